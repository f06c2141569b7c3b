//! Many inputs: worker processes that are watched, and what became of each input.

use std::collections::BTreeMap;
use std::io::{self, BufRead as _, BufReader};
use std::ops::Range;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use crate::MEMORY;
use crate::worker::Work;

/// The plan of a campaign.
#[derive(Clone, Copy)]
pub(crate) struct Plan {
    pub(crate) seed: u64,
    pub(crate) first: u64,
    pub(crate) inputs: u64,
    pub(crate) workers: usize,
    /// For one input.
    pub(crate) limit: Duration,
    pub(crate) self_test: bool,
}

/// A fault that an input has shown.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Finding {
    pub(crate) index: u64,
    /// "panic", "abort", "time-out", "memory" or "message".
    pub(crate) what: &'static str,
    pub(crate) detail: String,
}

/// How many inputs of a kind ended how.
#[derive(Clone, Copy, Default)]
pub(crate) struct Count {
    pub(crate) read: u64,
    pub(crate) refused: u64,
    /// The most memory of one input, megabytes.
    pub(crate) megabytes: u64,
}

#[derive(Default)]
pub(crate) struct Tally {
    pub(crate) counts: BTreeMap<usize, Count>,
    pub(crate) findings: Vec<Finding>,
}

/// Inputs that one worker process reads before the next takes over.
const TURN: u64 = 2000;

/// Address space of a worker beyond [`MEMORY`]: the program itself and what an allocator
/// sets aside.
const OWN_SPACE: u64 = 128 << 20;

/// Reads all inputs; prints how far it is about once a minute.
pub(crate) fn run(plan: Plan) -> io::Result<Tally> {
    let tally = Mutex::new(Tally::default());
    let next = AtomicU64::new(plan.first);
    let end = plan.first + plan.inputs;
    let started = Instant::now();
    let told = AtomicU64::new(0);
    let turns = || -> io::Result<()> {
        loop {
            let from = next.fetch_add(TURN, Ordering::Relaxed);
            if from >= end {
                return Ok(());
            }
            turn(plan, from..end.min(from + TURN), &tally)?;
            let minutes = started.elapsed().as_secs() / 60;
            if told.fetch_max(minutes, Ordering::Relaxed) < minutes {
                let findings = tally.lock().expect("no thread panics").findings.len();
                let done = from + TURN - plan.first;
                eprintln!(
                    "{minutes} min: {done} of {} inputs, {findings} findings",
                    plan.inputs
                );
            }
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..plan.workers.max(1))
            .map(|_| scope.spawn(turns))
            .collect();
        threads
            .into_iter()
            .try_for_each(|thread| thread.join().expect("no thread panics"))
    })?;
    let mut tally = tally.into_inner().expect("no thread panics");
    tally.findings.sort();
    Ok(tally)
}

/// Reads `inputs` in one process, or in several where an input ends one.
fn turn(plan: Plan, mut inputs: Range<u64>, tally: &Mutex<Tally>) -> io::Result<()> {
    while !inputs.is_empty() {
        let mut child = start(&Work {
            seed: plan.seed,
            inputs: inputs.clone(),
            self_test: plan.self_test,
        })?;
        let stdout = child.stdout.take().expect("it is piped");
        let (sender, lines) = mpsc::channel();
        let reader = std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines() {
                if line.is_ok_and(|line| sender.send(line).is_err()) {
                    break;
                }
            }
        });
        let mut at = None;
        let finding = loop {
            match lines.recv_timeout(plan.limit) {
                Ok(line) => {
                    let (word, rest) = line.split_once(' ').unwrap_or((&line, ""));
                    match word {
                        "begin" => at = rest.parse().ok(),
                        "done" => break None,
                        _ => note(word, rest, &mut tally.lock().expect("no thread panics")),
                    }
                }
                Err(RecvTimeoutError::Timeout) => {
                    break Some(("time-out", format!("more than {:?}", plan.limit)));
                }
                Err(RecvTimeoutError::Disconnected) => {
                    break Some(("abort", describe(child.wait()?)));
                }
            }
        };
        let _ = child.kill();
        child.wait()?;
        let _ = reader.join();
        let Some((what, detail)) = finding else {
            return Ok(());
        };
        // Ended before its first input: that is no input's fault.
        let index = at.ok_or_else(|| io::Error::other(format!("a worker failed: {detail}")))?;
        let finding = Finding {
            index,
            what,
            detail,
        };
        tally
            .lock()
            .expect("no thread panics")
            .findings
            .push(finding);
        inputs.start = index + 1;
    }
    Ok(())
}

fn note(word: &str, rest: &str, tally: &mut Tally) {
    let mut words = rest.splitn(3, ' ');
    let mut next = || words.next().unwrap_or_default();
    match word {
        "end" => {
            let count = tally.counts.entry(next().parse().unwrap_or(0)).or_default();
            match next() {
                "read" => count.read += 1,
                _ => count.refused += 1,
            }
            count.megabytes = count.megabytes.max(next().parse().unwrap_or(0));
        }
        "finding" => {
            let index = next().parse().unwrap_or(0);
            let what = ["panic", "memory", "message"].into_iter().find({
                let word = next();
                move |known| *known == word
            });
            tally.findings.push(Finding {
                index,
                what: what.unwrap_or("message"),
                detail: next().into(),
            });
        }
        _ => {}
    }
}

fn describe(status: ExitStatus) -> String {
    status.to_string()
}

/// Starts a worker; on Linux with an address space not far above what is allowed, so
/// that memory that is asked for and not touched counts too.
fn start(work: &Work) -> io::Result<Child> {
    let program = std::env::current_exe()?;
    let mut command = if cfg!(target_os = "linux") {
        let mut shell = Command::new("sh");
        let kilobytes = (MEMORY + OWN_SPACE) / 1024;
        shell.args(["-c", "ulimit -v \"$0\" && exec \"$@\""]);
        shell.arg(kilobytes.to_string()).arg(program);
        shell
    } else {
        Command::new(program)
    };
    command
        .args(["worker", "--seed", &work.seed.to_string()])
        .args(["--first", &work.inputs.start.to_string()])
        .args([
            "--inputs",
            &(work.inputs.end - work.inputs.start).to_string(),
        ])
        // One arena and one thread: address space is then what reading takes.
        .env("MALLOC_ARENA_MAX", "1")
        .env("RAYON_NUM_THREADS", "1")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null());
    if work.self_test {
        command.arg("--self-test");
    }
    command.spawn()
}

/// Writes each finding's files to a folder of its own in `folder`.
pub(crate) fn keep(plan: Plan, findings: &[Finding], folder: &Path) -> io::Result<()> {
    /// A mistake that many inputs meet is known from a few.
    const MOST: usize = 100;
    for finding in findings.iter().take(MOST) {
        let name = format!("{}-{}-{}", finding.what, plan.seed, finding.index);
        let folder = folder.join(name);
        crate::worker::write_input(plan.seed, finding.index, &folder)?;
        std::fs::write(folder.join("finding.txt"), &finding.detail)?;
    }
    Ok(())
}
