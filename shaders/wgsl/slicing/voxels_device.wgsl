// Voxels of a grid that was made on the device: scalars in the field's unit, or NO_VALUE.
//
// Of samples with a coverage those are gaps that are covered by less than a half, for models that
// know nothing between (`tetrascope_core::grid::coverage`).
//
// The difference comes first: that of scalars near each other is exact.
// With: slicing/frame.wgsl, slicing/slab.wgsl

@group(1) @binding(1) var voxels: texture_3d<f32>;

// As in `tetrascope_gpu::device_grid`.
const NO_VALUE: f32 = 3.40282346638528859811704183484516925e+38;

// Whether texels have a coverage behind the scalar.
override COVERED: bool = false;
const THERE: f32 = 0.5;

fn voxel(texel: vec3i) -> f32 {
    let there = textureLoad(voxels, texel, 0).xy;
    let raw = there.x;
    if GAPS && (raw >= NO_VALUE || (COVERED && there.y < THERE)) {
        return 1e8 * GAP;
    }
    return clamp(raw - frame.raw_base, -frame.raw_most, frame.raw_most) * frame.raw_unit;
}
