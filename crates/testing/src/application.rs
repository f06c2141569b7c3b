//! An application's color and depth textures, with a picture in them.

use tetrascope_core::Error;
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::passes::{TEXELS, group};
use tetrascope_gpu::{Gpu, Over, RenderProgram, SceneDepth, Target, wgpu};
use wgpu::{LoadOp, Operations, ShaderStages, StoreOp, Texture, TextureFormat, TextureUsages};

/// The picture of an application, before a volume is drawn into it.
#[derive(Debug)]
pub struct Application {
    /// Rgba32Float, if the device blends that, else Rgba16Float.
    pub color: Texture,
    /// Depths, in the format that was asked for.
    pub depth: Texture,
}

const DRAW: &str = "
@group(0) @binding(0) var colors: texture_2d<f32>;
@group(0) @binding(1) var depths: texture_2d<f32>;

@vertex
fn vs(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

struct Fragment {
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs(@builtin(position) position: vec4f) -> Fragment {
    let at = vec2i(position.xy);
    return Fragment(textureLoad(colors, at, 0), textureLoad(depths, at, 0).x);
}
";

impl Application {
    /// Draws `pixels` and `depths`, row-major.
    pub fn draw(
        gpu: &Gpu,
        size: (u32, u32),
        pixels: &[[f32; 4]],
        depths: &[f32],
        depth_format: TextureFormat,
    ) -> Result<Application, Error> {
        let given = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let colors = gpu.texture("colors", size, TextureFormat::Rgba32Float, given)?;
        gpu.write_texture(&colors, pixels)?;
        let values = gpu.texture("depths", size, TextureFormat::R32Float, given)?;
        gpu.write_texture(&values, depths)?;
        let format = match gpu.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
            true => TextureFormat::Rgba32Float,
            false => TextureFormat::Rgba16Float,
        };
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let application = Application {
            color: gpu.texture("color", size, format, drawn | TextureUsages::COPY_SRC)?,
            depth: gpu.texture(
                "depth",
                size,
                depth_format,
                drawn | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            )?,
        };
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        gpu.checked("an application", 0, || {
            application.record(gpu, &mut encoder, [&colors, &values])
        })??;
        gpu.finish(encoder)?;
        Ok(application)
    }

    fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        given: [&Texture; 2],
    ) -> Result<(), Error> {
        let label = "an application";
        let layout = gpu.layout(label, ShaderStages::FRAGMENT, &[TEXELS; 2])?;
        let has_stencil = self.depth.format().has_stencil_aspect();
        let pipeline = gpu.render_pipeline(&RenderProgram {
            label,
            source: DRAW,
            vertex: "vs",
            fragment: Some("fs"),
            targets: vec![Some(self.color.format().into())],
            groups: vec![layout.clone()],
            depth: Some(wgpu::DepthStencilState {
                format: self.depth.format(),
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Always),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            ..Default::default()
        })?;
        let views = [given[0], given[1], &self.color, &self.depth]
            .map(|texture| texture.create_view(&Default::default()));
        let resources = [0, 1].map(|i| wgpu::BindingResource::TextureView(&views[i]));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some(label),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &views[2],
                depth_slice: None,
                resolve_target: None,
                ops: Operations {
                    load: LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &views[3],
                depth_ops: Some(Operations {
                    load: LoadOp::Clear(0.0),
                    store: StoreOp::Store,
                }),
                stencil_ops: has_stencil.then_some(Operations {
                    load: LoadOp::Clear(0),
                    store: StoreOp::Store,
                }),
            }),
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group(gpu, label, &layout, &resources), &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }

    /// A volume drawn over what is there and among it; `color` is a view of the application's.
    pub fn target<'a>(
        &'a self,
        color: &'a wgpu::TextureView,
        clip_from_world: tetrascope_core::glam::DMat4,
    ) -> Target<'a> {
        Target {
            color,
            format: self.color.format(),
            over: Over::WhatIsThere,
            depth: Some(SceneDepth {
                texture: &self.depth,
                clip_from_world,
            }),
        }
    }

    /// The colors and, of Depth32Float, the depths, once all that was submitted is done.
    ///
    /// # Panics
    /// If the device does not blend f32.
    pub fn read(&self, gpu: &Gpu) -> Result<(Vec<[f32; 4]>, Vec<f32>), Error> {
        assert_eq!(self.color.format(), TextureFormat::Rgba32Float);
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let colors = read_back(gpu, &mut encoder, Source::Texture(&self.color))?;
        let depths = match self.depth.format() {
            TextureFormat::Depth32Float => {
                Some(read_back(gpu, &mut encoder, Source::Texture(&self.depth))?)
            }
            _ => None,
        };
        gpu.finish(encoder)?;
        let depths = depths.map(|copy| copy.read()).transpose()?;
        Ok((colors.read()?, depths.unwrap_or_default()))
    }
}
