//! The parts of an appearance beyond the integral: clip planes, depth cue, isosurfaces.

use tetrascope_core::Unit as _;
use tetrascope_core::appearance::{CueRamp, nearest_crossing};
use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::{Appearance, Bounds, DirectionalLight, OpticalModel, TetMesh};

use crate::bound::DISPLACEMENT;
use crate::frame::RayFrame;
use crate::ray::Entry;
use crate::tile::Scene;

/// The unit roundoff.
const UNIT: f64 = f64::EPSILON / 2.0;

/// An appearance in the frame of one image.
pub(crate) struct Look<'a> {
    appearance: &'a Appearance,
    /// Unit normal and n · p of each clip plane, frame coordinates.
    planes: Vec<(DVec3, f64)>,
    /// Depth cue as a function of z in frame units.
    cue: Option<CueRamp>,
    lights: Vec<DirectionalLight>,
    /// The greatest channel that a lit surface can have.
    brightest: f64,
}

/// The stretch that clip planes and the eye leave of a ray, frame units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// 0 or more.
    pub(crate) near: f64,
    pub(crate) far: f64,
    /// How far both may be off together.
    pub(crate) blur: f64,
}

/// Where a ray meets an isosurface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// Frame units.
    pub(crate) z: f64,
    /// Lit, linear RGB.
    pub(crate) color: DVec3,
    /// A bound on the error of `color`.
    pub(crate) error: f64,
}

impl<'a> Look<'a> {
    pub(crate) fn new(appearance: &'a Appearance, bounds: &Bounds, frame: &RayFrame) -> Look<'a> {
        let planes = appearance.clip_planes.iter().map(|plane| {
            let normal = frame.turned(plane.normal.unit());
            (normal, normal.dot(frame.position(plane.point)))
        });
        let cue = appearance.depth_cue.map(|cue| {
            let ramp = cue.ramp(frame.eye(), frame.forward(), bounds);
            CueRamp {
                slope: ramp.slope * frame.scale,
                ..ramp
            }
        });
        let lights = appearance.lighting.resolved(frame.forward());
        let lit = lights.iter().map(|l| l.color).sum::<DVec3>() + appearance.lighting.ambient;
        let colors = appearance.isosurfaces.iter().map(|s| s.color * lit);
        Look {
            appearance,
            planes: planes.collect(),
            cue,
            brightest: colors.map(DVec3::max_element).fold(1.0, f64::max),
            lights,
        }
    }

    /// The stretch that is left of the ray at `p`.
    pub(crate) fn stretch(&self, frame: &RayFrame, p: DVec2) -> Stretch {
        let mut stretch = Stretch {
            near: 0.0,
            far: f64::INFINITY,
            blur: 0.0,
        };
        let (origin, direction) = frame.line(p);
        for &(normal, offset) in &self.planes {
            let height = normal.dot(origin) - offset;
            let rise = normal.dot(direction);
            let z = -height / rise;
            if rise > 0.0 && z > stretch.near {
                stretch.near = z;
            } else if rise < 0.0 && z < stretch.far {
                stretch.far = z;
            } else if rise == 0.0 && height < 0.0 {
                stretch.far = f64::NEG_INFINITY;
            }
            // Dot products of three terms, and positions within 1 of the eye or so
            // that were rounded 5 times on the way: 8 u each, of numbers that may
            // be larger than 1 where the plane's point is far away.
            if rise != 0.0 {
                let size = 1.0 + offset.abs() + origin.length() + z.abs() * direction.length();
                stretch.blur += 16.0 * UNIT * size / rise.abs();
            }
        }
        stretch
    }

    /// The cue's factors at both ends of `entry`.
    pub(crate) fn cue(&self, entry: &Entry) -> Option<[f64; 2]> {
        let ramp = self.cue?;
        Some([ramp.at(entry.z_in), ramp.at(entry.z_out)])
    }

    /// The isosurface that the ray along `direction`, world space, meets first in `entry`.
    pub(crate) fn hit(&self, mesh: &TetMesh, entry: &Entry, direction: DVec3) -> Option<Hit> {
        let surfaces = &self.appearance.isosurfaces;
        let (index, share) = nearest_crossing(surfaces, entry.scalar_in, entry.scalar_out)?;
        let z = entry.z_in * (1.0 - share) + entry.z_out * share;
        let (gradient, doubt) = gradient(mesh, entry.cell as usize);
        let color = surfaces[index].color;
        let lighting = &self.appearance.lighting;
        let lit = lighting.shade(&self.lights, color, gradient, direction);
        let factor = self.cue.map_or(1.0, |ramp| ramp.at(z));
        // Seen edge-on, either side could be the lit one.
        let edge_on =
            gradient.dot(direction).abs() <= doubt * gradient.length() * direction.length();
        let doubt = if edge_on { 1.0 } else { doubt + 32.0 * UNIT };
        Some(Hit {
            z,
            color: factor * lit,
            error: doubt.min(1.0) * self.brightest,
        })
    }

    /// Whether rounding could have hidden, or made up, a crossing of a surface with `entry`:
    /// one of its ends is as near to an isovalue as scalars may be off.
    pub(crate) fn is_doubtful(&self, scene: &Scene, entry: &Entry) -> bool {
        let mesh = scene.mesh;
        let near = |blur: f64| {
            self.appearance.isosurfaces.iter().any(|surface| {
                let off = |end: f64| (end - surface.value).abs();
                off(entry.scalar_in).min(off(entry.scalar_out)) <= blur
            })
        };
        let scalars = mesh.cell_scalars(entry.cell as usize);
        let low = scalars.iter().copied().fold(f64::INFINITY, f64::min);
        let high = scalars.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // The scalar is never off by more than its range; most entries end here.
        if !near(high - low) {
            return false;
        }
        let points = mesh.cell_points(entry.cell as usize);
        let [a, b, c] = [1, 2, 3].map(|i| points[i] - points[0]);
        let [p, q, r] = [1, 2, 3].map(|i| scalars[i] - scalars[0]);
        let sum = p * b.cross(c) + q * c.cross(a) + r * a.cross(b);
        let gradient = (sum / a.dot(b.cross(c))).length();
        let blur = DISPLACEMENT * scene.frame.scale * gradient;
        // Without extent, a cell's scalars may be anywhere in their range.
        blur.is_nan() || near(blur.min(high - low))
    }

    /// Whether surfaces are drawn, and not the volume.
    pub(crate) fn draws_surfaces(&self) -> bool {
        self.appearance.optical_model == OpticalModel::Isosurfaces
    }

    pub(crate) fn brightest(&self) -> f64 {
        self.brightest
    }
}

/// A vector along the gradient of the scalar in a cell, on either side, and a bound on the error
/// of its direction.
fn gradient(mesh: &TetMesh, cell: usize) -> (DVec3, f64) {
    let points = mesh.cell_points(cell);
    let scalars = mesh.cell_scalars(cell);
    let edges = [1, 2, 3].map(|i| points[i] - points[0]);
    let rises = [1, 2, 3].map(|i| scalars[i] - scalars[0]);
    // Only the direction counts, so a power of the size can go, lest squares underflow.
    let size = edges
        .iter()
        .map(|e| e.abs().max_element())
        .fold(0.0, f64::max);
    let height = rises.iter().map(|r| r.abs()).fold(0.0, f64::max);
    if size == 0.0 || height == 0.0 || !size.is_finite() || !height.is_finite() {
        return (DVec3::ZERO, 1.0);
    }
    let [a, b, c] = edges.map(|e| e / size);
    let [p, q, r] = rises.map(|r| r / height);
    let terms = [p * b.cross(c), q * c.cross(a), r * a.cross(b)];
    let sum = terms[0] + terms[1] + terms[2];
    // Each term's factors are rounded twice, their products and differences three
    // times: 8 u of |p| |b| |c| covers a term, and 2 u more the sum.
    let bound = p.abs() * b.length() * c.length()
        + q.abs() * c.length() * a.length()
        + r.abs() * a.length() * b.length();
    (sum, 10.0 * UNIT * bound / sum.length())
}
