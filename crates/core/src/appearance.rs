//! How a volume looks: everything that changes without touching geometry.

use serde::{Deserialize, Serialize};

use crate::TransferFunction;

/// How scalars become light.
#[derive(Clone, Debug, PartialEq)]
pub struct Appearance {
    /// Color and extinction of each scalar.
    pub transfer_function: TransferFunction,
    /// Which terms of the volume rendering integral are kept.
    pub optical_model: OpticalModel,
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
}

impl OpticalModel {
    /// Every model.
    pub const ALL: [OpticalModel; 4] = [
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
