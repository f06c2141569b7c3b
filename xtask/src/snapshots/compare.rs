//! Pictures beside the reviewed ones, in 8-bit steps of sRGB over black and over white.

use std::path::{Path, PathBuf};

use image::RgbaImage;
use tetrascope::core::Error;

use crate::machine::{root, target};
use crate::output::write;
use crate::picture::{png, side_by_side};

/// Where reviewed pictures are, and where others are left.
pub struct Store {
    reviewed: PathBuf,
    left: PathBuf,
}

/// A picture that differs or is missing.
pub struct Left {
    /// The picture's name.
    pub name: String,
    /// Whether this adapter's picture may become the reviewed one.
    pub may_be_blessed: bool,
    /// The reviewed one, if there is any.
    pub expected: Option<RgbaImage>,
    /// The picture that was drawn.
    pub actual: RgbaImage,
}

/// The endings of what is left of a picture: to be blessed, from another adapter, and expected |
/// difference | actual.
const ENDINGS: [&str; 3] = [".png", ".other-adapter.png", ".diff.png"];

impl Store {
    /// Those of the repository.
    pub fn here() -> Store {
        Store::new(root().join("snapshots"), target().join("snapshots"))
    }

    /// Reviewed pictures in one folder, and what differs in another.
    pub fn new(reviewed: PathBuf, left: PathBuf) -> Store {
        Store { reviewed, left }
    }

    /// Compares a picture with the reviewed one; at most `steps` of 255 may differ.
    ///
    /// # Errors
    /// Where they differ by more, or no such picture exists, says what is wrong; then the picture
    /// is left here and, as NAME.diff.png, expected | difference | actual. `bless` says whether
    /// it may become the reviewed one.
    pub fn check(
        &self,
        name: &str,
        actual: &RgbaImage,
        steps: u8,
        bless: bool,
    ) -> Result<(), String> {
        // What was wrong before may be right now.
        for ending in ENDINGS {
            _ = std::fs::remove_file(self.left_as(name, ending));
        }
        let leave = |ending, image| {
            let path = self.left_as(name, ending);
            write(&path, png(image))
                .map(|()| path)
                .map_err(|e| e.to_string())
        };
        let pending = if bless { ENDINGS[0] } else { ENDINGS[1] };
        let expected = match self.expected(name) {
            Ok(expected) => expected,
            Err(error) => {
                let path = leave(pending, actual)?;
                return Err(format!(
                    "no reviewed picture {name}: {error}; look at {} and run `cargo xtask \
                     snapshots bless`",
                    path.display()
                ));
            }
        };
        let worst = difference_in_steps(&expected, actual);
        if worst.is_some_and(|worst| worst <= steps) {
            return Ok(());
        }
        leave(pending, actual)?;
        let map = steps_map(&expected, actual);
        let row = leave(ENDINGS[2], &side_by_side(&[&expected, &map, actual]))?;
        let worst = worst.map_or("other size".into(), |w| format!("{w} steps of 255"));
        Err(format!(
            "picture {name} changed: {worst}, at most {steps} allowed; see {}",
            row.display()
        ))
    }

    /// Takes the pictures that were left as the reviewed ones; their names.
    ///
    /// # Errors
    /// A folder or file that cannot be read or written.
    pub fn bless(&self) -> Result<Vec<String>, Error> {
        let mut blessed = Vec::new();
        for left in self.left()? {
            if left.may_be_blessed {
                write(
                    &self.reviewed.join(format!("{}.png", left.name)),
                    png(&left.actual),
                )?;
            }
            for ending in ENDINGS {
                _ = std::fs::remove_file(self.left_as(&left.name, ending));
            }
            if left.may_be_blessed {
                blessed.push(left.name);
            }
        }
        Ok(blessed)
    }

    /// The pictures that were left, by name.
    ///
    /// # Errors
    /// A folder or picture that cannot be read.
    pub fn left(&self) -> Result<Vec<Left>, Error> {
        let mut all = Vec::new();
        for stem in stems(&self.left)? {
            if stem.ends_with(".diff") {
                continue;
            }
            let other = stem.strip_suffix(".other-adapter");
            let name = other.unwrap_or(&stem);
            all.push(Left {
                name: name.into(),
                may_be_blessed: other.is_none(),
                expected: self.expected(name).ok(),
                actual: open(&self.left.join(format!("{stem}.png")))?,
            });
        }
        Ok(all)
    }

    /// The names of reviewed pictures, sorted.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn reviewed(&self) -> Result<Vec<String>, Error> {
        stems(&self.reviewed)
    }

    /// Where a reviewed picture is.
    pub fn path(&self, name: &str) -> PathBuf {
        self.reviewed.join(format!("{name}.png"))
    }

    fn expected(&self, name: &str) -> Result<RgbaImage, image::ImageError> {
        Ok(image::open(self.path(name))?.to_rgba8())
    }

    fn left_as(&self, name: &str, ending: &str) -> PathBuf {
        self.left.join(format!("{name}{ending}"))
    }
}

fn open(path: &Path) -> Result<RgbaImage, Error> {
    let opened = image::open(path).map_err(|error| Error::Io {
        action: "cannot read",
        path: path.into(),
        source: std::io::Error::other(error),
    });
    Ok(opened?.to_rgba8())
}

/// The names of PNG files in a folder, without ".png", sorted; none where there is no folder.
fn stems(folder: &Path) -> Result<Vec<String>, Error> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(source) => {
            return Err(Error::Io {
                action: "cannot read",
                path: folder.into(),
                source,
            });
        }
    };
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut stems: Vec<String> = names
        .filter_map(|name| Some(name.strip_suffix(".png")?.to_owned()))
        .collect();
    stems.sort();
    Ok(stems)
}

/// The greatest difference over black and over white, in steps of 255; `None` for
/// images of different sizes.
pub fn difference_in_steps(a: &RgbaImage, b: &RgbaImage) -> Option<u8> {
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

/// The difference in gray, of the size of `expected`: ten steps are white, so that a difference
/// that fails is seen.
pub fn steps_map(expected: &RgbaImage, actual: &RgbaImage) -> RgbaImage {
    RgbaImage::from_fn(expected.width(), expected.height(), |x, y| {
        let other = actual
            .get_pixel_checked(x, y)
            .map_or([0; 4], |pixel| pixel.0);
        let gray = steps_between(expected.get_pixel(x, y).0, other).saturating_mul(25);
        image::Rgba([gray, gray, gray, 255])
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use image::Rgba;

    pub(crate) fn gray(value: u8) -> RgbaImage {
        RgbaImage::from_pixel(2, 2, Rgba([value, value, value, 255]))
    }

    /// A store in a folder of its own.
    pub(crate) fn store() -> (tempfile::TempDir, Store) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = Store::new(folder.path().join("reviewed"), folder.path().join("left"));
        (folder, store)
    }

    #[test]
    fn a_missing_picture_fails_until_it_is_blessed() {
        let (_folder, store) = store();
        let missing = store.check("new", &gray(9), 255, true);
        assert!(missing.is_err_and(|why| why.contains("no reviewed picture")));
        assert_eq!(store.bless().expect("writable"), ["new"]);
        assert_eq!(store.check("new", &gray(9), 0, true), Ok(()));
        assert!(store.left().expect("readable").is_empty());
    }

    #[test]
    fn another_adapter_may_differ_by_more_and_blesses_nothing() {
        let (_folder, store) = store();
        _ = store.check("ball", &gray(100), 0, true);
        store.bless().expect("writable");
        assert_eq!(store.check("ball", &gray(103), 3, false), Ok(()));
        let changed = store.check("ball", &gray(104), 3, false);
        assert!(changed.is_err_and(|why| why.contains("4 steps of 255, at most 3 allowed")));
        let left = store.left().expect("readable");
        assert!(!left[0].may_be_blessed && left[0].name == "ball");
        assert!(store.left_as("ball", ".diff.png").is_file());
        assert!(store.bless().expect("writable").is_empty());
        assert_eq!(store.check("ball", &gray(100), 0, true), Ok(()));
        // What differed is right again: nothing stays.
        assert!(!store.left_as("ball", ".diff.png").exists());
    }

    #[test]
    fn another_size_is_no_reviewed_picture() {
        let (_folder, store) = store();
        _ = store.check("ball", &gray(1), 0, true);
        store.bless().expect("writable");
        let other = store.check("ball", &RgbaImage::new(1, 2), 255, true);
        assert!(other.is_err_and(|why| why.contains("other size")));
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
