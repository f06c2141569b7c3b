//! The samples of a grid in three stacks of textures (`turn.wgsl`).

use tetrascope_core::Error;
use tetrascope_f32::Normalization;
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::memory::texture_bytes;
use tetrascope_gpu::passes::group;
use tetrascope_gpu::wgpu::{self, BindingType, ShaderStages, TextureUsages};
use tetrascope_gpu::{ComputeProgram, DeviceGrid, Gpu};
use tetrascope_shaders::stacks::{TURN_COVERED, TURN_VALUES};

const LABEL: &str = "voxel-hw::turn";

/// Invocations of a workgroup along each axis.
const THREADS: u32 = 4;

/// The axes of a stack along `axis`, in the order of stack space.
pub(super) fn axes(axis: usize) -> [usize; 3] {
    [(axis + 1) % 3, (axis + 2) % 3, axis]
}

/// A grid and its three stacks.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) grid: DeviceGrid,
    pub(super) normalization: Normalization,
    /// One for each axis along which layers follow each other.
    pub(super) stacks: [Stack; 3],
}

/// Samples as the layers of a texture.
#[derive(Debug)]
pub(super) struct Stack {
    pub(super) texture: wgpu::Texture,
    turn: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
}

impl Layers {
    /// Makes the stacks of `grid`, whose samples are yet to be copied ([`Layers::submit`]). Those of
    /// `old` are used again if they are as large.
    ///
    /// # Errors
    /// [`Error::TooLarge`] for more samples along an axis than the device has layers, and
    /// [`Error::OutOfMemory`].
    pub(super) fn new(gpu: &Gpu, grid: &DeviceGrid, old: Option<&Layers>) -> Result<Layers, Error> {
        let old = |axis: usize| old.map(|layers| &layers.stacks[axis].texture);
        let stack = |axis: usize| Stack::new(gpu, grid, axis, old(axis));
        Ok(Layers {
            grid: grid.clone(),
            normalization: Normalization::of(&grid.lattice().bounds()),
            stacks: [stack(0)?, stack(1)?, stack(2)?],
        })
    }

    /// Whether these are the stacks of `grid` but for what its texture holds by now.
    pub(super) fn are_of(&self, grid: &DeviceGrid) -> bool {
        let own = &self.grid;
        own.texture() == grid.texture()
            && own.texels() == grid.texels()
            && own.lattice() == grid.lattice()
            && own.scalar_range() == grid.scalar_range()
    }

    /// Submits what `made` records to write the samples, and what copies them; waits for nothing.
    pub(super) fn submit(
        &self,
        gpu: &Gpu,
        made: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<(), Error> {
        gpu.checked(LABEL, 0, || {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            made(&mut encoder);
            self.record(&mut encoder);
            gpu.queue().submit([encoder.finish()]);
        })
    }

    /// Records what copies the samples that the texture holds by then.
    pub(super) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(LABEL),
            timestamp_writes: None,
        });
        for stack in &self.stacks {
            let size = stack.texture.size();
            let [x, y, z] = [size.width, size.height, size.depth_or_array_layers]
                .map(|side| side.div_ceil(THREADS));
            pass.set_pipeline(&stack.turn);
            pass.set_bind_group(0, &stack.group, &[]);
            pass.dispatch_workgroups(x, y, z);
        }
    }

    /// Bytes of the grid and its stacks.
    pub(super) fn bytes(&self) -> u64 {
        let stacks = self
            .stacks
            .iter()
            .map(|stack| texture_bytes(&stack.texture));
        self.grid.bytes() + stacks.sum::<u64>()
    }
}

impl Stack {
    fn new(
        gpu: &Gpu,
        grid: &DeviceGrid,
        axis: usize,
        old: Option<&wgpu::Texture>,
    ) -> Result<Stack, Error> {
        let format = grid.texels().format();
        // What does not fit 32 bits is not in a texture.
        let [width, height, layers] = axes(axis).map(|axis| grid.lattice().dims[axis] as u32);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: layers,
        };
        let texture = match old {
            Some(old) if old.size() == size && old.format() == format => old.clone(),
            _ => {
                let usage = TextureUsages::STORAGE_BINDING
                    | TextureUsages::TEXTURE_BINDING
                    | TextureUsages::COPY_SRC;
                let label = "a stack of textures, one for each plane of samples,";
                gpu.texture_layers(label, size, format, usage)?
            }
        };
        let source = match grid.texels() {
            Texels::Covered => TURN_COVERED,
            Texels::Values | Texels::Gaps => TURN_VALUES,
        };
        let types = [SAMPLES, written(format)];
        let layout = gpu.layout(LABEL, ShaderStages::COMPUTE, &types)?;
        let turn = gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source,
            entry: None,
            constants: vec![("AXIS", axis as f64)],
            groups: vec![layout.clone()],
        })?;
        let group = gpu.checked(LABEL, 0, || {
            let samples = grid.texture().create_view(&Default::default());
            let layers = texture.create_view(&Default::default());
            let resources = [&samples, &layers].map(wgpu::BindingResource::TextureView);
            group(gpu, LABEL, &layout, &resources)
        })?;
        Ok(Stack {
            texture,
            turn,
            group,
        })
    }
}

/// A grid's texture, read texel by texel.
const SAMPLES: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D3,
    multisampled: false,
};

/// Layers that are read texel by texel.
pub(super) const LAYERS: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Float { filterable: false },
    view_dimension: wgpu::TextureViewDimension::D2Array,
    multisampled: false,
};

/// Layers that are written texel by texel.
fn written(format: wgpu::TextureFormat) -> BindingType {
    BindingType::StorageTexture {
        access: wgpu::StorageTextureAccess::WriteOnly,
        format,
        view_dimension: wgpu::TextureViewDimension::D2Array,
    }
}
