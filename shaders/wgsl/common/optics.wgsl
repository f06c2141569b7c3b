// Optics: what one segment of a ray adds, for every optical model.
//
// The counterpart in f32 of `tetrascope_core::optics`, whose docs have the integral.
// Williams, Max, Stein 1998; Moreland, Angel 2004. In their terms: a and b are the
// extinctions at the segment's front and back times its length, m = (a + b)/2 its
// optical depth, Ψ = ∫₀¹ T ds.
// With: common/optics_model.wgsl, common/transfer_function.wgsl

// A bound of m over all segments: what only deeper ones need is not compiled.
override DEEPEST: f32 = 1e30;

// Light (linear RGB) in xyz and optical depth in w of a segment on which the scalar
// goes linearly from `front` to `back` over `length` ≥ 0, normalized. In
// MAXIMUM_INTENSITY the greatest color.
//
// Split at the knots, in ray order, so each piece is linear in extinction and color.
fn integrate(front: f32, back: f32, length: f32) -> vec4f {
    let rising = front <= back;
    let whole = abs(back - front);
    var sum = vec4f(0.0);
    var index = find_interval(front, rising);
    var from_scalar = front;
    // Bounded, so that a number that is none cannot hang the device.
    let most = interval_count();
    for (var n = 0u; n < most; n++) {
        let i = interval(index);
        let to_scalar = select(max(back, i.low), min(back, i.high), rising);
        var start = sample_interval(i, from_scalar);
        var end = sample_interval(i, to_scalar);
        // Each piece is as long as its share of the scalars; a constant one is whole.
        var share = length;
        if whole > 0.0 {
            share = length * (abs(to_scalar - from_scalar) / whole);
        } else if index > 0u && from_scalar == i.low {
            // Constant, and on a step: both sides count half.
            start = 0.5 * (start + sample_interval(interval(index - 1u), from_scalar));
            end = start;
        }
        sum = add_piece(sum, start, end, share);
        if select(i.low <= back, i.high >= back, rising) {
            break;
        }
        // The outer intervals reach beyond every scalar, so the walk stays inside.
        index = select(index - 1u, index + 1u, rising);
        from_scalar = to_scalar;
    }
    return sum;
}

// `sum` and a piece behind it, on which color and extinction are linear.
fn add_piece(sum: vec4f, start: vec4f, end: vec4f, length: f32) -> vec4f {
    let a = start.w * length;
    let b = end.w * length;
    let m = 0.5 * (a + b);
    switch MODEL {
        case EMISSION: {
            // Simpson's rule, exact for the product of two linear functions.
            let front = (2.0 * a + b) / 6.0;
            let back = (a + 2.0 * b) / 6.0;
            return vec4f(sum.xyz + front * start.xyz + back * end.xyz, 0.0);
        }
        case ABSORPTION: {
            return vec4f(0.0, 0.0, 0.0, sum.w + m);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(max(sum.xyz, max(start.xyz, end.xyz)), 0.0);
        }
        default: {
            let w = segment_weights(a, b, m);
            let light = w.x * start.xyz + w.y * end.xyz;
            return vec4f(sum.xyz + transmittance(sum.w) * light, sum.w + m);
        }
    }
}

// How much of the front and the back color reaches the segment's front:
// (∫ (1−s)(a + δs) T ds, ∫ s (a + δs) T ds), δ = b − a.
fn segment_weights(a: f32, b: f32, m: f32) -> vec2f {
    if DEEPEST <= SERIES_DEPTH || m <= SERIES_DEPTH {
        return weights_series(a, b);
    }
    if DEEPEST <= 1.0 || m <= 1.0 {
        return weights_quadrature(a, b - a);
    }
    let t = transmittance(m);
    let psi = mean_transmittance(a, b, m, t);
    return vec2f(max(1.0 - psi, 0.0), max(psi - t, 0.0));
}

// The power series to the fourth order (numerators and denominators exact). What is
// left out is at most 4.7e-8 < 2⁻²⁴ of the opacity for m ≤ 1/20, worst over all a, b
// with that mean (in rational arithmetic).
const SERIES_DEPTH: f32 = 0.05;

fn weights_series(a: f32, b: f32) -> vec2f {
    let front = (2.0 * a + b) / 6.0
        - (a * (8.0 * a + 9.0 * b) + 3.0 * b * b) / 120.0
        + (a * (a * (16.0 * a + 29.0 * b) + 20.0 * b * b) + 5.0 * b * b * b) / 1680.0
        - (a * (a * (a * (128.0 * a + 325.0 * b) + 345.0 * b * b) + 175.0 * b * b * b)
            + 35.0 * b * b * b * b) / 120960.0;
    let back = (a + 2.0 * b) / 6.0
        - (a * (7.0 * a + 21.0 * b) + 12.0 * b * b) / 120.0
        + (a * (a * (19.0 * a + 76.0 * b) + 85.0 * b * b) + 30.0 * b * b * b) / 1680.0
        - (a * (a * (a * (187.0 * a + 935.0 * b) + 1545.0 * b * b) + 1085.0 * b * b * b)
            + 280.0 * b * b * b * b) / 120960.0;
    return vec2f(front, back);
}

// Gauss-Legendre with 6 points on [0, 1]; truncation 8.8e-9 of the opacity for m ≤ 1.
fn weights_quadrature(a: f32, delta: f32) -> vec2f {
    return node(a, delta, 0.033765242898423986, 0.08566224618958517)
        + node(a, delta, 0.16939530676686774, 0.1803807865240693)
        + node(a, delta, 0.3806904069584015, 0.23395696728634552)
        + node(a, delta, 0.6193095930415985, 0.23395696728634552)
        + node(a, delta, 0.8306046932331323, 0.1803807865240693)
        + node(a, delta, 0.966234757101576, 0.08566224618958517);
}

fn node(a: f32, delta: f32, s: f32, weight: f32) -> vec2f {
    let value = weight * (a + delta * s) * exp(-s * (a + 0.5 * delta * s));
    return vec2f((1.0 - s) * value, s * value);
}

// Ψ for m > 1, t = e^(−m). With t, and not as a difference of squares, both terms
// are well conditioned for any δ: the second is at most e^(−1) of the first.
fn mean_transmittance(a: f32, b: f32, m: f32, t: f32) -> f32 {
    let delta = b - a;
    // Below this the extinction is constant to f32, and a/r would overflow.
    if abs(delta) <= 1e-7 * m {
        return (1.0 - t) / m;
    }
    let r = sqrt(2.0 * abs(delta));
    if delta > 0.0 {
        return SQRT_PI / r * (scaled_erfc(a / r) - t * scaled_erfc(b / r));
    }
    return 2.0 / r * (dawson(a / r) - t * dawson(b / r));
}

const SQRT_PI: f32 = 1.7724538509055159;

// e^(x²) erfc(x) for x ≥ 0, relative error 1.2e-7 (W. Press et al., "Numerical
// Recipes", 2nd edition, §6.2, `erfcc`, without its factor e^(−x²)).
fn scaled_erfc(x: f32) -> f32 {
    let t = 1.0 / (1.0 + 0.5 * x);
    return t * exp(-1.26551223 + t * (1.00002368 + t * (0.37409196 + t * (0.09678418
        + t * (-0.18628806 + t * (0.27886807 + t * (-1.13520398 + t * (1.48851587
        + t * (-0.82215223 + t * 0.17087277)))))))));
}

// Dawson's integral F(x) = e^(−x²) ∫₀ˣ e^(u²) du for x ≥ 0.
//
// G. Rybicki, "Dawson's Integral and the Sampling Theorem", 1989, with h = 13/32, so
// that n h is exact; its error is e^(−(π/h)²), the first term left out e^(−(13 h)²).
fn dawson(x: f32) -> f32 {
    if x > 10.0 {
        // Asymptotic; the next term, 105/(16 x⁸), is under 2⁻²³ here.
        let y = 1.0 / (x * x);
        return 0.5 / x * (1.0 + y * (0.5 + y * (0.75 + y * 1.875)));
    }
    if x < 0.2 {
        // The next term, 16 x⁸/945, is under 2⁻²⁵.
        let y = x * x;
        return x * (1.0 - 2.0 / 3.0 * y * (1.0 - 0.4 * y * (1.0 - 2.0 / 7.0 * y)));
    }
    let n = 2.0 * round(0.5 * x / DAWSON_STEP);
    let rest = x - n * DAWSON_STEP;
    let e = exp(2.0 * rest * DAWSON_STEP);
    let square = e * e;
    var up = e;
    var sum = 0.0;
    sum += dawson_term(0.847860583886983, up, n + 1.0, n - 1.0);
    up *= square;
    sum += dawson_term(0.22642272494309784, up, n + 3.0, n - 3.0);
    up *= square;
    sum += dawson_term(0.016147717630328653, up, n + 5.0, n - 5.0);
    up *= square;
    sum += dawson_term(3.075373352933031e-4, up, n + 7.0, n - 7.0);
    up *= square;
    sum += dawson_term(1.564156178422905e-6, up, n + 9.0, n - 9.0);
    up *= square;
    sum += dawson_term(2.1245059355929288e-9, up, n + 11.0, n - 11.0);
    return 0.5641895835477563 * exp(-rest * rest) * sum;
}

const DAWSON_STEP: f32 = 0.40625;

fn dawson_term(c: f32, up: f32, plus: f32, minus: f32) -> f32 {
    return c * (up / plus + 1.0 / (minus * up));
}
