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

/// The mirror of `Element` in `element.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct Element {
    pub(crate) center: [f32; 2],
    pub(crate) scale: f32,
    pub(crate) fan: u32,
    pub(crate) front: [f32; 2],
    pub(crate) back: [f32; 2],
    pub(crate) range: [f32; 2],
}

/// The mirror of `Step` in `element.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Step {
    pub(crate) first: i32,
    pub(crate) end: i32,
    pub(crate) slab: u32,
    pub(crate) padding: u32,
}

/// The mirror of `Draw` in `active.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Draw {
    pub(crate) vertices: u32,
    pub(crate) elements: u32,
    pub(crate) first_vertex: u32,
    pub(crate) first_instance: u32,
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::resample::{ACTIVE, ELEMENTS, FILL, FILL_COUNTED, SECTION};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        for program in [FILL, FILL_COUNTED, ELEMENTS, SECTION] {
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
        for program in [ELEMENTS, ACTIVE, SECTION] {
            assert_layout!(
                program,
                Element {
                    center,
                    scale,
                    fan,
                    front,
                    back,
                    range
                }
            );
        }
        for program in [ACTIVE, SECTION] {
            assert_layout!(
                program,
                Step {
                    first,
                    end,
                    slab,
                    padding
                }
            );
        }
        assert_layout!(
            ACTIVE,
            Draw {
                vertices,
                elements,
                first_vertex,
                first_instance
            }
        );
    }
}
