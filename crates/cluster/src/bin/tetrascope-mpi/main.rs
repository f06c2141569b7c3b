//! `tetrascope-mpi`: what `tetrascope render` draws, by many processes that `mpirun` has started.
//!
//! [`args`] says what can be typed, with the options of `tetrascope render` that choose a volume and a look; [`render`] draws;
//! [`report`] describes the picture. Rank 0 prints.

mod args;
mod render;
mod report;

use std::process::ExitCode;

use clap::Parser as _;
use tetrascope::cli::{Global, Output, exit_code, output};
use tetrascope::core::Error;
use tetrascope_cluster::mpi::Mpi;
use tetrascope_cluster::{Communicator as _, Failure};

use args::{Cli, Command};

/// Why the program ends early.
enum End {
    /// At some rank, and all know.
    Failure(Failure),
    /// Whoever read stdout has enough, or the error is printed.
    Stop(output::Stop),
}

impl From<Failure> for End {
    fn from(failure: Failure) -> End {
        End::Failure(failure)
    }
}

fn main() -> ExitCode {
    let Some(ranks) = Mpi::start() else {
        eprintln!("error: MPI cannot be started");
        return ExitCode::FAILURE;
    };
    let is_first = ranks.rank() == 0;
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        // All ranks have the same arguments.
        Err(error) if is_first => {
            return output::usage(&error).unwrap_or(ExitCode::FAILURE);
        }
        Err(error) => return ExitCode::from(if error.use_stderr() { 2 } else { 0 }),
    };
    #[cfg(unix)]
    tetrascope::cli::outlive_large_files();
    tetrascope::signals::leave_no_temporary_files();
    let output = match is_first {
        true => Output::new(&cli.global),
        false => Output::new(&Global {
            json: false,
            quiet: true,
            verbose: 0,
        }),
    };
    let Command::Render(args) = &cli.command;
    let code = match render::run(&ranks, args, &output) {
        Ok(()) => 0,
        Err(End::Failure(failure)) => {
            let code = exit_code(failure.kind);
            if is_first {
                let what = failure.to_string();
                let help = failure.help;
                output.error(&Error::Invalid { what, help }, code);
            }
            code
        }
        Err(End::Stop(output::Stop::ClosedPipe)) => 0,
        Err(End::Stop(output::Stop::Error(error))) => {
            let code = exit_code(error.kind());
            output.error(&error, code);
            code
        }
        Err(End::Stop(output::Stop::Step(_))) => unreachable!("one picture is not a series"),
    };
    ExitCode::from(code)
}
