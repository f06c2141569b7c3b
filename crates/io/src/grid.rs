//! Regular grids: `.mha`/`.mhd`, `.nrrd`/`.nhdr`, `.nii`/`.nii.gz` and raw samples.
//!
//! Each reader turns a header into a description: where the samples lie in space, and
//! where and how they stand in files. What follows is the same for all: lengths are
//! checked, then samples are read a few at a time, in the type in which they were stored.
//! VTK's grids (`.vti`, legacy `STRUCTURED_POINTS`) come from the VTK readers.

mod header;
pub(crate) mod meta_image;
pub(crate) mod nifti;
pub(crate) mod nrrd;
pub(crate) mod number;
mod payload;
pub(crate) mod raw;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use tetrascope_core::grid::{BrickSource as _, GridStream, Lattice, Samples};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, Grid, Volume};

pub use raw::{ByteOrder, RawFile, RawLayout};

use crate::fields::{Choice, choose, is_wide};
use crate::source::Source;
use payload::{Encoding, Payload};

/// A regular grid with every scalar field that its file offers.
#[derive(Clone, Debug)]
pub struct GridData {
    /// The fields, at least one; the one to draw first.
    pub fields: Vec<GridField>,
    /// What was found out, converted or left out, one sentence each.
    pub notes: Vec<String>,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// Samples with a name.
#[derive(Clone, Debug)]
pub struct GridField {
    /// What the file calls it.
    pub name: String,
    /// What the file has it for. Cell data are samples at the cells' centers.
    pub association: Association,
    /// Where the samples lie, world space.
    pub lattice: Lattice,
    /// Its samples.
    pub samples: FieldSamples,
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
        let volume = match field.samples {
            FieldSamples::Loaded(samples) => Volume::Grid(Grid::on(field.lattice, samples)?),
            FieldSamples::Streamed(stream) => Volume::Stream(stream),
        };
        Ok((volume, field.name))
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
            fields.push(GridField {
                name,
                association: Association::Point,
                lattice: file.lattice(),
                samples: FieldSamples::Streamed(GridStream::new(Arc::new(file))?),
            });
        }
        notes.push("samples are read from the file when they are needed".into());
        Ok((!fields.is_empty()).then(|| GridData {
            fields,
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

/// What a header says.
#[derive(Clone, Debug)]
pub(crate) struct Description {
    pub(crate) lattice: Lattice,
    pub(crate) payload: Payload,
    /// Numbers a sample.
    pub(crate) components: usize,
    /// Whether a sample's numbers stand together; else all first numbers come first.
    pub(crate) interleaved: bool,
    /// A stored number x is the scalar x · slope + shift.
    pub(crate) scale: Option<(f64, f64)>,
    pub(crate) name: String,
    pub(crate) notes: Vec<String>,
}

/// More would be a table, not a field.
pub(crate) const MOST_COMPONENTS: usize = 64;

/// The most files that one header may name.
pub(crate) const MOST_FILES: usize = 1 << 16;

/// An [`Error::Format`] for a lattice that a file's header makes.
pub(crate) fn no_volume(path: &Path, error: Error) -> Error {
    Error::Format {
        path: path.to_owned(),
        at: "the header".into(),
        what: error.to_string(),
        help: error.help(),
    }
}

impl Description {
    /// Reads the samples, or leaves them in their file if they take more than
    /// `stream_above` bytes and can be read there.
    pub(crate) fn read(self, path: &Path, stream_above: u64) -> Result<GridData, Error> {
        let Description {
            lattice,
            payload,
            components,
            interleaved,
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
        if components == 0 || components > MOST_COMPONENTS {
            return Err(damaged(format!(
                "{components} numbers a sample; 1 to {MOST_COMPONENTS} are read"
            )));
        }
        let points = lattice.validate().map_err(|error| no_volume(path, error))?;
        let count = points
            .checked_mul(components)
            .filter(|n| n.checked_mul(8).is_some())
            .ok_or_else(|| damaged(format!("{points} samples of {components} numbers")))?;
        let mut files = vec![path.to_owned()];
        files.extend(payload.files.iter().filter(|f| *f != path).cloned());
        let bytes = count as u64 * payload.number.sample_size() as u64;
        let stream = if bytes > stream_above && components == 1 && scale.is_none() {
            payload.stream(lattice, count)?
        } else {
            None
        };
        let fields = match stream {
            Some(stream) => {
                notes.push(format!(
                    "{bytes} bytes of samples are read from the file when they are needed"
                ));
                vec![(name, FieldSamples::Streamed(stream))]
            }
            None => {
                let converted = payload.read(count)?;
                if converted.rounded {
                    notes.push(format!("samples of '{name}' are rounded to 32-bit floats"));
                }
                let mut samples = converted.samples;
                if let Some((slope, shift)) = scale {
                    notes.push(format!(
                        "stored samples are scaled by {slope} and moved by {shift}"
                    ));
                    samples = scaled(&samples, slope, shift);
                }
                let fields = split(&name, samples, components, interleaved).into_iter();
                fields
                    .map(|(name, samples)| (name, FieldSamples::Loaded(samples)))
                    .collect()
            }
        };
        let fields = fields.into_iter().map(|(name, samples)| GridField {
            name,
            association: Association::Point,
            lattice,
            samples,
        });
        Ok(GridData {
            fields: fields.collect(),
            notes,
            files,
        })
    }
}

impl Payload {
    /// The samples where they stand, if they can be read there.
    fn stream(&self, lattice: Lattice, count: usize) -> Result<Option<GridStream>, Error> {
        let (Some(sample_type), Encoding::Raw, [path]) =
            (self.number.sample_type(), self.encoding, &self.files[..])
        else {
            return Ok(None);
        };
        let (_, offset) = self.begin(path, count)?;
        let order = ByteOrder::from(self.endian);
        let file = RawFile::open(path, offset + self.skip, lattice, sample_type, order)?;
        Ok(Some(GridStream::new(Arc::new(file))?))
    }
}

fn scaled(samples: &Samples, slope: f64, shift: f64) -> Samples {
    let scaled = (0..samples.len()).map(|i| (samples.get(i) * slope + shift) as f32);
    Samples::F32(scaled.collect())
}

/// Appends samples of the same type; of another, as floats.
pub(crate) fn append(all: &mut Samples, more: Samples) {
    match (all, more) {
        (Samples::U8(a), Samples::U8(b)) => a.extend(b),
        (Samples::U16(a), Samples::U16(b)) => a.extend(b),
        (Samples::I16(a), Samples::I16(b)) => a.extend(b),
        (Samples::F32(a), Samples::F32(b)) => a.extend(b),
        (all, more) => {
            let values = (0..all.len()).map(|i| all.get(i));
            let values = values.chain((0..more.len()).map(|i| more.get(i)));
            *all = Samples::F32(values.map(|v| v as f32).collect());
        }
    }
}

/// One field a component, and the magnitude of two and three.
pub(crate) fn split(
    name: &str,
    samples: Samples,
    components: usize,
    interleaved: bool,
) -> Vec<(String, Samples)> {
    if components == 1 {
        return vec![(name.into(), samples)];
    }
    let points = samples.len() / components;
    let (start, step) = if interleaved {
        (1, components)
    } else {
        (points, 1)
    };
    let mut fields = Vec::new();
    if components <= 3 {
        let magnitude = |point: usize| {
            let at = |c: usize| samples.get(start * c + step * point);
            (0..components).map(|c| at(c) * at(c)).sum::<f64>().sqrt() as f32
        };
        let magnitude = Samples::F32((0..points).map(magnitude).collect());
        fields.push((format!("{name}-magnitude"), magnitude));
    }
    for component in 0..components {
        fn every<T: Copy>(all: &[T], first: usize, step: usize, count: usize) -> Vec<T> {
            all[first..]
                .iter()
                .step_by(step)
                .take(count)
                .copied()
                .collect()
        }
        let first = start * component;
        let samples = match &samples {
            Samples::U8(v) => Samples::U8(every(v, first, step, points)),
            Samples::U16(v) => Samples::U16(every(v, first, step, points)),
            Samples::I16(v) => Samples::I16(every(v, first, step, points)),
            Samples::F32(v) => Samples::F32(every(v, first, step, points)),
            other => other.clone(),
        };
        let suffix = crate::fields::component_name(component, &[]);
        fields.push((format!("{name}-{suffix}"), samples));
    }
    fields
}

#[cfg(test)]
mod tests;
