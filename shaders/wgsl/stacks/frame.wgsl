// Stacks: the camera and the stack, and where rays are.
//
// Stack space numbers samples: sample (i, j) of layer k lies at (i, j, k). That is the lattice with
// its axes in another order. Camera space is (right, up, forward) from the anchor, the point of the
// optical axis beside the grid's center, in normalized units; depth is its third coordinate.
// With: common/look.wgsl, common/ends.wgsl

struct CameraUniform {
    // Rows of the transform from stack to camera space; w is the translation.
    right: vec4f,
    up: vec4f,
    forward: vec4f,
    // The ray at (x, y) of the image, each in [−1, 1], is in stack space
    // origin + x origin_x + y origin_y + depth · (along + x along_x + y along_y).
    origin: vec4f,
    origin_x: vec4f,
    origin_y: vec4f,
    along: vec4f,
    along_x: vec4f,
    along_y: vec4f,
    cells: vec4f, // of the grid, along each axis: one less than samples
    // In camera space it goes through (x, y) · extent + (x, y) · slope · depth.
    extent: vec2f,
    slope: vec2f,
    // A point of camera space is at (x, y) · inverse_reach / w of the image, where w is
    // w_per_depth · (depth + anchor_depth) + w_constant.
    inverse_reach: vec2f,
    size: vec2f,       // of the image, pixels
    anchor_depth: f32, // from the eye to the anchor along the axis
    w_per_depth: f32,  // 1 in perspective, else 0
    w_constant: f32,
    // Rectangles before the eye along the stack; those behind it are drawn later, from the first on.
    ahead: i32,
    rectangle_count: i32,
    // The sample r is the scalar (r − raw_base) · raw_unit; the difference is clamped to raw_most,
    // which leaves the product finite.
    raw_unit: f32,
    raw_base: f32,
    raw_most: f32,
}

// Group 0 is the frame, group 1 the volume.
@group(0) @binding(0) var<uniform> frame: CameraUniform;
// Camera space.
@group(0) @binding(1) var<uniform> look: Look;
@group(0) @binding(2) var ends: texture_2d<f32>; // of rays (common/ends.wgsl)

// The ray of a pixel, in stack space but for through and slope.
struct Ray {
    origin: vec3f,  // at depth 0
    along: vec3f,   // per unit of depth
    through: vec2f, // in camera space the ray is (through, 0) + depth · (slope, 1)
    slope: vec2f,
    span: vec2f,    // depths between the eye, clip planes and what an application has drawn
}

fn ray_of(position: vec4f) -> Ray {
    let x = 2.0 * position.x / frame.size.x - 1.0;
    let y = 1.0 - 2.0 * position.y / frame.size.y;
    let through = vec2f(x, y) * frame.extent;
    let slope = vec2f(x, y) * frame.slope;
    let left = clip_ray(vec3f(through, 0.0), vec3f(slope, 1.0));
    let end = end_of_ray(vec2i(position.xy));
    return Ray(
        frame.origin.xyz + x * frame.origin_x.xyz + y * frame.origin_y.xyz,
        frame.along.xyz + x * frame.along_x.xyz + y * frame.along_y.xyz,
        through,
        slope,
        vec2f(max(left.x, -frame.anchor_depth), min(left.y, end)),
    );
}

// The part of `span` in a box of stack space; swapped or empty if there is none.
fn within(ray: Ray, low: vec3f, high: vec3f, span: vec2f) -> vec2f {
    var left = span;
    for (var axis = 0u; axis < 3u; axis++) {
        let slope = ray.along[axis];
        if slope == 0.0 {
            if ray.origin[axis] < low[axis] || ray.origin[axis] > high[axis] {
                left.y = left.x;
            }
            continue;
        }
        let crossings = (vec2f(low[axis], high[axis]) - ray.origin[axis]) / slope;
        left.x = max(left.x, min(crossings.x, crossings.y));
        left.y = min(left.y, max(crossings.x, crossings.y));
    }
    return left;
}

// How long the ray is where its depth grows by 1.
fn stretched(ray: Ray) -> f32 {
    return length(vec3f(ray.slope, 1.0));
}

// The depth cue at a depth of the ray.
fn cue_in(ray: Ray, depth: f32) -> f32 {
    return cue_at(vec3f(ray.through + ray.slope * depth, depth));
}
