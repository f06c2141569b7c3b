//! The transfer function on the device, for `common/transfer_function.wgsl`.

use tetrascope_core::{Knot, TransferFunction};

use crate::normalization::{HUGE, Normalization, ScalarMap, color};

/// The mirror of the shaders' `Interval`: a range of scalars on which color and
/// extinction are linear.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Interval {
    /// Linear RGB, and extinction per normalized length, at the lower end.
    pub at_low: [f32; 4],
    /// The same at the upper end.
    pub at_high: [f32; 4],
    /// In the unit of the [`ScalarMap`].
    pub low: f32,
    /// In the unit of the [`ScalarMap`].
    pub high: f32,
    /// 1 / (high − low).
    pub inverse_width: f32,
    /// Room that WGSL leaves.
    pub padding: u32,
}

/// The intervals between the knots of `transfer_function`, by increasing scalar.
///
/// The first and the last are constant and reach beyond every scalar that
/// [`ScalarMap::scalar`] gives. Knots that f32 cannot tell apart become a step.
pub fn intervals(
    transfer_function: &TransferFunction,
    map: &ScalarMap,
    normalization: &Normalization,
) -> Vec<Interval> {
    let value = |knot: &Knot| {
        let [r, g, b] = color(knot.color).to_array();
        [r, g, b, normalization.extinction(knot.extinction)]
    };
    let interval = |low: f32, high: f32, at_low, at_high| Interval {
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
    let mut intervals = vec![interval(
        -beyond,
        map.scalar(first.scalar),
        value(first),
        value(first),
    )];
    for pair in knots.windows(2) {
        let (low, high) = (map.scalar(pair[0].scalar), map.scalar(pair[1].scalar));
        if low < high {
            intervals.push(interval(low, high, value(&pair[0]), value(&pair[1])));
        }
    }
    intervals.push(interval(
        map.scalar(last.scalar),
        beyond,
        value(last),
        value(last),
    ));
    intervals
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interval_has_the_layout_of_its_twin() {
        use tetrascope_shaders::{assert_layout, common::PROBE};
        // `padding` is at the end, where WGSL rounds the size up.
        assert_layout!(
            PROBE,
            Interval {
                at_low,
                at_high,
                low,
                high,
                inverse_width
            }
        );
    }
}
