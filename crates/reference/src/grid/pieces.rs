//! A transfer function as intervals of scalars on which it is linear.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Knot, TransferFunction};

/// Scalars between two knots, or beyond the outermost, where all is constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// −∞ for the first.
    pub(crate) low: f64,
    /// ∞ for the last.
    pub(crate) high: f64,
    pub(crate) colors: [DVec3; 2],
    pub(crate) extinctions: [f64; 2],
}

/// The step where two pieces meet, if they disagree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) scalar: f64,
    pub(crate) color: f64,
    pub(crate) extinction: f64,
}

/// A transfer function's pieces, by increasing scalar, each ending where the next begins.
#[derive(Clone, Debug)]
pub(crate) struct Pieces {
    pieces: Vec<Piece>,
    steps: Vec<Step>,
}

impl Pieces {
    pub(crate) fn new(transfer_function: &TransferFunction) -> Pieces {
        let knots = transfer_function.knots();
        let (first, last) = (&knots[0], &knots[knots.len() - 1]);
        let mut pieces = vec![Piece::new(f64::NEG_INFINITY, first.scalar, [first, first])];
        let mut steps = Vec::new();
        for pair in knots.windows(2) {
            let [a, b] = [&pair[0], &pair[1]];
            if a.scalar < b.scalar {
                pieces.push(Piece::new(a.scalar, b.scalar, [a, b]));
            } else {
                steps.push(Step {
                    scalar: a.scalar,
                    color: (a.color - b.color).abs().max_element(),
                    extinction: (a.extinction - b.extinction).abs(),
                });
            }
        }
        pieces.push(Piece::new(last.scalar, f64::INFINITY, [last, last]));
        Pieces { pieces, steps }
    }

    pub(crate) fn get(&self, index: usize) -> &Piece {
        &self.pieces[index]
    }

    /// The piece just above `scalar`, or just below where `rising` is false.
    pub(crate) fn find(&self, scalar: f64, rising: bool) -> usize {
        let inner = &self.pieces[1..];
        inner.partition_point(|p| {
            if rising {
                p.low <= scalar
            } else {
                p.low < scalar
            }
        })
    }

    /// All pieces that [low, high] touches.
    pub(crate) fn touched(&self, low: f64, high: f64) -> &[Piece] {
        &self.pieces[self.find(low, false)..=self.find(high, true)]
    }

    /// The steps in [low, high].
    pub(crate) fn steps(&self, low: f64, high: f64) -> &[Step] {
        let first = self.steps.partition_point(|s| s.scalar < low);
        let end = self.steps.partition_point(|s| s.scalar <= high);
        &self.steps[first..end.max(first)]
    }
}

impl Piece {
    fn new(low: f64, high: f64, ends: [&Knot; 2]) -> Piece {
        Piece {
            low,
            high,
            colors: ends.map(|k| k.color),
            extinctions: ends.map(|k| k.extinction),
        }
    }

    /// Whether nothing here absorbs or glows.
    pub(crate) fn is_clear(&self) -> bool {
        self.extinctions == [0.0; 2]
    }

    /// How far `scalar` is from the low and from the high end, as shares of the width.
    ///
    /// Each is a difference of given numbers, so that neither loses digits near 0.
    pub(crate) fn shares(&self, scalar: f64) -> [f64; 2] {
        if self.low.is_infinite() || self.high.is_infinite() {
            return [0.0, 1.0];
        }
        let width = self.high - self.low;
        [(scalar - self.low) / width, (self.high - scalar) / width]
    }

    /// The color at `scalar`.
    pub(crate) fn color(&self, scalar: f64) -> DVec3 {
        let [x, y] = self.shares(scalar);
        self.colors[0] * y + self.colors[1] * x
    }

    /// The extinction at `scalar`, which may lie outside.
    pub(crate) fn extinction(&self, scalar: f64) -> f64 {
        let [x, y] = self.shares(scalar);
        self.extinctions[0] * y + self.extinctions[1] * x
    }

    /// The greatest change of extinction and of a color's component, per scalar.
    pub(crate) fn slopes(&self) -> (f64, f64) {
        let width = self.high - self.low;
        let rise = (self.extinctions[1] - self.extinctions[0]).abs();
        let shift = (self.colors[1] - self.colors[0]).abs().max_element();
        // The outermost are infinitely wide and change by nothing.
        (rise / width, shift / width)
    }
}
