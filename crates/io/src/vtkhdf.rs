//! VTKHDF files, `.vtkhdf` and `.hdf`: VTK's meshes and images in HDF5.
//!
//! *VTKHDF File Format*, the VTK documentation, versions 1 and 2; the layouts are those that VTK
//! 9.7 writes. `UnstructuredGrid`: the partitions become one mesh, as pieces of a `.pvtu` file
//! do, without ghosts, polyhedra as in [`vtu`](crate::vtu). `StructuredGrid` and
//! `RectilinearGrid`: hexahedra, or an image where the coordinates are evenly spaced.
//! `ImageData`: as a `.vti` file. `PartitionedDataSetCollection` and `MultiBlockDataSet`: the
//! meshes among the blocks as one, as those of a `.vtm` file. Others are refused.
//!
//! Fields have the file's names; a file does not name components, which have numbers.
//! Fields of meshes are read when they are asked for. Of several time steps the first is read,
//! or that of [`ReadOptions::step`](crate::ReadOptions::step).

mod arrays;
mod blocks;
mod image;
mod mesh;
mod steps;

use tetrascope_core::Error;

use crate::hdf5::Group;
use crate::read::FileData;
use crate::steps::{StepChoice, choose, note};

use self::steps::Steps;

/// The greatest major version that is read.
const VERSION: f64 = 2.0;

/// Partitions or blocks of a file.
const MOST_PARTS: u64 = 1 << 18;

/// Parts times arrays: each takes a look for its values.
const MOST_PAIRS: u64 = 1 << 20;

/// Arrays of a group: each takes time for every point or cell.
const MOST_ARRAYS: usize = 4096;

/// The content of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Unstructured,
    Structured,
    Rectilinear,
    Image,
    Blocks,
}

impl Kind {
    /// By the attribute `Type`.
    fn of(group: &Group) -> Result<Kind, Error> {
        let Some(name) = group.text("Type")? else {
            return Err(group.error("there is no attribute 'Type' that says what it holds"));
        };
        let refuse = |what: &str, help: &str| {
            let name: String = name.chars().take(40).collect();
            let what = format!("the file holds {what} ({name}), which is not read");
            Err(group.error_with_help(what, help))
        };
        match name.as_str() {
            "UnstructuredGrid" => Ok(Kind::Unstructured),
            "StructuredGrid" => Ok(Kind::Structured),
            "RectilinearGrid" => Ok(Kind::Rectilinear),
            "ImageData" => Ok(Kind::Image),
            "PartitionedDataSetCollection" | "MultiBlockDataSet" => Ok(Kind::Blocks),
            "PolyData" => refuse(
                "surfaces, which have no volume",
                "mesh the volume, such as by vtkDelaunay3D",
            ),
            "OverlappingAMR" => refuse("images in each other", RESAMPLE),
            "HyperTreeGrid" => refuse("a tree of cells", RESAMPLE),
            "Table" => refuse("a table", "give a file with a mesh or an image"),
            _ => refuse(
                "something else than a mesh or an image",
                "save it as an unstructured grid or as image data",
            ),
        }
    }
}

/// The help with what has levels.
const RESAMPLE: &str = "resample it to an image, such as by vtkResampleToImage, and save that";

/// Reads what the group `VTKHDF` of a file holds.
pub(crate) fn read(root: &Group, choice: Option<StepChoice>) -> Result<FileData, Error> {
    check_version(root)?;
    let kind = Kind::of(root)?;
    if kind == Kind::Blocks {
        return blocks::read(root, choice).map(FileData::Mesh);
    }
    let steps = Steps::of(root)?;
    let times = steps.as_ref().map_or(&[][..], |steps| &steps.times);
    let chosen = choose(&root.file.path, choice, times)?;
    let step = steps.as_ref().zip(chosen);
    let notes = chosen.and_then(|number| note(times, number));
    let notes: Vec<String> = notes.into_iter().collect();
    match kind {
        Kind::Image => image::read(root, step, notes).map(FileData::Grid),
        Kind::Rectilinear => match image::of_rectilinear(root, step, &notes)? {
            Some(grid) => Ok(FileData::Grid(grid)),
            None => mesh::read(root, kind, step, notes).map(FileData::Mesh),
        },
        _ => mesh::read(root, kind, step, notes).map(FileData::Mesh),
    }
}

/// The times of the steps of a file.
pub(crate) fn step_times(root: &Group) -> Result<Vec<f64>, Error> {
    check_version(root)?;
    let steps = match Kind::of(root)? {
        Kind::Blocks => blocks::steps(root)?,
        _ => Steps::of(root)?,
    };
    Ok(steps.map_or(Vec::new(), |steps| steps.times))
}

fn check_version(root: &Group) -> Result<(), Error> {
    let version = root.numbers("Version")?.unwrap_or_default();
    let Some(&major) = version.first() else {
        return Err(root.error("there is no attribute 'Version'"));
    };
    if major <= VERSION {
        return Ok(());
    }
    let version: Vec<String> = version.iter().take(3).map(f64::to_string).collect();
    Err(root.error_with_help(
        format!(
            "this is VTKHDF of version {}; up to 2 are read",
            version.join(".")
        ),
        "save it as .vtu",
    ))
}

/// The step that is read, of several.
type Step<'a> = Option<(&'a Steps, usize)>;

#[cfg(test)]
mod tests;
