//! `cargo xtask test --adapter`: which driver the tests get.

use std::path::Path;
use std::process::{Command, Output};

use tetrascope_testing::say;
use xtask::testing::algorithms;

/// Runs the front with a `cargo` that says what it is asked, and on which adapter.
fn front(folder: &Path, arguments: &[&str]) -> Output {
    use std::os::unix::fs::PermissionsExt as _;
    let cargo = folder.join("cargo");
    let script = "#!/bin/sh\necho \"$WGPU_ADAPTER_NAME|$VK_DRIVER_FILES|$*\"\n";
    std::fs::write(&cargo, script).expect("writable");
    let executable = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(&cargo, executable).expect("ours");
    Command::new(env!("CARGO_BIN_EXE_front"))
        .args(arguments)
        .env("CARGO", &cargo)
        .env_remove("WGPU_ADAPTER_NAME")
        .env_remove("VK_DRIVER_FILES")
        .output()
        .expect("it starts")
}

/// The arguments of the last `cargo test`.
fn last(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut lines = text
        .lines()
        .filter(|line| line.contains("test --manifest-path"));
    lines.next_back().unwrap_or_default().to_owned()
}

#[cfg(unix)]
#[test]
fn tests_run_on_the_adapter_that_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    for arguments in [
        &["test", "--adapter"][..],
        &["test", "--adapter="],
        &["test", "--adapter", "--"],
    ] {
        let run = front(folder.path(), arguments);
        assert_eq!(run.status.code(), Some(2), "{arguments:?}");
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(said.contains("--adapter needs a name"), "{said}");
    }
    // After `--` it is for the tests.
    if !algorithms("tests_run_on_the_adapter_that_is_named")
        .iter()
        .any(|a| a.needs_gpu)
    {
        return;
    }
    let run = front(folder.path(), &["test", "--test", "cli", "--", "--adapter"]);
    assert!(last(&run).starts_with("||test "), "{run:?}");
    assert!(
        last(&run).ends_with("--workspace --test cli -- --adapter"),
        "{run:?}"
    );
    // A part of a name, as `tetrascope adapters` lists it.
    let name = tetrascope::gpu::adapters()[0].name.clone();
    let part = name.split(' ').next().expect("a word");
    for arguments in [
        &["test", "--adapter", part, "--test", "cli"][..],
        &["test", "--test", "cli", &format!("--adapter={part}")],
    ] {
        let run = front(folder.path(), arguments);
        assert!(run.status.success(), "{run:?}");
        let told = last(&run);
        assert!(told.starts_with(&format!("{part}||test ")), "{told}");
        assert!(told.ends_with("--workspace --test cli"), "{told}");
    }
    // What is not there is a failure before any test.
    let run = front(folder.path(), &["test", "--adapter", "no such adapter"]);
    assert_eq!(run.status.code(), Some(4), "{run:?}");
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(said.contains("none is called 'no such adapter'"), "{said}");
    assert!(!last(&run).starts_with("no such adapter"), "{run:?}");
    // SwiftShader by the file of its driver, where it is installed: nothing is installed here.
    let file = Path::new("/usr/lib/chromium/vk_swiftshader_icd.json");
    if !file.exists() {
        say("skipped: tests on SwiftShader: it is not installed");
        return;
    }
    let run = front(
        folder.path(),
        &["test", "--adapter", "SwiftShader", "--test", "cli"],
    );
    assert!(run.status.success(), "{run:?}");
    assert!(
        last(&run).starts_with(&format!("|{}|test ", file.display())),
        "{run:?}"
    );
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(said.contains("SwiftShader"), "{said}");
}
