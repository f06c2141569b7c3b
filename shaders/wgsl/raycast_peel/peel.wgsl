// Peel: the boundary faces that each ray crosses, one layer after the other.
//
// As phase 2 of Bernardon et al. 2004, front and back faces alike; layers are in the order of
// (t, face), in which nothing ties: so there is no bias. Faces are drawn by increasing
// number, and of equal depths the first stays.
// In:   a rectangle for each boundary face; the layer before, faces and depths.
// Out:  the face and its depth.
// With: raycast_peel/rays.wgsl, raycast_peel/boundary.wgsl and what it needs

@group(0) @binding(0) var<uniform> march: March;
@group(2) @binding(0) var before: texture_2d<u32>;
@group(2) @binding(1) var before_depths: texture_depth_2d; // greatest where nothing is before

struct Peeling {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) face: u32,
}

@vertex
fn vs_peel(
    @builtin(vertex_index) index: u32,
    @builtin(instance_index) face: u32,
    @location(0) rectangle: vec4f,
) -> Peeling {
    return Peeling(rectangle_corner(index, rectangle), face);
}

struct Peeled {
    @location(0) face: u32,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_peel(in: Peeling) -> Peeled {
    let pixel = vec2u(in.position.xy);
    let ray = ray_of(pixel);
    let crossed = boundary_crossing(in.face, shear_of(ray.anchor, ray.direction));
    let depth = depth_of(crossed.x);
    let last = textureLoad(before_depths, pixel, 0);
    let is_later = depth < last || (depth == last && in.face > textureLoad(before, pixel, 0).x);
    if crossed.y == 0.0 || !is_later {
        discard;
    }
    return Peeled(in.face, depth);
}
