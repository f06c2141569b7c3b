//! Numbers that leave f64: the one place where they do.
//!
//! Positions are moved to the mesh's center and scaled to its size, extinctions
//! by the same length, scalars mapped to the transfer function's range, and only
//! then rounded to f32. So a mesh a micrometer wide and one a light year wide, at
//! the origin or a million miles from it, give the same picture.

use tetrascope_core::glam::{DVec3, Vec3};
use tetrascope_core::{Appearance, Bounds, OpticalModel, TransferFunction};

/// Beyond this, extinctions and colors are as good as infinite; sums and products
/// of a few of them still fit f32.
pub(crate) const HUGE: f64 = 1e30;

/// From world space to normalized space: x ↦ (x − center) / scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normalization {
    /// World space.
    pub center: DVec3,
    /// World units in one normalized unit, a power of two, so that scaling rounds nothing.
    pub scale: f64,
}

impl Normalization {
    /// Takes `bounds` into the cube [−1, 1]³.
    pub fn of(bounds: &Bounds) -> Normalization {
        let half = bounds.size().max_element() / 2.0;
        let scale = if half > 0.0 && half.is_finite() {
            // Clamped where the power, or one over it, leaves the normal numbers.
            half.log2().ceil().clamp(-1000.0, 1000.0).exp2()
        } else {
            1.0
        };
        Normalization {
            center: bounds.center(),
            scale,
        }
    }

    /// A point of world space in normalized space, in f64.
    pub fn point(&self, world: DVec3) -> DVec3 {
        (world - self.center) / self.scale
    }

    /// A point of world space in normalized space.
    pub fn position(&self, world: DVec3) -> Vec3 {
        self.point(world).as_vec3()
    }

    /// An extinction per world unit as one per normalized unit.
    pub fn extinction(&self, per_world_unit: f64) -> f32 {
        (per_world_unit * self.scale).min(HUGE) as f32
    }
}

/// From the field's unit to one in which the transfer function's range is [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarMap {
    low: f64,
    width: f64,
}

impl ScalarMap {
    /// Takes the range of `transfer_function` to [0, 1].
    ///
    /// A single knot is constant everywhere, so any width will do.
    pub fn of(transfer_function: &TransferFunction) -> ScalarMap {
        ScalarMap::of_range(transfer_function.range())
    }

    /// Takes `low` to 0 and keeps the unit: whole numbers stay whole.
    pub fn from_low(low: f64) -> ScalarMap {
        ScalarMap { low, width: 1.0 }
    }

    /// As [`ScalarMap::of`]; but where isosurfaces are drawn, it takes the volume's own
    /// range to [0, 1], as there may be a value anywhere in it.
    pub fn of_appearance(appearance: &Appearance, volume: Option<(f64, f64)>) -> ScalarMap {
        ScalarMap::of_range(needed_range(appearance, volume))
    }

    fn of_range((low, high): (f64, f64)) -> ScalarMap {
        let width = high - low;
        ScalarMap {
            low,
            width: if width > 0.0 && width.is_finite() {
                width
            } else {
                1.0
            },
        }
    }

    /// The nearest map that f32 does as (x − low) · unit: both numbers are floats, so that what
    /// knots are relative to is what samples are relative to, and differences of near scalars are
    /// exact. The unit is at most 1e30, for the product to be finite.
    pub fn in_f32(self) -> ScalarMap {
        let low = self.low.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32;
        let unit = self.width.recip().clamp(1.0 / HUGE, HUGE) as f32;
        ScalarMap {
            low: low.into(),
            width: f64::from(unit).recip(),
        }
    }

    /// Whether scalars that were mapped for another transfer function still have
    /// the digits that this one needs, so that they need no new upload.
    ///
    /// They do while the new range is inside a few widths of the old one and not
    /// much narrower: below that, f32 would resolve less than 2⁻¹⁹ of it.
    pub fn suits(&self, transfer_function: &TransferFunction) -> bool {
        self.suits_range(transfer_function.range())
    }

    /// As [`ScalarMap::suits`], for [`ScalarMap::of_appearance`].
    pub fn suits_appearance(&self, appearance: &Appearance, volume: Option<(f64, f64)>) -> bool {
        self.suits_range(needed_range(appearance, volume))
    }

    fn suits_range(&self, (low, high): (f64, f64)) -> bool {
        let inside =
            (-1.0..=2.0).contains(&self.exact(low)) && (-1.0..=2.0).contains(&self.exact(high));
        let wide = high - low >= self.width / 8.0;
        inside && (wide || high == low)
    }

    /// The scalar that it takes to 0.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// New units in one of the field's.
    pub fn unit(&self) -> f64 {
        self.width.recip()
    }

    /// A scalar in the new unit, in f64.
    pub fn exact(&self, scalar: f64) -> f64 {
        (scalar - self.low) / self.width
    }

    /// A scalar in the new unit. What lies far outside the transfer function's
    /// range is clamped, where the function is constant; NaN stays NaN.
    pub fn scalar(&self, scalar: f64) -> f32 {
        self.exact(scalar).clamp(-HUGE, HUGE) as f32
    }

    /// A field's least and greatest scalar in the new unit; of a field without values, 0.
    pub fn range(&self, scalars: Option<(f64, f64)>) -> (f32, f32) {
        let (low, high) = scalars.unwrap_or((0.0, 0.0));
        (self.scalar(low), self.scalar(high))
    }
}

/// The scalars that `appearance` tells apart.
fn needed_range(appearance: &Appearance, volume: Option<(f64, f64)>) -> (f64, f64) {
    match (appearance.optical_model, volume) {
        (OpticalModel::Isosurfaces, Some(range)) => range,
        _ => appearance.transfer_function.range(),
    }
}

/// A color component as f32.
pub fn color(color: DVec3) -> Vec3 {
    color.min(DVec3::splat(HUGE)).as_vec3()
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Knot;

    use super::*;

    fn ramp(low: f64, high: f64) -> TransferFunction {
        let knot = |scalar| Knot {
            scalar,
            color: DVec3::ONE,
            extinction: 1.0,
        };
        TransferFunction::new(vec![knot(low), knot(high)]).expect("valid knots")
    }

    #[test]
    fn meshes_of_any_size_and_place_look_the_same() {
        let place = DVec3::new(3.0, -1.0, 2.0);
        let unit = Bounds::of([DVec3::ZERO, DVec3::new(1.0, 0.5, 0.25)]);
        let corner = Normalization::of(&unit).position(unit.max);
        for power in [-900, -40, 0, 40, 900] {
            let size = f64::from(power).exp2();
            let moved = Bounds::of([unit.min, unit.max].map(|p| (p + place) * size));
            let n = Normalization::of(&moved);
            assert_eq!(n.position(moved.max), corner, "size 2^{power}");
            assert!(
                (n.extinction(1.0 / size) - 0.5).abs() < 1e-7,
                "size 2^{power}"
            );
        }
        assert_eq!(Normalization::of(&Bounds::EMPTY).scale, 1.0);
    }

    #[test]
    fn outliers_and_nan_keep_their_meaning() {
        let map = ScalarMap::of(&ramp(1.0, 3.0));
        assert_eq!(
            (map.scalar(1.0), map.scalar(2.0), map.scalar(3.0)),
            (0.0, 0.5, 1.0)
        );
        assert!(map.scalar(f64::MAX).is_finite() && map.scalar(f64::MIN).is_finite());
        assert!(map.scalar(f64::NAN).is_nan());
    }

    #[test]
    fn a_map_in_f32_is_one_that_f32_can_do() {
        for (low, high) in [(0.1, 0.3), (1e6, 1e6 + 0.7), (-7.0, 1e-3), (0.0, 1e-35)] {
            let map = ScalarMap::of(&ramp(low, high)).in_f32();
            let (base, unit) = (map.low() as f32, map.unit() as f32);
            assert_eq!((f64::from(base), f64::from(unit)), (map.low(), map.unit()));
            for sample in [low, high, 0.5 * (low + high)].map(|s| s as f32) {
                // The difference rounds once and the product once.
                let (found, exact) = ((sample - base) * unit, map.exact(sample.into()));
                let bound = 2.0 * exact.abs() * f64::from(f32::EPSILON) / 2.0;
                assert!(
                    (f64::from(found) - exact).abs() <= 1.01 * bound,
                    "{low} {high}"
                );
            }
        }
        let huge = ScalarMap::of(&ramp(-1e300, 1e300)).in_f32();
        assert!((huge.low() as f32).is_finite() && huge.unit() as f32 > 0.0);
    }

    #[test]
    fn a_map_is_kept_until_digits_run_out() {
        let map = ScalarMap::of(&ramp(0.0, 1.0));
        assert!(map.suits(&ramp(0.25, 0.75)));
        assert!(map.suits(&ramp(-0.5, 1.5)));
        assert!(!map.suits(&ramp(0.5, 0.501)));
        assert!(!map.suits(&ramp(100.0, 200.0)));
    }
}
