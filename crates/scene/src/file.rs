//! A scene as a person writes it.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use serde::{Deserialize, Serialize};
use tetrascope_core::Error;

use crate::{AppearanceSpec, CameraSpec, VolumeSource};

/// The version of the scene format that this crate reads and writes.
pub const SCENE_VERSION: u32 = 1;

/// No scene file is longer: some ten thousand knots. A mesh given as a scene by mistake is,
/// and so is a device that never ends.
pub const MAX_SCENE_BYTES: u64 = 1 << 20;

/// A scene as written: what is left out is chosen by [`SceneFile::resolve`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFile {
    /// [`SCENE_VERSION`].
    pub version: u32,
    /// The volume.
    #[serde(default)]
    pub volume: VolumeSource,
    /// From where.
    #[serde(default)]
    pub camera: CameraSpec,
    /// How large and before what.
    #[serde(default)]
    pub image: ImageSpec,
    /// How scalars become light.
    #[serde(default)]
    pub appearance: AppearanceSpec,
}

/// Size and background as written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSpec {
    /// Pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// Linear RGBA, straight alpha.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub background: Option<[f32; 4]>,
}

impl SceneFile {
    /// A scene file that leaves everything out.
    pub fn new(volume: VolumeSource) -> SceneFile {
        SceneFile {
            version: SCENE_VERSION,
            volume,
            ..SceneFile::default()
        }
    }

    /// Reads the scene file at `path`; see [`SceneFile::parse`].
    ///
    /// # Errors
    /// [`Error::Io`] when it cannot be read, and [`Error::Scene`] when it has more than
    /// [`MAX_SCENE_BYTES`], is not UTF-8, or does not parse.
    pub fn read(path: &Path) -> Result<SceneFile, Error> {
        let invalid = |what: String| Error::Scene {
            at: path.display().to_string(),
            what,
            help: Some("a scene is TOML or JSON; start from a complete scene".into()),
        };
        // One byte more tells a file that is too long, whatever length it claims.
        let mut bytes = Vec::new();
        let read = File::open(path)
            .and_then(|file| file.take(MAX_SCENE_BYTES + 1).read_to_end(&mut bytes));
        read.map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        if bytes.len() as u64 > MAX_SCENE_BYTES {
            return Err(invalid(format!(
                "a file of more than {MAX_SCENE_BYTES} bytes is not a scene file"
            )));
        }
        // A mesh given as a scene by mistake; whatever parses it says less.
        let is_named = path.extension().is_some_and(|extension| {
            ["toml", "json"]
                .iter()
                .any(|known| extension.eq_ignore_ascii_case(known))
        });
        let begins_as = |start: &[u8]| bytes.trim_ascii_start().starts_with(start);
        if !is_named
            && [&b"<"[..], b"# vtk", b"\x89", b"NRRD", b"$Mesh"]
                .into_iter()
                .any(begins_as)
        {
            return Err(Error::Scene {
                at: path.display().to_string(),
                what: "this is not a scene, but looks like a mesh or a grid".into(),
                help: Some("give it as the volume, without `scene`".into()),
            });
        }
        let text = String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            invalid(format!("byte {at} is not text (UTF-8)"))
        })?;
        SceneFile::parse(&text, path)
    }

    /// Parses TOML, or JSON where `path` ends in `.json`.
    ///
    /// Relative paths inside are taken from the folder of `path`. Unknown keys
    /// and other versions are refused, with line and column.
    pub fn parse(text: &str, path: &Path) -> Result<SceneFile, Error> {
        let wrong = |line: usize, column: usize, what: &str| Error::Scene {
            at: format!("{}, line {line}, column {column}", path.display()),
            what: what.trim().replace('\n', "; "),
            help: Some("start from a complete scene".into()),
        };
        let is_json = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("json"));
        let mut scene: SceneFile = if is_json {
            serde_json::from_str(text).map_err(|e| {
                // serde_json ends its message with the position that we give ourselves.
                let message = e.to_string();
                let what = message
                    .rsplit_once(" at line")
                    .map_or(message.as_str(), |(what, _)| what);
                wrong(e.line(), e.column(), what)
            })?
        } else {
            toml::from_str(text).map_err(|e: toml::de::Error| {
                let (line, column) = position(text, e.span().map_or(0, |span| span.start));
                wrong(line, column, e.message())
            })?
        };
        if scene.version != SCENE_VERSION {
            return Err(Error::Scene {
                at: path.display().to_string(),
                what: format!("scene version {} is unknown", scene.version),
                help: Some(format!("this program reads version = {SCENE_VERSION}")),
            });
        }
        if let Some(folder) = path.parent() {
            for file in [&mut scene.volume.file, &mut scene.volume.solution]
                .into_iter()
                .flatten()
            {
                *file = folder.join(&*file);
            }
        }
        Ok(scene)
    }
}

/// Line and column, from 1, of byte `offset`.
fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn a_scene_is_read_to_a_bound() {
        let read = |path: &str| SceneFile::read(Path::new(path)).expect_err("not a scene");
        if cfg!(unix) {
            let error = read("/dev/zero").to_string();
            assert!(error.contains("more than 1048576 bytes"), "{error}");
        }
        assert!(matches!(read("no such file"), Error::Io { .. }));
    }

    #[test]
    fn paths_start_at_the_scene_file() {
        let scene = SceneFile::parse(
            "version = 1\n[volume]\nfile = \"b.vtu\"",
            Path::new("x/a.toml"),
        );
        assert_eq!(
            scene.expect("valid").volume.file,
            Some(PathBuf::from("x/b.vtu"))
        );
    }

    #[test]
    fn mistakes_are_refused_with_their_place() {
        let error = |text: &str, path: &str| {
            SceneFile::parse(text, Path::new(path))
                .expect_err("a mistake")
                .to_string()
        };
        let misspelt = error("version = 1\n[image]\nwidht = 3", "a.toml");
        assert!(
            misspelt.contains("widht") && misspelt.contains("line 3, column 1"),
            "{misspelt}"
        );
        let json = error("{\"version\": 1,\n \"colour\": 2}", "a.json");
        assert!(json.contains("colour") && json.contains("line 2"), "{json}");
        assert!(error("version = 2", "a.toml").contains("version 2"));
        assert!(error("version = ", "a.toml").contains("line 1"));
    }
}
