// Lookup: what a segment adds, from a table of integrals or exactly.
//
// Weiler, Kraus, Ertl 2002, §5.1. The table ends with the transfer function's knots;
// beyond them color and extinction are constant, and need none.
// Needs: `var table: texture_3d<f32>`, and what preintegration/axes.wgsl and
// common/transfer_function.wgsl need.
// With: preintegration/axes.wgsl, common/optics_model.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl

// Whether the volume has scalars beyond the table's ends.
override TABLE_IS_LEFT: bool = true;

// As `integrate`; what w is, `segment_opacity` and `segment_depth` know.
fn segment(front: f32, back: f32, length: f32) -> vec4f {
    if TABLE_AXES == 0u {
        return integrate(front, back, length);
    }
    if !TABLE_IS_LEFT {
        return inside(front, back, length);
    }
    let span = table_span();
    let from_scalar = clamp(front, span.x, span.y);
    let to_scalar = clamp(back, span.x, span.y);
    // The shares of the segment before, in and behind the table's range.
    var shares = vec3f(abs(from_scalar - front), abs(to_scalar - from_scalar), abs(back - to_scalar));
    let whole = shares.x + shares.y + shares.z;
    if front == back {
        shares = select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), front == from_scalar);
    } else {
        shares /= whole;
    }
    let lengths = length * shares;
    var sum = beyond(front, lengths.x);
    if shares.y > 0.0 {
        sum = behind(sum, inside(from_scalar, to_scalar, lengths.y));
    }
    return behind(sum, beyond(back, lengths.z));
}

// How much of what is behind a segment it hides.
fn segment_opacity(segment: vec4f) -> f32 {
    if has_opacities() {
        return segment.w;
    }
    if !DEEP {
        return thin_opacity(segment.w);
    }
    return opacity(segment.w);
}

// The optical depth of a segment.
fn segment_depth(segment: vec4f) -> f32 {
    if has_opacities() {
        return depth_of_opacity(segment.w);
    }
    return segment.w;
}

// A segment in the table's range.
fn inside(front: f32, back: f32, length: f32) -> vec4f {
    let span = table_span();
    let scalars = (vec2f(front, back) - span.x) * span.z;
    if TABLE_AXES == 2u {
        let sum = between(scalars);
        return select(length * sum, sum, MODEL == MAXIMUM_INTENSITY || TABLE_IS_FIXED);
    }
    return between_lengths(vec3f(scalars, length / span.w));
}

// Interpolated by hand: texture units round the weights, mostly to 1/256 (see
// `preintegration` of tetrascope-gpu).
fn between(place: vec2f) -> vec4f {
    let at = saturate(place) * f32(TABLE_SIDE - 1u);
    let low = min(vec2u(at), vec2u(TABLE_SIDE - 2u));
    return slice(vec3u(low, 0u), at - vec2f(low));
}

fn between_lengths(place: vec3f) -> vec4f {
    let at = saturate(place) * f32(TABLE_SIDE - 1u);
    let low = min(vec3u(at), vec3u(TABLE_SIDE - 2u));
    let toward = at - vec3f(low);
    return mix(slice(low, toward.xy), slice(low + vec3u(0u, 0u, 1u), toward.xy), toward.z);
}

fn slice(low: vec3u, toward: vec2f) -> vec4f {
    let t00 = textureLoad(table, low, 0);
    let t10 = textureLoad(table, low + vec3u(1u, 0u, 0u), 0);
    let t01 = textureLoad(table, low + vec3u(0u, 1u, 0u), 0);
    let t11 = textureLoad(table, low + vec3u(1u, 1u, 0u), 0);
    let texel = mix(mix(t00, t10, toward.x), mix(t01, t11, toward.x), toward.y);
    // Tables without light have one component.
    return select(texel, vec4f(0.0, 0.0, 0.0, texel.x), MODEL == ABSORPTION);
}

// A segment at one end of the transfer function, where it is constant.
fn beyond(scalar: f32, length: f32) -> vec4f {
    if length <= 0.0 {
        return vec4f(0.0);
    }
    var value = interval(0u).at_high;
    if scalar > table_span().y {
        value = interval(interval_count() - 1u).at_low;
    }
    let depth = length * value.w;
    switch MODEL {
        case EMISSION: {
            return vec4f(depth * value.xyz, 0.0);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(value.xyz, 0.0);
        }
        case ABSORPTION: {
            return vec4f(0.0, 0.0, 0.0, select(depth, opacity(depth), TABLE_AXES == 3u));
        }
        default: {
            return opacity(depth) * vec4f(value.xyz, 1.0);
        }
    }
}

// `sum` and a segment behind it.
fn behind(sum: vec4f, next: vec4f) -> vec4f {
    if MODEL == MAXIMUM_INTENSITY {
        return max(sum, next);
    }
    return sum + select(next, (1.0 - sum.w) * next, TABLE_AXES == 3u);
}

// −ln(1 − α). For α ≤ 1/2 as 2 artanh(α/(2 − α)), because 1 − α would lose digits and
// WGSL's logarithm has 21 bits there; the next term, 3⁻¹⁶/17, is under 2⁻²⁴.
fn depth_of_opacity(alpha: f32) -> f32 {
    if alpha <= 0.5 {
        let x = alpha / (2.0 - alpha);
        let y = x * x;
        return 2.0 * x * (1.0 + y * (1.0 / 3.0 + y * (1.0 / 5.0 + y * (1.0 / 7.0
            + y * (1.0 / 9.0 + y * (1.0 / 11.0 + y * (1.0 / 13.0 + y / 15.0)))))));
    }
    // At α = 1 the depth is that of f32's next opacity, which shows nothing behind either.
    return -log(max(1.0 - alpha, 5.9604645e-8));
}
