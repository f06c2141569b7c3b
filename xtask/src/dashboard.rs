//! The history of benchmarks as one page: how times change over revisions, error against time,
//! and the papers' tables beside the same here.
//!
//! [`criterion`] reads what `cargo bench` has left, [`history`] keeps it, [`trend`] draws it over
//! the runs, [`precision`] has the diagrams of the last comparison, [`papers`] the papers' numbers,
//! and [`page`] puts all of them together.

pub mod criterion;
pub mod history;
pub mod page;
pub mod papers;
pub mod precision;
pub mod trend;

use std::path::PathBuf;
use std::process::Command;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, SystemTime};

use tetrascope::Context;
use tetrascope::core::Error;
use tetrascope_benches::results;

use crate::cargo::{cargo, finish};
use crate::machine::{describe, root, target};
use crate::output::write;
use crate::setup;
use criterion::Measurement;
use history::{History, Place};

/// Options of `cargo xtask dashboard`.
#[derive(clap::Args)]
pub struct Options {
    /// Run the benchmarks first, or those whose names contain FILTER
    #[arg(long, value_name = "FILTER", num_args = 0..=1)]
    run: Option<Option<String>>,
    /// The history of measurements [default: target/dashboard/history.json]
    #[arg(long, value_name = "FILE")]
    history: Option<PathBuf>,
    /// The folder of index.html [default: target/dashboard]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Adds what was measured to the history, and writes the page.
///
/// # Errors
/// Nothing was measured; a history that is not one; files that cannot be written; benchmarks that
/// fail.
pub fn run(options: &Options) -> Result<(), Error> {
    let folder = target().join("dashboard");
    let path = options.history.clone();
    let path = path.unwrap_or_else(|| folder.join("history.json"));
    // What cannot be kept is not measured.
    let mut history = History::read(&path)?;
    if let Some(filter) = &options.run {
        measure(filter.as_deref())?;
    }
    let results = criterion::read(&results::folder());
    for path in &results.unreadable {
        eprintln!("not a result of criterion: {}", path.display());
    }
    let context = Context::new();
    let description = describe(context.gpu().map(|gpu| gpu.describe()), 0);
    let machine = Place::from(&description.machine);
    let [before, now] = around(&results.measurements, committed());
    let old = history.add(None, machine.clone(), &before);
    let new = history.add(description.program.revision, machine, &now);
    if old + new > 0 {
        history.write(&path)?;
    }
    // What was measured is kept by now; a comparison that cannot be read is only not shown.
    let compared = precision::read(&target().join("compare").join("report.json"));
    let precision = compared.unwrap_or_else(|error| {
        eprintln!("without diagrams: {error}");
        None
    });
    let papers = papers::shown(&results);
    let Some(html) = page::to_html(&history, precision.as_ref(), &papers) else {
        return Err(Error::Usage {
            what: format!("nothing was measured in {}", results::folder().display()),
            help: Some("run the benchmarks with `cargo xtask dashboard --run`".into()),
        });
    };
    let page = options.out.as_ref().unwrap_or(&folder).join("index.html");
    write(&page, html)?;
    eprintln!("{} new measurements in {}", old + new, path.display());
    if old > 0 {
        eprintln!("{old} of them are older than this revision, and kept without one");
    }
    eprintln!("wrote {}", page.display());
    Ok(())
}

/// Runs the benchmarks.
fn measure(filter: Option<&str>) -> Result<(), Error> {
    if let Err(error) = setup::setup() {
        eprintln!("{error}; measuring on the CPU alone");
    }
    let mut bench = cargo(root(), "bench");
    bench.args(["--package", "tetrascope-benches"]);
    bench.args(["--bench", "*", "--"]).args(filter);
    match finish(&mut bench, &AtomicUsize::new(0))?.success() {
        true => Ok(()),
        false => Err(Error::Invalid {
            what: "a benchmark has failed".into(),
            help: None,
        }),
    }
}

/// The measurements before a time, and those since.
fn around(all: &[Measurement], time: Option<SystemTime>) -> [Vec<Measurement>; 2] {
    let is_before = |m: &&Measurement| time.is_some_and(|time| m.measured < time);
    let (before, since): (Vec<_>, Vec<_>) = all.iter().partition(is_before);
    [before, since].map(|part| part.into_iter().cloned().collect())
}

/// When the revision that is checked out was committed: what is older was not measured with it.
fn committed() -> Option<SystemTime> {
    let mut git = Command::new("git");
    git.current_dir(root()).args(["log", "-1", "--format=%ct"]);
    let output = git.output().ok().filter(|output| output.status.success())?;
    let seconds = String::from_utf8(output.stdout).ok()?.trim().parse().ok()?;
    Some(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use history::tests::measured;

    #[test]
    fn what_is_older_than_the_revision_is_not_of_it() {
        let all = [
            measured("a/b/c/build", 1.0, 5),
            measured("a/b/c/frame", 1.0, 9),
        ];
        let at = |second| Some(SystemTime::UNIX_EPOCH + Duration::from_secs(second));
        let [before, since] = around(&all, at(9));
        assert_eq!(
            (before.as_slice(), since.as_slice()),
            (&all[..1], &all[1..])
        );
        let [before, since] = around(&all, None);
        assert_eq!((before.len(), since.len()), (0, 2));
    }
}
