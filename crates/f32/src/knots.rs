//! The transfer function in f32, as `common/transfer_function.wgsl` reads it.

use tetrascope_core::{Knot, TransferFunction};

use crate::normalization::{HUGE, Normalization, ScalarMap, color};

/// Two neighboring knots, between which color and extinction are linear; the mirror of the
/// shaders' `KnotPair`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct KnotPair {
    /// Linear RGB, and extinction per normalized length, at the lower knot.
    pub at_low: [f32; 4],
    /// The same at the upper knot.
    pub at_high: [f32; 4],
    /// The mapped scalar of the lower knot.
    pub low: f32,
    /// The mapped scalar of the upper knot.
    pub high: f32,
    /// 1 / (high − low).
    pub inverse_width: f32,
    /// Room that WGSL leaves.
    pub padding: u32,
}

/// The pairs of neighboring knots of `transfer_function`, by increasing scalar.
///
/// Before the first knot and behind the last, one more pair each is constant and reaches beyond
/// every scalar that [`ScalarMap::scalar`] gives. Knots that f32 cannot tell apart become a
/// step.
pub fn knot_pairs(
    transfer_function: &TransferFunction,
    map: &ScalarMap,
    normalization: &Normalization,
) -> Vec<KnotPair> {
    let value = |knot: &Knot| {
        let [r, g, b] = color(knot.color).to_array();
        [r, g, b, normalization.extinction(knot.extinction)]
    };
    let pair = |low: f32, high: f32, at_low, at_high| KnotPair {
        at_low,
        at_high,
        low,
        high,
        inverse_width: 1.0 / (high - low),
        padding: 0,
    };
    let knots = transfer_function.knots();
    let (first, last) = (&knots[0], &knots[knots.len() - 1]);
    // Twice as far as any scalar.
    let beyond = 2.0 * HUGE as f32;
    let (low, high) = (map.scalar(first.scalar), map.scalar(last.scalar));
    let mut pairs = vec![pair(-beyond, low, value(first), value(first))];
    for two in knots.windows(2) {
        let (low, high) = (map.scalar(two[0].scalar), map.scalar(two[1].scalar));
        if low < high {
            pairs.push(pair(low, high, value(&two[0]), value(&two[1])));
        }
    }
    pairs.push(pair(high, beyond, value(last), value(last)));
    pairs
}

#[cfg(test)]
mod tests {
    use tetrascope_shaders::{assert_layout, common::PROBE};

    use super::KnotPair;

    #[test]
    fn knot_pair_has_the_layout_of_its_twin() {
        // `padding` is at the end, where WGSL rounds the size up.
        assert_layout!(
            PROBE,
            KnotPair {
                at_low,
                at_high,
                low,
                high,
                inverse_width
            }
        );
    }
}
