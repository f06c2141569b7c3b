//! The numbers of an array: words, base64 or bytes, perhaps compressed.
//!
//! Uncompressed binary data is `[bytes][data]`, compressed data
//! `[blocks][block size][size of the last block, or 0][compressed sizes…][blocks…]`,
//! with headers of 32 or 64 bits. In base64 header and data are encoded one
//! after the other or together; both are met with. (VTK, *VTK XML Formats*.)

use std::borrow::Cow;
use std::cell::Cell;
use std::io::Read as _;

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use tetrascope_core::Error;

use super::document::{ArrayElement, Compressor, Data, Document};
use crate::grid::number::{Converted, Number};
use crate::source::{Endian, Source};
use crate::vtk::parse_float;

/// What a byte can grow to, by the formats: deflate codes at most 258 bytes in
/// 2 bits, LZ4 255 bytes in one. The sum allows for the headers of tiny blocks.
fn largest(compressor: Compressor, compressed: u64) -> u64 {
    let ratio = match compressor {
        Compressor::None => 1,
        Compressor::Zlib => 1032,
        Compressor::Lz4 => 255,
    };
    compressed.saturating_mul(ratio).saturating_add(64)
}

/// Reads the arrays of one file.
pub(super) struct Decoder<'a> {
    source: &'a Source,
    document: &'a Document<'a>,
    /// Encoded bytes read so far. Arrays do not overlap, so they are no more
    /// than the file has; arrays that all point at the same place are stopped.
    consumed: Cell<u64>,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(source: &'a Source, document: &'a Document<'a>) -> Decoder<'a> {
        Decoder {
            source,
            document,
            consumed: Cell::new(0),
        }
    }

    /// `tuples` tuples of any numbers, all components of one after the other.
    pub(super) fn floats(&self, array: &ArrayElement, tuples: u64) -> Result<Vec<f64>, Error> {
        let count = self.count(array, tuples)?;
        if let Data::Ascii(text) = &array.data {
            return self.words(array, text, count, parse_float);
        }
        let bytes = self.bytes(array, count)?;
        let endian = self.document.endian;
        let each = |f: &dyn Fn(&[u8]) -> f64| -> Vec<f64> {
            bytes.chunks_exact(array.kind.size()).map(f).collect()
        };
        Ok(match array.kind {
            Number::F32 => each(&|b| f64::from(endian.f32(b))),
            Number::F64 => each(&|b| endian.f64(b)),
            // Exact to 2⁵³.
            kind => each(&|b| integer(kind, endian, b) as f64),
        })
    }

    /// `tuples` tuples in the type of samples that holds them best.
    pub(super) fn samples(&self, array: &ArrayElement, tuples: u64) -> Result<Converted, Error> {
        let count = self.count(array, tuples)?;
        let text;
        let (bytes, endian) = if let Data::Ascii(words) = &array.data {
            let values = self.words(array, words, count, parse_float)?;
            let mut bytes = Vec::with_capacity(values.len() * array.kind.size());
            for (i, value) in values.into_iter().enumerate() {
                array.kind.encode(value, &mut bytes).ok_or_else(|| {
                    self.error(array, format!("value {i} is {value}, not of its type"))
                })?;
            }
            text = bytes;
            (Cow::Borrowed(text.as_slice()), Endian::Little)
        } else {
            (self.bytes(array, count)?, self.document.endian)
        };
        let converted = array.kind.read(&mut &bytes[..], endian, count as usize);
        converted.map_err(|error| self.error(array, error.to_string()))
    }

    /// `count` indices.
    pub(super) fn indices(&self, array: &ArrayElement, count: u64) -> Result<Vec<u64>, Error> {
        if matches!(array.kind, Number::F32 | Number::F64) || array.components != 1 {
            return Err(self.error(array, "indices must be whole numbers, one component each"));
        }
        let count = self.count(array, count)?;
        if let Data::Ascii(text) = &array.data {
            return self.words(array, text, count, |word| word.parse().ok());
        }
        let bytes = self.bytes(array, count)?;
        let endian = self.document.endian;
        bytes
            .chunks_exact(array.kind.size())
            .enumerate()
            .map(|(i, b)| {
                let value = integer(array.kind, endian, b);
                u64::try_from(value)
                    .map_err(|_| self.error(array, format!("value {i} is {value}, below 0")))
            })
            .collect()
    }

    /// Values in all; an array cannot have more than memory has bytes.
    fn count(&self, array: &ArrayElement, tuples: u64) -> Result<u64, Error> {
        tuples
            .checked_mul(array.components)
            .filter(|count| {
                count
                    .checked_mul(8)
                    .is_some_and(|b| usize::try_from(b).is_ok())
            })
            .ok_or_else(|| self.error(array, format!("{tuples} tuples cannot be")))
    }

    fn words<T>(
        &self,
        array: &ArrayElement,
        text: &str,
        count: u64,
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Vec<T>, Error> {
        self.consume(array, text.len() as u64)?;
        let values: Vec<T> = text
            .split_ascii_whitespace()
            .enumerate()
            .map(|(i, word)| {
                parse(word).ok_or_else(|| {
                    let word: String = word.chars().take(40).collect();
                    self.error(
                        array,
                        format!("value {i} is '{word}', not a number of its type"),
                    )
                })
            })
            .collect::<Result<_, _>>()?;
        if values.len() as u64 != count {
            return Err(self.error(
                array,
                format!("{} values where {count} are needed", values.len()),
            ));
        }
        Ok(values)
    }

    /// The decoded bytes of `count` numbers.
    fn bytes<'s>(&'s self, array: &'s ArrayElement, count: u64) -> Result<Cow<'s, [u8]>, Error> {
        let expected = count * array.kind.size() as u64; // checked in `count`
        if expected == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let mut stream = self.stream(array)?;
        let start = stream.rest();
        let result = self.block_data(array, &mut stream, expected);
        self.consume(array, start - stream.rest())?;
        result
    }

    fn stream<'s>(&'s self, array: &'s ArrayElement) -> Result<Stream<'s>, Error> {
        match (&array.data, self.document.appended) {
            (Data::Inline(text), _) => Ok(Stream::base64(text.as_bytes())),
            (Data::Appended(offset), Some(appended)) => {
                let rest = usize::try_from(*offset)
                    .ok()
                    .and_then(|offset| appended.bytes.get(offset..))
                    .ok_or_else(|| {
                        self.truncated(
                            array,
                            format!(
                                "its data begins at byte {offset} of the appended data, which has {}",
                                appended.bytes.len()
                            ),
                        )
                    })?;
                Ok(if appended.raw {
                    Stream::Raw(rest)
                } else {
                    Stream::base64(rest)
                })
            }
            (Data::Appended(_), None) => Err(self.truncated(array, "there is no appended data")),
            (Data::Ascii(_), _) => Err(self.error(array, "its data is text")),
        }
    }

    fn block_data<'s>(
        &self,
        array: &ArrayElement,
        stream: &mut Stream<'s>,
        expected: u64,
    ) -> Result<Cow<'s, [u8]>, Error> {
        let compressor = self.document.compressor;
        let wrong =
            |found: u64| self.error(array, format!("{found} bytes where {expected} are needed"));
        if compressor == Compressor::None {
            let length = self.header(array, stream)?;
            if length != expected {
                return Err(wrong(length));
            }
            return self.take(array, stream, length);
        }
        let block_count = self.header(array, stream)?;
        let block_size = self.header(array, stream)?;
        let last_size = self.header(array, stream)?;
        let total = if last_size == 0 {
            block_count.checked_mul(block_size)
        } else {
            block_count
                .checked_sub(1)
                .and_then(|full| full.checked_mul(block_size)?.checked_add(last_size))
        };
        if total != Some(expected) {
            return Err(wrong(total.unwrap_or(u64::MAX)));
        }
        if block_count > stream.rest() / 4 {
            return Err(self.truncated(
                array,
                format!("{block_count} compressed blocks are too many for the rest of the file"),
            ));
        }
        let mut sizes = Vec::with_capacity(block_count as usize);
        for _ in 0..block_count {
            sizes.push(self.header(array, stream)?);
        }
        let compressed = sizes.iter().try_fold(0_u64, |sum, &s| sum.checked_add(s));
        if compressed.is_none_or(|sum| {
            sum > stream.rest()
                || expected > largest(compressor, sum).saturating_add(64 * block_count)
        }) {
            return Err(self.truncated(
                array,
                format!(
                    "compressed blocks that cannot hold {expected} bytes in the rest of the file"
                ),
            ));
        }
        let mut bytes = Vec::with_capacity(expected as usize);
        for (i, size) in sizes.into_iter().enumerate() {
            let is_last = i as u64 + 1 == block_count;
            let full = if is_last && last_size != 0 {
                last_size
            } else {
                block_size
            };
            let block = self.take(array, stream, size)?;
            if full > largest(compressor, size)
                || !decompress(compressor, &block, full as usize, &mut bytes)
            {
                return Err(self.error(
                    array,
                    format!("compressed block {i} is damaged or does not hold {full} bytes"),
                ));
            }
        }
        Ok(Cow::Owned(bytes))
    }

    /// One number of a header.
    fn header(&self, array: &ArrayElement, stream: &mut Stream) -> Result<u64, Error> {
        let endian = self.document.endian;
        if self.document.wide_headers {
            Ok(endian.u64(&self.take(array, stream, 8)?))
        } else {
            Ok(u64::from(endian.u32(&self.take(array, stream, 4)?)))
        }
    }

    fn take<'s>(
        &self,
        array: &ArrayElement,
        stream: &mut Stream<'s>,
        length: u64,
    ) -> Result<Cow<'s, [u8]>, Error> {
        stream
            .take(length)
            .map_err(|what| self.truncated(array, what))
    }

    fn consume(&self, array: &ArrayElement, length: u64) -> Result<(), Error> {
        let sum = self.consumed.get().saturating_add(length);
        self.consumed.set(sum);
        if sum > self.source.bytes.len() as u64 {
            return Err(self.error(array, "its data overlaps that of other arrays"));
        }
        Ok(())
    }

    fn error(&self, array: &ArrayElement, what: impl Into<String>) -> Error {
        self.source.error(format!("array '{}'", array.name), what)
    }

    fn truncated(&self, array: &ArrayElement, what: impl Into<String>) -> Error {
        self.source.error_with_help(
            format!("array '{}'", array.name),
            what,
            "the file is truncated or damaged; copy or write it again",
        )
    }
}

/// Appends exactly `size` decompressed bytes; false if the block holds anything else.
fn decompress(compressor: Compressor, block: &[u8], size: usize, bytes: &mut Vec<u8>) -> bool {
    let start = bytes.len();
    match compressor {
        Compressor::None => false,
        Compressor::Zlib => {
            let mut limited = flate2::read::ZlibDecoder::new(block).take(size as u64 + 1);
            limited.read_to_end(bytes).is_ok() && bytes.len() == start + size
        }
        Compressor::Lz4 => {
            bytes.resize(start + size, 0);
            lz4_flex::block::decompress_into(block, &mut bytes[start..])
                .is_ok_and(|written| written == size)
        }
    }
}

/// Any integer type, widened. `u64` fits as well.
fn integer(kind: Number, endian: Endian, bytes: &[u8]) -> i128 {
    match kind {
        Number::I8 => i128::from(bytes[0] as i8),
        Number::U8 => i128::from(bytes[0]),
        Number::I16 => i128::from(endian.i16(bytes)),
        Number::U16 => i128::from(endian.u16(bytes)),
        Number::I32 => i128::from(endian.i32(bytes)),
        Number::U32 => i128::from(endian.u32(bytes)),
        Number::I64 => i128::from(endian.i64(bytes)),
        Number::U64 => i128::from(endian.u64(bytes)),
        Number::F32 => i128::from(endian.f32(bytes) as i64),
        Number::F64 => i128::from(endian.f64(bytes) as i64),
    }
}

/// Bytes one after the other.
enum Stream<'s> {
    Raw(&'s [u8]),
    Base64 {
        text: &'s [u8],
        /// Decoded and not yet taken.
        ready: Vec<u8>,
    },
}

/// Each group of four characters stands for itself, padded or not.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

impl<'s> Stream<'s> {
    fn base64(text: &'s [u8]) -> Stream<'s> {
        Stream::Base64 {
            text,
            ready: Vec::new(),
        }
    }

    /// At least the bytes or characters that are left.
    fn rest(&self) -> u64 {
        match self {
            Stream::Raw(bytes) => bytes.len() as u64,
            Stream::Base64 { text, ready } => (text.len() + ready.len()) as u64,
        }
    }

    fn take(&mut self, length: u64) -> Result<Cow<'s, [u8]>, String> {
        let rest = self.rest();
        let too_long = || format!("{length} bytes of data where only {rest} are left");
        if length > rest {
            return Err(too_long());
        }
        let length = length as usize; // no more than the file has
        match self {
            Stream::Raw(bytes) => {
                let (head, tail) = bytes.split_at(length);
                *bytes = tail;
                Ok(Cow::Borrowed(head))
            }
            Stream::Base64 { text, ready } => {
                while ready.len() < length {
                    let decoded = decode_run(text)?;
                    if decoded.is_empty() {
                        return Err(too_long());
                    }
                    ready.extend(decoded);
                }
                let tail = ready.split_off(length);
                Ok(Cow::Owned(std::mem::replace(ready, tail)))
            }
        }
    }
}

/// Decodes the next characters up to a padded group, and no more than a few
/// thousand; nothing at the end or at the next element.
fn decode_run(text: &mut &[u8]) -> Result<Vec<u8>, String> {
    let mut run = Vec::with_capacity(4096);
    let mut used = 0;
    for &byte in text.iter() {
        if byte == b'<' || (run.len() % 4 == 0 && (run.len() == 4096 || run.last() == Some(&b'=')))
        {
            break;
        }
        used += 1;
        if !byte.is_ascii_whitespace() {
            run.push(byte);
        }
    }
    *text = &text[used..];
    BASE64
        .decode(&run)
        .map_err(|error| format!("damaged base64: {error}"))
}
