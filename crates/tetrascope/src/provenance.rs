//! The texts in a picture's file that say how to make it again.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde_json::json;
use sha2::{Digest as _, Sha256};
use tetrascope_core::{Error, Frame, Settings};
use tetrascope_scene::Scene;

use crate::Algorithm;
use crate::volumes::Loaded;

/// The name and version of this program.
pub fn program() -> String {
    format!("tetrascope {}", env!("CARGO_PKG_VERSION"))
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Input {
    #[serde(serialize_with = "text")]
    path: PathBuf,
    /// SHA-256 of its bytes, hexadecimal.
    sha256: String,
}

/// A path as text; what is not UTF-8 in it is replaced, as JSON holds nothing else.
fn text<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

impl Input {
    /// Reads the file once more to name it by its contents.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn of(path: &Path) -> Result<Input, Error> {
        let bytes = digest(path).map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        Ok(Input {
            path: path.to_owned(),
            sha256: bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        })
    }

    /// All files that a volume was read from.
    ///
    /// # Errors
    /// As [`Input::of`].
    pub fn all_of(loaded: &Loaded) -> Result<Vec<Input>, Error> {
        loaded.files.iter().map(|path| Input::of(path)).collect()
    }

    /// SHA-256 of the file's bytes, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }
}

fn digest(path: &Path) -> std::io::Result<[u8; 32]> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut chunk = vec![0; 1 << 16];
    loop {
        match file.read(&mut chunk)? {
            0 => return Ok(hash.finalize().into()),
            length => hash.update(&chunk[..length]),
        }
    }
}

/// All that a picture was made of.
#[derive(Clone, Copy, Debug)]
pub struct Provenance<'a> {
    /// The algorithm that drew it.
    pub algorithm: &'static Algorithm,
    /// How.
    pub settings: &'a Settings,
    /// The graphics adapter in words; `None` if the CPU drew.
    pub adapter: Option<&'a str>,
    /// The volume.
    pub loaded: &'a Loaded,
    /// The files of the volume.
    pub inputs: &'a [Input],
    /// The complete scene.
    pub scene: &'a Scene,
}

impl Provenance<'_> {
    /// Keys and texts for the image file of `frame`: all that it takes to make it again, and no
    /// times, so that the same picture is the same file.
    pub fn texts(&self, frame: &Frame) -> Vec<(String, String)> {
        let mut stats = json!(frame.stats);
        if let Some(stats) = stats.as_object_mut() {
            stats.retain(|key, value| !key.ends_with("_seconds") && !value.is_null());
        }
        let inputs = self.inputs.iter();
        let inputs = inputs.map(|i| format!("{}  {}", i.sha256, i.path.display()));
        let inputs: Vec<String> = inputs.collect();
        let mut mesh = vec![self.loaded.description.clone()];
        mesh.extend(self.loaded.notes.iter().cloned());
        let texts = [
            ("Software", program()),
            ("Algorithm", self.algorithm.name.into()),
            ("Settings", self.settings.to_string()),
            ("Adapter", self.adapter.unwrap_or("CPU").into()),
            ("Mesh", mesh.join("\n")),
            ("Inputs", inputs.join("\n")),
            ("Statistics", stats.to_string()),
            ("Scene", self.scene.to_toml()),
        ];
        let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
        texts.map(|(key, text)| (key.into(), text)).collect()
    }
}
