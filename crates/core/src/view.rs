//! From where, how large and before what.

use crate::{Camera, Error, Ray};

/// One picture's camera, size and background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera, world space.
    pub camera: Camera,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGBA with straight alpha.
    pub background: [f32; 4],
}

/// A transparent background.
pub const TRANSPARENT: [f32; 4] = [0.0; 4];

/// An opaque black background.
pub const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// The longest side of an image, pixels: f32 still resolves 1/256 of a pixel there.
pub const MAX_IMAGE_SIDE: u32 = 1 << 16;

/// The most pixels of an image: 4 GiB of float texels.
pub const MAX_IMAGE_PIXELS: u64 = 1 << 28;

impl View {
    /// Refuses an image without pixels or with too many, a background that is no color and a
    /// camera that looks nowhere.
    pub fn validate(&self) -> Result<(), Error> {
        let side = 1..=MAX_IMAGE_SIDE;
        if !side.contains(&self.width) || !side.contains(&self.height) {
            return Err(Error::Invalid {
                what: format!("an image of {}x{} pixels", self.width, self.height),
                help: Some(format!(
                    "give 1 to {MAX_IMAGE_SIDE} pixels a side, for example --size 512x512"
                )),
            });
        }
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > MAX_IMAGE_PIXELS {
            return Err(Error::Invalid {
                what: format!(
                    "an image of {pixels} pixels, {}x{}",
                    self.width, self.height
                ),
                help: Some(format!("at most {MAX_IMAGE_PIXELS} pixels, as 16384x16384")),
            });
        }
        if self
            .background
            .iter()
            .any(|c| !(c.is_finite() && *c >= 0.0))
            || self.background[3] > 1.0
        {
            return Err(Error::Invalid {
                what: format!("the background {:?} is no color", self.background),
                help: Some("give linear RGBA, each 0 or more, alpha at most 1".into()),
            });
        }
        self.camera.validate()
    }

    /// The background times its own alpha, linear RGBA.
    pub fn premultiplied_background(&self) -> [f64; 4] {
        let [r, g, b, a] = self.background.map(f64::from);
        [r * a, g * a, b * a, a]
    }

    /// The ray through the center of pixel (column, row), row 0 at the top.
    pub fn ray(&self, column: u32, row: u32) -> Ray {
        self.camera.ray(
            2.0 * (f64::from(column) + 0.5) / f64::from(self.width) - 1.0,
            1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(self.height),
            f64::from(self.width) / f64::from(self.height),
        )
    }
}
