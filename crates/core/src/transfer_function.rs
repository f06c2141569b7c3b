//! Color and extinction as piecewise-linear functions of the scalar.

mod intervals;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Error;
use crate::appearance::BRIGHTEST;
use crate::colormap::Colormap;
pub(crate) use intervals::{Interval, Intervals};

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
                let what = format!("has the negative extinction {}", knot.extinction);
                return wrong(i, what, "extinction is 0 (clear) or more, per world unit");
            }
            if knot.color.min_element() < 0.0 {
                let what = format!("has the negative color {}", knot.color);
                return wrong(i, what, "colors are linear RGB, 0 or more");
            }
            if knot.color.max_element() > BRIGHTEST {
                let what = format!("has a color of {:e}", knot.color.max_element());
                return wrong(i, what, "a picture holds colors up to 8e37; 1 is white");
            }
            if i > 0 && knot.scalar < knots[i - 1].scalar {
                let what = format!("at {} comes after {}", knot.scalar, knots[i - 1].scalar);
                return wrong(i, what, "sort the knots by scalar");
            }
            if i > 1 && knot.scalar == knots[i - 2].scalar {
                let what = format!("is the third at {}", knot.scalar);
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
        if !(unit_distance > 0.0 && unit_distance.is_finite()) {
            return Err(Error::Invalid {
                what: format!("a unit distance of {unit_distance}"),
                help: Some(
                    "give the distance over which an opacity counts, world units, more than 0"
                        .into(),
                ),
            });
        }
        let last = knot_count.max(2) - 1;
        let knots = (0..=last).map(|k| {
            let x = k as f64 / last as f64;
            Knot {
                scalar: range.0 * (1.0 - x) + range.1 * x,
                color: map.linear_rgb(x),
                extinction: -(-x.min(MAX_OPACITY)).ln_1p() / unit_distance,
            }
        });
        if range.0 == range.1 {
            // A constant field: one knot, in the middle of the map.
            let middle = knots.skip(last / 2).take(1).collect();
            return TransferFunction::new(middle);
        }
        TransferFunction::new(knots.collect())
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

    #[test]
    fn a_constant_field_gets_one_knot() {
        let tf =
            TransferFunction::from_colormap(Colormap::Viridis, (2.0, 2.0), 1.0, 33).expect("valid");
        assert_eq!(tf.knots().len(), 1);
    }
}
