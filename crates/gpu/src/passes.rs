//! Short forms of what every pass declares. Inside of [`Gpu::checked`], as wgpu may refuse.

use tetrascope_core::{Appearance, OpticalModel};
use wgpu::{BindingType, BufferBindingType};

use crate::Gpu;
use crate::pipelines::Constant;

/// The number of `model` in `optics_model.wgsl`.
pub fn model_constant(model: OpticalModel) -> Constant {
    let index = OpticalModel::ALL.iter().position(|m| *m == model);
    ("MODEL", index.expect("ALL has every model") as f64)
}

/// The pipeline constants that compile only what `appearance` has.
pub fn look_constants(appearance: &Appearance) -> [Constant; 2] {
    let cued =
        appearance.depth_cue.is_some() && appearance.optical_model != OpticalModel::Absorption;
    let has = |yes: bool| f64::from(u8::from(yes));
    [
        ("CLIPPED", has(!appearance.clip_planes.is_empty())),
        ("CUED", has(cued)),
    ]
}

/// The pipeline constant of `optics.wgsl`: whether a segment's optical depth, at most `deepest`,
/// may exceed 1.
pub fn deep(deepest: f32) -> Constant {
    ("DEEP", f64::from(u8::from(deepest > 1.0)))
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
