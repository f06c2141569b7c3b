//! Directional lights on surfaces.

use crate::Unit as _;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::Error;

/// Light from infinitely far away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DirectionalLight {
    /// From the scene to the light, of any length, world space.
    pub toward: DVec3,
    /// Linear RGB, 0 or more.
    pub color: DVec3,
}

/// Ambient light and any number of directional lights.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Share of a surface's color that shows without light, 0 or more.
    pub ambient: f64,
    /// Without any, a white light of [`Lighting::HEADLIGHT`] shines along the view direction.
    pub lights: Vec<DirectionalLight>,
}

impl Default for Lighting {
    fn default() -> Self {
        Lighting {
            ambient: 0.2,
            lights: Vec::new(),
        }
    }
}

impl Lighting {
    /// The strength of the light that shines where there is no other: with the
    /// default ambient light, a surface seen face-on has its own color.
    pub const HEADLIGHT: f64 = 0.8;

    /// The most lights: each costs every pixel a pass of a loop.
    pub const MOST_LIGHTS: usize = 256;

    /// All light that could meet a surface at once, in its greatest channel.
    pub(super) fn brightest(&self) -> f64 {
        let lights: f64 = match self.lights.is_empty() {
            true => Self::HEADLIGHT,
            false => self.lights.iter().map(|l| l.color.max_element()).sum(),
        };
        self.ambient + lights
    }

    /// Refuses lights without a direction, invalid colors, and too many lights.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String, help: &str| {
            Err(Error::Invalid {
                what,
                help: Some(help.into()),
            })
        };
        if !(self.ambient.is_finite() && self.ambient >= 0.0) {
            let what = format!("ambient light of {}", self.ambient);
            return wrong(what, "give 0 or more; 0.2 is usual");
        }
        if self.lights.len() > Lighting::MOST_LIGHTS {
            let help = format!("give at most {}", Lighting::MOST_LIGHTS);
            return wrong(format!("{} lights", self.lights.len()), &help);
        }
        for light in &self.lights {
            let length = light.toward.length();
            if !(length.is_finite() && length > 0.0) {
                let what = format!("a light toward {}", light.toward);
                return wrong(what, "give a finite direction that is not zero");
            }
            if !(light.color.is_finite() && light.color.min_element() >= 0.0) {
                let what = format!("a light of color {}", light.color);
                return wrong(what, "colors are linear RGB, 0 or more");
            }
        }
        Ok(())
    }

    /// The lights of a frame whose camera looks along `forward`, with unit directions.
    pub fn resolved(&self, forward: DVec3) -> Vec<DirectionalLight> {
        if self.lights.is_empty() {
            return vec![DirectionalLight {
                toward: -forward,
                color: DVec3::splat(Self::HEADLIGHT),
            }];
        }
        let unit = |light: &DirectionalLight| DirectionalLight {
            toward: light.toward.unit(),
            ..*light
        };
        self.lights.iter().map(unit).collect()
    }

    /// The light that a surface of `color` sends to the eye: color (ambient + Σ light max(0, n · l)),
    /// linear RGB (Lambert).
    ///
    /// `lights` are [`Lighting::resolved`]; `gradient` is normal to the surface, on
    /// either side and of any length: surfaces have two sides, and the one that the
    /// ray along `direction` meets is lit. Without a gradient only ambient light counts.
    pub fn shade(
        &self,
        lights: &[DirectionalLight],
        color: DVec3,
        gradient: DVec3,
        direction: DVec3,
    ) -> DVec3 {
        // Scaled first: the square of a huge or tiny gradient would over- or underflow.
        let largest = gradient.abs().max_element();
        let mut normal = DVec3::ZERO;
        if largest > 0.0 && largest.is_finite() {
            normal = (gradient / largest).unit();
            if normal.dot(direction) > 0.0 {
                normal = -normal;
            }
        }
        let lit = |light: &DirectionalLight| light.color * normal.dot(light.toward).max(0.0);
        color * (DVec3::splat(self.ambient) + lights.iter().map(lit).sum::<DVec3>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_seen_face_on_has_its_color_by_default() {
        let lighting = Lighting::default();
        let lights = lighting.resolved(DVec3::NEG_Z);
        let color = DVec3::new(0.2, 0.5, 1.0);
        for gradient in [DVec3::Z, DVec3::NEG_Z, 1e-200 * DVec3::Z, 1e200 * DVec3::Z] {
            let shaded = lighting.shade(&lights, color, gradient, DVec3::NEG_Z);
            assert!((shaded - color).length() < 1e-15, "{gradient}");
        }
    }

    #[test]
    fn lights_add_up_and_those_behind_do_not_count() {
        let light = |toward, color| DirectionalLight { toward, color };
        let lighting = Lighting {
            ambient: 0.1,
            lights: vec![
                light(3.0 * DVec3::Z, DVec3::X),
                light(DVec3::new(0.0, 3.0, 4.0), DVec3::Y),
                light(DVec3::NEG_Z, DVec3::ONE),
            ],
        };
        let lights = lighting.resolved(DVec3::X);
        let shaded = lighting.shade(&lights, DVec3::ONE, DVec3::NEG_Z, DVec3::NEG_Z);
        assert!((shaded - DVec3::new(1.1, 0.9, 0.1)).length() < 1e-15);
        let flat = lighting.shade(&lights, DVec3::ONE, DVec3::ZERO, DVec3::NEG_Z);
        assert_eq!(flat, DVec3::splat(0.1));
    }

    #[test]
    fn lights_that_are_none_are_refused() {
        let with = |toward, color| Lighting {
            ambient: 0.0,
            lights: vec![DirectionalLight { toward, color }],
        };
        assert!(with(DVec3::X, DVec3::ONE).validate().is_ok());
        assert!(with(DVec3::ZERO, DVec3::ONE).validate().is_err());
        assert!(with(DVec3::X, DVec3::NEG_ONE).validate().is_err());
        let dark = Lighting {
            ambient: f64::NAN,
            lights: Vec::new(),
        };
        assert!(dark.validate().is_err());
    }
}
