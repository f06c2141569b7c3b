//! Sample points within a voxel (section 3.1).

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;

/// The most samples along an axis; the paper uses 1 to 5.
pub const MOST_REGULAR: u32 = 8;

/// The most random samples.
pub const MOST_RANDOM: u32 = 512;

/// Where samples are taken within a voxel, from its center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Offsets {
    /// The centers of n × n × n parts of the voxel; 1 is its center alone.
    Regular(u32),
    /// This many random points, uniform in the voxel.
    Uniform {
        /// How many.
        count: u32,
        /// The same seed gives the same points.
        seed: u64,
    },
    /// This many random points, normally distributed around the center; those outside of the voxel
    /// are drawn again.
    Gaussian {
        /// How many.
        count: u32,
        /// The standard deviation along each axis, in voxels.
        deviation: f64,
        /// The same seed gives the same points.
        seed: u64,
    },
}

impl Default for Offsets {
    fn default() -> Self {
        Offsets::Regular(1)
    }
}

impl Offsets {
    /// The offsets, in voxels, each component in [−1/2, 1/2].
    ///
    /// Their sum is exactly 0, so that the mean of a linear field is its value at the center:
    /// random points come in pairs of opposites, and an odd one is the center.
    ///
    /// # Errors
    /// No samples, more than [`MOST_REGULAR`] along an axis or [`MOST_RANDOM`] random ones, and a
    /// deviation that is not positive and finite.
    pub fn points(&self) -> Result<Vec<DVec3>, Error> {
        match *self {
            Offsets::Regular(n) if (1..=MOST_REGULAR).contains(&n) => {
                // 2i + 1 − n is odd or even as n is, and opposite for i and n − 1 − i.
                let at = |i: u32| (f64::from(2 * i + 1) - f64::from(n)) / f64::from(2 * n);
                let points = (0..n * n * n).map(|i| [i % n, i / n % n, i / (n * n)]);
                Ok(points.map(|i| DVec3::from(i.map(at))).collect())
            }
            Offsets::Regular(n) => Err(Error::Invalid {
                what: format!("{n} × {n} × {n} samples per voxel"),
                help: Some(format!("give 1 to {MOST_REGULAR} along an axis")),
            }),
            Offsets::Uniform { count, .. } | Offsets::Gaussian { count, .. }
                if !(1..=MOST_RANDOM).contains(&count) =>
            {
                Err(Error::Invalid {
                    what: format!("{count} random samples per voxel"),
                    help: Some(format!("give 1 to {MOST_RANDOM}")),
                })
            }
            Offsets::Uniform { count, seed } => {
                let mut random = Random(seed);
                Ok(pairs(count, || {
                    DVec3::from([(); 3].map(|()| random.unit() - 0.5))
                }))
            }
            Offsets::Gaussian {
                count,
                deviation,
                seed,
            } => {
                if !(deviation > 0.0 && deviation.is_finite()) {
                    return Err(Error::Invalid {
                        what: format!("a Gaussian of deviation {deviation}"),
                        help: Some("give voxels, more than 0; 0.25 is usual".into()),
                    });
                }
                let mut random = Random(seed);
                Ok(pairs(count, || {
                    DVec3::from([(); 3].map(|()| random.normal_within(deviation)))
                }))
            }
        }
    }
}

fn pairs(count: u32, mut draw: impl FnMut() -> DVec3) -> Vec<DVec3> {
    let mut points = Vec::new();
    for _ in 0..count / 2 {
        let point = draw();
        points.extend([point, -point]);
    }
    if count % 2 == 1 {
        points.push(DVec3::ZERO);
    }
    points
}

/// SplitMix64 (G. Steele, D. Lea, C. Flood, 2014).
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Normally distributed, within half a voxel of 0.
    ///
    /// A uniform point under the density's peak is accepted if it is under the density, so that
    /// no deviation needs many draws: beyond 1/2 the density is nearly flat, and a narrow one is
    /// drawn within eight deviations alone, which leaves out 10⁻¹⁵ of it.
    fn normal_within(&mut self, deviation: f64) -> f64 {
        let half = (8.0 * deviation).min(0.5);
        // The acceptance is at least 1/7: √(2π)/16.
        loop {
            let at = (2.0 * self.unit() - 1.0) * half;
            let share = at / deviation;
            if self.unit() < (-0.5 * share * share).exp() {
                return at;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_lie_in_the_voxel_and_their_sum_is_zero() {
        let regular = (1..=MOST_REGULAR).map(Offsets::Regular);
        let random = [1, 2, 7, 64].into_iter().flat_map(|count| {
            [
                Offsets::Uniform { count, seed: 3 },
                Offsets::Gaussian {
                    count,
                    deviation: 0.25,
                    seed: 3,
                },
                Offsets::Gaussian {
                    count,
                    deviation: 1e-3,
                    seed: 3,
                },
                Offsets::Gaussian {
                    count,
                    deviation: 1e9,
                    seed: 3,
                },
            ]
        });
        for offsets in regular.chain(random) {
            let points = offsets.points().expect("valid");
            assert!(points.iter().all(|p| p.abs().max_element() <= 0.5));
            // Each has its opposite.
            for point in &points {
                assert!(points.contains(&-*point), "{offsets:?}");
            }
            assert_eq!(points, offsets.points().expect("valid"));
        }
    }

    #[test]
    fn two_are_the_centers_of_octants() {
        let points = Offsets::Regular(2).points().expect("valid");
        assert_eq!(points.len(), 8);
        assert!(points.iter().all(|p| p.abs() == DVec3::splat(0.25)));
        assert_eq!(
            Offsets::default().points().expect("valid"),
            vec![DVec3::ZERO]
        );
    }

    // A normal distribution of 1/8, cut at 4 deviations, has variance 1/64 but for 10⁻³; that of
    // 256 independent squares is 2/256 of its square, so 5 deviations are 0.44 of it.
    #[test]
    fn a_gaussian_has_its_deviation() {
        let gaussian = Offsets::Gaussian {
            count: 512,
            deviation: 0.125,
            seed: 1,
        };
        let points = gaussian.points().expect("valid");
        let variance = points.iter().map(|p| p.x * p.x).sum::<f64>() / 512.0;
        assert!((variance * 64.0 - 1.0).abs() < 0.45, "{variance}");
    }

    #[test]
    fn no_samples_and_too_many_are_refused() {
        let gaussian = |deviation| Offsets::Gaussian {
            count: 2,
            deviation,
            seed: 0,
        };
        for wrong in [
            Offsets::Regular(0),
            Offsets::Regular(9),
            Offsets::Regular(u32::MAX),
            Offsets::Uniform { count: 0, seed: 0 },
            Offsets::Uniform {
                count: u32::MAX,
                seed: 0,
            },
            gaussian(0.0),
            gaussian(f64::NAN),
            gaussian(f64::INFINITY),
        ] {
            let error = wrong.points().expect_err("refused");
            assert!(error.help().is_some(), "{error}");
        }
    }
}
