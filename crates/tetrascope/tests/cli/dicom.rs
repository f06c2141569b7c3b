//! DICOM series are folders.

use std::path::Path;

use super::program::Folder;

#[test]
fn a_folder_is_a_series() {
    let fixtures =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../io/tests/fixtures/dicom/explicit");
    let folder = Folder::new();
    std::fs::create_dir(folder.path("series")).expect("a folder");
    for name in ["a.dcm", "b.dcm", "c.dcm", "notes.txt"] {
        let to = folder.path("series").join(name);
        std::fs::copy(fixtures.join(name), to).expect("a fixture");
    }
    let run = folder.run("info series --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let facts: serde_json::Value = serde_json::from_str(&run.stdout).expect("JSON");
    assert_eq!(facts["dims"], serde_json::json!([5, 4, 3]), "{facts}");
    for volume in ["series", "series/b.dcm"] {
        let run = folder.run(&format!("render {volume} -o a.png --size 16x16"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let run = folder.run("render . -o b.png");
    assert_eq!(run.code, 3, "{}", run.stdout);
    let what =
        "a folder is read as a DICOM series, and none of the files here is a DICOM image, in .";
    assert!(run.stderr.contains(what), "{}", run.stderr);
}
