//! Meshes out: VTK XML unstructured grids (`.vtu`).
//!
//! Arrays are appended raw, little-endian, with headers of 64 bits, and compressed by zlib if
//! that is asked for. VTK, ParaView, meshio and our own reader take all of it.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use quick_xml::escape::escape;
use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use crate::MeshData;
use crate::appended::{Appended, Compression};
use crate::fields::Array;
use crate::higher_order::is_renumbered;
use crate::image::extension;
use crate::whole_file::{check_writable, write_with};

/// Refuses at once what [`write_vtu`] would refuse after the work is done: another extension,
/// a folder that does not exist or cannot be written to, and a folder in the file's place.
///
/// # Errors
/// [`Error::Unknown`] for the extension, [`Error::Io`].
pub fn check_path(path: &Path) -> Result<(), Error> {
    match extension(path).as_str() {
        "vtu" => check_writable(path),
        other => Err(Error::Unknown {
            kind: "mesh format",
            name: other.into(),
            valid: vec!["vtu".into()],
        }),
    }
}

/// Writes a mesh with all its fields as a `.vtu` file: points, cells of every type, and each
/// array with the file's names of its components, in the order of [`MeshData::fields`]; the
/// first at points and the first of cells are marked as those to draw.
///
/// Points and arrays are 32-bit floats where those hold every number exactly, else 64-bit ones:
/// no number changes. What the mesh does not have is not written: cells that were left out,
/// polyhedra, which have become tetrahedra, and the types of whole numbers. A file of that name
/// is replaced only by a complete one, and the same mesh gives the same bytes.
///
/// # Errors
/// [`Error::Invalid`] for names that are empty, twice at points or in cells, or have control
/// characters; those of the file from which arrays are read only now; [`Error::Io`] when the
/// file cannot be written.
pub fn write_vtu(path: &Path, mesh: &MeshData, compression: Compression) -> Result<(), Error> {
    check_names(mesh)?;
    // Errors of the mesh's own file would be said to be of the one that is written.
    let mut failed = None;
    let written = write_with(path, |file| {
        write(&mut BufWriter::new(file), mesh, compression, &mut failed)
    });
    match failed {
        Some(error) => Err(error),
        None => written,
    }
}

fn check_names(mesh: &MeshData) -> Result<(), Error> {
    for (
        i,
        Array {
            name, association, ..
        },
    ) in mesh.arrays.iter().enumerate()
    {
        if name.is_empty() || name.contains(char::is_control) {
            return Err(Error::invalid(format!(
                "array {i} needs a name of printable characters, it is '{}'",
                name.escape_debug()
            )));
        }
        let is_same = |other: &Array| other.name == *name && other.association == *association;
        if mesh.arrays[..i].iter().any(is_same) {
            return Err(Error::invalid(format!("two arrays have the name '{name}'")));
        }
    }
    Ok(())
}

/// Numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Float {
    F32,
    F64,
}

impl Float {
    /// The shorter type that holds all of `numbers`.
    fn of(mut numbers: impl Iterator<Item = f64>) -> Float {
        let fits = |x: f64| x.is_nan() || f64::from(x as f32) == x;
        match numbers.all(fits) {
            true => Float::F32,
            false => Float::F64,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Float::F32 => "Float32",
            Float::F64 => "Float64",
        }
    }

    fn bytes(self) -> u64 {
        match self {
            Float::F32 => 4,
            Float::F64 => 8,
        }
    }

    fn write(self, out: &mut dyn Write, numbers: impl Iterator<Item = f64>) -> io::Result<()> {
        match self {
            Float::F32 => write_all(out, numbers.map(|x| (x as f32).to_le_bytes())),
            Float::F64 => write_all(out, numbers.map(f64::to_le_bytes)),
        }
    }
}

/// Writes numbers some thousands at a time.
fn write_all<const N: usize>(
    out: &mut dyn Write,
    numbers: impl Iterator<Item = [u8; N]>,
) -> io::Result<()> {
    const ROOM: usize = 1 << 15;
    let mut bytes = Vec::with_capacity(ROOM);
    for number in numbers {
        bytes.extend(number);
        if bytes.len() + N > ROOM {
            out.write_all(&bytes)?;
            bytes.clear();
        }
    }
    out.write_all(&bytes)
}

impl MeshData {
    /// The parts of the file from which this mesh was read that [`write_vtu`] does not keep, one sentence
    /// each.
    pub fn lost_in_vtu(&self) -> Vec<String> {
        let mut lost = Vec::new();
        let left_out = self.left_out.iter();
        lost.extend(left_out.map(|(name, why)| format!("array '{name}' is not written: {why}")));
        lost
    }
}

fn write(
    out: &mut BufWriter<&mut File>,
    mesh: &MeshData,
    compression: Compression,
    failed: &mut Option<Error>,
) -> io::Result<()> {
    let (points, cells) = (mesh.points.len() as u64, mesh.cells.types.len() as u64);
    let failed = std::cell::RefCell::new(failed);
    let fail = |error: Error| {
        let kept = io::Error::other(error.to_string());
        failed.borrow_mut().get_or_insert(error);
        kept
    };
    let places = || mesh.points.iter().flat_map(|point| point.to_array());
    // VTK's version from which on hexahedra of any order are numbered as since VTK 9.
    let version = match mesh.cells.types.iter().copied().any(is_renumbered) {
        true => "2.1",
        false => "1.0",
    };
    let mut appended = Appended::begin(out, ("UnstructuredGrid", version), compression)?;
    writeln!(out, "<UnstructuredGrid>")?;
    writeln!(
        out,
        "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    for association in [Association::Point, Association::Cell] {
        let data = match association {
            Association::Point => "PointData",
            Association::Cell => "CellData",
        };
        let arrays = mesh.arrays.iter().filter(|a| a.association == association);
        let first = arrays.clone().find(|array| array.components == 1);
        let active = first.map(|array| format!(" Scalars=\"{}\"", escape(&*array.name)));
        writeln!(out, "<{data}{}>", active.unwrap_or_default())?;
        for array in arrays {
            let tuples = mesh.tuples(array).map_err(&fail)?;
            let number = Float::of(tuples.iter().copied());
            let bytes = number.bytes() * tuples.len() as u64;
            drop(tuples); // of one array at a time, and read again
            let fail = &fail;
            appended.element(out, &attributes(array, number), bytes, move |out| {
                let tuples = mesh.tuples(array).map_err(fail)?;
                number.write(out, tuples.into_iter())
            })?;
        }
        writeln!(out, "</{data}>")?;
    }
    let number = Float::of(places());
    writeln!(out, "<Points>")?;
    let kind = format!(
        "type=\"{}\" Name=\"Points\" NumberOfComponents=\"3\"",
        number.name()
    );
    appended.element(out, &kind, 3 * number.bytes() * points, move |out| {
        number.write(out, places())
    })?;
    writeln!(out, "</Points>\n<Cells>")?;
    let connectivity = &mesh.cells.connectivity;
    let kind = "type=\"Int64\" Name=\"connectivity\"";
    appended.element(out, kind, 8 * connectivity.len() as u64, |out| {
        write_all(out, connectivity.iter().map(|point| point.to_le_bytes()))
    })?;
    let ends = mesh.cells.offsets.iter().skip(1);
    appended.element(out, "type=\"Int64\" Name=\"offsets\"", 8 * cells, |out| {
        write_all(out, ends.map(|end| end.to_le_bytes()))
    })?;
    appended.element(out, "type=\"UInt8\" Name=\"types\"", cells, |out| {
        out.write_all(&mesh.cells.types)
    })?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>")?;
    appended.finish(out)?;
    out.flush()
}

/// The attributes of an array's element.
fn attributes(array: &Array, number: Float) -> String {
    let mut text = format!(
        "type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"",
        number.name(),
        escape(&*array.name),
        array.components
    );
    for (i, name) in array.component_names.iter().enumerate() {
        if let Some(name) = name {
            text += &format!(" ComponentName{i}=\"{}\"", escape(&**name));
        }
    }
    text
}

#[cfg(test)]
mod tests;
