use std::sync::mpsc;
use std::time::Duration;

use super::*;

/// In a process of its own, as it removes what every test of the process is writing.
#[test]
fn what_is_being_written_is_gone_when_the_program_ends() {
    let program = std::env::current_exe().expect("this one");
    let test = "whole_file::tests::a_program_ends";
    let run = std::process::Command::new(program)
        .args(["--exact", test, "--ignored", "--nocapture"])
        .output()
        .expect("it runs");
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    let failed = String::from_utf8_lossy(&run.stderr);
    assert!(
        run.status.success() && said.contains("1 passed"),
        "{said}{failed}"
    );
}

#[test]
#[ignore = "another test runs it alone"]
fn a_program_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let count = || std::fs::read_dir(folder.path()).expect("readable").count();
    let path = folder.path().join("a");
    std::fs::write(&path, "old").expect("writable");
    let other = TemporaryFolder::new().expect("a folder");
    std::fs::write(other.path().join("b"), "b").expect("writable");
    let (done, waiting) = mpsc::channel();
    let writer = {
        let path = path.clone();
        move || {
            let written = write_file(&path, b"new");
            // The receiver waits for it.
            let _ = done.send(written);
        }
    };
    let written = write_with(&path, |file| {
        file.write_all(b"half of it")?;
        assert_eq!(count(), 2, "a temporary file beside the old one");
        let thread = remove_temporary_files_and(|| {
            assert_eq!(count(), 1, "the old file alone");
            assert!(!other.path().exists());
            // Nothing is written in the meantime, however long that is.
            let thread = std::thread::spawn(writer);
            let answer = waiting.recv_timeout(Duration::from_millis(100));
            assert!(answer.is_err(), "a file while the program ends");
            assert_eq!(count(), 1);
            thread
        });
        // The program did not end after all: others go on.
        thread.join().expect("no panic");
        Ok(())
    });
    // Another file may not take the name of the one that was removed.
    written.expect_err("its temporary file is gone");
    assert!(waiting.recv().expect("sent").is_ok());
    assert_eq!(std::fs::read(&path).expect("there"), b"new");
    assert_eq!(count(), 1);
    drop(other);
    assert!(pending().is_empty() || pending().iter().all(|p| !p.starts_with(folder.path())));
}

#[test]
fn nothing_is_noted_of_what_is_written_or_given_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a");
    let own = || {
        pending()
            .iter()
            .filter(|p| p.starts_with(folder.path()))
            .count()
    };
    write_file(&path, b"a").expect("writable");
    let beside = folder.path().join("b");
    std::fs::create_dir(&beside).expect("writable");
    // Both are complete before the second cannot take its name.
    write_files(&[(&path, b"a"), (&beside, b"b")]).expect_err("a folder is in the way");
    let failed = write_with(&path, |_| Err(std::io::Error::other("no room")));
    failed.expect_err("it failed");
    check_writable(&path).expect("writable");
    drop(TemporaryFolder::new().expect("a folder"));
    assert_eq!(own(), 0);
    assert_eq!(
        std::fs::read_dir(folder.path()).expect("readable").count(),
        2
    );
}
