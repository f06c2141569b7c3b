//! Lines and numbers of a Gmsh file, as text or binary, one after the other.

use tetrascope_core::Error;

use crate::parse_float;
use crate::source::{Endian, Source};

/// A place in the file.
#[derive(Clone)]
pub(super) struct Cursor<'a> {
    source: &'a Source,
    pub(super) at: usize,
    pub(super) encoding: Encoding,
}

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Text,
    Binary {
        endian: Endian,
        /// Bytes of a count or a tag (C's `size_t`): 4 or 8.
        size: usize,
    },
}

/// A type of numbers of the format.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Int,
    Size,
    Double,
}

impl Encoding {
    /// The least bytes that a number takes: as text a digit and a blank.
    pub(super) fn least_bytes(self, number: Number) -> u64 {
        match (self, number) {
            (Encoding::Text, _) => 2,
            (Encoding::Binary { .. }, Number::Int) => 4,
            (Encoding::Binary { size, .. }, Number::Size) => size as u64,
            (Encoding::Binary { .. }, Number::Double) => 8,
        }
    }
}

impl<'a> Cursor<'a> {
    pub(super) fn new(source: &'a Source) -> Cursor<'a> {
        Cursor {
            source,
            at: 0,
            encoding: Encoding::Text,
        }
    }

    pub(super) fn rest(&self) -> &'a [u8] {
        &self.source.bytes[self.at..]
    }

    /// The rest of the line, without blanks around it; `None` at the end of the file.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        Some(rest[..length].trim_ascii())
    }

    /// The next line that is not blank.
    pub(super) fn full_line(&mut self) -> Option<&'a [u8]> {
        loop {
            match self.line() {
                Some([]) => {}
                line => return line,
            }
        }
    }

    /// The text of the next line, of which it is said what it must be.
    pub(super) fn text_line(&mut self, what: &str) -> Result<&'a str, Error> {
        let line = self
            .full_line()
            .ok_or_else(|| self.truncated(format!("the file ends where {what} is needed")))?;
        std::str::from_utf8(line).map_err(|_| self.error(format!("{what} is not text")))
    }

    /// A line that holds a number in text, also in binary files.
    pub(super) fn number_line<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Error> {
        let line = self.text_line(what)?;
        line.parse()
            .map_err(|_| self.error(format!("'{}' is not {what}", clip(line))))
    }

    fn word(&mut self, what: &str) -> Result<&'a str, Error> {
        let rest = self.rest();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let start =
            start.ok_or_else(|| self.truncated(format!("the file ends where {what} is needed")))?;
        let length = rest[start..]
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len() - start);
        let word = std::str::from_utf8(&rest[start..start + length])
            .map_err(|_| self.error(format!("bytes that are not text where {what} is needed")))?;
        self.at += start + length;
        Ok(word)
    }

    fn bytes(&mut self, length: usize, what: &str) -> Result<&'a [u8], Error> {
        let bytes = self
            .rest()
            .get(..length)
            .ok_or_else(|| self.truncated(format!("the file ends where {what} is needed")))?;
        self.at += length;
        Ok(bytes)
    }

    fn parsed<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Error> {
        let word = self.word(what)?;
        word.parse()
            .map_err(|_| self.error(format!("'{}' where {what} is needed", clip(word))))
    }

    /// A 32-bit integer of the format; as text any.
    pub(super) fn int(&mut self, what: &str) -> Result<i64, Error> {
        match self.encoding {
            Encoding::Text => self.parsed(what),
            Encoding::Binary { endian, .. } => Ok(endian.i32(self.bytes(4, what)?).into()),
        }
    }

    /// An [`Cursor::int`] that counts or names something.
    pub(super) fn unsigned(&mut self, what: &str) -> Result<u64, Error> {
        let number = self.int(what)?;
        u64::try_from(number).map_err(|_| self.error(format!("{number} where {what} is needed")))
    }

    /// A count or a tag of version 4.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, Error> {
        match self.encoding {
            Encoding::Text => self.parsed(what),
            Encoding::Binary { endian, size: 4 } => Ok(endian.u32(self.bytes(4, what)?).into()),
            Encoding::Binary { endian, .. } => Ok(endian.u64(self.bytes(8, what)?)),
        }
    }

    pub(super) fn double(&mut self, what: &str) -> Result<f64, Error> {
        match self.encoding {
            Encoding::Text => {
                let word = self.word(what)?;
                parse_float(word)
                    .ok_or_else(|| self.error(format!("'{}' where {what} is needed", clip(word))))
            }
            Encoding::Binary { endian, .. } => Ok(endian.f64(self.bytes(8, what)?)),
        }
    }

    /// Whether `count` things that take `bytes` or more each can follow; then their number.
    pub(super) fn fits(&self, count: u64, bytes: u64, things: &str) -> Result<usize, Error> {
        let left = self.rest().len() as u64;
        // The last number of a text needs no blank.
        let room = left + u64::from(self.encoding == Encoding::Text);
        if count.saturating_mul(bytes) > room {
            return Err(self.truncated(format!(
                "{count} {things} cannot be in the {left} bytes that are left"
            )));
        }
        Ok(count as usize)
    }

    /// An error here.
    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        self.source.error(format!("byte {}", self.at), what)
    }

    pub(super) fn truncated(&self, what: impl Into<String>) -> Error {
        self.source.error_with_help(
            format!("byte {}", self.at),
            what,
            "the file is truncated or damaged; copy or write it again",
        )
    }

    pub(super) fn error_with_help(&self, what: impl Into<String>, help: &str) -> Error {
        self.source
            .error_with_help(format!("byte {}", self.at), what, help)
    }
}

/// At most 40 characters of a word, for a message.
pub(super) fn clip(word: &str) -> String {
    word.chars().take(40).collect()
}
