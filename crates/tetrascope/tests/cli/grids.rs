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
