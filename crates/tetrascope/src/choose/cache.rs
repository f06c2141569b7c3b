//! Measurements, kept in a file.
//!
//! A file belongs to an adapter, a build profile and a number of threads, which its name tells. It
//! says which version of this crate and which driver it was measured with: of others it is
//! nothing, and written anew. It appears whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tetrascope_io::write_file;

use super::calibrate::Calibration;
use crate::Context;

/// The version of the file's format.
const FORMAT: u32 = 2;

/// Files are of some 100 kB.
const MOST_BYTES: u64 = 16 << 20;

/// Where measurements hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Machine {
    /// The adapter's name; "CPU" without one.
    adapter: String,
    /// The adapter with its driver, in words.
    driver: String,
    /// This crate's.
    version: String,
    profile: String,
    threads: usize,
}

#[derive(Serialize, Deserialize)]
struct Contents {
    format: u32,
    machine: Machine,
    calibrations: Vec<Calibration>,
}

impl Machine {
    /// This machine; makes the device.
    pub(crate) fn of(context: &Context) -> Machine {
        let (adapter, driver) = adapter(context);
        let profile = if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        };
        Machine {
            adapter,
            driver,
            version: env!("CARGO_PKG_VERSION").into(),
            profile: profile.into(),
            threads: rayon::current_num_threads(),
        }
    }

    /// The file in a folder.
    pub(crate) fn path(&self, folder: &Path) -> PathBuf {
        let Machine {
            adapter,
            profile,
            threads,
            ..
        } = self;
        let key = format!("{adapter}\n{profile}\n{threads}");
        folder.join(format!("calibration-{:016x}.json", fnv(key.as_bytes())))
    }
}

#[cfg(feature = "gpu")]
fn adapter(context: &Context) -> (String, String) {
    // Without a device, what needs one is not drawn either.
    match context.gpu() {
        Ok(gpu) => (gpu.info().name.clone(), gpu.describe()),
        Err(_) => ("CPU".into(), String::new()),
    }
}

#[cfg(not(feature = "gpu"))]
fn adapter(_: &Context) -> (String, String) {
    ("CPU".into(), String::new())
}

/// The measurements in the file of this machine: none if there is no file or it is of another version or
/// driver, and why nothing if it is damaged.
pub(crate) fn read(folder: &Path, machine: &Machine) -> Result<Vec<Calibration>, String> {
    let path = machine.path(folder);
    let damaged = |why: String| format!("{}: {why}", path.display());
    match fs::metadata(&path) {
        Err(_) => return Ok(Vec::new()),
        Ok(data) if data.len() > MOST_BYTES => return Err(damaged("it is too large".into())),
        Ok(_) => {}
    }
    let text = fs::read(&path).map_err(|error| damaged(error.to_string()))?;
    // Other formats differ in the rest, too.
    #[derive(Deserialize)]
    struct Head {
        format: u32,
    }
    let head: Head = serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
    if head.format != FORMAT {
        return Ok(Vec::new());
    }
    let contents: Contents =
        serde_json::from_slice(&text).map_err(|error| damaged(error.to_string()))?;
    match contents.machine == *machine {
        true => Ok(contents.calibrations),
        false => Ok(Vec::new()),
    }
}

/// Writes all of `calibrations` for this machine; makes the folder.
///
/// # Errors
/// In words.
pub(crate) fn write(
    folder: &Path,
    machine: &Machine,
    calibrations: &[Calibration],
) -> Result<(), String> {
    let contents = Contents {
        format: FORMAT,
        machine: machine.clone(),
        calibrations: calibrations.to_vec(),
    };
    let text = serde_json::to_vec(&contents).map_err(|error| error.to_string())?;
    let path = machine.path(folder);
    fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", path.display()))?;
    write_file(&path, &text).map_err(|error| error.to_string())
}

/// The folder for files that a program makes for itself: `$XDG_CACHE_HOME/tetrascope`, else that of
/// the system (`~/.cache`, on macOS `~/Library/Caches`, on Windows `%LOCALAPPDATA%`); `None`
/// where the environment names none.
pub fn user_cache() -> Option<PathBuf> {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from);
    let absolute = |path: &PathBuf| path.is_absolute();
    let system = || {
        if cfg!(windows) {
            return folder("LOCALAPPDATA");
        }
        let home = folder("HOME")?;
        Some(match cfg!(target_os = "macos") {
            true => home.join("Library/Caches"),
            false => home.join(".cache"),
        })
    };
    let found = folder("XDG_CACHE_HOME").filter(absolute).or_else(system);
    Some(found.filter(absolute)?.join("tetrascope"))
}

/// FNV-1a, 64 bits.
fn fnv(bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choose::calibrate::tests::made_up;

    fn machine() -> Machine {
        Machine {
            adapter: "Some GPU".into(),
            driver: "Some GPU (driver 1.2)".into(),
            version: "1.0.0".into(),
            profile: "release".into(),
            threads: 4,
        }
    }

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().expect("a folder")
    }

    #[test]
    fn what_is_written_is_read_again_to_the_last_bit() {
        let folder = folder();
        let within = folder.path().join("made/for/it");
        assert_eq!(read(&within, &machine()), Ok(Vec::new()));
        write(&within, &machine(), &[made_up()]).expect("it is written");
        assert_eq!(read(&within, &machine()), Ok(vec![made_up()]));
        let files = fs::read_dir(&within).expect("a folder").count();
        assert_eq!(files, 1, "nothing else is left there");
    }

    #[test]
    fn another_version_or_driver_has_measured_nothing_and_takes_the_file() {
        let folder = folder();
        write(folder.path(), &machine(), &[made_up()]).expect("it is written");
        let newer = Machine {
            version: "1.0.1".into(),
            ..machine()
        };
        let driver = Machine {
            driver: "Some GPU (driver 1.3)".into(),
            ..machine()
        };
        for other in [newer, driver] {
            assert_eq!(read(folder.path(), &other), Ok(Vec::new()));
            assert_eq!(other.path(folder.path()), machine().path(folder.path()));
        }
        let threads = Machine {
            threads: 2,
            ..machine()
        };
        assert_ne!(threads.path(folder.path()), machine().path(folder.path()));
        assert_eq!(read(folder.path(), &machine()), Ok(vec![made_up()]));
    }

    #[test]
    fn a_damaged_file_says_what_is_wrong() {
        let folder = folder();
        write(folder.path(), &machine(), &[made_up()]).expect("it is written");
        let path = machine().path(folder.path());
        let text = fs::read_to_string(&path).expect("it is there");
        for damaged in [&text[..text.len() / 2], "", "[]", "{\"format\": 2}"] {
            fs::write(&path, damaged).expect("it can be written");
            let why = read(folder.path(), &machine()).expect_err("it is damaged");
            assert!(why.contains("calibration-"), "{why}");
        }
        // Of a format to come, nothing is known to be damaged.
        fs::write(&path, "{\"format\": 3, \"more\": []}").expect("it can be written");
        assert_eq!(read(folder.path(), &machine()), Ok(Vec::new()));
    }

    #[test]
    fn the_hash_is_the_known_one() {
        assert_eq!(fnv(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
    }
}
