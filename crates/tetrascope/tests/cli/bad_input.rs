//! Input that is wrong: one clear line, exit code 3, and nothing else changes.

use super::program::Folder;

/// An old picture, which a failed run must leave alone.
const OLD: &[u8] = b"the old picture";

/// One tetrahedron, `{points}` and `{connectivity}` to be filled in.
const VTU: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="{count}" NumberOfCells="1">
<PointData><DataArray type="Float64" Name="s" format="ascii">1 2 3 4</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{points}</DataArray></Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>
"#;

fn vtu(count: &str, points: &str, connectivity: &str) -> String {
    VTU.replace("{count}", count)
        .replace("{points}", points)
        .replace("{connectivity}", connectivity)
}

fn good_vtu() -> String {
    vtu("4", "0 0 0  1 0 0  0 1 0  0 0 1", "0 1 2 3")
}

/// A single-block Plot3D grid of `dims`, little-endian, as f32, with `count` coordinates.
fn plot3d(dims: [i32; 3], count: usize) -> Vec<u8> {
    let header = dims.into_iter().flat_map(i32::to_le_bytes);
    let values = (0..count).flat_map(|i| (i as f32).to_le_bytes());
    header.chain(values).collect()
}

/// Renders `name` in `folder` over an old picture; the error and its help.
#[track_caller]
fn refused(folder: &Folder, line: &str) -> (String, String) {
    folder.write("out.png", OLD);
    let before = folder.files();
    let failed = folder
        .run(&format!("render {line} --size 8 -o out.png"))
        .failed(3);
    assert_eq!(folder.read("out.png"), OLD, "an existing picture is kept");
    assert_eq!(folder.files(), before, "no temporary file is left");
    failed
}

#[track_caller]
fn file_is_refused(name: &str, bytes: impl AsRef<[u8]>) -> (String, String) {
    let folder = Folder::new();
    folder.write(name, bytes);
    let (error, help) = refused(&folder, name);
    assert!(error.contains(name), "the error names the file: {error}");
    (error, help)
}

#[track_caller]
fn scene_is_refused(text: &str, words: &[&str]) {
    let folder = Folder::new();
    folder.write("mesh.vtu", good_vtu());
    folder.write(
        "scene.toml",
        format!("version = 1\nvolume.file = \"mesh.vtu\"\n{text}"),
    );
    let (error, help) = refused(&folder, "--scene scene.toml");
    for word in words {
        assert!(error.contains(word), "{word}: {error}");
    }
    assert!(
        error.contains("scene.toml"),
        "the error names the scene: {error}"
    );
    assert!(!help.is_empty(), "there is help: {error}");
}

#[test]
fn the_mesh_that_the_other_tests_break_is_good() {
    let folder = Folder::new();
    folder.write("mesh.vtu", good_vtu());
    folder
        .run("render mesh.vtu --size 8 -o out.png")
        .succeeded();
    assert_eq!(folder.files(), ["mesh.vtu", "out.png"]);
}

#[test]
fn an_empty_file() {
    for name in ["mesh.vtu", "mesh.vtk", "meshxyz.bin"] {
        let (error, _) = file_is_refused(name, "");
        assert!(error.contains("empty"), "{error}");
    }
}

#[test]
fn a_truncated_file() {
    let whole = good_vtu();
    for part in [20, 200, 600, whole.len() - 30] {
        file_is_refused("mesh.vtu", &whole[..part]);
    }
    // A grid of 4³ points has 192 coordinates.
    file_is_refused("meshxyz.bin", plot3d([4, 4, 4], 100));
}

#[test]
fn a_header_that_promises_too_much() {
    file_is_refused("meshxyz.bin", plot3d([2_000_000_000; 3], 100));
    let points = vtu("9000000000000000000", "0 0 0", "0 1 2 3");
    file_is_refused("mesh.vtu", points);
}

#[test]
fn a_file_of_something_else() {
    for name in ["mesh.vtu", "mesh.vtk", "meshxyz.bin", "mesh.stl", "mesh"] {
        file_is_refused(name, [0xA7; 999]);
    }
}

#[test]
fn an_index_out_of_range() {
    let (error, _) = file_is_refused(
        "mesh.vtu",
        vtu("4", "0 0 0  1 0 0  0 1 0  0 0 1", "0 1 2 77"),
    );
    assert!(error.contains("77"), "{error}");
}

#[test]
fn a_coordinate_that_is_not_finite() {
    for number in ["nan", "inf"] {
        let points = format!("0 0 0  1 0 0  0 {number} 0  0 0 1");
        file_is_refused("mesh.vtu", vtu("4", &points, "0 1 2 3"));
    }
}

#[test]
fn a_missing_file_and_a_folder() {
    let folder = Folder::new();
    let (error, _) = refused(&folder, "nowhere/mesh.vtu");
    assert!(error.contains("nowhere/mesh.vtu"), "{error}");
    std::fs::create_dir(folder.path("folder.vtu")).expect("a folder");
    refused(&folder, "folder.vtu");
    let (error, help) = refused(&folder, "shpere");
    assert!(error.contains("neither a file nor a data set"), "{error}");
    assert!(help.contains("did you mean 'sphere'?"), "{help}");
    let (_, help) = refused(&folder, "mesh");
    assert!(
        help.contains("heat-sink") || help.contains("sphere"),
        "{help}"
    );
}

#[test]
fn a_missing_field_lists_those_that_exist() {
    let folder = Folder::new();
    folder.write("mesh.vtu", good_vtu());
    let (error, help) = refused(&folder, "mesh.vtu --field t");
    assert!(
        error.contains("no field 't'; there are s [1, 4]"),
        "{error}"
    );
    assert!(help.contains("--field 's'"), "{help}");
    let (error, _) = refused(&folder, "sphere --cells 100 --field t");
    assert!(error.contains("no field 't'"), "{error}");
}

#[test]
fn a_scene_that_names_a_missing_file() {
    let folder = Folder::new();
    folder.write("scene.toml", "version = 1\nvolume.file = \"gone.vtu\"");
    let (error, _) = refused(&folder, "--scene scene.toml");
    assert!(error.contains("gone.vtu"), "{error}");
    let (error, _) = refused(&folder, "--scene nowhere.toml");
    assert!(error.contains("nowhere.toml"), "{error}");
}

#[test]
fn a_scene_that_does_not_parse() {
    scene_is_refused("[image]\nwidht = 3", &["widht", "line 4"]);
    scene_is_refused("[image", &["line 3"]);
    let folder = Folder::new();
    folder.write("scene.toml", [0xFF; 9]);
    refused(&folder, "--scene scene.toml");
    folder.write("scene.toml", "version = 7");
    let (error, help) = refused(&folder, "--scene scene.toml");
    assert!(error.contains('7') && help.contains('1'), "{error} {help}");
}

#[test]
fn a_picture_without_pixels() {
    let folder = Folder::new();
    folder.write("mesh.vtu", good_vtu());
    folder.write(
        "scene.toml",
        "version = 1\nvolume.file = \"mesh.vtu\"\nimage.width = 0",
    );
    let (error, _) = folder.run("render --scene scene.toml").failed(3);
    assert!(error.contains("an image of 0x0"), "{error}");
    assert_eq!(folder.files(), ["mesh.vtu", "scene.toml"]);
}

#[test]
fn a_camera_that_looks_nowhere() {
    scene_is_refused(
        "[camera]\nposition = [2, 3, 4]\nfocal_point = [2, 3, 4]",
        &["at its focal point"],
    );
    scene_is_refused(
        "[camera]\nposition = [9, 0, 0]\nfocal_point = [0, 0, 0]\nview_up = [1, 0, 0]",
        &["along the view"],
    );
    scene_is_refused(
        "[camera]\nposition = [9, 0, 0]\nview_angle = 180.0",
        &["view_angle"],
    );
}

#[test]
fn knots_that_make_no_sense() {
    let knot = |scalar: f64, extinction: f64| {
        format!(
            "[[appearance.transfer_function]]\n\
             scalar = {scalar}\ncolor = [1, 1, 1]\nextinction = {extinction}\n"
        )
    };
    let negative = knot(0.0, 1.0) + &knot(1.0, -2.0);
    scene_is_refused(&negative, &["knot 1", "negative extinction -2"]);
    let unsorted = knot(3.0, 1.0) + &knot(1.0, 2.0);
    scene_is_refused(&unsorted, &["knot 1", "1 comes after 3"]);
}

#[test]
fn a_source_with_options_of_another() {
    let folder = Folder::new();
    folder.write("mesh.vtu", good_vtu());
    scene_is_refused("volume.dataset = \"sphere\"", &["not both"]);
    folder.write("scene.toml", "version = 1\nvolume.dataset = \"shpere\"");
    let (error, help) = refused(&folder, "--scene scene.toml");
    assert!(
        error.contains("shpere") && help.contains("sphere"),
        "{error}"
    );
    folder.write("scene.toml", "version = 1");
    let (error, _) = refused(&folder, "--scene scene.toml");
    assert!(error.contains("names no volume"), "{error}");
}

// Each was drawn, as infinity or as nothing.
#[test]
fn numbers_beyond_the_floats_of_a_picture() {
    let knot = |color: &str, extinction: &str| {
        format!(
            "[[appearance.transfer_function]]\n\
             scalar = 0.0\ncolor = [{color}, 1.0, 1.0]\nextinction = {extinction}\n"
        )
    };
    scene_is_refused(&knot("1e39", "1.0"), &["a color of 1e39"]);
    scene_is_refused(
        &knot("1.0", "1e39"),
        &["optical depth", "beyond 32-bit floats"],
    );
    scene_is_refused("image.background = [1e39, 0, 0, 1]", &["background"]);
    scene_is_refused(
        "[appearance]\noptical_model = \"isosurfaces\"\nambient = 1e39",
        &["isosurfaces"],
    );
}

#[test]
fn a_scene_without_end() {
    let folder = Folder::new();
    folder.write("long.toml", " ".repeat((1 << 20) + 1));
    let (error, help) = refused(&folder, "--scene long.toml");
    assert!(error.contains("more than 1048576 bytes"), "{error}");
    assert!(help.contains("print-scene"), "{help}");
    if cfg!(unix) {
        let (error, _) = refused(&folder, "--scene /dev/zero");
        assert!(error.contains("more than 1048576 bytes"), "{error}");
    }
}

// ESC [31m colors what follows red, and more than that can be asked of a terminal.
#[test]
fn control_characters_of_a_file_do_not_reach_the_terminal() {
    let folder = Folder::new();
    let wrong = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = \x1b[31mred\n";
    folder.write("grid.mhd", wrong);
    let run = folder.run("info grid.mhd");
    assert_eq!(run.code, 3);
    assert!(run.stderr.contains("\\u{1b}[31mred"), "{}", run.stderr);
    assert!(!run.stderr.contains('\x1b'), "{}", run.stderr);
    let mesh = good_vtu().replace("Name=\"s\"", "Name=\"&#x9b;31m\u{202e}s\"");
    folder.write("mesh\u{9b}.vtu", mesh);
    for line in [
        "info mesh\u{9b}.vtu",
        "info mesh\u{9b}.vtu --json",
        "render mesh\u{9b}.vtu -v --size 8",
    ] {
        let run = folder.run(line).succeeded();
        let all = run.stdout.clone() + &run.stderr;
        let seen = match line.starts_with("render") {
            // A program that reads the name of the picture gets its very bytes.
            true => run.stderr.clone(),
            false => all,
        };
        assert!(!seen.contains(['\u{9b}', '\u{202e}']), "{line}: {seen}");
    }
    let run = folder.run("info \u{9b}31m --wrong=\u{9b}");
    assert_eq!(run.code, 2);
    assert!(!run.stderr.contains('\u{9b}'), "{}", run.stderr);
}

#[test]
fn a_name_as_long_as_the_file_is_clipped() {
    let folder = Folder::new();
    folder.write(
        "mesh.vtu",
        good_vtu().replace("Name=\"s\"", &format!("Name=\"{}\"", "s".repeat(100_000))),
    );
    for line in [
        "info mesh.vtu",
        "render mesh.vtu --size 8 -v",
        "render mesh.vtu -f t",
    ] {
        let run = folder.run(line);
        let longest = run
            .stderr
            .lines()
            .chain(run.stdout.lines())
            .map(str::len)
            .max();
        assert!(longest < Some(2000), "{line}: {longest:?}");
        assert!(
            run.code == 0 || run.stderr.contains("characters)"),
            "{}",
            run.stderr
        );
    }
}
