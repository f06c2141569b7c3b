//! CGNS files in HDF5, `.cgns`: unstructured and structured zones of bases of three dimensions.
//!
//! *CGNS Standard Interface Data Structures*, and *SIDS File Mapping Manual* for HDF5. Sections
//! of volumes, of one type, mixed or of polyhedra (`NFACE_n` of `NGON_n`), become cells; those of
//! surfaces are left out, with a note. Structured zones become hexahedra. All zones and bases
//! become one mesh, as pieces of a `.pvtu` file do; fields that a zone lacks are NaN there.
//!
//! Solutions at vertices and in cells are read; three fields that follow each other and end in X, Y
//! and Z are a vector. Where zones say which solution belongs to which time
//! (`FlowSolutionPointers`), the file has time steps; coordinates are those of
//! `GridCoordinates`.

mod node;
mod sections;
mod solution;
mod zone;

use tetrascope_core::Error;

use self::node::Node;
use crate::MeshData;
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::hdf5::Group;
use crate::pieces::{Budget, Fields, join};
use crate::steps::{StepChoice, choose, note};

/// Zones, sections and fields of a file.
const MOST_NODES: u64 = 1 << 18;

/// Time steps that are read.
const MOST_STEPS: u64 = 1 << 20;

/// Whether an HDF5 file with these groups is CGNS.
pub(crate) fn is_cgns(groups: &[String]) -> bool {
    groups.iter().any(|name| name == "CGNSLibraryVersion")
}

/// Reads the mesh of a file at a time step.
pub(crate) fn read(root: &Group, choice: Option<StepChoice>) -> Result<MeshData, Error> {
    let root = Node::root(root);
    let bases = root.children("CGNSBase_t")?;
    let times = times(&bases)?;
    let step = choose(root.path(), choice, &times)?;
    let mut data = MeshData::default();
    data.notes.extend(step.and_then(|step| note(&times, step)));
    let length = root.length();
    let (mut zones, mut bytes, mut nodes) = (Vec::new(), 0_u64, 0);
    for base in &bases {
        let dimension = base.numbers(2)?.unwrap_or_default();
        if dimension != [3.0, 3.0] {
            let note = format!(
                "base '{}' left out: its cells are not volumes in space",
                base.name
            );
            data.notes.push(note);
            continue;
        }
        for node in base.children("Zone_t")? {
            let name = match bases.len() {
                1 => node.name.clone(),
                _ => format!("{}/{}", base.name, node.name),
            };
            nodes += 1;
            if let Some((zone, of_zone)) = zone::read(&node, &name, step, &mut nodes, &mut data)? {
                zones.push(zone);
                bytes = bytes.saturating_add(of_zone);
            }
            if bytes > most_unpacked(length) {
                let what = format!("{bytes} bytes are packed in {length}, which is refused");
                return Err(root.error_with_help(what, UNPACK));
            }
            if nodes > MOST_NODES {
                return Err(node.error(format!(
                    "more than {MOST_NODES} zones and fields are not read"
                )));
            }
        }
    }
    if zones.is_empty() {
        return Err(root.error("the file has no zone with volumes"));
    }
    let budget = Budget::new(root.path().to_owned(), length, false);
    join(&budget, zones, Fields::All, data)
}

/// The times of the steps of a file.
pub(crate) fn steps(root: &Group) -> Result<Vec<f64>, Error> {
    times(&Node::root(root).children("CGNSBase_t")?)
}

/// The times of the first base that has any and whose zones say what belongs to them.
fn times(bases: &[Node]) -> Result<Vec<f64>, Error> {
    for base in bases {
        let Some(iterative) = base.child("BaseIterativeData_t")? else {
            continue;
        };
        let Some(times) = iterative.named("TimeValues")? else {
            continue;
        };
        let times = times.numbers(MOST_STEPS)?.unwrap_or_default();
        for zone in base.children("Zone_t")? {
            if zone::has_pointers(&zone)? {
                return Ok(times);
            }
        }
    }
    Ok(Vec::new())
}

#[cfg(test)]
mod tests;
