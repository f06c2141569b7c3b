//! Lists of what there is, as JSON, and what a file holds.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use serde_json::{Value, json};
use tetrascope::core::colormap::Colormap;
use tetrascope::core::mesh::type_name;
use tetrascope::core::{CameraFit, Error, OpticalModel, Setting, Values};
use tetrascope::io::{FORMATS, is_collection, read_collection, read_steps};
use tetrascope::scene::{self, VolumeSource};
use tetrascope::volumes::{BareMesh, Contents, examine};
use tetrascope::{datasets, gpu};

use crate::context;
use crate::scene::parsed;
use crate::work::run;

/// Every algorithm: what it is, what it draws, its settings.
#[pyfunction]
pub(crate) fn algorithms() -> String {
    let all = tetrascope::algorithms().iter().map(|algorithm| {
        let sweep = (algorithm.sweep)(OpticalModel::EmissionAbsorption);
        json!({
            "name": algorithm.name,
            "title": algorithm.title,
            "draws": algorithm.draws,
            "paper": algorithm.paper,
            "needs_gpu": algorithm.needs_gpu,
            "is_truth": algorithm.is_truth(),
            "settings": algorithm.settings.iter().map(setting).collect::<Vec<_>>(),
            "sweep": sweep,
        })
    });
    Value::Array(all.collect()).to_string()
}

fn setting(setting: &Setting) -> Value {
    let values = match setting.values {
        Values::Choice(words) => json!(words),
        range => json!(range.to_string()),
    };
    json!({
        "name": setting.name,
        "about": setting.about,
        "values": values,
        "default": setting.default,
    })
}

/// The graphics adapter in words, if one is used.
#[pyfunction]
pub(crate) fn adapter() -> Option<String> {
    context().adapter()
}

/// The names that parameters take, the version, and the graphics adapters if asked for.
#[pyfunction]
pub(crate) fn names(py: Python<'_>, with_adapters: bool) -> PyResult<String> {
    let adapters = match with_adapters {
        true => run(py, || {
            let all = gpu::adapters();
            Ok(all.iter().map(|a| a.name.clone()).collect())
        })?,
        false => Vec::new(),
    };
    let formats = FORMATS.iter().filter(|format| format.is_read);
    let formats = formats.map(|f| json!({"name": f.name, "extensions": f.extensions}));
    let sets = datasets::all().iter();
    let sets = sets.map(|set| json!({"name": set.name, "about": set.about}));
    Ok(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "adapters": adapters,
        "colormaps": Colormap::ALL.map(Colormap::name),
        "optical_models": OpticalModel::ALL.map(OpticalModel::name),
        "fits": CameraFit::ALL.map(|(name, _)| name),
        "formats": formats.collect::<Vec<_>>(),
        "datasets": sets.collect::<Vec<_>>(),
    })
    .to_string())
}

/// The name of `valid` that was meant, if any is near.
#[pyfunction]
pub(crate) fn nearest(name: &str, valid: Vec<String>) -> Option<String> {
    scene::nearest(name, &valid).map(String::from)
}

/// The content of a file or a data set, as JSON; `source` is as for `load`.
#[pyfunction]
pub(crate) fn info(py: Python<'_>, file: Option<PathBuf>, source: &str) -> PyResult<String> {
    let mut source: VolumeSource = parsed(py, source)?;
    source.file = file;
    let contents = run(py, move || examine(&source))?;
    let found = match contents {
        Contents::Drawable(loaded) => {
            let bounds = loaded.volume.bounds();
            json!({
                "description": loaded.description,
                "field": loaded.field,
                "fields": loaded.fields,
                "cells": loaded.volume.cell_count(),
                "range": loaded.volume.scalar_range(),
                "bounds": [
                    bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y, bounds.min.z,
                    bounds.max.z,
                ],
                "notes": loaded.notes,
            })
        }
        Contents::Bare(bare) => of_bare(&bare),
    };
    Ok(found.to_string())
}

fn of_bare(bare: &BareMesh) -> Value {
    let cells = bare.cells_by_type.iter();
    let cells = cells.map(|(&kind, count)| format!("{} × {count}", type_name(kind)));
    let (min, max) = (bare.bounds.min, bare.bounds.max);
    json!({
        "description": format!("{}: there is nothing to draw", bare.why),
        "field": null,
        "fields": bare.fields,
        "cells": bare.mesh.as_ref().map_or(0, |mesh| mesh.cell_count()),
        "cells_by_type": cells.collect::<Vec<_>>(),
        "range": null,
        "bounds": [min.x, max.x, min.y, max.y, min.z, max.z],
        "notes": bare.notes,
    })
}

/// The time steps of a file or of a collection: file, number in it, time.
#[pyfunction]
pub(crate) fn steps(py: Python<'_>, path: PathBuf) -> PyResult<Steps> {
    run(py, move || steps_of(&path))
}

/// File, number of the step in it, time.
type Steps = Vec<(PathBuf, Option<usize>, Option<f64>)>;

fn steps_of(path: &Path) -> Result<Steps, Error> {
    if is_collection(path) {
        let all = read_collection(path)?.into_iter();
        return Ok(all.map(|s| (s.file, s.number, s.time)).collect());
    }
    let times = read_steps(path)?;
    if times.is_empty() {
        return Ok(vec![(path.to_owned(), None, None)]);
    }
    let all = times.into_iter().enumerate();
    Ok(all
        .map(|(number, time)| (path.to_owned(), Some(number), Some(time)))
        .collect())
}
