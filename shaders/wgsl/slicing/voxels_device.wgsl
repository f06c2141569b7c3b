// Voxels of a grid that was made on the device: scalars in the field's unit, or NO_VALUE.
//
// The difference comes first: that of scalars near each other is exact.
// With: slicing/frame.wgsl, slicing/slab.wgsl

@group(1) @binding(1) var voxels: texture_3d<f32>;

// As in `tetrascope_gpu::device_grid`.
const NO_VALUE: f32 = 3.40282346638528859811704183484516925e+38;

fn voxel(texel: vec3i) -> f32 {
    let raw = textureLoad(voxels, texel, 0).x;
    if GAPS && raw >= NO_VALUE {
        return 1e8 * GAP;
    }
    return clamp(raw - frame.raw_base, -frame.raw_most, frame.raw_most) * frame.raw_unit;
}
