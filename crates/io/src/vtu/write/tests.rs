use std::path::PathBuf;

use super::*;
use crate::{ReadOptions, read_mesh};

fn fixture(name: &str) -> MeshData {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures");
    read_mesh(&folder.join(name), &ReadOptions::default()).expect(name)
}

fn written(mesh: &MeshData, compression: Compression) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("out.vtu");
    write_vtu(&path, mesh, compression).expect("it is written");
    (folder, path)
}

/// Checks that a mesh reads back as it is, to the last bit.
fn round_trip(name: &str, mesh: &MeshData) {
    for compression in [Compression::None, Compression::Zlib] {
        let (_folder, path) = written(mesh, compression);
        let again = read_mesh(&path, &ReadOptions::default()).expect(name);
        assert_eq!(again.points, mesh.points, "{name}");
        assert_eq!(again.cells, mesh.cells, "{name}");
        assert_eq!(again.field_list(), mesh.field_list(), "{name}");
        for field in 0..mesh.fields.len() {
            let bits = |mesh: &MeshData| -> Vec<u64> {
                let values = mesh.scalars(field).expect(name).values;
                values.into_iter().map(f64::to_bits).collect()
            };
            assert_eq!(
                bits(&again),
                bits(mesh),
                "{name}: {}",
                mesh.fields[field].name
            );
        }
    }
}

#[test]
fn meshes_of_every_format_read_back_bit_by_bit() {
    for name in [
        "components.vtu",
        "mixed.vtu",
        "quadratic.vtu",
        "ghosts.vtu",
        "lattice-ascii.vtu",
        "lattice-42-binary.vtk",
        "lattice-41-binary.msh",
        "structured/pieces.vts",
        "listed/lattice.pvtu",
        "polyhedra/by-cell.vtu",
    ] {
        round_trip(name, &fixture(name));
    }
}

#[test]
fn numbers_that_32_bits_do_not_hold_stay_as_they_are() {
    let mut mesh = fixture("lattice-ascii.vtu");
    mesh.points[3].x += 1e-12;
    mesh.points[4].y = -0.0;
    round_trip("moved", &mesh);
    let text = |mesh: &MeshData| {
        let (_folder, path) = written(mesh, Compression::None);
        String::from_utf8_lossy(&std::fs::read(path).expect("it is there")).into_owned()
    };
    assert!(text(&mesh).contains("type=\"Float64\" Name=\"Points\""));
    mesh.points[3].x = 0.5;
    assert!(text(&mesh).contains("type=\"Float32\" Name=\"Points\""));
}

#[test]
fn the_same_mesh_gives_the_same_bytes() {
    let mesh = fixture("components.vtu");
    let (_folder, path) = written(&mesh, Compression::Zlib);
    let first = std::fs::read(&path).expect("it is there");
    write_vtu(&path, &mesh, Compression::Zlib).expect("it is written again");
    assert_eq!(std::fs::read(&path).expect("it is there"), first);
}

#[test]
fn names_that_a_file_cannot_hold_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("out.vtu");
    for name in ["", "a\nb", "\u{1}"] {
        let mut mesh = fixture("components.vtu");
        mesh.arrays[0].name = name.into();
        let error = write_vtu(&path, &mesh, Compression::None).expect_err(name);
        assert!(error.to_string().contains("printable"), "{error}");
    }
    let mut mesh = fixture("components.vtu");
    let twin = mesh.arrays[0].clone();
    mesh.arrays.push(twin);
    let error = write_vtu(&path, &mesh, Compression::None).expect_err("twins");
    assert!(error.to_string().contains("two arrays"), "{error}");
    assert!(!path.exists());
    let error = check_path(&folder.path().join("out.stl")).expect_err("of another format");
    assert!(error.to_string().contains("stl"), "{error}");
}
