// Trilinear interpolation in f32: eight loads.
//
// Texture units do it with 8-bit fractions. What is interpolated does not depend on
// where in a texture a sample lies, so all bricks agree to the last bit.
// Needs: `fn voxel(texel: vec3i) -> f32`.
// With: slicing/frame.wgsl

fn raw_at(lattice: vec3f, texel: vec3i) -> f32 {
    let base = clamp(floor(lattice), vec3f(0.0), frame.cells.xyz - 1.0);
    let f = saturate(lattice - base);
    let i = vec3i(base) + texel;
    let v000 = voxel(i);
    let v100 = voxel(i + vec3i(1, 0, 0));
    let v010 = voxel(i + vec3i(0, 1, 0));
    let v110 = voxel(i + vec3i(1, 1, 0));
    let v001 = voxel(i + vec3i(0, 0, 1));
    let v101 = voxel(i + vec3i(1, 0, 1));
    let v011 = voxel(i + vec3i(0, 1, 1));
    let v111 = voxel(i + vec3i(1, 1, 1));
    if GAPS {
        let greatest = max(max(max(v000, v100), max(v010, v110)), max(max(v001, v101), max(v011, v111)));
        if greatest >= GAP {
            return GAP;
        }
    }
    let near = mix(mix(v000, v100, f.x), mix(v010, v110, f.x), f.y);
    let far = mix(mix(v001, v101, f.x), mix(v011, v111, f.x), f.y);
    return mix(near, far, f.z);
}
