//! What the tests of this package share: who draws, on what, and what is left
//! behind when a picture is wrong.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use image::RgbaImage;
use tetrascope::core::{Appearance, Error, Frame, View, Volume, VolumeRenderer as _};
use tetrascope::{Algorithm, Context, Promise, Settings};
use tetrascope_testing::{ImageError, check_counts, say};

use crate::machine::{root, target};
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
    let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
    if let Err(error) = (algorithm.supports)(volume, appearance, view, &settings) {
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
        return None;
    }
    let renderer = (algorithm.build)(context(), volume, appearance, &settings);
    let frame = renderer.and_then(|renderer| renderer.render(view));
    let frame = frame.unwrap_or_else(|error| panic!("{} {setting}: {error}", algorithm.name));
    check_counts(algorithm, &frame.stats);
    Some(frame)
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

/// What went wrong in a test of many pictures: it fails at its end, with all of them.
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

/// Compares pixels with the reviewed picture `snapshots/NAME.png`, over black and
/// over white, in 8-bit steps of sRGB.
///
/// Where they differ by more than `steps`, or no such picture exists, fails; then
/// `target/snapshots` holds the new picture and, as NAME.diff.png, expected |
/// difference | actual. `bless` says whether this picture may become the reviewed
/// one.
pub fn check_snapshot(
    name: &str,
    actual: &RgbaImage,
    steps: u8,
    bless: bool,
) -> Result<(), String> {
    let expected_path = root().join("snapshots").join(format!("{name}.png"));
    let pending = pending(name);
    let expected = match image::open(&expected_path) {
        Ok(image) => image.to_rgba8(),
        Err(error) => {
            leave(&pending, actual, bless);
            return Err(format!(
                "no reviewed picture {name}: {error}; look at {} and run `cargo xtask bless`",
                pending.display()
            ));
        }
    };
    let worst = difference_in_steps(&expected, actual);
    if worst.is_some_and(|worst| worst <= steps) {
        // What was wrong before is right now.
        _ = fs::remove_file(&pending);
        return Ok(());
    }
    leave(&pending, actual, bless);
    let row = pending.with_extension("diff.png");
    save(
        &row,
        &side_by_side(&[&expected, &steps_map(&expected, actual), actual]),
    );
    let worst = worst.map_or("other size".into(), |w| format!("{w} steps of 255"));
    Err(format!(
        "picture {name} changed: {worst}, at most {steps} allowed; see {}",
        row.display()
    ))
}

/// The greatest difference over black and over white, in steps of 255; `None` for
/// images of different sizes.
fn difference_in_steps(a: &RgbaImage, b: &RgbaImage) -> Option<u8> {
    let pairs = a.pixels().zip(b.pixels());
    (a.dimensions() == b.dimensions()).then(|| {
        pairs
            .map(|(a, b)| steps_between(a.0, b.0))
            .max()
            .unwrap_or(0)
    })
}

/// The greatest difference of two pixels over black and over white, which is that of
/// what a reader sees: colors of clear pixels do not count.
fn steps_between(a: [u8; 4], b: [u8; 4]) -> u8 {
    let over = |pixel: [u8; 4], channel: usize, paper: f32| {
        let alpha = f32::from(pixel[3]) / 255.0;
        f32::from(pixel[channel]) * alpha + paper * (1.0 - alpha)
    };
    let difference = |channel, paper| (over(a, channel, paper) - over(b, channel, paper)).abs();
    let channels = (0..3).flat_map(|c| [difference(c, 0.0), difference(c, 255.0)]);
    channels.fold(0.0, f32::max).round() as u8
}

fn steps_map(expected: &RgbaImage, actual: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(expected.width(), expected.height(), |x, y| {
        let other = actual
            .get_pixel_checked(x, y)
            .map_or([0; 4], |pixel| pixel.0);
        // Ten steps are white: a difference that fails is seen.
        let gray = steps_between(expected.get_pixel(x, y).0, other).saturating_mul(25);
        image::Rgba([gray, gray, gray, 255])
    })
}

fn pending(name: &str) -> PathBuf {
    target().join("snapshots").join(format!("{name}.png"))
}

/// Leaves a picture to be accepted, or to be looked at alone.
fn leave(pending: &Path, actual: &RgbaImage, bless: bool) {
    if bless {
        save(pending, actual);
    } else {
        save(&pending.with_extension("other-adapter.png"), actual);
    }
}

fn save(path: &Path, image: &RgbaImage) {
    let folder = path.parent().expect("a file in a folder");
    fs::create_dir_all(folder).expect("the target folder is writable");
    fs::write(path, png(image)).expect("the target folder is writable");
}

/// Takes the pictures that the last snapshot test left as the reviewed ones;
/// returns their names.
pub fn bless() -> Result<Vec<String>, Error> {
    let failed = |path: &Path, source| Error::Io {
        action: "cannot write",
        path: path.into(),
        source,
    };
    let snapshots = root().join("snapshots");
    fs::create_dir_all(&snapshots).map_err(|e| failed(&snapshots, e))?;
    let folder = target().join("snapshots");
    let Ok(entries) = fs::read_dir(&folder) else {
        return Ok(Vec::new());
    };
    let mut blessed = Vec::new();
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let Some(name) = path.file_name().and_then(|n| n.to_str()) else {
            continue;
        };
        if name.ends_with(".diff.png") || name.ends_with(".other-adapter.png") {
            fs::remove_file(&path).map_err(|e| failed(&path, e))?;
        } else if name.ends_with(".png") {
            let accepted = snapshots.join(name);
            fs::copy(&path, &accepted).map_err(|e| failed(&accepted, e))?;
            fs::remove_file(&path).map_err(|e| failed(&path, e))?;
            blessed.push(name.trim_end_matches(".png").to_owned());
        }
    }
    blessed.sort();
    Ok(blessed)
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

    #[test]
    fn a_missing_snapshot_fails() {
        let missing = check_snapshot("harness-missing", &RgbaImage::new(2, 2), 255, false);
        assert!(missing.is_err_and(|why| why.contains("no reviewed picture")));
    }

    #[test]
    fn only_what_is_seen_counts() {
        assert_eq!(steps_between([255, 0, 9, 0], [0, 77, 1, 0]), 0);
        assert_eq!(steps_between([100, 0, 0, 255], [103, 0, 0, 255]), 3);
        // Opacity alone shows over white or over black.
        assert!(steps_between([0, 0, 0, 128], [0, 0, 0, 138]) >= 9);
        assert!(steps_between([255, 255, 255, 128], [255, 255, 255, 138]) >= 9);
    }
}
