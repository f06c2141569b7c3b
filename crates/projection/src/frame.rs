//! The camera in coordinates that stay small, made in f64 and rounded at the end.

use tetrascope_core::glam::{DAffine3, DMat3, DVec3};
use tetrascope_core::{Projection, View};
use tetrascope_f32::Normalization;

use crate::gpu_data::Frame;

/// The near plane, in normalized units: what a ray passes before it is lost in
/// cells around the eye. A cell that small is below f32's resolution of the mesh.
const NEAR: f32 = 1.0 / (1 << 22) as f32;

/// Radius of the ball around the cube [−1, 1]³ that holds the mesh.
const RADIUS: f64 = 1.7320508075688772;

/// Steps of a sort key.
const KEYS: f64 = (1 << KEY_BITS) as f64;

/// Bits of a sort key; f32 holds no more of a distance.
pub(crate) const KEY_BITS: u32 = 24;

/// Where the camera is among normalized positions.
pub(crate) struct CameraSpace {
    /// To camera space, see `frame.wgsl`.
    pub(crate) from_normalized: DAffine3,
    /// From the eye to the anchor along the axis, normalized.
    pub(crate) anchor_depth: f64,
}

/// The camera space of `view`, which must be valid.
pub(crate) fn camera_space(view: &View, normalization: &Normalization) -> CameraSpace {
    let (right, up, forward) = view.camera.axes();
    let eye = normalization.point(view.camera.position);
    // The mesh's center is the origin; beside it or, if it is behind, at the eye.
    let anchor_depth = (-eye.dot(forward)).max(0.0);
    let anchor = eye + anchor_depth * forward;
    let axes = DMat3::from_cols(right, up, forward).transpose();
    CameraSpace {
        from_normalized: DAffine3::from_mat3_translation(axes, -(axes * anchor)),
        anchor_depth,
    }
}

/// How far along their rays the depths `along` of an image are, world units, infinite
/// where `there` says that there is none.
pub(crate) fn along_rays(
    view: &View,
    normalization: &Normalization,
    along: &[f32],
    there: impl Fn(usize) -> bool,
) -> Vec<f32> {
    let anchor_depth = camera_space(view, normalization).anchor_depth;
    let (width, height) = (f64::from(view.width), f64::from(view.height));
    let reach = match view.camera.projection {
        Projection::Perspective { view_angle } => (view_angle.to_radians() / 2.0).tan(),
        Projection::Orthographic { .. } => 0.0,
    };
    let depth = |(i, along): (usize, &f32)| {
        if !there(i) {
            return f32::INFINITY;
        }
        let (column, row) = (i % view.width as usize, i / view.width as usize);
        let x = (2.0 * (column as f64 + 0.5) / width - 1.0) * width / height;
        let y = 2.0 * (row as f64 + 0.5) / height - 1.0;
        let per_depth = (1.0 + reach * reach * (x * x + y * y)).sqrt();
        ((f64::from(*along) + anchor_depth) * per_depth * normalization.scale) as f32
    };
    along.iter().enumerate().map(depth).collect()
}

/// The uniform of `frame.wgsl` for `view`, which must be valid.
pub(crate) fn frame(
    view: &View,
    normalization: &Normalization,
    cell_count: u32,
    scalars_per_cell: bool,
) -> Frame {
    let camera = &view.camera;
    let (right, up, forward) = camera.axes();
    let eye = normalization.point(camera.position);
    let anchor_depth = camera_space(view, normalization).anchor_depth;
    let anchor = eye + anchor_depth * forward;
    let row = |axis: DVec3| {
        let [x, y, z] = axis.as_vec3().to_array();
        [x, y, z, -anchor.dot(axis) as f32]
    };
    let aspect = f64::from(view.width) / f64::from(view.height);
    let (reach, perspective) = match camera.projection {
        Projection::Perspective { view_angle } => ((view_angle.to_radians() / 2.0).tan(), true),
        Projection::Orthographic { parallel_scale } => {
            (parallel_scale / normalization.scale, false)
        }
    };
    let reach = [reach * aspect, reach];
    let single = |pair: [f64; 2]| pair.map(|x| x as f32);
    // The range of what order.wgsl computes for centroids in the ball.
    let middle = anchor.length();
    let (nearest, farthest) = if perspective {
        let most = middle + RADIUS;
        let square = anchor_depth * anchor_depth;
        (
            (-square).max(-2.0 * anchor_depth * most),
            2.0 * anchor_depth * most + most * most,
        )
    } else {
        (-middle - RADIUS, middle + RADIUS)
    };
    Frame {
        right: row(right),
        up: row(up),
        forward: row(forward),
        extent: if perspective {
            single(reach.map(|r| r * anchor_depth))
        } else {
            single(reach)
        },
        slope: if perspective { single(reach) } else { [0.0; 2] },
        clip_per_unit: single(reach.map(f64::recip)),
        size: [view.width as f32, view.height as f32],
        anchor_depth: anchor_depth as f32,
        w_per_depth: f32::from(perspective),
        w_constant: f32::from(!perspective),
        // Orthographic: anything below w, as nothing is to be clipped.
        near: if perspective { NEAR } else { 0.5 },
        far_key: farthest as f32,
        key_scale: (KEYS / (farthest - nearest)) as f32,
        cell_count,
        scalars_per_cell: scalars_per_cell.into(),
    }
}
