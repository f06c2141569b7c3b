use super::*;
use crate::damage::{check_changed, check_cut_off};
use crate::hdf5::tests::{Files, bytes, fixtures};
use crate::read::{FileData, ReadOptions, read_file, read_mesh};
use crate::read_steps;

fn mesh_at(name: &str, step: Option<usize>) -> MeshData {
    let files = Files::of(&[name]);
    let options = ReadOptions {
        step: step.map(StepChoice::Number),
        ..ReadOptions::default()
    };
    // Values are read when they are asked for; on Unix an open file outlives its name.
    read_mesh(&files.path(name), &options).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    let field = data.field(Some(name));
    field.unwrap_or_else(|e| panic!("{e}")).values
}

fn volume(data: &MeshData) -> f64 {
    data.clone().into_mesh(None).expect("a mesh").volume()
}

/// The sum of values, each times its number from 1.
fn weighed(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .zip(1..)
        .map(|(value, n)| value * f64::from(n))
        .sum()
}

/// The numbers that vtkCGNSReader gives for each zone of a file.
fn expected(name: &str) -> Vec<serde_json::Value> {
    let text = std::fs::read(fixtures().join("cgns/expected.json")).expect("expected.json");
    let all: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    all[name].as_array().expect("zones").clone()
}

fn assert_near(found: f64, said: &serde_json::Value, what: &str) {
    let said = said.as_f64().expect("a number");
    assert!(
        (found - said).abs() <= 1e-9 * said.abs().max(1.0),
        "{what}: {found}, not {said}"
    );
}

#[test]
fn sections_are_those_that_vtk_reads() {
    for name in [
        "lattice.cgns",
        "mixed.cgns",
        "mixed-3.cgns",
        "ngon.cgns",
        "ngon-3.cgns",
    ] {
        let (data, zone) = (mesh_at(name, None), &expected(name)[0]);
        // Polyhedra are cut around points of their own, and surfaces are passed over.
        let points = zone["points"].as_u64().expect("a number") as usize;
        let places = data.points[..points].iter().flat_map(|p| p.to_array());
        assert_near(weighed(places), &zone["at"], name);
        // The lattice has cells that are turned over, which VTK takes off.
        if name.starts_with("ngon") {
            assert_near(volume(&data), &zone["volume"], name);
        }
    }
    let data = mesh_at("lattice.cgns", None);
    let zone = &expected("lattice.cgns")[0];
    let ids = data.cells.connectivity.iter().map(|&id| id as f64);
    assert_near(weighed(ids), &zone["ids"], "cells");
}

#[test]
fn a_mesh_is_that_of_the_same_vtu_file() {
    let other = read_file(
        &fixtures().join("lattice-ascii.vtu"),
        &ReadOptions::default(),
    );
    let Ok(FileData::Mesh(other)) = other else {
        panic!("a mesh")
    };
    let files = Files::of(&["lattice.cgns"]);
    let times = read_steps(&files.path("lattice.cgns")).expect("steps");
    assert_eq!(times, [0.0, 0.5, 1.5]);
    for (step, time) in times.iter().enumerate() {
        let data = mesh_at("lattice.cgns", Some(step));
        assert_eq!(data.points, other.points);
        assert_eq!(data.cells.connectivity, other.cells.connectivity);
        let f: Vec<f64> = values(&other, "f").iter().map(|f| f + time).collect();
        assert_eq!(values(&data, "f"), f);
        assert_eq!(values(&data, "c"), values(&other, "c"));
        for (a, b) in [("x", "0"), ("y", "1"), ("z", "2")] {
            let [a, b] = [(&data, "Velocity", a), (&other, "v", b)]
                .map(|(data, name, part)| values(data, &format!("{name}-{part}")));
            assert_eq!(a, b);
        }
    }
    let notes = mesh_at("lattice.cgns", None).notes;
    for words in [
        "3 time steps: the first",
        "'Wall' of 'Zone' left out: it has no cells with a volume",
        "'Faces' of 'Zone' left out: it is at each FaceCenter",
        "'p' of 'Beyond' of 'Zone' left out: it has values beyond the zone (Rind)",
    ] {
        assert!(
            notes.iter().any(|note| note.contains(words)),
            "{words}: {notes:?}"
        );
    }
}

#[test]
fn mixed_sections_have_values_of_volumes() {
    // A tetrahedron, a pyramid, a wedge and a cube.
    for name in ["mixed.cgns", "mixed-3.cgns"] {
        let data = mesh_at(name, None);
        assert_eq!(data.cells.types, [10, 14, 13, 12], "{name}");
        assert_eq!(values(&data, "c"), [0.0, 1.0, 2.0, 3.0]);
        assert!((volume(&data) - 2.0).abs() < 1e-12, "{name}");
    }
}

#[test]
fn polyhedra_share_faces() {
    for name in ["ngon.cgns", "ngon-3.cgns"] {
        let data = mesh_at(name, None);
        assert!((volume(&data) - 2.0).abs() < 1e-12, "{name}");
        // Twelve triangles around each middle.
        let c = values(&data, "c");
        assert_eq!(c.len(), 24);
        assert_eq!((c[0], c[11], c[12], c[23]), (3.0, 3.0, 5.0, 5.0));
    }
}

#[test]
fn structured_zones_are_hexahedra_that_share_a_side() {
    let data = mesh_at("structured.cgns", None);
    let zones = expected("structured.cgns");
    assert_eq!((data.points.len(), data.cells.types.len()), (36, 8));
    for (zone, said) in zones.iter().enumerate() {
        let places = data.points[18 * zone..18 * (zone + 1)].iter();
        assert_near(
            weighed(places.flat_map(|p| p.to_array())),
            &said["at"],
            "points",
        );
        for (name, count) in [("p", 18), ("c", 4)] {
            let place = if name == "p" { "point" } else { "cell" };
            let of_zone = &values(&data, name)[count * zone..count * (zone + 1)];
            let said = &said["arrays"][format!("{place}:{name}")][1];
            assert_near(weighed(of_zone.iter().copied()), said, name);
        }
    }
    let joined = "2 pieces joined: 6 points";
    assert!(
        data.notes.iter().any(|note| note.starts_with(joined)),
        "{:?}",
        data.notes
    );
    assert!(
        data.notes[0].starts_with("base 'Surface' left out"),
        "{:?}",
        data.notes
    );
}

#[test]
fn curved_cells_have_the_order_that_vtk_gives_them() {
    let data = mesh_at("curved.cgns", None);
    // By number of type, as HDF5 sorts the names of zones.
    assert_eq!(data.cells.types, [24, 27, 26, 32, 25, 29, 27]);
    for (cell, zone) in expected("curved.cgns").iter().enumerate() {
        let ends = &data.cells.offsets[cell..cell + 2];
        let points = &data.cells.connectivity[ends[0] as usize..ends[1] as usize];
        let first = points.iter().min().expect("points");
        let ids = points.iter().map(|id| (id - first) as f64);
        // vtkCGNSReader 9.7.2 gives pyramids of 14 nodes all of them, and has none of 13.
        if data.cells.types[cell] != 27 {
            assert_near(weighed(ids), &zone["ids"], &format!("cell {cell}"));
        } else {
            assert_eq!(weighed(ids), 728.0);
        }
    }
}

#[test]
fn adf_files_are_refused_with_a_way_out() {
    let files = Files::of(&[]);
    let path = files.put("a.cgns", b"@(#)ADF Database Version A02011>");
    let error = read_file(&path, &ReadOptions::default()).expect_err("refused");
    assert!(error.to_string().contains("CGNS file in ADF"), "{error}");
    assert!(error.help().is_some_and(|help| help.contains("adf2hdf")));
}

const SMALL: [&str; 4] = ["lattice.cgns", "mixed.cgns", "ngon.cgns", "structured.cgns"];

#[test]
fn a_file_that_is_cut_off_is_an_error() {
    for name in SMALL {
        check_cut_off(name, &bytes(name), 389);
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    for name in SMALL {
        check_changed(name, &bytes(name));
    }
}
