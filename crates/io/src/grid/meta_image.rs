//! MetaImage, `.mha` (one file) and `.mhd` (with its numbers in another).
//!
//! Lines of `Key = Value`, of which `ElementDataFile` is the last. `TransformMatrix`
//! (or `Orientation`, `Rotation`) has the direction of the first axis, then of the
//! second, then of the third; `Offset` (or `Position`, `Origin`) is the center of the
//! first sample. Positions are the file's own: `AnatomicalOrientation` only names them.

use std::path::Path;

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;

use super::header::{Header, clip};
use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, no_volume};
use crate::source::Endian;

pub(crate) fn read(path: &Path) -> Result<Description, Error> {
    let mut header = Header::open(path)?;
    let (mut dims, mut number, mut file) = (None, None, None);
    let (mut spacing, mut size) = (None, None);
    let mut origin = [0.0; 3];
    let mut axes = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
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
                let [n] = header.array::<u64, 1>(key, value)?;
                if n != 3 {
                    return Err(header.error(format!("an image of {n} dimensions; 3 are read")));
                }
            }
            "dimsize" => dims = Some(header.array::<usize, 3>(key, value)?),
            "elementspacing" => spacing = Some(header.array::<f64, 3>(key, value)?),
            "elementsize" => size = Some(header.array::<f64, 3>(key, value)?),
            "offset" | "position" | "origin" => origin = header.array(key, value)?,
            "transformmatrix" | "orientation" | "rotation" => axes = header.array(key, value)?,
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
    let dims = dims.ok_or_else(|| missing("DimSize"))?;
    let number = number.ok_or_else(|| missing("ElementType"))?;
    let file = file.ok_or_else(|| missing("ElementDataFile"))?;
    let [x, y, z] = spacing.or(size).unwrap_or([1.0; 3]);
    let [a, b, c] = [0, 3, 6].map(|i| DVec3::from_slice(&axes[i..i + 3]));
    let lattice = Lattice::from_axes(dims, origin.into(), [a * x, b * y, c * z]);
    let lattice = lattice.map_err(|error| no_volume(path, error))?;
    let (files, offset) = if file.eq_ignore_ascii_case("local") {
        (vec![path.to_owned()], skip.map(|s| s + header.position()))
    } else if file.eq_ignore_ascii_case("list") || file.contains('%') {
        return Err(header.error_with_help(
            "one file a slice is not read",
            "save the volume as one .mha file",
        ));
    } else {
        (vec![header.beside(&file)], skip)
    };
    if compressed && !binary {
        return Err(header.error("text cannot be compressed"));
    }
    Ok(Description {
        lattice,
        payload: Payload {
            files,
            offset,
            skip: 0,
            encoding: match (compressed, binary) {
                (true, _) => Encoding::Zlib,
                (false, true) => Encoding::Raw,
                (false, false) => Encoding::Text,
            },
            number,
            endian,
        },
        components,
        interleaved: true,
        scale: None,
        name: "scalars".into(),
        notes: Vec::new(),
    })
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
