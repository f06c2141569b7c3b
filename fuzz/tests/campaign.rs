//! A short campaign of the driver, and the driver itself.

use std::process::{Command, Output};

fn fuzz(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fuzz"));
    let keep = concat!(env!("CARGO_TARGET_TMPDIR"), "/findings");
    command.arg("run").args(arguments).args(["--keep", keep]);
    command.output().expect("the driver starts")
}

#[test]
fn no_reader_fails_on_mutated_files() {
    let output = fuzz(&["--inputs", "12000", "--seed", "7", "--seconds", "60"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("| vtu | 500 |"), "{text}");
}

// Were they counted as nothing, the test above could not fail.
#[test]
fn every_way_to_fail_is_counted() {
    let output = fuzz(&["--inputs", "20", "--self-test", "--seconds", "5"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let mut expected = vec![
        "input 3: panic: ",
        "input 5: abort: ",
        "input 7: time-out: ",
        "input 11: message: ",
    ];
    if cfg!(target_os = "linux") {
        expected.push("input 9: memory: ");
    }
    for finding in &expected {
        assert_eq!(text.matches(finding).count(), 1, "{finding}: {text}");
    }
    let lines = text.lines().filter(|line| line.starts_with("input "));
    assert_eq!(lines.count(), expected.len(), "{text}");
}
