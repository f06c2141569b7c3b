//! NIfTI-1 and NIfTI-2, in one file (`.nii`, `.nii.gz`) and in pairs (`.hdr` with `.img` or
//! `.img.gz`), and Analyze 7.5.
//!
//! <https://nifti.nimh.nih.gov/nifti-1>, <https://nifti.nimh.nih.gov/nifti-2>: 348 or 540 bytes
//! of header, the samples behind it or in the pair's other file. The
//! axes are those of `sform` if the file has one, but for a little shear; else those of
//! `qform`; else the sizes of voxels alone. `scl_slope` and `scl_inter` are applied: what
//! is drawn are the values that were measured, as 32-bit floats. Each of several volumes is
//! a field; so are the channels of colors, and the real and imaginary parts and the magnitude
//! of complex numbers.
//!
//! A pair whose header has no magic is Analyze 7.5. As nibabel has it, its scale factor (SPM's)
//! is applied. It does not say where left is, so that its axes are not turned and its
//! first sample is at 0; nibabel mirrors x and puts the middle there.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};

use super::number::Number;
use super::payload::{Encoding, Payload, open_unpacked};
use super::space::{RAS, turned};
use super::{Description, Entries, Extra, axes, no_volume};
use crate::source::Endian;

/// Where a value stands in a header, in bytes: in version 1, and in version 2.
type At = (usize, usize);

const DIM: At = (40, 16);
const INTENT: At = (68, 504);
const DATATYPE: At = (70, 12);
const PIXDIM: At = (76, 104);
const VOX_OFFSET: At = (108, 168);
const SLOPE: At = (112, 176);
const UNITS: At = (123, 500);
const QFORM: At = (252, 344);
const SFORM: At = (254, 348);
const QUATERNION: At = (256, 352);
const QOFFSET: At = (268, 376);
const SROWS: At = (280, 400);
const MAGIC: At = (344, 4);

/// The code NIFTI_INTENT_VECTOR, for a fifth axis of vectors.
const VECTORS: i32 = 1007;

/// NIFTI_INTENT_RGB_VECTOR, and with alpha the next.
const COLORS: i32 = 2003;

/// The kind of file that a header's magic names.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// The samples are behind the header.
    One,
    /// They are in a file of their own.
    Pair,
    /// So they are, and nothing but sizes and types is known.
    Analyze,
}

/// Whether this is the beginning of a header: its size comes first, in either order.
pub(crate) fn is_nifti(head: &[u8]) -> bool {
    let first = [b"\x5c\x01\0\0", b"\0\0\x01\x5c"];
    let magic = head.get(MAGIC.1..MAGIC.1 + 3);
    first.iter().any(|size| head.starts_with(*size)) || matches!(magic, Some(b"n+2" | b"ni2"))
}

/// The header that belongs to the file at `path`: that file, or, of a pair's samples, the file
/// beside it that is called the same but for `.hdr` or `.hdr.gz`, if it is there.
pub(crate) fn header_of(path: &Path) -> Option<PathBuf> {
    match ending(path)?.1.as_str() {
        ".img" | ".img.gz" => beside(path, &[".hdr", ".hdr.gz"]),
        _ => Some(path.to_owned()),
    }
}

/// A file's name without the ending, and the ending in lower case: `.img.gz`.
fn ending(path: &Path) -> Option<(&str, String)> {
    let name = path.file_name()?.to_str()?;
    let lower = name.to_ascii_lowercase();
    let plain = lower.strip_suffix(".gz").unwrap_or(&lower);
    let dot = plain.rfind('.').unwrap_or(plain.len());
    Some((&name[..dot], lower[dot..].to_owned()))
}

/// The first file that is there of those beside `path` that are called the same but for these
/// endings.
fn beside(path: &Path, endings: &[&str]) -> Option<PathBuf> {
    let (stem, _) = ending(path)?;
    let spellings = endings
        .iter()
        .flat_map(|e| [e.to_string(), e.to_ascii_uppercase()]);
    let mut paths = spellings.map(|ending| path.with_file_name(format!("{stem}{ending}")));
    paths.find(|path| path.is_file())
}

pub(crate) fn read(path: &Path) -> Result<Description, Error> {
    let header = Header::open(path)?;
    let kind = header.kind()?;
    let (dims, rest) = header.sizes()?;
    let code = header.code(DATATYPE);
    let (number, channels, meaning) = number_of(code).ok_or_else(|| {
        header.error(
            DATATYPE,
            format!("samples of NIfTI type {code} are not read"),
        )
    })?;
    let mut notes = Vec::new();
    let mut extras = Vec::new();
    if channels > 1 {
        extras.push(Extra {
            before: 0,
            size: channels,
            entries: meaning,
        });
    }
    // Time, then what there is of each sample, then what is not defined.
    let intent = match kind {
        Kind::Analyze => 0,
        _ => header.code(INTENT),
    };
    extras.extend(rest.into_iter().zip(4..).map(|(size, axis)| Extra {
        before: 3,
        size,
        entries: match (axis, intent) {
            (5, VECTORS) => Entries::Components,
            (5, COLORS | 2004) => Entries::Colors,
            _ => Entries::Numbered,
        },
    }));
    let (slope, mut shift) = (header.float(SLOPE, 0), header.float(SLOPE, 1));
    if kind == Kind::Analyze {
        shift = 0.0;
    }
    let scaled = slope != 0.0 && slope.is_finite() && shift.is_finite();
    let scaled = scaled && meaning != Entries::Colors;
    let scale = Some((slope, shift)).filter(|s| scaled && *s != (1.0, 0.0));
    let payload = header.payload(kind, number, &mut notes)?;
    let placed = match kind {
        Kind::Analyze => {
            notes.push(
                "this is Analyze 7.5, which does not say where left and right are: axes are not \
                 turned"
                    .into(),
            );
            header.steps_alone(dims, &mut notes)
        }
        _ => header.placement(dims, &mut notes),
    };
    let (lattice, is_placed) = placed.map_err(|error| no_volume(path, error))?;
    if kind != Kind::Analyze {
        notes.extend(header.units());
    }
    Ok(Description {
        lattice,
        is_placed,
        payload,
        extras,
        scale,
        name: "scalars".into(),
        notes,
    })
}

/// The first bytes of a file.
struct Header<'a> {
    path: &'a Path,
    bytes: Vec<u8>,
    endian: Endian,
    /// Whether it is of version 2, in which numbers have twice the bytes.
    wide: bool,
    /// Whether the file is packed with gzip.
    packed: bool,
}

impl Header<'_> {
    fn open(path: &Path) -> Result<Header<'_>, Error> {
        let wrong = |what: String| Error::Format {
            path: path.to_owned(),
            at: "byte 0".into(),
            what,
            help: None,
        };
        let (mut reader, packed) = open_unpacked(path)?;
        let mut bytes = vec![0; 4];
        let ends = |length: usize| {
            move |error: std::io::Error| {
                wrong(format!(
                    "there is no NIfTI header of {length} bytes ({error})"
                ))
            }
        };
        reader.read_exact(&mut bytes).map_err(ends(348))?;
        let sizes = [Endian::Little, Endian::Big].map(|e| (e, e.i32(&bytes)));
        let known = sizes.iter().find(|(_, size)| matches!(size, 348 | 540));
        let &(endian, size) = known.ok_or_else(|| {
            wrong("the header's size is neither 348 nor 540, as in NIfTI-1 and NIfTI-2".into())
        })?;
        bytes.resize(size as usize, 0);
        let rest = reader.read_exact(&mut bytes[4..]);
        rest.map_err(ends(size as usize))?;
        Ok(Header {
            path,
            bytes,
            endian,
            wide: size == 540,
            packed,
        })
    }

    fn at(&self, at: At) -> usize {
        if self.wide { at.1 } else { at.0 }
    }

    fn error(&self, at: At, what: String) -> Error {
        Error::Format {
            path: self.path.to_owned(),
            at: format!("byte {}", self.at(at)),
            what,
            help: None,
        }
    }

    /// Number `index` of the floats that begin at a place.
    fn float(&self, at: At, index: usize) -> f64 {
        let at = self.at(at);
        match self.wide {
            true => self.endian.f64(&self.bytes[at + 8 * index..][..8]),
            false => self.endian.f32(&self.bytes[at + 4 * index..][..4]).into(),
        }
    }

    /// A whole number: of 16 bits, and of 32 in version 2 but for the type of samples.
    fn code(&self, at: At) -> i32 {
        let place = self.at(at);
        match self.wide && at != DATATYPE {
            true => self.endian.i32(&self.bytes[place..][..4]),
            false => self.endian.i16(&self.bytes[place..][..2]).into(),
        }
    }

    /// Number `index` of `dim`.
    fn size(&self, index: usize) -> i64 {
        let at = self.at(DIM);
        match self.wide {
            true => self.endian.i64(&self.bytes[at + 8 * index..][..8]),
            false => self.endian.i16(&self.bytes[at + 2 * index..][..2]).into(),
        }
    }

    fn kind(&self) -> Result<Kind, Error> {
        let magic = &self.bytes[self.at(MAGIC)..][..4];
        match (magic, self.wide) {
            (b"n+1\0", false) | (b"n+2\0", true) => Ok(Kind::One),
            (b"ni1\0", false) | (b"ni2\0", true) => Ok(Kind::Pair),
            (_, false) if ending(self.path).is_some_and(|(_, e)| e.starts_with(".hdr")) => {
                Ok(Kind::Analyze)
            }
            _ => Err(self.error(MAGIC, "there is no NIfTI magic".into())),
        }
    }

    /// Samples along the three axes of space, and along those behind.
    fn sizes(&self) -> Result<([usize; 3], Vec<usize>), Error> {
        let rank = self.size(0);
        if !(1..=7).contains(&rank) {
            return Err(self.error(DIM, format!("{rank} dimensions; a volume has 3")));
        }
        if rank < 3 {
            let axes = ["no spatial axis", "one spatial axis", "two spatial axes"][rank as usize];
            return Err(self.error(DIM, format!("{axes}; a volume has three")));
        }
        let size = |i: usize| usize::try_from(self.size(i)).unwrap_or(0);
        let dims = [size(1), size(2), size(3)];
        Ok((dims, (4..=rank as usize).map(size).collect()))
    }

    /// Where the samples stand.
    fn payload(
        &self,
        kind: Kind,
        number: Number,
        notes: &mut Vec<String>,
    ) -> Result<Payload, Error> {
        let (file, least, packed) = match kind {
            // Where samples begin in one file with their header, at the earliest.
            Kind::One => (self.path.to_owned(), self.bytes.len() + 4, self.packed),
            Kind::Pair | Kind::Analyze => {
                let missing = || Error::Format {
                    path: self.path.to_owned(),
                    at: "the header".into(),
                    what: "the samples are in another file (.img), which is not there".into(),
                    help: Some("copy the .img file beside the .hdr file".into()),
                };
                let file = beside(self.path, &[".img", ".img.gz"]).ok_or_else(missing)?;
                let (_, packed) = open_unpacked(&file)?;
                (file, 0, packed)
            }
        };
        let at = self.at(VOX_OFFSET);
        let mut offset = match self.wide {
            true => self.endian.i64(&self.bytes[at..at + 8]) as f64,
            false => self.float(VOX_OFFSET, 0),
        };
        if kind == Kind::One && offset == 0.0 {
            notes.push(format!(
                "'vox_offset' is 0: samples are read from byte {least} on"
            ));
            offset = least as f64;
        }
        let earliest = match kind {
            Kind::One => self.bytes.len(),
            _ => 0,
        };
        if !(offset >= earliest as f64 && offset.fract() == 0.0 && offset < 2f64.powi(53)) {
            return Err(self.error(VOX_OFFSET, format!("samples that begin at byte {offset}")));
        }
        Ok(Payload {
            files: vec![file],
            start: 0,
            lines: 0,
            skip: Some(offset as u64),
            encoding: match packed {
                true => Encoding::Gzip,
                false => Encoding::Raw,
            },
            number,
            endian: self.endian,
        })
    }

    /// A note on the unit of lengths, if the file names it.
    fn units(&self) -> Option<String> {
        let at = self.at(UNITS);
        let code = match self.wide {
            true => self.endian.i32(&self.bytes[at..at + 4]),
            false => self.bytes[at].into(),
        };
        let unit = match code & 7 {
            1 => "meters",
            2 => "millimeters",
            3 => "micrometers",
            _ => return None,
        };
        Some(format!("lengths are in {unit}"))
    }

    /// The sizes of voxels, 1 where they are not sensible.
    fn steps(&self) -> [f64; 3] {
        [1, 2, 3].map(|i| match self.float(PIXDIM, i).abs() {
            step if step > 0.0 && step.is_finite() => step,
            _ => 1.0,
        })
    }

    /// Where samples lie, and whether the file says so.
    fn placement(
        &self,
        dims: [usize; 3],
        notes: &mut Vec<String>,
    ) -> Result<(Lattice, bool), Error> {
        let (has_qform, has_sform) = (self.code(QFORM) > 0, self.code(SFORM) > 0);
        let world = |origin: DVec3, axes: [DVec3; 3], notes: &mut Vec<String>| {
            // Numbers of 32 bits explain less than what a lattice allows anyway.
            let axes = axes.map(|axis| turned(axis, RAS.signs));
            axes::lattice(
                dims,
                turned(origin, RAS.signs),
                axes,
                [0.0; 3],
                Interpolation::Linear,
                notes,
            )
        };
        if has_sform {
            let row = |i: usize, row: usize| self.float(SROWS, 4 * row + i);
            let column = |i: usize| DVec3::new(row(i, 0), row(i, 1), row(i, 2));
            let found = world(column(3), [column(0), column(1), column(2)], notes);
            match found {
                Ok(lattice) => {
                    notes.extend(RAS.notes("RAS"));
                    return Ok((lattice, true));
                }
                Err(error) if !has_qform => return Err(error),
                Err(_) => notes.push("the file's sform is not drawn, so its qform is used".into()),
            }
        }
        if has_qform {
            let offset = |i| self.float(QOFFSET, i);
            let origin = DVec3::new(offset(0), offset(1), offset(2));
            let lattice = world(origin, self.qform(notes), notes)?;
            notes.extend(RAS.notes("RAS"));
            return Ok((lattice, true));
        }
        notes.push(
            "the file does not say where the volume lies (no sform, no qform): axes are not turned"
                .into(),
        );
        self.steps_alone(dims, notes)
    }

    /// The steps along the axes that the quaternion turns, in RAS.
    fn qform(&self, notes: &mut Vec<String>) -> [DVec3; 3] {
        let mut part = [0, 1, 2].map(|i| self.float(QUATERNION, i));
        let squares: f64 = part.iter().map(|x| x * x).sum();
        if squares > 1.0 {
            // A half turn; what is too long would stretch the axes.
            part = part.map(|x| x / squares.sqrt());
            if squares > 1.0 + 1e-5 {
                let length = squares.sqrt();
                notes.push(format!("the qform's quaternion is {length} long: made 1"));
            }
        }
        let [b, c, d] = part;
        let a = (1.0 - squares).max(0.0).sqrt();
        let x = DVec3::new(
            a * a + b * b - c * c - d * d,
            2.0 * (b * c + a * d),
            2.0 * (b * d - a * c),
        );
        let y = DVec3::new(
            2.0 * (b * c - a * d),
            a * a + c * c - b * b - d * d,
            2.0 * (c * d + a * b),
        );
        let z = DVec3::new(
            2.0 * (b * d + a * c),
            2.0 * (c * d - a * b),
            a * a + d * d - c * c - b * b,
        );
        // pixdim[0] says whether the third axis is mirrored.
        let mirror = if self.float(PIXDIM, 0) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let steps = self.steps();
        [x * steps[0], y * steps[1], z * steps[2] * mirror]
    }

    /// Axes that are not turned, from 0 on.
    fn steps_alone(
        &self,
        dims: [usize; 3],
        notes: &mut Vec<String>,
    ) -> Result<(Lattice, bool), Error> {
        let [x, y, z] = self.steps();
        let axes = [DVec3::X * x, DVec3::Y * y, DVec3::Z * z];
        axes::lattice(
            dims,
            DVec3::ZERO,
            axes,
            [0.0; 3],
            Interpolation::Linear,
            notes,
        )
        .map(|lattice| (lattice, false))
    }
}

/// The type of numbers, how many a sample has, and what they are.
fn number_of(code: i32) -> Option<(Number, usize, Entries)> {
    let number = match code {
        2 => Number::U8,
        4 => Number::I16,
        8 => Number::I32,
        16 => Number::F32,
        32 => return Some((Number::F32, 2, Entries::Complex)),
        64 => Number::F64,
        128 => return Some((Number::U8, 3, Entries::Colors)),
        256 => Number::I8,
        512 => Number::U16,
        768 => Number::U32,
        1024 => Number::I64,
        1280 => Number::U64,
        1792 => return Some((Number::F64, 2, Entries::Complex)),
        2304 => return Some((Number::U8, 4, Entries::Colors)),
        _ => return None,
    };
    Some((number, 1, Entries::Numbered))
}
