//! Time steps within one file.

use std::path::Path;

use super::program::Folder;

/// A mesh of every shape with two time steps, at 0 and 0.5.
fn folder() -> Folder {
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../io/tests/fixtures");
    let folder = Folder::new();
    let bytes = std::fs::read(fixtures.join("shapes.e")).expect("a fixture");
    folder.write("shapes.e", bytes);
    folder
}

fn info(folder: &Folder, line: &str) -> serde_json::Value {
    let run = folder.run(&format!("info shapes.e --json {line}"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    serde_json::from_str(&run.stdout).expect("JSON")
}

#[test]
fn info_lists_steps_and_describes_the_one_that_is_chosen() {
    let folder = folder();
    let first = info(&folder, "");
    let times = first["steps"].as_array().expect("a list").clone();
    assert_eq!(times.len(), 2, "{first}");
    let second = info(&folder, "--step 1");
    assert_eq!(second["steps"], first["steps"]);
    assert_ne!(second["fields"], first["fields"]);
    assert_eq!(info(&folder, &format!("--time {}", times[1])), second);
    assert_eq!(info(&folder, "--step 0")["fields"], first["fields"]);
    let text = folder.run("info shapes.e").stdout;
    assert!(text.starts_with("time steps     2, 0 to 1, at 0"), "{text}");
}

#[test]
fn steps_that_are_not_there_are_refused_with_those_that_are() {
    let folder = folder();
    folder.write("a.raw", [7; 8]);
    for (line, code, words) in [
        ("info shapes.e --step 2", 3, "2 time steps, 0 to 1, at 0"),
        ("info shapes.e --time 0.25", 3, "the nearest are number 0"),
        ("info shapes.e --step 0 --time 0", 2, "cannot be used with"),
        ("info sphere --step 0", 2, "files with time steps"),
        (
            "info a.raw --dims 2x2x2 --type u8 --step 0",
            3,
            "leave out the step",
        ),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, code, "{line}: {}", run.stderr);
        assert!(run.stderr.contains(words), "{line}: {}", run.stderr);
    }
    assert_eq!(folder.run("info a.raw --dims 2x2x2 --type u8").code, 0);
}

#[test]
fn the_steps_of_one_file_are_a_series() {
    let folder = folder();
    let size = "--size 24x16 --field x";
    let run = folder.run(&format!("render shapes.e {size} -o f_%d.png"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(run.stdout, "f_0.png\nf_1.png\n");
    assert_ne!(folder.read("f_0.png"), folder.read("f_1.png"));
    // Frames that are there are not drawn again, and each knows its step.
    let run = folder.run(&format!("render shapes.e {size} -o f_%d.png --resume"));
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("2 were there"), "{}", run.stderr);
    // A step that is chosen is one picture, numbered or not.
    for output in ["one.png", "one_%d.png"] {
        let run = folder.run(&format!("render shapes.e {size} --step 1 -o {output}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    assert_eq!(folder.read("one.png"), folder.read("one_0.png"));
    let scene = folder.run("print-scene shapes.e --step 1").stdout;
    assert!(scene.contains("step = 1"), "{scene}");
    folder.write("scene.toml", scene);
    let run = folder.run("render --scene scene.toml --size 24x16 -o again.png");
    assert_eq!(run.code, 0, "{}", run.stderr);
}
