//! The types of numbers that files hold, and how they become samples.

use std::io::{self, Read};
use std::ops::Range;

use half::f16;
use tetrascope_core::grid::{SampleType, Samples};

use crate::parse_float;
use crate::source::{Endian, count};

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    /// A float of 16 bits, as in IEEE 754.
    F16,
    F32,
    F64,
}

/// Numbers as a file has them; signed bytes are in 16 bits, and floats of
/// 16 bits in 32.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Numbers {
    U8(Vec<u8>),
    I16(Vec<i16>),
    U16(Vec<u16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    U64(Vec<u64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Samples that numbers became, and what was lost on the way.
#[derive(Clone, Debug)]
pub(crate) struct Converted {
    pub(crate) samples: Samples,
    /// A number is its sample and this.
    pub(crate) offset: f64,
    /// Whether any number had to be rounded to a 32-bit float.
    rounded: bool,
    /// A number that was taken as a mark of no value, and how often it occurred.
    fill: Option<(f64, u64)>,
}

/// Numbers that are decoded at a time.
const CHUNK: usize = 1 << 16;

/// The least number that may be a mark of no value: netCDF's is 9.97e36, others are 1e36,
/// 1e37 and the greatest of 32 or of 64 bits.
const LEAST_FILL: f64 = 1e30;

/// Marks of no value are at least so many times as large as all other numbers.
const FILL_RATIO: f64 = 1e10;

/// An offset is taken off numbers whose range is this share of the greatest of them or less:
/// 32-bit floats tell fewer than 2⁹ of them apart.
const NARROW: f64 = 1.0 / (1 << 15) as f64;

impl Number {
    /// Bytes of one number.
    pub(crate) fn size(self) -> usize {
        match self {
            Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 | Number::F16 => 2,
            Number::I32 | Number::U32 | Number::F32 => 4,
            Number::I64 | Number::U64 | Number::F64 => 8,
        }
    }

    /// The type of samples that has the same bits, if there is one.
    pub(crate) fn sample_type(self) -> Option<SampleType> {
        match self {
            Number::U8 => Some(SampleType::U8),
            Number::U16 => Some(SampleType::U16),
            Number::I16 => Some(SampleType::I16),
            Number::F32 => Some(SampleType::F32),
            _ => None,
        }
    }

    /// Bytes of one sample that a number becomes.
    pub(crate) fn sample_size(self) -> usize {
        match self {
            Number::I8 => 2,
            other => other.sample_type().unwrap_or(SampleType::F32).bytes(),
        }
    }

    /// The little-endian bytes of the number that `word` is, as many as [`Number::size`];
    /// `None` if it is none of the type's numbers.
    pub(crate) fn word(self, word: &str) -> Option<[u8; 8]> {
        let mut bytes = [0; 8];
        let mut put = |number: &[u8]| bytes[..number.len()].copy_from_slice(number);
        macro_rules! whole {
            ($type:ty) => {{
                let exact = word.parse::<$type>().ok();
                // Written with a point or an exponent. A cast saturates, so that what is out
                // of range or a fraction comes back changed.
                let float = || {
                    let value = parse_float(word)?;
                    Some(value as $type).filter(|whole| *whole as f64 == value)
                };
                put(&exact.or_else(float)?.to_le_bytes());
            }};
        }
        match self {
            Number::I8 => whole!(i8),
            Number::U8 => whole!(u8),
            Number::I16 => whole!(i16),
            Number::U16 => whole!(u16),
            Number::I32 => whole!(i32),
            Number::U32 => whole!(u32),
            Number::I64 => whole!(i64),
            Number::U64 => whole!(u64),
            Number::F16 => put(&f16::from_f64(parse_float(word)?).to_le_bytes()),
            Number::F32 => put(&(parse_float(word)? as f32).to_le_bytes()),
            Number::F64 => put(&parse_float(word)?.to_le_bytes()),
        }
        Some(bytes)
    }

    /// Reads `count` numbers, a few at a time.
    ///
    /// The caller has checked that `reader` can hold so many.
    pub(crate) fn read(
        self,
        reader: &mut dyn Read,
        endian: Endian,
        count: usize,
    ) -> io::Result<Numbers> {
        let (reader, n) = (reader, count);
        Ok(match self {
            Number::U8 => Numbers::U8(collect(reader, 1, n, |b| b[0])?),
            Number::I8 => Numbers::I16(collect(reader, 1, n, |b| i16::from(b[0] as i8))?),
            Number::I16 => Numbers::I16(collect(reader, 2, n, |b| endian.i16(b))?),
            Number::U16 => Numbers::U16(collect(reader, 2, n, |b| endian.u16(b))?),
            Number::I32 => Numbers::I32(collect(reader, 4, n, |b| endian.i32(b))?),
            Number::U32 => Numbers::U32(collect(reader, 4, n, |b| endian.u32(b))?),
            Number::I64 => Numbers::I64(collect(reader, 8, n, |b| endian.i64(b))?),
            Number::U64 => Numbers::U64(collect(reader, 8, n, |b| endian.u64(b))?),
            Number::F16 => Numbers::F32(collect(reader, 2, n, |b| {
                f16::from_bits(endian.u16(b)).to_f32()
            })?),
            Number::F32 => Numbers::F32(collect(reader, 4, n, |b| endian.f32(b))?),
            Number::F64 => Numbers::F64(collect(reader, 8, n, |b| endian.f64(b))?),
        })
    }
}

fn collect<T>(
    reader: &mut dyn Read,
    size: usize,
    count: usize,
    mut each: impl FnMut(&[u8]) -> T,
) -> io::Result<Vec<T>> {
    let mut values = Vec::new();
    values
        .try_reserve_exact(count)
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    let mut chunk = vec![0; size * count.min(CHUNK)];
    while values.len() < count {
        let bytes = &mut chunk[..size * (count - values.len()).min(CHUNK)];
        reader.read_exact(bytes)?;
        values.extend(bytes.chunks_exact(size).map(&mut each));
    }
    Ok(values)
}

impl Numbers {
    pub(crate) fn len(&self) -> usize {
        match self {
            Numbers::U8(v) => v.len(),
            Numbers::I16(v) => v.len(),
            Numbers::U16(v) => v.len(),
            Numbers::I32(v) => v.len(),
            Numbers::U32(v) => v.len(),
            Numbers::I64(v) => v.len(),
            Numbers::U64(v) => v.len(),
            Numbers::F32(v) => v.len(),
            Numbers::F64(v) => v.len(),
        }
    }

    /// Number `index`, to 2⁵³ exactly.
    pub(crate) fn get(&self, index: usize) -> f64 {
        match self {
            Numbers::F64(v) => v[index],
            Numbers::U8(v) => v[index].into(),
            Numbers::I16(v) => v[index].into(),
            Numbers::U16(v) => v[index].into(),
            Numbers::I32(v) => v[index].into(),
            Numbers::U32(v) => v[index].into(),
            Numbers::I64(v) => v[index] as f64,
            Numbers::U64(v) => v[index] as f64,
            Numbers::F32(v) => v[index].into(),
        }
    }

    /// Appends numbers of the same type; false, and nothing is done, if theirs is another.
    pub(crate) fn append(&mut self, more: Numbers) -> bool {
        macro_rules! same_types {
            ($($of:ident),*) => {
                match (self, more) {
                    $((Numbers::$of(a), Numbers::$of(b)) => a.extend(b),)*
                    _ => return false,
                }
            };
        }
        same_types!(U8, I16, U16, I32, U32, I64, U64, F32, F64);
        true
    }

    /// `count` numbers of this type: NaN, or 0 where there is none.
    pub(crate) fn blank(&self, count: usize) -> Numbers {
        match self {
            Numbers::F32(_) => Numbers::F32(vec![f32::NAN; count]),
            Numbers::F64(_) => Numbers::F64(vec![f64::NAN; count]),
            Numbers::U8(_) => Numbers::U8(vec![0; count]),
            Numbers::I16(_) => Numbers::I16(vec![0; count]),
            Numbers::U16(_) => Numbers::U16(vec![0; count]),
            Numbers::I32(_) => Numbers::I32(vec![0; count]),
            Numbers::U32(_) => Numbers::U32(vec![0; count]),
            Numbers::I64(_) => Numbers::I64(vec![0; count]),
            Numbers::U64(_) => Numbers::U64(vec![0; count]),
        }
    }

    /// Puts `run` of `numbers` at `start`; false, and nothing is done, if their type is
    /// another.
    pub(crate) fn put(&mut self, start: usize, numbers: &Numbers, run: Range<usize>) -> bool {
        macro_rules! same_types {
            ($($of:ident),*) => {
                match (self, numbers) {
                    $((Numbers::$of(a), Numbers::$of(b)) => {
                        a[start..start + run.len()].copy_from_slice(&b[run]);
                    })*
                    _ => return false,
                }
            };
        }
        same_types!(U8, I16, U16, I32, U32, I64, U64, F32, F64);
        true
    }

    /// The numbers at `indices`, in that order.
    pub(crate) fn pick(&self, indices: impl Iterator<Item = usize>) -> Numbers {
        match self {
            Numbers::U8(v) => Numbers::U8(indices.map(|i| v[i]).collect()),
            Numbers::I16(v) => Numbers::I16(indices.map(|i| v[i]).collect()),
            Numbers::U16(v) => Numbers::U16(indices.map(|i| v[i]).collect()),
            Numbers::I32(v) => Numbers::I32(indices.map(|i| v[i]).collect()),
            Numbers::U32(v) => Numbers::U32(indices.map(|i| v[i]).collect()),
            Numbers::I64(v) => Numbers::I64(indices.map(|i| v[i]).collect()),
            Numbers::U64(v) => Numbers::U64(indices.map(|i| v[i]).collect()),
            Numbers::F32(v) => Numbers::F32(indices.map(|i| v[i]).collect()),
            Numbers::F64(v) => Numbers::F64(indices.map(|i| v[i]).collect()),
        }
    }

    /// Each x as slope · x + shift.
    pub(crate) fn scaled(&self, slope: f64, shift: f64) -> Numbers {
        Numbers::F64(
            (0..self.len())
                .map(|i| self.get(i) * slope + shift)
                .collect(),
        )
    }

    /// Numbers of a sample's type as samples, which are NaN where they are not finite; of
    /// another type, `None`.
    pub(crate) fn samples(self) -> Option<Samples> {
        Some(match self {
            Numbers::U8(v) => Samples::U8(v),
            Numbers::I16(v) => Samples::I16(v),
            Numbers::U16(v) => Samples::U16(v),
            Numbers::F32(mut v) => {
                for x in v.iter_mut().filter(|x| !x.is_finite()) {
                    *x = f32::NAN;
                }
                Samples::F32(v)
            }
            _ => return None,
        })
    }

    /// The samples that hold these numbers best.
    ///
    /// 8- and 16-bit integers and 32-bit floats stay what they are; all others become 32-bit
    /// floats. Where those could not tell them apart, an offset is taken off first. What has
    /// no value is NaN: infinities, numbers beyond 32-bit floats, and marks of no value.
    pub(crate) fn convert(self) -> Converted {
        let exact = |samples| Converted {
            samples,
            offset: 0.0,
            rounded: false,
            fill: None,
        };
        match self {
            Numbers::U8(v) => exact(Samples::U8(v)),
            Numbers::I16(v) => exact(Samples::I16(v)),
            Numbers::U16(v) => exact(Samples::U16(v)),
            Numbers::I32(v) => integers(v),
            Numbers::U32(v) => integers(v),
            Numbers::I64(v) => integers(v),
            Numbers::U64(v) => integers(v),
            Numbers::F32(mut v) => {
                let fill = fill(v.iter().map(|x| f64::from(*x)));
                let mark = fill.map(|(mark, _)| mark as f32);
                for x in &mut v {
                    if !x.is_finite() || mark.is_some_and(|mark| x.abs() == mark.abs()) {
                        *x = f32::NAN;
                    }
                }
                Converted {
                    fill,
                    ..exact(Samples::F32(v))
                }
            }
            Numbers::F64(v) => floats(v),
        }
    }
}

/// Converts whole numbers; see [`Numbers::convert`].
fn integers<T: Copy + Into<i128>>(numbers: Vec<T>) -> Converted {
    let wide = |x: &T| -> i128 { (*x).into() };
    let low = numbers.iter().map(wide).min().unwrap_or(0);
    let high = numbers.iter().map(wide).max().unwrap_or(0);
    let mut rounded = numbers.iter().any(|x| wide(x) as f32 as i128 != wide(x));
    let offset = match rounded {
        true => offset(low as f64, high as f64, (high - low) as f64),
        false => 0.0,
    };
    let base = offset as i128;
    if base != 0 {
        let changed = |x| (wide(x) - base) as f32 as i128 != wide(x) - base;
        rounded = numbers.iter().any(changed);
    }
    let samples = numbers.iter().map(|x| (wide(x) - base) as f32);
    Converted {
        samples: Samples::F32(samples.collect()),
        offset,
        rounded,
        fill: None,
    }
}

/// Converts 64-bit floats; see [`Numbers::convert`].
fn floats(numbers: Vec<f64>) -> Converted {
    let fill = fill(numbers.iter().copied());
    let mark = fill.map_or(f64::INFINITY, |(mark, _)| mark.abs());
    let value = |x: f64| (x.abs() <= f64::from(f32::MAX) && x.abs() != mark).then_some(x);
    let values = || numbers.iter().filter_map(|x| value(*x));
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (x.min(low), x.max(high))
    });
    let changed = |base: f64| values().any(|x| f64::from((x - base) as f32) != x - base);
    let mut rounded = changed(0.0);
    let offset = match rounded {
        true => offset(low, high, high - low),
        false => 0.0,
    };
    if offset != 0.0 {
        rounded = changed(offset);
    }
    let sample = |x: &f64| value(*x).map_or(f32::NAN, |x| (x - offset) as f32);
    Converted {
        samples: Samples::F32(numbers.iter().map(sample).collect()),
        offset,
        rounded,
        fill,
    }
}

/// The offset to take off numbers from `low` to `high`, which are `range` apart: 0 if 32-bit floats
/// tell enough of them apart, else a number below `low` with few digits.
fn offset(low: f64, high: f64, range: f64) -> f64 {
    let most = low.abs().max(high.abs());
    if !(range > 0.0 && range <= most * NARROW) {
        return 0.0;
    }
    // A multiple of a power of two that is about the range and has a 64-bit float.
    let power = |x: f64| 2f64.powi(x.log2().floor() as i32);
    let unit = power(range).max(power(most) * f64::EPSILON);
    (low / unit).floor() * unit
}

/// The mark of no value among `numbers` and how often it occurs, if there is one: it is huge,
/// no other number is nearly as large, and others there are.
fn fill(numbers: impl Iterator<Item = f64> + Clone) -> Option<(f64, u64)> {
    let finite = numbers.filter(|x| x.is_finite());
    let mark = finite.clone().max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    if mark.abs() < LEAST_FILL {
        return None;
    }
    let (mut marks, mut others) = (0, 0);
    for x in finite {
        if x.abs() == mark.abs() {
            marks += 1;
        } else if x.abs() <= mark.abs() / FILL_RATIO {
            others += 1;
        } else {
            return None;
        }
    }
    (others > 0).then_some((mark, marks))
}

impl Converted {
    /// Notes on the samples of the field `name`.
    pub(crate) fn notes(&self, name: &str) -> Vec<String> {
        let mut notes = Vec::new();
        if self.offset != 0.0 {
            notes.push(format!(
                "'{name}' is drawn less {}, as 32-bit floats would lose what varies: ranges and \
                 isovalues are relative to that",
                self.offset
            ));
        }
        if self.rounded {
            notes.push(format!("samples of '{name}' are rounded to 32-bit floats"));
        }
        if let Some((mark, marks)) = self.fill {
            let samples = count(marks, "sample");
            // With the digits that the number has in its own type.
            let narrow = mark as f32;
            let mark = match f64::from(narrow) == mark {
                true => format!("{narrow:e}"),
                false => format!("{mark:e}"),
            };
            notes.push(format!(
                "{samples} of '{name}' taken to have no value: {mark} is a mark of that"
            ));
        }
        let marks = self.fill.map_or(0, |(_, marks)| marks);
        notes.extend(missing_note(name, self.samples.missing() - marks));
        notes
    }
}

/// A note that `missing` samples of the field `name` have no value, if any are.
pub(crate) fn missing_note(name: &str, missing: u64) -> Option<String> {
    let samples = count(missing, "sample");
    (missing > 0).then(|| {
        format!(
            "{samples} of '{name}' without a value, not finite or beyond 32-bit floats: \
             nothing is drawn where one takes part"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(number: Number, bytes: &[u8], endian: Endian) -> Converted {
        let count = bytes.len() / number.size();
        let numbers = number.read(&mut &bytes[..], endian, count);
        numbers.expect("all bytes are there").convert()
    }

    #[test]
    fn small_types_keep_their_bits_and_large_ones_say_when_they_round() {
        let bytes = [1, 0xff, 0x80, 0x7f];
        let samples = |number, endian| read(number, &bytes, endian).samples;
        assert_eq!(
            samples(Number::I8, Endian::Little),
            Samples::I16(vec![1, -1, -128, 127])
        );
        assert_eq!(
            samples(Number::U16, Endian::Big),
            Samples::U16(vec![0x01ff, 0x807f])
        );
        assert_eq!(
            samples(Number::I16, Endian::Little),
            Samples::I16(vec![-255, 0x7f80])
        );
        let exact = read(Number::I32, &16_777_216_i32.to_le_bytes(), Endian::Little);
        assert!(!exact.rounded && exact.samples == Samples::F32(vec![16_777_216.0]));
        let rounded = read(Number::I32, &16_777_217_i32.to_le_bytes(), Endian::Little);
        assert!(rounded.rounded && rounded.samples == Samples::F32(vec![16_777_216.0]));
        assert!(!read(Number::F64, &f64::NAN.to_be_bytes(), Endian::Big).rounded);
        assert!(read(Number::F64, &0.1_f64.to_be_bytes(), Endian::Big).rounded);
    }

    #[test]
    fn what_is_missing_is_an_error() {
        let mut bytes: &[u8] = &[1, 2, 3];
        assert!(Number::U16.read(&mut bytes, Endian::Little, 2).is_err());
    }

    #[test]
    fn what_varies_beside_a_large_offset_is_kept() {
        let of = |numbers: Numbers| {
            let converted = numbers.convert();
            let Samples::F32(samples) = converted.samples else {
                panic!("wide numbers become floats");
            };
            (samples, converted.offset, converted.rounded)
        };
        let ids = [0, 1, 700].map(|i| 864_691_135_000_000_123 + i);
        let (samples, base, rounded) = of(Numbers::I64(ids.to_vec()));
        assert!(!rounded && base as i64 <= ids[0]);
        for (sample, id) in samples.iter().zip(ids) {
            assert_eq!(*sample as i64 + base as i64, id);
        }
        let times = [1.6e9, 1.6e9 + 0.25, 1.6e9 + 1.0];
        let found = of(Numbers::F64(times.to_vec()));
        assert_eq!(found, (vec![0.0, 0.25, 1.0], 1.6e9, false));
        let unsigned = of(Numbers::U64(vec![u64::MAX, u64::MAX - 1]));
        assert_eq!(unsigned.0[0] - unsigned.0[1], 1.0);
        // Enough is left of 0.1 in 300: no offset.
        assert_eq!(of(Numbers::F64(vec![300.0, 300.1])).1, 0.0);
        assert_eq!(of(Numbers::I32(vec![1 << 30, 5])).1, 0.0);
        // A constant stays what it is.
        assert_eq!(of(Numbers::F64(vec![1e9 + 0.1; 3])).1, 0.0);
    }

    #[test]
    fn what_has_no_value_is_nan_and_counted() {
        let missing = |numbers: Numbers| {
            let converted = numbers.convert();
            (converted.samples.missing(), converted.notes("s").len())
        };
        let infinite = vec![1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN];
        assert_eq!(missing(Numbers::F32(infinite)), (3, 1));
        // The greatest is taken for a mark, the other is beyond 32 bits.
        assert_eq!(missing(Numbers::F64(vec![1.0, 1e39, -1e300, 2.0])), (2, 2));
        for mark in [1e36, -9.969_209_968_386_869e36, 1.8e37, f64::from(f32::MAX)] {
            assert_eq!(missing(Numbers::F64(vec![1.0, mark, mark, -2.0])), (2, 1));
            let narrow = [1.0, mark as f32, -2.0];
            assert_eq!(missing(Numbers::F32(narrow.to_vec())), (1, 1));
        }
        // f64's own greatest number is beyond 32 bits and a mark as well; said once.
        assert_eq!(missing(Numbers::F64(vec![1.0, f64::MAX])), (1, 1));
        // Numbers of all sizes, and huge ones alone, are no marks.
        assert_eq!(missing(Numbers::F64(vec![1e30, 1e31, 3e31, 1e25])), (0, 1));
        assert_eq!(missing(Numbers::F32(vec![1e36, 1e36])), (0, 0));
    }

    #[test]
    fn words_keep_all_digits_of_whole_numbers() {
        let word = |number: Number, text| number.word(text).map(u64::from_le_bytes);
        assert_eq!(
            word(Number::I64, "864691135000000701"),
            Some(864_691_135_000_000_701)
        );
        assert_eq!(word(Number::U8, "2e1"), Some(20));
        for wrong in ["-1", "256", "1.5", "nan", "x"] {
            assert_eq!(word(Number::U8, wrong), None, "{wrong}");
        }
    }
}
