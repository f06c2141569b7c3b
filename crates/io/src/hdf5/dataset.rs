//! Numbers and texts of datasets.

use std::fmt;
use std::ops::Range;
use std::sync::Arc;

#[cfg(feature = "exodus")]
use hdf5_reader::StringSize;
use hdf5_reader::messages::datatype::Datatype;
use hdf5_reader::{Attribute, H5Type, SliceInfo, SliceInfoElem};
use tetrascope_core::Error;

use super::{File, one_line};
use crate::fields;
use crate::grid::number::{Number, Numbers};
use crate::pieces::EachIndices;
use crate::pieces::sections::Indices;
use crate::source::{reserve, room};

/// Numbers that are read at a time, unless the chunks of a dataset have more.
const PART: u64 = 1 << 17;

/// A dataset of a file.
#[derive(Clone)]
pub(crate) struct Dataset {
    file: Arc<File>,
    data: Arc<hdf5_reader::Dataset>,
    /// From the root.
    path: Arc<str>,
}

/// Some of the numbers of a dataset: those at certain places of its first dimensions, then a
/// range of the next one.
#[derive(Clone)]
pub(crate) struct View {
    dataset: Dataset,
    places: Vec<u64>,
    rows: Range<u64>,
}

/// The type of numbers; `None` if they are something else.
fn number(kind: &Datatype) -> Option<Number> {
    Some(match kind {
        Datatype::FixedPoint { size, signed, .. } => match (size, signed) {
            (1, true) => Number::I8,
            (1, false) => Number::U8,
            (2, true) => Number::I16,
            (2, false) => Number::U16,
            (4, true) => Number::I32,
            (4, false) => Number::U32,
            (8, true) => Number::I64,
            (8, false) => Number::U64,
            _ => return None,
        },
        Datatype::FloatingPoint { size: 4, .. } => Number::F32,
        Datatype::FloatingPoint { size: 8, .. } => Number::F64,
        _ => return None,
    })
}

/// The numbers of an attribute, if it holds numbers.
pub(super) fn attribute_numbers(attribute: &Attribute) -> Option<Vec<f64>> {
    fn read<T: H5Type>(attribute: &Attribute, float: fn(T) -> f64) -> Option<Vec<f64>> {
        let values: Vec<T> = attribute.read_1d().ok()?;
        Some(values.into_iter().map(float).collect())
    }
    match number(&attribute.datatype)? {
        Number::I8 => read(attribute, |v: i8| v.into()),
        Number::U8 => read(attribute, |v: u8| v.into()),
        Number::I16 => read(attribute, |v: i16| v.into()),
        Number::U16 => read(attribute, |v: u16| v.into()),
        Number::I32 => read(attribute, |v: i32| v.into()),
        Number::U32 => read(attribute, |v: u32| v.into()),
        Number::I64 => read(attribute, |v: i64| v as f64),
        Number::U64 => read(attribute, |v: u64| v as f64),
        Number::F16 => None, // `number` does not give it
        Number::F32 => read(attribute, |v: f32| v.into()),
        Number::F64 => read(attribute, |v: f64| v),
    }
}

impl Dataset {
    pub(super) fn new(file: &Arc<File>, data: hdf5_reader::Dataset, path: String) -> Dataset {
        Dataset {
            file: file.clone(),
            data: Arc::new(data),
            path: path.into(),
        }
    }

    pub(crate) fn shape(&self) -> &[u64] {
        self.data.shape()
    }

    /// The type of its numbers; `None` if it holds something else.
    pub(crate) fn number(&self) -> Option<Number> {
        number(self.data.dtype())
    }

    /// Whether it holds texts of fixed length, such as netCDF's characters.
    #[cfg(feature = "exodus")]
    pub(crate) fn is_text(&self) -> bool {
        let kind = self.data.dtype();
        matches!(
            kind,
            Datatype::String {
                size: StringSize::Fixed(_),
                ..
            }
        )
    }

    /// The text of an attribute, as [`Group::text`](super::Group::text).
    pub(crate) fn attribute_text(&self, name: &str) -> Option<String> {
        let attribute = self.data.attribute(name).ok()?;
        super::text(&attribute)
    }

    /// The texts of a dataset of them, of characters those along the last dimension.
    #[cfg(feature = "exodus")]
    pub(crate) fn texts(&self, most_bytes: u64) -> Result<Vec<String>, Error> {
        let characters = match self.data.dtype() {
            Datatype::String {
                size: StringSize::Fixed(size),
                ..
            } => u64::from(*size),
            _ => return Ok(Vec::new()),
        };
        let shape = self.shape();
        let (texts, length) = match shape {
            [.., last] if characters == 1 => (&shape[..shape.len() - 1], *last),
            _ => (shape, characters),
        };
        let bytes = shape.iter().fold(characters, |n, d| n.saturating_mul(*d));
        if bytes > most_bytes || length == 0 {
            return Err(self.error(format!("{texts:?} texts of {length} bytes are not read")));
        }
        let bytes = self.data.read_raw_bytes();
        let bytes = bytes.map_err(|error| self.error(one_line(&error)))?;
        let texts = bytes.chunks_exact(length as usize).map(|text| {
            let end = text.iter().position(|&byte| byte == 0);
            let text = String::from_utf8_lossy(&text[..end.unwrap_or(text.len())]);
            text.trim_matches(' ').to_owned()
        });
        Ok(texts.collect())
    }

    /// An error about the dataset.
    pub(crate) fn error(&self, what: impl Into<String>) -> Error {
        self.file.error(format!("dataset '{}'", self.path), what)
    }

    /// The numbers at `places` of its first dimensions and in `rows` of the next.
    ///
    /// # Errors
    /// Those are not there, or the dataset holds something else than numbers.
    pub(crate) fn view(&self, places: &[u64], rows: Range<u64>) -> Result<View, Error> {
        let shape = self.shape();
        if self.number().is_none() {
            return Err(self.error("it holds no numbers of 8 to 64 bits"));
        }
        let is_inside = places.len() < shape.len()
            && places.iter().zip(shape).all(|(place, size)| place < size)
            && rows.start <= rows.end
            && rows.end <= shape[places.len()];
        if !is_inside {
            let places: String = places.iter().map(|place| format!("{place}, ")).collect();
            let (start, end) = (rows.start, rows.end);
            return Err(self.error(format!(
                "it has {shape:?} numbers, and those at [{places}{start} to {end}] are needed"
            )));
        }
        Ok(View {
            dataset: self.clone(),
            places: places.to_vec(),
            rows,
        })
    }

    /// All numbers of a dataset of at most `most`, as they are to 2⁵³.
    pub(crate) fn all(&self, most: u64) -> Result<Vec<f64>, Error> {
        let shape = self.shape();
        let count = shape.iter().fold(1, |n: u64, d| n.saturating_mul(*d));
        if count > most {
            return Err(self.error(format!("{count} numbers; up to {most} are read")));
        }
        let Some(&rows) = shape.first() else {
            return Err(self.error("it is one number where a list is needed"));
        };
        self.view(&[], 0..rows)?.floats()
    }
}

impl View {
    pub(crate) fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// How many numbers belong to a row.
    fn row(&self) -> u64 {
        let rest = &self.dataset.shape()[self.places.len() + 1..];
        rest.iter().fold(1, |n, d| n.saturating_mul(*d))
    }

    /// How many numbers there are.
    pub(crate) fn count(&self) -> u64 {
        let rows = self.rows.end - self.rows.start;
        rows.saturating_mul(self.row())
    }

    /// The bytes of the numbers.
    pub(crate) fn bytes(&self) -> u64 {
        let size = self.dataset.number().map_or(0, Number::size);
        self.count().saturating_mul(size as u64)
    }

    /// The same view of other rows of its own.
    fn part(&self, rows: Range<u64>) -> View {
        View {
            rows,
            ..self.clone()
        }
    }

    /// Cuts the rows into parts, each of whole chunks but for the first and last.
    fn parts(&self) -> impl Iterator<Item = Range<u64>> {
        let chunks = self.dataset.data.chunks().unwrap_or_default();
        let chunk = chunks.get(self.places.len()).map_or(1, |&n| u64::from(n));
        let chunk = chunk.max(1);
        let rows = (PART / self.row().max(1)).max(1);
        let step = rows.div_ceil(chunk).saturating_mul(chunk);
        let Range { mut start, end } = self.rows;
        std::iter::from_fn(move || {
            let from = start;
            let next = (from / step).saturating_add(1).saturating_mul(step);
            start = next.min(end);
            (from < end).then_some(from..start)
        })
    }

    fn slice<T: H5Type>(&self) -> Result<Vec<T>, Error> {
        let places = self.places.iter().map(|&place| SliceInfoElem::Index(place));
        let rows = SliceInfoElem::Slice {
            start: self.rows.start,
            end: self.rows.end,
            step: 1,
        };
        let rest = &self.dataset.shape()[self.places.len() + 1..];
        let rest = rest.iter().map(|&size| SliceInfoElem::Slice {
            start: 0,
            end: size,
            step: 1,
        });
        let selection = SliceInfo {
            selections: places.chain([rows]).chain(rest).collect(),
        };
        let wrong = |what: String| self.dataset.error(what);
        let values = self.dataset.data.read_slice::<T>(&selection);
        let values = values.map_err(|error| wrong(one_line(&error)))?;
        if values.len() as u64 != self.count() || !values.is_standard_layout() {
            return Err(wrong(format!(
                "{} numbers came where {} are needed",
                values.len(),
                self.count()
            )));
        }
        Ok(values.into_raw_vec_and_offset().0)
    }

    /// The numbers in their own type, all at once. The caller has checked how many they are.
    pub(crate) fn numbers(&self) -> Result<Numbers, Error> {
        let number = self.dataset.number().expect("checked by `view`");
        Ok(match number {
            Number::I8 => {
                let values: Vec<i8> = self.slice()?;
                Numbers::I16(values.into_iter().map(i16::from).collect())
            }
            Number::U8 => Numbers::U8(self.slice()?),
            Number::I16 => Numbers::I16(self.slice()?),
            Number::U16 => Numbers::U16(self.slice()?),
            Number::I32 => Numbers::I32(self.slice()?),
            Number::U32 => Numbers::U32(self.slice()?),
            Number::I64 => Numbers::I64(self.slice()?),
            Number::U64 => Numbers::U64(self.slice()?),
            // `number` does not give it.
            Number::F16 => return Err(self.dataset.error("16-bit floats are not read")),
            Number::F32 => Numbers::F32(self.slice()?),
            Number::F64 => Numbers::F64(self.slice()?),
        })
    }

    /// Calls `each` with every number, exact to 2⁵³, a part at a time.
    pub(crate) fn each_float(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        for rows in self.parts() {
            match self.part(rows).numbers()? {
                // The usual types without a choice for each number.
                Numbers::F32(values) => values.into_iter().for_each(|v| each(v.into())),
                Numbers::F64(values) => values.into_iter().for_each(&mut *each),
                values => (0..values.len()).for_each(|i| each(values.get(i))),
            }
        }
        Ok(())
    }

    /// All numbers, exact to 2⁵³. The caller has checked how many they are.
    pub(crate) fn floats(&self) -> Result<Vec<f64>, Error> {
        let mut values = room(self.count() as usize)?;
        self.each_float(&mut |value| values.push(value))?;
        Ok(values)
    }

    /// Calls `each` with the numbers, which must be whole and not below 0, a part at a time.
    pub(crate) fn each_indices(&self, each: EachIndices) -> Result<(), Error> {
        let mut indices = Vec::new();
        let mut done = 0;
        for rows in self.parts() {
            let numbers = self.part(rows).numbers()?;
            indices.clear();
            reserve(&mut indices, numbers.len())?;
            let negative = match &numbers {
                Numbers::U8(v) => widen(v, &mut indices),
                Numbers::I16(v) => widen(v, &mut indices),
                Numbers::U16(v) => widen(v, &mut indices),
                Numbers::I32(v) => widen(v, &mut indices),
                Numbers::U32(v) => widen(v, &mut indices),
                Numbers::I64(v) => widen(v, &mut indices),
                Numbers::U64(v) => widen(v, &mut indices),
                Numbers::F32(_) | Numbers::F64(_) => {
                    return Err(self.dataset.error("indices must be whole numbers"));
                }
            };
            if let Some(i) = negative {
                let value = numbers.get(i);
                let number = done + i as u64;
                return Err(self
                    .dataset
                    .error(format!("value {number} is {value}, and indices begin at 0")));
            }
            each(&indices)?;
            done += indices.len() as u64;
        }
        Ok(())
    }

    /// All numbers as indices; see [`View::each_indices`].
    pub(crate) fn indices(&self) -> Result<Vec<u64>, Error> {
        let mut all = room(self.count() as usize)?;
        self.each_indices(&mut |indices| {
            all.extend_from_slice(indices);
            Ok(())
        })?;
        Ok(all)
    }
}

/// Appends numbers as indices; gives the place of the first that is below 0.
fn widen<T: Copy + TryInto<u64>>(numbers: &[T], indices: &mut Vec<u64>) -> Option<usize> {
    for (i, &number) in numbers.iter().enumerate() {
        match number.try_into() {
            Ok(index) => indices.push(index),
            Err(_) => return Some(i),
        }
    }
    None
}

impl fmt::Debug for View {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let path = &self.dataset.path;
        write!(formatter, "{path} {:?} {:?}", self.places, self.rows)
    }
}

impl Indices for View {
    fn count(&self) -> u64 {
        View::count(self)
    }

    fn each_indices(&self, each: EachIndices) -> Result<(), Error> {
        View::each_indices(self, each)
    }
}

impl fields::Numbers for View {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        self.each_float(each)
    }
}
