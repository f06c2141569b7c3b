//! The integral over the cells of one ray, each a cubic, and its error bound.

use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::CompensatedSum;
use tetrascope_core::{Appearance, ClipPlane, OpticalModel};

use super::cubic::{Cubic, Monotone};
use super::cue::{self, Cue, NO_CUE};
use super::pieces::{Piece, Pieces, Step};
use super::quadrature::{LARGEST_DEPTH, rule};

/// Behind this optical depth T is below 2e-28 and no bit of a sum near 1 changes.
const OPAQUE: f64 = 64.0;

/// The unit roundoff u.
const UNIT: f64 = f64::EPSILON / 2.0;

/// Facts that all rays of an image share.
#[derive(Clone, Debug)]
pub(crate) struct Look {
    pub(crate) model: OpticalModel,
    pub(crate) pieces: Pieces,
    pub(crate) clip_planes: Vec<ClipPlane>,
    /// The greatest of all colors, of the background's channels and 1.
    pub(crate) brightest: f64,
    /// The greatest extinction of all, per world unit.
    pub(crate) densest: f64,
}

impl Look {
    /// `background` is premultiplied.
    pub(crate) fn new(appearance: &Appearance, background: [f64; 4]) -> Look {
        let knots = appearance.transfer_function.knots();
        let colors = knots.iter().map(|k| k.color.max_element());
        Look {
            model: appearance.optical_model,
            pieces: Pieces::new(&appearance.transfer_function),
            clip_planes: appearance.clip_planes.clone(),
            brightest: colors.chain(background).fold(1.0, f64::max),
            densest: knots.iter().map(|k| k.extinction).fold(0.0, f64::max),
        }
    }

    /// Whether scalars in [low, high] leave no trace.
    pub(crate) fn is_clear(&self, low: f64, high: f64) -> bool {
        self.model != OpticalModel::MaximumIntensity
            && self.pieces.touched(low, high).iter().all(Piece::is_clear)
    }
}

/// The light that a ray has gathered, front to back.
///
/// # Error
/// With u = 2⁻⁵³ and C the greatest color, besides what wrong scalars do
/// ([`GridIntegral::blur`]):
/// - The extinction's Bernstein coefficients are good to 32 u of the greatest, which for
///   a cubic that is nowhere negative is at most 8 of its means: each optical depth is
///   good to η = 256 u of itself, the exponent under the integral too, and that changes
///   the light by at most 2 η C and T by η/e, as in `RayIntegral::rounding_bound`.
/// - The quadrature's weights are good to 3e-14 < 300 u of each part's opacity, and the
///   opacities times T before sum to at most 1.
/// - Colors, exponentials and products add 32 u C, and the plain sum of n parts n u of itself.
///
/// Together less than (n + 1024) u C. With a depth cue two quadratures with such weights
/// take the place of one and of an opacity, 600 u C more, and its factors, rounded 4 times,
/// are in [0, 1]: less than (n + 2048) u C; see [`GridIntegral::blur_cue`] for the rest.
#[derive(Clone, Debug)]
pub(crate) struct GridIntegral<'a> {
    look: &'a Look,
    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`.
    pub(crate) light: DVec3,
    depth: CompensatedSum,
    /// Parts of cells that were integrated.
    parts: u64,
    /// A bound on what wrong scalars and positions do.
    error: f64,
    /// How far the cue's factors may be off.
    cue_error: f64,
}

impl<'a> GridIntegral<'a> {
    pub(crate) fn new(look: &'a Look) -> GridIntegral<'a> {
        GridIntegral {
            look,
            light: DVec3::ZERO,
            depth: CompensatedSum::default(),
            parts: 0,
            error: 0.0,
            cue_error: 0.0,
        }
    }

    /// ∫ σ dt, dimensionless; 0 where the model does not absorb.
    pub(crate) fn optical_depth(&self) -> f64 {
        self.depth.value()
    }

    /// The optical model.
    pub(crate) fn model(&self) -> OpticalModel {
        self.look.model
    }

    /// Adds a part of this optical depth, and of this light where nothing is before it.
    pub(crate) fn add_light(&mut self, light: DVec3, depth: f64) {
        self.parts += 1;
        match self.look.model {
            OpticalModel::Emission => {
                self.light += light;
                // Without the cue it would be this bright at most.
                self.error += self.look.brightest * depth * self.cue_error;
            }
            OpticalModel::EmissionAbsorption => {
                self.light += (-self.depth.value()).exp() * light;
                self.depth.add(depth);
            }
            _ => self.depth.add(depth),
        }
    }

    /// Adds to the error bound.
    pub(crate) fn blur_by(&mut self, error: f64) {
        self.error += error;
    }

    /// Whether nothing behind can be seen.
    pub(crate) fn is_opaque(&self) -> bool {
        self.optical_depth() > OPAQUE
    }

    /// Adds the next cell: the scalar on its way, the way's length in world units, and the
    /// depth cue's factors at its ends.
    ///
    /// Where the scalar is constant and on a step, both sides count half, as in
    /// [`TransferFunction::sample`](tetrascope_core::TransferFunction::sample).
    pub(crate) fn add(&mut self, cubic: &Cubic, length: f64, cue: Cue) {
        let [b0, b1, b2, b3] = cubic.0;
        if b0 == b1 && b1 == b2 && b2 == b3 {
            return self.add_constant(b0, length, cue);
        }
        for part in cubic.monotone() {
            let cue = cue::part(cue, part.from, part.to);
            self.add_monotone(&part, length * (part.to - part.from), cue);
        }
    }

    fn add_constant(&mut self, scalar: f64, length: f64, cue: Cue) {
        let pieces = [false, true].map(|rising| {
            let pieces = &self.look.pieces;
            pieces.get(pieces.find(scalar, rising))
        });
        let colors = pieces.map(|p| p.color(scalar));
        let extinctions = pieces.map(|p| p.extinction(scalar));
        let mean = 0.5 * (extinctions[0] + extinctions[1]);
        let color = 0.5 * (colors[0] + colors[1]);
        self.parts += 1;
        match self.look.model {
            OpticalModel::MaximumIntensity => {
                self.light = self.light.max(color * cue[0].max(cue[1]));
            }
            OpticalModel::Emission | OpticalModel::EmissionAbsorption if cue != NO_CUE => {
                // As a part of one color and extinction.
                let uniform = Piece {
                    low: f64::NEG_INFINITY,
                    high: f64::INFINITY,
                    colors: [color; 2],
                    extinctions: [mean; 2],
                };
                self.add_part(&uniform, &Cubic([0.0; 4]), length, cue);
            }
            OpticalModel::Emission => self.light += color * (mean * length),
            _ => self.add_uniform(color, mean * length),
        }
    }

    /// Adds a part of one color and the optical depth `depth`.
    fn add_uniform(&mut self, color: DVec3, depth: f64) {
        if self.look.model == OpticalModel::EmissionAbsorption {
            let before = (-self.depth.value()).exp();
            self.light += before * -(-depth).exp_m1() * color;
        }
        self.depth.add(depth);
    }

    /// Splits a part where it crosses knots.
    fn add_monotone(&mut self, part: &Monotone, length: f64, cue: Cue) {
        let pieces = &self.look.pieces;
        let [front, back] = part.ends();
        let rising = front < back;
        let last = pieces.find(back, !rising);
        let mut index = pieces.find(front, rising);
        let (mut from, mut front) = (0.0, front);
        loop {
            let piece = pieces.get(index);
            let there = index == last || front == back;
            let (to, scalar) = if there {
                (1.0, back)
            } else {
                let knot = if rising { piece.high } else { piece.low };
                (part.place(knot).max(from), knot)
            };
            if self.look.model == OpticalModel::MaximumIntensity {
                if cue == NO_CUE {
                    for scalar in [front, scalar] {
                        self.light = self.light.max(piece.color(scalar));
                    }
                } else {
                    let mut cubic = part.cubic.part(from, to);
                    (cubic.0[0], cubic.0[3]) = (front, scalar);
                    self.add_greatest(piece, &cubic, cue::part(cue, from, to));
                }
                self.parts += 1;
            } else if to > from && !piece.is_clear() {
                // Rounding of the roots must not lead out of the piece.
                let mut cubic = part.cubic.part(from, to);
                cubic.0[0] = front;
                cubic.0[3] = scalar;
                let cue = cue::part(cue, from, to);
                self.add_part(piece, &cubic, length * (to - from), cue);
            }
            if there || self.is_opaque() {
                return;
            }
            (from, front) = (to, scalar);
            index = if rising { index + 1 } else { index - 1 };
        }
    }

    /// Adds a part on which color and extinction are linear in the scalar.
    fn add_part(&mut self, piece: &Piece, cubic: &Cubic, length: f64, cue: Cue) {
        let extinctions = cubic.0.map(|s| piece.extinction(s));
        let [a, b, c, d] = extinctions.map(|e| 0.25 * e * length);
        // The mean of Bernstein coefficients is the mean of the polynomial.
        let depth = ((a + b) + (c + d)).max(0.0);
        let uniform = piece.colors[0] == piece.colors[1];
        match self.look.model {
            OpticalModel::Emission => {
                self.parts += 1;
                let [high, all] = cue::emitted(piece, cubic, length, cue);
                self.light += (all - high) * piece.colors[0] + high * piece.colors[1];
                if cue != NO_CUE {
                    // Without the cue it would be this bright at most.
                    self.error += self.look.brightest * depth * self.cue_error;
                }
            }
            OpticalModel::EmissionAbsorption if !uniform || cue != NO_CUE => {
                if depth > LARGEST_DEPTH {
                    let cues = [cue::part(cue, 0.0, 0.5), cue::part(cue, 0.5, 1.0)];
                    for (half, cue) in cubic.split(0.5).iter().zip(cues) {
                        self.add_part(piece, half, 0.5 * length, cue);
                        if self.is_opaque() {
                            return;
                        }
                    }
                    return;
                }
                self.parts += 1;
                let before = (-self.depth.value()).exp();
                let opacity = -(-depth).exp_m1();
                let [high, all] = match cue {
                    NO_CUE => [absorbed(piece, cubic, &[a, b, c, d], depth), opacity],
                    _ => cue::absorbed(piece, cubic, &[a, b, c, d], depth, cue),
                };
                let all = all.clamp(0.0, opacity);
                let high = high.clamp(0.0, all);
                self.light += before * ((all - high) * piece.colors[0] + high * piece.colors[1]);
                self.depth.add(depth);
            }
            _ => {
                self.parts += 1;
                self.add_uniform(piece.colors[0], depth);
            }
        }
    }

    /// The greatest color of a part times its cue, channel by channel.
    fn add_greatest(&mut self, piece: &Piece, cubic: &Cubic, cue: Cue) {
        for channel in 0..3 {
            let colors = piece.colors.map(|c| c[channel]);
            let most = cue::greatest(piece, cubic, colors, cue);
            self.light[channel] = self.light[channel].max(most);
        }
    }

    /// Says that the cue's factors may be off by `error`, before any cell is added.
    ///
    /// The light is at most C times the opacity, or the greatest color, before the cue.
    pub(crate) fn blur_cue(&mut self, error: f64) {
        self.cue_error = error;
        if self.look.model != OpticalModel::Emission {
            self.error += self.look.brightest * error;
        }
    }

    /// Adds to the error bound what a scalar that is off by `blur` does in a cell whose
    /// scalars lie in [low, high].
    ///
    /// L = ∫ c σ T dt + T B changes by at most ∫ (σ |δc| + C |δσ|) dt, to first order:
    /// (C max|dσ/ds| + max σ max|dc/ds|) l δs where color and extinction are linear, and
    /// for a step its height times the length on which the scalar is within δs of it.
    /// The greatest color moves by max|dc/ds| δs, and by a step that an extreme touches.
    pub(crate) fn blur(&mut self, cubic: &Cubic, length: f64, range: [f64; 2], blur: f64) {
        let [low, high] = [range[0] - blur, range[1] + blur];
        let look = self.look;
        let (mut extinction, mut rise, mut shift) = (0.0f64, 0.0f64, 0.0f64);
        for piece in look.pieces.touched(low, high) {
            let slopes = piece.slopes();
            extinction = extinction.max(piece.extinctions[0].max(piece.extinctions[1]));
            (rise, shift) = (rise.max(slopes.0), shift.max(slopes.1));
        }
        let c = look.brightest;
        if look.model == OpticalModel::MaximumIntensity {
            // A step counts for its colors where it is crossed; only an extreme that
            // nearly touches it may or may not.
            let near = |step: &&Step| {
                let mut ends = cubic.monotone().flat_map(|part| part.ends());
                ends.any(|end| (end - step.scalar).abs() <= blur)
            };
            let steps = look.pieces.steps(low, high).iter().filter(near);
            let steps: f64 = steps.map(|s| s.color).sum();
            self.error = self.error.max(shift * blur + steps);
            return;
        }
        self.error += (c * rise + extinction * shift) * length * blur;
        for step in look.pieces.steps(low, high) {
            let height = c * step.extinction + extinction * step.color;
            let mut near = 0.0;
            for part in cubic.monotone() {
                let ends = [step.scalar - blur, step.scalar + blur].map(|s| part.place(s));
                near += (ends[1] - ends[0]).abs() * (part.to - part.from);
            }
            // A constant has no place of its own.
            let [b0, _, _, b3] = cubic.0;
            if b0 == b3 && (b0 - step.scalar).abs() <= blur {
                near = 1.0;
            }
            self.error += height * near * length;
        }
    }

    /// Adds to the error bound that the volume may begin or end `t` world units elsewhere.
    pub(crate) fn blur_end(&mut self, t: f64) {
        if self.look.model != OpticalModel::MaximumIntensity {
            self.error += self.look.brightest * self.look.densest * t;
        }
    }

    /// A bound on the absolute error of every channel of the pixel.
    pub(crate) fn error(&self) -> f64 {
        let rounding = (self.parts as f64 + 2048.0) * UNIT;
        let scale = match self.look.model {
            OpticalModel::Emission => self.look.brightest.max(self.light.max_element()),
            _ => self.look.brightest,
        };
        let opaque = if self.is_opaque() { 1e-27 } else { 0.0 };
        self.error + (rounding + opaque) * scale
    }
}

/// ∫ x σ l e^(−∫σ l) dτ over a part, where x is the scalar's share of the piece and
/// `quarters` are the Bernstein coefficients of σ l / 4, whose sum is `depth`.
fn absorbed(piece: &Piece, cubic: &Cubic, quarters: &[f64; 4], depth: f64) -> f64 {
    let [a, b, c, _] = *quarters;
    // ∫₀^τ of a cubic is the quartic whose Bernstein coefficients are the partial sums.
    let sums = [0.0, a, a + b, (a + b) + c, depth];
    let share = power(cubic.0.map(|s| piece.shares(s)[0]));
    let extinction = power(quarters.map(|q| 4.0 * q));
    let exponent = quartic_power(sums);
    let mut sum = 0.0;
    for &(tau, weight) in rule(depth) {
        let value = horner(&share, tau) * horner(&extinction, tau);
        sum += weight * value * (-horner(&exponent, tau)).exp();
    }
    sum
}

/// Power coefficients of a cubic in Bernstein form.
pub(crate) fn power([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let [p, q, r] = [b - a, c - b, d - c];
    [a, 3.0 * p, 3.0 * (q - p), (r - q) - (q - p)]
}

/// Power coefficients of a quartic in Bernstein form.
pub(crate) fn quartic_power(b: [f64; 5]) -> [f64; 5] {
    let first = [0, 1, 2, 3].map(|i| b[i + 1] - b[i]);
    let second = [0, 1, 2].map(|i| first[i + 1] - first[i]);
    let third = [0, 1].map(|i| second[i + 1] - second[i]);
    [
        b[0],
        4.0 * first[0],
        6.0 * second[0],
        4.0 * third[0],
        third[1] - third[0],
    ]
}

pub(crate) fn horner(coefficients: &[f64], tau: f64) -> f64 {
    let terms = coefficients.iter().rev();
    terms.fold(0.0, |sum, coefficient| sum * tau + coefficient)
}

#[cfg(test)]
mod tests {
    use tetrascope_core::{Knot, TransferFunction};

    use super::*;

    /// Scalars from 0 to 1, color and extinction too.
    fn look(extinction: f64) -> Look {
        let knot = |scalar: f64| Knot {
            scalar,
            color: DVec3::splat(scalar),
            extinction: extinction * scalar,
        };
        let transfer_function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid");
        let appearance = Appearance::new(transfer_function, OpticalModel::EmissionAbsorption);
        Look::new(&appearance, [0.0; 4])
    }

    /// Monotone cubics of all shapes with values in [0, 1].
    fn shapes() -> Vec<Cubic> {
        let mut shapes = vec![
            Cubic([0.0, 0.0, 0.0, 1.0]),
            Cubic([0.0, 0.0, 1.0, 1.0]),
            Cubic([0.0, 1.0, 1.0, 1.0]),
            Cubic([0.0, 1.0, 0.0, 1.0]),
            Cubic([0.5, 0.5, 0.5, 0.6]),
        ];
        for i in 0..11 {
            // (τ − c)³, shifted and scaled to [0, 1].
            let c = f64::from(i) / 10.0;
            let (low, high) = (-c * c * c, (1.0 - c).powi(3));
            let blossom = [
                -c * c * c,
                c * c * (1.0 - c),
                -c * (1.0 - c) * (1.0 - c),
                high,
            ];
            shapes.push(Cubic(blossom.map(|b| (b - low) / (high - low))));
        }
        let falling: Vec<Cubic> = shapes
            .iter()
            .map(|s| Cubic([s.0[3], s.0[2], s.0[1], s.0[0]]))
            .collect();
        shapes.extend(falling);
        shapes
    }

    // The same over 4096 parts so thin that the 6-point rule is exact; their sum is
    // rounded 4096 times, 5e-13 at most and 1e-14 as a rule.
    #[test]
    fn rules_are_as_exact_as_they_say() {
        for shape in shapes() {
            let mean = shape.0.iter().sum::<f64>() / 4.0;
            for depth in [1e-6, 1e-5, 1e-4, 1e-3, 0.02, 0.03, 0.2, 0.25, 0.6, 1.0, 7.0] {
                let look = look(depth / mean);
                let mut whole = GridIntegral::new(&look);
                whole.add(&shape, 1.0, NO_CUE);
                let mut fine = GridIntegral::new(&look);
                for i in 0..4096 {
                    let at = |i: i32| f64::from(i) / 4096.0;
                    fine.add(&shape.part(at(i), at(i + 1)), 1.0 / 4096.0, NO_CUE);
                }
                let off = (whole.light.x - fine.light.x).abs() / depth;
                assert!(off < 5e-14, "{shape:?} {depth}: {off:e}");
                let off = (whole.optical_depth() / depth - 1.0).abs();
                assert!(off < 1e-14, "{shape:?} {depth}: {off:e}");
            }
        }
    }

    // Extinctions of any size end, and what is opaque has the front's color.
    #[test]
    fn huge_extinctions_show_the_front() {
        for extinction in [1e3, 1e9, 1e100, 1e300, f64::MAX] {
            let look = look(extinction);
            for (shape, front) in [
                (Cubic([0.5, 0.6, 0.8, 1.0]), 0.5),
                (Cubic([1.0, 0.9, 0.2, 0.1]), 1.0),
                (Cubic([0.3; 4]), 0.3),
            ] {
                let mut integral = GridIntegral::new(&look);
                integral.add(&shape, 1e9, NO_CUE);
                // The scalar moves by at most 3 over the length, and light comes from a
                // depth of 1/(σ l) of it.
                let off = (integral.light.x - front).abs();
                assert!(
                    off < 10.0 / extinction / 1e9 + 1e-15,
                    "{extinction:e} {shape:?} {off:e}"
                );
            }
        }
    }

    // A tent over a straight way, then the same over a way that turns back in it.
    #[test]
    fn a_touch_is_harmless() {
        let knots = [(0.0, 0.0), (0.5, 0.0), (0.5, 8.0), (1.0, 8.0)];
        let knots = knots.map(|(scalar, extinction)| Knot {
            scalar,
            color: DVec3::ONE,
            extinction,
        });
        let transfer_function = TransferFunction::new(knots.to_vec()).expect("valid");
        let appearance = Appearance::new(transfer_function, OpticalModel::Absorption);
        let look = Look::new(&appearance, [0.0; 4]);
        // 0.5 + e − (2 τ − 1)², greatest in the middle, above 0.5 on a length of √e.
        for e in [1e-2, 1e-6, 1e-12, 1e-15, 0.0, -1e-15, -1e-3] {
            let ends = e - 0.5;
            let cubic = Cubic([ends, ends + 4.0 / 3.0, ends + 4.0 / 3.0, ends]);
            let mut integral = GridIntegral::new(&look);
            integral.add(&cubic, 1.0, NO_CUE);
            let depth = 8.0 * f64::max(e, 0.0).sqrt();
            // The scalar is off by 4 u, so the length by √e − √(e − 4 u) ≤ √(4 u).
            let off = (integral.optical_depth() - depth).abs();
            assert!(off <= 8.0 * 2.2e-8, "{e:e}: {off:e}");
            let mut bound = GridIntegral::new(&look);
            bound.blur(&cubic, 1.0, [ends, 0.5 + e], 8.0 * UNIT);
            assert!(off <= bound.error(), "{e:e}: {off:e} {:e}", bound.error());
        }
    }
}
