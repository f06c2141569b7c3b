// Rays: the rays of a frame, the mesh in three textures, and a ray against one cell.
//
// Bernardon et al. 2004, equation 1 and figures 8 and 9. A cell is named by the texel
// (t_u, t_v) at which its data begins in all three textures; texels t_u, t_u + 1 and
// t_u + 2 are its own.

struct Frame {
    clip: mat4x4f,     // from normalized space; depth is greatest at the eye
    anchor: vec4f,     // of pixel (0, 0)'s center, relative to the mesh's center; w unused
    anchor_x: vec4f,   // how the anchor moves from a pixel to its right neighbor
    anchor_y: vec4f,   // … and to the one below
    eye: vec4f,        // perspective: the eye, w = 1; orthographic: the direction, w = 0
    background: vec4f, // premultiplied
    inside: vec4f,     // where rays begin if the eye is in a cell: (t_u, t_v, 0, scalar)
    eye_depth: f32,    // orthographic: λ of the camera's plane
    bias: f32,         // by which a layer must be behind the one before, normalized
    stop_opacity: f32, // at which a ray is done
    padding: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// v_0 x, y, z, v_3 x | v_1 x, y, z, v_3 y | v_2 x, y, z, v_3 z
@group(1) @binding(0) var vertices: texture_2d<f32>;
// The outward normals of the faces opposite, likewise.
@group(1) @binding(1) var normals: texture_2d<f32>;
// a_0, a_1 | a_2, a_3 | gradient, scalar at the origin. A neighbor a_i is its (t_u, t_v).
@group(1) @binding(2) var neighbors: texture_2d<f32>;

// In place of t_u where there is no cell: the ray is outside.
const OUTSIDE: f32 = -1.0;
// … and where a ray was given up: it found no face to leave a cell by.
const LOST: f32 = -2.0;

// Beyond every λ.
const FAR: f32 = 1e30;

// From here on a mapped scalar stands for one that is not a number.
const TRANSPARENT_SCALAR: f32 = 1e34;

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

// λ and the sign of r · n for the planes of a cell's faces.
struct Planes {
    lambda: vec4f,
    toward: vec4f, // r · n: positive where the ray leaves
}

fn planes_of(cell: vec2i, ray: Ray) -> Planes {
    let v0 = textureLoad(vertices, cell, 0);
    let v1 = textureLoad(vertices, cell + vec2i(1, 0), 0);
    let v2 = textureLoad(vertices, cell + vec2i(2, 0), 0);
    let n0 = textureLoad(normals, cell, 0);
    let n1 = textureLoad(normals, cell + vec2i(1, 0), 0);
    let n2 = textureLoad(normals, cell + vec2i(2, 0), 0);
    let v3 = vec3f(v0.w, v1.w, v2.w);
    let n3 = vec3f(n0.w, n1.w, n2.w);
    // Equation 1: face i's plane goes through v_(3 − i).
    let numerator = vec4f(
        dot(v3 - ray.anchor, n0.xyz),
        dot(v2.xyz - ray.anchor, n1.xyz),
        dot(v1.xyz - ray.anchor, n2.xyz),
        dot(v0.xyz - ray.anchor, n3),
    );
    let toward = vec4f(
        dot(ray.direction, n0.xyz),
        dot(ray.direction, n1.xyz),
        dot(ray.direction, n2.xyz),
        dot(ray.direction, n3),
    );
    return Planes(numerator / select(toward, vec4f(1.0), toward == vec4f(0.0)), toward);
}

// Equation 2, from the cell's gradient.
fn scalar_at(cell: vec2i, ray: Ray, lambda: f32) -> f32 {
    let gradient = textureLoad(neighbors, cell + vec2i(2, 0), 0);
    return dot(gradient.xyz, ray.anchor + lambda * ray.direction) + gradient.w;
}

// Two triangles' worth of one triangle that covers the target; scissors cut the tile out.
fn covering(index: u32, z: f32) -> vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, z, 1.0);
}
