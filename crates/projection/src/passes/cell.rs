//! Pass 2: draw the cells (`cell.wgsl`).

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{
    READ, UNIFORM, group, layout, model_constant, module, pipeline_layout,
};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_shaders::projection::CELL;

use crate::volume::{Field, Geometry, Look};

/// Cells that one draw call covers: its 16-bit indices number four vertices of each.
const CELLS_PER_DRAW: u32 = (1 << 16) / 4;

/// The faces of a positively oriented cell, counterclockwise from outside.
const FACES: [u16; 12] = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1];

/// What does not depend on the optical model.
#[derive(Clone, Debug)]
pub(crate) struct CellPass {
    module: wgpu::ShaderModule,
    frame_layout: wgpu::BindGroupLayout,
    volume_layout: wgpu::BindGroupLayout,
    pipeline_layout: wgpu::PipelineLayout,
    indices: wgpu::Buffer,
}

/// The pass for one volume and appearance.
#[derive(Clone, Debug)]
pub(crate) struct CellData {
    pipeline: wgpu::RenderPipeline,
    volume_group: wgpu::BindGroup,
    count: u32,
}

impl CellPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<CellPass, Error> {
        let label = "projection::cell";
        let indices: Vec<u16> = (0..CELLS_PER_DRAW)
            .flat_map(|cell| FACES.map(|corner| 4 * cell as u16 + corner))
            .collect();
        let indices = gpu.upload("projection::cell indices", &indices, BufferUsages::INDEX)?;
        gpu.checked(label, 0, || {
            let stages = ShaderStages::VERTEX_FRAGMENT;
            let frame_layout = layout(gpu, label, stages, &[UNIFORM]);
            let volume_layout = layout(gpu, label, stages, &[READ; 5]);
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
        geometry: &Geometry,
        field: &Field,
        look: &Look,
        drawn: &wgpu::Buffer,
        model: OpticalModel,
    ) -> Result<CellData, Error> {
        let label = "projection::cell";
        let (positions, cells) = (&geometry.positions, &geometry.cells);
        let buffers = [positions, &field.scalars, cells, drawn, &look.intervals];
        let buffers = buffers.map(|b| b.as_entire_binding());
        gpu.checked(label, 0, || CellData {
            pipeline: self.pipeline(gpu, model, look.deepest),
            volume_group: group(gpu, label, &self.volume_layout, &buffers),
            count: look.drawn_count,
        })
    }

    fn pipeline(&self, gpu: &Gpu, model: OpticalModel, deepest: f32) -> wgpu::RenderPipeline {
        let constants = [model_constant(model), ("DEEPEST", f64::from(deepest))];
        let options = wgpu::PipelineCompilationOptions {
            constants: &constants,
            ..Default::default()
        };
        gpu.device()
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("projection::cell"),
                layout: Some(&self.pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some("vs_cell"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState {
                    front_face: wgpu::FrontFace::Ccw,
                    cull_mode: Some(wgpu::Face::Front),
                    ..Default::default()
                },
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.module,
                    entry_point: Some("fs_cell"),
                    compilation_options: options,
                    targets: &[Some(wgpu::ColorTargetState {
                        format: gathered_format(gpu, model),
                        blend: Some(blend(model)),
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    /// Records one draw of all cells into `gathered`.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &wgpu::Buffer,
        data: &CellData,
        gathered: &wgpu::TextureView,
        timestamps: Option<wgpu::RenderPassTimestampWrites>,
    ) {
        let label = "projection::cell";
        let frame = group(gpu, label, &self.frame_layout, &[frame.as_entire_binding()]);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: gathered,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            timestamp_writes: timestamps,
            ..Default::default()
        });
        pass.set_pipeline(&data.pipeline);
        pass.set_bind_group(0, &frame, &[]);
        pass.set_bind_group(1, &data.volume_group, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        let mut first = 0;
        while first < data.count {
            let cells = (data.count - first).min(CELLS_PER_DRAW);
            pass.draw_indexed(0..12 * cells, (4 * first) as i32, 0..1);
            first += cells;
        }
    }
}
