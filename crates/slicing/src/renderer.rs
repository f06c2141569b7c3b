//! The renderer: what lasts, and how a frame is recorded.

mod parts;
#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use tetrascope_core::glam::Vec4;
use tetrascope_core::grid::{BrickSource, Interpolation, Lattice};
use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, OpticalModel, View, Volume, VolumeRenderer,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{Domain, Normalization, ScalarMap};
use tetrascope_gpu::gather::{Resolve, ResolvePass};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, Timer, read_back, timer};

use parts::Parts;

use crate::ABILITIES;
use crate::NAME;
use crate::box_plane::POLYGON;
use crate::cells::CellCorners;
use crate::count::{self, FragmentCounter};
use crate::cull::{Cast, CullData, CullPass, Culling};
use crate::frame::{FrameGeometry, geometry};
use crate::gpu_data;
use crate::octree::{Octree, Place, Visibility};
use crate::options::{Filtering, Level, Slicer, SlicingOptions, Traversal};
use crate::polygons::Polygons;
use crate::slice::{self, NOWHERE, Shape, SliceData, SliceFrame, SlicePass, Sums};
use crate::voxels::{Scale, Voxels};

/// Pipelines and the uploaded grid.
#[derive(Debug)]
pub struct Slicing {
    gpu: Gpu,
    options: SlicingOptions,
    pass: SlicePass,
    /// Where the GPU traverses.
    cull: Option<CullPass>,
    scene: Scene,
    /// The textures of the last frame, for the next of the same size.
    gathered: Mutex<Option<Gathered>>,
}

/// What slabs are drawn into.
#[derive(Clone, Debug)]
struct Gathered {
    sums: wgpu::Texture,
    /// Distances of isosurfaces.
    distances: Option<wgpu::Texture>,
}

/// All that `reload` and `restyle` replace, at once or not at all.
#[derive(Debug)]
struct Scene {
    appearance: Appearance,
    volume: Arc<Samples>,
    map: ScalarMap,
    scale: Scale,
    visibility: Visibility,
    voxels: Arc<Voxels>,
    /// Where the GPU traverses and all that can show is on it.
    cull: Option<CullData>,
    intervals: wgpu::Buffer,
    /// Clip planes, normal · p + w ≥ 0 in lattice space.
    kept: Vec<Vec4>,
    slice: SliceData,
    resolve: [ResolvePass; 2],
}

/// What does not depend on the appearance.
#[derive(Debug)]
struct Samples {
    source: Arc<dyn BrickSource>,
    lattice: Lattice,
    /// Whether each sample is that of a whole cell.
    fills_cells: bool,
    domain: Domain,
    normalization: Normalization,
    octree: Octree,
    /// Samples around each box that its range includes.
    reach: usize,
}

/// Where a frame is drawn, an index of [`Scene::resolve`].
#[derive(Clone, Copy)]
enum To {
    Target,
    ReadBack,
}

/// What is measured while a frame is drawn, where the device can.
#[derive(Default)]
struct Measures {
    timer: Option<Timer>,
    fragments: Option<FragmentCounter>,
    /// Arguments of the draw, where the device has made them, and how many boxes there are.
    arguments: Option<(wgpu::Buffer, u64)>,
    /// When the first of more than one submissions was made.
    submitted: Option<Instant>,
}

const READ_BACK_FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// A frame that is ready to be recorded.
struct Plan {
    frame: SliceFrame,
    level: u32,
    /// Back to front; none if the device finds them.
    boxes: Vec<Place>,
    culling: Option<Culling>,
    stats: FrameStats,
}

impl Slicing {
    /// Uploads the grid in `volume` and compiles what `appearance` needs.
    ///
    /// [`Error::Unsupported`] for a mesh, [`Error::TooLarge`] and
    /// [`Error::OutOfMemory`] if the device or the budget has no room for one brick.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        Slicing::from_source(gpu, source_of(volume)?, appearance, options)
    }

    /// Draws a grid that need not fit in memory; see also
    /// [`GridStream`](tetrascope_core::grid::GridStream).
    ///
    /// Reads all of it once, to know what is empty. Errors as in [`Slicing::new`].
    pub fn from_source(
        gpu: &Gpu,
        source: Arc<dyn BrickSource>,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        ABILITIES.check(NAME, appearance)?;
        options.validate()?;
        let pass = SlicePass::new(gpu)?;
        let reach = options.reach(appearance.optical_model);
        let volume = Arc::new(Samples::new(source, reach, options.domain)?);
        let parts = Parts {
            gpu,
            options,
            pass: &pass,
        };
        let scene = parts.scene(appearance, volume, None)?;
        let by_gpu = options.traversal == Traversal::Gpu;
        let cull = by_gpu.then(|| CullPass::new(gpu)).transpose()?;
        Ok(Slicing {
            cull,
            gpu: gpu.clone(),
            options: options.clone(),
            pass,
            scene,
            gathered: Mutex::new(None),
        })
    }

    /// Records a frame into `target`, a view of a texture of the view's size and of
    /// [`SlicingOptions::target_format`]; the caller submits.
    ///
    /// Every texel is written: linear premultiplied RGBA, over the view's background.
    /// Times and readback are for [`VolumeRenderer::render`]: the stats returned have the
    /// counts alone. A volume that is streamed is an [`Error::Unsupported`], as each of its
    /// batches must be submitted before the next is uploaded; `render` does that.
    pub fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        target: &wgpu::TextureView,
    ) -> Result<FrameStats, Error> {
        if !self.scene.voxels.is_complete() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "a streamed volume into a caller's encoder".into(),
                reason: "what can show does not fit the memory budget at once".into(),
            });
        }
        self.record(encoder, view, (target, To::Target), None)
    }

    fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        (target, to): (&wgpu::TextureView, To),
        measures: Option<&mut Measures>,
    ) -> Result<FrameStats, Error> {
        view.validate()?;
        let (gpu, scene) = (&self.gpu, &self.scene);
        let (mut plan, box_count) = self.plan(view)?;
        // New buffers each time: frames may be recorded before others are submitted.
        let background = [Resolve::of(view)];
        let background = gpu.upload("slicing::resolve", &background, BufferUsages::UNIFORM)?;
        let sums = self.gathered((view.width, view.height))?.views();
        let ends = match &plan {
            Some(plan) => scene
                .voxels
                .batches(&scene.volume.octree, plan.level, &plan.boxes),
            None => Vec::new(),
        };
        let (mut timer, mut counter, mut submitted) = (None, None, None);
        let culling = plan.as_ref().and_then(|plan| plan.culling.as_ref());
        if let Some(measures) = measures {
            measures.fragments = FragmentCounter::new(gpu, ends.len())?;
            measures.arguments = culling.map(|c| (c.arguments.clone(), c.box_count));
            (timer, counter) = (measures.timer.as_ref(), measures.fragments.as_ref());
            submitted = Some(&mut measures.submitted);
        }
        let mut times = timer.map(Timer::first_render_pass);
        if let (Some(culling), Some(cull)) = (culling, &self.cull) {
            times = None;
            let times = timer.map(Timer::first_compute_pass);
            gpu.checked("slicing::encode", 0, || {
                cull.record(encoder, culling, times);
            })?;
        }
        let mut first = 0;
        for (index, end) in (0..).zip(ends) {
            let Some(plan) = &mut plan else { break };
            if first > 0 {
                if let Some(submitted) = &mut submitted {
                    submitted.get_or_insert_with(Instant::now);
                }
                // The device must be done with the slots before they are filled again.
                let next = gpu.device().create_command_encoder(&Default::default());
                gpu.finish(std::mem::replace(encoder, next))?;
            }
            plan.stats.bytes_uploaded += self.fill(plan, first..end)?;
            let boxes = first as u32..end as u32;
            gpu.checked("slicing::encode", 0, || {
                let (frame, slice) = (&plan.frame, &scene.slice);
                let pass = &self.pass;
                pass.record(
                    encoder,
                    frame,
                    slice,
                    boxes,
                    index,
                    &sums,
                    times.take(),
                    counter,
                );
            })?;
            plan.stats.passes += 1;
            first = end;
        }
        let mut stats = match plan {
            Some(plan) => plan.stats,
            None => {
                // Nothing in front of the eye, or nothing that shows.
                slice::clear(encoder, &sums, times.take());
                let mut stats = self.stats();
                stats.bricks_drawn = Some(0);
                stats.bricks_skipped = Some(box_count);
                (stats.vertices, stats.fragments) = (Some(0), Some(0));
                stats
            }
        };
        gpu.checked("slicing::encode", 0, || {
            let times = timer.map(Timer::last_render_pass);
            let resolve = &scene.resolve[to as usize];
            resolve.record(gpu, encoder, &background, &sums.gathered, target, times);
        })?;
        stats.passes += 1;
        Ok(stats)
    }

    /// Brings a batch of boxes onto the device and writes where they are.
    fn fill(&self, plan: &Plan, range: std::ops::Range<usize>) -> Result<u64, Error> {
        let (gpu, scene) = (&self.gpu, &self.scene);
        if scene.voxels.is_complete() {
            return Ok(0);
        }
        let volume = &scene.volume;
        let boxes = &plan.boxes[range.clone()];
        let octree = &volume.octree;
        let bytes = scene
            .voxels
            .stream(gpu, &*volume.source, octree, plan.level, boxes)?;
        let data = self.boxes(plan.level, boxes);
        plan.frame.write_boxes(gpu, range.start, &data)?;
        Ok(bytes)
    }

    fn boxes(&self, level: u32, places: &[Place]) -> Vec<gpu_data::Box> {
        let scene = &self.scene;
        let octree = &scene.volume.octree;
        let of = |place: &Place| gpu_data::Box {
            low: octree.low(level, *place).map(|x| x as i32),
            padding: 0,
            // Zero for those that a later batch brings.
            texel: scene
                .voxels
                .texel(octree, level, *place)
                .unwrap_or_default(),
            padding_too: 0,
        };
        places.iter().map(of).collect()
    }

    /// Which boxes are drawn, and with what, `None` if there are none; and how many there
    /// are with those that are skipped.
    fn plan(&self, view: &View) -> Result<(Option<Plan>, u64), Error> {
        let (gpu, scene) = (&self.gpu, &self.scene);
        let Samples {
            domain,
            lattice,
            normalization,
            octree,
            ..
        } = &*scene.volume;
        let slices = self.options.slices_per_voxel;
        let Some(geometry) = geometry(view, lattice, normalization, slices)? else {
            return Ok((None, 1));
        };
        let level = self.level(&geometry);
        let box_count = octree.box_count(level) as u64;
        let size = octree.box_size(level);
        let mut frustum = geometry.frustum.clone();
        frustum.planes.extend(&scene.kept);
        let visibility = &scene.visibility;
        let viewer = geometry.viewer;
        let boxes = match scene.cull {
            None => octree.back_to_front(level, visibility, viewer, &frustum),
            Some(_) => Vec::new(),
        };
        let room = match scene.cull {
            None => boxes.len(),
            Some(_) => visibility.count(level),
        };
        if room == 0 {
            return Ok((None, box_count));
        }
        let uniform = gpu_data::Frame {
            scalar_unit: scene.scale.unit,
            scalar_base: scene.scale.base,
            ..geometry.uniform(size)
        };
        let mut stats = self.stats();
        let drawn = boxes.len() as u64;
        let data = self.boxes(level, &boxes);
        let mut sent = (size_of_val(&uniform) + size_of_val(&data[..])) as u64;
        let mut culling = None;
        let shape = match (self.options.slicer, &self.cull, &scene.cull) {
            (Slicer::VertexProgram, Some(pass), Some(cull)) => {
                let (indices, index_count) = self.pass.stacks(gpu, uniform.slabs_per_box)?;
                let cast = Cast {
                    level,
                    viewer,
                    frustum: &frustum,
                    room,
                    index_count,
                };
                let of_frame = pass.frame(gpu, cull, octree, &scene.voxels, &cast)?;
                sent += of_frame.bytes;
                let arguments = of_frame.arguments.clone();
                culling = Some(of_frame);
                Shape::Counted { indices, arguments }
            }
            (Slicer::VertexProgram, ..) => {
                let (indices, index_count) = self.pass.stacks(gpu, uniform.slabs_per_box)?;
                Shape::Stack {
                    indices,
                    index_count,
                }
            }
            (Slicer::Cpu, ..) => {
                let lows = boxes.iter().map(|place| octree.low(level, *place));
                let limit = gpu.limits().max_buffer_size;
                let polygons = Polygons::cut(&uniform, self.options.plane_test, lows, limit)?;
                stats.vertices = Some(polygons.corners.len() as u64);
                sent += polygons.bytes();
                Shape::of(gpu, polygons)?
            }
        };
        let uniform = gpu.upload("slicing::frame", &[uniform], BufferUsages::UNIFORM)?;
        let data = match &culling {
            None => gpu.upload("slicing::boxes", &data, BufferUsages::STORAGE)?,
            Some(culling) => culling.boxes.clone(),
        };
        let (look, items) = look(
            &scene.appearance,
            view,
            &domain.bounds,
            normalization,
            &scene.map,
            &geometry.camera,
        );
        let look = gpu.upload("slicing::look", &[look], BufferUsages::UNIFORM)?;
        let items = gpu.upload("slicing::look_items", &items, BufferUsages::STORAGE)?;
        let frame = self
            .pass
            .frame(gpu, &uniform, data, [&look, &items], shape)?;
        stats.geometry_bytes = Some(sent);
        let known = culling.is_none();
        let slabs = u64::from(geometry.slabs_per_box(size));
        stats.bricks_drawn = known.then_some(drawn);
        stats.bricks_skipped = known.then_some(box_count - drawn);
        if known && self.options.slicer == Slicer::VertexProgram {
            stats.vertices = Some(drawn * slabs * POLYGON as u64);
        }
        let plan = Plan {
            frame,
            level,
            boxes,
            culling,
            stats,
        };
        Ok((Some(plan), box_count))
    }

    /// The octree's level that is drawn.
    fn level(&self, geometry: &FrameGeometry) -> u32 {
        let (octree, visibility) = (&self.scene.volume.octree, &self.scene.visibility);
        let least = self.scene.voxels.least_level();
        let cost = |level: &u32| {
            let size = octree.box_size(*level);
            let polygons = f64::from(geometry.slabs_per_box(size)) * FRAGMENTS_PER_POLYGON;
            visibility.count(*level) as f64 * (geometry.fragments_per_box(size) + polygons)
        };
        match self.options.level {
            Level::Fixed(level) => level.clamp(least, octree.deepest()),
            // Among equally cheap levels, take the coarser one.
            Level::Auto => (least..=octree.deepest())
                .min_by(|a, b| cost(a).total_cmp(&cost(b)))
                .unwrap_or(least),
        }
    }

    /// The textures that slabs are drawn into, kept for the next frame.
    fn gathered(&self, size: (u32, u32)) -> Result<Gathered, Error> {
        let model = self.scene.appearance.optical_model;
        let format = slice::sum_format(&self.gpu, model);
        let surfaces = model == OpticalModel::Isosurfaces;
        let mut kept = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |g: &&Gathered| {
            let sums = &g.sums;
            (sums.width(), sums.height()) == size
                && sums.format() == format
                && g.distances.is_some() == surfaces
        };
        if let Some(gathered) = kept.as_ref().filter(fits) {
            return Ok(gathered.clone());
        }
        let texture = |label, format, usage| {
            let usage = TextureUsages::RENDER_ATTACHMENT | usage;
            self.gpu.texture(label, size, format, usage)
        };
        let distances = || {
            texture(
                "of distances",
                TextureFormat::R32Float,
                TextureUsages::COPY_SRC,
            )
        };
        let gathered = Gathered {
            sums: texture("of sums", format, TextureUsages::TEXTURE_BINDING)?,
            distances: surfaces.then(distances).transpose()?,
        };
        *kept = Some(gathered.clone());
        Ok(gathered)
    }

    fn stats(&self) -> FrameStats {
        let scene = &self.scene;
        let mut stats = FrameStats::default();
        stats.bytes_resident = scene.voxels.bytes + scene.intervals.size();
        let format = slice::sum_format(&self.gpu, scene.appearance.optical_model);
        if matches!(format, TextureFormat::R16Float | TextureFormat::Rgba16Float) {
            let note = "this device does not blend f32, so slabs add up in f16, and thin ones \
                        may be lost";
            stats.notes.push(note.into());
        }
        if self.options.traversal == Traversal::Gpu && scene.cull.is_none() {
            let note = "the volume is streamed, so the CPU finds the boxes to draw";
            stats.notes.push(note.into());
        }
        let filtered = scene.voxels.texels.filtered;
        if self.options.filtering == Filtering::Hardware && !filtered {
            let note = "this device does not filter samples of this type, so the shader does";
            stats.notes.push(note.into());
        }
        stats
    }

    fn parts(&self) -> Parts<'_> {
        Parts {
            gpu: &self.gpu,
            options: &self.options,
            pass: &self.pass,
        }
    }
}

/// What a polygon costs beside its fragments, in fragments.
///
/// Six vertices and four triangles, many without area. On llvmpipe a polygon took as long as
/// 24 to 37 fragments (`aneurism`, 256³ samples, 512×512 pixels, medians of three: one box
/// 13.7 s, 1150 of 4096 boxes 5.3 s, 4730 of 32768 boxes 4.2 s on a loaded machine).
const FRAGMENTS_PER_POLYGON: f64 = 32.0;

impl Gathered {
    fn views(&self) -> Sums {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        Sums {
            gathered: view(&self.sums),
            distances: self.distances.as_ref().map(view),
        }
    }
}

/// The grid of `volume`, or why there is none.
fn source_of(volume: &Volume) -> Result<Arc<dyn BrickSource>, Error> {
    match volume {
        Volume::Grid(grid) => Ok(Arc::new(grid.clone())),
        Volume::Stream(stream) => Ok(stream.source().clone()),
        _ => Err(Error::Unsupported {
            renderer: NAME,
            what: "meshes".into(),
            reason: "it slices regular grids".into(),
        }),
    }
}

impl Samples {
    fn new(
        source: Arc<dyn BrickSource>,
        reach: usize,
        domain: Option<Domain>,
    ) -> Result<Samples, Error> {
        let fills_cells = source.lattice().interpolation == Interpolation::Nearest;
        let source = match fills_cells {
            true => Arc::new(CellCorners::new(source)),
            false => source,
        };
        let lattice = source.lattice();
        let octree = Octree::build(&*source, reach)?;
        let [low, high] = octree.range(0, [0; 3]).map(f64::from);
        let own = Domain {
            bounds: lattice.bounds(),
            scalar_range: (low <= high && (high - low).is_finite()).then_some((low, high)),
        };
        let domain = own.within(domain)?;
        Ok(Samples {
            normalization: Normalization::of(&domain.bounds),
            domain,
            octree,
            lattice,
            fills_cells,
            source,
            reach,
        })
    }
}

impl VolumeRenderer for Slicing {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let appearance = &self.scene.appearance;
        let reach = self.options.reach(appearance.optical_model);
        let volume = Arc::new(Samples::new(
            source_of(volume)?,
            reach,
            self.options.domain,
        )?);
        self.scene = self.parts().scene(appearance, volume, None)?;
        Ok(())
    }

    /// Uploads the transfer function; samples only if they are floats and the range that
    /// matters moved so far that f32 would run out of digits, or if they are kept in bricks,
    /// or if the model needs more samples around each box than the one before.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        ABILITIES.check(NAME, appearance)?;
        let scene = &self.scene;
        let reach = self.options.reach(appearance.optical_model);
        let before = (reach <= scene.volume.reach).then_some(scene);
        let volume = match before {
            Some(scene) => scene.volume.clone(),
            None => {
                let source = scene.volume.source.clone();
                Arc::new(Samples::new(source, reach, self.options.domain)?)
            }
        };
        self.scene = self.parts().scene(appearance, volume, before)?;
        Ok(())
    }

    fn render(&self, view: &View) -> Result<Frame, Error> {
        let start = Instant::now();
        view.validate()?;
        let gpu = &self.gpu;
        let size = (view.width, view.height);
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let target = gpu.texture("to read back", size, READ_BACK_FORMAT, usage)?;
        let mut measures = Measures {
            timer: Timer::new(gpu)?,
            ..Measures::default()
        };
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let target_view = target.create_view(&Default::default());
        let to = (&target_view, To::ReadBack);
        let mut stats = self.record(&mut encoder, view, to, Some(&mut measures))?;
        let pixels = read_back(gpu, &mut encoder, Source::Texture(&target))?;
        let distances = self.gathered(size)?.distances;
        let distances = distances
            .map(|texture| read_back(gpu, &mut encoder, Source::Texture(&texture)))
            .transpose()?;
        let Measures {
            timer,
            fragments,
            arguments,
            submitted,
        } = measures;
        let times = timer.map(|t| t.resolve(gpu, &mut encoder)).transpose()?;
        let counts = fragments
            .map(|f| f.resolve(gpu, &mut encoder))
            .transpose()?;
        let arguments = arguments.map(|(buffer, box_count)| {
            let bytes = size_of::<gpu_data::Arguments>() as u64;
            let copy = read_back(gpu, &mut encoder, Source::Buffer(&buffer, bytes))?;
            Ok::<_, Error>((copy, box_count))
        });
        let arguments = arguments.transpose()?;
        let submitted = submitted.unwrap_or_else(Instant::now);
        gpu.finish(encoder)?;
        stats.gpu_seconds = timer::seconds(gpu, times, submitted.elapsed())?;
        let pixels = pixels.read()?;
        let distances = distances.map(|d| d.read()).transpose()?;
        if let Some(counts) = counts {
            stats.fragments = Some(count::total(counts)?);
        }
        if let Some((copy, box_count)) = arguments {
            let drawn: Vec<gpu_data::Arguments> = copy.read()?;
            let (boxes, indices) = (drawn[0].instance_count, drawn[0].index_count);
            stats.bricks_drawn = Some(boxes.into());
            stats.bricks_skipped = Some(box_count - u64::from(boxes));
            stats.vertices = Some(u64::from(boxes) * slice::vertices(indices));
            // As known where the CPU finds that there is nothing to draw.
            if boxes == 0 {
                stats.fragments = Some(0);
            }
        }
        stats.cpu_seconds = start.elapsed().as_secs_f64();
        let scale = self.scene.volume.normalization.scale;
        let in_world = |distance: f32| match distance < NOWHERE {
            true => (f64::from(distance) * scale) as f32,
            false => f32::INFINITY,
        };
        let mut frame = Frame::new(size, pixels, stats);
        frame.depths = distances.map(|d: Vec<f32>| d.into_iter().map(in_world).collect());
        Ok(frame)
    }
}
