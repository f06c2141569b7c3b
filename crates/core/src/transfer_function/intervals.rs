//! A transfer function's pieces, ready for evaluation.

use glam::DVec3;

use super::{Knot, Side};

/// A transfer function as the intervals between its distinct knot scalars.
///
/// The first and the last interval are unbounded and constant; a step is a
/// boundary at which the neighbors disagree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Intervals {
    /// By increasing scalar, each ending where the next begins.
    intervals: Vec<KnotPair>,
    /// `intervals[i + 1].low`, the distinct knot scalars.
    boundaries: Vec<f64>,
}

/// A range of scalars on which color and extinction are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KnotPair {
    /// −∞ for the first.
    pub(crate) low: f64,
    /// ∞ for the last.
    pub(crate) high: f64,
    at_low: (DVec3, f64),
    at_high: (DVec3, f64),
    /// Whether both ends are alike, as in the unbounded ones.
    constant: bool,
    /// Whether the extinction is 0 throughout.
    pub(crate) clear: bool,
}

impl Intervals {
    /// The intervals of at least one knot, sorted, at most two at one scalar.
    pub(crate) fn new(knots: &[Knot]) -> Intervals {
        let value = |knot: &Knot| (knot.color, knot.extinction);
        let (first, last) = (&knots[0], &knots[knots.len() - 1]);
        let mut intervals = vec![KnotPair::new(
            f64::NEG_INFINITY,
            first.scalar,
            value(first),
            value(first),
        )];
        for pair in knots.windows(2).filter(|p| p[0].scalar < p[1].scalar) {
            let (low, high) = (&pair[0], &pair[1]);
            intervals.push(KnotPair::new(
                low.scalar,
                high.scalar,
                value(low),
                value(high),
            ));
        }
        intervals.push(KnotPair::new(
            last.scalar,
            f64::INFINITY,
            value(last),
            value(last),
        ));
        let boundaries = intervals[1..].iter().map(|i| i.low).collect();
        Intervals {
            intervals,
            boundaries,
        }
    }

    /// The index of the interval to the `side` of `scalar`, not NaN.
    ///
    /// `Below` is where one comes from on the way up to `scalar`.
    pub(crate) fn find(&self, scalar: f64, side: Side) -> usize {
        self.boundaries.partition_point(|&b| match side {
            Side::Below => b < scalar,
            Side::Above => b <= scalar,
        })
    }

    /// The interval with this index, which must come from [`Intervals::find`] or be 0.
    #[inline]
    pub(crate) fn get(&self, index: usize) -> &KnotPair {
        &self.intervals[index]
    }
}

impl KnotPair {
    fn new(low: f64, high: f64, at_low: (DVec3, f64), at_high: (DVec3, f64)) -> KnotPair {
        KnotPair {
            low,
            high,
            at_low,
            at_high,
            constant: at_low == at_high,
            clear: at_low.1 == 0.0 && at_high.1 == 0.0,
        }
    }

    /// Color and extinction at a `scalar` in [low, high], each end included.
    ///
    /// Both weights are made from a difference of given numbers and nothing of
    /// opposite sign is added, so the relative error is at most 4 ε, also where a
    /// value goes to 0. Exact at both ends and where the interval is constant.
    #[inline]
    pub(crate) fn sample(&self, scalar: f64) -> (DVec3, f64) {
        if self.constant {
            return self.at_low;
        }
        let width = self.high - self.low;
        let x = (scalar - self.low) / width;
        let y = (self.high - scalar) / width;
        (
            self.at_low.0 * y + self.at_high.0 * x,
            self.at_low.1 * y + self.at_high.1 * x,
        )
    }
}
