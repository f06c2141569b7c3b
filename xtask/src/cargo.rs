//! `cargo`, started from here.

use std::io::ErrorKind;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use tetrascope::core::Error;

/// `cargo COMMAND` on the workspace in `root`.
pub(crate) fn cargo(root: &Path, command: &str) -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut cargo = Command::new(cargo);
    cargo
        .arg(command)
        .arg("--manifest-path")
        .arg(root.join("Cargo.toml"));
    // What the `cargo` that runs this program has told it is not for another one.
    for (name, _) in std::env::vars_os() {
        let is_packages = name.to_string_lossy().starts_with("CARGO_PKG_");
        if is_packages || name == "CARGO_MANIFEST_DIR" || name == "CARGO_MANIFEST_PATH" {
            cargo.env_remove(name);
        }
    }
    cargo
}

/// The number of the signal by which somebody has asked this program to end, such as by Ctrl-C or
/// `kill`; 0 before.
///
/// Once this is called, the program goes on after such a signal, until it has put away
/// what it left and ends by itself.
///
/// # Errors
/// The system does not let signals be handled.
fn interruptions() -> Result<Arc<AtomicUsize>, Error> {
    let number = Arc::new(AtomicUsize::new(0));
    #[cfg(unix)]
    for signal in [
        signal_hook::consts::SIGINT,
        signal_hook::consts::SIGTERM,
        signal_hook::consts::SIGHUP,
    ] {
        let noted = Arc::clone(&number);
        let handled = signal_hook::flag::register_usize(signal, noted, signal as usize);
        handled.map_err(|source| Error::Io {
            action: "cannot handle signals of",
            path: "xtask".into(),
            source,
        })?;
    }
    Ok(number)
}

/// Does what ends at a signal by itself, as [`finish`] does, and has put away what it left; then the program ends by
/// that signal.
///
/// # Errors
/// Those of `run`; the system does not let signals be handled.
pub(crate) fn ended_by_signals<T>(
    run: impl FnOnce(&AtomicUsize) -> Result<T, Error>,
) -> Result<T, Error> {
    let interrupted = interruptions()?;
    let done = run(&interrupted);
    #[cfg(unix)]
    match interrupted.load(Ordering::Relaxed) {
        0 => {}
        signal => tetrascope::signals::end_by(signal as i32),
    }
    done
}

/// Runs a command to its end, or ends it where `interrupted` is set; how it ended.
///
/// # Errors
/// It cannot be started, or was interrupted.
pub(crate) fn finish(
    command: &mut Command,
    interrupted: &AtomicUsize,
) -> Result<ExitStatus, Error> {
    let child = command
        .spawn()
        .map_err(|source| not_started(command, source))?;
    wait(child, interrupted).map_err(|source| not_started(command, source))
}

fn wait(mut child: Child, interrupted: &AtomicUsize) -> std::io::Result<ExitStatus> {
    loop {
        if interrupted.load(Ordering::Relaxed) != 0 {
            _ = child.kill();
            child.wait()?;
            return Err(ErrorKind::Interrupted.into());
        }
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A program that does not run.
pub(crate) fn not_started(command: &Command, source: std::io::Error) -> Error {
    Error::Io {
        action: "cannot run",
        path: command.get_program().into(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_is_ended_by_an_interruption() {
        // Cargo itself: it is there wherever this test runs, and ends soon if nobody ends it.
        let mut slow = cargo(crate::machine::root(), "metadata");
        slow.stdout(std::process::Stdio::null());
        slow.stderr(std::process::Stdio::null());
        let error = finish(&mut slow, &AtomicUsize::new(2)).expect_err("it is interrupted");
        let Error::Io { source, .. } = error else {
            panic!("another error: {error}");
        };
        assert_eq!(source.kind(), ErrorKind::Interrupted);
    }

    #[test]
    fn a_program_that_is_not_there_is_named() {
        let mut missing = Command::new("no program is called this");
        let error = finish(&mut missing, &AtomicUsize::new(0)).expect_err("it is missing");
        assert!(
            error.to_string().contains("cannot run no program"),
            "{error}"
        );
    }
}
