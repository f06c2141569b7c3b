//! `repr(C)` mirrors of WGSL structs.

use bytemuck::{Pod, Zeroable};

/// The mirror of `Vertex` in `mesh.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Vertex {
    pub(crate) sample: [f32; 3],
    pub(crate) key: u32,
    pub(crate) offset: [f32; 3],
    pub(crate) scalar: f32,
}

/// The mirror of `Work` in `mesh.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Work {
    pub(crate) low: [i32; 2],
    pub(crate) high: [i32; 2],
    pub(crate) first: i32,
    pub(crate) end: i32,
    pub(crate) cell_count: u32,
    pub(crate) small: u32,
    pub(crate) along: [i32; 3],
    pub(crate) flipped: u32,
    pub(crate) across_x: [i32; 3],
    pub(crate) padding: u32,
    pub(crate) across_y: [i32; 3],
    pub(crate) padding_too: u32,
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::resample::{FILL, FILL_COUNTED};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        for program in [FILL, FILL_COUNTED] {
            assert_layout!(
                program,
                Vertex {
                    sample,
                    key,
                    offset,
                    scalar
                }
            );
            assert_layout!(
                program,
                Work {
                    low,
                    high,
                    first,
                    end,
                    cell_count,
                    small,
                    along,
                    flipped,
                    across_x,
                    across_y,
                }
            );
        }
    }
}
