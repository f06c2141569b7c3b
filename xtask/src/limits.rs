//! From what an algorithm promises to what is demanded of its pictures.

use tetrascope::Promise;
use tetrascope::core::OpticalModel;

/// The RMSE and the greatest difference that are allowed over all channels.
pub type Limit = (f64, f64);

/// The error that arithmetic in f32 explains.
///
/// A ray's light is a sum over some 100 cells, of values up to 4 (to which extinction is
/// scaled in `Emission`), with a rounding of 2⁻²⁴ each: 2.4e-5 if all err the same way, a
/// tenth of that, √100, as they do not. Ends of segments are f32 of a box of side 2, which is
/// as much again of a whole ray's optical depth. A hundred times that is left for the
/// few rays along edges of slivers. The most that was measured is 1.0e-6 and
/// 1.1e-4, in `Emission` on a mesh of slivers.
pub const ROUNDING: Limit = (3e-6, 3e-4);

/// The error that is allowed where cells are sorted by a point of theirs, on convex meshes of cells
/// of like size: two neighbors that swap move light by the product of their opacities.
pub const ROUGH_ORDER: f64 = 2e-3;

/// The demand on a frame; `None` where there is none.
///
/// `order_proven` is what the frame says of its order of cells; `rough` is the RMSE allowed where
/// some cells may be in the wrong order.
pub fn limit(
    promise: Promise,
    model: OpticalModel,
    order_proven: Option<bool>,
    rough: Option<f64>,
) -> Option<Limit> {
    let (rmse, max) = ROUNDING;
    match promise {
        Promise::Truth | Promise::Exact => Some(ROUNDING),
        Promise::ExactIfProven | Promise::RoughOrder if model.commutes() => Some(ROUNDING),
        Promise::ExactIfProven if order_proven == Some(true) => Some(ROUNDING),
        Promise::ExactIfProven | Promise::RoughOrder => Some((rough?, 1.0)),
        Promise::Within(change) => Some((rmse + change, max + change)),
        Promise::Open => None,
    }
}

/// Pixels that may differ by anything where what is seen jumps: at the outline of a
/// surface, and in `MaximumIntensity` at that of the mesh or, where each has a scalar of its
/// own, of a cell.
///
/// f32 moves a ray by up to 1e-4 pixels (2⁻²³ of the box, 256 pixels wide: 3e-5, thrice),
/// so that it decides otherwise for that share of the pixels on outlines. Of n² pixels
/// some 10 n are on outlines: for n up to 1000 that is one pixel.
pub fn outliers(model: OpticalModel) -> usize {
    match model {
        OpticalModel::Isosurfaces | OpticalModel::MaximumIntensity => 1,
        _ => 0,
    }
}

/// The RMSE that `limit` allows with its [`outliers`] in an image of so many pixels.
pub fn rmse_with_outliers((rmse, _): Limit, model: OpticalModel, [width, height]: [u32; 2]) -> f64 {
    let pixels = f64::from(width) * f64::from(height);
    (rmse * rmse + outliers(model) as f64 / pixels).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SORTED: OpticalModel = OpticalModel::EmissionAbsorption;

    #[test]
    fn an_order_is_exact_where_it_is_proven_alone() {
        let of = |proven| limit(Promise::ExactIfProven, SORTED, proven, Some(0.5));
        assert_eq!(of(Some(true)), Some(ROUNDING));
        for proven in [Some(false), None] {
            assert_eq!(of(proven), Some((0.5, 1.0)), "{proven:?}");
        }
    }

    #[test]
    fn order_plays_no_part_where_the_model_commutes() {
        for promise in [Promise::ExactIfProven, Promise::RoughOrder] {
            let emission = limit(promise, OpticalModel::Emission, None, None);
            assert_eq!(emission, Some(ROUNDING));
            assert_eq!(limit(promise, SORTED, None, None), None);
        }
    }

    #[test]
    fn one_wrong_pixel_of_an_outline_passes_and_two_do_not() {
        // Each of four channels of one pixel wholly wrong: RMSE √(4 / (4 · 10⁴)) = 1e-2.
        let rmse = rmse_with_outliers((0.0, 1.0), OpticalModel::Isosurfaces, [100, 100]);
        assert!((rmse - 1e-2).abs() < 1e-15);
        assert_eq!(rmse_with_outliers(ROUNDING, SORTED, [100, 100]), ROUNDING.0);
    }
}
