//! What is asked for wrongly, and what the surroundings refuse.

use std::process::Stdio;

use super::program::{Folder, program};

#[test]
fn an_unknown_algorithm_or_setting_lists_the_valid_ones() {
    let folder = Folder::new();
    let (error, help) = folder.run("render sphere --algorithm refrence").failed(2);
    assert!(error.contains("valid: reference"), "{error}");
    assert_eq!(help, "  help: did you mean 'reference'?");
    let (error, _) = folder.run("render sphere --set order=best").failed(2);
    assert!(
        error.contains("no setting 'order=best'; valid: none"),
        "{error}"
    );
    let (error, _) = folder.run("render sphere -o sphere.jpg").failed(2);
    assert!(error.contains("valid: png, exr, npy"), "{error}");
    assert!(folder.files().is_empty());
}

#[cfg(feature = "projection")]
#[test]
fn settings_of_the_projection_are_checked_before_a_device_is_made() {
    let folder = Folder::new();
    let line = "render sphere --algorithm projection --set order=best";
    let (error, _) = folder.run(line).failed(2);
    assert!(error.contains("valid: order="), "{error}");
}

#[cfg(feature = "projection")]
#[test]
fn a_missing_gpu_has_its_own_code() {
    let folder = Folder::new();
    let output = program()
        .args(["render", "sphere", "--cells", "100", "--size", "8"])
        .args(["--algorithm", "projection", "--quiet"])
        .env("WGPU_ADAPTER_NAME", "no adapter is called this")
        .current_dir(folder.root())
        .output()
        .expect("the program starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(
        stderr.contains("error: no suitable graphics adapter"),
        "{stderr}"
    );
    assert!(folder.files().is_empty());
}

#[test]
fn wrong_usage_has_its_own_code() {
    let folder = Folder::new();
    for line in [
        "",
        "render",
        "draw sphere",
        "render sphere --sise 8",
        "render sphere --size big",
        "render sphere --model glow",
        "render sphere --camera fit+w",
        "render sphere --colormap jet",
        "render sphere --range 1",
        "render sphere --background red",
        "render sphere --threads 0",
        "render sphere -q -v",
        "info",
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, 2, "{line}: {}", run.stderr);
        assert!(run.stdout.is_empty() && !run.stderr.is_empty(), "{line}");
    }
}

#[test]
fn an_error_is_one_json_line_where_json_is_asked_for() {
    let folder = Folder::new();
    for (line, code, word) in [
        ("render shpere --json", 3, "shpere"),
        ("render sphere --set a=b --json", 2, "a=b"),
        ("render sphere --sise 8 --json", 2, "--sise"),
        ("--json", 2, ""),
    ] {
        let run = folder.run(line);
        assert_eq!(run.code, code, "{}", run.stderr);
        let lines: Vec<&str> = run.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "{line}: {}", run.stderr);
        let error: serde_json::Value = serde_json::from_str(lines[0]).expect("a JSON line");
        assert_eq!(error["code"], code, "{error}");
        let message = error["message"].as_str().expect("a message");
        assert!(message.contains(word) && !message.contains('\n'), "{error}");
        assert!(
            error["help"].is_string() || error["help"].is_null(),
            "{error}"
        );
    }
}

#[test]
fn a_picture_that_cannot_be_written_fails_before_it_is_drawn() {
    let folder = Folder::new();
    folder.write("file", "");
    std::fs::create_dir(folder.path("folder.png")).expect("a folder");
    for target in ["nowhere/out.png", "file/out.png", "folder.png"] {
        let line = format!("render sphere --cells 100 --size 8 -q -o {target}");
        let (error, _) = folder.run(&line).failed(1);
        assert!(
            error.contains("cannot write") && error.contains(target),
            "{error}"
        );
    }
    assert_eq!(folder.files(), ["file", "folder.png"]);
}

// `tetrascope algorithms | head -1` closes the pipe before all is written.
#[test]
fn a_closed_pipe_is_no_error() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let child = program()
        .arg("algorithms")
        .stdout(writer)
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn help_documents_the_exit_codes() {
    let folder = Folder::new();
    let run = folder.run("--help").succeeded();
    for line in [
        "0  done",
        "2  wrong usage",
        "3  input",
        "4  no suitable GPU",
    ] {
        assert!(run.stdout.contains(line), "{line}: {}", run.stdout);
    }
    let version = folder.run("--version").succeeded().stdout;
    assert_eq!(
        version.trim(),
        concat!("tetrascope ", env!("CARGO_PKG_VERSION"))
    );
    insta::assert_snapshot!(
        "help-render",
        folder.run("render --help").succeeded().stdout
    );
}
