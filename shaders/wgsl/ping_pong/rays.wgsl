// Rays: the rays of a frame, and the mesh in three textures.
//
// Bernardon et al. 2004, figures 8 and 9. A cell is named by the texel
// (t_u, t_v) at which its data begins in all three textures; texels t_u, t_u + 1 and
// t_u + 2 are its own.

struct CameraUniform {
    clip: mat4x4f,     // from normalized space; depth is greatest at the eye
    anchor: vec4f,     // of pixel (0, 0)'s center, relative to the mesh's center; w unused
    anchor_x: vec4f,   // how the anchor moves from a pixel to its right neighbor
    anchor_y: vec4f,   // … and to the one below
    eye: vec4f,        // perspective: the eye, w = 1; orthographic: the direction, w = 0
    inside: vec4f,     // where rays begin if the eye is in a cell: (t_u, t_v, 0, scalar)
    eye_depth: f32,    // orthographic: λ of the camera's plane
    bias: f32,         // by which a layer must be behind the one before, normalized
    stop_opacity: f32, // at which a ray is done
    starts_behind: u32, // 1 if rays by sides may come in behind the eye
    table_span: vec4f, // preintegration/axes.wgsl
}

@group(0) @binding(0) var<uniform> frame: CameraUniform;

// v_0 x, y, z, v_3 x | v_1 x, y, z, v_3 y | v_2 x, y, z, v_3 z
@group(1) @binding(0) var vertices: texture_2d<f32>;
// The outward normals of the faces opposite, likewise.
@group(1) @binding(1) var normals: texture_2d<f32>;
// a_0, a_1 | a_2, a_3 | gradient, scalar at the origin; a neighbor a_i is its (t_u, t_v).
// Where rays cross faces by sides, the last texel is the scalars of v_0 to v_3 instead.
@group(1) @binding(2) var neighbors: texture_2d<f32>;

// In place of t_u where there is no cell: the ray is outside.
const OUTSIDE: f32 = -1.0;
// … and where a ray was given up: it found no face to leave a cell by.
const LOST: f32 = -2.0;

// Beyond every λ.
const FAR: f32 = 1e30;

// From here on a mapped scalar stands for one that is not a number.
const TRANSPARENT_SCALAR: f32 = 1e34;

// Where a ray leaves a cell.
struct Leaving {
    next: vec2f,   // the cell behind the face
    lambda: f32,   // FAR if there is no such face
    scalar: f32,
}

// x = anchor + λ direction.
struct Ray {
    anchor: vec3f,
    direction: vec3f,
    eye: f32, // λ of the eye
}

fn ray_of(position: vec4f) -> Ray {
    let pixel = position.xy - 0.5;
    let anchor = (frame.anchor + pixel.x * frame.anchor_x + pixel.y * frame.anchor_y).xyz;
    if frame.eye.w == 1.0 {
        let from_eye = anchor - frame.eye.xyz;
        let distance = length(from_eye);
        return Ray(anchor, from_eye / distance, -distance);
    }
    return Ray(anchor, frame.eye.xyz, frame.eye_depth);
}

// Two triangles' worth of one triangle that covers the target; scissors cut the tile out.
fn covering(index: u32, z: f32) -> vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, z, 1.0);
}
