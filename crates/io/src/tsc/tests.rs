use std::fs;
use std::path::Path;

use tetrascope_core::clusters::{CellSource, Cut, MeshClusters};
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, Scalars, TetMesh};
use tetrascope_testing::data_set;

use super::format::{ENTRY, HEADER, checksum};
use super::*;
use crate::damage::{check_cut_off, read_all};
use crate::{FileData, ReadOptions, read_file, read_mesh};

fn cut(most_cells: u32) -> Cut {
    Cut {
        most_cells,
        ..Cut::default()
    }
}

fn with_cell_values(mesh: &TetMesh) -> TetMesh {
    let value = |i: usize| {
        if i % 7 == 3 {
            f64::NAN
        } else {
            (i as f64).sin()
        }
    };
    let scalars = Scalars {
        name: "per cell, µ".into(),
        association: Association::Cell,
        values: (0..mesh.cell_count()).map(value).collect(),
    };
    mesh.with_scalars(scalars).expect("as many")
}

/// The torus with positions and values that f32 holds exactly.
fn in_floats(mesh: &TetMesh) -> TetMesh {
    let round = |x: f64| f64::from(x as f32);
    let points = mesh
        .points()
        .iter()
        .map(|p| DVec3::from(p.to_array().map(round)));
    let scalars = Scalars {
        values: mesh.scalars().values.iter().copied().map(round).collect(),
        ..mesh.scalars().clone()
    };
    TetMesh::from_tetrahedra(points.collect(), mesh.tetrahedra().to_vec(), scalars).expect("valid")
}

/// Clusters of a file are those of the mesh in memory, to the last bit.
#[test]
fn what_is_written_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.tsc");
    let torus = data_set("torus", Some(3000));
    let floats = in_floats(&torus);
    for (mesh, per_point) in [
        (with_cell_values(&torus), 24),
        (torus, 32),
        (with_cell_values(&floats), 12),
        (floats, 16),
    ] {
        for most in [50, 1000, 100_000] {
            let packed = write_tsc(&path, &mesh, &cut(most)).expect("written");
            let memory = MeshClusters::of(&mesh, most).expect("cut");
            let FileData::Clusters(file) = read_file(&path, &ReadOptions::default()).expect("read")
            else {
                panic!("clusters");
            };
            let (file, memory) = (file.source(), memory.source());
            assert_eq!(file.clusters(), memory.clusters());
            assert_eq!(file.field(), memory.field());
            assert!(!file.picked().is_empty());
            for i in 0..file.clusters().len() {
                let (a, b) = (file.read(i).expect("read"), memory.read(i).expect("there"));
                assert_eq!((a.points(), a.tetrahedra()), (b.points(), b.tetrahedra()));
                let bits = |mesh: &TetMesh| -> Vec<u64> {
                    mesh.scalars().values.iter().map(|v| v.to_bits()).collect()
                };
                assert_eq!(bits(&a), bits(&b));
            }
            // 16 bytes of indices, a value where it is the cell's, and the cluster's entry.
            let values = if file.field().1 == Association::Cell {
                8
            } else {
                0
            };
            let beside = packed.bytes - per_point * packed.points;
            let name_and_picked = 8 + 8 * file.picked().len() + file.field().0.len();
            let expected = HEADER as u64
                + name_and_picked as u64
                + (16 + values) * packed.cells
                + ENTRY as u64 * packed.clusters;
            assert_eq!(beside, expected);
            assert_eq!(packed.cells, mesh.cell_count() as u64);
            assert_eq!(packed.bytes, fs::metadata(&path).expect("a file").len());
        }
        let bytes = fs::read(&path).expect("a file");
        write_tsc(&path, &mesh, &cut(100_000)).expect("written");
        assert_eq!(fs::read(&path).expect("a file"), bytes, "the same bytes");
    }
    let error = read_mesh(&path, &ReadOptions::default()).expect_err("not in memory");
    assert!(error.help().is_some(), "{error}");
}

/// A small file's bytes, in some clusters.
fn small(folder: &Path) -> Vec<u8> {
    let mesh = with_cell_values(&data_set("sphere", Some(40)));
    let path = folder.join("small.tsc");
    let packed = write_tsc(&path, &mesh, &cut(15)).expect("written");
    assert!(packed.clusters > 2);
    fs::read(path).expect("a file")
}

/// Whatever byte is spoiled, it is noticed, by the time the cluster is read.
#[test]
fn no_spoiled_byte_goes_unnoticed() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = small(folder.path());
    let path = folder.path().join("spoiled.tsc");
    for at in 0..whole.len() {
        for bits in [1, 0x80, 0xff] {
            let mut spoiled = whole.clone();
            spoiled[at] ^= bits;
            fs::write(&path, spoiled).expect("written");
            let error = read_all(&path).expect_err("spoiled").to_string();
            assert_eq!(error.lines().count(), 1, "{error}");
        }
    }
    for longer in [&[0][..], &[7; 100]] {
        fs::write(&path, [&whole, longer].concat()).expect("written");
        assert!(read_all(&path).is_err());
    }
    check_cut_off("small.tsc", &whole, 1);
}

/// Puts bytes at a place of the directory, counted from its end if that is negative, and makes checksums right.
fn forged(whole: &[u8], at: isize, bytes: &[u8]) -> Vec<u8> {
    let mut forged = whole.to_vec();
    let start = forged.len().checked_add_signed(at).expect("inside");
    forged[start..start + bytes.len()].copy_from_slice(bytes);
    sign(&mut forged);
    forged
}

fn sign(bytes: &mut [u8]) {
    let directory = u64::from_le_bytes(bytes[32..40].try_into().expect("eight")) as usize;
    let sum = checksum(&bytes[directory..]);
    bytes[48..52].copy_from_slice(&sum.to_le_bytes());
    let sum = checksum(&bytes[..52]);
    bytes[52..56].copy_from_slice(&sum.to_le_bytes());
}

/// Numbers that make no sense under checksums that are right: an error in a line, and no memory for them.
#[test]
fn forged_numbers_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = small(folder.path());
    let path = folder.path().join("forged.tsc");
    let check = |bytes: &[u8], words: &str| {
        fs::write(&path, bytes).expect("written");
        let error = read_all(&path).expect_err(words);
        assert!(error.to_string().contains(words), "{words}: {error}");
        assert_eq!(error.to_string().lines().count(), 1);
        assert!(error.help().is_some(), "{error}");
    };
    let header = |at: usize, bytes: &[u8]| {
        let mut forged = whole.clone();
        forged[at..at + bytes.len()].copy_from_slice(bytes);
        let sum = checksum(&forged[..52]);
        forged[52..56].copy_from_slice(&sum.to_le_bytes());
        forged
    };
    let huge = u64::MAX.to_le_bytes();
    check(&header(0, b"x"), "does not begin as a .tsc file");
    check(&header(8, &[2]), "version 2");
    check(&header(12, &[2]), "not 2");
    check(&header(16, &huge), "cells and end at byte");
    check(&header(24, &huge), "for 18446744073709551615 clusters");
    check(&header(24, &[0; 8]), "for 0 clusters");
    check(&header(32, &huge), "the header says");
    check(&header(40, &huge), "the header says");
    check(&header(32, &[0; 8]), "the header says");
    // The last cluster's entry.
    let entry = |at: usize, bytes: &[u8]| forged(&whole, at as isize - ENTRY as isize, bytes);
    let most = u32::MAX.to_le_bytes();
    check(&entry(0, &huge), "begins at byte 18446744073709551615");
    check(&entry(0, &[56, 0, 0, 0, 0, 0, 0, 0]), "begins at byte 56");
    check(&entry(8, &most), "end at byte");
    check(&entry(8, &[0; 4]), "numbers that make no sense");
    check(&entry(12, &most), "numbers that make no sense");
    check(&entry(12, &[0; 4]), "numbers that make no sense");
    check(&entry(16, &[4]), "numbers that make no sense");
    check(&entry(20, &most), "its checksum is another");
    check(
        &entry(24, &f64::NAN.to_le_bytes()),
        "numbers that make no sense",
    );
    check(
        &entry(24, &9.0_f64.to_le_bytes()),
        "numbers that make no sense",
    );
    check(
        &entry(24, &(-9.0_f64).to_le_bytes()),
        "not those that the directory has",
    );
    check(
        &entry(72, &9.0_f64.to_le_bytes()),
        "numbers that make no sense",
    );
    check(
        &entry(80, &9.0_f64.to_le_bytes()),
        "not those that the directory has",
    );
    check(
        &entry(72, &f64::NAN.to_le_bytes()),
        "not those that the directory has",
    );
    // The name's length and that of the values.
    let directory = u64::from_le_bytes(whole[32..40].try_into().expect("eight")) as usize;
    let at = directory as isize - whole.len() as isize;
    check(
        &forged(&whole, at, &most),
        "within the field's name or values",
    );
    let after_name = at + 4 + "per cell, µ".len() as isize;
    check(
        &forged(&whole, after_name, &most),
        "within the field's name or values",
    );
    check(
        &forged(&whole, after_name, &[1, 0, 0, 0]),
        "where each takes",
    );
    // The last index of the last cluster, which has no such point.
    let mut forged = whole.clone();
    forged[directory - 4..directory].copy_from_slice(&most);
    let last = whole.len() - ENTRY;
    let start = u64::from_le_bytes(whole[last..last + 8].try_into().expect("eight")) as usize;
    let sum = checksum(&forged[start..directory]);
    forged[last + 20..last + 24].copy_from_slice(&sum.to_le_bytes());
    sign(&mut forged);
    check(&forged, "uses point 4294967295");
}

/// Line ends that a transfer changed are told, and so is an empty file of that name.
#[test]
fn files_that_are_others_are_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = small(folder.path());
    let path = folder.path().join("mesh.tsc");
    let mut unix = whole.clone();
    unix.remove(4);
    for bytes in [unix, b"# not one".to_vec(), b"\x89TSC".to_vec()] {
        fs::write(&path, bytes).expect("written");
        let error = read_all(&path).expect_err("not one");
        assert!(matches!(error, Error::Format { .. }), "{error}");
    }
    // Told by its first bytes.
    let other = folder.path().join("mesh.dat");
    fs::write(&other, whole).expect("written");
    read_all(&other).expect("it is one");
}

/// A name of another kind, nothing to write, and a stop in the middle: no file, also no temporary one.
#[test]
fn a_file_that_is_refused_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mesh.tsc");
    assert!(check_path(&path.with_extension("vtu")).is_err());
    check_path(&path).expect("a name");
    let mesh = data_set("sphere", Some(40));
    let stopped = cut(10);
    stopped.stop.set();
    let error = write_tsc(&path, &mesh, &stopped).expect_err("stopped");
    assert!(matches!(error, Error::Stopped), "{error}");
    let scalars = Scalars {
        name: "f".into(),
        association: Association::Point,
        values: Vec::new(),
    };
    let nothing = TetMesh::from_tetrahedra(Vec::new(), Vec::new(), scalars).expect("empty");
    assert_eq!(CellSource::cell_count(&nothing), 0);
    assert!(write_tsc(&path, &nothing, &cut(10)).is_err());
    assert!(write_tsc(&path, &mesh, &cut(0)).is_err());
    let left = fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 0);
    let nowhere = folder.path().join("no/folder/mesh.tsc");
    let error = write_tsc(&nowhere, &mesh, &cut(10)).expect_err("no folder");
    assert!(matches!(error, Error::Io { .. }), "{error}");
}
