//! Regular grids out: VTK XML images (`.vti`).
//!
//! VTK, ParaView and our own reader take all of it.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use quick_xml::escape::escape;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{Interpolation, Lattice, SampleType, Samples};
use tetrascope_core::{Error, Grid};

use crate::appended::{Appended, BLOCK, Compression};
use crate::image::extension;
use crate::whole_file::{check_writable, write_with};

/// Refuses at once what [`write_vti`] would refuse after the work is done: another extension,
/// a folder that does not exist or cannot be written to, and a folder in the file's place.
///
/// # Errors
/// [`Error::Unknown`] for the extension, [`Error::Io`].
pub fn check_path(path: &Path) -> Result<(), Error> {
    match extension(path).as_str() {
        "vti" => check_writable(path),
        other => Err(Error::Unknown {
            kind: "grid format",
            name: other.into(),
            valid: vec!["vti".into()],
        }),
    }
}

/// Writes named arrays of samples on one lattice as a `.vti` file; the first is the one to draw.
///
/// Samples are written as they are, bit by bit. Those that fill cells become cell data, and
/// the image's origin is then the corner of the first cell. A file of that name is replaced
/// only by a complete one, and the same samples give the same bytes.
///
/// # Errors
/// [`Error::Invalid`] for a lattice that [`Lattice::validate`] refuses, for no array at all,
/// for an array that has not as many samples as the lattice, and for names that are empty,
/// the same, or have control characters; [`Error::Io`] when the file cannot be written.
pub fn write_vti(
    path: &Path,
    lattice: &Lattice,
    arrays: &[(&str, &Samples)],
    compression: Compression,
) -> Result<(), Error> {
    check(lattice, arrays)?;
    write_with(path, |file| {
        let mut out = BufWriter::new(file);
        write(&mut out, lattice, arrays, compression)?;
        out.flush()
    })
}

/// Writes the samples of `grid` under this name and, if it has a coverage, that as the array
/// [`COVERAGE`]; [`GridData::into_covered_volume`](crate::GridData::into_covered_volume) reads
/// both back.
///
/// # Errors
/// As [`write_vti`]; [`Error::Invalid`] also where the samples themselves are called so.
pub fn write_grid(
    path: &Path,
    grid: &Grid,
    name: &str,
    compression: Compression,
) -> Result<(), Error> {
    let coverage = grid.coverage().map(|shares| Samples::F32(shares.to_vec()));
    let mut arrays = vec![(name, grid.samples())];
    arrays.extend(coverage.iter().map(|shares| (COVERAGE, shares)));
    write_vti(path, grid.lattice(), &arrays, compression)
}

/// Name of the array of a grid's [coverage](tetrascope_core::grid::coverage).
pub const COVERAGE: &str = "coverage";

fn check(lattice: &Lattice, arrays: &[(&str, &Samples)]) -> Result<(), Error> {
    let count = lattice.validate()?;
    if arrays.is_empty() {
        return Err(Error::invalid(
            "an image without an array cannot be written",
        ));
    }
    for (i, (name, samples)) in arrays.iter().enumerate() {
        if name.is_empty() || name.contains(char::is_control) {
            return Err(Error::invalid(format!(
                "array {i} needs a name of printable characters, it is '{name}'"
            )));
        }
        if arrays[..i].iter().any(|(other, _)| other == name) {
            return Err(Error::invalid(format!("two arrays have the name '{name}'")));
        }
        if samples.len() != count {
            return Err(Error::invalid(format!(
                "array '{name}' has {} samples, and an image of {:?} has {count}",
                samples.len(),
                lattice.dims
            )));
        }
    }
    Ok(())
}

fn write(
    out: &mut BufWriter<&mut File>,
    lattice: &Lattice,
    arrays: &[(&str, &Samples)],
    compression: Compression,
) -> io::Result<()> {
    let (data, half) = match lattice.interpolation {
        Interpolation::Linear => ("PointData", 0.0),
        Interpolation::Nearest => ("CellData", 0.5),
    };
    let [nx, ny, nz] = lattice.cells();
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    let numbers = |numbers: &[f64]| {
        // The shortest digits that read back as the same number.
        let words = numbers.iter().map(|number| format!("{number:?}"));
        words.collect::<Vec<_>>().join(" ")
    };
    let origin = numbers(&lattice.point(DVec3::splat(-half)).to_array());
    let spacing = numbers(&lattice.spacing.to_array());
    // Row by row, the axes as columns.
    let direction = numbers(&lattice.direction.transpose().to_cols_array());
    let mut appended = Appended::begin(out, ("ImageData", "1.0"), compression)?;
    writeln!(
        out,
        "<ImageData WholeExtent=\"{extent}\" Origin=\"{origin}\" Spacing=\"{spacing}\" \
         Direction=\"{direction}\">"
    )?;
    writeln!(out, "<Piece Extent=\"{extent}\">")?;
    writeln!(out, "<{data} Scalars=\"{}\">", escape(arrays[0].0))?;
    for (name, samples) in arrays {
        let number = match samples.sample_type() {
            SampleType::U8 => "UInt8",
            SampleType::U16 => "UInt16",
            SampleType::I16 => "Int16",
            SampleType::F32 => "Float32",
        };
        let attributes = format!("type=\"{number}\" Name=\"{}\"", escape(*name));
        appended.element(out, &attributes, samples.bytes(), |out| {
            blocks(samples).try_for_each(|block| out.write_all(&block))
        })?;
    }
    writeln!(out, "</{data}>\n</Piece>\n</ImageData>")?;
    appended.finish(out)
}

/// The samples as little-endian bytes, [`BLOCK`] at a time.
fn blocks(samples: &Samples) -> Box<dyn Iterator<Item = Vec<u8>> + '_> {
    fn of<'a, T: Copy + 'a, const N: usize>(
        samples: &'a [T],
        bytes: fn(T) -> [u8; N],
    ) -> Box<dyn Iterator<Item = Vec<u8>> + 'a> {
        let blocks = samples.chunks(BLOCK / N);
        Box::new(blocks.map(move |block| block.iter().flat_map(|s| bytes(*s)).collect()))
    }
    match samples {
        Samples::U8(v) => of(v, u8::to_le_bytes),
        Samples::U16(v) => of(v, u16::to_le_bytes),
        Samples::I16(v) => of(v, i16::to_le_bytes),
        Samples::F32(v) => of(v, f32::to_le_bytes),
        // Types to come are `SampleType`s first, and those are matched in full above.
        _ => Box::new(std::iter::empty()),
    }
}

#[cfg(test)]
mod tests;
