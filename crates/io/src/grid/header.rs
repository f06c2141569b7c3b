//! Headers of lines: what grid formats in text have in common.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use tetrascope_core::Error;

use super::MOST_FILES;
use crate::source::{KEEP_TOGETHER, beside, open_file};

/// No header is longer; a file of another kind is.
const LONGEST: u64 = 1 << 20;

/// The beginning of a file, line by line.
pub(crate) struct Header {
    path: PathBuf,
    bytes: Vec<u8>,
    at: usize,
    line: usize,
}

impl Header {
    pub(crate) fn open(path: &Path) -> Result<Header, Error> {
        let (file, _) = open_file(path)?;
        let mut bytes = Vec::new();
        let read = file.take(LONGEST).read_to_end(&mut bytes);
        read.map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        Ok(Header {
            path: path.to_owned(),
            bytes,
            at: 0,
            line: 0,
        })
    }

    /// The next line without its end; `None` after the last.
    ///
    /// Bytes that are not text are read with replacements: the line then matches no key.
    pub(crate) fn next_line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..length]);
        let text = text.trim_end_matches('\r').to_owned();
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        Some(text)
    }

    /// The names of files in all lines that are left.
    pub(crate) fn files(&mut self) -> Result<Vec<PathBuf>, Error> {
        let mut files = Vec::new();
        while let Some(line) = self.next_line() {
            let name = line.trim();
            if !name.is_empty() && files.len() < MOST_FILES {
                files.push(self.beside(name)?);
            }
        }
        Ok(files)
    }

    /// How many bytes were read as lines.
    pub(crate) fn position(&self) -> u64 {
        self.at as u64
    }

    /// A file that the header names, from the header's folder.
    fn beside(&self, name: &str) -> Result<PathBuf, Error> {
        beside(&self.path, name).ok_or_else(|| {
            let what = format!("'{}' is not in the header's folder", clip(name));
            self.error_with_help(what, KEEP_TOGETHER)
        })
    }

    /// An error in the line that was read last.
    pub(crate) fn error(&self, what: impl Into<String>) -> Error {
        self.error_with_help(what, None)
    }

    pub(crate) fn error_with_help(
        &self,
        what: impl Into<String>,
        help: impl Into<Option<&'static str>>,
    ) -> Error {
        Error::Format {
            path: self.path.clone(),
            at: format!("line {}", self.line),
            what: what.into(),
            help: help.into().map(String::from),
        }
    }

    /// Whole numbers, or floats, separated by blanks.
    pub(crate) fn numbers<T: std::str::FromStr>(
        &self,
        key: &str,
        text: &str,
    ) -> Result<Vec<T>, Error> {
        let words = text.split_ascii_whitespace();
        let numbers: Option<Vec<T>> = words.map(|word| word.parse().ok()).collect();
        numbers.ok_or_else(|| self.error(format!("'{key}' has '{}', no numbers", clip(text))))
    }

    /// Exactly as many numbers as fit.
    pub(crate) fn array<T: std::str::FromStr, const N: usize>(
        &self,
        key: &str,
        text: &str,
    ) -> Result<[T; N], Error> {
        let numbers: Vec<T> = self.numbers(key, text)?;
        let count = numbers.len();
        numbers
            .try_into()
            .map_err(|_| self.error(format!("'{key}' has {count} numbers where {N} are needed")))
    }
}

/// A name, or a pattern with its first, last and increment: `quarter.%d 1 93 1`.
pub(crate) fn data_files(header: &Header, value: &str) -> Result<Vec<PathBuf>, Error> {
    let words: Vec<&str> = value.split_ascii_whitespace().collect();
    let numbers =
        |words: &[&str]| -> Option<Vec<i64>> { words.iter().map(|w| w.parse().ok()).collect() };
    if words.len() >= 4 && words[0].contains('%') {
        let numbers = numbers(&words[1..]);
        let Some([first, last, step, ..]) = numbers.as_deref() else {
            return Err(header.error(format!(
                "'{}' is no pattern with three numbers",
                clip(value)
            )));
        };
        let count = last.checked_sub(*first).and_then(|d| d.checked_div(*step));
        let count = count
            .and_then(|c| usize::try_from(c).ok())
            .filter(|c| *c < MOST_FILES);
        let Some(count) = count else {
            return Err(header.error(format!("files from {first} to {last} by {step}")));
        };
        let names = (0..=count as i64).map(|i| numbered(words[0], first + i * step));
        let names: Option<Vec<String>> = names.collect();
        let names = names.ok_or_else(|| {
            header.error(format!(
                "'{}' has no number like %d or %03d",
                clip(words[0])
            ))
        })?;
        return names.iter().map(|name| header.beside(name)).collect();
    }
    Ok(vec![header.beside(value)?])
}

/// `pattern` with its one `%d` or `%03d` replaced.
fn numbered(pattern: &str, number: i64) -> Option<String> {
    let (before, rest) = pattern.split_once('%')?;
    let (width, after) = rest.split_once('d')?;
    let zeros = width.starts_with('0');
    let width: usize = if width.is_empty() {
        0
    } else {
        width.parse().ok()?
    };
    if width > 20 || after.contains('%') {
        return None;
    }
    Some(if zeros {
        format!("{before}{number:0width$}{after}")
    } else {
        format!("{before}{number:width$}{after}")
    })
}

/// At most 40 characters, for a message.
pub(crate) fn clip(text: &str) -> String {
    text.chars().take(40).collect()
}
