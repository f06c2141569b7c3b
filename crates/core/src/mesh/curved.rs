//! Curved cells as straight ones: each is cut into smaller cells, until what that changes is small.
//!
//! A curved cell of order 2 maps its reference cell by a polynomial, and its field is another. Its
//! reference cell is cut into n parts along each edge (`lattice`), and each part's corners are
//! evaluated (`shapes`). What straight parts are off by falls with n², and `bound` says by
//! how much at most, from the polynomials' second derivatives.
//!
//! n is the same in the whole mesh, so that parts of neighbors meet: a point on a face is named by
//! the weights of the face's corners, which both cells say alike, and is made once. A point that is
//! one of the cell's own stays that.

mod bound;
mod lattice;
mod shapes;

use std::collections::HashMap;

use glam::DVec3;

use super::{Association, Cells, Scalars, check_point, split};
use crate::{Bounds, Error, number};
use lattice::Lattice;
use shapes::Curved;

/// The most parts along an edge.
pub const MOST_PARTS: usize = 16;

/// How curved cells become straight ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straightening {
    /// How far shape and values may be off: in parts of the diagonal of the mesh's box, and of each
    /// field's range.
    pub tolerance: f64,
    /// The most cells that curved ones are cut into; two parts along each edge are always allowed.
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
    /// Whether both are less than what was asked for.
    pub is_kept: bool,
    /// Whether the numbers are estimates: those of pyramids are, whose functions are rational.
    pub is_estimate: bool,
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
        match self.is_kept {
            true => Ok(()),
            false => write!(f, "; finer parts would be too many"),
        }
    }
}

/// Whether [`straighten`] cuts cells of this VTK type into straight ones.
pub fn is_straightened(cell_type: u8) -> bool {
    Curved::of(cell_type).is_some()
}

/// Cuts curved cells of order 2 (VTK's types 24 to 27, 29 and 31 to 33) into straight ones: tetrahedra,
/// hexahedra, wedges and pyramids. Others, and curved cells of other types, stay.
///
/// Edges are cut into the fewest parts that keep the tolerance, or as many as are allowed, at most
/// [`MOST_PARTS`]; the report says which.
///
/// # Errors
/// A tolerance that is not above 0, those of [`TetMesh::new`](super::TetMesh::new) for cells and fields
/// (where there are curved cells), and more points than memory holds.
pub fn straighten(
    points: Vec<DVec3>,
    cells: Cells,
    scalars: Vec<Scalars>,
    how: Straightening,
) -> Result<Straightened, Error> {
    let tolerance = how.tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::Invalid {
            what: format!("a tolerance of {tolerance} for curved cells"),
            help: Some("give a number above 0, such as 1e-3".into()),
        });
    }
    let mut kinds: HashMap<u8, Curved> = HashMap::new();
    for &cell_type in &cells.types {
        if let Some(curved) = Curved::of(cell_type) {
            kinds.entry(cell_type).or_insert(curved);
        }
    }
    if kinds.is_empty() {
        return Ok(Straightened {
            points,
            cells,
            scalars,
            report: None,
        });
    }
    check(&points, &cells, &scalars, &kinds)?;
    let report = choose(&points, &cells, &scalars, &kinds, how);
    Cutter::new(&kinds, report.parts).cut(points, &cells, scalars, report)
}

/// Refuses what [`TetMesh::new`](super::TetMesh::new) refuses of cells and the length of fields, and
/// nodes of curved cells that are not finite.
fn check(
    points: &[DVec3],
    cells: &Cells,
    scalars: &[Scalars],
    kinds: &HashMap<u8, Curved>,
) -> Result<(), Error> {
    split::check_cells(points, cells)?;
    for (cell, cell_type) in cells.types.iter().enumerate() {
        if kinds.contains_key(cell_type) {
            for &node in nodes(cells, cell) {
                check_point(points, cell, node)?;
            }
        }
    }
    for field in scalars {
        let (expected, per) = match field.association {
            Association::Point => (points.len(), "points"),
            Association::Cell => (cells.types.len(), "cells"),
        };
        let (name, count) = (&field.name, field.values.len());
        if count != expected {
            return Err(Error::invalid(format!(
                "field '{name}' has {count} values for {expected} {per}"
            )));
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
    kinds: &HashMap<u8, Curved>,
    how: Straightening,
) -> CurvedReport {
    let tolerance = how.tolerance;
    let curved = |cell: usize| Some((kinds.get(&cells.types[cell])?, nodes(cells, cell)));
    let all = || (0..cells.types.len()).filter_map(curved);
    let greatest = |value: &dyn Fn(u64) -> DVec3| {
        let bounds = all().map(|(curved, nodes)| {
            let values: Vec<DVec3> = nodes.iter().map(|&node| value(node)).collect();
            curved.bend(&values)
        });
        // NaN, of missing values, is passed over.
        bounds.fold(0.0, f64::max)
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
        let used = all().flat_map(|(_, nodes)| nodes.iter().map(|&node| values[node as usize]));
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
    let count = all().count();
    // Cells of n parts along each edge become n³, pyramids some twice that.
    let fits = |&parts: &usize| parts <= 2 || count.saturating_mul(parts.pow(3)) <= how.most_cells;
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
        is_estimate: all().any(|(curved, _)| curved.is_pyramid()),
    }
}

/// A point of a lattice on a face, by the weights of the face's corners: up to four, by increasing
/// corner. Both cells of the face say the same.
type Name = [(u64, u64); 4];

/// Cuts cells into a given number of parts: one lattice for each type.
struct Cutter {
    lattices: HashMap<u8, Lattice>,
}

impl Cutter {
    fn new(kinds: &HashMap<u8, Curved>, parts: usize) -> Cutter {
        let lattice = |(&cell_type, curved): (&u8, &Curved)| (cell_type, curved.lattice(parts));
        Cutter {
            lattices: kinds.iter().map(lattice).collect(),
        }
    }

    fn cut(
        &self,
        mut points: Vec<DVec3>,
        cells: &Cells,
        scalars: Vec<Scalars>,
        report: CurvedReport,
    ) -> Result<Straightened, Error> {
        let mut cut = Cells {
            offsets: vec![0],
            ..Cells::default()
        };
        let first = points.len() as u64;
        // Where each new point is: its cell and its place in that cell's lattice.
        let mut made: Vec<(usize, usize)> = Vec::new();
        let mut sources: Vec<usize> = Vec::new();
        let mut shared: HashMap<Name, u64> = HashMap::new();
        let mut places: Vec<u64> = Vec::new();
        for (cell, &cell_type) in cells.types.iter().enumerate() {
            let nodes = nodes(cells, cell);
            let Some(lattice) = self.lattices.get(&cell_type) else {
                cut.types.push(cell_type);
                cut.connectivity.extend(nodes);
                cut.offsets.push(cut.connectivity.len() as u64);
                sources.push(cell);
                continue;
            };
            places.clear();
            for (place, point) in lattice.points.iter().enumerate() {
                let mut new = || {
                    made.push((cell, place));
                    first + made.len() as u64 - 1
                };
                places.push(match (point.node, name(&point.corners, nodes)) {
                    (Some(node), _) => nodes[node],
                    (None, Some(name)) => *shared.entry(name).or_insert_with(new),
                    (None, None) => new(),
                });
            }
            for (cell_type, corners) in &lattice.cells {
                cut.types.push(*cell_type);
                cut.connectivity
                    .extend(corners.iter().map(|&corner| places[corner]));
                cut.offsets.push(cut.connectivity.len() as u64);
                sources.push(cell);
            }
        }
        let weights = |&(cell, place): &(usize, usize)| {
            let lattice = &self.lattices[&cells.types[cell]];
            let weights = &lattice.points[place].weights;
            weights
                .iter()
                .map(move |&(node, weight)| (nodes(cells, cell)[node] as usize, weight))
        };
        points
            .try_reserve_exact(made.len())
            .map_err(|_| Error::NoMemory {
                what: "the points of curved cells".into(),
                bytes: size_of_val(&*made) as u64,
            })?;
        for place in &made {
            let point = weights(place)
                .map(|(node, weight)| points[node] * weight)
                .sum();
            points.push(point);
        }
        let keep = without_nodes(points.len(), cells, &mut cut);
        let spread = |field: Scalars| {
            let mut values = field.values;
            match field.association {
                Association::Cell => values = sources.iter().map(|&cell| values[cell]).collect(),
                Association::Point => {
                    for place in &made {
                        // Halves, so that great numbers do not overflow on the way.
                        let half = weights(place).map(|(node, weight)| values[node] / 2.0 * weight);
                        values.push(half.sum::<f64>() * 2.0);
                    }
                    retain(&mut values, &keep);
                }
            }
            Scalars { values, ..field }
        };
        let scalars = scalars.into_iter().map(spread).collect();
        retain(&mut points, &keep);
        Ok(Straightened {
            scalars,
            points,
            cells: cut,
            report: Some(report),
        })
    }
}

/// Which points stay: nodes that only curved cells named, and parts do not, go. Numbers the
/// points in `cut` anew; `cells` is the mesh before.
fn without_nodes(points: usize, cells: &Cells, cut: &mut Cells) -> Vec<bool> {
    let mut keep = vec![true; points];
    let mut set = |cells: &Cells, to: bool| {
        cells
            .connectivity
            .iter()
            .for_each(|&point| keep[point as usize] = to);
    };
    set(cells, false);
    set(cut, true);
    let mut number = 0;
    let numbers = keep.iter().map(|&keep| {
        number += u64::from(keep);
        number.wrapping_sub(1)
    });
    let numbers: Vec<u64> = numbers.collect();
    for point in &mut cut.connectivity {
        *point = numbers[*point as usize];
    }
    keep
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| *keep.next().expect("one for each"));
}

/// The name of a point on a face; `None` inside of the cell.
fn name(corners: &[(usize, u64)], nodes: &[u64]) -> Option<Name> {
    let mut name = [(u64::MAX, 0); 4];
    if corners.len() > name.len() {
        return None;
    }
    for (entry, &(corner, weight)) in name.iter_mut().zip(corners) {
        *entry = (nodes[corner], weight);
    }
    name.sort_unstable();
    Some(name)
}

#[cfg(test)]
mod tests;
