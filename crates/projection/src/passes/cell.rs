//! Pass 3: draw the cells (`cell.wgsl`).

use std::sync::{Arc, OnceLock};

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{
    READ, TEXELS, UNIFORM, group, layout, model_constant, module, pipeline_layout,
};
use tetrascope_gpu::preintegration::TABLE;
use tetrascope_gpu::wgpu::{self, BindingResource, BufferUsages, ShaderStages};
use tetrascope_gpu::{Gpu, sides};
use tetrascope_shaders::projection::CELL;

use super::faces::FacePass;
use super::lists::{self, ListPass};
use super::surface::{self, SurfaceData, SurfacePass};
use crate::gpu_data;
use crate::volume::{Field, Geometry, Look};

/// Cells that one draw call covers: its 16-bit indices number four corners of each.
const CELLS_PER_DRAW: u32 = (1 << 16) / 4;

/// Two triangles around the corners of a cell's footprint.
const FOOTPRINT: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// What does not depend on the optical model.
#[derive(Clone, Debug)]
pub(crate) struct CellPass {
    module: wgpu::ShaderModule,
    frame_layout: wgpu::BindGroupLayout,
    volume_layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    indices: wgpu::Buffer,
}

/// What is on the device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uploaded<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) field: &'a Field,
    pub(crate) look: &'a Look,
}

/// The uniforms of a frame; new ones each time, as frames may be recorded before others
/// are submitted.
#[derive(Clone, Debug)]
pub(crate) struct FrameData {
    pub(crate) values: gpu_data::Frame,
    pub(crate) frame: wgpu::Buffer,
    pub(crate) look: wgpu::Buffer,
    /// Where rays end, and whether they do.
    pub(crate) ends: (wgpu::TextureView, bool),
    /// Surfaces and lights, as `surfaces.wgsl` wants them.
    pub(crate) items: Vec<[f32; 4]>,
}

/// What becomes of fragments.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Into<'a> {
    /// They are blended.
    Sum,
    /// They are listed for each pixel.
    Lists(&'a ListPass),
    /// The nearest surface is kept.
    Nearest(&'a SurfacePass, &'a SurfaceData),
    /// They are of faces, and are blended.
    Faces(&'a FacePass),
}

/// The pass for one volume and appearance.
#[derive(Clone, Debug)]
pub(crate) struct CellData {
    program: CellProgram,
    pipeline: wgpu::RenderPipeline,
    /// For rays that end before an application's geometry, compiled when it is first needed.
    ending: Arc<OnceLock<wgpu::RenderPipeline>>,
    pub(crate) volume_group: wgpu::BindGroup,
    pub(crate) count: u32,
    /// Group 2, where faces are drawn in place of footprints.
    faces: Option<wgpu::BindGroup>,
}

/// What both pipelines have in common.
#[derive(Clone, Debug)]
struct CellProgram {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    vertices: &'static str,
    fragments: &'static str,
    /// Of the vertex stage, and of the fragment stage.
    constants: [Vec<(&'static str, f64)>; 2],
    targets: Vec<Option<wgpu::ColorTargetState>>,
    depth: Option<wgpu::DepthStencilState>,
    cull_mode: Option<wgpu::Face>,
}

impl CellProgram {
    /// With `ends` for rays that end before an application's geometry.
    fn pipeline(&self, gpu: &Gpu, ends: bool) -> Result<wgpu::RenderPipeline, Error> {
        let label = "projection::cell";
        let [vertices, fragments] = &self.constants;
        let mut fragments = fragments.clone();
        fragments.push(("ENDS", ends.into()));
        let with = |constants| wgpu::PipelineCompilationOptions {
            constants,
            ..Default::default()
        };
        gpu.checked(label, 0, || {
            gpu.device()
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(label),
                    layout: Some(&self.layout),
                    vertex: wgpu::VertexState {
                        module: &self.module,
                        entry_point: Some(self.vertices),
                        compilation_options: with(vertices),
                        buffers: &[],
                    },
                    primitive: wgpu::PrimitiveState {
                        cull_mode: self.cull_mode,
                        ..Default::default()
                    },
                    depth_stencil: self.depth.clone(),
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &self.module,
                        entry_point: Some(self.fragments),
                        compilation_options: with(&fragments),
                        targets: &self.targets,
                    }),
                    multiview_mask: None,
                    cache: None,
                })
        })
    }
}

impl CellData {
    fn pipeline(&self, gpu: &Gpu, ends: bool) -> Result<&wgpu::RenderPipeline, Error> {
        if !ends {
            return Ok(&self.pipeline);
        }
        if let Some(pipeline) = self.ending.get() {
            return Ok(pipeline);
        }
        let made = self.program.pipeline(gpu, true)?;
        Ok(self.ending.get_or_init(|| made))
    }
}

impl CellPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<CellPass, Error> {
        let label = "projection::cell";
        let indices: Vec<u16> = (0..CELLS_PER_DRAW)
            .flat_map(|cell| FOOTPRINT.map(|corner| 4 * cell as u16 + corner))
            .collect();
        let indices = gpu.upload("projection::cell indices", &indices, BufferUsages::INDEX)?;
        gpu.checked(label, 0, || {
            let stages = ShaderStages::VERTEX_FRAGMENT;
            let frame_layout = layout(gpu, label, stages, &[UNIFORM, UNIFORM, TEXELS]);
            let types = [TEXELS, READ, READ, READ, READ, TEXELS, READ, TABLE];
            let volume_layout = layout(gpu, label, stages, &types);
            CellPass {
                module: module(gpu, label, CELL),
                pipeline_layout: pipeline_layout(gpu, label, &[&frame_layout, &volume_layout]),
                frame_layout,
                volume_layout,
                indices,
            }
        })
    }

    /// The pass for what is to be drawn, in the order of the cell indices in `drawn`.
    pub(crate) fn data(
        &self,
        gpu: &Gpu,
        uploaded: Uploaded,
        drawn: &wgpu::Buffer,
        model: OpticalModel,
        into: Into,
    ) -> Result<CellData, Error> {
        let mut constants = vec![
            model_constant(model),
            ("DEEPEST", f64::from(uploaded.look.deepest)),
            ("INTERVAL_COUNT", uploaded.look.interval_count.into()),
        ];
        // The programs of faces do not know them.
        if !matches!(into, Into::Faces(_)) {
            constants.extend(uploaded.look.extras);
            constants.push(sides::constant(gpu)?);
        }
        let in_pieces = ("PIECES", uploaded.look.culled.in_pieces.into());
        let in_parts = ("PARTS", uploaded.look.culled.in_parts.into());
        constants.push(in_pieces);
        if !matches!(into, Into::Faces(_)) {
            constants.push(in_parts);
        }
        let mut per_vertex = vec![
            ("SCALARS_PER_CELL", uploaded.field.per_cell.into()),
            ("INTERVAL_COUNT", uploaded.look.interval_count.into()),
            in_pieces,
        ];
        let (mut vertices, mut cull_mode) = ("vs_cell", None);
        if let Into::Faces(pass) = into {
            let (cells, most) = (uploaded.look.culled.items, u32::MAX / 12);
            if cells > most {
                return Err(Error::TooLarge {
                    what: "the mesh".into(),
                    needed: cells.into(),
                    limit: most.into(),
                    unit: "cells",
                });
            }
            vertices = "vs_face";
            cull_mode = Some(wgpu::Face::Back);
            per_vertex.extend(pass.vertex_constants(uploaded.field.range));
        }
        constants.extend(uploaded.look.table.constants(uploaded.field.range));
        let blended = [Some(wgpu::ColorTargetState {
            format: gathered_format(gpu, model),
            blend: Some(blend(model)),
            write_mask: wgpu::ColorWrites::ALL,
        })];
        let untouched = [Some(lists::UNTOUCHED)];
        let (module, layout, entry, targets, depth) = match into {
            Into::Sum => {
                let layout = &self.pipeline_layout;
                (&self.module, layout, "fs_cell", &blended[..], None)
            }
            Into::Lists(lists) => {
                let (module, layout) = (lists.fill(), lists.layout());
                (module, layout, "fs_fill", &untouched[..], None)
            }
            Into::Nearest(pass, data) => {
                constants = data.constants().to_vec();
                constants.extend(uploaded.look.extras);
                constants.push(sides::constant(gpu)?);
                let targets = &surface::TARGETS[..];
                let depth = Some(surface::hidden());
                (&pass.module, &pass.layout, "fs_surface", targets, depth)
            }
            Into::Faces(pass) => {
                constants.extend(pass.constants());
                let targets = &blended[..];
                (&pass.module, &pass.layout, "fs_face", targets, None)
            }
        };
        let program = CellProgram {
            module: module.clone(),
            layout: layout.clone(),
            vertices,
            fragments: entry,
            constants: [per_vertex, constants],
            targets: targets.to_vec(),
            depth,
            cull_mode,
        };
        Ok(CellData {
            pipeline: program.pipeline(gpu, false)?,
            program,
            ending: Arc::default(),
            volume_group: self.volume_group(gpu, uploaded, drawn)?,
            count: uploaded.look.culled.items,
            faces: match into {
                Into::Faces(pass) => Some(pass.group(gpu, uploaded.geometry, uploaded.field)?),
                _ => None,
            },
        })
    }

    /// What the pass reads, with the cells of `drawn`.
    pub(crate) fn volume_group(
        &self,
        gpu: &Gpu,
        uploaded: Uploaded,
        drawn: &wgpu::Buffer,
    ) -> Result<wgpu::BindGroup, Error> {
        let label = "projection::cell";
        let Uploaded {
            geometry,
            field,
            look,
        } = uploaded;
        let transformed = geometry.transformed.create_view(&Default::default());
        let intervals = look.intervals.create_view(&Default::default());
        let resources = [
            BindingResource::TextureView(&transformed),
            field.scalars.as_entire_binding(),
            geometry.cells.as_entire_binding(),
            drawn.as_entire_binding(),
            look.culled.pieces.as_entire_binding(),
            BindingResource::TextureView(&intervals),
            look.culled.ranges.as_entire_binding(),
            look.table.binding(),
        ];
        gpu.checked(label, 0, || {
            group(gpu, label, &self.volume_layout, &resources)
        })
    }

    /// Records one draw of all cells into `gathered`.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameData,
        data: &CellData,
        gathered: &wgpu::TextureView,
    ) -> Result<(), Error> {
        let clear = wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT);
        let mut pass = begin(encoder, "projection::cell", gathered, clear);
        self.draw(gpu, &mut pass, frame, data)
    }

    /// Draws all cells; what is in groups from 2 on is the caller's.
    pub(crate) fn draw(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass,
        frame: &FrameData,
        data: &CellData,
    ) -> Result<(), Error> {
        self.bind(gpu, pass, frame, data);
        pass.set_pipeline(data.pipeline(gpu, frame.ends.1)?);
        if let Some(faces) = &data.faces {
            pass.set_bind_group(2, faces, &[]);
            pass.draw(0..12 * data.count, 0..1);
            return Ok(());
        }
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        let mut first = 0;
        while first < data.count {
            let cells = (data.count - first).min(CELLS_PER_DRAW);
            pass.draw_indexed(0..6 * cells, (4 * first) as i32, 0..1);
            first += cells;
        }
        Ok(())
    }

    /// Sets groups 0 and 1.
    pub(crate) fn bind(
        &self,
        gpu: &Gpu,
        pass: &mut wgpu::RenderPass,
        frame: &FrameData,
        data: &CellData,
    ) {
        let label = "projection::cell";
        let resources = [
            frame.frame.as_entire_binding(),
            frame.look.as_entire_binding(),
            BindingResource::TextureView(&frame.ends.0),
        ];
        let frame = group(gpu, label, &self.frame_layout, &resources);
        pass.set_bind_group(0, &frame, &[]);
        pass.set_bind_group(1, &data.volume_group, &[]);
    }

    /// The layouts of groups 0 and 1.
    pub(crate) fn layouts(&self) -> [&wgpu::BindGroupLayout; 2] {
        [&self.frame_layout, &self.volume_layout]
    }
}

/// A pass into one texture.
pub(crate) fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    target: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> wgpu::RenderPass<'a> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load,
                store: wgpu::StoreOp::Store,
            },
        })],
        ..Default::default()
    })
}
