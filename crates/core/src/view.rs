//! From where, how large and before what.

use crate::appearance::BRIGHTEST;
use crate::{Camera, Error, Ray};

/// One picture's camera, size and background.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera, world space.
    pub camera: Camera,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
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

/// The most pixels of an image: 1 GiB of float texels.
pub const MAX_IMAGE_PIXELS: u64 = 1 << 26;

/// Refuses an image without pixels or with too many.
pub fn check_size(width: u32, height: u32) -> Result<(), Error> {
    let side = 1..=MAX_IMAGE_SIDE;
    if !side.contains(&width) || !side.contains(&height) {
        return Err(Error::Invalid {
            what: format!("an image of {width}x{height} pixels"),
            help: Some(format!(
                "give 1 to {MAX_IMAGE_SIDE} pixels a side, such as 512x512"
            )),
        });
    }
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_IMAGE_PIXELS {
        return Err(Error::Invalid {
            what: format!("an image of {pixels} pixels, {width}x{height}"),
            help: Some(format!(
                "give at most {MAX_IMAGE_PIXELS} pixels, such as 8192x8192"
            )),
        });
    }
    Ok(())
}

/// Refuses a background that is not a color: linear RGBA with straight alpha.
pub fn check_background(background: [f32; 4]) -> Result<(), Error> {
    let [.., alpha] = background;
    if background.iter().all(|c| c.is_finite() && *c >= 0.0)
        && alpha <= 1.0
        && background.iter().all(|c| f64::from(*c) <= BRIGHTEST)
    {
        return Ok(());
    }
    Err(Error::Invalid {
        what: format!("the background {background:?} is not a color"),
        help: Some("give linear RGBA, each 0 or more, alpha at most 1".into()),
    })
}

impl View {
    /// Refuses an image without pixels or with too many, a background that is not a color and
    /// a camera that looks nowhere.
    pub fn validate(&self) -> Result<(), Error> {
        check_size(self.width, self.height)?;
        check_background(self.background)?;
        self.camera.validate()
    }

    /// Refuses an image for which this machine does not have the memory: `bytes` for each
    /// pixel, which are asked for at once and given back.
    ///
    /// # Errors
    /// [`Error::NoMemory`].
    pub fn check_memory(&self, bytes: u64) -> Result<(), Error> {
        let pixels = u64::from(self.width) * u64::from(self.height);
        let needed = pixels.saturating_mul(bytes);
        let mut memory: Vec<u8> = Vec::new();
        let fits = usize::try_from(needed).is_ok_and(|n| memory.try_reserve_exact(n).is_ok());
        if fits {
            return Ok(());
        }
        Err(Error::NoMemory {
            what: format!("an image of {}x{} pixels", self.width, self.height),
            bytes: needed,
        })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bounds, CameraFit};
    use glam::DVec3;

    #[test]
    fn sizes_and_backgrounds_out_of_range_are_refused() {
        for (width, height) in [(0, 8), (8, 0), (65_537, 1), (65_536, 4096), (8193, 8192)] {
            assert!(check_size(width, height).is_err(), "{width}x{height}");
        }
        assert!(check_size(8192, 8192).is_ok() && check_size(65_536, 1).is_ok());
        for wrong in [-0.1, f32::NAN, f32::INFINITY, f32::MAX] {
            assert!(check_background([0.0, wrong, 0.0, 1.0]).is_err(), "{wrong}");
        }
        assert!(check_background([0.0, 0.0, 0.0, 1.1]).is_err());
        assert!(check_background([9.0, 0.0, 0.0, 0.5]).is_ok());
    }

    #[test]
    fn an_image_beyond_memory_is_refused_with_its_size() {
        let bounds = Bounds {
            min: DVec3::ZERO,
            max: DVec3::ONE,
        };
        let view = View {
            camera: Camera::fit(&bounds, CameraFit::PlusX, false, 1.0),
            width: 8192,
            height: 8192,
            background: BLACK,
        };
        let error = view.check_memory(1 << 33).expect_err("2⁵⁹ bytes");
        assert!(error.to_string().contains("576460752303 MB"), "{error}");
        let small = View {
            width: 8,
            height: 8,
            ..view
        };
        assert!(small.check_memory(100).is_ok());
    }
}
