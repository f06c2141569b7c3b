//! Pass 3: draw the cells (`cell.wgsl`).

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::gather::{blend, gathered_format};
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, deep, group, model_constant};
use tetrascope_gpu::preintegration::TABLE;
use tetrascope_gpu::wgpu::{self, BindingResource, BufferUsages, ShaderStages};
use tetrascope_gpu::{Gpu, RenderProgram, sides};
use tetrascope_shaders::projection::CELL;

use crate::classified::Classified;
use crate::gpu_data;
use crate::mesh::{Field, Geometry};

/// Cells that one draw call covers: its 16-bit indices number four corners of each.
const CELLS_PER_DRAW: u32 = (1 << 16) / 4;

/// Two triangles around the corners of a cell's footprint.
const FOOTPRINT: [u16; 6] = [0, 1, 2, 0, 2, 3];

/// The parts of the pass that do not depend on the optical model.
#[derive(Clone, Debug)]
pub(crate) struct CellPass {
    frame_layout: wgpu::BindGroupLayout,
    volume_layout: wgpu::BindGroupLayout,
    indices: wgpu::Buffer,
}

/// The data on the device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uploaded<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) field: &'a Field,
    pub(crate) classified: &'a Classified,
}

/// The uniforms of a frame; new ones each time, as frames may be recorded before others
/// are submitted.
#[derive(Clone, Debug)]
pub(crate) struct FrameData {
    pub(crate) values: gpu_data::CameraUniform,
    pub(crate) frame: wgpu::Buffer,
    pub(crate) look: wgpu::Buffer,
    /// Where rays end, and whether they do.
    pub(crate) ends: (wgpu::TextureView, bool),
    /// Surfaces and lights, as `surfaces.wgsl` wants them.
    pub(crate) items: Vec<[f32; 4]>,
}

/// The pass for one volume and appearance.
#[derive(Clone, Debug)]
pub(crate) struct CellData {
    program: RenderProgram,
    pipeline: wgpu::RenderPipeline,
    pub(crate) volume_group: wgpu::BindGroup,
    pub(crate) count: u32,
    /// Group 2, where faces are drawn in place of footprints.
    faces: Option<wgpu::BindGroup>,
}

impl CellData {
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

impl CellPass {
    pub(crate) fn new(gpu: &Gpu) -> Result<CellPass, Error> {
        let label = "projection::cell";
        let indices: Vec<u16> = (0..CELLS_PER_DRAW)
            .flat_map(|cell| FOOTPRINT.map(|corner| 4 * cell as u16 + corner))
            .collect();
        let indices = gpu.upload("projection::cell indices", &indices, BufferUsages::INDEX)?;
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let types = [TEXELS, READ, READ, READ, READ, TEXELS, READ, TABLE];
        Ok(CellPass {
            frame_layout: gpu.layout(label, stages, &[UNIFORM, UNIFORM, TEXELS])?,
            volume_layout: gpu.layout(label, stages, &types)?,
            indices,
        })
    }

    /// The program that integrates in cells and blends what it finds; passes that make something
    /// else of a cell start from it.
    pub(crate) fn program(
        &self,
        gpu: &Gpu,
        uploaded: Uploaded,
        model: OpticalModel,
    ) -> Result<RenderProgram, Error> {
        let classified = uploaded.classified;
        let mut program = self.integral(gpu, uploaded, model);
        program.constants.extend(classified.extras);
        let in_parts = ("PARTS", classified.culled.in_parts.into());
        program.constants.extend([in_parts, sides::constant(gpu)?]);
        Ok(program)
    }

    /// The same without what fragments of a footprint ask for.
    pub(crate) fn integral(
        &self,
        gpu: &Gpu,
        uploaded: Uploaded,
        model: OpticalModel,
    ) -> RenderProgram {
        let classified = uploaded.classified;
        let range = uploaded.field.range;
        let in_pieces = ("PIECES", classified.culled.in_pieces.into());
        let mut program = RenderProgram {
            label: "projection::cell",
            source: CELL,
            vertex: "vs_cell",
            vertex_constants: vec![
                ("SCALARS_PER_CELL", uploaded.field.per_cell.into()),
                in_pieces,
            ],
            fragment: Some("fs_cell"),
            constants: vec![model_constant(model), in_pieces],
            targets: vec![Some(wgpu::ColorTargetState {
                format: gathered_format(gpu, model),
                blend: Some(blend(model)),
                write_mask: wgpu::ColorWrites::ALL,
            })],
            groups: self.layouts().map(Clone::clone).to_vec(),
            ..Default::default()
        };
        program.constants.push(deep(classified.deepest));
        program.constants.extend(classified.table.constants(range));
        program
    }

    /// The data that `program` draws, in the order of the cell indices in `drawn`; where it is of faces,
    /// with their group.
    pub(crate) fn data(
        &self,
        gpu: &Gpu,
        uploaded: Uploaded,
        drawn: &wgpu::Buffer,
        (program, faces): (RenderProgram, Option<wgpu::BindGroup>),
    ) -> Result<CellData, Error> {
        Ok(CellData {
            pipeline: gpu.render_pipeline(&program)?,
            program,
            volume_group: self.volume_group(gpu, uploaded, drawn)?,
            count: uploaded.classified.culled.items,
            faces,
        })
    }

    /// The data that the pass reads, with the cells of `drawn`.
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
            classified,
        } = uploaded;
        let transformed = geometry.transformed.create_view(&Default::default());
        let intervals = classified.intervals.create_view(&Default::default());
        let resources = [
            BindingResource::TextureView(&transformed),
            field.scalars.as_entire_binding(),
            geometry.cells.as_entire_binding(),
            drawn.as_entire_binding(),
            classified.culled.pieces.as_entire_binding(),
            BindingResource::TextureView(&intervals),
            classified.culled.ranges.as_entire_binding(),
            classified.table.binding(),
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
        pass.set_pipeline(&data.pipeline(gpu, frame.ends.1)?);
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
