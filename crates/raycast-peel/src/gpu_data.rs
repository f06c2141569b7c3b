//! `repr(C)` mirrors of the structs in `rays.wgsl` and `march.wgsl`.

use bytemuck::{Pod, Zeroable};
use tetrascope_gpu::wgpu;

/// One instance per rectangle of [`rectangles`](tetrascope_f32::tiles::rectangles).
pub(crate) const RECTANGLES: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 16,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![0 => Float32x4],
};

/// `March`: what changes every frame.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct March {
    /// The anchor of pixel (0, 0), normalized; w is unused.
    pub(crate) anchor: [f32; 4],
    /// From a pixel to its right neighbor.
    pub(crate) anchor_x: [f32; 4],
    /// From a pixel to the one below.
    pub(crate) anchor_y: [f32; 4],
    /// The eye with w = 1, or the common direction with w = 0.
    pub(crate) eye: [f32; 4],
    /// Direction of the camera, a unit vector; w is unused.
    pub(crate) forward: [f32; 4],
    /// t of the camera's plane from the anchors' plane; orthographic only.
    pub(crate) eye_depth: f32,
    pub(crate) width: u32,
    pub(crate) height: u32,
    /// Tiles a row.
    pub(crate) tiles_x: u32,
    /// The optical depth beyond which a ray stops.
    pub(crate) stop_depth: f32,
    pub(crate) unused: f32,
    /// Layers of the boundary that were peeled.
    pub(crate) layers: u32,
    /// A ray in this many layers may be in more, and searches lists.
    pub(crate) listed_from: u32,
}

/// `Counters`: what a frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Counters {
    /// Cells passed, the lower 32 bits.
    pub(crate) cell_visits_low: u32,
    /// And the upper.
    pub(crate) cell_visits_high: u32,
    /// Paths through the mesh.
    pub(crate) paths: u32,
    /// Rays that cross the boundary an odd number of times.
    pub(crate) unpaired_faces: u32,
    /// Rays that came out through a face that they do not cross.
    pub(crate) lost_rays: u32,
    /// Rays that are not done.
    pub(crate) rays_left: u32,
}

/// `Progress`: what differs between the dispatches of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Progress {
    /// Work groups of the next dispatch: as many as of this one, or none.
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    pub(crate) slices: u32,
    /// Rays that are not done.
    pub(crate) rays_left: u32,
    /// 1 if rays are in `states` already.
    pub(crate) goes_on: u32,
    /// 1 if no dispatch follows: then the rays left are among what the frame counts.
    pub(crate) is_last: u32,
    /// First row of pixels.
    pub(crate) first_row: u32,
}

/// `State`: a ray between two dispatches. Only shaders know what is in it.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct State {
    gathered: [f32; 4],
    aside: [f32; 4],
    before: [f32; 4],
    near: [f32; 4],
    ids: [u32; 4],
    path: [u32; 4],
    piece: [f32; 4],
    rest: [f32; 4],
    before_step: [f32; 4],
    crossed: [u32; 4],
    exits: [u32; 4],
    t: [f32; 4],
    face: [u32; 4],
    more_t: [f32; 4],
    more_face: [u32; 4],
    search: [u32; 4],
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::{assert_layout, raycast_peel::MARCH};

    use super::*;

    #[test]
    fn structs_have_the_layout_of_their_twins() {
        assert_layout!(
            MARCH,
            March {
                anchor,
                anchor_x,
                anchor_y,
                eye,
                forward,
                eye_depth,
                width,
                height,
                tiles_x,
                stop_depth,
                unused,
                layers,
                listed_from
            }
        );
        assert_layout!(
            MARCH,
            Counters {
                cell_visits_low,
                cell_visits_high,
                paths,
                unpaired_faces,
                lost_rays,
                rays_left
            }
        );
        assert_layout!(
            MARCH,
            Progress {
                columns,
                rows,
                slices,
                rays_left,
                goes_on,
                is_last,
                first_row
            }
        );
        assert_layout!(
            MARCH,
            State {
                gathered,
                aside,
                before,
                near,
                ids,
                path,
                piece,
                rest,
                before_step,
                crossed,
                exits,
                t,
                face,
                more_t,
                more_face,
                search
            }
        );
    }
}
