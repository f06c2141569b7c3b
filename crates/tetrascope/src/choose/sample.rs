//! The truth in some pixels: how much work a picture is, and how wrong one is.

use rayon::prelude::*;
use tetrascope_core::{Appearance, Bounds, Error, Frame, Projection, View, Volume};
use tetrascope_reference::Reference;

use super::features::Features;

/// Pixels in which the truth of a scene is computed. Of 512, a picture's error was measured at
/// 5e-4 that is 1.2e-3, as a few pixels have most of it.
const PIXELS: u32 = 2048;

/// One in so many of these tells how much work a ray is.
const TRACED: usize = 4;

/// Where pixels are taken is the same every time.
const SEED: u64 = 1;

/// One-sided quantile of the normal distribution at 95 %.
const QUANTILE: f64 = 1.645;

/// How wrong a picture is, by the truth in a sample of its pixels.
///
/// Differences are of premultiplied linear RGBA, over all four channels.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SampledError {
    /// Pixels in which the truth is known.
    pub sampled: u64,
    /// Pixels of the picture.
    pub pixels: u64,
    /// √(mean of squared differences), estimated for the whole picture.
    pub rmse: f64,
    /// The RMSE is below this with a probability of 95 %, as far as the sample tells: errors in
    /// few pixels alone, such as at outlines of surfaces, may have escaped it. Where an exact
    /// picture was drawn before, both numbers also follow from all pixels of that.
    pub upper: f64,
    /// The greatest difference in the sample.
    pub greatest: f64,
}

impl SampledError {
    /// Whether the RMSE is at most `target`, with the certainty of [`SampledError::upper`].
    pub fn keeps(&self, target: f64) -> bool {
        self.upper <= target
    }
}

impl SampledError {
    /// The error of a picture of a view, by some 2000 rays of the truth, which draws the volume in
    /// this look.
    ///
    /// # Errors
    /// Those of [`Reference::render_pixels`].
    pub fn of(
        reference: &Reference,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
        frame: &Frame,
    ) -> Result<SampledError, Error> {
        Ok(Sample::new(reference, volume, appearance, view)?.error(frame))
    }

    /// The same, and how far the whole picture is from one that is `exact`: what is wrong in few
    /// pixels escapes a sample, and not this.
    pub(crate) fn beside(self, difference: f64, exact: &SampledError) -> SampledError {
        SampledError {
            rmse: self.rmse.max(difference - exact.upper),
            // Distances of pictures keep the triangle inequality.
            upper: self.upper.max(difference + exact.upper),
            ..self
        }
    }
}

/// The truth in a sample of a view's pixels.
pub(crate) struct Sample {
    pub(crate) features: Features,
    size: [u32; 2],
    /// Columns and rows, first and end, in which the volume may be seen.
    window: [[u32; 2]; 2],
    pixels: Vec<[u32; 2]>,
    truth: Vec<[f64; 4]>,
    background: [f64; 4],
}

impl Sample {
    /// Computes about [`PIXELS`] pixels.
    ///
    /// # Errors
    /// Those of [`Reference::render_pixels`].
    pub(crate) fn new(
        reference: &Reference,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
    ) -> Result<Sample, Error> {
        view.validate()?;
        let window = window(view, &volume.bounds());
        let pixels = stratified(window, PIXELS);
        let truth = reference.render_pixels(view, &pixels)?.pixels;
        let traced: Vec<[u32; 2]> = pixels.iter().step_by(TRACED).copied().collect();
        let traces = traced.par_iter().map(|&[column, row]| {
            let trace = reference.trace(&view.ray(column, row))?;
            Ok(Features::of_ray(&trace, appearance))
        });
        let rays = traces.collect::<Result<Vec<[f64; 3]>, Error>>()?;
        let size = [view.width, view.height];
        Ok(Sample {
            features: Features::new(volume, size, area(window), &rays),
            size,
            window,
            pixels,
            truth,
            background: view.premultiplied_background(),
        })
    }

    /// The error of a picture of this view.
    pub(crate) fn error(&self, frame: &Frame) -> SampledError {
        let mut greatest = 0.0_f64;
        // Of a pixel: the mean over its channels.
        let mut square = |truth: &[f64; 4], pixel: [f32; 4]| {
            let squares = truth.iter().zip(pixel).map(|(t, p)| {
                let difference = (t - f64::from(p)).abs();
                // NaN is infinitely wrong.
                let difference = if difference.is_nan() {
                    f64::INFINITY
                } else {
                    difference
                };
                greatest = greatest.max(difference);
                difference * difference
            });
            squares.sum::<f64>() / 4.0
        };
        let sampled = self.pixels.iter().zip(&self.truth);
        let squares: Vec<f64> = sampled
            .map(|(&[column, row], truth)| square(truth, frame.pixel(column, row)))
            .collect();
        // Elsewhere the truth is known: it is the background.
        let [[c0, c1], [r0, r1]] = self.window;
        let mut outside = 0.0;
        for row in 0..self.size[1] {
            for column in 0..self.size[0] {
                if !(c0..c1).contains(&column) || !(r0..r1).contains(&row) {
                    outside += square(&self.background, frame.pixel(column, row));
                }
            }
        }
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let (inside, count) = (area(self.window), squares.len() as f64);
        let mean = squares.iter().sum::<f64>() / count.max(1.0);
        let variance = squares.iter().map(|s| (s - mean).powi(2)).sum::<f64>();
        let variance = variance / (count - 1.0).max(1.0);
        // Of a sample without repetition; that it is stratified makes it better than this.
        let left = 1.0 - count / inside.max(1.0);
        let deviation = (variance / count.max(1.0) * left.max(0.0)).sqrt();
        let whole = |mean: f64| ((mean * inside + outside) / pixels as f64).sqrt();
        let upper = whole(mean + QUANTILE * deviation);
        SampledError {
            sampled: squares.len() as u64 + pixels - inside as u64,
            pixels,
            rmse: whole(mean),
            // Of infinite differences there is no deviation.
            upper: if upper.is_nan() { f64::INFINITY } else { upper },
            greatest,
        }
    }
}

fn area([[c0, c1], [r0, r1]]: [[u32; 2]; 2]) -> f64 {
    f64::from(c1 - c0) * f64::from(r1 - r0)
}

/// Columns and rows outside of which there is nothing of a box; all where it reaches the eye.
fn window(view: &View, bounds: &Bounds) -> [[u32; 2]; 2] {
    let camera = &view.camera;
    let (right, up, forward) = camera.axes();
    let [width, height] = [view.width, view.height].map(f64::from);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for corner in bounds.corners() {
        let p = corner - camera.position;
        let depth = p.dot(forward);
        let half = match camera.projection {
            Projection::Perspective { view_angle } => depth * (view_angle.to_radians() / 2.0).tan(),
            Projection::Orthographic { parallel_scale } => parallel_scale,
        };
        if depth <= 0.0 {
            return [[0, view.width], [0, view.height]];
        }
        let x = p.dot(right) / (half * width / height);
        let y = p.dot(up) / half;
        let pixel = [(x + 1.0) / 2.0 * width, (1.0 - y) / 2.0 * height];
        for axis in 0..2 {
            low[axis] = low[axis].min(pixel[axis]);
            high[axis] = high[axis].max(pixel[axis]);
        }
    }
    // A pixel more on each side, for renderers that round to f32.
    let span = |axis: usize, size: f64| {
        let first = (low[axis] - 1.0).floor().clamp(0.0, size);
        let end = (high[axis] + 1.0).ceil().clamp(first, size);
        [first as u32, end as u32]
    };
    [span(0, width), span(1, height)]
}

/// About `count` pixels of a window, each somewhere in its share of it; all where there are no more.
fn stratified(window: [[u32; 2]; 2], count: u32) -> Vec<[u32; 2]> {
    let [[c0, c1], [r0, r1]] = window;
    let [width, height] = [c1 - c0, r1 - r0].map(u64::from);
    if width * height <= u64::from(count) {
        return (r0..r1)
            .flat_map(|row| (c0..c1).map(move |column| [column, row]))
            .collect();
    }
    let across = (f64::from(count) * width as f64 / height as f64).sqrt();
    let across = (across.round() as u64).clamp(1, width);
    let down = (u64::from(count) / across).clamp(1, height);
    let mut state = SEED;
    // Somewhere in the share number `i` of `parts` of `size` pixels.
    let mut within = |i: u64, parts: u64, size: u64| {
        let (first, end) = (i * size / parts, (i + 1) * size / parts);
        (first + random(&mut state) % (end - first)) as u32
    };
    let mut pixels = Vec::with_capacity((across * down) as usize);
    for row in 0..down {
        for column in 0..across {
            let column = c0 + within(column, across, width);
            pixels.push([column, r0 + within(row, down, height)]);
        }
    }
    pixels
}

/// SplitMix64 (Steele, Lea, Flood 2014).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use tetrascope_core::VolumeRenderer as _;
    use tetrascope_reference::ReferenceOptions;

    use super::*;
    use crate::choose::tests::scene;

    #[test]
    fn pixels_are_within_the_window_and_differ() {
        for window in [
            [[0, 100], [0, 50]],
            [[7, 40], [3, 300]],
            [[2, 5], [1, 4]],
            [[3, 3], [0, 9]],
        ] {
            let pixels = stratified(window, 64);
            let [[c0, c1], [r0, r1]] = window;
            assert!(
                pixels
                    .iter()
                    .all(|[c, r]| (c0..c1).contains(c) && (r0..r1).contains(r))
            );
            let mut once = pixels.clone();
            once.sort_unstable();
            once.dedup();
            assert_eq!(once.len(), pixels.len(), "{window:?}");
            let most = area(window).min(64.0);
            assert!(
                pixels.len() as f64 >= most * 0.75 && pixels.len() <= 64,
                "{window:?}"
            );
        }
        assert_eq!(
            stratified([[0, 9], [0, 9]], 40),
            stratified([[0, 9], [0, 9]], 40)
        );
    }

    #[test]
    fn a_sample_of_the_truth_has_no_error_but_rounding() {
        let (volume, mut scene) = scene("sphere", 600, 128);
        // Twice as far away: its box no longer fills the picture.
        let camera = &mut scene.view.camera;
        camera.position = camera.focal_point.lerp(camera.position, 2.0);
        let reference = Reference::new(&volume, &scene.appearance, &ReferenceOptions::default());
        let reference = reference.expect("it draws");
        let sample = Sample::new(&reference, &volume, &scene.appearance, &scene.view);
        let sample = sample.expect("it draws");
        let mut frame = reference.render(&scene.view).expect("it draws");
        let error = sample.error(&frame);
        // f32 rounds numbers up to 1 by up to 2⁻²⁵.
        assert!(
            error.greatest < 3e-8 && error.rmse <= error.upper,
            "{error:?}"
        );
        assert!(error.keeps(1e-7) && !error.keeps(error.rmse / 2.0));
        assert!(error.sampled < error.pixels);
        let [[c0, c1], [r0, r1]] = sample.window;
        // What is outside of the window counts, too.
        assert!(
            c0 > 0 && c1 < 128 && r0 > 0 && r1 < 128,
            "{:?}",
            sample.window
        );
        frame.pixels[0][2] += 0.5;
        let error = sample.error(&frame);
        let rmse = (0.25_f64 / 4.0 / (128.0 * 128.0)).sqrt();
        assert!((error.rmse / rmse - 1.0).abs() < 1e-6 && error.greatest == 0.5);
        let [column, row] = sample.pixels[3];
        frame.pixels[(row * 128 + column) as usize][1] = f32::NAN;
        assert!(!sample.error(&frame).keeps(1e9));
    }

    #[test]
    fn what_a_sample_misses_is_found_beside_an_exact_picture() {
        let of = |rmse| SampledError {
            sampled: 100,
            pixels: 10_000,
            rmse,
            upper: 2.0 * rmse,
            greatest: rmse,
        };
        let beside = of(5e-4).beside(1.2e-3, &of(1e-7));
        assert!(
            (beside.rmse - 1.2e-3).abs() < 1e-6 && !beside.keeps(1.1e-3),
            "{beside:?}"
        );
        assert!(beside.keeps(1.3e-3));
        // Where both agree, the sample is what is known.
        assert_eq!(of(5e-4).beside(1e-4, &of(1e-7)), of(5e-4));
    }

    #[test]
    fn an_estimate_is_near_the_error_of_all_pixels() {
        let (volume, scene) = scene("sphere", 600, 96);
        let reference = Reference::new(&volume, &scene.appearance, &ReferenceOptions::default());
        let reference = reference.expect("it draws");
        let sample = Sample::new(&reference, &volume, &scene.appearance, &scene.view);
        let sample = sample.expect("it draws");
        let truth = reference.render_exact(&scene.view).expect("it draws");
        let mut frame = truth.to_frame();
        // A smooth error: a twentieth of the light is missing.
        frame
            .pixels
            .iter_mut()
            .for_each(|p| p.iter_mut().for_each(|c| *c *= 0.95));
        let squares = truth
            .pixels
            .iter()
            .flatten()
            .zip(frame.pixels.iter().flatten());
        let squares = squares
            .map(|(t, p)| (t - f64::from(*p)).powi(2))
            .sum::<f64>();
        let rmse = (squares / (4.0 * 96.0 * 96.0)).sqrt();
        let error = sample.error(&frame);
        // Squares of this picture vary by no more than twice their mean: of 2048, the mean is
        // within 2/√2048 of it, the RMSE within half of that, 2.2 %; three times that for chance.
        assert!(
            (error.rmse / rmse - 1.0).abs() < 0.07,
            "{} {rmse}",
            error.rmse
        );
        assert!(error.upper < 1.1 * rmse, "{} {rmse}", error.upper);
    }
}
