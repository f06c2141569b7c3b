// Fill: integrate every segment that a table with two axes has a place for.
//
// With: preintegration/axes.wgsl, common/optics_model.wgsl,
//       common/transfer_function.wgsl, common/optics.wgsl, and for `put` one of
//       preintegration/put_color.wgsl and put_depth.wgsl

@group(0) @binding(0) var<storage, read> intervals: array<KnotPair>;
// `table_span`. Not a uniform: lavapipe compiles programs whose loops depend on one anew for each
// of its values.
@group(0) @binding(2) var<storage, read> span: vec4f;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

fn table_span() -> vec4f {
    return span;
}

@compute @workgroup_size(8, 8, 1)
fn cs_fill(@builtin(global_invocation_id) at: vec3u) {
    if any(at.xy >= vec2u(TABLE_SIDE)) {
        return;
    }
    let last = f32(TABLE_SIDE - 1u);
    let front = scalar_at(at.x, last);
    let back = scalar_at(at.y, last);
    // Of unit length: light, optical depth, or the greatest color.
    var length = 1.0;
    if has_opacities() {
        length = span.w;
    }
    var sum = integrate(front, back, length);
    if has_opacities() {
        sum.w = opacity(sum.w);
    }
    put(at, sum);
}

// Exact at both ends.
fn scalar_at(i: u32, last: f32) -> f32 {
    return span.x * ((last - f32(i)) / last) + span.y * (f32(i) / last);
}
