//! Pass 3 where isosurfaces are drawn (`surface.wgsl`), and how they get among the
//! application's own geometry (`among.wgsl`).

use tetrascope_core::glam::DMat4;
use tetrascope_core::{Appearance, Error};
use tetrascope_f32::ScalarMap;
use tetrascope_f32::look::surfaces;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::passes::{READ, TEXELS, UNIFORM, group, layout, module, pipeline_layout};
use tetrascope_gpu::wgpu::{
    self, BindingResource, BufferUsages, ShaderStages, TextureFormat, TextureUsages,
};
use tetrascope_shaders::projection::{AMONG, SURFACE};

use super::cell::{CellData, CellPass, FrameData};
use crate::gpu_data;
use crate::options::{DepthFormat, SurfaceSearch};

/// Linear RGB, opaque.
pub(crate) const COLOR: TextureFormat = TextureFormat::Rgba32Float;
/// Depth along the axis.
const ALONG: TextureFormat = TextureFormat::R32Float;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The depth along the axis where no surface is met: before any that is drawn.
pub(crate) const NO_SURFACE: f32 = -1e30;

/// What the pass draws into.
pub(crate) const TARGETS: [Option<wgpu::ColorTargetState>; 2] = [target(COLOR), target(ALONG)];

const fn target(format: TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState {
        format,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    })
}

/// The nearest fragment is kept.
pub(crate) fn hidden() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Less),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// What does not depend on the appearance.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePass {
    pub(crate) module: wgpu::ShaderModule,
    pub(crate) layout: wgpu::PipelineLayout,
    look_layout: wgpu::BindGroupLayout,
    among: Option<Among>,
}

/// How isosurfaces get among geometry that is there already.
#[derive(Clone, Debug)]
struct Among {
    frame_layout: wgpu::BindGroupLayout,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    has_stencil: bool,
}

/// How surfaces are found in cells, for one appearance.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceData {
    table: wgpu::TextureView,
    side: u32,
    range: (f32, f32),
}

/// What a frame is drawn into, kept for the next.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceTextures {
    pub(crate) color: wgpu::Texture,
    pub(crate) along: wgpu::Texture,
    depth: wgpu::Texture,
}

/// A texture of numbers of surfaces.
const NUMBERS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

impl SurfacePass {
    pub(crate) fn new(
        gpu: &Gpu,
        cells: &CellPass,
        target: TextureFormat,
        depth: Option<DepthFormat>,
    ) -> Result<SurfacePass, Error> {
        let label = "projection::surface";
        gpu.checked(label, 0, || {
            let types = [READ, NUMBERS];
            let look_layout = layout(gpu, label, ShaderStages::FRAGMENT, &types);
            let [frame, volume] = cells.layouts();
            SurfacePass {
                module: module(gpu, label, SURFACE),
                layout: pipeline_layout(gpu, label, &[frame, volume, &look_layout]),
                look_layout,
                among: depth.map(|depth| Among::new(gpu, target, depth)),
            }
        })
    }

    /// Records one draw of all cells into `textures`.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (frame, look): (&FrameData, &wgpu::BindGroup),
        (cells, data): (&CellPass, &CellData),
        textures: &SurfaceTextures,
    ) {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let color = view(&textures.color);
        let along = view(&textures.along);
        let depth = view(&textures.depth);
        let nowhere = wgpu::Color {
            r: f64::from(NO_SURFACE),
            ..wgpu::Color::TRANSPARENT
        };
        let attachment = |view, clear| {
            Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(clear),
                    store: wgpu::StoreOp::Store,
                },
            })
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("projection::surface"),
            color_attachments: &[
                attachment(&color, wgpu::Color::TRANSPARENT),
                attachment(&along, nowhere),
            ],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(1.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(2, look, &[]);
        cells.draw(gpu, &mut pass, frame, data);
    }

    /// What the pass reads of `frame`.
    pub(crate) fn look_group(
        &self,
        gpu: &Gpu,
        frame: &FrameData,
        data: &SurfaceData,
    ) -> Result<wgpu::BindGroup, Error> {
        let label = "projection::surface";
        let items = gpu.upload(label, &frame.items, BufferUsages::STORAGE)?;
        let resources = [
            items.as_entire_binding(),
            BindingResource::TextureView(&data.table),
        ];
        gpu.checked(label, 0, || {
            group(gpu, label, &self.look_layout, &resources)
        })
    }

    /// Records what puts `textures` into `target` where nothing in `depth` hides it;
    /// `clip` takes camera space to clip space.
    pub(crate) fn record_among(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (frame, clip): (&wgpu::Buffer, &DMat4),
        textures: &SurfaceTextures,
        (target, depth): (&wgpu::TextureView, &wgpu::TextureView),
    ) -> Result<(), Error> {
        let label = "projection::among";
        let Some(among) = &self.among else {
            return Err(Error::invalid(
                "a depth target, but ProjectionOptions::depth_format is not set",
            ));
        };
        let clip = gpu_data::Clip {
            z: clip.row(2).as_vec4().to_array(),
            w: clip.row(3).as_vec4().to_array(),
        };
        let clip = gpu.upload(label, &[clip], BufferUsages::UNIFORM)?;
        gpu.checked(label, 0, || {
            let frame = [frame.as_entire_binding()];
            let frame = group(gpu, label, &among.frame_layout, &frame);
            let color = textures.color.create_view(&Default::default());
            let along = textures.along.create_view(&Default::default());
            let resources = [
                clip.as_entire_binding(),
                BindingResource::TextureView(&color),
                BindingResource::TextureView(&along),
            ];
            let drawn = group(gpu, label, &among.layout, &resources);
            let kept = wgpu::StoreOp::Store;
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(label),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: kept,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: depth,
                    depth_ops: Some(wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: kept,
                    }),
                    stencil_ops: among.has_stencil.then_some(wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: kept,
                    }),
                }),
                ..Default::default()
            });
            pass.set_pipeline(&among.pipeline);
            pass.set_bind_group(0, &frame, &[]);
            pass.set_bind_group(1, &drawn, &[]);
            pass.draw(0..3, 0..1);
        })
    }
}

impl Among {
    /// Inside of [`Gpu::checked`].
    fn new(gpu: &Gpu, target: TextureFormat, depth: DepthFormat) -> Among {
        let label = "projection::among";
        let module = module(gpu, label, AMONG);
        let frame_layout = layout(gpu, label, ShaderStages::FRAGMENT, &[UNIFORM]);
        let types = [UNIFORM, TEXELS, TEXELS];
        let textures = layout(gpu, label, ShaderStages::FRAGMENT, &types);
        let pipeline = gpu
            .device()
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(label),
                layout: Some(&pipeline_layout(gpu, label, &[&frame_layout, &textures])),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("vs_among"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: depth.format,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(depth.compare),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("fs_among"),
                    compilation_options: Default::default(),
                    targets: &[Some(target.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
        Among {
            frame_layout,
            layout: textures,
            pipeline,
            has_stencil: depth.format.has_stencil_aspect(),
        }
    }
}

impl SurfaceData {
    /// For the surfaces of `appearance` in a field of scalars from `range.0` to `range.1`,
    /// in the unit of `map`.
    pub(crate) fn new(
        gpu: &Gpu,
        appearance: &Appearance,
        map: &ScalarMap,
        range: (f32, f32),
        search: SurfaceSearch,
    ) -> Result<SurfaceData, Error> {
        let (side, texels) = match search {
            SurfaceSearch::Exact => (0, vec![0]),
            SurfaceSearch::Table { n, thickness } => {
                search.validate()?;
                let values = surfaces(appearance).into_iter();
                let values: Vec<f32> = values.map(|s| map.scalar(s.value)).collect();
                (n, thickened(&values, n, thickness, range))
            }
        };
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let size = (side.max(1), side.max(1));
        let format = TextureFormat::R32Uint;
        let table = gpu.texture("the table of isosurfaces", size, format, usage)?;
        gpu.checked("the table of isosurfaces", 0, || {
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(4 * size.0),
                rows_per_image: None,
            };
            let bytes = bytemuck::cast_slice(&texels);
            gpu.queue()
                .write_texture(table.as_image_copy(), bytes, layout, table.size());
        })?;
        Ok(SurfaceData {
            table: table.create_view(&Default::default()),
            side,
            range,
        })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        4 * u64::from(self.side) * u64::from(self.side)
    }

    /// The constants of `surface.wgsl`.
    pub(crate) fn constants(&self) -> [(&'static str, f64); 3] {
        [
            ("SURFACE_TABLE", self.side.into()),
            ("SURFACE_LOW", self.range.0.into()),
            ("SURFACE_HIGH", self.range.1.into()),
        ]
    }
}

/// Which surface is seen first from scalar to scalar, n × n, that at the front running
/// fastest, each at the middle of its n-th part of the range; `values.len()` for none.
///
/// "The smallest isovalue occludes the others" where scalars rise along the ray, else the
/// greatest (§5.2). Each surface counts as `thickness` samples thick on either side.
fn thickened(values: &[f32], n: u32, thickness: f32, (low, high): (f32, f32)) -> Vec<u32> {
    let step = (high - low) / n as f32;
    let at = |i: u32| low + step * (i as f32 + 0.5);
    let reach = thickness * step;
    let seen = |front: f32, back: f32| {
        let (least, greatest) = (front.min(back) - reach, front.max(back) + reach);
        let met = (0_u32..)
            .zip(values)
            .filter(|(_, v)| (least..=greatest).contains(*v));
        let nearer = |a: &(u32, &f32), b: &(u32, &f32)| {
            let by_value = a.1.total_cmp(b.1);
            let by_value = if front <= back {
                by_value
            } else {
                by_value.reverse()
            };
            by_value.then(a.0.cmp(&b.0))
        };
        met.min_by(nearer).map_or(values.len() as u32, |(i, _)| i)
    };
    (0..n)
        .flat_map(|back| (0..n).map(move |front| (front, back)))
        .map(|(front, back)| seen(at(front), at(back)))
        .collect()
}

impl SurfaceTextures {
    pub(crate) fn new(gpu: &Gpu, size: (u32, u32)) -> Result<SurfaceTextures, Error> {
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let read = drawn | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC;
        Ok(SurfaceTextures {
            color: gpu.texture("of isosurfaces", size, COLOR, read)?,
            along: gpu.texture("of isosurfaces' depths", size, ALONG, read)?,
            depth: gpu.texture("of isosurfaces' order", size, DEPTH, drawn)?,
        })
    }

    /// Whether a frame of `size` fits.
    pub(crate) fn fits(&self, size: (u32, u32)) -> bool {
        (self.color.width(), self.color.height()) == size
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Figure 10b: seen along the gradient, the smallest isovalue is in front.
    #[test]
    fn the_table_is_that_of_the_figure() {
        let table = thickened(&[0.7, 0.3, 0.5], 10, 0.0, (0.0, 1.0));
        let seen = |front: usize, back: usize| table[10 * back + front];
        assert_eq!((seen(0, 9), seen(9, 0)), (1, 0));
        assert_eq!((seen(4, 9), seen(4, 0)), (2, 1));
        assert_eq!((seen(0, 1), seen(9, 9)), (3, 3), "none");
        // 0.45 to 0.45 is half a sample from 0.5.
        assert_eq!(seen(4, 4), 3);
        let thick = thickened(&[0.7, 0.3, 0.5], 10, 0.6, (0.0, 1.0));
        assert_eq!(thick[44], 2);
    }
}
