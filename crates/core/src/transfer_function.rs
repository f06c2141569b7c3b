//! Color and extinction as piecewise-linear functions of the scalar.

mod intervals;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::appearance::BRIGHTEST;
use crate::colormap::Colormap;
use crate::{Error, number};
pub(crate) use intervals::{Intervals, KnotPair};

/// A piecewise-linear map from scalar to linear RGB and extinction.
///
/// Between knots both are linear; before the first knot and after the last they
/// are constant. Two knots at one scalar make a step. NaN is transparent.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    knots: Vec<Knot>,
    /// Made from the knots once, as the integral looks it up for every segment.
    intervals: Intervals,
}

/// One point of a [`TransferFunction`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Knot {
    /// In the field's own units.
    pub scalar: f64,
    /// Linear RGB, usually in [0, 1].
    pub color: DVec3,
    /// Per world unit, 0 or more.
    pub extinction: f64,
}

impl Knot {
    /// Nothing, at `scalar`.
    fn clear(scalar: f64) -> Knot {
        Knot {
            scalar,
            color: DVec3::ZERO,
            extinction: 0.0,
        }
    }
}

/// How opaque each scalar is, over one unit distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OpacityRamp {
    /// Opacity rises linearly from 0 to 1 over this range, and is constant beyond.
    pub range: (f64, f64),
    /// Scalars inside of the range that are clear. Opacity rises from them in both
    /// directions, equally fast, up to 1 at the farther end of the range.
    pub background: Option<(f64, f64)>,
    /// Whether scalars below the range are clear and black.
    pub clear_below: bool,
    /// Whether scalars above the range are clear and black.
    pub clear_above: bool,
}

impl OpacityRamp {
    /// The opacity of `scalar` over one unit distance.
    pub fn opacity(&self, scalar: f64) -> f64 {
        let (low, high) = self.range;
        if (self.clear_below && scalar < low) || (self.clear_above && scalar > high) {
            return 0.0;
        }
        if low == high {
            return 0.5;
        }
        let scalar = scalar.clamp(low, high);
        let mut opacity = 0.0;
        for (from, to) in self.slopes() {
            if scalar >= from.0 && scalar <= to.0 {
                let x = (scalar * 0.5 - from.0 * 0.5) / (to.0 * 0.5 - from.0 * 0.5);
                opacity = from.1 * (1.0 - x) + to.1 * x;
            }
        }
        opacity
    }

    /// Stretches on which opacity is linear, each from (scalar, opacity) to the same, by
    /// increasing scalar.
    fn slopes(&self) -> Vec<((f64, f64), (f64, f64))> {
        let (low, high) = self.range;
        let Some((from, to)) = self.background else {
            return vec![((low, 0.0), (high, 1.0))];
        };
        let [below, above] = [from * 0.5 - low * 0.5, high * 0.5 - to * 0.5];
        let farther = below.max(above);
        let mut slopes = Vec::new();
        if below > 0.0 {
            slopes.push(((low, below / farther), (from, 0.0)));
        }
        if above > 0.0 {
            slopes.push(((to, 0.0), (high, above / farther)));
        }
        slopes
    }
}

/// Opacities are clipped here before they become extinctions, which would
/// otherwise be infinite (PyVista's choice).
pub const MAX_OPACITY: f64 = 0.998;

impl TransferFunction {
    /// A transfer function through `knots`, whose scalars must not decrease.
    ///
    /// Refuses an empty list, numbers that are not finite, negative colors or
    /// extinctions, colors beyond [`BRIGHTEST`], and more than two knots at one scalar.
    pub fn new(knots: Vec<Knot>) -> Result<TransferFunction, Error> {
        let wrong = |i: usize, what: String, help: &str| {
            Err(Error::Invalid {
                what: format!("transfer function knot {i} {what}"),
                help: Some(help.into()),
            })
        };
        if knots.is_empty() {
            return Err(Error::invalid(
                "a transfer function needs at least one knot",
            ));
        }
        for (i, knot) in knots.iter().enumerate() {
            if !(knot.scalar.is_finite() && knot.color.is_finite() && knot.extinction.is_finite()) {
                return wrong(
                    i,
                    "has a number that is not finite".into(),
                    "give finite numbers",
                );
            }
            if knot.extinction < 0.0 {
                let extinction = number::exact(knot.extinction);
                let what = format!("has the negative extinction {extinction}");
                return wrong(i, what, "extinction is 0 (clear) or more, per world unit");
            }
            if knot.color.min_element() < 0.0 {
                let what = format!("has the negative color {}", number::vector(knot.color));
                return wrong(i, what, "colors are linear RGB, 0 or more");
            }
            if knot.color.max_element() > BRIGHTEST {
                let what = format!("has a color of {:e}", knot.color.max_element());
                return wrong(i, what, "a picture holds colors up to 8e37; 1 is white");
            }
            if i > 0 && knot.scalar < knots[i - 1].scalar {
                let [this, before] = [knot, &knots[i - 1]].map(|k| number::exact(k.scalar));
                let what = format!("at {this} comes after {before}");
                return wrong(i, what, "sort the knots by scalar");
            }
            if i > 1 && knot.scalar == knots[i - 2].scalar {
                let what = format!("is the third at {}", number::exact(knot.scalar));
                return wrong(
                    i,
                    what,
                    "two knots at one scalar make a step; remove the others",
                );
            }
        }
        if !(knots[knots.len() - 1].scalar - knots[0].scalar).is_finite() {
            return Err(Error::Invalid {
                what: "a transfer function wider than a 64-bit float holds".into(),
                help: Some("give knots at most 1.7e308 apart".into()),
            });
        }
        let intervals = Intervals::new(&knots);
        Ok(TransferFunction { knots, intervals })
    }

    /// A color map over `range` with opacity rising linearly from 0 to 1.
    ///
    /// Opacity is per `unit_distance` world units: σ = −ln(1 − α) / D, with α
    /// clipped at [`MAX_OPACITY`]. σ is curved where α is straight, so the result
    /// is sampled at `knot_count` ≥ 2 even scalars and linear between them;
    /// renderers are exact for those knots.
    pub fn from_colormap(
        map: Colormap,
        range: (f64, f64),
        unit_distance: f64,
        knot_count: usize,
    ) -> Result<TransferFunction, Error> {
        let ramp = OpacityRamp {
            range,
            ..OpacityRamp::default()
        };
        TransferFunction::from_ramp(map, &ramp, unit_distance, knot_count)
    }

    /// A color map over the ramp's range with the ramp's opacity, as
    /// [`TransferFunction::from_colormap`]; `knot_count` is for opacities from 0 to 1.
    pub fn from_ramp(
        map: Colormap,
        ramp: &OpacityRamp,
        unit_distance: f64,
        knot_count: usize,
    ) -> Result<TransferFunction, Error> {
        if !(unit_distance > 0.0 && unit_distance.is_finite()) {
            return Err(Error::Invalid {
                what: format!("a unit distance of {}", number::exact(unit_distance)),
                help: Some(
                    "give the distance over which an opacity counts, world units, more than 0"
                        .into(),
                ),
            });
        }
        let (low, high) = ramp.range;
        // Halves first: the difference of two huge ends could overflow.
        let part = |from: f64, to: f64| (to * 0.5 - from * 0.5) / (high * 0.5 - low * 0.5);
        let knot = |scalar: f64, position: f64, opacity: f64| Knot {
            scalar,
            color: map.linear_rgb(position),
            extinction: -(-opacity.min(MAX_OPACITY)).ln_1p() / unit_distance,
        };
        if low == high {
            // A constant field: one knot, in the middle of the map.
            return TransferFunction::new(vec![knot(low, 0.5, 0.5)]);
        }
        let last = knot_count.max(2) - 1;
        let mut knots: Vec<Knot> = Vec::new();
        if ramp.clear_below {
            knots.push(Knot::clear(low));
        }
        for (from, to) in ramp.slopes() {
            let (begin, end) = (part(low, from.0), part(low, to.0));
            let steps = (last as f64 * (to.1 - from.1).abs()).ceil().max(1.0) as usize;
            for k in 0..=steps {
                let x = k as f64 / steps as f64;
                let mix = |a: f64, b: f64| a * (1.0 - x) + b * x;
                let next = knot(mix(from.0, to.0), mix(begin, end), mix(from.1, to.1));
                // Where two slopes meet, one knot is enough.
                if knots.last() != Some(&next) {
                    knots.push(next);
                }
            }
        }
        if ramp.clear_above {
            knots.push(Knot::clear(high));
        }
        TransferFunction::new(knots)
    }

    /// The knots, by increasing scalar; two at one scalar are a step.
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// Color and extinction at `scalar`; at a step, the mean of both sides.
    ///
    /// NaN gives `None`: it is transparent.
    pub fn sample(&self, scalar: f64) -> Option<(DVec3, f64)> {
        if scalar.is_nan() {
            return None;
        }
        let below = self.limit(scalar, Side::Below);
        let above = self.limit(scalar, Side::Above);
        Some(((below.0 + above.0) / 2.0, (below.1 + above.1) / 2.0))
    }

    /// Color and extinction at `scalar` as approached from `side`.
    pub fn limit(&self, scalar: f64, side: Side) -> (DVec3, f64) {
        self.intervals
            .get(self.intervals.find(scalar, side))
            .sample(scalar)
    }

    /// The intervals between the knots.
    pub(crate) fn intervals(&self) -> &Intervals {
        &self.intervals
    }

    /// The greatest extinction for scalars in [low, high].
    pub fn max_extinction(&self, low: f64, high: f64) -> f64 {
        self.maximum(low, high, |_, extinction| extinction)
    }

    /// The greatest color component for scalars in [low, high].
    pub fn max_color(&self, low: f64, high: f64) -> f64 {
        self.maximum(low, high, |color, _| color.max_element())
    }

    /// The greatest value of `measure`, convex on each interval, for scalars in [low, high].
    fn maximum(&self, low: f64, high: f64, measure: impl Fn(DVec3, f64) -> f64) -> f64 {
        let inside = self
            .knots
            .iter()
            .filter(|k| k.scalar >= low && k.scalar <= high);
        let at = |(color, extinction)| measure(color, extinction);
        inside
            .map(|k| measure(k.color, k.extinction))
            .fold(at(self.limit(low, Side::Above)), f64::max)
            .max(at(self.limit(high, Side::Below)))
    }

    /// The scalars of the first and last knot.
    pub fn range(&self) -> (f64, f64) {
        (
            self.knots[0].scalar,
            self.knots[self.knots.len() - 1].scalar,
        )
    }
}

/// From which side a scalar is approached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// From smaller scalars.
    Below,
    /// From greater scalars.
    Above,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot(scalar: f64, extinction: f64) -> Knot {
        Knot {
            scalar,
            color: DVec3::splat(extinction),
            extinction,
        }
    }

    #[test]
    fn a_step_has_two_limits() {
        let step = TransferFunction::new(vec![
            knot(0.0, 1.0),
            knot(1.0, 1.0),
            knot(1.0, 3.0),
            knot(2.0, 3.0),
        ])
        .expect("the knots are valid");
        assert_eq!(step.limit(1.0, Side::Below).1, 1.0);
        assert_eq!(step.limit(1.0, Side::Above).1, 3.0);
        assert_eq!(step.sample(1.0).expect("a number").1, 2.0);
        assert_eq!(step.sample(f64::NAN), None);
        assert_eq!(step.sample(-9.0).expect("a number").1, 1.0);
        assert_eq!(step.sample(9.0).expect("a number").1, 3.0);
    }

    #[test]
    fn the_maximum_includes_knots_inside() {
        let tent = TransferFunction::new(vec![knot(0.0, 0.0), knot(1.0, 5.0), knot(2.0, 0.0)])
            .expect("the knots are valid");
        assert_eq!(tent.max_extinction(0.5, 1.5), 5.0);
        assert_eq!(tent.max_extinction(1.5, 2.5), 2.5);
        assert_eq!(tent.max_extinction(2.0, 3.0), 0.0);
        assert_eq!(tent.max_color(-1.0, 0.5), 2.5);
    }

    #[test]
    fn wrong_knots_are_refused_with_their_number() {
        let refused = [
            vec![],
            vec![knot(1.0, 0.0), knot(0.0, 0.0)],
            vec![knot(0.0, -1.0)],
            vec![knot(f64::NAN, 0.0)],
            vec![knot(0.0, 1.0), knot(0.0, 2.0), knot(0.0, 3.0)],
        ];
        for knots in refused {
            assert!(TransferFunction::new(knots).is_err());
        }
        let error =
            TransferFunction::new(vec![knot(0.0, 0.0), knot(1.0, -2.0)]).expect_err("negative");
        assert!(error.to_string().contains("knot 1"), "{error}");
    }

    // α over one unit distance at constant scalar s is 1 − e^(−σ D) = s.
    #[test]
    fn colormap_opacity_is_per_unit_distance() {
        let tf = TransferFunction::from_colormap(Colormap::Viridis, (0.0, 1.0), 0.25, 33)
            .expect("valid");
        for k in tf.knots() {
            let alpha = -(-k.extinction * 0.25).exp_m1();
            assert!((alpha - k.scalar.min(MAX_OPACITY)).abs() < 1e-14);
        }
    }

    // Opacity over one unit distance is |s − background| over the farther end's distance.
    #[test]
    fn opacity_grows_away_from_the_background_on_both_sides() {
        let ramp = OpacityRamp {
            range: (-1.0, 4.0),
            background: Some((0.0, 0.5)),
            ..OpacityRamp::default()
        };
        let tf = TransferFunction::from_ramp(Colormap::Viridis, &ramp, 0.25, 33).expect("valid");
        let opacity = |scalar: f64| {
            let (_, extinction) = tf.sample(scalar).expect("a number");
            -(-extinction * 0.25).exp_m1()
        };
        for k in tf.knots() {
            let distance = (-k.scalar).max(k.scalar - 0.5).max(0.0);
            let expected = (distance / 3.5).min(MAX_OPACITY);
            assert!((opacity(k.scalar) - expected).abs() < 1e-14, "{}", k.scalar);
            let own = ramp.opacity(k.scalar).min(MAX_OPACITY);
            assert!((own - expected).abs() < 1e-14, "{}", k.scalar);
            let position = (k.scalar + 1.0) / 5.0;
            let error = k.color - Colormap::Viridis.linear_rgb(position);
            assert!(error.abs().max_element() < 1e-12, "{}", k.scalar);
        }
        assert_eq!([0.0, 0.2, 0.5].map(opacity), [0.0; 3]);
        assert_eq!(tf.range(), (-1.0, 4.0));
    }

    #[test]
    fn what_lies_beyond_the_range_may_be_clear() {
        let ramp = OpacityRamp {
            range: (0.0, 1.0),
            clear_above: true,
            background: Some((0.5, 0.5)),
            clear_below: true,
        };
        let tf = TransferFunction::from_ramp(Colormap::Viridis, &ramp, 1.0, 33).expect("valid");
        for beyond in [-1e9, -1e-9, 1.0 + 1e-9, 1e36] {
            assert_eq!(tf.sample(beyond), Some((DVec3::ZERO, 0.0)), "{beyond}");
        }
        for inside in [1e-9, 1.0 - 1e-9] {
            assert!(tf.sample(inside).expect("a number").1 > 5.0, "{inside}");
        }
    }

    #[test]
    fn a_constant_field_gets_one_knot() {
        let tf =
            TransferFunction::from_colormap(Colormap::Viridis, (2.0, 2.0), 1.0, 33).expect("valid");
        assert_eq!(tf.knots().len(), 1);
    }
}
