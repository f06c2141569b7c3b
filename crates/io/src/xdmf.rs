//! XDMF 2 and 3, `.xdmf` and `.xmf`: meshes and grids described in XML.
//!
//! *XDMF Model and Format*, xdmf.org; names and numbers of types are those of XDMF's own
//! library. Numbers stand in the file itself, in binary files, or in HDF5 files (feature `hdf5`)
//! in the folder of the file or below. Grids of volumes and structured grids become one mesh, as
//! pieces of a `.pvtu` file do; one evenly spaced grid alone is a regular grid. Surfaces are left
//! out, with a note. Grids of one mesh that differ only in their attributes, as DOLFINx writes a
//! list of time steps for each function, are one.
//!
//! Collections in time have time steps. Paths in `Reference` and `xi:include` are followed where
//! they have one of the forms that writers use.

mod document;
mod grids;
mod item;
mod items;
mod shapes;
mod zones;

use tetrascope_core::Error;

use self::document::Document;
use self::grids::{find, temporal};
use self::items::Items;
use crate::read::FileData;
use crate::source::Source;
use crate::steps::{StepChoice, choose, note};
use crate::vtu::to_utf8;

/// Grids of a file.
const MOST_GRIDS: usize = 1 << 18;

/// Numbers of an attribute or times of a collection that are held to look at them.
const MOST_TIMES: u64 = 1 << 20;

/// Reads the mesh or grid of a file at a time step.
pub(crate) fn read(source: Source, choice: Option<StepChoice>) -> Result<FileData, Error> {
    let document = Document::parse(to_utf8(source)?)?;
    let items = Items::new(&document);
    let times = temporal(&items)?;
    let step = choose(&document.source.path, choice, &times)?;
    let mut notes = Vec::new();
    notes.extend(step.and_then(|step| note(&times, step)));
    let grids = find(&items, step.unwrap_or(0), &times, &mut notes)?;
    zones::read(items, grids, notes)
}

/// The times of the steps of a file.
pub(crate) fn steps(source: Source) -> Result<Vec<f64>, Error> {
    let document = Document::parse(to_utf8(source)?)?;
    temporal(&Items::new(&document))
}

/// Whether a file that begins with these bytes is XDMF.
pub(crate) fn is_xdmf(head: &[u8]) -> bool {
    head.windows(6).any(|w| w == b"<Xdmf " || w == b"<Xdmf>")
}

#[cfg(test)]
mod tests;
