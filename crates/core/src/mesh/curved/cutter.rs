//! Cells into parts: the points of their lattices, made once where neighbors agree.

use std::collections::{HashMap, HashSet};

use glam::DVec3;
use rayon::prelude::*;

use super::form::{Basis, Forms, STRAIGHT};
use super::lattice::{self, Lattice};
use super::seams::{Seams, Sides, Wanted, corners_of};
use super::shapes::{Curved, Family};
use super::{CurvedReport, Extra, Straightened, nodes};
use crate::mesh::places::Places;
use crate::mesh::{Association, Cells, Scalars, split, volume_corners, volume_faces};
use crate::{Bounds, Error};

/// Cuts cells into a given number of parts.
pub(super) struct Cutter<'a> {
    forms: &'a Forms,
    cells: &'a Cells,
    /// Weights of points, or none.
    weights: &'a [f64],
    parts: usize,
    lattices: HashMap<Family, Lattice>,
}

/// A point that was made: its cell and its place in that cell's lattice.
type Made = (usize, usize);

impl<'a> Cutter<'a> {
    pub(super) fn new(
        forms: &'a Forms,
        cells: &'a Cells,
        extra: &'a Extra,
        parts: usize,
    ) -> Cutter<'a> {
        let families = forms.kinds.iter().map(|kind| kind.family);
        let lattices = families.map(|family| (family, family.lattice(parts)));
        Cutter {
            lattices: lattices.collect(),
            weights: &extra.weights,
            forms,
            cells,
            parts,
        }
    }

    /// `report` says what it is about; how neighbors meet is added.
    pub(super) fn cut(
        &self,
        mut points: Vec<DVec3>,
        scalars: Vec<Scalars>,
        mut report: CurvedReport,
    ) -> Result<Straightened, Error> {
        let corners = split::used_corners(points.len(), self.cells);
        let places = Places::new(&points, &corners);
        let mut cut = Cells {
            offsets: vec![0],
            ..Cells::default()
        };
        let mut sources: Vec<usize> = Vec::new();
        let mut made: Vec<Made> = Vec::new();
        let mut seams = Seams::default();
        let first = points.len() as u64;
        let at_nodes: Vec<Vec<Option<usize>>> = self
            .forms
            .kinds
            .iter()
            .map(|kind| self.nodes_at(kind))
            .collect();
        let sides: Vec<Sides> = self
            .forms
            .kinds
            .iter()
            .map(|kind| Sides::new(kind, &self.lattices[&kind.family].points))
            .collect();
        let mut numbers: Vec<u64> = Vec::new();
        for (cell, &form) in self.forms.of_cells.iter().enumerate() {
            let nodes = nodes(self.cells, cell);
            if form == STRAIGHT {
                cut.types.push(self.cells.types[cell]);
                cut.connectivity.extend(nodes);
                cut.offsets.push(cut.connectivity.len() as u64);
                sources.push(cell);
                continue;
            }
            let form = usize::from(form);
            let lattice = &self.lattices[&self.forms.kinds[form].family];
            let signatures = sides[form].signatures(nodes, &places);
            numbers.clear();
            for (place, corners) in lattice.points.iter().enumerate() {
                let mut new = || {
                    made.push((cell, place));
                    first + made.len() as u64 - 1
                };
                let node = at_nodes[form][place].map(|node| nodes[node]);
                let side = corners_of(corners);
                let side = signatures.iter().find(|(corners, _)| *corners == side);
                numbers.push(match (side, node) {
                    (Some(&(_, signature)), node) => {
                        let wanted = Wanted {
                            cell,
                            nodes,
                            corners,
                            signature,
                            node,
                        };
                        seams.point(&wanted, &places, new)
                    }
                    (None, Some(node)) => node,
                    (None, None) => new(),
                });
            }
            for (cell_type, corners) in &lattice.cells {
                cut.types.push(*cell_type);
                cut.connectivity
                    .extend(corners.iter().map(|&corner| numbers[corner]));
                cut.offsets.push(cut.connectivity.len() as u64);
                sources.push(cell);
            }
        }
        points
            .try_reserve_exact(made.len())
            .map_err(|_| Error::NoMemory {
                what: "the points of curved cells".into(),
                bytes: size_of_val(&*made) as u64,
            })?;
        let named = self
            .cells
            .connectivity
            .iter()
            .map(|&point| points[point as usize]);
        let diagonal = Bounds::of(named).diagonal();
        // Far from the origin, coordinates of 32 bits are coarse. What shows there is said, not moved.
        let rounding = rounding(&points).min(1e-6 * diagonal);
        let sorted = self.sorted(&made);
        let new = self.values(&made, &sorted, |node| points[node]);
        points.extend(new);
        let meeting = seams.meet(&mut points, rounding);
        report.apart = meeting.cells_apart;
        if diagonal > 0.0 {
            report.gap = meeting.gap / diagonal;
            report.shape += meeting.moved / diagonal;
        }
        report.hanging = self.hanging_faces(&places);
        let keep = without_nodes(points.len(), self.cells, &mut cut);
        let spread = |field: Scalars| {
            let mut values = field.values;
            match field.association {
                Association::Cell => values = sources.iter().map(|&cell| values[cell]).collect(),
                Association::Point => {
                    // Halves, so that great numbers do not overflow on the way.
                    let halves =
                        self.values(&made, &sorted, |node| DVec3::X * (values[node] / 2.0));
                    values.extend(halves.into_iter().map(|half| half.x * 2.0));
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

    /// The node at each place of a kind's lattice, where there is one.
    fn nodes_at(&self, kind: &Curved) -> Vec<Option<usize>> {
        let lattice = &self.lattices[&kind.family];
        let node = |corners: &Vec<(usize, u64)>| match kind.weights(&self.scaled(corners))[..] {
            [(node, 1.0)] => Some(node),
            _ => None,
        };
        lattice.points.par_iter().map(node).collect()
    }

    /// A point of a lattice for [`Curved::functions`]: exact where the result is a whole number.
    fn scaled<'p>(&self, point: &'p [(usize, u64)]) -> impl Fn(&[usize], usize) -> f64 + use<'p> {
        let whole = lattice::whole(self.parts) as f64;
        move |corners, order| {
            let shares = point.iter().filter(|(corner, _)| corners.contains(corner));
            let sum: u64 = shares.map(|(_, weight)| weight).sum();
            (order as u64 * sum) as f64 / whole
        }
    }

    /// The made points, those at one place of cells of one form together.
    fn sorted(&self, made: &[Made]) -> Vec<usize> {
        let mut sorted: Vec<usize> = (0..made.len()).collect();
        let key = |&point: &usize| {
            let (cell, place) = made[point];
            (self.forms.of_cells[cell], place, point)
        };
        sorted.par_sort_unstable_by_key(key);
        sorted
    }

    /// A function at each point that was made, from its values at nodes.
    fn values(
        &self,
        made: &[Made],
        sorted: &[usize],
        at_node: impl Fn(usize) -> DVec3 + Sync,
    ) -> Vec<DVec3> {
        let kind = |point: usize| self.forms.of_cells[made[point].0];
        let is_alike = |a: &usize, b: &usize| kind(*a) == kind(*b) && made[*a].1 == made[*b].1;
        let alike = sorted.par_chunk_by(is_alike);
        let of_place = |alike: &[usize]| {
            let (cell, place) = made[alike[0]];
            let kind = self.forms.of(cell).expect("straight cells make no points");
            let corners = &self.lattices[&kind.family].points[place];
            let functions = kind.weights(&self.scaled(corners));
            let is_rational = kind.basis == Basis::Bernstein && !self.weights.is_empty();
            let value = |&point: &usize| {
                let nodes = nodes(self.cells, made[point].0);
                let terms = functions
                    .iter()
                    .map(|&(node, weight)| (nodes[node] as usize, weight));
                let value = match is_rational {
                    false => terms.map(|(node, weight)| at_node(node) * weight).sum(),
                    true => {
                        let weighted =
                            terms.map(|(node, weight)| (node, weight * self.weights[node]));
                        let sum: f64 = weighted.clone().map(|(_, weight)| weight).sum();
                        weighted
                            .map(|(node, weight)| at_node(node) * (weight / sum))
                            .sum()
                    }
                };
                (point, value)
            };
            alike.iter().map(value).collect::<Vec<_>>()
        };
        let mut values = vec![DVec3::ZERO; made.len()];
        let found: Vec<Vec<(usize, DVec3)>> = alike.map(of_place).collect();
        for (point, value) in found.into_iter().flatten() {
            values[point] = value;
        }
        values
    }

    /// Faces of cells that stay as they are which are those of cells that are cut: parts there end at edges that the
    /// others do not have.
    fn hanging_faces(&self, places: &Places) -> usize {
        if self.parts == 1 {
            return 0;
        }
        let is_straight = |cell: &usize| {
            self.forms.of_cells[*cell] == STRAIGHT
                && volume_corners(self.cells.types[*cell]).is_some()
        };
        let straight: Vec<usize> = (0..self.cells.types.len()).filter(is_straight).collect();
        if straight.is_empty() {
            return 0;
        }
        let faces = |cell: usize| {
            let nodes = nodes(self.cells, cell);
            let faces = volume_faces(self.cells.types[cell])
                .unwrap_or_default()
                .iter();
            faces.map(|face| {
                let mut key: Vec<u32> = face
                    .iter()
                    .map(|&corner| places.of(nodes[corner] as u32))
                    .collect();
                key.sort_unstable();
                key
            })
        };
        let cut: HashSet<Vec<u32>> = self.forms.cut().flat_map(|(cell, _)| faces(cell)).collect();
        straight
            .into_iter()
            .flat_map(faces)
            .filter(|face| cut.contains(face))
            .count()
    }
}

/// How far points that are made of rounded ones may be apart at most.
///
/// Coordinates up to X of 32 bits are off by 2⁻²⁴ X. On a face, functions of order 6 enlarge that by the square of their Lebesgue
/// constant, 4.55, on either side: 42 · 2⁻²⁴ X along each axis, and √3 that in space. Sums of up to 49 products, of two rounded
/// factors, add 2 · 51 · 20.7 · 2⁻⁵³ X along each axis.
fn rounding(points: &[DVec3]) -> f64 {
    let largest = points
        .par_iter()
        .filter(|p| p.is_finite())
        .map(|p| p.abs().max_element());
    let largest = largest.reduce(|| 0.0, f64::max);
    let is_narrow = |x: f64| f64::from(x as f32) == x || !x.is_finite();
    let is_narrow = points
        .par_iter()
        .all(|p| p.to_array().into_iter().all(is_narrow));
    let unit = if is_narrow {
        0.5_f64.powi(24)
    } else {
        0.5_f64.powi(53)
    };
    largest * (73.0 * unit + 3660.0 * 0.5_f64.powi(53))
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
