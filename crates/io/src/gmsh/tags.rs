//! Which item has a tag: a file may number its nodes and elements as it likes.

use tetrascope_core::Error;

use crate::source::room;

/// No item.
const NONE: u64 = u64::MAX;

/// The items of a list by their tags.
pub(super) enum Tags {
    /// Item of tag `first` + i; [`NONE`] where there is none.
    Table { first: u64, items: Vec<u64> },
    /// Tags in ascending order with their items, where the tags are far apart.
    Sorted(Vec<(u64, u64)>),
}

impl Tags {
    /// Finds items by these tags, one for each item. Also returns a tag that two items have, if there is one:
    /// it then leads to the last of them.
    pub(super) fn new(tags: &[u64]) -> Result<(Tags, Option<u64>), Error> {
        let first = tags.iter().copied().min().unwrap_or(0);
        let span = tags.iter().copied().max().unwrap_or(0) - first;
        let mut repeated = None;
        if span / 2 <= tags.len() as u64 {
            let mut items = room(span as usize + 1)?;
            items.resize(span as usize + 1, NONE);
            for (item, &tag) in (0..).zip(tags) {
                let place = &mut items[(tag - first) as usize];
                if *place != NONE {
                    repeated.get_or_insert(tag);
                }
                *place = item;
            }
            return Ok((Tags::Table { first, items }, repeated));
        }
        let mut pairs: Vec<(u64, u64)> = room(tags.len())?;
        pairs.extend(tags.iter().copied().zip(0..));
        pairs.sort_unstable();
        let twins = pairs.windows(2).find(|pair| pair[0].0 == pair[1].0);
        let repeated = twins.map(|pair| pair[0].0);
        Ok((Tags::Sorted(pairs), repeated))
    }

    /// The item with that tag.
    pub(super) fn item(&self, tag: u64) -> Option<u64> {
        match self {
            Tags::Table { first, items } => {
                let place = usize::try_from(tag.checked_sub(*first)?).ok()?;
                items.get(place).copied().filter(|&item| item != NONE)
            }
            Tags::Sorted(pairs) => {
                let after = pairs.partition_point(|pair| pair.0 <= tag);
                let &(found, item) = pairs.get(after.checked_sub(1)?)?;
                (found == tag).then_some(item)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_found_near_and_far_apart() {
        for tags in [
            vec![7, 5, 6, 9],
            vec![u64::MAX, 5, 1 << 40, 9],
            vec![0],
            vec![u64::MAX],
        ] {
            let (found, repeated) = Tags::new(&tags).expect("little memory");
            assert_eq!(repeated, None);
            for (item, &tag) in (0..).zip(&tags) {
                assert_eq!(found.item(tag), Some(item), "{tags:?}");
            }
            for tag in [3, 8, 10, 1 << 50] {
                assert_eq!(found.item(tag), None, "{tags:?}: {tag}");
            }
        }
        assert_eq!(Tags::new(&[]).expect("no memory").0.item(0), None);
    }

    #[test]
    fn of_two_items_with_a_tag_the_last_has_it() {
        for far in [4, 1 << 40] {
            let (found, repeated) = Tags::new(&[3, far, 3]).expect("little memory");
            assert_eq!(repeated, Some(3));
            assert_eq!(found.item(3), Some(2));
        }
    }
}
