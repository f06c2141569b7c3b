// Projection: the camera and the mesh, and what rays look like.
//
// Camera space is (right, up, forward) from the anchor, the point of the optical
// axis beside the mesh's center, in normalized units. So coordinates stay as small
// as the mesh however far the eye is, and its distance cancels nothing.

struct CameraUniform {
    // Rows of the transform from normalized to camera space; w is the translation.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // A ray at (x, y) of the image, each in [−1, 1], goes through
    // (x, y) · extent + (x, y) · slope · z at depth z.
    extent: vec2f,
    slope: vec2f,
    // The image is (x, y) · clip_per_unit / w, each in [−1, 1], with
    // w = w_per_depth · (z + anchor_depth) + w_constant.
    clip_per_unit: vec2f,
    size: vec2f, // of the image, pixels
    anchor_depth: f32, // from the eye to the anchor along the axis
    w_per_depth: f32, // 1 in perspective, else 0
    w_constant: f32,
    near: f32, // the least w that is drawn
    // The sort key is (far_key − distance key) · key_scale; see order.wgsl.
    far_key: f32,
    key_scale: f32,
    cell_count: u32, // cells that are drawn
    scalars_per_cell: u32, // 1 for cell data, 0 for point data
    scalar_range: vec2f, // the field's
}

// Group 0 is the frame, group 1 the volume.
@group(0) @binding(0) var<uniform> frame: CameraUniform;
@group(0) @binding(2) var ends: texture_2d<f32>; // of rays (common/ends.wgsl)
