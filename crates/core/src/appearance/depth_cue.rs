//! Depth cue: what is farther away is darker.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Bounds, Error};

/// Light fades linearly with depth through the volume ("intensity depth-cueing", Weiler,
/// Kraus, Ertl 2002, figure 11).
///
/// Color emitted at the depth z, the distance from the eye along the view
/// direction, is multiplied by 1 − strength (z − z₀)/(z₁ − z₀), where [z₀, z₁] are the
/// depths of the volume's bounding box before the eye. Opacity and background
/// keep theirs; a model without light, `Absorption`, shows no cue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DepthCue {
    /// How much light the farthest point loses, in [0, 1].
    pub strength: f64,
}

/// A [`DepthCue`] for one camera and volume: the factor `at_eye` + `slope` z of light at depth z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CueRamp {
    /// The factor at depth 0, if the ramp went on to there.
    pub at_eye: f64,
    /// Per world unit of depth; 0 or less.
    pub slope: f64,
}

impl DepthCue {
    /// Refuses a strength outside of [0, 1].
    pub fn validate(&self) -> Result<(), Error> {
        if (0.0..=1.0).contains(&self.strength) {
            return Ok(());
        }
        Err(Error::Invalid {
            what: format!("a depth cue of strength {}", self.strength),
            help: Some("give 0 (none) to 1 (the farthest point is black)".into()),
        })
    }

    /// The ramp over a volume in `bounds`, seen from `eye` along the unit vector `forward`.
    pub fn ramp(&self, eye: DVec3, forward: DVec3, bounds: &Bounds) -> CueRamp {
        let depth = |corner| forward.dot(corner - eye);
        let depths = bounds.corners().map(depth);
        let near = depths.iter().copied().fold(f64::INFINITY, f64::min);
        let far = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let near = near.max(0.0);
        if far > near && (far - near).is_finite() {
            let slope = -self.strength / (far - near);
            CueRamp {
                at_eye: 1.0 - slope * near,
                slope,
            }
        } else {
            CueRamp::NONE
        }
    }
}

impl CueRamp {
    /// Light keeps all of itself.
    pub const NONE: CueRamp = CueRamp {
        at_eye: 1.0,
        slope: 0.0,
    };

    /// The factor at depth `z`, world units; inside the volume it is in [1 − strength, 1]
    /// to rounding, and outside it is held there.
    pub fn at(&self, z: f64) -> f64 {
        (self.at_eye + self.slope * z).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_spans_the_box_before_the_eye() {
        let bounds = Bounds {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        };
        let cue = DepthCue { strength: 0.75 };
        let ramp = cue.ramp(DVec3::new(0.0, 0.0, 5.0), DVec3::NEG_Z, &bounds);
        assert!((ramp.at(4.0) - 1.0).abs() < 1e-15);
        assert!((ramp.at(5.0) - 0.625).abs() < 1e-15);
        assert!((ramp.at(6.0) - 0.25).abs() < 1e-15);
        // From inside, it begins at the eye.
        let ramp = cue.ramp(DVec3::ZERO, DVec3::NEG_Z, &bounds);
        assert!((ramp.at(0.0) - 1.0).abs() < 1e-15);
        assert!((ramp.at(1.0) - 0.25).abs() < 1e-15);
    }

    #[test]
    fn strengths_out_of_range_are_refused() {
        for strength in [-0.1, 1.1, f64::NAN] {
            assert!(DepthCue { strength }.validate().is_err());
        }
    }
}
