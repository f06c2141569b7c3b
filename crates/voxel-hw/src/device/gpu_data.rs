//! `repr(C)` mirrors of WGSL structs.

use bytemuck::{Pod, Zeroable};

/// The mirror of `Work` in `work.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Work {
    pub(crate) dims: [i32; 3],
    pub(crate) cell_count: u32,
    pub(crate) offset: [i32; 3],
    pub(crate) first: i32,
    pub(crate) end: i32,
    pub(crate) small: u32,
    pub(crate) flipped: u32,
    pub(crate) is_first: u32,
}

/// The mirror of `Resolve` in `resolve.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct Resolve {
    pub(crate) dims: [u32; 3],
    pub(crate) first: u32,
    pub(crate) low: f32,
    pub(crate) high: f32,
    pub(crate) steps: f32,
    pub(crate) samples: f32,
    pub(crate) across_x: [u32; 3],
    pub(crate) padding: u32,
    pub(crate) across_y: [u32; 3],
    pub(crate) padding_too: u32,
    pub(crate) along: [u32; 3],
    pub(crate) padding_behind: u32,
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::voxel_hw::{POLYHEDRA, RESOLVE, TETRAHEDRA};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        for program in [TETRAHEDRA, POLYHEDRA] {
            assert_layout!(
                program,
                Work {
                    dims,
                    cell_count,
                    offset,
                    first,
                    end,
                    small,
                    flipped,
                    is_first
                }
            );
        }
        assert_layout!(
            RESOLVE,
            Resolve {
                dims,
                first,
                low,
                high,
                steps,
                samples,
                across_x,
                across_y,
                along
            }
        );
    }
}
