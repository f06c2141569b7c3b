use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Interpolation;
use tetrascope_core::mesh::Association;

use super::*;
use crate::hdf5::tests::{Files, bytes, fixtures};
use crate::read::{ReadOptions, read_file, read_mesh};
use crate::{FieldSamples, GridData, MeshData, read_steps};

mod damage;

fn at(step: Option<StepChoice>) -> ReadOptions {
    ReadOptions {
        step,
        ..ReadOptions::default()
    }
}

fn read_step(name: &str, step: Option<StepChoice>) -> Result<FileData, Error> {
    let files = Files::of(&[name]);
    read_file(&files.path(name), &at(step))
}

fn mesh_at(name: &str, step: Option<StepChoice>) -> MeshData {
    match read_step(name, step).unwrap_or_else(|e| panic!("{name}: {e}")) {
        // Values are read when they are asked for, so that the file must outlive them; on Unix
        // an open one does.
        FileData::Mesh(mesh) => mesh,
        FileData::Grid(_) | FileData::Clusters(_) => panic!("{name} is a grid"),
    }
}

fn mesh(name: &str) -> MeshData {
    mesh_at(name, None)
}

fn grid_at(name: &str, step: Option<StepChoice>) -> GridData {
    match read_step(name, step).unwrap_or_else(|e| panic!("{name}: {e}")) {
        FileData::Grid(grid) => grid,
        FileData::Mesh(_) | FileData::Clusters(_) => panic!("{name} is a mesh"),
    }
}

/// The same data from a file of another format.
fn other(name: &str) -> FileData {
    read_file(&fixtures().join(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn other_mesh(name: &str) -> MeshData {
    match other(name) {
        FileData::Mesh(mesh) => mesh,
        FileData::Grid(_) | FileData::Clusters(_) => panic!("{name} is a grid"),
    }
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    let field = data.field(Some(name));
    field.unwrap_or_else(|e| panic!("{e}")).values
}

fn volume(data: MeshData) -> f64 {
    data.into_mesh(None).expect("a mesh").volume()
}

fn samples(data: &GridData, name: &str) -> Vec<f64> {
    let field = &data.fields[data.choose(Some(name)).expect("a field").0];
    match &field.samples {
        FieldSamples::Loaded(samples) => (0..samples.len()).map(|i| samples.get(i)).collect(),
        FieldSamples::Streamed(_) => panic!("loaded"),
    }
}

fn refused(bytes: &[u8]) -> String {
    let files = Files::of(&[]);
    let path = files.put("a.vtkhdf", bytes);
    let error = read_file(&path, &ReadOptions::default()).expect_err("refused");
    let help = error.help().unwrap_or_default();
    let words = format!("{error}; {help}");
    assert_eq!(words.lines().count(), 1, "{words}");
    words
}

/// Points, cells and fields are the same, in any order of the fields.
fn assert_same(mesh: &MeshData, other: &MeshData, name: &str) {
    assert_eq!(mesh.points, other.points, "{name}");
    assert_eq!(mesh.cells.types, other.cells.types, "{name}");
    assert_eq!(mesh.cells.offsets, other.cells.offsets, "{name}");
    assert_eq!(mesh.cells.connectivity, other.cells.connectivity, "{name}");
    let sorted = |data: &MeshData| {
        let mut list = data.field_list();
        list.sort();
        list
    };
    assert_eq!(sorted(mesh), sorted(other), "{name}");
    for field in &mesh.fields {
        let [a, b] = [mesh, other].map(|data| values(data, &field.name));
        let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
        assert!(a.iter().zip(&b).all(same), "{name}: {}", field.name);
    }
}

#[test]
fn meshes_are_those_of_the_same_xml_files() {
    for (name, same) in [
        ("lattice.vtkhdf", "lattice-ascii.vtu"),
        ("lattice-zlib.vtkhdf", "lattice-ascii.vtu"),
        ("partitions.vtkhdf", "listed/lattice.pvtu"),
        ("polyhedra.vtkhdf", "polyhedra/by-number.vtu"),
        ("structured.vtkhdf", "structured/pieces.vts"),
        ("blanked.vtkhdf", "structured/blanked.vts"),
        ("stretched.vtkhdf", "structured/stretched.vtr"),
    ] {
        let (mut data, other) = (mesh(name), other_mesh(same));
        if name == "structured.vtkhdf" {
            // The pieces of the other repeat the points between them.
            assert_eq!((data.points.len(), data.cells.types.len()), (36, 12));
            let (data, other) = (volume(data), volume(other));
            assert!((data - 12.0).abs() < 1e-12 && (other - 12.0).abs() < 1e-12);
            continue;
        }
        assert_same(&data, &other, name);
        assert_eq!(data.notes, other.notes, "{name}");
        assert_eq!(data.files.len(), 1, "{name}");
        data.notes.clear();
        assert!((volume(data) - volume(other)).abs() < 1e-12, "{name}");
    }
    let data = mesh("lattice.vtkhdf");
    assert_eq!(data.field(None).expect("it has fields").name, "f");
    // By VTK: vtkHDFReader 9.7.2.
    let list = ["f [0, 222] (point)", "c [0, 39] (cell)"];
    assert_eq!(data.field_list()[..2], list);
}

#[test]
fn blocks_are_one_mesh_and_others_are_left_out() {
    // Both name the same blocks in different words.
    let (data, other) = (mesh("nested.vtkhdf"), other_mesh("listed/blocks.vtm"));
    assert_same(&data, &other, "nested.vtkhdf");
    let data = mesh("blocks.vtkhdf");
    assert_eq!(data.points.len(), 34 + 2 * 27);
    assert_eq!(data.cells.types.len(), 6 + 2 * 40);
    let c = values(&data, "c");
    assert!(c[..6].iter().all(|c| c.is_nan()));
    assert_eq!((c[6], c[45], c[46], c[85]), (0.0, 39.0, 0.0, 39.0));
    for words in ["holds a ImageData", "'c' is NaN in 1 of 3 pieces"] {
        let is_said = data.notes.iter().any(|note| note.contains(words));
        assert!(is_said, "{words}: {:?}", data.notes);
    }
}

#[test]
fn an_image_lies_and_is_hidden_as_vtk_has_it() {
    let data = grid_at("image.vtkhdf", None);
    let names: Vec<&str> = data.fields.iter().map(|f| f.name.as_str()).collect();
    assert_eq!(names, ["bytes", "v-magnitude", "v-0", "v-1", "v-2", "c"]);
    let (points, cells) = (data.fields[0].lattice, data.fields[5].lattice);
    assert_eq!((points.dims, cells.dims), ([4, 3, 2], [3, 2, 1]));
    assert_eq!(data.fields[5].association, Association::Cell);
    assert_eq!(cells.interpolation, Interpolation::Nearest);
    // vtkImageData::TransformContinuousIndexToPhysicalPoint of the first and the last point:
    // Direction ((0, -1, 0), (1, 0, 0), (0, 0, 1)).
    let place = |lattice: tetrascope_core::grid::Lattice, i, j, k| {
        lattice.point(DVec3::new(i, j, k)).to_array()
    };
    assert_eq!(place(points, 0.0, 0.0, 0.0), [1.25, 3.0, 3.0]);
    assert_eq!(place(points, 3.0, 2.0, 1.0), [0.75, 4.5, 5.0]);
    assert_eq!(place(cells, 0.0, 0.0, 0.0), [1.125, 3.25, 4.0]);
    let bytes = samples(&data, "bytes");
    assert_eq!(bytes[..23], (0..23).map(f64::from).collect::<Vec<_>>());
    assert!(bytes[23].is_nan());
    assert_eq!(samples(&data, "v-1")[5], 16.0);
    // The last cell has a hidden point.
    assert_eq!(samples(&data, "c")[..5], [-3.0, -2.0, -1.0, 0.0, 1.0]);
    assert!(samples(&data, "c")[5].is_nan());
}

#[test]
fn an_evenly_spaced_rectilinear_grid_is_an_image() {
    let data = grid_at("even.vtkhdf", None);
    let FileData::Grid(mut other) = other("structured/even-binary.vtk") else {
        panic!("a grid");
    };
    other.notes.reverse();
    assert_eq!(data.notes, other.notes);
    for (field, other) in data.fields.iter().zip(&other.fields) {
        assert_eq!(field.name, other.name);
        assert_eq!(field.lattice, other.lattice);
        assert_eq!(samples(&data, &field.name), samples(&data, &other.name));
    }
}

#[test]
fn every_time_step_has_its_own_mesh() {
    let files = Files::of(&["moving.vtkhdf"]);
    let times = read_steps(&files.path("moving.vtkhdf")).expect("steps");
    assert_eq!(times, [0.0, 0.5, 1.5]);
    // A cube of 2³; four corners of a cube, of which one point is at (1.25, 1, 0.75), so that
    // they have (1 + 0.75 + 1 + 1.25) / 6; a tetrahedron, a pyramid, a wedge and two cubes. c begins at 100 times the time.
    for (step, time, points, cells, expected) in [
        (0, 0.0, 27, 40, 8.0),
        (1, 0.5, 54, 4, 2.0 / 3.0),
        (2, 1.5, 34, 6, 3.0),
    ] {
        let number = mesh_at("moving.vtkhdf", Some(StepChoice::Number(step)));
        let data = mesh_at("moving.vtkhdf", Some(StepChoice::Time(time)));
        assert_same(&number, &data, "by number and time");
        assert_eq!((data.points.len(), data.cells.types.len()), (points, cells));
        let c: Vec<f64> = (0..cells).map(|cell| 100.0 * time + cell as f64).collect();
        assert_eq!(values(&data, "c"), c);
        let f = data.points.iter().map(|p| p.x + 10.0 * p.y + 100.0 * p.z);
        assert_eq!(values(&data, "f"), f.collect::<Vec<_>>());
        let least = data
            .points
            .iter()
            .map(|p| p.z)
            .fold(f64::INFINITY, f64::min);
        assert_eq!(least, time);
        let said = &data.notes[0];
        assert!(said.starts_with("the file holds 3 time steps: "), "{said}");
        assert!(said.ends_with(&format!("at {time}, is read")), "{said}");
        let found = volume(data);
        assert!((found - expected).abs() < 1e-12, "{found}");
    }
    let first = mesh("moving.vtkhdf");
    assert_eq!(first.cells.types.len(), 40);
    for step in [StepChoice::Number(3), StepChoice::Time(0.75)] {
        let error = read_step("moving.vtkhdf", Some(step)).expect_err("not there");
        let help = error.help().expect("a list");
        assert_eq!(help, "it has 3 time steps, 0 to 2, at 0, 0.5, 1.5");
    }
}

#[test]
fn fields_change_where_the_mesh_does_not() {
    for (step, time) in [(0, 0.0), (1, 0.1), (2, 0.2)] {
        // The file has times of 32 bits.
        let data = mesh_at("steady.vtkhdf", Some(StepChoice::Time(time)));
        assert_eq!(data.cells.types.len(), 40);
        let c: Vec<f64> = (0..40).map(|c| f64::from(c) + time).collect();
        assert_eq!(values(&data, "c"), c, "{step}");
        assert_eq!(values(&data, "v-1")[26], 4.0);
        assert_eq!(values(&data, "f")[26], 222.0 + time);
    }
}

#[test]
fn polyhedra_images_and_collections_have_time_steps() {
    let last = Some(StepChoice::Number(1));
    let (first, data) = (mesh("warped.vtkhdf"), mesh_at("warped.vtkhdf", last));
    let moved = first.points.iter().map(|p| p + DVec3::Z * 0.5);
    let near = |(a, b): (DVec3, &DVec3)| (a - b).length() < 1e-14;
    assert!(moved.zip(&data.points).all(near));
    assert_eq!(first.cells.connectivity, data.cells.connectivity);
    assert_eq!(values(&first, "f"), values(&data, "f"));
    assert_same(&first, &mesh("polyhedra.vtkhdf"), "warped.vtkhdf");

    let data = grid_at("images.vtkhdf", last);
    let expected: Vec<f64> = (200..224).map(f64::from).collect();
    assert_eq!(samples(&data, "s"), expected);
    assert_eq!(samples(&data, "c"), [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(samples(&grid_at("images.vtkhdf", None), "s")[23], 23.0);

    let data = mesh_at("rectilinear.vtkhdf", last);
    assert_eq!(data.points[2], DVec3::new(4.0, -1.0, -1.0));
    assert_eq!(values(&data, "f")[26], 27.0);
    assert_eq!(mesh("rectilinear.vtkhdf").points[2].x, 3.0);

    let data = mesh_at("collections.vtkhdf", last);
    let c = values(&data, "c");
    assert_eq!((c[6], c[45], c[46], c[85]), (1.0, 40.0, 1.0, 40.0));
    assert_eq!(data.cells.types.len(), 86);
}

#[test]
fn other_types_of_numbers_and_text_are_read() {
    for name in ["by-hand.hdf", "behind.hdf"] {
        by_hand(mesh(name));
    }
}

fn by_hand(data: MeshData) {
    assert_eq!(data.points[3], DVec3::Z);
    assert_eq!(data.field(None).expect("it has fields").name, "second");
    assert_eq!(values(&data, "first"), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(values(&data, "second"), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(values(&data, "tensor-5"), [5.0, 14.0, 23.0, 32.0]);
    let note = "array 'words' left out: it holds no numbers of 8 to 64 bits";
    assert_eq!(data.notes, [note]);
    assert!((volume(data) - 1.0 / 6.0).abs() < 1e-15);
}

#[test]
fn groups_in_a_cycle_are_met_once() {
    let data = mesh("cycle.hdf");
    assert_eq!(data.cells.types.len(), 1);
}

#[test]
fn what_is_in_other_files_is_refused() {
    let files = Files::of(&["elsewhere.hdf", "raw.hdf", "by-hand.hdf"]);
    for name in ["elsewhere.hdf", "raw.hdf"] {
        let path = files.path(name);
        let error = read_mesh(&path, &ReadOptions::default()).expect_err("refused");
        let words = error.to_string();
        assert!(words.contains("in another file, 'by-hand.hdf'"), "{words}");
    }
}

/// Puts `new` for the only place of `old`.
fn with(mut bytes: Vec<u8>, old: &[u8], new: &[u8]) -> Vec<u8> {
    assert_eq!(old.len(), new.len());
    let places: Vec<usize> = (0..bytes.len() - old.len())
        .filter(|&at| bytes[at..].starts_with(old))
        .collect();
    let &[at] = &places[..] else {
        panic!("{} places", places.len());
    };
    bytes[at..at + new.len()].copy_from_slice(new);
    bytes
}

#[test]
fn what_is_not_read_is_refused_in_words() {
    let of_type = |name: &[u8; 16]| with(bytes("lattice.vtkhdf"), b"UnstructuredGrid", name);
    for (name, words) in [
        (
            b"PolyData\0\0\0\0\0\0\0\0",
            "surfaces, which have no volume (PolyData)",
        ),
        (
            b"OverlappingAMR\0\0",
            "images in each other (OverlappingAMR)",
        ),
        (b"HyperTreeGrid\0\0\0", "a tree of cells (HyperTreeGrid)"),
        (b"Table           ", "a table (Table)"),
        (
            b"UnstructuredGrip",
            "something else than a mesh or an image",
        ),
    ] {
        let error = refused(&of_type(name));
        assert!(error.contains(words), "{error}");
    }
    let version = |major: i64| [major, 8].map(i64::to_le_bytes).concat();
    let newer = with(bytes("lattice.vtkhdf"), &version(2), &version(3));
    let error = refused(&newer);
    assert!(
        error.contains("VTKHDF of version 3.8; up to 2 are read"),
        "{error}"
    );
    let error = refused(&bytes("others.h5"));
    assert!(error.contains("it holds 'Mesh', 'time'"), "{error}");
    let error = read_step("lattice.vtkhdf", Some(StepChoice::Number(0))).expect_err("no steps");
    assert!(error.to_string().contains("holds none"), "{error}");
}
