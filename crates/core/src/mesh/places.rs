//! Which points lie at the same place.

use std::sync::atomic::{AtomicU32, Ordering};

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
        if are_apart(points, used) == Some(true) {
            return Places::default();
        }
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
    #[inline]
    pub(super) fn coincide<const N: usize>(&self, points: [u32; N]) -> bool {
        let places = match self.are_apart() {
            true => points,
            false => points.map(|point| self.of(point)),
        };
        let same = |i: usize, j: usize| places[i] == places[j];
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
        let coincide = |cell: &[u32; 4]| cell.iter().any(|&point| place(point) != point);
        match cells.par_iter().any(coincide) {
            true => cells.par_iter().map(|cell| cell.map(place)).collect(),
            false => Vec::new(),
        }
    }
}

/// Whether no two used points coincide, as is most often the case; `None` where too many positions
/// have similar hashes. In parallel; O(n).
///
/// A table of open addressing that all threads fill: each point takes the first free entry from that of
/// its hash on, and meets there all that were at its position before.
fn are_apart(points: &[DVec3], used: &[bool]) -> Option<bool> {
    /// One in 10¹² points passes so many entries of a table that is half full.
    const MOST_STEPS: usize = 64;
    const FREE: u32 = u32::MAX;
    const TOGETHER: usize = 16;
    let length = (2 * points.len()).next_power_of_two().max(2);
    // Upper bits of a hash are well mixed.
    let shift = 64 - length.trailing_zeros();
    let table = (0..length).into_par_iter().map(|_| AtomicU32::new(FREE));
    let table: Vec<AtomicU32> = table.collect();
    let first = |point: &DVec3| (hash(bits(point)) >> shift) as usize;
    let enter = |point: &DVec3, number: u32| {
        let position = bits(point);
        let first = first(point);
        for step in 0..MOST_STEPS {
            let entry = &table[(first + step) & (length - 1)];
            let taken = entry.compare_exchange(FREE, number, Ordering::Relaxed, Ordering::Relaxed);
            match taken {
                Ok(_) => return Ok(()),
                Err(other) if bits(&points[other as usize]) == position => return Err(Some(false)),
                Err(_) => {}
            }
        }
        Err(None)
    };
    let enter_all = |(chunk, members): (usize, &[DVec3])| {
        // Each exchange waits for its entry, but entries can be fetched together before.
        let fetch = |point: &DVec3| table[first(point)].load(Ordering::Relaxed);
        std::hint::black_box(members.iter().map(fetch).fold(0, |a, b| a ^ b));
        let numbers = chunk * TOGETHER..;
        let used = numbers.zip(members).filter(|(number, _)| used[*number]);
        used.map(|(number, point)| enter(point, number as u32))
            .find(Result::is_err)
    };
    let chunks = points.par_chunks(TOGETHER).enumerate().with_min_len(256);
    match chunks.find_map_any(enter_all) {
        Some(Err(why)) => why,
        _ => Some(true),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(n: u32) -> Vec<DVec3> {
        let at = |i: u32| f64::from(i) / f64::from(n);
        let numbers = 0..n * n * n;
        numbers
            .map(|i| DVec3::new(at(i % n), at(i / n % n), at(i / (n * n))))
            .collect()
    }

    #[test]
    fn coincident_points_are_found_among_many_if_they_are_used() {
        let mut points = lattice(20);
        let all = vec![true; points.len() + 1];
        assert_eq!(are_apart(&points, &all), Some(true));
        points.push(DVec3::new(-0.0, 0.5, 0.25));
        assert_eq!(are_apart(&points, &all), Some(false));
        let places = Places::new(&points, &all);
        assert_eq!(places.of(8000), 20 * (10 + 20 * 5));
        let mut used = all;
        used[8000] = false;
        assert!(Places::new(&points, &used).are_apart());
    }

    #[test]
    fn positions_that_a_stranger_chose_to_have_one_hash_are_told_apart() {
        // The last step multiplies `hash ^ z` by an odd number: equal sums have equal hashes.
        let before = |x: f64| {
            let [first, second] = [x.to_bits(), 1.0_f64.to_bits()];
            let mixed = |hash: u64, bits: u64| {
                let mixed = (hash ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                mixed ^ mixed >> 29
            };
            mixed(mixed(0, first), second)
        };
        let point = |x: f64| {
            let z = f64::from_bits(before(x) ^ before(1.0) ^ 2.0_f64.to_bits());
            DVec3::new(x, 1.0, z)
        };
        let points = (0..500).map(|i| point(1.0 + f64::from(i) / 512.0));
        let mut points: Vec<DVec3> = points.filter(|p| p.is_finite()).collect();
        assert!(points.len() > 400);
        let first = hash(bits(&points[0]));
        assert!(points.iter().all(|p| hash(bits(p)) == first));
        assert!(are_apart(&points, &vec![true; points.len()]) != Some(false));
        assert!(Places::new(&points, &vec![true; points.len()]).are_apart());
        points.push(points[100]);
        let places = Places::new(&points, &vec![true; points.len()]);
        assert_eq!(places.of(points.len() as u32 - 1), 100);
    }
}
