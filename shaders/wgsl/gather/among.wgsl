// Among: put isosurfaces among what an application has drawn.
//
// In:   the nearest surfaces, and how far along their rays they are; the application's depth
//       buffer tests.
// Out:  linear premultiplied RGBA, and depth as the application has it.
// With: gather/scene.wgsl

@group(0) @binding(1) var colors: texture_2d<f32>;
// From where rays start, normalized units.
@group(0) @binding(2) var distances: texture_2d<f32>;

struct Fragment {
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_among(@builtin(position) position: vec4f) -> Fragment {
    let at = vec2i(position.xy);
    let color = textureLoad(colors, at, 0);
    let ray = scene_ray(position);
    // The anchor is where rays start.
    let p = ray.through + textureLoad(distances, at, 0).x / length(ray.slope.xyz) * ray.slope;
    let depth = dot(scene.clip_z, p) / dot(scene.clip_w, p);
    // Nothing there, or beyond the near or the far plane.
    if color.w == 0.0 || depth < 0.0 || depth > 1.0 {
        discard;
    }
    return Fragment(color, depth);
}
