//! What `cargo xtask` starts.
//!
//! `test` runs here: it builds and runs the tests and nothing else. Every other
//! command goes to the `xtask` binary, which is built in release because it
//! measures. This file uses the standard library alone and compiles in a second.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus};

const HELP: &str = "\
The harness of Tetrascope.

Usage: cargo xtask COMMAND [ARGUMENT]...

  setup      look for a graphics adapter; install a software one if there is none
  test       set up, then run every test (arguments go to `cargo test`)
  compare    draw scenes with every algorithm; error against time, in target/compare
  bless      accept the pictures of the last snapshot test

`cargo xtask COMMAND --help` says more.";

const TEST_HELP: &str = "\
Set up a graphics adapter and run every test.

Usage: cargo xtask test [ARGUMENT]...

Arguments go to `cargo test --workspace`, for example `cargo xtask test -- --nocapture`
or `cargo xtask test --test snapshots`. The exit status is that of cargo.

Without an adapter, tests that need one say that they are skipped; with the
environment variable CI set, a missing adapter is a failure.";

fn main() -> ExitCode {
    let mut arguments = env::args_os().skip(1);
    let command = arguments.next();
    let rest: Vec<OsString> = arguments.collect();
    match command.as_ref().and_then(|c| c.to_str()) {
        None | Some("help" | "--help" | "-h") => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        Some("test") if rest.iter().any(|a| a == "--help" || a == "-h") => {
            println!("{TEST_HELP}");
            ExitCode::SUCCESS
        }
        Some("test") => test(&rest),
        Some(_) => {
            let mut cargo = cargo("run");
            cargo.args(["--release", "--package", "xtask", "--bin", "xtask", "--"]);
            cargo.args(command).args(rest);
            code(run(cargo))
        }
    }
}

/// Builds the tests, sets an adapter up, runs the tests.
fn test(rest: &[OsString]) -> ExitCode {
    // What comes before `--` chooses what to build, what comes after is for the tests.
    let chosen = rest.split(|a| a == "--").next().unwrap_or_default();
    say("1/3 building the tests");
    let mut build = cargo("test");
    build.args(["--workspace", "--no-run"]).args(chosen);
    let status = run(build);
    if !status.success() {
        return code(status);
    }

    say("2/3 looking for a graphics adapter");
    let mut setup = cargo("run");
    setup.args(["--quiet", "--package", "xtask", "--bin", "xtask"]);
    setup.args(["--", "setup"]);
    // Tests of several crates were built together, so their `xtask` may be at hand.
    let built = env::current_exe().map(|front| front.with_file_name(exe("xtask")));
    if let Ok(built) = built
        && built.is_file()
    {
        setup = child(&built);
        setup.arg("setup");
    }
    let found = run(setup);
    if !found.success() && env::var_os("CI").is_some() {
        say("CI is set, so a missing graphics adapter is a failure");
        return code(found);
    }
    if !found.success() {
        say("no graphics adapter: tests that need one will say that they are skipped");
    }

    say("3/3 running the tests");
    let mut tests = cargo("test");
    tests.arg("--workspace").args(rest);
    code(run(tests))
}

/// `cargo COMMAND` on this workspace, from wherever it was started.
fn cargo(command: &str) -> Command {
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut cargo = child(Path::new(&cargo));
    cargo
        .arg(command)
        .arg("--manifest-path")
        .arg(root().join("Cargo.toml"));
    cargo
}

/// A process in an environment in which Mesa finds what it wants without a session.
fn child(program: &Path) -> Command {
    let mut command = Command::new(program);
    if cfg!(unix) && env::var_os("XDG_RUNTIME_DIR").is_none() {
        match private_folder() {
            Ok(folder) => _ = command.env("XDG_RUNTIME_DIR", folder),
            Err(error) => say(&format!("no folder for XDG_RUNTIME_DIR: {error}")),
        }
    }
    command
}

/// A folder under the build folder that only this user can enter.
///
/// Mesa complains where `XDG_RUNTIME_DIR` is unset, as it is without a login
/// session; it asks for a folder of mode 0700.
fn private_folder() -> std::io::Result<PathBuf> {
    let front = env::current_exe()?;
    let folder = front.with_file_name("xdg-runtime");
    std::fs::create_dir_all(&folder)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o700))?;
    }
    Ok(folder)
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("this package is in a folder of the repository")
}

fn exe(name: &str) -> String {
    format!("{name}{}", env::consts::EXE_SUFFIX)
}

fn run(mut command: Command) -> ExitStatus {
    command.status().unwrap_or_else(|error| {
        say(&format!(
            "cannot start {:?}: {error}",
            command.get_program()
        ));
        std::process::exit(1)
    })
}

fn code(status: ExitStatus) -> ExitCode {
    // Ended by a signal: there is no code to pass on.
    let code = status.code().unwrap_or(1);
    ExitCode::from(u8::try_from(code).unwrap_or(1))
}

fn say(phase: &str) {
    eprintln!("xtask: {phase}");
}
