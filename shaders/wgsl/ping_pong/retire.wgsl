// Retire: idle rays are moved before all others, so that the depth test rejects them.
//
// Phase 3b of Bernardon et al. 2004: the Z-update; what the occlusion query then
// draws is as deep as a step and needs no fragment shader.
// In:   the state and colors that the last pass read: a ray that was idle there is
//       so in both targets, and its color is final in both.
// Out:  depth 0 for idle rays.
// With: ping_pong/rays.wgsl

@group(2) @binding(0) var states: texture_2d<f32>;
@group(2) @binding(1) var colors: texture_2d<f32>;

@vertex
fn vs_retire(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

@fragment
fn fs_retire(@builtin(position) position: vec4f) {
    let pixel = vec2i(position.xy);
    let is_inside = textureLoad(states, pixel, 0).x >= 0.0;
    if is_inside && textureLoad(colors, pixel, 0).w < frame.stop_opacity {
        discard;
    }
}

@vertex
fn vs_query(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.5);
}
