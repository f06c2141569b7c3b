//! The weights of a segment's front and back color.

use std::f64::consts::{FRAC_2_SQRT_PI, PI, SQRT_2};

use errorfunctions::RealErrorFunctions as _;

/// Up to this optical depth the series is used, above it the closed form.
///
/// The closed form subtracts e^(−m) and is well conditioned once that is no
/// longer near 1; the series converges everywhere, but takes more terms.
const SERIES_DEPTH: f64 = 1.0;

/// The weights of the front and back color, apart from a common factor.
///
/// w_f = `front` · e^(−`shift`), w_b = `back` · e^(−`shift`). The factor is left
/// to the caller, who has another exponential, of the depth before the segment,
/// to take in the same step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub(super) front: f64,
    pub(super) back: f64,
    pub(super) shift: f64,
}

/// The optical depth of a segment whose ends have the depths `a` and `b`: (a + b) / 2.
///
/// Infinite where that overflows, and then as opaque as if it did not.
#[inline]
pub(super) fn depth(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

/// Weights of a segment on which σ l goes linearly from `a` to `b`; `m` = [`depth`]`(a, b)`.
#[inline]
pub(super) fn weights(a: f64, b: f64, m: f64) -> Weights {
    // The series is cut where it drops below 1e-16 of the weights, for every
    // b − a: the first omitted terms have degree 8, 12 and 16 in m and d.
    if m <= 1.0 / 32.0 {
        series::<3, 6>(a, b, m)
    } else if m <= 0.25 {
        series::<5, 10>(a, b, m)
    } else if m <= SERIES_DEPTH {
        series::<7, 14>(a, b, m)
    } else {
        let (front, back) = closed_form(a, b, m);
        Weights {
            front,
            back,
            shift: 0.0,
        }
    }
}

/// The weights about the middle of the segment, where both are entire functions.
///
/// With y = s − 1/2 and d = (b − a)/2, σ l = m + 2 d y and
/// T = e^(−m/2) e^(−m y) e^(d (1/4 − y²)). The sum and the difference of the
/// weights are integrals over y from −1/2 to 1/2 of which only the even part counts:
///
/// w_f + w_b = 1 − e^(−m) = 2 e^(−m/2) S,  S = sinh(m/2),
///
/// w_f − w_b = −∫ 2 y (m + 2 d y) T dy
///           = e^(−m/2) ∫ (2 m y sinh(m y) − 4 d y² cosh(m y)) e^(d (1/4 − y²)) dy = 2 e^(−m/2) Q,
///
/// so w_f = e^(−m/2) (S + Q), w_b = e^(−m/2) (S − Q). Expanding all three functions,
/// each power integrates to a beta function, and with M = m/2 and D = d/2
///
/// Q = Σᵢ M²ⁱ/(2i+1)! (2i − Uᵢ),  Uᵢ = D/(2i+3) + D²/((2i+3)(2i+5)) + … = D/(2i+3) (1 + Uᵢ₊₁).
///
/// `ROWS` + 1 terms of the sum are kept, and powers of D up to `TERMS`. As
/// |d| ≤ m, |Q| ≤ S/3 or so: S ± Q loses less than one bit.
#[inline]
fn series<const ROWS: usize, const TERMS: usize>(a: f64, b: f64, m: f64) -> Weights {
    let half_d = 0.25 * (b - a);
    let half_m = 0.5 * m;
    // Two steps of the recurrence at once, so that odd and even Uᵢ are two
    // chains that a processor runs side by side.
    let square = half_d * half_d;
    let mut u = [0.0; MOST_TERMS + 2];
    for i in (0..TERMS).rev() {
        let pair = square * (ODD[i] * ODD[i + 1]);
        u[i] = (half_d * ODD[i] + pair) + pair * u[i + 2];
    }
    let square = half_m * half_m;
    // M²ⁱ/(2i+1)!
    let mut power = [1.0; MOST_TERMS];
    for i in 0..ROWS {
        power[i + 1] = power[i] * square * FACTORIAL[i];
    }
    // Small terms first.
    let (mut sinh, mut q) = (0.0, 0.0);
    for i in (0..=ROWS).rev() {
        sinh += power[i];
        q += power[i] * ((2 * i) as f64 - u[i]);
    }
    let sinh = half_m * sinh;
    Weights {
        front: sinh + q,
        back: sinh - q,
        shift: half_m,
    }
}

/// The greatest `TERMS` of [`series`].
const MOST_TERMS: usize = 14;

/// 1/(2i+3).
const ODD: [f64; MOST_TERMS + 1] = {
    let mut table = [0.0; MOST_TERMS + 1];
    let mut i = 0;
    while i < table.len() {
        table[i] = 1.0 / (2 * i + 3) as f64;
        i += 1;
    }
    table
};

/// 1/((2i+2)(2i+3)), the steps between the factorials of odd numbers.
const FACTORIAL: [f64; MOST_TERMS + 1] = {
    let mut table = [0.0; MOST_TERMS + 1];
    let mut i = 0;
    while i < table.len() {
        table[i] = 1.0 / ((2 * i + 2) * (2 * i + 3)) as f64;
        i += 1;
    }
    table
};

/// (w_f, w_b) from Ψ = ∫₀¹ T ds: w_f = 1 − Ψ, w_b = Ψ − e^(−m), for m > 1.
///
/// With r = √(2 |b − a|), Ψ = (√π/r) (erfcx(a/r) − e^(−m) erfcx(b/r)) for rising
/// extinction and (2/r) (F(a/r) − e^(−m) F(b/r)), F Dawson's integral, for falling
/// (Moreland & Angel 2004, §3; Williams, Max & Stein 1998). With e^(−m), not its
/// equal e^(a²/r² − b²/r²), nothing cancels: the second term is at most e^(−m) of
/// the first, however near a and b are.
fn closed_form(a: f64, b: f64, m: f64) -> (f64, f64) {
    if m == f64::INFINITY {
        // Opaque from the first point on.
        return (1.0, 0.0);
    }
    let behind = (-m).exp();
    let psi = if a == b {
        -(-m).exp_m1() / m
    } else {
        // √2 √|δ|, as 2 |δ| may overflow.
        let r = SQRT_2 * (b - a).abs().sqrt();
        if a < b {
            PI.sqrt() / r * ((a / r).erfcx() - behind * (b / r).erfcx())
        } else {
            // w_im = 2 F / √π.
            2.0 / (FRAC_2_SQRT_PI * r) * ((a / r).w_im() - behind * (b / r).w_im())
        }
    };
    (1.0 - psi, psi - behind)
}

/// ∫ s (1 − s) (a + (b − a) s) T ds, the weight of a color that bulges in the middle,
/// for m ≤ 1.
///
/// Gauss-Legendre with 8 points: its error is below 4e-16 there, as the integrand's
/// derivatives of order 16 are below those of s² e^(−s).
pub(super) fn bulge(a: f64, b: f64) -> f64 {
    let delta = b - a;
    let at = |s: f64| s * (1.0 - s) * (a + delta * s) * (-s * (a + 0.5 * delta * s)).exp();
    let pair = |&(x, weight): &(f64, f64)| weight * (at(0.5 - x) + at(0.5 + x));
    NODES.iter().map(pair).sum()
}

/// Positions from the middle and weights of Gauss-Legendre with 8 points on [0, 1].
const NODES: [(f64, f64); 4] = [
    (0.091_717_321_247_824_9, 0.181_341_891_689_181),
    (0.262_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.398_333_238_706_813_37, 0.111_190_517_226_687_24),
    (0.480_144_928_248_768_1, 0.050_614_268_145_188_13),
];
