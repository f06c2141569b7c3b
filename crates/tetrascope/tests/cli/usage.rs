//! Tests of wrong requests, and of what the surroundings refuse.

use std::process::Stdio;

use super::program::{Folder, program};

#[test]
fn an_unknown_algorithm_or_setting_lists_the_valid_ones() {
    let folder = Folder::new();
    let (error, help) = folder.run("render sphere --algorithm refrence").failed(2);
    assert!(error.contains("valid: reference"), "{error}");
    assert_eq!(help, "  help: did you mean 'reference'?");
    let (error, _) = folder
        .run("render sphere --algorithm reference --set order=best")
        .failed(2);
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

/// Options with a value, each with values that are wrong.
const WRONG_VALUES: [(&str, &[&str]); 27] = [
    ("--error", &["0", "-1e-3", "nan", "small"]),
    ("--budget", &["16", "0ms", "-1s", "soon"]),
    ("--memory", &["2", "0GB", "-1MB", "much"]),
    ("--algorithm", &["", "refrence"]),
    ("--set", &["a=b", "a", "="]),
    ("--output", &["a.jpg", "a"]),
    ("--threads", &["0", "-1", "1025", "x"]),
    ("--steps", &["", "3", "4..3", "a..b", "1..2"]), // the last: not of a data set
    ("--model", &["glow", ""]),
    (
        "--size",
        &[
            "0x0",
            "0",
            "8x0",
            "65537x1",
            "65536x65536",
            "65536x4096",
            "-1x4",
            "8x",
            "1e2",
        ],
    ),
    ("--camera", &["fit+w", ""]),
    ("--colormap", &["jet"]),
    ("--range", &["1,0", "nan,5", "0,inf", "1", "a,b", "0,1,2"]),
    ("--unit-distance", &["0", "-1", "nan", "inf", "x"]),
    ("--isovalue", &["nan", "-inf", "x"]),
    ("--depth-cue", &["-0.1", "1.1", "nan"]),
    (
        "--clip",
        &["0,0,0", "0,0,0,0,0,0", "0,0,0,nan,0,1", "inf,0,0,1,0,0"],
    ),
    (
        "--background",
        &["-1,0,0", "nan,0,0", "1e39,0,0", "1,1,1,2", "red", "#12"],
    ),
    (
        "--cells",
        &[
            "0",
            "-1",
            "18446744073709551615",
            "18446744073709551616",
            "x",
        ],
    ),
    ("--seed", &["-1", "x"]),
    ("--curved", &["0", "-1", "nan", "inf", "x", "1e-3"]),
    (
        "--dims",
        &[
            "2x2",
            "0x1x2",
            "1x2x2",
            "-2x2x2",
            "2x2x99999999999999999999",
        ],
    ),
    ("--type", &["u9"]),
    ("--byte-order", &["middle"]),
    ("--interpolation", &["cubic", ""]),
    ("--step", &["-1", "x", "0", "18446744073709551616"]),
    ("--time", &["nan", "inf", "x", "0"]),
];
/// Options that go with `--dims` and `--type` alone.
const WRONG_RAW_VALUES: [(&str, &[&str]); 3] = [
    (
        "--spacing",
        &["1,1", "0,1,1", "-1,1,1", "nan,1,1", "1,1,inf"],
    ),
    ("--origin", &["1,1", "nan,1,1", "1,1,inf"]),
    ("--offset", &["-1", "x", "18446744073709551616"]),
];
/// Options whose value is a name of the user's: any is right in itself.
const NAMES: [&str; 3] = ["--solution", "--field", "--scene"];
/// Options without a value.
const FLAGS: [&str; 9] = [
    "--recalibrate",
    "--orthographic",
    "--resume",
    "--each-step",
    "--json",
    "--quiet",
    "--verbose",
    "--help",
    "--version",
];

#[test]
fn every_wrong_value_of_every_option_is_wrong_usage() {
    let folder = Folder::new();
    folder.write("grid.raw", [0; 8]);
    let raw = ["grid.raw", "--dims", "2x2x2", "--type", "u8"];
    let on_a_data_set = WRONG_VALUES.map(|entry| (entry, &["sphere"][..]));
    let on_a_file = WRONG_RAW_VALUES.map(|entry| (entry, &raw[..]));
    for ((option, values), volume) in on_a_data_set.into_iter().chain(on_a_file) {
        for value in values {
            let mut arguments = vec!["render"];
            arguments.extend(volume);
            arguments.extend([option, value]);
            let run = folder.run_all(&arguments);
            let stderr = &run.stderr;
            assert_eq!(run.code, 2, "{option} {value}: {stderr}");
            let errors = stderr.lines().filter(|line| line.starts_with("error: "));
            assert_eq!(errors.count(), 1, "{option} {value}: {stderr}");
            let is_helpful = ["help: ", "--help", "give ", "valid: ", "[possible values: "];
            assert!(
                is_helpful.iter().any(|word| stderr.contains(word)),
                "{option}: {stderr}"
            );
        }
    }
    assert_eq!(folder.files(), ["grid.raw"]);
    // An option that is new has its wrong values too.
    let help = folder.run("render --help").succeeded().stdout;
    let options = help.lines().filter_map(|line| {
        let word = line
            .split_whitespace()
            .find(|word| word.starts_with("--"))?;
        let word = word.trim_end_matches('.'); // as in --verbose...
        line.trim_start().starts_with('-').then_some(word)
    });
    for option in options {
        let tables = WRONG_VALUES.iter().chain(&WRONG_RAW_VALUES);
        let known = tables.map(|(option, _)| option).chain(&NAMES).chain(&FLAGS);
        assert!(known.into_iter().any(|known| *known == option), "{option}");
    }
}

#[test]
fn options_that_do_not_go_with_the_volume_are_wrong_usage() {
    let folder = Folder::new();
    folder.write("grid.raw", [0; 8]);
    for line in [
        "grid.raw --cells 9",
        "grid.raw --seed 9",
        "grid.raw --dims 2x2x2",
        "grid.raw --type u8",
        "grid.raw --offset 2",
        "sphere --solution grid.raw",
        "sphere --dims 2x2x2 --type u8",
    ] {
        for command in ["info", "render", "print-scene"] {
            let (error, help) = folder.run(&format!("{command} {line}")).failed(2);
            assert!(!help.is_empty(), "{line}: {error}");
        }
    }
    let planes = "--clip 0,0,0,1,0,0 ".repeat(17);
    let (error, _) = folder.run(&format!("render sphere {planes}")).failed(2);
    assert!(error.contains("17 clip planes"), "{error}");
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

// A full disk, as far as the program can tell.
#[cfg(target_os = "linux")]
#[test]
fn results_that_cannot_be_printed_are_a_failure() {
    for line in [
        "--help",
        "--version",
        "render --help",
        "algorithms",
        "datasets --json",
        "info sphere --cells 100",
        "print-scene sphere --cells 100",
    ] {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let output = program()
            .args(line.split(' '))
            .stdout(full.expect("Linux has it"))
            .output()
            .expect("the program starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{line}: {stderr}");
        assert!(
            stderr.contains("cannot write standard output: No space left on device"),
            "{line}: {stderr}"
        );
    }
}

// `ulimit -f` counts blocks of 512 bytes: the picture is larger.
#[cfg(unix)]
#[test]
fn a_picture_larger_than_a_file_may_be_fails_and_leaves_nothing() {
    let folder = Folder::new();
    folder.write("out.npy", "old");
    let output = std::process::Command::new("sh")
        .args(["-c", "ulimit -f 8 && exec \"$@\"", "sh"])
        .arg(program().get_program())
        .args([
            "render", "sphere", "--cells", "100", "--size", "64", "-o", "out.npy", "-q",
        ])
        .current_dir(folder.root())
        .output()
        .expect("the shell starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("cannot write out.npy: File too large"),
        "{stderr}"
    );
    assert_eq!(folder.files(), ["out.npy"]);
    assert_eq!(folder.read("out.npy"), b"old");
}

// Linux alone lets every file be called like that.
#[cfg(target_os = "linux")]
#[test]
fn a_name_that_is_not_utf_8_works() {
    use std::os::unix::ffi::OsStrExt as _;
    let name = |bytes: &'static [u8]| std::ffi::OsStr::from_bytes(bytes);
    let folder = Folder::new();
    let path = folder.root().join(name(b"a\xff.raw"));
    std::fs::write(&path, [1, 2, 3, 4, 5, 6, 7, 8]).expect("it is writable");
    for command in [
        "info",
        "info --json",
        "print-scene",
        "render --size 8",
        "render --size 8 --json",
    ] {
        let output = program()
            .args(command.split(' '))
            .arg(name(b"a\xff.raw"))
            .args(["--dims", "2x2x2", "--type", "u8"])
            .current_dir(folder.root())
            .output()
            .expect("the program starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{command}: {stderr}");
    }
    assert!(folder.root().join(name(b"a\xff.png")).exists());
    for extension in ["exr", "npy"] {
        let mut picture = name(b"b\xfe.").to_owned();
        picture.push(extension);
        let output = program()
            .args([
                "render", "sphere", "--cells", "100", "--size", "8", "--json", "-o",
            ])
            .arg(&picture)
            .current_dir(folder.root())
            .output()
            .expect("the program starts");
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        assert!(folder.root().join(&picture).exists());
    }
}

// The encoder's order of attributes differs from process to process.
#[test]
fn the_same_scene_gives_the_same_file_in_every_format() {
    let folder = Folder::new();
    for extension in ["png", "exr", "npy"] {
        let draw = |name: &str| {
            let line = format!("render sphere --cells 100 --size 8 -o {name}.{extension}");
            folder.run(&line).succeeded();
            folder.read(&format!("{name}.{extension}"))
        };
        assert!(draw("first") == draw("second"), "{extension}");
    }
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

// Nothing that is asked for is passed over in silence.
#[test]
fn a_setting_that_changes_nothing_is_said() {
    let folder = Folder::new();
    let line = "render sphere --cells 100 --size 8 --set tolerance=0.1";
    let stderr = folder.run(line).succeeded().stderr;
    assert!(
        stderr.contains("`tolerance` is for regular grids, and changes nothing here"),
        "{stderr}"
    );
    let shown = stderr.lines().find(|line| line.starts_with("preparing"));
    assert_eq!(shown, Some("preparing raycast-cpu stop-opacity=1"));
}
