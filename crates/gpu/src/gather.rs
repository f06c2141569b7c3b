//! Where a volume's parts add up, and how the sum gets over the background.
//!
//! A renderer blends what each cell, slab or segment adds into a texture of
//! [`gathered_format`] with [`blend`]; [`ResolvePass`] (`resolve.wgsl`) then puts it
//! over the background.

use tetrascope_core::{Error, OpticalModel, View};
use tetrascope_shaders::gather::RESOLVE;
use wgpu::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, Features, ShaderStages, TextureFormat,
};

use crate::Gpu;
use crate::passes::{TEXELS, UNIFORM, group, layout, model_constant, module, pipeline_layout};

/// The mirror of `Resolve` in `resolve.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Resolve {
    /// Linear RGBA, premultiplied.
    pub background: [f32; 4],
}

impl Resolve {
    /// The uniform for `view`.
    pub fn of(view: &View) -> Resolve {
        Resolve {
            background: view.premultiplied_background().map(|c| c as f32),
        }
    }
}

/// The format of the texture in which parts add up: f32 where the device blends it.
pub fn gathered_format(gpu: &Gpu, model: OpticalModel) -> TextureFormat {
    let single = gpu.features().contains(Features::FLOAT32_BLENDABLE);
    match (model, single) {
        (OpticalModel::Absorption, true) => TextureFormat::R32Float,
        (OpticalModel::Absorption, false) => TextureFormat::R16Float,
        (_, true) => TextureFormat::Rgba32Float,
        (_, false) => TextureFormat::Rgba16Float,
    }
}

/// How a part is blended over those behind it, drawn before.
pub fn blend(model: OpticalModel) -> BlendState {
    let component = |dst_factor, operation| BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor,
        operation,
    };
    let component = match model {
        // Back to front, premultiplied.
        OpticalModel::EmissionAbsorption => {
            component(BlendFactor::OneMinusSrcAlpha, BlendOperation::Add)
        }
        OpticalModel::MaximumIntensity => component(BlendFactor::One, BlendOperation::Max),
        _ => component(BlendFactor::One, BlendOperation::Add),
    };
    BlendState {
        color: component,
        alpha: component,
    }
}

/// The pipeline for one optical model and target format.
#[derive(Clone, Debug)]
pub struct ResolvePass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
}

impl ResolvePass {
    /// Compiles the pass for targets of format `target`.
    pub fn new(
        gpu: &Gpu,
        model: OpticalModel,
        target: TextureFormat,
    ) -> Result<ResolvePass, Error> {
        let label = "gpu::resolve";
        let constants = [model_constant(model)];
        gpu.checked(label, 0, || {
            let layout = layout(gpu, label, ShaderStages::FRAGMENT, &[UNIFORM, TEXELS]);
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
    pub fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        background: &wgpu::Buffer,
        gathered: &wgpu::TextureView,
        target: &wgpu::TextureView,
        timestamps: Option<wgpu::RenderPassTimestampWrites>,
    ) {
        let label = "gpu::resolve";
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

#[cfg(test)]
mod tests {
    use tetrascope_shaders::assert_layout;

    use super::*;

    #[test]
    fn resolve_has_the_layout_of_its_twin() {
        assert_layout!(RESOLVE, Resolve { background });
    }
}
