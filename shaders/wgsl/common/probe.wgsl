// Probe: many segments at once, for testing optics.wgsl and tables against the CPU.
//
// With: common/transfer_function.wgsl, common/optics.wgsl, preintegration/lookup.wgsl

struct Probe {
    front: f32,
    back: f32,
    length: f32,
}

@group(0) @binding(0) var<storage, read> intervals: array<KnotPair>;
@group(0) @binding(1) var<storage, read> probes: array<Probe>;
// Light and optical depth of each.
@group(0) @binding(2) var<storage, read_write> answers: array<vec4f>;
// α of each, which `answers` cannot give: 1 − e^(−τ) cancels.
@group(0) @binding(3) var<storage, read_write> opacities: array<f32>;
@group(0) @binding(4) var table: texture_3d<f32>;
@group(0) @binding(5) var<uniform> span: vec4f;

fn interval(i: u32) -> KnotPair {
    return intervals[i];
}

fn interval_count() -> u32 {
    return arrayLength(&intervals);
}

fn table_span() -> vec4f {
    return span;
}

@compute @workgroup_size(64)
fn cs_probe(@builtin(global_invocation_id) id: vec3u) {
    let i = id.x;
    if i >= arrayLength(&probes) {
        return;
    }
    let probe = probes[i];
    let sum = segment(probe.front, probe.back, probe.length);
    answers[i] = vec4f(sum.xyz, segment_depth(sum));
    opacities[i] = segment_opacity(sum);
}
