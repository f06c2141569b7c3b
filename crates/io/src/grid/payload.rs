//! Where a grid's numbers stand, and how they are fetched.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Cursor, ErrorKind, Read, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::read::{DeflateDecoder, MultiGzDecoder, ZlibDecoder};
use tetrascope_core::Error;

use super::formats::GZIP;
use super::number::{Number, Numbers};
use crate::source::{Endian, open_file};

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    Raw,
    Gzip,
    Zlib,
    /// As in zip files, without a header.
    Deflate,
    /// Words, as people read them.
    Text,
}

/// Numbers in a file, or in several one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Payload {
    /// At least one.
    pub(crate) files: Vec<PathBuf>,
    /// Where in each file the lines begin that come before its numbers.
    pub(crate) start: u64,
    /// How many lines.
    pub(crate) lines: u64,
    /// Bytes to pass over behind those, after decompression; `None` if the numbers are the
    /// end of what there is.
    pub(crate) skip: Option<u64>,
    pub(crate) encoding: Encoding,
    pub(crate) number: Number,
    pub(crate) endian: Endian,
}

/// The most bytes that a byte of deflated data becomes: 258 bytes in 2 bits.
pub(crate) const DEFLATE: u64 = 1032;

/// The most bytes that a packed file of `length` bytes may hold.
///
/// Deflate could make up to 1032 times its bytes of it. What is measured hardly goes beyond 64
/// times, but masks do, which are empty nearly everywhere; those of up to 1 GiB are read
/// whatever they are packed to. Samples that are not packed are never more than their file.
pub(crate) fn most_unpacked(length: u64) -> u64 {
    length.saturating_mul(64).saturating_add(1 << 30)
}

/// The help of an error about a file that holds more than [`most_unpacked`].
pub(crate) const UNPACK: &str =
    "unpack the samples first: those that stand in a file as they are may be of any size";

/// The shortest words: a digit and a space.
const WORD: u64 = 2;

impl Payload {
    /// Reads `parts` runs of `length` numbers each.
    ///
    /// Nothing is allocated before the files are known to be long enough for them.
    pub(crate) fn read(&self, length: usize, parts: usize) -> Result<Vec<Numbers>, Error> {
        let count = length * parts; // checked by the caller
        let per_file = count / self.files.len();
        if per_file == 0 || per_file * self.files.len() != count {
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
        self.check_files(count)?;
        // So many are of one part and in one file.
        let step = greatest_common_divisor(length, per_file);
        let mut all: Vec<Numbers> = Vec::new();
        for path in &self.files {
            let mut reader = self.unpack(path, per_file)?;
            for _ in 0..per_file / step {
                let numbers = self.number.read(&mut *reader, self.endian(), step);
                let numbers = numbers.map_err(|error| damaged(path, per_file, error))?;
                match all.last_mut().filter(|part| part.len() < length) {
                    Some(part) => {
                        part.append(numbers);
                    }
                    None => all.push(numbers),
                }
            }
        }
        Ok(all)
    }

    /// Refuses files that give much more than they hold: one that is named several times, and
    /// packed ones beyond [`most_unpacked`].
    fn check_files(&self, count: usize) -> Result<(), Error> {
        let refuse = |path: &Path, what: String, help: &str| Error::Format {
            path: path.to_owned(),
            at: "the samples".into(),
            what,
            help: Some(help.into()),
        };
        let mut known = HashSet::new();
        let mut length = 0u64;
        for path in &self.files {
            length = length.saturating_add(open_file(path)?.1);
            let is_known = self.files.len() > 1
                && !known.insert(path.canonicalize().map_err(|e| cannot_read(path, e))?);
            if is_known {
                let what = "the header names this file twice".into();
                return Err(refuse(path, what, "each file holds samples of its own"));
            }
        }
        let needed = (count as u64).saturating_mul(self.number.size() as u64);
        let is_plain = matches!(self.encoding, Encoding::Raw | Encoding::Text);
        match !is_plain && needed > most_unpacked(length) {
            false => Ok(()),
            true => Err(refuse(
                &self.files[0],
                format!("{needed} bytes of samples are packed in {length}, which is refused"),
                UNPACK,
            )),
        }
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
            .and_then(|n| n.checked_add(self.skip.unwrap_or(0)))
            .ok_or_else(|| format(0, format!("{count} samples cannot be"), "check the sizes"))?;
        let start = self.behind_lines(path, &mut file)?;
        let rest = length.saturating_sub(start);
        let (most, offset, help) = match self.encoding {
            Encoding::Raw => (
                rest,
                match self.skip {
                    Some(skip) => start.saturating_add(skip),
                    None => length.saturating_sub(needed),
                },
                "check the sizes and the type of samples",
            ),
            Encoding::Gzip | Encoding::Zlib | Encoding::Deflate => (
                rest.saturating_mul(DEFLATE),
                start,
                "the file is truncated or damaged; copy or write it again",
            ),
            Encoding::Text => {
                let skip = self.skip.unwrap_or(0);
                let words = (rest.saturating_sub(skip) + 1) / WORD;
                let most = words.saturating_mul(self.number.size() as u64);
                (
                    most.saturating_add(skip),
                    start.saturating_add(skip),
                    "check the sizes",
                )
            }
        };
        if needed > most {
            let skip = self.skip.unwrap_or(0);
            let (bytes, from) = (needed - skip, start.saturating_add(skip));
            return Err(format(
                length,
                format!(
                    "the file ends, but {count} samples need {bytes} bytes from byte {from} on"
                ),
                help,
            ));
        }
        let seek = file.seek(SeekFrom::Start(offset));
        seek.map_err(|source| cannot_read(path, source))?;
        Ok((file, offset))
    }

    /// The first byte behind the lines that come before the numbers.
    fn behind_lines(&self, path: &Path, file: &mut File) -> Result<u64, Error> {
        let mut at = self.start;
        if self.lines == 0 {
            return Ok(at);
        }
        let io = |source| cannot_read(path, source);
        file.seek(SeekFrom::Start(at)).map_err(io)?;
        let mut reader = BufReader::new(&*file);
        let mut left = self.lines;
        while left > 0 {
            let bytes = reader.fill_buf().map_err(io)?;
            if bytes.is_empty() {
                return Err(Error::Format {
                    path: path.to_owned(),
                    at: format!("byte {at}"),
                    what: format!(
                        "the file ends after {} of {} lines before its numbers",
                        self.lines - left,
                        self.lines
                    ),
                    help: Some("check 'line skip'".into()),
                });
            }
            let (length, ends) = match bytes.iter().position(|b| *b == b'\n') {
                Some(end) => (end + 1, 1),
                None => (bytes.len(), 0),
            };
            reader.consume(length);
            at += length as u64;
            left -= ends;
        }
        Ok(at)
    }

    /// The bytes of `count` numbers of one file, and perhaps more.
    fn unpack(&self, path: &Path, count: usize) -> Result<Box<dyn Read>, Error> {
        let open = || -> Result<Box<dyn Read>, Error> {
            let (file, _) = self.begin(path, count)?;
            let plain = BufReader::with_capacity(1 << 16, file);
            Ok(match self.encoding {
                Encoding::Raw | Encoding::Text => Box::new(plain),
                Encoding::Gzip => Box::new(MultiGzDecoder::new(plain)),
                Encoding::Zlib => Box::new(ZlibDecoder::new(plain)),
                Encoding::Deflate => Box::new(DeflateDecoder::new(plain)),
            })
        };
        let mut reader = open()?;
        if self.encoding == Encoding::Text {
            let bytes = self.words(path, &mut *reader, count)?;
            return Ok(Box::new(Cursor::new(bytes)));
        }
        if self.encoding == Encoding::Raw {
            return Ok(reader);
        }
        let pass = |reader: &mut dyn Read, bytes: u64| {
            let copied = std::io::copy(&mut reader.take(bytes), &mut std::io::sink());
            copied.map_err(|error| damaged(path, count, error))
        };
        let skip = match self.skip {
            Some(skip) => skip,
            // How much there is, only all of it tells.
            None => {
                let all = pass(&mut *reader, u64::MAX)?;
                reader = open()?;
                all.saturating_sub(count as u64 * self.number.size() as u64)
            }
        };
        pass(&mut *reader, skip)?;
        Ok(reader)
    }

    /// The byte order of the numbers that [`Payload::unpack`] gives: words become little-endian.
    fn endian(&self) -> Endian {
        match self.encoding {
            Encoding::Text => Endian::Little,
            _ => self.endian,
        }
    }

    /// The bytes of `count` words.
    fn words(&self, path: &Path, reader: &mut dyn Read, count: usize) -> Result<Vec<u8>, Error> {
        let wrong = |at: String, what: String| Error::Format {
            path: path.to_owned(),
            at,
            what,
            help: None,
        };
        let mut text = Vec::new();
        let read = reader.read_to_end(&mut text);
        read.map_err(|source| cannot_read(path, source))?;
        let size = self.number.size();
        let mut bytes = Vec::with_capacity(count * size); // checked in `begin`
        let words = text.split(|b| b.is_ascii_whitespace() || *b == b',');
        for (i, word) in words.filter(|w| !w.is_empty()).take(count).enumerate() {
            let number = std::str::from_utf8(word).ok();
            let number = number.and_then(|word| self.number.word(word));
            let number = number.ok_or_else(|| {
                let word: String = String::from_utf8_lossy(word).chars().take(40).collect();
                wrong(
                    format!("value {i}"),
                    format!("'{word}' is not a number of its type"),
                )
            })?;
            bytes.extend_from_slice(&number[..size]);
        }
        let found = bytes.len() / size;
        if found < count {
            return Err(wrong(
                "the samples".into(),
                format!("{found} values where {count} are needed"),
            ));
        }
        Ok(bytes)
    }
}

/// The bytes of a file, unpacked if they are packed with gzip, and whether they are.
pub(crate) fn open_unpacked(path: &Path) -> Result<(Box<dyn Read>, bool), Error> {
    let (file, _) = open_file(path)?;
    let mut plain = BufReader::new(file);
    let head = plain.fill_buf().map_err(|e| cannot_read(path, e))?;
    Ok(match head.starts_with(GZIP) {
        true => (Box::new(MultiGzDecoder::new(plain)), true),
        false => (Box::new(plain), false),
    })
}

/// The error for a failure while `count` numbers were read.
fn damaged(path: &Path, count: usize, source: std::io::Error) -> Error {
    match source.kind() {
        ErrorKind::UnexpectedEof | ErrorKind::InvalidData | ErrorKind::InvalidInput => {
            Error::Format {
                path: path.to_owned(),
                at: "the samples".into(),
                what: format!("the data is damaged or ends before {count} samples ({source})"),
                help: Some("the file is truncated or damaged; copy or write it again".into()),
            }
        }
        _ => cannot_read(path, source),
    }
}

fn cannot_read(path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        action: "cannot read",
        path: path.to_owned(),
        source,
    }
}

/// The greatest common divisor of two numbers above 0.
fn greatest_common_divisor(a: usize, b: usize) -> usize {
    let (mut a, mut b) = (a, b);
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}
