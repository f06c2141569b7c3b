//! Files of nothing but samples, whole and in parts.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tetrascope_core::Error;
use tetrascope_core::grid::{BrickSource, Lattice, RawNumber, Region, SampleType, Samples};

use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, no_volume};
use crate::source::{Endian, open_file};

pub use tetrascope_core::grid::{ByteOrder, RawLayout};

impl From<Endian> for ByteOrder {
    fn from(endian: Endian) -> ByteOrder {
        match endian {
            Endian::Little => ByteOrder::Little,
            Endian::Big => ByteOrder::Big,
        }
    }
}

impl From<RawNumber> for Number {
    fn from(number: RawNumber) -> Number {
        match number {
            RawNumber::I8 => Number::I8,
            RawNumber::U8 => Number::U8,
            RawNumber::I16 => Number::I16,
            RawNumber::U16 => Number::U16,
            RawNumber::I32 => Number::I32,
            RawNumber::U32 => Number::U32,
            RawNumber::F32 => Number::F32,
            RawNumber::F64 => Number::F64,
        }
    }
}

/// The content of a raw file of this layout.
pub(crate) fn describe(path: &Path, layout: &RawLayout) -> Result<Description, Error> {
    let dims = layout.lattice.dims;
    let count = layout.lattice.validate().map_err(|e| no_volume(path, e))?;
    let number = Number::from(layout.number);
    let (_, length) = open_file(path)?;
    let needed = (count as u64)
        .checked_mul(number.size() as u64)
        .and_then(|n| n.checked_add(layout.offset));
    let mut notes = Vec::new();
    if let Some(rest) = needed
        .and_then(|n| length.checked_sub(n))
        .filter(|r| *r > 0)
    {
        notes.push(format!("{rest} bytes behind {dims:?} samples are not read"));
    }
    Ok(Description {
        lattice: layout.lattice,
        payload: Payload {
            files: vec![path.to_owned()],
            start: 0,
            lines: 0,
            skip: Some(layout.offset),
            encoding: Encoding::Raw,
            number,
            endian: match layout.byte_order {
                ByteOrder::Little => Endian::Little,
                ByteOrder::Big => Endian::Big,
            },
        },
        is_placed: false,
        extras: Vec::new(),
        scale: None,
        name: "scalars".into(),
        notes,
    })
}

/// Rows are read together with what lies between them if that is at most so many times
/// as much: copies in memory cost less than calls of the system.
const NEAR: usize = 32;

/// A file of samples, x fastest, read where and when they are needed.
#[derive(Clone, Debug)]
pub struct RawFile {
    path: PathBuf,
    file: Arc<Mutex<File>>,
    offset: u64,
    lattice: Lattice,
    sample_type: SampleType,
    byte_order: ByteOrder,
}

impl RawFile {
    /// The samples of `lattice` that begin at byte `offset` of the file at `path`.
    ///
    /// Refuses a file that ends before the last sample.
    pub fn open(
        path: &Path,
        offset: u64,
        lattice: Lattice,
        sample_type: SampleType,
        byte_order: ByteOrder,
    ) -> Result<RawFile, Error> {
        let count = lattice.validate()?;
        let needed = (count as u64)
            .checked_mul(sample_type.bytes() as u64)
            .and_then(|n| n.checked_add(offset))
            .ok_or_else(|| Error::invalid(format!("{count} samples cannot be in a file")))?;
        let (file, length) = open_file(path)?;
        if length < needed {
            return Err(Error::Format {
                path: path.to_path_buf(),
                at: format!("byte {length}"),
                what: format!(
                    "the file ends, but {:?} samples need {needed} bytes",
                    lattice.dims
                ),
                help: Some("check dimensions, sample type and offset".into()),
            });
        }
        Ok(RawFile {
            path: path.to_path_buf(),
            file: Arc::new(Mutex::new(file)),
            offset,
            lattice,
            sample_type,
            byte_order,
        })
    }

    /// Samples like these that begin `bytes` later in the same file, which the caller has
    /// found to be long enough.
    pub(crate) fn later(&self, bytes: u64) -> RawFile {
        RawFile {
            offset: self.offset + bytes,
            ..self.clone()
        }
    }
}

impl BrickSource for RawFile {
    fn lattice(&self) -> Lattice {
        self.lattice
    }

    fn sample_type(&self) -> SampleType {
        self.sample_type
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        let io = |source| Error::Io {
            action: "cannot read",
            path: self.path.clone(),
            source,
        };
        let width = self.sample_type.bytes();
        let [nx, ny, _] = self.lattice.dims;
        let (row, pitch) = (region.size[0] * width, nx * width);
        let mut bytes = Vec::with_capacity(region.count() * width);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut read = |start: usize, length: usize, out: &mut Vec<u8>| {
            let at = self.offset + (start * width) as u64;
            file.seek(SeekFrom::Start(at)).map_err(io)?;
            let from = out.len();
            out.resize(from + length, 0);
            file.read_exact(&mut out[from..]).map_err(io)
        };
        if row == pitch && (region.size[1] == ny || region.size[2] == 1) {
            // All of it is in one piece.
            let start = region.rows(self.lattice.dims).next().unwrap_or(0);
            read(start, region.count() * width, &mut bytes)?;
        } else if pitch <= NEAR * row {
            let mut layer = Vec::new();
            for start in region.rows(self.lattice.dims).step_by(region.size[1]) {
                layer.clear();
                read(start, pitch * (region.size[1] - 1) + row, &mut layer)?;
                for from in layer.chunks(pitch) {
                    bytes.extend_from_slice(&from[..row]);
                }
            }
        } else {
            for start in region.rows(self.lattice.dims) {
                read(start, row, &mut bytes)?;
            }
        }
        let endian = match self.byte_order {
            ByteOrder::Little => Endian::Little,
            ByteOrder::Big => Endian::Big,
        };
        let number = match self.sample_type {
            SampleType::U8 => Number::U8,
            SampleType::U16 => Number::U16,
            SampleType::I16 => Number::I16,
            SampleType::F32 => Number::F32,
        };
        let numbers = number.read(&mut bytes.as_slice(), endian, region.count());
        let samples = numbers.map_err(io)?.samples();
        Ok(samples.expect("the number was chosen for its type of samples"))
    }
}
