//! NIfTI-1, `.nii` and `.nii.gz`.
//!
//! <https://nifti.nimh.nih.gov/nifti-1>: 348 bytes of header, the samples behind it. The
//! axes are those of `sform` if it says where it leads and has no shear, else those of
//! `qform`, else the sizes of voxels alone. `scl_slope` and `scl_inter` are applied: what
//! is drawn are the values that were measured, as 32-bit floats. Of several volumes the
//! first is read.

use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;

use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, no_volume};
use crate::source::{Endian, open_file};

/// Bytes of a header.
const HEADER: usize = 348;

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
    if !(3..=7).contains(&rank) {
        return Err(wrong(40, format!("{rank} dimensions; a volume has 3")));
    }
    let size = |i: usize| usize::try_from(short(40 + 2 * i)).unwrap_or(0);
    let dims = [size(1), size(2), size(3)];
    let mut notes = Vec::new();
    let volumes: usize = (4..=rank as usize)
        .map(|i| size(i).max(1))
        .fold(1, usize::saturating_mul);
    if volumes > 1 {
        notes.push(format!("the first of {volumes} volumes is read"));
    }
    let code = short(70);
    let number = number_of(code)
        .ok_or_else(|| wrong(70, format!("samples of NIfTI type {code} are not read")))?;
    let offset = float(108);
    if !(offset >= HEADER as f64 && offset.fract() == 0.0 && offset < 2f64.powi(53)) {
        return Err(wrong(108, format!("samples that begin at byte {offset}")));
    }
    let (slope, shift) = (float(112), float(116));
    let scaled = slope != 0.0 && slope.is_finite() && shift.is_finite();
    let scale = Some((slope, shift)).filter(|s| scaled && *s != (1.0, 0.0));

    let (origin, axes) = placement(&short, &float, &mut notes);
    let lattice = Lattice::from_axes(dims, origin, axes).map_err(|e| no_volume(path, e))?;
    let (offset, skip, encoding) = if compressed {
        (0, offset as u64, Encoding::Gzip)
    } else {
        (offset as u64, 0, Encoding::Raw)
    };
    Ok(Description {
        lattice,
        payload: Payload {
            files: vec![path.to_owned()],
            offset: Some(offset),
            skip,
            encoding,
            number,
            endian,
        },
        components: 1,
        interleaved: false,
        scale,
        name: "scalars".into(),
        notes,
    })
}

/// Origin and axes, world space.
fn placement(
    short: &dyn Fn(usize) -> i16,
    float: &dyn Fn(usize) -> f64,
    notes: &mut Vec<String>,
) -> (DVec3, [DVec3; 3]) {
    let steps = [80, 84, 88].map(|at| match float(at).abs() {
        step if step > 0.0 && step.is_finite() => step,
        _ => 1.0,
    });
    if short(254) > 0 {
        let row = |i: usize, at: usize| float(at + 4 * i);
        let column = |i: usize| DVec3::new(row(i, 280), row(i, 296), row(i, 312));
        let axes = [column(0), column(1), column(2)];
        if Lattice::from_axes([2; 3], column(3), axes).is_ok() {
            return (column(3), axes);
        }
        notes.push("the file's sform has shear, so its qform is used".into());
    }
    if short(252) > 0 {
        let [b, c, d] = [256, 260, 264].map(float);
        // Rounding may leave a little less than nothing.
        let a = (1.0 - (b * b + c * c + d * d)).max(0.0).sqrt();
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
        if Lattice::from_axes([2; 3], origin, axes).is_ok() {
            return (origin, axes);
        }
        notes.push("the file's qform is no rotation, so axes are not turned".into());
    }
    let [x, y, z] = steps;
    (DVec3::ZERO, [DVec3::X * x, DVec3::Y * y, DVec3::Z * z])
}

fn number_of(code: i16) -> Option<Number> {
    Some(match code {
        2 => Number::U8,
        4 => Number::I16,
        8 => Number::I32,
        16 => Number::F32,
        64 => Number::F64,
        256 => Number::I8,
        512 => Number::U16,
        768 => Number::U32,
        1024 => Number::I64,
        1280 => Number::U64,
        _ => return None,
    })
}
