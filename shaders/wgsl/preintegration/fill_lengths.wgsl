// Fill with lengths: integrate all segments between two scalars, sixteen lengths at a time.
//
// Segments between the same scalars have the same pieces: the length scales only their optical
// depths. So one invocation finds the pieces once and adds each to sixteen entries. On llvmpipe,
// where reading an interval is slow, 128³ entries take a fifth of the time that they take one by
// one, and twice that of writing them alone; four, eight and thirty-two at a time take 1.6, 1.2 and
// 1.2 times as long.
//
// `segment_weights` and `attenuated_light` of common/optics.wgsl are written out here: what
// depends on the scalars alone is computed once, and there is no exponential, as opacities are
// added up instead of depths.
// With: preintegration/fill.wgsl and what it is with

// Lengths of an invocation, in groups of four.
const LENGTHS: u32 = 16u;

// Of four lengths, the premultiplied light and the opacity.
struct Four {
    r: vec4f,
    g: vec4f,
    b: vec4f,
    alpha: vec4f,
}

@compute @workgroup_size(64)
fn cs_fill_lengths(@builtin(global_invocation_id) id: vec3u) {
    // The lengths of this invocation. Where parts are cut for the longest, the shortest must not be
    // far shorter: it would be added up from many parts, each of which is rounded.
    var first = LENGTHS * id.z;
    var end = first + LENGTHS;
    if DEEP {
        switch id.z {
            case 0u: {
                end = 4u;
            }
            case 1u: {
                first = 4u;
                end = 8u;
            }
            case 2u: {
                first = 8u;
                end = 16u;
            }
            default: {
                first -= 2u * LENGTHS;
                end = first + LENGTHS;
            }
        }
    }
    end = min(end, TABLE_SIDE);
    let at = vec3u(id.xy, first);
    if any(at >= vec3u(TABLE_SIDE)) {
        return;
    }
    let last = f32(TABLE_SIDE - 1u);
    let front = scalar_at(at.x, last);
    let back = scalar_at(at.y, last);
    // The length at the end of the table is `span.w`; all lengths below are shares of the longest
    // here.
    let longest_place = f32(max(end - 1u, 1u));
    let longest = span.w * (longest_place / last);
    if MODEL == ABSORPTION {
        let depth = min(integrate(front, back, longest).w, DENSEST);
        for (var n = 0u; n < LENGTHS; n++) {
            let share = f32(at.z + n) / longest_place;
            put_before(end, at + vec3u(0u, 0u, n), vec4f(0.0, 0.0, 0.0, opacity(share * depth)));
        }
        return;
    }
    let shares_0 = shares_from(at.z, longest_place);
    let shares_1 = shares_from(at.z + 4u, longest_place);
    let shares_2 = shares_from(at.z + 8u, longest_place);
    let shares_3 = shares_from(at.z + 12u, longest_place);
    // The least share but 0, of which nothing is seen.
    let least = f32(max(at.z, 1u)) / longest_place;
    var four_0 = Four();
    var four_1 = Four();
    var four_2 = Four();
    var four_3 = Four();
    // Optical depth of the longest.
    var depth = 0.0;
    // Walk from piece to piece as `integrate` does.
    let rising = front <= back;
    let whole = abs(back - front);
    var index = find_interval(front, rising);
    var from_scalar = front;
    let most = interval_count();
    for (var n = 0u; n < most; n++) {
        let i = interval(index);
        let to_scalar = select(max(back, i.low), min(back, i.high), rising);
        var start = sample_interval(i, from_scalar);
        var stop = sample_interval(i, to_scalar);
        var length = longest;
        if whole > 0.0 {
            length = longest * (abs(to_scalar - from_scalar) / whole);
        } else if index > 0u && from_scalar == i.low {
            // Constant, and on a step: both sides count half.
            start = 0.5 * (start + sample_interval(interval(index - 1u), from_scalar));
            stop = start;
        }
        // From here on w is the extinction times the length, and 0 the depth at the piece's front.
        start.w = min(start.w * length, DENSEST);
        stop.w = min(stop.w * length, DENSEST);
        let piece_depth = 0.5 * (start.w + stop.w);
        // Cut where the depth of the longest is 1, 2, 3 and so on. As the square of w is linear in
        // the depth, each cut is found from the piece's ends: what it is off by does not add up.
        var near = start;
        for (var part = 0u; part < MOST_PARTS; part++) {
            let left = piece_depth - f32(part);
            let is_last = !DEEP || left <= 1.0;
            var far = stop;
            if !is_last {
                let cut = f32(part + 1u);
                far.w = sqrt(max(start.w * start.w + 2.0 * (stop.w - start.w) * cut, 0.0));
                let share = min(2.0 * cut / (start.w + far.w), 1.0);
                far = vec4f(mix(start.xyz, stop.xyz, share), far.w);
            }
            let part_depth = select(1.0, left, is_last);
            let weights = weights_of(part_depth, near.w, far.w);
            four_0 = with_part(four_0, weights, near.xyz, far.xyz, shares_0);
            four_1 = with_part(four_1, weights, near.xyz, far.xyz, shares_1);
            four_2 = with_part(four_2, weights, near.xyz, far.xyz, shares_2);
            four_3 = with_part(four_3, weights, near.xyz, far.xyz, shares_3);
            depth += part_depth;
            if is_last || least * depth > OPAQUE {
                break;
            }
            near = far;
        }
        if select(i.low <= back, i.high >= back, rising) || least * depth > OPAQUE {
            break;
        }
        index = select(index - 1u, index + 1u, rising);
        from_scalar = to_scalar;
    }
    put_four(end, at, four_0);
    put_four(end, at + vec3u(0u, 0u, 4u), four_1);
    put_four(end, at + vec3u(0u, 0u, 8u), four_2);
    put_four(end, at + vec3u(0u, 0u, 12u), four_3);
}

// Parts of depth 1 until the shortest is opaque: it has at least a third of the longest's depth,
// which so ends behind 3 · OPAQUE.
const MOST_PARTS: u32 = 3u * u32(OPAQUE) + 1u;

fn shares_from(place: u32, longest_place: f32) -> vec4f {
    let places = vec4f(vec4u(place) + vec4u(0u, 1u, 2u, 3u));
    // Beyond the table there is nothing to put, and nothing may overflow.
    return min(places / longest_place, vec4f(1.0));
}

// The back color's share of the opacity α of a segment with optical depth m is a polynomial in m:
// `constant` + m (`odd` + m² …) + m² (`even` + m² …).
struct Weights {
    depth: f32,
    constant: f32,
    odd: vec3f,
    even: vec2f,
}

// For a part that has this depth in the longest, and ends proportional to `a` and `b`; all lengths
// share their ratio. `segment_weights` has the coefficients.
fn weights_of(depth: f32, a: f32, b: f32) -> Weights {
    let r = (b - a) / max(a + b, 1e-30);
    let q = r * r;
    let odd = vec3f(
        -8.333320693e-02 + q * 1.666664085e-02,
        1.388011680e-03 + q * (-3.965941202e-04 + q * 6.610851054e-05),
        -3.151067489e-05 + q * (9.468718452e-06 + q * (-1.922933438e-06 + q * 1.120811580e-07)),
    );
    let even = vec2f(
        r * (-2.777022709e-03 + q * 1.190191193e-03),
        r * (6.386194648e-05 + q * (-3.200546875e-05 + q * 2.932028353e-06)),
    );
    return Weights(depth, 0.5 + r * 1.666666402e-01, odd, even);
}

// `sums` and a part behind them that has these shares of its depth.
fn with_part(sums: Four, weights: Weights, near: vec3f, far: vec3f, shares: vec4f) -> Four {
    let m = shares * weights.depth;
    let mm = m * m;
    let odd = weights.odd.x + mm * (weights.odd.y + mm * weights.odd.z);
    let even = mm * (weights.even.x + mm * weights.even.y);
    let back_share = weights.constant + even + m * odd;
    // As `thin_opacity`, behind what is in front.
    let alpha = m * (1.0 + m * (-4.999997914e-01 + m * (1.666634530e-01 + m * (-4.164704308e-02
        + m * (8.275879547e-03 + m * (-1.301107346e-03 + m * 1.291868684e-04))))));
    let seen = (1.0 - sums.alpha) * alpha;
    let of_back = seen * back_share;
    let of_front = seen - of_back;
    return Four(
        sums.r + of_front * near.x + of_back * far.x,
        sums.g + of_front * near.y + of_back * far.y,
        sums.b + of_front * near.z + of_back * far.z,
        sums.alpha + seen,
    );
}

fn put_four(end: u32, at: vec3u, sums: Four) {
    put_before(end, at, vec4f(sums.r.x, sums.g.x, sums.b.x, sums.alpha.x));
    put_before(end, at + vec3u(0u, 0u, 1u), vec4f(sums.r.y, sums.g.y, sums.b.y, sums.alpha.y));
    put_before(end, at + vec3u(0u, 0u, 2u), vec4f(sums.r.z, sums.g.z, sums.b.z, sums.alpha.z));
    put_before(end, at + vec3u(0u, 0u, 3u), vec4f(sums.r.w, sums.g.w, sums.b.w, sums.alpha.w));
}

// An invocation may have fewer lengths than it adds up.
fn put_before(end: u32, at: vec3u, sum: vec4f) {
    if at.z < end {
        put(at, sum);
    }
}
