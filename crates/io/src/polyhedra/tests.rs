use std::fs;
use std::path::Path;

use super::*;
use crate::read::{FileData, ReadOptions, read_mesh};
use crate::source::Source;
use crate::vtu;

const LAYOUTS: [&str; 4] = [
    "by-cell.vtu",
    "by-cell-zlib.vtu",
    "by-number.vtu",
    "by-number-zlib.vtu",
];

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/polyhedra");
    fs::read_to_string(folder.join(name)).expect("a fixture")
}

fn fixture(name: &str) -> MeshData {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/polyhedra");
    read_mesh(&folder.join(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn read_text(text: &str) -> Result<MeshData, Error> {
    let source = Source {
        path: "a.vtu".into(),
        bytes: text.into(),
    };
    match vtu::read(source)? {
        FileData::Mesh(mesh) => Ok(mesh),
        FileData::Grid(_) | FileData::Clusters(_) => panic!("a grid"),
    }
}

#[test]
fn both_layouts_give_tetrahedra_that_agree_with_each_other_and_with_hexahedra() {
    for name in LAYOUTS {
        let data = fixture(name);
        // Four means of corners, and one of the face between the L, one at each of its ends.
        assert_eq!(data.points.len(), 34 + 4 + 3, "{name}");
        let words = "4 polyhedra cut into 72 tetrahedra around the mean of their corners, 3 faces \
                     around their own; fields at points have the mean of the corners' values there";
        assert_eq!(data.notes, [words], "{name}");
        // A linear field is met at added points, too.
        let near = |(a, b): (f64, f64)| (a - b).abs() < 1e-12 * b.abs().max(1.0);
        let f = data.points.iter().map(|p| p.x + 10.0 * p.y + 100.0 * p.z);
        let values = data.field(Some("f")).expect("a field").values;
        assert!(values.into_iter().zip(f).all(near), "{name}");
        let cells = data.field(Some("c")).expect("a field").values;
        let expected = [(0.0, 12), (1.0, 1), (2.0, 12), (3.0, 24), (4.0, 24)];
        let expected = expected.map(|(c, copies)| vec![c; copies]).concat();
        assert_eq!(cells, expected, "{name}");
        assert_eq!(data.fields[1].range, Some((0.0, 4.0)));
        let mesh = data.into_mesh(Some("f")).expect("a mesh");
        let report = mesh.report();
        assert_eq!((report.flipped, report.crowded_faces), (0, 0), "{name}");
        // Two triangles for each quadrilateral outside, and six for each L.
        assert_eq!(
            mesh.boundary_faces().len(),
            2 * 14 + 2 * 12 + 2 * 6,
            "{name}"
        );
        // The boundary alone makes the volume: a sixth of the determinants of its triangles.
        let boundary = mesh.boundary_faces().iter().map(|&(cell, face)| {
            let corners = tetrascope_core::mesh::FACES[usize::from(face)];
            let [a, b, c] = corners.map(|corner| mesh.cell_points(cell as usize)[corner]);
            a.dot(b.cross(c)) / 6.0
        });
        let boundary: f64 = boundary.sum();
        assert!((mesh.volume() - boundary).abs() < 1e-12, "{name}");
        assert!(
            (mesh.volume() - 16.0 - 3.0).abs() < 0.3,
            "{name}: {}",
            mesh.volume()
        );
    }
}

#[test]
fn a_polyhedron_of_four_triangles_is_a_tetrahedron() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    let data = read_mesh(&folder.join("polyhedron.vtu"), &ReadOptions::default()).expect("a mesh");
    assert_eq!((data.points.len(), &data.cells.types[..]), (4, &[10][..]));
}

#[test]
fn cells_that_share_places_and_not_points_are_cut_alike() {
    // The L one above the other in two pieces, with other numbers of their points.
    let data = fixture("by-number.vtu");
    let (mut apart, mut polyhedra) = (MeshData::default(), Polyhedra::default());
    let ell = |low: usize| (low..low + 6).collect::<Vec<usize>>();
    apart.cells.offsets.push(0);
    for (cell, low, turned) in [(0, 16, false), (1, 22, true)] {
        let base = apart.points.len();
        let mut numbers: Vec<usize> = [ell(low), ell(low + 6)].concat();
        if turned {
            numbers.reverse();
        }
        apart.points.extend(numbers.iter().map(|&n| data.points[n]));
        let at =
            |n: usize| (base + numbers.iter().position(|&m| m == n).expect("it is there")) as u64;
        let mut faces = vec![ell(low), ell(low + 6)];
        faces.extend((0..6).map(|i| {
            let next = (i + 1) % 6;
            vec![low + i, low + next, low + next + 6, low + i + 6]
        }));
        let points = faces.iter().flatten().map(|&n| at(n));
        apart.cells.connectivity.extend(points);
        apart
            .cells
            .offsets
            .push(apart.cells.connectivity.len() as u64);
        apart.cells.types.push(POLYHEDRON);
        polyhedra.push(cell, faces.iter().map(|face| face.len() as u32));
    }
    polyhedra
        .split(Path::new("a"), &mut apart, 1 << 20)
        .expect("closed");
    let scalars = tetrascope_core::Scalars {
        name: "none".into(),
        association: tetrascope_core::mesh::Association::Point,
        values: vec![0.0; apart.points.len()],
    };
    let mesh = tetrascope_core::TetMesh::from_cells(apart.points, apart.cells, scalars);
    let mesh = mesh.expect("a mesh");
    assert!((mesh.volume() - 16.0).abs() < 1e-12);
    assert_eq!(mesh.report().joined_faces, 6);
    // At the upper end the smallest corner is one from which a fan is good.
    assert_eq!(mesh.boundary_faces().len(), 2 * 12 + 6 + 4);
}

#[test]
fn ghosts_among_polyhedra_are_left_out() {
    let marks =
        r#"<DataArray type="UInt8" Name="vtkGhostType" format="ascii">1 0 0 0 32</DataArray>"#;
    for name in ["by-cell.vtu", "by-number.vtu"] {
        let marked = text(name).replace("</CellData>", &format!("{marks}</CellData>"));
        let data = read_text(&marked).expect("a mesh");
        let cells = data.field(Some("c")).expect("a field").values;
        let expected = [vec![1.0; 1], vec![2.0; 12], vec![3.0; 24]].concat();
        assert_eq!(cells, expected, "{name}");
        let volume = data.into_mesh(Some("c")).expect("a mesh").volume();
        assert!((volume - 10.0).abs() < 0.3, "{name}: {volume}");
    }
}

/// A cube as a polyhedron in the older layout; `faces` and the end of their list may be wrong.
fn cube(faces: &str, end: &str) -> String {
    format!(
        r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="8" NumberOfCells="1">
<PointData><DataArray type="Int8" Name="n" format="ascii">0 1 2 3 4 5 6 7</DataArray></PointData>
<Points><DataArray type="Int8" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1</DataArray></Points>
<Cells><DataArray type="Int8" Name="connectivity" format="ascii">0 1 2 3 4 5 6 7</DataArray>
<DataArray type="Int8" Name="offsets" format="ascii">8</DataArray>
<DataArray type="Int8" Name="types" format="ascii">42</DataArray>
<DataArray type="Int64" Name="faces" format="ascii">{faces}</DataArray>
<DataArray type="Int64" Name="faceoffsets" format="ascii">{end}</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"#
    )
}

const CUBE: &str = "6 4 0 2 3 1 4 4 5 7 6 4 0 1 5 4 4 2 6 7 3 4 0 4 6 2 4 1 3 7 5";

#[test]
fn faces_that_make_no_sense_are_refused() {
    let data = read_text(&cube(CUBE, "31")).expect("a mesh");
    assert_eq!(data.field(None).expect("a field").values[8], 3.5);
    assert_eq!(data.into_mesh(None).expect("a mesh").volume(), 1.0);
    let edited = |from: &str, to: &str| CUBE.replacen(from, to, 1);
    for (faces, end, words) in [
        (CUBE.into(), "30", "31 values where 30 are needed"),
        (CUBE.into(), "-1", "31 values where 0 are needed"),
        (CUBE.into(), "4000000000000", "cells with"),
        (
            edited("6 4", "7 4"),
            "31",
            "the faces of cell 0 do not end at 31",
        ),
        (
            edited("6 4", "5 4"),
            "31",
            "the faces of cell 0 do not end at 31",
        ),
        (
            edited("6 4", "6 3"),
            "31",
            "the faces of cell 0 do not end at 31",
        ),
        (
            edited("6 4", "6 9000000000000"),
            "31",
            "the faces of cell 0 do not end at 31",
        ),
        (
            edited("7 5", "7 8"),
            "31",
            "is point 8, but the piece has 8 points",
        ),
        (edited("7 5", "7 -5"), "31", "indices begin at 0"),
        // A hole, and a face that is there twice.
        (
            "5 4 0 2 3 1 4 4 5 7 6 4 0 1 5 4 4 2 6 7 3 4 0 4 6 2".into(),
            "26",
            "do not close it: the edge between points 3 and 1 belongs to 1 face",
        ),
        (
            "7 4 0 2 3 1 4 4 5 7 6 4 0 1 5 4 4 2 6 7 3 4 0 4 6 2 4 1 3 7 5 4 1 3 7 5".into(),
            "36",
            "belongs to 3 faces",
        ),
        ("0".into(), "1", "do not close it: it has none"),
    ] {
        let error = read_text(&cube(&faces, end)).expect_err(words);
        assert!(matches!(error, Error::Format { .. }), "{error}");
        assert!(error.to_string().contains(words), "{words}: {error}");
    }
    let without = cube(CUBE, "31").replace("Name=\"faces\"", "Name=\"sides\"");
    let error = read_text(&without).expect_err("no faces").to_string();
    assert!(
        error.contains("no array 'faces' or 'face_connectivity'"),
        "{error}"
    );
    let new = text("by-number.vtu");
    for (name, from, to, words) in [
        ("face_offsets", "4 8", "8 4", "less than the one before"),
        (
            "polyhedron_offsets",
            "6 6",
            "6 5",
            "less than the one before",
        ),
        (
            "polyhedron_to_faces",
            "0 1",
            "0 99",
            "values where 100 are needed",
        ),
        ("face_connectivity", "0 8", "0 99", "is point 99"),
        (
            "polyhedron_offsets",
            "polyhedron_offsets",
            "x",
            "no array 'polyhedron_offsets'",
        ),
    ] {
        let (head, tail) = new.split_at(new.find(name).expect("it is there"));
        let wrong = format!("{head}{}", tail.replacen(from, to, 1));
        let error = read_text(&wrong).expect_err(words).to_string();
        assert!(error.contains(words), "{name}: {error}");
    }
}

#[test]
fn a_face_that_is_listed_again_and_again_is_counted_each_time() {
    // A thousand cells of a thousand faces, all of which are one of a thousand points.
    let (cells, of_each, points) = (1000, 1000, 1000);
    let array = |name: &str, values: &mut dyn Iterator<Item = usize>| {
        let values: Vec<String> = values.map(|v| v.to_string()).collect();
        let text = values.join(" ");
        format!(r#"<DataArray type="Int64" Name="{name}" format="ascii">{text}</DataArray>"#)
    };
    let arrays = [
        array("connectivity", &mut std::iter::repeat_n(0, cells)),
        array("offsets", &mut (1..=cells)),
        array("types", &mut std::iter::repeat_n(42, cells)),
        array("face_connectivity", &mut (0..points).map(|_| 0)),
        array("face_offsets", &mut std::iter::once(points)),
        array(
            "polyhedron_to_faces",
            &mut std::iter::repeat_n(0, cells * of_each),
        ),
        array("polyhedron_offsets", &mut (1..=cells).map(|i| i * of_each)),
    ];
    let text = format!(
        r#"<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="1" NumberOfCells="{cells}">
<Points><DataArray type="Int8" NumberOfComponents="3" format="ascii">0 0 0</DataArray></Points>
<Cells>{}</Cells></Piece></UnstructuredGrid></VTKFile>"#,
        arrays.concat()
    );
    let error = read_text(&text).expect_err("too many").to_string();
    assert!(
        error.contains("so many different ones cannot be in"),
        "{error}"
    );
}

#[test]
fn polyhedra_that_overlap_themselves_are_counted() {
    // The L with its corner far in: its center sees not all sides.
    let text = text("by-number.vtu");
    let data = read_text(
        &text
            .replace("7 2 0", "5.1 0.1 0")
            .replace("7 2 1", "5.1 0.1 1")
            .replace("7 2 2", "5.1 0.1 2"),
    );
    let data = data.expect("a mesh");
    let words = "do not see all of their faces";
    assert!(
        data.notes.iter().any(|note| note.contains(words)),
        "{:?}",
        data.notes
    );
}

#[test]
fn the_order_of_a_face_does_not_matter() {
    let data = fixture("by-number.vtu");
    let order = Order { places: Vec::new() };
    let ell: Vec<u64> = (16..22).collect();
    for turn in 0..6 {
        let mut face = ell.clone();
        face.rotate_left(turn);
        for reverse in [false, true] {
            if reverse {
                face.reverse();
            }
            let face = &faces(&face, &[6], &order)[0];
            assert_eq!(face[0], 16);
            assert!(!is_good_fan(face, &data.points));
        }
    }
    // From its inner corner or the opposite one it is a good one.
    assert!(is_good_fan(&[18, 19, 20, 21, 16, 17], &data.points));
}

/// Two cells that share places and not points begin the fan of a face at the same place.
#[test]
fn a_face_of_points_at_the_same_places_is_cut_alike() {
    let order = Order {
        places: vec![0, 1, 2, 3, 3, 2, 1, 0],
    };
    assert_eq!(faces(&[2, 3, 0, 1], &[4], &order), [[0, 1, 2, 3]]);
    assert_eq!(faces(&[4, 5, 6, 7], &[4], &order), [[7, 4, 5, 6]]);
}
