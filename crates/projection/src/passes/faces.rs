//! Pass 3 by ray parameters at vertices: draw the faces of cells (`faces.wgsl`,
//! `face.wgsl`).

use tetrascope_core::{Error, OpticalModel};
use tetrascope_gpu::passes::{READ, group};
use tetrascope_gpu::preintegration::TABLE;
use tetrascope_gpu::wgpu::{self, BindingResource, ShaderStages, TextureFormat, TextureUsages};
use tetrascope_gpu::{Gpu, RenderProgram};
use tetrascope_shaders::projection::{FACES_FLOATS, FACES_SHARED, FACES_SHORTS};

use super::cell::{CellPass, Uploaded};
use crate::mesh::{Field, Geometry};
use crate::options::{CellLayout, ExitSearch, ProjectionOptions};

/// The parts of the pass that do not depend on the volume.
#[derive(Clone, Debug)]
pub(crate) struct FacePass {
    source: &'static str,
    groups: Vec<wgpu::BindGroupLayout>,
    group_layout: wgpu::BindGroupLayout,
    /// The minimum of three numbers; one texel where they are compared.
    minimum: wgpu::Texture,
    /// Its samples per side, 0 where they are compared.
    side: u32,
}

impl FacePass {
    pub(crate) fn new(
        gpu: &Gpu,
        options: &ProjectionOptions,
        cells: &CellPass,
    ) -> Result<FacePass, Error> {
        let label = "projection::faces";
        let source = match options.cell_layout {
            CellLayout::SharedVertices => FACES_SHARED,
            CellLayout::TwelveFloats => FACES_FLOATS,
            CellLayout::TwelveShorts => FACES_SHORTS,
        };
        let side = match options.exit_search {
            ExitSearch::PerVertexTexture => options.minimum_side,
            _ => 0,
        };
        let minimum = minimum_texture(gpu, side)?;
        let stages = ShaderStages::VERTEX_FRAGMENT;
        let group_layout = gpu.layout(label, stages, &[READ, READ, TABLE])?;
        let [frame, volume] = cells.layouts();
        Ok(FacePass {
            source,
            groups: vec![frame.clone(), volume.clone(), group_layout.clone()],
            group_layout,
            minimum,
            side,
        })
    }

    /// The program of what is drawn, and what it reads beside the mesh.
    pub(crate) fn program(
        &self,
        gpu: &Gpu,
        cells: &CellPass,
        uploaded: Uploaded,
        model: OpticalModel,
    ) -> Result<(RenderProgram, wgpu::BindGroup), Error> {
        let (needed, most) = (uploaded.classified.culled.items, u32::MAX / 12);
        if needed > most {
            return Err(Error::TooLarge {
                what: "the mesh".into(),
                needed: needed.into(),
                limit: most.into(),
                unit: "cells",
            });
        }
        let mut program = RenderProgram {
            source: self.source,
            vertex: "vs_face",
            fragment: Some("fs_face"),
            groups: self.groups.clone(),
            cull_mode: Some(wgpu::Face::Back),
            ..cells.integral(gpu, uploaded, model)
        };
        program.constants.push(("MINIMUM_SIDE", self.side.into()));
        Ok((program, self.group(gpu, uploaded.geometry, uploaded.field)?))
    }

    fn group(
        &self,
        gpu: &Gpu,
        geometry: &Geometry,
        field: &Field,
    ) -> Result<wgpu::BindGroup, Error> {
        let label = "projection::faces";
        let [placed, shaped] = match &field.faces {
            Some([placed, shaped]) => [placed, shaped],
            None => [&geometry.positions, &field.scalars],
        };
        let minimum = self.minimum.create_view(&Default::default());
        let resources = [
            placed.as_entire_binding(),
            shaped.as_entire_binding(),
            BindingResource::TextureView(&minimum),
        ];
        gpu.checked(label, 0, || {
            group(gpu, label, &self.group_layout, &resources)
        })
    }

    /// Bytes on the device.
    pub(crate) fn bytes(&self) -> u64 {
        4 * u64::from(self.side).pow(3)
    }
}

/// The minimum of the coordinates at each of side³ samples from 0 to 1 (§4.1).
fn minimum_texture(gpu: &Gpu, side: u32) -> Result<wgpu::Texture, Error> {
    let n = side.max(1);
    let last = f32::from((n - 1).max(1) as u16);
    let samples = (0..n).flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| [x, y, z])));
    let least = |at: [u32; 3]| at.into_iter().min().unwrap_or(0) as f32 / last;
    let samples: Vec<f32> = samples.map(least).collect();
    let size = wgpu::Extent3d {
        width: n,
        height: n,
        depth_or_array_layers: n,
    };
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
    let texture = gpu.texture_3d("the minimum texture", size, TextureFormat::R32Float, usage)?;
    gpu.write_texture(&texture, &samples)?;
    Ok(texture)
}
