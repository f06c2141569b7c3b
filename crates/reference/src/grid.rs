//! Regular grids: trilinear interpolation, integrated voxel cell by voxel cell; or samples
//! that fill cells.
//!
//! On a ray the scalar is a cubic in each cell, which `cubic` keeps in Bernstein form and
//! splits at its extremes and where it crosses the transfer function's knots. On each part
//! color and extinction are cubics too, so optical depths are exact and the light is a
//! smooth integral of one variable, for which `quadrature` has Gauss–Legendre rules with
//! errors under 3e-14; `cue` has the same for light that fades with depth. `walk` finds the
//! cells, `integral` adds them up, and `surface` finds isosurfaces in them.
//!
//! Where the grid has a coverage, `covered` takes the place of the cubics: extinction is one
//! still, and color a quotient of two; unless the optical model has no extinction, for which a
//! sample is there or not.
//!
//! A cell with a NaN or an infinity at a corner is transparent. Where each sample fills a
//! cell of its own, all corners of a cell are that sample, and an isosurface is nowhere, as
//! in a mesh whose cells have scalars of their own.
//!
//! # Error
//! With u = 2⁻⁵³, a point of the ray is off by at most 64 u of its distance from the eye,
//! the grid's origin and the far end of the volume, whichever is farthest: 1 for
//! subtracting the origin, 16 for the inverse of the direction matrix and the product, 8
//! for the ray's own direction, 8 for the time at which a plane is crossed, and as many
//! again in reserve. The scalar moves by at most the samples' range in the cell times the
//! shift along each axis, in voxels. Twice that is taken, as the point may be in a
//! neighbor instead. See [`integral::GridIntegral::blur`] for what follows.
//! Where scalars jump from cell to cell, the time of the jump is off as that is at which the
//! volume begins.
//! Where the grid has a coverage, the quadrature's own error is estimated by halving; see
//! `covered`.
//! A ray in the very surface of the volume, or of a cell with a scalar of its own, may meet it
//! or not, as rounding decides.

mod covered;
mod cubic;
mod cue;
mod integral;
mod pieces;
mod quadrature;
mod surface;
mod walk;

use std::ops::Range;
use tetrascope_core::Unit as _;

use tetrascope_core::appearance::{CueRamp, clip_ray};
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::coverage::{THERE, fades};
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::optics::over;
use tetrascope_core::{
    Appearance, Bounds, ClipPlane, DepthCue, Error, Grid, OpticalModel, Ray, View,
};

use crate::ray::{Consistency, Outcome};
use crate::trace::Interval;
use covered::{CoveredCell, Way};
use cubic::Cubic;
use cue::NO_CUE;
use integral::{GridIntegral, Look};
use surface::{CellOnRay, RayOnGrid, Search, Surfaces};
use walk::{Line, Stretch, Walk};

/// How far a point may be off, of the greatest distance.
const DISPLACEMENT: f64 = 64.0 * UNIT;
/// Rounding of a scalar by interpolation, in parts of the greatest sample.
const INTERPOLATION: f64 = 32.0 * UNIT;
/// The unit roundoff u.
const UNIT: f64 = f64::EPSILON / 2.0;

/// A grid, ready for rays.
///
/// Places are relative to its first sample, and so as exact far from the world's origin as at it.
#[derive(Clone, Debug)]
pub(crate) struct GridBody {
    grid: Grid,
    /// Relative to the first sample.
    bounds: Bounds,
    /// The inverse of the grid's direction matrix.
    turn: DMat3,
    cells: [usize; 3],
}

/// A grid as one image or one ray sees it.
pub(crate) struct GridScene<'a> {
    body: &'a GridBody,
    look: Look,
    /// The surfaces that the model `Isosurfaces` draws in place of the volume.
    surfaces: Option<Surfaces>,
    /// Depth cue as a function of depth along `forward`.
    cue: Option<CueRamp>,
    /// Unit, world space.
    forward: DVec3,
    background: [f64; 4],
}

impl GridBody {
    pub(crate) fn new(grid: &Grid) -> GridBody {
        GridBody {
            bounds: Lattice {
                origin: DVec3::ZERO,
                ..*grid.lattice()
            }
            .bounds(),
            turn: grid.direction().inverse(),
            cells: grid.lattice().cells(),
            grid: grid.clone(),
        }
    }

    /// The grid that is drawn.
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Bytes of the samples, and of their coverage.
    pub(crate) fn bytes(&self) -> u64 {
        let coverage = self.grid.coverage().map_or(0, size_of_val);
        self.grid.samples().bytes() + coverage as u64
    }

    /// For a camera at `eye` that looks along the unit vector `forward`.
    pub(crate) fn scene(
        &self,
        appearance: &Appearance,
        (eye, forward): (DVec3, DVec3),
        background: [f64; 4],
    ) -> GridScene<'_> {
        let draws_surfaces = appearance.optical_model == OpticalModel::Isosurfaces;
        let ramp = |cue: DepthCue| cue.ramp(eye - self.grid.origin(), forward, &self.bounds);
        let planes = appearance.clip_planes.iter().map(|plane| ClipPlane {
            point: plane.point - self.grid.origin(),
            ..*plane
        });
        let appearance = Appearance {
            clip_planes: planes.collect(),
            ..appearance.clone()
        };
        GridScene {
            body: self,
            look: Look::new(&appearance, background),
            surfaces: draws_surfaces.then(|| Surfaces::new(&appearance, forward)),
            cue: appearance.depth_cue.map(ramp),
            forward,
            background,
        }
    }

    /// Refuses an eye from which distances overflow.
    pub(crate) fn check_eye(&self, eye: DVec3) -> Result<(), Error> {
        let far = self.distance(eye - self.grid.origin());
        if far.is_nan() || far > f64::MAX / 16.0 {
            return Err(Error::Invalid {
                what: format!("the camera is {far:e} away from the grid"),
                help: Some("move it closer".into()),
            });
        }
        Ok(())
    }

    /// Whether each sample fills a cell of its own.
    fn has_cell_samples(&self) -> bool {
        self.grid.lattice().interpolation == Interpolation::Nearest
    }

    /// At least the distance from `eye`, relative to the first sample, to the farthest cell, and to that
    /// sample.
    fn distance(&self, eye: DVec3) -> f64 {
        eye.length() + self.bounds.diagonal()
    }

    /// A ray relative to the first sample in the space of cells: lattice space, moved to where the first
    /// cell begins.
    fn line(&self, ray: &Ray) -> Line {
        let spacing = self.grid.spacing();
        let origin = self.turn * ray.origin / spacing;
        Line {
            origin: origin - self.grid.lattice().first(),
            slope: self.turn * ray.direction / spacing,
        }
    }

    fn cell_index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.cells[0] * (y + self.cells[1] * z)
    }

    fn corners(&self, cell: [usize; 3]) -> [f64; 8] {
        let samples = self.grid.samples();
        self.of_corners(cell, |index| samples.get(index))
    }

    /// The same without a value where less than [`THERE`] of a sample is.
    fn corners_there(&self, cell: [usize; 3]) -> [f64; 8] {
        let samples = self.grid.samples();
        match self.grid.coverage() {
            None => self.corners(cell),
            Some(coverage) => self.of_corners(cell, |index| match coverage[index] < THERE {
                true => f64::NAN,
                false => samples.get(index),
            }),
        }
    }

    /// The cell with its coverage, if the grid has one; `Some(None)` where nothing is covered.
    fn covered(&self, cell: [usize; 3], corners: &[f64; 8]) -> Option<Option<CoveredCell>> {
        let coverage = self.grid.coverage()?;
        let coverage = self.of_corners(cell, |index| coverage[index].into());
        Some(CoveredCell::new(*corners, coverage))
    }

    /// The values of the samples at the corners of a cell, by their index.
    fn of_corners(&self, [x, y, z]: [usize; 3], of: impl Fn(usize) -> f64) -> [f64; 8] {
        let [nx, ny, _] = self.grid.dims();
        let first = x + nx * (y + ny * z);
        if self.has_cell_samples() {
            return [of(first); 8];
        }
        let row = |at: usize| [of(at), of(at + 1)];
        let [a, b] = row(first);
        let [c, d] = row(first + nx);
        let [e, f] = row(first + nx * ny);
        let [g, h] = row(first + nx * ny + nx);
        [a, b, c, d, e, f, g, h]
    }
}

impl GridScene<'_> {
    /// Draws the pixels in `columns` × `rows`, row by row, each with the number of cells met. The
    /// ray of a pixel ends `end_of` its column and row, world units.
    pub(crate) fn draw(
        &self,
        view: &View,
        columns: Range<u32>,
        rows: Range<u32>,
        end_of: &dyn Fn(u32, u32) -> f64,
    ) -> Vec<(Outcome, usize)> {
        let mut view = *view;
        view.camera.position -= self.body.grid.origin();
        view.camera.focal_point -= self.body.grid.origin();
        rows.flat_map(|row| columns.clone().map(move |column| (column, row)))
            .map(|(column, row)| {
                let mut visits = 0;
                let (ray, end) = (view.ray(column, row), end_of(column, row));
                let outcome = self.follow(&ray, end, |_, _| visits += 1);
                (outcome, visits)
            })
            .collect()
    }

    /// Follows one ray with a unit direction and lists the cells that are not transparent.
    pub(crate) fn trace(&self, ray: &Ray) -> (Outcome, Vec<Interval>) {
        let mut intervals = Vec::new();
        let ray = Ray {
            origin: ray.origin - self.body.grid.origin(),
            ..*ray
        };
        let outcome = self.follow(&ray, f64::INFINITY, |stretch, scalar| {
            let [scalar_in, .., scalar_out] = scalar().0;
            intervals.push(Interval {
                cell: self.body.cell_index(stretch.cell),
                t_in: stretch.t_in,
                t_out: stretch.t_out,
                scalar_in,
                scalar_out,
            });
        });
        (outcome, intervals)
    }

    /// Integrates a ray, relative to the first sample, up to `end`, world units, and shows `visit` each cell that is not
    /// transparent.
    fn follow(
        &self,
        ray: &Ray,
        end: f64,
        mut visit: impl FnMut(&Stretch, &dyn Fn() -> Cubic),
    ) -> Outcome {
        let body = self.body;
        let line = body.line(ray);
        let shift = DISPLACEMENT * body.distance(ray.origin) / body.grid.spacing();
        // By how much the time is off at which a plane across `axis` is crossed.
        let late = |axis: usize| (shift[axis] / line.slope[axis]).abs();
        // Rays begin in the eye's plane, so depth is proportional to the distance.
        let cosine = ray.direction.dot(self.forward);
        let cue = self.cue.map(|ramp| CueRamp {
            slope: ramp.slope * cosine,
            ..ramp
        });
        let off = DISPLACEMENT * body.distance(ray.origin) * cue.map_or(0.0, |r| r.slope.abs());
        let ray_on_grid = RayOnGrid {
            line: &line,
            direction: ray.direction,
            axes: body.grid.direction(),
            spacing: body.grid.spacing(),
            shift,
            cue,
            cue_error: off,
        };
        let mut search = self.surfaces.as_ref().map(Surfaces::search);
        let mut integral = GridIntegral::new(&self.look);
        integral.blur_cue(off);
        let mut inside = false;
        // The scalar of the cell before, and its coverage, where cells have their own.
        let mut before = None;
        // The same for the ends that clip planes make, and 0 for the eye.
        let planes = &self.look.clip_planes;
        let mut kept = clip_ray(planes, ray);
        kept[1] = kept[1].min(end);
        let cut = |end: f64| if end > 0.0 { self.cut(ray) } else { 0.0 };
        if let Some(walk) = Walk::new(line, body.cells, kept) {
            let exit = walk.exit;
            for stretch in walk {
                let length = stretch.t_out - stretch.t_in;
                if length <= 0.0 {
                    continue;
                }
                let (corners, covered) = match fades(self.look.model) {
                    false => (body.corners_there(stretch.cell), None),
                    true => {
                        let corners = body.corners(stretch.cell);
                        (corners, body.covered(stretch.cell, &corners))
                    }
                };
                let range = match &covered {
                    None => range(&corners),
                    Some(covered) => covered.map(|cell| cell.range),
                };
                if range.is_some() != inside {
                    integral.blur_end(stretch.across.map_or_else(|| cut(kept[0]), late));
                    inside = !inside;
                }
                let Some([low, high]) = range else {
                    search.as_mut().map(Search::gap);
                    before = None;
                    continue;
                };
                if body.has_cell_samples() {
                    let here = (low, covered.flatten().map(|cell| cell.coverage[0]));
                    if before.is_some_and(|before| before != here) {
                        integral.blur_end(stretch.across.map_or(0.0, late));
                    }
                    before = Some(here);
                    search.as_mut().map(Search::gap);
                }
                if let Some(cell) = covered.flatten() {
                    let at = |t: f64| stretch.place(&line, t);
                    let way = Way {
                        entry: at(stretch.t_in),
                        exit: at(stretch.t_out),
                        length,
                    };
                    visit(&stretch, &|| {
                        let [front, back] = cell.ends(&way);
                        Cubic([front, front, back, back])
                    });
                    if !integral.is_opaque() {
                        let cue =
                            cue.map_or(NO_CUE, |r| [stretch.t_in, stretch.t_out].map(|t| r.at(t)));
                        cell.add(&self.look, &mut integral, &way, cue);
                        cell.blur(&self.look, &mut integral, &way, shift.element_sum());
                    }
                    continue;
                }
                let scalar = || scalar(&line, &stretch, &corners, [low, high]);
                visit(&stretch, &scalar);
                let blur = blur([low, high], shift);
                if let Some(search) = &mut search {
                    let cell = CellOnRay {
                        stretch: &stretch,
                        corners: &corners,
                        range: [low, high],
                        blur,
                    };
                    search.add(&ray_on_grid, &cell, scalar);
                    continue;
                }
                if integral.is_opaque() || self.look.is_clear(low - blur, high + blur) {
                    continue;
                }
                let cubic = scalar();
                let cue = cue.map_or(NO_CUE, |r| [stretch.t_in, stretch.t_out].map(|t| r.at(t)));
                integral.add(&cubic, length, cue);
                integral.blur(&cubic, length, [low, high], blur);
            }
            if inside {
                integral.blur_end(exit.map_or_else(|| cut(kept[1]), late));
            }
        }
        if let Some(search) = search {
            return self.met(&search);
        }
        let depth = integral.optical_depth();
        Outcome {
            pixel: over(self.look.model, integral.light, depth, self.background),
            light: integral.light.to_array(),
            optical_depth: depth,
            surface_depth: f64::INFINITY,
            error: integral.error(),
            consistency: Consistency::default(),
        }
    }
}

impl GridScene<'_> {
    /// The outcome of a search for surfaces.
    fn met(&self, search: &Search) -> Outcome {
        let (light, depth, t) = match search.hit {
            Some(hit) => (hit.color, f64::INFINITY, hit.t),
            None => (DVec3::ZERO, 0.0, f64::INFINITY),
        };
        Outcome {
            pixel: over(self.look.model, light, depth, self.background),
            light: light.to_array(),
            optical_depth: depth,
            surface_depth: t,
            error: search.error(),
            consistency: Consistency::default(),
        }
    }

    /// By how much the times are off, all together, at which clip planes cross a ray.
    fn cut(&self, ray: &Ray) -> f64 {
        let planes = self.look.clip_planes.iter().map(|plane| {
            let rise = plane.normal.unit().dot(ray.direction).abs();
            // Where the plane lies counts as well as where the grid does.
            let far = self
                .body
                .distance(ray.origin)
                .max((plane.point - ray.origin).length());
            if rise > 0.0 {
                DISPLACEMENT * far / rise
            } else {
                0.0
            }
        });
        planes.sum()
    }
}

/// The least and greatest corner; `None` if one is not finite, and the cell transparent.
fn range(corners: &[f64; 8]) -> Option<[f64; 2]> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for &corner in corners {
        if !corner.is_finite() {
            return None;
        }
        (low, high) = (low.min(corner), high.max(corner));
    }
    Some([low, high])
}

/// The scalar on a stretch of the line through a cell with these corners and their `range`.
fn scalar(line: &Line, stretch: &Stretch, corners: &[f64; 8], [low, high]: [f64; 2]) -> Cubic {
    if low == high {
        return Cubic([low; 4]);
    }
    let at = |t: f64| stretch.place(line, t);
    Cubic::trilinear(corners, at(stretch.t_in), at(stretch.t_out))
}

/// By how much a scalar in a cell is off; `shift` is in voxels.
fn blur([low, high]: [f64; 2], shift: DVec3) -> f64 {
    if low == high {
        return 0.0;
    }
    let steepest = (high - low) * (shift.x + shift.y + shift.z).min(0.5);
    2.0 * steepest + INTERPOLATION * low.abs().max(high.abs())
}
