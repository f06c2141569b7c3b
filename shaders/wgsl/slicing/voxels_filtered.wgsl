// Trilinear interpolation by the texture unit, whose fractions have 8 bits or more. What
// is read has as many bits as texels on some devices, so these have 16 or 32.
//
// With: slicing/frame.wgsl

@group(1) @binding(1) var voxels: texture_3d<f32>;
@group(1) @binding(2) var linear: sampler;

fn raw_at(lattice: vec3f, texel: vec3i) -> f32 {
    let place = lattice + vec3f(texel) + 0.5;
    let size = vec3f(textureDimensions(voxels));
    return textureSampleLevel(voxels, linear, place / size, 0.0).x;
}

fn voxel(texel: vec3i) -> f32 {
    return textureLoad(voxels, texel, 0).x;
}
