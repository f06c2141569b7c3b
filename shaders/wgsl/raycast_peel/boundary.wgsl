// Boundary: where a ray crosses a boundary face.
//
// With: raycast_peel/walk.wgsl, raycast_peel/layers.wgsl, common/texels.wgsl

// Lists of texels (common/texels.wgsl).
@group(1) @binding(0) var vertices: texture_2d<f32>; // position, normalized, and scalar
@group(1) @binding(4) var boundary: texture_2d<u32>; // three vertices and the cell behind

// From here on a mapped scalar stands for one that is not a number.
const TRANSPARENT_SCALAR: f32 = 1e34;

// Instead of a face: there is none, or the ray ended inside the mesh.
const NO_FACE: u32 = 0xffffffffu;

// t where the ray crosses boundary face `face`, and on which side its edges pass, 0 where it is
// not crossed. One function for whoever asks, so that all get the same bits.
fn boundary_crossing(face: u32, shear: Shear) -> vec2f {
    let ids = textureLoad(boundary, texel(face), 0);
    let a = corner(ids.x, shear);
    let b = corner(ids.y, shear);
    let c = corner(ids.z, shear);
    let turn = crossing(a.xy, b.xy, c.xy);
    let t = t_of(crossing_point(a, b, c).x, shear);
    // What depths cannot tell from 0 is 0 for all, and the faces decide.
    return vec2f(select(t, 0.0, abs(t) <= LEAST_DEPTH), f32(turn));
}
