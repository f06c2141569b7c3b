//! Which points lie at the same place.

use glam::DVec3;
use rayon::prelude::*;

use crate::groups::Groups;

/// The place of each point: the least index of the used points there.
///
/// Points are at one place if their coordinates are equal, where −0 equals 0.
#[derive(Debug, Default)]
pub(super) struct Places(
    /// By point; empty where no two used points coincide, so that each is its own.
    Vec<u32>,
);

impl Places {
    /// The places of the points that `used` marks. In parallel; O(n) as long as different
    /// positions have different hashes.
    pub(super) fn new(points: &[DVec3], used: &[bool]) -> Places {
        let count = u32::try_from(points.len()).expect("points were counted");
        // Points at one place are in one group; most groups have one or two.
        let groups = Groups::new(points, points.len(), |point| {
            let scaled = u128::from(hash(bits(point))) * u128::from(count);
            [(scaled >> 64) as u32]
        });
        let find = |members: &mut Vec<([u64; 3], u32)>, group: usize| {
            members.clear();
            let used = groups.members(group).iter().filter(|p| used[**p as usize]);
            members.extend(used.map(|&point| (bits(&points[point as usize]), point)));
            members.sort_unstable();
            let mut moved = Vec::new();
            for same in members.chunk_by(|a, b| a.0 == b.0) {
                moved.extend(same[1..].iter().map(|&(_, point)| (point, same[0].1)));
            }
            moved
        };
        let moved = (0..groups.count()).into_par_iter();
        let moved = moved.map_init(Vec::new, find);
        let moved: Vec<(u32, u32)> = moved.flatten_iter().collect();
        if moved.is_empty() {
            return Places::default();
        }
        let mut places: Vec<u32> = (0..count).collect();
        for (point, place) in moved {
            places[point as usize] = place;
        }
        Places(places)
    }

    /// Whether no two points coincide.
    pub(super) fn are_apart(&self) -> bool {
        self.0.is_empty()
    }

    /// The place of a point.
    pub(super) fn of(&self, point: u32) -> u32 {
        *self.0.get(point as usize).unwrap_or(&point)
    }

    /// Whether two of the points are at one place.
    pub(super) fn coincide<const N: usize>(&self, points: [u32; N]) -> bool {
        let same = |i: usize, j: usize| self.of(points[i]) == self.of(points[j]);
        (1..N).any(|i| (0..i).any(|j| same(i, j)))
    }

    /// The cells by the places of their points, each place now named by the least of the
    /// points that these cells use; empty where no two of those coincide.
    pub(super) fn of_cells(&self, cells: &[[u32; 4]]) -> Vec<[u32; 4]> {
        if self.are_apart() {
            return Vec::new();
        }
        let mut least = vec![u32::MAX; self.0.len()];
        for &point in cells.iter().flatten() {
            let least = &mut least[self.of(point) as usize];
            *least = point.min(*least);
        }
        let place = |point| least[self.of(point) as usize];
        let coincide = |&point: &u32| place(point) != point;
        match cells.iter().flatten().any(coincide) {
            true => cells.iter().map(|cell| cell.map(place)).collect(),
            false => Vec::new(),
        }
    }
}

/// A position's bits, which are equal where it is: adding 0 turns −0 into +0.
fn bits(point: &DVec3) -> [u64; 3] {
    point.to_array().map(|x| (x + 0.0).to_bits())
}

/// Numbers that are spread evenly in 64 bits, be positions on a lattice or not.
fn hash(bits: [u64; 3]) -> u64 {
    bits.into_iter().fold(0, |hash: u64, bits| {
        // The golden ratio as a fraction of 2⁶⁴; upper bits are well mixed, and come down.
        let mixed = (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ mixed >> 29
    })
}
