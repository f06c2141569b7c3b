//! The description of a picture: written into it, and printed.

use std::path::Path;

use serde_json::{Value, json};
use tetrascope::core::{Error, Frame};
use tetrascope::provenance::{Input, Provenance, program};
use tetrascope::raycast_cpu;
use tetrascope::scene::Scene;
use tetrascope::volumes::Loaded;
use tetrascope::{Settings, help};
use tetrascope_cluster::Times;

/// A picture of all ranks, and where it comes from.
pub(crate) struct Report<'a> {
    pub(crate) settings: &'a Settings,
    pub(crate) loaded: &'a Loaded,
    pub(crate) scene: &'a Scene,
    pub(crate) frame: &'a Frame,
    /// By rank.
    pub(crate) times: &'a [Times],
    /// Seconds of reading at rank 0, which waits for the others.
    pub(crate) read: f64,
    /// Seconds of the picture at rank 0.
    pub(crate) seconds: f64,
    pub(crate) warning: Option<&'a Error>,
}

impl Report<'_> {
    /// Keys and texts for the image file.
    pub(crate) fn metadata(&self, inputs: &[Input]) -> Result<Vec<(String, String)>, Error> {
        let provenance = Provenance {
            algorithm: tetrascope::algorithm(raycast_cpu::NAME)?,
            settings: self.settings,
            adapter: None,
            loaded: self.loaded,
            inputs,
            scene: self.scene,
        };
        Ok(provenance.texts(self.frame))
    }

    /// The greatest measure of all ranks.
    fn most(&self, measure: impl Fn(&Times) -> f64) -> f64 {
        self.times.iter().map(measure).fold(0.0, f64::max)
    }

    fn sum(&self, count: impl Fn(&Times) -> u64) -> u64 {
        self.times.iter().map(count).sum()
    }

    /// Measures, one line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        vec![
            format!("seconds: {:.4}", self.seconds),
            format!("seconds of casting, at most: {:.4}", self.most(|t| t.cast)),
            format!(
                "seconds of exchange, at most: {:.4}",
                self.most(|t| t.exchange)
            ),
            format!(
                "seconds of gathering, at most: {:.4}",
                self.most(|t| t.gather)
            ),
            format!("bytes exchanged: {}", self.sum(|t| t.bytes)),
            format!("runs exchanged: {}", self.sum(|t| t.runs)),
            format!("bytes of pixels: {}", self.sum(|t| t.pixel_bytes)),
        ]
    }

    /// The description and the measures of each rank, as JSON.
    pub(crate) fn json(&self, path: &Path) -> Result<Value, Error> {
        let settings = self
            .settings
            .iter()
            .map(|(key, value)| (key.into(), value.into()));
        let settings: serde_json::Map<String, Value> = settings.collect();
        let volume = &self.loaded.volume;
        let bounds = volume.bounds();
        let of_rank = |times: &Times| {
            json!({
                "cast": times.cast,
                "wait": times.wait,
                "exchange": times.exchange,
                "gather": times.gather,
                "bytes": times.bytes,
                "messages": times.messages,
                "runs": times.runs,
                "pixel_bytes": times.pixel_bytes,
                "bands": times.bands,
                "received_runs": times.received_runs,
                "cast_work": times.cast_work,
                "exchange_work": times.exchange_work,
                "gather_work": times.gather_work,
            })
        };
        let warnings = self.warning.into_iter();
        let warnings: Vec<Value> = warnings
            .map(|w| json!({"message": w.to_string(), "help": help(w)}))
            .collect();
        Ok(json!({
            "program": program(),
            "width": self.frame.width,
            "height": self.frame.height,
            "algorithm": raycast_cpu::NAME,
            "settings": settings,
            "volume": {
                "description": self.loaded.description,
                "notes": self.loaded.notes,
                "cells": volume.cell_count(),
                "scalar_range": volume.scalar_range(),
                "bounds": [bounds.min, bounds.max],
            },
            "scene": self.scene.to_file(),
            "defaults": self.scene.defaults,
            "statistics": self.frame.stats,
            "seconds": {
                "read": self.read,
                "render": self.seconds,
                "cast": self.most(|t| t.cast),
                "exchange": self.most(|t| t.exchange),
                "gather": self.most(|t| t.gather),
            },
            "ranks": self.times.iter().map(of_rank).collect::<Vec<Value>>(),
            "warnings": warnings,
            "output": path.to_string_lossy(),
        }))
    }
}

/// "1 rank", "2 ranks".
pub(crate) fn count(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}
