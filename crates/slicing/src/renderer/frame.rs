//! The commands of a frame: which boxes, with what, and in how many batches.

use bytemuck::Zeroable as _;
use tetrascope_core::{Error, FrameStats, OpticalModel, View};
use tetrascope_f32::look::look;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::{BufferUsages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Commands, Outcome, Recorded, SceneDepth, Sums, SumsKind, Target, read_back};

use super::Slicing;
use crate::NAME;
use crate::box_plane::POLYGON;
use crate::boxes::Place;
use crate::count::{self, FragmentCounter};
use crate::counters::{BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES};
use crate::cull::{Cast, Culling};
use crate::frame::{FrameGeometry, geometry};
use crate::gpu_data;
use crate::options::{Filtering, Level, Slicer, Traversal};
use crate::polygons::Polygons;
use crate::samples::Samples;
use crate::slice::{self, Shape, SliceFrame};

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
    pub(super) fn record_frame(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        if !self.style.voxels.is_complete() && !commands.may_submit() {
            return Err(Error::Unsupported {
                renderer: NAME,
                what: "a streamed volume into a caller's encoder".into(),
                reason: "what can show does not fit the memory budget at once".into(),
            });
        }
        let model = self.style.appearance.optical_model;
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
        let normalization = &self.style.volume.normalization;
        let encoder = commands.encoder();
        self.canvas
            .put(encoder, view, normalization, (model, &sums), target)?;
        recorded.stats.passes += 1;
        Ok(match &sums.distances {
            Some(distances) => recorded.with_distances(distances, normalization.scale),
            None => recorded,
        })
    }

    /// Records the frame's boxes into `sums`, batch by batch.
    fn record_boxes(
        &self,
        commands: &mut Commands,
        sums: &Sums,
        depth: Option<&SceneDepth>,
        mut plan: Plan,
    ) -> Result<Recorded, Error> {
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let boxes = &style.volume.boxes;
        let ends = style.voxels.batches(boxes, plan.level, &plan.boxes);
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
                let (frame, slice) = ((&plan.frame, depth.is_some()), &style.slice);
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
                // Rays are followed before anyone knows whether they meet boxes.
                if indices > 0 {
                    stats.count(VERTICES, u64::from(boxes) * slice::vertices(indices));
                    // As known where the CPU finds that there is nothing to draw.
                    if boxes == 0 {
                        stats.count(FRAGMENTS, 0);
                    }
                }
                Ok(Outcome::Complete)
            });
        }
        Ok(recorded)
    }

    /// Brings a batch of boxes onto the device and writes where they are.
    fn fill(&self, plan: &Plan, range: std::ops::Range<usize>) -> Result<u64, Error> {
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        if style.voxels.is_complete() {
            return Ok(0);
        }
        let (source, octree) = style.volume.source().expect("the rest is complete");
        let drawn = &plan.boxes[range.clone()];
        let bytes = style
            .voxels
            .stream(gpu, &**source, &octree.boxes, plan.level, drawn)?;
        let data = self.boxes(plan.level, drawn);
        plan.frame.write_boxes(gpu, range.start, &data)?;
        Ok(bytes)
    }

    fn boxes(&self, level: u32, places: &[Place]) -> Vec<gpu_data::PlacedBox> {
        let style = &self.style;
        let boxes = &style.volume.boxes;
        let of = |place: &Place| gpu_data::PlacedBox {
            low: boxes.low(level, *place).map(|x| x as i32),
            padding: 0,
            // Zero for those that a later batch brings.
            texel: style.voxels.texel(boxes, level, *place).unwrap_or_default(),
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
        let (gpu, style) = (self.canvas.gpu(), &self.style);
        let Samples {
            domain,
            lattice,
            normalization,
            boxes: divided,
            ..
        } = &*style.volume;
        let slices = self.options.slices_per_voxel;
        let Some(geometry) = geometry(view, lattice, normalization, slices)? else {
            return Ok((None, 1));
        };
        let level = self.level(&geometry);
        let box_count = divided.box_count(level) as u64;
        let size = divided.box_size(level);
        let mut frustum = geometry.frustum.clone();
        frustum.planes.extend(&style.kept);
        let viewer = geometry.viewer;
        let known = style.volume.source().zip(style.visibility.as_ref());
        let (boxes, room) = match (&style.cull, known) {
            (None, Some(((_, octree), visibility))) => {
                let boxes = octree.back_to_front(level, visibility, viewer, &frustum);
                let room = boxes.len();
                (boxes, room)
            }
            (Some(_), Some((_, visibility))) => (Vec::new(), visibility.count(level)),
            // All of them may show, or none.
            (_, None) if style.shows => (Vec::new(), box_count as usize),
            (_, None) => (Vec::new(), 0),
        };
        if room == 0 {
            return Ok((None, box_count));
        }
        let slicer = style.slice.slicer;
        let runs = geometry.slabs().div_ceil(style.slice.slabs_per_run);
        let uniform = gpu_data::CameraUniform {
            slabs_per_run: style.slice.slabs_per_run,
            run_count: runs,
            scalar_unit: style.scale.unit,
            scalar_base: style.scale.base,
            raw_unit: style.scale.raw_unit,
            raw_base: style.scale.raw_base,
            raw_most: style.scale.raw_most(),
            ..geometry.uniform(size)
        };
        let mut stats = self.stats();
        let drawn = boxes.len() as u64;
        let data = match slicer {
            // What buffers have at least.
            Slicer::Rays => vec![gpu_data::PlacedBox::zeroed()],
            _ => self.boxes(level, &boxes),
        };
        let mut sent = size_of_val(&uniform) as u64;
        if slicer != Slicer::Rays {
            sent += size_of_val(&data[..]) as u64;
        }
        let stack = match slicer {
            Slicer::VertexProgram => Some(self.pass.stacks(gpu, uniform.slabs_per_box)?),
            _ => None,
        };
        let culling = match (&self.cull, &style.cull) {
            (Some(pass), Some(cull)) => {
                let cast = Cast {
                    level,
                    slicer,
                    viewer,
                    frustum: &frustum,
                    room,
                    index_count: stack.as_ref().map_or(0, |(_, count)| *count),
                };
                let culling = pass.frame(gpu, cull, &style.volume, &style.voxels, &cast)?;
                sent += culling.bytes;
                Some(culling)
            }
            _ => None,
        };
        let shape = match (slicer, stack) {
            (Slicer::Rays, _) => {
                let table = match (culling.as_ref().and_then(Culling::table), known) {
                    (Some(table), _) => table.clone(),
                    (None, Some((_, visibility))) => {
                        let (tables, voxels) = (&style.tables, &style.voxels);
                        tables.known(gpu, divided, level, visibility, voxels)?
                    }
                    (None, None) => unreachable!("what the CPU does not know the device finds"),
                };
                stats.bytes_resident += table.bytes;
                stats.count(VERTICES, u64::from(runs * slice::CORNERS_PER_RUN));
                let table = table.reading(gpu)?;
                Shape::Rays { runs, table }
            }
            (Slicer::VertexProgram, stack) => {
                let (indices, index_count) = stack.expect("made for it");
                match &culling {
                    Some(culling) => Shape::Counted {
                        indices,
                        arguments: culling.arguments.clone(),
                    },
                    None => Shape::Stack {
                        indices,
                        index_count,
                    },
                }
            }
            (Slicer::Cpu, _) => {
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
            &style.appearance,
            view,
            &domain.bounds,
            normalization,
            &style.map,
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
        if known && slicer == Slicer::VertexProgram {
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
        let boxes = &self.style.volume.boxes;
        let least = self.style.voxels.least_level();
        let visibility = match (self.options.level, &self.style.visibility) {
            (Level::Fixed(level), _) => return level.clamp(least, boxes.deepest()),
            (Level::Auto, None) => {
                let most = match self.style.slice.slicer {
                    Slicer::Rays => RAY_CELLS,
                    _ => DEVICE_CELLS,
                };
                return boxes.first_level(|size| size.iter().all(|s| *s <= most));
            }
            (Level::Auto, Some(visibility)) => visibility,
        };
        let cost = |level: &u32| {
            let size = boxes.box_size(*level);
            let polygons = match self.style.slice.slicer {
                Slicer::Rays => 0.0,
                _ => f64::from(geometry.slabs_per_box(size)) * FRAGMENTS_PER_POLYGON,
            };
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
        let style = &self.style;
        let mut stats = FrameStats::default();
        stats.bytes_resident =
            style.voxels.bytes + style.volume.range_bytes() + style.intervals.size();
        let format = slice::sum_format(self.canvas.gpu(), style.appearance.optical_model);
        if matches!(format, TextureFormat::R16Float | TextureFormat::Rgba16Float) {
            let note = "this device does not blend f32, so slabs add up in f16, and thin ones \
                        may be lost";
            stats.notes.push(note.into());
        }
        if self.options.traversal == Traversal::Gpu && style.cull.is_none() {
            let note = "the volume is streamed, so the CPU finds the boxes to draw";
            stats.notes.push(note.into());
        }
        if self.options.slicer != style.slice.slicer {
            let note = "the volume is streamed, so it is drawn in polygons";
            stats.notes.push(note.into());
        }
        let filtered = style.voxels.texels.filtered;
        if self.options.filtering == Filtering::Hardware && !filtered {
            let note = match style.volume.device_grid() {
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
}

/// The cost of a polygon beside its fragments, in fragments.
///
/// Six vertices and four triangles, many without area. On llvmpipe a polygon took as long as
/// 24 to 37 fragments (`aneurism`, 256³ samples, 512×512 pixels, medians of three: one box
/// 13.7 s, 1150 of 4096 boxes 5.3 s, 4730 of 32768 boxes 4.2 s on a loaded machine).
const FRAGMENTS_PER_POLYGON: f64 = 32.0;

/// Cells along an axis of a box, at most, where nobody knows before a frame is drawn how many
/// boxes show. In the example above, those of 16 cells took two fifths of the time of one box, and
/// those of 8 a third.
const DEVICE_CELLS: usize = 16;

/// The same for rays, which pass a box in a step: there those of 16 cells took a third longer than
/// those of 8.
const RAY_CELLS: usize = 8;
