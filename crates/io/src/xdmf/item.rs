//! Numbers of a `DataItem`: in the file itself, in a binary file, or in an HDF5 file.

use std::fmt;
use std::io::{Seek as _, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tetrascope_core::Error;

use crate::fields;
use crate::grid::header::clip;
use crate::grid::number::{Number, Numbers};
#[cfg(feature = "hdf5")]
use crate::hdf5::View;
use crate::pieces::EachIndices;
use crate::pieces::sections::Indices;
use crate::source::{Endian, Source, format_error, open_file, room};
use crate::vtu::line;

/// Numbers that are read at a time.
const PART: u64 = 1 << 14;

/// A list of numbers.
#[derive(Clone)]
pub(super) struct Item {
    pub(super) source: Arc<Source>,
    /// Byte of the element in the file.
    pub(super) byte: usize,
    pub(super) number: Number,
    pub(super) shape: Vec<u64>,
    pub(super) place: Place,
    /// The same for items that say the same of the same file.
    pub(super) signature: String,
}

#[derive(Clone, Debug)]
pub(super) enum Place {
    /// Words in the file itself.
    Text(Range<usize>),
    Binary {
        path: PathBuf,
        seek: u64,
        endian: Endian,
    },
    #[cfg(feature = "hdf5")]
    Hdf5(View),
}

/// How many numbers of a shape there are.
pub(super) fn product(shape: &[u64]) -> u64 {
    shape.iter().fold(1, |n: u64, d| n.saturating_mul(*d))
}

impl Item {
    /// How many numbers there are.
    pub(super) fn count(&self) -> u64 {
        product(&self.shape)
    }

    /// How many bytes they take.
    pub(super) fn bytes(&self) -> u64 {
        self.count().saturating_mul(self.number.size() as u64)
    }

    /// The ε of the numbers' type.
    pub(super) fn epsilon(&self) -> f64 {
        match self.number {
            Number::F32 => f32::EPSILON.into(),
            _ => f64::EPSILON,
        }
    }

    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        let text = String::from_utf8_lossy(&self.source.bytes);
        self.source
            .error(format!("{}, <DataItem>", line(&text, self.byte)), what)
    }

    /// All numbers in their own type. The caller has checked how many they are.
    pub(super) fn numbers(&self) -> Result<Numbers, Error> {
        let count = self.count() as usize;
        let unread = |error: std::io::Error| self.error(format!("it cannot be read: {error}"));
        match &self.place {
            Place::Text(range) => {
                let mut bytes: Vec<u8> = room(count * self.number.size())?;
                self.each_word(range, |word| {
                    let number = self
                        .number
                        .word(word)
                        .ok_or_else(|| self.not_a_number(word))?;
                    bytes.extend_from_slice(&number[..self.number.size()]);
                    Ok(())
                })?;
                self.number
                    .read(&mut &bytes[..], Endian::Little, count)
                    .map_err(unread)
            }
            Place::Binary { path, seek, endian } => {
                let (mut file, _) = open_file(path)?;
                file.seek(SeekFrom::Start(*seek)).map_err(unread)?;
                self.number.read(&mut file, *endian, count).map_err(unread)
            }
            #[cfg(feature = "hdf5")]
            Place::Hdf5(view) => view.numbers(),
        }
    }

    fn not_a_number(&self, word: &str) -> Error {
        self.error(format!("'{}' is not a number of its type", clip(word)))
    }

    /// Calls `each` with the words of the text, which must be as many as there are numbers.
    fn each_word(
        &self,
        range: &Range<usize>,
        mut each: impl FnMut(&str) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let text = std::str::from_utf8(&self.source.bytes[range.clone()]).unwrap_or_default();
        let words = text.split(|c: char| c.is_ascii_whitespace() || c == ',');
        let needed = self.count();
        let mut found = 0;
        for word in words.filter(|word| !word.is_empty()) {
            found += 1;
            if found > needed {
                break;
            }
            each(word)?;
        }
        match found == needed {
            true => Ok(()),
            false if found > needed => Err(self.error(format!(
                "there are more than the {needed} numbers that are needed"
            ))),
            false => Err(self.error(format!(
                "there are {found} numbers, and {needed} are needed"
            ))),
        }
    }

    /// All numbers as indices, of at most `most`.
    #[cfg(feature = "hdf5")] // parts of items need it
    pub(super) fn indices(&self, most: u64) -> Result<Vec<u64>, Error> {
        if self.count() > most {
            return Err(self.error(format!("{} numbers; up to {most} are read", self.count())));
        }
        let mut all = room(self.count() as usize)?;
        self.each_indices(&mut |indices| {
            all.extend_from_slice(indices);
            Ok(())
        })?;
        Ok(all)
    }

    /// All numbers, of at most `most`.
    pub(super) fn floats(&self, most: u64) -> Result<Vec<f64>, Error> {
        if self.count() > most {
            return Err(self.error(format!("{} numbers; up to {most} are read", self.count())));
        }
        let mut all = room(self.count() as usize)?;
        fields::Numbers::each(self, &mut |value| all.push(value))?;
        Ok(all)
    }

    /// Calls `each` with every number of a binary file.
    fn each_binary(
        &self,
        path: &Path,
        (seek, endian): (u64, Endian),
        each: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        let unread = |error: std::io::Error| {
            format_error(
                path,
                format!("byte {seek}"),
                format!("it cannot be read: {error}"),
            )
        };
        let (mut file, _) = open_file(path)?;
        file.seek(SeekFrom::Start(seek)).map_err(unread)?;
        let mut left = self.count();
        while left > 0 {
            let part = left.min(PART);
            let numbers = self
                .number
                .read(&mut file, endian, part as usize)
                .map_err(unread)?;
            (0..numbers.len()).for_each(|i| each(numbers.get(i)));
            left -= part;
        }
        Ok(())
    }
}

impl fmt::Debug for Item {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "data item {}", self.signature)
    }
}

impl fields::Numbers for Item {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        match &self.place {
            Place::Text(range) => self.each_word(range, |word| {
                each(crate::parse_float(word).ok_or_else(|| self.not_a_number(word))?);
                Ok(())
            }),
            Place::Binary { path, seek, endian } => self.each_binary(path, (*seek, *endian), each),
            #[cfg(feature = "hdf5")]
            Place::Hdf5(view) => view.each_float(each),
        }
    }
}

impl Indices for Item {
    fn count(&self) -> u64 {
        Item::count(self)
    }

    fn each_indices(&self, each: EachIndices) -> Result<(), Error> {
        #[cfg(feature = "hdf5")]
        if let Place::Hdf5(view) = &self.place {
            return view.each_indices(each);
        }
        let mut part: Vec<u64> = Vec::new();
        let mut wrong = Ok(());
        fields::Numbers::each(self, &mut |value| {
            if wrong.is_err() {
                return;
            }
            // Whole numbers up to 2^53 are exact.
            if !(value >= 0.0 && value.fract() == 0.0 && value < 9e15) {
                wrong = Err(self.error(format!("{value} is not a whole number from 0 on")));
                return;
            }
            part.push(value as u64);
            if part.len() as u64 >= PART {
                wrong = each(&part);
                part.clear();
            }
        })?;
        wrong?;
        each(&part)
    }
}
