//! Isosurfaces, and where a ray meets them.
//!
//! In a mesh's cell the scalar is linear along a ray and [`nearest_crossing`] is all there
//! is to it; the normal is the cell's gradient, constant in it (flat shading).
//!
//! On a grid the scalar is the trilinear interpolant of a voxel cell's eight corners, which
//! along a ray is a cubic. Between its extremes it rises or falls, and a surface is met on
//! such a part where [`Isosurface::is_met`] says so of the part's ends. The normal is the
//! interpolant's gradient at the very point, in the cell in which the surface is met; from
//! cell to cell it jumps, as the interpolant is continuous and its gradient is not. A cell
//! with a corner that is NaN holds no surface.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Error;

/// An opaque surface on which the field has one value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Isosurface {
    /// In the field's own units.
    pub value: f64,
    /// Linear RGB before lighting, 0 or more.
    pub color: DVec3,
}

impl Isosurface {
    /// Refuses a value or a color that is none.
    pub fn validate(&self) -> Result<(), Error> {
        let color = self.color;
        if self.value.is_finite() && color.is_finite() && color.min_element() >= 0.0 {
            return Ok(());
        }
        Err(Error::Invalid {
            what: format!("an isosurface at {} of color {color}", self.value),
            help: Some("give a finite value and linear RGB, 0 or more".into()),
        })
    }

    /// Whether a ray meets the surface on a stretch on which the scalar rises or falls from
    /// `front` to `back`: one end is below the value and the other is not.
    ///
    /// So a chain of stretches that share their ends misses no surface and doubles none,
    /// wherever it is divided, and a stretch of constant scalar meets none.
    pub fn is_met(&self, front: f64, back: f64) -> bool {
        (front < self.value) != (back < self.value)
    }
}

/// The first of `surfaces` that a ray meets on a stretch where the scalar goes linearly
/// from `front` to `back`: its index, and where, as a share of the stretch in [0, 1].
///
/// A surface is met where [`Isosurface::is_met`]. Of surfaces met at one place, the one
/// with the lowest index counts. NaN meets none.
pub fn nearest_crossing(surfaces: &[Isosurface], front: f64, back: f64) -> Option<(usize, f64)> {
    if front.is_nan() || back.is_nan() {
        return None;
    }
    let mut nearest: Option<(usize, f64)> = None;
    for (index, surface) in surfaces.iter().enumerate() {
        let value = surface.value;
        if !surface.is_met(front, back) {
            continue;
        }
        // Halves, as the difference of huge numbers may overflow.
        let share = (0.5 * value - 0.5 * front) / (0.5 * back - 0.5 * front);
        let share = share.clamp(0.0, 1.0);
        if nearest.is_none_or(|(_, s)| share < s) {
            nearest = Some((index, share));
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surfaces(values: &[f64]) -> Vec<Isosurface> {
        let surface = |&value: &f64| Isosurface {
            value,
            color: DVec3::ONE,
        };
        values.iter().map(surface).collect()
    }

    #[test]
    fn the_nearest_is_met_first_from_either_side() {
        let surfaces = surfaces(&[3.0, 1.0, 2.0]);
        assert_eq!(nearest_crossing(&surfaces, 0.0, 4.0), Some((1, 0.25)));
        assert_eq!(nearest_crossing(&surfaces, 4.0, 0.0), Some((0, 0.25)));
        assert_eq!(nearest_crossing(&surfaces, 3.5, 4.0), None);
        assert_eq!(nearest_crossing(&surfaces, f64::NAN, 4.0), None);
        // All at one place, as far as the share can tell.
        let wide = nearest_crossing(&surfaces, -f64::MAX, f64::MAX);
        assert_eq!(wide, Some((0, 0.5)));
    }

    // Whether or not a stretch ends on the value, a chain meets the surface once.
    #[test]
    fn a_chain_meets_each_surface_once() {
        let surfaces = surfaces(&[0.5]);
        for middle in [0.25, 0.5, 0.75] {
            for chain in [[0.0, middle, 1.0], [1.0, middle, 0.0]] {
                let met = chain
                    .windows(2)
                    .filter(|ends| nearest_crossing(&surfaces, ends[0], ends[1]).is_some());
                assert_eq!(met.count(), 1, "{chain:?}");
            }
        }
    }
}
