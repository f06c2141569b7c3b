//! `repr(C)` mirrors of the structs in `rays.wgsl` and `tally.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::options::MAX_TILES;

/// `CameraUniform`: what all passes of a frame know.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct CameraUniform {
    /// From normalized space; columns.
    pub(super) clip: [[f32; 4]; 4],
    /// The anchor of pixel (0, 0), normalized; w is unused.
    pub(super) anchor: [f32; 4],
    /// From a pixel to its right neighbor.
    pub(super) anchor_x: [f32; 4],
    /// From a pixel to the one below.
    pub(super) anchor_y: [f32; 4],
    /// The eye with w = 1, or the common direction with w = 0.
    pub(super) eye: [f32; 4],
    /// (t_u, t_v, 0, scalar) of the cell with the eye in it.
    pub(super) inside: [f32; 4],
    /// λ of the camera's plane; orthographic only.
    pub(super) eye_depth: f32,
    /// By which a layer must be behind the one before, normalized.
    pub(super) bias: f32,
    /// The opacity at which a ray is done.
    pub(super) stop_opacity: f32,
    /// 1 if rays by sides may come in behind the eye.
    pub(super) starts_behind: u32,
    /// Span of the table of integrals.
    pub(super) table_span: [f32; 4],
}

/// The most tiles of an image.
pub(super) const TILES: usize = (MAX_TILES * MAX_TILES) as usize;

/// `Tally`: how many rays a layer lost.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Tally {
    /// Tiles a side; the others are unused.
    pub(super) tiles: [u32; 4],
    pub(super) lost: u32,
    /// Whether each tile was drawn, row by row.
    pub(super) drawn: [u32; TILES],
    /// Room that WGSL leaves, as `tiles` is aligned to 16 bytes.
    pub(super) padding: [u32; 3],
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::{assert_layout, ping_pong};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        assert_layout!(
            ping_pong::ENTRY,
            CameraUniform {
                clip,
                anchor,
                anchor_x,
                anchor_y,
                eye,
                inside,
                eye_depth,
                bias,
                stop_opacity,
                starts_behind,
                table_span
            }
        );
        // `padding` is at the end, where WGSL rounds the size up.
        assert_layout!(ping_pong::TALLY, Tally { tiles, lost, drawn });
    }
}
