//! Regular grids: `.mha`/`.mhd`, `.nrrd`/`.nhdr`, `.nii`/`.nii.gz` and `.hdr` with `.img`,
//! `.npy`/`.npz`, `.mrc`, TIFF stacks, DICOM series and raw samples.
//!
//! Each reader turns a header into a description: where the samples lie in space, and
//! where and how they stand in files. What follows is the same for all: lengths are
//! checked, then samples are read a few at a time, in the type in which they were stored.
//! Axes that are not space (frames, components) become fields, one for each entry.
//! Where files say how they lie in a body, positions are in LPS; see `space`.
//! VTK's grids (`.vti`, legacy `STRUCTURED_POINTS`) come from the VTK readers.
//!
//! # NIfTI
//! Both versions, in one file or in pairs, whichever file of a pair is given. Real and imaginary
//! parts and magnitudes of complex numbers are fields, and so is each channel of colors.
//! A pair without NIfTI's magic is Analyze 7.5, whose axes are not turned.
//!
//! # NumPy
//! The last axis is x: `a[z, y, x]`, whether the numbers stand in C or in Fortran order. A fourth
//! axis is that of channels if it is the last and has up to four entries, else the first is that
//! of frames. All arrays of an `.npz` that have three axes or more are fields.
//!
//! # MRC
//! Positions are in ångström, from `ORIGIN`, or from `NXSTART` and its like where that is zero.
//! `MAPC`, `MAPR` and `MAPS` turn the axes; cells that are not right-angled are refused.
//!
//! # TIFF
//! Pages are slices; channels, frames and distances are what ImageJ, OME-XML or tifffile write
//! into the first page's description. JPEG, and pages of 1 to 7 bits, are not read.
//!
//! # DICOM
//! A folder, one of its files, or one file of several frames; see the module `dicom`.

pub(crate) mod axes;
#[cfg(feature = "dicom")]
mod dicom;
pub(crate) mod formats;
pub(crate) mod ghosts;
pub(crate) mod header;
pub(crate) mod meta_image;
mod mrc;
mod nifti;
mod npy;
mod npz;
pub(crate) mod nrrd;
pub(crate) mod number;
pub(crate) mod payload;
pub(crate) mod raw;
mod space;
#[cfg(feature = "tiff")]
mod tiff;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tetrascope_core::grid::{BrickSource as _, GridStream, Lattice, Samples};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, Grid, Volume};

pub use raw::{ByteOrder, RawFile, RawLayout};

use crate::fields::{Choice, choose, is_wide};
use crate::source::Source;
use number::{Number, Numbers, missing_note};
use payload::{Encoding, Payload};

/// A regular grid with every scalar field that its file offers.
#[derive(Clone, Debug)]
pub struct GridData {
    /// The fields, at least one; the one to draw first.
    pub fields: Vec<GridField>,
    /// The world in which the file says that the grid lies: LPS, where x grows to a patient's
    /// left, y to the back and z to the head; `None` if the file does not say.
    pub space: Option<&'static str>,
    /// Findings, conversions and omissions, one sentence each.
    pub notes: Vec<String>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Samples with a name.
#[derive(Clone, Debug)]
pub struct GridField {
    /// Name in the file.
    pub name: String,
    /// Where the samples lie, as the file says. Cell data are samples at the cells' centers that fill
    /// their cells.
    pub association: Association,
    /// Where the samples lie, world space.
    pub lattice: Lattice,
    /// Its samples.
    pub samples: FieldSamples,
    /// A number of the file is its sample and this.
    pub offset: f64,
}

/// Where a field's samples are.
#[derive(Clone, Debug)]
pub enum FieldSamples {
    /// In memory.
    Loaded(Samples),
    /// In their file, as they take more than
    /// [`ReadOptions::stream_above`](crate::ReadOptions::stream_above).
    Streamed(GridStream),
}

impl FieldSamples {
    /// The least and greatest finite sample, if there is any.
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            FieldSamples::Loaded(samples) => samples.range(),
            FieldSamples::Streamed(stream) => stream.scalar_range(),
        }
    }

    /// How many samples are not finite, which is to have no value.
    pub fn missing(&self) -> u64 {
        match self {
            FieldSamples::Loaded(samples) => samples.missing(),
            FieldSamples::Streamed(stream) => stream.missing(),
        }
    }
}

impl GridData {
    /// The number of the field that a name means, and what is to be said about the choice;
    /// as [`MeshData::choose`](crate::MeshData::choose).
    ///
    /// # Errors
    /// [`Error::NoSuchField`] with the fields that exist.
    pub fn choose(&self, name: Option<&str>) -> Result<(usize, Option<String>), Error> {
        let fields = self.fields.iter();
        let names: Vec<_> = fields.map(|f| (f.name.as_str(), f.association)).collect();
        let choice = choose(&names, name, |i| is_wide(self.fields[i].samples.range()));
        let Choice { index, note } =
            choice.ok_or_else(|| self.no_field(name.unwrap_or_default()))?;
        Ok((index, note))
    }

    /// The volume with the field that [`GridData::choose`] finds; and the field's name.
    ///
    /// # Errors
    /// As [`GridData::choose`].
    pub fn into_volume(self, name: Option<&str>) -> Result<(Volume, String), Error> {
        let (chosen, _) = self.choose(name)?;
        let field = self.fields.into_iter().nth(chosen);
        let field = field.ok_or_else(|| Error::invalid("a grid without a field"))?;
        let lattice = field.lattice;
        let volume = match field.samples {
            FieldSamples::Loaded(samples) => Volume::Grid(Grid::on(lattice, samples)?),
            FieldSamples::Streamed(stream) => {
                Volume::Stream(stream.interpolated(lattice.interpolation)?)
            }
        };
        Ok((volume, field.name))
    }

    /// [`GridData::into_volume`], of which the field that is called `coverage` says how much is
    /// there; see [`tetrascope_core::grid::coverage`].
    ///
    /// # Errors
    /// As [`GridData::choose`], also of the coverage; [`Error::Invalid`] if one of both stays in
    /// its file, if they do not lie at the same points, and for shares that are not in [0, 1].
    pub fn into_covered_volume(
        self,
        name: Option<&str>,
        coverage: &str,
    ) -> Result<(Volume, String), Error> {
        let (shares, _) = self.choose(Some(coverage))?;
        let GridField {
            lattice, samples, ..
        } = self.fields[shares].clone();
        let (volume, name) = self.into_volume(name)?;
        let (Volume::Grid(grid), FieldSamples::Loaded(samples)) = (volume, samples) else {
            return Err(Error::Invalid {
                what: format!("'{name}' or its coverage stays in its file"),
                help: Some("read all of the file to memory: a coverage is not streamed".into()),
            });
        };
        if *grid.lattice() != lattice {
            return Err(Error::invalid(format!(
                "'{name}' and '{coverage}' do not lie at the same points"
            )));
        }
        let shares = (0..samples.len()).map(|i| samples.get(i) as f32).collect();
        Ok((Volume::Grid(grid.covered(shares)?), name))
    }

    /// A grid whose fields, by name, stay in the file that begins with `head`; `None`
    /// without any.
    pub(crate) fn streamed(
        head: &Source,
        files: impl Iterator<Item = (String, RawFile)>,
        mut notes: Vec<String>,
    ) -> Result<Option<GridData>, Error> {
        let mut fields = Vec::new();
        for (name, file) in files {
            let lattice = file.lattice();
            let stream = GridStream::new(Arc::new(file))?;
            notes.extend(missing_note(&name, stream.missing()));
            let field = Field {
                name,
                samples: FieldSamples::Streamed(stream),
                offset: 0.0,
            };
            fields.push(field.on(lattice, Association::Point));
        }
        notes.push("samples are read from the file when they are needed".into());
        Ok((!fields.is_empty()).then(|| GridData {
            fields,
            space: None,
            notes,
            files: vec![head.path.clone()],
        }))
    }

    fn no_field(&self, name: &str) -> Error {
        let fields = self.fields.iter().map(|field| {
            let range = field.samples.range();
            let range = range.map_or(String::new(), |(low, high)| format!(" [{low}, {high}]"));
            format!("{}{range}", field.name)
        });
        Error::NoSuchField {
            name: name.into(),
            available: fields.collect(),
        }
    }
}

/// The content of a header.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    pub(crate) lattice: Lattice,
    /// Whether the file says how the grid lies in the world.
    pub(crate) is_placed: bool,
    pub(crate) payload: Payload,
    /// The axes that are not space, in the order of the file.
    pub(crate) extras: Vec<Extra>,
    /// A stored number x is the scalar x · slope + shift.
    pub(crate) scale: Option<(f64, f64)>,
    pub(crate) name: String,
    pub(crate) notes: Vec<String>,
}

/// An axis that is not space: each of its entries is a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Extra {
    /// How many axes of space come before it and so vary faster: 0 to 3.
    pub(crate) before: usize,
    pub(crate) size: usize,
    pub(crate) entries: Entries,
}

/// The meaning of an axis that is not space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entries {
    /// Frames and the like.
    Numbered,
    /// Parts of vectors and tensors.
    Components,
    /// Red, green, blue and perhaps alpha.
    Colors,
    /// The real and the imaginary part, before all other axes.
    Complex,
}

impl Entries {
    /// The customary meaning of `components` numbers in a file that does not say: colors if they are three
    /// or four bytes, as VTK and ITK have it.
    pub(crate) fn of_bytes(number: Number, components: usize) -> Entries {
        match (number, components) {
            (Number::U8, 3 | 4) => Entries::Colors,
            _ => Entries::Components,
        }
    }
}

/// The most axes of a file, as NRRD has it.
pub(crate) const MOST_AXES: usize = 16;

/// The most fields that the axes that are not space may make.
const MOST_FIELDS: usize = 1 << 16;

/// The most files that one header may name.
pub(crate) const MOST_FILES: usize = 1 << 16;

/// Notes on fields beyond this are counted.
const MOST_NOTES: usize = 12;

/// An [`Error::Format`] for a lattice that a file's header makes.
pub(crate) fn no_volume(path: &Path, error: Error) -> Error {
    let help = error.help();
    let what = match error {
        Error::Invalid { what, .. } => what,
        other => other.to_string(),
    };
    Error::Format {
        path: path.to_owned(),
        at: "the header".into(),
        what,
        help,
    }
}

/// Reads samples that are not in a [`Payload`]; see `Description::read_from`.
pub(crate) type Runs<'a> = &'a mut dyn FnMut(usize, usize) -> Result<Vec<Numbers>, Error>;

impl Description {
    /// Reads the samples, or leaves them in their file if they take more than
    /// `stream_above` bytes and can be read there.
    pub(crate) fn read(self, path: &Path, stream_above: u64) -> Result<GridData, Error> {
        self.finish(path, Some(stream_above), None)
    }

    /// Takes the samples from `runs`, which gives as many runs as its second argument says, of
    /// as many numbers each as its first says; the payload then tells their type and file.
    #[cfg(any(feature = "dicom", feature = "tiff"))]
    pub(crate) fn read_from(self, path: &Path, runs: Runs) -> Result<GridData, Error> {
        self.finish(path, None, Some(runs))
    }

    fn finish(
        self,
        path: &Path,
        stream_above: Option<u64>,
        runs: Option<Runs>,
    ) -> Result<GridData, Error> {
        let Description {
            lattice,
            is_placed,
            payload,
            extras,
            scale,
            name,
            mut notes,
        } = self;
        let damaged = |what: String| Error::Format {
            path: path.to_owned(),
            at: "the header".into(),
            what,
            help: None,
        };
        let entries = extras
            .iter()
            .try_fold(1, |n: usize, e| n.checked_mul(e.size));
        let entries = entries.filter(|n| (1..=MOST_FIELDS).contains(n));
        let Some(entries) = entries else {
            let sizes: Vec<usize> = extras.iter().map(|extra| extra.size).collect();
            return Err(damaged(format!(
                "{sizes:?} numbers for each sample; 1 to {MOST_FIELDS} are read"
            )));
        };
        let points = lattice.validate().map_err(|error| no_volume(path, error))?;
        let count = points
            .checked_mul(entries)
            .filter(|n| n.checked_mul(8).is_some())
            .ok_or_else(|| damaged(format!("{points} samples of {entries} numbers")))?;
        let mut files = vec![path.to_owned()];
        files.extend(payload.files.iter().filter(|f| *f != path).cloned());
        let bytes = count as u64 * payload.number.sample_size() as u64;
        // Entries of axes behind those of space are parts of the file of their own.
        let last = extras.iter().position(|extra| extra.before == 3);
        let (within, behind) = extras.split_at(last.unwrap_or(extras.len()));
        let parts: usize = behind.iter().map(|extra| extra.size).product();
        let is_large = stream_above.is_some_and(|above| bytes > above);
        let streams = if is_large && within.is_empty() && scale.is_none() {
            payload.streams(lattice, points, parts)?
        } else {
            None
        };
        let fields = match streams {
            Some(streams) => {
                notes.push(format!(
                    "{bytes} bytes of samples are read from the file when they are needed"
                ));
                let mut fields = Vec::new();
                for (i, stream) in streams.into_iter().enumerate() {
                    let name = entry_name(&name, i, &extras, false);
                    notes.extend(missing_note(&name, stream.missing()));
                    fields.push(Field {
                        name,
                        samples: FieldSamples::Streamed(stream),
                        offset: 0.0,
                    });
                }
                fields
            }
            None => {
                let runs = match runs {
                    Some(runs) => runs(count / parts, parts)?,
                    None => payload.read(count / parts, parts)?,
                };
                let mut numbers = separate(runs, lattice.dims, within);
                if let Some((slope, shift)) = scale {
                    notes.push(format!(
                        "stored samples are scaled by {slope} and moved by {shift}"
                    ));
                    // A complex number is moved along the real axis.
                    let is_complex = |e: &Extra| e.entries == Entries::Complex;
                    let is_complex = extras.first().is_some_and(is_complex);
                    let shift = |i: usize| if is_complex && i % 2 == 1 { 0.0 } else { shift };
                    let numbers_of = numbers.iter().enumerate();
                    numbers = numbers_of.map(|(i, n)| n.scaled(slope, shift(i))).collect();
                }
                fields(&name, numbers, &extras, &mut notes)
            }
        };
        let fields = fields.into_iter();
        Ok(GridData {
            fields: fields.map(|f| f.on(lattice, Association::Point)).collect(),
            space: is_placed.then_some(space::WORLD),
            notes,
            files,
        })
    }
}

impl Payload {
    /// `parts` runs of samples on `lattice` where they stand, if they can be read there.
    fn streams(
        &self,
        lattice: Lattice,
        points: usize,
        parts: usize,
    ) -> Result<Option<Vec<GridStream>>, Error> {
        let (Some(sample_type), Encoding::Raw, [path]) =
            (self.number.sample_type(), self.encoding, &self.files[..])
        else {
            return Ok(None);
        };
        let (_, offset) = self.begin(path, points * parts)?;
        let order = ByteOrder::from(self.endian);
        // One file for all parts, as only so many can be open.
        let first = RawFile::open(path, offset, lattice, sample_type, order)?;
        let part_bytes = (points * sample_type.bytes()) as u64;
        let stream = |part: usize| {
            let file = first.later(part as u64 * part_bytes);
            GridStream::new(Arc::new(file))
        };
        (0..parts).map(stream).collect::<Result<_, _>>().map(Some)
    }
}

/// A field that has no place yet.
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) samples: FieldSamples,
    pub(crate) offset: f64,
}

impl Field {
    pub(crate) fn on(self, lattice: Lattice, association: Association) -> GridField {
        GridField {
            name: self.name,
            association,
            lattice,
            samples: self.samples,
            offset: self.offset,
        }
    }
}

/// Takes apart `runs` of numbers, in each of which the axes `within` stand before or between
/// those of space: the numbers of one entry of all axes each, that of the first axis fastest.
fn separate(runs: Vec<Numbers>, dims: [usize; 3], within: &[Extra]) -> Vec<Numbers> {
    if within.is_empty() {
        return runs;
    }
    // How far apart neighbors along each axis stand.
    let (mut extra_steps, mut space_steps, mut step) = (Vec::new(), [0; 3], 1);
    for axis in 0..=3 {
        for extra in within.iter().filter(|extra| extra.before == axis) {
            extra_steps.push(step);
            step *= extra.size;
        }
        if axis < 3 {
            space_steps[axis] = step;
            step *= dims[axis];
        }
    }
    let entries: usize = within.iter().map(|extra| extra.size).product();
    let mut separated = Vec::new();
    for run in runs {
        for entry in 0..entries {
            let mut rest = entry;
            let mut first = 0;
            for (extra, step) in within.iter().zip(&extra_steps) {
                first += rest % extra.size * step;
                rest /= extra.size;
            }
            let [nx, ny, nz] = dims;
            let [x, y, z] = space_steps;
            let row = |k, j| (0..nx).map(move |i| first + i * x + j * y + k * z);
            let layer = |k| (0..ny).flat_map(move |j| row(k, j));
            separated.push(run.pick((0..nz).flat_map(layer)));
        }
    }
    separated
}

/// The fields that the `numbers` of each entry of `extras` become, that of the first axis
/// fastest, with the magnitudes of vectors before their components.
pub(crate) fn fields(
    name: &str,
    numbers: Vec<Numbers>,
    extras: &[Extra],
    notes: &mut Vec<String>,
) -> Vec<Field> {
    if extras.iter().any(|extra| extra.entries == Entries::Colors) {
        notes.push(format!(
            "'{name}' holds colors: each channel (0 is red, 1 green, 2 blue, 3 alpha) is a \
             field, and one of them is drawn"
        ));
    }
    let mut magnitudes = magnitudes(&numbers, extras).into_iter().peekable();
    let mut found = Vec::new();
    let mut said = Vec::new();
    for (entry, numbers) in numbers.into_iter().enumerate() {
        let field_name = entry_name(name, entry, extras, false);
        if let Some((_, samples)) = magnitudes.next_if(|(first, _)| *first == entry) {
            let vector = entry_name(name, entry, extras, true);
            found.push(Field {
                name: format!("{vector}-magnitude"),
                samples: FieldSamples::Loaded(samples),
                offset: 0.0,
            });
        }
        let converted = numbers.convert();
        said.extend(converted.notes(&field_name));
        found.push(Field {
            name: field_name,
            samples: FieldSamples::Loaded(converted.samples),
            offset: converted.offset,
        });
    }
    if said.len() > MOST_NOTES {
        let more = said.len() - MOST_NOTES;
        said.truncate(MOST_NOTES);
        said.push(format!(
            "{more} more notes like these on fields of '{name}'"
        ));
    }
    notes.extend(said);
    found
}

/// The magnitude of each vector of two or three components, with its first one's entry.
fn magnitudes(numbers: &[Numbers], extras: &[Extra]) -> Vec<(usize, Samples)> {
    let vectors = |e: &Extra| matches!(e.entries, Entries::Components | Entries::Complex);
    let Some(axis) = extras.iter().position(vectors) else {
        return Vec::new();
    };
    let size = extras[axis].size;
    if !(2..=3).contains(&size) || extras.iter().filter(|e| vectors(e)).count() > 1 {
        return Vec::new();
    }
    let step: usize = extras[..axis].iter().map(|extra| extra.size).product();
    let is_first = |entry: &usize| (entry / step).is_multiple_of(size);
    let of = |first: usize| {
        let parts: Vec<&Numbers> = (0..size).map(|i| &numbers[first + i * step]).collect();
        let magnitude = |point: usize| {
            let squares = parts.iter().map(|part| part.get(point).powi(2));
            let length = squares.sum::<f64>().sqrt() as f32;
            if length.is_finite() { length } else { f32::NAN }
        };
        Samples::F32((0..parts[0].len()).map(magnitude).collect())
    };
    (0..numbers.len())
        .filter(is_first)
        .map(|first| (first, of(first)))
        .collect()
}

/// The name of the field of an entry of `extras`: `name-3`, or `name-3-1` for the second
/// component of the fourth frame, whichever way these stand in the file; `whole` leaves
/// components out.
fn entry_name(name: &str, entry: usize, extras: &[Extra], whole: bool) -> String {
    let (mut frames, mut components) = (String::new(), String::new());
    let mut rest = entry;
    for extra in extras {
        let index = rest % extra.size;
        rest /= extra.size;
        // One entry needs no name.
        if extra.size == 1 {
            continue;
        }
        match extra.entries {
            Entries::Numbered => frames += &format!("-{index}"),
            Entries::Components | Entries::Colors => components += &format!("-{index}"),
            Entries::Complex => components += ["-real", "-imaginary"][index],
        }
    }
    if whole {
        components.clear();
    }
    format!("{name}{frames}{components}")
}

/// The fields of an array whose samples are `components` numbers that stand together.
pub(crate) fn split(
    name: &str,
    numbers: Numbers,
    components: usize,
    entries: Entries,
    notes: &mut Vec<String>,
) -> Vec<Field> {
    let extra = [Extra {
        before: 0,
        size: components,
        entries,
    }];
    let dims = [numbers.len() / components, 1, 1];
    let numbers = separate(vec![numbers], dims, &extra);
    fields(name, numbers, &extra, notes)
}

#[cfg(test)]
mod tests;
