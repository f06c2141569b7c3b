//! Which rank has which pieces.

use std::ops::Range;

/// The pieces of each rank, one run after the other: about as many bytes for each rank.
///
/// A piece goes to the rank in whose equal share of all bytes its middle lies, so that neighbors in the list stay together
/// (clusters lie along a Hilbert curve), and no rank has more than its share and one piece. Ranks may have none. Every piece has one rank.
///
/// ```
/// use tetrascope_cluster::partition::by_bytes;
///
/// assert_eq!(by_bytes(&[10, 10, 10, 30], 2), [0..3, 3..4]);
/// assert_eq!(by_bytes(&[7], 3), [0..0, 0..1, 1..1]);
/// ```
pub fn by_bytes(bytes: &[u64], ranks: usize) -> Vec<Range<usize>> {
    // Pieces of 0 bytes are spread, too.
    let sizes = || bytes.iter().map(|&bytes| u128::from(bytes) + 1);
    let all: u128 = sizes().sum();
    let mut before = 0;
    let owner = |size: u128| {
        let middle = 2 * before + size;
        before += size;
        (middle * ranks as u128 / (2 * all)) as usize
    };
    let owners: Vec<usize> = sizes().map(owner).collect();
    let first = |rank: usize| owners.partition_point(|&owner| owner < rank);
    (0..ranks)
        .map(|rank| first(rank)..first(rank + 1))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_has_one_rank_and_no_rank_has_more_than_its_share_and_one_piece() {
        let mut seed = 1_u64;
        let mut random = |most: u64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) % most
        };
        for _ in 0..500 {
            let ranks = 1 + random(9) as usize;
            let bytes: Vec<u64> = (0..random(40)).map(|_| random(1000)).collect();
            let found = by_bytes(&bytes, ranks);
            assert_eq!(found.len(), ranks);
            assert_eq!(found[0].start, 0);
            assert_eq!(found[ranks - 1].end, bytes.len());
            assert!(found.windows(2).all(|pair| pair[0].end == pair[1].start));
            let size = |pieces: &Range<usize>| {
                bytes[pieces.clone()]
                    .iter()
                    .map(|bytes| bytes + 1)
                    .sum::<u64>()
            };
            let share = bytes.iter().map(|bytes| bytes + 1).sum::<u64>() / ranks as u64;
            let largest = bytes.iter().max().map_or(0, |bytes| bytes + 1);
            assert!(
                found
                    .iter()
                    .all(|pieces| size(pieces) <= share + 1 + largest)
            );
        }
    }

    #[test]
    fn huge_files_do_not_overflow() {
        let found = by_bytes(&[u64::MAX; 4], 4);
        assert_eq!(found, [0..1, 1..2, 2..3, 3..4]);
        assert_eq!(by_bytes(&[], 2), [0..0, 0..0]);
    }
}
