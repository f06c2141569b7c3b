//! Passes 3 and 4 where each pixel sorts: list fragments (`fill.wgsl`), then add them
//! up (`composite.wgsl`), tile by tile.

use std::sync::{Mutex, PoisonError};

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::passes::{
    UNIFORM, WRITE, group, layout, model_constant, module, pipeline_layout,
};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages, TextureFormat};
use tetrascope_shaders::projection::{COMPOSITE, FILL};

use super::cell::{CellData, CellPass, FrameData, begin};
use crate::gpu_data;
use crate::tiles::Tile;

/// What the lists add up to; nothing is blended, so every device draws into f32.
pub(crate) const FORMAT: TextureFormat = TextureFormat::Rgba32Float;

/// A pass must have a target; this one stays as it is.
pub(crate) const UNTOUCHED: wgpu::ColorTargetState = wgpu::ColorTargetState {
    format: FORMAT,
    blend: None,
    write_mask: wgpu::ColorWrites::empty(),
};

/// Bytes of a `Fragment` in `fragments.wgsl`.
pub(crate) const FRAGMENT_BYTES: u64 = 24;

/// The pipelines of the passes and the buffers of the last frame.
#[derive(Debug)]
pub(crate) struct ListPass {
    fill: wgpu::ShaderModule,
    tile_layout: wgpu::BindGroupLayout,
    layout: wgpu::PipelineLayout,
    composite: wgpu::RenderPipeline,
    kept: Mutex<Option<Lists>>,
}

/// Room for the fragments of one tile.
#[derive(Clone, Debug)]
struct Lists {
    heads: wgpu::Buffer,
    fragments: wgpu::Buffer,
}

impl ListPass {
    pub(crate) fn new(gpu: &Gpu, cells: &CellPass) -> Result<ListPass, Error> {
        let label = "projection::lists";
        let constants = [model_constant(OpticalModel::EmissionAbsorption)];
        gpu.checked(label, 0, || {
            let tile_layout = layout(gpu, label, ShaderStages::FRAGMENT, &[UNIFORM, WRITE, WRITE]);
            let [frame, volume] = cells.layouts();
            let layout = pipeline_layout(gpu, label, &[frame, volume, &tile_layout]);
            let module_of = |source| module(gpu, label, source);
            let composite = module_of(COMPOSITE);
            let composite = gpu
                .device()
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some("projection::composite"),
                    layout: Some(&layout),
                    vertex: wgpu::VertexState {
                        module: &composite,
                        entry_point: Some("vs_composite"),
                        compilation_options: Default::default(),
                        buffers: &[],
                    },
                    primitive: Default::default(),
                    depth_stencil: None,
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &composite,
                        entry_point: Some("fs_composite"),
                        compilation_options: wgpu::PipelineCompilationOptions {
                            constants: &constants,
                            ..Default::default()
                        },
                        targets: &[Some(FORMAT.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                });
            ListPass {
                fill: module_of(FILL),
                tile_layout,
                layout,
                composite,
                kept: Mutex::new(None),
            }
        })
    }

    /// The module with `fs_fill`.
    pub(crate) fn fill(&self) -> &wgpu::ShaderModule {
        &self.fill
    }

    /// The layout of its pipelines.
    pub(crate) fn layout(&self) -> &wgpu::PipelineLayout {
        &self.layout
    }

    /// How many fragments a tile may have, in `bytes` and on this device.
    pub(crate) fn capacity(gpu: &Gpu, bytes: u64) -> u64 {
        let limits = gpu.limits();
        let most = limits
            .max_buffer_size
            .min(limits.max_storage_buffer_binding_size);
        (bytes.min(most) / FRAGMENT_BYTES).min(u64::from(u32::MAX) - 1)
    }

    /// Records both passes for each tile into `gathered`. Returns the buffer that gets
    /// the number of fragments of each tile, u32.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameData,
        (cells, data): (&CellPass, &CellData),
        tiles: &[Tile],
        gathered: &wgpu::TextureView,
    ) -> Result<wgpu::Buffer, Error> {
        let lists = self.lists(gpu, tiles)?;
        let usage = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let counts = gpu.buffer("projection::counts", 4 * tiles.len() as u64, usage)?;
        for (tile, place) in tiles.iter().zip(0_u64..) {
            let uniform = gpu_data::Tile {
                origin: tile.origin,
                width: tile.size[0],
                capacity: (lists.fragments.size() / FRAGMENT_BYTES) as u32,
            };
            let uniform = gpu.upload("projection::tile", &[uniform], BufferUsages::UNIFORM)?;
            let label = "projection::lists";
            gpu.checked(label, 0, || {
                let buffers = [&uniform, &lists.heads, &lists.fragments];
                let buffers = buffers.map(|b| b.as_entire_binding());
                let group = group(gpu, label, &self.tile_layout, &buffers);
                let ([x, y], [width, height]) = (tile.origin, tile.size);
                encoder.clear_buffer(&lists.heads, 0, None);
                {
                    let load = wgpu::LoadOp::Load;
                    let mut pass = begin(encoder, "projection::fill", gathered, load);
                    pass.set_bind_group(2, &group, &[]);
                    pass.set_scissor_rect(x, y, width, height);
                    cells.draw(gpu, &mut pass, frame, data);
                }
                {
                    let load = wgpu::LoadOp::Load;
                    let mut pass = begin(encoder, "projection::composite", gathered, load);
                    cells.bind(gpu, &mut pass, frame, data);
                    pass.set_pipeline(&self.composite);
                    pass.set_bind_group(2, &group, &[]);
                    pass.set_scissor_rect(x, y, width, height);
                    pass.draw(0..3, 0..1);
                }
                encoder.copy_buffer_to_buffer(&lists.heads, 0, &counts, 4 * place, 4);
            })?;
        }
        Ok(counts)
    }

    /// Buffers that suffice for each of `tiles`, kept for the next frame.
    fn lists(&self, gpu: &Gpu, tiles: &[Tile]) -> Result<Lists, Error> {
        let most = |measure: fn(&Tile) -> u64| tiles.iter().map(measure).max().unwrap_or(0);
        let pixels = most(|t| u64::from(t.size[0]) * u64::from(t.size[1]));
        let heads = 4 * (1 + pixels);
        let fragments = FRAGMENT_BYTES * most(|t| t.most).max(1);
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let fits = |l: &&Lists| l.heads.size() >= heads && l.fragments.size() >= fragments;
        if let Some(lists) = kept.as_ref().filter(fits) {
            return Ok(lists.clone());
        }
        // What is kept goes first: two may not fit.
        *kept = None;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let lists = Lists {
            heads: gpu.buffer("projection::heads", heads, usage)?,
            fragments: gpu.buffer("projection::fragments", fragments, BufferUsages::STORAGE)?,
        };
        *kept = Some(lists.clone());
        Ok(lists)
    }
}
