//! Evenly spread values that stand for all those of a large field.

use std::ops::Range;

use crate::grid::Samples;

/// The most values that are picked.
pub const MOST_PICKED: usize = 1 << 20;

/// The part of `range` among about evenly spread numbers from 0 to `total`: all of them, or
/// at most [`MOST_PICKED`].
///
/// One of each step is at a place in it that looks random, as every n-th sample of a grid
/// could be one column of it.
pub fn picks(range: Range<usize>, total: usize) -> impl Iterator<Item = usize> {
    let step = total.div_ceil(MOST_PICKED).max(1);
    let steps = range.start / step..range.end.div_ceil(step);
    let place = move |k: usize| {
        // The golden ratio as a fraction of 2⁶⁴, whose multiples are spread evenly.
        let mixed = (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32;
        k * step + mixed as usize % step
    };
    steps.map(place).filter(move |i| range.contains(i))
}

/// Appends the samples that stand for a grid of `total`, of which `samples` are those from
/// `start` on.
pub fn pick_samples(samples: &Samples, start: usize, total: usize, picked: &mut Vec<f64>) {
    let range = start..start + samples.len();
    picked.extend(picks(range, total).map(|i| samples.get(i - start)));
}
