// Display: what the rays gathered, over the background.
//
// Phase 4 of Bernardon et al. 2004.
// With: ping_pong/rays.wgsl, common/optics_model.wgsl

@group(2) @binding(0) var states: texture_2d<f32>;
@group(2) @binding(1) var colors: texture_2d<f32>;

@vertex
fn vs_display(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return covering(index, 0.0);
}

@fragment
fn fs_display(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let color = textureLoad(colors, vec2i(position.xy), 0);
    let behind = frame.background;
    switch MODEL {
        case EMISSION: {
            return vec4f(color.xyz + behind.xyz, behind.w);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(max(color.xyz, behind.xyz), behind.w);
        }
        default: {
            return color + (1.0 - color.w) * behind;
        }
    }
}
