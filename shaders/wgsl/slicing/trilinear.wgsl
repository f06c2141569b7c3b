// Trilinear interpolation in f32: eight loads.
//
// Texture units do it with 8-bit fractions. What is interpolated does not depend on
// where in a texture a sample lies, so all bricks agree to the last bit. Where all samples
// are equal so is what is between them, to the last bit: a + f (b − a), and no mean.
// Needs: `fn voxel(texel: vec3i) -> f32`.
// With: slicing/frame.wgsl

fn raw_at(lattice: vec3f, texel: vec3i) -> f32 {
    let base = clamp(floor(lattice), vec3f(0.0), frame.cells.xyz - 1.0);
    let f = saturate(lattice - base);
    let i = vec3i(base) + texel;
    let low = vec4f(
        voxel(i),
        voxel(i + vec3i(0, 1, 0)),
        voxel(i + vec3i(0, 0, 1)),
        voxel(i + vec3i(0, 1, 1)),
    );
    let high = vec4f(
        voxel(i + vec3i(1, 0, 0)),
        voxel(i + vec3i(1, 1, 0)),
        voxel(i + vec3i(1, 0, 1)),
        voxel(i + vec3i(1, 1, 1)),
    );
    if GAPS {
        let greatest = max(low, high);
        if max(max(greatest.x, greatest.y), max(greatest.z, greatest.w)) >= GAP {
            return GAP;
        }
    }
    let edges = low + f.x * (high - low);
    let faces = edges.xz + f.y * (edges.yw - edges.xz);
    return faces.x + f.z * (faces.y - faces.x);
}
