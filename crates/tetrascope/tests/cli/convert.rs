//! The files that `convert` writes.

use super::program::Folder;
use super::resampling::cube;

fn info(folder: &Folder, name: &str) -> serde_json::Value {
    let run = folder.run(&format!("info {name} --json"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).expect("JSON")
}

#[test]
fn a_mesh_keeps_its_cells_and_fields() {
    let folder = cube();
    for options in ["", " --compress"] {
        let run = folder.run(&format!("convert cube.vtk{options}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert_eq!(run.stdout, "cube.vtu\n");
        let [before, after] = ["cube.vtk", "cube.vtu"].map(|name| info(&folder, name));
        for key in ["fields", "bounds", "points", "volume", "cells"] {
            assert!(before.get(key).is_some(), "{key}: {before}");
            assert_eq!(before[key], after[key], "{key}");
        }
    }
    let sizes = ["", "--compress"].map(|option| {
        let line = format!("convert sphere --cells 5000 -o out.vtu {option}");
        assert_eq!(folder.run(&line).code, 0);
        folder.read("out.vtu").len()
    });
    assert!(sizes[1] < sizes[0], "{sizes:?}");
}

#[test]
fn one_field_can_be_written_alone() {
    let folder = cube();
    let run = folder.run("convert cube.vtk -o one.vtu --field cell:plane --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let said: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(said["fields"], serde_json::json!(["plane"]));
    let fields = &info(&folder, "one.vtu")["fields"];
    assert_eq!(fields.as_array().map(Vec::len), Some(1), "{fields}");
    assert_eq!(fields[0]["association"], "cell");
}

#[test]
fn a_grid_becomes_an_image() {
    let folder = Folder::new();
    let bytes: Vec<u8> = (0..24).collect();
    folder.write("samples.raw", bytes);
    let line = "convert samples.raw --dims 2x3x4 --type u8 --spacing 1,1,2 -o grid.vti";
    let run = folder.run(line);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let grid = info(&folder, "grid.vti");
    assert_eq!(grid["dims"], serde_json::json!([2, 3, 4]), "{grid}");
    assert_eq!(
        grid["fields"][0]["range"],
        serde_json::json!([0.0, 23.0]),
        "{grid}"
    );
}

#[test]
fn what_cannot_be_written_is_refused_before_or_with_a_way_out() {
    let folder = cube();
    for (line, code, words) in [
        ("convert cube.vtk -o cube.stl", 2, "vtu"),
        ("convert cube.vtk -o cube.vti", 2, ".vtu"),
        ("convert cube.vtk -o missing/cube.vtu", 1, "missing"),
        ("convert nothing.vtk -o out.vtu", 3, "nothing.vtk"),
        ("convert cube.vtk -o out.vtu --field speed", 3, "plane"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    assert_eq!(folder.files(), ["cube.vtk"]);
    assert_eq!(folder.run("convert cube.vtk").code, 0);
    let run = folder.run("convert cube.vtu");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert!(run.stderr.contains("over itself"), "{}", run.stderr);
}
