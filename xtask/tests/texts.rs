//! Counters of frames and the layout of `report.json`, as reviewed texts.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::process::Command;

use serde_json::Value;
use tetrascope::Algorithm;
use tetrascope::core::{CameraFit, Volume};
use tetrascope_testing::{Place, data_set, fitted, grid, ramp};
use xtask::testing::{algorithms, draw};

/// Counters whose values follow from the scene, whoever draws: the others depend on an adapter's
/// rounding at the edges of cells and pixels, or on how much it does at a time.
const DETERMINED: [(&str, &[&str]); 3] = [
    ("reference", &["cell_visits", "inconsistent_pixels"]),
    ("projection", &["cells_drawn", "cells_skipped", "lost_rays"]),
    ("slicing", &["bricks_drawn", "bricks_skipped", "vertices"]),
];

/// Counters of one frame, with the values that are [`DETERMINED`].
fn counts(algorithm: &Algorithm, volume: &Volume) -> Option<String> {
    let view = fitted(volume, CameraFit::PlusIso, true, 32);
    let stats = draw(algorithm, "", volume, &ramp(volume), &view)?.stats;
    let determined = DETERMINED.iter().find(|d| d.0 == algorithm.name);
    let mut lines = String::new();
    for count in &stats.counts {
        let name = count.counter.name;
        let value = match determined.is_some_and(|d| d.1.contains(&name)) {
            true => count.value.to_string(),
            false => "some".into(),
        };
        _ = writeln!(lines, "  {name}: {value} {}", count.counter.unit);
    }
    Some(lines)
}

#[test]
fn frames_count_as_reviewed() {
    let volumes = [
        ("mesh", Volume::Mesh(data_set("sphere", Some(3000)))),
        (
            "grid",
            Volume::Grid(grid(&Place::unit(8), |p| p.x + p.y * p.z)),
        ),
    ];
    let drawing = algorithms("frames_count_as_reviewed");
    if drawing.len() < tetrascope::algorithms().len() {
        return; // said to be skipped
    }
    let mut text = String::new();
    for algorithm in drawing {
        for (name, volume) in &volumes {
            if let Some(lines) = counts(algorithm, volume) {
                _ = write!(text, "{}, {name}\n{lines}", algorithm.name);
            }
        }
    }
    insta::assert_snapshot!("counters", text);
}

/// The types of all values by their places, "scenes[].models[].size[]".
fn layout(place: &str, value: &Value, types: &mut BTreeMap<String, BTreeSet<&'static str>>) {
    let mut note = |kind| _ = types.entry(place.into()).or_default().insert(kind);
    match value {
        Value::Null => note("null"),
        Value::Bool(_) => note("true or false"),
        Value::Number(_) => note("number"),
        Value::String(_) => note("text"),
        Value::Array(items) => {
            note("list");
            let place = format!("{place}[]");
            items.iter().for_each(|item| layout(&place, item, types));
        }
        Value::Object(fields) => {
            note("object");
            for (name, field) in fields {
                layout(&format!("{place}.{name}"), field, types);
            }
        }
    }
}

/// Fields that are null on some machines.
const OF_THE_MACHINE: [&str; 3] = [".machine.processor", ".program.revision", ".gpu_seconds"];

/// `report.md` says what each field means; this is what there is.
#[test]
fn reports_are_laid_out_as_reviewed() {
    let names = ["reference", "projection"];
    let drawing = algorithms("reports_are_laid_out_as_reviewed");
    if !names
        .iter()
        .all(|name| drawing.iter().any(|a| a.name == *name))
    {
        return; // said to be skipped
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.toml");
    let text = "version = 1\n[volume]\ndataset = \"sphere\"\ncells = 300\n[image]\nwidth = 16\nheight = 16\n";
    std::fs::write(&scene, text).expect("the folder can be written");
    let mut compare = Command::new(env!("CARGO_BIN_EXE_xtask"));
    compare
        .arg("compare")
        .arg(&scene)
        .args(["--algorithms", &names.join(","), "--repeat", "1"])
        .args(["--models", "emission-absorption"])
        .arg("--out")
        .arg(folder.path());
    let output = compare.output().expect("the program starts");
    let report = std::fs::read(folder.path().join("report.json"));
    let stderr = String::from_utf8_lossy(&output.stderr);
    let report = report.unwrap_or_else(|error| panic!("{error}: {stderr}"));
    let report: Value = serde_json::from_slice(&report).expect("JSON");
    let mut types = BTreeMap::new();
    layout("", &report, &mut types);
    let lines = types.iter().map(|(place, kinds)| {
        let is_of_machine = OF_THE_MACHINE.iter().any(|end| place.ends_with(end));
        let kinds: Vec<&str> = match is_of_machine {
            true => vec!["as the machine has it"],
            false => kinds.iter().copied().collect(),
        };
        format!("{place}: {}\n", kinds.join(", "))
    });
    insta::assert_snapshot!("report", lines.collect::<String>());
}
