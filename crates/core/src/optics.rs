//! The volume rendering integral over one segment, and its composition.
//!
//! Every table and every shader is tested against this module. Sources: N. Max,
//! "Optical Models for Direct Volume Rendering", 1995; P. Williams, N. Max,
//! C. Stein, "A High Accuracy Volume Renderer for Unstructured Data", 1998;
//! K. Moreland, E. Angel, "A Fast High Accuracy Volume Renderer for
//! Unstructured Data", 2004.

mod weights;

use glam::DVec3;

use crate::transfer_function::{KnotPair, Side};
use crate::{OpticalModel, TransferFunction};

/// A piece of a ray on which the scalar varies linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The scalar at the end nearer to the eye.
    pub front: f64,
    /// The scalar at the farther end.
    pub back: f64,
    /// World units, 0 or more.
    pub length: f64,
}

/// How much of the front and back color a segment with linear extinction sends to the eye.
///
/// With a = σ_front l and b = σ_back l, the radiance of a segment whose color
/// goes linearly from c_f to c_b is c_f w_f + c_b w_b, where
/// w_f = ∫ (1−s)(a + (b−a)s) T ds, w_b = ∫ s (a + (b−a)s) T ds and
/// T(s) = exp(−(a s + (b−a) s²/2)), s from 0 to 1. w_f + w_b = 1 − e^(−(a+b)/2).
///
/// `a` and `b` are dimensionless, finite and 0 or more. Relative error ≤ 1e-12.
pub fn segment_weights(a: f64, b: f64) -> (f64, f64) {
    let w = weights::weights(a, b, weights::depth(a, b));
    let factor = (-w.shift).exp();
    (w.front * factor, w.back * factor)
}

/// Beyond this optical depth e^(−τ) is 0 in f64 (its smallest number is e^(−744.4…)),
/// so that nothing behind can be seen.
const OPAQUE: f64 = 746.0;

/// The factors of a segment without a depth cue.
const NO_CUE: [f64; 2] = [1.0; 2];

/// The value at the share `s` of the way from `ends[0]` to `ends[1]`, linearly.
fn mix(ends: [f64; 2], s: f64) -> f64 {
    ends[0] * (1.0 - s) + ends[1] * s
}

/// The light that a ray has gathered, front to back.
#[derive(Clone, Debug)]
pub struct RayIntegral<'a> {
    transfer_function: &'a TransferFunction,
    model: OpticalModel,
    /// The transfer function's interval in which the last segment ended, where
    /// the next is likely to be. It has no influence on the result.
    interval: usize,
    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`; with a
    /// depth cue, of c times its factor.
    light: DVec3,
    /// ∫ σ dt.
    optical_depth: CompensatedSum,
    /// Segments after splitting at knots, for the error bound.
    pieces: u64,
}

/// Light, linear RGB, and optical depth of one segment; see [`RayIntegral`].
pub fn integrate_segment(
    transfer_function: &TransferFunction,
    model: OpticalModel,
    segment: &Segment,
) -> (DVec3, f64) {
    let mut ray = RayIntegral::new(transfer_function, model);
    ray.add(segment);
    (ray.light(), ray.optical_depth())
}

impl<'a> RayIntegral<'a> {
    /// A ray that has met nothing.
    pub fn new(transfer_function: &'a TransferFunction, model: OpticalModel) -> Self {
        RayIntegral {
            transfer_function,
            model,
            interval: 0,
            light: DVec3::ZERO,
            optical_depth: CompensatedSum::default(),
            pieces: 0,
        }
    }

    /// Adds the next segment, behind all that were added before.
    ///
    /// A segment with a scalar that is not finite is transparent, and one that has no
    /// length adds nothing. In `MaximumIntensity` it does if its scalar changes: a layer without
    /// thickness is what thin layers tend to. Where the scalar is constant and on a step of the
    /// transfer function, both sides count half ([`TransferFunction::sample`]).
    #[inline]
    pub fn add(&mut self, segment: &Segment) {
        self.add_cued(segment, NO_CUE);
    }

    /// Adds the next segment, whose color is multiplied by a factor that goes linearly
    /// from `cue[0]` at its front to `cue[1]` at its back: a depth cue.
    #[inline]
    pub fn add_cued(&mut self, segment: &Segment, cue: [f64; 2]) {
        let &Segment {
            front,
            back,
            length,
        } = segment;
        let is_layer = self.model == OpticalModel::MaximumIntensity && front != back;
        let shows = length > 0.0 || (length == 0.0 && is_layer);
        if !(shows && front.is_finite() && back.is_finite()) {
            return;
        }
        // An infinite length times no extinction would be NaN.
        let length = length.min(f64::MAX);
        let interval = self.transfer_function.intervals().get(self.interval);
        let (low, high) = (interval.low, interval.high);
        let inside = if front == back {
            low < front && front < high
        } else {
            low <= front && front <= high && low <= back && back <= high
        };
        if inside {
            let ends = [interval.sample(front), interval.sample(back)];
            self.add_piece(interval.clear, ends, length, cue);
        } else {
            self.add_elsewhere(front, back, length, cue);
        }
    }

    /// Adds a segment that is not, or not wholly, in the current interval.
    fn add_elsewhere(&mut self, front: f64, back: f64, length: f64, cue: [f64; 2]) {
        let intervals = self.transfer_function.intervals();
        if front == back {
            let below = intervals.find(front, Side::Below);
            let above = intervals.find(front, Side::Above);
            self.interval = above;
            let (below, above) = (intervals.get(below), intervals.get(above));
            let (b, a) = (below.sample(front), above.sample(front));
            let mean = (0.5 * (b.0 + a.0), 0.5 * (b.1 + a.1));
            return self.add_piece(below.clear && above.clear, [mean; 2], length, cue);
        }
        // Each piece is as long as its share of the scalars, taken from given
        // numbers; lengths from differences of positions would lose the digits
        // of the short ones. The halves do not overflow.
        let scale = if (back - front).is_finite() { 1.0 } else { 0.5 };
        let whole = (scale * back - scale * front).abs();
        let share = |from: f64, to: f64| (scale * to - scale * from).abs() / whole;
        let rising = front < back;
        let mut index = intervals.find(front, if rising { Side::Above } else { Side::Below });
        let mut from = front;
        loop {
            let interval: &KnotPair = intervals.get(index);
            let to = if rising {
                back.min(interval.high)
            } else {
                back.max(interval.low)
            };
            let ends = [interval.sample(from), interval.sample(to)];
            let cue = if cue == NO_CUE {
                NO_CUE
            } else {
                [from, to].map(|scalar| mix(cue, share(front, scalar)))
            };
            self.add_piece(interval.clear, ends, length * share(from, to), cue);
            if to == back {
                break;
            }
            index = if rising { index + 1 } else { index - 1 };
            from = to;
        }
        self.interval = index;
    }

    /// Adds a segment on which color, extinction and cue are linear between their ends.
    #[inline]
    fn add_piece(&mut self, clear: bool, ends: [(DVec3, f64); 2], length: f64, cue: [f64; 2]) {
        if cue != NO_CUE {
            return self.add_cued_piece(clear, ends, length, cue);
        }
        let [(front, front_extinction), (back, back_extinction)] = ends;
        self.pieces += 1;
        if self.model == OpticalModel::MaximumIntensity {
            self.light = self.light.max(front).max(back);
            return;
        }
        if clear {
            return;
        }
        let a = front_extinction * length;
        let b = back_extinction * length;
        match self.model {
            OpticalModel::EmissionAbsorption => {
                let before = self.optical_depth.value();
                let m = weights::depth(a, b);
                self.optical_depth.add(m);
                if before < OPAQUE {
                    let w = weights::weights(a, b, m);
                    let transmittance = (-(before + w.shift)).exp();
                    self.light += transmittance * (w.front * front + w.back * back);
                }
            }
            OpticalModel::Emission => {
                // Simpson's rule, exact for the product of linear functions;
                // no 2 a + b, which may overflow.
                let third = (a / 3.0 + b / 6.0, a / 6.0 + b / 3.0);
                self.light += third.0 * front + third.1 * back;
            }
            OpticalModel::Absorption => self.optical_depth.add(weights::depth(a, b)),
            OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => {}
        }
    }

    /// Adds a piece whose color, times its cue, is a parabola:
    /// q(s) = q_f (1 − s) + q_b s + κ s (1 − s), κ = −Δc Δcue.
    fn add_cued_piece(&mut self, clear: bool, ends: [(DVec3, f64); 2], length: f64, cue: [f64; 2]) {
        let [(front, front_extinction), (back, back_extinction)] = ends;
        let kappa = (front - back) * (cue[1] - cue[0]);
        let (q_front, q_back) = (front * cue[0], back * cue[1]);
        if self.model == OpticalModel::MaximumIntensity {
            self.pieces += 1;
            self.light = self.light.max(q_front).max(q_back);
            for channel in 0..3 {
                // Where the parabola's slope, q_b − q_f + κ (1 − 2 s), is 0.
                let k = kappa[channel];
                let top = 0.5 + 0.5 * (q_back[channel] - q_front[channel]) / k;
                if k > 0.0 && (0.0..=1.0).contains(&top) {
                    let value = q_front[channel] * (1.0 - top)
                        + q_back[channel] * top
                        + k * top * (1.0 - top);
                    self.light[channel] = self.light[channel].max(value);
                }
            }
            return;
        }
        if clear {
            return;
        }
        let a = front_extinction * length;
        let b = back_extinction * length;
        let m = weights::depth(a, b);
        match self.model {
            // Beyond any scale at which something could show.
            OpticalModel::EmissionAbsorption if m > 1e40 => {
                self.pieces += 1;
                self.light += (-self.optical_depth.value()).exp() * q_front;
                self.optical_depth.add(m);
            }
            OpticalModel::EmissionAbsorption if m > 1.0 => {
                // Halves, the front one first; behind OPAQUE nothing is left to do.
                let middle = (
                    0.5 * (front + back),
                    0.5 * (front_extinction + back_extinction),
                );
                let half = mix(cue, 0.5);
                self.add_cued_piece(clear, [ends[0], middle], 0.5 * length, [cue[0], half]);
                if self.is_opaque() {
                    self.optical_depth
                        .add(weights::depth(0.5 * (a + b), b) * 0.5);
                } else {
                    self.add_cued_piece(clear, [middle, ends[1]], 0.5 * length, [half, cue[1]]);
                }
            }
            OpticalModel::EmissionAbsorption => {
                self.pieces += 1;
                let before = self.optical_depth.value();
                self.optical_depth.add(m);
                if before < OPAQUE {
                    let w = weights::weights(a, b, m);
                    let transmittance = (-(before + w.shift)).exp();
                    self.light += transmittance * (w.front * q_front + w.back * q_back);
                    self.light += (-before).exp() * weights::bulge(a, b) * kappa;
                }
            }
            OpticalModel::Emission => {
                self.pieces += 1;
                // Simpson's rule, exact for the product of a parabola and a line.
                let third = (a / 3.0 + b / 6.0, a / 6.0 + b / 3.0);
                self.light += third.0 * q_front + third.1 * q_back + m / 6.0 * kappa;
            }
            OpticalModel::Absorption => {
                self.pieces += 1;
                self.optical_depth.add(m);
            }
            OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => {}
        }
    }

    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`, linear RGB.
    pub fn light(&self) -> DVec3 {
        self.light
    }

    /// ∫ σ dt, dimensionless; 0 where the model does not absorb.
    pub fn optical_depth(&self) -> f64 {
        self.optical_depth.value()
    }

    /// Whether nothing behind can change the light or the pixel, as T is 0 in f64.
    pub fn is_opaque(&self) -> bool {
        self.optical_depth() >= OPAQUE
    }

    /// A bound on the rounding error of every channel of [`RayIntegral::over`]
    /// for these very segments and a background of at most 1.
    ///
    /// With n pieces after splitting at knots, ε = 2⁻⁵³ and c the greatest color:
    /// - Extinction is sampled within 4 ε, a piece's length within 4 ε, their
    ///   product and the trapezoid add 2 ε, the compensated sum 2 ε and the
    ///   argument of the exponential 2 ε: σ dt is off by η ≤ 14 ε, relative.
    /// - The light is ∫ c e^(−τ) dτ, so η changes it by at most
    ///   η c ∫ (1 + τ) e^(−τ) dτ = 2 η c, however many pieces there are, and T by
    ///   η τ e^(−τ) ≤ η / e.
    /// - The weights are within 20 ε (measured, `exact_values.csv`), color within
    ///   4 ε, exponential and products within 6 ε: at most 30 ε c in all, as the
    ///   weights times T sum to α ≤ 1.
    /// - The plain sum of n non-negative terms adds at most n ε of itself.
    ///
    /// 28 + 30 for the light and 14/e + 2 for T and the background stay below 96. A
    /// depth cue adds 8 ε for its factors, of which κ takes no more than c, and 4 ε for
    /// the bulge's weight.
    pub fn rounding_bound(&self) -> f64 {
        const FIXED: f64 = 96.0;
        let n = self.pieces as f64;
        let light = self.light.max_element();
        let relative = 0.5 * f64::EPSILON;
        match self.model {
            OpticalModel::EmissionAbsorption => {
                let color = self
                    .transfer_function
                    .max_color(f64::NEG_INFINITY, f64::INFINITY);
                relative * (n + FIXED) * color.max(1.0)
            }
            // No cancellation anywhere: relative to the result.
            OpticalModel::Emission => relative * (n + FIXED) * light.max(1.0),
            OpticalModel::Absorption
            | OpticalModel::MaximumIntensity
            | OpticalModel::Isosurfaces => relative * FIXED * light.max(1.0),
        }
    }

    /// The pixel: premultiplied linear RGBA over a premultiplied `background`.
    pub fn over(&self, background: [f64; 4]) -> [f64; 4] {
        over(self.model, self.light, self.optical_depth(), background)
    }
}

/// The pixel that `light` seen through `optical_depth` makes before a
/// premultiplied `background`; see [`OpticalModel`].
pub fn over(
    model: OpticalModel,
    light: DVec3,
    optical_depth: f64,
    background: [f64; 4],
) -> [f64; 4] {
    let [r, g, b, alpha] = background;
    let behind = DVec3::new(r, g, b);
    let transmittance = (-optical_depth).exp();
    // 1 − T (1 − α) without the cancellation at small depths.
    let covered = -(-optical_depth).exp_m1() + transmittance * alpha;
    let (color, alpha) = match model {
        OpticalModel::EmissionAbsorption => (light + transmittance * behind, covered),
        OpticalModel::Emission => (light + behind, alpha),
        OpticalModel::Absorption => (transmittance * behind, covered),
        OpticalModel::MaximumIntensity => (light.max(behind), alpha),
        // Opaque where a surface was met, by an infinite depth.
        OpticalModel::Isosurfaces => (light + transmittance * behind, covered),
    };
    [color.x, color.y, color.z, alpha]
}

/// A sum whose error does not grow with the number of terms (Neumaier 1974).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    sum: f64,
    compensation: f64,
}

impl CompensatedSum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.compensation += if self.sum.abs() >= term.abs() {
            (self.sum - sum) + term
        } else {
            (term - sum) + self.sum
        };
        self.sum = sum;
    }

    /// The sum so far; infinite once a term is, or the sum overflows.
    pub fn value(&self) -> f64 {
        // The compensation of an infinite sum is NaN.
        if self.sum.is_finite() {
            self.sum + self.compensation
        } else {
            self.sum
        }
    }
}

#[cfg(test)]
mod tests;
