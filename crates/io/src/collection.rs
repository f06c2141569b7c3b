//! Collections: files that list the files of a series, one for each step of time.
//!
//! Read are ParaView's two: `.pvd`, which is VTK XML, and `.series`, which is JSON and named
//! `NAME.vtu.series` or the like. Names start at the collection's folder and do not lead out of
//! it. Nothing is read of the files themselves, but that they are there.

mod pvd;
mod series;

use std::collections::HashSet;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use tetrascope_core::Error;

use crate::source::{KEEP_TOGETHER, Source, beside, count, open_file};
use crate::steps::{self, StepChoice};

/// A step of a series.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its file.
    pub file: PathBuf,
    /// When it is, in the collection's own unit; `None` where that is not said.
    pub time: Option<f64>,
    /// Its number in the file, from 0, where the file itself holds several steps
    /// ([`read_steps`](crate::read_steps)); `None` for one that a collection lists.
    pub number: Option<usize>,
}

/// The most bytes of a collection: some fifty thousand steps.
pub const MAX_COLLECTION_BYTES: u64 = 4 << 20;

/// The help where a collection is given for one of its files.
pub(crate) const AS_A_SERIES: &str = "give one of these files, or draw it as a series";

/// An entry of a collection as its file has it, before it is checked.
struct Entry {
    name: String,
    time: Option<f64>,
    /// Where it stands: "byte 80", "files[3]".
    at: String,
}

/// Whether the name of `path` is that of a collection.
pub fn is_collection(path: &Path) -> bool {
    matches!(crate::image::extension(path).as_str(), "pvd" | "series")
}

/// The steps that a collection lists, by time.
///
/// # Errors
/// [`Error::Io`] when it cannot be read; [`Error::Format`] when it makes no sense or is longer
/// than [`MAX_COLLECTION_BYTES`], and for what is not drawn: several files for one time, a file
/// that is listed twice, other collections, and files that are not there or not in the folder of
/// the collection.
pub fn read_collection(path: &Path) -> Result<Vec<Step>, Error> {
    let source = read(path)?;
    let entries = match crate::image::extension(path).as_str() {
        "pvd" => pvd::parse(source)?,
        _ => series::parse(&source)?,
    };
    steps(path, entries)
}

/// The files of one time of a `.pvd` file, which may be several: the parts of a step. Gives the times, too, and which of
/// them was chosen: the first without a choice.
///
/// # Errors
/// As [`read_collection`], but for several files of one time and for files that list others; [`Error::Invalid`] for
/// a step that is not there.
pub(crate) fn parts_of_step(
    path: &Path,
    choice: Option<StepChoice>,
) -> Result<(Vec<PathBuf>, Vec<f64>, usize), Error> {
    let mut entries = pvd::parse(read(path)?)?;
    let time = |entry: &Entry| entry.time.unwrap_or(0.0);
    entries.sort_by(|a, b| time(a).total_cmp(&time(b)));
    let mut times: Vec<f64> = entries.iter().map(time).collect();
    times.dedup();
    let number = steps::choose(path, choice, &times)?.unwrap_or(0);
    let chosen = times.get(number).copied();
    entries.retain(|entry| Some(time(entry)) == chosen);
    // One file for each time, and so each by itself is checked as a collection is.
    let mut files = Vec::new();
    let mut known = HashSet::new();
    for entry in entries {
        if !known.insert(entry.name.clone()) {
            return Err(Error::Format {
                path: path.to_owned(),
                at: entry.at,
                what: format!("'{}' is listed twice", entry.name),
                help: Some("each file is one part of a step".into()),
            });
        }
        files.extend(
            self::steps(path, vec![entry])?
                .into_iter()
                .map(|step| step.file),
        );
    }
    match files.is_empty() {
        true => self::steps(path, Vec::new()).map(|_| (files, times, number)),
        false => Ok((files, times, number)),
    }
}

/// The whole file, to a bound.
fn read(path: &Path) -> Result<Source, Error> {
    let (file, _): (File, u64) = open_file(path)?;
    let mut bytes = Vec::new();
    // One byte more tells a file that is too long, whatever length it claims.
    let read = file.take(MAX_COLLECTION_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|source| Error::Io {
        action: "cannot read",
        path: path.to_owned(),
        source,
    })?;
    let source = Source {
        path: path.to_owned(),
        bytes,
    };
    if source.bytes.is_empty() {
        return Err(source.error("", "the file is empty"));
    }
    if source.bytes.len() as u64 > MAX_COLLECTION_BYTES {
        return Err(source.error(
            "",
            format!("a file of more than {MAX_COLLECTION_BYTES} bytes is not a collection"),
        ));
    }
    Ok(source)
}

/// The steps that entries are, by time.
fn steps(path: &Path, entries: Vec<Entry>) -> Result<Vec<Step>, Error> {
    let refuse = |at: &str, what: String, help: Option<&str>| Error::Format {
        path: path.to_owned(),
        at: at.into(),
        what,
        help: help.map(String::from),
    };
    if entries.is_empty() {
        return Err(refuse(
            "its end",
            "the collection lists no file".into(),
            None,
        ));
    }
    let mut known = HashSet::new();
    for Entry { name, time, at } in &entries {
        let what = if name.is_empty() {
            Some("an entry without a file".into())
        } else if lists_files(name) {
            Some(format!(
                "'{name}' lists other files itself, which a collection cannot name"
            ))
        } else if time.is_some_and(|time| !time.is_finite()) {
            Some(format!("the time of '{name}' is not a finite number"))
        } else if !known.insert(name) {
            Some(format!("'{name}' is listed twice"))
        } else {
            None
        };
        if let Some(what) = what {
            let help = "a collection lists files with a mesh or a grid, one for each time";
            return Err(refuse(at, what, Some(help)));
        }
    }
    let mut entries = entries;
    let timed = entries.iter().filter(|entry| entry.time.is_some()).count();
    if let (Some(entry), true) = (entries.iter().find(|e| e.time.is_none()), timed > 0) {
        return Err(refuse(
            &entry.at,
            format!("'{}' has no time, and others have", entry.name),
            None,
        ));
    }
    // Stable: without times, the order is the file's.
    entries.sort_by(|a, b| match (a.time, b.time) {
        (Some(a), Some(b)) => a.total_cmp(&b),
        _ => std::cmp::Ordering::Equal,
    });
    if let Some([a, b]) = entries
        .array_windows()
        .find(|[a, b]| a.time.is_some() && a.time == b.time)
    {
        let time = b.time.unwrap_or_default();
        return Err(refuse(
            &b.at,
            format!(
                "'{}' and '{}' are both for the time {time}: parts of a step are not joined",
                a.name, b.name
            ),
            Some("write each step as one file"),
        ));
    }
    let step = |entry: &Entry| match beside(path, &entry.name) {
        Some(file) => Ok(Step {
            file,
            time: entry.time,
            number: None,
        }),
        None => Err(refuse(
            &entry.at,
            format!("'{}' is not in the collection's folder", entry.name),
            Some(KEEP_TOGETHER),
        )),
    };
    let steps: Vec<Step> = entries.iter().map(step).collect::<Result<_, _>>()?;
    let is_missing = |step: &&Step| !step.file.is_file();
    let missing = steps.iter().filter(is_missing).count();
    if let Some(first) = steps.iter().position(|step| is_missing(&step)) {
        let entry = &entries[first];
        let others = match missing {
            1 => String::new(),
            _ => format!(", nor are {}", count(missing as u64 - 1, "other")),
        };
        return Err(refuse(
            &entry.at,
            format!("the file '{}' is not there{others}", entry.name),
            Some("names of files start at the collection's folder"),
        ));
    }
    Ok(steps)
}

/// Whether a file of this name lists others and is not read as a mesh of its own.
fn lists_files(name: &str) -> bool {
    let extension = crate::image::extension(Path::new(name));
    let known = ["pvd", "series"];
    known.contains(&extension.as_str())
}

#[cfg(test)]
mod tests;
