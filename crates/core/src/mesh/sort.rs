//! Linear-time sorting of keys that begin with a point index.

use rayon::prelude::*;

/// The items in ascending order, in parallel.
///
/// `leading` must be the item's most significant key and less than `bucket_count`.
/// Items fall into one bucket per point first; a point of a mesh has a few dozen
/// faces, so sorting the buckets costs O(1) an item. A mesh in which everything
/// shares one point degrades to O(n log n), not worse.
pub(super) fn sort_by_point<T, I>(
    items: I,
    bucket_count: usize,
    leading: impl Fn(&T) -> u32 + Sync,
) -> Vec<T>
where
    T: Copy + Default + Ord + Send,
    I: Iterator<Item = T> + Clone,
{
    let mut starts = vec![0_usize; bucket_count + 1];
    let mut item_count = 0;
    for item in items.clone() {
        starts[leading(&item) as usize + 1] += 1;
        item_count += 1;
    }
    for bucket in 0..bucket_count {
        starts[bucket + 1] += starts[bucket];
    }
    let mut sorted = vec![T::default(); item_count];
    for item in items {
        let next = &mut starts[leading(&item) as usize];
        sorted[*next] = item;
        *next += 1;
    }
    sorted
        .par_chunk_by_mut(|a, b| leading(a) == leading(b))
        .for_each(|bucket| bucket.sort_unstable());
    sorted
}
