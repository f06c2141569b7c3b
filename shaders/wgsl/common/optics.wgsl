// Optics: what one segment of a ray adds, for every optical model.
//
// The counterpart in f32 of `tetrascope_core::optics`, whose docs have the integral.
// Williams, Max, Stein 1998. In their terms: a and b are the extinctions at the segment's
// front and back times its length, m = (a + b)/2 its optical depth.
// With: common/optics_model.wgsl, common/transfer_function.wgsl

// Whether m may be above 1: else what only deeper segments need is not compiled.
override DEEP: bool = true;

// Light (linear RGB) in xyz and optical depth in w of a segment on which the scalar
// goes linearly from `front` to `back` over `length` ≥ 0, normalized. In
// MAXIMUM_INTENSITY the greatest color.
//
// Split at the knots, in ray order, so each piece is linear in extinction and color. Ends
// behind the opaque depth: so all pieces together have few parts of `attenuated_light`.
fn integrate(front: f32, back: f32, length: f32) -> vec4f {
    var held = no_interval();
    return integrate_from(&held, front, back, length);
}

// `integrate`, beginning with the interval in which the segment before ended, if that was near.
fn integrate_from(held: ptr<function, Held>, front: f32, back: f32, length: f32) -> vec4f {
    let rising = front <= back;
    let whole = abs(back - front);
    enter(held, front, rising, whole == 0.0);
    var sum = vec4f(0.0);
    var from_scalar = front;
    // Bounded, so that a NaN cannot hang the device.
    let most = interval_count();
    for (var n = 0u; n < most; n++) {
        let i = (*held).pair;
        let to_scalar = select(max(back, i.low), min(back, i.high), rising);
        var start = sample_interval(i, from_scalar);
        var end = sample_interval(i, to_scalar);
        // Each piece is as long as its share of the scalars; a constant one is whole.
        var share = length;
        if whole > 0.0 {
            share = length * (abs(to_scalar - from_scalar) / whole);
        } else if (*held).on_step {
            start = 0.5 * (start + (*held).below);
            end = start;
        }
        sum = add_piece(sum, start, end, share);
        if select(i.low <= back, i.high >= back, rising) || hides_all(sum) {
            break;
        }
        // The outer intervals reach beyond every scalar, so the walk stays inside.
        (*held).index = select((*held).index - 1u, (*held).index + 1u, rising);
        (*held).pair = interval((*held).index);
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
            let light = attenuated_light(sum, start, end, vec2f(a, b));
            return vec4f(light, sum.w + m);
        }
    }
}

// Behind this depth a color changes the picture by less than 2⁻²⁵.
const OPAQUE: f32 = 18.0;

// Whether nothing behind `sum` shows. It also bounds what loops over pieces with loops over
// their parts add up to: 3 passes for each of n pieces, and one for each optical depth up to
// that of the last, at most 36. Neighbors on a device that steps them together may add theirs.
fn hides_all(sum: vec4f) -> bool {
    return MODEL == EMISSION_ABSORPTION && sum.w > OPAQUE;
}

// Extinctions times a length, beyond which nothing changes but squares overflow.
const DENSEST: f32 = 1e18;

// The light of `sum` and of a piece behind it with extinctions `ends` times its length.
//
// In steps of optical depth 1, as `segment_weights` wants; almost all pieces are one.
fn attenuated_light(sum: vec4f, start: vec4f, end: vec4f, ends: vec2f) -> vec3f {
    if !DEEP {
        let w = segment_weights(ends.x, ends.y);
        return sum.xyz + transmittance(sum.w) * (w.x * start.xyz + w.y * end.xyz);
    }
    var light = sum.xyz;
    var depth = sum.w;
    var color = start.xyz;
    // At the front and at the back of what is left.
    var a = min(ends.x, DENSEST);
    var b = min(ends.y, DENSEST);
    for (var n = 0u; n < u32(OPAQUE); n++) {
        let m = 0.5 * (a + b);
        let is_last = m <= 1.0;
        var share = 1.0;
        if !is_last {
            // a s + (b − a) s²/2 = 1, in the form that does not cancel.
            share = min(2.0 / (a + sqrt(max(a * a + 2.0 * (b - a), 0.0))), 1.0);
        }
        let next = mix(a, b, share);
        let next_color = mix(color, end.xyz, share);
        let w = segment_weights(share * a, share * next);
        light += transmittance(depth) * (w.x * color + w.y * next_color);
        depth += 0.5 * share * (a + next);
        if is_last || depth > OPAQUE {
            break;
        }
        a = (1.0 - share) * next;
        b = (1.0 - share) * b;
        color = next_color;
    }
    return light;
}

// How much of the front and the back color reaches the front of a segment with a + b ≤ 2:
// (∫ (1−s)(a + δs) T ds, ∫ s (a + δs) T ds), δ = b − a.
//
// Their sum is the opacity. The share of the second, with m = (a + b)/2 and
// r = (b − a)/(a + b), is 1/2 and a function that changes its sign with m and r
// together, as if seen from behind. The polynomial of degree 5 in m, a least-squares fit
// reweighted to even out the error on m ∈ [0, 1], r ∈ [−1, 1], is off by at most 3.2e-8.
fn segment_weights(a: f32, b: f32) -> vec2f {
    let total = a + b;
    let m = 0.5 * total;
    let r = (b - a) / max(total, 1e-30);
    let q = r * r;
    let mm = m * m;
    let odd = -8.333320693e-02 + q * 1.666664085e-02
        + mm * (1.388011680e-03 + q * (-3.965941202e-04 + q * 6.610851054e-05)
        + mm * (-3.151067489e-05 + q * (9.468718452e-06 + q * (-1.922933438e-06 + q * 1.120811580e-07))));
    let even = 1.666666402e-01 + mm * (-2.777022709e-03 + q * 1.190191193e-03
        + mm * (6.386194648e-05 + q * (-3.200546875e-05 + q * 2.932028353e-06)));
    let back = 0.5 + r * even + m * odd;
    let alpha = thin_opacity(m);
    return vec2f(alpha * (1.0 - back), alpha * back);
}

// `opacity` for m ≤ 1, without exponential and division: m times a polynomial, an
// interpolation of (1 − e^(−m))/m at 400 Chebyshev nodes that is off by at most 2.0e-9.
fn thin_opacity(m: f32) -> f32 {
    return m * (1.0 + m * (-4.999997914e-01 + m * (1.666634530e-01 + m * (-4.164704308e-02
        + m * (8.275879547e-03 + m * (-1.301107346e-03 + m * 1.291868684e-04))))));
}
