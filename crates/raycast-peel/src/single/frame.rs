//! The commands of a frame: where its rays enter, and dispatches until they are done.

use std::sync::atomic::Ordering;

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Error, FrameStats, OpticalModel, View};
use tetrascope_f32::tiles::TILE;
use tetrascope_f32::{Rays, Tiles};
use tetrascope_gpu::memory::{ReadBack, Source};
use tetrascope_gpu::wgpu::{self, TextureFormat, TextureUsages};
use tetrascope_gpu::{Canvas, Commands, Gpu, Outcome, Recorded, SumsKind, Target, read_back};

use super::Single;
use super::cast::{Cast, Size, Targets};
use super::layers::Layers;
use crate::NAME;
use crate::counters::{CELL_VISITS, LAYERS, LOST_RAYS, PATHS, UNPAIRED_FACES};
use crate::gpu_data::{Counters, March, Progress};

/// Dispatches that [`Single::record`] waits for, in each of which every ray that is left gets on:
/// more than any mesh of 32 bits needs for its cells.
const MOST_DISPATCHES: u32 = 1 << 16;

/// Dispatches that are recorded into a caller's commands, as nobody reads between them what is
/// left.
const RECORDED: u32 = 16;

/// Where a frame's rays cross the boundary.
pub(super) enum Found {
    Lists(Tiles),
    /// And lists where rays may be in more layers.
    Layers(Layers, Option<Tiles>),
}

impl Single {
    /// The boundary faces that the rays of each tile may meet.
    fn lists(&self, view: &View, rays: &Rays) -> Result<Tiles, Error> {
        Tiles::new(view, rays, &self.mesh.faces).ok_or_else(too_many_faces)
    }

    /// Where rays cross the boundary; layers are peeled here.
    fn find(&self, view: &View, rays: &Rays) -> Result<Found, Error> {
        let Some(peeling) = &self.peeling else {
            return Ok(Found::Lists(self.lists(view, rays)?));
        };
        let layers = peeling.peel(&self.gpu, view, rays, &self.mesh, &self.march(view, rays))?;
        let lists = layers.may_be_more.then(|| self.lists(view, rays));
        Ok(Found::Layers(layers, lists.transpose()?))
    }

    /// Records what draws any volume whose rays are done in so many dispatches: those that
    /// find no ray left are empty. Returns the counters.
    fn record_blindly(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        rays: &Rays,
        targets: &Targets,
    ) -> Result<wgpu::Buffer, Error> {
        if self.peeling.is_some() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "peeled layers into the caller's encoder".into(),
                reason: "the CPU reads between layers whether there are more".into(),
            });
        }
        let found = Found::Lists(self.lists(view, rays)?);
        let found = self.trees(view, rays, found)?;
        let cast = Cast::new(self, view, rays, &found, targets, true)?;
        let bands = cast.bands();
        let states = cast.states(&bands)?;
        for band in bands {
            let mut last = cast.progress(band, false, false)?;
            cast.record(encoder, Size::Band(band), &last, &states)?;
            for dispatch in 1..RECORDED {
                let progress = cast.progress(band, true, dispatch + 1 == RECORDED)?;
                cast.record(encoder, Size::Left(&last), &progress, &states)?;
                last = progress;
            }
        }
        Ok(cast.counters)
    }

    /// The same with trees in place of lists.
    fn trees(&self, view: &View, rays: &Rays, found: Found) -> Result<Found, Error> {
        let grown = |lists: Tiles| {
            let trees = lists.trees(view, rays, &self.mesh.faces);
            trees.ok_or_else(too_many_faces)
        };
        Ok(match found {
            Found::Lists(lists) => Found::Lists(grown(lists)?),
            Found::Layers(layers, lists) => Found::Layers(layers, lists.map(grown).transpose()?),
        })
    }

    fn sums_kind(&self) -> SumsKind {
        SumsKind {
            format: TextureFormat::Rgba32Float,
            usage: TextureUsages::STORAGE_BINDING,
            distances: self.style.appearance.optical_model == OpticalModel::Isosurfaces,
        }
    }

    pub(super) fn march(&self, view: &View, rays: &Rays) -> March {
        let extended = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        March {
            anchor: extended(rays.anchor, 0.0),
            anchor_x: extended(rays.anchor_x, 0.0),
            anchor_y: extended(rays.anchor_y, 0.0),
            eye: extended(rays.eye, if rays.is_point { 1.0 } else { 0.0 }),
            forward: extended(rays.forward, 0.0),
            eye_depth: rays.eye_depth as f32,
            width: view.width,
            height: view.height,
            tiles_x: view.width.div_ceil(TILE),
            stop_depth: self.options.stop_depth(),
            unused: 0.0,
            layers: 0,
            listed_from: u32::MAX,
        }
    }

    pub(crate) fn record(
        &self,
        canvas: &Canvas,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        let gpu = &self.gpu;
        let model = self.style.appearance.optical_model;
        let normalization = &self.mesh.normalization;
        if self.style.is_transparent() {
            let mut stats = FrameStats::default();
            stats.bytes_resident = self.bytes_resident();
            stats.passes = canvas.put_nothing(commands.encoder(), view, target)?;
            Counters::default().count(&mut stats);
            return Ok(Recorded::new(stats));
        }
        let sums = canvas.sums(view, self.sums_kind())?;
        let rays = Rays::new(view, normalization);
        // Surfaces are hidden when they are put among the geometry.
        let depth = target.depth.as_ref();
        let depth = depth.filter(|_| model != OpticalModel::Isosurfaces);
        let anchor_depth = -rays.eye_depth;
        let encoder = commands.encoder();
        let (ends, has_ends) = canvas.ends(encoder, view, normalization, anchor_depth, depth)?;
        let targets = Targets {
            sums: &sums,
            ends: &ends,
            has_ends,
        };
        let mut stats = FrameStats::default();
        stats.bytes_resident = self.bytes_resident();
        let is_long = self.is_long.load(Ordering::Relaxed);
        let counters = match commands.may_submit() {
            false => self.record_blindly(commands.encoder(), view, &rays, &targets)?,
            true => self.record_watched(commands, (view, &rays), &targets, &mut stats, is_long)?,
        };
        let bytes = size_of::<Counters>() as u64;
        let encoder = commands.encoder();
        let counters = read_back(gpu, encoder, Source::Buffer(&counters, bytes))?;
        canvas.put(encoder, view, normalization, (model, &sums), target)?;
        stats.passes += 1;
        let watched = commands.may_submit().then(|| self.is_long.clone());
        let mut recorded = Recorded::new(stats).then(move |stats| {
            let counters = one::<Counters>(counters)?;
            if let Some(mark) = watched.filter(|_| counters.rays_left > 0 && !is_long) {
                mark.store(true, Ordering::Relaxed);
                return Ok(Outcome::Incomplete);
            }
            counters.count(stats);
            Ok(Outcome::Complete)
        });
        if let Some(distances) = &sums.distances {
            recorded = recorded.with_distances(distances, normalization.scale);
        }
        Ok(recorded)
    }

    /// Records one dispatch, which most volumes are done in; where it is known that rays are
    /// left, submits as many as it takes. Returns the counters.
    fn record_watched(
        &self,
        commands: &mut Commands,
        (view, rays): (&View, &Rays),
        targets: &Targets,
        stats: &mut FrameStats,
        is_long: bool,
    ) -> Result<wgpu::Buffer, Error> {
        if is_long || self.peeling.is_some() {
            commands.submit()?;
        }
        let found = self.find(view, rays)?;
        if let Found::Layers(layers, _) = &found {
            stats.passes = layers.passes;
            stats.count(LAYERS, layers.full);
        }
        if is_long {
            let found = self.trees(view, rays, found)?;
            let cast = Cast::new(self, view, rays, &found, targets, true)?;
            self.finish(&cast, &mut stats.passes, MOST_DISPATCHES)?;
            return Ok(cast.counters);
        }
        let cast = Cast::new(self, view, rays, &found, targets, false)?;
        let (progress, room) = (cast.progress(cast.whole(), false, true)?, cast.room(1)?);
        let whole = Size::Band(cast.whole());
        cast.record(commands.encoder(), whole, &progress, &room)?;
        stats.passes += 1;
        Ok(cast.counters)
    }

    /// Dispatches until all rays are done, band by band, or `most` times for each. Returns how
    /// many are not done.
    fn finish(&self, cast: &Cast, passes: &mut u64, most: u32) -> Result<u32, Error> {
        let gpu = &self.gpu;
        let bands = cast.bands();
        let states = cast.states(&bands)?;
        let mut given_up = 0;
        for band in bands {
            for dispatch in 0..most {
                let is_last = dispatch + 1 == most;
                let progress = cast.progress(band, dispatch > 0, is_last)?;
                let mut encoder = new_encoder(gpu);
                cast.record(&mut encoder, Size::Band(band), &progress, &states)?;
                *passes += 1;
                let bytes = size_of::<Progress>() as u64;
                let progress = read_back(gpu, &mut encoder, Source::Buffer(&progress, bytes))?;
                gpu.finish(encoder)?;
                let left = one::<Progress>(progress)?.rays_left;
                if left == 0 {
                    break;
                }
                given_up += if is_last { left } else { 0 };
            }
        }
        Ok(given_up)
    }
}

fn new_encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device().create_command_encoder(&Default::default())
}

fn too_many_faces() -> Error {
    Error::TooLarge {
        what: "the boundary faces of all tiles".into(),
        needed: u64::from(u32::MAX) + 1,
        limit: u64::from(u32::MAX),
        unit: "pairs of tile and face",
    }
}

impl Counters {
    fn count(&self, stats: &mut FrameStats) {
        let high = u64::from(self.cell_visits_high) << 32;
        stats.count(CELL_VISITS, high | u64::from(self.cell_visits_low));
        stats.count(PATHS, self.paths.into());
        stats.count(UNPAIRED_FACES, self.unpaired_faces.into());
        // A ray that was given up is as lost as one that came out where it should not.
        let (lost, left) = (self.lost_rays, self.rays_left);
        stats.count(LOST_RAYS, u64::from(lost) + u64::from(left));
        if left > 0 {
            stats.notes.push(format!(
                "{left} rays were given up after many dispatches and show a part of what they \
                 cross"
            ));
        }
        if lost > 0 {
            stats.notes.push(format!(
                "{lost} rays came out of the mesh where they do not cross it"
            ));
        }
    }
}

/// The one `T` that was read back.
fn one<T: bytemuck::Pod>(read: ReadBack) -> Result<T, Error> {
    match read.read::<T>()?[..] {
        [one] => Ok(one),
        _ => Err(Error::Device {
            reason: "the counters did not come back".into(),
        }),
    }
}

#[cfg(test)]
mod resumed;
