//! The types of numbers that files hold, and how they become samples.

use std::io::{self, Read};

use tetrascope_core::grid::{SampleType, Samples};

use crate::source::Endian;

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
    F32,
    F64,
}

/// Samples, and whether any of them had to be rounded to 32-bit floats.
pub(crate) struct Converted {
    pub(crate) samples: Samples,
    pub(crate) rounded: bool,
}

/// Numbers that are decoded at a time.
const CHUNK: usize = 1 << 16;

impl Number {
    /// Bytes of one number.
    pub(crate) fn size(self) -> usize {
        match self {
            Number::I8 | Number::U8 => 1,
            Number::I16 | Number::U16 => 2,
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

    /// Appends `value`, little-endian; `None` if it is none of the type's numbers.
    pub(crate) fn encode(self, value: f64, bytes: &mut Vec<u8>) -> Option<()> {
        // A cast saturates, so that what is out of range or a fraction comes back changed.
        macro_rules! whole {
            ($type:ty) => {{
                let whole = value as $type;
                if whole as f64 != value {
                    return None;
                }
                bytes.extend(whole.to_le_bytes());
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
            Number::F32 => bytes.extend((value as f32).to_le_bytes()),
            Number::F64 => bytes.extend(value.to_le_bytes()),
        }
        Some(())
    }

    /// Reads `count` numbers, a few at a time.
    ///
    /// 8- and 16-bit integers and 32-bit floats stay what they are (signed bytes become
    /// 16-bit integers, which hold them); all others are rounded to 32-bit floats.
    /// The caller has checked that `reader` can hold so many.
    pub(crate) fn read(
        self,
        reader: &mut dyn Read,
        endian: Endian,
        count: usize,
    ) -> io::Result<Converted> {
        let mut rounded = false;
        let mut round = |value: f64| {
            let sample = value as f32;
            rounded |= f64::from(sample) != value && !value.is_nan();
            sample
        };
        let (reader, n) = (reader, count);
        let samples = match self {
            Number::U8 => Samples::U8(collect(reader, 1, n, |b| b[0])?),
            Number::I8 => Samples::I16(collect(reader, 1, n, |b| i16::from(b[0] as i8))?),
            Number::I16 => Samples::I16(collect(reader, 2, n, |b| endian.i16(b))?),
            Number::U16 => Samples::U16(collect(reader, 2, n, |b| endian.u16(b))?),
            Number::F32 => Samples::F32(collect(reader, 4, n, |b| endian.f32(b))?),
            Number::I32 => Samples::F32(collect(reader, 4, n, |b| round(endian.i32(b).into()))?),
            Number::U32 => Samples::F32(collect(reader, 4, n, |b| round(endian.u32(b).into()))?),
            // Rounding to f64 first is noticed too: both are powers of two apart.
            Number::I64 => Samples::F32(collect(reader, 8, n, |b| round(endian.i64(b) as f64))?),
            Number::U64 => Samples::F32(collect(reader, 8, n, |b| round(endian.u64(b) as f64))?),
            Number::F64 => Samples::F32(collect(reader, 8, n, |b| round(endian.f64(b)))?),
        };
        Ok(Converted { samples, rounded })
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

#[cfg(test)]
mod tests {
    use super::*;

    fn read(number: Number, bytes: &[u8], endian: Endian) -> Converted {
        let count = bytes.len() / number.size();
        let converted = number.read(&mut &bytes[..], endian, count);
        converted.expect("all bytes are there")
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
}
