//! Regular grids from files.

use serde_json::Value;

use super::program::Folder;

/// 3×4×5 bytes that rise along z.
fn samples() -> Vec<u8> {
    (0..60).map(|i| (i / 12 * 60) as u8).collect()
}

fn vti() -> String {
    let numbers: Vec<String> = samples().iter().map(u8::to_string).collect();
    format!(
        "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 2 0 3 0 4\" \
         Origin=\"0 0 0\" Spacing=\"1 1 0.5\"><Piece Extent=\"0 2 0 3 0 4\"><PointData>\
         <DataArray type=\"UInt8\" Name=\"height\" format=\"ascii\">{}</DataArray>\
         </PointData></Piece></ImageData></VTKFile>",
        numbers.join(" ")
    )
}

#[test]
fn a_vti_is_described_and_drawn() {
    let folder = Folder::new();
    folder.write("ramp.vti", vti());
    let info = folder.run("info ramp.vti").succeeded();
    for line in [
        "samples        3×4×5 of u8",
        "cells          24",
        "  height [0, 240] (point, drawn)",
        "spacing        [1, 1, 0.5]",
        "bounds         [0, 0, 0] to [2, 3, 2]",
        "  none: no problems found",
    ] {
        assert!(info.stdout.contains(line), "{line}: {}", info.stdout);
    }
    let json = folder.run("info ramp.vti --json").succeeded();
    let json: Value = serde_json::from_str(&json.stdout).expect("JSON");
    assert_eq!(json["dims"], serde_json::json!([3, 4, 5]));
    assert_eq!(json["samples"], "u8");
    assert_eq!(json["axes"][0], serde_json::json!([1.0, 0.0, 0.0]));

    let run = folder
        .run("render ramp.vti --size 24x24 -o a.npy")
        .succeeded();
    let loaded = "3×4×5 samples of u8, 1×1×0.5 apart, field 'height'";
    assert!(run.stderr.contains(loaded), "{}", run.stderr);
    let missing = folder.run("render ramp.vti --field width");
    assert_eq!(missing.code, 3);
    assert!(
        missing.stderr.contains("height [0, 240]"),
        "{}",
        missing.stderr
    );
}

#[test]
fn a_raw_file_is_what_options_or_a_scene_say() {
    let folder = Folder::new();
    folder.write("ramp.vti", vti());
    let mut bytes = b"head".to_vec();
    bytes.extend(samples());
    folder.write("ramp.raw", bytes);
    let size = "--size 16x16 -q";
    let options = "--dims 3x4x5 --type u8 --spacing 1,1,0.5 --offset 4";
    folder
        .run(&format!("render ramp.vti {size} -o a.npy"))
        .succeeded();
    folder
        .run(&format!("render ramp.raw {options} {size} -o b.npy"))
        .succeeded();
    assert_eq!(folder.read("a.npy"), folder.read("b.npy"));
    let scene = folder
        .run(&format!("print-scene ramp.raw {options} -q"))
        .succeeded();
    folder.write("scene.toml", &scene.stdout);
    folder
        .run(&format!("render --scene scene.toml {size} -o c.npy"))
        .succeeded();
    assert_eq!(folder.read("a.npy"), folder.read("c.npy"));

    for (line, code, words) in [
        ("info ramp.raw", 3, "--dims 256x256x128 --type u8"),
        (
            "info ramp.raw --dims 3x4x5",
            2,
            "needs its dims and the type",
        ),
        ("info ramp.raw --dims 3x4x5 --type u16", 3, "120 bytes"),
        ("info ramp.raw --dims 3x4x1 --type u8", 2, "2 or more"),
        (
            "info ramp.raw --dims 3x4 --type u8",
            2,
            "three whole numbers",
        ),
        ("render sphere --dims 3x4x5 --type u8", 2, "raw files"),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
}

/// The same 3×4×5 numbers as scalars of cells.
fn cells() -> String {
    vti()
        .replace("PointData", "CellData")
        .replace("0 2 0 3 0 4", "0 3 0 4 0 5")
}

#[test]
fn cells_are_whole_and_samples_fill_cells_on_demand() {
    let folder = Folder::new();
    folder.write("points.vti", vti());
    folder.write("cells.vti", cells());
    let info = folder.run("info cells.vti --json").succeeded().json();
    assert_eq!(info["interpolation"], "nearest");
    assert_eq!(info["cells"], 60);
    let whole = serde_json::json!([[0.0, 0.0, 0.0], [3.0, 4.0, 2.5]]);
    assert_eq!(info["bounds"], whole);
    // Point samples that fill cells reach half a spacing farther.
    let info = folder.run("info points.vti --json --interpolation nearest");
    let half = serde_json::json!([[-0.5, -0.5, -0.25], [2.5, 3.5, 2.25]]);
    assert_eq!(info.succeeded().json()["bounds"], half);

    // A scene keeps the choice.
    let options = "--size 16x16 -q";
    folder
        .run(&format!(
            "render points.vti --interpolation nearest {options} -o a.npy"
        ))
        .succeeded();
    folder
        .run(&format!("render points.vti {options} -o b.npy"))
        .succeeded();
    assert_ne!(folder.read("a.npy"), folder.read("b.npy"));
    let scene = folder
        .run("print-scene points.vti --interpolation nearest -q --size 16x16")
        .succeeded();
    folder.write("scene.toml", &scene.stdout);
    folder
        .run("render --scene scene.toml -q -o c.npy")
        .succeeded();
    assert_eq!(folder.read("a.npy"), folder.read("c.npy"));

    let (error, _) = folder
        .run("render sphere --interpolation nearest")
        .failed(2);
    assert!(error.contains("regular grids"), "{error}");
}

#[test]
fn samples_without_a_value_are_counted() {
    let folder = Folder::new();
    let mut bytes = Vec::new();
    for sample in [1.0, f32::INFINITY, f32::NAN, 1e36, 2.0, 3.0, 4.0, 5.0] {
        bytes.extend(f32::to_le_bytes(sample));
    }
    folder.write("a.raw", bytes);
    let run = folder.run("info a.raw --dims 2x2x2 --type f32 --json");
    let info = run.succeeded().json();
    assert_eq!(info["fields"][0]["missing"], 3);
    assert_eq!(info["fields"][0]["range"], serde_json::json!([1.0, 5.0]));
    let notes = info["notes"].to_string();
    assert!(
        notes.contains("1e36") && notes.contains("2 samples"),
        "{notes}"
    );

    folder.write(
        "ids.nrrd",
        "NRRD0004\ntype: int64\ndimension: 3\nsizes: 2 2 2\nencoding: text\n\n\
         864691135000000000 864691135000000700 864691135000000000 864691135000000000 \
         864691135000000000 864691135000000000 864691135000000000 864691135000000000",
    );
    let info = folder.run("info ids.nrrd --json").succeeded().json();
    assert_eq!(info["fields"][0]["range"], serde_json::json!([0.0, 700.0]));
    assert_eq!(info["fields"][0]["offset"], 864_691_135_000_000_000.0);
    let text = folder.run("info ids.nrrd").succeeded().stdout;
    assert!(text.contains("[0, 700] + 8.64691135e17"), "{text}");
}

#[test]
fn spacing_without_a_reciprocal_is_refused() {
    let folder = Folder::new();
    folder.write("a.raw", [0; 8]);
    let (error, _) = folder
        .run("render a.raw --dims 2x2x2 --type u8 --spacing 1,1,1e-310")
        .failed(2);
    assert!(error.contains("finite reciprocal"), "{error}");
}
