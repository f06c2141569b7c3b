use std::path::Path;

use serde_json::Value;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::curved::{Straightened, Straightening};

use super::*;
use crate::appended::Compression;
use crate::read::{FileData, ReadOptions, read_file};
use crate::vtu::write_vtu;

fn read(path: &Path) -> MeshData {
    match read_file(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}")) {
        FileData::Mesh(mesh) => mesh,
        _ => panic!("{} is a grid", path.display()),
    }
}

fn fixture(name: &str) -> MeshData {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/higher_order");
    read(&folder.join(name))
}

/// The mesh with twelve parts along each edge.
fn in_twelve(data: &MeshData) -> Straightened {
    let scalars = data.field(Some("f")).expect("it has f");
    let to = |tolerance| {
        let cut = data
            .clone()
            .into_straight(vec![scalars.clone()], Straightening::to(tolerance));
        cut.expect("it is cut")
    };
    let report = to(1.0).report.expect("there are curved cells");
    let bound = report.shape.max(report.field) * (report.parts * report.parts) as f64;
    // The root and the quotient are rounded.
    let cut = to(bound / 144.0 * (1.0 + 1e-12));
    assert_eq!(cut.report.expect("as before").parts, 12);
    cut
}

/// Each file's cells with the places and values that VTK gives.
fn expected() -> serde_json::Map<String, Value> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/tests/fixtures/higher_order/expected.json"
    );
    let text = std::fs::read_to_string(path).expect("a fixture");
    serde_json::from_str(&text).expect("it is JSON")
}

fn check(name: &str, cut: &Straightened) {
    let mut samples = 0;
    for cell in expected()[name].as_array().expect("cells") {
        for row in cell[1].as_array().expect("rows") {
            let number = |i: usize| row[i].as_f64().expect("a number");
            let place = DVec3::new(number(0), number(1), number(2));
            // Up to 343 products of numbers up to 12 are rounded on both sides, and 15 digits are written.
            let is_there = |(p, value): (&DVec3, &f64)| {
                (*p - place).length() < 1e-12 && (value - number(3)).abs() < 1e-12
            };
            let mut found = cut.points.iter().zip(&cut.scalars[0].values);
            assert!(found.any(is_there), "{name}: {row}");
            samples += 1;
        }
    }
    assert!(samples >= 12, "{name}");
}

#[test]
fn places_and_values_are_those_of_vtk() {
    for name in [
        "tetrahedra.vtu",
        "hexahedra.vtu",
        "hexahedra-high.vtu",
        "wedges.vtu",
        "degrees.vtu",
        "bezier.vtu",
        "rational.vtu",
        "hexahedron-51.vtk",
    ] {
        let data = fixture(name);
        assert!(data.notes.is_empty(), "{name}: {:?}", data.notes);
        let cut = in_twelve(&data);
        assert_eq!(cut.report.expect("curved").apart, 0, "{name}");
        check(name, &cut);
    }
}

#[test]
fn old_numbers_of_hexahedra_are_told_by_the_version() {
    for (name, cells) in [
        ("hexahedra-old.vtu", 3),
        ("degrees-old.vtu", 2),
        ("hexahedron-42.vtk", 1),
    ] {
        let data = fixture(name);
        let noun = if cells == 1 {
            "hexahedron"
        } else {
            "hexahedra"
        };
        let note = format!("{cells} {noun} of any order renumbered");
        assert!(data.notes[0].starts_with(&note), "{name}: {:?}", data.notes);
        check(name, &in_twelve(&data));
    }
}

#[test]
fn orders_and_weights_are_written_and_read() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["degrees.vtu", "degrees-old.vtu", "rational.vtu"] {
        let data = fixture(name);
        let (field, _) = data.choose(None).expect("it has fields");
        assert_eq!(data.fields[field].name, "f");
        let path = folder.path().join(name);
        let alone = data.with_field(field).expect("in memory");
        write_vtu(&path, &alone, Compression::None).expect("it is written");
        let back = read(&path);
        assert!(back.notes.is_empty(), "{:?}", back.notes);
        check(name, &in_twelve(&back));
    }
}

#[test]
fn without_orders_cells_that_need_them_are_refused() {
    let mut data = fixture("degrees.vtu");
    data.arrays.retain(|array| array.name != DEGREES);
    let scalars = data.field(Some("f")).expect("it has f");
    let error = data.into_straight(vec![scalars], Straightening::default());
    let error = error.expect_err("no order").to_string();
    assert!(
        error.contains("cell 0 is a Lagrange hexahedron of 24 points"),
        "{error}"
    );
}
