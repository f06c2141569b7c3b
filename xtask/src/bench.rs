//! Two revisions' benchmarks in turn: what one is slower or faster at, beyond noise.
//!
//! 1. [`worktree`] checks the base out; its benchmarks are built there, with a target folder of
//!    their own, and those of the working tree where they always are.
//! 2. Both run in turn, round by round, so that what slows the machine slows both. Each run has a
//!    folder of criterion's results of its own.
//! 3. [`statistics`] makes a ratio and an interval of the rounds.
//!
//! All of it is in `target/against`, of which only the base's build stays.

pub mod statistics;
pub mod worktree;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicUsize;

use serde::Deserialize;
use tetrascope::core::Error;
use tetrascope_testing::data_path;

use crate::cargo::{cargo, ended_by_signals, finish, not_started};
use crate::dashboard::criterion;
use crate::dashboard::history::Verdict;
use crate::machine::{root, target};
use crate::output::print;
use crate::setup;
use statistics::Comparison;
use worktree::Worktree;

/// Options of `cargo xtask bench`.
#[derive(clap::Args)]
pub struct Options {
    /// The revision to compare the working tree with
    #[arg(long, value_name = "REV")]
    against: String,
    /// Only benchmarks whose ids contain this
    #[arg(value_name = "FILTER")]
    filter: Option<String>,
    /// Only this program of benchmarks, such as frames; may be repeated [default: all]
    #[arg(long, value_name = "NAME")]
    bench: Vec<String>,
    /// How often each runs
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(2..=100))]
    rounds: u32,
}

/// A program of benchmarks, as built from both states.
struct Pair {
    name: String,
    base: PathBuf,
    new: PathBuf,
}

/// Runs both; whether nothing is slower beyond noise.
///
/// # Errors
/// A revision that does not exist, what does not build or run, nothing that matches, an
/// interruption.
pub fn run(options: &Options) -> Result<bool, Error> {
    ended_by_signals(|interrupted| run_until(interrupted, options))
}

fn run_until(interrupted: &AtomicUsize, options: &Options) -> Result<bool, Error> {
    let base = worktree::resolve(root(), &options.against)?;
    if let Err(error) = setup::setup() {
        eprintln!("{error}; measuring on the CPU alone");
    }
    let folder = target().join("against");
    let worktree = Worktree::new(root(), &folder, &base)?;
    eprintln!("building {} and the working tree", worktree.short());
    let built = folder.join("build");
    let base = build(worktree.path(), Some(&built), &options.bench, interrupted)?;
    let new = build(root(), None, &options.bench, interrupted)?;
    let pairs = pairs(base, new)?;
    let mut rounds = Vec::new();
    for round in 0..options.rounds {
        eprintln!("round {} of {}", round + 1, options.rounds);
        let mut medians = [BTreeMap::new(), BTreeMap::new()];
        for pair in &pairs {
            eprintln!("  {}", pair.name);
            // Who is first has a cooler machine: each is in turn.
            let order = if round % 2 == 0 { [0, 1] } else { [1, 0] };
            for side in order {
                let (program, place) = match side {
                    0 => (&pair.base, worktree.path()),
                    _ => (&pair.new, root()),
                };
                let results = worktree.results().join(["base", "new"][side]);
                measure(program, place, &results, options, interrupted)?;
                let read = criterion::read(&results);
                let found = read.measurements.into_iter();
                medians[side].extend(found.map(|m| (m.id, m.median.value)));
                remove(&results)?;
            }
        }
        rounds.push(medians);
    }
    let comparisons = statistics::compare(&rounds);
    if comparisons.is_empty() {
        return Err(Error::Usage {
            what: "no benchmark of both revisions was run".into(),
            help: Some("choose another filter; `cargo bench -- --list` names benchmarks".into()),
        });
    }
    for (side, name) in ["base", "working tree"].into_iter().enumerate() {
        let alone = statistics::alone(&rounds, side);
        if !alone.is_empty() {
            eprintln!("only in the {name}: {}", alone.join(", "));
        }
    }
    print(&statistics::table(&comparisons))?;
    let count = |verdict| {
        comparisons
            .iter()
            .filter(|c| c.verdict() == verdict)
            .count()
    };
    eprintln!(
        "{} slower, {} faster, {} within noise, beside {}",
        count(Verdict::Slower),
        count(Verdict::Faster),
        count(Verdict::Within),
        worktree.short()
    );
    Ok(!comparisons.iter().any(Comparison::is_slower))
}

/// A message of `cargo --message-format=json` about something built.
#[derive(Deserialize)]
struct Message {
    reason: String,
    target: Option<BuiltTarget>,
    executable: Option<PathBuf>,
}

#[derive(Deserialize)]
struct BuiltTarget {
    name: String,
    kind: Vec<String>,
}

/// Builds the benchmarks of a checkout; programs by name.
fn build(
    checkout: &Path,
    target: Option<&Path>,
    names: &[String],
    interrupted: &AtomicUsize,
) -> Result<BTreeMap<String, PathBuf>, Error> {
    let mut build = cargo(checkout, "bench");
    build.args(["--package", "tetrascope-benches", "--no-run"]);
    build.arg("--message-format=json-render-diagnostics");
    match names {
        [] => _ = build.args(["--bench", "*"]),
        names => _ = build.args(names.iter().flat_map(|name| ["--bench", name])),
    }
    if let Some(target) = target {
        build.env("CARGO_TARGET_DIR", target);
    }
    // Lines, and not much of them, go to a file, so that waiting can be interrupted.
    let lines = tempfile::tempfile().map_err(|source| not_started(&build, source))?;
    let copy = lines
        .try_clone()
        .map_err(|source| not_started(&build, source))?;
    build.stdout(Stdio::from(copy));
    if !finish(&mut build, interrupted)?.success() {
        return Err(Error::Invalid {
            what: format!("the benchmarks in {} do not build", checkout.display()),
            help: None,
        });
    }
    let text = read_again(lines).map_err(|source| not_started(&build, source))?;
    Ok(programs(&text))
}

fn read_again(mut file: std::fs::File) -> std::io::Result<String> {
    use std::io::{Read as _, Seek as _};
    let mut text = String::new();
    file.rewind()?;
    file.read_to_string(&mut text)?;
    Ok(text)
}

fn programs(messages: &str) -> BTreeMap<String, PathBuf> {
    let parsed = messages
        .lines()
        .filter_map(|line| serde_json::from_str(line).ok());
    let built = parsed.filter(|m: &Message| m.reason == "compiler-artifact");
    let programs = built.filter_map(|m| {
        let target = m.target.filter(|target| target.kind == ["bench"])?;
        Some((target.name, m.executable?))
    });
    programs.collect()
}

fn pairs(
    mut base: BTreeMap<String, PathBuf>,
    new: BTreeMap<String, PathBuf>,
) -> Result<Vec<Pair>, Error> {
    let mut pairs = Vec::new();
    for (name, new) in new {
        match base.remove(&name) {
            Some(base) => pairs.push(Pair { name, base, new }),
            None => eprintln!("{name}: not in the base"),
        }
    }
    for name in base.into_keys() {
        eprintln!("{name}: not in the working tree");
    }
    match pairs.is_empty() {
        false => Ok(pairs),
        true => Err(Error::Usage {
            what: "no program of benchmarks is in both revisions".into(),
            help: None,
        }),
    }
}

/// Runs a program of benchmarks as cargo does, with results in a folder.
fn measure(
    program: &Path,
    checkout: &Path,
    results: &Path,
    options: &Options,
    interrupted: &AtomicUsize,
) -> Result<(), Error> {
    let mut bench = Command::new(program);
    bench
        .current_dir(checkout.join("benches"))
        .args(["--bench", "--noplot", "--quiet"])
        .args(&options.filter)
        .env("CRITERION_HOME", results)
        .stdout(Stdio::null());
    // The base is elsewhere, and its data beside the working tree.
    if std::env::var_os("TETRASCOPE_DATA").is_none() {
        bench.env("TETRASCOPE_DATA", data_path(""));
    }
    match finish(&mut bench, interrupted)?.success() {
        true => Ok(()),
        false => Err(Error::Invalid {
            what: format!("{} has failed", program.display()),
            help: None,
        }),
    }
}

fn remove(folder: &Path) -> Result<(), Error> {
    match std::fs::remove_dir_all(folder) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => Err(Error::Io {
            action: "cannot delete",
            path: folder.into(),
            source,
        }),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_benchmarks_are_found_among_cargos_messages() {
        let messages = r#"{"reason":"compiler-artifact","target":{"name":"criterion","kind":["lib"]},"executable":null}
{"reason":"compiler-artifact","target":{"name":"frames","kind":["bench"]},"executable":"/t/frames-1"}
{"reason":"build-finished","success":true}
not JSON
"#;
        let found = programs(messages);
        assert_eq!(found.len(), 1);
        assert_eq!(found["frames"], Path::new("/t/frames-1"));
    }

    #[test]
    fn only_what_both_have_is_run() {
        let of = |names: &[&str]| -> BTreeMap<String, PathBuf> {
            names
                .iter()
                .map(|n| ((*n).to_owned(), PathBuf::from(n)))
                .collect()
        };
        let both = pairs(of(&["a", "b"]), of(&["b", "c"])).expect("b is in both");
        assert_eq!(both.len(), 1);
        assert_eq!(both[0].name, "b");
        assert!(pairs(of(&["a"]), of(&["b"])).is_err());
    }
}
