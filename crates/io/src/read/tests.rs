use std::fs;

use super::*;

fn read_named(name: &str, bytes: &[u8]) -> Error {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("it is writable");
    read_mesh(&path, &ReadOptions::default()).expect_err("it is no mesh")
}

#[test]
fn unknown_files_are_refused_with_the_formats_that_are_read() {
    for (name, bytes, words) in [
        (
            "a.png",
            b"\x89PNG\r\n".as_slice(),
            "not a mesh in a format that is read",
        ),
        ("a.msh", b"hello", "Gmsh"),
        ("a.case", b"FORMAT", "EnSight"),
        ("a.pvtu", b"pieces", "give one of its .vtu pieces"),
        ("a.vtu", b"no xml", "does not begin with an XML element"),
        ("a.vtk", b"no vtk", "# vtk DataFile"),
        ("a.html", b"<html></html>", "no <VTKFile> element"),
        ("a.vtu", b"\x1f\x8b\x08", "gzip"),
        ("a", b"\x89HDF\r\n\x1a\n", "HDF5"),
    ] {
        let error = read_named(name, bytes);
        assert!(error.to_string().contains(words), "{name}: {error}");
        assert_eq!(error.help().as_deref(), Some(FORMATS));
    }
    let error = read_named("a.vtu", b"");
    assert!(error.to_string().contains("the file is empty"), "{error}");
}

#[test]
fn a_missing_file_and_a_folder_are_errors() {
    let missing = read_mesh(Path::new("nowhere.vtu"), &ReadOptions::default());
    assert!(matches!(missing, Err(Error::Io { .. })));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = read_mesh(folder.path(), &ReadOptions::default()).expect_err("a folder");
    assert!(
        folder.to_string().contains("not a regular file"),
        "{folder}"
    );
}
