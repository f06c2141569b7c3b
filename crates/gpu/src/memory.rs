//! Buffers and textures, checked against the device's limits before they are made.

use std::sync::mpsc;
use std::time::Duration;

use tetrascope_core::Error;
use wgpu::{BufferUsages, TextureUsages};

use crate::Gpu;

/// Bytes of a texture's texels.
pub fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = texture.format().block_copy_size(None).unwrap_or(16);
    let layers = texture.depth_or_array_layers();
    u64::from(texture.width()) * u64::from(texture.height()) * u64::from(layers) * u64::from(texel)
}

/// How [`Gpu::upload_texels`] lays texels out, as in `common/texels.wgsl`.
pub const TEXELS_PER_ROW: u32 = 4096;

impl Gpu {
    /// An empty buffer of `bytes` bytes, rounded up to what wgpu copies.
    ///
    /// [`Error::TooLarge`] if the device holds no such buffer, or binds none when
    /// `usage` asks for it; [`Error::OutOfMemory`] if its memory is full.
    pub fn buffer(
        &self,
        label: &str,
        bytes: u64,
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        let size = self.checked_size(label, bytes, usage)?;
        self.checked(label, size, || {
            self.count_allocation();
            self.device().create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        })
    }

    /// A buffer that holds `contents`; an empty slice makes room for one element,
    /// as bindings may not be empty.
    ///
    /// Errors as in [`Gpu::buffer`].
    pub fn upload<T: bytemuck::Pod>(
        &self,
        label: &str,
        contents: &[T],
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        let bytes = size_of_val(contents).max(size_of::<T>()) as u64;
        let buffer = self.buffer(label, bytes, usage | BufferUsages::COPY_DST)?;
        self.write(label, &buffer, contents)?;
        Ok(buffer)
    }

    /// Writes `contents` to the start of `buffer`, before the next submission.
    pub fn write<T: bytemuck::Pod>(
        &self,
        label: &str,
        buffer: &wgpu::Buffer,
        contents: &[T],
    ) -> Result<(), Error> {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        // wgpu copies multiples of 4 bytes.
        let aligned = bytes.len() - bytes.len() % 4;
        self.checked(label, bytes.len() as u64, || {
            if aligned > 0 {
                self.queue().write_buffer(buffer, 0, &bytes[..aligned]);
            }
            if aligned < bytes.len() {
                let mut tail = [0; 4];
                tail[..bytes.len() - aligned].copy_from_slice(&bytes[aligned..]);
                self.queue().write_buffer(buffer, aligned as u64, &tail);
            }
        })
    }

    /// A two-dimensional texture with one mip level.
    ///
    /// Errors as in [`Gpu::buffer`].
    pub fn texture(
        &self,
        label: &str,
        (width, height): (u32, u32),
        format: wgpu::TextureFormat,
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        let limit = self.limits().max_texture_dimension_2d;
        for side in [width, height] {
            if side > limit {
                return Err(Error::TooLarge {
                    what: format!("the image {label}, {width}x{height},"),
                    needed: side.into(),
                    limit: limit.into(),
                    unit: "pixels a side",
                });
            }
        }
        let texel = u64::from(format.block_copy_size(None).unwrap_or(16));
        let bytes = u64::from(width) * u64::from(height) * texel;
        self.checked(label, bytes, || {
            self.count_allocation();
            self.device().create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: extent(width, height),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        })
    }

    /// A three-dimensional texture with one mip level.
    ///
    /// Errors as in [`Gpu::buffer`].
    pub fn texture_3d(
        &self,
        label: &str,
        size: wgpu::Extent3d,
        format: wgpu::TextureFormat,
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        let limit = self.limits().max_texture_dimension_3d;
        let sides = [size.width, size.height, size.depth_or_array_layers];
        let greatest = sides.into_iter().max().unwrap_or(0);
        if greatest > limit {
            return Err(Error::TooLarge {
                what: label.into(),
                needed: greatest.into(),
                limit: limit.into(),
                unit: "texels a side",
            });
        }
        let texel = u64::from(format.block_copy_size(None).unwrap_or(16));
        let bytes = sides.into_iter().map(u64::from).product::<u64>() * texel;
        self.checked(label, bytes, || {
            self.count_allocation();
            self.device().create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D3,
                format,
                usage,
                view_formats: &[],
            })
        })
    }

    /// A stack of two-dimensional textures with one mip level: `size` has their number.
    ///
    /// Errors as in [`Gpu::buffer`].
    pub fn texture_layers(
        &self,
        label: &str,
        size: wgpu::Extent3d,
        format: wgpu::TextureFormat,
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        let limits = self.limits();
        let sides = (limits.max_texture_dimension_2d, "texels a side");
        let layers = (limits.max_texture_array_layers, "layers");
        for (needed, (limit, unit)) in [
            (size.width, sides),
            (size.height, sides),
            (size.depth_or_array_layers, layers),
        ] {
            if needed > limit {
                return Err(Error::TooLarge {
                    what: label.into(),
                    needed: needed.into(),
                    limit: limit.into(),
                    unit,
                });
            }
        }
        let texel = u64::from(format.block_copy_size(None).unwrap_or(16));
        let texels = [size.width, size.height, size.depth_or_array_layers];
        let bytes = texels.into_iter().map(u64::from).product::<u64>() * texel;
        self.checked(label, bytes, || {
            self.count_allocation();
            self.device().create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        })
    }

    /// Writes all texels of `texture`, row-major and slice by slice, before the next submission.
    ///
    /// Panics if `contents` does not have their size.
    pub fn write_texture<T: bytemuck::Pod>(
        &self,
        texture: &wgpu::Texture,
        contents: &[T],
    ) -> Result<(), Error> {
        self.write_texels(
            texture,
            wgpu::Origin3d::ZERO,
            texture.size(),
            bytemuck::cast_slice(contents),
        )
    }

    /// Writes the texels of a box of `texture`, row-major and slice by slice, before the next
    /// submission.
    ///
    /// Panics if there are not as many bytes as the box has.
    pub fn write_texels(
        &self,
        texture: &wgpu::Texture,
        origin: wgpu::Origin3d,
        size: wgpu::Extent3d,
        bytes: &[u8],
    ) -> Result<(), Error> {
        let texel = texture.format().block_copy_size(None).unwrap_or(16);
        let row = size.width * texel;
        assert_eq!(
            bytes.len() as u64,
            u64::from(row) * u64::from(size.height) * u64::from(size.depth_or_array_layers),
            "every texel has its contents"
        );
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(row),
            rows_per_image: Some(size.height),
        };
        let to = wgpu::TexelCopyTextureInfo {
            origin,
            ..texture.as_image_copy()
        };
        self.checked("gpu::write_texels", bytes.len() as u64, || {
            self.queue().write_texture(to, bytes, layout, size);
        })
    }

    /// A texture of `contents`, [`TEXELS_PER_ROW`] in each row, that shaders read by
    /// number: texel i is at (i % TEXELS_PER_ROW, i / TEXELS_PER_ROW).
    ///
    /// Software rasterizers read texels several times faster than buffers.
    pub fn upload_texels<T: bytemuck::Pod>(
        &self,
        label: &str,
        format: wgpu::TextureFormat,
        contents: &[T],
    ) -> Result<wgpu::Texture, Error> {
        let count = contents.len().max(1) as u64;
        let width = count.min(TEXELS_PER_ROW.into()) as u32;
        let rows = count.div_ceil(TEXELS_PER_ROW.into());
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        // What does not fit is refused with the texture.
        let rows = rows.min(u32::MAX.into()) as u32;
        let texture = self.texture(label, (width, rows), format, usage)?;
        let mut padded = contents.to_vec();
        padded.resize(width as usize * rows as usize, T::zeroed());
        self.write_texture(&texture, &padded)?;
        Ok(texture)
    }

    fn checked_size(&self, what: &str, bytes: u64, usage: BufferUsages) -> Result<u64, Error> {
        let limits = self.limits();
        let mut limit = limits.max_buffer_size;
        if usage.contains(BufferUsages::STORAGE) {
            limit = limit.min(limits.max_storage_buffer_binding_size);
        }
        if usage.contains(BufferUsages::UNIFORM) {
            limit = limit.min(limits.max_uniform_buffer_binding_size);
        }
        // Checked before rounding up, which could overflow.
        if bytes > limit {
            return Err(Error::TooLarge {
                what: what.into(),
                needed: bytes,
                limit,
                unit: "bytes in one buffer",
            });
        }
        Ok(bytes.next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT).max(4))
    }
}

/// A copy of a texture or buffer on its way to the CPU.
///
/// Made by [`read_back`] while commands are recorded, read once they are submitted.
#[derive(Debug)]
pub struct ReadBack {
    gpu: Gpu,
    buffer: wgpu::Buffer,
    row_bytes: usize,
    padded_row_bytes: usize,
}

/// The source that [`read_back`] copies.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// All of a texture, layer by layer.
    Texture(&'a wgpu::Texture),
    /// The first bytes of a buffer, a multiple of 4.
    Buffer(&'a wgpu::Buffer, u64),
}

/// Records the copy of `source` to where the CPU can read it.
pub fn read_back(
    gpu: &Gpu,
    encoder: &mut wgpu::CommandEncoder,
    source: Source,
) -> Result<ReadBack, Error> {
    const USAGE: BufferUsages = BufferUsages::COPY_DST.union(BufferUsages::MAP_READ);
    let label = "gpu::read_back";
    match source {
        Source::Buffer(from, bytes) => {
            let buffer = gpu.buffer(label, bytes, USAGE)?;
            encoder.copy_buffer_to_buffer(from, 0, &buffer, 0, bytes);
            Ok(ReadBack {
                gpu: gpu.clone(),
                buffer,
                row_bytes: bytes as usize,
                padded_row_bytes: bytes as usize,
            })
        }
        Source::Texture(texture) => {
            let texel = texture.format().block_copy_size(None).unwrap_or(16);
            let row_bytes = texture.width() * texel;
            let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
            let rows = u64::from(texture.height()) * u64::from(texture.depth_or_array_layers());
            let bytes = u64::from(padded) * rows;
            let buffer = gpu.buffer(label, bytes, USAGE)?;
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(padded),
                        rows_per_image: Some(texture.height()),
                    },
                },
                texture.size(),
            );
            Ok(ReadBack {
                gpu: gpu.clone(),
                buffer,
                row_bytes: row_bytes as usize,
                padded_row_bytes: padded as usize,
            })
        }
    }
}

/// How long another thread may take from the end of the device's work to handing
/// its result over: far more than any scheduler lets it wait.
const ANSWER: Duration = Duration::from_secs(30);

impl ReadBack {
    /// Waits for the device and returns the elements, rows without padding.
    ///
    /// The recorded commands must have been submitted.
    pub fn read<T: bytemuck::Pod>(self) -> Result<Vec<T>, Error> {
        let (done, waiting) = mpsc::channel();
        self.buffer.map_async(wgpu::MapMode::Read, .., move |r| {
            // The receiver lives until after the wait below.
            let _ = done.send(r);
        });
        self.gpu.wait()?;
        let failed = |reason: String| Error::Device {
            reason: format!("cannot read the result: {reason}"),
        };
        // Threads that share a device also run each other's callbacks, so that ours may
        // still be on its way when our own wait is over.
        waiting
            .recv_timeout(ANSWER)
            .map_err(|_| failed("the device did not answer".into()))?
            .map_err(|error| failed(error.to_string()))?;
        let mapped = self.buffer.get_mapped_range(..);
        let mapped = mapped.map_err(|error| failed(error.to_string()))?;
        let mut elements = Vec::with_capacity(mapped.len() / size_of::<T>().max(1));
        for row in mapped.chunks(self.padded_row_bytes.max(1)) {
            let row = &row[..self.row_bytes.min(row.len())];
            elements.extend(
                row.chunks_exact(size_of::<T>())
                    .map(bytemuck::pod_read_unaligned::<T>),
            );
        }
        Ok(elements)
    }
}

fn extent(width: u32, height: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn what_is_uploaded_reads_back() {
        let Some(gpu) = testing::gpu("what_is_uploaded_reads_back") else {
            return;
        };
        // Five bytes: neither the size nor the tail is a multiple of four.
        let usage = BufferUsages::COPY_SRC | BufferUsages::STORAGE;
        let buffer = gpu.upload("bytes", &[1_u8, 2, 3, 4, 5], usage);
        let buffer = buffer.expect("five bytes fit");
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let copy = read_back(&gpu, &mut encoder, Source::Buffer(&buffer, 8)).expect("a copy");
        gpu.finish(encoder).expect("nothing can fail");
        assert_eq!(copy.read::<u8>().expect("readable")[..5], [1, 2, 3, 4, 5]);
    }

    #[test]
    fn texture_rows_lose_their_padding() {
        let Some(gpu) = testing::gpu("texture_rows_lose_their_padding") else {
            return;
        };
        let usage = TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let texture = gpu.texture("texels", (3, 2), wgpu::TextureFormat::R32Float, usage);
        let texture = texture.expect("six texels fit");
        let texels: Vec<f32> = (0..6_u8).map(f32::from).collect();
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(12),
            rows_per_image: None,
        };
        let bytes = bytemuck::cast_slice(&texels);
        let image = texture.as_image_copy();
        gpu.queue()
            .write_texture(image, bytes, layout, extent(3, 2));
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let copy = read_back(&gpu, &mut encoder, Source::Texture(&texture)).expect("a copy");
        gpu.finish(encoder).expect("nothing can fail");
        assert_eq!(copy.read::<f32>().expect("readable"), texels);
    }

    #[test]
    fn sizes_beyond_the_limits_are_refused_with_numbers() {
        let Some(gpu) = testing::gpu("sizes_beyond_the_limits_are_refused_with_numbers") else {
            return;
        };
        for bytes in [gpu.limits().max_storage_buffer_binding_size + 1, u64::MAX] {
            let error = gpu.buffer("cells", bytes, BufferUsages::STORAGE);
            match error.expect_err("no device binds this much") {
                Error::TooLarge { needed, limit, .. } => assert!(needed == bytes && limit < bytes),
                other => panic!("{other}"),
            }
        }
        let side = gpu.limits().max_texture_dimension_2d + 1;
        let format = wgpu::TextureFormat::Rgba32Float;
        let error = gpu.texture("image", (side, 1), format, TextureUsages::COPY_SRC);
        assert!(matches!(error, Err(Error::TooLarge { .. })));
    }

    #[test]
    fn what_wgpu_refuses_is_an_error() {
        let Some(gpu) = testing::gpu("what_wgpu_refuses_is_an_error") else {
            return;
        };
        // Mapping and storage exclude each other.
        let usage = BufferUsages::MAP_READ | BufferUsages::STORAGE;
        let error = gpu.buffer("contradiction", 16, usage).expect_err("refused");
        assert!(matches!(error, Error::Device { .. }), "{error}");
        assert!(!error.to_string().contains('\n'));
        gpu.healthy().expect("the device itself is fine");
    }

    #[test]
    fn a_destroyed_device_is_an_error() {
        let Some(gpu) = testing::gpu("a_destroyed_device_is_an_error") else {
            return;
        };
        let buffer = gpu.upload("four bytes", &[1_u32], BufferUsages::COPY_SRC);
        let buffer = buffer.expect("four bytes fit");
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let copy = read_back(&gpu, &mut encoder, Source::Buffer(&buffer, 4)).expect("a copy");
        gpu.device().destroy();
        let finished = gpu.finish(encoder).and_then(|()| copy.read::<u32>());
        assert!(
            matches!(finished, Err(Error::Device { .. })),
            "{finished:?}"
        );
    }
}
