//! The process that reads inputs, and says which one it begins, so that its end tells
//! which one ended it.
//!
//! Lines on stdout: `begin INDEX`; `end KIND WORD MEGABYTES` after it; `finding INDEX WHAT
//! DETAIL` for what went wrong; `done` at last.

use std::fs;
use std::io::{self, Write as _};
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;

use crate::mutate::Input;
use crate::reader::{Reading, explain, read};
use crate::seeds::kinds;
use crate::{MEMORY, allowed};

/// Where the panic that is being caught began.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// The inputs that are read, and how.
pub(crate) struct Work {
    pub(crate) seed: u64,
    pub(crate) inputs: Range<u64>,
    /// Misbehave on some inputs instead of reading, so that a test sees what is counted.
    pub(crate) self_test: bool,
}

pub(crate) fn run(work: &Work) -> io::Result<()> {
    std::panic::set_hook(Box::new(|info| {
        let text = info.to_string().replace('\n', " ");
        *PANIC.lock().unwrap_or_else(|poison| poison.into_inner()) = text;
    }));
    let kinds = kinds()?;
    let folder = tempfile::tempdir()?;
    let mut out = io::stdout().lock();
    for index in work.inputs.clone() {
        let input = Input::new(&kinds, work.seed, index);
        for (name, bytes) in &input.files {
            fs::write(folder.path().join(name), bytes)?;
        }
        writeln!(out, "begin {index}")?;
        out.flush()?;
        reset_peak();
        let reading = catch_unwind(AssertUnwindSafe(|| match work.self_test {
            true => misbehave(index),
            false => read(&input, folder.path()),
        }));
        let peak = peak();
        let word = match reading {
            Ok(Ok(Reading::Read)) => "read",
            Ok(Ok(Reading::Refused)) => "refused",
            Ok(Err(message)) => {
                writeln!(out, "finding {index} message {message}")?;
                "refused"
            }
            Err(_) => {
                let text = PANIC.lock().unwrap_or_else(|poison| poison.into_inner());
                writeln!(out, "finding {index} panic {text}")?;
                "failed"
            }
        };
        if peak > allowed(input.len()) {
            let (megabytes, length) = (peak / 1_000_000, input.len());
            writeln!(
                out,
                "finding {index} memory {megabytes} MB for {length} bytes"
            )?;
        }
        writeln!(out, "end {} {word} {}", input.kind, peak / 1_000_000)?;
        for (name, _) in &input.files {
            fs::remove_file(folder.path().join(name))?;
        }
    }
    writeln!(out, "done")
}

/// Reads every seed as it is; a seed that is refused at once is a weak one, unless it is of a
/// format that is refused on purpose.
pub(crate) fn seeds() -> io::Result<()> {
    let folder = tempfile::tempdir()?;
    for (index, kind) in kinds()?.iter().enumerate() {
        for (place, seed) in kind.seeds.iter().chain(&kind.heavy).enumerate() {
            let input = Input::unchanged(index, seed);
            for (name, bytes) in &input.files {
                fs::write(folder.path().join(name), bytes)?;
            }
            match explain(&input, folder.path()) {
                None => println!("{} {place}: read", kind.name),
                Some(error) => println!("{} {place}: {error}", kind.name),
            }
        }
    }
    Ok(())
}

/// Writes the files of one input to `folder`.
pub(crate) fn write_input(seed: u64, index: u64, folder: &Path) -> io::Result<()> {
    let input = Input::new(&kinds()?, seed, index);
    fs::create_dir_all(folder)?;
    for (name, bytes) in &input.files {
        fs::write(folder.join(name), bytes)?;
    }
    Ok(())
}

/// Forgets the most memory that was in use so far; Linux alone has it.
fn reset_peak() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The most memory that was in use since, bytes; 0 where it is not known.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    1024 * kilobytes.unwrap_or(0)
}

/// Each of the ways to fail, once.
fn misbehave(index: u64) -> Result<Reading, String> {
    match index {
        3 => panic!("as the test of the driver asks"),
        5 => std::process::abort(),
        7 => loop {
            std::thread::sleep(std::time::Duration::from_secs(1));
        },
        9 => {
            // Ones, as zeros would be promised and not given.
            let much = vec![1u8; MEMORY as usize + (20 << 20)];
            assert_eq!(std::hint::black_box(&much)[9], 1);
            Ok(Reading::Read)
        }
        11 => Err("a message holds the character '\\u{1b}'".into()),
        _ => Ok(Reading::Refused),
    }
}
