//! The appearance of a scene, as written.

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::Colormap;
use tetrascope_core::glam::DVec3;
use tetrascope_core::transfer_function::OpacityRamp;
use tetrascope_core::{
    Appearance, ClipPlane, DepthCue, DirectionalLight, Error, Isosurface, Knot, Lighting,
    OpticalModel, TransferFunction, number,
};

use crate::defaults::{default_isovalue, default_ramp, unit_distance_of};
use crate::subject::Subject;

/// Knots in a transfer function made from a color map: between them the sampled
/// extinction −ln(1 − α)/D is within 2 % of its curve up to α = 0.95.
pub(crate) const COLORMAP_KNOTS: usize = 33;

/// Appearance as written: `transfer_function`, or a color map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AppearanceSpec {
    /// Emission-absorption unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optical_model: Option<OpticalModel>,
    /// Viridis unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub colormap: Option<Colormap>,
    /// The color map's scalars, over which opacity rises linearly from 0 to 1. Unless
    /// given, both are chosen by the field's values: without outliers and marks for "no
    /// value", and clear where most of the volume has one value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// The distance over which the color map's opacity counts, world units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_distance: Option<f64>,
    /// How much light the farthest point loses, 0 to 1; no depth cue unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub depth_cue: Option<f64>,
    /// Share of a surface's color that shows without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ambient: Option<f64>,
    /// Knots by increasing scalar; excludes `colormap`, `range` and `unit_distance`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<Vec<Knot>>,
    /// For the model `isosurfaces`: the middle of the range unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub isosurfaces: Option<Vec<IsosurfaceSpec>>,
    /// Lights on surfaces; one at the eye unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<DirectionalLight>>,
    /// Planes behind which everything is cut away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip_planes: Option<Vec<ClipPlane>>,
}

/// An isosurface as written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IsosurfaceSpec {
    /// In the field's own units.
    pub value: f64,
    /// Linear RGB; the transfer function's at `value` unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<DVec3>,
}

impl AppearanceSpec {
    /// The optical model, emission and absorption unless another is written.
    pub(crate) fn model(&self) -> OpticalModel {
        self.optical_model
            .unwrap_or(OpticalModel::EmissionAbsorption)
    }

    /// Whether nothing is left out that is chosen from the volume.
    pub(crate) fn is_complete(&self) -> bool {
        let scaled = self.range.is_some() && self.unit_distance.is_some();
        (self.transfer_function.is_some() || scaled) && !self.needs_values()
    }

    /// Whether something is left out that is chosen from how the values are spread.
    pub(crate) fn needs_values(&self) -> bool {
        let no_surface = self.model() == OpticalModel::Isosurfaces && self.isosurfaces.is_none();
        match self.transfer_function {
            Some(_) => no_surface,
            None => self.range.is_none(),
        }
    }

    /// The appearance of `volume` for a camera that looks along the unit vector `forward`;
    /// adds what was chosen to `defaults`.
    pub(crate) fn resolve(
        &self,
        volume: &dyn Subject,
        forward: DVec3,
        defaults: &mut Vec<String>,
    ) -> Result<Appearance, Error> {
        let (transfer_function, ramp) = self.transfer_function(volume, forward, defaults)?;
        let isovalue = || match ramp {
            Some(ramp) => Ok(ramp),
            None => default_ramp(volume, forward).map(|suggestion| suggestion.ramp),
        };
        let isovalue = || isovalue().map(|ramp| default_isovalue(&ramp));
        let isosurfaces = self.isosurfaces(isovalue, &transfer_function, defaults)?;
        let appearance = Appearance {
            transfer_function,
            optical_model: self.model(),
            isosurfaces,
            lighting: Lighting {
                ambient: self.ambient.unwrap_or(Lighting::default().ambient),
                lights: self.lights.clone().unwrap_or_default(),
            },
            depth_cue: self.depth_cue.map(|strength| DepthCue { strength }),
            clip_planes: self.clip_planes.clone().unwrap_or_default(),
        };
        appearance.validate_in(&volume.bounds())?;
        Ok(appearance)
    }

    /// The transfer function and, if a color map made it, the ramp of its opacity.
    fn transfer_function(
        &self,
        volume: &dyn Subject,
        forward: DVec3,
        defaults: &mut Vec<String>,
    ) -> Result<(TransferFunction, Option<OpacityRamp>), Error> {
        if let Some(knots) = &self.transfer_function {
            if self.colormap.is_some() || self.range.is_some() || self.unit_distance.is_some() {
                return Err(Error::Scene {
                    at: "[appearance]".into(),
                    what: "transfer_function excludes colormap, range and unit_distance".into(),
                    help: Some("keep one of the two ways".into()),
                });
            }
            return Ok((TransferFunction::new(knots.clone())?, None));
        }
        let map = self.colormap.unwrap_or_else(|| {
            defaults.push("colormap: viridis".into());
            Colormap::Viridis
        });
        let mut longest_unit = f64::INFINITY;
        let ramp = match self.range {
            Some([low, high]) if low <= high => OpacityRamp {
                range: (low, high),
                ..OpacityRamp::default()
            },
            Some([low, high]) => {
                let [low, high] = [low, high].map(number::exact);
                return Err(Error::Scene {
                    at: "[appearance]".into(),
                    what: format!("range [{low}, {high}] is reversed"),
                    help: Some(format!("write [{high}, {low}]")),
                });
            }
            None => {
                let suggestion = default_ramp(volume, forward)?;
                defaults.extend(suggestion.lines);
                longest_unit = suggestion.longest_unit;
                suggestion.ramp
            }
        };
        let unit_distance = self.unit_distance.unwrap_or_else(|| {
            let (mut distance, mut why) = unit_distance_of(volume, self.model(), forward);
            if longest_unit < distance && longest_unit > 0.0 {
                distance = longest_unit;
                why = "as nearly all of the volume is clear";
            }
            // Surfaces are drawn without it.
            if self.model() != OpticalModel::Isosurfaces {
                let rounded = number::rounded(distance);
                defaults.push(format!("unit distance: {rounded}, {why}"));
            }
            distance
        });
        let function = TransferFunction::from_ramp(map, &ramp, unit_distance, COLORMAP_KNOTS)?;
        Ok((function, Some(ramp)))
    }

    /// The isosurfaces that are written, each with a color; for the model `isosurfaces` at
    /// least one, at `default_value`.
    fn isosurfaces(
        &self,
        default_value: impl FnOnce() -> Result<f64, Error>,
        transfer_function: &TransferFunction,
        defaults: &mut Vec<String>,
    ) -> Result<Vec<Isosurface>, Error> {
        let written = match &self.isosurfaces {
            Some(written) => written.clone(),
            None if self.model() != OpticalModel::Isosurfaces => Vec::new(),
            None => {
                let value = default_value()?;
                defaults.push(format!(
                    "isosurface: {}, in the middle of the values to tell apart",
                    number::exact(value)
                ));
                vec![IsosurfaceSpec { value, color: None }]
            }
        };
        let complete = |written: IsosurfaceSpec| {
            let IsosurfaceSpec { value, color } = written;
            let mapped = || transfer_function.sample(value).map(|(color, _)| color);
            Isosurface {
                value,
                color: color.or_else(mapped).unwrap_or(DVec3::ONE),
            }
        };
        Ok(written.into_iter().map(complete).collect())
    }

    /// The appearance with nothing left out.
    pub(crate) fn of(appearance: &Appearance) -> AppearanceSpec {
        let Appearance {
            transfer_function,
            optical_model,
            isosurfaces,
            lighting,
            depth_cue,
            clip_planes,
        } = appearance;
        let surface = |surface: &Isosurface| IsosurfaceSpec {
            value: surface.value,
            color: Some(surface.color),
        };
        let surfaces: Vec<_> = isosurfaces.iter().map(surface).collect();
        let is_lit = *optical_model == OpticalModel::Isosurfaces;
        AppearanceSpec {
            optical_model: Some(*optical_model),
            depth_cue: depth_cue.map(|cue| cue.strength),
            ambient: is_lit.then_some(lighting.ambient),
            transfer_function: Some(transfer_function.knots().to_vec()),
            isosurfaces: unless_empty(&surfaces),
            lights: unless_empty(&lighting.lights),
            clip_planes: unless_empty(clip_planes),
            ..AppearanceSpec::default()
        }
    }
}

fn unless_empty<T: Clone>(list: &[T]) -> Option<Vec<T>> {
    (!list.is_empty()).then(|| list.to_vec())
}
