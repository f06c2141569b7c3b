//! Curved cells as straight ones: each is cut into smaller cells, until what that changes is small.
//!
//! A curved cell maps its reference cell by a polynomial or, with weights, by a quotient of two, and its field is
//! another. Its reference cell is cut into n parts along each edge (`lattice`), and each part's corners are
//! evaluated (`shapes`, `simplex`). What straight parts are off by falls with n², and `bound` says by
//! how much at most, from the functions' second derivatives.
//!
//! n is the same in the whole mesh, so that parts of neighbors meet (`seams`): a point on a face is named by
//! the weights of the face's corners, which both cells say alike, and is made once. A point that is
//! one of the cell's own stays that.
//!
//! # Limits
//! The functions of pyramids are known at order 2, without nodes in faces. VTK gives no order to the nodes of others, which stay as they are, as
//! do cells of an order above 6, tetrahedra of 15 nodes and wedges of 21. Where a cell with straight edges shares a face with one
//! that is cut, the face is cut on one side alone; the report counts these.

mod bound;
mod cutter;
mod form;
mod lattice;
mod net;
mod numbering;
mod seams;
mod shapes;
mod simplex;

use glam::DVec3;
use rayon::prelude::*;

use super::{Association, Cells, Scalars, check_counts, check_point, split};
use crate::{Bounds, Error, number};
use cutter::Cutter;
use form::{Forms, is_curved};
use shapes::Curved;

pub use numbering::{exchanged, lagrange_nodes};

/// The most parts along an edge.
pub const MOST_PARTS: usize = 16;

/// How curved cells become straight ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straightening {
    /// How far shape and values may be off: in parts of the diagonal of the mesh's box, and of each
    /// field's range.
    pub tolerance: f64,
    /// The most cells that curved ones are cut into; two parts along each edge, and as many as the order of
    /// the cells, are always allowed.
    pub most_cells: usize,
}

impl Straightening {
    /// For who asks for a tolerance.
    pub fn to(tolerance: f64) -> Straightening {
        Straightening {
            tolerance,
            most_cells: 1 << 24,
        }
    }
}

impl Default for Straightening {
    /// A tolerance that a picture of 512×512 hardly shows, in little memory.
    fn default() -> Straightening {
        Straightening {
            tolerance: 1e-3,
            most_cells: 1 << 18,
        }
    }
}

/// A file's facts on curved cells beside their types and points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Extra {
    /// The orders of each cell along its axes, VTK's HigherOrderDegrees: used for hexahedra and wedges of any order.
    /// NaN, or all empty, where orders follow from the number of points.
    pub degrees: Vec<[f64; 3]>,
    /// The weight of each point in rational Bézier cells, VTK's RationalWeights; empty where all are 1.
    pub weights: Vec<f64>,
}

/// A mesh whose curved cells have become straight ones.
#[derive(Clone, Debug, PartialEq)]
pub struct Straightened {
    /// The points that were there, and after them those that were made.
    pub points: Vec<DVec3>,
    /// Cells; those that were straight are as they were.
    pub cells: Cells,
    /// The fields, at these points and in these cells.
    pub scalars: Vec<Scalars>,
    /// The work that was done, if any.
    pub report: Option<CurvedReport>,
}

/// The fate of curved cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvedReport {
    /// How many there were.
    pub cells: usize,
    /// Parts along each of their edges.
    pub parts: usize,
    /// How far a point is at most from its place in the curved cell, in parts of the diagonal of the
    /// mesh's box.
    pub shape: f64,
    /// How far a value is at most from that of the curved cell at the same point, in parts of the
    /// field's range.
    pub field: f64,
    /// Whether both are less than what was asked for, but for the rounding of coordinates, by which points of neighbors are moved
    /// to one place: at most 1e-6.
    pub is_kept: bool,
    /// Whether the numbers are estimates: those of pyramids are, whose functions are rational.
    pub is_estimate: bool,
    /// Cells that share corners of a face or an edge with a neighbor whose face is elsewhere: of another order, or with nodes
    /// elsewhere. There are gaps or overlaps there.
    pub apart: usize,
    /// How wide these are at most, in parts of the diagonal of the mesh's box.
    pub gap: f64,
    /// Faces between a curved cell, which is cut, and one with straight edges, which is not.
    pub hanging: usize,
}

impl std::fmt::Display for CurvedReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let CurvedReport { cells, parts, .. } = self;
        let [shape, field] = [self.shape, self.field].map(number::rounded);
        match cells {
            1 => write!(f, "1 curved cell is ")?,
            _ => write!(f, "{cells} curved cells are ")?,
        }
        match parts {
            1 => write!(f, "drawn by the corners")?,
            _ => write!(f, "cut into {parts} parts along each edge")?,
        }
        let (how, what) = match self.is_estimate {
            true => ("about ", " (estimated, as there are pyramids)"),
            false => ("at most ", ""),
        };
        write!(
            f,
            ": shape is off by {how}{shape} of the mesh's diagonal, values by {how}{field} of \
             the field's range{what}"
        )?;
        if !self.is_kept {
            write!(f, "; finer parts would be too many")?;
        }
        match self.apart {
            0 => {}
            1 => write!(f, "; 1 cell has")?,
            cells => write!(f, "; {cells} cells have")?,
        }
        if self.apart > 0 {
            let gap = number::rounded(self.gap);
            write!(
                f,
                " faces that are not where a neighbor's are: gaps there are up to {gap} of the diagonal wide"
            )?;
        }
        match self.hanging {
            0 => Ok(()),
            1 => write!(
                f,
                "; 1 face between a curved and a straight cell is cut on one side alone"
            ),
            faces => write!(
                f,
                "; {faces} faces between curved and straight cells are cut on one side alone"
            ),
        }
    }
}

/// Whether [`straighten`] cuts cells of this VTK type into straight ones, if their order is known.
pub fn is_straightened(cell_type: u8) -> bool {
    is_curved(cell_type)
}

/// Cuts curved cells into straight ones, tetrahedra, hexahedra, wedges and pyramids: those of order 2 (VTK's types 24 to 27,
/// 29 and 31 to 33), and Lagrange and Bézier tetrahedra, hexahedra and wedges of orders 1 to 6 (71 to 73, 78 to 80). Others, and
/// curved cells of other types and orders, stay. Where all orders are 1, cells only get the types of straight ones.
///
/// Edges are cut into the fewest parts that keep the tolerance, or as many as are allowed, at most
/// [`MOST_PARTS`]; the report says which.
///
/// # Errors
/// A tolerance that is not above 0, those of [`TetMesh::new`](super::TetMesh::new) for cells and fields
/// (where there are curved cells), a cell whose number of points fits no order or not its degrees, weights that are not above 0,
/// and more points than memory holds.
pub fn straighten(
    points: Vec<DVec3>,
    mut cells: Cells,
    scalars: Vec<Scalars>,
    extra: &Extra,
    how: Straightening,
) -> Result<Straightened, Error> {
    let tolerance = how.tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Invalid {
            what: format!("a tolerance of {tolerance} for curved cells"),
            help: Some("give a number above 0, such as 1e-3".into()),
        });
    }
    if !cells.types.iter().any(|cell_type| is_curved(*cell_type)) {
        return Ok(Straightened {
            points,
            cells,
            scalars,
            report: None,
        });
    }
    check(&points, &cells, &scalars, extra)?;
    let forms = Forms::new(&cells, extra)?;
    check_nodes(&points, &cells, &forms)?;
    if forms.are_straight(extra) {
        for (cell_type, form) in cells.types.iter_mut().zip(&forms.of_cells) {
            if let Some(kind) = forms.kinds.get(usize::from(*form)) {
                *cell_type = kind.family.straight();
            }
        }
        return Ok(Straightened {
            points,
            cells,
            scalars,
            report: None,
        });
    }
    let report = choose(&points, &cells, &scalars, &forms, extra, how);
    Cutter::new(&forms, &cells, extra, report.parts).cut(points, scalars, report)
}

/// Refuses what [`TetMesh::new`](super::TetMesh::new) refuses of cells and the length of fields.
fn check(points: &[DVec3], cells: &Cells, scalars: &[Scalars], extra: &Extra) -> Result<(), Error> {
    check_counts(points.len(), cells.types.len())?;
    split::check_cells(points, cells)?;
    let wrong = |name: &str, count: usize, association| {
        let (expected, per) = match association {
            Association::Point => (points.len(), "points"),
            Association::Cell => (cells.types.len(), "cells"),
        };
        match count == expected {
            true => Ok(()),
            false => Err(Error::invalid(format!(
                "field '{name}' has {count} values for {expected} {per}"
            ))),
        }
    };
    for field in scalars {
        wrong(&field.name, field.values.len(), field.association)?;
    }
    if !extra.degrees.is_empty() {
        wrong("HigherOrderDegrees", extra.degrees.len(), Association::Cell)?;
    }
    if !extra.weights.is_empty() {
        wrong("RationalWeights", extra.weights.len(), Association::Point)?;
    }
    Ok(())
}

/// Refuses nodes of curved cells that are not finite.
fn check_nodes(points: &[DVec3], cells: &Cells, forms: &Forms) -> Result<(), Error> {
    for (cell, _) in forms.cut() {
        for &node in nodes(cells, cell) {
            check_point(points, cell, node)?;
        }
    }
    Ok(())
}

/// The points of a cell.
fn nodes(cells: &Cells, cell: usize) -> &[u64] {
    &cells.connectivity[cells.offsets[cell] as usize..cells.offsets[cell + 1] as usize]
}

/// The fewest parts that keep the tolerance, and what they are off by.
fn choose(
    points: &[DVec3],
    cells: &Cells,
    scalars: &[Scalars],
    forms: &Forms,
    extra: &Extra,
    how: Straightening,
) -> CurvedReport {
    let tolerance = how.tolerance;
    let all: Vec<(&Curved, &[u64])> = forms
        .cut()
        .map(|(cell, kind)| (kind, nodes(cells, cell)))
        .collect();
    let greatest = |value: &(dyn Fn(u64) -> DVec3 + Sync)| {
        let bounds = all.par_iter().map(|(kind, nodes)| {
            let values: Vec<DVec3> = nodes.iter().map(|&node| value(node)).collect();
            let weights: Option<Vec<f64>> = (!extra.weights.is_empty()).then(|| {
                nodes
                    .iter()
                    .map(|&node| extra.weights[node as usize])
                    .collect()
            });
            kind.bend(&values, weights.as_deref())
        });
        // NaN, of missing values, is passed over.
        bounds.reduce(|| 0.0, f64::max)
    };
    let named = cells.connectivity.iter().map(|&p| points[p as usize]);
    let diagonal = Bounds::of(named).diagonal();
    let parts_of = |bend: f64, size: f64| if bend > 0.0 { bend / size } else { 0.0 };
    let shape = parts_of(greatest(&|node| points[node as usize]), diagonal);
    let mut field = 0.0_f64;
    for Scalars { values, .. } in scalars
        .iter()
        .filter(|s| s.association == Association::Point)
    {
        let nodes = all.iter().flat_map(|(_, nodes)| *nodes);
        let used = nodes.map(|&node| values[node as usize]);
        let finite = used.filter(|value| value.is_finite());
        let [low, high] = finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        });
        if high > low {
            // Halves, so that the difference of two great numbers is finite.
            let half = high / 2.0 - low / 2.0;
            let bend = greatest(&|node| DVec3::X * (values[node as usize] / 2.0));
            field = field.max(parts_of(bend, half));
        }
    }
    let wanted = (shape.max(field) / tolerance).sqrt().ceil();
    let count = all.len();
    // Cells of n parts along each edge become n³, pyramids some twice that. As many parts as the orders are
    // always allowed, as the file has a node for each, and two.
    let known = all.iter().map(|(kind, _)| kind.order.max(2).pow(3)).sum();
    let most = how.most_cells.max(known);
    let fits = |&parts: &usize| parts <= 2 || count.saturating_mul(parts.pow(3)) <= most;
    let wanted = (wanted as usize).clamp(1, MOST_PARTS);
    let parts = (1..=wanted).rev().find(fits).unwrap_or(1);
    let [shape, field] = [shape, field].map(|bend| bend / (parts * parts) as f64);
    CurvedReport {
        cells: count,
        parts,
        shape,
        field,
        // The root was rounded.
        is_kept: shape.max(field) <= tolerance * (1.0 + 1e-12),
        is_estimate: all.iter().any(|(kind, _)| kind.is_pyramid()),
        apart: 0,
        gap: 0.0,
        hanging: 0,
    }
}

#[cfg(test)]
mod tests;
