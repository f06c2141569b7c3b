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
/// every scalar that [`ScalarMap::scalar`] gives.
///
/// Floats move knots by up to 2⁻²⁵ of the range, which is much of a needle's width: where it is, extinctions
/// make up for it, so that a ray through the needle meets what it would. Needles narrower than floats can
/// tell apart are as wide as that ([`NARROWEST`]), neighboring ones together.
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
    let mut reached = map.scalar(first.scalar);
    let mut pairs = vec![pair(-beyond, reached, value(first), value(first))];
    let mut needle: Option<Needle> = None;
    for two in knots.windows(2) {
        let (at_low, at_high) = (value(&two[0]), value(&two[1]));
        let width = map.exact(two[1].scalar) - map.exact(two[0].scalar);
        let high = map.scalar(two[1].scalar);
        if reached < high {
            if let Some(mut found) = needle.take() {
                let has_room = reached.next_up() < high;
                if !has_room {
                    found.add(width, at_low, at_high);
                }
                let end = if has_room {
                    found.end(reached).min(high.next_down())
                } else {
                    high
                };
                let value = found.value(end - reached);
                pairs.push(pair(reached, end, value, value));
                reached = end;
                if !has_room {
                    continue;
                }
            }
            let made_up = made_up(width, high - reached);
            pairs.push(pair(reached, high, made_up(at_low), made_up(at_high)));
            reached = high;
        } else if width > 0.0 {
            needle.get_or_insert_default().add(width, at_low, at_high);
        }
    }
    if let Some(needle) = needle {
        let end = needle.end(reached);
        let value = needle.value(end - reached);
        pairs.push(pair(reached, end, value, value));
        reached = end;
    }
    pairs.push(pair(reached, beyond, value(last), value(last)));
    pairs
}

/// The width of a needle that floats cannot tell from a line, in parts of the range.
pub const NARROWEST: f32 = 1.0 / (1 << 24) as f32;

/// From values of a pair of knots of one width to those of another that let as much light through. What
/// differs by less than [`MADE_UP`] stays.
fn made_up(width: f64, rounded: f32) -> impl Fn([f32; 4]) -> [f32; 4] {
    let factor = width / f64::from(rounded);
    move |[r, g, b, extinction]| {
        let made_up = (f64::from(extinction) * factor).min(HUGE) as f32;
        let is_off = (factor - 1.0).abs() > MADE_UP;
        [r, g, b, if is_off { made_up } else { extinction }]
    }
}

/// How far, relatively, floats may be from a pair's width: those wider than 2⁻¹⁰ never are.
const MADE_UP: f64 = 1.0 / (1 << 14) as f64;

/// Knots that f32 cannot tell apart: their extinction times their width, and their color times that.
#[derive(Clone, Copy, Debug, Default)]
struct Needle {
    depth: f64,
    light: [f64; 3],
}

impl Needle {
    /// Adds what is between two knots, whose color and extinction are linear.
    fn add(&mut self, width: f64, low: [f32; 4], high: [f32; 4]) {
        let (a, b) = (f64::from(low[3]), f64::from(high[3]));
        self.depth += width * (a + b) / 2.0;
        for ((light, low), high) in self.light.iter_mut().zip(low).zip(high) {
            // ∫ of the product of two linear functions.
            let (c, d) = (f64::from(low), f64::from(high));
            *light += width * (2.0 * a * c + a * d + b * c + 2.0 * b * d) / 6.0;
        }
    }

    /// The end of a pair as wide as such a needle has to be.
    fn end(&self, low: f32) -> f32 {
        (low + NARROWEST).max(low.next_up())
    }

    /// Color and extinction of a pair of this width.
    fn value(&self, width: f32) -> [f32; 4] {
        let extinction = (self.depth / f64::from(width)).min(HUGE) as f32;
        let [r, g, b] = self.light.map(|light| match self.depth > 0.0 {
            true => (light / self.depth) as f32,
            false => 0.0,
        });
        [r, g, b, extinction]
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::{Bounds, Knot, TransferFunction};
    use tetrascope_shaders::{assert_layout, common::PROBE};

    use super::{KnotPair, knot_pairs};
    use crate::{Normalization, ScalarMap};

    fn pairs(knots: &[(f64, f64)]) -> Vec<KnotPair> {
        let knot = |&(scalar, extinction)| Knot {
            scalar,
            color: DVec3::new(0.5, 1.0, 0.25),
            extinction,
        };
        let function = TransferFunction::new(knots.iter().map(knot).collect()).expect("sorted");
        let unit = Normalization::of(&Bounds::of([DVec3::NEG_ONE, DVec3::ONE]));
        knot_pairs(&function, &ScalarMap::of(&function), &unit)
    }

    /// ∫ σ over all that lies between the first knot and the last, as floats have it.
    fn area(pairs: &[KnotPair]) -> f64 {
        let inner = &pairs[1..pairs.len() - 1];
        let areas = inner.iter().map(|pair| {
            let width = f64::from(pair.high) - f64::from(pair.low);
            width * f64::from(pair.at_low[3] + pair.at_high[3]) / 2.0
        });
        areas.sum()
    }

    #[test]
    fn a_needle_keeps_its_area_however_narrow_it_is() {
        for width in [1e-2, 1e-4, 1e-6, 1e-7, 1e-9, 1e-12] {
            for at in [0.0, 0.1, 0.637, 1.0 - width] {
                let knots = [
                    (0.0, 0.0),
                    (at, 0.0),
                    (at + width / 2.0, 2.0 / width),
                    (at + width, 0.0),
                    (1.0, 0.0),
                ];
                let pairs = pairs(&knots);
                // Both halves may differ by 2⁻¹⁴ each, and the sums' roundings are less.
                assert!(
                    (area(&pairs) - 1.0).abs() < 1e-4,
                    "{width} at {at}: {}",
                    area(&pairs)
                );
                assert!(
                    pairs
                        .windows(2)
                        .all(|p| p[0].high == p[1].low && p[0].low < p[0].high)
                );
                assert!(pairs.iter().all(|p| p.inverse_width.is_finite()));
                let colors = pairs[1..].iter().filter(|p| p.at_high[3] > 0.0);
                for pair in colors {
                    assert_eq!(pair.at_high[..3], [0.5, 1.0, 0.25]);
                }
            }
        }
    }

    #[test]
    fn many_needles_in_one_place_are_one() {
        let mut knots = vec![(0.0, 0.0)];
        knots.extend((0..1000).map(|i| {
            (
                0.3 + 1e-13 * f64::from(i),
                if i % 2 == 0 { 0.0 } else { 2e10 },
            )
        }));
        knots.push((1.0, 0.0));
        let area_of_all = 0.5 * 2e10 * 1e-13 * 999.0 + 0.5 * 2e10 * (0.7 - 999e-13);
        let pairs = pairs(&knots);
        assert_eq!(
            pairs.len(),
            5,
            "constant, up to them, they, behind them, constant"
        );
        assert!((area(&pairs) / area_of_all - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_wide_and_steps_are_as_floats_have_them() {
        let pairs = pairs(&[(0.0, 1.0), (0.3, 2.0), (0.3, 5.0), (0.7, 0.1), (1.0, 3.0)]);
        let ends: Vec<_> = pairs
            .iter()
            .map(|p| (p.low, p.at_low[3], p.at_high[3]))
            .collect();
        assert_eq!(
            ends[1..],
            [
                (0.0, 1.0, 2.0),
                (0.3, 5.0, 0.1),
                (0.7, 0.1, 3.0),
                (1.0, 3.0, 3.0)
            ]
        );
    }

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
