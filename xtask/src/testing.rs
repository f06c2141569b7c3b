//! Tools that the tests of this package share: who draws, on what, and what is left
//! behind when a picture is wrong.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use image::RgbaImage;
use tetrascope::core::{Appearance, Error, Frame, View, Volume, VolumeRenderer as _};
use tetrascope::{Algorithm, Context, Promise, Settings};
use tetrascope_testing::{ImageError, check_counts, say};

use crate::machine::target;
use crate::picture::{difference_map, png, shown, side_by_side};
use crate::setup::adapter_is_required;

/// One context for all tests of a program: they draw on one device.
pub fn context() -> &'static Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(Context::new)
}

/// The algorithms that this machine can run. For each of the others it says
/// "skipped", with the reason; in CI (`CI` set) it panics instead.
pub fn algorithms(test: &str) -> Vec<&'static Algorithm> {
    let runs = |algorithm: &&Algorithm| {
        if !algorithm.needs_gpu {
            return true;
        }
        let Err(error) = context().gpu() else {
            return true;
        };
        assert!(!adapter_is_required(), "CI is set, but: {error}");
        say(&format!("skipped: {test} with {}: {error}", algorithm.name));
        false
    };
    tetrascope::algorithms().iter().filter(runs).collect()
}

/// The adapter in words, for messages of GPU algorithms; "CPU" for the others.
pub fn drawn_by(algorithm: &Algorithm) -> String {
    let adapter = context().adapter().filter(|_| algorithm.needs_gpu);
    adapter.unwrap_or_else(|| "CPU".into())
}

/// Draws with one entry of an algorithm's sweep; `None` where the algorithm says
/// that it does not draw such a scene.
pub fn draw(
    algorithm: &Algorithm,
    setting: &str,
    volume: &Volume,
    appearance: &Appearance,
    view: &View,
) -> Option<Frame> {
    draw_all(algorithm, setting, volume, appearance, &[*view])?.pop()
}

/// [`draw`] by one renderer for several views; `None` if one of them is not drawn.
pub fn draw_all(
    algorithm: &Algorithm,
    setting: &str,
    volume: &Volume,
    appearance: &Appearance,
    views: &[View],
) -> Option<Vec<Frame>> {
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    for view in views {
        if let Err(error) = (algorithm.supports)(volume, appearance, view, &settings) {
            assert!(matches!(error, Error::Unsupported { .. }), "{error}");
            return None;
        }
    }
    let renderer = (algorithm.build)(context(), volume, appearance, &settings);
    let frames: Result<Vec<Frame>, Error> =
        renderer.and_then(|renderer| views.iter().map(|view| renderer.render(view)).collect());
    let frames = frames.unwrap_or_else(|error| panic!("{} {setting}: {error}", algorithm.name));
    for frame in &frames {
        check_counts(algorithm, &frame.stats);
    }
    Some(frames)
}

/// How near to the truth an algorithm is with one entry of its sweep.
pub fn promised(algorithm: &Algorithm, setting: &str) -> Promise {
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    (algorithm.promise)(&settings)
}

/// The ground truth's picture.
pub fn truth(volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let truth = tetrascope::truth().expect("compiled in");
    draw(truth, "", volume, appearance, view).expect("the ground truth draws every mesh")
}

/// Faults in a test of many pictures: it fails at its end, with all of them.
#[derive(Default)]
pub struct Failures(Vec<String>);

impl Failures {
    /// Takes note where `image` is farther from `expected` than allowed, and leaves
    /// expected | difference | actual side by side in `target/failures`.
    pub fn compare(&mut self, name: &str, expected: &Frame, image: &Frame, rmse: f64, max: f64) {
        let error = ImageError::between(expected, image);
        if error.within(rmse, max) {
            return;
        }
        let row = side_by_side(&[
            &shown(expected),
            &map_or_black(expected, image),
            &shown(image),
        ]);
        let kept = |c: char| if c.is_alphanumeric() { c } else { '-' };
        let file: String = name.chars().map(kept).collect();
        let path = target().join("failures").join(file + ".png");
        save(&path, &row);
        let [column, line] = error.worst_pixel;
        self.push(format!(
            "{name}: RMSE {:.3e} (at most {rmse:.1e}), greatest difference {:.3e} (at most \
             {max:.1e}) in pixel ({column}, {line}): expected {:?}, got {:?}; see {}",
            error.rmse,
            error.max,
            expected.pixel(column, line),
            image.pixel(column, line),
            path.display()
        ));
    }

    /// As [`Failures::compare`], without the `outliers` pixels that differ most.
    pub fn compare_most(
        &mut self,
        name: &str,
        expected: &Frame,
        image: &Frame,
        (rmse, max): (f64, f64),
        outliers: usize,
    ) {
        let mut most = image.clone();
        for _ in 0..outliers {
            let [column, row] = ImageError::between(expected, &most).worst_pixel;
            most.pixels[row as usize * most.width as usize + column as usize] =
                expected.pixel(column, row);
        }
        self.compare(name, expected, &most, rmse, max);
    }

    /// Takes note of another failure.
    pub fn push(&mut self, failure: String) {
        self.0.push(failure);
    }

    /// Panics if there was any.
    pub fn finish(self) {
        let Failures(all) = self;
        assert!(
            all.is_empty(),
            "{} pictures are wrong:\n{}",
            all.len(),
            all.join("\n")
        );
    }
}

fn map_or_black(expected: &Frame, image: &Frame) -> RgbaImage {
    let map = difference_map(expected, image).map(|(map, _)| map);
    map.unwrap_or_else(|| RgbaImage::new(expected.width, expected.height))
}

fn save(path: &Path, image: &RgbaImage) {
    let folder = path.parent().expect("a file in a folder");
    fs::create_dir_all(folder).expect("the target folder is writable");
    fs::write(path, png(image)).expect("the target folder is writable");
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope::core::{Counter, FrameStats};

    fn frame(value: f32) -> Frame {
        Frame::new((2, 1), vec![[value; 4]; 2], FrameStats::default())
    }

    #[test]
    #[should_panic(expected = "greatest difference")]
    fn pictures_that_differ_fail() {
        let mut failures = Failures::default();
        failures.compare(
            "harness: pictures that differ",
            &frame(0.5),
            &frame(0.51),
            1e-3,
            1e-3,
        );
        failures.finish();
    }

    #[test]
    #[should_panic(expected = "does not list")]
    fn counts_that_are_not_listed_fail() {
        let mut stats = FrameStats::default();
        let counter = Counter {
            name: "pictures",
            unit: "pictures",
            about: "Pictures.",
        };
        stats.count(counter, 1);
        check_counts(&tetrascope::algorithms()[0], &stats);
    }

    #[test]
    fn equal_pictures_pass() {
        let mut failures = Failures::default();
        failures.compare(
            "harness: equal pictures",
            &frame(0.5),
            &frame(0.5),
            0.0,
            0.0,
        );
        failures.finish();
    }

    #[test]
    #[should_panic(expected = "1 pictures are wrong")]
    fn only_so_many_pixels_are_outliers() {
        let mut failures = Failures::default();
        failures.compare_most(
            "harness: two outliers",
            &frame(0.5),
            &frame(0.6),
            (1e-3, 1.0),
            2,
        );
        failures.compare_most(
            "harness: one outlier",
            &frame(0.5),
            &frame(0.6),
            (1e-3, 1.0),
            1,
        );
        failures.finish();
    }
}
