//! The description of a picture: written into it, and printed as JSON.

use serde_json::{Value, json};
use tetrascope::core::{Error, Frame};
use tetrascope::provenance::{Input, Provenance, program};
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

/// Seconds that each step took.
#[derive(serde::Serialize)]
pub(crate) struct Times {
    pub(crate) load: f64,
    pub(crate) prepare: f64,
    pub(crate) render: f64,
    pub(crate) write: f64,
}

impl Picture<'_> {
    /// Keys and texts for the image file.
    pub(crate) fn metadata(&self) -> Vec<(String, String)> {
        let provenance = Provenance {
            algorithm: self.algorithm,
            settings: &self.settings,
            adapter: self.adapter.as_deref(),
            loaded: self.loaded,
            inputs: &self.inputs,
            scene: &self.scene,
        };
        provenance.texts(&self.frame)
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
