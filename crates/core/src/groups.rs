//! Numbers in groups, found in parallel: cells by a point, items by a stretch of a curve.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use rayon::prelude::*;

/// The numbers of items, sorted into groups.
///
/// A counting sort: O(items + groups), in 4 bytes per member and 8 per group, and while it is
/// made 4 more per group and thread, of at most eight threads.
#[derive(Debug)]
pub struct Groups {
    /// Where each group begins in `members`, and where the last one ends.
    starts: Vec<usize>,
    members: Vec<u32>,
}

/// The most parts of the items that are counted each by itself. Counts are as long as there are
/// groups, so that more of them would cost more than they save.
const MOST_PARTS: usize = 8;

impl Groups {
    /// Each item in the groups that `groups_of` names, which must differ and be less than
    /// `group_count`. The members of a group are in ascending order, whatever the threads do.
    ///
    /// # Panics
    /// With more items than 32 bits count.
    pub fn new<T: Sync, const N: usize>(
        items: &[T],
        group_count: usize,
        groups_of: impl Fn(&T) -> [u32; N] + Sync,
    ) -> Groups {
        let item_count = u32::try_from(items.len()).expect("items are counted in 32 bits");
        let part_count = rayon::current_num_threads().clamp(1, MOST_PARTS);
        let part_length = items.len().div_ceil(part_count).max(1);
        // How many members of each group are in a part.
        let count = |part: &[T]| {
            let mut counts = vec![0_u32; group_count];
            for group in part.iter().flat_map(&groups_of) {
                counts[group as usize] += 1;
            }
            counts
        };
        let mut counts: Vec<Vec<u32>> = items.par_chunks(part_length).map(count).collect();
        // Where each group begins, and in it the members of each part.
        let mut starts = Vec::with_capacity(group_count + 1);
        let mut member_count = 0;
        for group in 0..group_count {
            starts.push(member_count);
            let mut of_group = 0;
            for counts in &mut counts {
                let of_part = counts[group];
                counts[group] = of_group;
                of_group += of_part;
            }
            member_count += of_group as usize;
        }
        starts.push(member_count);
        // Parts write to places of their own, though not side by side: atomic without order.
        let members = (0..member_count).into_par_iter();
        let members: Vec<AtomicU32> = members.map(|_| AtomicU32::new(0)).collect();
        let parts = items.par_chunks(part_length).zip(counts);
        parts.enumerate().for_each(|(part, (items, mut counts))| {
            let numbers = (part * part_length) as u32..item_count;
            for (item, number) in items.iter().zip(numbers) {
                for group in groups_of(item) {
                    let place = &mut counts[group as usize];
                    let at = starts[group as usize] + *place as usize;
                    members[at].store(number, Ordering::Relaxed);
                    *place += 1;
                }
            }
        });
        let members = members.into_iter().map(AtomicU32::into_inner).collect();
        Groups { starts, members }
    }

    /// How many groups there are.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// The members of a group.
    pub fn members(&self, group: usize) -> &[u32] {
        &self.members[self.range(group)]
    }

    /// The members of several groups, one group after the other.
    pub fn members_of_all(&self, groups: Range<usize>) -> &[u32] {
        &self.members[self.starts[groups.start]..self.starts[groups.end]]
    }

    fn range(&self, group: usize) -> Range<usize> {
        self.starts[group]..self.starts[group + 1]
    }

    /// All members, those of each group by `key`, and where keys are equal in ascending order.
    pub fn sorted_by_key<K: Ord + Send>(mut self, key: impl Fn(u32) -> K + Sync) -> Vec<u32> {
        /// A group that is worth the threads.
        const LARGE: usize = 1 << 14;
        let mut rest = self.members.as_mut_slice();
        let mut groups = Vec::with_capacity(self.starts.len() - 1);
        for ends in self.starts.windows(2) {
            let (group, others) = rest.split_at_mut(ends[1] - ends[0]);
            groups.push(group);
            rest = others;
        }
        groups.into_par_iter().for_each(|group| {
            if group.len() > LARGE {
                group.par_sort_by_cached_key(|&member| key(member));
            } else {
                group.sort_by_cached_key(|&member| key(member));
            }
        });
        self.members
    }
}

/// Whether each number from 0 to before `count` is among `numbers`, all of which are less.
pub fn marked(count: usize, numbers: impl ParallelIterator<Item = usize>) -> Vec<bool> {
    let marks: Vec<AtomicBool> = (0..count).map(|_| AtomicBool::new(false)).collect();
    numbers.for_each(|number| {
        // Written once, so that threads seldom wait for each other's caches.
        if !marks[number].load(Ordering::Relaxed) {
            marks[number].store(true, Ordering::Relaxed);
        }
    });
    marks.into_iter().map(AtomicBool::into_inner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_grouped_in_ascending_order_by_any_number_of_threads() {
        let items: Vec<u32> = (0..1000).map(|i| i * i % 97).collect();
        let of = |&item: &u32| [item % 13, 13 + item % 7];
        let simple = |group: usize| {
            let numbered = (0..).zip(&items);
            let members = numbered.filter(|(_, item)| of(item).contains(&(group as u32)));
            members.map(|(number, _)| number).collect::<Vec<u32>>()
        };
        for threads in [1, 2, 5, 12] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().expect("threads");
            let groups = pool.install(|| Groups::new(&items, 21, of));
            assert_eq!(groups.count(), 21);
            for group in 0..21 {
                assert_eq!(groups.members(group), simple(group));
            }
        }
    }

    #[test]
    fn groups_sort_by_key_and_keep_the_order_of_equals() {
        // One group is large, and some are empty.
        let items: Vec<u32> = (0..40_000).map(|i| i * 7919 % 1000).collect();
        let groups = Groups::new(&items, 40, |&item| [if item < 900 { 0 } else { item / 25 }]);
        let sorted = groups.sorted_by_key(|member| items[member as usize]);
        let mut expected: Vec<u32> = (0..40_000).collect();
        expected.sort_by_key(|&member| items[member as usize]);
        assert_eq!(sorted, expected);
    }

    #[test]
    fn nothing_has_no_members() {
        let none: [u32; 0] = [];
        let groups = Groups::new(&none, 3, |&item| [item]);
        assert_eq!((groups.count(), groups.members(2)), (3, [].as_slice()));
        assert_eq!(Groups::new(&none, 0, |&item| [item]).count(), 0);
    }
}
