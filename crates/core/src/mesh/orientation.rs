//! On which side of a plane a point lies, decided without rounding errors.

use glam::DVec3;
use robust::Coord3D;

/// Coordinates up to this magnitude are accepted: a product of three differences
/// of such numbers, 8e300, stays below the largest f64, 1.8e308.
pub(super) const LARGEST_COORDINATE: f64 = 1e100;

/// Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
/// Geometric Predicates", bound A of ORIENT3D: the determinant's error is at most
/// (7 + 56ε)ε times its permanent, with ε = 2⁻⁵³.
const ERROR_BOUND: f64 = {
    let epsilon = f64::EPSILON / 2.0;
    (7.0 + 56.0 * epsilon) * epsilon
};

/// Six times the signed volume of a tetrahedron, and how far to trust it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Orientation {
    /// (p₁ − p₀) · ((p₂ − p₀) × (p₃ − p₀)) as f64 computes it.
    pub(super) determinant: f64,
    /// Whether `determinant` differs from 0 by less than its rounding error.
    pub(super) degenerate: bool,
    /// The exact sign: −1, 0 or 1.
    pub(super) sign: i8,
}

/// Six times the signed volume of a tetrahedron, as f64 computes it.
#[inline]
pub(super) fn determinant([p0, p1, p2, p3]: [DVec3; 4]) -> f64 {
    (p1 - p0).dot((p2 - p0).cross(p3 - p0))
}

/// Evaluates the determinant; falls back to exact arithmetic where its sign is in doubt.
///
/// Cells so small that products of three edge lengths underflow (below about 1e-100)
/// count as degenerate.
#[inline]
pub(super) fn orientation([p0, p1, p2, p3]: [DVec3; 4]) -> Orientation {
    let (a, b, c) = (p1 - p0, p2 - p0, p3 - p0);
    let determinant = determinant([p0, p1, p2, p3]);
    let permanent = a.x.abs() * ((b.y * c.z).abs() + (b.z * c.y).abs())
        + a.y.abs() * ((b.z * c.x).abs() + (b.x * c.z).abs())
        + a.z.abs() * ((b.x * c.y).abs() + (b.y * c.x).abs());
    let degenerate = determinant.abs() <= ERROR_BOUND * permanent;
    let decisive = if degenerate {
        let coord = |p: DVec3| Coord3D {
            x: p.x,
            y: p.y,
            z: p.z,
        };
        robust::orient3d(coord(p1), coord(p2), coord(p3), coord(p0))
    } else {
        determinant
    };
    Orientation {
        determinant,
        degenerate,
        sign: i8::from(decisive > 0.0) - i8::from(decisive < 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Findings about a cell need not be made again once it is turned.
    #[test]
    fn two_corners_in_turn_change_signs_alone() {
        let mut state = 1_u64;
        let mut number = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 * 2_f64.powi((state >> 32 & 31) as i32 - 16) - 1e3
        };
        let mut signs = [0; 3];
        for i in 0..20_000 {
            let mut corners = [0; 4].map(|_| DVec3::new(number(), number(), number()));
            if i % 3 == 0 {
                // Flat but for rounding.
                corners[3] = corners[0] * 0.3 + corners[1] * 0.3 + corners[2] * 0.4;
            }
            let [a, b, c, d] = corners;
            let (found, turned) = (orientation([a, b, c, d]), orientation([a, b, d, c]));
            assert_eq!(turned.determinant, -found.determinant);
            assert_eq!(turned.degenerate, found.degenerate);
            assert_eq!(turned.sign, -found.sign);
            signs[(found.sign + 1) as usize] += 1;
        }
        assert!(signs[0] > 1000 && signs[2] > 1000, "{signs:?}");
    }
}
