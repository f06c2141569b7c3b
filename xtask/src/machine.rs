//! The facts on which numbers depend besides the algorithms: program, machine, inputs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{SystemTime, UNIX_EPOCH};

use sha2::{Digest as _, Sha256};
use tetrascope::core::Error;

use crate::report::{Machine, Program, REPORT_VERSION, Report};

/// The repository's root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("this package is in a folder of the repository")
}

/// Where reports and pictures of failures go, whatever cargo's own target folder.
pub fn target() -> PathBuf {
    root().join("target")
}

/// The program that runs, and how it was called.
pub fn program() -> Program {
    let arguments: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|argument| argument.to_string_lossy().into_owned())
        .collect();
    Program {
        name: "tetrascope".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        revision: revision(),
        started: utc(SystemTime::now()),
        command: format!("cargo xtask {}", arguments.join(" ")),
        build: match cfg!(debug_assertions) {
            true => "debug".into(),
            false => "release".into(),
        },
    }
}

/// A report without scenes.
pub fn describe(adapter: Result<String, Error>, repeat: u32) -> Report {
    let (adapter, no_adapter) = match adapter {
        Ok(adapter) => (Some(adapter), None),
        Err(error) => (None, Some(error.to_string())),
    };
    Report {
        version: REPORT_VERSION,
        program: program(),
        machine: Machine {
            os: std::env::consts::OS.into(),
            architecture: std::env::consts::ARCH.into(),
            processor: processor(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            adapter,
            no_adapter,
            peer: None,
        },
        repeat,
        resumed: 0,
        scenes: Vec::new(),
        scaling: Vec::new(),
        checks: Vec::new(),
    }
}

/// SHA-256 of each file, hexadecimal, by name; an unreadable one is left out, as it
/// was read a moment ago.
pub fn fingerprints(files: &[PathBuf]) -> BTreeMap<String, String> {
    let of = |path: &PathBuf| {
        let digest = Sha256::digest(std::fs::read(path).ok()?);
        let hex: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        Some((path.display().to_string(), hex))
    };
    files.iter().filter_map(of).collect()
}

fn revision() -> Option<String> {
    let mut git = Command::new("git");
    git.current_dir(root())
        .args(["describe", "--always", "--dirty", "--exclude=*"]);
    let output = git.output().ok().filter(|output| output.status.success())?;
    String::from_utf8(output.stdout)
        .ok()
        .map(|text| text.trim().to_owned())
}

fn processor() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, name)| name.trim().to_owned())
}

/// The time in UTC as RFC 3339 has it, to the second.
pub(crate) fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Days since 0000-03-01, so that leap days end their year (H. Hinnant,
    // "chrono-Compatible Low-Level Date Algorithms", civil_from_days).
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted_month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted_month + 2) / 5 + 1;
    let month = if shifted_month < 10 {
        shifted_month + 3
    } else {
        shifted_month - 9
    };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3_600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates_are_right() {
        let at = |seconds| utc(UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(at(1_735_689_599), "2024-12-31T23:59:59Z");
        assert_eq!(at(1_795_330_875), "2026-11-22T07:01:15Z");
    }

    #[test]
    fn fingerprints_are_those_of_the_bytes() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("abc");
        std::fs::write(&path, "abc").expect("writable");
        let found = fingerprints(&[path.clone(), folder.path().join("missing")]);
        assert_eq!(found.len(), 1);
        // FIPS 180-2, appendix B.1.
        assert!(found[&path.display().to_string()].starts_with("ba7816bf8f01cfea"));
    }
}
