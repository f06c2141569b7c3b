//! The arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use tetrascope::choose::Need;
use tetrascope::cli::{Global, SceneArgs};

const NOTES: &str = "\
Pieces of a .pvtu, .vtm or .pvd file and clusters of a .tsc file are spread over ranks by their bytes, and each
rank reads its own. `tetrascope pack` makes a .tsc file of any mesh.

Exit codes are those of `tetrascope`; 101 after a fault of the program.

Examples:
  mpirun -n 4 tetrascope-mpi render mesh.pvtu -o mesh.png
  mpirun -n 64 tetrascope-mpi render mesh.tsc --memory 4GB --threads 2 --size 2048";

/// Draws meshes that many processes have in parts, started by mpirun.
#[derive(Parser)]
#[command(name = "tetrascope-mpi", version, after_help = NOTES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    #[command(flatten)]
    pub(crate) global: Global,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Draw a mesh and write the picture, as `tetrascope render` does
    Render(RenderArgs),
}

#[derive(Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    /// A quality setting of raycast-cpu; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Memory of each rank for its part of the mesh and what rays gather in it, as 2GB or 512MB; pieces that stay in memory may
    /// take as much again
    #[arg(long, value_name = "SIZE", value_parser = Need::parse_memory, default_value = "2GB", allow_hyphen_values = true)]
    pub(crate) memory: u64,
    /// Exchange tiles in rounds of at most this many ranks [default: all at once]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(2..))]
    pub(crate) radix: Option<u16>,
    /// Where to write: .png (sRGB), .exr or .npy (linear floats) [default: NAME.png here]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// CPU threads of each rank
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), default_value_t = 1)]
    pub(crate) threads: u16,
    /// Draw the picture so many times; measures are those of the fastest
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1000), default_value_t = 1)]
    pub(crate) repeat: u16,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    use super::*;

    #[test]
    fn the_options_are_consistent() {
        Cli::command().debug_assert();
    }
}
