//! The harness's commands; see `front.rs` for `test`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tetrascope::core::{Error, ErrorKind};
use xtask::output::print;
use xtask::{
    bench, compare, dashboard, fuzz, gallery, rays, setup, snapshots, stability, sweep,
    voxel_figures,
};

/// The harness of Tetrascope
#[derive(Parser)]
#[command(
    bin_name = "cargo xtask",
    after_help = "Exit status: 0 done, 1 failure, 2 usage, 3 bad input, 4 no suitable graphics \
                  adapter, 5 an error above its bound, a case that hangs, a ray that is lost, a snapshot that is not as \
                  reviewed, a benchmark that is slower beyond noise, or an input that is a fault."
)]
struct Arguments {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Look for a graphics adapter; install a software one if there is none
    Setup {
        /// Find or install a second Vulkan driver (SwiftShader) for the tests; print its file
        #[arg(long)]
        second_driver: bool,
        /// Find or install a Python with NumPy and pytest for the tests; print its path
        #[arg(long, conflicts_with = "second_driver")]
        python: bool,
        /// Find or install an MPI for the tests of `tetrascope-mpi`; print the path of its mpirun
        #[arg(long, conflicts_with_all = ["second_driver", "python"])]
        mpi: bool,
    },
    /// Draw scenes with every algorithm: error against time
    Compare(compare::Options),
    /// Keep what benchmarks have measured, and show it over revisions, beside the papers' tables
    Dashboard(dashboard::Options),
    /// Run the benchmarks of another revision and of the working tree in turn
    Bench(bench::Options),
    /// Draw stiff and extreme cases with every algorithm: does each keep what it promises?
    Stability(stability::Options),
    /// Cast rays by the hundred million at what breaks walks from cell to cell; goes on where it was
    Rays(rays::Options),
    /// Simulate the machine of voxels: meshes, sizes, samples and machines
    Machine(sweep::Options),
    /// Draw figures 3 to 6 of Prakash and Manohar's paper again
    Figures(voxel_figures::Options),
    /// Draw the pictures of real data in docs/gallery again, and the page that shows them
    Gallery(gallery::Options),
    /// Draw a scene once and print the most memory that this took
    #[command(name = compare::peak::COMMAND, hide = true)]
    Peak { algorithm: String, setting: String },
    /// Fuzz readers, scene parser and mesh builder, guided by coverage
    Fuzz(fuzz::Options),
    /// Check reviewed pictures and texts, show what differs, accept it, find what nobody asks for
    Snapshots(snapshots::Options),
    /// The same as `snapshots bless`
    Bless,
}

/// All that was asked for is done, and something is not as it has to be.
const MISSED: u8 = 5;

fn status(is_well: bool) -> ExitCode {
    ExitCode::from(if is_well { 0 } else { MISSED })
}

fn main() -> ExitCode {
    let task = Arguments::parse().command;
    // These end what they have started first.
    if !matches!(task, Task::Bench(_) | Task::Rays(_) | Task::Fuzz(_)) {
        tetrascope::signals::leave_no_temporary_files();
    }
    match task {
        Task::Setup {
            second_driver,
            python,
            mpi,
        } if second_driver || python || mpi => match match (python, mpi) {
            (true, _) => setup::python(),
            (_, true) => setup::mpi(),
            _ => setup::second_driver(),
        } {
            Ok(file) => finish(print(&format!("{}\n", file.display())).map(|()| ExitCode::SUCCESS)),
            Err(reason) => {
                eprintln!("{reason}");
                ExitCode::from(4)
            }
        },
        Task::Setup { .. } => {
            let found = setup::setup().and_then(|adapter| print(&format!("{adapter}\n")));
            finish(found.map(|()| ExitCode::SUCCESS))
        }
        Task::Compare(options) => finish(compare::run(&options).map(status)),
        Task::Peak { algorithm, setting } => {
            let peak = compare::peak::run(&algorithm, &setting);
            let said = peak.and_then(|bytes| print(&format!("{bytes}\n")));
            finish(said.map(|()| ExitCode::SUCCESS))
        }
        Task::Dashboard(options) => finish(dashboard::run(&options).map(|()| ExitCode::SUCCESS)),
        Task::Bench(options) => finish(bench::run(&options).map(status)),
        Task::Machine(options) => finish(sweep::run(&options).map(|()| ExitCode::SUCCESS)),
        Task::Stability(options) => finish(stability::run(&options).map(status)),
        Task::Rays(options) => finish(rays::run(&options).map(status)),
        Task::Figures(options) => finish(voxel_figures::run(&options).map(|()| ExitCode::SUCCESS)),
        Task::Gallery(options) => finish(gallery::run(&options).map(|()| ExitCode::SUCCESS)),
        Task::Fuzz(options) => finish(fuzz::run(&options).map(status)),
        Task::Snapshots(options) => finish(snapshots::run(&options).map(status)),
        Task::Bless => finish(snapshots::bless().map(|()| ExitCode::SUCCESS)),
    }
}

/// What, then how to help; and the exit status for who has to act.
fn finish(result: Result<ExitCode, Error>) -> ExitCode {
    result.unwrap_or_else(|error| {
        eprintln!("error: {error}");
        if let Some(help) = tetrascope::help(&error) {
            eprintln!("help: {help}");
        }
        ExitCode::from(match error.kind() {
            ErrorKind::Failure => 1,
            ErrorKind::Usage => 2,
            ErrorKind::Input => 3,
            ErrorKind::Gpu => 4,
        })
    })
}
