//! Where a grid's numbers stand, and how they are fetched.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::read::{MultiGzDecoder, ZlibDecoder};
use tetrascope_core::Error;

use super::number::{Converted, Number};
use crate::parse_float;
use crate::source::{Endian, open_file};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Gzip,
    Zlib,
    /// Words, as people read them.
    Text,
}

/// Numbers in a file, or in several one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Payload {
    /// At least one.
    pub(crate) files: Vec<PathBuf>,
    /// Bytes before the numbers of each file, before any decompression; `None` if the
    /// numbers are the file's end.
    pub(crate) offset: Option<u64>,
    /// Bytes to pass over after decompression.
    pub(crate) skip: u64,
    pub(crate) encoding: Encoding,
    pub(crate) number: Number,
    pub(crate) endian: Endian,
}

/// What a byte of deflated data grows to at most: 258 bytes in 2 bits.
const DEFLATE: u64 = 1032;

/// The shortest words: a digit and a space.
const WORD: u64 = 2;

impl Payload {
    /// Reads `count` numbers.
    ///
    /// Nothing is allocated before the files are known to be long enough for them.
    pub(crate) fn read(&self, count: usize) -> Result<Converted, Error> {
        let per_file = count / self.files.len();
        if per_file * self.files.len() != count {
            return Err(Error::Format {
                path: self.files[0].clone(),
                at: "byte 0".into(),
                what: format!(
                    "{count} samples do not divide among {} files",
                    self.files.len()
                ),
                help: None,
            });
        }
        let mut all: Option<Converted> = None;
        for path in &self.files {
            let part = self.read_file(path, per_file)?;
            all = Some(match all {
                None => part,
                Some(mut all) => {
                    all.rounded |= part.rounded;
                    super::append(&mut all.samples, part.samples);
                    all
                }
            });
        }
        all.ok_or_else(|| Error::invalid("a grid without files"))
    }

    /// Where the numbers begin in `path`, checked to hold `count` of them.
    pub(crate) fn begin(&self, path: &Path, count: usize) -> Result<(File, u64), Error> {
        let format = |at: u64, what: String, help: &str| Error::Format {
            path: path.to_owned(),
            at: format!("byte {at}"),
            what,
            help: Some(help.into()),
        };
        let (mut file, length) = open_file(path)?;
        let needed = (count as u64)
            .checked_mul(self.number.size() as u64)
            .and_then(|n| n.checked_add(self.skip))
            .ok_or_else(|| format(0, format!("{count} samples cannot be"), "check the sizes"))?;
        let offset = match self.offset {
            Some(offset) => offset,
            None => length.saturating_sub(needed),
        };
        let rest = length.saturating_sub(offset);
        let (most, damaged) = match self.encoding {
            Encoding::Raw => (rest, "check the sizes and the type of samples"),
            Encoding::Gzip | Encoding::Zlib => (
                rest.saturating_mul(DEFLATE),
                "the file is truncated or damaged; copy or write it again",
            ),
            Encoding::Text => (
                (rest + 1) / WORD * self.number.size() as u64,
                "check the sizes",
            ),
        };
        if needed > most || (self.offset.is_none() && needed > length) {
            return Err(format(
                length,
                format!(
                    "the file ends, but {count} samples need {needed} bytes from byte {offset} on"
                ),
                damaged,
            ));
        }
        file.seek(SeekFrom::Start(offset))
            .map_err(|source| Error::Io {
                action: "cannot read",
                path: path.to_owned(),
                source,
            })?;
        Ok((file, offset))
    }

    fn read_file(&self, path: &Path, count: usize) -> Result<Converted, Error> {
        let (file, _) = self.begin(path, count)?;
        let mut plain = BufReader::with_capacity(1 << 16, file);
        let mut unpacked: Box<dyn Read> = match self.encoding {
            Encoding::Raw => Box::new(plain),
            Encoding::Gzip => Box::new(MultiGzDecoder::new(plain)),
            Encoding::Zlib => Box::new(ZlibDecoder::new(plain)),
            Encoding::Text => return self.read_words(path, &mut plain, count),
        };
        let skipped = std::io::copy(&mut unpacked.by_ref().take(self.skip), &mut std::io::sink());
        let converted = skipped.and_then(|_| self.number.read(&mut *unpacked, self.endian, count));
        converted.map_err(|source| match source.kind() {
            ErrorKind::UnexpectedEof | ErrorKind::InvalidData | ErrorKind::InvalidInput => {
                Error::Format {
                    path: path.to_owned(),
                    at: "the samples".into(),
                    what: format!("the data is damaged or ends before {count} samples ({source})"),
                    help: Some("the file is truncated or damaged; copy or write it again".into()),
                }
            }
            _ => Error::Io {
                action: "cannot read",
                path: path.to_owned(),
                source,
            },
        })
    }

    /// Reads words to 64-bit floats and from there to samples, so that integers of 8 and
    /// 16 bits stay integers.
    fn read_words(
        &self,
        path: &Path,
        reader: &mut dyn Read,
        count: usize,
    ) -> Result<Converted, Error> {
        let wrong = |at: String, what: String| Error::Format {
            path: path.to_owned(),
            at,
            what,
            help: None,
        };
        let mut text = Vec::new();
        reader.read_to_end(&mut text).map_err(|source| Error::Io {
            action: "cannot read",
            path: path.to_owned(),
            source,
        })?;
        let mut bytes = Vec::with_capacity(count * self.number.size());
        let words = text.split(|b| b.is_ascii_whitespace() || *b == b',');
        for (i, word) in words.filter(|w| !w.is_empty()).take(count).enumerate() {
            let value = std::str::from_utf8(word).ok().and_then(parse_float);
            let value = value.and_then(|v| self.number.encode(v, &mut bytes));
            value.ok_or_else(|| {
                let word: String = String::from_utf8_lossy(word).chars().take(40).collect();
                wrong(
                    format!("value {i}"),
                    format!("'{word}' is not a number of its type"),
                )
            })?;
        }
        let found = bytes.len() / self.number.size();
        if found < count {
            return Err(wrong(
                "the samples".into(),
                format!("{found} values where {count} are needed"),
            ));
        }
        let converted = self
            .number
            .read(&mut bytes.as_slice(), Endian::Little, count);
        converted.map_err(|error| wrong("the samples".into(), error.to_string()))
    }
}
