//! Which points of neighbors are one, and which lie at one place.
//!
//! A point on a face or an edge is named by the places of its corners and their weights, which all
//! cells there say alike. Where they have the same nodes on it, it is made once, or is one of these
//! nodes. Where they have others (their own, or those of another order), each cell keeps its point with its
//! own values, and the points are moved to one place if they differ by rounding alone: then faces there
//! coincide to the last bit. What differs by more stays apart and is counted.

use std::collections::HashMap;

use glam::DVec3;

use super::shapes::Curved;
use crate::mesh::places::Places;

/// A point of a lattice on a face, by the weights of the face's corners: up to four, by increasing
/// place. Both cells of the face say the same.
type Name = [(u64, u64); 4];

/// Faces and edges of a kind of cell, with the nodes on each.
pub(super) struct Sides {
    sides: Vec<Side>,
    /// Where each node is: corners and their weights.
    places: Vec<Vec<(usize, u64)>>,
    /// Tells functions apart that have the same nodes.
    salt: u64,
}

struct Side {
    /// A bit for each corner.
    corners: u8,
    nodes: Vec<usize>,
}

/// The corners of a point, a bit for each.
pub(super) fn corners_of(point: &[(usize, u64)]) -> u8 {
    point
        .iter()
        .fold(0, |bits, &(corner, _)| bits | 1 << corner)
}

impl Sides {
    /// Those that points of a lattice lie on: all but its corners and what is inside.
    pub(super) fn new(kind: &Curved, lattice: &[Vec<(usize, u64)>]) -> Sides {
        let places = kind.node_places();
        let mut sides: Vec<Side> = Vec::new();
        let all = kind.family.corners();
        for point in lattice
            .iter()
            .filter(|point| point.len() > 1 && point.len() < all)
        {
            let corners = corners_of(point);
            if sides.iter().any(|side| side.corners == corners) {
                continue;
            }
            let is_on = |node: &usize| corners_of(&places[*node]) & !corners == 0;
            sides.push(Side {
                corners,
                nodes: (0..places.len()).filter(is_on).collect(),
            });
        }
        Sides {
            sides,
            places,
            salt: kind.basis as u64,
        }
    }

    /// A number for each side of a cell, the same where two cells have the same nodes at the same places of
    /// the side, and else another but in one of 2⁶⁴ cases.
    pub(super) fn signatures(&self, nodes: &[u64], places: &Places) -> Vec<(u8, u64)> {
        let place = |corner: usize| mixed(place_of(places, nodes[corner]));
        let signature = |side: &Side| {
            let of_node = |&node: &usize| {
                let terms = self.places[node].iter();
                let at = terms.map(|&(corner, weight)| place(corner).wrapping_mul(weight));
                mixed(nodes[node] ^ mixed(at.fold(self.salt, u64::wrapping_add)))
            };
            let all = side.nodes.iter().map(of_node);
            (side.corners, all.fold(0, u64::wrapping_add))
        };
        self.sides.iter().map(signature).collect()
    }
}

/// Mixes the bits of a number: the finalizer of splitmix64 (G. Steele, D. Lea, C. Flood, 2014).
fn mixed(number: u64) -> u64 {
    let x = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// The place of a point of a checked cell.
fn place_of(places: &Places, point: u64) -> u64 {
    places
        .of(u32::try_from(point).expect("points were counted"))
        .into()
}

/// The points on faces and edges.
#[derive(Default)]
pub(super) struct Seams {
    known: HashMap<Name, usize>,
    seams: Vec<Seam>,
    followers: Vec<Follower>,
}

/// All points of one name.
struct Seam {
    /// The first point, and the signature of its side.
    point: u64,
    signature: u64,
    /// The point whose place counts: a node, if one is there.
    leader: u64,
    is_node: bool,
}

/// A point that is not the first of its name.
struct Follower {
    point: u64,
    seam: usize,
    cell: usize,
}

/// A point that a cell asks for.
pub(super) struct Wanted<'a> {
    pub(super) cell: usize,
    pub(super) nodes: &'a [u64],
    /// Its corners and their weights; up to four.
    pub(super) corners: &'a [(usize, u64)],
    pub(super) signature: u64,
    /// The cell's node there, if there is one.
    pub(super) node: Option<u64>,
}

/// The fate of points that are not the first of their name.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Meeting {
    /// Cells with points that lie elsewhere than a neighbor's.
    pub(super) cells_apart: usize,
    /// The greatest distance between them.
    pub(super) gap: f64,
    /// How far a point was moved at most.
    pub(super) moved: f64,
}

impl Seams {
    /// The number of a point on a face or an edge; `new` makes one.
    pub(super) fn point(
        &mut self,
        wanted: &Wanted,
        places: &Places,
        new: impl FnOnce() -> u64,
    ) -> u64 {
        let mut name = [(u64::MAX, 0); 4];
        for (entry, &(corner, weight)) in name.iter_mut().zip(wanted.corners) {
            *entry = (place_of(places, wanted.nodes[corner]), weight);
        }
        name.sort_unstable();
        let signature = wanted.signature;
        let number = match self.known.get(&name) {
            Some(&seam) => seam,
            None => {
                let point = wanted.node.unwrap_or_else(new);
                self.known.insert(name, self.seams.len());
                self.seams.push(Seam {
                    point,
                    signature,
                    leader: point,
                    is_node: wanted.node.is_some(),
                });
                return point;
            }
        };
        let seam = &mut self.seams[number];
        if seam.signature == signature {
            return wanted.node.unwrap_or(seam.point);
        }
        let mut point = wanted.node.unwrap_or_else(new);
        let own = point;
        if wanted.node.is_some() && !seam.is_node {
            std::mem::swap(&mut point, &mut seam.leader);
            seam.is_node = true;
        }
        self.followers.push(Follower {
            point,
            seam: number,
            cell: wanted.cell,
        });
        own
    }

    /// Moves points to those that they follow, where they are nearer than `rounding`.
    pub(super) fn meet(self, points: &mut [DVec3], rounding: f64) -> Meeting {
        let mut meeting = Meeting::default();
        let mut last = None;
        for Follower { point, seam, cell } in self.followers {
            let leader = points[self.seams[seam].leader as usize];
            let own = &mut points[point as usize];
            let distance = (*own - leader).length();
            if distance <= rounding {
                meeting.moved = meeting.moved.max(distance);
                *own = leader;
                continue;
            }
            meeting.gap = meeting.gap.max(distance);
            meeting.cells_apart += usize::from(last != Some(cell));
            last = Some(cell);
        }
        meeting
    }
}
