//! How wrong a pixel can be: a bound on the effect of rounding, from the ray's own crossings.
//!
//! # Where faces are
//! With lengths in units of the [`RayFrame`](crate::frame::RayFrame), in which no
//! vertex is farther than 1, and u = 2⁻⁵³:
//!
//! - A vertex, turned into the frame and sheared along a ray, is off by at most
//!   16 u: 1 for subtracting the eye, 2√3 + 4 for the dot products and the axes'
//!   own rounding, 4 for the shear, and some to spare.
//! - Where a ray meets a face, its vertices are at most L = diameter · |d| away
//!   from the ray. The edge functions w = a × b are then off by at most
//!   2 √2 · 16 u L for the vertices and 2 u L² for the products, L < 2 |d|, and
//!   a barycentric coordinate w/W, W = Σ |w|, by four times that over W. So a
//!   coordinate is off by at most q = 256 u L / W, and never by more than 1.
//! - z and scalar at the face are off by at most q times their range in the cell,
//!   z by another 64 u for the vertices' own z.
//!
//! # What it does to the integral
//! L = ∫ c σ T dt + T B changes by at most ∫ (σ |δc| + C |δσ|) dt, to first order,
//! with C the greatest of all colors, the background, and 1 for opacity (T ≤ 1 is
//! left out). On a segment of length l whose ends move by δz and δs:
//!
//! - linear pieces: (C max|dσ/ds| + max σ max|dc/ds|) (l δs + |Δs| δz),
//! - steps of the transfer function inside it: their heights times
//!   min(l, l δs/|Δs| + δz),
//! - ends that no neighbor shares (the boundary, or cell data): C max σ δz. Ends that two
//!   cells share agree to the last bit and move together, which the first line covers.
//!
//! The greatest color on a ray moves by max|dc/ds| δs, and by a step's height
//! where one is within δs of an end.
//!
//! # Integration
//! The closed form of one segment is good to 1e-14 of its own opacity, and n of
//! them are summed.

use tetrascope_core::{Appearance, Knot, OpticalModel};

use crate::cell::Crossing;

/// q per L / W.
const SHIFT: f64 = 256.0 * UNIT;
/// Of a z by its vertices' z.
const Z_ROUNDING: f64 = 64.0 * UNIT;
/// The unit roundoff u.
const UNIT: f64 = f64::EPSILON / 2.0;

/// What an appearance contributes to error bounds.
pub(crate) struct Steepness<'a> {
    knots: &'a [Knot],
    model: OpticalModel,
    /// C above.
    brightest: f64,
    /// The greatest extinction of all, per world unit.
    densest: f64,
}

/// How strongly a cell's light reacts to errors of scalar and position; see the
/// module's text. Products with lengths in world units and scalars in the field's.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CellSteepness {
    /// Per scalar and length, or per scalar for `MaximumIntensity`.
    slope: f64,
    /// Per length, or absolute for `MaximumIntensity`.
    steps: f64,
    z_range: f64,
    scalar_range: f64,
}

impl<'a> Steepness<'a> {
    /// `background` is premultiplied.
    pub(crate) fn new(appearance: &'a Appearance, background: [f64; 4]) -> Steepness<'a> {
        let knots = appearance.transfer_function.knots();
        let colors = knots.iter().map(|k| k.color.max_element());
        Steepness {
            knots,
            model: appearance.optical_model,
            brightest: colors.chain(background).fold(1.0, f64::max),
            densest: knots.iter().map(|k| k.extinction).fold(0.0, f64::max),
        }
    }

    /// The steepness in a cell with these least and greatest scalars and z.
    pub(crate) fn of_cell(&self, scalars: (f64, f64), z: (f64, f64)) -> CellSteepness {
        let (low, high) = scalars;
        let knots = self.knots;
        // All knots that bound an interval which the range touches.
        let first = knots.partition_point(|k| k.scalar < low).saturating_sub(1);
        let last = knots.partition_point(|k| k.scalar <= high);
        let touched = &knots[first.min(last)..(last + 1).min(knots.len())];
        let (mut extinction, mut extinction_slope, mut color_slope) = (0.0f64, 0.0f64, 0.0f64);
        let (mut extinction_step, mut color_step) = (0.0f64, 0.0f64);
        for pair in touched.windows(2) {
            let [a, b] = pair else { continue };
            let rise = (b.extinction - a.extinction).abs();
            let shift = (b.color - a.color).abs().max_element();
            let width = b.scalar - a.scalar;
            if width > 0.0 {
                extinction_slope = extinction_slope.max(rise / width);
                color_slope = color_slope.max(shift / width);
            } else {
                extinction_step += rise;
                color_step += shift;
            }
        }
        for knot in touched {
            extinction = extinction.max(knot.extinction);
        }
        let c = self.brightest;
        let (slope, steps) = match self.model {
            OpticalModel::MaximumIntensity => (color_slope, color_step),
            _ => (
                c * extinction_slope + extinction * color_slope,
                c * extinction_step + extinction * color_step,
            ),
        };
        CellSteepness {
            slope,
            steps,
            z_range: z.1 - z.0,
            scalar_range: (high - low).max(0.0),
        }
    }

    /// The greatest value that a channel could reach: C above.
    pub(crate) fn brightest(&self) -> f64 {
        self.brightest
    }

    /// A bound on the error that a shift of the mesh's boundary by `z` frame
    /// units makes; `length_per_z` is in world units.
    pub(crate) fn of_boundary(&self, z: f64, length_per_z: f64) -> f64 {
        match self.model {
            OpticalModel::MaximumIntensity => 0.0,
            _ => self.brightest * self.densest * z * length_per_z,
        }
    }

    /// Adds one crossing's error bound to what a ray has.
    pub(crate) fn accumulate(&self, error: &mut f64, more: f64) {
        match self.model {
            OpticalModel::MaximumIntensity => *error = error.max(more),
            _ => *error += more,
        }
    }

    /// A bound on the rounding errors of integrating `segments` pieces of a ray.
    pub(crate) fn of_integration(&self, segments: usize, optical_depth: f64, light: f64) -> f64 {
        // Each piece is good to 1e-14 of itself; the sum's terms round once each;
        // e^(−τ) inherits τ's relative error of 2 u, and τ e^(−τ) < 1.
        let per_piece = 1e-14 + (segments as f64 + 4.0) * UNIT;
        let depth = if optical_depth > 0.0 { 8.0 * UNIT } else { 0.0 };
        per_piece * light + self.brightest * (depth + 4.0 * UNIT)
    }
}

impl CellSteepness {
    /// How far the crossing's z and scalars may be off, both faces together:
    /// frame units, and the field's.
    pub(crate) fn blur(&self, crossing: &Crossing, slant: f64) -> (f64, f64) {
        // `min` turns NaN, of a cell without extent, into the 2 of two faces.
        let q = (SHIFT * slant * crossing.sensitivity).min(2.0);
        (q * self.z_range + Z_ROUNDING, q * self.scalar_range)
    }

    /// A bound on the error that `blur` makes in a segment.
    pub(crate) fn error(
        &self,
        crossing: &Crossing,
        (dz, ds): (f64, f64),
        length_per_z: f64,
        model: OpticalModel,
    ) -> f64 {
        if model == OpticalModel::MaximumIntensity {
            return self.slope * ds + self.steps;
        }
        let length = (crossing.z_out - crossing.z_in) * length_per_z;
        let dz = dz * length_per_z;
        let change = (crossing.scalar_out - crossing.scalar_in).abs();
        let mut error = self.slope * (length * ds + change * dz);
        if self.steps > 0.0 {
            let moved = if change > 0.0 { ds / change } else { 1.0 };
            error += self.steps * length.min(length * moved + dz);
        }
        error
    }
}
