//! Cells in f64, one at a time.
//!
//! With the corners' scalars s and coverages c, D = Σ w c and, for any scalar k,
//! F(k) = Σ w c (s − k) are cubics on a ray, and the scalar is k where F(k) = 0. Between two
//! knots at k₀ and k₁, X = F(k₀)/(k₁ − k₀) and Y = −F(k₁)/(k₁ − k₀) are not negative, X + Y = D,
//! C σ = Y σ₀ + X σ₁, and the color is (Y c₀ + X c₁)/D.

use tetrascope_core::OpticalModel;

use super::cubic::Cubic;
use super::gathered::Gathered;
use super::pieces::{Piece, Pieces};

/// A part is halved at most so often: where D falls to 0 at an end, what is left is 2⁻²⁴ of the
/// cell and holds less than that of its light.
const MOST_HALVINGS: u32 = 24;

/// Parts of a greater optical depth are halved before they are integrated.
const DEEPEST: f64 = 1.0;

/// Nodes and weights of Gauss-Legendre with 6 points on [0, 1].
const SIX: [[f64; 2]; 6] = [
    [0.033_765_242_898_423_99, 0.085_662_246_189_585_17],
    [0.169_395_306_766_867_74, 0.180_380_786_524_069_3],
    [0.380_690_406_958_401_5, 0.233_956_967_286_345_52],
    [0.619_309_593_041_598_5, 0.233_956_967_286_345_52],
    [0.830_604_693_233_132_3, 0.180_380_786_524_069_3],
    [0.966_234_757_101_576, 0.085_662_246_189_585_17],
];

/// Data that all cells of a frame share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exact<'a> {
    pub(crate) pieces: &'a Pieces,
    pub(crate) model: OpticalModel,
    /// How far the light of a part may be from that of its halves, relative to its greatest.
    pub(crate) tolerance: f64,
    /// Behind this optical depth nothing shows.
    pub(crate) stop_depth: f64,
}

/// The straight way of a ray through a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// In [0, 1]³.
    pub(crate) entry: [f64; 3],
    pub(crate) exit: [f64; 3],
    /// World units.
    pub(crate) length: f64,
    /// The depth cue's factors at both ends.
    pub(crate) cue: [f64; 2],
}

/// A part of a way between two knots.
#[derive(Clone, Copy, Debug)]
struct Part<'a> {
    piece: &'a Piece,
    /// X and Y of the module's comment.
    shares: [Cubic; 2],
    length: f64,
    cue: [f64; 2],
}

impl Exact<'_> {
    /// Adds a cell with these corners to what a ray has gathered. Corners that are not covered
    /// may be NaN.
    pub(crate) fn add(
        &self,
        scalars: &[f64; 8],
        coverage: &[f64; 8],
        way: &Way,
        gathered: &mut Gathered,
    ) {
        let covered = (0..8).filter(|i| coverage[*i] > 0.0).map(|i| scalars[i]);
        let low = covered.clone().fold(f64::INFINITY, f64::min);
        let high = covered.fold(f64::NEG_INFINITY, f64::max);
        if !(low.is_finite() && high.is_finite()) {
            return;
        }
        if self.model == OpticalModel::MaximumIntensity {
            return self.add_greatest(scalars, [low, high], way, gathered);
        }
        let on_way = |corner: &dyn Fn(usize) -> f64| {
            Cubic::trilinear(&std::array::from_fn(corner), way.entry, way.exit)
        };
        let all = on_way(&|i| coverage[i]);
        if low == high {
            let piece = self.pieces.constant(low);
            let part = Part {
                piece: &piece,
                shares: [Cubic([0.0; 4]), all],
                length: way.length,
                cue: way.cue,
            };
            return self.add_part(&part, MOST_HALVINGS, gathered);
        }
        let excess = |k: f64, factor: f64| {
            on_way(&|i| match coverage[i] > 0.0 {
                true => coverage[i] * ((scalars[i] - k) * factor),
                false => 0.0,
            })
        };
        let pieces = self.pieces.touched(low, high);
        let mut places = vec![0.0, 1.0];
        for piece in &pieces[..pieces.len() - 1] {
            let parts = excess(piece.high, 1.0);
            places.extend(parts.monotone().map(|part| part.place(0.0)));
        }
        places.sort_unstable_by(f64::total_cmp);
        let from_low = excess(low, 1.0);
        for pair in places.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let middle = 0.5 * (from + to);
            let there = all.at(middle);
            if to <= from || there <= 0.0 {
                continue;
            }
            let scalar = (low + from_low.at(middle) / there).clamp(low, high);
            let piece = &self.pieces.all()[self.pieces.find(scalar, true)];
            if piece.is_clear() {
                continue;
            }
            let shares = match piece.is_unbounded() {
                true => [Cubic([0.0; 4]), all],
                false => {
                    let factor = (piece.high - piece.low).recip();
                    [excess(piece.low, factor), excess(piece.high, -factor)]
                }
            };
            let at = |tau: f64| way.cue[0] * (1.0 - tau) + way.cue[1] * tau;
            let part = Part {
                piece,
                shares: shares.map(|cubic| cubic.part(from, to)),
                length: way.length * (to - from),
                cue: [at(from), at(to)],
            };
            self.add_part(&part, MOST_HALVINGS, gathered);
            if gathered.depth.value() > self.stop_depth {
                return;
            }
        }
    }

    fn add_part(&self, part: &Part, halvings: u32, gathered: &mut Gathered) {
        let depth = part.depth();
        if depth <= 0.0 {
            return;
        }
        if self.model == OpticalModel::Absorption {
            return gathered.depth.add(depth);
        }
        let absorbs = self.model == OpticalModel::EmissionAbsorption;
        let halves = part.halves();
        let whole = part.emitted(absorbs);
        let [first, second] = halves.map(|half| half.emitted(absorbs));
        let passed = if absorbs {
            (-halves[0].depth()).exp()
        } else {
            1.0
        };
        let both = [0, 1].map(|i| first[i] + passed * second[i]);
        let off = (whole[0] - both[0]).abs().max((whole[1] - both[1]).abs());
        // The two halves are exact to a thousandth of that, as the rule is of degree 11.
        let is_near = off <= self.tolerance * if absorbs { 1.0 } else { depth };
        // However deep a part is, all but the first few depths of it are hidden.
        let is_deep = absorbs && depth > DEEPEST;
        if is_deep || halvings > 0 && !is_near {
            for half in &halves {
                self.add_part(half, halvings - u32::from(!is_deep), gathered);
                if gathered.depth.value() > self.stop_depth {
                    return;
                }
            }
            return;
        }
        let share = both[0].clamp(0.0, both[1].max(0.0));
        let [low, high] = part.piece.colors;
        let light = (both[1] - share) * low + share * high;
        match absorbs {
            true => {
                gathered.light += (-gathered.depth.value()).exp() * light;
                gathered.depth.add(depth);
            }
            false => gathered.light += light,
        }
    }

    /// The greatest product of color and cue in a cell, channel by channel.
    fn add_greatest(
        &self,
        scalars: &[f64; 8],
        [low, high]: [f64; 2],
        way: &Way,
        gathered: &mut Gathered,
    ) {
        if low == high {
            let piece = self.pieces.constant(low);
            let factor = way.cue[0].max(way.cue[1]);
            gathered.light = gathered.light.max(piece.colors[0] * factor);
            return;
        }
        let cubic = Cubic::trilinear(scalars, way.entry, way.exit);
        for part in cubic.monotone() {
            let [front, back] = part.ends();
            if front == back && part.cubic.0[1] == front && part.cubic.0[2] == front {
                let color = self.pieces.constant(front).colors[0];
                let factor = way.cue[0].max(way.cue[1]);
                gathered.light = gathered.light.max(color * factor);
                continue;
            }
            for piece in self.pieces.touched(front.min(back), front.max(back)) {
                let places = [piece.low, piece.high].map(|knot| match knot.is_infinite() {
                    true if (knot > 0.0) == (front < back) => part.to,
                    true => part.from,
                    false => part.place(knot),
                });
                let [from, to] = [places[0].min(places[1]), places[0].max(places[1])];
                let cue = [from, to].map(|t| way.cue[0] * (1.0 - t) + way.cue[1] * t);
                let shares = cubic
                    .part(from, to)
                    .0
                    .map(|s| piece.share(s).clamp(0.0, 1.0));
                for channel in 0..3 {
                    let [c0, c1] = piece.colors.map(|c| c[channel]);
                    let color = shares.map(|x| c0 * (1.0 - x) + c1 * x);
                    let light = &mut gathered.light[channel];
                    *light = greatest(product(color, cue), *light, self.tolerance);
                }
            }
        }
    }
}

/// Bernstein coefficients of the product of a cubic and a line.
fn product(c: [f64; 4], [a, b]: [f64; 2]) -> [f64; 5] {
    let inner = |i: usize| {
        let share = i as f64 / 4.0;
        (1.0 - share) * c[i] * a + share * c[i - 1] * b
    };
    [c[0] * a, inner(1), inner(2), inner(3), c[3] * b]
}

/// The greater of `so_far` and the greatest value of a quartic, to `tolerance` of it.
fn greatest(b: [f64; 5], so_far: f64, tolerance: f64) -> f64 {
    let so_far = so_far.max(b[0]).max(b[4]);
    let bound = b.into_iter().fold(0.0, f64::max);
    // The curve stays below its coefficients. Curves of one value are halved no further.
    let is_flat = bound - b.into_iter().fold(bound, f64::min) <= 1e-3 * tolerance * bound;
    if bound <= so_far * (1.0 + 1e-3 * tolerance) || is_flat {
        return so_far;
    }
    let mut row = b;
    let (mut left, mut right) = ([b[0]; 5], [b[4]; 5]);
    for i in 1..5 {
        for j in 0..5 - i {
            row[j] = 0.5 * (row[j] + row[j + 1]);
        }
        left[i] = row[0];
        right[4 - i] = row[4 - i];
    }
    let so_far = greatest(left, so_far, tolerance);
    greatest(right, so_far, tolerance)
}

impl<'a> Part<'a> {
    /// Bernstein coefficients of C σ l.
    fn extinctions(&self) -> [f64; 4] {
        let [e0, e1] = self.piece.extinctions;
        let [x, y] = self.shares;
        std::array::from_fn(|i| self.length * (e0 * y.0[i] + e1 * x.0[i]))
    }

    /// ∫ C σ over the part: the mean of the coefficients.
    fn depth(&self) -> f64 {
        let [a, b, c, d] = self.extinctions();
        0.25 * ((a + b) + (c + d))
    }

    fn halves(&self) -> [Part<'a>; 2] {
        let [x, y] = self.shares.map(|cubic| cubic.split(0.5));
        let middle = 0.5 * (self.cue[0] + self.cue[1]);
        let cues = [[self.cue[0], middle], [middle, self.cue[1]]];
        [0, 1].map(|i| Part {
            shares: [x[i], y[i]],
            length: 0.5 * self.length,
            cue: cues[i],
            ..*self
        })
    }

    /// ∫ f x C σ l e^(−∫) and ∫ f C σ l e^(−∫), without the exponential unless it `absorbs`:
    /// f is the cue, x the color's share of the piece's high end.
    fn emitted(&self, absorbs: bool) -> [f64; 2] {
        let extinction = Cubic(self.extinctions());
        let [x, y] = self.shares;
        let (mut high, mut all) = (0.0, 0.0);
        for [tau, weight] in SIX {
            // The depth of the part before `tau`, by the mean of its coefficients.
            let passed = match absorbs {
                true => {
                    let before = extinction.split(tau)[0].0;
                    (-0.25 * tau * before.into_iter().sum::<f64>()).exp()
                }
                false => 1.0,
            };
            let cue = self.cue[0] * (1.0 - tau) + self.cue[1] * tau;
            let emitted = weight * cue * extinction.at(tau).max(0.0) * passed;
            // Rounding of the roots must not lead out of the piece.
            let (x, y) = (x.at(tau).max(0.0), y.at(tau).max(0.0));
            high += emitted * if x + y > 0.0 { x / (x + y) } else { 0.0 };
            all += emitted;
        }
        [high, all]
    }
}
