//! How a volume's parts add up: the format of the texture that they are blended into, and how.

use tetrascope_core::OpticalModel;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, Features, TextureFormat};

use crate::Gpu;

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
