//! Cells of a grid with coverage: extinction is a cubic there, too, and color a quotient.
//!
//! With the corners' scalars s and coverages c, D = Σ w c and, for any scalar k,
//! F(k) = Σ w c (s − k) are cubics on a ray; the scalar is k where F(k) = 0, so the roots of
//! these cubics split a cell at the transfer function's knots. Between two knots at k₀ and k₁
//! the cubics X = F(k₀)/(k₁ − k₀) and Y = −F(k₁)/(k₁ − k₀) are not negative, X + Y = D, and
//!
//! ```text
//! C σ = D σ(s) = Y σ₀ + X σ₁,   so that optical depths are exact;
//! c = (Y c₀ + X c₁) / D,        so that the light is an integral of a smooth function.
//! ```
//!
//! No rule has a bound for all quotients of cubics, so the light of each part is integrated
//! whole and in halves, and split until both agree to [`AGREEMENT`] of the brightest color times
//! the part's optical depth. What is left counts twice to the error bound: the one part of it
//! that is an estimate.

use tetrascope_core::OpticalModel;

use super::cubic::Cubic;
use super::cue::{self, Cue};
use super::integral::{GridIntegral, Look, horner, power, quartic_power};
use super::pieces::Piece;
use super::quadrature::{LARGEST_DEPTH, rule};

/// How far the light of a part may be from that of its halves, of its optical depth.
const AGREEMENT: f64 = 1e-14;

/// A part is halved at most so often. Where D falls to 0 at an end, halves of it are 2⁻⁴⁰ of the
/// cell, and hold less than that of its light.
const MOST_HALVINGS: u32 = 40;

/// A cell by its corners, x fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CoveredCell {
    pub(crate) scalars: [f64; 8],
    pub(crate) coverage: [f64; 8],
    /// The least and the greatest scalar of those covered.
    pub(crate) range: [f64; 2],
}

/// The straight way through a cell: places in [0, 1]³, and its length in world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    pub(crate) entry: [f64; 3],
    pub(crate) exit: [f64; 3],
    pub(crate) length: f64,
}

/// A part of a way between two knots.
#[derive(Clone, Copy, Debug)]
struct Part<'a> {
    piece: &'a Piece,
    /// X and Y of the module's comment.
    shares: [Cubic; 2],
    length: f64,
    cue: Cue,
}

impl CoveredCell {
    /// `None` where nothing is covered.
    pub(crate) fn new(scalars: [f64; 8], coverage: [f64; 8]) -> Option<CoveredCell> {
        let covered = (0..8).filter(|i| coverage[*i] > 0.0);
        let range = covered.fold(None, |range: Option<[f64; 2]>, i| {
            let [low, high] = range.unwrap_or([scalars[i]; 2]);
            Some([low.min(scalars[i]), high.max(scalars[i])])
        });
        Some(CoveredCell {
            scalars,
            coverage,
            range: range?,
        })
    }

    /// D on a way.
    fn coverage_on(&self, way: &Way) -> Cubic {
        Cubic::trilinear(&self.coverage, way.entry, way.exit)
    }

    /// Σ w c (s − k) · factor on a way.
    fn excess_on(&self, way: &Way, k: f64, factor: f64) -> Cubic {
        let corner = |i: usize| match self.coverage[i] > 0.0 {
            true => self.coverage[i] * ((self.scalars[i] - k) * factor),
            false => 0.0,
        };
        Cubic::trilinear(&std::array::from_fn(corner), way.entry, way.exit)
    }

    /// The scalars at both ends of a way, or beside them where the end is not covered.
    pub(crate) fn ends(&self, way: &Way) -> [f64; 2] {
        let [low, high] = self.range;
        let (coverage, excess) = (self.coverage_on(way), self.excess_on(way, low, 1.0));
        [[0.0, 1e-6, 0.5], [1.0, 1.0 - 1e-6, 0.5]].map(|places| {
            let scalar = |tau: &f64| low + excess.at(*tau) / coverage.at(*tau);
            let mut scalars = places.iter().map(scalar).filter(|s| s.is_finite());
            scalars.next().unwrap_or(low).clamp(low, high)
        })
    }

    /// Adds the cell on this way to what a ray has gathered.
    pub(crate) fn add(&self, look: &Look, integral: &mut GridIntegral, way: &Way, cue: Cue) {
        let coverage = self.coverage_on(way);
        let [low, high] = self.range;
        if low == high {
            // On a step both sides count half.
            let sides = [false, true].map(|rising| look.pieces.get(look.pieces.find(low, rising)));
            let mean = Piece {
                low: f64::NEG_INFINITY,
                high: f64::INFINITY,
                colors: [0.5 * (sides[0].color(low) + sides[1].color(low)); 2],
                extinctions: [0.5 * (sides[0].extinction(low) + sides[1].extinction(low)); 2],
            };
            let part = Part {
                piece: &mean,
                shares: [Cubic([0.0; 4]), coverage],
                length: way.length,
                cue,
            };
            part.add(integral, MOST_HALVINGS);
            return;
        }
        // Where the scalar crosses a knot.
        let pieces = look.pieces.touched(low, high);
        let mut places = vec![0.0, 1.0];
        for piece in &pieces[..pieces.len() - 1] {
            let excess = self.excess_on(way, piece.high, 1.0);
            for part in excess.monotone() {
                let tau = part.place(0.0);
                if tau > 0.0 && tau < 1.0 {
                    places.push(part.from + tau * (part.to - part.from));
                }
            }
        }
        places.sort_unstable_by(f64::total_cmp);
        let excess = self.excess_on(way, low, 1.0);
        for pair in places.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let middle = 0.5 * (from + to);
            let there = coverage.at(middle);
            if to <= from || there <= 0.0 {
                continue;
            }
            let scalar = (low + excess.at(middle) / there).clamp(low, high);
            let piece = look.pieces.get(look.pieces.find(scalar, true));
            if piece.is_clear() {
                continue;
            }
            let shares = if piece.low.is_infinite() || piece.high.is_infinite() {
                // All is constant there, as at its one knot.
                [Cubic([0.0; 4]), coverage]
            } else {
                let factor = (piece.high - piece.low).recip();
                [(piece.low, factor), (piece.high, -factor)]
                    .map(|(k, factor)| self.excess_on(way, k, factor))
            };
            let part = Part {
                piece,
                shares: shares.map(|cubic| cubic.part(from, to)),
                length: way.length * (to - from),
                cue: cue::part(cue, from, to),
            };
            part.add(integral, MOST_HALVINGS);
            if integral.is_opaque() {
                return;
            }
        }
    }

    /// Adds to the error bound what places in the cell that are off by `shift`, in voxels along
    /// all axes together, do.
    ///
    /// D moves by at most the shift, and F(k), for k among the cell's scalars, by their range
    /// times it; twice that, as the point may be in a neighbor, and what rounding adds. Between
    /// knots C σ is a combination of both, so with the greatest extinction E, its slope and that
    /// of the colors, it moves by (E + 2 range slope) times the shift, and C σ c by as much of
    /// color besides. A step counts its height on the length on which F at its scalar is no
    /// farther from 0 than it may be off.
    pub(crate) fn blur(&self, look: &Look, integral: &mut GridIntegral, way: &Way, shift: f64) {
        let [low, high] = self.range;
        let shift = 2.0 * shift.min(0.5) + super::INTERPOLATION;
        let off = (high - low) * shift + super::INTERPOLATION * low.abs().max(high.abs());
        let (mut extinction, mut rise, mut turn) = (0.0f64, 0.0f64, 0.0f64);
        for piece in look.pieces.touched(low - off, high + off) {
            let slopes = piece.slopes();
            extinction = extinction.max(piece.extinctions[0].max(piece.extinctions[1]));
            (rise, turn) = (rise.max(slopes.0), turn.max(slopes.1));
        }
        let c = look.brightest;
        let moved = extinction * shift + 2.0 * rise * off;
        integral.blur_by((c * moved + extinction * 2.0 * turn * off) * way.length);
        for step in look.pieces.steps(low - off, high + off) {
            let height = c * step.extinction + extinction * step.color;
            let excess = self.excess_on(way, step.scalar, 1.0);
            let mut near = 0.0;
            for part in excess.monotone() {
                let ends = [-off, off].map(|s| part.place(s));
                near += (ends[1] - ends[0]).abs() * (part.to - part.from);
            }
            let [b0, _, _, b3] = excess.0;
            if b0 == b3 && b0.abs() <= off {
                near = 1.0;
            }
            integral.blur_by(height * near * way.length);
        }
    }
}

impl Part<'_> {
    /// Bernstein coefficients of C σ l / 4, whose sum is the optical depth.
    fn quarters(&self) -> [f64; 4] {
        let [e0, e1] = self.piece.extinctions;
        let [x, y] = self.shares;
        std::array::from_fn(|i| 0.25 * self.length * (e0 * y.0[i] + e1 * x.0[i]))
    }

    fn halves(&self) -> [Part<'_>; 2] {
        let [x, y] = self.shares.map(|cubic| cubic.split(0.5));
        [0, 1].map(|i| Part {
            piece: self.piece,
            shares: [x[i], y[i]],
            length: 0.5 * self.length,
            cue: cue::part(self.cue, 0.5 * i as f64, 0.5 * (i as f64 + 1.0)),
        })
    }

    /// ∫ f x C σ l e^(−∫) and ∫ f C σ l e^(−∫) over the part, without the exponential in
    /// `Emission`: f is the cue, x the color's share of the piece's high end.
    fn emitted(&self, absorbs: bool) -> [f64; 2] {
        let quarters = self.quarters();
        let [a, b, c, d] = quarters;
        let depth = (a + b) + (c + d);
        let [x, y] = self.shares.map(|cubic| power(cubic.0));
        let extinction = power(quarters.map(|q| 4.0 * q));
        let exponent = quartic_power([0.0, a, a + b, (a + b) + c, depth]);
        let (mut high, mut all) = (0.0, 0.0);
        for &(tau, weight) in rule(LARGEST_DEPTH) {
            let factor = self.cue[0] * (1.0 - tau) + self.cue[1] * tau;
            let passed = if absorbs {
                (-horner(&exponent, tau)).exp()
            } else {
                1.0
            };
            let emitted = weight * factor * horner(&extinction, tau) * passed;
            // Rounding of the roots must not lead out of the piece.
            let (x, y) = (horner(&x, tau).max(0.0), horner(&y, tau).max(0.0));
            let share = if x + y > 0.0 { x / (x + y) } else { 0.0 };
            high += emitted * share;
            all += emitted;
        }
        [high, all]
    }

    fn add(&self, integral: &mut GridIntegral, halvings: u32) {
        let [a, b, c, d] = self.quarters();
        let depth = ((a + b) + (c + d)).max(0.0);
        let model = integral.model();
        let absorbs = model == OpticalModel::EmissionAbsorption;
        let is_deep = absorbs && depth > LARGEST_DEPTH;
        let [low, high] = self.piece.colors;
        if model == OpticalModel::Absorption {
            integral.add_light(low * 0.0, depth);
            return;
        }
        let halves = self.halves();
        if is_deep {
            for half in halves {
                half.add(integral, halvings.saturating_sub(1));
                if integral.is_opaque() {
                    return;
                }
            }
            return;
        }
        let whole = self.emitted(absorbs);
        let [first, second] = halves.map(|half| half.emitted(absorbs));
        let [a, b, c, d] = halves[0].quarters();
        let passed = if absorbs {
            (-((a + b) + (c + d))).exp()
        } else {
            1.0
        };
        let both = [0, 1].map(|i| first[i] + passed * second[i]);
        let off = [0, 1].map(|i| (whole[i] - both[i]).abs());
        let off = off[0].max(off[1]);
        if off > AGREEMENT * depth && halvings > 0 {
            for half in halves {
                half.add(integral, halvings - 1);
            }
            return;
        }
        let share = both[0].clamp(0.0, both[1].max(0.0));
        integral.add_light((both[1] - share) * low + share * high, depth);
        integral.blur_by(2.0 * off * low.max(high).max_element());
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::grid::coverage::covered;
    use tetrascope_core::{Appearance, Knot, TransferFunction};

    use super::super::cue::NO_CUE;
    use super::*;

    fn look(knots: &[(f64, f64, f64)], model: OpticalModel) -> Look {
        let knots = knots.iter().map(|&(scalar, color, extinction)| Knot {
            scalar,
            color: DVec3::new(color, 1.0 - color, 0.5),
            extinction,
        });
        let function = TransferFunction::new(knots.collect()).expect("sorted");
        Look::new(&Appearance::new(function, model), [0.0; 4])
    }

    /// Slopes, a step, and what is clear.
    const KNOTS: [(f64, f64, f64); 6] = [
        (-0.5, 0.2, 0.0),
        (0.1, 0.9, 3.0),
        (0.1, 0.4, 0.5),
        (0.3, 0.4, 0.0),
        (0.4, 0.8, 0.0),
        (0.7, 0.1, 4.0),
    ];

    const WAY: Way = Way {
        entry: [0.0, 0.2, 0.9],
        exit: [1.0, 0.85, 0.1],
        length: 0.7,
    };

    fn gathered(look: &Look, cell: &CoveredCell, way: &Way, cue: Cue) -> (DVec3, f64, f64) {
        let mut integral = GridIntegral::new(look);
        cell.add(look, &mut integral, way, cue);
        (integral.light, integral.optical_depth(), integral.error())
    }

    // The same by steps straight from the definition, as midpoints. Without steps of the transfer
    // function light and depth bend by less than 100 per length of the cell, and so err by an
    // eighth of that times the step squared, at some ten bends; at a step by its height times
    // half a step.
    #[test]
    fn a_cell_is_what_the_definition_says() {
        let scalars = [-0.4, 0.8, 0.2, 0.35, f64::NAN, 0.05, 0.6, -0.2];
        let all = [
            [0.3, 1.0, 0.7, 0.0, 0.0, 0.9, 0.2, 1.0],
            [1.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0],
            [0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.25],
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ];
        const STEPS: u32 = 1 << 16;
        for coverage in all {
            let cell = CoveredCell::new(scalars, coverage).expect("something is there");
            for model in [
                OpticalModel::EmissionAbsorption,
                OpticalModel::Emission,
                OpticalModel::Absorption,
            ] {
                let cues = [NO_CUE, [0.9, 0.3]];
                let knots = [
                    (&KNOTS[..2], 1e-7),
                    (&KNOTS[..], 4.0 * 0.7 / f64::from(STEPS)),
                ];
                for (cue, (knots, bound)) in cues.into_iter().flat_map(|c| knots.map(|k| (c, k))) {
                    let look = look(knots, model);
                    let (mut light, mut depth) = (DVec3::ZERO, 0.0_f64);
                    for i in 0..STEPS {
                        let tau = (f64::from(i) + 0.5) / f64::from(STEPS);
                        let [entry, exit] = [WAY.entry, WAY.exit].map(DVec3::from_array);
                        let place = entry.lerp(exit, tau);
                        let Some(point) = covered(&scalars, &coverage, place) else {
                            continue;
                        };
                        let piece = look.pieces.get(look.pieces.find(point.scalar, true));
                        let part = point.coverage * piece.extinction(point.scalar) * WAY.length
                            / f64::from(STEPS);
                        let color = piece.color(point.scalar) * (cue[0] + tau * (cue[1] - cue[0]));
                        match model {
                            OpticalModel::Absorption => {}
                            OpticalModel::Emission => light += color * part,
                            _ => light += color * (-depth - 0.5 * part).exp() * part,
                        }
                        if model != OpticalModel::Emission {
                            depth += part;
                        }
                    }
                    let (found, found_depth, error) = gathered(&look, &cell, &WAY, cue);
                    let context = format!("{coverage:?} {model:?} {cue:?}");
                    let off = (found - light).abs().max_element();
                    assert!(off < bound, "{context}: {off:e}");
                    assert!((found_depth - depth).abs() < bound, "{context}");
                    assert!(error < 1e-12, "{context}: {error:e}");
                }
            }
        }
    }

    // One scalar, so one color: 1 − e^(−σ ∫ D), and D is a cubic whose mean is that of its
    // Bernstein coefficients.
    #[test]
    fn one_scalar_has_a_closed_form() {
        let coverage = [0.0, 0.5, 0.25, 1.0, 0.0, 0.0, 0.75, 0.125];
        let look = look(
            &[(0.0, 0.3, 5.0), (1.0, 0.7, 5.0)],
            OpticalModel::EmissionAbsorption,
        );
        let cell = CoveredCell::new([0.5; 8], coverage).expect("something is there");
        let mean = cell.coverage_on(&WAY).0.iter().sum::<f64>() / 4.0;
        let (light, depth, error) = gathered(&look, &cell, &WAY, NO_CUE);
        let truth = -(-5.0 * mean * WAY.length).exp_m1() * DVec3::splat(0.5);
        assert!(
            (light - truth).abs().max_element() < 1e-14,
            "{light} {truth}"
        );
        assert!((depth - 5.0 * mean * WAY.length).abs() < 1e-14);
        assert!(error < 1e-12, "{error:e}");
        assert!(CoveredCell::new([0.5; 8], [0.0; 8]).is_none());
    }

    // What is covered whole is what a cell without coverage is.
    #[test]
    fn covered_whole_is_not_covered_at_all() {
        let scalars = [-0.4, 0.8, 0.2, 0.35, 0.9, 0.05, 0.6, -0.2];
        let cell = CoveredCell::new(scalars, [1.0; 8]).expect("all is there");
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
            for length in [1e-6, 0.7, 30.0] {
                let look = look(&KNOTS, model);
                let way = Way { length, ..WAY };
                let (light, depth, error) = gathered(&look, &cell, &way, NO_CUE);
                let mut plain = GridIntegral::new(&look);
                let cubic = Cubic::trilinear(&scalars, way.entry, way.exit);
                plain.add(&cubic, length, NO_CUE);
                let off = (light - plain.light).abs().max_element();
                assert!(off < 1e-13 * length.max(1.0), "{model:?} {length}: {off:e}");
                assert!((depth - plain.optical_depth()).abs() < 1e-13 * length.max(1.0));
                assert!(error < 1e-12 * length.max(1.0), "{error:e}");
            }
        }
    }
}
