//! The passes of [`Passes::Direct`](crate::Passes::Direct): `column.wgsl` for `columns/fill.wgsl`.

use tetrascope_core::Error;
use tetrascope_core::grid::Lattice;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::columns::{Columns, Programs};
use tetrascope_gpu::passes::{READ, WRITE, group};
use tetrascope_gpu::pipelines::ComputeProgram;
use tetrascope_gpu::tables::{TABLE, Table, grown, holds};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{DeviceGrid, sides};
use tetrascope_shaders::loops::{COLUMN_CELL_PASSES, COLUMN_SIDE};
use tetrascope_shaders::resample::{FILL, FILL_COUNTED};

use crate::gpu_data::Work;
use crate::placed::{Placed, along};

const LABEL: &str = "resample::direct";

/// Bytes of zeros that clear a texture part by part.
const ZEROS: u64 = 1 << 20;

/// How work is divided, which changes nothing in the samples, and what follows from the device;
/// tests try other numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tuning {
    /// Passes of loops that one invocation takes for a cell, at most [`COLUMN_CELL_PASSES`]; cells of
    /// more are shared by workgroups.
    pub(crate) small: u32,
    /// Samples along each axis that are filled in one dispatch, at most [`COLUMN_SIDE`].
    pub(crate) side: u32,
    /// Whether to count how often each sample is written.
    pub(crate) counted: bool,
    /// Whether fragments of 32-bit floats can be added to a target.
    pub(crate) adds: bool,
    /// How far rasterizers may round a vertex, in pixels; `ROUNDED` of `section.wgsl`.
    pub(crate) rounded: f64,
}

impl Tuning {
    pub(crate) fn new(gpu: &Gpu) -> Tuning {
        let small = match gpu.is_software() {
            // One invocation after the other: the fewer idle ones the better.
            true => COLUMN_CELL_PASSES,
            // Thousands at once: none should be long.
            false => 512,
        };
        Tuning {
            small,
            side: COLUMN_SIDE,
            counted: false,
            adds: gpu.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
            rounded: 1.0 / 256.0,
        }
    }
}

/// Buffers that hold a mesh, and what the passes write. They grow, and never shrink.
#[derive(Debug)]
struct Buffers {
    vertices: Table,
    cells: Table,
    cell_scalars: wgpu::Buffer,
    lists: wgpu::Buffer,
    parts: Vec<Part>,
}

/// A part of the grid that one dispatch fills.
#[derive(Debug)]
struct Part {
    work: wgpu::Buffer,
    /// Without the number of cells.
    of_grid: Work,
    group: wgpu::BindGroup,
}

/// Pipelines and buffers.
#[derive(Debug)]
pub(crate) struct Direct {
    gpu: Gpu,
    layout: wgpu::BindGroupLayout,
    /// For fields of points, and for those of cells.
    programs: [Programs; 2],
    samples: wgpu::BindGroup,
    texture: wgpu::Texture,
    zeros: wgpu::Buffer,
    columns: Columns,
    buffers: Buffers,
    cell_count: u32,
    cell_data: bool,
    /// How often each sample was written, in tests.
    writes: Option<wgpu::Buffer>,
}

impl Direct {
    /// Compiles the passes and uploads the mesh.
    pub(crate) fn new(
        gpu: &Gpu,
        grid: &DeviceGrid,
        placed: &Placed,
        cells: &[[u32; 4]],
        tuning: Tuning,
    ) -> Result<Direct, Error> {
        let counted = tuning.counted;
        let compute = ShaderStages::COMPUTE;
        let layout = gpu.layout(LABEL, compute, &[READ, TABLE, TABLE, READ, WRITE, WRITE])?;
        let put_types: &[_] = if counted {
            &[SAMPLES, WRITE]
        } else {
            &[SAMPLES]
        };
        let put_layout = gpu.layout(LABEL, compute, put_types)?;
        let source = if counted { FILL_COUNTED } else { FILL };
        let constant = sides::constant(gpu)?;
        let programs = |cell_data: f64| {
            let program = ComputeProgram {
                label: LABEL,
                source,
                entry: None,
                constants: vec![constant, ("CELL_DATA", cell_data)],
                groups: vec![layout.clone(), put_layout.clone()],
            };
            Programs::new(gpu, &program)
        };
        let programs = [programs(0.0)?, programs(1.0)?];
        let writes = match counted {
            false => None,
            true => {
                let texels = grid.lattice().dims.iter().product::<usize>() as u64;
                let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
                Some(gpu.buffer("resample::writes", 4 * texels, usage)?)
            }
        };
        let samples = gpu.checked(LABEL, 0, || {
            let view = grid.texture().create_view(&Default::default());
            let mut resources = vec![wgpu::BindingResource::TextureView(&view)];
            resources.extend(writes.as_ref().map(|writes| writes.as_entire_binding()));
            group(gpu, LABEL, &put_layout, &resources)
        })?;
        let columns = Columns::new(gpu)?;
        // Rows of a texture that are copied are whole multiples of 256 bytes.
        let row = (8 * u64::from(grid.texture().width())).next_multiple_of(256);
        let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let zeros = gpu.buffer("resample::zeros", row.max(ZEROS), usage)?;
        let of_grid = parts(grid.lattice(), tuning);
        let buffers = Buffers::new(gpu, &layout, columns.counts(), &of_grid, None, [0, 0, 0])?;
        let mut direct = Direct {
            gpu: gpu.clone(),
            layout,
            programs,
            samples,
            texture: grid.texture().clone(),
            zeros,
            columns,
            buffers,
            cell_count: 0,
            cell_data: false,
            writes,
        };
        direct.upload(placed, cells)?;
        Ok(direct)
    }

    /// Uploads another mesh. Buffers are made anew only where they are too small.
    pub(crate) fn upload(&mut self, placed: &Placed, cells: &[[u32; 4]]) -> Result<(), Error> {
        let gpu = &self.gpu;
        let needed = [
            placed.vertices.len(),
            cells.len(),
            placed.cell_scalars.len(),
        ];
        if !self.buffers.fit(needed) {
            let of_grid: Vec<Work> = self.buffers.parts.iter().map(|p| p.of_grid).collect();
            let old = Some(&self.buffers);
            let made = Buffers::new(
                gpu,
                &self.layout,
                self.columns.counts(),
                &of_grid,
                old,
                needed,
            )?;
            self.buffers = made;
        }
        let buffers = &self.buffers;
        buffers
            .vertices
            .write(gpu, bytemuck::cast_slice(&placed.vertices))?;
        buffers.cells.write(gpu, bytemuck::cast_slice(cells))?;
        gpu.write(LABEL, &buffers.cell_scalars, &placed.cell_scalars)?;
        for part in &buffers.parts {
            let work = Work {
                cell_count: cells.len() as u32,
                ..part.of_grid
            };
            gpu.write(LABEL, &part.work, &[work])?;
        }
        self.cell_count = cells.len() as u32;
        self.cell_data = !placed.cell_scalars.is_empty();
        Ok(())
    }

    /// Records the passes.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        self.clear(encoder);
        if let Some(writes) = &self.writes {
            encoder.clear_buffer(writes, 0, None);
        }
        let programs = &self.programs[usize::from(self.cell_data)];
        for part in &self.buffers.parts {
            let groups = [&part.group, &self.samples];
            self.columns
                .record(encoder, programs, &groups, self.cell_count);
        }
    }

    /// Records what makes every texel 0: copies of zeros, which drivers do fastest.
    fn clear(&self, encoder: &mut wgpu::CommandEncoder) {
        let size = self.texture.size();
        let row = (8 * size.width).next_multiple_of(256);
        let rows = (self.zeros.size() / u64::from(row)).min(u64::from(u32::MAX)) as u32;
        let layers = (rows / size.height).clamp(1, size.depth_or_array_layers);
        let rows = rows.min(size.height);
        let from = wgpu::TexelCopyBufferInfo {
            buffer: &self.zeros,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row),
                rows_per_image: Some(rows),
            },
        };
        for z in (0..size.depth_or_array_layers).step_by(layers as usize) {
            for y in (0..size.height).step_by(rows as usize) {
                let to = wgpu::TexelCopyTextureInfo {
                    origin: wgpu::Origin3d { x: 0, y, z },
                    ..self.texture.as_image_copy()
                };
                let part = wgpu::Extent3d {
                    width: size.width,
                    height: rows.min(size.height - y),
                    depth_or_array_layers: layers.min(size.depth_or_array_layers - z),
                };
                encoder.copy_buffer_to_texture(from, to, part);
            }
        }
    }

    /// Bytes of buffers, the mesh among them.
    pub(crate) fn bytes(&self) -> u64 {
        let b = &self.buffers;
        b.vertices.bytes()
            + b.cells.bytes()
            + b.cell_scalars.size()
            + b.lists.size()
            + self.zeros.size()
    }

    /// How often each sample was written.
    #[cfg(test)]
    pub(crate) fn writes(&self) -> &wgpu::Buffer {
        self.writes.as_ref().expect("made to be counted")
    }
}

impl Buffers {
    /// Buffers for so many vertices, cells and scalars of cells, or a little more than `old` has
    /// where that is not enough.
    fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        counts: &wgpu::Buffer,
        of_grid: &[Work],
        old: Option<&Buffers>,
        [vertices, cells, cell_scalars]: [usize; 3],
    ) -> Result<Buffers, Error> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = |label: &str, count: usize, bytes: usize, old: Option<&wgpu::Buffer>| {
            grown(gpu, label, (count, bytes), usage, old)
        };
        let vertices = Table::new(
            gpu,
            "resample::vertices",
            2 * vertices,
            old.map(|o| &o.vertices),
        )?;
        let lists = buffer("resample::lists", cells, 8, old.map(|o| &o.lists))?;
        let cells = Table::new(gpu, "resample::cells", cells, old.map(|o| &o.cells))?;
        let cell_scalars = buffer(
            "resample::cell scalars",
            cell_scalars,
            4,
            old.map(|o| &o.cell_scalars),
        )?;
        let part = |of_grid: &Work| -> Result<Part, Error> {
            let bytes = size_of::<Work>() as u64;
            let work = gpu.buffer("resample::work", bytes, usage)?;
            gpu.checked(LABEL, 0, || {
                let views = [&vertices, &cells].map(Table::view);
                let [vertices, cells] = &views;
                let resources = [
                    work.as_entire_binding(),
                    wgpu::BindingResource::TextureView(vertices),
                    wgpu::BindingResource::TextureView(cells),
                    cell_scalars.as_entire_binding(),
                    counts.as_entire_binding(),
                    lists.as_entire_binding(),
                ];
                Part {
                    group: group(gpu, LABEL, layout, &resources),
                    of_grid: *of_grid,
                    work,
                }
            })
        };
        let parts = of_grid.iter().map(part).collect::<Result<_, _>>()?;
        Ok(Buffers {
            vertices,
            cells,
            cell_scalars,
            lists,
            parts,
        })
    }

    fn fit(&self, [vertices, cells, cell_scalars]: [usize; 3]) -> bool {
        self.vertices.texels() >= 2 * vertices as u64
            && self.cells.texels() >= cells as u64
            && holds(&self.lists, (cells, 8))
            && holds(&self.cell_scalars, (cell_scalars, 4))
    }
}

/// The parts of a grid that are filled one by one, of at most [`COLUMN_SIDE`] samples along
/// each axis; nearly always one.
fn parts(lattice: &Lattice, tuning: Tuning) -> Vec<Work> {
    let along = along(lattice);
    let axes = [(along + 1) % 3, (along + 2) % 3, along];
    let dims = axes.map(|axis| lattice.dims[axis] as i32);
    let unit = |axis: usize| [0, 1, 2].map(|a| i32::from(a == axis));
    let [across_x, across_y, along] = axes.map(unit);
    let side = tuning.side as i32;
    let starts = |dim: i32| (0..dim).step_by(side as usize);
    let mut parts = Vec::new();
    for first in starts(dims[2]) {
        for y in starts(dims[1]) {
            for x in starts(dims[0]) {
                parts.push(Work {
                    low: [x, y],
                    high: [(x + side).min(dims[0]), (y + side).min(dims[1])],
                    first,
                    end: (first + side).min(dims[2]),
                    small: tuning.small,
                    along,
                    flipped: u32::from(lattice.linear().determinant() < 0.0),
                    across_x,
                    across_y,
                    ..Work::default()
                });
            }
        }
    }
    parts
}

/// The texture that is filled.
const SAMPLES: wgpu::BindingType = wgpu::BindingType::StorageTexture {
    access: wgpu::StorageTextureAccess::WriteOnly,
    format: wgpu::TextureFormat::Rg32Float,
    view_dimension: wgpu::TextureViewDimension::D3,
};
