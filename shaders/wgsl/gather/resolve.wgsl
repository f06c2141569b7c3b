// Resolve: put what a volume added up to over the background.
//
// `tetrascope_core::optics::over`, model by model.
// In:   gathered, what a renderer blended.
// Out:  linear premultiplied RGBA.
// With: common/optics_model.wgsl

struct Resolve {
    background: vec4f, // linear, premultiplied
}

@group(0) @binding(0) var<uniform> resolve: Resolve;
@group(0) @binding(1) var gathered: texture_2d<f32>;

// One triangle over the whole image.
@vertex
fn vs_resolve(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_resolve(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let sum = textureLoad(gathered, vec2i(position.xy), 0);
    let behind = resolve.background;
    switch MODEL {
        case EMISSION: {
            return vec4f(sum.xyz + behind.xyz, behind.w);
        }
        case ABSORPTION: {
            let t = transmittance(sum.x);
            return vec4f(t * behind.xyz, opacity(sum.x) + t * behind.w);
        }
        case MAXIMUM_INTENSITY: {
            return vec4f(max(sum.xyz, behind.xyz), behind.w);
        }
        default: {
            return sum + (1.0 - sum.w) * behind;
        }
    }
}
