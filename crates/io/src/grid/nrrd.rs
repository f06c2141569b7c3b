//! NRRD, `.nrrd` (one file) and `.nhdr` (with its numbers in others).
//!
//! <http://teem.sourceforge.net/nrrd/format.html>: a magic line, then `field: value` and
//! `key:=value` lines up to an empty one. Read are three spatial axes, with one axis of
//! components before or behind them; encodings raw, gzip and text; `data file` as a name,
//! a `LIST`, or a pattern with its numbers. Positions are in the file's own `space`.

use std::path::{Path, PathBuf};

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;

use super::header::{Header, clip};
use super::number::Number;
use super::payload::{Encoding, Payload};
use super::{Description, MOST_FILES, no_volume};
use crate::source::Endian;

/// What the fields say; see the format's description for their meaning.
#[derive(Default)]
struct Fields {
    number: Option<Number>,
    sizes: Vec<usize>,
    spacings: Vec<f64>,
    mins: Vec<f64>,
    directions: Vec<Option<DVec3>>,
    origin: Option<DVec3>,
    endian: Option<Endian>,
    encoding: Option<Encoding>,
    files: Vec<PathBuf>,
    byte_skip: i64,
    line_skip: u64,
    content: Option<String>,
}

pub(crate) fn read(path: &Path) -> Result<Description, Error> {
    let mut header = Header::open(path)?;
    header.next_line(); // the magic, which the caller has seen
    let mut fields = Fields::default();
    while let Some(line) = header.next_line() {
        let line = line.trim();
        if line.is_empty() {
            break;
        }
        if line.starts_with('#') || line.contains(":=") {
            continue;
        }
        let Some((key, value)) = line.split_once(':') else {
            return Err(header.error(format!("'{}' is no 'field: value'", clip(line))));
        };
        let value = value.trim();
        let list = fields.set(&header, &key.trim().to_ascii_lowercase(), value)?;
        if list {
            while let Some(line) = header.next_line() {
                let name = line.trim();
                if !name.is_empty() && fields.files.len() < MOST_FILES {
                    fields.files.push(header.beside(name));
                }
            }
        }
    }
    fields.description(path, &header)
}

impl Fields {
    /// Takes one field; true if the names of files follow it.
    fn set(&mut self, header: &Header, key: &str, value: &str) -> Result<bool, Error> {
        match key {
            "type" => {
                let found = number_of(value);
                self.number = Some(found.ok_or_else(|| {
                    header.error(format!("samples of type '{}' are not read", clip(value)))
                })?);
            }
            "sizes" => self.sizes = header.numbers(key, value)?,
            "spacings" => self.spacings = header.numbers(key, value)?,
            "axis mins" | "axismins" => self.mins = header.numbers(key, value)?,
            "space directions" => self.directions = vectors(header, key, value)?,
            "space origin" => {
                let found = vectors(header, key, value)?;
                self.origin = match found[..] {
                    [Some(origin)] => Some(origin),
                    _ => return Err(header.error("'space origin' is no single vector")),
                };
            }
            "endian" => {
                self.endian = match value {
                    "little" => Some(Endian::Little),
                    "big" => Some(Endian::Big),
                    _ => return Err(header.error(format!("unknown endian '{}'", clip(value)))),
                }
            }
            "encoding" => {
                self.encoding = match value.to_ascii_lowercase().as_str() {
                    "raw" => Some(Encoding::Raw),
                    "gzip" | "gz" => Some(Encoding::Gzip),
                    "txt" | "text" | "ascii" => Some(Encoding::Text),
                    other => {
                        return Err(header.error_with_help(
                            format!("the encoding '{}' is not read", clip(other)),
                            "raw, gzip and text are",
                        ));
                    }
                }
            }
            "byte skip" | "byteskip" => [self.byte_skip] = header.array(key, value)?,
            "line skip" | "lineskip" => [self.line_skip] = header.array(key, value)?,
            "content" => self.content = Some(clip(value)).filter(|c| !c.is_empty()),
            "data file" | "datafile" => {
                if value.split_ascii_whitespace().next() == Some("LIST") {
                    return Ok(true);
                }
                self.files = data_files(header, value)?;
            }
            _ => {}
        }
        Ok(false)
    }

    fn description(self, path: &Path, header: &Header) -> Result<Description, Error> {
        let missing = |key: &str| header.error(format!("there is no '{key}'"));
        let number = self.number.ok_or_else(|| missing("type"))?;
        let encoding = self.encoding.ok_or_else(|| missing("encoding"))?;
        if self.endian.is_none() && number.size() > 1 && encoding != Encoding::Text {
            return Err(missing("endian"));
        }
        let (axes, components, interleaved) = self.axes(header)?;
        let at = |values: &[f64], axis: usize, other: f64| {
            values
                .get(axis)
                .copied()
                .filter(|v| v.is_finite())
                .unwrap_or(other)
        };
        let mut steps = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut origin = self.origin.unwrap_or(DVec3::ZERO);
        for (i, axis) in axes.into_iter().enumerate() {
            match self.directions.get(axis) {
                Some(Some(direction)) => steps[i] = *direction,
                _ => {
                    steps[i] *= at(&self.spacings, axis, 1.0);
                    if self.origin.is_none() {
                        origin[i] = at(&self.mins, axis, 0.0);
                    }
                }
            }
        }
        let dims = axes.map(|axis| self.sizes[axis]);
        let lattice = Lattice::from_axes(dims, origin, steps);
        let lattice = lattice.map_err(|error| no_volume(path, error))?;
        let attached = self.files.is_empty();
        let mut offset = if attached {
            Some(header.position())
        } else {
            Some(0)
        };
        let mut skip = 0;
        match u64::try_from(self.byte_skip) {
            Ok(bytes) if encoding == Encoding::Gzip => skip = bytes,
            Ok(bytes) => offset = offset.map(|o| o.saturating_add(bytes)),
            // −1: the numbers are the end of the file.
            Err(_) if encoding == Encoding::Raw => offset = None,
            Err(_) => return Err(header.error("'byte skip' below 0 goes with raw data only")),
        }
        if self.line_skip > 0 {
            return Err(header.error_with_help(
                "'line skip' is not read",
                "give the bytes to pass over as 'byte skip'",
            ));
        }
        Ok(Description {
            lattice,
            payload: Payload {
                files: if attached {
                    vec![path.to_owned()]
                } else {
                    self.files
                },
                offset,
                skip,
                encoding,
                number,
                endian: self.endian.unwrap_or(Endian::Little),
            },
            components,
            interleaved,
            scale: None,
            name: self.content.unwrap_or_else(|| "scalars".into()),
            notes: Vec::new(),
        })
    }

    /// The three spatial axes, the number of components, and whether these come first.
    fn axes(&self, header: &Header) -> Result<([usize; 3], usize, bool), Error> {
        let spatial = |axis: &usize| !matches!(self.directions.get(*axis), Some(None));
        match (self.sizes.len(), self.directions.is_empty()) {
            (3, _) if (0..3).all(|a| spatial(&a)) => Ok(([0, 1, 2], 1, true)),
            (4, false) => {
                let kept: Vec<usize> = (0..4).filter(spatial).collect();
                let axes = <[usize; 3]>::try_from(kept).ok();
                let other = (0..4).find(|a| !spatial(a));
                match (axes, other) {
                    (Some(axes), Some(other @ (0 | 3))) => {
                        Ok((axes, self.sizes[other], other == 0))
                    }
                    _ => Err(header.error("of four axes the first or the last must be 'none'")),
                }
            }
            // Without directions the short axis is that of components.
            (4, true) if self.sizes[0] <= 9 => Ok(([1, 2, 3], self.sizes[0], true)),
            (4, true) => Ok(([0, 1, 2], self.sizes[3], false)),
            (n, _) => Err(header.error(format!("{n} axes; three spatial ones are read"))),
        }
    }
}

/// `(1,0,0) (0,1,0) none`.
fn vectors(header: &Header, key: &str, text: &str) -> Result<Vec<Option<DVec3>>, Error> {
    let wrong = || header.error(format!("'{key}' has '{}', no vectors of three", clip(text)));
    let mut vectors = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let (vector, after) = rest
            .strip_prefix('(')
            .and_then(|r| r.split_once(')'))
            .ok_or_else(wrong)?;
        let numbers: Option<Vec<f64>> = vector.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some([x, y, z]) => vectors.push(Some(DVec3::new(*x, *y, *z))),
            _ => return Err(wrong()),
        }
        rest = after.trim_start();
    }
    Ok(vectors)
}

/// A name, or a pattern with its first, last and increment: `quarter.%d 1 93 1`.
fn data_files(header: &Header, value: &str) -> Result<Vec<PathBuf>, Error> {
    let words: Vec<&str> = value.split_ascii_whitespace().collect();
    let numbers =
        |words: &[&str]| -> Option<Vec<i64>> { words.iter().map(|w| w.parse().ok()).collect() };
    if words.len() >= 4 && words[0].contains('%') {
        let numbers = numbers(&words[1..]);
        let Some([first, last, step, ..]) = numbers.as_deref() else {
            return Err(header.error(format!(
                "'{}' is no pattern with three numbers",
                clip(value)
            )));
        };
        let count = last.checked_sub(*first).and_then(|d| d.checked_div(*step));
        let count = count
            .and_then(|c| usize::try_from(c).ok())
            .filter(|c| *c < MOST_FILES);
        let Some(count) = count else {
            return Err(header.error(format!("files from {first} to {last} by {step}")));
        };
        let names = (0..=count as i64).map(|i| numbered(words[0], first + i * step));
        let names: Option<Vec<String>> = names.collect();
        let names = names.ok_or_else(|| {
            header.error(format!(
                "'{}' has no number like %d or %03d",
                clip(words[0])
            ))
        })?;
        return Ok(names.iter().map(|name| header.beside(name)).collect());
    }
    Ok(vec![header.beside(value)])
}

/// `pattern` with its one `%d` or `%03d` replaced.
fn numbered(pattern: &str, number: i64) -> Option<String> {
    let (before, rest) = pattern.split_once('%')?;
    let (width, after) = rest.split_once('d')?;
    let zeros = width.starts_with('0');
    let width: usize = if width.is_empty() {
        0
    } else {
        width.parse().ok()?
    };
    if width > 20 || after.contains('%') {
        return None;
    }
    Some(if zeros {
        format!("{before}{number:0width$}{after}")
    } else {
        format!("{before}{number:width$}{after}")
    })
}

fn number_of(name: &str) -> Option<Number> {
    Some(match name {
        "signed char" | "int8" | "int8_t" => Number::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Number::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Number::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Number::U16,
        "int" | "signed int" | "int32" | "int32_t" => Number::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Number::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Number::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Number::U64
        }
        "float" => Number::F32,
        "double" => Number::F64,
        _ => return None,
    })
}
