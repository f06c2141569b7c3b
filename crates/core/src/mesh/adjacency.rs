//! Which cells share a face.

use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

use super::NO_NEIGHBOR;
use crate::groups::Groups;

/// The points of the face opposite vertex 0…3 of a positively oriented cell,
/// counterclockwise as seen from outside.
pub const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

/// Face neighbors of all cells, and the faces that have none.
#[derive(Debug)]
pub(super) struct Adjacency {
    pub(super) neighbors: Vec<[u32; 4]>,
    pub(super) boundary: Vec<(u32, u8)>,
    /// Faces of three or more cells.
    pub(super) crowded_faces: usize,
    /// Faces of two cells that name different points there.
    pub(super) joined_faces: usize,
}

/// A face of the group of its least place: its other two places, the lesser one in the high bits,
/// then its cell and opposite vertex.
type FaceKey = (u64, u32, u8);

impl Adjacency {
    /// Pairs faces between the same places, in parallel. O(n) as long as no place has more than
    /// some dozen faces; those of one place are sorted.
    ///
    /// `places` are the cells by places, of which the four of a cell differ, and `tetrahedra`
    /// the same by points.
    pub(super) fn new(
        places: &[[u32; 4]],
        tetrahedra: &[[u32; 4]],
        point_count: usize,
    ) -> Adjacency {
        // A face is in the group of its least place, which is one of the least two of its cell.
        let groups = Groups::new(places, point_count, |&cell| {
            let [(least, _), (next, _), ..] = ascending(cell);
            [least, next]
        });
        let pairs = Pairs {
            tetrahedra,
            // Where no points coincide, both are the same slice.
            may_join: !std::ptr::eq(places, tetrahedra),
            neighbors: (0..tetrahedra.len())
                .map(|_| [NO_NEIGHBOR; 4].map(AtomicU32::new))
                .collect(),
        };
        let find = |faces: &mut Vec<FaceKey>, least: usize| {
            faces.clear();
            for &cell in groups.members(least) {
                add_faces(places[cell as usize], least as u32, cell, faces);
            }
            faces.sort_unstable();
            let same = faces.chunk_by(|a, b| a.0 == b.0);
            same.map(|same| pairs.pair(same)).fold([0, 0], sum)
        };
        let found = (0..groups.count()).into_par_iter();
        let found = found.map_init(Vec::new, find);
        let [crowded_faces, joined_faces] = found.reduce(|| [0, 0], sum);
        drop(groups);

        let rows = pairs.neighbors.into_iter();
        let neighbors: Vec<[u32; 4]> = rows.map(|row| row.map(AtomicU32::into_inner)).collect();
        let open = |(cell, row): (usize, &[u32; 4])| {
            let numbered = (0_u8..).zip(*row);
            let open = numbered.filter(|(_, neighbor)| *neighbor == NO_NEIGHBOR);
            open.map(move |(opposite, _)| (cell as u32, opposite))
        };
        let boundary = neighbors.par_iter().enumerate().flat_map_iter(open);
        Adjacency {
            boundary: boundary.collect(),
            neighbors,
            crowded_faces,
            joined_faces,
        }
    }
}

/// Adds the faces of a cell whose least place is `least`.
fn add_faces(places: [u32; 4], least: u32, cell: u32, faces: &mut Vec<FaceKey>) {
    let [(a, at_a), (b, at_b), (c, at_c), (d, at_d)] = ascending(places);
    let key = |p: u32, q: u32| u64::from(p) << 32 | u64::from(q);
    if a == least {
        faces.push((key(b, c), cell, at_d));
        faces.push((key(b, d), cell, at_c));
        faces.push((key(c, d), cell, at_b));
    } else {
        faces.push((key(c, d), cell, at_a));
    }
}

/// The table that threads share while they pair faces.
struct Pairs<'a> {
    tetrahedra: &'a [[u32; 4]],
    /// Whether points coincide.
    may_join: bool,
    /// Each is written at most once, as a face is in one group: atomic without order.
    neighbors: Vec<[AtomicU32; 4]>,
}

impl Pairs<'_> {
    /// Makes two cells with the same face neighbors; gives the number of crowded and of joined
    /// faces.
    fn pair(&self, same: &[FaceKey]) -> [usize; 2] {
        match *same {
            [_] => [0, 0],
            [(_, a, a_opposite), (_, b, b_opposite)] => {
                let neighbor =
                    |cell: u32, opposite: u8| &self.neighbors[cell as usize][usize::from(opposite)];
                neighbor(a, a_opposite).store(b, Ordering::Relaxed);
                neighbor(b, b_opposite).store(a, Ordering::Relaxed);
                let differ = || self.points(a, a_opposite) != self.points(b, b_opposite);
                [0, usize::from(self.may_join && differ())]
            }
            // No pairing is better than another: all of them are boundary.
            _ => [1, 0],
        }
    }

    /// The points of a face, ascending.
    fn points(&self, cell: u32, opposite: u8) -> [u32; 3] {
        let corners = FACES[usize::from(opposite)];
        let mut points = corners.map(|corner| self.tetrahedra[cell as usize][corner]);
        points.sort_unstable();
        points
    }
}

fn sum([a, b]: [usize; 2], [c, d]: [usize; 2]) -> [usize; 2] {
    [a + c, b + d]
}

/// The places of a cell in ascending order, and which of its vertices they are.
#[inline]
pub(super) fn ascending([a, b, c, d]: [u32; 4]) -> [(u32, u8); 4] {
    let [a, b, c, d] = [(a, 0), (b, 1), (c, 2), (d, 3)];
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (a, c) = (a.min(c), a.max(c));
    let (b, d) = (b.min(d), b.max(d));
    let (b, c) = (b.min(c), b.max(c));
    [a, b, c, d]
}
