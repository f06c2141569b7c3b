//! The volume rendering integral over one segment, and its composition.
//!
//! Every table and every shader is tested against this module. Sources: N. Max,
//! "Optical Models for Direct Volume Rendering", 1995; P. Williams, N. Max,
//! C. Stein, "A High Accuracy Volume Renderer for Unstructured Data", 1998;
//! K. Moreland, E. Angel, "A Fast High Accuracy Volume Renderer for
//! Unstructured Data", 2004.

use glam::DVec3;

use crate::{OpticalModel, TransferFunction};

/// A piece of a ray on which the scalar varies linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The scalar at the end nearer to the eye.
    pub front: f64,
    /// The scalar at the farther end.
    pub back: f64,
    /// World units, 0 or more.
    pub length: f64,
}

/// How much of the front and back color a segment with linear extinction sends to the eye.
///
/// With a = σ_front l and b = σ_back l, the radiance of a segment whose color
/// goes linearly from c_f to c_b is c_f w_f + c_b w_b, where
/// w_f = ∫ (1−s)(a + (b−a)s) T ds, w_b = ∫ s (a + (b−a)s) T ds and
/// T(s) = exp(−(a s + (b−a) s²/2)), s from 0 to 1. w_f + w_b = 1 − e^(−(a+b)/2).
///
/// `a` and `b` are dimensionless, finite and 0 or more. Relative error ≤ 1e-12.
pub fn segment_weights(a: f64, b: f64) -> (f64, f64) {
    let _ = (a, b);
    unimplemented!("written next")
}

/// What a ray has gathered, front to back.
#[derive(Clone, Debug)]
pub struct RayIntegral<'a> {
    transfer_function: &'a TransferFunction,
    model: OpticalModel,
    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`.
    light: DVec3,
    /// ∫ σ dt.
    optical_depth: CompensatedSum,
}

impl<'a> RayIntegral<'a> {
    /// A ray that has met nothing.
    pub fn new(transfer_function: &'a TransferFunction, model: OpticalModel) -> Self {
        RayIntegral {
            transfer_function,
            model,
            light: DVec3::ZERO,
            optical_depth: CompensatedSum::default(),
        }
    }

    /// Adds the next segment, behind all that were added before.
    ///
    /// A segment with a NaN scalar is transparent.
    pub fn add(&mut self, segment: &Segment) {
        let _ = (segment, self.transfer_function);
        unimplemented!("written next")
    }

    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`, linear RGB.
    pub fn light(&self) -> DVec3 {
        self.light
    }

    /// ∫ σ dt, dimensionless; 0 where the model does not absorb.
    pub fn optical_depth(&self) -> f64 {
        self.optical_depth.value()
    }

    /// The pixel: premultiplied linear RGBA over a premultiplied `background`.
    pub fn over(&self, background: [f64; 4]) -> [f64; 4] {
        over(self.model, self.light, self.optical_depth(), background)
    }
}

/// The pixel that `light` seen through `optical_depth` makes before a
/// premultiplied `background`; see [`OpticalModel`].
pub fn over(
    model: OpticalModel,
    light: DVec3,
    optical_depth: f64,
    background: [f64; 4],
) -> [f64; 4] {
    let [r, g, b, alpha] = background;
    let behind = DVec3::new(r, g, b);
    let transmittance = (-optical_depth).exp();
    // 1 − T (1 − α) without the cancellation at small depths.
    let covered = -(-optical_depth).exp_m1() + transmittance * alpha;
    let (color, alpha) = match model {
        OpticalModel::EmissionAbsorption => (light + transmittance * behind, covered),
        OpticalModel::Emission => (light + behind, alpha),
        OpticalModel::Absorption => (transmittance * behind, covered),
        OpticalModel::MaximumIntensity => (light.max(behind), alpha),
    };
    [color.x, color.y, color.z, alpha]
}

/// A sum whose error does not grow with the number of terms (Neumaier 1974).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    sum: f64,
    compensation: f64,
}

impl CompensatedSum {
    /// Adds a term.
    pub fn add(&mut self, term: f64) {
        let sum = self.sum + term;
        self.compensation += if self.sum.abs() >= term.abs() {
            (self.sum - sum) + term
        } else {
            (term - sum) + self.sum
        };
        self.sum = sum;
    }

    /// The sum so far.
    pub fn value(&self) -> f64 {
        self.sum + self.compensation
    }
}
