//! The table of a level's boxes in which rays look (`rays.wgsl`): which show, and where their
//! samples are.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use tetrascope_core::Error;
use tetrascope_gpu::memory::texture_bytes;
use tetrascope_gpu::passes::group;
use tetrascope_gpu::wgpu::{self, BindingType, ShaderStages, TextureUsages};
use tetrascope_gpu::{Gpu, wgpu::TextureFormat};

use crate::boxes::{Boxes, places};
use crate::octree::Visibility;
use crate::voxels::Voxels;

const LABEL: &str = "slicing::table";
const FORMAT: TextureFormat = TextureFormat::Rgba16Sint;

/// How fragments read a table.
const READ_TABLE: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Sint,
    view_dimension: wgpu::TextureViewDimension::D3,
    multisampled: false,
};

/// How a compute pass writes one.
const WRITE_TABLE: BindingType = BindingType::StorageTexture {
    access: wgpu::StorageTextureAccess::WriteOnly,
    format: FORMAT,
    view_dimension: wgpu::TextureViewDimension::D3,
};

/// A table of boxes on the device.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    view: wgpu::TextureView,
    pub(crate) bytes: u64,
}

/// Tables for one appearance, of the levels that were drawn.
#[derive(Debug, Default)]
pub(crate) struct Tables(Mutex<HashMap<u32, Table>>);

impl Tables {
    /// That of a level whose boxes the CPU knows, uploaded when it is first needed. What is outside
    /// of an image is in it, as no ray comes there.
    pub(crate) fn known(
        &self,
        gpu: &Gpu,
        boxes: &Boxes,
        level: u32,
        visibility: &Visibility,
        voxels: &Voxels,
    ) -> Result<Table, Error> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(table) = kept.get(&level) {
            return Ok(table.clone());
        }
        let entry = |place| -> [i16; 4] {
            if !visibility.contains(level, boxes.index(level, place)) {
                return [0; 4];
            }
            // Textures have less than 2¹⁵ texels along each axis.
            let texel = voxels.texel(boxes, level, place).unwrap_or_default();
            let [x, y, z] = texel.map(|t| t as i16);
            [x, y, z, 1]
        };
        let entries: Vec<[i16; 4]> = places(boxes.divisions(level)).map(entry).collect();
        let (texture, table) = make(gpu, boxes, level, TextureUsages::COPY_DST)?;
        gpu.write_texture(&texture, &entries)?;
        kept.insert(level, table.clone());
        Ok(table)
    }
}

impl Table {
    /// One that a compute pass writes.
    pub(crate) fn to_write(gpu: &Gpu, boxes: &Boxes, level: u32) -> Result<Table, Error> {
        Ok(make(gpu, boxes, level, TextureUsages::STORAGE_BINDING)?.1)
    }

    /// The bind group of fragments.
    pub(crate) fn reading(&self, gpu: &Gpu) -> Result<wgpu::BindGroup, Error> {
        self.group(gpu, &reading(gpu)?)
    }

    /// The bind group of a compute pass.
    pub(crate) fn writing(&self, gpu: &Gpu) -> Result<wgpu::BindGroup, Error> {
        self.group(gpu, &writing(gpu)?)
    }

    fn group(&self, gpu: &Gpu, layout: &wgpu::BindGroupLayout) -> Result<wgpu::BindGroup, Error> {
        let view = wgpu::BindingResource::TextureView(&self.view);
        gpu.checked(LABEL, 0, || group(gpu, LABEL, layout, &[view]))
    }
}

/// The layout of [`Table::reading`].
pub(crate) fn reading(gpu: &Gpu) -> Result<wgpu::BindGroupLayout, Error> {
    gpu.layout(LABEL, ShaderStages::FRAGMENT, &[READ_TABLE])
}

/// The layout of [`Table::writing`].
pub(crate) fn writing(gpu: &Gpu) -> Result<wgpu::BindGroupLayout, Error> {
    gpu.layout(LABEL, ShaderStages::COMPUTE, &[WRITE_TABLE])
}

fn make(
    gpu: &Gpu,
    boxes: &Boxes,
    level: u32,
    usage: TextureUsages,
) -> Result<(wgpu::Texture, Table), Error> {
    let [width, height, depth] = boxes.divisions(level).map(|n| n as u32);
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: depth,
    };
    let texture = gpu.texture_3d(LABEL, size, FORMAT, usage | TextureUsages::TEXTURE_BINDING)?;
    let table = Table {
        view: texture.create_view(&Default::default()),
        bytes: texture_bytes(&texture),
    };
    Ok((texture, table))
}
