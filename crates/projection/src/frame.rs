//! The camera in coordinates that stay small, made in f64 and rounded at the end.

use tetrascope_core::glam::DVec3;
use tetrascope_f32::ImagePlane;

use crate::gpu_data::CameraUniform;

/// The near plane, in normalized units: what a ray passes before it is lost in
/// cells around the eye. A cell that small is below f32's resolution of the mesh.
const NEAR: f32 = 1.0 / (1 << 22) as f32;

/// Radius of the ball around the cube [−1, 1]³ that holds the mesh.
const RADIUS: f64 = 1.7320508075688772;

/// Steps of a sort key.
const KEYS: f64 = (1 << KEY_BITS) as f64;

/// Bits of a sort key; f32 holds no more of a distance.
pub(crate) const KEY_BITS: u32 = 24;

/// The uniform of `frame.wgsl` for a picture of `size` pixels.
pub(crate) fn frame(
    plane: &ImagePlane,
    size: (u32, u32),
    cell_count: u32,
    scalars_per_cell: bool,
) -> CameraUniform {
    let ImagePlane {
        anchor,
        anchor_depth,
        is_perspective,
        ..
    } = *plane;
    let row = |axis: DVec3| {
        let [x, y, z] = axis.as_vec3().to_array();
        [x, y, z, -anchor.dot(axis) as f32]
    };
    let single = |pair: [f64; 2]| pair.map(|x| x as f32);
    // The range of what order.wgsl computes for centroids in the ball.
    let middle = anchor.length();
    let (nearest, farthest) = if is_perspective {
        let most = middle + RADIUS;
        let square = anchor_depth * anchor_depth;
        (
            (-square).max(-2.0 * anchor_depth * most),
            2.0 * anchor_depth * most + most * most,
        )
    } else {
        (-middle - RADIUS, middle + RADIUS)
    };
    CameraUniform {
        right: row(plane.right),
        up: row(plane.up),
        forward: row(plane.forward),
        extent: single(plane.extent),
        slope: single(plane.slope),
        clip_per_unit: single(plane.reach.map(f64::recip)),
        size: [size.0 as f32, size.1 as f32],
        anchor_depth: anchor_depth as f32,
        w_per_depth: f32::from(is_perspective),
        w_constant: f32::from(!is_perspective),
        // Orthographic: anything below w, as nothing is to be clipped.
        near: if is_perspective { NEAR } else { 0.5 },
        far_key: farthest as f32,
        key_scale: (KEYS / (farthest - nearest)) as f32,
        cell_count,
        scalars_per_cell: scalars_per_cell.into(),
        scalar_range: [0.0, 1.0],
        unused: [0; 2],
    }
}
