//! The transfer function on the device, for `common/transfer_function.wgsl`.

use tetrascope_core::{Error, Knot, TransferFunction};
use tetrascope_shaders::loops::MOST_KNOTS;

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
///
/// [`Error::TooLarge`] for more than [`MOST_KNOTS`], as a shader's loop over them would be
/// too long.
pub fn intervals(
    transfer_function: &TransferFunction,
    map: &ScalarMap,
    normalization: &Normalization,
) -> Result<Vec<Interval>, Error> {
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
    if knots.len() > MOST_KNOTS {
        return Err(Error::TooLarge {
            what: "the transfer function on a GPU".into(),
            needed: knots.len() as u64,
            limit: MOST_KNOTS as u64,
            unit: "knots",
        });
    }
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
    Ok(intervals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_knots_than_a_loop_may_have_are_refused() {
        let of = |count: usize| {
            let knot = |i: usize| Knot {
                scalar: i as f64,
                color: tetrascope_core::glam::DVec3::ONE,
                extinction: 1.0,
            };
            let tf = TransferFunction::new((0..count).map(knot).collect()).expect("sorted");
            let unit = Normalization {
                center: tetrascope_core::glam::DVec3::ZERO,
                scale: 1.0,
            };
            intervals(&tf, &ScalarMap::of(&tf), &unit)
        };
        assert_eq!(of(MOST_KNOTS).expect("as many").len(), MOST_KNOTS + 1);
        let error = of(MOST_KNOTS + 1).expect_err("one more").to_string();
        assert!(error.contains("knots"), "{error}");
    }

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
