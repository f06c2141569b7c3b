//! The description of a picture: written into it, and printed as JSON.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest as _, Sha256};
use tetrascope::core::{Error, Frame};
use tetrascope::scene::Scene;
use tetrascope::volumes::Loaded;
use tetrascope::{Algorithm, Settings, help};

/// A picture and where it comes from.
pub(crate) struct Picture<'a> {
    pub(crate) algorithm: &'static Algorithm,
    pub(crate) settings: Settings,
    pub(crate) loaded: &'a Loaded,
    pub(crate) inputs: Vec<Input>,
    pub(crate) scene: Scene,
    /// In words; `None` if the CPU drew.
    pub(crate) adapter: Option<String>,
    pub(crate) frame: Frame,
}

/// A file that was read.
#[derive(serde::Serialize)]
pub(crate) struct Input {
    #[serde(serialize_with = "text")]
    path: PathBuf,
    /// SHA-256 of its bytes, hexadecimal.
    sha256: String,
}

/// Seconds that each step took.
#[derive(serde::Serialize)]
pub(crate) struct Times {
    pub(crate) load: f64,
    pub(crate) prepare: f64,
    pub(crate) render: f64,
    pub(crate) write: f64,
}

/// A path as text; what is not UTF-8 in it is replaced, as JSON holds nothing else.
fn text<S: serde::Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

impl Input {
    /// SHA-256 of the file's bytes, hexadecimal.
    pub(crate) fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Reads the file once more to name it by its contents.
    pub(crate) fn of(path: &Path) -> Result<Input, Error> {
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
}

impl Picture<'_> {
    /// Keys and texts for the image file: all that it takes to make it again, and
    /// no times, so that the same picture is the same file.
    pub(crate) fn metadata(&self) -> Vec<(String, String)> {
        let mut stats = json!(self.frame.stats);
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
            (
                "Adapter",
                self.adapter.clone().unwrap_or_else(|| "CPU".into()),
            ),
            ("Mesh", mesh.join("\n")),
            ("Inputs", inputs.join("\n")),
            ("Statistics", stats.to_string()),
            ("Scene", self.scene.to_toml()),
        ];
        let texts = texts.into_iter().filter(|(_, text)| !text.is_empty());
        texts.map(|(key, text)| (key.into(), text)).collect()
    }

    /// The same, the times and why it shows little if so, as JSON.
    pub(crate) fn report(&self, times: &Times, warning: Option<&Error>) -> Value {
        let settings = self
            .settings
            .iter()
            .map(|(key, value)| (key.into(), value.into()));
        let settings: serde_json::Map<String, Value> = settings.collect();
        let volume = &self.loaded.volume;
        let bounds = volume.bounds();
        json!({
            "program": program(),
            "width": self.frame.width,
            "height": self.frame.height,
            "algorithm": self.algorithm.name,
            "settings": settings,
            "adapter": self.adapter,
            "volume": {
                "description": self.loaded.description,
                "notes": self.loaded.notes,
                "cells": volume.cell_count(),
                "scalar_range": volume.scalar_range(),
                "bounds": [bounds.min, bounds.max],
                "inputs": self.inputs,
            },
            "scene": self.scene.to_file(),
            "defaults": self.scene.defaults,
            "statistics": self.frame.stats,
            "seconds": times,
            "warnings": warnings(warning),
        })
    }

    /// The frame's statistics, one line each.
    pub(crate) fn statistics(&self) -> Vec<String> {
        let stats = json!(self.frame.stats);
        let entries = stats.as_object().into_iter().flatten();
        entries
            .filter(|(_, value)| !value.is_null() && !value.is_array())
            .map(|(key, value)| format!("{}: {value}", key.replace('_', " ")))
            .collect()
    }
}

/// Warnings as JSON.
pub(crate) fn warnings(warning: Option<&Error>) -> Value {
    let warnings = warning.into_iter();
    warnings
        .map(|w| json!({"message": w.to_string(), "help": help(w)}))
        .collect()
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

fn program() -> String {
    format!("tetrascope {}", env!("CARGO_PKG_VERSION"))
}
