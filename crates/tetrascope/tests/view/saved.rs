//! The files that a person saves are those that `tetrascope render` writes.

use std::process::Command;

use crate::program::{PROGRAM, Viewer};

#[test]
fn saved_pictures_are_the_files_that_render_writes_to_the_last_byte() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("one.vtk");
    std::fs::write(&path, crate::hands::tetrahedra(0)).expect("written");
    let viewer = Viewer::start(path.to_str().expect("text"));
    std::fs::write(folder.path().join("scene.toml"), viewer.file("scene.toml")).expect("written");
    for format in ["png", "exr", "npy"] {
        let name = format!("picture.{format}");
        let run = Command::new(PROGRAM)
            .current_dir(folder.path())
            .args(["render", "--scene", "scene.toml", "-o", &name])
            .output()
            .expect("the program starts");
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        let beside = format!("{name}.json");
        let names = match format {
            "npy" => vec![name, beside],
            _ => vec![name],
        };
        for name in names {
            let written = std::fs::read(folder.path().join(&name)).expect("it is there");
            assert!(viewer.file(&name) == written, "{name}");
            // The file is named by its contents, wherever it lies.
            let text = String::from_utf8_lossy(&written);
            assert!(name == "picture.npy" || text.contains("one.vtk"), "{name}");
        }
    }
}
