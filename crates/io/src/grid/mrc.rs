//! MRC and CCP4 maps: `.mrc`, `.map`, `.ccp4`, `.rec`, `.st`, also packed with gzip.
//!
//! A. Cheng et al., "MRC2014: Extensions to the MRC format header for electron cryo-microscopy
//! and tomography", 2015, and <https://www.ccpem.ac.uk/mrc-format/mrc2014>: 1024 bytes of
//! header, an extended header that is passed over, the samples. Modes are 0 (signed
//! bytes; unsigned ones where IMOD's flags say so), 1, 2, 3 and 4 (complex), 6 and 12 (floats of 16 bits).
//!
//! `MAPC`, `MAPR` and `MAPS` say which axis columns, rows and sections run along. The samples
//! stay in the file's order; the grid's directions say where they lie. Distances are the cell's lengths
//! by its samples, in ångström. The first sample lies at `ORIGIN`, or, where that is zero, at
//! `NXSTART` and so on, as programs that draw maps have it. Several volumes are fields.
//!
//! The header is read here: it is 56 numbers at places of their own, and the crates for it
//! read no floats of 16 bits, or not from a part of a file.

use std::io::Read as _;
use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};

use super::number::Number;
use super::payload::{Encoding, Payload, open_unpacked};
use super::{Description, Entries, Extra, axes, no_volume};
use crate::source::{Endian, Source};

/// Bytes of a header.
const HEADER: usize = 1024;

// Where values stand in a header, in bytes.
const SIZE: usize = 0;
const MODE: usize = 12;
const START: usize = 16;
const SAMPLING: usize = 28;
const LENGTHS: usize = 40;
const ANGLES: usize = 52;
const AXES: usize = 64;
const SPACE_GROUP: usize = 88;
const EXTENDED: usize = 92;
const IMOD_STAMP: usize = 152;
const IMOD_FLAGS: usize = 156;
const ORIGIN: usize = 196;
const MAP: usize = 208;
const MACHINE: usize = 212;

/// The stamp that IMOD writes at [`IMOD_STAMP`]; the lowest of its flags then means that bytes are signed.
const IMOD: i32 = 1_146_047_817;

/// Angles of the cell are right if they are off by less than this, in degrees: lengths of a
/// million samples are known no better.
const RIGHT: f64 = 1e-4;

/// Whether this is the beginning of a map.
pub(crate) fn is_mrc(head: &[u8]) -> bool {
    head.get(MAP..MAP + 3) == Some(b"MAP")
}

pub(crate) fn read(path: &Path) -> Result<Description, Error> {
    let (mut reader, packed) = open_unpacked(path)?;
    let mut header = Header {
        source: Source {
            path: path.to_owned(),
            bytes: vec![0; HEADER],
        },
        endian: Endian::Little,
    };
    let read = reader.read_exact(&mut header.source.bytes);
    read.map_err(|error| {
        let what = format!("there is no MRC header of {HEADER} bytes ({error})");
        header.source.error("byte 0", what)
    })?;
    let mut notes = Vec::new();
    header.endian = header.endian(&mut notes)?;
    let (number, is_complex) = header.number(&mut notes)?;
    let (dims, volumes) = header.sizes(&mut notes)?;
    let lattice = header.lattice(dims, &mut notes)?;
    let extended = header.int(EXTENDED);
    let skip = u64::try_from(extended)
        .map_err(|_| header.error(EXTENDED, format!("an extended header of {extended} bytes")))?;
    let mut extras = Vec::new();
    if is_complex {
        extras.push(Extra {
            before: 0,
            size: 2,
            entries: Entries::Complex,
        });
    }
    if volumes > 1 {
        extras.push(Extra {
            before: 3,
            size: volumes,
            entries: Entries::Numbered,
        });
    }
    Ok(Description {
        lattice,
        is_placed: false,
        payload: Payload {
            files: vec![path.to_owned()],
            start: 0,
            lines: 0,
            skip: Some(HEADER as u64 + skip),
            encoding: match packed {
                true => Encoding::Gzip,
                false => Encoding::Raw,
            },
            number,
            endian: header.endian,
        },
        extras,
        scale: None,
        name: "scalars".into(),
        notes,
    })
}

struct Header {
    source: Source,
    endian: Endian,
}

impl Header {
    fn error(&self, at: usize, what: String) -> Error {
        self.source.error(format!("byte {at}"), what)
    }

    fn int(&self, at: usize) -> i32 {
        self.endian.i32(&self.source.bytes[at..at + 4])
    }

    fn ints(&self, at: usize) -> [i32; 3] {
        [0, 4, 8].map(|more| self.int(at + more))
    }

    fn floats(&self, at: usize) -> [f64; 3] {
        let float = |at| self.endian.f32(&self.source.bytes[at..at + 4]);
        [0, 4, 8].map(|more| float(at + more).into())
    }

    /// By the machine stamp; where that is none, by the mode.
    fn endian(&self, notes: &mut Vec<String>) -> Result<Endian, Error> {
        let stamp = &self.source.bytes[MACHINE..MACHINE + 2];
        match stamp {
            [0x44, 0x44 | 0x41] => return Ok(Endian::Little),
            [0x11, 0x11] => return Ok(Endian::Big),
            _ => {}
        }
        let mode = |endian: &Endian| endian.i32(&self.source.bytes[MODE..MODE + 4]);
        let is_mode = |endian: &Endian| (0..128).contains(&mode(endian));
        let found = [Endian::Little, Endian::Big].into_iter().find(is_mode);
        let endian = found
            .ok_or_else(|| self.error(MACHINE, format!("{stamp:02x?} is not a machine stamp")))?;
        notes.push(format!(
            "{stamp:02x?} is not a machine stamp: the file is taken to be {}, by its mode",
            endian.name()
        ));
        Ok(endian)
    }

    /// The type of numbers, and whether two of them are a complex number.
    fn number(&self, notes: &mut Vec<String>) -> Result<(Number, bool), Error> {
        let of_imod = self.int(IMOD_STAMP) == IMOD;
        match self.int(MODE) {
            0 if of_imod && self.int(IMOD_FLAGS) & 1 == 0 => {
                notes.push("bytes are unsigned, as IMOD's flags say".into());
                Ok((Number::U8, false))
            }
            0 => Ok((Number::I8, false)),
            1 => Ok((Number::I16, false)),
            2 => Ok((Number::F32, false)),
            3 => Ok((Number::I16, true)),
            4 => Ok((Number::F32, true)),
            6 => Ok((Number::U16, false)),
            12 => Ok((Number::F16, false)),
            mode => Err(self.error(MODE, format!("samples of MRC mode {mode} are not read"))),
        }
    }

    /// Samples along columns, rows and sections of a volume, and how many volumes there are.
    fn sizes(&self, notes: &mut Vec<String>) -> Result<([usize; 3], usize), Error> {
        let mut sizes = [0; 3];
        for (size, n) in sizes.iter_mut().zip(self.ints(SIZE)) {
            *size = usize::try_from(n)
                .map_err(|_| self.error(SIZE, format!("a volume of {n} samples along an axis")))?;
        }
        let group = self.int(SPACE_GROUP);
        // Stacks of volumes have 400 and the space group; `MZ` is the sections of one.
        let sections = usize::try_from(self.int(SAMPLING + 8)).unwrap_or(0);
        if (401..=630).contains(&group) {
            if sections == 0 || !sizes[2].is_multiple_of(sections) {
                let what = format!(
                    "volumes of {sections} sections, of which there are {}",
                    sizes[2]
                );
                return Err(self.error(SAMPLING + 8, what));
            }
            let volumes = sizes[2] / sections;
            sizes[2] = sections;
            return Ok((sizes, volumes));
        }
        if group == 0 && sizes[2] > 1 {
            notes.push("the file calls itself a stack of images, which becomes a volume".into());
        }
        Ok((sizes, 1))
    }

    fn lattice(&self, dims: [usize; 3], notes: &mut Vec<String>) -> Result<Lattice, Error> {
        let order = self.order(notes)?;
        let steps = self.steps(notes);
        let start = self.ints(START);
        let mut origin = DVec3::from_array(self.floats(ORIGIN));
        if !(origin.is_finite() && origin != DVec3::ZERO) {
            // Columns, rows and sections are counted from there.
            origin = (0..3).map(|i| steps[order[i]] * f64::from(start[i])).sum();
        } else if start != [0; 3] {
            notes.push(format!(
                "the first sample is at ORIGIN; NXSTART, NYSTART and NZSTART, {start:?}, are not \
                 used"
            ));
        }
        axes::lattice(
            dims,
            origin,
            order.map(|axis| steps[axis]),
            [0.0; 3],
            Interpolation::Linear,
            notes,
        )
        .map_err(|error| no_volume(&self.source.path, error))
    }

    /// Which of x, y and z columns, rows and sections run along.
    fn order(&self, notes: &mut Vec<String>) -> Result<[usize; 3], Error> {
        let axes = self.ints(AXES);
        if axes == [0; 3] {
            notes.push("the file does not name its axes: columns are x and rows y".into());
            return Ok([0, 1, 2]);
        }
        let mut sorted = axes;
        sorted.sort_unstable();
        if sorted != [1, 2, 3] {
            return Err(self.error(AXES, format!("columns, rows and sections along {axes:?}")));
        }
        if axes != [1, 2, 3] {
            let names = axes.map(|axis| ["x", "y", "z"][axis as usize - 1]);
            let [columns, rows, sections] = names;
            notes.push(format!(
                "columns run along {columns}, rows along {rows}, sections along {sections}"
            ));
        }
        Ok(axes.map(|axis| axis as usize - 1))
    }

    /// The steps between samples along the cell's axes x, y and z, ångström.
    fn steps(&self, notes: &mut Vec<String>) -> [DVec3; 3] {
        let (lengths, sampling) = (self.floats(LENGTHS), self.ints(SAMPLING));
        let mut steps = [1.0; 3];
        let is_good = |i: usize| lengths[i] > 0.0 && lengths[i].is_finite() && sampling[i] > 0;
        if (0..3).all(is_good) {
            steps = [0, 1, 2].map(|i| lengths[i] / f64::from(sampling[i]));
            notes.push("lengths are in ångström".into());
        } else {
            notes.push(format!(
                "the cell of {lengths:?} Å and {sampling:?} samples is none: distances are 1"
            ));
        }
        let mut angles = self.floats(ANGLES);
        if angles == [0.0; 3] {
            angles = [90.0; 3];
        }
        // a along x, b in the plane of x and y, as the PDB has it.
        let cosine = |angle: f64| match (angle - 90.0).abs() < RIGHT {
            true => 0.0,
            false => angle.to_radians().cos(),
        };
        let [alpha, beta, gamma] = angles.map(cosine);
        let sine = (1.0 - gamma * gamma).sqrt();
        let y = (alpha - beta * gamma) / sine;
        let c = DVec3::new(beta, y, (1.0 - beta * beta - y * y).sqrt());
        let directions = [DVec3::X, DVec3::new(gamma, sine, 0.0), c];
        [0, 1, 2].map(|i| directions[i] * steps[i])
    }
}
