// Corners: one voxel cell, its interpolant along a ray and its gradient.
//
// Needs: `fn voxel(texel: vec3i) -> f32`, `fn scalar_of(raw: f32) -> f32`.

// The scalars of a cell, x fastest.
struct Corners {
    low: vec4f,  // at the lower z
    high: vec4f,
}

// In a loop, as compilers take long for each place where a texture is read: SwiftShader took over
// two minutes for the eight of `first_in_cells`, and takes two seconds for four.
fn corners(texel: vec3i) -> Corners {
    var c: Corners;
    for (var z = 0; z < 2; z++) {
        c.low = c.high;
        c.high = layer(texel + vec3i(0, 0, z));
    }
    return c;
}

// The scalars of four corners, x fastest.
fn layer(texel: vec3i) -> vec4f {
    let raw = vec4f(
        voxel(texel),
        voxel(texel + vec3i(1, 0, 0)),
        voxel(texel + vec3i(0, 1, 0)),
        voxel(texel + vec3i(1, 1, 0)),
    );
    return raw * frame.scalar_unit - frame.scalar_base;
}

// Linear interpolation that is exact at both ends, so that cells agree on the face between
// them, and where both numbers are equal, so that a constant stays what it is.
fn between(a: f32, b: f32, f: f32) -> f32 {
    return clamp(a * (1.0 - f) + b * f, min(a, b), max(a, b));
}

fn between2(a: vec2f, b: vec2f, f: f32) -> vec2f {
    return clamp(a * (1.0 - f) + b * f, min(a, b), max(a, b));
}

fn between4(a: vec4f, b: vec4f, f: f32) -> vec4f {
    return clamp(a * (1.0 - f) + b * f, min(a, b), max(a, b));
}

// The interpolant at a point of the unit cube.
fn value_in(c: Corners, place: vec3f) -> f32 {
    let flat = between4(c.low, c.high, place.z);
    let row = between2(flat.xy, flat.zw, place.y);
    return between(row.x, row.y, place.x);
}

// The Bernstein coefficients of the interpolant on the straight way between two points of
// the unit cube: a cubic. They are means of its polar form, in which each coordinate is
// taken from either end.
fn cubic_of(c: Corners, enter: vec3f, leave: vec3f) -> vec4f {
    let near = between4(c.low, c.high, enter.z);
    let far = between4(c.low, c.high, leave.z);
    // By the end of y and that of z; lower and upper x.
    let near_near = between2(near.xy, near.zw, enter.y);
    let far_near = between2(near.xy, near.zw, leave.y);
    let near_far = between2(far.xy, far.zw, enter.y);
    let far_far = between2(far.xy, far.zw, leave.y);
    let once = vec3f(
        between(near_near.x, near_near.y, leave.x),
        between(far_near.x, far_near.y, enter.x),
        between(near_far.x, near_far.y, enter.x),
    );
    let twice = vec3f(
        between(far_near.x, far_near.y, leave.x),
        between(near_far.x, near_far.y, leave.x),
        between(far_far.x, far_far.y, enter.x),
    );
    return vec4f(
        between(near_near.x, near_near.y, enter.x),
        mean(once),
        mean(twice),
        between(far_far.x, far_far.y, leave.x),
    );
}

fn mean(v: vec3f) -> f32 {
    let low = min(v.x, min(v.y, v.z));
    let high = max(v.x, max(v.y, v.z));
    return clamp((v.x + v.y + v.z) / 3.0, low, high);
}

// The cubic with these coefficients, at a share of the way (de Casteljau).
fn cubic_at(b: vec4f, share: f32) -> f32 {
    let first = mix(b.xyz, b.yzw, share);
    let second = mix(first.xy, first.yz, share);
    return mix(second.x, second.y, share);
}

// The gradient of the interpolant at a point of the unit cube.
fn gradient_in(c: Corners, place: vec3f) -> vec3f {
    let flat = mix(c.low, c.high, place.z);
    let up = c.high - c.low;
    let rise = mix(up.xy, up.zw, place.y);
    return vec3f(
        mix(flat.y - flat.x, flat.w - flat.z, place.y),
        mix(flat.z - flat.x, flat.w - flat.y, place.x),
        mix(rise.x, rise.y, place.x),
    );
}
