//! Every ray to its end in one dispatch: what is uploaded when, and what a frame records.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, OpticalModel, TetMesh, View, Volume, VolumeRenderer,
};
use tetrascope_f32::tiles::TILE;
use tetrascope_f32::{Domain, KnotPair, Rays, ScalarMap, Tiles, deepest, mean_chord};
use tetrascope_gpu::memory::{ReadBack, Source, texture_bytes};
use tetrascope_gpu::passes::{compute_pipeline, look_constants, model_constant, module};
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Integration, Timer, read_back, sides, timer};

use crate::NAME;
use crate::gpu_data::{Counters, March, Progress};
use crate::options::{Entries, RaycastOptions};
use crate::renderer::tetrahedra;

const LABEL: &str = "raycast-peel::cast";

/// Dispatches that [`Single::render`] waits for, in each of which every ray that is left gets on:
/// more than any mesh of 32 bits needs for its cells.
const MOST_DISPATCHES: u32 = 1 << 16;

/// Dispatches that [`Single::encode`] records, as nobody reads between them what is left.
const RECORDED: u32 = 16;

/// What the shader writes for a ray that meets no surface: infinity is nothing to count on.
const NO_SURFACE: f32 = 3e38;

mod budget;
mod cast;
mod layers;
mod mesh;

use budget::Budget;
use cast::{Cast, Size, Targets};
use layers::{Layers, Peeling};
use mesh::Kind;
pub(crate) use mesh::{Mesh, TRANSPARENT_SCALAR};

/// Pipelines and the uploaded mesh.
#[derive(Debug)]
pub(crate) struct Single {
    gpu: Gpu,
    options: RaycastOptions,
    mesh: Mesh,
    style: Style,
    peeling: Option<Peeling>,
    timer: Option<Timer>,
    /// Whether a frame had rays that one dispatch did not finish.
    is_long: AtomicBool,
}

/// Where a frame's rays cross the boundary.
enum Found {
    Lists(Tiles),
    /// And lists where rays may be in more layers.
    Layers(Layers, Option<Tiles>),
}

fn view_of(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&Default::default())
}

/// What `restyle` changes.
#[derive(Debug)]
struct Style {
    appearance: Appearance,
    /// For frames that one dispatch draws.
    pipeline: wgpu::ComputePipeline,
    /// For others: most volumes never need it.
    resuming: OnceLock<wgpu::ComputePipeline>,
    constants: Vec<(&'static str, f64)>,
    deepest: f32,
    intervals: wgpu::Texture,
    table: Table,
}

impl Style {
    fn new(
        gpu: &Gpu,
        mesh: &Mesh,
        appearance: &Appearance,
        options: &RaycastOptions,
        last: Option<&Table>,
    ) -> Result<Style, Error> {
        let intervals = knot_pairs(
            &appearance.transfer_function,
            &mesh.scalar_map,
            &mesh.normalization,
        )?;
        let segments = Segments {
            mesh: &mesh.source,
            scale: mesh.normalization.scale,
            intervals: &intervals,
            longest: mesh.longest_edge,
            scalars: mesh.scalars(),
        };
        let table = table(gpu, appearance, &segments, options, last)?;
        let deepest = deepest(&intervals, segments.scalars, mesh.longest_edge);
        let mut constants = constants(gpu, mesh, appearance, &intervals, options)?;
        constants.push(("DEEPEST", deepest.into()));
        constants.extend(table.constants(segments.scalars));
        constants.extend(Budget::new(appearance)?.constants());
        Ok(Style {
            appearance: appearance.clone(),
            pipeline: pipeline(gpu, &constants)?,
            resuming: OnceLock::new(),
            constants,
            deepest,
            table,
            intervals: gpu.upload_texels(
                "of the transfer function",
                TextureFormat::Rgba32Float,
                &texels(&intervals),
            )?,
        })
    }
}

fn pipeline(gpu: &Gpu, constants: &[(&str, f64)]) -> Result<wgpu::ComputePipeline, Error> {
    gpu.checked(LABEL, 0, || {
        let program = module(gpu, LABEL, tetrascope_shaders::raycast_peel::MARCH);
        compute_pipeline(gpu, LABEL, &program, Some("cs_cast"), constants, &[])
    })
}

/// What a table is to hold.
pub(crate) struct Segments<'a> {
    pub(crate) mesh: &'a TetMesh,
    /// World units in a normalized unit.
    pub(crate) scale: f64,
    pub(crate) intervals: &'a [KnotPair],
    /// The longest that there can be, normalized.
    pub(crate) longest: f32,
    /// The least and the greatest scalar, mapped.
    pub(crate) scalars: (f32, f32),
}

/// The table that the options ask for: `last` if that is it.
pub(crate) fn table(
    gpu: &Gpu,
    appearance: &Appearance,
    segments: &Segments,
    options: &RaycastOptions,
    last: Option<&Table>,
) -> Result<Table, Error> {
    let model = appearance.optical_model;
    let integration = match model {
        OpticalModel::Isosurfaces => Integration::Exact,
        _ => options.integration,
    };
    if integration != Integration::Exact && appearance.depth_cue.is_some() {
        return Err(Error::Unsupported {
            renderer: NAME,
            what: "a depth cue with a table of integrals".into(),
            reason: "the cue differs from place to place, the table does not".into(),
        });
    }
    let fixed = || preintegration::Fixed {
        length: (mean_chord(segments.mesh) / segments.scale) as f32,
        scalars: segments.scalars,
    };
    let is_fixed = matches!(integration, Integration::TableFixed { .. });
    let source = preintegration::Source {
        integration,
        model,
        intervals: segments.intervals,
        longest: segments.longest,
        fixed: is_fixed.then(fixed),
    };
    match last {
        Some(last) => last.renewed(gpu, NAME, &source),
        None => Table::new(gpu, NAME, &source),
    }
}

/// The constant of `sides.wgsl`.
pub(crate) fn sides_constant(
    gpu: &Gpu,
    options: &RaycastOptions,
) -> Result<(&'static str, f64), Error> {
    match options.integer_sides {
        true => Ok(sides::integer_sides(true)),
        false => sides::constant(gpu),
    }
}

/// The constants of `march.wgsl`, but for its table's.
fn constants(
    gpu: &Gpu,
    mesh: &Mesh,
    appearance: &Appearance,
    intervals: &[KnotPair],
    options: &RaycastOptions,
) -> Result<Vec<(&'static str, f64)>, Error> {
    let kind = Kind::of(&mesh.source);
    let layered = options.entries == Entries::PeeledLayers;
    let [clipped, cued] = look_constants(appearance);
    Ok(vec![
        sides_constant(gpu, options)?,
        clipped,
        cued,
        model_constant(appearance.optical_model),
        ("INTERVAL_COUNT", intervals.len() as f64),
        ("SCALARS_PER_CELL", f64::from(u8::from(kind == Kind::Cells))),
        ("CORNER_SCALARS", f64::from(u8::from(kind == Kind::Corners))),
        ("LAYERED", f64::from(u8::from(layered))),
    ])
}

impl Style {
    /// Whether the constants hold for `mesh`, too, with the same map of scalars: programs
    /// ask only whether the bound of depths is at most 1.
    fn holds_for(&self, mesh: &Mesh) -> Result<bool, Error> {
        let tf = &self.appearance.transfer_function;
        let intervals = knot_pairs(tf, &mesh.scalar_map, &mesh.normalization)?;
        let deepest = deepest(&intervals, mesh.scalars(), mesh.longest_edge);
        Ok(self.deepest > 1.0 || deepest <= 1.0)
    }

    /// The pipeline for rays that go on from dispatch to dispatch.
    fn resuming(&self, gpu: &Gpu) -> Result<&wgpu::ComputePipeline, Error> {
        if let Some(pipeline) = self.resuming.get() {
            return Ok(pipeline);
        }
        let mut constants = self.constants.clone();
        constants.extend([("RESUMES", 1.0), ("TREES", 1.0)]);
        let made = pipeline(gpu, &constants)?;
        Ok(self.resuming.get_or_init(|| made))
    }
}

/// Three texels an interval.
fn texels(intervals: &[KnotPair]) -> Vec<[f32; 4]> {
    let three = |i: &KnotPair| [i.at_low, i.at_high, [i.low, i.high, i.inverse_width, 0.0]];
    intervals.iter().flat_map(three).collect()
}

impl Single {
    /// A renderer of `volume`, which must be a mesh.
    ///
    /// # Errors
    /// A grid is unsupported; a mesh larger than the device's bindings is too large.
    pub(crate) fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &RaycastOptions,
    ) -> Result<Single, Error> {
        let source = tetrahedra(volume)?;
        let domain = Domain::of(source).within(options.domain)?;
        let map = ScalarMap::of_appearance(appearance, domain.scalar_range);
        let mesh = Mesh::new(gpu, source, domain, map, options.locality)?;
        Ok(Single {
            style: Style::new(gpu, &mesh, appearance, options, None)?,
            peeling: match options.entries {
                Entries::TileLists => None,
                Entries::PeeledLayers => Some(Peeling::new(gpu, sides_constant(gpu, options)?)?),
            },
            mesh,
            gpu: gpu.clone(),
            options: *options,
            timer: Timer::new(gpu)?,
            is_long: AtomicBool::new(false),
        })
    }

    /// Bytes on the device between frames, the image not counted.
    pub(crate) fn bytes_resident(&self) -> u64 {
        let textures = self
            .mesh
            .textures()
            .into_iter()
            .chain([&self.style.intervals]);
        textures.map(texture_bytes).sum::<u64>() + self.style.table.bytes()
    }

    /// Records one frame into `image`, an Rgba32Float storage texture, and where there are
    /// isosurfaces into `depths`, R32Float; both as large as the view. The caller submits.
    /// What the frame did is in the buffer returned, once the commands have run.
    pub(crate) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        image: &wgpu::TextureView,
        depths: Option<&wgpu::TextureView>,
    ) -> Result<wgpu::Buffer, Error> {
        view.validate()?;
        if self.peeling.is_some() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "peeled layers into the caller's encoder".into(),
                reason: "the CPU reads between layers whether there are more".into(),
            });
        }
        let rays = Rays::new(view, &self.mesh.normalization);
        let found = Found::Lists(self.lists(view, &rays)?);
        self.encode_resuming(encoder, view, &rays, found, (image, depths))
    }

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
    /// find no ray left are empty.
    fn encode_resuming(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        rays: &Rays,
        found: Found,
        targets: Targets,
    ) -> Result<wgpu::Buffer, Error> {
        let found = self.trees(view, rays, found)?;
        let cast = Cast::new(self, view, rays, &found, targets, true)?;
        let bands = cast.bands();
        let states = cast.states(&bands)?;
        for band in bands {
            let mut last = cast.progress(band, false, false)?;
            cast.record(encoder, Size::Band(band), &last, &states, None)?;
            for dispatch in 1..RECORDED {
                let progress = cast.progress(band, true, dispatch + 1 == RECORDED)?;
                cast.record(encoder, Size::Left(&last), &progress, &states, None)?;
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

    /// A texture for depths.
    fn depths(&self, size: (u32, u32)) -> Result<wgpu::Texture, Error> {
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let label = "raycast-peel::depths";
        self.gpu
            .texture(label, size, TextureFormat::R32Float, usage)
    }

    fn march(&self, view: &View, rays: &Rays) -> March {
        let extended = |v: DVec3, w: f32| v.as_vec3().extend(w).to_array();
        March {
            anchor: extended(rays.anchor, 0.0),
            anchor_x: extended(rays.anchor_x, 0.0),
            anchor_y: extended(rays.anchor_y, 0.0),
            eye: extended(rays.eye, if rays.is_point { 1.0 } else { 0.0 }),
            background: view.premultiplied_background().map(|c| c as f32),
            forward: extended(rays.forward, 0.0),
            eye_depth: rays.eye_depth as f32,
            width: view.width,
            height: view.height,
            tiles_x: view.width.div_ceil(TILE),
            stop_depth: self.options.stop_depth(),
            scale: self.mesh.normalization.scale as f32,
            layers: 0,
            listed_from: u32::MAX,
        }
    }
}

impl VolumeRenderer for Single {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let source = tetrahedra(volume)?;
        let (gpu, old) = (&self.gpu, &self.mesh);
        let appearance = &self.style.appearance;
        let domain = Domain::of(source).within(self.options.domain)?;
        let range = domain.scalar_range;
        let same_kind = Kind::of(source) == Kind::of(&old.source);
        let same_geometry = source.shares_geometry(&old.source) && same_kind;
        let keeps_map = same_geometry && old.scalar_map.suits_appearance(appearance, range);
        let map = match keeps_map {
            true => old.scalar_map,
            false => ScalarMap::of_appearance(appearance, range),
        };
        let mesh = match same_geometry {
            true => old.with_scalars(gpu, source, domain, map)?,
            false => Mesh::new(gpu, source, domain, map, self.options.locality)?,
        };
        // A table's program knows whether scalars leave it.
        let holds = keeps_map && self.style.holds_for(&mesh)?;
        if !holds || self.options.integration != Integration::Exact {
            let table = Some(&self.style.table);
            self.style = Style::new(gpu, &mesh, appearance, &self.options, table)?;
        }
        self.is_long = AtomicBool::new(false);
        self.mesh = mesh;
        Ok(())
    }

    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let (gpu, old) = (&self.gpu, &self.mesh);
        let range = old.domain.scalar_range;
        let mesh = match old.scalar_map.suits_appearance(appearance, range) {
            true => None,
            false => {
                let map = ScalarMap::of_appearance(appearance, range);
                Some(old.with_scalars(gpu, &old.source, old.domain, map)?)
            }
        };
        let drawn = mesh.as_ref().unwrap_or(old);
        let table = Some(&self.style.table);
        self.style = Style::new(gpu, drawn, appearance, &self.options, table)?;
        self.is_long = AtomicBool::new(false);
        if let Some(mesh) = mesh {
            self.mesh = mesh;
        }
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        view.validate()?;
        let start = Instant::now();
        let gpu = &self.gpu;
        let image = gpu.texture(
            "raycast-peel::image",
            (view.width, view.height),
            TextureFormat::Rgba32Float,
            TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC,
        )?;
        let has_depths = self.style.appearance.optical_model == OpticalModel::Isosurfaces;
        let depths = has_depths
            .then(|| self.depths((view.width, view.height)))
            .transpose()?;
        let rays = Rays::new(view, &self.mesh.normalization);
        let mut found = self.find(view, &rays)?;
        let mut stats = FrameStats::default();
        if let Found::Layers(layers, _) = &found {
            stats.passes = layers.passes;
            stats.layers = Some(layers.full);
        }
        let views = (view_of(&image), depths.as_ref().map(view_of));
        let targets = (&views.0, views.1.as_ref());
        let mut drawn = None;
        if !self.is_long.load(Ordering::Relaxed) {
            let cast = Cast::new(self, view, &rays, &found, targets, false)?;
            let (progress, room) = (cast.progress(cast.whole(), false, true)?, cast.room(1)?);
            // Layers were peeled before the timer began.
            let timer = self.timer.as_ref().filter(|_| self.peeling.is_none());
            let times = timer.map(Timer::only_compute_pass);
            let mut encoder = new_encoder(gpu);
            let size = Size::Band(cast.whole());
            cast.record(&mut encoder, size, &progress, &room, times)?;
            stats.passes += 1;
            let picture = Picture::take(gpu, encoder, &image, depths.as_ref(), &cast, timer)?;
            match picture.counters.rays_left {
                0 => drawn = Some(picture),
                _ => self.is_long.store(true, Ordering::Relaxed),
            }
        }
        let picture = match drawn {
            Some(picture) => picture,
            None => {
                found = self.trees(view, &rays, found)?;
                let cast = Cast::new(self, view, &rays, &found, targets, true)?;
                self.finish(&cast, &mut stats.passes, MOST_DISPATCHES)?;
                let encoder = new_encoder(gpu);
                Picture::take(gpu, encoder, &image, depths.as_ref(), &cast, None)?
            }
        };
        picture.count(&mut stats);
        stats.bytes_resident = self.bytes_resident();
        stats.cpu_seconds = start.elapsed().as_secs_f64();
        let mut frame = Frame::new((view.width, view.height), picture.pixels, stats);
        frame.depths = picture.depths;
        Ok(frame)
    }
}

impl Single {
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
                cast.record(&mut encoder, Size::Band(band), &progress, &states, None)?;
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

/// What a frame's dispatches left on the device.
struct Picture {
    pixels: Vec<[f32; 4]>,
    depths: Option<Vec<f32>>,
    counters: Counters,
    gpu_seconds: Option<f64>,
}

impl Picture {
    /// Submits what was recorded and waits for it.
    fn take(
        gpu: &Gpu,
        mut encoder: wgpu::CommandEncoder,
        image: &wgpu::Texture,
        depths: Option<&wgpu::Texture>,
        cast: &Cast,
        timer: Option<&Timer>,
    ) -> Result<Picture, Error> {
        let depths = depths.map(|texture| read_back(gpu, &mut encoder, Source::Texture(texture)));
        let depths = depths.transpose()?;
        let pixels = read_back(gpu, &mut encoder, Source::Texture(image))?;
        let bytes = size_of::<Counters>() as u64;
        let counters = read_back(gpu, &mut encoder, Source::Buffer(&cast.counters, bytes))?;
        let times = timer.map(|timer| timer.resolve(gpu, &mut encoder));
        let times = times.transpose()?;
        let submitted = Instant::now();
        gpu.finish(encoder)?;
        let waited = submitted.elapsed();
        let gpu_seconds = match timer {
            Some(_) => timer::seconds(gpu, times, waited)?,
            None => None,
        };
        let finite = |depths: ReadBack| {
            let mut depths: Vec<f32> = depths.read()?;
            for depth in depths.iter_mut().filter(|depth| **depth >= NO_SURFACE) {
                *depth = f32::INFINITY;
            }
            Ok::<_, Error>(depths)
        };
        Ok(Picture {
            pixels: pixels.read()?,
            depths: depths.map(finite).transpose()?,
            counters: one(counters)?,
            gpu_seconds,
        })
    }

    fn count(&self, stats: &mut FrameStats) {
        let counters = &self.counters;
        let high = u64::from(counters.cell_visits_high) << 32;
        stats.cell_visits = Some(high | u64::from(counters.cell_visits_low));
        stats.paths = Some(counters.paths.into());
        stats.unpaired_faces = Some(counters.unpaired_faces.into());
        // A ray that was given up is as lost as one that came out where it should not.
        let (lost, left) = (counters.lost_rays, counters.rays_left);
        stats.lost_rays = Some(u64::from(lost) + u64::from(left));
        stats.gpu_seconds = self.gpu_seconds;
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
mod aimed;
#[cfg(test)]
mod resumed;
