//! `repr(C)` mirrors of WGSL structs.

use bytemuck::{Pod, Zeroable};

/// The mirror of `CameraUniform` in `frame.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct CameraUniform {
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
    pub(crate) scalar_range: [f32; 2],
    pub(crate) unused: [u32; 2],
}

/// The mirror of `Tile` in `fragments.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Tile {
    pub(crate) origin: [u32; 2],
    pub(crate) width: u32,
    pub(crate) capacity: u32,
    pub(crate) turn: u32,
    pub(crate) turns: u32,
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::projection::{CELL, COMPOSITE, FILL, ORDER, SURFACE};

    use super::*;
    use crate::passes::lists::{FRAGMENT_BYTES, STATE_BYTES};

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        for program in [ORDER, CELL, FILL, SURFACE] {
            assert_layout!(
                program,
                CameraUniform {
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
                    scalar_range,
                }
            );
        }
        assert_layout!(
            COMPOSITE,
            Tile {
                origin,
                width,
                capacity,
                turn,
                turns
            }
        );
    }

    #[test]
    fn a_fragment_has_the_size_that_lists_count_on() {
        struct Fragment {
            red: f32,
            green: f32,
            blue: f32,
            optical_depth: f32,
            depth: f32,
            next: u32,
            run: u32,
        }
        assert_layout!(
            COMPOSITE,
            Fragment {
                red,
                green,
                blue,
                optical_depth,
                depth,
                next,
                run
            }
        );
        assert_eq!(size_of::<Fragment>() as u64, FRAGMENT_BYTES);
        struct State {
            a: u32,
            b: u32,
            head: u32,
            tail: u32,
            front: u32,
            out: u32,
            red: f32,
            green: f32,
            blue: f32,
            optical_depth: f32,
            red_aside: f32,
            green_aside: f32,
            blue_aside: f32,
            depth_aside: f32,
            added: u32,
        }
        assert_layout!(
            COMPOSITE,
            State {
                a,
                b,
                head,
                tail,
                front,
                out,
                red,
                green,
                blue,
                optical_depth,
                red_aside,
                green_aside,
                blue_aside,
                depth_aside,
                added
            }
        );
        assert_eq!(size_of::<State>() as u64, STATE_BYTES);
    }
}
