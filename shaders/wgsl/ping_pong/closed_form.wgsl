// Integration of a segment in closed form.
//
// With: common/optics.wgsl and what it needs

@group(3) @binding(0) var<storage, read> intervals: array<Interval>;

fn interval(i: u32) -> Interval {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

// Light and opacity of a segment from `front` to `back`.
fn segment(front: f32, back: f32, length: f32) -> vec4f {
    let sum = integrate(front, back, length);
    return vec4f(sum.xyz, opacity(sum.w));
}
