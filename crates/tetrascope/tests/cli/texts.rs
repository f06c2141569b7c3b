//! Error messages and descriptions as reviewed texts: `cargo xtask snapshots`.

use std::fmt::Write as _;

use super::program::Folder;

/// Wrong requests, and files that are not what they say.
const WRONG: [&str; 23] = [
    "render empty.vtu",
    "render truncated.vtk",
    "render surface.stl",
    "render nofield.vtu",
    "render study",
    "render .",
    "render --scene nofield.vtu",
    "render sphere -o missing/a.png",
    "render sphere --opacity 0.5",
    "render sphere --width 640",
    "render sphere --isosurface 1",
    "render sphere --size 0x4",
    "render sphere --range 1,0",
    "render sphere --algorithm refrence",
    "render sphere --set order=best",
    "render sphere --model glow",
    "render sphere --camera fit+w",
    "render sphere --field temperature",
    "render sphere --cells 0",
    "render sphere --clip 0,0,0,0,0,0",
    "render sphere -o sphere.jpg",
    "render --scene broken.toml",
    "info spere",
];

/// A tetrahedron without values.
const WITHOUT_FIELD: &str = r#"<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><Points>
<DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>"#;

#[test]
fn errors_are_worded_as_reviewed() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path("study/series")).expect("a folder");
    let head = [&[0; 128][..], b"DICM"].concat();
    folder
        .write("study/series/1", head)
        .write("surface.stl", "solid a\nendsolid a\n")
        .write("nofield.vtu", WITHOUT_FIELD)
        .write("empty.vtu", "")
        .write("truncated.vtk", "# vtk DataFile Version 3.0\nmesh\nASCII\n")
        .write(
            "broken.toml",
            "[volume]\ndataset = \"sphere\"\ncells = -1\n",
        );
    let mut text = String::new();
    for line in WRONG {
        let run = folder.run(line);
        assert_ne!(run.code, 0, "{line}");
        _ = write!(
            text,
            "$ tetrascope {line}\n{}[{}]\n\n",
            run.stderr, run.code
        );
    }
    insta::assert_snapshot!("errors", text);
}

#[test]
fn a_mesh_is_described_as_reviewed() {
    let run = Folder::new().run("info sphere --cells 3000").succeeded();
    insta::assert_snapshot!("info", run.stdout);
}
