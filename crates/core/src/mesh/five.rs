//! Five tetrahedra per hexahedron, mirrored from one hexahedron to the next.
//!
//! A hexahedron's corners fall into two sets of four without common edges; the
//! tetrahedron over one set is the middle piece, and its edges are the diagonals of the
//! six faces. Two hexahedra with a common face must put the diagonal between the
//! same corners, so one's choice forces the other's: a two-coloring.

use glam::DVec3;

use super::Cells;
use super::cell_type::{Kind, PYRAMID, Shape, VOXEL, WEDGE};
use super::orientation::orientation;
use super::places::Places;
use super::sort::sort_by_point;
use super::split::{cone, corners, is_hexahedron, smallest};
use crate::Error;

/// The pieces when the middle one stands on corners 0, 2, 5, 7, or on 1, 3, 4, 6.
const FIVE: [[[usize; 4]; 5]; 2] = [
    [
        [0, 5, 2, 7],
        [1, 2, 0, 5],
        [3, 0, 2, 7],
        [4, 5, 0, 7],
        [6, 2, 5, 7],
    ],
    [
        [1, 3, 4, 6],
        [0, 1, 3, 4],
        [2, 3, 1, 6],
        [5, 1, 4, 6],
        [7, 4, 3, 6],
    ],
];

/// Which of the two sets of `FIVE` a hexahedron's corner belongs to.
const COLOR_OF_CORNER: [bool; 8] = [false, true, false, true, true, false, true, false];

/// A voxel's corner 2 is a hexahedron's 3, and so on.
const HEXAHEDRON_FROM_VOXEL: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// A quadrilateral by its points or places in ascending order, the hexahedron it belongs
/// to, and the color of the least of them there.
type Quad = ([u32; 4], u32, bool);

/// The choice for every hexahedron, and the diagonals that follow.
pub(super) struct FiveSplit {
    /// By cell; `true` takes the second of `FIVE`. Meaningless for other cells.
    colors: Vec<bool>,
    /// Faces of hexahedra by places, ascending.
    quads: Vec<Quad>,
}

impl FiveSplit {
    /// Colors checked cells.
    pub(super) fn new(
        points: &[DVec3],
        cells: &Cells,
        places: &Places,
    ) -> Result<FiveSplit, Error> {
        let hexahedra = cells.types.iter().zip(0_u32..).filter_map(|(&t, cell)| {
            let shape = Kind::of(t).shape().filter(|s| is_hexahedron(s))?;
            Some((cell, hexahedron_corners(cells, cell as usize, shape)))
        });
        let mut quads = sorted_quads(hexahedra.clone(), points.len());
        let pair_of_cells = |pair: &[Quad]| match *pair {
            [(a_key, a, a_color), (b_key, b, b_color)] if a_key == b_key => {
                Some((a, b, a_color != b_color))
            }
            _ => None,
        };
        let mut forest = ParityForest::new(cells.types.len());
        for (a, b, differ) in quads.windows(2).filter_map(pair_of_cells) {
            if !forest.join(a, b, differ) {
                return Err(Error::Invalid {
                    what: format!(
                        "hexahedra cannot be split into five alternately: going around from cell {a} to its neighbor {b} takes an odd number of steps"
                    ),
                    help: Some("split by the smallest index, which works for every mesh".into()),
                });
            }
        }

        // Then across faces that coincide without sharing points, where no face that does
        // share them forbids it.
        if !places.are_apart() {
            let by_places = hexahedra
                .clone()
                .map(|(cell, corners)| (cell, corners.map(|p| places.of(p))));
            quads = sorted_quads(by_places, points.len());
            for (a, b, differ) in quads.windows(2).filter_map(pair_of_cells) {
                forest.join(a, b, differ);
            }
        }

        // Of a part's two colorings take the one that inverts fewer pieces.
        let mut colors = vec![false; cells.types.len()];
        let mut inverted = vec![[0_u32; 2]; cells.types.len()];
        for (cell, corners) in hexahedra.clone() {
            let (root, odd) = forest.find(cell);
            for (color, pieces) in FIVE.iter().enumerate() {
                let sign = |piece: &[usize; 4]| {
                    orientation(piece.map(|i| points[corners[i] as usize])).sign
                };
                let negative = pieces.iter().filter(|piece| sign(piece) < 0).count();
                let positive = pieces.iter().filter(|piece| sign(piece) > 0).count();
                let fewer = u32::try_from(negative.min(positive)).expect("at most five");
                let total = &mut inverted[root as usize][color ^ usize::from(odd)];
                *total = total.saturating_add(fewer);
            }
        }
        // On a tie the part's first cell takes the first way.
        let mut first_is_odd = vec![None; cells.types.len()];
        for (cell, _) in hexahedra {
            let (root, odd) = forest.find(cell);
            let first_is_odd = *first_is_odd[root as usize].get_or_insert(odd);
            let [even_root, odd_root] = inverted[root as usize];
            let root_color = match even_root.cmp(&odd_root) {
                std::cmp::Ordering::Less => false,
                std::cmp::Ordering::Greater => true,
                std::cmp::Ordering::Equal => first_is_odd,
            };
            colors[cell as usize] = root_color ^ odd;
        }
        Ok(FiveSplit { colors, quads })
    }

    /// Cuts one cell; `corners` are in its shape's order.
    pub(super) fn cut(
        &self,
        cell: usize,
        corners: &[u32],
        shape: &Shape,
        places: &Places,
        out: &mut Vec<[u32; 4]>,
    ) -> Result<(), Error> {
        if is_hexahedron(shape) {
            let pieces = &FIVE[usize::from(self.colors[cell])];
            let corner = |i: usize| match shape == &VOXEL {
                true => corners[HEXAHEDRON_FROM_VOXEL[i]],
                false => corners[i],
            };
            out.extend(pieces.iter().map(|piece| piece.map(corner)));
            return Ok(());
        }
        if shape.corners == 4 {
            out.push([corners[0], corners[1], corners[2], corners[3]]);
            return Ok(());
        }
        if shape != &WEDGE && shape != &PYRAMID {
            return Err(Error::Invalid {
                what: format!(
                    "cell {cell} has {} faces; the split into five takes tetrahedra, pyramids, wedges and hexahedra",
                    shape.faces.len()
                ),
                help: Some("split by the smallest index, which works for every mesh".into()),
            });
        }
        // The corner from which most diagonals of the cell's quadrilaterals start: a
        // wedge needs two at one corner, a pyramid its one.
        let start = |face: &[usize]| self.diagonal_start(corners, face, places);
        let mut ends = [0_u8; 6];
        let quads = shape.faces.iter().filter(|face| face.len() == 4);
        for face in quads.clone() {
            let first = start(face);
            ends[face[first]] += 1;
            ends[face[(first + 2) % 4]] += 1;
        }
        let needed = if shape == &WEDGE { 2 } else { 1 };
        let Some(apex) = (0..shape.corners).find(|&i| ends[i] >= needed) else {
            return Err(Error::Invalid {
                what: format!(
                    "wedge {cell} cannot be split: the diagonals of its neighbors form a cycle around it"
                ),
                help: Some("split by the smallest index, which works for every mesh".into()),
            });
        };
        cone(
            corners,
            shape,
            apex,
            |face| if face.len() == 4 { start(face) } else { 0 },
            out,
        );
        Ok(())
    }

    /// Where in `face` its diagonal starts: as the hexahedron behind it says, or else
    /// at the smallest corner.
    fn diagonal_start(&self, corners: &[u32], face: &[usize], places: &Places) -> usize {
        let place = |i: usize| places.of(corners[i]);
        let imposed = quad_key(face, place).and_then(|key| {
            let at = self.quads.partition_point(|quad| quad.0 < key);
            let quad = self.quads.get(at).filter(|quad| quad.0 == key)?;
            let least = face.iter().position(|&i| place(i) == key[0])?;
            let through_least = quad.2 == self.colors[quad.1 as usize];
            Some(if through_least {
                least
            } else {
                (least + 1) % 4
            })
        });
        imposed.unwrap_or_else(|| smallest(places, corners, face))
    }
}

/// All faces of hexahedra, each by the numbers of its corners, ascending.
fn sorted_quads(
    hexahedra: impl Iterator<Item = (u32, [u32; 8])> + Clone,
    count: usize,
) -> Vec<Quad> {
    let quads = hexahedra.flat_map(|(cell, corners)| {
        super::cell_type::HEXAHEDRON
            .faces
            .iter()
            .filter_map(move |face| {
                let key = quad_key(face, |i| corners[i])?;
                let least = face.iter().find(|&&i| corners[i] == key[0])?;
                Some((key, cell, COLOR_OF_CORNER[*least]))
            })
    });
    sort_by_point(quads, count, |quad| quad.0[0])
}

/// A face's four different numbers in ascending order; a collapsed face agrees with
/// everything.
fn quad_key(face: &[usize], number: impl Fn(usize) -> u32) -> Option<[u32; 4]> {
    let mut key = [0, 1, 2, 3].map(|i| number(face[i]));
    key.sort_unstable();
    key.windows(2).all(|pair| pair[0] < pair[1]).then_some(key)
}

fn hexahedron_corners(cells: &Cells, cell: usize, shape: &Shape) -> [u32; 8] {
    let given = corners(cells, cell, shape);
    std::array::from_fn(|i| match shape == &VOXEL {
        true => given[HEXAHEDRON_FROM_VOXEL[i]],
        false => given[i],
    })
}

/// Disjoint sets in which every member knows whether it equals its root or differs.
struct ParityForest {
    parents: Vec<(u32, bool)>,
}

impl ParityForest {
    fn new(count: usize) -> ParityForest {
        ParityForest {
            parents: (0..u32::try_from(count).expect("cells were counted"))
                .map(|i| (i, false))
                .collect(),
        }
    }

    /// The root, and whether `member` differs from it.
    fn find(&mut self, mut member: u32) -> (u32, bool) {
        let mut odd = false;
        loop {
            let (parent, differs) = self.parents[member as usize];
            if parent == member {
                return (member, odd);
            }
            // Halve the path: point to the grandparent.
            let (grandparent, parent_differs) = self.parents[parent as usize];
            self.parents[member as usize] = (grandparent, differs ^ parent_differs);
            odd ^= differs ^ parent_differs;
            member = grandparent;
        }
    }

    /// States that `a` and `b` differ, or are equal; false if that contradicts.
    fn join(&mut self, a: u32, b: u32, differ: bool) -> bool {
        let (a_root, a_odd) = self.find(a);
        let (b_root, b_odd) = self.find(b);
        if a_root == b_root {
            return a_odd ^ b_odd == differ;
        }
        self.parents[b_root as usize] = (a_root, a_odd ^ b_odd ^ differ);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_five_pieces_fill_a_cube() {
        let corners = [
            [0, 0, 0],
            [1, 0, 0],
            [1, 1, 0],
            [0, 1, 0],
            [0, 0, 1],
            [1, 0, 1],
            [1, 1, 1],
            [0, 1, 1],
        ]
        .map(|c: [i32; 3]| DVec3::from_array(c.map(f64::from)));
        for (color, pieces) in FIVE.iter().enumerate() {
            let volumes = pieces.map(|piece| orientation(piece.map(|i| corners[i])).determinant);
            assert_eq!(volumes, [2.0, 1.0, 1.0, 1.0, 1.0], "color {color}");
            assert!(
                pieces[0]
                    .iter()
                    .all(|&i| COLOR_OF_CORNER[i] == (color == 1))
            );
        }
    }
}
