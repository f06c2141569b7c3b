//! The ground truth: BVH ray casting on the CPU in f64.
//!
//! For each ray it finds *all* cells that the ray crosses, clips the ray against
//! each, sorts the pieces by entry, and integrates each in closed form
//! ([`tetrascope_core::optics`]). It knows nothing of which cell is whose
//! neighbor, so holes, cycles, hanging nodes and overlaps cannot break it, and it
//! shares no code with the algorithms that it judges.
//!
//! 1. `geometry` builds a BVH over the cells (obvhs; f32 boxes, padded so that
//!    rounding loses nothing) and finds the cells in a frustum.
//! 2. `frame` turns the mesh into the camera's frame, in which a ray is a pair of numbers.
//! 3. `tile` asks the BVH once for each square of pixels, and tests each cell
//!    that it finds against the rays in its outline.
//! 4. `cell` says which faces a ray crosses, and where; `predicate` decides ties
//!    so that rays through vertices, along edges and in faces lose and double nothing.
//! 5. `ray` sorts, checks and integrates.
//! 6. `look` adds clip planes, depth cue and isosurfaces.
//! 7. `bound` derives the error bound that comes with each pixel.
//!
//! N. Max, P. Hanrahan, R. Crawfis, "Area and Volume Coherence for Efficient
//! Visualization of 3D Scalar Functions", 1990, cast rays through unsorted cells
//! in this way; S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle
//! Intersection", 2013, is the source of the sheared test.
//!
//! # Limits
//! Regular grids are not drawn. Where cells overlap, which no valid mesh has, their
//! pieces are integrated one after the other in the order of their entries, and
//! the pixel is counted as inconsistent.

mod bound;
mod cell;
mod frame;
mod geometry;
mod image;
mod look;
mod predicate;
mod ray;
mod tile;
mod trace;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use tetrascope_core::{
    Abilities, Appearance, Error, Frame, OpticalModel, TetMesh, View, Volume, VolumeRenderer,
};

pub use image::ReferenceImage;
pub use ray::Consistency;
pub use trace::{Interval, RayTrace};

use bound::Steepness;
use frame::RayFrame;
use geometry::Geometry;
use look::Look;
use tile::{SIDE, Scene, Workspace};

/// The name in lists and messages.
pub const NAME: &str = "reference";

/// What it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;

/// How the reference works; none of it changes a bit of the image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReferenceOptions {
    /// Threads that draw; `None` is rayon's own pool, one a core.
    pub threads: Option<usize>,
}

/// The most threads that [`ReferenceOptions`] takes.
const MAX_THREADS: usize = 1024;

/// A mesh with its BVH. Immutable between reloads.
#[derive(Clone)]
pub struct Reference {
    mesh: TetMesh,
    geometry: Arc<Geometry>,
    appearance: Appearance,
    pool: Option<Arc<rayon::ThreadPool>>,
    bvh_builds: u64,
}

impl Reference {
    /// Builds the BVH of `volume`.
    ///
    /// # Errors
    /// A grid, and a number of threads that is zero or that the system refuses.
    pub fn new(
        volume: &Volume,
        appearance: &Appearance,
        options: &ReferenceOptions,
    ) -> Result<Reference, Error> {
        ABILITIES.check(NAME, appearance)?;
        let mesh = mesh_of(volume)?;
        let pool = match options.threads {
            None => None,
            Some(threads) if (1..=MAX_THREADS).contains(&threads) => {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().map_err(|error| {
                    Error::invalid(format!("cannot start {threads} threads: {error}"))
                })?;
                Some(Arc::new(pool))
            }
            Some(threads) => {
                return Err(Error::Invalid {
                    what: format!("{threads} threads"),
                    help: Some(format!("give 1 to {MAX_THREADS}")),
                });
            }
        };
        Ok(Reference {
            mesh: mesh.clone(),
            geometry: Arc::new(Geometry::new(mesh)),
            appearance: appearance.clone(),
            pool,
            bvh_builds: 1,
        })
    }

    /// Draws a view in f64.
    ///
    /// # Errors
    /// A view that [`View::validate`] refuses, and a camera so far away that
    /// distances overflow.
    pub fn render_exact(&self, view: &View) -> Result<ReferenceImage, Error> {
        self.render_with_progress(view, &|_| {})
    }

    /// Draws a view in f64, calling `on_progress` with the share that is done,
    /// increasing to 1, from any thread.
    ///
    /// # Errors
    /// As [`Reference::render_exact`].
    pub fn render_with_progress(
        &self,
        view: &View,
        on_progress: &(dyn Fn(f64) + Sync),
    ) -> Result<ReferenceImage, Error> {
        match &self.pool {
            Some(pool) => pool.install(|| self.draw(view, on_progress)),
            None => self.draw(view, on_progress),
        }
    }

    fn draw(
        &self,
        view: &View,
        on_progress: &(dyn Fn(f64) + Sync),
    ) -> Result<ReferenceImage, Error> {
        let start = Instant::now();
        view.validate()?;
        let (frame, grid) = RayFrame::of_view(view, &self.geometry)?;
        let background = view.premultiplied_background();
        let positions = frame.positions(&self.mesh);
        let scene = Scene {
            mesh: &self.mesh,
            geometry: &self.geometry,
            appearance: &self.appearance,
            steepness: Steepness::new(&self.appearance, background),
            look: Look::new(&self.appearance, &self.mesh.bounds(), &frame),
            frame,
            background,
        };
        let side = SIDE as u32;
        let across = view.width.div_ceil(side);
        let tiles = across * view.height.div_ceil(side);
        let done = AtomicUsize::new(0);
        let drawn: Vec<_> = (0..tiles)
            .into_par_iter()
            .map_init(Workspace::default, |workspace, tile| {
                let (column, row) = (tile % across * side, tile / across * side);
                let columns = column..view.width.min(column + side);
                let rows = row..view.height.min(row + side);
                let pixels = tile::draw(
                    &scene,
                    &positions,
                    &grid,
                    columns.clone(),
                    rows.clone(),
                    workspace,
                );
                let done = done.fetch_add(1, Ordering::Relaxed) + 1;
                on_progress(done as f64 / f64::from(tiles));
                image::Part::new(columns, rows, pixels)
            })
            .collect();
        let has_depths = self.appearance.optical_model == OpticalModel::Isosurfaces;
        let mut image = ReferenceImage::assemble(view, &drawn, has_depths);
        image.bytes_resident = self.bytes_resident();
        image.seconds = start.elapsed().as_secs_f64();
        Ok(image)
    }

    /// How many times a BVH was built: once, and again for each volume with
    /// another geometry that was loaded since.
    pub fn bvh_builds(&self) -> u64 {
        self.bvh_builds
    }

    /// Bytes of the BVH and of the mesh in its order.
    fn bytes_resident(&self) -> u64 {
        self.geometry.bytes() as u64
    }
}

impl VolumeRenderer for Reference {
    /// Keeps the BVH where the geometry is the same ([`TetMesh::shares_geometry`]).
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let mesh = mesh_of(volume)?;
        if !mesh.shares_geometry(&self.mesh) {
            self.geometry = Arc::new(Geometry::new(mesh));
            self.bvh_builds += 1;
        }
        self.mesh = mesh.clone();
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        ABILITIES.check(NAME, appearance)?;
        self.appearance = appearance.clone();
        Ok(())
    }

    /// [`Reference::render_exact`], rounded to f32; the error bound includes that rounding.
    fn render(&self, view: &View) -> Result<Frame, Error> {
        Ok(self.render_exact(view)?.to_frame())
    }
}

fn mesh_of(volume: &Volume) -> Result<&TetMesh, Error> {
    match volume {
        Volume::Mesh(mesh) => Ok(mesh),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "a regular grid".into(),
            reason: "it clips rays against tetrahedra, and a grid has none".into(),
        }),
    }
}
