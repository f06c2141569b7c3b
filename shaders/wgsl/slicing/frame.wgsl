// Slicing: the camera and the volume, and what rays look like.
//
// Lattice space numbers samples: sample (i, j, k) lies at that point. Camera space is
// (right, up, forward) from the anchor, the point of the optical axis beside the
// volume's center, in normalized units; depth is its third coordinate.
// With: slicing/box.wgsl

struct CameraUniform {
    // Rows of the transform from lattice to camera space; w is the translation.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // The ray at (x, y) of the image, each in [−1, 1], is in lattice space
    // origin + x origin_x + y origin_y + depth · (along + x along_x + y along_y).
    origin: vec4f,
    origin_x: vec4f,
    origin_y: vec4f,
    along: vec4f,
    along_x: vec4f,
    along_y: vec4f,
    cells: vec4f,           // of the volume, along each axis
    box_size: vec4f,        // cells along each axis of a box
    margin: vec4f,          // by how much a box is enlarged on each side
    inverse_spacing: vec4f, // 1 / the distance of samples, normalized units
    // A ray goes through (x, y) · extent + (x, y) · slope · depth.
    slope: vec2f,
    // Clip space is (x, y) · clip_per_unit, near, and w_per_depth · (depth +
    // anchor_depth) + w_constant: reversed, without a far plane.
    clip_per_unit: vec2f,
    size: vec2f,       // of the image, pixels
    anchor_depth: f32, // from the eye to the anchor along the axis
    w_per_depth: f32,  // 1 in perspective, else 0
    w_constant: f32,
    near: f32,
    // Slab k lies between the depths first_depth + k · step and one step more.
    first_depth: f32,
    step: f32,
    slab_count: i32,
    slabs_per_box: u32, // planes that may cut one box
    front: u32,         // the corner of a box that a plane touches first
    // A raw sample r is the scalar r · scalar_unit − scalar_base, in the unit of `ScalarMap`.
    scalar_unit: f32,
    scalar_base: f32,
    // Of a grid on the device, the sample r is the scalar (r − raw_base) · raw_unit; the
    // difference is clamped to raw_most, which leaves the product finite.
    raw_unit: f32,
    raw_base: f32,
    raw_most: f32,
    // Of a ray, slabs of a fragment at most, and fragments of a pixel (rays.wgsl).
    slabs_per_run: u32,
    run_count: u32,
}

// Group 0 is the frame, group 1 the volume.
@group(0) @binding(0) var<uniform> frame: CameraUniform;
@group(0) @binding(1) var<storage, read> boxes: array<PlacedBox>; // back to front
// Camera space.
@group(0) @binding(2) var<uniform> look: Look;
@group(0) @binding(5) var ends: texture_2d<f32>; // of rays (common/ends.wgsl)

fn slab_depth(slab: i32) -> f32 {
    return frame.first_depth + f32(slab) * frame.step;
}

// The plane of a slab, in its middle.
fn plane_depth(slab: i32) -> f32 {
    return frame.first_depth + (f32(slab) + 0.5) * frame.step;
}

fn camera_depth(lattice: vec3f) -> f32 {
    return dot(frame.forward.xyz, lattice) + frame.forward.w;
}

fn clip_position(lattice: vec3f) -> vec4f {
    let p = vec4f(lattice, 1.0);
    let w = frame.w_per_depth * (dot(frame.forward, p) + frame.anchor_depth) + frame.w_constant;
    return vec4f(vec2f(dot(frame.right, p), dot(frame.up, p)) * frame.clip_per_unit, frame.near, w);
}
