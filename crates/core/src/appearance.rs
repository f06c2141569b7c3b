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

use crate::{Error, TransferFunction};

/// How scalars become light.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Color and extinction of each scalar; [`OpticalModel::Isosurfaces`] does not use it.
    pub transfer_function: TransferFunction,
    /// Which terms of the volume rendering integral are kept.
    pub optical_model: OpticalModel,
    /// What [`OpticalModel::Isosurfaces`] draws, in any order; other models do not use them.
    pub isosurfaces: Vec<Isosurface>,
    /// What isosurfaces are lit by.
    pub lighting: Lighting,
    /// Whether light fades with depth.
    pub depth_cue: Option<DepthCue>,
    /// What lies behind any of these is cut away; at most [`MAX_CLIP_PLANES`].
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
}

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

    /// Refuses an appearance that is not valid, or that `renderer` does not draw.
    pub fn check(&self, renderer: &'static str, appearance: &Appearance) -> Result<(), Error> {
        appearance.validate()?;
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
                reason: "it does not draw them; `tetrascope algorithms` lists who does".into(),
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
    /// Ertl 2002, §5.1, keep "the maximum of the transfer function".)
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

    /// The name in scene files and on the command line.
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
