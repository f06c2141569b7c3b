// Entry by sides: where rays come in, one layer of boundary faces after the other.
//
// As phases 1 and 2 of Bernardon et al. 2004 in entry.wgsl, but a face is drawn as the
// rectangle of pixels that may see it, the ray decides whether it comes in there, and layers
// are in the order of (λ, cell), in which nothing ties: so there is no bias. A whole line is
// a ray here, as it is unknown in which cell the eye is.
// In:   a rectangle and a face for each boundary face, by increasing cell; the layer before.
// Out:  the cell behind the face, λ and the scalar there.
// With: ping_pong/rays.wgsl, ping_pong/sides.wgsl, raycast_peel/layers.wgsl

@group(2) @binding(0) var before: texture_2d<f32>;

struct Entering {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) cell: vec2f,
    @location(1) @interpolate(flat) opposite: f32,
}

// Of two triangles; `rectangle` is left, bottom, right, top in clip space.
@vertex
fn vs_entry(
    @builtin(vertex_index) index: u32,
    @location(0) rectangle: vec4f,
    @location(1) face: vec3f,
) -> Entering {
    return Entering(rectangle_corner(index, rectangle), face.xy, face.z);
}

struct Entered {
    @location(0) state: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_entry(in: Entering) -> Entered {
    let ray = ray_of(in.position);
    let shear = shear_of(ray.anchor, ray.direction);
    let v = corners_of(vec2i(in.cell), shear);
    // `FACES` of tetrascope_core::mesh.
    var a = v.v0;
    var b = v.v2;
    var c = v.v1;
    if in.opposite == 0.0 {
        a = v.v1;
        c = v.v3;
    } else if in.opposite == 1.0 {
        b = v.v3;
        c = v.v2;
    } else if in.opposite == 2.0 {
        b = v.v1;
        c = v.v3;
    }
    let turn = -outward(shear);
    let crossed = crossing(a.xy, b.xy, c.xy) == turn;
    let at = crossing_point(a, b, c);
    let lambda = t_of(at.x, shear);
    let depth = depth_of(lambda);
    let layer = textureLoad(before, vec2i(in.position.xy), 0);
    let last = depth_of(layer.z);
    let is_later_cell = in.cell.y > layer.y || (in.cell.y == layer.y && in.cell.x > layer.x);
    let is_later = depth < last || (depth == last && is_later_cell);
    let is_seen = lambda >= ray.eye || frame.starts_behind != 0u;
    if !(crossed && is_later && is_seen) {
        discard;
    }
    return Entered(vec4f(in.cell, lambda, at.y), depth);
}
