//! The light that a piece of a ray adds, in every optical model: the counterpart in vectors of
//! `tetrascope_core::optics`, whose docs have the integral.
//!
//! Williams, Max, Stein 1998. In their terms: a and b are the extinctions at a piece's front and
//! back times its length, m = (a + b)/2 its optical depth.

use fearless_simd::prelude::*;
use tetrascope_core::OpticalModel;

use crate::simd::each;

/// `OpticalModel`, in its order, as what kernels are compiled for.
pub(super) const EMISSION_ABSORPTION: u8 = 0;
pub(super) const EMISSION: u8 = 1;
pub(super) const ABSORPTION: u8 = 2;
pub(super) const MAXIMUM_INTENSITY: u8 = 3;
pub(super) const ISOSURFACES: u8 = 4;

/// The number of a model.
pub(super) fn number(model: OpticalModel) -> u8 {
    match model {
        OpticalModel::EmissionAbsorption => EMISSION_ABSORPTION,
        OpticalModel::Emission => EMISSION,
        OpticalModel::Absorption => ABSORPTION,
        OpticalModel::MaximumIntensity => MAXIMUM_INTENSITY,
        _ => ISOSURFACES,
    }
}

/// The light that rays have gathered, front to back.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gathered<S: Simd> {
    /// Light; the optical depth in the first where only that is gathered; the greatest color.
    pub(super) light: [S::f32s; 3],
    pub(super) transmittance: S::f32s,
    /// The part that roundings took from it: many clear cells would add up (Kahan 1965).
    pub(super) lost: S::f32s,
}

/// A piece on which color and extinction are linear: in one interval of the transfer function.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<S: Simd> {
    /// At the interval's lower end, RGB.
    pub(super) base: [S::f32s; 3],
    /// How much more at its upper end.
    pub(super) more: [S::f32s; 3],
    /// Where front and back are between the two.
    pub(super) at: [S::f32s; 2],
    /// Extinction times length at front and back.
    pub(super) ends: [S::f32s; 2],
    /// The depth cue there.
    pub(super) cue: [S::f32s; 2],
    /// Pieces without length add nothing, in `MAXIMUM_INTENSITY` neither.
    pub(super) is_there: S::mask32s,
}

/// Behind so many parts of optical depth 1 nothing is left: e⁻²⁴ is 2⁻³⁴.
const OPAQUE: u32 = 24;

/// Extinctions times a length, beyond which nothing changes but squares overflow.
const DENSEST: f32 = 1e18;

impl<S: Simd> Gathered<S> {
    /// Adds a piece behind all that were added before.
    #[inline(always)]
    pub(super) fn add<const MODEL: u8>(&mut self, simd: S, piece: &Piece<S>, cued: bool) {
        let splat = |value: f32| S::f32s::splat(simd, value);
        let [a, b] = piece.ends;
        match MODEL {
            EMISSION_ABSORPTION => {
                if cued {
                    self.absorb_cued(simd, piece);
                } else if (a + b).simd_gt(splat(2.0)).any_true() {
                    self.absorb_parts(simd, piece);
                } else {
                    self.absorb(simd, piece, piece.at, piece.ends);
                }
            }
            EMISSION => {
                // Simpson's rule, exact for the product of two linear functions.
                let front = a.mul_add(splat(1.0 / 3.0), b * splat(1.0 / 6.0));
                let back = b.mul_add(splat(1.0 / 3.0), a * splat(1.0 / 6.0));
                if cued {
                    let bulge = (a + b) * splat(1.0 / 12.0);
                    self.add_cued_light(
                        piece,
                        splat(1.0),
                        [front, back, bulge],
                        piece.at,
                        piece.cue,
                    );
                } else {
                    self.add_light(
                        piece,
                        front + back,
                        front * piece.at[0] + back * piece.at[1],
                    );
                }
            }
            ABSORPTION => self.light[0] += (a + b) * splat(0.5),
            MAXIMUM_INTENSITY => {
                for i in 0..3 {
                    let [front, back] = each!([0, 1], end => {
                        piece.more[i].mul_add(piece.at[end], piece.base[i])
                    });
                    let most = match cued {
                        true => greatest_cued(simd, [front, back], piece.cue),
                        false => front.max(back),
                    };
                    let most = self.light[i].max(most);
                    self.light[i] = piece.is_there.select(most, self.light[i]);
                }
            }
            _ => {}
        }
    }

    /// Adds the interval's lower color `weight` times, and the difference to its upper one
    /// `more` times.
    #[inline(always)]
    fn add_light(&mut self, piece: &Piece<S>, weight: S::f32s, more: S::f32s) {
        for i in 0..3 {
            let light = piece.base[i].mul_add(weight, self.light[i]);
            self.light[i] = piece.more[i].mul_add(more, light);
        }
    }

    /// Absorbs `alpha` of the light behind.
    #[inline(always)]
    fn dim(&mut self, transmittance: S::f32s, alpha: S::f32s) {
        let taken = transmittance * alpha;
        let left = self.transmittance - taken;
        self.lost = (self.lost - self.lost * alpha) + ((self.transmittance - left) - taken);
        self.transmittance = left;
    }

    /// A part of a piece with optical depth 1 at most.
    #[inline(always)]
    fn absorb(&mut self, simd: S, piece: &Piece<S>, at: [S::f32s; 2], ends: [S::f32s; 2]) {
        let (alpha, back) = weights(simd, ends);
        let before = self.transmittance + self.lost;
        let more = (alpha - back).mul_add(at[0], back * at[1]);
        self.add_light(piece, before * alpha, before * more);
        self.dim(before, alpha);
    }

    /// In parts of optical depth 1, as [`weights`] wants.
    #[inline(always)]
    fn absorb_parts(&mut self, simd: S, piece: &Piece<S>) {
        let splat = |value: f32| S::f32s::splat(simd, value);
        let (zero, one) = (splat(0.0), splat(1.0));
        let [mut a, mut b] = each!([0, 1], i => piece.ends[i].min(splat(DENSEST)));
        let mut at = piece.at[0];
        for part in 0..=OPAQUE {
            let is_last = (a + b).simd_le(splat(2.0));
            // a s + (b − a) s²/2 = 1, in the form that does not cancel.
            let square = (b - a).mul_add(splat(2.0), a * a).max(zero);
            let share = (splat(2.0) / (a + square.sqrt())).min(one);
            let share = is_last.select(one, share);
            let next = share.mul_add(b - a, a).max(zero);
            let next_at = is_last.select(piece.at[1], share.mul_add(piece.at[1] - at, at));
            self.absorb(simd, piece, [at, next_at], [share * a, share * next]);
            if is_last.all_true() {
                break;
            }
            if part == OPAQUE {
                self.transmittance = is_last.select(self.transmittance, zero);
                self.lost = is_last.select(self.lost, zero);
            }
            let rest = one - share;
            (a, b, at) = (rest * next, rest * b, next_at);
        }
    }

    /// Adds light whose color times its cue is a parabola, q_f (1 − s) + q_b s + κ s (1 − s), with
    /// the weights of its three terms.
    #[inline(always)]
    fn add_cued_light(
        &mut self,
        piece: &Piece<S>,
        transmittance: S::f32s,
        [front, back, bulge]: [S::f32s; 3],
        at: [S::f32s; 2],
        cue: [S::f32s; 2],
    ) {
        for i in 0..3 {
            let [near, far] = each!([at[0], at[1]], at => piece.more[i].mul_add(at, piece.base[i]));
            let kappa = (near - far) * (cue[1] - cue[0]);
            let sum = front * cue[0] * near + back * cue[1] * far + bulge * kappa;
            self.light[i] = transmittance.mul_add(sum, self.light[i]);
        }
    }

    /// With a depth cue, in parts with an optical depth of 2 at most: at 1 the quadrature's
    /// truncation is 8.8e-9 of the opacity, at 2 it is 6e-7.
    #[inline(always)]
    fn absorb_cued(&mut self, simd: S, piece: &Piece<S>) {
        let splat = |value: f32| S::f32s::splat(simd, value);
        let [a, b] = each!([0, 1], i => piece.ends[i].min(splat(DENSEST)));
        let (zero, one) = (splat(0.0), splat(1.0));
        let m = (a + b) * splat(0.5);
        let opaque = splat(OPAQUE as f32);
        // The share in front of the opaque depth: a s + (b − a) s²/2 = 24.
        let square = (b - a).mul_add(opaque + opaque, a * a).max(zero);
        let seen = ((opaque + opaque) / (a + square.sqrt())).min(one);
        let seen = m.simd_gt(opaque).select(seen, one);
        let parts = m.ceil().max(one).min(opaque);
        let most = parts
            .as_slice()
            .iter()
            .fold(1.0_f32, |most, &n| most.max(n)) as u32;
        for part in 0..most {
            let shares = [part as f32, (part + 1) as f32];
            let [near, far] = each!([0, 1], i => seen * (splat(shares[i]).min(parts) / parts));
            let length = far - near;
            let ends = each!([near, far], share => length * share.mul_add(b - a, a));
            let (at, cue) = (piece.at, piece.cue);
            let at = each!([near, far], share => share.mul_add(at[1] - at[0], at[0]));
            let cue = each!([near, far], share => share.mul_add(cue[1] - cue[0], cue[0]));
            let weights = cued_weights(simd, ends);
            let before = self.transmittance + self.lost;
            self.add_cued_light(piece, before, weights, at, cue);
            let alpha = one - exponential(simd, (ends[0] + ends[1]) * splat(-0.5));
            let thin = thin_opacity(simd, (ends[0] + ends[1]) * splat(0.5));
            let is_thin = alpha.simd_lt(splat(0.5));
            self.dim(before, is_thin.select(thin, alpha));
        }
        let is_opaque = m.simd_gt(opaque);
        self.transmittance = is_opaque.select(zero, self.transmittance);
        self.lost = is_opaque.select(zero, self.lost);
    }
}

/// The greatest of a color times its cue, which is a parabola, on a piece.
#[inline(always)]
fn greatest_cued<S: Simd>(simd: S, [front, back]: [S::f32s; 2], cue: [S::f32s; 2]) -> S::f32s {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let (zero, one, half) = (splat(0.0), splat(1.0), splat(0.5));
    let kappa = (front - back) * (cue[1] - cue[0]);
    let (front, back) = (front * cue[0], back * cue[1]);
    // Where the parabola's slope is 0, if that is a maximum inside.
    let bulges = kappa.simd_gt(zero);
    let top = half + half * (back - front) / bulges.select(kappa, one);
    let inside = bulges & (top - half).abs().simd_lt(half);
    let peak = front * (one - top) + back * top + kappa * top * (one - top);
    let most = front.max(back);
    inside.select(most.max(peak), most)
}

/// The opacity of a piece with a + b ≤ 2, and how much of its back color reaches its front:
/// ∫ s (a + δs) T ds, δ = b − a.
///
/// The share of the second, with m = (a + b)/2 and r = (b − a)/(a + b), is 1/2 and a function that
/// changes its sign with m and r together, as if seen from behind. The polynomial of degree 5 in m,
/// a least-squares fit reweighted to even out the error on m ∈ [0, 1], r ∈ [−1, 1], is off by at most
/// 3.2e-8 (`shaders/wgsl/common/optics.wgsl` has the same).
#[inline(always)]
fn weights<S: Simd>(simd: S, [a, b]: [S::f32s; 2]) -> (S::f32s, S::f32s) {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let total = a + b;
    let m = total * splat(0.5);
    let r = (b - a) / total.max(splat(1e-30));
    let (q, mm) = (r * r, m * m);
    let odd_0 = q.mul_add(splat(1.666_664_1e-2), splat(-8.333_321e-2));
    let odd_2 = q.mul_add(
        q.mul_add(splat(6.610_851_4e-5), splat(-3.965_941e-4)),
        splat(1.388_011_7e-3),
    );
    let odd_4 = q.mul_add(
        q.mul_add(
            q.mul_add(splat(1.120_811_6e-7), splat(-1.922_933_5e-6)),
            splat(9.468_718e-6),
        ),
        splat(-3.151_067_4e-5),
    );
    let odd = mm.mul_add(mm.mul_add(odd_4, odd_2), odd_0);
    let even_2 = q.mul_add(splat(1.190_191_1e-3), splat(-2.777_022_8e-3));
    let even_4 = q.mul_add(
        q.mul_add(splat(2.932_028_3e-6), splat(-3.200_546_8e-5)),
        splat(6.386_194_6e-5),
    );
    let even = mm.mul_add(mm.mul_add(even_4, even_2), splat(1.666_666_4e-1));
    let back = m.mul_add(odd, r.mul_add(even, splat(0.5)));
    let alpha = thin_opacity(simd, m);
    (alpha, alpha * back)
}

/// 1 − e^(−m) for m ≤ 1, without exponential and division: m times a polynomial, an interpolation of
/// (1 − e^(−m))/m at 400 Chebyshev nodes that is off by at most 2.0e-9.
#[inline(always)]
fn thin_opacity<S: Simd>(simd: S, m: S::f32s) -> S::f32s {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let mut sum = splat(1.291_868_7e-4);
    for coefficient in [
        -1.301_107_3e-3,
        8.275_88e-3,
        -4.164_704_3e-2,
        1.666_634_5e-1,
        -4.999_998e-1,
        1.0,
    ] {
        sum = sum.mul_add(m, splat(coefficient));
    }
    sum * m
}

/// The weights of the front color, the back color and the bulge between them:
/// ∫ (1−s, s, s (1−s)) (a + δs) T ds, by Gauss-Legendre with 6 points.
#[inline(always)]
fn cued_weights<S: Simd>(simd: S, [a, b]: [S::f32s; 2]) -> [S::f32s; 3] {
    const NODES: [(f32, f32); 6] = [
        (0.033_765_24, 0.085_662_246),
        (0.169_395_31, 0.180_380_79),
        (0.380_690_4, 0.233_956_97),
        (0.619_309_6, 0.233_956_97),
        (0.830_604_7, 0.180_380_79),
        (0.966_234_76, 0.085_662_246),
    ];
    let splat = |value: f32| S::f32s::splat(simd, value);
    let delta = b - a;
    let mut sums = [splat(0.0); 3];
    for (s, weight) in NODES {
        let depth = (delta * splat(0.5 * s) + a) * splat(s);
        let value = splat(weight) * (delta * splat(s) + a) * exponential(simd, -depth);
        let factors = [1.0 - s, s, s * (1.0 - s)];
        sums = each!([0, 1, 2], i => value.mul_add(splat(factors[i]), sums[i]));
    }
    sums
}

/// e^x for x ≤ 0, within 2 last places down to e^(−87), where it ends.
///
/// x = n ln 2 + r with |r| ≤ ln 2 / 2; the series of e^r to degree 7 is off by r⁸/8! < 6e-9, and
/// n ln 2 is taken away in two parts, the first exactly.
#[inline(always)]
fn exponential<S: Simd>(simd: S, x: S::f32s) -> S::f32s {
    let splat = |value: f32| S::f32s::splat(simd, value);
    let x = x.max(splat(-87.0));
    let n = (x * splat(std::f32::consts::LOG2_E)).round_ties_even();
    let r = n.mul_add(splat(-0.693_359_4), x);
    let r = n.mul_add(splat(2.121_944_4e-4), r);
    let mut sum = splat(1.0 / 5040.0);
    for coefficient in [
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        sum = sum.mul_add(r, splat(coefficient));
    }
    let exponent: S::i32s = n.to_int();
    let power: S::i32s = (exponent + 127) << 23;
    sum * power.bitcast::<S::f32s>()
}
