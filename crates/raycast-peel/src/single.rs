//! Every ray to its end in one dispatch: what is uploaded when, and what a frame records.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Appearance, Error, FrameStats, OpticalModel, TetMesh, View, Volume};
use tetrascope_f32::tiles::TILE;
use tetrascope_f32::{
    Domain, KnotPair, Rays, ScalarMap, Tiles, deepest, is_transparent, mean_chord,
};
use tetrascope_gpu::memory::{ReadBack, Source, texture_bytes};
use tetrascope_gpu::passes::{deep, look_constants, model_constant};
use tetrascope_gpu::pipelines::Constant;
use tetrascope_gpu::preintegration::{self, Table};
use tetrascope_gpu::transfer_function::knot_pairs;
use tetrascope_gpu::wgpu::{self, ComputePipeline, TextureFormat, TextureUsages};
use tetrascope_gpu::{
    Canvas, Commands, ComputeProgram, Gpu, Integration, Outcome, Recorded, SumsKind, Target,
    read_back, sides,
};

use tetrascope_shaders::raycast_peel::MARCH;

use crate::NAME;
use crate::counters::{CELL_VISITS, LAYERS, LOST_RAYS, PATHS, UNPAIRED_FACES};
use crate::gpu_data::{Counters, March, Progress};
use crate::options::{Entries, RaycastOptions};
use crate::renderer::tetrahedra;

const LABEL: &str = "raycast-peel::cast";

/// Dispatches that [`Single::render`] waits for, in each of which every ray that is left gets on:
/// more than any mesh of 32 bits needs for its cells.
const MOST_DISPATCHES: u32 = 1 << 16;

/// Dispatches that [`Single::encode`] records, as nobody reads between them what is left.
const RECORDED: u32 = 16;

mod budget;
mod cast;
mod layers;
mod mesh;

pub(crate) use budget::Budget;
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
    /// What is bound where there are no isosurfaces.
    no_distances: wgpu::Texture,
    /// Whether a frame had rays that one dispatch did not finish.
    is_long: Arc<AtomicBool>,
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
    constants: Vec<Constant>,
    deepest: f32,
    intervals: wgpu::Texture,
    interval_count: usize,
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
        let mut constants = constants(gpu, mesh, appearance, options)?;
        constants.push(deep(deepest));
        constants.extend(table.constants(segments.scalars));
        constants.extend(Budget::new(appearance)?.constants());
        let style = Style {
            appearance: appearance.clone(),
            constants,
            deepest,
            table,
            interval_count: intervals.len(),
            intervals: gpu.upload_texels(
                "of the transfer function",
                TextureFormat::Rgba32Float,
                &texels(&intervals),
            )?,
        };
        style.pipeline(gpu, false, false)?;
        Ok(style)
    }
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
    options: &RaycastOptions,
) -> Result<Vec<Constant>, Error> {
    let kind = Kind::of(&mesh.source);
    let layered = options.entries == Entries::PeeledLayers;
    let [clipped, cued] = look_constants(appearance);
    Ok(vec![
        sides_constant(gpu, options)?,
        clipped,
        cued,
        model_constant(appearance.optical_model),
        ("SCALARS_PER_CELL", f64::from(u8::from(kind == Kind::Cells))),
        ("CORNER_SCALARS", f64::from(u8::from(kind == Kind::Corners))),
        ("LAYERED", f64::from(u8::from(layered))),
    ])
}

impl Style {
    /// Whether nothing of the mesh shows.
    fn is_transparent(&self) -> bool {
        is_transparent(self.appearance.optical_model, self.deepest)
    }

    /// Whether this holds for `mesh`, too, with the same map of scalars: programs ask only whether
    /// the bound of depths is at most 1, and [`Style::is_transparent`] whether it is 0.
    fn holds_for(&self, mesh: &Mesh) -> Result<bool, Error> {
        let tf = &self.appearance.transfer_function;
        let intervals = knot_pairs(tf, &mesh.scalar_map, &mesh.normalization)?;
        let deepest = deepest(&intervals, mesh.scalars(), mesh.longest_edge);
        Ok((self.deepest > 1.0 || deepest <= 1.0) && (self.deepest > 0.0 || deepest == 0.0))
    }

    /// The pipeline, with `resumes` for rays that go on from dispatch to dispatch, and with
    /// `ends` for rays that end before an application's geometry.
    fn pipeline(&self, gpu: &Gpu, resumes: bool, ends: bool) -> Result<ComputePipeline, Error> {
        let mut constants = self.constants.clone();
        if resumes {
            constants.extend([("RESUMES", 1.0), ("TREES", 1.0)]);
        }
        if ends {
            constants.push(("ENDS", 1.0));
        }
        gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source: MARCH,
            entry: Some("cs_cast"),
            constants,
            groups: Vec::new(),
        })
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
            no_distances: gpu.texture(
                "raycast-peel::no_distances",
                (1, 1),
                TextureFormat::R32Float,
                TextureUsages::STORAGE_BINDING,
            )?,
            is_long: Arc::default(),
        })
    }

    /// How and what is drawn, and its mesh.
    pub(crate) fn scene(&self) -> (&RaycastOptions, &Appearance, &TetMesh) {
        (&self.options, &self.style.appearance, &self.mesh.source)
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

    fn march(&self, view: &View, rays: &Rays) -> March {
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
}

impl Single {
    pub(crate) fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
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
        self.is_long = Arc::default();
        self.mesh = mesh;
        Ok(())
    }

    pub(crate) fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
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
        self.is_long = Arc::default();
        if let Some(mesh) = mesh {
            self.mesh = mesh;
        }
        Ok(())
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
mod aimed;
#[cfg(test)]
mod resumed;
