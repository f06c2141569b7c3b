//! Finished parts of a run, kept until all is done: the same run, interrupted and started again, goes on
//! from there.
//!
//! A part is one scene under one optical model. It is taken only by the same program with the same
//! plan on the same adapter, and only if the scene and its files are what they were.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use image::RgbaImage;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use tetrascope::core::Error;
use tetrascope::scene::Scene;

use super::Options;
use crate::output::write;
use crate::picture::{SignedMap, png};
use crate::report::{Difference, ModelReport, Picture};

/// A scene under one optical model.
pub(super) struct Part {
    pub(super) model: ModelReport,
    pub(super) pictures: Vec<Picture>,
}

/// Where parts are.
pub(super) struct Parts {
    /// The folder of all runs.
    folder: PathBuf,
    /// The folder of runs like this one; `None` where this program cannot be told from another.
    own: Option<PathBuf>,
}

/// The adapter and the peer, in words, as far as there are.
type Device<'a> = (Option<&'a String>, Option<&'a str>);

/// A part as a file.
#[derive(Deserialize, Serialize)]
struct Stored {
    sha256: BTreeMap<String, String>,
    model: ModelReport,
    pictures: Vec<StoredPicture>,
}

/// A picture, with images as PNG files in base64.
#[derive(Deserialize, Serialize)]
struct StoredPicture {
    algorithm: String,
    setting: String,
    image: String,
    difference: Option<StoredDifference>,
}

#[derive(Deserialize, Serialize)]
struct StoredDifference {
    /// Image, end of the scale, and pixels beyond.
    map: Option<(String, f64, usize)>,
    worst_pixel: [u32; 2],
}

impl Parts {
    /// The parts of runs like this one, beside its report.
    pub(super) fn open(out: &Path, options: &Options, device: Device) -> Parts {
        let folder = out.join("parts");
        let own = name(options, device).map(|name| folder.join(name));
        Parts { folder, own }
    }

    fn file(&self, (scene, model): (usize, usize)) -> Option<PathBuf> {
        Some(self.own.as_ref()?.join(format!("{scene}-{model}.json")))
    }

    /// The part that a run before has drawn of this; `None` where it has not, or of something else. A part that
    /// cannot be read is drawn again.
    pub(super) fn read(
        &self,
        place: (usize, usize),
        scene: &Scene,
        sha256: &BTreeMap<String, String>,
    ) -> Option<Part> {
        let bytes = std::fs::read(self.file(place)?).ok()?;
        let stored: Stored = serde_json::from_slice(&bytes).ok()?;
        if stored.model.scene != scene.to_toml() || stored.sha256 != *sha256 {
            return None;
        }
        let mut model = stored.model;
        model.promise_again();
        let pictures = stored.pictures.into_iter().map(StoredPicture::read);
        Some(Part {
            model,
            pictures: pictures.collect::<Option<_>>()?,
        })
    }

    /// Keeps a part, whole or not at all.
    pub(super) fn write(
        &self,
        place: (usize, usize),
        part: &Part,
        sha256: &BTreeMap<String, String>,
    ) -> Result<(), Error> {
        let Some(file) = self.file(place) else {
            return Ok(());
        };
        #[derive(Serialize)]
        struct Written<'a> {
            sha256: &'a BTreeMap<String, String>,
            model: &'a ModelReport,
            pictures: Vec<StoredPicture>,
        }
        let written = Written {
            sha256,
            model: &part.model,
            pictures: part.pictures.iter().map(StoredPicture::of).collect(),
        };
        let json = serde_json::to_vec(&written).expect("parts are plain data");
        write(&file, json)
    }

    /// All is done, so that the next run draws all anew. What other runs have left goes, too.
    pub(super) fn finish(self) {
        // What stays takes room and is never wrong.
        _ = std::fs::remove_dir_all(self.folder);
    }
}

/// A name for runs like this one, from the program's own bytes, what it was asked and on what it draws.
fn name(options: &Options, device: Device) -> Option<String> {
    let asked = Options {
        out: None,
        json: false,
        ..options.clone()
    };
    let mut hash = Sha256::new();
    hash.update(std::fs::read(std::env::current_exe().ok()?).ok()?);
    hash.update(format!("{asked:?} {device:?}"));
    let bytes = hash.finalize();
    let hex = bytes.iter().take(8).map(|byte| format!("{byte:02x}"));
    Some(hex.collect())
}

impl StoredPicture {
    fn of(picture: &Picture) -> StoredPicture {
        StoredPicture {
            algorithm: picture.algorithm.clone(),
            setting: picture.setting.clone(),
            image: STANDARD.encode(png(&picture.image)),
            difference: picture.difference.as_ref().map(|difference| {
                let map = difference.map.as_ref();
                StoredDifference {
                    map: map.map(|m| (STANDARD.encode(png(&m.image)), m.end, m.beyond)),
                    worst_pixel: difference.worst_pixel,
                }
            }),
        }
    }

    fn read(self) -> Option<Picture> {
        let difference = match self.difference {
            None => None,
            Some(StoredDifference { map, worst_pixel }) => {
                let map = match map {
                    None => None,
                    Some((file, end, beyond)) => Some(SignedMap {
                        image: image(&file)?,
                        end,
                        beyond,
                    }),
                };
                Some(Difference { map, worst_pixel })
            }
        };
        Some(Picture {
            algorithm: self.algorithm,
            setting: self.setting,
            image: image(&self.image)?,
            difference,
        })
    }
}

fn image(base64: &str) -> Option<RgbaImage> {
    let file = STANDARD.decode(base64).ok()?;
    Some(image::load_from_memory(&file).ok()?.into_rgba8())
}
