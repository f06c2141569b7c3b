//! `Zone_t`: points, cells and solutions.

use std::sync::Arc;

use tetrascope_core::Error;

use super::node::Node;
use super::{sections, solution};
use crate::MeshData;
use crate::fields::{Numbers, Together};
use crate::pieces::sections::{Coordinates, Topology, Zone, lattice_counts};

/// A zone, and how many bytes its points and fields take; `None` for one without volumes.
pub(super) fn read(
    node: &Node,
    name: &str,
    step: Option<usize>,
    nodes: &mut u64,
    data: &mut MeshData,
) -> Result<Option<(Zone, u64)>, Error> {
    let sizes = node.indices(9)?;
    let kind = match node.child("ZoneType_t")? {
        Some(kind) => kind.text()?,
        None => "Structured".into(),
    };
    let (points, topology, cells, of_cells) = match (kind.as_str(), &sizes[..]) {
        ("Unstructured", &[points, _, _]) => {
            let (topology, cells, bytes) = sections::read(node, name, data)?;
            (points, topology, cells, bytes)
        }
        ("Structured", &[i, j, k, _, _, _, _, _, _]) => match lattice_counts([i, j, k]) {
            Some((points, cells)) => (points, Topology::Lattice([i, j, k]), cells, 0),
            None => {
                let what = format!("a zone of {i}×{j}×{k} points has no volume");
                return Err(node.error_with_help(
                    what,
                    "volume rendering needs at least 2 points along each axis",
                ));
            }
        },
        (kind, sizes) => {
            let kind: String = kind.chars().take(40).collect();
            let what = format!("a zone of the type '{kind}' with the sizes {sizes:?} is not read");
            return Err(node.error(what));
        }
    };
    if cells == 0 {
        let note = format!("'{name}' left out: it has no cells with a volume");
        data.notes.push(note);
        return Ok(None);
    }
    let (coordinates, bytes) = coordinates(node, points)?;
    let mut bytes = bytes.saturating_add(of_cells);
    let mut zone = Zone {
        path: node.path().to_owned(),
        name: name.to_owned(),
        points,
        cells,
        coordinates,
        topology,
        arrays: [Vec::new(), Vec::new()],
    };
    let mut solutions = node.children("FlowSolution_t")?;
    if let (Some(step), Some(all)) = (step, pointers(node)?) {
        let chosen = all.get(step).cloned().unwrap_or_default();
        // A solution that no time names is there at all times.
        solutions.retain(|solution| solution.name == chosen || !all.contains(&solution.name));
        solutions.sort_by_key(|solution| solution.name != chosen);
    }
    for solution in &solutions {
        bytes = bytes.saturating_add(solution::add(solution, &mut zone, nodes, data)?);
    }
    Ok(Some((zone, bytes)))
}

/// Where the points of a zone lie, and how many bytes they take.
fn coordinates(node: &Node, points: u64) -> Result<(Coordinates, u64), Error> {
    let grid = match node.named("GridCoordinates")? {
        Some(grid) => Some(grid),
        None => node.child("GridCoordinates_t")?,
    };
    let grid = grid.ok_or_else(|| node.error("the zone has no GridCoordinates"))?;
    let mut axes: Vec<Arc<dyn Numbers>> = Vec::new();
    for name in ["CoordinateX", "CoordinateY", "CoordinateZ"] {
        let axis = grid.named(name)?;
        let axis = axis.ok_or_else(|| {
            grid.error_with_help(
                format!("there is no '{name}'"),
                "coordinates must be x, y and z",
            )
        })?;
        let view = axis.view()?;
        if view.count() != points {
            let what = format!("{} numbers for {points} points", view.count());
            return Err(axis.error_with_help(what, "values beyond the zone (Rind) are not read"));
        }
        axes.push(Arc::new(view));
    }
    let coordinates = Coordinates::Each(Arc::new(Together(axes)));
    Ok((coordinates, points.saturating_mul(24)))
}

/// The names of the solutions of each time step, if a zone says them.
fn pointers(zone: &Node) -> Result<Option<Vec<String>>, Error> {
    let Some(iterative) = zone.child("ZoneIterativeData_t")? else {
        return Ok(None);
    };
    let pointers = iterative.named("FlowSolutionPointers")?;
    pointers.map(|pointers| pointers.texts()).transpose()
}

pub(super) fn has_pointers(zone: &Node) -> Result<bool, Error> {
    Ok(pointers(zone)?.is_some())
}
