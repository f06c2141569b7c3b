//! One ray by itself, with all that happens on it.

use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::{Error, Ray};

use crate::bound::Steepness;
use crate::frame::RayFrame;
use crate::grid::GridBody;
use crate::look::Look;
use crate::ray::{self, Consistency};
use crate::tile::{Line, Scene};
use crate::{Body, Reference};

/// The interval that a ray and a cell have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The mesh's index of the cell.
    pub cell: usize,
    /// Where the ray enters, world units from its origin, 0 or more.
    pub t_in: f64,
    /// Where it leaves; not before `t_in`.
    pub t_out: f64,
    /// The scalar at `t_in`.
    pub scalar_in: f64,
    /// The scalar at `t_out`.
    pub scalar_out: f64,
}

/// A ray through the volume.
#[derive(Clone, Debug)]
pub struct RayTrace {
    /// Front to back; where the ray is in no cell there is no interval.
    pub intervals: Vec<Interval>,
    /// ∫ c σ T dt (T = 1 in `Emission`), or the greatest c in `MaximumIntensity`, linear RGB.
    pub light: [f64; 3],
    /// ∫ σ dt, dimensionless; 0 where the model does not absorb. Exact up to 64,
    /// and a lower bound beyond, where nothing can be seen.
    pub optical_depth: f64,
    /// How far away the isosurface is that the ray meets, world units; infinite without one.
    pub surface_depth: f64,
    /// Premultiplied linear RGBA before a transparent background.
    pub pixel: [f64; 4],
    /// A bound on the absolute error of `pixel`.
    pub error_bound: f64,
    /// Whether the intervals lie end to end.
    pub consistency: Consistency,
}

impl Reference {
    /// Follows one ray, which need not belong to a view. Depth cue and headlight are those
    /// of a camera that looks along it.
    ///
    /// # Errors
    /// A ray with a number that is not finite or without a direction, and one
    /// that starts so far away that distances overflow.
    pub fn trace(&self, ray: &Ray) -> Result<RayTrace, Error> {
        let (mesh, units, geometry) = match &self.body {
            Body::Mesh {
                mesh,
                units,
                geometry,
            } => (mesh, units, geometry),
            Body::Grid(grid) => return self.trace_grid(grid, ray),
        };
        let frame = RayFrame::of_ray(ray, geometry)?;
        let background = [0.0; 4];
        let p = DVec2::ZERO;
        let planes = frame.planes(geometry, p, p);
        let scene = Scene {
            mesh,
            geometry,
            appearance: &self.look,
            steepness: Steepness::new(&self.look, background),
            look: Look::new(&self.look, &mesh.bounds(), &frame),
            frame,
            background,
        };
        let line = Line::new(&scene, p);
        let length_per_z = line.length_per_z;
        let points = mesh.points();
        let (mut entries, mut error) = (Vec::new(), 0.0);
        geometry.visit(&planes, &mut Vec::new(), |range| {
            for index in range {
                let cell = scene.cell(index, |v| scene.frame.position(points[v as usize]));
                let steepness = scene.steepness.of_cell(&cell);
                cell.cross(&cell.above(p.y), &[p.x], |_, crossing| {
                    let id = geometry.ids[index];
                    entries.extend(scene.entry(crossing, id, &steepness, &line, &mut error));
                });
            }
        });
        ray::sort(&mut entries);
        let outcome = ray::integrate(&scene, &line, &entries, error);
        let intervals = entries.iter().map(|entry| Interval {
            cell: entry.cell as usize,
            t_in: entry.z_in * length_per_z,
            t_out: entry.z_out * length_per_z,
            scalar_in: units.to_field(entry.scalar_in),
            scalar_out: units.to_field(entry.scalar_out),
        });
        Ok(RayTrace {
            intervals: intervals.collect(),
            light: outcome.light,
            optical_depth: outcome.optical_depth,
            surface_depth: outcome.surface_depth,
            pixel: outcome.pixel,
            error_bound: outcome.error,
            consistency: outcome.consistency,
        })
    }

    fn trace_grid(&self, grid: &GridBody, ray: &Ray) -> Result<RayTrace, Error> {
        let direction = ray.direction.normalize_or_zero();
        if !ray.origin.is_finite() || direction == DVec3::ZERO {
            return Err(no_ray());
        }
        grid.check_eye(ray.origin)?;
        let ray = Ray {
            origin: ray.origin,
            direction,
        };
        let scene = grid.scene(&self.look, (ray.origin, direction), [0.0; 4]);
        let (outcome, intervals) = scene.trace(&ray);
        Ok(RayTrace {
            intervals,
            light: outcome.light,
            optical_depth: outcome.optical_depth,
            surface_depth: outcome.surface_depth,
            pixel: outcome.pixel,
            error_bound: outcome.error,
            consistency: outcome.consistency,
        })
    }
}

/// Why a ray cannot be followed.
pub(crate) fn no_ray() -> Error {
    Error::invalid("a ray needs a finite origin and a finite direction that is not zero")
}
