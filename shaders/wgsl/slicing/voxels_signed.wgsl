// Voxels of a texture that holds i16.

@group(1) @binding(1) var voxels: texture_3d<i32>;

fn voxel(texel: vec3i) -> f32 {
    return f32(textureLoad(voxels, texel, 0).x);
}
