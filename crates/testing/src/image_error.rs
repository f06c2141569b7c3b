//! How far one picture is from another.

use serde::{Deserialize, Deserializer, Serialize};
use tetrascope_core::Frame;

/// The error of an image against the truth, over all pixels and all four
/// channels of premultiplied linear RGBA.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct ImageError {
    /// √(mean of squared differences).
    #[serde(deserialize_with = "infinite_if_null")]
    pub rmse: f64,
    /// The greatest difference.
    #[serde(deserialize_with = "infinite_if_null")]
    pub max: f64,
    /// −20 log₁₀ RMSE, decibel, for a peak of 1; `None` for equal images.
    pub psnr: Option<f64>,
    /// Column and row of the greatest difference.
    pub worst_pixel: [u32; 2],
}

/// Reads a number that was infinite where it is null: JSON has no infinity.
///
/// # Errors
/// A value that is neither a number nor null.
pub fn infinite_if_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let number = Option::<f64>::deserialize(deserializer)?;
    Ok(number.unwrap_or(f64::INFINITY))
}

impl ImageError {
    /// The error of `image` against `truth`.
    ///
    /// A value that is not finite counts as infinitely wrong unless both have
    /// the very same. Panics where the sizes differ: they come from one view.
    pub fn between(truth: &Frame, image: &Frame) -> ImageError {
        assert_eq!(
            (truth.width, truth.height),
            (image.width, image.height),
            "images of one view have one size"
        );
        ImageError::against(&exactly(truth), image)
    }

    /// The same where the truth is known in f64: premultiplied linear RGBA, top row first.
    pub fn against(truth: &[[f64; 4]], image: &Frame) -> ImageError {
        assert_eq!(truth.len(), image.pixels.len());
        let mut squares = 0.0;
        let (mut max, mut worst) = (0.0, 0);
        for (i, (t, p)) in truth.iter().zip(&image.pixels).enumerate() {
            for (&t, &p) in t.iter().zip(p) {
                let difference = apart(t, p.into());
                squares += difference * difference;
                if difference > max {
                    (max, worst) = (difference, i);
                }
            }
        }
        let rmse = (squares / (4 * truth.len().max(1)) as f64).sqrt();
        let width = image.width.max(1) as usize;
        ImageError {
            rmse,
            max,
            psnr: (rmse > 0.0).then(|| -20.0 * rmse.log10()),
            worst_pixel: [(worst % width) as u32, (worst / width) as u32],
        }
    }

    /// Whether both the RMSE and the greatest difference are within bounds.
    pub fn within(&self, rmse: f64, max: f64) -> bool {
        self.rmse <= rmse && self.max <= max
    }
}

/// |a − b|, infinite where that makes no sense.
pub fn apart(a: f64, b: f64) -> f64 {
    let difference = (a - b).abs();
    if a.to_bits() == b.to_bits() {
        0.0
    } else if difference.is_nan() {
        f64::INFINITY
    } else {
        difference
    }
}

/// RMSE and greatest error of `image`.
pub fn difference(image: &Frame, truth: &[[f64; 4]]) -> (f64, f64) {
    let error = ImageError::against(truth, image);
    (error.rmse, error.max)
}

/// RMSE and greatest difference of two pictures.
pub fn between(a: &Frame, b: &Frame) -> (f64, f64) {
    difference(a, &exactly(b))
}

/// The picture in f64.
pub fn exactly(frame: &Frame) -> Vec<[f64; 4]> {
    let pixels = frame.pixels.iter();
    pixels.map(|pixel| pixel.map(f64::from)).collect()
}

/// The greatest channel, and at least 1: sums of light have no other unit.
pub fn scale(truth: &[[f64; 4]]) -> f64 {
    truth.iter().flatten().fold(1.0, |a: f64, b| a.max(*b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope_core::FrameStats;

    fn frame(width: u32, pixels: &[[f32; 4]]) -> Frame {
        Frame::new(
            (width, pixels.len() as u32 / width),
            pixels.to_vec(),
            FrameStats::default(),
        )
    }

    #[test]
    fn known_differences_give_known_numbers() {
        let truth = frame(2, &[[0.0; 4], [0.5; 4]]);
        let mut image = truth.clone();
        image.pixels[1][2] = 0.25;
        // One of eight values is off by 1/4: RMSE = 1/(4 √8), PSNR = 20 log₁₀(4 √8).
        let error = ImageError::between(&truth, &image);
        assert!((error.rmse - 0.25 / 8f64.sqrt()).abs() < 1e-15);
        assert!(
            (error.psnr.expect("they differ") - 20.0 * (4.0 * 8f64.sqrt()).log10()).abs() < 1e-12
        );
        assert_eq!(error.max, 0.25);
        assert_eq!(error.worst_pixel, [1, 0]);
    }

    #[test]
    fn every_channel_counts() {
        for channel in 0..4 {
            let truth = frame(1, &[[0.25; 4]]);
            let mut image = truth.clone();
            image.pixels[0][channel] += 0.5;
            let error = ImageError::between(&truth, &image);
            assert_eq!(error.max, 0.5, "channel {channel}");
            assert_eq!(error.rmse, 0.25, "channel {channel}");
        }
    }

    #[test]
    fn equal_images_have_no_error() {
        let image = frame(1, &[[0.1, 0.2, 0.3, f32::INFINITY]]);
        let error = ImageError::between(&image, &image.clone());
        assert_eq!((error.rmse, error.max, error.psnr), (0.0, 0.0, None));
    }

    #[test]
    fn images_that_differ_fail() {
        let truth = frame(1, &[[0.5; 4]]);
        let brighter = frame(1, &[[0.5, 0.5, 0.5, 0.51]]);
        assert!(!ImageError::between(&truth, &brighter).within(1e-3, 1e-3));
        assert!(ImageError::between(&truth, &truth.clone()).within(0.0, 0.0));
    }

    #[test]
    fn not_a_number_is_infinitely_wrong() {
        let truth = frame(1, &[[0.5; 4]]);
        let broken = frame(1, &[[0.5, f32::NAN, 0.5, 0.5]]);
        let error = ImageError::between(&truth, &broken);
        assert_eq!(error.max, f64::INFINITY);
        assert!(!error.within(1.0, 1.0));
    }

    #[test]
    #[should_panic(expected = "one size")]
    fn images_of_different_sizes_are_not_compared() {
        let _ = ImageError::between(&frame(2, &[[0.0; 4]; 2]), &frame(1, &[[0.0; 4]; 2]));
    }
}
