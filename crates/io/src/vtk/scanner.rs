//! Words, lines and arrays of a legacy VTK file, one after the other.

use tetrascope_core::Error;

use crate::grid::number::{Number, Numbers};
use crate::source::{Endian, Source, room};

/// How an array's numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bit,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Kind {
    /// By the names of vtkDataWriter. `vtkIdType` is written as 32-bit
    /// integers, whatever its size in memory.
    pub(super) fn of(name: &str) -> Option<Kind> {
        Some(match name.to_ascii_lowercase().as_str() {
            "bit" => Kind::Bit,
            "char" | "signed_char" | "vtktypeint8" => Kind::I8,
            "unsigned_char" | "vtktypeuint8" => Kind::U8,
            "short" | "vtktypeint16" => Kind::I16,
            "unsigned_short" | "vtktypeuint16" => Kind::U16,
            "int" | "vtkidtype" | "vtktypeint32" => Kind::I32,
            "unsigned_int" | "vtktypeuint32" => Kind::U32,
            "long" | "long_long" | "vtktypeint64" => Kind::I64,
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => Kind::U64,
            "float" | "vtktypefloat32" => Kind::F32,
            "double" | "vtktypefloat64" => Kind::F64,
            _ => return None,
        })
    }

    /// The same type elsewhere; bits have none.
    pub(super) fn number(self) -> Option<Number> {
        Some(match self {
            Kind::Bit => return None,
            Kind::I8 => Number::I8,
            Kind::U8 => Number::U8,
            Kind::I16 => Number::I16,
            Kind::U16 => Number::U16,
            Kind::I32 => Number::I32,
            Kind::U32 => Number::U32,
            Kind::I64 => Number::I64,
            Kind::U64 => Number::U64,
            Kind::F32 => Number::F32,
            Kind::F64 => Number::F64,
        })
    }

    fn size(self) -> u64 {
        match self {
            Kind::Bit | Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::I64 | Kind::U64 | Kind::F64 => 8,
        }
    }
}

/// A place in the file.
pub(super) struct Scanner<'a> {
    source: &'a Source,
    pub(super) at: usize,
    /// Numbers are big-endian bytes, else words.
    pub(super) binary: bool,
}

impl<'a> Scanner<'a> {
    pub(super) fn new(source: &'a Source) -> Scanner<'a> {
        Scanner {
            source,
            at: 0,
            binary: false,
        }
    }

    fn rest(&self) -> &'a [u8] {
        &self.source.bytes[self.at..]
    }

    /// The rest of the line, without its end.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += (length + 1).min(rest.len());
        rest[..length].trim_ascii_end()
    }

    /// The bytes up to the next blank of any line.
    fn token(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest();
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let length = rest[start..]
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len() - start);
        self.at += start + length;
        Some(&rest[start..start + length])
    }

    /// The next word of any line; `None` at the end of the file.
    pub(super) fn word(&mut self) -> Result<Option<&'a str>, Error> {
        let Some(token) = self.token() else {
            return Ok(None);
        };
        std::str::from_utf8(token).map(Some).map_err(|_| {
            let bytes = &token[..token.len().min(8)];
            let bytes: Vec<String> = bytes.iter().map(|b| format!("{b:02x}")).collect();
            self.at -= token.len();
            self.truncated(format!(
                "the bytes {} where a word is needed",
                bytes.join(" ")
            ))
        })
    }

    /// Moves past the next word if it is `word`, in any case of letters.
    pub(super) fn skip_word(&mut self, word: &str) -> bool {
        let at = self.at;
        let found = self
            .token()
            .is_some_and(|token| token.eq_ignore_ascii_case(word.as_bytes()));
        if !found {
            self.at = at;
        }
        found
    }

    /// The next word of this line.
    pub(super) fn word_in_line(&mut self) -> Result<Option<&'a str>, Error> {
        let rest = self.rest();
        let spaces = rest
            .iter()
            .take_while(|&&b| b == b' ' || b == b'\t')
            .count();
        match rest.get(spaces) {
            None | Some(b'\n' | b'\r') => Ok(None),
            Some(_) => self.word(),
        }
    }

    /// The word that must follow.
    pub(super) fn expect(&mut self, what: &str) -> Result<&'a str, Error> {
        self.word()?
            .ok_or_else(|| self.truncated(format!("the file ends where {what} is needed")))
    }

    /// A number of things.
    pub(super) fn count(&mut self, what: &str) -> Result<u64, Error> {
        let word = self.expect(what)?;
        word.parse()
            .map_err(|_| self.error(format!("'{}' is not {what}", clip(word))))
    }

    /// The name of a type of numbers.
    pub(super) fn kind(&mut self) -> Result<Kind, Error> {
        let word = self.expect("a type of numbers")?;
        Kind::of(word)
            .ok_or_else(|| self.error(format!("'{}' is not a type of numbers", clip(word))))
    }

    /// The name of an array: what is not a letter or digit may be in percent code.
    pub(super) fn name(&mut self) -> Result<String, Error> {
        match self.token() {
            Some(token) => Ok(decode_percent(token)),
            None => Err(self.truncated("the file ends where a name is needed")),
        }
    }

    /// Calls `each` with `count` numbers as f64 (integers are exact to 2⁵³).
    pub(super) fn each_float(
        &mut self,
        kind: Kind,
        count: u64,
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        if !self.binary {
            return self.each_word(count, parse_float, each);
        }
        if kind == Kind::Bit {
            let bytes = self.bytes(count.div_ceil(8))?;
            let bit = |i: usize| f64::from(bytes[i / 8] >> (7 - i % 8) & 1);
            (0..count as usize).for_each(|i| each(bit(i)));
            return Ok(());
        }
        let big = Endian::Big;
        let read = |b: &[u8]| match kind {
            Kind::Bit | Kind::U8 => f64::from(b[0]),
            Kind::I8 => f64::from(b[0] as i8),
            Kind::I16 => f64::from(big.i16(b)),
            Kind::U16 => f64::from(big.u16(b)),
            Kind::I32 => f64::from(big.i32(b)),
            Kind::U32 => f64::from(big.u32(b)),
            Kind::I64 => big.i64(b) as f64,
            Kind::U64 => big.u64(b) as f64,
            Kind::F32 => f64::from(big.f32(b)),
            Kind::F64 => big.f64(b),
        };
        self.each_number(kind, count, |bytes| each(read(bytes)))
    }

    /// Bytes of the file.
    pub(super) fn length(&self) -> u64 {
        self.source.bytes.len() as u64
    }

    /// `count` numbers as f64.
    pub(super) fn floats(&mut self, kind: Kind, count: u64) -> Result<Vec<f64>, Error> {
        let mut values = self.room_for(kind, count, 1)?;
        self.each_float(kind, count, &mut |value| values.push(value))?;
        Ok(values)
    }

    /// Moves past `count` numbers, of which words at least look like some.
    pub(super) fn skip_numbers(&mut self, kind: Kind, count: u64) -> Result<(), Error> {
        if self.binary {
            return self.each_float(kind, count, &mut |_| {});
        }
        self.check_fits(kind, count)?;
        let looks_right = |word: &str| {
            let digit = |b: &u8| b.is_ascii_digit() || b"+-.".contains(b);
            (word.as_bytes().first().is_some_and(digit) || parse_float(word).is_some())
                .then_some(())
        };
        self.each_word(count, looks_right, |()| {})
    }

    /// `count` numbers in their own type; bits become bytes.
    pub(super) fn numbers_of(&mut self, kind: Kind, count: u64) -> Result<Numbers, Error> {
        let Some(number) = kind.number() else {
            let bits = self.floats(kind, count)?;
            return Ok(Numbers::U8(bits.into_iter().map(|bit| bit as u8).collect()));
        };
        let mut bytes = Vec::new();
        let (bytes, endian) = if self.binary {
            let length = count.checked_mul(kind.size());
            let length = length.ok_or_else(|| self.too_many(count))?;
            (self.bytes(length)?, Endian::Big)
        } else {
            for word in self.words(count, |word| number.word(word))? {
                bytes.extend_from_slice(&word[..number.size()]);
            }
            (bytes.as_slice(), Endian::Little)
        };
        let numbers = number.read(&mut &bytes[..], endian, count as usize);
        numbers.map_err(|error| self.error(error.to_string()))
    }

    /// `count` indices; negative ones keep their bits, which are larger than any mesh.
    pub(super) fn indices(&mut self, kind: Kind, count: u64) -> Result<Vec<u64>, Error> {
        if !self.binary {
            return self.words(count, parse_index);
        }
        let mut values = self.room_for(kind, count, 1)?;
        let mut push = |value| values.push(value);
        let big = Endian::Big;
        match kind {
            Kind::I32 => self.each_number(kind, count, |b| push(i64::from(big.i32(b)) as u64)),
            Kind::U32 => self.each_number(kind, count, |b| push(u64::from(big.u32(b)))),
            Kind::I64 | Kind::U64 => self.each_number(kind, count, |b| push(big.u64(b))),
            _ => Err(self.error("indices must be 32- or 64-bit integers")),
        }?;
        Ok(values)
    }

    /// Moves past `count` texts.
    pub(super) fn skip_texts(&mut self, count: u64) -> Result<(), Error> {
        self.line();
        for _ in 0..count {
            if self.rest().is_empty() {
                return Err(self.truncated("the file ends within an array of texts"));
            }
            if !self.binary {
                self.line();
                continue;
            }
            // The first two bits say how many bytes hold the length (vtkDataWriter).
            let width = match self.rest()[0] >> 6 {
                3 => 1,
                2 => 2,
                1 => 4,
                _ => 8,
            };
            let mut length = 0;
            for (i, &byte) in self.exactly(width)?.iter().enumerate() {
                let byte = if i == 0 { byte & 0x3f } else { byte };
                length = length << 8 | u64::from(byte);
            }
            self.exactly(length)?;
        }
        Ok(())
    }

    /// Moves past the lines of a METADATA block, which an empty line ends. It may name the
    /// `components` of the array before it; an empty line is there a component without a name.
    pub(super) fn metadata(&mut self, components: usize) -> Vec<Option<String>> {
        self.line();
        let mut names = Vec::new();
        while !self.rest().is_empty() {
            let line = self.line();
            if line.eq_ignore_ascii_case(b"COMPONENT_NAMES") && names.is_empty() {
                for _ in 0..components {
                    let name = decode_percent(self.line());
                    names.push((!name.is_empty()).then_some(name));
                }
            } else if line.is_empty() {
                break;
            }
        }
        names
    }

    /// Room for `tuples` tuples of `components` numbers, if so many can follow.
    pub(super) fn room_for<T>(
        &self,
        kind: Kind,
        tuples: u64,
        components: u64,
    ) -> Result<Vec<T>, Error> {
        self.check_fits(kind, tuples.saturating_mul(components))?;
        room(tuples as usize)
    }

    /// Whether the rest of the file can hold `count` numbers.
    fn check_fits(&self, kind: Kind, count: u64) -> Result<(), Error> {
        let most = match (self.binary, kind) {
            // A number takes a digit and a space.
            (false, _) => self.rest().len() as u64 / 2 + 1,
            (true, Kind::Bit) => (self.rest().len() as u64).saturating_mul(8),
            (true, kind) => self.rest().len() as u64 / kind.size(),
        };
        match count > most {
            true => Err(self.too_many(count)),
            false => Ok(()),
        }
    }

    fn words<T>(&mut self, count: u64, parse: impl Fn(&str) -> Option<T>) -> Result<Vec<T>, Error> {
        self.check_fits(Kind::U8, count)?;
        let mut values = room(count as usize)?;
        self.each_word(count, parse, |value| values.push(value))?;
        Ok(values)
    }

    fn each_word<T>(
        &mut self,
        count: u64,
        parse: impl Fn(&str) -> Option<T>,
        mut each: impl FnMut(T),
    ) -> Result<(), Error> {
        for _ in 0..count {
            let word = self.expect("a number")?;
            let value = parse(word).ok_or_else(|| {
                self.error(format!("'{}' is not a number of its type", clip(word)))
            })?;
            each(value);
        }
        Ok(())
    }

    fn each_number(
        &mut self,
        kind: Kind,
        count: u64,
        each: impl FnMut(&[u8]),
    ) -> Result<(), Error> {
        let length = count
            .checked_mul(kind.size())
            .ok_or_else(|| self.too_many(count))?;
        let bytes = self.bytes(length)?;
        bytes.chunks_exact(kind.size() as usize).for_each(each);
        Ok(())
    }

    /// Bytes that begin on the next line.
    fn bytes(&mut self, length: u64) -> Result<&'a [u8], Error> {
        self.line();
        self.exactly(length)
    }

    /// Where the bytes of an array begin whose head was just read.
    pub(super) fn data_start(&mut self) -> u64 {
        self.line();
        self.at as u64
    }

    fn exactly(&mut self, length: u64) -> Result<&'a [u8], Error> {
        let rest = self.rest();
        if length > rest.len() as u64 {
            return Err(self.truncated(format!(
                "{length} bytes of data where only {} are left",
                rest.len()
            )));
        }
        self.at += length as usize;
        Ok(&rest[..length as usize])
    }

    fn too_many(&self, count: u64) -> Error {
        self.truncated(format!(
            "{count} numbers cannot be in the {} bytes that are left",
            self.rest().len()
        ))
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
}

/// A number in words, also as C libraries write what is not a number.
pub(crate) fn parse_float(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let word = word.trim_start_matches(['-', '+']).as_bytes();
        let is_nan =
            word.len() > 3 && (word[..3].eq_ignore_ascii_case(b"nan") || word.starts_with(b"1.#"));
        is_nan.then_some(f64::NAN)
    })
}

/// An index; a negative one keeps its bits.
fn parse_index(word: &str) -> Option<u64> {
    word.parse()
        .ok()
        .or_else(|| Some(word.parse::<i64>().ok()? as u64))
}

/// At most 40 characters of a word, for a message.
pub(super) fn clip(word: &str) -> String {
    word.chars().take(40).collect()
}

/// "Nodal Stress" for "Nodal%20Stress".
fn decode_percent(bytes: &[u8]) -> String {
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = bytes
            .get(at + 1..at + 3)
            .filter(|_| bytes[at] == b'%')
            .filter(|digits| digits.iter().all(u8::is_ascii_hexdigit))
            .and_then(|digits| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok());
        decoded.push(code.unwrap_or(bytes[at]));
        at += if code.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&decoded).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_codes_are_decoded_and_percents_kept() {
        assert_eq!(decode_percent(b"Nodal%20Stress"), "Nodal Stress");
        assert_eq!(decode_percent(b"%C3%A9%"), "é%");
        assert_eq!(decode_percent(b"100%zz%2"), "100%zz%2");
    }

    #[test]
    fn what_is_not_a_number_is_read_in_every_spelling() {
        for word in ["nan", "-nan", "NaN", "-nan(ind)", "1.#QNAN", "-1.#IND"] {
            assert!(parse_float(word).is_some_and(f64::is_nan), "{word}");
        }
        assert_eq!(parse_float("-inf"), Some(f64::NEG_INFINITY));
        assert_eq!(parse_float("1e-3"), Some(1e-3));
        assert_eq!(parse_float("äää"), None);
        assert_eq!(parse_float("x"), None);
    }
}
