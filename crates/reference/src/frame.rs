//! The camera's frame, in which a ray is a pair of numbers.

use rayon::prelude::*;
use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::{Error, Projection, Ray, TetMesh, View};

use crate::geometry::{Geometry, Plane};
use crate::predicate::power_of_two;
use crate::trace::no_ray;

/// Coordinates (x right, y up, z forward) from the eye.
///
/// All rays of an image, or one ray alone, are q + z d with d = (p, 1) and q = 0
/// in perspective, and d = (0, 0, 1) and q = (p, 0) in an orthographic view; the
/// position p in the image plane tells them apart.
///
/// The unit of length is a power of two that makes the farthest vertex less than
/// 1 from the eye: scaling a scene by a power of two changes no bit, and no
/// product under- or overflows however large or small the scene.
pub(crate) struct RayFrame {
    eye: DVec3,
    /// Right, up, forward: orthonormal to rounding, world space.
    axes: [DVec3; 3],
    /// World units in one unit of this frame.
    pub(crate) scale: f64,
    pub(crate) perspective: bool,
}

/// How the pixels of a view lie in the image plane of its [`RayFrame`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelGrid {
    width: u32,
    height: u32,
    /// The image plane's half sizes.
    half: DVec2,
}

impl RayFrame {
    /// The frame of a view's camera, and its pixels.
    pub(crate) fn of_view(
        view: &View,
        geometry: &Geometry,
    ) -> Result<(RayFrame, PixelGrid), Error> {
        let camera = &view.camera;
        let axes = camera.axes().into();
        let aspect = f64::from(view.width) / f64::from(view.height);
        let (perspective, half) = match camera.projection {
            Projection::Perspective { view_angle } => (true, (view_angle.to_radians() / 2.0).tan()),
            Projection::Orthographic { parallel_scale } => (false, parallel_scale),
        };
        let frame = RayFrame::new(camera.position, axes, perspective, geometry)?;
        let unit = if perspective { 1.0 } else { frame.scale };
        let grid = PixelGrid {
            width: view.width,
            height: view.height,
            half: DVec2::new(aspect * half, half) / unit,
        };
        Ok((frame, grid))
    }

    /// A frame in which `ray` has the position 0.
    pub(crate) fn of_ray(ray: &Ray, geometry: &Geometry) -> Result<RayFrame, Error> {
        let forward = ray.direction.normalize_or_zero();
        if !ray.origin.is_finite() || forward == DVec3::ZERO {
            return Err(no_ray());
        }
        let (right, up) = forward.any_orthonormal_pair();
        RayFrame::new(ray.origin, [right, up, forward], true, geometry)
    }

    fn new(
        eye: DVec3,
        axes: [DVec3; 3],
        perspective: bool,
        geometry: &Geometry,
    ) -> Result<RayFrame, Error> {
        let farthest = (geometry.center - eye).length() + geometry.radius;
        if farthest.is_nan() || farthest > f64::MAX / 16.0 {
            return Err(Error::Invalid {
                what: format!("the camera is {farthest:e} away from the mesh"),
                help: Some("move it closer".into()),
            });
        }
        Ok(RayFrame {
            eye,
            axes,
            scale: 2.0 * power_of_two(farthest),
            perspective,
        })
    }

    /// World space.
    pub(crate) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The unit vector along z, world space.
    pub(crate) fn forward(&self) -> DVec3 {
        self.axes[2]
    }

    /// A direction of world space in this frame, of the same length.
    pub(crate) fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::from_array(self.axes.map(|axis| axis.dot(v)))
    }

    /// The ray at `p`, q + z d, in this frame.
    pub(crate) fn line(&self, p: DVec2) -> (DVec3, DVec3) {
        match self.perspective {
            true => (DVec3::ZERO, p.extend(1.0)),
            false => (p.extend(0.0), DVec3::Z),
        }
    }

    /// The direction of the ray at `p`, world space, of any length.
    pub(crate) fn direction(&self, p: DVec2) -> DVec3 {
        let [right, up, forward] = self.axes;
        match self.perspective {
            true => p.x * right + p.y * up + forward,
            false => forward,
        }
    }

    /// A position of world space in this frame.
    pub(crate) fn position(&self, p: DVec3) -> DVec3 {
        let p = (p - self.eye) / self.scale;
        DVec3::from_array(self.axes.map(|axis| axis.dot(p)))
    }

    /// Positions of all points of `mesh`.
    pub(crate) fn positions(&self, mesh: &TetMesh) -> Vec<DVec3> {
        let points = mesh.points().par_iter();
        points.map(|&p| self.position(p)).collect()
    }

    /// World units in a unit of z along the ray at `p`.
    pub(crate) fn length_per_z(&self, p: DVec2) -> f64 {
        match self.perspective {
            true => self.scale * p.extend(1.0).length(),
            false => self.scale,
        }
    }

    /// Planes around all rays with positions from `min` to `max`, and before the eye.
    pub(crate) fn planes(&self, geometry: &Geometry, min: DVec2, max: DVec2) -> [Plane; 5] {
        let [right, up, forward] = self.axes;
        let side = |axis: DVec3, p: f64, sign: f64| match self.perspective {
            true => geometry.plane(sign * (axis - p * forward), self.eye, 0.0),
            false => geometry.plane(sign * axis, self.eye, -sign * p * self.scale),
        };
        [
            side(right, min.x, 1.0),
            side(right, max.x, -1.0),
            side(up, min.y, 1.0),
            side(up, max.y, -1.0),
            geometry.plane(forward, self.eye, 0.0),
        ]
    }
}

impl PixelGrid {
    /// The position of the center of column `column` in the image plane.
    pub(crate) fn x(&self, column: f64) -> f64 {
        (2.0 * (column + 0.5) / f64::from(self.width) - 1.0) * self.half.x
    }

    /// The position of the center of row `row`, row 0 at the top.
    pub(crate) fn y(&self, row: f64) -> f64 {
        (1.0 - 2.0 * (row + 0.5) / f64::from(self.height)) * self.half.y
    }

    /// The column whose center is at `x`, fractional; the inverse of [`PixelGrid::x`].
    pub(crate) fn column(&self, x: f64) -> f64 {
        (x / self.half.x + 1.0) * 0.5 * f64::from(self.width) - 0.5
    }

    /// The row whose center is at `y`, fractional; the inverse of [`PixelGrid::y`].
    pub(crate) fn row(&self, y: f64) -> f64 {
        (1.0 - y / self.half.y) * 0.5 * f64::from(self.height) - 0.5
    }
}
