//! `algorithms`, `datasets`, `colormaps`, `adapters`, `info` and `print-scene`.

use super::program::Folder;

#[cfg(all(feature = "projection", feature = "raycast-peel"))]
#[test]
fn the_algorithms_are_listed() {
    let folder = Folder::new();
    insta::assert_snapshot!("algorithms", folder.run("algorithms").succeeded().stdout);
    let list = folder.run("algorithms --json").succeeded().json();
    let names: Vec<&str> = list
        .as_array()
        .expect("a list")
        .iter()
        .map(|algorithm| algorithm["name"].as_str().expect("a name"))
        .collect();
    let registered = tetrascope::algorithms()
        .iter()
        .map(|algorithm| algorithm.name);
    assert_eq!(names, registered.collect::<Vec<_>>());
    for setting in list[1]["settings"].as_array().expect("settings") {
        assert!(setting["default"].is_string(), "{setting}");
    }
}

#[test]
fn data_sets_and_color_maps_are_listed() {
    let folder = Folder::new();
    for name in ["sphere", "orbital", "heat-sink"] {
        let text = folder.run("datasets").succeeded().stdout;
        assert!(text.contains(&format!("{name}: ")), "{text}");
    }
    let list = folder.run("datasets --json").succeeded().json();
    assert_eq!(list[0]["name"], "sphere");
    assert_eq!(list[0]["cells"], 148_955);
    let maps = folder.run("colormaps").succeeded().stdout;
    assert!(maps.starts_with("viridis\n"), "{maps}");
    assert_eq!(
        folder.run("colormaps --json").succeeded().json()[0],
        "viridis"
    );
}

#[test]
fn file_formats_are_listed_with_what_can_be_done() {
    let folder = Folder::new();
    insta::assert_snapshot!("formats", folder.run("formats").succeeded().stdout);
    let list = folder.run("formats --json").succeeded().json();
    let list = list.as_array().expect("a list");
    let of = |extension: &str| {
        let has = |format: &&serde_json::Value| {
            let extensions = format["extensions"].as_array().expect("a list");
            extensions.iter().any(|e| e == extension)
        };
        list.iter()
            .find(has)
            .unwrap_or_else(|| panic!("{extension}"))
    };
    assert_eq!(of("vtu")["written"], true);
    assert_eq!(of("msh")["time_steps"], true);
    assert_eq!(of("nrrd")["streamed"], true);
    // What a file is refused with leads here.
    folder.write("a.xyzzy", "?");
    let run = folder.run("info a.xyzzy");
    let leads = format!("`tetrascope formats` lists all {}", list.len());
    assert!(run.stderr.contains(&leads), "{}", run.stderr);
}

// Which adapters there are is not ours to say; that none is an error is.
#[test]
fn adapters_are_a_list_or_code_4() {
    let folder = Folder::new();
    let run = folder.run("adapters");
    match run.code {
        0 => assert!(!run.stdout.trim().is_empty()),
        _ => {
            let (error, help) = run.failed(4);
            assert!(error.contains("no suitable graphics adapter"), "{error}");
            assert!(!help.is_empty());
        }
    }
}

#[test]
fn info_describes_a_mesh() {
    let folder = Folder::new();
    let text = folder.run("info sphere --cells 600").succeeded().stdout;
    for word in [
        "tetrahedron",
        "points",
        "fields",
        "bounds",
        "convex",
        "unit distance",
        "notes",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let facts = folder
        .run("info sphere --cells 600 --json")
        .succeeded()
        .json();
    let cells = facts["tetrahedra"].as_u64().expect("a count");
    assert!((300..1200).contains(&cells), "{facts}");
    assert_eq!(facts["boundary"]["convex"], true);
    assert_eq!(facts["boundary"]["euler_characteristic"], 2);
    assert_eq!(facts["fields"][0]["association"], "point");
    let torus = folder
        .run("info torus --cells 600 --json")
        .succeeded()
        .json();
    assert_eq!(torus["boundary"]["convex"], false);
    assert_eq!(torus["boundary"]["euler_characteristic"], 0);
}

#[test]
fn a_printed_scene_is_complete_and_prints_the_same_again() {
    let folder = Folder::new();
    let options = "sphere --cells 600 --camera fit-z --colormap inferno --size 20x10";
    let run = folder.run(&format!("print-scene {options}")).succeeded();
    assert!(
        run.stderr.contains("unit distance"),
        "defaults are told: {}",
        run.stderr
    );
    folder.write("scene.toml", &run.stdout);
    let again = folder.run("print-scene --scene scene.toml -q").succeeded();
    assert_eq!(again.stdout, run.stdout);
    assert_eq!(again.stderr, "");

    let json = folder
        .run(&format!("print-scene {options} --json"))
        .succeeded();
    folder.write("scene.json", &json.stdout);
    let again = folder.run("print-scene --scene scene.json -q").succeeded();
    assert_eq!(again.stdout, run.stdout);
}

#[test]
fn options_override_the_scene() {
    let folder = Folder::new();
    folder.write(
        "scene.toml",
        "version = 1\nvolume.dataset = \"sphere\"\nvolume.cells = 600\n\
         image.width = 64\nimage.height = 32\ncamera.fit = \"+x\"\n\
         appearance.optical_model = \"emission\"",
    );
    let scene = |options: &str| {
        let line = format!("print-scene --scene scene.toml --json {options}");
        folder.run(&line).succeeded().json()
    };
    let plain = scene("");
    assert_eq!(plain["image"]["width"], 64);
    assert_eq!(plain["appearance"]["optical_model"], "emission");
    let changed = scene("--size 9x7 --model absorption --camera fit+z --orthographic --seed 3");
    assert_eq!(changed["image"]["width"], 9);
    assert_eq!(changed["image"]["height"], 7);
    assert_eq!(changed["appearance"]["optical_model"], "absorption");
    assert_eq!(changed["camera"]["projection"], "orthographic");
    assert_eq!(changed["volume"]["cells"], 600);
    assert_eq!(changed["volume"]["seed"], 3);
    let background = scene("--background white");
    assert_eq!(
        background["image"]["background"],
        serde_json::json!([1.0, 1.0, 1.0, 1.0])
    );
    // Another volume in the same look.
    let other = scene("orbital");
    assert_eq!(other["volume"]["dataset"], "orbital");
    assert_eq!(other["image"]["width"], 64);
    // The data set's own transfer function gives way to a color map.
    let knots = scene("--colormap plasma --range -2,3");
    let knots = knots["appearance"]["transfer_function"]
        .as_array()
        .expect("knots");
    assert_eq!(knots[0]["scalar"], -2.0);
    assert_eq!(knots[knots.len() - 1]["scalar"], 3.0);
}

#[test]
fn paths_in_a_scene_start_at_its_folder() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("a/b")).expect("folders");
    folder.write(
        "a/b/scene.toml",
        "version = 1\nvolume.file = \"../gone.vtu\"",
    );
    let (error, _) = folder
        .run("print-scene --scene a/b/scene.toml -q")
        .failed(3);
    assert!(error.contains("a/b/../gone.vtu"), "{error}");
}

/// `T` at points and in cells of a tetrahedron, a stress with names of its own, a vector.
const NAMES: &str = r#"<VTKFile type="UnstructuredGrid" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1"><PointData>
<DataArray type="Float64" Name="T" format="ascii">0 1 2 3</DataArray>
<DataArray type="Float64" Name="U" NumberOfComponents="3" format="ascii">3 4 0 0 0 0 0 0 0 0 0 0</DataArray>
<DataArray type="Float64" Name="s" NumberOfComponents="6" ComponentName3="YZ" ComponentName5="XY" format="ascii">
1 2 3 23 13 12 1 2 3 23 13 12 1 2 3 23 13 12 1 2 3 24 13 12.5</DataArray>
</PointData><CellData><DataArray type="Float64" Name="T" format="ascii">9</DataArray></CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="Int32" Name="types" format="ascii">10</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>"#;

#[test]
fn info_marks_the_one_field_that_is_drawn() {
    let folder = Folder::new();
    folder.write("names.vtu", NAMES);
    folder.write(
        "cells.toml",
        "version = 1\nvolume.file = \"names.vtu\"\nvolume.field = \"T (cell)\"",
    );
    for (options, name, association, range) in [
        ("", "T", "point", [0.0, 3.0]),
        ("-f cell:T", "T", "cell", [9.0, 9.0]),
        ("-f U", "U-magnitude", "point", [0.0, 5.0]),
        ("-f s-XY", "s-XY", "point", [12.0, 12.5]),
        ("-f s-YZ", "s-YZ", "point", [23.0, 24.0]),
    ] {
        let command = format!("info names.vtu --json {options}");
        let facts = folder.run(&command).succeeded().json();
        assert_eq!(facts["field"], name, "{command}");
        let drawn = facts["fields"].as_array().expect("a list").iter();
        let drawn: Vec<_> = drawn.filter(|field| field["drawn"] == true).collect();
        assert_eq!(drawn.len(), 1, "{command}: {drawn:?}");
        assert_eq!(drawn[0]["name"], name, "{command}");
        assert_eq!(drawn[0]["association"], association, "{command}");
        assert_eq!(drawn[0]["range"], serde_json::json!(range), "{command}");
    }
    let text = folder.run("info names.vtu").succeeded().stdout;
    assert_eq!(text.matches("drawn)").count(), 1, "{text}");
    // A scene names a field in the same way.
    let run = folder.run("render --scene cells.toml --range 0,10 --size 8x8 -o a.npy");
    let stderr = run.succeeded().stderr;
    assert!(stderr.contains("field 'T' (cell)"), "{stderr}");
    let (error, help) = folder.run("info names.vtu -f s").failed(3);
    assert!(error.contains("no field 's'"), "{error}");
    assert!(help.contains("--field"), "{help}");
}
