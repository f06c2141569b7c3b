//! Numbers of a comparison: errors of pictures and the middle of times.
//!
//! Errors are taken on linear premultiplied RGBA in f32, over all pixels and all four channels, and
//! summed in f64. FLIP alone sees what a person would: sRGB without alpha.

use serde::{Deserialize, Deserializer, Serialize};
use tetrascope::core::Frame;
use tetrascope::core::colormap::linear_to_srgb;
use tetrascope_testing::{ImageError, apart, infinite_if_null};

/// All errors of a picture against the truth.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Errors {
    /// RMSE, greatest error, PSNR and the worst pixel.
    #[serde(flatten)]
    pub image: ImageError,
    /// The channel of the greatest error, "r", "g", "b" or "a".
    pub worst_channel: char,
    /// The mean of absolute differences.
    #[serde(deserialize_with = "infinite_if_null")]
    pub mean: f64,
    /// ‖image − truth‖₂ / ‖truth‖₂; infinite where the truth is 0 everywhere and the image is not.
    #[serde(deserialize_with = "infinite_if_null")]
    pub relative_l2: f64,
    /// Percentiles of each pixel's greatest absolute error.
    pub percentiles: Percentiles,
    /// [`flip`].
    pub flip: Option<f64>,
    /// The greatest errors of pixels, [`WORST`] at most, the worst first.
    #[serde(deserialize_with = "each_infinite_if_null")]
    pub worst: Vec<f64>,
    /// How many pixels have which greatest error: [`bin`] says where each counts.
    pub histogram: [u64; BINS],
}

fn each_infinite_if_null<'de, D: Deserializer<'de>>(numbers: D) -> Result<Vec<f64>, D::Error> {
    let numbers = Vec::<Option<f64>>::deserialize(numbers)?;
    Ok(numbers
        .into_iter()
        .map(|number| number.unwrap_or(f64::INFINITY))
        .collect())
}

/// Bins of a histogram of errors: none at all, half decades, and 1 or more.
pub const BINS: usize = 22;

/// The decade at which half decades begin: what is below counts as that.
pub const FIRST_DECADE: i32 = -10;

/// Where an error counts in a histogram: 0 for none at all, then one bin for each half decade from
/// 10⁻¹⁰ (with all that is less) to 1, then one for 1 and more, infinity included.
pub fn bin(error: f64) -> usize {
    if error == 0.0 {
        return 0;
    }
    let half_decades = (2.0 * (error.log10() - f64::from(FIRST_DECADE))).floor();
    // A float becomes the nearest integer there is.
    1 + (half_decades.max(0.0) as usize).min(BINS - 2)
}

/// How many of the greatest errors are kept: more than any bound leaves out.
const WORST: usize = 8;

/// The errors that 50, 90, 99 and 99.9 % of the pixels do not exceed, by nearest rank.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
pub struct Percentiles {
    /// Half of the pixels have at most this.
    #[serde(deserialize_with = "infinite_if_null")]
    pub p50: f64,
    /// 90 % of the pixels have at most this.
    #[serde(deserialize_with = "infinite_if_null")]
    pub p90: f64,
    /// 99 % of the pixels have at most this.
    #[serde(deserialize_with = "infinite_if_null")]
    pub p99: f64,
    /// 99.9 % of the pixels have at most this.
    #[serde(rename = "p99.9", deserialize_with = "infinite_if_null")]
    pub p99_9: f64,
}

impl Percentiles {
    /// Percentiles of values in ascending order.
    fn of(sorted: &[f64]) -> Percentiles {
        Percentiles {
            p50: nearest_rank(sorted, 500),
            p90: nearest_rank(sorted, 900),
            p99: nearest_rank(sorted, 990),
            p99_9: nearest_rank(sorted, 999),
        }
    }
}

impl Errors {
    /// The errors of `image` against `truth`.
    ///
    /// A value that is not finite is infinitely wrong unless both have the very same. Panics where
    /// the sizes differ: they come from one view.
    pub fn between(truth: &Frame, image: &Frame) -> Errors {
        let error = ImageError::between(truth, image);
        let (mut sum, mut squares, mut truth_squares) = (0.0, 0.0, 0.0);
        let mut by_pixel = Vec::with_capacity(truth.pixels.len());
        for (t, p) in truth.pixels.iter().zip(&image.pixels) {
            let apart = channels_apart(t, p);
            sum += apart.iter().sum::<f64>();
            squares += apart.iter().map(|d| d * d).sum::<f64>();
            truth_squares += t.iter().map(|&t| f64::from(t).powi(2)).sum::<f64>();
            by_pixel.push(apart.into_iter().fold(0.0, f64::max));
        }
        by_pixel.sort_by(f64::total_cmp);
        let [column, row] = error.worst_pixel;
        let place = row as usize * image.width as usize + column as usize;
        let worst_channel = match truth.pixels.get(place) {
            Some(t) => {
                let apart = channels_apart(t, &image.pixels[place]);
                let is_worst = |c: &usize| apart[*c] == error.max;
                ['r', 'g', 'b', 'a'][(0..4).find(is_worst).unwrap_or(0)]
            }
            None => 'r',
        };
        Errors {
            worst_channel,
            mean: sum / (4 * by_pixel.len().max(1)) as f64,
            relative_l2: match squares > 0.0 {
                true => (squares / truth_squares).sqrt(),
                false => 0.0,
            },
            percentiles: Percentiles::of(&by_pixel),
            histogram: histogram(&by_pixel),
            flip: flip(truth, image),
            worst: by_pixel.iter().rev().take(WORST).copied().collect(),
            image: error,
        }
    }

    /// The greatest error of all pixels but the `outliers` worst, of which there are fewer than 8.
    pub fn max_without(&self, outliers: usize) -> f64 {
        assert!(outliers < WORST, "no bound leaves out as many");
        self.worst.get(outliers).copied().unwrap_or(0.0)
    }
}

fn histogram(errors: &[f64]) -> [u64; BINS] {
    let mut counts = [0; BINS];
    for &error in errors {
        counts[bin(error)] += 1;
    }
    counts
}

fn channels_apart(truth: &[f32; 4], image: &[f32; 4]) -> [f64; 4] {
    std::array::from_fn(|c| apart(truth[c].into(), image[c].into()))
}

/// The least of `sorted` that `thousandths` of them do not exceed; 0 for none.
fn nearest_rank(sorted: &[f64], thousandths: usize) -> f64 {
    let rank = (thousandths * sorted.len()).div_ceil(1000);
    sorted.get(rank.max(1) - 1).copied().unwrap_or(0.0)
}

/// The mean of FLIP over all pixels, 0 for pictures that look alike and at most 1; `None` where a
/// picture is empty or has values that are not finite.
///
/// FLIP has no alpha. Both pictures are put on black and on white, and the greater mean counts: over
/// one of the two, any change of color or alpha is seen. Viewing conditions are FLIP's own, 67
/// pixels per degree.
///
/// P. Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", 2020.
pub fn flip(truth: &Frame, image: &Frame) -> Option<f64> {
    let over = |background: f32| {
        let [truth, image] = [truth, image].map(|frame| on(frame, background));
        let map = flip_rs::ldr_flip(&truth?, &image?, flip_rs::DEFAULT_PPD).ok()?;
        let sum: f64 = map.pixels().iter().map(|&x| f64::from(x)).sum();
        Some(sum / map.pixels().len() as f64)
    };
    Some(over(0.0)?.max(over(1.0)?))
}

/// A frame on a gray background, in sRGB.
fn on(frame: &Frame, background: f32) -> Option<flip_rs::RgbImage<f32>> {
    let pixels = frame.pixels.iter().flat_map(|&[r, g, b, alpha]| {
        [r, g, b].map(|light| {
            let linear = light + (1.0 - alpha) * background;
            match linear.is_finite() {
                true => linear_to_srgb(f64::from(linear).clamp(0.0, 1.0)) as f32,
                false => f32::NAN, // which FLIP refuses
            }
        })
    });
    let (width, height) = (frame.width as usize, frame.height as usize);
    flip_rs::RgbImage::new(width, height, pixels.collect()).ok()
}

/// The middle of `values`, the mean of both middles for an even count; `None` for none.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => None,
        n if n % 2 == 1 => Some(sorted[middle]),
        _ => Some((sorted[middle - 1] + sorted[middle]) / 2.0),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use tetrascope::core::FrameStats;
    use tetrascope::core::colormap::srgb_to_linear;

    pub(crate) fn frame(width: u32, pixels: Vec<[f32; 4]>) -> Frame {
        let height = pixels.len() as u32 / width;
        Frame::new((width, height), pixels, FrameStats::default())
    }

    impl Errors {
        /// Made-up errors around these.
        pub(crate) fn of(image: ImageError) -> Errors {
            Errors {
                image,
                worst_channel: 'a',
                mean: 1e-5,
                relative_l2: 2e-4,
                percentiles: Percentiles {
                    p50: 0.0,
                    p90: 1e-5,
                    p99: 2e-4,
                    p99_9: 9e-4,
                },
                flip: Some(0.0125),
                worst: vec![image.max],
                histogram: std::array::from_fn(|bin| bin as u64),
            }
        }
    }

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[3.0]), Some(3.0));
        assert_eq!(median(&[9.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), Some(3.0));
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let picture = frame(4, vec![[0.1, 0.2, 0.3, 0.5]; 16]);
        let errors = Errors::between(&picture, &picture.clone());
        assert_eq!(
            (errors.image.rmse, errors.image.max, errors.mean),
            (0.0, 0.0, 0.0)
        );
        // An infinite PSNR.
        assert_eq!(errors.image.psnr, None);
        assert_eq!((errors.relative_l2, errors.flip), (0.0, Some(0.0)));
        assert_eq!(errors.percentiles, Percentiles::of(&[0.0]));
        assert_eq!(errors.histogram[0], 16);
    }

    #[test]
    fn known_differences_give_known_numbers() {
        // 1000 pixels: pixel i is wrong by i / 1024 in alpha alone, exact in f32.
        let truth = frame(40, vec![[0.5, 0.5, 0.5, 1.0]; 1000]);
        let mut image = truth.clone();
        for (i, pixel) in image.pixels.iter_mut().enumerate() {
            pixel[3] -= i as f32 / 1024.0;
        }
        let errors = Errors::between(&truth, &image);
        // Σ i = 999 · 1000 / 2, over 4000 values.
        assert!((errors.mean - 499_500.0 / 1024.0 / 4000.0).abs() < 1e-15);
        // Σ i² = 999 · 1000 · 1999 / 6; the truth's squares are 1000 · (3/4 + 1).
        let squares = 332_833_500.0 / 1024f64.powi(2);
        assert!((errors.relative_l2 - (squares / 1750.0).sqrt()).abs() < 1e-15);
        // The nearest ranks of 1000: the 500th, 900th, 990th and 999th pixel.
        let Percentiles {
            p50,
            p90,
            p99,
            p99_9,
        } = errors.percentiles;
        let ranks = [499.0, 899.0, 989.0, 998.0].map(|i| i / 1024.0);
        assert_eq!([p50, p90, p99, p99_9], ranks);
        // One pixel is right; below √0.1 = 0.3162 are 1 to 323, the rest is below 1.
        assert_eq!(errors.histogram[0], 1);
        assert_eq!(errors.histogram[20], 999 - 323);
        assert_eq!(errors.histogram.iter().sum::<u64>(), 1000);
        assert_eq!(
            (errors.image.worst_pixel, errors.worst_channel),
            ([39, 24], 'a')
        );
        let greatest = [0, 1, 7].map(|outliers| errors.max_without(outliers));
        assert_eq!(greatest, [999.0, 998.0, 992.0].map(|i| i / 1024.0));
    }

    #[test]
    fn every_error_has_its_bin() {
        for (error, expected) in [
            (0.0, 0),
            (1e-300, 1),
            (2e-10, 1),
            (4e-10, 2),
            (1e-5, 11),
            (0.99, 20),
            (1.0, 21),
            (7.0, 21),
            (f64::INFINITY, 21),
        ] {
            assert_eq!(bin(error), expected, "{error}");
        }
    }

    #[test]
    fn an_empty_truth_makes_any_light_infinitely_wrong_in_proportion() {
        let errors = Errors::between(&frame(1, vec![[0.0; 4]]), &frame(1, vec![[0.5; 4]]));
        assert_eq!(errors.relative_l2, f64::INFINITY);
    }

    #[test]
    fn not_a_number_is_infinitely_wrong_everywhere() {
        let truth = frame(2, vec![[0.5; 4]; 4]);
        let mut image = truth.clone();
        image.pixels[2][1] = f32::NAN;
        let errors = Errors::between(&truth, &image);
        let found = [errors.image.rmse, errors.image.max, errors.mean];
        assert_eq!(found, [f64::INFINITY; 3]);
        assert_eq!(
            (errors.image.worst_pixel, errors.worst_channel),
            ([0, 1], 'g')
        );
        assert_eq!(errors.flip, None);
    }

    /// A square of gray on a gradient, as sRGB on an opaque frame. NVIDIA's own program (the Python
    /// package flip-evaluator 1.7) finds 0.051204678 there; it sums up to 20 terms of filters in f32,
    /// in another order: a few times 2⁻²⁴ of values up to 1.
    #[test]
    fn flip_is_what_its_authors_compute() {
        let picture = |has_square| {
            let pixels = (0..32u32 * 32).map(|i| {
                let (x, y) = (i % 32, i / 32);
                let color = match has_square && (8..16).contains(&x) && (8..16).contains(&y) {
                    true => [0.25; 3],
                    false => [f64::from(x) / 31.0, f64::from(y) / 31.0, 0.5],
                };
                let [r, g, b] = color.map(|c| srgb_to_linear(c) as f32);
                [r, g, b, 1.0]
            });
            frame(32, pixels.collect())
        };
        let found = flip(&picture(false), &picture(true)).expect("finite");
        assert!((found - 0.051_204_678).abs() < 2e-6, "{found}");
    }

    #[test]
    fn flip_sees_alpha_alone() {
        let of = |alpha| frame(8, vec![[0.0, 0.0, 0.0, alpha]; 64]);
        // On black both are black; on white the one is black and the other is white.
        assert!(flip(&of(0.0), &of(1.0)).expect("finite") > 0.9);
    }
}
