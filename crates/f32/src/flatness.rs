//! Volumes so flat that 32-bit floats hold lengths across them badly.

use tetrascope_core::{Bounds, FrameStats, OpticalModel};

use crate::Normalization;

/// By how much of the volume's size both ends of a length across it may be off together: sums of three
/// products of numbers up to 1, each rounded to 2⁻²⁵, with what the sums round.
const ROUNDED: f64 = 1.0 / (1 << 22) as f64;

/// A change of less is within what is promised of any volume.
const WORTH_SAYING: f64 = 1e-4;

/// How much of itself a length across a volume may be off where depths are rounded along the view, and not
/// along an axis: 2⁻²² of the volume's size, in parts of its least extent. At most 1; 0 for
/// a volume without any.
pub fn rounding_across(bounds: &Bounds, normalization: &Normalization) -> f64 {
    let least = bounds.size().min_element() / normalization.scale;
    match least > 0.0 {
        true => (ROUNDED / least).min(1.0),
        false => 0.0,
    }
}

/// Says in a frame's statistics how wrong it may be for [`rounding_across`], if that is worth saying.
///
/// An optical depth of τ that is off by a share r of itself changes opacity by r τ e^(−τ) < r, and light of colors
/// up to 1 by no more. A surface's normal is the direction of a sum of products of two edges, each off by r: its
/// terms by 2 r, and a unit vector by twice that.
pub fn say_if_flat(
    stats: &mut FrameStats,
    bounds: &Bounds,
    normalization: &Normalization,
    model: OpticalModel,
) {
    let off = rounding_across(bounds, normalization);
    let shows = match model {
        OpticalModel::Isosurfaces => (4.0 * off).min(1.0),
        _ => off,
    };
    if shows < WORTH_SAYING {
        return;
    }
    let size = bounds.size();
    stats.notes.push(format!(
        "the volume is {:.0e} times as thick as long: lengths across it are known to {:.0e} of themselves",
        size.min_element() / size.max_element(),
        off
    ));
    stats.error_bound = Some(stats.error_bound.unwrap_or(0.0).max(shows));
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;

    use super::*;

    fn stats(thickness: f64, model: OpticalModel) -> FrameStats {
        let bounds = Bounds::of([DVec3::ZERO, DVec3::new(1.0, 1.0, thickness)]);
        let mut stats = FrameStats::default();
        say_if_flat(&mut stats, &bounds, &Normalization::of(&bounds), model);
        stats
    }

    #[test]
    fn flat_volumes_say_so_and_others_do_not() {
        let model = OpticalModel::EmissionAbsorption;
        for thickness in [1.0, 1e-2, 0.0] {
            assert_eq!(
                stats(thickness, model),
                FrameStats::default(),
                "{thickness}"
            );
        }
        let thin = stats(1e-6, model);
        // 2⁻²² of a scale of ½ in 1e-6.
        let known = 0.5 / (1 << 22) as f64 / 1e-6;
        assert!((thin.error_bound.expect("said") - known).abs() < 1e-12);
        assert!(
            thin.notes[0].contains("1e-6 times as thick"),
            "{:?}",
            thin.notes
        );
        assert_eq!(stats(1e-12, model).error_bound, Some(1.0));
        let surfaces = stats(1e-6, OpticalModel::Isosurfaces).error_bound;
        assert!((surfaces.expect("said") - 4.0 * known).abs() < 1e-12);
    }
}
