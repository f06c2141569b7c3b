//! Error messages and descriptions as reviewed texts: `cargo xtask snapshots`.

use std::fmt::Write as _;

use super::program::Folder;

/// Wrong requests, and files that are not what they say.
const WRONG: [&str; 15] = [
    "render empty.vtu",
    "render truncated.vtk",
    "render . -o a.png",
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

#[test]
fn errors_are_worded_as_reviewed() {
    let folder = Folder::new();
    folder
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
