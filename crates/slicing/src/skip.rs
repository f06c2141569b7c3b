//! Whether a transfer function maps a range of scalars to nothing, in constant time (§6).

use tetrascope_core::grid::SampleType;
use tetrascope_core::{Appearance, OpticalModel};

use crate::maxima::Maxima;

/// Bins for floats. Their ranges are rounded outward to bins, so that a box may be drawn
/// that has nothing to show, but none is left out that has.
const BINS: usize = 1 << 16;

/// A summed table over the transfer function: how many of its first n entries show.
///
/// Entries are bins of scalars, then for integers the integers themselves. The bins of
/// integers are the unit intervals between them, so that the answer is exact. The last
/// entry shows.
///
/// Where isosurfaces are drawn, entries are these by increasing value, and all of them show.
#[derive(Debug)]
pub(crate) struct SkipTable {
    maxima: Maxima,
    /// Where bin 1 begins; bin 0 and the last one are unbounded.
    first: f64,
    /// Where the last but one ends.
    last: f64,
    bins_per_scalar: f64,
    /// Bins between `first` and `last`.
    inner: usize,
    /// `shown[n]` of the first n entries show.
    shown: Vec<u32>,
    /// How many integers there are, from `first` on, as entries behind the bins.
    points: usize,
    /// The values of isosurfaces, by increasing value, if they are what shows.
    surfaces: Option<Vec<f64>>,
}

impl SkipTable {
    pub(crate) fn new(appearance: &Appearance, sample_type: SampleType) -> SkipTable {
        let maxima = Maxima::new(appearance);
        let (low, high) = appearance.transfer_function.range();
        let (first, bins_per_scalar, bins) = match sample_type {
            SampleType::U8 => (0.0, 1.0, 255),
            SampleType::U16 => (0.0, 1.0, 65535),
            SampleType::I16 => (-32768.0, 1.0, 65535),
            SampleType::F32 if (BINS as f64 / (high - low)).is_finite() => {
                (low, BINS as f64 / (high - low), BINS)
            }
            // One bin around all knots, which lie close together or at one scalar.
            SampleType::F32 => (low, 1.0, 1),
        };
        let integers = sample_type != SampleType::F32;
        // Bins of floats begin a little early and end a little late, for rounding.
        let slack = if integers { 0.0 } else { 1e-3 };
        let end = |bins: f64| first + bins / bins_per_scalar;
        let shows = |bin: usize| {
            let (low, high) = match bin {
                // Beyond the knots all is constant.
                0 => (f64::NEG_INFINITY, f64::NEG_INFINITY),
                n if n > bins => (f64::INFINITY, f64::INFINITY),
                n => (end(n as f64 - 1.0 - slack), end(n as f64 + slack)),
            };
            maxima.over(low, high) > 0.0
        };
        let points = if integers { bins + 1 } else { 0 };
        let point_shows = |i: usize| {
            let scalar = first + i as f64;
            maxima.over(scalar, scalar) > 0.0
        };
        let entries = (0..bins + 2).map(shows).chain((0..points).map(point_shows));
        let mut shown = vec![0];
        let mut count = 0;
        for shows in entries.chain([true]) {
            count += u32::from(shows);
            shown.push(count);
        }
        let surfaces = (appearance.optical_model == OpticalModel::Isosurfaces).then(|| {
            let values = appearance.isosurfaces.iter().map(|s| s.value);
            let mut values: Vec<f64> = values.collect();
            values.sort_unstable_by(f64::total_cmp);
            values
        });
        if let Some(surfaces) = &surfaces {
            shown = (0..=surfaces.len() as u32).collect();
        }
        SkipTable {
            surfaces,
            points,
            inner: bins,
            maxima,
            first,
            last: if integers { end(bins as f64) } else { high },
            bins_per_scalar,
            shown,
        }
    }

    /// Whether any scalar in [low, high] shows; an empty range does not.
    pub(crate) fn shows(&self, low: f64, high: f64) -> bool {
        let [from, to] = self.entries(low, high);
        self.shown[to as usize] > self.shown[from as usize]
    }

    /// How many of the first n entries show.
    pub(crate) fn counts(&self) -> &[u32] {
        &self.shown
    }

    /// The entries for scalars in [low, high]: the first, and the one behind the last.
    pub(crate) fn entries(&self, low: f64, high: f64) -> [u32; 2] {
        if low > high {
            return [0; 2];
        }
        if let Some(surfaces) = &self.surfaces {
            // Those between whose value and `low` the field must pass
            // (`Isosurface::is_met`).
            return [low, high].map(|s| surfaces.partition_point(|v| *v <= s) as u32);
        }
        let place = |scalar: f64| (scalar - self.first) * self.bins_per_scalar;
        let run = |from: usize, to: usize| [from as u32, to as u32];
        if low == high {
            // The cast saturates, also what is no integer's place.
            let point = place(low) as usize;
            let entries = self.shown.len() - 1;
            return match self.maxima.over(low, high) > 0.0 {
                _ if point < self.points => run(self.inner + 2 + point, self.inner + 3 + point),
                true => run(entries - 1, entries),
                false => run(0, 0),
            };
        }
        // Bins 1 to `inner` lie between `first` and `last`, both included.
        let bin = |scalar: f64, inside: f64| match scalar {
            s if s < self.first => 0,
            s if s > self.last => self.inner + 1,
            _ => (inside as usize).clamp(1, self.inner),
        };
        let from = bin(low, place(low).floor() + 1.0);
        let to = bin(high, place(high).ceil());
        run(from, to + 1)
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Knot, OpticalModel, TransferFunction};

    use super::*;

    fn appearance(knots: &[(f64, f64)]) -> Appearance {
        let knots = knots.iter().map(|&(scalar, extinction)| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        });
        let tf = TransferFunction::new(knots.collect()).expect("sorted");
        Appearance::new(tf, OpticalModel::EmissionAbsorption)
    }

    /// Clear, but for a tent, a box between integers, a spike and what is above 200.
    fn holes() -> Appearance {
        appearance(&[
            (10.0, 0.0),
            (12.5, 1.0),
            (15.0, 0.0),
            (40.25, 0.0),
            (40.25, 2.0),
            (40.75, 2.0),
            (40.75, 0.0),
            (99.0, 0.0),
            (100.0, 1e-9),
            (101.0, 0.0),
            (200.0, 0.0),
            (200.0, 3.0),
        ])
    }

    #[test]
    fn ranges_of_integers_are_answered_exactly() {
        let look = holes();
        let maxima = Maxima::new(&look);
        for sample_type in [SampleType::U8, SampleType::U16, SampleType::I16] {
            let table = SkipTable::new(&look, sample_type);
            for low in 0..=255 {
                for high in low..=255 {
                    let (low, high) = (f64::from(low), f64::from(high));
                    let truth = maxima.over(low, high) > 0.0;
                    assert_eq!(
                        table.shows(low, high),
                        truth,
                        "{sample_type:?} {low} {high}"
                    );
                }
            }
            assert!(!table.shows(f64::INFINITY, f64::NEG_INFINITY));
        }
        let signed = SkipTable::new(&appearance(&[(-5.0, 1.0), (0.0, 0.0)]), SampleType::I16);
        assert!(signed.shows(-32768.0, -32768.0) && signed.shows(-1.0, 7.0));
        assert!(!signed.shows(0.0, 32767.0));
    }

    #[test]
    fn ranges_around_a_surface_show() {
        let mut look = holes();
        look.optical_model = OpticalModel::Isosurfaces;
        let surface = |value| tetrascope_core::Isosurface {
            value,
            color: DVec3::ONE,
        };
        look.isosurfaces = vec![surface(50.0), surface(20.5)];
        for sample_type in [SampleType::U8, SampleType::F32] {
            let table = SkipTable::new(&look, sample_type);
            for low in 0..60 {
                for high in low..60 {
                    let (low, high) = (f64::from(low), f64::from(high));
                    let mut all = look.isosurfaces.iter();
                    let truth = all.any(|s| s.is_met(low, high));
                    assert_eq!(table.shows(low, high), truth, "{low} {high}");
                }
            }
            assert!(!table.shows(f64::INFINITY, f64::NEG_INFINITY));
        }
    }

    // Nothing that shows is skipped, and what is farther than a bin from all that shows is.
    #[test]
    fn ranges_of_floats_are_answered_safely() {
        let look = holes();
        let maxima = Maxima::new(&look);
        let table = SkipTable::new(&look, SampleType::F32);
        let bin = 190.0 / BINS as f64;
        for i in 0..600 {
            for length in [0.0, 0.01, 0.7, 30.0] {
                let low = f64::from(i) * 0.4321 - 20.0;
                let shows = table.shows(low, low + length);
                let truth = maxima.over(low, low + length) > 0.0;
                let near = maxima.over(low - 2.0 * bin, low + length + 2.0 * bin) > 0.0;
                assert!(shows || !truth, "{low} {length}");
                assert!(!shows || near, "{low} {length}");
            }
        }
        assert!(table.shows(f64::NEG_INFINITY, f64::INFINITY));
        let constant = SkipTable::new(&appearance(&[(3.0, 0.0)]), SampleType::F32);
        assert!(!constant.shows(-1e30, 1e30));
        let opaque = SkipTable::new(&appearance(&[(3.0, 1.0)]), SampleType::F32);
        assert!(opaque.shows(7.0, 7.0) && opaque.shows(-9.0, -8.0));
    }
}
