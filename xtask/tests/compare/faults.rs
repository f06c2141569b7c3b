//! A comparison that is ended, or finds no room: it says so, leaves nothing by halves, and goes on.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use tetrascope_testing::say;

use super::{errors, read};

/// A comparison by the program, of the ground truth alone.
fn compare(out: &Path, scenes: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_xtask"));
    command.arg("compare").args(scenes);
    command
        .args(["--algorithms", "reference", "--out"])
        .arg(out);
    command.args(["--models", "emission-absorption,emission,absorption"]);
    command
}

/// All files in a folder and those in it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("readable").path();
        match path.is_dir() {
            true => found.extend(files(&path)),
            false => found.push(path),
        }
    }
    found
}

fn report(out: &Path) -> serde_json::Value {
    serde_json::from_str(&read(out.join("report.json"))).expect("JSON")
}

/// Whether there is only what is complete.
fn is_whole(out: &Path) -> bool {
    let name = |path: &PathBuf| path.to_string_lossy().into_owned();
    let is_complete = |path: &PathBuf| {
        let is_json = serde_json::from_slice::<serde_json::Value>(&fs::read(path).expect("there"));
        !name(path).contains("/.tetrascope-") && is_json.is_ok()
    };
    files(out).iter().all(is_complete)
}

#[cfg(unix)]
#[test]
fn a_comparison_that_a_signal_ends_goes_on_where_it_was() {
    use std::os::unix::process::ExitStatusExt as _;
    let folder = tempfile::tempdir().expect("a folder");
    let sized = |out: &Path| {
        let mut command = compare(out, &["sphere", "heat-sink"]);
        command.args(["--size", "96x96", "--repeat", "2"]);
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command
    };
    let out = folder.path().join("ended");
    let parts = |count: usize| {
        let done = files(&out).into_iter();
        done.filter(|file| file.extension().is_some_and(|e| e == "json"))
            .count()
            >= count
    };
    for (after, name, number) in [(1, "INT", 2), (2, "TERM", 15)] {
        let mut run = sized(&out).spawn().expect("it starts");
        while !parts(after) && run.try_wait().expect("ours").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut kill = Command::new("kill");
        let sent = kill.args(["-s", name, &run.id().to_string()]).status();
        assert!(sent.expect("it starts").success());
        let status = run.wait().expect("ours");
        assert_eq!(status.signal(), Some(number), "{status}");
        assert!(is_whole(&out), "{:?}", files(&out));
        assert!(!out.join("report.json").exists());
    }
    let run = sized(&out).output().expect("it starts");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let resumed = report(&out)["resumed"].as_u64().expect("a number");
    assert!(resumed >= 2, "{resumed}");
    let whole = folder.path().join("whole");
    assert!(sized(&whole).status().expect("it starts").success());
    assert_eq!(errors(&report(&out)), errors(&report(&whole)));
}

/// A comparison of one small scene.
fn small(out: &Path) -> Command {
    let mut command = compare(out, &["sphere"]);
    command.arg("--check");
    command
}

#[cfg(target_os = "linux")]
#[test]
fn a_comparison_without_room_says_so_and_goes_on_once_there_is_some() {
    let folder = tempfile::tempdir().expect("a folder");
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).expect("writable");
    let mount = |options: &str| {
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", options, "tmpfs"])
            .arg(&disk);
        mount.output()
    };
    match mount("size=64k") {
        Ok(done) if done.status.success() => {}
        other => {
            say(&format!(
                "skipped: a comparison without room: no small disk: {other:?}"
            ));
            return;
        }
    }
    let checked = std::panic::catch_unwind(|| {
        let out = disk.join("out");
        let run = small(&out).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{stderr}");
        assert!(stderr.contains("error: cannot write "), "{stderr}");
        assert!(stderr.contains("No space left on device"), "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        assert!(!out.join("index.html").exists());
        assert!(is_whole(&out), "{:?}", files(&out));
        let more = mount("remount,size=64m").expect("as before");
        assert!(more.status.success(), "{more:?}");
        let done = small(&out).output().expect("it starts");
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        assert!(out.join("index.html").exists());
    });
    let gone = Command::new("umount").arg(&disk).status();
    assert!(gone.expect("it starts").success());
    checked.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
}

#[cfg(target_os = "linux")]
#[test]
fn a_report_to_a_full_device_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    for option in [None, Some("--json")] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full");
        let mut command = small(folder.path());
        let run = command.args(option).stdout(full.expect("Linux has it"));
        let run = run.output().expect("it starts");
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{stderr}");
        let words = "error: cannot write standard output: No space left on device";
        assert!(stderr.contains(words), "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
}
