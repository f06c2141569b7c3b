//! Coverage: how much of a grid's samples is there.
//!
//! A volume that does not fill its grid, such as a mesh that was resampled, has samples beside
//! those of its own. Each sample then has a coverage c in [0, 1]: 0 is outside, which is
//! transparent and has no scalar; 1 is inside; what is between lies on the border. This is the
//! one definition of what that means; `shaders/wgsl/slicing/covered.wgsl` says the same.
//!
//! With the trilinear weights w of a cell's corners and their scalars s, a point has
//!
//! ```text
//! coverage  C = Σ w c
//! scalar    s = Σ w c s / Σ w c,  of the samples that are covered alone; none where C = 0
//! extinction    C σ(s)
//! ```
//!
//! So the scalar does not mix with what is outside, and the volume fades where it ends instead
//! of stopping on a staircase. Where all corners are covered whole, it is the trilinear
//! interpolant. Where samples fill cells of their own, the one sample is all corners.
//!
//! A sample without a value ([`is_value`](crate::is_value)) is not covered, whatever its
//! coverage says, so in a grid with coverage no cell is a gap for one such corner.
//!
//! Coverage scales extinction. Models without one ([`fades`]) know only samples that are there
//! and others: a sample covered by less than [`THERE`] has no value for them, and the cells around
//! it are transparent, as those of a sample that is not finite.

use glam::DVec3;

use crate::OpticalModel;

/// The least coverage with which a sample is there, where a model knows no more.
pub const THERE: f32 = 0.5;

/// Whether coverage scales what `model` draws.
pub fn fades(model: OpticalModel) -> bool {
    match model {
        OpticalModel::EmissionAbsorption | OpticalModel::Emission | OpticalModel::Absorption => {
            true
        }
        OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => false,
    }
}

/// A point of a grid with coverage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered {
    /// Σ w c s / Σ w c, between the least and the greatest covered corner.
    pub scalar: f64,
    /// Σ w c, in [0, 1] and not 0.
    pub coverage: f64,
}

/// The point at `place`, in [0, 1]³, of a cell with these corners, x fastest; `None` where
/// nothing is covered.
///
/// Scalars of corners that are not covered do not matter, NaN neither.
pub fn covered(scalars: &[f64; 8], coverage: &[f64; 8], place: DVec3) -> Option<Covered> {
    let (mut sum, mut weighted) = (0.0, 0.0);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in 0..8 {
        if coverage[corner] <= 0.0 {
            continue;
        }
        let weight = (0..3).fold(coverage[corner], |weight, axis| {
            let share = place[axis];
            weight
                * if corner >> axis & 1 == 1 {
                    share
                } else {
                    1.0 - share
                }
        });
        sum += weight;
        weighted += weight * scalars[corner];
        (low, high) = (low.min(scalars[corner]), high.max(scalars[corner]));
    }
    (sum > 0.0).then(|| Covered {
        scalar: (weighted / sum).clamp(low, high),
        coverage: sum.min(1.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [DVec3; 4] = [
        DVec3::ZERO,
        DVec3::new(0.25, 0.5, 0.125),
        DVec3::new(0.9, 0.3, 0.6),
        DVec3::ONE,
    ];

    /// 1 + 2 x + 4 y + 8 z.
    fn linear() -> [f64; 8] {
        std::array::from_fn(|i| {
            let [x, y, z] = [0, 1, 2].map(|axis| f64::from(i as u32 >> axis & 1));
            1.0 + 2.0 * x + 4.0 * y + 8.0 * z
        })
    }

    #[test]
    fn cells_that_are_covered_whole_are_trilinear() {
        for place in PLACES {
            let found = covered(&linear(), &[1.0; 8], place).expect("covered");
            let truth = 1.0 + place.dot(DVec3::new(2.0, 4.0, 8.0));
            // Eight products of four factors and their sum: at most 16 roundings of 15.
            assert!(
                (found.scalar - truth).abs() < 16.0 * 15.0 * f64::EPSILON,
                "{place}"
            );
            assert!((found.coverage - 1.0).abs() < 16.0 * f64::EPSILON);
            // Half of everything has the same scalars.
            let half = covered(&linear(), &[0.5; 8], place).expect("covered");
            assert_eq!(half.scalar, found.scalar);
            assert!((half.coverage - 0.5).abs() < 16.0 * f64::EPSILON);
        }
    }

    // The plane x = 0 is covered, x = 1 is not: the scalar is that of the plane, all the way.
    #[test]
    fn scalars_do_not_mix_with_what_is_outside() {
        let mut scalars = linear();
        let mut coverage = [1.0; 8];
        for corner in [1, 3, 5, 7] {
            (scalars[corner], coverage[corner]) = (f64::NAN, 0.0);
        }
        for place in PLACES {
            let found = covered(&scalars, &coverage, place);
            if place.x == 1.0 {
                assert_eq!(found, None);
                continue;
            }
            let found = found.expect("covered");
            let truth = 1.0 + 4.0 * place.y + 8.0 * place.z;
            assert!(
                (found.scalar - truth).abs() < 16.0 * 15.0 * f64::EPSILON,
                "{place}"
            );
            assert!((found.coverage - (1.0 - place.x)).abs() < 16.0 * f64::EPSILON);
        }
        assert_eq!(covered(&scalars, &[0.0; 8], DVec3::splat(0.5)), None);
    }

    // Weighted means round, and a constant would leave a step of the transfer function.
    #[test]
    fn constants_stay_what_they_are() {
        let coverage = [0.1, 0.7, 0.0, 0.3, 1.0, 0.9, 0.2, 0.6];
        for place in PLACES {
            let found = covered(&[0.1; 8], &coverage, place).expect("covered");
            assert_eq!(found.scalar, 0.1, "{place}");
        }
    }
}
