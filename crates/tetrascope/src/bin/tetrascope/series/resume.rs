//! Frames that are there already.

use std::path::Path;

use tetrascope::core::Error;
use tetrascope::io::image::read_metadata;
use tetrascope::provenance::Input;
use tetrascope::scene::{Scene, SceneFile};
use tetrascope::{Algorithm, Settings};

/// Whether the frame at `path` is there, whole, and just what would be drawn in its place.
///
/// A file that cannot be read as a picture is drawn anew, and so is one of a step whose file
/// has changed. Another picture is refused: frames of two scenes make no series.
pub(crate) fn is_drawn(
    path: &Path,
    algorithm: &Algorithm,
    settings: &Settings,
    scene: &Scene,
) -> Result<bool, Error> {
    let Ok(texts) = read_metadata(path) else {
        return Ok(false);
    };
    let text = |key: &str| {
        let found = texts.iter().find(|(k, _)| k == key);
        found.map_or("", |(_, text)| text.as_str())
    };
    let differs = if text("Algorithm") != algorithm.name {
        "by another algorithm"
    } else if text("Settings") != settings.to_string() {
        "with other settings"
    } else {
        let drawn = SceneFile::parse(text("Scene"), Path::new("scene.toml"));
        let wanted = SceneFile::parse(&scene.to_toml(), Path::new("scene.toml"))?;
        match drawn.map(without_folders) {
            Ok(drawn) if drawn == without_folders(wanted.clone()) => {
                let folder = scene.source.file.as_deref().and_then(Path::parent);
                return Ok(is_unchanged(
                    text("Inputs"),
                    folder.unwrap_or(Path::new("")),
                ));
            }
            Ok(drawn) if drawn.volume.file != without_folders(wanted).volume.file => {
                "of another file"
            }
            _ => "of another scene",
        }
    };
    Err(Error::Usage {
        what: format!("{} is there, but is a frame {differs}", path.display()),
        help: Some(
            "remove it, choose another name with -o, or draw all anew without --resume".into(),
        ),
    })
}

/// Whether all files that a picture was made of, lines of hash and path, are in this folder
/// as they were.
fn is_unchanged(inputs: &str, folder: &Path) -> bool {
    let is_same = |line: &str| {
        let (sha256, path) = line.split_once("  ")?;
        let path = folder.join(Path::new(path).file_name()?);
        Some(Input::of(&path).ok()?.sha256() == sha256)
    };
    inputs.lines().all(|line| is_same(line) == Some(true))
}

/// The same from whatever folder files are named.
fn without_folders(mut scene: SceneFile) -> SceneFile {
    for file in [&mut scene.volume.file, &mut scene.volume.solution] {
        *file = file
            .as_ref()
            .and_then(|path| Some(path.file_name()?.into()));
    }
    scene
}
