//! NIfTI-1, `.nii` and `.nii.gz`.
//!
//! <https://nifti.nimh.nih.gov/nifti-1>: 348 bytes of header, the samples behind it. The
//! axes are those of `sform` if the file has one, but for a little shear; else those of
//! `qform`; else the sizes of voxels alone. `scl_slope` and `scl_inter` are applied: what
//! is drawn are the values that were measured, as 32-bit floats. Each of several volumes is
//! a field.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice};

use super::number::Number;
use super::payload::{Encoding, Payload};
use super::space::{RAS, turned};
use super::{Description, Entries, Extra, axes, no_volume};
use crate::source::{Endian, open_file};

/// Bytes of a header.
const HEADER: usize = 348;

/// Where samples begin in one file with their header, at the earliest.
const SAMPLES: f64 = 352.0;

/// What NIFTI_INTENT_VECTOR says of the fifth axis.
const VECTORS: i16 = 1007;

/// NIFTI_INTENT_RGB_VECTOR, and with alpha the next.
const COLORS: i16 = 2003;

pub(crate) fn read(path: &Path, compressed: bool) -> Result<Description, Error> {
    let wrong = |at: usize, what: String| Error::Format {
        path: path.to_owned(),
        at: format!("byte {at}"),
        what,
        help: None,
    };
    let (file, _) = open_file(path)?;
    let mut bytes = [0; HEADER];
    let read = if compressed {
        MultiGzDecoder::new(file).read_exact(&mut bytes)
    } else {
        (&file).read_exact(&mut bytes)
    };
    read.map_err(|error| {
        wrong(
            0,
            format!("there is no NIfTI header of {HEADER} bytes ({error})"),
        )
    })?;
    let endian = match [Endian::Little, Endian::Big].map(|e| e.i32(&bytes[..4])) {
        [348, _] => Endian::Little,
        [_, 348] => Endian::Big,
        [540, _] | [_, 540] => {
            return Err(wrong(0, "this is NIfTI-2; version 1 is read".into()));
        }
        _ => {
            return Err(wrong(
                0,
                "the header's size is not 348, as in NIfTI-1".into(),
            ));
        }
    };
    match &bytes[344..348] {
        b"n+1\0" => {}
        b"ni1\0" => {
            return Err(Error::Format {
                path: path.to_owned(),
                at: "byte 344".into(),
                what: "the samples are in another file (.img)".into(),
                help: Some("save the volume as one .nii file".into()),
            });
        }
        _ => return Err(wrong(344, "there is no NIfTI magic".into())),
    }
    let short = |at: usize| endian.i16(&bytes[at..at + 2]);
    let float = |at: usize| f64::from(endian.f32(&bytes[at..at + 4]));
    let rank = short(40);
    if !(1..=7).contains(&rank) {
        return Err(wrong(40, format!("{rank} dimensions; a volume has 3")));
    }
    let size = |i: usize| match i <= rank as usize {
        true => usize::try_from(short(40 + 2 * i)).unwrap_or(0),
        false => 1,
    };
    if rank < 3 {
        let axes = ["no spatial axis", "one spatial axis", "two spatial axes"][rank as usize];
        return Err(wrong(40, format!("{axes}; a volume has three")));
    }
    let dims = [size(1), size(2), size(3)];
    let mut notes = Vec::new();
    let code = short(70);
    let (number, channels) = number_of(code)
        .ok_or_else(|| wrong(70, format!("samples of NIfTI type {code} are not read")))?;
    let mut extras = Vec::new();
    if channels > 1 {
        extras.push(Extra {
            before: 0,
            size: channels,
            entries: Entries::Colors,
        });
    }
    // Time, then what there is of each sample, then what is not defined.
    let intent = short(68);
    extras.extend((4..=rank as usize).map(|i| Extra {
        before: 3,
        size: size(i),
        entries: match (i, intent) {
            (5, VECTORS) => Entries::Components,
            (5, COLORS | 2004) => Entries::Colors,
            _ => Entries::Numbered,
        },
    }));
    let mut offset = float(108);
    if offset == 0.0 {
        notes.push(format!(
            "'vox_offset' is 0: samples are read from byte {SAMPLES} on"
        ));
        offset = SAMPLES;
    }
    if !(offset >= HEADER as f64 && offset.fract() == 0.0 && offset < 2f64.powi(53)) {
        return Err(wrong(108, format!("samples that begin at byte {offset}")));
    }
    let (slope, shift) = (float(112), float(116));
    let scaled = slope != 0.0 && slope.is_finite() && shift.is_finite() && channels == 1;
    let scale = Some((slope, shift)).filter(|s| scaled && *s != (1.0, 0.0));

    let (lattice, is_placed) =
        placement(dims, &short, &float, &mut notes).map_err(|error| no_volume(path, error))?;
    Ok(Description {
        lattice,
        is_placed,
        payload: Payload {
            files: vec![path.to_owned()],
            start: 0,
            lines: 0,
            skip: Some(offset as u64),
            encoding: match compressed {
                true => Encoding::Gzip,
                false => Encoding::Raw,
            },
            number,
            endian,
        },
        extras,
        scale,
        name: "scalars".into(),
        notes,
    })
}

/// Where samples lie, and whether the file says so.
fn placement(
    dims: [usize; 3],
    short: &dyn Fn(usize) -> i16,
    float: &dyn Fn(usize) -> f64,
    notes: &mut Vec<String>,
) -> Result<(Lattice, bool), Error> {
    let steps = [80, 84, 88].map(|at| match float(at).abs() {
        step if step > 0.0 && step.is_finite() => step,
        _ => 1.0,
    });
    let (has_qform, has_sform) = (short(252) > 0, short(254) > 0);
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
        let row = |i: usize, at: usize| float(at + 4 * i);
        let column = |i: usize| DVec3::new(row(i, 280), row(i, 296), row(i, 312));
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
        let mut part = [256, 260, 264].map(float);
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
        let mirror = if float(76) < 0.0 { -1.0 } else { 1.0 };
        let origin = DVec3::new(float(268), float(272), float(276));
        let axes = [x * steps[0], y * steps[1], z * steps[2] * mirror];
        let lattice = world(origin, axes, notes)?;
        notes.extend(RAS.notes("RAS"));
        return Ok((lattice, true));
    }
    notes.push(
        "the file does not say where the volume lies (no sform, no qform): axes are not turned"
            .into(),
    );
    let [x, y, z] = steps;
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

/// The type of numbers, and how many a sample has.
fn number_of(code: i16) -> Option<(Number, usize)> {
    let number = match code {
        2 => Number::U8,
        4 => Number::I16,
        8 => Number::I32,
        16 => Number::F32,
        64 => Number::F64,
        128 => return Some((Number::U8, 3)),
        256 => Number::I8,
        512 => Number::U16,
        768 => Number::U32,
        1024 => Number::I64,
        1280 => Number::U64,
        2304 => return Some((Number::U8, 4)),
        _ => return None,
    };
    Some((number, 1))
}
