//! `repr(C)` mirrors of WGSL structs.

use bytemuck::{Pod, Zeroable};

/// The mirror of `Frame` in `frame.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Frame {
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) forward: [f32; 4],
    pub(crate) extent: [f32; 2],
    pub(crate) slope: [f32; 2],
    pub(crate) clip_per_unit: [f32; 2],
    pub(crate) size: [f32; 2],
    pub(crate) anchor_depth: f32,
    pub(crate) w_per_depth: f32,
    pub(crate) w_constant: f32,
    pub(crate) near: f32,
    pub(crate) far_key: f32,
    pub(crate) key_scale: f32,
    pub(crate) cell_count: u32,
    pub(crate) scalars_per_cell: u32,
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::projection::{CELL, ORDER};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        for program in [ORDER, CELL] {
            assert_layout!(
                program,
                Frame {
                    right,
                    up,
                    forward,
                    extent,
                    slope,
                    clip_per_unit,
                    size,
                    anchor_depth,
                    w_per_depth,
                    w_constant,
                    near,
                    far_key,
                    key_scale,
                    cell_count,
                    scalars_per_cell,
                }
            );
        }
    }
}
