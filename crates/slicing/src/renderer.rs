//! The renderer: what lasts, and how a frame is recorded.

mod parts;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use tetrascope_core::glam::Vec4;
use tetrascope_core::grid::{BrickSource, Interpolation, Lattice};
use tetrascope_core::{
    Appearance, Error, Frame, FrameStats, OpticalModel, View, Volume, VolumeRenderer,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{Domain, Normalization, ScalarMap};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{
    Canvas, Commands, Draw, Gpu, Outcome, Recorded, SceneDepth, Sums, SumsKind, Target, draw,
    read_back,
};

use parts::Parts;

use crate::ABILITIES;
use crate::NAME;
use crate::box_plane::POLYGON;
use crate::cells::between_samples;
use crate::count::{self, FragmentCounter};
use crate::counters::{BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES};
use crate::cull::{Cast, CullData, CullPass, Culling};
use crate::entry::check;
use crate::frame::{FrameGeometry, geometry};
use crate::gpu_data;
use crate::octree::{Octree, Place, Visibility};
use crate::options::{Filtering, Level, Slicer, SlicingOptions, Traversal};
use crate::polygons::Polygons;
use crate::slice::{self, Shape, SliceData, SliceFrame, SlicePass};
use crate::voxels::{Scale, Voxels};

/// Pipelines and the uploaded grid.
#[derive(Debug)]
pub struct Slicing {
    canvas: Canvas,
    options: SlicingOptions,
    pass: SlicePass,
    /// Where the GPU traverses.
    cull: Option<CullPass>,
    scene: Scene,
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
        check(&*source, appearance, options)?;
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
            canvas: Canvas::new(gpu)?,
            options: options.clone(),
            pass,
            scene,
        })
    }

    /// Records the frame's boxes into `sums`, batch by batch.
    fn record_boxes(
        &self,
        commands: &mut Commands,
        view: &View,
        sums: &Sums,
        depth: Option<&SceneDepth>,
    ) -> Result<Recorded, Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
        let (plan, box_count) = self.plan(view, commands, depth)?;
        let Some(mut plan) = plan else {
            // Nothing in front of the eye, or nothing that shows.
            slice::clear(commands.encoder(), sums);
            let mut stats = self.stats();
            stats.count(BRICKS_DRAWN, 0);
            stats.count(BRICKS_SKIPPED, box_count);
            stats.count(VERTICES, 0);
            stats.count(FRAGMENTS, 0);
            return Ok(Recorded::new(stats));
        };
        let octree = &scene.volume.octree;
        let ends = scene.voxels.batches(octree, plan.level, &plan.boxes);
        let counter = FragmentCounter::new(gpu, ends.len())?;
        if let (Some(culling), Some(cull)) = (&plan.culling, &self.cull) {
            gpu.checked("slicing::cull", 0, || {
                cull.record(commands.encoder(), culling);
            })?;
        }
        let mut first = 0;
        for (index, end) in (0..).zip(ends) {
            if first > 0 {
                // The device must be done with the slots before they are filled again.
                commands.submit()?;
            }
            plan.stats.bytes_uploaded += self.fill(&plan, first..end)?;
            let boxes = first as u32..end as u32;
            gpu.checked("slicing::slice", 0, || {
                let (frame, slice) = ((&plan.frame, depth.is_some()), &scene.slice);
                let (pass, counter) = (&self.pass, counter.as_ref());
                let encoder = commands.encoder();
                pass.record(gpu, encoder, frame, slice, boxes, index, sums, counter)
            })??;
            plan.stats.passes += 1;
            first = end;
        }
        let mut recorded = Recorded::new(plan.stats);
        if let Some(counter) = counter {
            let counts = counter.resolve(gpu, commands.encoder())?;
            recorded = recorded.then(move |stats| {
                stats.count(FRAGMENTS, count::total(counts)?);
                Ok(Outcome::Complete)
            });
        }
        if let Some(culling) = plan.culling {
            let bytes = size_of::<gpu_data::Arguments>() as u64;
            let source = Source::Buffer(&culling.arguments, bytes);
            let arguments = read_back(gpu, commands.encoder(), source)?;
            recorded = recorded.then(move |stats| {
                let drawn: Vec<gpu_data::Arguments> = arguments.read()?;
                let (boxes, indices) = (drawn[0].instance_count, drawn[0].index_count);
                stats.count(BRICKS_DRAWN, boxes.into());
                stats.count(BRICKS_SKIPPED, culling.box_count - u64::from(boxes));
                stats.count(VERTICES, u64::from(boxes) * slice::vertices(indices));
                // As known where the CPU finds that there is nothing to draw.
                if boxes == 0 {
                    stats.count(FRAGMENTS, 0);
                }
                Ok(Outcome::Complete)
            });
        }
        Ok(recorded)
    }

    /// Brings a batch of boxes onto the device and writes where they are.
    fn fill(&self, plan: &Plan, range: std::ops::Range<usize>) -> Result<u64, Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
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
    fn plan(
        &self,
        view: &View,
        commands: &mut Commands,
        depth: Option<&SceneDepth>,
    ) -> Result<(Option<Plan>, u64), Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
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
                stats.count(VERTICES, polygons.corners.len() as u64);
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
        let anchor = geometry.anchor_depth;
        let encoder = commands.encoder();
        let (ends, _) = self
            .canvas
            .ends(encoder, view, normalization, anchor, depth)?;
        let frame = self
            .pass
            .frame(gpu, &uniform, data, [&look, &items], &ends, shape)?;
        stats.count(GEOMETRY_BYTES, sent);
        let known = culling.is_none();
        let slabs = u64::from(geometry.slabs_per_box(size));
        if known {
            stats.count(BRICKS_DRAWN, drawn);
            stats.count(BRICKS_SKIPPED, box_count - drawn);
        }
        if known && self.options.slicer == Slicer::VertexProgram {
            stats.count(VERTICES, drawn * slabs * POLYGON as u64);
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

    fn stats(&self) -> FrameStats {
        let scene = &self.scene;
        let mut stats = FrameStats::default();
        stats.bytes_resident = scene.voxels.bytes + scene.intervals.size();
        let format = slice::sum_format(self.canvas.gpu(), scene.appearance.optical_model);
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
            gpu: self.canvas.gpu(),
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

/// The grid of `volume`, or why there is none.
pub(crate) fn source_of(volume: &Volume) -> Result<Arc<dyn BrickSource>, Error> {
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
        let source = between_samples(source);
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
        ABILITIES.check(NAME, appearance, &volume.bounds())?;
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
        let scene = &self.scene;
        ABILITIES.check(NAME, appearance, &scene.volume.source.lattice().bounds())?;
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
        draw::render(self, view)
    }
}

impl Draw for Slicing {
    fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// # Errors
    /// In a caller's encoder a volume that is streamed is [`Error::Unsupported`], as each of its
    /// batches must be submitted before the next is uploaded.
    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        if !self.scene.voxels.is_complete() && !commands.may_submit() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "a streamed volume into a caller's encoder".into(),
                reason: "what can show does not fit the memory budget at once".into(),
            });
        }
        let model = self.scene.appearance.optical_model;
        let is_surface = model == OpticalModel::Isosurfaces;
        let sums = self.canvas.sums(
            view,
            SumsKind {
                format: slice::sum_format(self.canvas.gpu(), model),
                usage: TextureUsages::RENDER_ATTACHMENT,
                distances: is_surface,
            },
        )?;
        // Surfaces are hidden when they are put among the geometry.
        let depth = target.depth.as_ref().filter(|_| !is_surface);
        let mut recorded = self.record_boxes(commands, view, &sums, depth)?;
        let normalization = &self.scene.volume.normalization;
        let encoder = commands.encoder();
        self.canvas
            .put(encoder, view, normalization, (model, &sums), target)?;
        recorded.stats.passes += 1;
        Ok(match &sums.distances {
            Some(distances) => recorded.with_distances(distances, normalization.scale),
            None => recorded,
        })
    }
}
