//! `cargo xtask fuzz`: libFuzzer over the readers, the scene parser and the mesh builder.
//!
//! 1. [`build`] makes a program of each target of `fuzz/guided`, with the nightly toolchain.
//! 2. Each runs for some seconds ([`turn`]): first what `fuzz/corpora` and earlier runs have
//!    found worth keeping, then changes of it. A fault ends its target.
//! 3. What each did is read from what it printed ([`Count::of`]): a table, and with `--record`
//!    sums in `fuzz/README.md`.
//! 4. With `--minimise` the corpora are made anew ([`minimise`]).
//!
//! Seeds, inputs, logs and faults are in `target/fuzz`.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use tetrascope::core::Error;

use crate::cargo::{cargo, ended_by_signals, finish, not_started};
use crate::machine::{root, target};
use crate::output::print;

/// Options of `cargo xtask fuzz`.
#[derive(clap::Args)]
pub struct Options {
    /// How long each target runs
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    seconds: u64,
    /// Only these targets [default: all]
    #[arg(value_name = "TARGET")]
    targets: Vec<String>,
    /// Make the corpora in fuzz/corpora anew of all that was found
    #[arg(long)]
    minimise: bool,
    /// Add executions to the sums in fuzz/README.md
    #[arg(long)]
    record: bool,
}

/// The most memory of a process. An input's own is counted by the target: see the
/// documentation of `tetrascope_io`.
const MEGABYTES: u64 = 1024;

/// Seconds that one input may take.
const TIME_LIMIT: u64 = 10;

/// Runs the targets; whether no fault was found.
///
/// # Errors
/// A tool that is missing, a target that does not exist, a program that does not build or run, an
/// interruption.
pub fn run(options: &Options) -> Result<bool, Error> {
    ended_by_signals(|interrupted| run_until(interrupted, options))
}

fn run_until(interrupted: &AtomicUsize, options: &Options) -> Result<bool, Error> {
    check_tools()?;
    let names = targets(&options.targets, interrupted)?;
    let place = Place::new()?;
    let programs = build(interrupted)?;
    guide(&place, interrupted)?;
    let mut counts = Vec::new();
    for name in &names {
        if interrupted.load(Ordering::Relaxed) != 0 {
            break;
        }
        eprintln!("{name} for {} s", options.seconds);
        let count = turn(&place, &programs.join(name), name, options, interrupted)?;
        counts.push((name.clone(), count));
    }
    print(&table(&counts))?;
    if options.record {
        record(&counts)?;
    }
    if interrupted.load(Ordering::Relaxed) != 0 {
        return Ok(true);
    }
    if options.minimise {
        for name in &names {
            minimise(&place, &programs.join(name), name, interrupted)?;
        }
    }
    let faults: u64 = counts.iter().map(|(_, count)| count.faults).sum();
    if faults > 0 {
        eprintln!("{faults} faults, in {}", place.faults().display());
    }
    Ok(faults == 0)
}

/// Folders of `target/fuzz`.
struct Place {
    folder: PathBuf,
}

impl Place {
    fn new() -> Result<Place, Error> {
        let place = Place {
            folder: target().join("fuzz"),
        };
        for folder in [place.faults(), place.guide(), place.folder.join("logs")] {
            fs::create_dir_all(&folder).map_err(io("cannot make", &folder))?;
        }
        Ok(place)
    }

    fn faults(&self) -> PathBuf {
        self.folder.join("faults")
    }

    /// Seeds, words and lengths.
    fn guide(&self) -> PathBuf {
        self.folder.join("guide")
    }

    /// The bytes of a target's longest input. What is longer is read more slowly, and finds
    /// little more.
    fn longest(&self, name: &str) -> Result<u64, Error> {
        let path = self.guide().join(format!("{name}.len"));
        let text = fs::read_to_string(&path).map_err(io("cannot read", &path))?;
        text.trim()
            .parse()
            .map_err(|_| failed(format!("{} holds no number", path.display())))
    }

    /// All inputs that were worth keeping.
    fn found(&self, name: &str) -> PathBuf {
        self.folder.join("corpora").join(name)
    }

    /// How many faults of a target are kept.
    fn kept(&self, name: &str) -> u64 {
        let files = fs::read_dir(self.faults()).into_iter().flatten().flatten();
        let start = format!("{name}-");
        let kept = files.filter(|file| {
            let file = file.file_name();
            let rest = file
                .to_string_lossy()
                .strip_prefix(&start)
                .map(str::to_owned);
            rest.is_some_and(|rest| {
                let mut kinds = ["crash-", "oom-", "timeout-", "leak-"].iter();
                kinds.any(|kind| rest.starts_with(kind))
            })
        });
        kept.count() as u64
    }
}

/// The corpus of a target that the tests read, too.
fn corpus(name: &str) -> PathBuf {
    root().join("fuzz/corpora").join(name)
}

fn io(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Error {
    move |source| Error::Io {
        action,
        path: path.to_owned(),
        source,
    }
}

fn failed(what: String) -> Error {
    Error::Invalid { what, help: None }
}

/// `cargo` of the nightly toolchain, which alone builds the targets.
fn nightly() -> Command {
    let mut command = Command::new("rustup");
    command.args(["run", "nightly", "cargo"]);
    for name in ["CARGO", "RUSTUP_TOOLCHAIN", "RUSTC", "RUSTDOC"] {
        command.env_remove(name);
    }
    command
}

/// Says in one line what to type if something is missing.
fn check_tools() -> Result<(), Error> {
    let mut version = nightly();
    version.args(["fuzz", "--version"]);
    version.stdout(Stdio::null()).stderr(Stdio::null());
    if version.status().is_ok_and(|status| status.success()) {
        return Ok(());
    }
    Err(Error::Invalid {
        what: "fuzzing needs the nightly toolchain and cargo-fuzz".into(),
        help: Some(
            "type `rustup toolchain install nightly --profile minimal && cargo install cargo-fuzz --locked`; a C++ compiler is needed, too"
                .into(),
        ),
    })
}

/// The targets of these names, or all.
fn targets(wanted: &[String], interrupted: &AtomicUsize) -> Result<Vec<String>, Error> {
    let lines = tempfile::NamedTempFile::new().map_err(io("cannot make", Path::new("a file")))?;
    let copy = lines.reopen().map_err(io("cannot open", lines.path()))?;
    let mut list = cargo(root(), "run");
    list.args(["--quiet", "--package", "tetrascope-fuzz", "--", "targets"]);
    list.stdout(Stdio::from(copy));
    if !finish(&mut list, interrupted)?.success() {
        return Err(failed("the targets cannot be listed".into()));
    }
    let text = fs::read_to_string(lines.path()).map_err(io("cannot read", lines.path()))?;
    let all: Vec<String> = text.lines().map(str::to_owned).collect();
    if let Some(unknown) = wanted.iter().find(|name| !all.contains(name)) {
        return Err(Error::Usage {
            what: format!("there is no target '{unknown}'"),
            help: Some(format!("the targets are {}", all.join(", "))),
        });
    }
    Ok(match wanted {
        [] => all,
        wanted => wanted.to_vec(),
    })
}

/// Builds all targets; the folder with their programs.
fn build(interrupted: &AtomicUsize) -> Result<PathBuf, Error> {
    let built = match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => PathBuf::from(folder),
        None => target(),
    };
    let built = built.join("guided");
    let mut build = nightly();
    build.args(["fuzz", "build", "--fuzz-dir"]);
    build.arg(root().join("fuzz/guided"));
    // There is no unsafe code of ours for a sanitizer to watch, and without one it is faster.
    build.args(["--sanitizer", "none", "--target-dir"]);
    build.arg(&built).stdout(Stdio::null());
    if !finish(&mut build, interrupted)?.success() {
        return Err(failed("the targets do not build".into()));
    }
    // cargo-fuzz always names the platform that it builds for.
    let platforms = fs::read_dir(&built).map_err(io("cannot read", &built))?;
    let folders = platforms
        .flatten()
        .map(|entry| entry.path().join("release"));
    let mut folders = folders.filter(|folder| folder.join("vtu").is_file());
    folders
        .next()
        .ok_or_else(|| failed(format!("no targets in {}", built.display())))
}

/// Writes seeds, words and lengths.
fn guide(place: &Place, interrupted: &AtomicUsize) -> Result<(), Error> {
    let mut write = cargo(root(), "run");
    write.args(["--quiet", "--package", "tetrascope-fuzz", "--", "guide"]);
    write.arg(place.guide());
    match finish(&mut write, interrupted)?.success() {
        true => Ok(()),
        false => Err(failed("the seeds cannot be written".into())),
    }
}

/// A folder for the files that targets read, in memory if possible.
fn scratch() -> Result<tempfile::TempDir, Error> {
    let memory = Path::new("/dev/shm");
    let folder = match memory.is_dir() {
        true => tempfile::tempdir_in(memory),
        false => tempfile::tempdir(),
    };
    folder.map_err(io("cannot make", Path::new("a folder")))
}

/// Runs a target for its time.
fn turn(
    place: &Place,
    program: &Path,
    name: &str,
    options: &Options,
    interrupted: &AtomicUsize,
) -> Result<Count, Error> {
    let scratch = scratch()?;
    let found = place.found(name);
    let known = corpus(name);
    for folder in [&found, &known] {
        fs::create_dir_all(folder).map_err(io("cannot make", folder))?;
    }
    let words = place.guide().join(format!("{name}.dict"));
    let log = place.folder.join("logs").join(format!("{name}.txt"));
    let output = File::create(&log).map_err(io("cannot write", &log))?;
    let mut command = Command::new(program);
    command.args([&found, &known, &place.guide().join(name)]);
    // An empty dictionary is an error.
    if fs::metadata(&words).is_ok_and(|words| words.len() > 0) {
        command.arg(format!("-dict={}", words.display()));
    }
    command.arg(format!("-max_total_time={}", options.seconds));
    command.arg(format!("-timeout={TIME_LIMIT}"));
    command.arg(format!("-rss_limit_mb={MEGABYTES}"));
    command.arg(format!("-max_len={}", place.longest(name)?));
    command.arg(format!(
        "-artifact_prefix={}/{name}-",
        place.faults().display()
    ));
    // Where the time goes is the readers: bookkeeping of entropies halves the speed.
    command.args(["-print_final_stats=1", "-entropic=0"]);
    command.env("TMPDIR", scratch.path());
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.stderr(Stdio::from(output));
    let before = place.kept(name);
    let started = Instant::now();
    let mut child = command
        .spawn()
        .map_err(|source| not_started(&command, source))?;
    let status = loop {
        let ended = child.try_wait();
        if let Some(status) = ended.map_err(|source| not_started(&command, source))? {
            break status;
        }
        // Ctrl-C reaches the child, too, which then prints what it has done; a signal to this
        // process alone does not.
        if interrupted.load(Ordering::Relaxed) != 0 {
            std::thread::sleep(Duration::from_secs(1));
            _ = child.kill();
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let text = fs::read(&log).map_err(io("cannot read", &log))?;
    let mut count = Count::of(&String::from_utf8_lossy(&text), started.elapsed());
    let kept = place.kept(name).saturating_sub(before);
    let is_ended = status.success() || (interrupted.load(Ordering::Relaxed) != 0);
    // One that left no file is a fault, too.
    count.faults = kept.max(u64::from(!is_ended));
    Ok(count)
}

/// Counts of a target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Count {
    /// Inputs.
    pub executions: u64,
    /// How long it ran.
    pub seconds: f64,
    /// Edges of the program that some input covers.
    pub edges: u64,
    /// Inputs that are worth keeping.
    pub corpus: u64,
    /// Greatest resident set of the process, megabytes.
    pub megabytes: u64,
    /// Inputs with a panic, too much memory, too much time, or an empty message.
    pub faults: u64,
}

impl Count {
    /// From libFuzzer's output: lines as `#1234 NEW cov: 5 ft: 6 corp: 7/89b exec/s: 1 rss: 2Mb`.
    pub fn of(log: &str, ran: Duration) -> Count {
        let mut count = Count {
            seconds: ran.as_secs_f64(),
            ..Count::default()
        };
        for line in log.lines() {
            if let Some(rest) = line.strip_prefix("stat::") {
                let (key, value) = rest.split_once(':').unwrap_or_default();
                let value = value.trim().parse().unwrap_or(0);
                match key {
                    "number_of_executed_units" => count.executions = value,
                    "peak_rss_mb" => count.megabytes = count.megabytes.max(value),
                    _ => {}
                }
            }
            let Some(rest) = line.strip_prefix('#') else {
                continue;
            };
            let words: Vec<&str> = rest.split_whitespace().collect();
            let Some(executions) = words.first().and_then(|word| word.parse().ok()) else {
                continue;
            };
            count.executions = count.executions.max(executions);
            let after = |key: &str| {
                let at = words.iter().position(|word| *word == key)?;
                let word = words.get(at + 1)?;
                let digits = word.find(|c: char| !c.is_ascii_digit());
                word[..digits.unwrap_or(word.len())].parse::<u64>().ok()
            };
            count.edges = after("cov:").unwrap_or(count.edges);
            count.corpus = after("corp:").unwrap_or(count.corpus);
            count.megabytes = count.megabytes.max(after("rss:").unwrap_or(0));
        }
        count
    }
}

/// A line for each target, and their sum.
pub fn table(counts: &[(String, Count)]) -> String {
    let mut text = String::from(
        "| target | executions | executions/s | edges | corpus | greatest RSS, MB | faults |\n|---|---|---|---|---|---|---|\n",
    );
    let mut all = Count::default();
    for (name, count) in counts {
        let Count {
            executions,
            seconds,
            edges,
            corpus,
            megabytes,
            faults,
        } = count;
        let speed = *executions as f64 / seconds.max(1e-3);
        text += &format!(
            "| {name} | {executions} | {speed:.0} | {edges} | {corpus} | {megabytes} | {faults} |\n"
        );
        all.executions += executions;
        all.seconds += seconds;
        all.corpus += corpus;
        all.megabytes = all.megabytes.max(*megabytes);
        all.faults += faults;
    }
    let speed = all.executions as f64 / all.seconds.max(1e-3);
    text += &format!(
        "| all | {} | {speed:.0} | | {} | {} | {} |\n",
        all.executions, all.corpus, all.megabytes, all.faults
    );
    text
}

/// How the table of sums begins.
const SUMS: &str = "| target | code | executions | edges |\n|---|---|---|---|\n";

/// Adds executions to the sums in `fuzz/README.md`, those of each version of the code apart.
fn record(counts: &[(String, Count)]) -> Result<(), Error> {
    let path = root().join("fuzz/README.md");
    let text = fs::read_to_string(&path).map_err(io("cannot read", &path))?;
    let code = version()?;
    let new = counts.iter().map(|(name, count)| {
        let key = (name.clone(), code.clone());
        (key, (count.executions, count.edges))
    });
    let recorded = recorded(&text, new)
        .ok_or_else(|| failed(format!("{} has no table of executions", path.display())))?;
    fs::write(&path, recorded).map_err(io("cannot write", &path))
}

/// The last change of what is fuzzed.
fn version() -> Result<String, Error> {
    let mut log = Command::new("git");
    log.current_dir(root());
    log.args(["log", "-1", "--format=%h", "--"]);
    log.args(["crates/core/src", "crates/io/src", "crates/scene/src"]);
    let output = log.output().map_err(|source| not_started(&log, source))?;
    let version = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    match version.is_empty() {
        true => Err(failed("git does not say which version this is".into())),
        false => Ok(version),
    }
}

/// Target and version.
type Key = (String, String);

/// `text` with its table of sums, to which executions are added; edges are the most.
fn recorded(text: &str, new: impl Iterator<Item = (Key, (u64, u64))>) -> Option<String> {
    let (before, rest) = text.split_once(SUMS)?;
    let length = rest
        .lines()
        .take_while(|line| line.starts_with('|'))
        .count();
    let end: usize = rest.split_inclusive('\n').take(length).map(str::len).sum();
    let (lines, after) = rest.split_at(end);
    let mut sums: BTreeMap<Key, (u64, u64)> = BTreeMap::new();
    let old = lines.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, name, code, executions, edges, _] = cells[..] else {
            return None;
        };
        let numbers = (executions.parse().ok()?, edges.parse().ok()?);
        Some(((name.to_owned(), code.to_owned()), numbers))
    });
    for (key, (executions, edges)) in old.chain(new).filter(|((name, _), _)| name != "all") {
        let sum = sums.entry(key).or_default();
        *sum = (sum.0 + executions, sum.1.max(edges));
    }
    let mut table = String::from(SUMS);
    for ((name, code), (executions, edges)) in &sums {
        table += &format!("| {name} | {code} | {executions} | {edges} |\n");
    }
    let all: u64 = sums.values().map(|(executions, _)| executions).sum();
    table += &format!("| all | | {all} | |\n");
    Some(format!("{before}{table}{after}"))
}

/// The most bytes of a corpus in the repository.
const CORPUS_BYTES: u64 = 110_000;

/// Makes a corpus anew: the fewest inputs that cover the edges that all cover, as libFuzzer finds
/// them; of fewer bytes each where they would be too many together.
fn minimise(
    place: &Place,
    program: &Path,
    name: &str,
    interrupted: &AtomicUsize,
) -> Result<(), Error> {
    let folder = corpus(name);
    let all = [place.found(name), folder.clone(), place.guide().join(name)];
    let mut longest = place.longest(name)?;
    loop {
        let scratch = scratch()?;
        let (short, merged) = (scratch.path().join("short"), scratch.path().join("merged"));
        for made in [&short, &merged] {
            fs::create_dir_all(made).map_err(io("cannot make", made))?;
        }
        for from in &all {
            for file in files(from)? {
                let size = fs::metadata(&file).map_or(u64::MAX, |metadata| metadata.len());
                let to = short.join(file.file_name().unwrap_or_default());
                if size <= longest {
                    fs::copy(&file, &to).map_err(io("cannot copy", &file))?;
                }
            }
        }
        let mut merge = Command::new(program);
        merge.args(["-set_cover_merge=1", "-use_counters=0"]);
        merge.args([&merged, &short]);
        merge.arg(format!("-max_len={longest}"));
        merge.env("TMPDIR", scratch.path());
        merge.stdout(Stdio::null()).stderr(Stdio::null());
        if !finish(&mut merge, interrupted)?.success() {
            return Err(failed(format!("the corpus of {name} cannot be minimised")));
        }
        let kept = files(&merged)?;
        let sizes = kept
            .iter()
            .map(|file| fs::metadata(file).map_or(0, |m| m.len()));
        let bytes: u64 = sizes.sum();
        if bytes > CORPUS_BYTES && longest > 1 {
            longest = longest * 3 / 4;
            continue;
        }
        for old in files(&folder)? {
            fs::remove_file(&old).map_err(io("cannot remove", &old))?;
        }
        for file in &kept {
            let to = folder.join(file.file_name().unwrap_or_default());
            fs::copy(file, &to).map_err(io("cannot write", &to))?;
        }
        let count = kept.len();
        eprintln!("{name}: {count} inputs of up to {longest} bytes, {bytes} bytes");
        return Ok(());
    }
}

/// The files in a folder.
fn files(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let entries = fs::read_dir(folder).map_err(io("cannot read", folder))?;
    let files = entries.flatten().map(|entry| entry.path());
    Ok(files.filter(|path| path.is_file()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "INFO: Seed: 1\n#2\tINITED cov: 7 ft: 8 corp: 1/1b exec/s: 0 rss: 29Mb\n\
        #131072\tpulse  cov: 1004 ft: 1737 corp: 354/32Kb lim: 1024 exec/s: 7388 rss: 34Mb\n\
        #450671\tDONE   cov: 1010 ft: 1737 corp: 355/32Kb lim: 1024 exec/s: 7388 rss: 34Mb\n\
        stat::number_of_executed_units: 450671\nstat::peak_rss_mb:              38\n";

    #[test]
    fn counts_are_read_from_what_libfuzzer_prints() {
        let count = Count::of(LOG, Duration::from_secs(10));
        let expected = Count {
            executions: 450_671,
            seconds: 10.0,
            edges: 1010,
            corpus: 355,
            megabytes: 38,
            faults: 0,
        };
        assert_eq!(count, expected);
        // Killed, it says no more than this.
        let cut = LOG.split("#450671").next().expect("it is there");
        assert_eq!(Count::of(cut, Duration::ZERO).executions, 131_072);
        assert_eq!(Count::of("", Duration::ZERO), Count::default());
        let table = table(&[("raw".into(), expected)]);
        assert!(table.contains("| raw | 450671 | 45067 | 1010 | 355 | 38 | 0 |"));
        assert!(table.contains("| all | 450671 | 45067 | | 355 | 38 | 0 |"));
    }

    #[test]
    fn executions_of_each_version_are_added_apart() {
        let key = |code: &str| ("raw".to_owned(), code.to_owned());
        let text = format!("before\n\n{SUMS}after\n");
        let once = recorded(&text, [(key("a"), (5, 7))].into_iter()).expect("a table");
        let more = [(key("a"), (6, 3)), (key("b"), (1, 1))];
        let twice = recorded(&once, more.into_iter()).expect("a table");
        let expected = format!(
            "before\n\n{SUMS}| raw | a | 11 | 7 |\n| raw | b | 1 | 1 |\n| all | | 12 | |\nafter\n"
        );
        assert_eq!(twice, expected);
        assert_eq!(recorded("no table", [].into_iter()), None);
    }
}
