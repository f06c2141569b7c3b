use std::fs;
use std::path::{Path, PathBuf};

use tetrascope_core::Error;

use crate::read::{ReadOptions, read_mesh};
use crate::{MeshData, read_collection};

fn fixture(name: &str) -> PathBuf {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    fixtures.join(name)
}

fn read(path: &Path) -> Result<MeshData, Error> {
    read_mesh(path, &ReadOptions::default())
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    data.field(Some(name))
        .unwrap_or_else(|e| panic!("{e}"))
        .values
}

#[test]
fn pieces_become_one_mesh_without_ghosts_and_seams() {
    let data = read(&fixture("listed/lattice.pvtu")).expect("a mesh");
    let whole = read(&fixture("lattice-ascii.vtu")).expect("a mesh");
    // The fields say which cells and points are which.
    let mut cells = values(&data, "c");
    cells.sort_by(f64::total_cmp);
    assert_eq!(cells, values(&whole, "c"));
    let f: Vec<f64> = data
        .points
        .iter()
        .map(|p| p.x + 10.0 * p.y + 100.0 * p.z)
        .collect();
    assert_eq!(values(&data, "f"), f);
    let list = |data: &MeshData| {
        let mut list = data.field_list();
        list.sort();
        list
    };
    assert_eq!(list(&data), list(&whole));
    let name = |path: &PathBuf| path.file_name().expect("a name").to_owned();
    let names: Vec<_> = data.files.iter().map(name).collect();
    assert_eq!(
        names,
        [
            "lattice.pvtu",
            "lattice_0.vtu",
            "lattice_1.vtu",
            "lattice_2.vtu"
        ]
    );
    let (notes, [mesh, whole]) = (
        data.notes.clone(),
        [data, whole].map(|data| data.into_mesh(Some("f")).expect("a mesh")),
    );
    let joined = mesh.report().coincident_points;
    assert!(joined > 0);
    let words = format!(
        "3 pieces joined: {joined} points lie exactly where others are, and neighbors share faces there"
    );
    assert!(notes.contains(&words), "{notes:?}");
    assert_eq!(mesh.volume(), whole.volume());
    assert_eq!(mesh.boundary_faces().len(), whole.boundary_faces().len());
    assert!(mesh.is_continuous());
}

#[test]
fn blocks_become_one_mesh_and_what_is_none_is_noted() {
    let data = read(&fixture("listed/blocks.vtm")).expect("a mesh");
    let lattice = read(&fixture("lattice-ascii.vtu")).expect("a mesh");
    let mixed = read(&fixture("mixed.vtu")).expect("a mesh");
    assert_eq!(data.points.len(), mixed.points.len() + lattice.points.len());
    assert_eq!(data.cells.types.len(), 6 + 40);
    let (x, f, c) = (values(&data, "x"), values(&data, "f"), values(&data, "c"));
    let (first, second) = x.split_at(mixed.points.len());
    assert_eq!(first, values(&mixed, "x"));
    assert!(second.iter().all(|v| v.is_nan()));
    assert!(f[..mixed.points.len()].iter().all(|v| v.is_nan()));
    assert_eq!(f[mixed.points.len()..], values(&lattice, "f"));
    assert!(c[..6].iter().all(|v| v.is_nan()));
    assert_eq!(c[6..], values(&lattice, "c"));
    for words in [
        "'blocks/blocks_3.vtu' left out: it has no cells with a volume",
        "'blocks/blocks_4.vti' left out: it holds a ImageData, and meshes are joined",
        "'blocks/blocks_5.vtp' left out: it holds a PolyData, and meshes are joined",
        "'f' is NaN in 1 of 2 pieces, which have no such array",
    ] {
        assert!(data.notes.iter().any(|n| n == words), "{:?}", data.notes);
    }
    assert!(data.notes.iter().any(|n| n.starts_with("2 pieces joined")));
    // Volumes of 3 and 8; one tetrahedron of both is the same, and drawn once.
    let mesh = data.into_mesh(Some("x")).expect("a mesh");
    assert_eq!(mesh.report().duplicates, 1);
    assert!((mesh.volume() - (11.0 - 1.0 / 6.0)).abs() < 1e-13);
}

/// One tetrahedron with a point field, at `x`.
fn tetrahedron(field: &str, x: u32) -> String {
    format!(
        r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="1">
<PointData><DataArray type="Float32" Name="{field}" format="ascii">{x} 1 2 3</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 0 1 0 0 0 1 {x} 0 0</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4</DataArray>
<DataArray type="Int32" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"#
    )
}

/// A folder with `a.vtu`, `sub/b.vtu` and `c.vtu`, of which the last has no cells.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: String| {
        fs::write(folder.path().join(name), text).expect("written");
    };
    fs::create_dir(folder.path().join("sub")).expect("made");
    write("a.vtu", tetrahedron("t", 5));
    write("sub/b.vtu", tetrahedron("t", 7));
    write("other.vtu", tetrahedron("u", 9));
    let empty = r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid>
<Piece NumberOfPoints="0" NumberOfCells="0"></Piece></UnstructuredGrid></VTKFile>"#;
    write("c.vtu", empty.into());
    folder
}

fn pvtu(pieces: &str) -> String {
    format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="0">{pieces}</PUnstructuredGrid></VTKFile>"#
    )
}

fn pieces(names: &[&str]) -> String {
    let piece = |name: &&str| format!(r#"<Piece Source="{name}"/>"#);
    pvtu(&names.iter().map(piece).collect::<String>())
}

fn read_text(folder: &tempfile::TempDir, name: &str, text: &str) -> Result<MeshData, Error> {
    let path = folder.path().join(name);
    fs::write(&path, text).expect("written");
    read(&path)
}

#[test]
fn a_piece_without_cells_is_no_matter_and_a_field_of_one_piece_is_left_out() {
    let folder = folder();
    let text = pieces(&["a.vtu", "c.vtu", "./sub/b.vtu"]);
    let data = read_text(&folder, "x.pvtu", &text).expect("a mesh");
    assert_eq!(values(&data, "t"), [5.0, 1.0, 2.0, 3.0, 7.0, 1.0, 2.0, 3.0]);
    let words =
        "2 pieces joined: 3 points lie exactly where others are, and neighbors share faces there";
    assert_eq!(data.notes, [words]);
    let data = read_text(&folder, "x.pvtu", &pieces(&["a.vtu", "other.vtu"])).expect("a mesh");
    assert!(data.fields.is_empty());
    assert_eq!(
        data.notes[1..],
        [
            "array 't' left out: 'other.vtu' has no such array of 1 component",
            "array 'u' left out: 'a.vtu' has no such array of 1 component",
        ]
    );
}

#[test]
fn steps_of_a_series_may_be_lists() {
    let folder = folder();
    fs::write(folder.path().join("x.pvtu"), pieces(&["a.vtu"])).expect("written");
    fs::write(folder.path().join("y.vtm"), vtm(&["a.vtu"])).expect("written");
    let series = folder.path().join("all.pvd");
    let text = r#"<VTKFile type="Collection"><Collection><DataSet timestep="0" file="x.pvtu"/>
<DataSet timestep="1" file="y.vtm"/></Collection></VTKFile>"#;
    fs::write(&series, text).expect("written");
    let steps = read_collection(&series).expect("a series");
    assert_eq!(steps.len(), 2);
    for step in steps {
        assert_eq!(read(&step.file).expect("a mesh").cells.types, [10]);
    }
}

fn vtm(names: &[&str]) -> String {
    let block =
        |name: &&str| format!(r#"<Block index="0"><DataSet index="0" file="{name}"/></Block>"#);
    let blocks: String = names.iter().map(block).collect();
    format!(
        r#"<VTKFile type="vtkMultiBlockDataSet"><vtkMultiBlockDataSet>{blocks}<DataSet index="9"/></vtkMultiBlockDataSet></VTKFile>"#
    )
}

#[test]
fn what_is_wrong_with_a_list_is_said_with_the_file() {
    let folder = folder();
    let absolute = folder.path().join("a.vtu").display().to_string();
    for (text, words) in [
        (
            pieces(&["a.vtu", "gone.vtu", "lost.vtu"]),
            "the file 'gone.vtu' is not there, nor are 1 other, in",
        ),
        (pieces(&["."]), "the file '.' is not there"),
        (
            pieces(&["../a.vtu"]),
            "'../a.vtu' is not in the folder of the file that lists it",
        ),
        (pieces(&[&absolute]), "is not in the folder"),
        (pieces(&["a.vtu", "./a.vtu"]), "'./a.vtu' is listed twice"),
        (pieces(&["sub/b.vtu", "sub/./b.vtu"]), "is listed twice"),
        (pieces(&["x.pvtu"]), "holds a PUnstructuredGrid"),
        (pieces(&["c.vtu"]), "the mesh has no cells"),
        (pieces(&[]), "no <Piece> with a name"),
        (pvtu("<Piece/>"), "a <Piece> without Source"),
        (
            pieces(&["a.vtu"]).replace("</VTKFile>", ""),
            "ends before </VTKFile>",
        ),
        (pvtu("<Piece Source=\"a.vtu>"), "XML is damaged"),
        (
            pieces(&["a.vtu"]).replace("<VTKFile", "<!DOCTYPE x><VTKFile"),
            "document type",
        ),
        (vtm(&["a.vtu", "a.vtu"]), "'a.vtu' is listed twice"),
        (vtm(&["gone.vtu"]), "the file 'gone.vtu' is not there"),
        (vtm(&["x.pvtu"]), "the file lists no mesh"),
        (vtm(&[]), "no <DataSet> with a name"),
    ] {
        let error = read_text(&folder, "x.pvtu", &text).expect_err(words);
        assert!(matches!(error, Error::Format { .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains(words), "{message}");
        assert!(
            !message.contains('\n') && message.contains("x.pvtu"),
            "{message}"
        );
    }
    // What is wrong with a piece is said of the piece.
    fs::write(
        folder.path().join("c.vtu"),
        tetrahedron("t", 1).replace(">0 1 2 3<", ">0 1 2 4<"),
    )
    .expect("written");
    let error = read_text(&folder, "x.pvtu", &pieces(&["a.vtu", "c.vtu"])).expect_err("no point 4");
    let message = error.to_string();
    assert!(
        message.contains("value 3 is point 4") && message.contains("c.vtu"),
        "{message}"
    );
    let long = pvtu(&" ".repeat(5 << 20));
    let error = read_text(&folder, "x.pvtu", &long).expect_err("too long");
    assert!(
        error.to_string().contains("more than 4194304 bytes"),
        "{error}"
    );
}

#[test]
fn fields_of_many_blocks_are_filled_to_a_bound() {
    let folder = folder();
    // A field of its own in each block would take as many values as all have points.
    let names: Vec<String> = (0..40).map(|i| format!("{i}.vtu")).collect();
    for (i, name) in names.iter().enumerate() {
        let more = (0..40).map(|k| {
            format!(r#"<DataArray type="Int8" Name="{i} {k}" format="ascii">1 2 3 4</DataArray>"#)
        });
        let text = tetrahedron("t", 5)
            .replace("</PointData>", &(more.collect::<String>() + "</PointData>"));
        fs::write(folder.path().join(name), text).expect("written");
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let data = read_text(&folder, "x.vtm", &vtm(&names)).expect("a mesh");
    assert_eq!(data.fields.len(), 1 + crate::pieces::MOST_FILLED);
    let left_out = data.notes.iter().filter(|note| note.contains("left out"));
    assert_eq!(left_out.count(), 40 * 40 - crate::pieces::MOST_FILLED);
}

#[test]
fn damaged_lists_never_panic() {
    let folder = folder();
    let text = pieces(&["a.vtu", "sub/b.vtu"]).into_bytes();
    let whole = read_text(&folder, "x.pvtu", &pieces(&["a.vtu", "sub/b.vtu"])).expect("a mesh");
    let path = folder.path().join("x.pvtu");
    for length in 1..text.len() {
        fs::write(&path, &text[..length]).expect("written");
        if let Ok(data) = read(&path) {
            assert_eq!(data.cells, whole.cells);
        }
        let mut damaged = text.clone();
        damaged[length] ^= 1 << (length % 8);
        fs::write(&path, damaged).expect("written");
        let _ = read(&path);
    }
}
