//! The program that `cargo xtask` starts.
//!
//! `test` runs here: it builds and runs the tests and nothing else. Every other
//! command goes to the `xtask` binary, which is built in release because it
//! measures. This file uses the standard library alone and compiles in a second.

use std::env;
use std::ffi::OsString;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Stdio};

const HELP: &str = "\
The harness of Tetrascope.

Usage: cargo xtask COMMAND [ARGUMENT]...

  setup      look for a graphics adapter; install a software one if there is none
  test       set up, then run every test (arguments go to `cargo test`)
  compare    draw scenes with every algorithm; error against time, in target/compare
  stability  draw stiff and extreme cases with every algorithm; who keeps what it promises
  rays       rays by the hundred million at vertices, edges and faces: none may be lost
  dashboard  benchmarks over revisions, beside the papers' tables, in target/dashboard
  bench      benchmarks of another revision and of the working tree in turn: --against REV
  machine    simulate the machine of voxels; what bounds it, in target/machine
  figures    draw figures 3 to 6 of the paper on voxels again, in snapshots/voxel-hw
  gallery    draw the pictures of real data in docs/gallery again, and their page
  fuzz       fuzz what reads files, guided by coverage: --seconds N, in target/fuzz
  snapshots  reviewed pictures and texts: check, report, bless, dead

`cargo xtask COMMAND --help` says more.";

const TEST_HELP: &str = "\
Set up a graphics adapter and run every test.

Usage: cargo xtask test [--adapter NAME] [ARGUMENT]...

Arguments go to `cargo test --workspace`, for example `cargo xtask test -- --nocapture`
or `cargo xtask test --test snapshots`. The exit status is that of cargo.

  --adapter NAME  run the tests on this adapter alone: `swiftshader`, which is installed where
                  it may be, or a part of a name that `tetrascope adapters` lists, such as
                  `llvmpipe`; that there is none is then a failure

Unless arguments choose what to test, the libraries' own tests run beside the others, and after
them the GPU crates' tests again on a second Vulkan driver, SwiftShader; with CI set, a few of
them. What these print comes last.
`VK_DRIVER_FILES` set means that you chose a driver: then it is the only one.
The tests of the Python package need a Python with NumPy and pytest: `TETRASCOPE_PYTHON`, or one
that is found or installed.
`cargo xtask test --mpi` installs an MPI where it may, and runs the tests of `tetrascope-mpi` alone.

Without an adapter, tests that need one say that they are skipped; with the
environment variable CI set, a missing adapter or second driver is a failure.";

/// The GPU crates' own tests of pictures, by target: `gpu`'s, `projection`'s and
/// `raycast-peel`'s, `slicing`'s.
const GPU_TESTS: [&str; 3] = ["integral", "pictures", "truth"];

/// Those that draw on the second driver in CI, by parts of their names: what one driver or the
/// other has got wrong, and closed forms. Of all, `projection`'s alone take it over five minutes.
const SMALL: [&str; 6] = [
    "optics::",
    "analytic::",
    "both_traversals",
    "bodies_in_a_row_are_drawn",
    "by_planes_a_step_a_pass",
    "interpolated_parameters",
];

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
            instead(cargo)
        }
    }
}

/// Builds the tests, sets an adapter up, runs the tests, and those of the GPU crates on
/// a second driver.
fn test(rest: &[OsString]) -> ExitCode {
    let (adapter, rest) = match adapter(rest) {
        Ok(parted) => parted,
        Err(mistake) => {
            eprintln!("error: {mistake}\n\n{TEST_HELP}");
            return ExitCode::from(2);
        }
    };
    let rest = &rest[..];
    // Apart from the others, as dependencies of MPI make cargo build nearly everything anew.
    if rest.first().is_some_and(|first| first == "--mpi") {
        return match mpi() {
            true => code(run(tests_of_mpi())),
            false => ExitCode::from(4),
        };
    }
    // What comes before `--` chooses what to build, what comes after is for the tests.
    let chosen = rest.split(|a| a == "--").next().unwrap_or_default();
    let phases = if adapter.is_some() { 3 } else { 4 };
    say(&format!("1/{phases} building the tests"));
    let mut build = cargo("test");
    build.args(["--workspace", "--no-run"]).args(chosen);
    let status = run(build);
    if !status.success() {
        return code(status);
    }

    if let Some(adapter) = adapter {
        return test_on(&adapter, rest);
    }
    say("2/4 looking for a graphics adapter");
    let found = run(harness(&["setup"]));
    if !found.success() && env::var_os("CI").is_some() {
        say("CI is set, so a missing graphics adapter is a failure");
        return code(found);
    }
    if !found.success() {
        say("no graphics adapter: tests that need one will say that they are skipped");
    }

    // Its package brings the browser in which the tests look at pages, too.
    let second = match rest.is_empty() && found.success() {
        true => other_driver(),
        false => Second::NotWanted,
    };
    if matches!(second, Second::Missing) && env::var_os("CI").is_some() {
        say("CI is set, so a missing second driver is a failure");
        return ExitCode::FAILURE;
    }

    say("3/4 running the tests");
    let mut tests = cargo("test");
    tests.arg("--workspace").args(rest);
    if let Some(python) = python() {
        tests.env(PYTHON, python);
    }
    if !rest.is_empty() {
        return code(run(tests));
    }
    tests.args(["--test", "*"]);
    let mut beside = vec![libraries(&["--lib", "--bins"]), libraries(&["--doc"])];
    match &second {
        Second::Driver(driver) => {
            say("4/4 beside them, running the GPU crates' tests on a second driver");
            beside.push(on_second_driver(driver));
        }
        Second::Missing => say("no second driver: the tests run on one"),
        Second::NotWanted => {}
    }
    let (status, of_libraries) = run_beside(tests, beside);
    match status.success() {
        true => code(of_libraries),
        false => code(status),
    }
}

/// Tests in the libraries, which are built.
fn libraries(of: &[&str]) -> Command {
    let mut tests = cargo("test");
    tests.arg("--workspace").args(of);
    tests
}

/// Runs a command and, beside it, others one after the other until one fails: many tests keep one core busy, or none
/// while a browser or a disk works. The others' output comes when all have ended. How the first ended, and the last of
/// the others that ran.
fn run_beside(command: Command, others: Vec<Command>) -> (ExitStatus, ExitStatus) {
    // In a file, not in a pipe: who reads a pipe to its end waits for whatever a test has left running, too.
    let name = format!("beside-{}.log", std::process::id());
    let path = env::temp_dir().join(name);
    let written = path.clone();
    let others = std::thread::spawn(move || {
        let mut last = ExitStatus::default();
        for command in others {
            last = append(command, &written).unwrap_or_else(|error| {
                say(&format!("cannot run the tests beside the others: {error}"));
                std::process::exit(1)
            });
            if !last.success() {
                break;
            }
        }
        last
    });
    let status = run(command);
    say("waiting for the tests that run beside these");
    let last = others.join().expect("it does not panic");
    let output = std::fs::read(&path).unwrap_or_default();
    _ = std::fs::remove_file(&path);
    // Whoever closed standard output does not read it.
    _ = std::io::stdout().lock().write_all(&output);
    (status, last)
}

/// Adds what a command prints, on both of its streams, to a file.
fn append(mut command: Command, path: &Path) -> std::io::Result<ExitStatus> {
    let file = File::options().create(true).append(true).open(path)?;
    command.stdin(Stdio::null());
    command.stdout(file.try_clone()?).stderr(file);
    command.status()
}

/// The adapter behind `--adapter`, and the other arguments; or the mistake, in words.
fn adapter(arguments: &[OsString]) -> Result<(Option<OsString>, Vec<OsString>), &'static str> {
    const OPTION: &str = "--adapter";
    let mut found = None;
    let mut rest = Vec::new();
    let mut arguments = arguments.iter();
    while let Some(argument) = arguments.next() {
        let text = argument.to_string_lossy();
        let name = match text.strip_prefix(OPTION) {
            Some("") => arguments.next().cloned(),
            Some(after) if after.starts_with('=') => Some(after[1..].into()),
            _ => {
                rest.push(argument.clone());
                if text == "--" {
                    rest.extend(arguments.by_ref().cloned());
                }
                continue;
            }
        };
        let name = name.filter(|name| !name.is_empty() && name != "--");
        found = Some(name.ok_or("--adapter needs a name, such as llvmpipe or swiftshader")?);
    }
    Ok((found, rest))
}

/// Runs the tests, which are built, on one adapter.
fn test_on(adapter: &OsString, rest: &[OsString]) -> ExitCode {
    let chosen: (&str, OsString) = match adapter.eq_ignore_ascii_case(SWIFTSHADER) {
        // The loader does not know where its package has put it.
        true => match second_driver() {
            Second::Driver(driver) => ("VK_DRIVER_FILES", driver.into()),
            _ => return ExitCode::from(4),
        },
        false => ("WGPU_ADAPTER_NAME", adapter.clone()),
    };
    let (name, value) = &chosen;
    say("2/3 looking for the adapter");
    say(&format!("{name}={}", value.to_string_lossy()));
    let found = run_by(harness(&["setup"]).env(name, value));
    if !found.success() {
        return code(found);
    }
    say("3/3 running the tests");
    let mut tests = cargo("test");
    tests.arg("--workspace").args(rest).env(name, value);
    code(run(tests))
}

/// The second driver's name for `--adapter`.
const SWIFTSHADER: &str = "swiftshader";

/// A second Vulkan driver for the tests.
enum Second {
    /// The file that describes it.
    Driver(String),
    Missing,
    NotWanted,
}

/// Finds or installs a second Vulkan driver, unless one was chosen.
fn other_driver() -> Second {
    if env::var_os("VK_DRIVER_FILES").is_some() {
        say("VK_DRIVER_FILES is set, so that driver is the only one");
        return Second::NotWanted;
    }
    second_driver()
}

/// Which Python the tests of the Python package use.
const PYTHON: &str = "TETRASCOPE_PYTHON";

/// Finds or installs a Python for the tests, unless one was chosen. Without one, its tests say
/// that they are skipped; with CI set, they fail.
fn python() -> Option<String> {
    if env::var_os(PYTHON).is_some() {
        return None;
    }
    let found = harness(&["setup", "--python"])
        .stderr(Stdio::inherit())
        .output();
    let found = found.ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&found.stdout).trim().to_owned())
}

/// Finds or installs an MPI; whether there is one.
fn mpi() -> bool {
    let found = harness(&["setup", "--mpi"])
        .stderr(Stdio::inherit())
        .output();
    found.is_ok_and(|output| output.status.success())
}

/// The tests of ranks that are processes: of the whole workspace, so that what is built stays so.
fn tests_of_mpi() -> Command {
    let mut tests = cargo("test");
    tests.args(["--workspace", "--features", "tetrascope-cluster/mpi"]);
    tests.args(["--test", "mpirun", "--bin", "tetrascope-mpi"]);
    tests
}

/// Finds or installs SwiftShader.
fn second_driver() -> Second {
    let found = harness(&["setup", "--second-driver"])
        .stderr(Stdio::inherit())
        .output();
    match found {
        Ok(output) if output.status.success() => {
            Second::Driver(String::from_utf8_lossy(&output.stdout).trim().to_owned())
        }
        _ => Second::Missing,
    }
}

/// The GPU crates' tests on a second Vulkan driver, where there is one: what passes on
/// one driver may still rely on what Vulkan leaves open.
fn on_second_driver(driver: &str) -> Command {
    let is_ci = env::var_os("CI").is_some();
    say(&format!("VK_DRIVER_FILES={driver}"));
    // Of the whole workspace, as they were built: other packages would mean other features.
    let mut tests = cargo("test");
    tests.arg("--workspace").env("VK_DRIVER_FILES", driver);
    tests.args(GPU_TESTS.iter().flat_map(|name| ["--test", name]));
    match is_ci {
        true => tests.arg("--").args(SMALL),
        false => tests.arg("--lib"),
    };
    tests
}

/// A command of the `xtask` binary.
fn harness(arguments: &[&str]) -> Command {
    let built = env::current_exe().map(|front| front.with_file_name(exe("xtask")));
    let mut command = match built {
        // Tests of several crates were built together, so it may be at hand.
        Ok(built) if built.is_file() => child(&built),
        _ => {
            let mut command = cargo("run");
            command.args(["--quiet", "--package", "xtask", "--bin", "xtask", "--"]);
            command
        }
    };
    command.args(arguments);
    command
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

/// Runs a command in place of this program, so that who ends one ends the other.
fn instead(mut command: Command) -> ExitCode {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt as _;
        let error = command.exec();
        say(&format!(
            "cannot start {:?}: {error}",
            command.get_program()
        ));
        ExitCode::FAILURE
    }
    #[cfg(not(unix))]
    code(run_by(&mut command))
}

fn run(mut command: Command) -> ExitStatus {
    run_by(&mut command)
}

fn run_by(command: &mut Command) -> ExitStatus {
    command.status().unwrap_or_else(|error| {
        say(&format!(
            "cannot start {:?}: {error}",
            command.get_program()
        ));
        std::process::exit(1)
    })
}

fn code(status: ExitStatus) -> ExitCode {
    #[cfg(unix)]
    let signal = std::os::unix::process::ExitStatusExt::signal(&status);
    #[cfg(not(unix))]
    let signal: Option<i32> = None;
    // As shells say that a signal ended a program.
    let of_signal = signal.map_or(1, |signal| 128 + signal);
    let code = status.code().unwrap_or(of_signal);
    ExitCode::from(u8::try_from(code).unwrap_or(1))
}

fn say(phase: &str) {
    eprintln!("xtask: {phase}");
}
