//! Which points lie at the same place.

use glam::DVec3;
use rayon::prelude::*;

/// The place of each point: the least index of the used points there.
///
/// Points are at one place if their coordinates are equal, where −0 equals 0.
#[derive(Debug, Default)]
pub(super) struct Places(
    /// By point; empty where no two used points coincide, so that each is its own.
    Vec<u32>,
);

impl Places {
    /// The places of the points that `used` marks. O(n log n).
    pub(super) fn new(points: &[DVec3], used: &[bool]) -> Places {
        let count = u32::try_from(points.len()).expect("points were counted");
        // Adding 0 turns −0 into +0.
        let mut order: Vec<([u64; 3], u32)> = (points.par_iter(), used, 0..count)
            .into_par_iter()
            .filter(|(_, used, _)| **used)
            .map(|(p, _, index)| (p.to_array().map(|x| (x + 0.0).to_bits()), index))
            .collect();
        order.par_sort_unstable();
        let same_place = |a: &([u64; 3], u32), b: &([u64; 3], u32)| a.0 == b.0;
        if !order.windows(2).any(|pair| same_place(&pair[0], &pair[1])) {
            return Places::default();
        }
        let mut places: Vec<u32> = (0..count).collect();
        for same in order.chunk_by(same_place) {
            for &(_, point) in same {
                places[point as usize] = same[0].1;
            }
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
        let places = points.map(|p| self.of(p));
        (1..N).any(|i| places[..i].contains(&places[i]))
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
