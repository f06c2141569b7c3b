//! `algorithms`, `formats`, `adapters`, `datasets`, `colormaps`.

use serde_json::{Value, json};
use tetrascope::core::Error;
use tetrascope::core::colormap::Colormap;
use tetrascope::io::{FORMATS, FileFormat};
use tetrascope::{Algorithm, Setting, Values, datasets as data};

use crate::output::{Output, Stop};

pub(crate) fn algorithms(output: &Output) -> Result<(), Stop> {
    let all = tetrascope::algorithms();
    if output.json() {
        let list: Vec<Value> = all.iter().map(algorithm_json).collect();
        return output.json_result(&list.into());
    }
    let blocks: Vec<String> = all.iter().map(algorithm_text).collect();
    output.result(blocks.join("\n\n"))
}

pub(crate) fn formats(output: &Output) -> Result<(), Stop> {
    if output.json() {
        let list = FORMATS.iter().map(|format| {
            json!({
                "name": format.name,
                "extensions": format.extensions,
                "holds": format.holds.name(),
                "read": format.is_read,
                "written": format.is_written,
                "time_steps": format.has_steps,
                "streamed": format.streams,
                "feature": format.feature,
                "limits": format.limits,
            })
        });
        return output.json_result(&list.collect());
    }
    let blocks: Vec<String> = FORMATS.iter().map(format_text).collect();
    output.result(blocks.join("\n"))
}

fn format_text(format: &FileFormat) -> String {
    let extensions: Vec<String> = format.extensions.iter().map(|e| format!(".{e}")).collect();
    let mut can = match (format.is_read, format.is_written) {
        (true, true) => "read and written",
        (true, false) => "read",
        (false, _) => "not read",
    }
    .to_owned();
    if let (false, Some(feature)) = (format.is_read, format.feature) {
        can += &format!(", as this program was built without the feature {feature}");
    }
    if format.has_steps {
        can += "; time steps are chosen";
    }
    if format.streams {
        can += "; large ones stay in their file";
    }
    format!(
        "{}: {}\n  {}, {can}\n  {}",
        format.name,
        extensions.join(" "),
        format.holds.name(),
        format.limits
    )
}

fn algorithm_text(algorithm: &Algorithm) -> String {
    let mut lines = vec![
        format!("{}: {}", algorithm.name, algorithm.title),
        format!("  paper     {}", algorithm.paper),
        format!("  draws     {}", algorithm.draws),
        format!("  runs on   {}", device(algorithm)),
    ];
    if algorithm.settings.is_empty() {
        lines.push("  settings  none".into());
    } else {
        lines.push("  settings  (--set KEY=VALUE)".into());
    }
    for setting in algorithm.settings {
        let Setting {
            name,
            about,
            values,
            default,
            .. // `about` says for what it is
        } = setting;
        lines.push(format!("    {name}: {about}"));
        lines.push(format!("      {values} [default: {default}]"));
    }
    lines.push("  counters  (render -v, render --json)".into());
    for counter in algorithm.counters {
        let name = counter.name.replace('_', " ");
        lines.push(format!("    {name}: {}", counter.about));
    }
    lines.join("\n")
}

fn algorithm_json(algorithm: &Algorithm) -> Value {
    let settings = algorithm.settings.iter().map(|setting| {
        let mut value = json!({
            "name": setting.name,
            "about": setting.about,
            "default": setting.default,
        });
        match setting.values {
            Values::Choice(words) => value["values"] = json!(words),
            Values::Integer { min, max } => {
                (value["min"], value["max"]) = (json!(min), json!(max));
            }
            Values::Number { min, max } => {
                (value["min"], value["max"]) = (json!(min), json!(max));
            }
        }
        value
    });
    let counters = algorithm
        .counters
        .iter()
        .map(|c| json!({ "name": c.name, "unit": c.unit, "about": c.about }));
    json!({
        "name": algorithm.name,
        "title": algorithm.title,
        "paper": algorithm.paper,
        "draws": algorithm.draws,
        "device": device(algorithm),
        "settings": settings.collect::<Vec<Value>>(),
        "counters": counters.collect::<Vec<Value>>(),
    })
}

fn device(algorithm: &Algorithm) -> &'static str {
    if algorithm.needs_gpu { "GPU" } else { "CPU" }
}

/// No adapter at all is an error, so that a script can ask.
pub(crate) fn adapters(output: &Output) -> Result<(), Stop> {
    let list = adapter_list()?;
    if output.json() {
        return output.json_result(&list.into());
    }
    output.result(list.join("\n"))
}

#[cfg(feature = "gpu")]
fn adapter_list() -> Result<Vec<String>, Error> {
    use tetrascope::gpu::{Gpu, GpuOptions, adapters, describe};
    let found = adapters();
    if found.is_empty() {
        Gpu::new(&GpuOptions::default())?; // says what is missing
    }
    Ok(found.iter().map(describe).collect())
}

#[cfg(not(feature = "gpu"))]
fn adapter_list() -> Result<Vec<String>, Error> {
    Err(Error::NoAdapter {
        reason: "this program was built without GPU support".into(),
        help: Some("build it with a GPU algorithm: --features projection".into()),
    })
}

pub(crate) fn datasets(output: &Output) -> Result<(), Stop> {
    if output.json() {
        let entry = |d: &data::Dataset| {
            json!({
                "name": d.name,
                "about": d.about,
                "source": d.paper,
                "cells": d.default_cells,
                "seeded": d.seeded,
            })
        };
        let list: Vec<Value> = data::all().iter().map(entry).collect();
        return output.json_result(&list.into());
    }
    let entry = |d: &data::Dataset| {
        let seeded = if d.seeded { ", seeded" } else { "" };
        format!(
            "{}: {}\n  about {} cells{seeded}; {}",
            d.name, d.about, d.default_cells, d.paper
        )
    };
    let list: Vec<String> = data::all().iter().map(entry).collect();
    output.result(list.join("\n"))
}

pub(crate) fn colormaps(output: &Output) -> Result<(), Stop> {
    let names = Colormap::ALL.map(Colormap::name);
    if output.json() {
        return output.json_result(&json!(names));
    }
    output.result(names.join("\n"))
}
