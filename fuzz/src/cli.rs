//! The command line.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::{Args, Parser, Subcommand};

use crate::campaign::{self, Plan, Tally};
use crate::worker::{self, Work};
use crate::{seeds, targets};

/// Mutated files for every reader
#[derive(Parser)]
#[command(after_help = "Exit status: 0 nothing found, 1 failure or findings.")]
struct Arguments {
    #[command(subcommand)]
    command: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Read many inputs and count what becomes of them
    Run(RunArgs),
    /// Write the files of one input, to look at or to read with the program
    Write(WriteArgs),
    /// Read every seed as it is, and say which of them are refused
    Seeds,
    /// Write each guided target's seeds and words to FOLDER
    Guide {
        /// Gets a folder and a `.dict` file for each target
        folder: PathBuf,
    },
    /// Print the names of the guided targets
    Targets,
    /// What `run` starts
    #[command(hide = true)]
    Worker(Inputs),
}

#[derive(Args)]
struct Inputs {
    /// Chooses all mutations
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The first input
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// How many inputs
    #[arg(long, default_value_t = 100_000)]
    inputs: u64,
    /// Misbehave in every way once instead of reading
    #[arg(long, hide = true)]
    self_test: bool,
}

#[derive(Args)]
struct RunArgs {
    #[command(flatten)]
    inputs: Inputs,
    /// Processes at a time [default: one per processor]
    #[arg(long)]
    workers: Option<usize>,
    /// Seconds that one input may take
    #[arg(long, default_value_t = 10)]
    seconds: u64,
    /// Where the files of findings are kept
    #[arg(long, default_value = "target/fuzz")]
    keep: PathBuf,
}

#[derive(Args)]
struct WriteArgs {
    /// The campaign's seed
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The input
    index: u64,
    /// The folder to write to
    folder: PathBuf,
}

/// The program `tetrascope-fuzz`: reads its arguments, and does what they ask for.
pub fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Task::Run(args) => run(&args),
        Task::Write(args) => {
            worker::write_input(args.seed, args.index, &args.folder).map(|()| true)
        }
        Task::Seeds => worker::seeds().map(|()| true),
        Task::Guide { folder } => targets::write_seeds(&folder).map(|()| true),
        Task::Targets => {
            targets::TARGETS
                .iter()
                .for_each(|target| println!("{}", target.name));
            Ok(true)
        }
        Task::Worker(args) => worker::run(&Work {
            seed: args.seed,
            inputs: args.first..args.first + args.inputs,
            self_test: args.self_test,
        })
        .map(|()| true),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// True if nothing was found.
fn run(args: &RunArgs) -> std::io::Result<bool> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let plan = Plan {
        seed: args.inputs.seed,
        first: args.inputs.first,
        inputs: args.inputs.inputs,
        workers: args.workers.unwrap_or(processors),
        limit: Duration::from_secs(args.seconds),
        self_test: args.inputs.self_test,
    };
    let started = Instant::now();
    let tally = campaign::run(plan)?;
    let seconds = started.elapsed().as_secs_f64();
    print(&tally, &seeds::kinds()?)?;
    println!(
        "seed {}, inputs {} to {}, {seconds:.0} s, {:.0} inputs per second",
        plan.seed,
        plan.first,
        plan.first + plan.inputs,
        plan.inputs as f64 / seconds
    );
    if !plan.self_test {
        campaign::keep(plan, &tally.findings, &args.keep)?;
    }
    Ok(tally.findings.is_empty())
}

/// The counts as a table, then the findings.
fn print(tally: &Tally, kinds: &[seeds::Kind]) -> std::io::Result<()> {
    const WHATS: [&str; 5] = ["panic", "abort", "time-out", "memory", "message"];
    println!(
        "| kind | inputs | read | refused | panics | aborts | time-outs | memory | messages | greatest memory, MB |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|");
    for (index, kind) in kinds.iter().enumerate() {
        let count = tally.counts.get(&index).copied().unwrap_or_default();
        let of_kind = |what: &str| {
            let findings = tally.findings.iter();
            let findings = findings.filter(|f| f.index % kinds.len() as u64 == index as u64);
            findings.filter(|f| f.what == what).count()
        };
        let found = WHATS.map(|what| of_kind(what).to_string()).join(" | ");
        // Those that ended their process have no line of their own.
        let ended = (of_kind("abort") + of_kind("time-out")) as u64;
        println!(
            "| {} | {} | {} | {} | {found} | {} |",
            kind.name,
            count.read + count.refused + ended,
            count.read,
            count.refused - of_kind("panic") as u64,
            count.megabytes
        );
    }
    for finding in &tally.findings {
        println!(
            "input {}: {}: {}",
            finding.index, finding.what, finding.detail
        );
    }
    Ok(())
}
