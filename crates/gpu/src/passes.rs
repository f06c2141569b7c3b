//! Short forms of what every pass declares. Inside of [`Gpu::checked`], as wgpu may refuse.

use tetrascope_core::{Appearance, OpticalModel};
use wgpu::{BindingType, BufferBindingType, ShaderStages};

use crate::Gpu;

/// The number of `model` in `optics_model.wgsl`.
pub fn model_constant(model: OpticalModel) -> (&'static str, f64) {
    let index = OpticalModel::ALL.iter().position(|m| *m == model);
    ("MODEL", index.expect("ALL has every model") as f64)
}

/// The pipeline constants that compile only what `appearance` has.
pub fn look_constants(appearance: &Appearance) -> [(&'static str, f64); 2] {
    let cued =
        appearance.depth_cue.is_some() && appearance.optical_model != OpticalModel::Absorption;
    let has = |yes: bool| f64::from(u8::from(yes));
    [
        ("CLIPPED", has(!appearance.clip_planes.is_empty())),
        ("CUED", has(cued)),
    ]
}

/// A bind group's layout: one buffer, or other resource, for each of `types`.
pub fn layout(
    gpu: &Gpu,
    label: &str,
    visibility: ShaderStages,
    types: &[BindingType],
) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility,
            ty: *ty,
            count: None,
        })
        .collect();
    gpu.device()
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(label),
            entries: &entries,
        })
}

/// A bind group of whole buffers.
pub fn group(
    gpu: &Gpu,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry {
            binding,
            resource: resource.clone(),
        })
        .collect();
    gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout,
        entries: &entries,
    })
}

/// A pipeline's layout with these groups.
pub fn pipeline_layout(
    gpu: &Gpu,
    label: &str,
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(|g| Some(*g)).collect();
    gpu.device()
        .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &groups,
            immediate_size: 0,
        })
}

/// A compiled program.
pub fn module(gpu: &Gpu, label: &str, source: &str) -> wgpu::ShaderModule {
    gpu.device()
        .create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        })
}

/// A compute pipeline of a program's entry point, or of its only one, with its constants set.
/// Without `groups`, for what the program declares.
pub fn compute_pipeline(
    gpu: &Gpu,
    label: &str,
    module: &wgpu::ShaderModule,
    entry_point: Option<&str>,
    constants: &[(&str, f64)],
    groups: &[&wgpu::BindGroupLayout],
) -> wgpu::ComputePipeline {
    let layout = (!groups.is_empty()).then(|| pipeline_layout(gpu, label, groups));
    gpu.device()
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: layout.as_ref(),
            module,
            entry_point,
            compilation_options: wgpu::PipelineCompilationOptions {
                constants,
                ..Default::default()
            },
            cache: None,
        })
}

const fn buffer(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer {
        ty,
        has_dynamic_offset: false,
        min_binding_size: None,
    }
}

/// A storage buffer that shaders read.
pub const READ: BindingType = buffer(BufferBindingType::Storage { read_only: true });
/// A storage buffer that shaders write.
pub const WRITE: BindingType = buffer(BufferBindingType::Storage { read_only: false });
/// A uniform buffer.
pub const UNIFORM: BindingType = buffer(BufferBindingType::Uniform);
/// A texture that shaders read texel by texel.
pub const TEXELS: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// A texture of `format` that shaders write texel by texel.
pub const fn write_texels(format: wgpu::TextureFormat) -> BindingType {
    BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: wgpu::TextureViewDimension::D2,
    }
}
