// Walk: which face a ray crosses, decided without any tolerance.
//
// sides.wgsl decides about vertices as shear.wgsl has them, so a ray that enters a cell
// leaves it, whatever its shape, and never comes back to it.
// With: raycast_peel/shear.wgsl, common/sides.wgsl, common/texels.wgsl

fn corner(id: u32, shear: Shear) -> Corner {
    let vertex = textureLoad(vertices, texel(id), 0);
    return sheared(id, vertex.xyz, vertex.w, shear);
}
