//! Descriptions for pages, in JSON.

use serde_json::{Value, json};
use tetrascope_core::colormap::{Colormap, linear_to_srgb};
use tetrascope_core::{OpticalModel, Promise, Values};
use tetrascope_io::Step;
use tetrascope_scene::{CameraSpec, ColorSpace, Preset};

use super::command::{Command, Message};
use super::picture::{command_line, short_command_line, stem};
use super::quick;
use super::state::State;
use crate::algorithms;

/// Colors of a map's picture.
const SWATCH: u32 = 32;

/// The parts that do not change: algorithms, models, color maps.
pub(crate) fn catalog() -> Value {
    let algorithms = algorithms().iter().map(|algorithm| {
        let settings = algorithm.settings.iter().map(|setting| {
            let values = match setting.values {
                Values::Choice(words) => json!({"choice": words}),
                Values::Integer { min, max } => json!({"integer": [min, max]}),
                Values::Number { min, max } => json!({"number": [min, max]}),
            };
            json!({
                "name": setting.name,
                "about": setting.about,
                "default": setting.default,
                "values": values,
            })
        });
        json!({
            "name": algorithm.name,
            "title": algorithm.title,
            "paper": algorithm.paper,
            "draws": algorithm.draws,
            "needs_gpu": algorithm.needs_gpu,
            "settings": settings.collect::<Vec<_>>(),
        })
    });
    let colormaps = Colormap::ALL.map(|map| {
        let color = |i: u32| {
            let color = map.linear_rgb(f64::from(i) / f64::from(SWATCH - 1));
            color.to_array().map(linear_to_srgb)
        };
        let colors: Vec<[f64; 3]> = (0..SWATCH).map(color).collect();
        json!({"name": map.name(), "colors": colors})
    });
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "algorithms": algorithms.collect::<Vec<_>>(),
        "colormaps": colormaps,
        "models": OpticalModel::ALL.map(OpticalModel::name),
        "color_spaces": ColorSpace::ALL.map(ColorSpace::name),
    })
}

/// The volume, its fields and time steps.
pub(crate) fn field(state: &State, steps: &[Step]) -> Value {
    let field = &state.field;
    let loaded = &field.loaded;
    let volume = field.volume();
    let bounds = volume.bounds();
    let steps = steps.iter().map(|step| {
        let name = step.file.file_name().unwrap_or_default();
        json!({"name": name.to_string_lossy(), "time": step.time})
    });
    json!({
        "type": "field",
        "name": stem(state),
        "description": loaded.description,
        "notes": loaded.notes,
        "fields": loaded.fields,
        "field": field.name(),
        "field_id": field.id,
        "range": volume.scalar_range(),
        "bounds": [bounds.min, bounds.max],
        "diagonal": bounds.diagonal(),
        "cells": volume.cell_count(),
        "values": {
            "count": field.values.count(),
            "is_complete": field.values.is_complete(),
        },
        "steps": steps.collect::<Vec<_>>(),
        "step": field.step,
    })
}

/// The camera alone, while a hand moves.
pub(crate) fn camera(state: &State, by: Option<u64>) -> Value {
    json!({
        "type": "camera",
        "version": state.version,
        "by": by,
        "field_id": state.field.id,
        "camera": CameraSpec::of(&state.scene.view.camera),
    })
}

/// The state, and what follows from it.
pub(crate) fn state(state: &State, by: Option<u64>) -> Value {
    let scene = &state.scene;
    let view = &scene.view;
    let promise = match (state.algorithm.promise)(&state.settings) {
        Promise::Truth => "the truth itself, with a bound on its error".into(),
        Promise::Exact => "exact but for rounding".into(),
        Promise::ExactIfProven => "exact where the order of cells is proven".into(),
        Promise::RoughOrder => "some cells may be blended in the wrong order".into(),
        Promise::Within(error) => format!("off by at most {error} by design"),
        Promise::Open => "an error that depends on the scene".into(),
    };
    let reasons = quick::drawn_by(state).into_iter();
    let reasons = reasons.map(|(name, why)| (name.to_owned(), json!(why)));
    let settings = state.settings.iter();
    let settings = settings.map(|(key, value)| (key.to_owned(), json!(value)));
    let look = &state.look;
    json!({
        "type": "state",
        "version": state.version,
        "by": by,
        "field_id": state.field.id,
        "step": state.field.step,
        "camera": CameraSpec::of(&view.camera),
        "size": [view.width, view.height],
        "background": state.background,
        "shown_background": view.background,
        "model": scene.appearance.optical_model,
        "range": scene.appearance.transfer_function.range(),
        "knots": scene.appearance.transfer_function.knots().len(),
        "look": {
            "preset": look.preset,
            "colormap": look.colormap,
            "unit_distance": look.unit_distance,
            "surfaces": look.surfaces,
        },
        "isosurfaces": scene.appearance.isosurfaces,
        "clip": scene.appearance.clip_planes,
        "depth_cue": scene.appearance.depth_cue.map(|cue| cue.strength),
        "algorithm": state.algorithm.name,
        "settings": settings.collect::<serde_json::Map<_, _>>(),
        "promise": promise,
        "reasons": reasons.collect::<serde_json::Map<_, _>>(),
        "defaults": scene.defaults,
        "command": command_line(state),
        "short_command": short_command_line(state),
        "saved": state.saved(),
    })
}

/// The parts of a message that are passed over, a sentence each.
pub(crate) fn notes(message: &Message) -> Vec<String> {
    match &message.command {
        Some(Command::ImportPreset { text, .. }) => {
            Preset::from_json(text).map_or(Vec::new(), |read| read.notes)
        }
        Some(Command::ImportScene { .. }) => {
            vec!["camera, background and look are those of the file; the volume stays".into()]
        }
        _ => Vec::new(),
    }
}
