//! NRRD, `.nrrd` (one file) and `.nhdr` (with its numbers in others).
//!
//! <http://teem.sourceforge.net/nrrd/format.html>: a magic line, then `field: value` and
//! `key:=value` lines up to an empty one. `space directions` and `kinds` tell which three
//! axes are space; the entries of all others become fields. Encodings are raw, gzip and text;
//! `data file` is a name, a `LIST`, or a pattern with its numbers. Positions are converted
//! from the file's `space`.

use std::path::{Path, PathBuf};

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Interpolation;

use super::header::{Header, clip, data_files};
use super::number::Number;
use super::payload::{Encoding, Payload};
use super::space::{Space, turned};
use super::{Description, Entries, Extra, MOST_AXES, axes, no_volume};
use crate::source::Endian;

/// The fields of a header; see the format's description for their meaning.
#[derive(Default)]
struct Fields {
    number: Option<Number>,
    sizes: Vec<usize>,
    kinds: Vec<String>,
    spacings: Vec<f64>,
    mins: Vec<f64>,
    directions: Vec<Option<Vec<f64>>>,
    /// By how much numbers of `directions` may be off, as they are written.
    rounding: f64,
    origin: Option<Vec<f64>>,
    space: Option<String>,
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
            fields.files = header.files()?;
        }
    }
    fields.description(path, &header)
}

impl Fields {
    /// Takes one field; true if the names of files follow it.
    fn set(&mut self, header: &Header, key: &str, value: &str) -> Result<bool, Error> {
        match key {
            "type" => {
                let found = number_of(&value.to_ascii_lowercase());
                self.number = Some(found.ok_or_else(|| {
                    header.error(format!("samples of type '{}' are not read", clip(value)))
                })?);
            }
            "sizes" => self.sizes = header.numbers(key, value)?,
            "kinds" => {
                let words = value.split_ascii_whitespace();
                self.kinds = words.map(str::to_ascii_lowercase).collect();
            }
            "spacings" => self.spacings = header.numbers(key, value)?,
            "axis mins" | "axismins" => self.mins = header.numbers(key, value)?,
            "space" => self.space = Some(value.to_owned()),
            "space directions" => {
                self.directions = vectors(header, key, value)?;
                self.rounding = axes::rounding(value.split(['(', ')', ',', ' ', '\t']));
            }
            "space origin" => {
                let mut found = vectors(header, key, value)?;
                self.origin = match (found.pop(), found.is_empty()) {
                    (Some(Some(origin)), true) => Some(origin),
                    _ => return Err(header.error("'space origin' is no single vector")),
                };
            }
            "endian" => {
                self.endian = match value.to_ascii_lowercase().as_str() {
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
                let word = value.split_ascii_whitespace().next();
                if word.is_some_and(|word| word.eq_ignore_ascii_case("list")) {
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
        let mut notes = Vec::new();
        let (axes, extras) = self.axes(header, number, &mut notes)?;
        let (steps, origin) = self.place(header, axes)?;
        let space = self
            .space
            .as_deref()
            .filter(|_| !self.directions.is_empty());
        let (mut signs, mut is_placed) = (DVec3::ONE, false);
        if let Some(name) = space {
            match Space::of(name) {
                Some(space) => {
                    notes.extend(space.notes(&clip(name)));
                    (signs, is_placed) = (space.signs, space.anatomical);
                }
                None => notes.push(format!(
                    "the file's space, '{}', is not known: positions are taken as they are",
                    clip(name)
                )),
            }
        }
        let dims = axes.map(|axis| self.sizes[axis]);
        let steps = steps.map(|step| turned(step, signs));
        let rounding = [self.rounding; 3];
        let lattice = axes::lattice(
            dims,
            turned(origin, signs),
            steps,
            rounding,
            Interpolation::Linear,
            &mut notes,
        );
        let lattice = lattice.map_err(|error| no_volume(path, error))?;
        let skip = u64::try_from(self.byte_skip).ok();
        // −1: the numbers are the end of the file, or of what is unpacked.
        if skip.is_none() && encoding == Encoding::Text {
            return Err(header.error("'byte skip' below 0 does not go with text"));
        }
        let attached = self.files.is_empty();
        Ok(Description {
            lattice,
            is_placed,
            payload: Payload {
                files: match attached {
                    true => vec![path.to_owned()],
                    false => self.files,
                },
                start: match attached {
                    true => header.position(),
                    false => 0,
                },
                lines: self.line_skip,
                skip,
                encoding,
                number,
                endian: self.endian.unwrap_or(Endian::Little),
            },
            extras,
            scale: None,
            name: self.content.unwrap_or_else(|| "scalars".into()),
            notes,
        })
    }

    /// The steps along the axes of space and where the first sample lies, in the file's space.
    fn place(&self, header: &Header, axes: [usize; 3]) -> Result<([DVec3; 3], DVec3), Error> {
        let in_space = |vector: &[f64]| match *vector {
            [x, y, z] => Some(DVec3::new(x, y, z)),
            // With time, of which space does not depend.
            [x, y, z, 0.0] => Some(DVec3::new(x, y, z)),
            _ => None,
        };
        let at = |values: &[f64], axis: usize, other: f64| {
            let value = values.get(axis).copied().filter(|v| v.is_finite());
            value.unwrap_or(other)
        };
        let mut steps = [DVec3::X, DVec3::Y, DVec3::Z];
        let mut origin = DVec3::ZERO;
        if let Some(vector) = &self.origin {
            let of_space = match vector.as_slice() {
                [x, y, z, _] => in_space(&[*x, *y, *z]),
                other => in_space(other),
            };
            let wrong = || header.error("'space origin' has no three coordinates of space");
            origin = of_space.ok_or_else(wrong)?;
        }
        for (i, axis) in axes.into_iter().enumerate() {
            match self.directions.get(axis) {
                Some(Some(direction)) => {
                    let wrong = || {
                        header.error(format!("axis {axis} of 'space directions' is not in space"))
                    };
                    steps[i] = in_space(direction).ok_or_else(wrong)?;
                }
                _ => {
                    steps[i] *= at(&self.spacings, axis, 1.0);
                    if self.origin.is_none() {
                        origin[i] = at(&self.mins, axis, 0.0);
                    }
                }
            }
        }
        Ok((steps, origin))
    }

    /// The three axes of space, and what the entries of the others are.
    fn axes(
        &self,
        header: &Header,
        number: Number,
        notes: &mut Vec<String>,
    ) -> Result<([usize; 3], Vec<Extra>), Error> {
        let rank = self.sizes.len();
        if rank > MOST_AXES {
            return Err(header.error(format!("{rank} axes; up to {MOST_AXES} are read")));
        }
        for (key, count) in [
            ("kinds", self.kinds.len()),
            ("space directions", self.directions.len()),
        ] {
            if count != 0 && count != rank {
                return Err(header.error(format!("'{key}' has {count} entries for {rank} axes")));
            }
        }
        let kind = |axis: usize| Kind::of(self.kinds.get(axis).map_or("???", String::as_str));
        let is_space = |axis: &usize| match (self.directions.get(*axis), kind(*axis)) {
            // The fourth of four coordinates is time.
            (Some(Some(vector)), _) => vector.iter().take(3).any(|x| *x != 0.0),
            (Some(None), _) => false,
            (None, kind) => matches!(kind, Kind::Space | Kind::Unknown),
        };
        let mut space: Vec<usize> = (0..rank).filter(is_space).collect();
        let unknown = |axis: &usize| kind(*axis) == Kind::Unknown;
        if space.len() == 4 && self.directions.is_empty() && (0..4).all(|a| unknown(&a)) {
            // A short first axis is that of components, as a rule.
            let other = if self.sizes[0] <= 9 { 0 } else { 3 };
            space.remove(other);
            notes.push(format!(
                "axis {other} of four is taken for that of components, as no 'kinds' say"
            ));
        }
        // Of more than three the first are space, as ITK has it, and the rest frames.
        space.truncate(3);
        let Ok(axes) = <[usize; 3]>::try_from(space.as_slice()) else {
            let found = ["no spatial axis", "one spatial axis", "two spatial axes"][space.len()];
            return Err(header.error(format!("{found} of {rank}; a volume has three")));
        };
        let others = (0..rank).filter(|axis| !axes.contains(axis));
        let extras = others.map(|axis| Extra {
            before: axes.iter().filter(|space| **space < axis).count(),
            size: self.sizes[axis],
            entries: match kind(axis) {
                Kind::Components => Entries::Components,
                Kind::Colors => Entries::Colors,
                Kind::Unknown => Entries::of_bytes(number, self.sizes[axis]),
                Kind::Space | Kind::Frames => Entries::Numbered,
            },
        });
        Ok((axes, extras.collect()))
    }
}

/// The kind of an axis.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Space,
    Frames,
    Components,
    Colors,
    Unknown,
}

impl Kind {
    /// By its name in lower case.
    fn of(name: &str) -> Kind {
        match name {
            "domain" | "space" => Kind::Space,
            "time" | "list" | "point" => Kind::Frames,
            "???" | "none" => Kind::Unknown,
            color if color.ends_with("-color") => Kind::Colors,
            _ => Kind::Components,
        }
    }
}

/// `(1,0,0) (0,1,0) none`.
fn vectors(header: &Header, key: &str, text: &str) -> Result<Vec<Option<Vec<f64>>>, Error> {
    let wrong = || header.error(format!("'{key}' has '{}', no vectors", clip(text)));
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
        // Some writers have (nan,nan,nan) for `none`.
        let numbers = numbers.ok_or_else(wrong)?;
        vectors.push(Some(numbers).filter(|n| !n.iter().all(|x| x.is_nan())));
        rest = after.trim_start();
    }
    Ok(vectors)
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
