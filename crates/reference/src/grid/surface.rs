//! Isosurfaces of a grid: where a ray meets the first, and how it is lit there.
//!
//! Cells come front to back. Within each, the cubic's monotone parts are the stretches of
//! `tetrascope_core::appearance`; the joints between parts and between cells are stretches
//! without length, so that what rounding makes of a scalar on both sides of a face can
//! neither hide a surface nor show it twice.

use tetrascope_core::appearance::{CueRamp, Isosurface, Lighting};
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::{Appearance, DirectionalLight};

use super::cubic::Cubic;
use super::walk::{Line, Stretch};
use super::{INTERPOLATION, UNIT};

/// The surfaces of an appearance and what lights them in one image.
#[derive(Clone, Debug)]
pub(crate) struct Surfaces {
    surfaces: Vec<Isosurface>,
    lighting: Lighting,
    lights: Vec<DirectionalLight>,
    /// The greatest channel that a lit surface can have.
    brightest: f64,
}

/// A ray's cell: its corners, their range, and how far scalars and places are off.
pub(crate) struct CellOnRay<'a> {
    pub(crate) stretch: &'a Stretch,
    pub(crate) corners: &'a [f64; 8],
    pub(crate) range: [f64; 2],
    /// Error of a scalar.
    pub(crate) blur: f64,
}

/// A ray in the coordinates of the grid's lattice.
pub(crate) struct RayOnGrid<'a> {
    pub(crate) line: &'a Line,
    /// Unit, world space.
    pub(crate) direction: DVec3,
    /// The grid's axes, world space, one per column.
    pub(crate) axes: DMat3,
    pub(crate) spacing: DVec3,
    /// How far a point may be off, voxels.
    pub(crate) shift: DVec3,
    /// Depth cue as a function of the distance along the ray.
    pub(crate) cue: Option<CueRamp>,
    /// How far the cue's factor may be off where the distance is right.
    pub(crate) cue_error: f64,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// World units along the ray.
    pub(crate) t: f64,
    /// Lit, linear RGB.
    pub(crate) color: DVec3,
    /// A bound on the error of `color`.
    error: f64,
}

/// A ray on its way to the first surface.
pub(crate) struct Search<'a> {
    surfaces: &'a Surfaces,
    /// The scalar where the last cell was left, or one on the same side of all surfaces.
    last: Option<f64>,
    pub(crate) hit: Option<Hit>,
    /// Whether rounding could have hidden a surface, made one up, or met it in another cell.
    doubtful: bool,
}

impl Surfaces {
    /// For a camera that looks along `forward`.
    pub(crate) fn new(appearance: &Appearance, forward: DVec3) -> Surfaces {
        let lights = appearance.lighting.resolved(forward);
        let lit = lights.iter().map(|l| l.color).sum::<DVec3>() + appearance.lighting.ambient;
        let colors = appearance.isosurfaces.iter().map(|s| s.color * lit);
        Surfaces {
            surfaces: appearance.isosurfaces.clone(),
            lighting: appearance.lighting.clone(),
            brightest: colors.map(DVec3::max_element).fold(1.0, f64::max),
            lights,
        }
    }

    pub(crate) fn search(&self) -> Search<'_> {
        Search {
            surfaces: self,
            last: None,
            hit: None,
            doubtful: false,
        }
    }

    /// Whether some surface has a value in [low, high].
    fn touched(&self, low: f64, high: f64) -> bool {
        let values = self.surfaces.iter().map(|s| s.value);
        values.into_iter().any(|v| low <= v && v <= high)
    }
}

impl Search<'_> {
    /// The ray leaves what has scalars: what comes next is no neighbor.
    pub(crate) fn gap(&mut self) {
        self.last = None;
    }

    /// A bound on the error of the color that was found.
    pub(crate) fn error(&self) -> f64 {
        if self.doubtful {
            self.surfaces.brightest
        } else {
            self.hit.map_or(0.0, |hit| hit.error)
        }
    }

    /// Follows the ray through its next cell, in which `scalar` gives the scalar.
    pub(crate) fn add(
        &mut self,
        ray: &RayOnGrid,
        cell: &CellOnRay,
        scalar: impl FnOnce() -> Cubic,
    ) {
        if self.hit.is_some() {
            return;
        }
        let [low, high] = cell.range;
        let cubic = if self.surfaces.touched(low - cell.blur, high + cell.blur) {
            scalar()
        } else {
            // All of the cell is on one side of every surface.
            Cubic([low; 4])
        };
        for part in cubic.monotone() {
            let [front, back] = part.ends();
            let last = self.last.unwrap_or(front);
            self.doubtful |= cell.blur > 0.0 && self.is_near([last, front, back], cell.blur);
            self.last = Some(back);
            let met = |ends: [f64; 2]| {
                let surfaces = self.surfaces.surfaces.iter();
                surfaces.filter(move |s| s.is_met(ends[0], ends[1]))
            };
            // On the joint all are met at one place.
            let joint = met([last, front]).next().map(|s| (s, 0.0));
            let nearest = || {
                let places = met([front, back]).map(|s| (s, part.place(s.value)));
                // Of equal ones the first.
                places.min_by(|a, b| a.1.total_cmp(&b.1))
            };
            let Some((surface, tau)) = joint.or_else(nearest) else {
                continue;
            };
            let early = |tau: f64| part.from + tau * (part.to - part.from);
            let off = [-cell.blur, cell.blur].map(|b| part.place(surface.value + b));
            let error = early(off[0]) - early(off[1]);
            self.hit = Some(self.light(ray, cell, surface, early(tau), error.abs()));
            return;
        }
    }

    /// Whether one of `scalars` is as near to an isovalue as they may be off.
    fn is_near(&self, scalars: [f64; 3], blur: f64) -> bool {
        let near = |s: &Isosurface| scalars.iter().any(|x| (x - s.value).abs() <= blur);
        self.surfaces.surfaces.iter().any(near)
    }

    /// The light of `surface`, met at the share `tau` of the way through the cell, which
    /// may be off by `error`.
    fn light(
        &mut self,
        ray: &RayOnGrid,
        cell: &CellOnRay,
        surface: &Isosurface,
        tau: f64,
        error: f64,
    ) -> Hit {
        let Stretch { t_in, t_out, .. } = *cell.stretch;
        let t = t_in + tau * (t_out - t_in);
        let t_error = error * (t_out - t_in);
        let place = cell.stretch.place(ray.line, t);
        let off = ray.shift + t_error * ray.line.slope.abs();
        // In a neighbor the gradient is another one.
        let beside = |a: usize| place[a] <= off[a] || 1.0 - place[a] <= off[a];
        self.doubtful |= (0..3).any(beside);
        let gradient = gradient(cell.corners, place);
        // Mixed differences of the corners are at most twice their range, so that is how
        // fast each component changes along the other axes.
        let [low, high] = cell.range;
        let rounding = INTERPOLATION * low.abs().max(high.abs());
        let sum = off.element_sum();
        let doubt = (DVec3::splat(sum) - off) * (2.0 * (high - low)) + rounding;
        // Only the direction counts, so that lengths may be in units of the spacing.
        let least = ray.spacing.min_element();
        let world = |v: DVec3| v * (least / ray.spacing);
        let (normal, doubt) = (ray.axes * world(gradient), world(doubt).length());
        let relative = 2.0 * doubt / normal.length() + 32.0 * UNIT;
        // Seen edge-on, either side could be the lit one.
        let edge_on = normal.dot(ray.direction).abs() <= doubt;
        let relative = if edge_on || relative.is_nan() {
            1.0
        } else {
            relative.min(1.0)
        };
        let set = self.surfaces;
        let lit = set
            .lighting
            .shade(&set.lights, surface.color, normal, ray.direction);
        let factor = ray.cue.map_or(1.0, |ramp| ramp.at(t));
        let slope = ray.cue.map_or(0.0, |ramp| ramp.slope.abs());
        Hit {
            t,
            color: factor * lit,
            error: (relative + slope * t_error + ray.cue_error) * set.brightest,
        }
    }
}

/// The gradient of the trilinear interpolant of `corners` (x fastest) at `place` in
/// [0, 1]³, per voxel.
fn gradient(corners: &[f64; 8], place: [f64; 3]) -> DVec3 {
    let along = |axis: usize| {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut sum = 0.0;
        for i in 0..4 {
            let (bit_b, bit_c) = (i & 1, i >> 1);
            let weight = |bit: usize, f: f64| if bit == 1 { f } else { 1.0 - f };
            let low = bit_b << b | bit_c << c;
            let rise = corners[low | 1 << axis] - corners[low];
            sum += weight(bit_b, place[b]) * weight(bit_c, place[c]) * rise;
        }
        sum
    };
    // Infinite corners make no gradient that has a direction.
    let gradient = DVec3::new(along(0), along(1), along(2));
    if gradient.is_finite() {
        gradient
    } else {
        DVec3::ZERO
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // s = 1 + 2 x + 3 y + 5 z + 7 x y + 11 y z + 13 z x + 17 x y z, whose derivatives are known.
    #[test]
    fn the_gradient_is_that_of_the_interpolant() {
        let s = |[x, y, z]: [f64; 3]| {
            1.0 + 2.0 * x
                + 3.0 * y
                + 5.0 * z
                + 7.0 * x * y
                + 11.0 * y * z
                + 13.0 * z * x
                + 17.0 * x * y * z
        };
        let corners =
            [0, 1, 2, 3, 4, 5, 6, 7].map(|i: usize| s([0, 1, 2].map(|a| (i >> a & 1) as f64)));
        for place in [[0.0; 3], [1.0; 3], [0.25, 0.5, 0.75], [0.3, 0.1, 0.9]] {
            let [x, y, z] = place;
            let want = DVec3::new(
                2.0 + 7.0 * y + 13.0 * z + 17.0 * y * z,
                3.0 + 7.0 * x + 11.0 * z + 17.0 * x * z,
                5.0 + 11.0 * y + 13.0 * x + 17.0 * x * y,
            );
            // A dozen roundings of numbers up to 60.
            assert!((gradient(&corners, place) - want).length() < 1e-13);
        }
    }
}
