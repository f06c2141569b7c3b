// Rays: the rays of a frame, one per pixel.
//
// With: `march`, a March in a binding.

struct March {
    anchor: vec4f,     // anchor of pixel (0, 0)'s center, relative to the mesh's center; w unused
    anchor_x: vec4f,   // how the anchor moves from a pixel to its right neighbor
    anchor_y: vec4f,   // … and to the one below
    eye: vec4f,        // perspective: the eye, w = 1; orthographic: the direction, w = 0
    forward: vec4f,    // of the camera, a unit vector; w unused
    eye_depth: f32,    // orthographic: t of the camera's plane, seen from the anchor
    width: u32,
    height: u32,
    tiles_x: u32,      // tiles a row
    stop_depth: f32,   // optical depth beyond which a ray stops
    unused: f32,
    layers: u32,       // of the boundary that were peeled
    listed_from: u32,  // a ray in this many layers may be in more, and searches lists
}

// x = anchor + t direction, a unit vector.
struct Ray {
    anchor: vec3f,
    direction: vec3f,
    eye_t: f32,
}

fn ray_of(pixel: vec2u) -> Ray {
    let anchor = (march.anchor + f32(pixel.x) * march.anchor_x + f32(pixel.y) * march.anchor_y).xyz;
    if march.eye.w == 1.0 {
        let from_eye = anchor - march.eye.xyz;
        let distance = length(from_eye);
        return Ray(anchor, from_eye / distance, -distance);
    }
    return Ray(anchor, march.eye.xyz, march.eye_depth);
}
