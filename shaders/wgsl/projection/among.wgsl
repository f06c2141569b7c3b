// Among: put isosurfaces among geometry that is there already.
//
// In:   what surface.wgsl drew; the target's depth buffer tests.
// Out:  linear premultiplied RGBA, and depth as the target's matrix has it.
// With: projection/frame.wgsl

// Rows of the transform from camera space to the target's clip space.
struct Clip {
    z: vec4f,
    w: vec4f,
}

@group(1) @binding(0) var<uniform> clip: Clip;
@group(1) @binding(1) var colors: texture_2d<f32>;
@group(1) @binding(2) var alongs: texture_2d<f32>;

struct Fragment {
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

// One triangle over the whole image.
@vertex
fn vs_among(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fs_among(@builtin(position) position: vec4f) -> Fragment {
    let at = vec2i(position.xy);
    let color = textureLoad(colors, at, 0);
    let along = textureLoad(alongs, at, 0).x;
    let x = 2.0 * position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * position.y / frame.size.y;
    let p = vec4f(vec2f(x, y) * (frame.extent + frame.slope * along), along, 1.0);
    let depth = dot(clip.z, p) / dot(clip.w, p);
    // Nothing there, or beyond the near or the far plane.
    if color.w == 0.0 || depth < 0.0 || depth > 1.0 {
        discard;
    }
    return Fragment(color, depth);
}
