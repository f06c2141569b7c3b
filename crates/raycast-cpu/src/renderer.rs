//! The renderer, of a mesh or of a grid.

use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use tetrascope_core::{
    Appearance, Bounds, Error, Frame, FrameStats, OpticalModel, Stop, View, Volume, VolumeRenderer,
};

use crate::clusters::Tile;
use crate::entry::supports;
use crate::options::RaycastCpuOptions;
use crate::segments::PathSegments;
use crate::{ABILITIES, NAME, clusters, grid, mesh};

/// A packed volume. It draws without any device.
#[derive(Debug)]
pub struct RaycastCpu {
    body: Body,
    bounds: Bounds,
    appearance: Appearance,
    options: RaycastCpuOptions,
    pool: Option<Arc<rayon::ThreadPool>>,
    stop: Stop,
}

/// The body that rays are cast through.
#[derive(Debug)]
enum Body {
    Mesh(Box<mesh::Caster>),
    Clusters(Box<clusters::Caster>),
    Grid(Box<grid::Caster>),
}

/// The most threads that [`RaycastCpuOptions`] takes.
const MAX_THREADS: usize = 1024;

impl RaycastCpu {
    /// A renderer of a mesh, in memory or in clusters, or of a grid in memory.
    ///
    /// # Errors
    /// Refusals of [`supports`], an option out of its range, and threads that the system refuses.
    pub fn new(
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Result<RaycastCpu, Error> {
        options.validate()?;
        supports(volume, appearance)?;
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
        Ok(RaycastCpu {
            body: in_pool(&pool, || Body::new(volume, appearance, options))?,
            bounds: volume.bounds(),
            appearance: appearance.clone(),
            options: options.clone(),
            pool,
            stop: Stop::new(),
        })
    }

    /// The same; frames end early with [`Error::Stopped`] where `stop` asks for it.
    pub fn with_stop(self, stop: Stop) -> RaycastCpu {
        RaycastCpu { stop, ..self }
    }

    /// Draws what is before opaque things: each ray ends where `ends` says, world units from
    /// where it starts, infinite where it does not; row-major, top row first.
    ///
    /// # Errors
    /// As [`VolumeRenderer::render`], and [`Error::Invalid`] unless `ends` has a number for each
    /// pixel.
    pub fn render_before(&self, view: &View, ends: &[f64]) -> Result<Frame, Error> {
        self.draw(view, Some(ends))
    }

    /// The paths of a view's rays through a mesh, each by itself: of a part of a mesh, so that
    /// [`PathSegments::composite`] draws the whole.
    ///
    /// # Errors
    /// As [`VolumeRenderer::render`]; a grid is unsupported.
    pub fn segments(&self, view: &View) -> Result<PathSegments, Error> {
        view.validate()?;
        match &self.body {
            Body::Mesh(caster) => in_pool(&self.pool, || caster.segments(view, &self.stop)),
            Body::Clusters(caster) => in_pool(&self.pool, || caster.segments(view, &self.stop)),
            Body::Grid(_) => Err(Error::Unsupported {
                renderer: NAME,
                what: "paths through a grid".into(),
                reason: "a ray has one way through it".into(),
            }),
        }
    }

    /// Runs that a view's rays gather in some rows of tiles ([`Tile::grid`]) of a mesh in clusters, and the counts of it: of a
    /// part of a mesh, so that the tiles of all parts, added to each other ([`Tile::add_runs`]), are the whole's.
    ///
    /// `None` if these are several rows and would take more than `room` bytes of runs.
    ///
    /// # Errors
    /// As [`VolumeRenderer::render`]; [`Error::Invalid`] for rows that the picture does not have; what is not in clusters
    /// is unsupported.
    pub fn tiles(
        &self,
        view: &View,
        rows: Range<usize>,
        room: u64,
    ) -> Result<Option<(Vec<Tile>, FrameStats)>, Error> {
        view.validate()?;
        if rows.end > Tile::grid(view)[1] {
            return Err(Error::invalid("rows of tiles beyond the picture"));
        }
        match &self.body {
            Body::Clusters(caster) => {
                in_pool(&self.pool, || caster.tiles_of(view, rows, room, &self.stop))
            }
            _ => Err(Error::Unsupported {
                renderer: NAME,
                what: "tiles of a volume in one part".into(),
                reason: "they are of a mesh in clusters".into(),
            }),
        }
    }

    fn draw(&self, view: &View, ends: Option<&[f64]>) -> Result<Frame, Error> {
        let start = Instant::now();
        view.validate()?;
        let pixels = view.width as usize * view.height as usize;
        if ends.is_some_and(|ends| ends.len() != pixels || ends.iter().any(|e| e.is_nan())) {
            return Err(Error::invalid(format!(
                "ends of rays that are not one number for each of {pixels} pixels"
            )));
        }
        view.check_memory(BYTES_PER_PIXEL)?;
        let mut frame = in_pool(&self.pool, || match &self.body {
            Body::Mesh(caster) => caster.draw(view, ends, &self.stop),
            Body::Clusters(caster) => caster.draw(view, ends, &self.stop),
            Body::Grid(caster) => caster.draw(view, ends, &self.stop),
        })?;
        if self.appearance.optical_model != OpticalModel::Isosurfaces {
            frame.depths = None;
        }
        frame.stats.cpu_seconds = start.elapsed().as_secs_f64();
        Ok(frame)
    }
}

/// Bytes for a pixel: its color and depth in a block and in the frame.
const BYTES_PER_PIXEL: u64 = 2 * (16 + 4);

fn in_pool<T: Send>(pool: &Option<Arc<rayon::ThreadPool>>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

impl Body {
    fn new(
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastCpuOptions,
    ) -> Result<Body, Error> {
        Ok(match volume {
            Volume::Mesh(mesh) => {
                Body::Mesh(Box::new(mesh::Caster::new(mesh, appearance, options)?))
            }
            Volume::Clusters(clusters) => Body::Clusters(Box::new(clusters::Caster::new(
                clusters, appearance, options,
            )?)),
            Volume::Grid(grid) => {
                Body::Grid(Box::new(grid::Caster::new(grid, appearance, options)?))
            }
            _ => return Err(Error::invalid("a volume that `supports` refuses")),
        })
    }
}

impl VolumeRenderer for RaycastCpu {
    /// Keeps the packed mesh where the geometry is the same
    /// ([`TetMesh::shares_geometry`](tetrascope_core::TetMesh::shares_geometry)).
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        supports(volume, &self.appearance)?;
        let (body, appearance, options) = (&self.body, &self.appearance, &self.options);
        let new = in_pool(&self.pool, || match (body, volume) {
            (Body::Mesh(caster), Volume::Mesh(mesh)) => caster
                .reloaded(mesh)
                .map(|caster| Body::Mesh(Box::new(caster))),
            _ => Body::new(volume, appearance, options),
        })?;
        self.body = new;
        self.bounds = volume.bounds();
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        ABILITIES.check(NAME, appearance, &self.bounds)?;
        let body = &mut self.body;
        in_pool(&self.pool, || match body {
            Body::Mesh(caster) => caster.restyle(appearance),
            Body::Clusters(caster) => {
                caster.restyle(appearance);
                Ok(())
            }
            Body::Grid(caster) => caster.restyle(appearance),
        })?;
        self.appearance = appearance.clone();
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        self.draw(view, None)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;
    use tetrascope_core::{CameraFit, OpticalModel};
    use tetrascope_testing::{data_set, fitted, grid, ramp, surfaces};

    use super::*;

    #[test]
    fn a_frame_stops_when_asked_and_the_next_is_whole() {
        let mesh = Volume::Mesh(data_set("sphere", Some(600)));
        let place = tetrascope_testing::Place::unit(8);
        let grid = Volume::Grid(grid(&place, |p| p.x + p.y * p.z));
        for volume in [mesh, grid] {
            let stop = Stop::new();
            let options = RaycastCpuOptions::default();
            let rays = RaycastCpu::new(&volume, &ramp(&volume), &options).expect("a volume");
            let rays = rays.with_stop(stop.clone());
            let view = fitted(&volume, CameraFit::PlusIso, false, 48);
            let whole = rays.render(&view).expect("a frame");
            stop.set();
            assert!(matches!(rays.render(&view), Err(Error::Stopped)));
            if matches!(volume, Volume::Mesh(_)) {
                assert!(matches!(rays.segments(&view), Err(Error::Stopped)));
            }
            stop.clear();
            let again = rays.render(&view).expect("a frame");
            assert_eq!(again.pixels, whole.pixels);
        }
    }

    /// The instructions that every processor of its kind has draw the same as those that this one has: vectors of other
    /// widths, and without fused products.
    #[test]
    fn instruction_sets_agree() {
        let mesh = Volume::Mesh(data_set("torus", Some(3000)));
        let place = tetrascope_testing::Place::unit(12);
        let grid = Volume::Grid(grid(&place, |p| (3.0 * p.x).sin() + p.y * p.z));
        for volume in [mesh, grid] {
            for model in OpticalModel::ALL {
                let appearance = Appearance {
                    optical_model: model,
                    ..surfaces(&volume, ramp(&volume))
                };
                let options = RaycastCpuOptions::default();
                let mut rays = RaycastCpu::new(&volume, &appearance, &options).expect("a volume");
                let view = fitted(&volume, CameraFit::PlusIso, false, 48);
                let wide = rays.render(&view).expect("a frame");
                match &mut rays.body {
                    Body::Mesh(caster) => caster.set_level(Level::baseline()),
                    Body::Clusters(_) => panic!("it is in memory"),
                    Body::Grid(caster) => caster.set_level(Level::baseline()),
                }
                let narrow = rays.render(&view).expect("a frame");
                let pairs = wide.pixels.iter().zip(&narrow.pixels);
                let differs = |(a, b): &(&[f32; 4], &[f32; 4])| {
                    // Sums of some hundred roundings of numbers up to 2.
                    (0..4).any(|i| (a[i] - b[i]).abs() > 1e-5)
                };
                // A ray within a rounding of a surface's outline may meet it or not.
                let most = if model == OpticalModel::Isosurfaces {
                    2
                } else {
                    0
                };
                let count = pairs.filter(differs).count();
                assert!(count <= most, "{}: {count} pixels", model.name());
            }
        }
    }
}
