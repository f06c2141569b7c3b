//! The command line of Tetrascope.
//!
//! [`args`] says what can be typed; one module each runs `render`, `view`, `info`,
//! `convert`, `pack` and the lists; [`scene`] makes a scene from options; [`series`] draws several files as `render` does one;
//! [`output`](tetrascope::cli::output) is all that is printed.

mod args;
mod convert;
mod info;
mod lists;
#[cfg(any(feature = "resample", feature = "voxel-hw"))]
mod mesh;
mod need;
mod pack;
mod picture;
mod render;
#[cfg(feature = "resample")]
mod resample;
mod scene;
mod series;
#[cfg(feature = "resample")]
mod slice;
#[cfg(feature = "view")]
mod view;
#[cfg(feature = "voxel-hw")]
mod voxelize;

use std::io::IsTerminal as _;
use std::process::ExitCode;

use clap::Parser as _;
use tetrascope::cli::{exit_code, output};

use args::{Cli, Command};
use output::{Output, Stop};

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let json = std::env::args_os().any(|argument| argument == "--json");
            let output = Output::plain(json);
            return output::usage(&error).unwrap_or_else(|stop| end(stop, &output));
        }
    };
    #[cfg(all(unix, feature = "gpu"))]
    quiet_mesa();
    #[cfg(unix)]
    tetrascope::cli::outlive_large_files();
    tetrascope::signals::leave_no_temporary_files();
    let output = Output::new(&cli.global);
    log(cli.global.verbose, output.color());
    let done = match &cli.command {
        Command::Render(args) => render::run(args, &output),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args, &output),
        Command::Info(args) => info::run(args, &output),
        Command::Convert(args) => convert::run(args, &output),
        Command::Pack(args) => pack::run(args, &output),
        #[cfg(feature = "voxel-hw")]
        Command::Voxelize(args) => voxelize::voxelize(args, &output),
        #[cfg(feature = "voxel-hw")]
        Command::Machine(args) => voxelize::machine(args, &output),
        #[cfg(feature = "resample")]
        Command::Resample(args) => resample::run(args, &output),
        #[cfg(feature = "resample")]
        Command::Slice(args) => slice::run(args, &output),
        Command::PrintScene(args) => scene::run(args, &output),
        Command::Algorithms => lists::algorithms(&output),
        Command::Formats => lists::formats(&output),
        Command::Adapters => lists::adapters(&output),
        Command::Datasets => lists::datasets(&output),
        Command::Colormaps => lists::colormaps(&output),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(stop) => end(stop, &output),
    }
}

/// Says why a command ends early.
fn end(stop: Stop, output: &Output) -> ExitCode {
    match stop {
        Stop::ClosedPipe => ExitCode::SUCCESS,
        Stop::Step(step) => {
            let code = exit_code(step.error.kind());
            output.error_in(&step, code);
            ExitCode::from(code)
        }
        Stop::Error(error) => {
            let code = exit_code(error.kind());
            output.error(&error, code);
            ExitCode::from(code)
        }
    }
}

/// Starts this program anew where Mesa would complain on stderr that
/// `XDG_RUNTIME_DIR` is unset, as it is without a login, with what keeps it quiet:
/// a process cannot safely change its own environment.
#[cfg(all(unix, feature = "gpu"))]
fn quiet_mesa() {
    use std::os::unix::process::CommandExt as _;
    let (variable, value) = tetrascope::gpu::QUIET_MESA;
    let is_set = |name: &str| std::env::var_os(name).is_some();
    if is_set("XDG_RUNTIME_DIR") || is_set(variable) {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        let arguments = std::env::args_os().skip(1);
        // Returns only if it fails, and then the complaint is all that is lost.
        let _ = std::process::Command::new(program)
            .args(arguments)
            .env(variable, value)
            .exec();
    }
}

/// Sends the libraries' log to stderr; `RUST_LOG` chooses, else `-v` and `-vv`.
fn log(verbose: u8, color: bool) {
    let level = ["error", "info", "debug", "trace"][usize::from(verbose.min(3))];
    let filter = tracing_subscriber::EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new(level));
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .with_ansi(color && std::io::stderr().is_terminal())
        .init();
}
