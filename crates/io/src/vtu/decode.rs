//! The numbers of an array: words, base64 or bytes, perhaps compressed.
//!
//! Uncompressed binary data is `[bytes][data]`, compressed data
//! `[blocks][block size][size of the last block, or 0][compressed sizes…][blocks…]`,
//! with headers of 32 or 64 bits. In base64 header and data are encoded one
//! after the other or together; both are met with. (VTK, *VTK XML Formats*.)

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use base64::Engine as _;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use half::f16;
use tetrascope_core::Error;

use super::blocks::Blocks;
use super::document::{ArrayElement, Compressor, Data, Document};
use crate::grid::number::{Number, Numbers};
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::source::{Endian, Source, room};
use crate::vtk::parse_float;

/// The most bytes that a byte can become, by the formats: deflate codes at most 258 bytes in
/// 2 bits, LZ4 255 bytes in one, LZMA 273 bytes in 14 decisions. Each of these costs 0.022 bits
/// or more, as its probability stays at or below 1 - 31/2048. The sum allows for the headers of
/// tiny blocks.
fn largest(compressor: &Compressor, compressed: u64) -> u64 {
    let ratio = match compressor {
        Compressor::Zlib => 1032,
        Compressor::Lz4 => 255,
        #[cfg(feature = "lzma")]
        Compressor::Lzma => 7100,
        Compressor::None | Compressor::Unknown(_) => 1,
    };
    compressed.saturating_mul(ratio).saturating_add(64)
}

/// Bytes that are decoded at a time; whole numbers of any size and groups of base64.
pub(super) const CHUNK: usize = 48 << 10;

/// Indices that are handed on at a time.
const RUN: usize = 4096;

/// Takes decoded bytes, one part after the other.
pub(super) type Sink<'f> = &'f mut dyn FnMut(&[u8]) -> Result<(), Error>;

/// Reads the arrays of one file.
pub(super) struct Decoder<'a> {
    source: &'a Source,
    document: &'a Document<'a>,
    /// Encoded bytes read so far. Arrays do not overlap, so they are no more
    /// than the file has; arrays that all point at the same place are stopped.
    consumed: Arc<AtomicU64>,
    /// Bytes that [`Decoder::numbers`] has handed out.
    held: AtomicU64,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(source: &'a Source, document: &'a Document<'a>) -> Decoder<'a> {
        Decoder::counting(source, document, Arc::default())
    }

    /// A decoder that goes on counting the bytes that others have read of the file.
    pub(super) fn counting(
        source: &'a Source,
        document: &'a Document<'a>,
        consumed: Arc<AtomicU64>,
    ) -> Decoder<'a> {
        Decoder {
            source,
            document,
            consumed,
            held: AtomicU64::new(0),
        }
    }

    /// The count of bytes read so far.
    pub(super) fn consumed(&self) -> Arc<AtomicU64> {
        self.consumed.clone()
    }

    /// Calls `each` with the numbers of `tuples` tuples, all components of one after the other.
    pub(super) fn each_float(
        &self,
        array: &ArrayElement,
        tuples: u64,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        let count = self.count(array, tuples)?;
        if let Data::Ascii(text) = &array.data {
            return self.each_word(array, text, count, parse_float, each);
        }
        let (kind, endian) = (array.kind, self.document.endian);
        self.each_bytes(array, count, &mut |bytes| {
            let numbers = bytes.chunks_exact(kind.size());
            match kind {
                Number::F32 => numbers.for_each(|b| each(f64::from(endian.f32(b)))),
                Number::F64 => numbers.for_each(|b| each(endian.f64(b))),
                // Exact to 2⁵³.
                _ => numbers.for_each(|b| each(integer(kind, endian, b) as f64)),
            }
            Ok(())
        })
    }

    /// `tuples` tuples in the type that the array has.
    ///
    /// All that are asked for together are held to [`most_unpacked`].
    pub(super) fn numbers(&self, array: &ArrayElement, tuples: u64) -> Result<Numbers, Error> {
        let count = self.count(array, tuples)?;
        let bytes = count * array.kind.size() as u64; // checked in `count`
        let held = self.held.fetch_add(bytes, Ordering::Relaxed);
        let held = held.saturating_add(bytes);
        let length = self.source.bytes.len();
        if held > most_unpacked(length as u64) {
            return Err(self.source.error_with_help(
                format!("array '{}'", array.name),
                format!("{held} bytes of samples are packed in {length}, which is refused"),
                UNPACK,
            ));
        }
        let text;
        let (bytes, endian) = if let Data::Ascii(words) = &array.data {
            let size = array.kind.size();
            let words = self.words(array, words, count, |word| array.kind.word(word))?;
            text = words
                .iter()
                .flat_map(|word| &word[..size])
                .copied()
                .collect::<Vec<u8>>();
            (Cow::Borrowed(text.as_slice()), Endian::Little)
        } else {
            (self.bytes(array, count)?, self.document.endian)
        };
        let numbers = array.kind.read(&mut &bytes[..], endian, count as usize);
        numbers.map_err(|error| self.error(array, error.to_string()))
    }

    /// Calls `each` with `count` indices, some at a time.
    pub(super) fn each_indices(
        &self,
        array: &ArrayElement,
        count: u64,
        each: &mut dyn FnMut(&[u64]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        if matches!(array.kind, Number::F32 | Number::F64) || array.components != 1 {
            return Err(self.error(array, "indices must be whole numbers, one component each"));
        }
        let count = self.count(array, count)?;
        let negative = |number: u64, value: i128| {
            self.error(
                array,
                format!("value {number} is {value}, and indices begin at 0"),
            )
        };
        let mut indices = Vec::with_capacity(RUN);
        let mut number = 0;
        if let Data::Ascii(text) = &array.data {
            let whole = |word: &str| match word.parse::<u64>() {
                Ok(index) => Some(i128::from(index)),
                Err(_) => word.parse().ok(),
            };
            let mut result = Ok(());
            self.each_word(array, text, count, whole, &mut |value: i128| {
                if result.is_err() {
                    return;
                }
                match u64::try_from(value) {
                    Ok(index) => indices.push(index),
                    // What is wrong with an index before comes first.
                    Err(_) => result = each(&indices).and(Err(negative(number, value))),
                }
                number += 1;
                if indices.len() == RUN {
                    result = each(&indices);
                    indices.clear();
                }
            })?;
            return result.and_then(|()| each(&indices));
        }
        let (kind, endian) = (array.kind, self.document.endian);
        self.each_bytes(array, count, &mut |bytes| {
            for run in bytes.chunks(RUN * kind.size()) {
                indices.clear();
                let appended = append_indices(kind, endian, run, &mut indices);
                each(&indices)?;
                number += indices.len() as u64;
                appended.map_err(|value| negative(number, value))?;
            }
            Ok(())
        })
    }

    /// `count` indices; the caller bounds how many.
    pub(super) fn indices(&self, array: &ArrayElement, count: u64) -> Result<Vec<u64>, Error> {
        let mut values = Vec::new();
        self.each_indices(array, count, &mut |indices| {
            if values.is_empty() {
                values = room(count as usize)?;
            }
            values.extend_from_slice(indices);
            Ok(())
        })?;
        Ok(values)
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
        // A number takes a digit and a blank; if there are fewer, `each_word` says so.
        let mut values = room(count.min(text.len() as u64 / 2 + 1) as usize)?;
        self.each_word(array, text, count, parse, &mut |value| values.push(value))?;
        Ok(values)
    }

    fn each_word<T>(
        &self,
        array: &ArrayElement,
        text: &str,
        count: u64,
        parse: impl Fn(&str) -> Option<T>,
        each: &mut dyn FnMut(T),
    ) -> Result<(), Error> {
        self.consume(array, text.len() as u64)?;
        let mut found = 0;
        for word in text.split_ascii_whitespace() {
            let value = parse(word).ok_or_else(|| {
                let word: String = word.chars().take(40).collect();
                self.error(
                    array,
                    format!("value {found} is '{word}', not a number of its type"),
                )
            })?;
            if found < count {
                each(value);
            }
            found += 1;
        }
        if found != count {
            return Err(self.error(array, format!("{found} values where {count} are needed")));
        }
        Ok(())
    }

    /// The decoded bytes of `count` numbers.
    fn bytes(&self, array: &ArrayElement, count: u64) -> Result<Cow<'_, [u8]>, Error> {
        let mut bytes = Vec::new();
        self.each_bytes(array, count, &mut |part| {
            if bytes.is_empty() {
                bytes = room(count as usize * array.kind.size())?;
            }
            bytes.extend_from_slice(part);
            Ok(())
        })?;
        Ok(Cow::Owned(bytes))
    }

    /// Calls `each` with the bytes of `count` numbers, some whole numbers at a time.
    fn each_bytes(&self, array: &ArrayElement, count: u64, each: Sink) -> Result<(), Error> {
        let size = array.kind.size();
        let expected = count * size as u64; // checked in `count`
        if expected == 0 {
            return Ok(());
        }
        let mut stream = self.stream(array)?;
        let start = stream.rest();
        // The first bytes of a number whose other bytes are in the next part.
        let mut begun: Vec<u8> = Vec::with_capacity(size);
        let result = self.blocks(array, &mut stream, expected, &mut |mut bytes| {
            if !begun.is_empty() {
                let (head, tail) = bytes.split_at((size - begun.len()).min(bytes.len()));
                begun.extend_from_slice(head);
                bytes = tail;
                if begun.len() < size {
                    return Ok(());
                }
                each(&begun)?;
                begun.clear();
            }
            let (whole, rest) = bytes.split_at(bytes.len() - bytes.len() % size);
            begun.extend_from_slice(rest);
            each(whole)
        });
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

    /// Calls `sink` with the `expected` decoded bytes, in parts.
    fn blocks(
        &self,
        array: &ArrayElement,
        stream: &mut Stream,
        expected: u64,
        sink: Sink,
    ) -> Result<(), Error> {
        let compressor = &self.document.compressor;
        if let Compressor::Unknown(name) = compressor {
            return Err(self.source.error_with_help(
                format!("array '{}'", array.name),
                format!("compression with {name} is not read"),
                match name == "vtkLZMADataCompressor" {
                    true => "read it with the feature `lzma`, or save the file with zlib or LZ4",
                    false => "save the file with zlib, LZ4 or no compression",
                },
            ));
        }
        let wrong =
            |found: u64| self.error(array, format!("{found} bytes where {expected} are needed"));
        if *compressor == Compressor::None {
            let mut left = self.header(array, stream)?;
            if left != expected {
                return Err(wrong(left));
            }
            if left > stream.rest() {
                let rest = stream.rest();
                return Err(self.truncated(
                    array,
                    format!("{left} bytes of data where only {rest} are left"),
                ));
            }
            while left > 0 {
                let part = self.take(array, stream, left.min(CHUNK as u64))?;
                left -= part.len() as u64;
                sink(&part)?;
            }
            return Ok(());
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
        let mut sizes = room(block_count as usize)?;
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
        let damaged = |block: u64, size: u64| {
            self.error(
                array,
                format!("compressed block {block} is damaged or does not hold {size} bytes"),
            )
        };
        let mut blocks = Blocks::new(compressor);
        for (number, compressed) in (0..block_count).zip(sizes) {
            let is_last = number + 1 == block_count;
            let size = match is_last && last_size != 0 {
                true => last_size,
                false => block_size,
            };
            let taken = self.take(array, stream, compressed);
            let taken = taken.and_then(|bytes| match size <= largest(compressor, compressed) {
                true => Ok(bytes),
                false => Err(damaged(number, size)),
            });
            let failure = match taken {
                Ok(bytes) => {
                    blocks.push(number, bytes, size as usize);
                    None
                }
                Err(failure) => Some(failure),
            };
            // What is wrong with blocks before comes first.
            if (failure.is_some() || is_last || blocks.are_enough())
                && let Some((number, size)) = blocks.decompress(sink)?
            {
                return Err(damaged(number, size as u64));
            }
            if let Some(failure) = failure {
                return Err(failure);
            }
        }
        Ok(())
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
        let before = self.consumed.fetch_add(length, Ordering::Relaxed);
        let sum = before.saturating_add(length);
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
        Number::F16 => i128::from(f16::from_bits(endian.u16(bytes)).to_f32() as i64),
        Number::F32 => i128::from(endian.f32(bytes) as i64),
        Number::F64 => i128::from(endian.f64(bytes) as i64),
    }
}

/// Appends whole numbers as indices, up to the first that is negative, which is the error.
fn append_indices(
    kind: Number,
    endian: Endian,
    bytes: &[u8],
    indices: &mut Vec<u64>,
) -> Result<(), i128> {
    let mut numbers = bytes.chunks_exact(kind.size());
    // The types of large meshes, without a decision for each number.
    match kind {
        Number::U8 => indices.extend(bytes.iter().map(|&byte| u64::from(byte))),
        Number::I32 if numbers.clone().all(|b| endian.i32(b) >= 0) => {
            indices.extend(numbers.map(|b| endian.i32(b) as u64));
        }
        Number::I64 if numbers.clone().all(|b| endian.i64(b) >= 0) => {
            indices.extend(numbers.map(|b| endian.i64(b) as u64));
        }
        _ => {
            return numbers.try_for_each(|number| {
                let value = integer(kind, endian, number);
                indices.push(u64::try_from(value).map_err(|_| value)?);
                Ok(())
            });
        }
    }
    Ok(())
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
