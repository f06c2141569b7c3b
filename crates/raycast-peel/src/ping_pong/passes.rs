//! The passes (the paper's section 4.2 and figure 7), one function for each phase.

use tetrascope_core::Error;
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE};
use tetrascope_gpu::pipelines::Constant;
use tetrascope_gpu::preintegration::TABLE;
use tetrascope_gpu::wgpu::{
    self, BindGroup, BindGroupLayout, BindingType, Color, CompareFunction, LoadOp, Operations,
    RenderPipeline, ShaderStages, StoreOp, TextureFormat, TextureView,
};
use tetrascope_gpu::{ComputeProgram, Gpu, RenderProgram};
use tetrascope_shaders::ping_pong::{ENTRY, ENTRY_SIDES, RETIRE, STEP, STEP_SIDES, TALLY};

use super::mesh::{Boundary, BoundaryCorner, BoundaryFace};
use super::tiles::Tile;
use crate::gpu_data::RECTANGLES;
use crate::integral::sides_constant;
use crate::options::{Crossings, RaycastOptions};

/// Format of traversal state, layers and the image.
pub(super) const TEXELS: TextureFormat = TextureFormat::Rgba32Float;
/// Format of both depth buffers.
pub(super) const DEPTHS: TextureFormat = TextureFormat::Depth32Float;

const TEXTURE: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// The parts that do not depend on appearance.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) frame_layout: BindGroupLayout,
    pub(super) mesh_layout: BindGroupLayout,
    pub(super) before_layout: BindGroupLayout,
    pub(super) traversal_layout: BindGroupLayout,
    pub(super) tally_layout: BindGroupLayout,
    pub(super) integration_layout: BindGroupLayout,
    crossings: Crossings,
    /// The constant of `sides.wgsl`, where that decides.
    sides: Option<Constant>,
    entry: RenderPipeline,
    /// Where rays cross by planes.
    inside: Option<RenderPipeline>,
    retire: RenderPipeline,
    query: RenderPipeline,
    tally: wgpu::ComputePipeline,
}

/// The parts that depend on it.
#[derive(Debug)]
pub(super) struct StyledPasses {
    step: RenderPipeline,
}

/// A depth test against `retired` or the nearest so far, and whether depths are written.
fn depth(compare: CompareFunction, write: bool) -> Option<wgpu::DepthStencilState> {
    Some(wgpu::DepthStencilState {
        format: DEPTHS,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: Default::default(),
        bias: Default::default(),
    })
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, options: &RaycastOptions) -> Result<Pipelines, Error> {
        let crossings = options.crossings;
        let sides = match crossings {
            Crossings::Planes => None,
            Crossings::Sides => Some(sides_constant(gpu, options)?),
        };
        let all = ShaderStages::VERTEX_FRAGMENT | ShaderStages::COMPUTE;
        let (fragment, compute) = (ShaderStages::FRAGMENT, ShaderStages::COMPUTE);
        let layout = |label, stages, types: &[BindingType]| gpu.layout(label, stages, types);
        let frame_layout = layout("ping-pong::frame", all, &[UNIFORM])?;
        let mesh_layout = layout("ping-pong::mesh", fragment, &[TEXTURE; 3])?;
        let before_layout = layout("ping-pong::before", fragment, &[TEXTURE])?;
        let traversal_layout = layout("ping-pong::traversal", fragment, &[TEXTURE; 2])?;
        let counted = [TEXTURE, TEXTURE, TEXTURE, WRITE];
        let tally_layout = layout("ping-pong::tally", compute, &counted)?;
        let integration_layout = layout("ping-pong::integration", fragment, &[READ, TABLE])?;
        let with = |last: &BindGroupLayout| {
            let groups = [&frame_layout, &mesh_layout, last];
            groups.map(Clone::clone).to_vec()
        };
        let (source, buffers, cull_mode) = match crossings {
            Crossings::Planes => (
                ENTRY,
                vec![Some(BoundaryCorner::LAYOUT)],
                Some(wgpu::Face::Back),
            ),
            Crossings::Sides => (
                ENTRY_SIDES,
                vec![Some(RECTANGLES), Some(BoundaryFace::LAYOUT)],
                None,
            ),
        };
        let entry = RenderProgram {
            label: "ping-pong::entry",
            source,
            vertex: "vs_entry",
            buffers,
            fragment: Some("fs_entry"),
            constants: sides.into_iter().collect(),
            targets: vec![Some(TEXELS.into())],
            groups: with(&before_layout),
            depth: depth(CompareFunction::Greater, true),
            cull_mode,
            ..Default::default()
        };
        let inside = RenderProgram {
            label: "ping-pong::inside",
            source: ENTRY,
            vertex: "vs_inside",
            fragment: Some("fs_inside"),
            targets: vec![Some(TEXELS.into())],
            groups: with(&before_layout),
            depth: depth(CompareFunction::Always, false),
            ..Default::default()
        };
        let inside = (crossings == Crossings::Planes).then_some(inside);
        let retire = RenderProgram {
            label: "ping-pong::retire",
            source: RETIRE,
            vertex: "vs_retire",
            fragment: Some("fs_retire"),
            groups: with(&traversal_layout),
            depth: depth(CompareFunction::Always, true),
            ..Default::default()
        };
        let query = RenderProgram {
            label: "ping-pong::query",
            vertex: "vs_query",
            fragment: None,
            depth: depth(CompareFunction::Less, false),
            ..retire.clone()
        };
        let tally = ComputeProgram {
            label: "ping-pong::tally",
            source: TALLY,
            groups: with(&tally_layout),
            ..Default::default()
        };
        Ok(Pipelines {
            entry: gpu.render_pipeline(&entry)?,
            inside: inside.map(|p| gpu.render_pipeline(&p)).transpose()?,
            crossings,
            sides,
            retire: gpu.render_pipeline(&retire)?,
            query: gpu.render_pipeline(&query)?,
            tally: gpu.compute_pipeline(&tally)?,
            frame_layout,
            mesh_layout,
            before_layout,
            traversal_layout,
            tally_layout,
            integration_layout,
        })
    }

    /// The constants of a step's program that no appearance changes.
    pub(super) fn constants(&self) -> Option<Constant> {
        self.sides
    }

    /// The passes that know the appearance, with the constants of their program.
    pub(super) fn styled(&self, gpu: &Gpu, step: &[Constant]) -> Result<StyledPasses, Error> {
        let groups = [
            &self.frame_layout,
            &self.mesh_layout,
            &self.traversal_layout,
            &self.integration_layout,
        ];
        let step_program = match self.crossings {
            Crossings::Planes => STEP,
            Crossings::Sides => STEP_SIDES,
        };
        let step = RenderProgram {
            label: "ping-pong::step",
            source: step_program,
            vertex: "vs_step",
            fragment: Some("fs_step"),
            constants: step.to_vec(),
            targets: vec![Some(TEXELS.into()); 2],
            groups: groups.map(Clone::clone).to_vec(),
            depth: depth(CompareFunction::Less, false),
            ..Default::default()
        };
        Ok(StyledPasses {
            step: gpu.render_pipeline(&step)?,
        })
    }

    /// Phases 1 and 2: one layer of boundary front faces, behind the layer in `before`.
    /// Where rays cross by sides, `rectangles` are the pixels of each face.
    pub(super) fn record_entry(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: [&BindGroup; 3],
        (boundary, rectangles): (&Boundary, Option<&wgpu::Buffer>),
        layer: &TextureView,
        depths: &TextureView,
    ) {
        let mut pass = begin(
            encoder,
            "ping-pong::entry",
            &[(layer, LoadOp::Clear(NOTHING))],
            Some(depth_attachment(depths, LoadOp::Clear(0.0))),
            None,
        );
        pass.set_pipeline(&self.entry);
        set(&mut pass, &groups);
        match (boundary, rectangles) {
            (Boundary::Corners(corners, count), _) => {
                pass.set_vertex_buffer(0, corners.slice(..));
                pass.draw(0..*count, 0..1);
            }
            (Boundary::Faces(faces, corners), Some(rectangles)) => {
                pass.set_vertex_buffer(0, rectangles.slice(..));
                pass.set_vertex_buffer(1, faces.slice(..));
                pass.draw(0..6, 0..corners.len() as u32);
            }
            (Boundary::Faces(..), None) => {}
        }
    }

    /// In place of phase 1 where the eye is in a cell.
    pub(super) fn record_inside(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: [&BindGroup; 3],
        layer: &TextureView,
        depths: &TextureView,
    ) {
        let mut pass = begin(
            encoder,
            "ping-pong::inside",
            &[(layer, LoadOp::Clear(NOTHING))],
            Some(depth_attachment(depths, LoadOp::Clear(0.0))),
            None,
        );
        let Some(inside) = &self.inside else {
            return;
        };
        pass.set_pipeline(inside);
        set(&mut pass, &groups);
        pass.draw(0..3, 0..1);
    }

    /// Phase 3b: retires the idle rays of `tiles` and asks for each whether rays are left.
    pub(super) fn record_retire(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: [&BindGroup; 3],
        tiles: &[Tile],
        retired: (&TextureView, LoadOp<f32>),
        queries: &wgpu::QuerySet,
    ) {
        let mut pass = begin(
            encoder,
            "ping-pong::retire",
            &[],
            Some(depth_attachment(retired.0, retired.1)),
            Some(queries),
        );
        set(&mut pass, &groups);
        for (pipeline, asks) in [(&self.retire, false), (&self.query, true)] {
            pass.set_pipeline(pipeline);
            for (index, tile) in (0..).zip(tiles) {
                pass.set_scissor_rect(tile.x, tile.y, tile.width, tile.height);
                if asks {
                    pass.begin_occlusion_query(index);
                }
                pass.draw(0..3, 0..1);
                if asks {
                    pass.end_occlusion_query();
                }
            }
        }
    }

    /// Counts the rays that a layer lost.
    pub(super) fn record_tally(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: [&BindGroup; 3],
        (width, height): (u32, u32),
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("ping-pong::tally"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.tally);
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    }
}

impl StyledPasses {
    /// Phase 3a: one step of the rays in `tiles`, into `state` and `color`.
    pub(super) fn record_step(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        groups: [&BindGroup; 4],
        tiles: &[Tile],
        [state, color]: [&TextureView; 2],
        retired: &TextureView,
    ) {
        let mut pass = begin(
            encoder,
            "ping-pong::step",
            &[(state, LoadOp::Load), (color, LoadOp::Load)],
            Some(wgpu::RenderPassDepthStencilAttachment {
                view: retired,
                depth_ops: None, // only read
                stencil_ops: None,
            }),
            None,
        );
        pass.set_pipeline(&self.step);
        set(&mut pass, &groups);
        for tile in tiles {
            pass.set_scissor_rect(tile.x, tile.y, tile.width, tile.height);
            pass.draw(0..3, 0..1);
        }
    }
}

/// A layer where nothing comes in: no cell, and behind everything, so that no later
/// layer is behind it.
const NOTHING: Color = Color {
    r: -1.0,
    g: -1.0,
    b: 1e30,
    a: 0.0,
};

/// The layer before the first: no cell, and before everything.
pub(super) const BEFORE: Color = Color {
    b: -1e30,
    ..NOTHING
};

/// Sets every texel.
pub(super) fn record_clear(encoder: &mut wgpu::CommandEncoder, view: &TextureView, color: Color) {
    let clear = LoadOp::Clear(color);
    drop(begin(
        encoder,
        "ping-pong::clear",
        &[(view, clear)],
        None,
        None,
    ));
}

fn set(pass: &mut wgpu::RenderPass, groups: &[&BindGroup]) {
    for (index, group) in (0..).zip(groups) {
        pass.set_bind_group(index, *group, &[]);
    }
}

fn depth_attachment(
    view: &TextureView,
    load: LoadOp<f32>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(Operations {
            load,
            store: StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    label: &str,
    targets: &[(&TextureView, LoadOp<Color>)],
    depths: Option<wgpu::RenderPassDepthStencilAttachment>,
    queries: Option<&wgpu::QuerySet>,
) -> wgpu::RenderPass<'a> {
    let attachments: Vec<_> = targets
        .iter()
        .map(|&(view, load)| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load,
                    store: StoreOp::Store,
                },
            })
        })
        .collect();
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &attachments,
        depth_stencil_attachment: depths,
        occlusion_query_set: queries,
        ..Default::default()
    })
}
