//! The light that a ray has gathered.

use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::{CompensatedSum, over};
use tetrascope_core::{OpticalModel, View};

/// Light and optical depth of a ray so far, front to back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gathered {
    /// ∫ c σ T dt (T = 1 in `Emission`), the greatest c in `MaximumIntensity`, or a surface's.
    pub(crate) light: DVec3,
    /// ∫ σ dt, infinite at a surface.
    pub(crate) depth: CompensatedSum,
}

/// A pixel and how far along its ray its surface is.
pub(crate) type Pixel = ([f32; 4], f32);

/// The results of rays where they end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Finish {
    pub(crate) model: OpticalModel,
    /// Premultiplied.
    background: [f64; 4],
}

impl Finish {
    pub(crate) fn new(model: OpticalModel, view: &View) -> Finish {
        Finish {
            model,
            background: view.premultiplied_background(),
        }
    }

    pub(crate) fn pixel(&self, light: DVec3, depth: f64) -> [f32; 4] {
        over(self.model, light, depth, self.background).map(|channel| channel as f32)
    }
}
