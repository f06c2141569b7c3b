//! `render` with `--error`, `--budget` and `--memory` in place of an algorithm.

use std::fs;

use super::program::{Folder, Run, program};

const SMALL: &str = "render sphere --cells 600 --size 24x16";

/// Runs the program with a cache of its own and calibrations that take next to no time.
fn run(folder: &Folder, line: &str) -> Run {
    let output = program()
        .current_dir(folder.root())
        .env("XDG_CACHE_HOME", folder.path("cache"))
        .env("TETRASCOPE_CALIBRATION", "quick")
        .args(line.split_whitespace())
        .output()
        .expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program prints UTF-8");
    Run {
        code: output.status.code().expect("no signal ends the program"),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    }
}

/// The floats of a .npy file.
fn floats(bytes: &[u8]) -> Vec<f32> {
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let floats = bytes[start..].as_chunks::<4>().0;
    floats
        .iter()
        .map(|four| f32::from_le_bytes(*four))
        .collect()
}

fn calibration(folder: &Folder) -> std::path::PathBuf {
    let files = fs::read_dir(folder.path("cache/tetrascope")).expect("it was calibrated");
    let files: Vec<_> = files.map(|file| file.expect("readable").path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

#[test]
fn an_error_is_kept_and_machines_are_measured_once() {
    let folder = Folder::new();
    let first = run(&folder, &format!("{SMALL} --error 1e-3 -o chosen.npy")).succeeded();
    for part in ["calibrating", "chose ", "  expected ", "  came out "] {
        assert!(first.stderr.contains(part), "{part}: {}", first.stderr);
    }
    folder.run(&format!("{SMALL} -o truth.npy")).succeeded();
    let [chosen, truth] = ["chosen.npy", "truth.npy"].map(|name| floats(&folder.read(name)));
    assert_eq!(chosen.len(), 24 * 16 * 4);
    let squares = chosen
        .iter()
        .zip(&truth)
        .map(|(a, b)| f64::from(a - b).powi(2));
    let rmse = (squares.sum::<f64>() / truth.len() as f64).sqrt();
    assert!(rmse <= 1e-3, "{rmse}: {}", first.stderr);
    assert!(
        truth.iter().any(|channel| *channel > 0.1),
        "there is something to see"
    );

    // The file is used again, and made anew where it is damaged or unwanted.
    let again = run(
        &folder,
        &format!("{SMALL} --budget 100s --json -o again.png"),
    )
    .succeeded();
    let report = again.json();
    let name = report["choice"]["chosen"]["name"].as_str().expect("a name");
    assert!(
        name.starts_with(report["algorithm"].as_str().expect("a name")),
        "{report}"
    );
    assert_eq!(
        report["choice"]["gives_way"].as_array().map(Vec::len),
        Some(0)
    );
    assert!(
        report["choice"]["chosen"]["found"]["error"]["rmse"].is_number(),
        "{report}"
    );
    let path = calibration(&folder);
    let written = fs::metadata(&path)
        .and_then(|m| m.modified())
        .expect("it is there");
    let warned = run(&folder, &format!("{SMALL} --error 1e-12 -o warned.png")).succeeded();
    assert!(!warned.stderr.contains("calibrating"), "{}", warned.stderr);
    assert!(
        warned.stderr.contains("warning: the error gives way"),
        "{}",
        warned.stderr
    );
    assert_eq!(
        fs::metadata(&path)
            .and_then(|m| m.modified())
            .expect("it is there"),
        written
    );
    let (error, help) = run(&folder, &format!("{SMALL} --memory 1B -q")).failed(2);
    assert!(error.contains("no setting is expected to hold"), "{error}");
    assert!(help.contains("--memory"), "{help}");
    fs::write(&path, "{").expect("it can be written");
    let anew = run(&folder, &format!("{SMALL} --error 1e-2 -o anew.png")).succeeded();
    assert!(anew.stderr.contains("damaged") && anew.stderr.contains("calibrating"));
    assert_eq!(calibration(&folder), path);
}

#[test]
fn what_makes_no_sense_is_refused_with_what_does() {
    let folder = Folder::new();
    for (options, part) in [
        ("--budget 16", "write it like 16ms or 0.5s"),
        ("--memory 2", "write it like 2GB or 512MB"),
        ("--error -1", "such as 1e-3"),
        ("--error 1e-3 --algorithm reference", "cannot be used with"),
        ("--budget 1s --set order=centroid", "cannot be used with"),
        ("--recalibrate", "add --error, --budget or --memory"),
    ] {
        let refused = run(&folder, &format!("{SMALL} {options}"));
        assert_eq!(refused.code, 2, "{options}: {}", refused.stderr);
        assert!(
            refused.stderr.contains(part),
            "{options}: {}",
            refused.stderr
        );
    }
    assert!(folder.files().is_empty(), "{:?}", folder.files());
}

#[test]
fn a_series_is_drawn_by_what_its_first_frame_chooses() {
    let folder = Folder::new();
    for (name, height) in [("step_1.vtk", 1.0), ("step_2.vtk", 2.0)] {
        folder.write(name, super::series::mesh(height, 0.0, 1.0));
    }
    let line = "render step_*.vtk --size 16 --error 1e-12 -o frame_%d.png";
    let drawn = run(&folder, line).succeeded();
    assert_eq!(drawn.stdout, "frame_0.png\nframe_1.png\n");
    assert_eq!(
        drawn.stderr.matches("chose reference").count(),
        1,
        "{}",
        drawn.stderr
    );
    // What is there was drawn by an algorithm, which is to be named.
    let refused = run(&folder, &format!("{line} --resume"));
    assert_eq!(refused.code, 2);
    assert!(
        refused.stderr.contains("cannot be used with"),
        "{}",
        refused.stderr
    );
}
