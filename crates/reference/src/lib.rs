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
//! 8. `pixels` draws chosen pixels alone, by the same code.
//! 9. `grid` does all of it for regular grids: trilinear interpolation, a cubic in each
//!    voxel cell, split at knots and integrated by Gauss–Legendre rules; isosurfaces are
//!    its roots, lit by the interpolant's gradient. Grids with coverage, too.
//!
//! N. Max, P. Hanrahan, R. Crawfis, "Area and Volume Coherence for Efficient
//! Visualization of 3D Scalar Functions", 1990, cast rays through unsorted cells
//! in this way; S. Woop, C. Benthin, I. Wald, "Watertight Ray/Triangle
//! Intersection", 2013, is the source of the sheared test.
//!
//! # Limits
//! Where cells overlap, which no valid mesh has, their
//! pieces are integrated one after the other in the order of their entries, and
//! the pixel is counted as inconsistent.
//!
//! # A picture and its error bound
//! ```
//! use tetrascope_core::glam::DVec3;
//! use tetrascope_core::mesh::Association;
//! use tetrascope_core::{Appearance, Camera, CameraFit, Knot, OpticalModel, Scalars};
//! use tetrascope_core::{TetMesh, TransferFunction, View, Volume, view};
//! use tetrascope_reference::{Reference, ReferenceOptions};
//!
//! // A tetrahedron of constant extinction 2 that is 1 deep along z at the z axis.
//! let points = vec![DVec3::new(-1.0, -1.0, 0.0), DVec3::X, DVec3::Y, DVec3::Z];
//! let scalars = Scalars {
//!     name: "density".into(),
//!     association: Association::Point,
//!     values: vec![1.0; 4],
//! };
//! let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars)?;
//! let volume = Volume::Mesh(mesh);
//! let knot = Knot { scalar: 1.0, color: DVec3::ONE, extinction: 2.0 };
//! let colors = TransferFunction::new(vec![knot])?;
//! let appearance = Appearance::new(colors, OpticalModel::EmissionAbsorption);
//!
//! let renderer = Reference::new(&volume, &appearance, &ReferenceOptions::default())?;
//! let image = renderer.render_exact(&View {
//!     camera: Camera {
//!         focal_point: DVec3::ZERO, // the axis goes through the middle of the picture
//!         position: DVec3::new(0.0, 0.0, 5.0),
//!         ..Camera::fit(&volume.bounds(), CameraFit::PlusZ, true, 1.0)
//!     },
//!     width: 65,
//!     height: 65,
//!     background: view::TRANSPARENT,
//! })?;
//! let (opacity, bound) = (image.pixel(32, 32)[3], image.error_bound[32 * 65 + 32]);
//! assert!((opacity - (1.0 - (-2.0_f64).exp())).abs() <= bound);
//! assert!(bound < 1e-9); // f32 would round by up to 3e-8
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

mod bound;
mod cell;
pub mod counters;
mod frame;
mod geometry;
mod grid;
mod image;
mod look;
mod pixels;
mod predicate;
mod ray;
mod tile;
mod trace;

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use rayon::prelude::*;
use tetrascope_core::scalar_units::Floats;
use tetrascope_core::{
    Abilities, Appearance, Entry, Error, Frame, OpticalModel, Promise, ScalarUnits, Stop, TetMesh,
    View, Volume, VolumeRenderer,
};

pub use image::ReferenceImage;
pub use pixels::ReferencePixels;
pub use ray::Consistency;
pub use trace::{Interval, RayTrace};

use bound::Steepness;
use frame::RayFrame;
use geometry::Geometry;
use grid::GridBody;
use look::Look;
use ray::Outcome;
use tile::{SIDE, Scene, Workspace};

/// The name in lists and messages.
pub const NAME: &str = "reference";

/// The parts of an appearance that it draws beyond the volumetric optical models, of meshes and of regular grids.
pub const ABILITIES: Abilities = Abilities::ALL;

/// This algorithm's entry.
pub const ENTRY: Entry = Entry {
    name: NAME,
    title: "exact BVH ray casting, the ground truth",
    paper: "N. Max, \"Optical Models for Direct Volume Rendering\", IEEE Transactions on \
            Visualization and Computer Graphics 1(2), 1995, pp. 99-108, doi:10.1109/2945.468400",
    draws: "any mesh, non-convex, cyclic or overlapping too, and any regular grid in memory, in \
            every optical model, with depth cue and clip planes, in f64 with an error bound",
    settings: &[],
    sweep: |_| &[""],
    sources: &[],
    figures: None,
    promise: |_| Promise::Truth,
    counters: counters::ALL,
    supports: |volume, appearance, _, _| supports(volume, appearance),
};

/// How the reference works; none of it changes a bit of the image.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReferenceOptions {
    /// Threads that draw; `None` is rayon's own pool, one a core.
    pub threads: Option<usize>,
}

/// The most threads that [`ReferenceOptions`] takes.
const MAX_THREADS: usize = 1024;

/// A mesh with its BVH, or a grid. Immutable between reloads.
#[derive(Clone)]
pub struct Reference {
    body: Body,
    appearance: Appearance,
    /// The same in the body's units, which a reload may change.
    look: Appearance,
    pool: Option<Arc<rayon::ThreadPool>>,
    stop: Stop,
    bvh_builds: u64,
}

/// The body that rays are cast through.
#[derive(Clone)]
enum Body {
    Mesh {
        /// In `units`.
        mesh: TetMesh,
        units: ScalarUnits,
        geometry: Arc<Geometry>,
    },
    Grid(Box<GridBody>),
}

impl Reference {
    /// Builds the BVH of a mesh; a grid needs none.
    ///
    /// # Errors
    /// A number of threads that is zero or that the system refuses.
    pub fn new(
        volume: &Volume,
        appearance: &Appearance,
        options: &ReferenceOptions,
    ) -> Result<Reference, Error> {
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
        supports(volume, appearance)?;
        let (body, bvh_builds) = Body::of(volume, None)?;
        Ok(Reference {
            look: body.look(appearance),
            body,
            appearance: appearance.clone(),
            pool,
            stop: Stop::new(),
            bvh_builds,
        })
    }

    /// The same; pictures end early with [`Error::Stopped`] where `stop` asks for it.
    pub fn with_stop(self, stop: Stop) -> Reference {
        Reference { stop, ..self }
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
        self.in_pool(|| self.draw(view, None, on_progress))
    }

    /// Draws what is before opaque things: each ray ends where `ends` says, world units from
    /// where it starts, infinite where it does not; row-major, top row first.
    ///
    /// # Errors
    /// As [`Reference::render_exact`], and [`Error::Invalid`] unless `ends` has a number for each
    /// pixel.
    pub fn render_before(&self, view: &View, ends: &[f64]) -> Result<ReferenceImage, Error> {
        self.in_pool(|| self.draw(view, Some(ends), &|_| {}))
    }

    fn in_pool<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.pool {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    fn draw(
        &self,
        view: &View,
        ends: Option<&[f64]>,
        on_progress: &(dyn Fn(f64) + Sync),
    ) -> Result<ReferenceImage, Error> {
        let start = Instant::now();
        view.validate()?;
        let pixels = view.width as usize * view.height as usize;
        if ends.is_some_and(|ends| ends.len() != pixels || ends.iter().any(|e| e.is_nan())) {
            return Err(Error::invalid(format!(
                "ends of rays that are not one number for each of {pixels} pixels"
            )));
        }
        let end_of = |column: u32, row: u32| {
            let pixel = row as usize * view.width as usize + column as usize;
            ends.map_or(f64::INFINITY, |ends| ends[pixel])
        };
        view.check_memory(BYTES_PER_PIXEL)?;
        let has_depths = self.look.optical_model == OpticalModel::Isosurfaces;
        let mut image = ReferenceImage::new(view, has_depths);
        let put = |part: &image::Part| image.add(part);
        self.with_tiles(view, &end_of, |draw| {
            in_tiles(view, (on_progress, &self.stop), draw, put)
        })??;
        image.bytes_resident = self.bytes_resident();
        image.seconds = start.elapsed().as_secs_f64();
        Ok(image)
    }

    /// Runs `work` with what draws the pixels in columns and rows of this view.
    fn with_tiles<T>(
        &self,
        view: &View,
        end_of: &(dyn Fn(u32, u32) -> f64 + Sync),
        work: impl FnOnce(&DrawTile) -> T,
    ) -> Result<T, Error> {
        let background = view.premultiplied_background();
        match &self.body {
            Body::Mesh { mesh, geometry, .. } => {
                let (frame, grid) = RayFrame::of_view(view, geometry)?;
                let positions = frame.positions(mesh);
                let scene = Scene {
                    mesh,
                    geometry,
                    appearance: &self.look,
                    steepness: Steepness::new(&self.look, background),
                    look: Look::new(&self.look, &mesh.bounds(), &frame),
                    frame,
                    background,
                };
                Ok(work(&|columns, rows, workspace| {
                    tile::draw(&scene, &positions, &grid, columns, rows, end_of, workspace)
                }))
            }
            Body::Grid(grid) => {
                grid.check_eye(view.camera.position)?;
                let (_, _, forward) = view.camera.axes();
                let camera = (view.camera.position, forward);
                let scene = grid.scene(&self.look, camera, background);
                Ok(work(&|columns, rows, _| {
                    scene.draw(view, columns, rows, end_of)
                }))
            }
        }
    }

    /// How many times a BVH was built: once for each mesh with another geometry
    /// that was loaded.
    pub fn bvh_builds(&self) -> u64 {
        self.bvh_builds
    }

    /// Bytes of the BVH and of the mesh in its order, or of the samples.
    fn bytes_resident(&self) -> u64 {
        match &self.body {
            Body::Mesh { geometry, .. } => geometry.bytes() as u64,
            Body::Grid(grid) => grid.bytes(),
        }
    }
}

impl VolumeRenderer for Reference {
    /// Keeps the BVH where the geometry is the same ([`TetMesh::shares_geometry`]).
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        supports(volume, &self.appearance)?;
        let (body, built) = Body::of(volume, Some(&self.body))?;
        self.look = body.look(&self.appearance);
        self.body = body;
        self.bvh_builds += built;
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        match &self.body {
            Body::Mesh { mesh, .. } => ABILITIES.check(NAME, appearance, &mesh.bounds())?,
            Body::Grid(body) => supports(&Volume::Grid(body.grid().clone()), appearance)?,
        }
        self.look = self.body.look(appearance);
        self.appearance = appearance.clone();
        Ok(())
    }

    /// [`Reference::render_exact`], rounded to f32; the error bound includes that rounding.
    fn render(&self, view: &View) -> Result<Frame, Error> {
        Ok(self.render_exact(view)?.to_frame())
    }
}

/// Refuses what is not drawn: parts of an appearance, and a grid that stays in its file.
///
/// # Errors
/// [`Error::Unsupported`] with the reason, and what [`Appearance::validate_in`] refuses.
pub fn supports(volume: &Volume, appearance: &Appearance) -> Result<(), Error> {
    match volume {
        Volume::Mesh(_) | Volume::Grid(_) => ABILITIES.check(NAME, appearance, &volume.bounds()),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "a volume that stays in its file".into(),
            reason: "its rays need all of it in memory".into(),
        }),
    }
}

impl Body {
    /// The appearance in the body's units.
    fn look(&self, appearance: &Appearance) -> Appearance {
        match self {
            Body::Mesh { units, .. } => units.appearance(appearance),
            Body::Grid(_) => appearance.clone(),
        }
    }

    /// The body of `volume`, with the BVH of a body `before` where that fits, and how many
    /// were built.
    fn of(volume: &Volume, before: Option<&Body>) -> Result<(Body, u64), Error> {
        match volume {
            Volume::Mesh(new) => {
                let (geometry, built) = match before {
                    Some(Body::Mesh { mesh, geometry, .. }) if new.shares_geometry(mesh) => {
                        (geometry.clone(), 0)
                    }
                    _ => (Arc::new(Geometry::new(new)), 1),
                };
                let units = ScalarUnits::of_range(new.scalar_range(), Floats::F64);
                let mesh = units.mesh(new);
                let body = Body::Mesh {
                    mesh,
                    units,
                    geometry,
                };
                Ok((body, built))
            }
            Volume::Grid(grid) => Ok((Body::Grid(Box::new(GridBody::new(grid))), 0)),
            _ => Err(Error::invalid("a volume that `supports` refuses")),
        }
    }
}

/// Bytes for a pixel: its color, bound and depth, and the same as part of a frame.
const BYTES_PER_PIXEL: u64 = 32 + 8 + 8 + 16 + 4;

/// Tiles that are drawn before they are put in their places: a million pixels, so that
/// large images do not take twice their memory.
const BAND: u32 = 4096;

/// Draws the pixels in columns and rows, row by row, at most [`SIDE`] each; with each goes how
/// many cells its ray has met.
type DrawTile<'a> =
    dyn Fn(Range<u32>, Range<u32>, &mut Workspace) -> Vec<(Outcome, usize)> + Sync + 'a;

/// Draws the tiles of an image, on all threads; `put` gets the parts in order.
fn in_tiles(
    view: &View,
    (on_progress, stop): (&(dyn Fn(f64) + Sync), &Stop),
    draw: &DrawTile,
    mut put: impl FnMut(&image::Part),
) -> Result<(), Error> {
    let side = SIDE as u32;
    let across = view.width.div_ceil(side);
    let tiles = across * view.height.div_ceil(side);
    let done = AtomicUsize::new(0);
    let draw = |workspace: &mut Workspace, tile: u32| {
        stop.check()?;
        let (column, row) = (tile % across * side, tile / across * side);
        let columns = column..view.width.min(column + side);
        let rows = row..view.height.min(row + side);
        let pixels = draw(columns.clone(), rows.clone(), workspace);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        on_progress(done as f64 / f64::from(tiles));
        Ok(image::Part::new(columns, rows, pixels))
    };
    for first in (0..tiles).step_by(BAND as usize) {
        let band = (first..tiles.min(first + BAND)).into_par_iter();
        let parts = band.map_init(Workspace::default, draw);
        let parts = parts.collect::<Result<Vec<_>, Error>>()?;
        parts.iter().for_each(&mut put);
    }
    Ok(())
}
