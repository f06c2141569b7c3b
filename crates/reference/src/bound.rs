//! How wrong a pixel can be: a bound on the effect of rounding, from the ray's own crossings.
//!
//! # Where the mesh is
//! With lengths in units of the [`RayFrame`](crate::frame::RayFrame), in which no
//! vertex is farther than 1, and u = 2⁻⁵³: a vertex, turned into the frame and
//! sheared along a ray, is off by at most 8 u in each coordinate: 1 for subtracting
//! the eye, 3 for the dot product, 2 for the axes' own rounding, 2 for the shear.
//!
//! From there on all is relative to what these vertices say: the weights that
//! interpolate z and scalar in a face are good to 65 u of themselves, so that
//! they name a point on the ray to 130 u of the face's size, which is a small part
//! of the unit. So a ray sees, to rounding, an exact mesh whose points are moved by δ = 32 u at
//! most, and all cells of one ray see the same one.
//!
//! # What it does to the integral
//! A scalar on the ray is off by at most δs = δ |∇s|, and never by more than its range in
//! the cell. Twice that is taken, as the ray may be in a neighbor instead.
//! L = ∫ c σ T dt + T B changes by at most ∫ (σ |δc| + C |δσ|) dt, to first order,
//! with C the greatest of all colors, the background, and 1 for opacity (T ≤ 1 is
//! left out). For a segment of length l with the scalars' difference Δs that is
//!
//! - where color and extinction are linear: (C max|dσ/ds| + max σ max|dc/ds|) l δs,
//! - for steps of the transfer function inside it: their heights times
//!   min(l, l δs/|Δs|), by which the step moves,
//! - for an end that no neighbor shares (the boundary, or cell data): C max σ δz.
//!
//! There δz = q Δz + 64 u: edge functions are w = a × b of sheared vertices no longer than
//! L = diameter · |d|, so those of the moved face differ by 2 √2 · 8 u L = 23 u L each,
//! and the barycentric coordinates w/W, W = Σ |w|, by half of 2 Σ |δw| / W in all, 69 u L / W;
//! q is 96 u L / W, and not above 1.
//!
//! The greatest color on a ray moves by max|dc/ds| δs, and by the height of
//! steps that are in the cell's range.
//!
//! # Integration
//! [`RayIntegral::rounding_bound`](tetrascope_core::optics::RayIntegral::rounding_bound),
//! which assumes a background of at most 1 and here is multiplied with C.

use tetrascope_core::{Appearance, Knot, OpticalModel};

use crate::cell::{Cell, Crossing};

/// 2 δ.
pub(crate) const DISPLACEMENT: f64 = 64.0 * UNIT;
/// q per L / W.
const SHIFT: f64 = 96.0 * UNIT;
/// Rounding of a z, in parts of its vertices' z.
const Z_ROUNDING: f64 = 64.0 * UNIT;
/// The unit roundoff u.
const UNIT: f64 = f64::EPSILON / 2.0;

/// The contribution of an appearance to error bounds.
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
    /// δs, the field's units.
    scalar_blur: f64,
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

    /// The steepness in a cell.
    pub(crate) fn of_cell(&self, cell: &Cell) -> CellSteepness {
        let (low, high) = cell.scalar_range();
        let (nearest, farthest) = cell.z_range();
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
            let slopes = [rise / width, shift / width];
            // A slope beyond f64 is a step.
            if slopes.iter().all(|slope| slope.is_finite()) {
                extinction_slope = extinction_slope.max(slopes[0]);
                color_slope = color_slope.max(slopes[1]);
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
            z_range: farthest - nearest,
            // `min` also turns the NaN of a flat cell into the range.
            scalar_blur: (DISPLACEMENT * cell.gradient()).min((high - low).max(0.0)),
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
}

impl CellSteepness {
    /// How far both of a crossing's z may be off together, frame units.
    #[inline]
    pub(crate) fn blur(&self, crossing: &Crossing, slant: f64) -> f64 {
        // `min` turns NaN, of a cell without extent, into the 2 of two faces.
        let q = (SHIFT * slant * crossing.sensitivity).min(2.0);
        q * self.z_range + Z_ROUNDING
    }

    /// A bound on the error of a crossing whose ends neighbors share.
    #[inline]
    pub(crate) fn error(&self, crossing: &Crossing, length_per_z: f64, model: OpticalModel) -> f64 {
        if model == OpticalModel::MaximumIntensity {
            return self.slope * self.scalar_blur + self.steps;
        }
        let length = (crossing.z_out - crossing.z_in) * length_per_z;
        let mut error = self.slope * length * self.scalar_blur;
        if self.steps > 0.0 {
            let change = (crossing.scalar_out - crossing.scalar_in).abs();
            // A NaN, of 0/0, is a whole segment too.
            error += self.steps * length * (self.scalar_blur / change).min(1.0);
        }
        error
    }
}
