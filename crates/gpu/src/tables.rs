//! Textures and buffers that hold a mesh which may change: they grow, and never shrink.

use tetrascope_core::Error;
use wgpu::BufferUsages;

use crate::Gpu;
use crate::memory::{TEXELS_PER_ROW, texture_bytes};

/// Texels of four 32-bit numbers, [`TEXELS_PER_ROW`] in each row.
#[derive(Clone, Debug)]
pub struct Table(wgpu::Texture);

impl Table {
    /// One of at least `texels` texels: `old` if it has them.
    pub fn new(gpu: &Gpu, label: &str, texels: usize, old: Option<&Table>) -> Result<Table, Error> {
        let texels = texels as u64;
        let made = |texels: u64| {
            let rows = texels.div_ceil(TEXELS_PER_ROW.into()).max(1);
            let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
            // What does not fit is refused with the texture.
            let rows = rows.min(u32::MAX.into()) as u32;
            gpu.texture(label, (TEXELS_PER_ROW, rows), TABLE_FORMAT, usage)
        };
        match old {
            Some(old) if old.texels() >= texels => Ok(Table(old.0.clone())),
            // Meshes that change grow by a little many times.
            Some(_) => made(texels + texels / 4)
                .or_else(|_| made(texels))
                .map(Table),
            None => made(texels).map(Table),
        }
    }

    /// How many texels it has.
    pub fn texels(&self) -> u64 {
        u64::from(self.0.width()) * u64::from(self.0.height())
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        texture_bytes(&self.0)
    }

    /// For a bind group.
    pub fn view(&self) -> wgpu::TextureView {
        self.0.create_view(&Default::default())
    }

    /// Writes texels from the first on. Of large meshes a part at a time: a queue keeps copies of all
    /// that is not yet done.
    pub fn write(&self, gpu: &Gpu, bytes: &[u8]) -> Result<(), Error> {
        let row = 16 * TEXELS_PER_ROW as usize;
        let parts = bytes.chunks(ROWS_PER_PART * row);
        let last = parts.len().saturating_sub(1);
        for (index, part) in parts.enumerate() {
            self.write_from(gpu, index * ROWS_PER_PART, part)?;
            if index < last {
                gpu.finish(gpu.device().create_command_encoder(&Default::default()))?;
            }
        }
        Ok(())
    }

    /// Writes texels from the first one of row `y` on.
    fn write_from(&self, gpu: &Gpu, y: usize, bytes: &[u8]) -> Result<(), Error> {
        let row = 16 * TEXELS_PER_ROW as usize;
        let (rows, last) = bytes.split_at(bytes.len() - bytes.len() % row);
        let write = |y: usize, width: usize, bytes: &[u8]| match bytes.is_empty() {
            true => Ok(()),
            false => {
                let size = wgpu::Extent3d {
                    width: width as u32,
                    height: (bytes.len() / (16 * width)) as u32,
                    depth_or_array_layers: 1,
                };
                let origin = wgpu::Origin3d {
                    y: y as u32,
                    ..Default::default()
                };
                gpu.write_texels(&self.0, origin, size, bytes)
            }
        };
        write(y, TEXELS_PER_ROW as usize, rows)?;
        write(y + rows.len() / row, last.len() / 16, last)
    }
}

/// Rows of a table that are written at a time: 16 MiB.
const ROWS_PER_PART: usize = 256;

const TABLE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Uint;

/// A table that shaders read.
pub const TABLE: wgpu::BindingType = wgpu::BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// A buffer of at least `count` things of `bytes` bytes: `old` if it has the room, and otherwise one
/// with a little more where that is not enough.
pub fn grown(
    gpu: &Gpu,
    label: &str,
    (count, bytes): (usize, usize),
    usage: BufferUsages,
    old: Option<&wgpu::Buffer>,
) -> Result<wgpu::Buffer, Error> {
    let needed = count.max(1) as u64 * bytes as u64;
    match old {
        Some(old) if old.size() >= needed => Ok(old.clone()),
        // Meshes that change grow by a little many times.
        Some(old) if old.size() > bytes as u64 => {
            let roomy = needed + needed / 4;
            gpu.buffer(label, roomy, usage)
                .or_else(|_| gpu.buffer(label, needed, usage))
        }
        _ => gpu.buffer(label, needed, usage),
    }
}

/// Whether `buffer` has the room.
pub fn holds(buffer: &wgpu::Buffer, (count, bytes): (usize, usize)) -> bool {
    buffer.size() >= count as u64 * bytes as u64
}
