//! `repr(C)` mirrors of WGSL structs.

use bytemuck::{Pod, Zeroable};

/// The mirror of `CameraUniform` in `frame.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct CameraUniform {
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) forward: [f32; 4],
    pub(crate) origin: [f32; 4],
    pub(crate) origin_x: [f32; 4],
    pub(crate) origin_y: [f32; 4],
    pub(crate) along: [f32; 4],
    pub(crate) along_x: [f32; 4],
    pub(crate) along_y: [f32; 4],
    pub(crate) cells: [f32; 4],
    pub(crate) box_size: [f32; 4],
    pub(crate) margin: [f32; 4],
    pub(crate) inverse_spacing: [f32; 4],
    pub(crate) slope: [f32; 2],
    pub(crate) clip_per_unit: [f32; 2],
    pub(crate) size: [f32; 2],
    pub(crate) anchor_depth: f32,
    pub(crate) w_per_depth: f32,
    pub(crate) w_constant: f32,
    pub(crate) near: f32,
    pub(crate) first_depth: f32,
    pub(crate) step: f32,
    pub(crate) slab_count: i32,
    pub(crate) slabs_per_box: u32,
    pub(crate) front: u32,
    pub(crate) scalar_unit: f32,
    pub(crate) scalar_base: f32,
    pub(crate) raw_unit: f32,
    pub(crate) raw_base: f32,
    pub(crate) raw_most: f32,
    pub(crate) slabs_per_run: u32,
    pub(crate) run_count: u32,
    pub(crate) padding: [u32; 2],
}

/// The mirror of `PlacedBox` in `box.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct PlacedBox {
    pub(crate) low: [i32; 3],
    pub(crate) padding: i32,
    pub(crate) texel: [i32; 3],
    pub(crate) padding_too: i32,
}

/// A vertex as `vs_polygon` takes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Corner {
    /// Lattice space.
    pub(crate) place: [f32; 3],
    pub(crate) slab: i32,
    pub(crate) box_index: u32,
}

/// The mirror of `Cull` in `cull.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Cull {
    pub(crate) whole: [u32; 4],
    pub(crate) box_size: [u32; 4],
    pub(crate) halvings: [u32; 4],
    pub(crate) brick_shift: [u32; 4],
    pub(crate) brick_count: [u32; 4],
    pub(crate) eye: [f32; 4],
    pub(crate) margin: [f32; 4],
    pub(crate) level: u32,
    pub(crate) bits: u32,
    pub(crate) plane_count: u32,
    pub(crate) block_count: u32,
    pub(crate) base: f32,
    pub(crate) most: f32,
    pub(crate) bins_per_scalar: f32,
    pub(crate) offset: f32,
    pub(crate) bins: u32,
    pub(crate) first_range: u32,
    pub(crate) padding: [u32; 2],
}

/// The mirror of `Ranges` in `ranges.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Ranges {
    pub(crate) cells: [u32; 4],
    pub(crate) box_size: [u32; 4],
    pub(crate) divisions: [u32; 4],
    pub(crate) halved: [u32; 4],
    pub(crate) first: u32,
    pub(crate) first_below: u32,
    pub(crate) reach: u32,
    pub(crate) padding: u32,
}

/// The arguments that an indexed draw takes from the device; the mirror of `Arguments` in `cull.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Arguments {
    pub(crate) index_count: u32,
    pub(crate) instance_count: u32,
    pub(crate) first_index: u32,
    pub(crate) base_vertex: i32,
    pub(crate) first_instance: u32,
}

/// The mirror of `Tables` in `box_plane.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Tables {
    pub(crate) sequence: [[u32; 8]; 8],
    pub(crate) first: [[u32; 4]; 6],
    pub(crate) second: [[u32; 4]; 6],
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::slicing::{
        CULL, RANGES, SLICE_COVERED, SLICE_DEVICE, SLICE_FILTERED, SLICE_FLOAT, SLICE_SIGNED,
        SLICE_UNSIGNED,
    };

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        assert_layout!(CULL, PlacedBox { low, texel });
        assert_layout!(
            CULL,
            Cull {
                whole,
                box_size,
                halvings,
                brick_shift,
                brick_count,
                eye,
                margin,
                level,
                bits,
                plane_count,
                block_count,
                base,
                most,
                bins_per_scalar,
                offset,
                bins,
                first_range,
            }
        );
        assert_layout!(
            RANGES,
            Ranges {
                cells,
                box_size,
                divisions,
                halved,
                first,
                first_below,
                reach,
            }
        );
        assert_layout!(
            CULL,
            Arguments {
                index_count,
                instance_count,
                first_index,
                base_vertex,
                first_instance
            }
        );
        let programs = [
            SLICE_FLOAT,
            SLICE_UNSIGNED,
            SLICE_SIGNED,
            SLICE_FILTERED,
            SLICE_DEVICE,
            SLICE_COVERED,
        ];
        for program in programs {
            assert_layout!(
                program,
                CameraUniform {
                    right,
                    up,
                    forward,
                    origin,
                    origin_x,
                    origin_y,
                    along,
                    along_x,
                    along_y,
                    cells,
                    box_size,
                    margin,
                    inverse_spacing,
                    slope,
                    clip_per_unit,
                    size,
                    anchor_depth,
                    w_per_depth,
                    w_constant,
                    near,
                    first_depth,
                    step,
                    slab_count,
                    slabs_per_box,
                    front,
                    scalar_unit,
                    scalar_base,
                    raw_unit,
                    raw_base,
                    raw_most,
                    slabs_per_run,
                    run_count,
                }
            );
            assert_layout!(program, PlacedBox { low, texel });
            assert_layout!(
                program,
                Tables {
                    sequence,
                    first,
                    second
                }
            );
        }
    }
}
