//! Runs the program in a folder of its own.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// A folder that is gone with the test, and in which the program runs.
pub(crate) struct Folder(tempfile::TempDir);

/// The result of a run.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// The program, without what the surroundings could change about it.
pub(crate) fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tetrascope"));
    command.env_remove("RUST_LOG").env("NO_COLOR", "1");
    command
}

impl Folder {
    pub(crate) fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Folder {
        fs::write(self.path(name), bytes).expect("the folder can be written");
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The names of the files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).expect("the folder can be read");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("readable").file_name())
            .map(|name| name.to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs the program here; `line` is split at spaces.
    pub(crate) fn run(&self, line: &str) -> Run {
        self.run_all(&line.split_whitespace().collect::<Vec<&str>>())
    }

    pub(crate) fn run_all(&self, arguments: &[&str]) -> Run {
        let output = program()
            .current_dir(self.0.path())
            .args(arguments)
            .output()
            .expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("the program prints UTF-8");
        Run {
            code: output.status.code().expect("no signal ends the program"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// The folder's name, as it would appear in messages.
    pub(crate) fn root(&self) -> &Path {
        self.0.path()
    }
}

impl Run {
    /// The run, which must have succeeded.
    #[track_caller]
    pub(crate) fn succeeded(self) -> Run {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }

    /// The error's line and its help, after checking that there is nothing else
    /// and that nothing panicked.
    #[track_caller]
    pub(crate) fn failed(self, code: i32) -> (String, String) {
        let Run { stdout, stderr, .. } = &self;
        assert_eq!(self.code, code, "{stderr}");
        assert!(stdout.is_empty(), "{stdout}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        let mut errors = stderr.lines().filter(|line| line.starts_with("error: "));
        let error = errors.next().expect("an error line");
        assert_eq!(errors.next(), None, "one error line: {stderr}");
        let mut after = stderr.lines().skip_while(|line| *line != error).skip(1);
        let help = after.next().unwrap_or_default();
        assert!(
            help.is_empty() || help.starts_with("  help: "),
            "help follows the error: {stderr}"
        );
        assert_eq!(after.next(), None, "nothing follows the help: {stderr}");
        (error.into(), help.into())
    }

    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}", self.stdout))
    }
}
