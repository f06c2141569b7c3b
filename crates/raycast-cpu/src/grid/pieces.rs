//! A transfer function as intervals of scalars on which it is linear.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Knot, TransferFunction};

use super::shows::{above, below};

/// Scalars between two knots, or beyond the outermost, where all is constant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// −∞ for the first.
    pub(crate) low: f64,
    /// ∞ for the last.
    pub(crate) high: f64,
    pub(crate) colors: [DVec3; 2],
    /// Per world unit.
    pub(crate) extinctions: [f64; 2],
}

/// A transfer function's pieces, by increasing scalar, each ending where the next begins.
#[derive(Clone, Debug)]
pub(crate) struct Pieces(Vec<Piece>);

impl Pieces {
    pub(crate) fn new(transfer_function: &TransferFunction) -> Pieces {
        let knots = transfer_function.knots();
        let (first, last) = (&knots[0], &knots[knots.len() - 1]);
        let mut pieces = vec![Piece::new(f64::NEG_INFINITY, first.scalar, first, first)];
        let inner = knots.windows(2).filter(|p| p[0].scalar < p[1].scalar);
        pieces.extend(inner.map(|p| Piece::new(p[0].scalar, p[1].scalar, &p[0], &p[1])));
        pieces.push(Piece::new(last.scalar, f64::INFINITY, last, last));
        Pieces(pieces)
    }

    pub(crate) fn all(&self) -> &[Piece] {
        &self.0
    }

    /// The number of the piece just above `scalar`, or just below where `rising` is false.
    pub(crate) fn find(&self, scalar: f64, rising: bool) -> usize {
        self.0[1..].partition_point(|p| match rising {
            true => p.low <= scalar,
            false => p.low < scalar,
        })
    }

    /// All pieces that [low, high] touches.
    pub(crate) fn touched(&self, low: f64, high: f64) -> &[Piece] {
        &self.0[self.find(low, false)..=self.find(high, true)]
    }

    /// The piece that a constant scalar is: on a step both sides count half.
    pub(crate) fn constant(&self, scalar: f64) -> Piece {
        let sides = [false, true].map(|rising| self.0[self.find(scalar, rising)]);
        Piece {
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            colors: [0.5 * (sides[0].color(scalar) + sides[1].color(scalar)); 2],
            extinctions: [0.5 * (sides[0].extinction(scalar) + sides[1].extinction(scalar)); 2],
        }
    }

    /// The widest intervals, in f32, of scalars that have no extinction, or no color where
    /// `by_color`. An end on a step whose other side shows is outside.
    pub(crate) fn clear_intervals(&self, by_color: bool) -> Vec<[f32; 2]> {
        let ends = |piece: &Piece| match by_color {
            true => piece.colors.map(DVec3::max_element),
            false => piece.extinctions,
        };
        let mut intervals = Vec::new();
        let mut index = 0;
        while index < self.0.len() {
            let first = index;
            while index < self.0.len() && ends(&self.0[index]) == [0.0; 2] {
                index += 1;
            }
            if index == first {
                index += 1;
                continue;
            }
            let low = match first.checked_sub(1).map(|before| ends(&self.0[before])[1]) {
                None => f32::NEG_INFINITY,
                Some(0.0) => above(self.0[first].low),
                Some(_) => below(self.0[first].low).next_up(),
            };
            let high = match self.0.get(index).map(|next| ends(next)[0]) {
                None => f32::INFINITY,
                Some(0.0) => below(self.0[index].low),
                Some(_) => above(self.0[index].low).next_down(),
            };
            intervals.push([low, high]);
        }
        intervals
    }
}

impl Piece {
    fn new(low: f64, high: f64, at_low: &Knot, at_high: &Knot) -> Piece {
        Piece {
            low,
            high,
            colors: [at_low.color, at_high.color],
            extinctions: [at_low.extinction, at_high.extinction],
        }
    }

    /// Whether nothing here absorbs or glows.
    pub(crate) fn is_clear(&self) -> bool {
        self.extinctions == [0.0; 2]
    }

    /// Whether this is beyond the outermost knots, where all is constant.
    pub(crate) fn is_unbounded(&self) -> bool {
        self.low.is_infinite() || self.high.is_infinite()
    }

    /// How far `scalar` is from the low end, as a share of the width.
    pub(crate) fn share(&self, scalar: f64) -> f64 {
        match self.is_unbounded() {
            true => 0.0,
            false => (scalar - self.low) / (self.high - self.low),
        }
    }

    pub(crate) fn color(&self, scalar: f64) -> DVec3 {
        self.colors[0].lerp(self.colors[1], self.share(scalar))
    }

    pub(crate) fn extinction(&self, scalar: f64) -> f64 {
        let x = self.share(scalar);
        self.extinctions[0] * (1.0 - x) + self.extinctions[1] * x
    }
}
