//! The subject that defaults are chosen from: a volume, or a survey of several.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Bounds, Camera, CameraFit, Volume};

use crate::distribution::Distribution;

/// The facts about a volume that complete a scene for it.
pub(crate) trait Subject {
    /// The box around it.
    fn bounds(&self) -> Bounds;
    /// Three edges of the box around it, as [`Volume::box_axes`].
    fn box_axes(&self) -> [DVec3; 3];
    /// How many cells there are.
    fn cell_count(&self) -> usize;
    /// The part of the box that cells fill, as far as is known; NaN for a box without extent.
    fn filled(&self) -> f64;
    /// The least and greatest finite scalar, if there is any.
    fn scalar_range(&self) -> Option<(f64, f64)>;
    /// How the values are spread; takes time.
    fn distribution(&self) -> Distribution;
    /// The camera on the side `from` whose picture, of this width over its height, it fills.
    fn framed(&self, from: CameraFit, orthographic: bool, aspect: f64) -> Camera;
}

impl Subject for Volume {
    fn bounds(&self) -> Bounds {
        Volume::bounds(self)
    }

    fn box_axes(&self) -> [DVec3; 3] {
        Volume::box_axes(self)
    }

    fn cell_count(&self) -> usize {
        Volume::cell_count(self)
    }

    fn filled(&self) -> f64 {
        match self {
            Volume::Mesh(mesh) => {
                let [x, y, z] = mesh.bounds().size().to_array();
                mesh.volume() / x / y / z
            }
            _ => 1.0,
        }
    }

    fn scalar_range(&self) -> Option<(f64, f64)> {
        Volume::scalar_range(self)
    }

    fn distribution(&self) -> Distribution {
        Distribution::of(self)
    }

    fn framed(&self, from: CameraFit, orthographic: bool, aspect: f64) -> Camera {
        Camera::frame(self.outline(), from, orthographic, aspect)
    }
}
