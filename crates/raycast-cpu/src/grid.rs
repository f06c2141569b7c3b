//! Regular grids: the integral of each voxel cell in which something shows.
//!
//! On a ray the scalar is a cubic in each cell.
//!
//! 1. [`tree`] keeps the range of scalars in each brick and says which cells show in an
//!    appearance ([`shows`]).
//! 2. [`rays`] takes the rays of a view into the space of cells, and [`walk`] leads each from one
//!    cell that shows to the next.
//! 3. [`packet`] integrates the cells of eight rays at once in f32, with a [`table`] of the
//!    transfer function.
//! 4. [`exact`] does so in f64 for grids with coverage and for the greatest color under a depth
//!    cue; [`surface`] finds isosurfaces.
//!
//! # Precision
//! Where a ray enters and leaves a cell is found in f64; both places are relative to the cell
//! when they become f32. So precision depends neither on the grid's size nor on where it lies.

mod cubic;
mod exact;
mod field;
mod gathered;
mod packet;
mod pieces;
mod rays;
mod shows;
mod surface;
mod table;
mod tree;
mod walk;

use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use tetrascope_core::glam::DMat3;
use tetrascope_core::grid::coverage::fades;
use tetrascope_core::{Appearance, Error, Frame, FrameStats, Grid, OpticalModel, Stop, View};

use crate::counters;
use crate::options::RaycastCpuOptions;
use exact::{Exact, Way};
use field::Field;
use gathered::{Finish, Gathered, Pixel};
use packet::{Shared, Square, Work};
use pieces::Pieces;
use rays::{PixelRay, Rays};
use shows::Shows;
use surface::{Search, Surfaces};
use table::Table;
use tree::Tree;
use walk::Walk;

/// Pixels along each side of the squares that threads take.
const TILE: u32 = 32;

/// A grid in bricks.
#[derive(Debug)]
pub(crate) struct Caster {
    field: Field,
    tree: Tree,
    /// The inverse of the grid's direction matrix.
    turn: DMat3,
    appearance: Appearance,
    pieces: Pieces,
    table: Table,
    options: RaycastCpuOptions,
    level: Level,
}

/// Data that the tiles of a frame share.
struct Scene<'a> {
    caster: &'a Caster,
    rays: Rays<'a>,
    finish: Finish,
    exact: Exact<'a>,
    surfaces: Option<Surfaces>,
}

impl Caster {
    pub(crate) fn new(
        grid: &Grid,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Result<Caster, Error> {
        let field = Field::new(grid);
        let pieces = Pieces::new(&appearance.transfer_function);
        let mut caster = Caster {
            tree: Tree::new(&field)?,
            turn: grid.direction().inverse(),
            appearance: appearance.clone(),
            table: Table::new(appearance, &pieces, &field, options.tolerance),
            pieces,
            options: options.clone(),
            level: Level::new(),
            field,
        };
        caster.restyle(appearance)?;
        Ok(caster)
    }

    /// Draws with other instructions than the best there are.
    #[cfg(test)]
    pub(crate) fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    pub(crate) fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        self.pieces = Pieces::new(&appearance.transfer_function);
        let shows = Shows::new(appearance, &self.pieces, self.field.fills_cells);
        self.tree.restyle(&self.field, &shows);
        let tolerance = self.options.tolerance;
        self.table = Table::new(appearance, &self.pieces, &self.field, tolerance);
        self.appearance = appearance.clone();
        Ok(())
    }

    /// Draws a valid view; each ray ends where `ends` says, world units, one per pixel.
    pub(crate) fn draw(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        stop: &Stop,
    ) -> Result<Frame, Error> {
        self.check_eye(view)?;
        let grid = &self.field.grid;
        let model = self.appearance.optical_model;
        let rays = Rays::new(view, grid, self.turn, &self.appearance, ends);
        let axes = (grid.direction(), grid.spacing());
        let surfaces = || Surfaces::new(&self.appearance, rays.forward(), axes);
        let scene = Scene {
            caster: self,
            finish: Finish::new(model, view),
            exact: Exact {
                pieces: &self.pieces,
                model,
                tolerance: self.options.tolerance,
                stop_depth: self.stop_depth(),
            },
            surfaces: (model == OpticalModel::Isosurfaces).then(surfaces),
            rays,
        };
        let [columns, rows] = [view.width, view.height].map(|side| side.div_ceil(TILE));
        let visits = AtomicU64::new(0);
        let skipped = AtomicU64::new(0);
        let tiles = (0..columns * rows)
            .into_par_iter()
            .map(|tile| {
                stop.check()?;
                let (pixels, work) = scene.tile(view, [tile % columns, tile / columns]);
                visits.fetch_add(work.visits, Ordering::Relaxed);
                skipped.fetch_add(work.skipped, Ordering::Relaxed);
                Ok(pixels)
            })
            .collect::<Result<Vec<Vec<Pixel>>, Error>>()?;
        let count = view.width as usize * view.height as usize;
        let mut pixels = vec![[0.0; 4]; count];
        let mut depths = vec![0.0; count];
        for (tile, found) in (0..).zip(tiles) {
            let ([x, y], [width, _]) = square(view, [tile % columns, tile / columns]);
            for (i, (pixel, depth)) in (0..).zip(found) {
                let (column, row) = (x + i % width, y + i / width);
                let at = row as usize * view.width as usize + column as usize;
                (pixels[at], depths[at]) = (pixel, depth);
            }
        }
        let mut stats = FrameStats::default();
        stats.count(counters::CELL_VISITS, visits.into_inner());
        stats.count(counters::CELLS_SKIPPED, skipped.into_inner());
        stats.bytes_resident = self.field.bytes() + self.tree.bytes();
        let mut frame = Frame::new((view.width, view.height), pixels, stats);
        frame.depths = Some(depths);
        Ok(frame)
    }

    /// The optical depth behind which rays stop.
    ///
    /// The optical depth at which a ray stops. All that is behind counts as one more segment, whose
    /// light may be off by the tolerance, too; a quarter of it is left to what is before.
    fn stop_depth(&self) -> f64 {
        let unseen = -(0.25 * self.options.tolerance).ln();
        f64::from(self.options.stop_depth()).min(unseen)
    }

    /// Refuses an eye from which distances overflow.
    fn check_eye(&self, view: &View) -> Result<(), Error> {
        let grid = &self.field.grid;
        let way = (grid.origin() - view.camera.position).length();
        let far = way + grid.bounds().diagonal();
        if far.is_nan() || far > f64::MAX / 16.0 {
            return Err(Error::Invalid {
                what: format!("the camera is {far:e} away from the grid"),
                help: Some("move it closer".into()),
            });
        }
        Ok(())
    }
}

/// The first pixel of a tile, and its size.
fn square(view: &View, [column, row]: [u32; 2]) -> ([u32; 2], [u32; 2]) {
    let first = [column * TILE, row * TILE];
    let size = [view.width - first[0], view.height - first[1]].map(|rest| rest.min(TILE));
    (first, size)
}

impl Scene<'_> {
    /// Whether [`packet`] draws this.
    fn in_packets(&self) -> bool {
        let has_coverage = self.caster.field.grid.coverage().is_some();
        match self.finish.model {
            OpticalModel::Isosurfaces => false,
            OpticalModel::MaximumIntensity => !self.rays.is_cued(),
            _ => !has_coverage,
        }
    }

    /// Draws a tile, row by row.
    fn tile(&self, view: &View, tile: [u32; 2]) -> (Vec<Pixel>, Work) {
        let ([x, y], [width, height]) = square(view, tile);
        if self.in_packets() {
            let shared = Shared {
                field: &self.caster.field,
                tree: &self.caster.tree,
                table: &self.caster.table,
                rays: &self.rays,
                finish: self.finish,
                stop_depth: self.exact.stop_depth as f32,
            };
            let square = Square {
                first: [x, y],
                size: [width, height],
            };
            return dispatch!(self.caster.level, simd => packet::draw(simd, &shared, square));
        }
        let mut work = Work::default();
        let pixels = (0..width * height).map(|i| {
            let ray = self.rays.ray(x + i % width, y + i / width);
            match &self.surfaces {
                Some(surfaces) => self.search(surfaces, &ray, &mut work),
                None => self.follow(&ray, &mut work),
            }
        });
        (pixels.collect(), work)
    }

    /// Looks for the first surface on a ray.
    fn search(&self, surfaces: &Surfaces, ray: &PixelRay, work: &mut Work) -> Pixel {
        let Caster { field, tree, .. } = self.caster;
        let mut hit = None;
        if let Some(mut walk) = Walk::new(ray.line, tree, ray.kept) {
            let mut search = Search::default();
            while hit.is_none()
                && let Some(stretch) = walk.next(tree)
            {
                work.visits += 1;
                let corners = field.corners_there(stretch.cell);
                let on_ray = (&ray.line, ray.direction, ray.cue);
                hit = search.add(surfaces, on_ray, &stretch, &corners);
            }
            work.skipped += walk.skipped;
        }
        match hit {
            Some(hit) => (self.finish.pixel(hit.color, f64::INFINITY), hit.t as f32),
            None => (self.finish.pixel(Default::default(), 0.0), f32::INFINITY),
        }
    }

    /// Gathers what a ray meets, cell by cell in f64.
    fn follow(&self, ray: &PixelRay, work: &mut Work) -> Pixel {
        let Caster { field, tree, .. } = self.caster;
        let mut gathered = Gathered::default();
        if let Some(mut walk) = Walk::new(ray.line, tree, ray.kept) {
            while gathered.depth.value() <= self.exact.stop_depth
                && let Some(stretch) = walk.next(tree)
            {
                work.visits += 1;
                let (corners, coverages) = match fades(self.exact.model) {
                    true => {
                        let coverages = field.coverages(stretch.cell);
                        (field.corners(stretch.cell).map(f64::from), coverages)
                    }
                    false => (field.corners_there(stretch.cell), None),
                };
                let way = Way {
                    entry: stretch.clamped(&ray.line, stretch.t_in),
                    exit: stretch.clamped(&ray.line, stretch.t_out),
                    length: stretch.t_out - stretch.t_in,
                    cue: match ray.cue {
                        Some(ramp) => [stretch.t_in, stretch.t_out].map(|t| ramp.at(t)),
                        None => [1.0; 2],
                    },
                };
                let coverages = coverages.unwrap_or([1.0; 8]);
                self.exact.add(&corners, &coverages, &way, &mut gathered);
            }
            work.skipped += walk.skipped;
        }
        let pixel = self.finish.pixel(gathered.light, gathered.depth.value());
        (pixel, f32::INFINITY)
    }
}
