//! Directions of length 1.

use glam::{DVec3, Vec3};

/// A vector's direction. `clippy.toml` disallows glam's `normalize`, which makes NaN of vectors that are
/// zero, tiny or huge.
pub trait Unit {
    /// The vector of length 1 in this direction, whatever the length; zero for a vector that has none, being
    /// zero or not finite.
    #[must_use]
    fn unit(self) -> Self;
}

macro_rules! unit {
    ($vector:ty, $squares:expr) => {
        impl Unit for $vector {
            fn unit(self) -> $vector {
                let length = self.length();
                if $squares.contains(&length) {
                    return self * (1.0 / length);
                }
                // The squares of such components over- or underflow.
                let largest = self.abs().max_element();
                if !(largest > 0.0 && largest.is_finite()) {
                    return <$vector>::ZERO;
                }
                let scaled = self / largest;
                scaled * (1.0 / scaled.length())
            }
        }
    };
}

// Squares of these lengths, and of components of 1e-8 and 1e-3 of them, are normal numbers.
unit!(DVec3, 1e-140..1e140);
unit!(Vec3, 1e-15..1e15);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_length_has_a_direction() {
        let direction = DVec3::new(2.0, -3.0, 6.0);
        for length in [5e-324, 1e-300, 1e-150, 1.0, 1e150, 2.9e307] {
            let unit = (direction * length).unit();
            let coarse = if length < 1e-310 { 0.2 } else { 1e-15 };
            assert!(
                (unit * 7.0 - direction).length() < 7.0 * coarse,
                "{length}: {unit}"
            );
            assert!((unit.length() - 1.0).abs() < 1e-15, "{length}: {unit}");
        }
        for length in [1e-44, 1e-20, 1.0, 1e37] {
            let unit = (direction.as_vec3() * length).unit();
            assert!((unit.length() - 1.0).abs() < 1e-6, "{length}: {unit}");
        }
    }

    #[test]
    fn without_a_direction_it_is_zero() {
        for vector in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert_eq!(vector.unit(), DVec3::ZERO);
        }
    }
}
