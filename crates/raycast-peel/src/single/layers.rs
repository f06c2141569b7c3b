//! Layers of the boundary faces that rays cross, peeled front to back by `peel.wgsl`
//! ([`crate::Entries::PeeledLayers`]).

use tetrascope_core::{Error, View};
use tetrascope_f32::Rays;
use tetrascope_f32::tiles::rectangles;
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::wgpu::TextureViewDimension::{self, D2, D2Array};
use tetrascope_gpu::wgpu::{
    self, BindingResource, BufferUsages, Color, LoadOp, StoreOp, TextureFormat, TextureUsages,
    TextureView,
};
use tetrascope_gpu::{Gpu, RenderProgram, read_back};
use tetrascope_shaders::raycast_peel::PEEL;

use super::Mesh;
use crate::gpu_data::{March, RECTANGLES};

/// The most layers of a frame: a ray in more searches lists.
///
/// The meshes that the crate is judged by have up to 14 where they are seen from a corner.
const MOST_LAYERS: u64 = 16;

/// The most bytes that layers take, unless two take more.
const MOST_BYTES: u64 = 128 << 20;

const LABEL: &str = "raycast-peel::peel";
const FACES: TextureFormat = TextureFormat::R32Uint;
const DEPTHS: TextureFormat = TextureFormat::Depth32Float;

/// `NO_FACE`, as a color is given to wgpu.
const NOTHING: Color = Color {
    r: u32::MAX as f64,
    ..Color::TRANSPARENT
};

/// Pipelines.
#[derive(Debug)]
pub(crate) struct Peeling {
    pipeline: wgpu::RenderPipeline,
}

/// The layers that were peeled.
pub(crate) struct Layers {
    faces: wgpu::Texture,
    pub(crate) count: u32,
    /// Layers with a face, as far as rays cross the boundary in pairs.
    pub(crate) full: u64,
    /// Whether rays in all layers may be in more.
    pub(crate) may_be_more: bool,
    pub(crate) passes: u64,
}

impl Layers {
    /// All layers that were peeled.
    pub(crate) fn view(&self) -> TextureView {
        array(&self.faces, 0..self.count, D2Array)
    }
}

fn array(
    texture: &wgpu::Texture,
    layers: std::ops::Range<u32>,
    dimension: TextureViewDimension,
) -> TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(dimension),
        base_array_layer: layers.start,
        array_layer_count: Some(layers.end - layers.start),
        ..Default::default()
    })
}

/// The texture that is bound where no layers are peeled.
pub(crate) fn none(gpu: &Gpu) -> Result<TextureView, Error> {
    let label = "raycast-peel::no_layers";
    let texture = gpu.texture(label, (1, 1), FACES, TextureUsages::TEXTURE_BINDING)?;
    Ok(array(&texture, 0..1, D2Array))
}

impl Peeling {
    pub(crate) fn new(gpu: &Gpu, sides: (&'static str, f64)) -> Result<Peeling, Error> {
        let pipeline = gpu.render_pipeline(&RenderProgram {
            label: LABEL,
            source: PEEL,
            vertex: "vs_peel",
            buffers: vec![Some(RECTANGLES)],
            fragment: Some("fs_peel"),
            constants: vec![sides],
            targets: vec![Some(FACES.into())],
            depth: Some(wgpu::DepthStencilState {
                format: DEPTHS,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            ..Default::default()
        })?;
        Ok(Peeling { pipeline })
    }

    fn group(&self, gpu: &Gpu, index: u32, of: &[(u32, BindingResource)]) -> wgpu::BindGroup {
        let entries = of.iter().map(|(binding, resource)| wgpu::BindGroupEntry {
            binding: *binding,
            resource: resource.clone(),
        });
        gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(LABEL),
            layout: &self.pipeline.get_bind_group_layout(index),
            entries: &entries.collect::<Vec<_>>(),
        })
    }

    /// Peels until a layer is empty, or there is no room for more. Submits one layer
    /// or two, and waits for an occlusion query.
    pub(crate) fn peel(
        &self,
        gpu: &Gpu,
        view: &View,
        rays: &Rays,
        mesh: &Mesh,
        march: &March,
    ) -> Result<Layers, Error> {
        let size = (view.width, view.height);
        let bytes = 4 * u64::from(size.0) * u64::from(size.1);
        let most = (MOST_BYTES / bytes).clamp(2, MOST_LAYERS) as u32;
        let faces = gpu.checked("raycast-peel::layers", u64::from(most) * bytes, || {
            gpu.device().create_texture(&wgpu::TextureDescriptor {
                label: Some("raycast-peel::layers"),
                size: wgpu::Extent3d {
                    width: size.0,
                    height: size.1,
                    depth_or_array_layers: most,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FACES,
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        })?;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let depths = || gpu.texture("raycast-peel::layer_depths", size, DEPTHS, usage);
        let depths = [depths()?, depths()?].map(|t| t.create_view(&Default::default()));
        let rectangles = rectangles(view, rays, &mesh.faces);
        let rectangles = gpu.upload(
            "raycast-peel::rectangles",
            &rectangles,
            BufferUsages::VERTEX,
        )?;
        let march = gpu.upload("raycast-peel::march", &[*march], BufferUsages::UNIFORM)?;
        let [vertices, .., boundary] = mesh.textures().map(|t| t.create_view(&Default::default()));
        let usage = BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC;
        let answer = gpu.buffer("raycast-peel::answer", 8, usage)?;
        let query = gpu.checked(LABEL, 0, || {
            gpu.device().create_query_set(&wgpu::QuerySetDescriptor {
                label: Some(LABEL),
                ty: wgpu::QueryType::Occlusion,
                count: 1,
            })
        })?;
        let frame = self.group(gpu, 0, &[(0, march.as_entire_binding())]);
        let volume = self.group(
            gpu,
            1,
            &[
                (0, BindingResource::TextureView(&vertices)),
                (4, BindingResource::TextureView(&boundary)),
            ],
        );
        let layer = |i: u32| array(&faces, i..i + 1, D2);
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        // Nothing is before the first layer: every face is behind the greatest depth.
        drop(begin(&mut encoder, None, (&depths[1], 1.0), None));
        let mut count = 0;
        let is_empty = loop {
            let [new, old] = [0, 1].map(|i| &depths[(count as usize + i) % 2]);
            let last = layer(if count == 0 { 1 } else { count - 1 });
            let before = self.group(
                gpu,
                2,
                &[
                    (0, BindingResource::TextureView(&last)),
                    (1, BindingResource::TextureView(old)),
                ],
            );
            let target = layer(count);
            let mut pass = begin(&mut encoder, Some(&target), (new, 0.0), Some(&query));
            pass.set_pipeline(&self.pipeline);
            for (index, group) in (0..).zip([&frame, &volume, &before]) {
                pass.set_bind_group(index, group, &[]);
            }
            pass.set_vertex_buffer(0, rectangles.slice(..));
            pass.begin_occlusion_query(0);
            pass.draw(0..6, 0..mesh.faces.len() as u32);
            pass.end_occlusion_query();
            drop(pass);
            count += 1;
            // Rays cross a boundary in pairs: a second layer needs no question.
            if count % 2 == 0 && count < most {
                continue;
            }
            encoder.resolve_query_set(&query, 0..1, &answer, 0);
            let visible = read_back(gpu, &mut encoder, Source::Buffer(&answer, 8))?;
            gpu.finish(encoder)?;
            let is_empty = visible.read::<u64>()? == [0];
            if is_empty || count == most {
                break is_empty;
            }
            encoder = gpu.device().create_command_encoder(&Default::default());
        };
        Ok(Layers {
            faces,
            count,
            full: u64::from(count) - u64::from(is_empty),
            may_be_more: !is_empty,
            passes: 1 + u64::from(count),
        })
    }
}

/// A pass that begins with no faces, and depths of `clear`.
fn begin<'a>(
    encoder: &'a mut wgpu::CommandEncoder,
    layer: Option<&TextureView>,
    (depths, clear): (&TextureView, f32),
    query: Option<&wgpu::QuerySet>,
) -> wgpu::RenderPass<'a> {
    let attachment = layer.map(|view| wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: LoadOp::Clear(NOTHING),
            store: StoreOp::Store,
        },
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(LABEL),
        color_attachments: &[attachment],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depths,
            depth_ops: Some(wgpu::Operations {
                load: LoadOp::Clear(clear),
                store: StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        occlusion_query_set: query,
        ..Default::default()
    })
}
