//! The greatest optical depth that a shader can find on one segment of a ray.

use tetrascope_core::OpticalModel;

use crate::KnotPair;

/// How much longer than the longest edge a segment may be, by its length.
///
/// `face.wgsl` takes lengths up to 1.001 edges for a rounded one. Beyond that, eight products
/// and sums lead from a length and two extinctions to an optical depth: under 2⁻²⁰ in all, for
/// which the bound is rounded up as well.
const LONGER: f64 = 1.001 * (1.0 + 1.0 / (1 << 20) as f64);

/// And by the error of its ends, normalized.
///
/// Each end is a mean of a face's corners along the axis, off by 2⁻¹⁹ (`BLUR` in `tiles.rs`).
/// A ray up to 60° beside the axis is twice as long as along it. So 2 · 2 · 2⁻¹⁹.
///
/// Beyond 60°, and where a face is seen so nearly from its edge that its corners' weights are
/// rounding alone, a segment may be longer still. That is harmless while few are: programs ask
/// for bounds up to 1, and the polynomial that they then take is off by 2.6e-7 at a depth of 1.1.
const ENDS: f64 = 1.0 / (1 << 17) as f64;

/// The scalars of programs that continue a cell's gradient beyond its corners.
pub const ANY_SCALAR: (f32, f32) = (f32::NEG_INFINITY, f32::INFINITY);

/// A bound of the optical depth of any segment with mapped scalars from `low` to `high` that is
/// no longer than `longest`, normalized, but for rounding; at most 1e30.
///
/// The greatest extinction there times the greatest length. A table of integrals, or a slab,
/// has a longest segment just as a mesh has a longest edge.
pub fn deepest(knots: &[KnotPair], (low, high): (f32, f32), longest: f32) -> f32 {
    // A scalar between two others is off by a few roundings of the greater.
    let blur = low.abs().max(high.abs()) * (1.0 / (1 << 20) as f32);
    let met = |pair: &&KnotPair| pair.low <= high + blur && low - blur <= pair.high;
    let extinctions = knots.iter().filter(met);
    let extinctions = extinctions.flat_map(|pair| [pair.at_low[3], pair.at_high[3]]);
    let greatest = f64::from(extinctions.fold(0.0, f32::max));
    let length = f64::from(longest) * LONGER + ENDS;
    (greatest * length).min(1e30) as f32
}

/// Whether nothing shows of a volume whose [`deepest`] segment is known: where optical depth
/// decides, and there is none.
pub fn is_transparent(model: OpticalModel, deepest: f32) -> bool {
    let by_depth = !matches!(
        model,
        OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces
    );
    by_depth && deepest == 0.0
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Bounds, Knot, TransferFunction};

    use super::*;
    use crate::knots::knot_pairs;
    use crate::{Normalization, ScalarMap};

    #[test]
    fn only_scalars_that_occur_count() {
        let knot = |scalar, extinction| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        };
        let knots = vec![
            knot(0.0, 1.0),
            knot(1.0, 3.0),
            knot(1.0, 40.0),
            knot(2.0, 5.0),
        ];
        let tf = TransferFunction::new(knots).expect("sorted");
        let unit = Normalization::of(&Bounds::of([DVec3::NEG_ONE, DVec3::ONE]));
        let map = ScalarMap::of(&tf);
        let pairs = knot_pairs(&tf, &map, &unit);
        let over = |low, high| {
            let scalars = map.range(Some((low, high)));
            deepest(&pairs, scalars, 0.25)
        };
        let close = |bound: f32, truth: f32| bound >= truth && bound < truth * 1.002;
        assert!(close(over(-9.0, -1.0), 0.25));
        assert!(close(over(0.2, 0.9), 0.75));
        assert!(close(over(0.2, 1.0), 10.0), "up to the step");
        assert!(close(over(2.5, 9.0), 1.25));
        assert!(close(deepest(&pairs, ANY_SCALAR, 0.25), 10.0));
    }

    /// Segments of a tiny cell, whose ends round by more than a thousandth of its edge.
    #[test]
    fn ends_of_tiny_segments_are_rounded_too() {
        let pair = KnotPair {
            at_low: [1.0; 4],
            at_high: [1.0; 4],
            low: 0.0,
            high: 1.0,
            inverse_width: 1.0,
            padding: 0,
        };
        let (near, far) = (1.5_f32, 1.5_f32 + 1e-6);
        let longest = 1e-6;
        assert!(far.next_up() - near > 1.001 * longest, "one rounding more");
        assert!(deepest(&[pair], (0.0, 1.0), longest) > far.next_up() - near);
    }
}
