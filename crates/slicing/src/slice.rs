//! The pass that draws slabs (`box_plane.wgsl` or `rays.wgsl`, `slab.wgsl`, `slice.wgsl`,
//! `surface.wgsl`).

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_gpu::canvas::NOWHERE;
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, deep, group, look_constants, model_constant};
use tetrascope_gpu::wgpu::{self, BindingType, BufferUsages, ShaderStages};
use tetrascope_gpu::{Gpu, RenderProgram, Sums};

use crate::box_plane::{POLYGON, edges, sequence};
use crate::count::FragmentCounter;
use crate::gpu_data::{Corner, PlacedBox, Tables};
use crate::options::{
    Crossing, Integration, Phong, PlaneTest, Shading, SlabEnds, Slicer, SlicingOptions, StepLength,
};
use crate::polygons::Polygons;
use crate::runs::{Work, slabs_per_run};
use crate::table;
use crate::voxels::Voxels;

const LABEL: &str = "slicing::slice";

/// The parts of the pass that do not depend on the volume.
#[derive(Debug)]
pub(crate) struct SlicePass {
    frame_layout: wgpu::BindGroupLayout,
    tables: wgpu::Buffer,
    /// Triangles of a stack of polygons, for as many as were needed yet.
    stack: Mutex<(u32, wgpu::Buffer)>,
}

/// The pass for one volume and appearance.
#[derive(Clone, Debug)]
pub(crate) struct SliceData {
    volume_group: wgpu::BindGroup,
    program: RenderProgram,
    pipeline: wgpu::RenderPipeline,
    /// Who cuts boxes of this volume.
    pub(crate) slicer: Slicer,
    /// Slabs of a ray that one fragment takes at most.
    pub(crate) slabs_per_run: u32,
}

/// The data that a frame is drawn with.
pub(crate) struct SliceFrame {
    group: wgpu::BindGroup,
    boxes: wgpu::Buffer,
    shape: Shape,
}

/// The shape that is drawn for boxes.
pub(crate) enum Shape {
    /// A stack of polygons an instance, for the vertex program.
    Stack {
        indices: wgpu::Buffer,
        index_count: u32,
    },
    /// The same for boxes that the device counts.
    Counted {
        indices: wgpu::Buffer,
        arguments: wgpu::Buffer,
    },
    /// All slabs of rays, in runs, for which the group has the table of boxes.
    Rays { runs: u32, table: wgpu::BindGroup },
    /// Polygons as the CPU has cut them.
    Polygons {
        corners: wgpu::Buffer,
        indices: wgpu::Buffer,
        /// How many indices there are up to the end of each box.
        ends: Vec<u32>,
    },
}

/// How often [`Crossing::Corrected`] corrects. False position gains digits by a factor of
/// about 1.4 a step; from the 3 of a straight line to the 7 of f32 that is three, and a bent
/// field wants as many before.
const CORRECTIONS: f64 = 8.0;

/// The facts on which the pipeline of an appearance depends.
pub(crate) struct Look<'a> {
    pub(crate) intervals: &'a wgpu::Buffer,
    pub(crate) interval_count: usize,
    pub(crate) appearance: &'a Appearance,
    /// A bound of the optical depth of any slab.
    pub(crate) deepest: f32,
    /// Whether there are samples that are not finite.
    pub(crate) gaps: bool,
    /// Whether each cell has one scalar, that of its lower corner.
    pub(crate) nearest: bool,
}

impl SlicePass {
    pub(crate) fn new(gpu: &Gpu) -> Result<SlicePass, Error> {
        let (first, second) = (
            edges().map(|e| e.map(|e| e[0])),
            edges().map(|e| e.map(|e| e[1])),
        );
        let tables = [Tables {
            sequence: sequence(),
            first,
            second,
        }];
        let tables = gpu.upload("slicing::tables", &tables, BufferUsages::UNIFORM)?;
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let types = [UNIFORM, READ, UNIFORM, UNIFORM, READ, TEXELS];
        let frame_layout = gpu.layout(LABEL, stages, &types)?;
        Ok(SlicePass {
            frame_layout,
            tables,
            stack: Mutex::new((1, stack(gpu, 1)?)),
        })
    }

    /// The pipeline and bindings for one volume and appearance.
    pub(crate) fn data(
        &self,
        gpu: &Gpu,
        voxels: &Voxels,
        look: &Look,
        options: &SlicingOptions,
    ) -> Result<SliceData, Error> {
        let sampler = voxels.texels.filtered.then(|| {
            gpu.device().create_sampler(&wgpu::SamplerDescriptor {
                label: Some("slicing::linear"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            })
        });
        let texture = wgpu::BindingResource::TextureView(&voxels.view);
        let mut resources = vec![look.intervals.as_entire_binding(), texture];
        let mut types = vec![READ, texture_type(voxels)];
        if let Some(sampler) = &sampler {
            resources.push(wgpu::BindingResource::Sampler(sampler));
            types.push(BindingType::Sampler(wgpu::SamplerBindingType::Filtering));
        }
        let volume_layout = gpu.layout(LABEL, ShaderStages::FRAGMENT, &types)?;
        let slicer = match options.slicer {
            // The boxes of a batch are not those of all of a ray.
            Slicer::Rays if !voxels.is_complete() => Slicer::VertexProgram,
            slicer => slicer,
        };
        let options = &SlicingOptions {
            slicer,
            ..options.clone()
        };
        let program = self.program(gpu, &volume_layout, voxels, look, options)?;
        Ok(SliceData {
            slicer,
            slabs_per_run: slabs_per_run(look.work(options)),
            volume_group: gpu
                .checked(LABEL, 0, || group(gpu, LABEL, &volume_layout, &resources))?,
            pipeline: gpu.render_pipeline(&program)?,
            program,
        })
    }

    fn program(
        &self,
        gpu: &Gpu,
        volume_layout: &wgpu::BindGroupLayout,
        voxels: &Voxels,
        look: &Look,
        options: &SlicingOptions,
    ) -> Result<RenderProgram, Error> {
        let model = look.appearance.optical_model;
        let yes = |condition: bool| f64::from(u8::from(condition));
        let phong = match options.shading {
            Shading::Phong(phong) => phong,
            Shading::None => Phong::default(),
        };
        let [clipped, cued] = look_constants(look.appearance);
        let common = [
            clipped,
            cued,
            ("CUT_ENDS", yes(options.slab_ends == SlabEnds::Clipped)),
            ("GAPS", yes(look.gaps)),
            ("NEAREST", yes(look.nearest)),
            ("TRILINEAR", yes(options.is_trilinear(model))),
        ];
        let volume = [
            model_constant(model),
            deep(look.deepest),
            ("SLABS", yes(options.integration == Integration::Slabs)),
            ("PER_RAY", yes(options.step_length == StepLength::PerRay)),
            ("PHONG", yes(options.shading != Shading::None)),
            ("AMBIENT", phong.ambient),
            ("DIFFUSE", phong.diffuse),
            ("SPECULAR", phong.specular),
            ("SHININESS", phong.shininess),
        ];
        let corrections = match options.crossing {
            Crossing::Corrected => CORRECTIONS,
            Crossing::Cells | Crossing::Linear => 0.0,
        };
        let surface = [
            ("IN_CELLS", yes(options.crossing == Crossing::Cells)),
            ("CORRECTIONS", corrections),
        ];
        let sums = wgpu::ColorTargetState {
            format: sum_format(gpu, model),
            blend: Some(blend(model)),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let rays = options.slicer == Slicer::Rays;
        let (fragment, own, targets) = if model == OpticalModel::Isosurfaces {
            // What is drawn later hides what was drawn before.
            let colors = wgpu::ColorTargetState {
                blend: None,
                ..sums
            };
            let distances = wgpu::TextureFormat::R32Float.into();
            (
                if rays { "fs_run_surface" } else { "fs_surface" },
                &surface[..],
                vec![Some(colors), Some(distances)],
            )
        } else {
            let fragment = if rays { "fs_run" } else { "fs_slice" };
            (fragment, &volume[..], vec![Some(sums)])
        };
        let covered = voxels.texels.covered.map(|is| ("COVERED", yes(is)));
        let (vertex, vertex_constants, buffers) = match options.slicer {
            Slicer::VertexProgram => {
                let by_sides = yes(options.plane_test == PlaneTest::Sides);
                ("vs_slice", vec![("BY_SIDES", by_sides)], vec![])
            }
            Slicer::Cpu => ("vs_polygon", vec![], vec![Some(CORNERS)]),
            Slicer::Rays => ("vs_run", vec![], vec![]),
        };
        let mut groups = vec![self.frame_layout.clone(), volume_layout.clone()];
        if rays {
            groups.push(table::reading(gpu)?);
        }
        Ok(RenderProgram {
            label: LABEL,
            source: voxels.texels.program,
            vertex,
            vertex_constants,
            buffers,
            fragment: Some(fragment),
            constants: [&common, own, covered.as_slice()].concat(),
            targets,
            groups,
            // Both windings: a grid's axes may be left-handed.
            ..Default::default()
        })
    }

    /// The triangles of stacks of as many polygons as the uniform's `slabs_per_box`, and
    /// how many indices they have.
    pub(crate) fn stacks(
        &self,
        gpu: &Gpu,
        slabs_per_box: u32,
    ) -> Result<(wgpu::Buffer, u32), Error> {
        let mut kept = self.stack.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.0 < slabs_per_box {
            let polygons = slabs_per_box.next_power_of_two();
            *kept = (polygons, stack(gpu, polygons)?);
        }
        Ok((kept.1.clone(), slabs_per_box * TRIANGLES.len() as u32))
    }

    /// The data that a frame is drawn with, from its buffers; the look's uniform and items are two.
    pub(crate) fn frame(
        &self,
        gpu: &Gpu,
        uniform: &wgpu::Buffer,
        boxes: wgpu::Buffer,
        [look, items]: [&wgpu::Buffer; 2],
        ends: &wgpu::TextureView,
        shape: Shape,
    ) -> Result<SliceFrame, Error> {
        let buffers = [uniform, &boxes, look, &self.tables, items];
        let mut resources = buffers.map(|b| b.as_entire_binding()).to_vec();
        resources.push(wgpu::BindingResource::TextureView(ends));
        Ok(SliceFrame {
            group: gpu.checked(LABEL, 0, || {
                group(gpu, LABEL, &self.frame_layout, &resources)
            })?,
            boxes,
            shape,
        })
    }

    /// Records one draw of some of the frame's boxes into `sums`, over what is there
    /// unless they are the first. The draw is number `index` of the frame.
    #[expect(
        clippy::too_many_arguments,
        reason = "each is a different thing of a pass"
    )]
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (frame, ends): (&SliceFrame, bool),
        data: &SliceData,
        boxes: Range<u32>,
        index: u32,
        sums: &Sums,
        counter: Option<&FragmentCounter>,
    ) -> Result<(), Error> {
        let pipeline = data.pipeline(gpu, ends)?;
        let mut pass = begin(encoder, sums, index == 0);
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &frame.group, &[]);
        pass.set_bind_group(1, &data.volume_group, &[]);
        let draw = |pass: &mut wgpu::RenderPass| frame.shape.draw(pass, boxes);
        match counter {
            Some(counter) => counter.count(&mut pass, index, draw),
            None => draw(&mut pass),
        }
        Ok(())
    }
}

impl Look<'_> {
    /// The numbers on which loops of a slab depend.
    fn work(&self, options: &SlicingOptions) -> Work {
        let model = self.appearance.optical_model;
        let cells = model == OpticalModel::Isosurfaces && options.crossing == Crossing::Cells;
        Work {
            model,
            intervals: self.interval_count,
            surfaces: self.appearance.isosurfaces.len(),
            in_parts: self.deepest > 1.0 || self.appearance.depth_cue.is_some(),
            by_cells: self.gaps || self.nearest || cells,
        }
    }
}

impl SliceData {
    /// With `ends` for rays that end before an application's geometry.
    fn pipeline(&self, gpu: &Gpu, ends: bool) -> Result<wgpu::RenderPipeline, Error> {
        if !ends {
            return Ok(self.pipeline.clone());
        }
        let mut program = self.program.clone();
        program.constants.push(("ENDS", 1.0));
        gpu.render_pipeline(&program)
    }
}

/// The corners of polygons that the CPU has cut.
const CORNERS: wgpu::VertexBufferLayout = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Sint32, 2 => Uint32],
};

/// Begins a pass into `sums`, which is cleared first or kept.
fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    sums: &Sums,
    clear: bool,
) -> wgpu::RenderPass<'a> {
    let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
    let color = view(&sums.color);
    let distances = sums.distances.as_ref().map(view);
    let nowhere = wgpu::Color {
        r: NOWHERE.into(),
        ..wgpu::Color::TRANSPARENT
    };
    let attachment = |view, color| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: match clear {
                true => wgpu::LoadOp::Clear(color),
                false => wgpu::LoadOp::Load,
            },
            store: wgpu::StoreOp::Store,
        },
    };
    let mut attachments = vec![Some(attachment(&color, wgpu::Color::TRANSPARENT))];
    attachments.extend(distances.as_ref().map(|v| Some(attachment(v, nowhere))));
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(LABEL),
        color_attachments: &attachments,
        ..Default::default()
    })
}

/// Records that nothing is drawn.
pub(crate) fn clear(encoder: &mut wgpu::CommandEncoder, sums: &Sums) {
    begin(encoder, sums, true);
}

/// The format of what slabs are drawn into; isosurfaces are not blended.
pub(crate) fn sum_format(gpu: &Gpu, model: OpticalModel) -> wgpu::TextureFormat {
    match model {
        OpticalModel::Isosurfaces => wgpu::TextureFormat::Rgba32Float,
        _ => gathered_format(gpu, model),
    }
}

impl Shape {
    /// The polygons of the CPU on the device.
    pub(crate) fn of(gpu: &Gpu, polygons: Polygons) -> Result<Shape, Error> {
        let (corners, indices) = (&polygons.corners, &polygons.indices);
        Ok(Shape::Polygons {
            corners: gpu.upload("slicing::corners", corners, BufferUsages::VERTEX)?,
            indices: gpu.upload("slicing::triangles", indices, BufferUsages::INDEX)?,
            ends: polygons.ends,
        })
    }

    fn draw(&self, pass: &mut wgpu::RenderPass, boxes: Range<u32>) {
        let of = wgpu::IndexFormat::Uint32;
        match self {
            Shape::Rays { runs, table } => {
                pass.set_bind_group(2, table, &[]);
                pass.draw(0..CORNERS_PER_RUN, 0..*runs);
            }
            Shape::Stack {
                indices,
                index_count,
            } => {
                pass.set_index_buffer(indices.slice(..), of);
                pass.draw_indexed(0..*index_count, 0, boxes);
            }
            Shape::Counted { indices, arguments } => {
                pass.set_index_buffer(indices.slice(..), of);
                pass.draw_indexed_indirect(arguments, 0);
            }
            Shape::Polygons {
                corners,
                indices,
                ends,
            } => {
                let end = |count: u32| match count {
                    0 => 0,
                    n => ends[n as usize - 1],
                };
                pass.set_vertex_buffer(0, corners.slice(..));
                pass.set_index_buffer(indices.slice(..), of);
                pass.draw_indexed(end(boxes.start)..end(boxes.end), 0, 0..1);
            }
        }
    }
}

impl SliceFrame {
    /// Writes boxes from number `first` on, before the next submission.
    pub(crate) fn write_boxes(
        &self,
        gpu: &Gpu,
        first: usize,
        boxes: &[PlacedBox],
    ) -> Result<(), Error> {
        let bytes: &[u8] = bytemuck::cast_slice(boxes);
        let offset = (first * size_of::<PlacedBox>()) as u64;
        gpu.checked("slicing::boxes", bytes.len() as u64, || {
            gpu.queue().write_buffer(&self.boxes, offset, bytes);
        })
    }
}

/// A triangle over the image for each run of slabs.
pub(crate) const CORNERS_PER_RUN: u32 = 3;

/// A polygon as a fan.
const TRIANGLES: [u32; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5];

/// Vertices of a stack of polygons with this many indices.
pub(crate) fn vertices(index_count: u32) -> u64 {
    u64::from(index_count) / TRIANGLES.len() as u64 * POLYGON as u64
}

fn stack(gpu: &Gpu, polygons: u32) -> Result<wgpu::Buffer, Error> {
    let indices: Vec<u32> = (0..polygons)
        .flat_map(|polygon| TRIANGLES.map(|corner| POLYGON as u32 * polygon + corner))
        .collect();
    gpu.upload("slicing::stack", &indices, BufferUsages::INDEX)
}

fn texture_type(voxels: &Voxels) -> BindingType {
    let filterable = voxels.texels.filtered;
    let sample_type = match voxels.texels.format {
        wgpu::TextureFormat::R8Uint | wgpu::TextureFormat::R16Uint => wgpu::TextureSampleType::Uint,
        wgpu::TextureFormat::R16Sint => wgpu::TextureSampleType::Sint,
        _ => wgpu::TextureSampleType::Float { filterable },
    };
    BindingType::Texture {
        sample_type,
        view_dimension: wgpu::TextureViewDimension::D3,
        multisampled: false,
    }
}
