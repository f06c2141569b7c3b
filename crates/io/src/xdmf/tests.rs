use std::fs;
use std::path::{Path, PathBuf};

use tetrascope_core::mesh::Association;

use super::*;
use crate::read::{ReadOptions, read_file};
use crate::{FieldSamples, MeshData, read_steps};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/xdmf")
}

fn read_at(path: &Path, step: Option<usize>) -> Result<FileData, Error> {
    let options = ReadOptions {
        step: step.map(StepChoice::Number),
        ..ReadOptions::default()
    };
    read_file(path, &options)
}

fn mesh_at(name: &str, step: Option<usize>) -> MeshData {
    match read_at(&folder().join(name), step).unwrap_or_else(|e| panic!("{name}: {e}")) {
        FileData::Mesh(mesh) => mesh,
        FileData::Grid(_) | FileData::Clusters(_) => panic!("{name} is a grid"),
    }
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    let field = data.field(Some(name));
    field.unwrap_or_else(|e| panic!("{e}")).values
}

/// The sum of values, each times its number from 1.
fn weighed(values: impl IntoIterator<Item = f64>) -> f64 {
    let weighed = values
        .into_iter()
        .zip(1..)
        .map(|(value, n)| value * f64::from(n));
    weighed.sum()
}

fn is_near(a: f64, b: &serde_json::Value) -> bool {
    let b = b.as_f64().expect("a number");
    (a - b).abs() <= 1e-6 * b.abs().max(1.0)
}

/// Points, cells and fields are those of one block that VTK has read.
fn assert_as_vtk(name: &str, data: &MeshData, block: &serde_json::Value, is_lattice: bool) {
    assert_eq!(block["points"], data.points.len(), "{name}");
    assert_eq!(block["cells"], data.cells.types.len(), "{name}");
    let places = data.points.iter().flat_map(|p| p.to_array());
    assert!(is_near(weighed(places), &block["at"]), "{name}: points");
    if !is_lattice {
        let types = data.cells.types.iter().map(|&kind| f64::from(kind));
        assert!(is_near(weighed(types), &block["types"]), "{name}: types");
        let ids = data.cells.connectivity.iter().map(|&id| id as f64);
        assert!(is_near(weighed(ids), &block["ids"]), "{name}: cells");
    }
    let arrays = block["arrays"].as_object().expect("arrays");
    for (array, said) in arrays {
        // Interleaved again where the array has components.
        let components = said[0].as_u64().expect("a number");
        let fields: Vec<Vec<f64>> = match components {
            1 if data
                .fields
                .iter()
                .all(|field| !array.ends_with(&field.name)) =>
            {
                (0..3)
                    .map(|i| values(data, &format!("{array}-{i}")))
                    .collect()
            }
            1 => vec![values(data, array)],
            // VTK makes symmetric tensors whole.
            9 => continue,
            n => (0..n)
                .map(|i| values(data, &format!("{array}-{i}")))
                .collect(),
        };
        let whole = (0..fields[0].len()).flat_map(|i| fields.iter().map(move |field| field[i]));
        assert!(is_near(weighed(whole), &said[1]), "{name}: {array}");
    }
}

fn expected() -> serde_json::Value {
    let text = fs::read(folder().join("expected.json")).expect("expected.json");
    serde_json::from_slice(&text).expect("JSON")
}

#[test]
fn meshes_are_those_that_vtk_reads() {
    let expected = expected();
    for name in [
        "lattice-binary.xdmf",
        #[cfg(feature = "hdf5")]
        "forms.xdmf",
        #[cfg(feature = "hdf5")]
        "lattice-hdf.xdmf",
        "lattice-xml.xdmf",
        "mixed-meshio.xdmf",
        "vtk-bent.xdmf",
        "vtk-stretched.xdmf",
    ] {
        let block = &expected[name][0]["blocks"][0];
        let is_lattice = block["kind"] != "vtkUnstructuredGrid";
        assert_as_vtk(name, &mesh_at(name, None), block, is_lattice);
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn time_steps_are_those_that_vtk_reads() {
    let expected = expected();
    let name = "series-meshio.xdmf";
    assert_eq!(
        read_steps(&folder().join(name)).expect("steps"),
        [0.0, 0.5, 1.5]
    );
    for step in 0..3 {
        let block = &expected[name][step]["blocks"][0];
        assert_as_vtk(name, &mesh_at(name, Some(step)), block, false);
    }
    assert!(read_at(&folder().join(name), Some(3)).is_err());
}

#[test]
fn a_list_of_times_and_cells_of_the_first_step() {
    let name = "fenics.xdmf";
    assert_eq!(read_steps(&folder().join(name)).expect("steps"), [0.0, 2.0]);
    let (first, second) = (mesh_at(name, None), mesh_at(name, Some(1)));
    assert_eq!(first.cells.connectivity, second.cells.connectivity);
    assert_eq!(values(&second, "c")[39], 40.0);
    assert_eq!(
        first.notes,
        ["the file holds 2 time steps: the first, at 0, is read"]
    );
    let lattice = mesh_at("lattice-xml.xdmf", None);
    assert_eq!(first.points, lattice.points);
    assert_eq!(first.cells.connectivity, lattice.cells.connectivity);
}

#[cfg(feature = "hdf5")]
#[test]
fn functions_of_one_mesh_are_fields_of_it() {
    let data = mesh_at("dolfinx.xdmf", Some(1));
    let lattice = mesh_at("lattice-xml.xdmf", None);
    assert_eq!(data.points, lattice.points);
    assert_eq!(data.cells.connectivity, lattice.cells.connectivity);
    for (name, time) in [("f", 0.25), ("v-0", 0.25), ("v-2", 0.25)] {
        let later: Vec<f64> = values(&lattice, name).iter().map(|v| v + time).collect();
        assert_eq!(values(&data, name), later, "{name}");
    }
    assert_eq!(data.files.len(), 2);
}

#[cfg(feature = "hdf5")]
#[test]
fn forms_of_data_items() {
    let data = mesh_at("forms.xdmf", None);
    let lattice = mesh_at("lattice-xml.xdmf", None);
    assert_eq!(data.points, lattice.points);
    assert_eq!(data.cells.connectivity, lattice.cells.connectivity);
    let twice: Vec<f64> = values(&lattice, "f").iter().map(|f| 2.0 * f).collect();
    assert_eq!(values(&data, "twice"), twice);
    assert_eq!(values(&data, "stress-YZ")[1], 10.0);
    assert_eq!(data.field(None).expect("fields").name, "c");
    let note = "attribute 'name of all' left out: it is at each Grid, not at points or in cells";
    assert_eq!(data.notes, [note]);
}

#[test]
fn cells_of_several_types_are_those_of_the_same_vtu_file() {
    let other = read_file(&folder().join("../mixed.vtu"), &ReadOptions::default());
    let Ok(FileData::Mesh(other)) = other else {
        panic!("a mesh")
    };
    let volume = |data: MeshData| data.into_mesh(None).expect("a mesh").volume();
    for name in [
        "vtk-mixed.xdmf",
        #[cfg(feature = "hdf5")]
        "vtk-mixed-heavy.xdmf",
    ] {
        let data = mesh_at(name, None);
        assert_eq!(data.points, other.points, "{name}");
        // The other has a voxel, too, of volume 1.
        assert_eq!(data.cells.types, [10, 14, 13, 12, 5], "{name}");
        assert_eq!(values(&data, "x"), values(&other, "x"));
        assert!(
            (volume(data) + 1.0 - volume(other.clone())).abs() < 1e-12,
            "{name}"
        );
    }
}

#[test]
fn grids_in_space_and_in_trees_are_joined() {
    let data = mesh_at("vtk-blocks.xmf", None);
    assert_eq!((data.points.len(), data.cells.types.len()), (54, 80));
    let c = values(&data, "c");
    assert_eq!((c[39], c[40], c[79]), (39.0, 0.0, 39.0));
    assert!(
        data.notes
            .iter()
            .any(|n| n.starts_with("2 pieces joined: 9 points")),
        "{:?}",
        data.notes
    );

    let data = mesh_at("tree.xdmf", None);
    assert_eq!((data.points.len(), data.cells.types.len()), (36, 8));
    assert!(
        data.notes[0].starts_with("'surface' left out"),
        "{:?}",
        data.notes
    );
    assert_eq!(data.points[23].to_array(), [2.5, 2.5, 5.0]);
    assert_eq!(data.points[26].to_array(), [8.0, 0.0, 0.0]);
    let c = values(&data, "c");
    assert!(c[5].is_nan());
    assert_eq!(c[6..], [7.0, 9.0]);
    // 1.5 × 0.5 × 2 and 3 × 1 × 2
    let volume = data.into_mesh(Some("c")).expect("a mesh").volume();
    assert!((volume - 7.5).abs() < 1e-12, "{volume}");
}

#[test]
fn domains_after_the_first_are_left_out_and_counted() {
    let text = fs::read_to_string(folder().join("lattice-xml.xdmf")).expect("it is there");
    let from = text.find("<Domain").expect("a domain");
    let to = text.find("</Domain>").expect("its end") + "</Domain>".len();
    let place = tempfile::tempdir().expect("a folder");
    let path = place.path().join("several.xdmf");
    let notes = |others: &str| {
        fs::write(&path, [&text[..to], others, &text[to..]].concat()).expect("written");
        match read_at(&path, None).expect("a mesh") {
            FileData::Mesh(data) => data.notes,
            _ => panic!("a mesh was written"),
        }
    };
    let before = notes("<Domain></Domain>");
    let after = notes(&text[from..to]);
    let note = "the first <Domain> is read, and 1 other with grids left out";
    assert!(!before.iter().any(|n| n == note), "{before:?}");
    assert!(after.iter().any(|n| n == note), "{after:?}");
}

#[test]
fn a_grid_of_even_steps_is_regular() {
    let read = read_at(&folder().join("vtk-image.xdmf"), None).expect("a grid");
    let FileData::Grid(data) = read else {
        panic!("a grid")
    };
    let names: Vec<&str> = data.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["v-magnitude", "v-0", "v-1", "v-2", "c"]);
    let lattice = data.fields[1].lattice;
    assert_eq!(lattice.dims, [4, 3, 2]);
    let place = |i, j, k| {
        lattice
            .point(tetrascope_core::glam::DVec3::new(i, j, k))
            .to_array()
    };
    assert_eq!(place(0.0, 0.0, 0.0), [1.0, 2.0, 3.0]);
    assert_eq!(place(3.0, 2.0, 1.0), [2.5, 2.5, 5.0]);
    let samples = |field: usize| match &data.fields[field].samples {
        FieldSamples::Loaded(samples) => (0..samples.len()).map(|i| samples.get(i)).collect(),
        FieldSamples::Streamed(_) => Vec::new(),
    };
    assert_eq!(samples(2)[5], 16.0);
    assert_eq!(samples(4), [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0]);
    assert_eq!(data.fields[4].association, Association::Cell);
}

#[test]
fn curved_cells_have_the_order_of_vtk() {
    let data = mesh_at("curved.xdmf", None);
    assert_eq!(data.cells.types, [29, 33, 25, 26, 32, 24, 27]);
    let natural: Vec<u64> = (0..127).collect();
    assert_eq!(data.cells.connectivity, natural);
}

mod damage;
