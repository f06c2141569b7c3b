//! How a volume looks: everything that changes without touching geometry.

mod clip;
mod depth_cue;
mod lighting;
mod surface;

use serde::{Deserialize, Serialize};

pub use clip::{ClipPlane, MAX_CLIP_PLANES, clip_ray};
pub use depth_cue::{CueRamp, DepthCue};
pub use lighting::{DirectionalLight, Lighting};
pub use surface::{Isosurface, nearest_crossing};

use crate::{Bounds, Error, TransferFunction};

/// How scalars become light.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Color and extinction of each scalar; [`OpticalModel::Isosurfaces`] does not use it.
    pub transfer_function: TransferFunction,
    /// Which terms of the volume rendering integral are kept.
    pub optical_model: OpticalModel,
    /// The surfaces of [`OpticalModel::Isosurfaces`], in any order; other models do not use them.
    pub isosurfaces: Vec<Isosurface>,
    /// The light on isosurfaces.
    pub lighting: Lighting,
    /// Whether light fades with depth.
    pub depth_cue: Option<DepthCue>,
    /// Planes behind which everything is cut away; at most [`MAX_CLIP_PLANES`].
    pub clip_planes: Vec<ClipPlane>,
}

impl Appearance {
    /// An appearance without isosurfaces, depth cue and clip planes.
    pub fn new(transfer_function: TransferFunction, optical_model: OpticalModel) -> Appearance {
        Appearance {
            transfer_function,
            optical_model,
            isosurfaces: Vec::new(),
            lighting: Lighting::default(),
            depth_cue: None,
            clip_planes: Vec::new(),
        }
    }

    /// Refuses numbers out of range; every renderer calls it first.
    pub fn validate(&self) -> Result<(), Error> {
        for surface in &self.isosurfaces {
            surface.validate()?;
        }
        self.lighting.validate()?;
        let brightest = self.isosurfaces.iter().map(|s| s.color.max_element());
        let brightest = brightest.fold(0.0, f64::max) * self.lighting.brightest();
        if brightest > BRIGHTEST {
            return Err(Error::Invalid {
                what: format!("isosurfaces lit as brightly as {brightest:e}"),
                help: Some(format!(
                    "a picture holds colors up to {BRIGHTEST:e}; 1 is white"
                )),
            });
        }
        if let Some(cue) = self.depth_cue {
            cue.validate()?;
        }
        if self.clip_planes.len() > MAX_CLIP_PLANES {
            return Err(Error::Invalid {
                what: format!("{} clip planes", self.clip_planes.len()),
                help: Some(format!("give at most {MAX_CLIP_PLANES}")),
            });
        }
        self.clip_planes.iter().try_for_each(ClipPlane::validate)
    }

    /// Refuses what [`Appearance::validate`] refuses, and an appearance whose picture of a
    /// volume in `bounds` would not fit 32-bit floats.
    ///
    /// No ray is longer in there than the diagonal d, so optical depths are at most σ d, and
    /// the model `Emission`, which nothing dims, sends at most c σ d.
    pub fn validate_in(&self, bounds: &Bounds) -> Result<(), Error> {
        self.validate()?;
        let tf = &self.transfer_function;
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        let depth = match self.optical_model {
            OpticalModel::MaximumIntensity | OpticalModel::Isosurfaces => 0.0,
            _ => tf.max_extinction(all.0, all.1) * bounds.diagonal(),
        };
        let light = match self.optical_model {
            OpticalModel::Emission => depth * tf.max_color(all.0, all.1),
            _ => 0.0,
        };
        if depth <= BRIGHTEST && light <= BRIGHTEST {
            return Ok(());
        }
        let what = match depth <= BRIGHTEST {
            true => format!("a picture as bright as {light:e}"),
            false => format!("an optical depth of up to {depth:e}"),
        };
        Err(Error::Invalid {
            what: format!("{what}, beyond 32-bit floats"),
            help: Some(
                "lower extinctions and colors, or count opacity over a longer unit distance".into(),
            ),
        })
    }
}

/// The greatest color that is drawn: pictures are of 32-bit floats, and sums of two such
/// colors and what rounding adds to them still fit.
pub const BRIGHTEST: f64 = f32::MAX as f64 / 4.0;

/// Which parts of an [`Appearance`] a renderer draws, beyond the volumetric models.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Abilities {
    /// [`OpticalModel::Isosurfaces`].
    pub isosurfaces: bool,
    /// [`Appearance::depth_cue`].
    pub depth_cue: bool,
    /// [`Appearance::clip_planes`].
    pub clip_planes: bool,
}

impl Abilities {
    /// All there are.
    pub const ALL: Abilities = Abilities {
        isosurfaces: true,
        depth_cue: true,
        clip_planes: true,
    };

    /// Refuses an appearance that is not valid for a volume in `bounds`
    /// ([`Appearance::validate_in`]), or that `renderer` does not draw.
    pub fn check(
        &self,
        renderer: &'static str,
        appearance: &Appearance,
        bounds: &Bounds,
    ) -> Result<(), Error> {
        appearance.validate_in(bounds)?;
        let wanted = [
            (
                "isosurfaces",
                appearance.optical_model == OpticalModel::Isosurfaces && !self.isosurfaces,
            ),
            (
                "a depth cue",
                appearance.depth_cue.is_some() && !self.depth_cue,
            ),
            (
                "clip planes",
                !appearance.clip_planes.is_empty() && !self.clip_planes,
            ),
        ];
        match wanted.into_iter().find(|(_, missing)| *missing) {
            None => Ok(()),
            Some((what, _)) => Err(Error::Unsupported {
                renderer,
                what: what.into(),
                reason: "it does not draw them".into(),
            }),
        }
    }
}

/// Which terms of the volume rendering integral are kept (Max 1995).
///
/// All are in terms of the transfer function's color c, linear RGB, and
/// extinction σ, per world unit; B is the background, premultiplied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum OpticalModel {
    /// Glowing particles that hide each other: ∫ c σ T dt + T B.
    EmissionAbsorption,
    /// Glow alone: ∫ c σ dt + B. Nothing hides anything, so cell order is free.
    Emission,
    /// Black smoke: T B, the optical depth's shadow. Cell order is free.
    Absorption,
    /// The greatest c on the ray and of B, channel by channel; σ plays no part,
    /// so what should not show is black. Cell order is free. (Weiler, Kraus,
    /// Ertl 2002, §5.1, keep "the maximum of the transfer function".) A layer of
    /// cells without thickness counts as thin layers do, here and below.
    MaximumIntensity,
    /// The nearest of [`Appearance::isosurfaces`], opaque, shaded by
    /// [`Appearance::lighting`] and the field's gradient in the cell
    /// ([`Isosurface`]); B where the ray meets none. The depth buffer
    /// hides, so cell order is free.
    Isosurfaces,
}

impl OpticalModel {
    /// Every model.
    pub const ALL: [OpticalModel; 5] = [
        OpticalModel::EmissionAbsorption,
        OpticalModel::Emission,
        OpticalModel::Absorption,
        OpticalModel::MaximumIntensity,
        OpticalModel::Isosurfaces,
    ];

    /// The models that use the transfer function: all but [`OpticalModel::Isosurfaces`].
    pub const VOLUMETRIC: [OpticalModel; 4] = [
        OpticalModel::EmissionAbsorption,
        OpticalModel::Emission,
        OpticalModel::Absorption,
        OpticalModel::MaximumIntensity,
    ];

    /// The name that people write.
    pub fn name(self) -> &'static str {
        match self {
            OpticalModel::EmissionAbsorption => "emission-absorption",
            OpticalModel::Emission => "emission",
            OpticalModel::Absorption => "absorption",
            OpticalModel::MaximumIntensity => "maximum-intensity",
            OpticalModel::Isosurfaces => "isosurfaces",
        }
    }

    /// Whether cells may be drawn in any order.
    pub fn commutes(self) -> bool {
        self != OpticalModel::EmissionAbsorption
    }

    /// Whether the model only adds light, so that it needs an opaque background to show.
    pub fn only_adds_light(self) -> bool {
        matches!(
            self,
            OpticalModel::Emission | OpticalModel::MaximumIntensity
        )
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::Knot;

    fn with(model: OpticalModel, color: f64, extinction: f64) -> Result<(), Error> {
        let knots = vec![Knot {
            scalar: 0.0,
            color: DVec3::splat(color),
            extinction,
        }];
        let bounds = Bounds {
            min: DVec3::ZERO,
            max: DVec3::X * 10.0,
        };
        Appearance::new(TransferFunction::new(knots)?, model).validate_in(&bounds)
    }

    // Each was drawn as infinity: a color, an optical depth, and the light of both.
    #[test]
    fn what_does_not_fit_the_picture_is_refused() {
        let (absorbing, glowing) = (OpticalModel::EmissionAbsorption, OpticalModel::Emission);
        for model in [absorbing, glowing] {
            assert!(with(model, 1.0, 1e9).is_ok());
            assert!(with(model, 1e39, 1.0).is_err());
            let error = with(model, 1.0, 1e38).expect_err("1e39 over the diagonal");
            assert!(error.to_string().contains("1e39"), "{error}");
        }
        assert!(with(glowing, 1e20, 1e20).is_err());
        assert!(with(absorbing, 1e20, 1e20).is_ok(), "it hides itself");
        assert!(
            with(OpticalModel::MaximumIntensity, 1.0, 1e300).is_ok(),
            "σ plays no part"
        );
    }

    #[test]
    fn surfaces_too_bright_for_the_picture_are_refused() {
        let tf = TransferFunction::new(vec![Knot {
            scalar: 0.0,
            color: DVec3::ONE,
            extinction: 1.0,
        }]);
        let mut appearance = Appearance::new(tf.expect("valid"), OpticalModel::Isosurfaces);
        appearance.isosurfaces.push(Isosurface {
            value: 0.0,
            color: DVec3::splat(1e30),
        });
        assert!(appearance.validate().is_ok());
        appearance.lighting.lights.push(DirectionalLight {
            toward: DVec3::X,
            color: DVec3::splat(1e10),
        });
        let error = appearance.validate().expect_err("1e40");
        assert!(error.to_string().contains("e40"), "{error}");
    }
}
