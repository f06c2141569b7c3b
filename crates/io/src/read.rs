//! Which reader a file needs, and what all readers must guarantee.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use tetrascope_core::Error;
use tetrascope_core::clusters::MeshClusters;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;

#[cfg(feature = "exodus")]
use crate::exodus;
use crate::fields::Array;
use crate::formats::in_words;
use crate::grid::formats::{GZIP, GridFormat};
use crate::grid::{GridData, RawLayout, meta_image, nrrd, raw};
use crate::polyhedra::POLYHEDRON;
use crate::source::{Source, open_file};
use crate::steps::{StepChoice, without_steps};
use crate::{MeshData, gmsh, plot3d, tsc, vtk, vtu, xdmf};
#[cfg(feature = "hdf5")]
use crate::{cgns, hdf5, vtkhdf};

/// How to read a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadOptions {
    /// The file with the fields where the format keeps them apart (Plot3D);
    /// found by its name when not given.
    pub solution: Option<PathBuf>,
    /// Says what is in a file of samples alone; without it no file is one.
    pub raw: Option<RawLayout>,
    /// The distance of samples along each axis, world units, for files that do not say it
    /// (`.npy`, `.npz`, `.tif`); what a `.tif` says of it is then not used.
    pub spacing: Option<DVec3>,
    /// Where the first sample lies, world space, for the same files; at 0 unless given.
    pub origin: Option<DVec3>,
    /// The time step of a file that holds several; without a choice the first is read, with a
    /// note. See [`read_steps`](crate::read_steps).
    pub step: Option<StepChoice>,
    /// Grids with more bytes of samples than this stay in their file, if they stand
    /// there as they are, and are read in parts.
    pub stream_above: u64,
}

impl Default for ReadOptions {
    fn default() -> ReadOptions {
        ReadOptions {
            solution: None,
            raw: None,
            spacing: None,
            origin: None,
            step: None,
            stream_above: (1 << 30) - 1,
        }
    }
}

/// The content of a file.
#[derive(Clone, Debug)]
pub enum FileData {
    /// An unstructured mesh.
    Mesh(MeshData),
    /// A regular grid.
    Grid(GridData),
    /// A tetrahedral mesh that stays in its file, with its one field ([`tsc`](crate::tsc)).
    Clusters(MeshClusters),
}

/// Formats that people have and that are not read, by extension; what helps stands behind a semicolon.
const NOT_READ: [(&[&str], &str); 11] = [
    (
        &["pvd", "series"],
        "a list of the files of a series; give one of these files, or draw it as a series",
    ),
    (
        &["vtp", "stl", "ply", "obj"],
        "a surface, and there is nothing inside it to draw; fill it with tetrahedra, by Gmsh or TetGen, with values at their points, and save these as .vtu",
    ),
    (
        &["raw", "dat", "img", "rec", "st"],
        "a file of samples alone; say what is in it with `dims` and `type`",
    ),
    (
        &["hdr"],
        "a format of another program; save it as .nrrd, .mha or .nii",
    ),
    (
        &["dcm", "dicom", "ima"],
        "without the letters DICM at byte 128, or read with the feature `dicom`; write it again with pydicom or `dcmconv`",
    ),
    (
        &["tif", "tiff", "npy", "npz", "mrc", "map", "ccp4"],
        "a format whose files begin with other bytes than this one, or, of .tif, one of the feature `tiff`; save it again",
    ),
    (
        &["vtkhdf", "hdf", "h5", "hdf5"],
        "not an HDF5 file, as its first bytes are others; copy or write it again",
    ),
    (
        &["xdmf", "xmf"],
        "not XML with an <Xdmf> element, as its first bytes are others; copy or write it again",
    ),
    (&["case", "encas"], "an EnSight case; save it as .vtu"),
    (
        &["exo", "e", "ex2", "exii", "cgns", "nc"],
        "neither netCDF nor HDF5, as its first bytes are others; copy or write it again",
    ),
    (
        &["inp", "med", "foam"],
        "a mesh in a format of another program; save it as .vtu",
    ),
];

/// Reads a mesh with all its fields; see [`read_file`].
///
/// # Errors
/// Those of [`read_file`], and [`Error::Format`] for a regular grid and for a mesh in clusters.
pub fn read_mesh(path: &Path, options: &ReadOptions) -> Result<MeshData, Error> {
    match read_file(path, options)? {
        FileData::Mesh(mesh) => Ok(mesh),
        FileData::Grid(_) => Err(Error::Format {
            path: path.to_owned(),
            at: "".into(),
            what: "the file holds a regular grid where a mesh is needed".into(),
            help: None,
        }),
        FileData::Clusters(_) => Err(Error::Format {
            path: path.to_owned(),
            at: "".into(),
            what: "the file holds a mesh in clusters where one in memory is needed".into(),
            help: Some("give the file that it was packed from".into()),
        }),
    }
}

/// Reads a mesh or a grid with all its fields; the format is told by the file's first
/// bytes, then by its extension.
///
/// The points of every cell of a mesh exist and lie at finite coordinates,
/// and every field has one value a point or a cell. Every field of a grid has a sample
/// for each point of its lattice.
///
/// # Errors
/// [`Error::Io`] when a file cannot be read, [`Error::Format`] when it makes no
/// sense or is of a format that is not read; [`Error::Invalid`] for a solution where none
/// belongs, and for a time step that the file does not hold.
pub fn read_file(path: &Path, options: &ReadOptions) -> Result<FileData, Error> {
    let format = match &options.raw {
        Some(layout) => Format::Raw(*layout),
        None => Format::of_file(path)?,
    };
    if let (Some(solution), false) = (&options.solution, matches!(format, Format::Plot3d)) {
        return Err(Error::Invalid {
            what: format!(
                "{} cannot be used: {} holds its own fields",
                solution.display(),
                path.display()
            ),
            help: Some("a solution file goes with a Plot3D grid; leave out `solution`".into()),
        });
    }
    let takes_spacing = matches!(format, Format::Grid(grid) if grid.takes_spacing());
    if (options.spacing.is_some() || options.origin.is_some()) && !takes_spacing {
        return Err(Error::Invalid {
            what: format!("{} says itself where its samples lie", path.display()),
            help: Some("leave out `spacing` and `origin`".into()),
        });
    }
    if options.step.is_some() && !format.has_steps() {
        return Err(without_steps(path));
    }
    if matches!(format, Format::VtkXml | Format::VtkLegacy)
        && let Some(grid) = vtk_stream(path, &format, options.stream_above)?
    {
        return Ok(FileData::Grid(grid));
    }
    let description = match format {
        Format::Plot3d => {
            let mesh = plot3d::read(path, options.solution.as_deref())?;
            return Ok(with_file(FileData::Mesh(mesh), path));
        }
        Format::VtkXml => return Ok(with_file(vtu::read(Source::open(path)?)?, path)),
        Format::VtkLegacy => return Ok(with_file(vtk::read(Source::open(path)?)?, path)),
        Format::Gmsh => {
            let mesh = gmsh::read(Source::open(path)?, options.step)?;
            return Ok(with_file(FileData::Mesh(mesh), path));
        }
        Format::Xdmf => {
            let data = xdmf::read(Source::open(path)?, options.step)?;
            return Ok(with_file(data, path));
        }
        #[cfg(feature = "exodus")]
        Format::Exodus => {
            let mesh = exodus::read(Source::open(path)?, options.step)?;
            return Ok(with_file(FileData::Mesh(mesh), path));
        }
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => return Ok(with_file(read_hdf5(path, options.step)?, path)),
        Format::Clusters => return tsc::open_tsc(path).map(FileData::Clusters),
        Format::MetaImage => meta_image::read(path),
        Format::Nrrd => nrrd::read(path),
        Format::Grid(grid) => return grid.read(path, options).map(FileData::Grid),
        Format::Raw(layout) => raw::describe(path, &layout),
    }?;
    description
        .read(path, options.stream_above)
        .map(FileData::Grid)
}

/// Reads the mesh or image of an HDF5 file.
#[cfg(feature = "hdf5")]
fn read_hdf5(path: &Path, step: Option<StepChoice>) -> Result<FileData, Error> {
    let root = hdf5::open(path)?;
    if let Some(group) = root.group("VTKHDF")? {
        return vtkhdf::read(&group, step);
    }
    let names = root.members()?;
    if cgns::is_cgns(&names.0) {
        return cgns::read(&root, step).map(FileData::Mesh);
    }
    #[cfg(feature = "exodus")]
    if exodus::is_exodus(&names.1) {
        return exodus::read_hdf5(&root, step).map(FileData::Mesh);
    }
    Err(other_hdf5(&root, names))
}

/// The times of the steps of an HDF5 file.
#[cfg(feature = "hdf5")]
pub(crate) fn hdf5_steps(path: &Path) -> Result<Vec<f64>, Error> {
    let root = hdf5::open(path)?;
    if let Some(group) = root.group("VTKHDF")? {
        return vtkhdf::step_times(&group);
    }
    let names = root.members()?;
    if cgns::is_cgns(&names.0) {
        return cgns::steps(&root);
    }
    #[cfg(feature = "exodus")]
    if exodus::is_exodus(&names.1) {
        return exodus::hdf5_steps(&root);
    }
    Err(other_hdf5(&root, names))
}

/// The error of an HDF5 file of another kind, which holds these groups and datasets.
#[cfg(feature = "hdf5")]
fn other_hdf5(root: &hdf5::Group, (groups, datasets): (Vec<String>, Vec<String>)) -> Error {
    const MOST: usize = 5;
    let all = groups.len() + datasets.len();
    let names = groups.iter().chain(&datasets).take(MOST).map(|name| {
        let name: String = name.chars().take(40).collect();
        format!("'{}'", name.replace(char::is_control, " "))
    });
    let mut names = names.collect::<Vec<_>>().join(", ");
    if all > MOST {
        names += &format!(" and {} more", all - MOST);
    }
    let what = match all {
        0 => "the HDF5 file is empty".to_owned(),
        _ if cfg!(feature = "exodus") => {
            format!(
                "the HDF5 file is neither VTKHDF nor a CGNS or an Exodus mesh: it holds {names}"
            )
        }
        _ => format!(
            "the HDF5 file is neither VTKHDF nor a CGNS mesh: it holds {names}; Exodus meshes are read with the feature `exodus`"
        ),
    };
    root.error_with_help(what, "save the mesh or image as .vtkhdf, .vtu or .vti")
}

/// The grid of a VTK file that stands there as it is, if it takes more than `above` bytes.
fn vtk_stream(path: &Path, format: &Format, above: u64) -> Result<Option<GridData>, Error> {
    // Where arrays begin; a header of more than this is read with all that follows.
    const HEAD: u64 = 1 << 20;
    let (_, length) = open_file(path)?;
    if length <= above {
        return Ok(None);
    }
    let head = head(path, HEAD)?;
    match format {
        Format::VtkXml => vtu::stream(&head, above),
        _ => vtk::stream(&head, above),
    }
}

/// The first bytes of a file; an empty one is an error.
fn head(path: &Path, most: u64) -> Result<Source, Error> {
    let (file, _) = open_file(path)?;
    let mut bytes = Vec::new();
    let read = file.take(most).read_to_end(&mut bytes);
    read.map_err(|source| Error::Io {
        action: "cannot read",
        path: path.to_owned(),
        source,
    })?;
    let head = Source {
        path: path.to_owned(),
        bytes,
    };
    if head.bytes.is_empty() {
        return Err(head.error("", "the file is empty"));
    }
    Ok(head)
}

fn with_file(mut data: FileData, path: &Path) -> FileData {
    let files = match &mut data {
        FileData::Mesh(mesh) => &mut mesh.files,
        FileData::Grid(grid) => &mut grid.files,
        FileData::Clusters(_) => return data,
    };
    if files.is_empty() {
        files.push(path.to_owned());
    }
    data
}

/// How a file is read.
pub(crate) enum Format {
    Plot3d,
    VtkXml,
    VtkLegacy,
    Gmsh,
    Xdmf,
    Clusters,
    #[cfg(feature = "exodus")]
    Exodus,
    #[cfg(feature = "hdf5")]
    Hdf5,
    MetaImage,
    Nrrd,
    Grid(GridFormat),
    Raw(RawLayout),
}

impl Format {
    /// The format of a file.
    pub(crate) fn of_file(path: &Path) -> Result<Format, Error> {
        if path.is_dir() {
            return Format::of_folder(path);
        }
        let name = path
            .file_name()
            .map(|n| n.to_string_lossy().to_ascii_lowercase());
        Format::of(&head(path, 4096)?, &name.unwrap_or_default())
    }

    /// The format of a folder, which one format alone has.
    #[cfg(feature = "dicom")]
    fn of_folder(_: &Path) -> Result<Format, Error> {
        Ok(Format::Grid(GridFormat::Dicom))
    }

    #[cfg(not(feature = "dicom"))]
    fn of_folder(path: &Path) -> Result<Format, Error> {
        let what = "folders hold DICOM series, which are read with the feature `dicom`";
        Err(crate::source::format_error(path, "", what))
    }

    /// Whether one of several time steps can be chosen.
    fn has_steps(&self) -> bool {
        match self {
            Format::Gmsh | Format::Xdmf => true,
            #[cfg(feature = "exodus")]
            Format::Exodus => true,
            #[cfg(feature = "hdf5")]
            Format::Hdf5 => true,
            _ => false,
        }
    }

    /// By the first bytes of the file called `name`.
    fn of(source: &Source, name: &str) -> Result<Format, Error> {
        let extension = name.rsplit_once('.').map_or("", |(_, extension)| extension);
        let bytes = source
            .bytes
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(&source.bytes);
        let head = bytes;
        let refuse = |what: &str| Err(source.error_with_help("", what, in_words()));
        // Also where line ends were changed on the way, so that this is what is said.
        if head.starts_with(&tsc::MAGIC[..4]) || extension == "tsc" {
            return Ok(Format::Clusters);
        }
        if head.starts_with(b"# vtk DataFile") {
            return Ok(Format::VtkLegacy);
        }
        let utf16 = [b"\xff\xfe", b"\xfe\xff", b"<\0", b"\0<"];
        let is_xml = matches!(
            extension,
            "vtu" | "vti" | "vts" | "vtr" | "pvtu" | "pvti" | "pvts" | "pvtr" | "vtm" | "vtmb"
        );
        if is_xml && utf16.iter().any(|mark| head.starts_with(*mark)) {
            return refuse("this is text in UTF-16; save it as UTF-8");
        }
        if head.trim_ascii_start().starts_with(b"<") {
            if xdmf::is_xdmf(head) {
                return Ok(Format::Xdmf);
            }
            let root = head.windows(8).any(|w| w == b"<VTKFile");
            return if root {
                Ok(Format::VtkXml)
            } else {
                refuse("this is not a VTK XML file: there is no <VTKFile> element")
            };
        }
        // An HDF5 file may begin behind a block of something else.
        let is_hdf5 = |at: usize| {
            head.get(at..)
                .is_some_and(|h| h.starts_with(b"\x89HDF\r\n"))
        };
        if [0, 512, 1024, 2048].into_iter().any(is_hdf5) {
            #[cfg(feature = "hdf5")]
            return Ok(Format::Hdf5);
            #[cfg(not(feature = "hdf5"))]
            return refuse(
                "this is an HDF5 file; VTKHDF, CGNS and Exodus meshes in HDF5 are read with the feature `hdf5`",
            );
        }
        if head.starts_with(b"@(#)ADF Database") {
            return Err(source.error_with_help(
                "",
                "this is a CGNS file in ADF, CGNS's own container, and those in HDF5 are read",
                "convert it with adf2hdf, which comes with the CGNS library",
            ));
        }
        if gmsh::is_gmsh(head) {
            return Ok(Format::Gmsh);
        }
        let classic = [b"CDF\x01", b"CDF\x02", b"CDF\x05"];
        if classic.iter().any(|mark| head.starts_with(*mark)) {
            #[cfg(feature = "exodus")]
            return Ok(Format::Exodus);
            #[cfg(not(feature = "exodus"))]
            return refuse(
                "this is a netCDF file; Exodus meshes are read with the feature `exodus`",
            );
        }
        if head.starts_with(b"NRRD000") {
            return Ok(Format::Nrrd);
        }
        if let Some(grid) = GridFormat::of(head, &source.path, name) {
            return Ok(Format::Grid(grid));
        }
        let meta = [b"ObjectType".as_slice(), b"NDims", b"Comment"];
        if matches!(extension, "mha" | "mhd") || meta.iter().any(|key| head.starts_with(key)) {
            return Ok(Format::MetaImage);
        }
        if head.starts_with(GZIP) {
            return refuse("the file is compressed with gzip; decompress it first");
        }
        if plot3d::has_extension(extension) {
            return Ok(Format::Plot3d);
        }
        if extension == "msh" {
            return refuse(
                "the file does not begin with '$MeshFormat' as a Gmsh mesh does; save meshes of Fluent as .vtu",
            );
        }
        if is_xml {
            return refuse(&format!(
                "the file does not begin with an XML element as a .{extension} file does"
            ));
        }
        if matches!(extension, "nrrd" | "nhdr") {
            return refuse("the file does not begin with 'NRRD000' as a .nrrd file does");
        }
        if extension == "vtk" {
            return refuse(
                "the file does not begin with '# vtk DataFile' as a legacy .vtk file does",
            );
        }
        for (extensions, what) in NOT_READ {
            if extensions.contains(&extension) {
                let (what, help) = what.split_once("; ").unwrap_or((what, ""));
                let what = format!(".{extension} is not read: it is {what}");
                return match help {
                    "" => refuse(&what),
                    help => Err(source.error_with_help("", what, help)),
                };
            }
        }
        refuse("this is not a mesh or a grid in a format that is read")
    }
}

/// The promises of [`read_mesh`]. Readers refuse what they can say more about;
/// this is the last word.
pub(crate) fn check(path: &Path, data: &MeshData, arrays: &[Array]) -> Result<(), Error> {
    let refuse = |at: String, what: String| Error::Format {
        path: path.to_owned(),
        at,
        what,
        help: None,
    };
    let cells = &data.cells;
    let point_count = data.points.len();
    let cell_count = cells.types.len();
    let is_polyhedron = |kind: &&u8| **kind == POLYHEDRON;
    let polyhedra = cells.types.iter().filter(is_polyhedron).count();
    let with_faces = data.polyhedra.as_ref();
    if polyhedra > with_faces.map_or(0, |polyhedra| polyhedra.count()) {
        return Err(Error::Format {
            path: path.to_owned(),
            at: "the cells".into(),
            what: format!(
                "the mesh has {polyhedra} polyhedra (VTK type 42), which are read from .vtu and VTKHDF files alone"
            ),
            help: Some("save the mesh as .vtu".into()),
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
    let check_cell = |(cell, range): (usize, &[u64])| {
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
                // Readers keep the bits of numbers below 0, which are larger than any mesh.
                let number = match point as i64 {
                    below @ ..0 => below.to_string(),
                    _ => point.to_string(),
                };
                return Err(refuse(
                    format!("cell {cell}"),
                    format!(
                        "the cell uses point {number}, but the mesh has points 0 to {}",
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
        Ok(())
    };
    // The first error by number, whatever the threads do.
    let checked = cells.offsets.par_windows(2).enumerate().map(check_cell);
    checked.find_first(Result::is_err).unwrap_or(Ok(()))?;
    for array in arrays {
        let (needed, things) = match array.association {
            Association::Point => (point_count, "points"),
            Association::Cell => (cell_count, "cells"),
        };
        if array.tuples != needed {
            return Err(refuse(
                format!("array '{}'", array.name),
                format!("{} values for {needed} {things}", array.tuples),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
