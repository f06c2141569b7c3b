//! The stack of a view, and the camera in it, made in f64 and rounded at the end.

use bytemuck::{Pod, Zeroable};
use tetrascope_core::View;
use tetrascope_core::glam::{DVec3, DVec4};
use tetrascope_core::grid::Lattice;
use tetrascope_f32::{ImagePlane, Normalization};

use super::volume::axes;

/// The mirror of `CameraUniform` in `stacks/frame.wgsl`, where each field is explained.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct CameraUniform {
    pub(super) right: [f32; 4],
    pub(super) up: [f32; 4],
    pub(super) forward: [f32; 4],
    pub(super) origin: [f32; 4],
    pub(super) origin_x: [f32; 4],
    pub(super) origin_y: [f32; 4],
    pub(super) along: [f32; 4],
    pub(super) along_x: [f32; 4],
    pub(super) along_y: [f32; 4],
    pub(super) cells: [f32; 4],
    pub(super) extent: [f32; 2],
    pub(super) slope: [f32; 2],
    pub(super) inverse_reach: [f32; 2],
    pub(super) size: [f32; 2],
    pub(super) anchor_depth: f32,
    pub(super) w_per_depth: f32,
    pub(super) w_constant: f32,
    pub(super) ahead: i32,
    pub(super) rectangle_count: i32,
    pub(super) raw_unit: f32,
    pub(super) raw_base: f32,
    pub(super) raw_most: f32,
}

/// Scalars are clamped here, where any transfer function is constant; sums of a few are finite.
const MOST: f32 = 1e20;

/// With more cells between two planes along another axis, a frame says so.
const MANY_CELLS: f64 = 8.0;

/// A stack as a view sees it.
#[derive(Clone, Debug)]
pub(super) struct Stacked {
    /// Along which layers follow each other.
    pub(super) axis: usize,
    pub(super) uniform: CameraUniform,
    /// The most cells along another axis that a ray of the image passes from plane to plane;
    /// infinite if rays go along the planes.
    cells_per_plane: f64,
}

/// The axis of `lattice` that is most nearly along the view's optical axis.
fn axis_of(view: &View, lattice: &Lattice) -> usize {
    let (_, _, forward) = view.camera.axes();
    let along = (lattice.direction.transpose() * forward).abs();
    [0, 1, 2]
        .into_iter()
        .max_by(|&a, &b| along[a].total_cmp(&along[b]))
        .expect("there are three")
}

impl Stacked {
    /// The stack for `view`, which must be valid: of slabs between planes, or of planes.
    pub(super) fn new(
        view: &View,
        plane: &ImagePlane,
        lattice: &Lattice,
        normalization: &Normalization,
        is_slabs: bool,
    ) -> Stacked {
        let axis = axis_of(view, lattice);
        let turned = |v: DVec3| DVec3::from_array(axes(axis).map(|axis| v[axis]));
        let camera = plane.camera_from_normalized();
        let linear = camera.matrix3 * lattice.linear() * normalization.scale.recip();
        let shift = camera.matrix3 * (normalization.point(lattice.origin) - plane.anchor);
        let inverse = linear.inverse();
        // The ray at (x, y) is origin + x … + y … + depth (along + x … + y …).
        let origin = turned(inverse * -shift);
        let [x, y, along] = [inverse.x_axis, inverse.y_axis, inverse.z_axis].map(turned);
        let [along_x, along_y] = [x * plane.slope[0], y * plane.slope[1]];
        let cells = turned(DVec3::from_array(lattice.cells().map(|cells| cells as f64)));

        let count = cells.z as i32 + i32::from(!is_slabs);
        let eye = origin.z - plane.anchor_depth * along.z;
        // Those that begin before the eye, or at it, are behind it for rays that go up the stack.
        let behind = match plane.is_perspective {
            true => (eye.floor() + 1.0).clamp(0.0, count.into()) as i32,
            false if along.z > 0.0 => 0,
            false => count,
        };
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| along + x * along_x + y * along_y);
        let rises = corners.map(|along| along.z);
        let is_along = rises.iter().any(|rise| rise * rises[0] <= 0.0);
        let aside = corners.map(|along| along.x.abs().max(along.y.abs()) / along.z.abs());
        let cells_per_plane = match is_along {
            true => f64::INFINITY,
            false => aside.into_iter().fold(0.0, f64::max),
        };

        let row = |i: usize| {
            let row: DVec4 = turned(linear.row(i)).extend(shift[i]);
            row.as_vec4().to_array()
        };
        let vector = |v: DVec3| v.extend(0.0).as_vec4().to_array();
        let pair = |pair: [f64; 2]| pair.map(|x| x as f32);
        Stacked {
            axis,
            cells_per_plane,
            uniform: CameraUniform {
                right: row(0),
                up: row(1),
                forward: row(2),
                origin: vector(origin),
                origin_x: vector(x * plane.extent[0]),
                origin_y: vector(y * plane.extent[1]),
                along: vector(along),
                along_x: vector(along_x),
                along_y: vector(along_y),
                cells: vector(cells),
                extent: pair(plane.extent),
                slope: pair(plane.slope),
                inverse_reach: pair(plane.reach.map(f64::recip)),
                size: [view.width as f32, view.height as f32],
                anchor_depth: plane.anchor_depth as f32,
                w_per_depth: f32::from(u8::from(plane.is_perspective)),
                w_constant: f32::from(u8::from(!plane.is_perspective)),
                ahead: count - behind,
                rectangle_count: count,
                raw_unit: 1.0,
                raw_base: 0.0,
                raw_most: f32::MAX,
            },
        }
    }

    /// With what takes samples to the transfer function's unit.
    pub(super) fn with_scale(mut self, base: f32, unit: f32) -> Stacked {
        let uniform = &mut self.uniform;
        (uniform.raw_base, uniform.raw_unit) = (base, unit);
        uniform.raw_most = (MOST / unit).min(f32::MAX);
        self
    }

    /// A sentence about rays that planes serve badly, if there are any.
    pub(super) fn note(&self) -> Option<String> {
        (self.cells_per_plane > MANY_CELLS).then(|| {
            let passed = match self.cells_per_plane.is_finite() {
                true => format!("{:.0} cells", self.cells_per_plane),
                false => "any number of cells".into(),
            };
            format!(
                "rays at the border of the image pass {passed} between two planes of samples, where \
                 scalars are taken to be linear"
            )
        })
    }
}
