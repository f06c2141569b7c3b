// Ends: how deep each pixel's ray goes before it meets what an application has drawn.
//
// In:   the application's depth buffer.
// Out:  depth in camera space; far behind all where nothing was drawn.
// With: gather/scene.wgsl

@group(0) @binding(1) var depths: texture_depth_2d;

const NOTHING: f32 = 1e30;

@fragment
fn fs_ends(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let depth = textureLoad(depths, vec2i(position.xy), 0);
    let ray = scene_ray(position);
    // depth = (z + d z') / (w + d w'), solved for d.
    let z = vec2f(dot(scene.clip_z, ray.through), dot(scene.clip_z, ray.slope));
    let w = vec2f(dot(scene.clip_w, ray.through), dot(scene.clip_w, ray.slope));
    let end = (z.x - depth * w.x) / (depth * w.y - z.y);
    return vec4f(select(end, NOTHING, depth == scene.cleared), 0.0, 0.0, 0.0);
}
