//! How often values of a field occur, for whoever draws a histogram or cuts a range.

use tetrascope_core::Volume;

use crate::distribution::Distribution;

/// The finite values of a field: all of them, or about a million that stand for them.
#[derive(Clone, Debug)]
pub struct FieldValues {
    /// By increasing value, with how many values are at most that.
    cumulative: Vec<(f64, f64)>,
    is_complete: bool,
}

impl FieldValues {
    /// The values of the volume's field; takes time. Those of points count once each, as do those
    /// of cells.
    pub fn of(volume: &Volume) -> FieldValues {
        let distribution = Distribution::of(volume);
        let mut passed = 0.0;
        let cumulative = distribution.counts().map(|(value, count)| {
            passed += count;
            (value, passed)
        });
        FieldValues {
            cumulative: cumulative.collect(),
            is_complete: distribution.is_complete(),
        }
    }

    /// Whether all values were looked at.
    pub fn is_complete(&self) -> bool {
        self.is_complete
    }

    /// How many values were looked at.
    pub fn count(&self) -> f64 {
        self.cumulative.last().map_or(0.0, |(_, passed)| *passed)
    }

    /// The least value that this share of all values does not exceed, 0 to 1; `None` without a
    /// value.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let wanted = share.clamp(0.0, 1.0) * self.count();
        let place = self.cumulative.partition_point(|(_, n)| *n < wanted);
        let last = self.cumulative.len().checked_sub(1)?;
        Some(self.cumulative[place.min(last)].0)
    }

    /// How many values lie in each of `bins` equal parts of the range from `low` to `high`; a value
    /// on a border belongs to the upper part, `high` itself to the last.
    pub fn histogram(&self, (low, high): (f64, f64), bins: usize) -> Vec<f64> {
        let mut counts = vec![0.0; bins];
        let mut before = 0.0;
        for &(value, passed) in &self.cumulative {
            let count = passed - before;
            before = passed;
            if bins == 0 || !(low..=high).contains(&value) {
                continue;
            }
            // Halves first: the difference of two huge ends could overflow.
            let place = (value * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5);
            let bin = if place.is_finite() {
                (place * bins as f64) as usize
            } else {
                bins / 2 // a constant field
            };
            counts[bin.min(bins - 1)] += count;
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Grid;
    use tetrascope_core::glam::{DMat3, DVec3};
    use tetrascope_core::grid::Samples;

    use super::*;

    fn values(samples: Vec<f32>) -> FieldValues {
        let dims = [samples.len() / 4, 2, 2];
        let samples = Samples::F32(samples);
        let grid = Grid::new(dims, DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
        FieldValues::of(&Volume::Grid(grid.expect("a grid")))
    }

    #[test]
    fn every_finite_value_is_in_one_bin() {
        let mut samples: Vec<f32> = (0..100).map(|i| i as f32).collect();
        samples[7] = f32::NAN;
        let values = values(samples);
        assert_eq!(values.count(), 99.0);
        assert_eq!(values.histogram((0.0, 99.0), 1), [99.0]);
        let counts = values.histogram((0.0, 100.0), 10);
        assert_eq!(
            counts,
            [9.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0]
        );
        assert_eq!(values.histogram((10.0, 19.0), 2), [5.0, 5.0]);
        assert_eq!(values.histogram((3.0, 3.0), 4), [0.0, 0.0, 1.0, 0.0]);
        assert!(values.histogram((0.0, 1.0), 0).is_empty());
    }

    #[test]
    fn quantiles_are_values_of_the_field() {
        let values = values((0..100).map(|i| i as f32).collect());
        assert_eq!(values.quantile(0.0), Some(0.0));
        assert_eq!(values.quantile(0.02), Some(1.0));
        assert_eq!(values.quantile(0.5), Some(49.0));
        assert_eq!(values.quantile(1.0), Some(99.0));
        assert_eq!(values.quantile(7.0), Some(99.0));
    }

    #[test]
    fn without_a_finite_value_there_is_no_quantile() {
        let values = values(vec![f32::NAN; 8]);
        assert_eq!((values.quantile(0.5), values.count()), (None, 0.0));
        assert_eq!(values.histogram((0.0, 1.0), 2), [0.0, 0.0]);
    }
}
