//! Which reader a file needs, and what all readers must guarantee.

use std::path::{Path, PathBuf};

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use crate::source::Source;
use crate::{MeshData, plot3d, vtk, vtu};

/// How to read a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The file with the fields where the format keeps them apart (Plot3D);
    /// found by its name when not given.
    pub solution: Option<PathBuf>,
}

/// What is read, for messages.
const FORMATS: &str = "Tetrascope reads Plot3D (.bin .xyz .x .g .grd .p3d with .q), VTK XML (.vtu) and legacy VTK (.vtk)";

/// Formats that people have and that are not read, by extension.
const NOT_READ: [(&[&str], &str); 8] = [
    (
        &["pvtu", "pvd", "vtm", "vtmb"],
        "a VTK file that lists other files; give one of its .vtu pieces",
    ),
    (
        &["vts", "vtr", "vtp"],
        "a VTK XML file of another kind; save it as an unstructured grid (.vtu)",
    ),
    (
        &["vti", "nrrd", "nhdr", "mha", "mhd", "nii", "raw"],
        "a regular grid of samples; this version reads meshes",
    ),
    (
        &["vtkhdf", "hdf", "h5", "xdmf", "xmf"],
        "an HDF5 file; save it as .vtu",
    ),
    (&["msh"], "a Gmsh or Fluent mesh; save it as .vtu"),
    (&["case", "encas"], "an EnSight case; save it as .vtu"),
    (
        &["exo", "e", "ex2", "cgns", "nc"],
        "an Exodus, CGNS or netCDF mesh; save it as .vtu",
    ),
    (
        &["inp", "med", "foam", "stl", "ply", "obj"],
        "a mesh in a format of another program; save it as .vtu",
    ),
];

/// Reads a mesh with all its fields; the format is told by the file's first
/// bytes, then by its extension.
///
/// The points of every cell of the result exist and lie at finite coordinates,
/// and every field has one value a point or a cell.
///
/// # Errors
/// [`Error::Io`] when a file cannot be read, [`Error::Format`] when it makes no
/// sense or is of a format that is not read.
pub fn read_mesh(path: &Path, options: &ReadOptions) -> Result<MeshData, Error> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default();
    let source = Source::open(path)?;
    let format = Format::of(&source, &extension)?;
    if let (Some(solution), false) = (&options.solution, matches!(format, Format::Plot3d)) {
        return Err(Error::Invalid {
            what: format!(
                "{} cannot be used: {} holds its own fields",
                solution.display(),
                path.display()
            ),
            help: Some("a solution file goes with a Plot3D grid; leave out --solution".into()),
        });
    }
    let mut data = match format {
        Format::Plot3d => {
            drop(source); // the reader may need the other file of the pair
            plot3d::read(path, options.solution.as_deref())
        }
        Format::VtkXml => vtu::read(&source),
        Format::VtkLegacy => vtk::read(&source),
    }?;
    if data.files.is_empty() {
        data.files.push(path.to_owned());
    }
    Ok(data)
}

enum Format {
    Plot3d,
    VtkXml,
    VtkLegacy,
}

impl Format {
    fn of(source: &Source, extension: &str) -> Result<Format, Error> {
        let bytes = source
            .bytes
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(&source.bytes);
        let head = &bytes[..bytes.len().min(4096)];
        let refuse = |what: &str| Err(source.error_with_help("byte 0", what, FORMATS));
        if head.starts_with(b"# vtk DataFile") {
            return Ok(Format::VtkLegacy);
        }
        if head.trim_ascii_start().starts_with(b"<") {
            let root = head.windows(8).any(|w| w == b"<VTKFile");
            return if root {
                Ok(Format::VtkXml)
            } else {
                refuse("this is not a VTK XML file: there is no <VTKFile> element")
            };
        }
        if head.starts_with(b"\x89HDF") {
            return refuse("this is an HDF5 file; save it as .vtu");
        }
        if head.starts_with(b"$MeshFormat") {
            return refuse("this is a Gmsh mesh; save it as .vtu");
        }
        if head.starts_with(b"\x1f\x8b") {
            return refuse("the file is compressed with gzip; decompress it first");
        }
        if plot3d::has_extension(extension) {
            return Ok(Format::Plot3d);
        }
        if extension == "vtu" {
            return refuse("the file does not begin with an XML element as a .vtu file does");
        }
        if extension == "vtk" {
            return refuse(
                "the file does not begin with '# vtk DataFile' as a legacy .vtk file does",
            );
        }
        for (extensions, what) in NOT_READ {
            if extensions.contains(&extension) {
                return refuse(&format!(".{extension} is not read: it is {what}"));
            }
        }
        refuse("this is not a mesh in a format that is read")
    }
}

/// The promises of [`read_mesh`]. Readers refuse what they can say more about;
/// this is the last word.
pub(crate) fn check(path: &Path, data: &MeshData) -> Result<(), Error> {
    let refuse = |at: String, what: String| Error::Format {
        path: path.to_owned(),
        at,
        what,
        help: None,
    };
    let cells = &data.cells;
    let point_count = data.points.len();
    let cell_count = cells.types.len();
    let polyhedra = cells.types.iter().filter(|&&kind| kind == 42).count();
    if polyhedra > 0 {
        return Err(Error::Format {
            path: path.to_owned(),
            at: "the cells".into(),
            what: format!("the mesh has {polyhedra} polyhedra (VTK type 42), which are not read"),
            help: Some("cut them first, for example with ParaView's Tetrahedralize filter".into()),
        });
    }
    if cell_count == 0 {
        return Err(refuse("the cells".into(), "the mesh has no cells".into()));
    }
    if cells.offsets.len() != cell_count + 1
        || cells.offsets.first() != Some(&0)
        || cells.offsets.last() != Some(&(cells.connectivity.len() as u64))
    {
        return Err(refuse(
            "array 'offsets'".into(),
            format!(
                "the offsets of {cell_count} cells do not cover the connectivity of {} points",
                cells.connectivity.len()
            ),
        ));
    }
    for (cell, range) in cells.offsets.windows(2).enumerate() {
        let Some(used) = cells.connectivity.get(range[0] as usize..range[1] as usize) else {
            return Err(refuse(
                format!("cell {cell}"),
                format!(
                    "the cell's points are numbers {} to {} of {}",
                    range[0],
                    range[1],
                    cells.connectivity.len()
                ),
            ));
        };
        for &point in used {
            let Some(position) = usize::try_from(point).ok().and_then(|p| data.points.get(p))
            else {
                return Err(refuse(
                    format!("cell {cell}"),
                    format!(
                        "the cell uses point {point}, but the mesh has points 0 to {}",
                        point_count as i64 - 1
                    ),
                ));
            };
            if !position.is_finite() {
                return Err(refuse(
                    format!("cell {cell}"),
                    format!(
                        "its point {point} is at ({}, {}, {})",
                        position.x, position.y, position.z
                    ),
                ));
            }
        }
    }
    for field in &data.fields {
        let (needed, things) = match field.association {
            Association::Point => (point_count, "points"),
            Association::Cell => (cell_count, "cells"),
        };
        if field.values.len() != needed {
            return Err(refuse(
                format!("array '{}'", field.name),
                format!("{} values for {needed} {things}", field.values.len()),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
