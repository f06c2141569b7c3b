//! Whether ranges of scalars that only the device knows can show.

use tetrascope_core::{Appearance, OpticalModel};

use crate::maxima::Maxima;

/// Bins of scalars; `cull.wgsl` finds their numbers in f32.
const BINS: u32 = 1 << 16;

/// By how much of a bin one reaches beyond its ends: numbers in f32 are a little off.
const SLACK: f64 = 1.0 / 64.0;

/// A summed table over a transfer function, or over isosurfaces: how many of its first n entries
/// show.
///
/// Entries are bins of scalars: one below all knots, those between, and one above; then the
/// scalar of the first knot by itself, which is that of much empty space. As in
/// [`SkipTable`](crate::skip::SkipTable), but in numbers of f32. A box may be drawn that has
/// nothing to show, but none is left out that has.
#[derive(Clone, Debug)]
pub(crate) struct FloatTable {
    /// As in `Cull` of `cull.wgsl`.
    pub(crate) base: f32,
    pub(crate) most: f32,
    pub(crate) bins_per_scalar: f32,
    pub(crate) offset: f32,
    pub(crate) bins: u32,
    /// `counts[n]` of the first n entries show.
    pub(crate) counts: Vec<u32>,
}

impl FloatTable {
    pub(crate) fn new(appearance: &Appearance) -> FloatTable {
        let maxima = Maxima::new(appearance);
        let values = || appearance.isosurfaces.iter().map(|surface| surface.value);
        let are_surfaces = appearance.optical_model == OpticalModel::Isosurfaces;
        let (first, last) = if are_surfaces {
            let least = values().fold(f64::INFINITY, f64::min);
            let greatest = values().fold(f64::NEG_INFINITY, f64::max);
            // Without any surface nothing shows, wherever the bins are.
            if least <= greatest {
                (least, greatest)
            } else {
                (0.0, 0.0)
            }
        } else {
            appearance.transfer_function.range()
        };
        let shows = |low: f64, high: f64| match are_surfaces {
            true => values().any(|value| low <= value && value <= high),
            false => maxima.over(low, high) > 0.0,
        };
        let width = last - first;
        let fine = f64::from(BINS) / width;
        let is_far = fine < 1e-30;
        let (bins, bins_per_scalar) = if (1e-30..=1e30).contains(&fine) {
            (BINS, fine as f32)
        } else if is_far {
            (1, 1.0)
        } else {
            // One bin around knots that f32 can hardly tell apart, or around a single one.
            let narrow = (f64::from(1 << 20) / first.abs()).min(1e30);
            (1, narrow.min(width.recip()).max(1e-30) as f32)
        };
        let limit = f64::from(f32::MAX);
        let base = first.clamp(-limit, limit) as f32;
        let per_scalar = f64::from(bins_per_scalar);
        // Where bin n of those between ends.
        let end = |n: f64| first + n / per_scalar;
        let bin_shows = |bin: u32| match bin {
            _ if is_far => shows(f64::NEG_INFINITY, f64::INFINITY),
            // Beyond the knots all is constant.
            0 => shows(f64::NEG_INFINITY, f64::NEG_INFINITY),
            n if n > bins => shows(f64::INFINITY, f64::INFINITY),
            n => shows(end(f64::from(n) - 1.0 - SLACK), end(f64::from(n) + SLACK)),
        };
        let mut counts = vec![0];
        let mut count = 0;
        for shows in (0..bins + 2).map(bin_shows).chain([shows(first, first)]) {
            count += u32::from(shows);
            counts.push(count);
        }
        FloatTable {
            base,
            most: (2.0 * f64::from(bins) / per_scalar).min(limit) as f32,
            bins_per_scalar,
            offset: ((f64::from(base) - first) * per_scalar) as f32,
            bins,
            counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Isosurface, Knot, TransferFunction};

    use super::*;

    impl FloatTable {
        /// The twin of `entries_of` in `cull.wgsl`.
        fn shows(&self, low: f32, high: f32) -> bool {
            if low > high {
                return false;
            }
            let place = |s: f32| {
                (s - self.base).clamp(-self.most, self.most) * self.bins_per_scalar + self.offset
            };
            let [from, to] = if low == high && place(low) == 0.0 {
                [self.bins + 2, self.bins + 3]
            } else {
                let last = (self.bins + 1) as f32;
                let from = ((place(low) - 0.03125).floor() + 1.0).clamp(0.0, last);
                let to = (place(high) + 0.03125).ceil().clamp(0.0, last);
                [from as u32, to as u32 + 1]
            };
            self.counts[to as usize] > self.counts[from as usize]
        }
    }

    fn appearance(knots: &[(f64, f64)]) -> Appearance {
        let knots = knots.iter().map(|&(scalar, extinction)| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        });
        let tf = TransferFunction::new(knots.collect()).expect("sorted");
        Appearance::new(tf, OpticalModel::EmissionAbsorption)
    }

    /// Clear, but for a tent, a box and what is above 9; `low` is where that begins.
    fn holes(low: f64, width: f64) -> Appearance {
        let knots = [
            (0.0, 0.0),
            (1.0, 1.0),
            (2.0, 0.0),
            (4.25, 0.0),
            (4.25, 2.0),
            (4.75, 2.0),
            (4.75, 0.0),
            (9.0, 0.0),
            (10.0, 3.0),
        ];
        appearance(&knots.map(|(s, extinction)| (low + 0.1 * s * width, extinction)))
    }

    // Nothing that shows is skipped, and what is farther than two bins from all that shows is.
    #[test]
    fn ranges_are_answered_safely() {
        for (low, width) in [
            (0.0, 1.0),
            (0.1, 0.3),
            (1e6, 100.0),
            (-3e-7, 1e-9),
            (5e20, 1e21),
        ] {
            let look = holes(low, width);
            let maxima = Maxima::new(&look);
            let table = FloatTable::new(&look);
            // What f32 cannot tell from each other counts as a bin, too.
            let bin = (width / f64::from(BINS)).max(low.abs() * f64::from(f32::EPSILON));
            let mut hidden = 0;
            for i in 0..2000 {
                for length in [0.0, 1e-4, 0.07, 0.5] {
                    let from = (low + (f64::from(i) * 8e-4 - 0.3) * width) as f32;
                    let to = (f64::from(from) + length * width) as f32;
                    let shows = table.shows(from, to);
                    let (from, to) = (f64::from(from), f64::from(to));
                    let truth = maxima.over(from, to) > 0.0;
                    let near = maxima.over(from - 2.0 * bin, to + 2.0 * bin) > 0.0;
                    assert!(shows || !truth, "{low} {width}: {from} {to}");
                    assert!(!shows || near, "{low} {width}: {from} {to}");
                    hidden += u32::from(!shows);
                }
            }
            assert!(hidden > 500, "{low} {width}: {hidden}");
            assert!(!table.shows(f32::MAX, f32::MIN), "an empty range");
            assert!(table.shows(f32::MIN, f32::MAX));
        }
    }

    // Air is 0 as a rule, and a ramp begins there.
    #[test]
    fn the_first_knot_alone_is_as_clear_as_it_is() {
        let table = FloatTable::new(&appearance(&[(0.0, 0.0), (1.0, 1.0)]));
        assert!(!table.shows(0.0, 0.0) && table.shows(0.0, 1e-3) && table.shows(0.5, 0.5));
        assert!(!table.shows(-2.0, -1.0) && table.shows(2.0, 2.0));
        let step = FloatTable::new(&appearance(&[(0.0, 0.0), (0.0, 1.0)]));
        assert!(step.shows(0.0, 0.0) && step.shows(1.0, 2.0) && !step.shows(-2.0, -1.0));
        let constant = FloatTable::new(&appearance(&[(3.0, 0.0)]));
        assert!(!constant.shows(-1e30, 1e30));
        let opaque = FloatTable::new(&appearance(&[(3.0, 1.0)]));
        assert!(opaque.shows(7.0, 7.0) && opaque.shows(-9.0, -8.0) && opaque.shows(3.0, 3.0));
        let narrow = FloatTable::new(&appearance(&[(0.0, 0.0), (1e-38, 1.0)]));
        assert!(narrow.shows(0.5, 0.5) && !narrow.shows(-0.5, -0.5));
        let wide = FloatTable::new(&appearance(&[(-1e300, 0.0), (1e300, 1.0)]));
        assert!(wide.shows(0.5, 0.5) && wide.shows(-1e38, -1e38) && wide.shows(1e38, 1e38));
    }

    #[test]
    fn ranges_around_a_surface_show() {
        let mut look = holes(0.0, 1.0);
        look.optical_model = OpticalModel::Isosurfaces;
        assert!(
            !FloatTable::new(&look).shows(f32::MIN, f32::MAX),
            "no surface"
        );
        for values in [&[0.5, 0.205][..], &[0.3][..]] {
            let surface = |value: &f64| Isosurface {
                value: *value,
                color: DVec3::ONE,
            };
            look.isosurfaces = values.iter().map(surface).collect();
            let table = FloatTable::new(&look);
            for low in 0..60 {
                for high in low..60 {
                    let (low, high) = (low as f32 * 0.01, high as f32 * 0.01);
                    let met = |v: &f64| f64::from(low) <= *v && *v <= f64::from(high);
                    assert!(
                        table.shows(low, high) || !values.iter().any(met),
                        "{low} {high}"
                    );
                }
            }
            assert!(!table.shows(-1.0, 0.1) && !table.shows(0.6, 2.0));
        }
    }
}
