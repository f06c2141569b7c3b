//! The camera, made in f64 and rounded at the end.

use bytemuck::{Pod, Zeroable};
use tetrascope_core::glam::DVec3;
use tetrascope_core::{Bounds, Error, View};
use tetrascope_f32::{ImagePlane, Normalization};

use super::scene::Mesh;
use crate::NAME;

/// The mirror of `CameraUniform` in `mesh_slices/frame.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(crate) struct CameraUniform {
    pub(crate) right: [f32; 4],
    pub(crate) up: [f32; 4],
    pub(crate) forward: [f32; 4],
    pub(crate) extent: [f32; 2],
    pub(crate) slope: [f32; 2],
    pub(crate) size: [f32; 2],
    pub(crate) inverse_anchor_depth: f32,
    pub(crate) first_depth: f32,
    pub(crate) step: f32,
    pub(crate) plane_count: u32,
    pub(crate) cell_count: u32,
    pub(crate) padding: u32,
}

/// How near to the eye the mesh's box may be, as a share of its depth: 2⁻¹⁰. What is nearer is seen
/// so much larger that floats run out of digits.
const NEAREST: f64 = 1.0 / (1 << 10) as f64;

/// The uniform for `view`.
///
/// # Errors
/// [`Error::Unsupported`] where the mesh reaches behind the eye.
pub(super) fn frame(
    view: &View,
    plane: &ImagePlane,
    mesh: &Mesh,
    planes: u32,
) -> Result<CameraUniform, Error> {
    let [first, last] = depths(plane, &mesh.mesh.bounds(), &mesh.normalization)?;
    let row = |axis: DVec3| {
        let [x, y, z] = axis.as_vec3().to_array();
        [x, y, z, -plane.anchor.dot(axis) as f32]
    };
    let single = |pair: [f64; 2]| pair.map(|x| x as f32);
    Ok(CameraUniform {
        right: row(plane.right),
        up: row(plane.up),
        forward: row(plane.forward),
        extent: single(plane.extent),
        slope: single(plane.slope),
        size: [view.width as f32, view.height as f32],
        inverse_anchor_depth: match plane.is_perspective {
            true => plane.anchor_depth.recip() as f32,
            false => 0.0,
        },
        first_depth: first as f32,
        // A mesh without depth has no volume: no plane is met, but none is at infinity.
        step: ((last - first) / f64::from(planes)).max(1e-30) as f32,
        plane_count: planes,
        cell_count: mesh.cell_count,
        padding: 0,
    })
}

/// The least and the greatest depth of a box, relative to the anchor.
///
/// # Errors
/// [`Error::Unsupported`] where it reaches behind the eye.
pub(super) fn depths(
    plane: &ImagePlane,
    bounds: &Bounds,
    normalization: &Normalization,
) -> Result<[f64; 2], Error> {
    let to_camera = plane.camera_from_normalized();
    let depth = |corner: DVec3| {
        let corner = normalization.point(corner);
        to_camera.transform_point3(corner).z
    };
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in 0..8 {
        let high = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
        let pick = |axis: usize| [bounds.min, bounds.max][usize::from(high[axis])][axis];
        let depth = depth(DVec3::new(pick(0), pick(1), pick(2)));
        (first, last) = (first.min(depth), last.max(depth));
    }
    if plane.is_perspective && first + plane.anchor_depth < NEAREST * (last - first) {
        return Err(Error::Unsupported {
            renderer: NAME,
            what: "an eye inside of the mesh's box, or beside it".into(),
            reason: "a cell is seen as triangles only in front of the eye".into(),
        });
    }
    Ok([first, last])
}
