// Cue: what one segment of a ray adds where a depth cue dims its light.
//
// The color is multiplied by a factor that goes linearly from cue.x at the segment's front
// to cue.y at its back, as in `tetrascope_core::optics::RayIntegral::add_cued`. In the
// terms of optics.wgsl.
// With: common/optics.wgsl and what it needs

// Whether there is a depth cue.
override CUED: bool = false;

// `integrate` with a cue.
fn integrate_cued(front: f32, back: f32, length: f32, cue: vec2f) -> vec4f {
    var held = no_interval();
    return integrate_cued_from(&held, front, back, length, cue);
}

// `integrate_from` with a cue.
fn integrate_cued_from(
    held: ptr<function, Held>,
    front: f32,
    back: f32,
    length: f32,
    cue: vec2f,
) -> vec4f {
    let rising = front <= back;
    let whole = abs(back - front);
    enter(held, front, rising, whole == 0.0);
    var sum = vec4f(0.0);
    var from_scalar = front;
    let most = interval_count();
    for (var n = 0u; n < most; n++) {
        let i = (*held).pair;
        let to_scalar = select(max(back, i.low), min(back, i.high), rising);
        var start = sample_interval(i, from_scalar);
        var end = sample_interval(i, to_scalar);
        var share = vec2f(0.0, 1.0);
        if whole > 0.0 {
            share = abs(vec2f(from_scalar, to_scalar) - front) / whole;
        } else if (*held).on_step {
            start = 0.5 * (start + (*held).below);
            end = start;
        }
        let piece = length * select(1.0, abs(to_scalar - from_scalar) / whole, whole > 0.0);
        sum = add_cued_piece(sum, start, end, piece, mix(cue.xx, cue.yy, share));
        if select(i.low <= back, i.high >= back, rising) || hides_all(sum) {
            break;
        }
        (*held).index = select((*held).index - 1u, (*held).index + 1u, rising);
        (*held).pair = interval((*held).index);
        from_scalar = to_scalar;
    }
    return sum;
}

// `add_piece` with a cue: color times cue is a parabola,
// q(s) = q_f (1 − s) + q_b s + κ s (1 − s).
fn add_cued_piece(sum: vec4f, start: vec4f, end: vec4f, length: f32, cue: vec2f) -> vec4f {
    let a = start.w * length;
    let b = end.w * length;
    let m = 0.5 * (a + b);
    let q_front = cue.x * start.xyz;
    let q_back = cue.y * end.xyz;
    let kappa = (start.xyz - end.xyz) * (cue.y - cue.x);
    switch MODEL {
        case EMISSION: {
            let front = (2.0 * a + b) / 6.0;
            let back = (a + 2.0 * b) / 6.0;
            return vec4f(sum.xyz + front * q_front + back * q_back + m / 6.0 * kappa, 0.0);
        }
        case ABSORPTION: {
            return vec4f(0.0, 0.0, 0.0, sum.w + m);
        }
        case MAXIMUM_INTENSITY: {
            // Where the parabola's slope is 0, if that is a maximum inside.
            let bulges = kappa > vec3f(0.0);
            let top = 0.5 + 0.5 * (q_back - q_front) / select(vec3f(1.0), kappa, bulges);
            let inside = bulges & (abs(top - 0.5) < vec3f(0.5));
            let peak = q_front * (1.0 - top) + q_back * top + kappa * top * (1.0 - top);
            let most = max(max(q_front, q_back), select(vec3f(0.0), peak, inside));
            return vec4f(max(sum.xyz, most), 0.0);
        }
        default: {
            return add_cued_parts(sum, start, end, length, cue);
        }
    }
}

// Behind this optical depth nothing shows: e^(−24) is 2⁻³⁴.
const OPAQUE_DEPTH: f32 = 24.0;

// EMISSION_ABSORPTION, in parts with an optical depth of 2 at most: at 1 the
// quadrature's truncation is 8.8e-9 of the opacity, at 2 it is 6e-7.
fn add_cued_parts(sum: vec4f, start: vec4f, end: vec4f, length: f32, cue: vec2f) -> vec4f {
    let a = start.w * length;
    let delta = (end.w - start.w) * length;
    let m = a + 0.5 * delta;
    // The share in front of the opaque depth: a s + δ s²/2 = 24, without the squares of
    // numbers that f32 cannot hold.
    var seen = 1.0;
    if m > OPAQUE_DEPTH {
        let root = sqrt(max(min(a, 1e18) * min(a, 1e18) + 2.0 * OPAQUE_DEPTH * delta, 0.0));
        seen = min(2.0 * OPAQUE_DEPTH / (a + root), 1.0);
    }
    let parts = clamp(ceil(m), 1.0, OPAQUE_DEPTH);
    var light = sum.xyz;
    var depth = sum.w;
    for (var i = 0.0; i < parts; i += 1.0) {
        let s0 = seen * (i / parts);
        let s1 = seen * ((i + 1.0) / parts);
        let near = mix(start, end, s0);
        let far = mix(start, end, s1);
        let cues = mix(cue.xx, cue.yy, vec2f(s0, s1));
        let part = (s1 - s0) * length;
        let w = cued_weights(near.w * part, (far.w - near.w) * part);
        let kappa = (near.xyz - far.xyz) * (cues.y - cues.x);
        let q = w.x * cues.x * near.xyz + w.y * cues.y * far.xyz + w.z * kappa;
        light += transmittance(depth) * q;
        depth += 0.5 * (near.w + far.w) * part;
    }
    return vec4f(light, sum.w + m);
}

// The weights of the front color, the back color and the bulge between them:
// ∫ (1−s, s, s (1−s)) (a + δs) T ds, by Gauss-Legendre with 6 points.
fn cued_weights(a: f32, delta: f32) -> vec3f {
    return cued_node(a, delta, 0.033765242898423986, 0.08566224618958517)
        + cued_node(a, delta, 0.16939530676686774, 0.1803807865240693)
        + cued_node(a, delta, 0.3806904069584015, 0.23395696728634552)
        + cued_node(a, delta, 0.6193095930415985, 0.23395696728634552)
        + cued_node(a, delta, 0.8306046932331323, 0.1803807865240693)
        + cued_node(a, delta, 0.966234757101576, 0.08566224618958517);
}

fn cued_node(a: f32, delta: f32, s: f32, weight: f32) -> vec3f {
    let value = weight * (a + delta * s) * exp(-s * (a + 0.5 * delta * s));
    return value * vec3f(1.0 - s, s, s * (1.0 - s));
}
