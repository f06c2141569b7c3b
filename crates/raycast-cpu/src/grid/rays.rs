//! The rays of a view in the space of a grid's cells.

use tetrascope_core::Unit as _;
use tetrascope_core::appearance::{CueRamp, clip_ray};
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::{Appearance, ClipPlane, Grid, Projection, Ray, View};

use super::walk::Line;

/// The rays of all pixels of a view.
#[derive(Clone, Debug)]
pub(crate) struct Rays<'a> {
    view: View,
    /// Pixels per row, rows, and what one pixel is along the image's axes: the direction of a
    /// ray before it is normalized, or how far its origin moves.
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    turn: DMat3,
    grid_origin: DVec3,
    spacing: DVec3,
    first: f64,
    planes: &'a [ClipPlane],
    /// Depth cue as a function of depth along `forward`.
    cue: Option<CueRamp>,
    ends: Option<&'a [f64]>,
}

/// The ray of a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PixelRay {
    /// World space.
    pub(crate) direction: DVec3,
    /// In cells.
    pub(crate) line: Line,
    /// The stretch that nothing cuts away, world units.
    pub(crate) kept: [f64; 2],
    /// Depth cue as a function of the distance along the ray.
    pub(crate) cue: Option<CueRamp>,
}

impl<'a> Rays<'a> {
    pub(crate) fn new(
        view: &View,
        grid: &Grid,
        turn: DMat3,
        appearance: &'a Appearance,
        ends: Option<&'a [f64]>,
    ) -> Rays<'a> {
        let (right, up, forward) = view.camera.axes();
        let aspect = f64::from(view.width) / f64::from(view.height);
        let half = match view.camera.projection {
            Projection::Perspective { view_angle } => (view_angle.to_radians() / 2.0).tan(),
            Projection::Orthographic { parallel_scale } => parallel_scale,
        };
        let eye = view.camera.position;
        let ramp = |cue: tetrascope_core::DepthCue| cue.ramp(eye, forward, &grid.bounds());
        Rays {
            view: *view,
            right: right * (aspect * half),
            up: up * half,
            forward,
            turn,
            grid_origin: grid.origin(),
            spacing: grid.spacing(),
            first: grid.lattice().first(),
            planes: &appearance.clip_planes,
            cue: appearance.depth_cue.map(ramp),
            ends,
        }
    }

    /// The camera's view direction.
    pub(crate) fn forward(&self) -> DVec3 {
        self.forward
    }

    /// Whether light fades with depth.
    pub(crate) fn is_cued(&self) -> bool {
        self.cue.is_some()
    }

    /// The ray through the center of a pixel, as [`View::ray`] has it.
    #[inline(always)]
    pub(crate) fn ray(&self, column: u32, row: u32) -> PixelRay {
        let View { width, height, .. } = self.view;
        let x = 2.0 * (f64::from(column) + 0.5) / f64::from(width) - 1.0;
        let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(height);
        let eye = self.view.camera.position;
        let across = self.right * x + self.up * y;
        let (origin, direction) = match self.view.camera.projection {
            Projection::Perspective { .. } => (eye, (self.forward + across).unit()),
            Projection::Orthographic { .. } => (eye + across, self.forward),
        };
        let line = Line {
            origin: self.turn * (origin - self.grid_origin) / self.spacing
                - DVec3::splat(self.first),
            slope: self.turn * direction / self.spacing,
        };
        let mut kept = match self.planes.is_empty() {
            true => [0.0, f64::INFINITY],
            false => clip_ray(self.planes, &Ray { origin, direction }),
        };
        if let Some(ends) = self.ends {
            kept[1] = kept[1].min(ends[row as usize * width as usize + column as usize]);
        }
        // Rays begin in the eye's plane, so depth is proportional to the distance.
        let cosine = direction.dot(self.forward);
        let cue = self.cue.map(|ramp| CueRamp {
            slope: ramp.slope * cosine,
            ..ramp
        });
        PixelRay {
            direction,
            line,
            kept,
            cue,
        }
    }
}
