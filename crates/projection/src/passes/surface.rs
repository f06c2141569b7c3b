//! Pass 3 where isosurfaces are drawn (`surface.wgsl`).

use std::sync::{Arc, Mutex, PoisonError};

use tetrascope_core::{Appearance, Error, OpticalModel};
use tetrascope_f32::ScalarMap;
use tetrascope_f32::look::{surfaces, table_span};
use tetrascope_gpu::canvas::NOWHERE;
use tetrascope_gpu::passes::{READ, group};
use tetrascope_gpu::pipelines::Constant;
use tetrascope_gpu::wgpu::{
    self, BindingResource, BufferUsages, ShaderStages, TextureFormat, TextureUsages,
};
use tetrascope_gpu::{Gpu, RenderProgram, Sums, sides};
use tetrascope_shaders::projection::SURFACE;

use super::cell::{CellData, CellPass, FrameData, Uploaded};
use crate::options::SurfaceSearch;

/// Linear RGB, opaque.
pub(crate) const COLOR: TextureFormat = TextureFormat::Rgba32Float;
/// Distance along the ray.
const DISTANCE: TextureFormat = TextureFormat::R32Float;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

/// The targets of the pass.
const TARGETS: [Option<wgpu::ColorTargetState>; 2] = [target(COLOR), target(DISTANCE)];

const fn target(format: TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState {
        format,
        blend: None,
        write_mask: wgpu::ColorWrites::ALL,
    })
}

/// The nearest fragment is kept.
fn hidden() -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH,
        depth_write_enabled: Some(true),
        depth_compare: Some(wgpu::CompareFunction::Less),
        stencil: Default::default(),
        bias: Default::default(),
    }
}

/// The parts of the pass that do not depend on the appearance.
#[derive(Clone, Debug)]
pub(crate) struct SurfacePass {
    groups: Vec<wgpu::BindGroupLayout>,
    look_layout: wgpu::BindGroupLayout,
    /// The depths of the nearest, of the last frame for the next.
    depths: Arc<Mutex<Option<wgpu::Texture>>>,
}

/// How surfaces are found in cells, for one appearance.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceData {
    table: wgpu::TextureView,
    side: u32,
    range: (f32, f32),
}

/// A texture of numbers of surfaces.
const NUMBERS: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

impl SurfacePass {
    pub(crate) fn new(gpu: &Gpu, cells: &CellPass) -> Result<SurfacePass, Error> {
        let label = "projection::surface";
        let look_layout = gpu.layout(label, ShaderStages::FRAGMENT, &[READ, NUMBERS])?;
        let [frame, volume] = cells.layouts();
        Ok(SurfacePass {
            groups: vec![frame.clone(), volume.clone(), look_layout.clone()],
            look_layout,
            depths: Arc::default(),
        })
    }

    /// The program that finds the nearest surface in cells.
    pub(crate) fn program(
        &self,
        gpu: &Gpu,
        cells: &CellPass,
        uploaded: Uploaded,
        data: &SurfaceData,
    ) -> Result<RenderProgram, Error> {
        let extras = uploaded.classified.extras;
        let mut constants = [data.constants().to_vec(), extras.to_vec()].concat();
        constants.push(sides::constant(gpu)?);
        Ok(RenderProgram {
            source: SURFACE,
            fragment: Some("fs_surface"),
            groups: self.groups.clone(),
            targets: TARGETS.to_vec(),
            depth: Some(hidden()),
            constants,
            ..cells.integral(gpu, uploaded, OpticalModel::Isosurfaces)
        })
    }

    /// Records one draw of all cells into `sums`, which has distances.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        (frame, look): (&FrameData, &wgpu::BindGroup),
        (cells, data): (&CellPass, &CellData),
        sums: &Sums,
    ) -> Result<(), Error> {
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let color = view(&sums.color);
        let distances = view(sums.distances.as_ref().expect("surfaces have distances"));
        let depth = view(&self.depths(gpu, (sums.color.width(), sums.color.height()))?);
        let nowhere = wgpu::Color {
            r: NOWHERE.into(),
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
                attachment(&distances, nowhere),
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
        cells.draw(gpu, &mut pass, frame, data)
    }

    fn depths(&self, gpu: &Gpu, size: (u32, u32)) -> Result<wgpu::Texture, Error> {
        let mut kept = self.depths.lock().unwrap_or_else(PoisonError::into_inner);
        let found = kept.take().filter(|t| (t.width(), t.height()) == size);
        let usage = TextureUsages::RENDER_ATTACHMENT;
        let make = || gpu.texture("of isosurfaces' order", size, DEPTH, usage);
        let found = found.map_or_else(make, Ok)?;
        *kept = Some(found.clone());
        Ok(found)
    }

    /// The data that the pass reads of `frame`.
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
    pub(crate) fn constants(&self) -> [Constant; 1] {
        [("SURFACE_TABLE", self.side.into())]
    }

    /// The ends of the table.
    pub(crate) fn span(&self) -> [f32; 4] {
        table_span(self.range, 1.0)
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
