//! Pass 3: put what the cells added up to over the background (`resolve.wgsl`).

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, ShaderStages, TextureFormat};
use tetrascope_shaders::projection::RESOLVE;

use super::{UNIFORM, group, layout, model_constant, module, pipeline_layout};

const TEXTURE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// The pipeline for one optical model and target format.
#[derive(Clone, Debug)]
pub(crate) struct ResolvePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl ResolvePass {
    pub(crate) fn new(
        gpu: &Gpu,
        model: OpticalModel,
        target: TextureFormat,
    ) -> Result<ResolvePass, Error> {
        let label = "projection::resolve";
        let constants = [model_constant(model)];
        gpu.checked(label, 0, || {
            let layout = layout(gpu, label, ShaderStages::FRAGMENT, &[UNIFORM, TEXTURE]);
            let module = module(gpu, label, RESOLVE);
            let pipeline = gpu
                .device()
                .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                    label: Some(label),
                    layout: Some(&pipeline_layout(gpu, label, &[&layout])),
                    vertex: wgpu::VertexState {
                        module: &module,
                        entry_point: Some("vs_resolve"),
                        compilation_options: Default::default(),
                        buffers: &[],
                    },
                    primitive: Default::default(),
                    depth_stencil: None,
                    multisample: Default::default(),
                    fragment: Some(wgpu::FragmentState {
                        module: &module,
                        entry_point: Some("fs_resolve"),
                        compilation_options: wgpu::PipelineCompilationOptions {
                            constants: &constants,
                            ..Default::default()
                        },
                        targets: &[Some(target.into())],
                    }),
                    multiview_mask: None,
                    cache: None,
                });
            ResolvePass { layout, pipeline }
        })
    }

    /// Records the pass; every texel of `target` is written.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        background: &wgpu::Buffer,
        gathered: &wgpu::TextureView,
        target: &wgpu::TextureView,
        timestamps: Option<wgpu::RenderPassTimestampWrites>,
    ) {
        let label = "projection::resolve";
        let resources = [
            background.as_entire_binding(),
            wgpu::BindingResource::TextureView(gathered),
        ];
        let group = group(gpu, label, &self.layout, &resources);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
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
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
