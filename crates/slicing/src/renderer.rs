//! The renderer: what lasts, and how a frame is recorded.

mod parts;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use tetrascope_core::glam::Vec4;
use tetrascope_core::grid::BrickSource;
use tetrascope_core::{
    Appearance, Bounds, Error, Frame, FrameStats, OpticalModel, View, Volume, VolumeRenderer,
};
use tetrascope_f32::ScalarMap;
use tetrascope_f32::look::look;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{self, BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{
    Canvas, Commands, DeviceGrid, Draw, Gpu, Outcome, Recorded, SceneDepth, Sums, SumsKind, Target,
    draw, read_back,
};

use parts::Parts;

use crate::ABILITIES;
use crate::NAME;
use crate::box_plane::POLYGON;
use crate::boxes::Place;
use crate::count::{self, FragmentCounter};
use crate::counters::{BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES};
use crate::cull::{Cast, CullData, CullPass, Culling};
use crate::entry::check;
use crate::frame::{FrameGeometry, geometry};
use crate::gpu_data;
use crate::octree::Visibility;
use crate::options::{Filtering, Level, Slicer, SlicingOptions, Traversal};
use crate::polygons::Polygons;
use crate::samples::{Content, Samples};
use crate::slice::{self, Shape, SliceData, SliceFrame, SlicePass};
use crate::texels::Scale;
use crate::voxels::Voxels;

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
    /// Which boxes can show; `None` where only the device knows.
    visibility: Option<Visibility>,
    voxels: Arc<Voxels>,
    /// Where the GPU traverses and all that can show is on it.
    cull: Option<CullData>,
    intervals: wgpu::Buffer,
    /// Clip planes, normal · p + w ≥ 0 in lattice space.
    kept: Vec<Vec4>,
    slice: SliceData,
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
    /// [`Error::OutOfMemory`] if the device or the budget has no room for one brick. A grid with
    /// [coverage](tetrascope_core::grid::coverage) is drawn as by [`Slicing::from_device`], and
    /// refused with what that refuses.
    pub fn new(
        gpu: &Gpu,
        volume: &Volume,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        let bounds = volume.bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::of(gpu, volume, reach, options)
        })
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
        let bounds = source.lattice().bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::from_source(source, reach, options)
        })
    }

    /// Draws a grid that is on the device: no sample is read back or looked at by the CPU, and
    /// what is empty is found there. The texture may be written again; see [`Slicing::refresh`].
    ///
    /// The GPU finds the boxes, whatever [`SlicingOptions::traversal`] says.
    ///
    /// ```no_run
    /// use tetrascope_core::grid::Lattice;
    /// use tetrascope_core::{Appearance, Error, View};
    /// use tetrascope_gpu::device_grid::Texels;
    /// use tetrascope_gpu::{DeviceGrid, Draw as _, Gpu, Target, wgpu};
    /// use tetrascope_slicing::{Slicing, SlicingOptions};
    ///
    /// # fn record_yours(_: &mut wgpu::CommandEncoder, _: &wgpu::Texture) {}
    /// fn frames(
    ///     gpu: &Gpu,
    ///     lattice: &Lattice,
    ///     appearance: &Appearance,
    ///     views: &[View],
    ///     target: &Target,
    /// ) -> Result<(), Error> {
    ///     let range = Some((0.0, 1.0)); // no scalar will lie outside
    ///     let grid = DeviceGrid::new(gpu, lattice, Texels::Covered, range)?;
    ///     let options = SlicingOptions::default();
    ///     let slicing = Slicing::from_device(gpu, &grid, appearance, &options)?;
    ///     for view in views {
    ///         let mut encoder = gpu.device().create_command_encoder(&Default::default());
    ///         // A compute pass that stores (scalar, coverage) in each texel.
    ///         record_yours(&mut encoder, grid.texture());
    ///         slicing.refresh(&mut encoder)?;
    ///         slicing.encode(&mut encoder, view, target)?;
    ///         gpu.queue().submit([encoder.finish()]);
    ///     }
    ///     Ok(())
    /// }
    /// ```
    ///
    /// # Errors
    /// [`Error::Unsupported`] for samples that fill cells, for polygons cut on the CPU and for
    /// bricks; with coverage also for isosurfaces, greatest colors and shading.
    pub fn from_device(
        gpu: &Gpu,
        grid: &DeviceGrid,
        appearance: &Appearance,
        options: &SlicingOptions,
    ) -> Result<Slicing, Error> {
        let bounds = grid.lattice().bounds();
        Slicing::with(gpu, appearance, options, &bounds, |reach| {
            Samples::on_device(gpu, grid.clone(), reach, options)
        })
    }

    /// Draws another grid that is on the device from now on.
    ///
    /// # Errors
    /// As [`Slicing::from_device`]; what was drawn before is kept then.
    pub fn reload_device(&mut self, grid: &DeviceGrid) -> Result<(), Error> {
        let appearance = &self.scene.appearance;
        ABILITIES.check(NAME, appearance, &grid.lattice().bounds())?;
        let reach = self.options.reach(appearance.optical_model);
        let gpu = self.canvas.gpu();
        let samples = Samples::on_device(gpu, grid.clone(), reach, &self.options)?;
        self.replace(samples)
    }

    /// Records what is to be done once the texture of a grid on the device was written again:
    /// the ranges of boxes are found anew. The work on the CPU is the same for grids of any
    /// size, so a grid may be made in every frame: record what writes it, this, and
    /// [`Draw::encode`], one behind the other.
    ///
    /// # Errors
    /// [`Error::Invalid`] if the volume is not a grid on the device.
    pub fn refresh(&self, encoder: &mut wgpu::CommandEncoder) -> Result<(), Error> {
        match &self.scene.volume.content {
            Content::Device { ranges, .. } => {
                self.canvas
                    .gpu()
                    .checked("slicing::ranges", 0, || ranges.record(encoder))
            }
            Content::Source { .. } => Err(Error::Invalid {
                what: "a volume to be found anew on the device, where it is not made".into(),
                help: Some("reload it; `Slicing::from_device` draws what is made there".into()),
            }),
        }
    }

    /// A renderer of the samples that `samples` has, with ranges that reach so far.
    fn with(
        gpu: &Gpu,
        appearance: &Appearance,
        options: &SlicingOptions,
        bounds: &Bounds,
        samples: impl FnOnce(usize) -> Result<Samples, Error>,
    ) -> Result<Slicing, Error> {
        ABILITIES.check(NAME, appearance, bounds)?;
        options.validate()?;
        let pass = SlicePass::new(gpu)?;
        let volume = Arc::new(samples(options.reach(appearance.optical_model))?);
        let parts = Parts {
            gpu,
            options,
            pass: &pass,
        };
        let scene = parts.scene(appearance, volume, None)?;
        let cull = scene.cull.is_some().then(|| CullPass::new(gpu));
        Ok(Slicing {
            cull: cull.transpose()?,
            canvas: Canvas::new(gpu)?,
            options: options.clone(),
            pass,
            scene,
        })
    }

    /// Draws other samples from now on.
    fn replace(&mut self, samples: Samples) -> Result<(), Error> {
        let scene = self
            .parts()
            .scene(&self.scene.appearance, Arc::new(samples), None)?;
        self.show(scene)
    }

    /// Draws another scene from now on.
    fn show(&mut self, scene: Scene) -> Result<(), Error> {
        if self.cull.is_none() && scene.cull.is_some() {
            self.cull = Some(CullPass::new(self.canvas.gpu())?);
        }
        self.scene = scene;
        Ok(())
    }

    /// Records the frame's boxes into `sums`, batch by batch.
    fn record_boxes(
        &self,
        commands: &mut Commands,
        sums: &Sums,
        depth: Option<&SceneDepth>,
        mut plan: Plan,
    ) -> Result<Recorded, Error> {
        let (gpu, scene) = (self.canvas.gpu(), &self.scene);
        let boxes = &scene.volume.boxes;
        let ends = scene.voxels.batches(boxes, plan.level, &plan.boxes);
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
        let (source, octree) = scene.volume.source().expect("the rest is complete");
        let drawn = &plan.boxes[range.clone()];
        let bytes = scene
            .voxels
            .stream(gpu, &**source, &octree.boxes, plan.level, drawn)?;
        let data = self.boxes(plan.level, drawn);
        plan.frame.write_boxes(gpu, range.start, &data)?;
        Ok(bytes)
    }

    fn boxes(&self, level: u32, places: &[Place]) -> Vec<gpu_data::Box> {
        let scene = &self.scene;
        let boxes = &scene.volume.boxes;
        let of = |place: &Place| gpu_data::Box {
            low: boxes.low(level, *place).map(|x| x as i32),
            padding: 0,
            // Zero for those that a later batch brings.
            texel: scene.voxels.texel(boxes, level, *place).unwrap_or_default(),
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
            boxes: divided,
            ..
        } = &*scene.volume;
        let slices = self.options.slices_per_voxel;
        let Some(geometry) = geometry(view, lattice, normalization, slices)? else {
            return Ok((None, 1));
        };
        let level = self.level(&geometry);
        let box_count = divided.box_count(level) as u64;
        let size = divided.box_size(level);
        let mut frustum = geometry.frustum.clone();
        frustum.planes.extend(&scene.kept);
        let viewer = geometry.viewer;
        let known = scene.volume.source().zip(scene.visibility.as_ref());
        let (boxes, room) = match (&scene.cull, known) {
            (None, Some(((_, octree), visibility))) => {
                let boxes = octree.back_to_front(level, visibility, viewer, &frustum);
                let room = boxes.len();
                (boxes, room)
            }
            (Some(_), Some((_, visibility))) => (Vec::new(), visibility.count(level)),
            // All of them may show.
            (_, None) => (Vec::new(), box_count as usize),
        };
        if room == 0 {
            return Ok((None, box_count));
        }
        let uniform = gpu_data::Frame {
            scalar_unit: scene.scale.unit,
            scalar_base: scene.scale.base,
            raw_unit: scene.scale.raw_unit,
            raw_base: scene.scale.raw_base,
            raw_most: scene.scale.raw_most(),
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
                let of_frame = pass.frame(gpu, cull, &scene.volume, &scene.voxels, &cast)?;
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
                let lows = boxes.iter().map(|place| divided.low(level, *place));
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
        let boxes = &self.scene.volume.boxes;
        let least = self.scene.voxels.least_level();
        let visibility = match (self.options.level, &self.scene.visibility) {
            (Level::Fixed(level), _) => return level.clamp(least, boxes.deepest()),
            (Level::Auto, None) => {
                return boxes.first_level(|size| size.iter().all(|s| *s <= DEVICE_CELLS));
            }
            (Level::Auto, Some(visibility)) => visibility,
        };
        let cost = |level: &u32| {
            let size = boxes.box_size(*level);
            let polygons = f64::from(geometry.slabs_per_box(size)) * FRAGMENTS_PER_POLYGON;
            visibility.count(*level) as f64 * (geometry.fragments_per_box(size) + polygons)
        };
        // Among equally cheap levels, take the coarser one.
        (least..=boxes.deepest())
            .min_by(|a, b| cost(a).total_cmp(&cost(b)))
            .unwrap_or(least)
    }

    /// Statistics where nothing is in front of the eye, or nothing shows, of `box_count` boxes.
    fn no_boxes(&self, box_count: u64) -> FrameStats {
        let mut stats = self.stats();
        stats.count(BRICKS_SKIPPED, box_count);
        for counter in [BRICKS_DRAWN, VERTICES, FRAGMENTS] {
            stats.count(counter, 0);
        }
        stats
    }

    fn stats(&self) -> FrameStats {
        let scene = &self.scene;
        let mut stats = FrameStats::default();
        stats.bytes_resident =
            scene.voxels.bytes + scene.volume.range_bytes() + scene.intervals.size();
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
            let note = match scene.volume.device_grid() {
                None => "this device does not filter samples of this type, so the shader does",
                Some(_) => {
                    "samples on the device are mapped before they are filtered, so the \
                            shader filters them"
                }
            };
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

/// Cells along an axis of a box, at most, where nobody knows before a frame is drawn how many
/// boxes show. In the example above, those of 16 cells took two fifths of the time of one box, and
/// those of 8 a third.
const DEVICE_CELLS: usize = 16;

impl VolumeRenderer for Slicing {
    fn reload(&mut self, volume: &Volume) -> Result<(), Error> {
        let appearance = &self.scene.appearance;
        ABILITIES.check(NAME, appearance, &volume.bounds())?;
        let reach = self.options.reach(appearance.optical_model);
        self.replace(Samples::of(
            self.canvas.gpu(),
            volume,
            reach,
            &self.options,
        )?)
    }

    /// Uploads the transfer function; samples only if they are floats and the range that
    /// matters moved so far that f32 would run out of digits, or if they are kept in bricks,
    /// or if the model needs more samples around each box than the one before.
    fn restyle(&mut self, appearance: &Appearance) -> Result<(), Error> {
        let scene = &self.scene;
        ABILITIES.check(NAME, appearance, &scene.volume.bounds())?;
        let reach = self.options.reach(appearance.optical_model);
        let before = (reach <= scene.volume.reach).then_some(scene);
        let volume = match before {
            Some(scene) => scene.volume.clone(),
            None => {
                let gpu = self.canvas.gpu();
                Arc::new(scene.volume.reaching(gpu, reach, &self.options)?)
            }
        };
        let scene = self.parts().scene(appearance, volume, before)?;
        self.show(scene)
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
        // Surfaces are hidden when they are put among the geometry.
        let depth = target.depth.as_ref().filter(|_| !is_surface);
        let (plan, box_count) = self.plan(view, commands, depth)?;
        if plan.is_none() && !is_surface {
            let mut stats = self.no_boxes(box_count);
            stats.passes = self.canvas.put_nothing(commands.encoder(), view, target)?;
            return Ok(Recorded::new(stats));
        }
        let sums = self.canvas.sums(
            view,
            SumsKind {
                format: slice::sum_format(self.canvas.gpu(), model),
                usage: TextureUsages::RENDER_ATTACHMENT,
                distances: is_surface,
            },
        )?;
        let mut recorded = match plan {
            Some(plan) => self.record_boxes(commands, &sums, depth, plan)?,
            None => {
                slice::clear(commands.encoder(), &sums);
                Recorded::new(self.no_boxes(box_count))
            }
        };
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
