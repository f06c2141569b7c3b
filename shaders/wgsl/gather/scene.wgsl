// Scene: an application's depth buffer, seen by the view's camera.
//
// Camera space is (right, up, forward) from the anchor, a point of the optical axis near the
// volume, in normalized units; depth is its third coordinate. The pixels are the camera's; the
// depths are those of the application's own projection, which sees the same.

struct Occluder {
    // Rows of the transform from camera space to the application's clip space, times any factor.
    clip_z: vec4f,
    clip_w: vec4f,
    // A ray at (x, y) of the image, each in [−1, 1], goes through
    // (x, y) · extent + (x, y) · slope · depth.
    extent: vec2f,
    slope: vec2f,
    size: vec2f,  // of the image, pixels
    cleared: f32, // the depth where nothing was drawn
    unused: f32,
}

@group(0) @binding(0) var<uniform> scene: Occluder;

// One triangle over the whole image.
@vertex
fn vs_scene(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

// A pixel's ray in camera space at depth 0, and what it moves by where depth grows by 1.
struct SceneRay {
    through: vec4f,
    slope: vec4f,
}

fn scene_ray(position: vec4f) -> SceneRay {
    let at = vec2f(2.0, -2.0) * (position.xy / scene.size) + vec2f(-1.0, 1.0);
    return SceneRay(vec4f(at * scene.extent, 0.0, 1.0), vec4f(at * scene.slope, 1.0, 0.0));
}
