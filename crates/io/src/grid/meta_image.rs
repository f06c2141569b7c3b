//! MetaImage, `.mha` (one file) and `.mhd` (with its numbers in others).
//!
//! Lines of `Key = Value`, of which `ElementDataFile` is the last. `TransformMatrix`
//! (or `Orientation`, `Rotation`) has the direction of the first axis, then of the
//! second, then of the third; `Offset` (or `Position`, `Origin`) is the center of the
//! first sample. Positions are in LPS, as ITK has them whatever `AnatomicalOrientation`
//! says. A fourth axis is time: each frame is a field.

use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Interpolation;

use super::header::{Header, clip, data_files};
use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, Entries, Extra, MOST_AXES, axes, no_volume};
use crate::source::Endian;

/// The values of the keys before the samples.
#[derive(Default)]
struct Keys {
    rank: Option<usize>,
    dims: Vec<usize>,
    spacing: Vec<f64>,
    size: Vec<f64>,
    origin: Vec<f64>,
    matrix: Vec<f64>,
    /// By how much numbers of `matrix` may be off, as they are written.
    rounding: f64,
}

pub(crate) fn read(path: &Path) -> Result<Description, Error> {
    let mut header = Header::open(path)?;
    let mut keys = Keys::default();
    let (mut number, mut file) = (None, None);
    let (mut endian, mut compressed, mut skip) = (Endian::Little, false, Some(0));
    let mut components = 1;
    let mut binary = true;
    while let Some(line) = header.next_line() {
        let Some((key, value)) = line.split_once('=') else {
            if line.trim().is_empty() {
                continue;
            }
            return Err(header.error(format!("'{}' is no 'Key = Value'", clip(&line))));
        };
        let (key, value) = (key.trim(), value.trim());
        let flag = || value.eq_ignore_ascii_case("true") || value == "1";
        match key.to_ascii_lowercase().as_str() {
            "ndims" => {
                let [n] = header.array::<usize, 1>(key, value)?;
                keys.rank = Some(n);
            }
            "dimsize" => keys.dims = header.numbers(key, value)?,
            "elementspacing" => keys.spacing = header.numbers(key, value)?,
            "elementsize" => keys.size = header.numbers(key, value)?,
            "offset" | "position" | "origin" => keys.origin = header.numbers(key, value)?,
            "transformmatrix" | "orientation" | "rotation" => {
                keys.matrix = header.numbers(key, value)?;
                keys.rounding = axes::rounding(value.split_ascii_whitespace());
            }
            "elementbyteordermsb" | "binarydatabyteordermsb" if flag() => endian = Endian::Big,
            "elementbyteordermsb" | "binarydatabyteordermsb" => endian = Endian::Little,
            "compresseddata" => compressed = flag(),
            "binarydata" => binary = flag(),
            "headersize" => {
                let [bytes] = header.array::<i64, 1>(key, value)?;
                // −1: the numbers are the end of the file.
                skip = u64::try_from(bytes).ok();
            }
            "elementnumberofchannels" => [components] = header.array::<usize, 1>(key, value)?,
            "elementtype" => {
                let found = number_of(value);
                number = Some(found.ok_or_else(|| {
                    header.error(format!("samples of type '{}' are not read", clip(value)))
                })?);
            }
            "elementdatafile" => {
                file = Some(value.to_owned());
                break;
            }
            _ => {}
        }
    }
    let missing = |key: &str| header.error(format!("there is no '{key}'"));
    let number = number.ok_or_else(|| missing("ElementType"))?;
    let file = file.ok_or_else(|| missing("ElementDataFile"))?;
    if keys.dims.is_empty() {
        return Err(missing("DimSize"));
    }
    let mut notes = Vec::new();
    let (lattice, frames) = keys.lattice(path, &header, &mut notes)?;
    let word = file.split_ascii_whitespace().next().unwrap_or("");
    let (files, start) = if file.eq_ignore_ascii_case("local") {
        (vec![path.to_owned()], header.position())
    } else if word.eq_ignore_ascii_case("list") {
        // How many dimensions each file has, which follows from their number too.
        (header.files()?, 0)
    } else {
        (data_files(&header, &file)?, 0)
    };
    if files.is_empty() {
        return Err(header.error("'ElementDataFile = LIST' names no file"));
    }
    if compressed && !binary {
        return Err(header.error("text cannot be compressed"));
    }
    if skip.is_none() && (compressed || !binary) {
        return Err(header.error("'HeaderSize' below 0 goes with raw data only"));
    }
    // Behind what a header of its own takes in each file.
    let (start, skip) = if compressed {
        (start.saturating_add(skip.unwrap_or(0)), Some(0))
    } else {
        (start, skip)
    };
    let mut extras = Vec::new();
    if components != 1 {
        extras.push(Extra {
            before: 0,
            size: components,
            entries: Entries::of_bytes(number, components),
        });
    }
    extras.extend(frames);
    Ok(Description {
        lattice,
        is_placed: true,
        payload: Payload {
            files,
            start,
            lines: 0,
            skip,
            encoding: match (compressed, binary) {
                (true, _) => Encoding::Zlib,
                (false, true) => Encoding::Raw,
                (false, false) => Encoding::Text,
            },
            number,
            endian,
        },
        extras,
        scale: None,
        name: "scalars".into(),
        notes,
    })
}

impl Keys {
    /// The three axes of space, and those of frames behind them.
    fn lattice(
        &self,
        path: &Path,
        header: &Header,
        notes: &mut Vec<String>,
    ) -> Result<(super::Lattice, Vec<Extra>), Error> {
        let rank = self.rank.unwrap_or(self.dims.len());
        if rank != self.dims.len() {
            return Err(header.error(format!(
                "'DimSize' has {} numbers where {rank} are needed",
                self.dims.len()
            )));
        }
        if rank > MOST_AXES {
            return Err(header.error(format!("{rank} axes; up to {MOST_AXES} are read")));
        }
        if rank < 3 {
            let axes = ["no spatial axis", "one spatial axis", "two spatial axes"][rank];
            return Err(header.error(format!("{axes}; a volume has three")));
        }
        // Of values that are left out, the others count.
        let values = |numbers: &[f64], key: &str, other: f64| match numbers.len() {
            0 => Ok(vec![other; rank]),
            n if n == rank => Ok(numbers.to_vec()),
            n => Err(header.error(format!("'{key}' has {n} numbers where {rank} are needed"))),
        };
        let spacing = match self.spacing.is_empty() {
            true => values(&self.size, "ElementSize", 1.0)?,
            false => values(&self.spacing, "ElementSpacing", 1.0)?,
        };
        let origin = values(&self.origin, "Offset", 0.0)?;
        let mut matrix = self.matrix.clone();
        if matrix.iter().all(|number| *number == 0.0) {
            if !matrix.is_empty() {
                notes.push("a 'TransformMatrix' of zeros: axes are not turned".into());
            }
            matrix = vec![0.0; rank * rank];
            matrix.iter_mut().step_by(rank + 1).for_each(|n| *n = 1.0);
        }
        if matrix.len() != rank * rank {
            let found = matrix.len();
            return Err(header.error(format!(
                "'TransformMatrix' has {found} numbers where {rank} times {rank} are needed"
            )));
        }
        let mixed = |(i, number): (usize, &f64)| {
            let (row, column) = (i / rank, i % rank);
            (row < 3) != (column < 3) && number.abs() > self.rounding
        };
        if matrix.iter().enumerate().any(mixed) {
            return Err(header.error("'TransformMatrix' turns space into other axes"));
        }
        let axis = |i: usize| DVec3::from_slice(&matrix[rank * i..]) * spacing[i];
        let lattice = axes::lattice(
            [self.dims[0], self.dims[1], self.dims[2]],
            DVec3::from_slice(&origin),
            [axis(0), axis(1), axis(2)],
            [0, 1, 2].map(|i| self.rounding * spacing[i].abs()),
            Interpolation::Linear,
            notes,
        );
        let lattice = lattice.map_err(|error| no_volume(path, error))?;
        let frames = self.dims[3..].iter().map(|size| Extra {
            before: 3,
            size: *size,
            entries: Entries::Numbered,
        });
        Ok((lattice, frames.collect()))
    }
}

fn number_of(name: &str) -> Option<Number> {
    Some(match name.strip_suffix("_ARRAY").unwrap_or(name) {
        "MET_CHAR" => Number::I8,
        "MET_UCHAR" => Number::U8,
        "MET_SHORT" => Number::I16,
        "MET_USHORT" => Number::U16,
        "MET_INT" | "MET_LONG" => Number::I32,
        "MET_UINT" | "MET_ULONG" => Number::U32,
        "MET_LONG_LONG" => Number::I64,
        "MET_ULONG_LONG" => Number::U64,
        "MET_FLOAT" => Number::F32,
        "MET_DOUBLE" => Number::F64,
        _ => return None,
    })
}
