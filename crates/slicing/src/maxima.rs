//! The greatest value that a transfer function takes on a range of scalars, quickly.

use tetrascope_core::transfer_function::Side;
use tetrascope_core::{Appearance, OpticalModel, TransferFunction};

/// A sparse table over the knots: the maximum of any run of knots in constant time.
#[derive(Clone, Debug)]
pub(crate) struct Maxima {
    transfer_function: TransferFunction,
    color_counts: bool,
    scalars: Vec<f64>,
    /// `levels[k][i]` is the maximum of knots i to i + 2^k − 1.
    levels: Vec<Vec<f64>>,
}

impl Maxima {
    /// For what `appearance` can make visible: extinction, or color where only that counts.
    pub(crate) fn new(appearance: &Appearance) -> Maxima {
        let tf = &appearance.transfer_function;
        let color_counts = appearance.optical_model == OpticalModel::MaximumIntensity;
        let measure = |k: &tetrascope_core::Knot| {
            if color_counts {
                k.color.max_element()
            } else {
                k.extinction
            }
        };
        let mut levels = vec![tf.knots().iter().map(measure).collect::<Vec<f64>>()];
        let mut run = 1;
        while 2 * run <= levels[0].len() {
            let below = &levels[levels.len() - 1];
            let pairs = below.iter().zip(&below[run..]);
            levels.push(pairs.map(|(a, b)| a.max(*b)).collect());
            run *= 2;
        }
        Maxima {
            transfer_function: tf.clone(),
            color_counts,
            scalars: tf.knots().iter().map(|k| k.scalar).collect(),
            levels,
        }
    }

    /// The greatest value for scalars in [low, high]; 0 for an empty range.
    pub(crate) fn over(&self, low: f64, high: f64) -> f64 {
        if low > high {
            return 0.0;
        }
        let ends = [(low, Side::Above), (high, Side::Below)].map(|(scalar, side)| {
            let (color, extinction) = self.transfer_function.limit(scalar, side);
            if self.color_counts {
                color.max_element()
            } else {
                extinction
            }
        });
        let first = self.scalars.partition_point(|s| *s < low);
        let end = self.scalars.partition_point(|s| *s <= high);
        let mut most = ends[0].max(ends[1]);
        if first < end {
            let level = &self.levels[(end - first).ilog2() as usize];
            let run = 1 << (end - first).ilog2();
            most = most.max(level[first]).max(level[end - run]);
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Knot;
    use tetrascope_core::glam::DVec3;

    use super::*;

    #[test]
    fn any_range_has_the_maximum_that_a_search_finds() {
        let knots = (0..23).map(|i: u32| Knot {
            scalar: f64::from(i / 2),
            color: DVec3::new(f64::from(i * 7 % 5), 0.0, f64::from(i * 3 % 11)),
            extinction: f64::from(i * 5 % 13),
        });
        let tf = TransferFunction::new(knots.collect()).expect("two knots a scalar");
        for optical_model in OpticalModel::VOLUMETRIC {
            let appearance = Appearance::new(tf.clone(), optical_model);
            let maxima = Maxima::new(&appearance);
            for low in -3..30 {
                for high in low..30 {
                    let (low, high) = (f64::from(low) * 0.5, f64::from(high) * 0.5);
                    let truth = match optical_model {
                        OpticalModel::MaximumIntensity => tf.max_color(low, high),
                        _ => tf.max_extinction(low, high),
                    };
                    assert_eq!(maxima.over(low, high), truth, "{low} {high}");
                }
            }
            assert_eq!(maxima.over(f64::INFINITY, f64::NEG_INFINITY), 0.0);
        }
    }
}
