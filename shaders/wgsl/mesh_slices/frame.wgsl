// Mesh slices: the camera and the mesh.
//
// Camera space is (right, up, forward) from the anchor, the point of the optical axis beside the
// mesh's center, in normalized units; depth is its third coordinate.
//
// A place as it is seen is (x, y) · k and depth · k, where k = D / (D + depth), D being the eye's
// distance from the anchor: 1 for parallel rays. Straight lines stay straight, what is linear
// in space is linear there once it is times k, and k = 1 − (depth · k) / D.
// With: common/look.wgsl

struct CameraUniform {
    // Rows of the transform from normalized to camera space; w is the translation.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // The ray at (x, y) of the image, each in [−1, 1], goes through
    // (x, y) · extent + (x, y) · slope · depth.
    extent: vec2f,
    slope: vec2f,
    size: vec2f, // of the image, pixels
    inverse_anchor_depth: f32, // 1 / D, or 0 for parallel rays
    first_depth: f32, // where the slab of the first plane begins
    step: f32, // from plane to plane
    plane_count: u32,
    cell_count: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> frame: CameraUniform;
// Camera space.
@group(0) @binding(1) var<uniform> look: Look;
@group(0) @binding(2) var ends: texture_2d<f32>; // of rays (common/ends.wgsl)

// One texel for each vertex and one for each cell; texel i is at (i % 4096, i / 4096). Of a
// vertex: its normalized place and its scalar.
@group(1) @binding(0) var vertices: texture_2d<u32>;
@group(1) @binding(1) var cells: texture_2d<u32>;
// One for each cell, if they have any.
@group(1) @binding(2) var<storage, read> cell_scalars: array<f32>;

// Stands for no scalar.
const NO_VALUE: f32 = 0x1.fffffep127f;

// Whether cells have scalars, not vertices.
override CELL_DATA: bool = false;

fn corners_of(cell: u32) -> vec4u {
    return textureLoad(cells, vec2u(cell & 4095u, cell >> 12u), 0);
}

// A vertex of a cell in camera space, with its scalar.
fn vertex_of(id: u32, cell: u32) -> vec4f {
    let texel = bitcast<vec4f>(textureLoad(vertices, vec2u(id & 4095u, id >> 12u), 0));
    let p = vec4f(texel.xyz, 1.0);
    var scalar = texel.w;
    if CELL_DATA {
        scalar = cell_scalars[cell];
    }
    return vec4f(dot(frame.right, p), dot(frame.up, p), dot(frame.forward, p), scalar);
}

// The same as it is seen.
fn seen(vertex: vec4f) -> vec4f {
    return vertex / (1.0 + vertex.z * frame.inverse_anchor_depth);
}

// The middle of a slab.
fn plane_depth(index: i32) -> f32 {
    return frame.first_depth + (f32(index) + 0.5) * frame.step;
}
