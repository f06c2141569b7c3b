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
    /// Whether cells have the same four places; then nothing else here is of use.
    pub(super) has_duplicates: bool,
}

/// Groups whose cells are fetched before they are looked at.
const TOGETHER: usize = 16;

impl Adjacency {
    /// Pairs faces between the same places, in parallel. O(n) as long as no place has more than
    /// some dozen faces; those of one place are sorted.
    ///
    /// `places` are the cells by places, of which the four of a cell differ, and `tetrahedra` the
    /// same by points; `places` may be empty where no points coincide.
    pub(super) fn new(
        places: &[[u32; 4]],
        tetrahedra: &[[u32; 4]],
        point_count: usize,
    ) -> Adjacency {
        let may_join = !places.is_empty();
        let places = if may_join { places } else { tetrahedra };
        // A face is in the group of its least place, which is one of the least two of its cell.
        let groups = Groups::new(places, point_count, |&cell| least_two(cell));
        let neighbors = tetrahedra.par_iter();
        let pairs = Pairs {
            tetrahedra,
            may_join,
            neighbors: neighbors
                .map(|_| [NO_NEIGHBOR; 4].map(AtomicU32::new))
                .collect(),
        };
        let find = |(faces, fetched): &mut (Faces, Vec<[u32; 4]>), batch: usize| {
            let first = batch * TOGETHER;
            let batch = first..groups.count().min(first + TOGETHER);
            // Memory that is asked for together arrives together.
            let cells = groups.members_of_all(batch.clone()).iter();
            fetched.clear();
            fetched.extend(cells.map(|&cell| places[cell as usize]));
            let mut fetched = fetched.iter();
            let mut found = Found::default();
            for least in batch {
                faces.clear();
                for (&cell, &places) in groups.members(least).iter().zip(&mut fetched) {
                    faces.add(places, least as u32, cell);
                }
                faces.sort();
                faces.for_each_run(|same| found = found.and(pairs.pair(same)));
            }
            found
        };
        let found = (0..groups.count().div_ceil(TOGETHER)).into_par_iter();
        let found = found.map_init(Default::default, find);
        let found = found.reduce(Found::default, Found::and);
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
            crowded_faces: found.crowded,
            joined_faces: found.joined,
            has_duplicates: found.duplicates,
        }
    }
}

/// Findings while faces are paired.
#[derive(Clone, Copy, Default)]
struct Found {
    crowded: usize,
    joined: usize,
    duplicates: bool,
}

impl Found {
    fn and(self, other: Found) -> Found {
        Found {
            crowded: self.crowded + other.crowded,
            joined: self.joined + other.joined,
            duplicates: self.duplicates || other.duplicates,
        }
    }
}

/// A face of the group of its least place.
#[derive(Clone, Copy)]
struct Face {
    /// Its other two places, the lesser one in the high bits.
    key: u64,
    cell: u32,
    /// The fourth place of the cell, and which of its vertices that is.
    fourth: u32,
    opposite: u8,
}

/// The faces of a group.
#[derive(Default)]
struct Faces {
    faces: Vec<Face>,
    /// 32 bits that are equal for equal keys, and below them the number of the face: numbers as
    /// such are sorted several times as fast as faces.
    order: Vec<u64>,
    run: Vec<Face>,
}

impl Faces {
    fn clear(&mut self) {
        self.faces.clear();
        self.order.clear();
    }

    /// Adds the faces of a cell whose least place is `least`.
    #[inline]
    fn add(&mut self, places: [u32; 4], least: u32, cell: u32) {
        let [a, b, c, d] = ascending(places);
        let face = |(p, _): (u32, u8), (q, _): (u32, u8), (fourth, opposite)| Face {
            key: u64::from(p) << 32 | u64::from(q),
            cell,
            fourth,
            opposite,
        };
        let first = self.faces.len() as u64;
        let order = |face: &Face, number: u64| mixed(face.key) << 32 | number;
        if a.0 == least {
            let of = [face(b, c, d), face(b, d, c), face(c, d, b)];
            self.order.extend([
                order(&of[0], first),
                order(&of[1], first + 1),
                order(&of[2], first + 2),
            ]);
            self.faces.extend(of);
        } else {
            let of = face(c, d, a);
            self.order.push(order(&of, first));
            self.faces.push(of);
        }
    }

    fn sort(&mut self) {
        self.order.sort_unstable();
    }

    /// Calls `take` with the faces of each key.
    fn for_each_run(&mut self, mut take: impl FnMut(&mut [Face])) {
        let Faces { faces, order, run } = self;
        let face = |order: u64| faces[order as u32 as usize];
        for same in order.chunk_by(|a, b| a >> 32 == b >> 32) {
            // Most faces are of two cells.
            if let [a, b] = *same
                && face(a).key == face(b).key
            {
                take(&mut [face(a), face(b)]);
                continue;
            }
            run.clear();
            run.extend(same.iter().map(|&order| face(order)));
            // Keys that differ may have the same bits in the order.
            run.sort_unstable_by_key(|face| face.key);
            for same in run.chunk_by_mut(|a, b| a.key == b.key) {
                take(same);
            }
        }
    }
}

/// 32 bits of a key, spread evenly.
fn mixed(key: u64) -> u64 {
    // The golden ratio as a fraction of 2⁶⁴: upper bits depend on all of the key's.
    (key ^ key >> 32).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32
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
    /// Makes two cells with the same face neighbors.
    #[inline]
    fn pair(&self, same: &mut [Face]) -> Found {
        match same {
            [_] => Found::default(),
            [a, b] => {
                let neighbor =
                    |face: &Face| &self.neighbors[face.cell as usize][usize::from(face.opposite)];
                neighbor(a).store(b.cell, Ordering::Relaxed);
                neighbor(b).store(a.cell, Ordering::Relaxed);
                let differ = || self.points(a) != self.points(b);
                Found {
                    crowded: 0,
                    joined: usize::from(self.may_join && differ()),
                    duplicates: a.fourth == b.fourth,
                }
            }
            // No pairing is better than another: all of them are boundary.
            crowd => {
                crowd.sort_unstable_by_key(|face| face.fourth);
                Found {
                    crowded: 1,
                    joined: 0,
                    duplicates: crowd
                        .windows(2)
                        .any(|pair| pair[0].fourth == pair[1].fourth),
                }
            }
        }
    }

    /// The points of a face, ascending.
    fn points(&self, face: &Face) -> [u32; 3] {
        let corners = FACES[usize::from(face.opposite)];
        let mut points = corners.map(|corner| self.tetrahedra[face.cell as usize][corner]);
        points.sort_unstable();
        points
    }
}

/// The least two of four places, ascending.
#[inline]
fn least_two([a, b, c, d]: [u32; 4]) -> [u32; 2] {
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    [a.min(c), a.max(c).min(b.min(d))]
}

/// The places of a cell in ascending order, and which of its vertices they are.
#[inline]
pub(super) fn ascending([a, b, c, d]: [u32; 4]) -> [(u32, u8); 4] {
    // One number each, as numbers are compared without a branch.
    let numbered = |place: u32, vertex: u64| u64::from(place) << 2 | vertex;
    let [a, b, c, d] = [
        numbered(a, 0),
        numbered(b, 1),
        numbered(c, 2),
        numbered(d, 3),
    ];
    let (a, b) = (a.min(b), a.max(b));
    let (c, d) = (c.min(d), c.max(d));
    let (a, c) = (a.min(c), a.max(c));
    let (b, d) = (b.min(d), b.max(d));
    let (b, c) = (b.min(c), b.max(c));
    let apart = |numbered: u64| ((numbered >> 2) as u32, (numbered & 3) as u8);
    [apart(a), apart(b), apart(c), apart(d)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 32 bits of so many keys are the same for some that differ: of n keys, for some n² / 2³³ pairs.
    #[test]
    fn keys_that_are_ordered_alike_are_told_apart() {
        let mut faces = Faces::default();
        let cells = (1..300_000).flat_map(|q| [(q, 0), (q, 1)]);
        for (cell, (q, _)) in cells.clone().enumerate() {
            faces.add([0, q, 300_000, 300_001 + cell as u32], 0, cell as u32);
        }
        faces.sort();
        let alike = faces.order.windows(2);
        let alike = alike.filter(|pair| {
            let keys = [pair[0], pair[1]].map(|order| faces.faces[order as u32 as usize].key);
            pair[0] >> 32 == pair[1] >> 32 && keys[0] != keys[1]
        });
        assert!(alike.count() > 10);
        let mut pairs = 0;
        faces.for_each_run(|same| {
            assert!(same.iter().all(|face| face.key == same[0].key));
            // The face of the two cells that differ in their fourth place.
            if same[0].key as u32 == 300_000 {
                assert_eq!(same.len(), 2);
                pairs += 1;
            }
        });
        assert_eq!(pairs, cells.count() / 2);
    }
}
