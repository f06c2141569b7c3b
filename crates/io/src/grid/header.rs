//! Headers of lines: what grid formats in text have in common.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use tetrascope_core::Error;

use crate::source::open_file;

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
    /// What is no text is read as such with replacements: it then matches no key.
    pub(crate) fn next_line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..length]);
        let text = text.trim_end_matches('\r').to_owned();
        self.at += (length + 1).min(rest.len());
        self.line += 1;
        Some(text)
    }

    /// How many bytes were read as lines.
    pub(crate) fn position(&self) -> u64 {
        self.at as u64
    }

    /// A file that the header names, from the header's folder.
    pub(crate) fn beside(&self, name: &str) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        folder.join(name)
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

/// At most 40 characters, for a message.
pub(crate) fn clip(text: &str) -> String {
    text.chars().take(40).collect()
}
