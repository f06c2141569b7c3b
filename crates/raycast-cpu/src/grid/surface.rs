//! Isosurfaces of a grid: where a ray meets the first, and how it is lit there.
//!
//! Within a cell, the cubic's monotone parts are the stretches of
//! [`Isosurface::is_met`]; joints between parts and between cells are stretches without length,
//! so that what rounding makes of a scalar on both sides of a face can neither hide a surface nor
//! show it twice. Cells between two that are met lie on one side of every surface, the one on
//! which the first was left.

use tetrascope_core::appearance::{CueRamp, Isosurface, Lighting};
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::{Appearance, DirectionalLight};

use super::cubic::Cubic;
use super::walk::{Line, Stretch};

/// The surfaces of an appearance and what lights them in one frame.
#[derive(Clone, Debug)]
pub(crate) struct Surfaces {
    surfaces: Vec<Isosurface>,
    lighting: Lighting,
    lights: Vec<DirectionalLight>,
    axes: DMat3,
    spacing: DVec3,
}

/// A ray on its way to the first surface.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Search {
    /// The scalar where the last cell was left.
    last: Option<f64>,
}

/// Where a ray meets a surface, world units along it, and its lit color.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f64,
    pub(crate) color: DVec3,
}

impl Surfaces {
    /// For a camera that looks along `forward` at a grid with these axes.
    pub(crate) fn new(
        appearance: &Appearance,
        forward: DVec3,
        (axes, spacing): (DMat3, DVec3),
    ) -> Surfaces {
        Surfaces {
            surfaces: appearance.isosurfaces.clone(),
            lighting: appearance.lighting.clone(),
            lights: appearance.lighting.resolved(forward),
            axes,
            spacing,
        }
    }
}

impl Search {
    /// Follows a ray through its next cell.
    pub(crate) fn add(
        &mut self,
        surfaces: &Surfaces,
        (line, direction, cue): (&Line, DVec3, Option<CueRamp>),
        stretch: &Stretch,
        corners: &[f64; 8],
    ) -> Option<Hit> {
        if corners.iter().any(|corner| !corner.is_finite()) {
            self.last = None;
            return None;
        }
        let at = |t: f64| stretch.clamped(line, t);
        let cubic = Cubic::trilinear(corners, at(stretch.t_in), at(stretch.t_out));
        for part in cubic.monotone() {
            let [front, back] = part.ends();
            let last = self.last.replace(back).unwrap_or(front);
            let met = |ends: [f64; 2]| {
                let all = surfaces.surfaces.iter();
                all.filter(move |s| s.is_met(ends[0], ends[1]))
            };
            // On the joint all are met at one place; of equal places the first counts.
            let joint = met([last, front]).next().map(|s| (s, part.from));
            let nearest = || {
                let places = met([front, back]).map(|s| (s, part.place(s.value)));
                places.min_by(|a, b| a.1.total_cmp(&b.1))
            };
            if let Some((surface, tau)) = joint.or_else(nearest) {
                let t = stretch.t_in + tau * (stretch.t_out - stretch.t_in);
                let gradient = gradient(corners, at(t));
                // Only the direction counts, so that lengths may be in units of the spacing.
                let least = surfaces.spacing.min_element();
                let normal = surfaces.axes * (gradient * (least / surfaces.spacing));
                let lighting = &surfaces.lighting;
                let lit = lighting.shade(&surfaces.lights, surface.color, normal, direction);
                let factor = cue.map_or(1.0, |ramp| ramp.at(t));
                return Some(Hit {
                    t,
                    color: factor * lit,
                });
            }
        }
        None
    }
}

/// The gradient of the trilinear interpolant of `corners` at `place`, per voxel; none where that
/// has no direction.
fn gradient(corners: &[f64; 8], place: [f64; 3]) -> DVec3 {
    let along = |axis: usize| {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let weight = |bit: usize, f: f64| if bit == 1 { f } else { 1.0 - f };
        let rises = (0..4).map(|i| {
            let low = (i & 1) << b | (i >> 1) << c;
            let rise = corners[low | 1 << axis] - corners[low];
            weight(i & 1, place[b]) * weight(i >> 1, place[c]) * rise
        });
        rises.sum::<f64>()
    };
    let gradient = DVec3::new(along(0), along(1), along(2));
    match gradient.is_finite() {
        true => gradient,
        false => DVec3::ZERO,
    }
}
