//! NumPy arrays, `.npy`.
//!
//! <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>: a magic, a Python
//! dictionary with type, order and shape, and the numbers. The last axis is x, the one before
//! it y, the one before that z, `a[z, y, x]`, in whichever order the numbers stand: arrays that
//! NumPy calls equal are drawn alike.
//!
//! A fourth axis makes fields. It is the last if that has up to four entries, as the channels
//! of images stand in NumPy, else the first, which is that of frames: `a[z, y, x, channel]` and
//! `a[frame, z, y, x]`; `a[frame, z, y, x, channel]` has both. Complex numbers are real and
//! imaginary parts and magnitudes. Distances are 1, and the first sample is at 0, unless
//! [`ReadOptions`] has `spacing` and `origin`.
//!
//! The header is read here, not by `npyz`: that reads numbers one by one from any
//! stream and asks for their type at compile time, where we need the place of the numbers in the
//! file, to read them in parts.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};

use super::header::clip;
use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, Entries, Extra, no_volume};
use crate::ReadOptions;
use crate::source::{Endian, open_file};

/// How files begin; the numbers of the version follow.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// The longest dictionary that is read; NumPy itself reads 10 000 bytes.
const LONGEST: u32 = 1 << 16;

/// The most entries of a last axis that is that of channels.
const MOST_CHANNELS: usize = 4;

/// The header of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) number: Number,
    endian: Endian,
    is_complex: bool,
    is_fortran: bool,
    pub(crate) shape: Vec<usize>,
    /// Bytes before the first number.
    length: u64,
}

/// Where an array stands.
pub(crate) struct Place<'a> {
    pub(crate) path: &'a Path,
    /// Where its magic is, in bytes.
    pub(crate) start: u64,
    pub(crate) encoding: Encoding,
    /// The name of the array, for its field.
    pub(crate) name: &'a str,
}

pub(crate) fn read(path: &Path, options: &ReadOptions) -> Result<Description, Error> {
    let (mut file, _): (File, u64) = open_file(path)?;
    let wrong = |what| wrong(path, "the header", what);
    let header = Header::read(&mut file).map_err(wrong)?;
    let place = Place {
        path,
        start: 0,
        encoding: Encoding::Raw,
        name: "scalars",
    };
    header.description(&place, options)
}

fn wrong(path: &Path, at: &str, what: String) -> Error {
    Error::Format {
        path: path.to_owned(),
        at: at.into(),
        what,
        help: None,
    }
}

impl Header {
    /// Reads magic and dictionary; else what is wrong with them.
    pub(crate) fn read(reader: &mut dyn Read) -> Result<Header, String> {
        let mut take = |length: usize| {
            let mut bytes = vec![0; length];
            let read = reader.read_exact(&mut bytes);
            read.map_err(|error| format!("the header of a NumPy array is cut off ({error})"))?;
            Ok::<_, String>(bytes)
        };
        let magic = take(8)?;
        if !magic.starts_with(MAGIC) {
            return Err("there is no NumPy magic".into());
        }
        let (width, length) = match magic[6] {
            1 => (2, Endian::Little.u16(&take(2)?).into()),
            2 | 3 => (4, Endian::Little.u32(&take(4)?)),
            version => return Err(format!("version {version} of NumPy arrays is not known")),
        };
        if length > LONGEST {
            return Err(format!("a header of {length} bytes; {LONGEST} are read"));
        }
        let text = take(length as usize)?;
        let text = String::from_utf8_lossy(&text);
        let value = |key| value(&text, key).ok_or_else(|| format!("there is no '{key}'"));
        let description = value("descr")?;
        let (number, is_complex, endian) = number_of(description)?;
        let order = value("fortran_order")?;
        let is_fortran = match (order.starts_with("True"), order.starts_with("False")) {
            (false, false) => return Err(format!("'fortran_order' is {}", clip(order))),
            (is_fortran, _) => is_fortran,
        };
        let shape = value("shape")?;
        Ok(Header {
            number,
            endian,
            is_complex,
            is_fortran,
            shape: sizes(shape).ok_or_else(|| format!("'shape' is {}", clip(shape)))?,
            length: 8 + width + u64::from(length),
        })
    }

    /// Bytes of the array with its header; `None` if they are beyond counting.
    pub(crate) fn bytes(&self) -> Option<u64> {
        let parts = if self.is_complex { 2 } else { 1 };
        let mut sizes = self.shape.iter().map(|size| *size as u64);
        let count = sizes.try_fold(parts, |n: u64, size| n.checked_mul(size));
        let numbers = count?.checked_mul(self.number.size() as u64)?;
        numbers.checked_add(self.length)
    }

    /// The array that stands at `place`.
    pub(crate) fn description(
        &self,
        place: &Place,
        options: &ReadOptions,
    ) -> Result<Description, Error> {
        let mut notes = Vec::new();
        let (frames, channels) = self
            .axes(&mut notes)
            .map_err(|what| wrong(place.path, "the header", what))?;
        let rank = self.shape.len();
        let spacing = options.spacing.unwrap_or(DVec3::ONE);
        let (mut dims, mut axes) = (Vec::new(), Vec::new());
        let mut extras = Vec::new();
        if self.is_complex {
            extras.push(Extra {
                before: 0,
                size: 2,
                entries: Entries::Complex,
            });
        }
        for i in 0..rank {
            // The axis of the array, the one that varies fastest in the file first.
            let axis = if self.is_fortran { i } else { rank - 1 - i };
            let size = self.shape[axis];
            let entries = match axis {
                _ if channels == Some(axis) => Entries::of_bytes(self.number, size),
                _ if frames == Some(axis) => Entries::Numbered,
                _ => {
                    // x is the last axis of space.
                    let of_space = rank - usize::from(channels.is_some()) - 1 - axis;
                    let unit = [DVec3::X, DVec3::Y, DVec3::Z][of_space];
                    axes.push(unit * spacing[of_space]);
                    dims.push(size);
                    continue;
                }
            };
            extras.push(Extra {
                before: dims.len(),
                size,
                entries,
            });
        }
        let dims = <[usize; 3]>::try_from(dims).expect("`axes` leaves three");
        let axes = <[DVec3; 3]>::try_from(axes).expect("one for each of `dims`");
        let origin = options.origin.unwrap_or(DVec3::ZERO);
        let lattice = Lattice::from_axes(dims, origin, axes, Interpolation::Linear)
            .map_err(|error| no_volume(place.path, error))?;
        if options.spacing.is_none() {
            notes.push("the file does not say how far apart samples are: 1 is taken".into());
        }
        Ok(Description {
            lattice,
            is_placed: false,
            payload: Payload {
                files: vec![place.path.to_owned()],
                start: place.start,
                lines: 0,
                skip: Some(self.length),
                encoding: place.encoding,
                number: self.number,
                endian: self.endian,
            },
            extras,
            scale: None,
            name: place.name.into(),
            notes,
        })
    }

    /// The axes of frames and of channels, where there are such; else what is wrong.
    fn axes(&self, notes: &mut Vec<String>) -> Result<(Option<usize>, Option<usize>), String> {
        let shape = &self.shape;
        let rank = shape.len();
        let has_channels = shape.last().is_some_and(|size| *size <= MOST_CHANNELS);
        match (rank, has_channels) {
            (0..3, _) => {
                let axes = ["no axis", "one axis", "two axes"][rank];
                Err(format!("an array of {axes}; a volume has three"))
            }
            (3, _) => Ok((None, None)),
            (4, true) => {
                notes.push(format!(
                    "the last axis of {shape:?} is taken for that of channels"
                ));
                Ok((None, Some(3)))
            }
            (4, false) => {
                notes.push(format!(
                    "the first axis of {shape:?} is taken for that of frames"
                ));
                Ok((Some(0), None))
            }
            (5, true) => {
                notes.push(format!(
                    "of {shape:?} the first axis is taken for that of frames, the last for that \
                     of channels"
                ));
                Ok((Some(0), Some(4)))
            }
            _ => Err(format!(
                "an array of {rank} axes, {shape:?}; [z, y, x], [frame, z, y, x] and both with \
                 up to {MOST_CHANNELS} channels behind are read"
            )),
        }
    }
}

/// The text behind `'key':` in a dictionary.
fn value<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let after = quoted.iter().find_map(|key| text.split_once(key.as_str()));
    let (_, after) = after?;
    Some(after.trim_start().strip_prefix(':')?.trim_start())
}

/// `(2, 3, 4)`, of which Python 2 may have written `2L`.
fn sizes(text: &str) -> Option<Vec<usize>> {
    let (inside, _) = text.strip_prefix('(')?.split_once(')')?;
    let words = inside.split(',').map(str::trim);
    let words = words.filter(|word| !word.is_empty());
    words
        .map(|word| word.trim_end_matches('L').parse().ok())
        .collect()
}

/// The meaning of a type such as `'<f4'`: numbers, whether two of them make one, and their order;
/// else what is wrong.
fn number_of(description: &str) -> Result<(Number, bool, Endian), String> {
    let refuse = |what: &str| {
        Err(format!(
            "numbers of type {} are not read{what}",
            clip(description)
        ))
    };
    let quote = description
        .chars()
        .next()
        .filter(|c| matches!(c, '\'' | '"'));
    let Some(name) = quote.and_then(|quote| description[1..].split(quote).next()) else {
        return refuse(": they are records; save each field as an array of its own");
    };
    let (endian, kind) = match name.split_at_checked(1) {
        Some((">", kind)) => (Endian::Big, kind),
        Some(("<" | "|" | "=", kind)) => (Endian::Little, kind),
        _ => return refuse(""),
    };
    let number = match kind {
        "b1" | "u1" => Number::U8,
        "i1" => Number::I8,
        "u2" => Number::U16,
        "i2" => Number::I16,
        "f2" => Number::F16,
        "u4" => Number::U32,
        "i4" => Number::I32,
        "f4" | "c8" => Number::F32,
        "u8" => Number::U64,
        "i8" => Number::I64,
        "f8" | "c16" => Number::F64,
        "O" => return refuse(": they are Python objects"),
        _ => return refuse(""),
    };
    Ok((number, kind.starts_with('c'), endian))
}
