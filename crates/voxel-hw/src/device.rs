//! The same on a graphics device: cells side by side, in compute shaders.

use bytemuck::cast_slice;
use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh};
use tetrascope_f32::domain::range_of_floats;
use tetrascope_gpu::columns::{self, LIST_BYTES, Programs};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::passes::{READ, UNIFORM, WRITE, group};
use tetrascope_gpu::pipelines::ComputeProgram;
use tetrascope_gpu::tables::{TABLE, Table, grown};
use tetrascope_gpu::wgpu::{self, BufferUsages, ShaderStages};
use tetrascope_gpu::{DeviceGrid, Gpu, sides};
use tetrascope_shaders::loops::COLUMN_CELL_PASSES;
use tetrascope_shaders::voxel_hw::{POLYHEDRA, RESOLVE, TETRAHEDRA, TETRAHEDRA_FLOAT};

use crate::NAME;
use crate::options::{Arithmetic, Cells, FirstVoxel, VoxelSize, VoxelizerOptions, voxel_count};
use crate::space::Space;
use crate::volume::VoxelVolume;
use crate::voxelizer::{AccumulationBuffer, Counts, Voxelizer};
use gpu_data::{Resolve, Work};
use snapped::{Snapped, parts, place_bits};

mod gpu_data;
mod snapped;
#[cfg(test)]
mod tests;

const LABEL: &str = "voxel-hw::voxelize";

/// Bytes of the accumulation buffer for each voxel.
const SUM_BYTES: u64 = 12;

/// Numbers of `tallies` in `put.wgsl`.
const TALLIES: usize = 4;

/// How work is divided, which changes nothing in the voxels; tests try other numbers.
#[derive(Clone, Copy, Debug)]
struct Tuning {
    /// Passes of loops that one invocation takes for a cell, at most [`COLUMN_CELL_PASSES`]; the
    /// pixels of larger cells are shared by workgroups, one for each invocation.
    small: u32,
    /// The most bytes of the accumulation buffer; volumes with more are voxelized in parts.
    part: u64,
    /// Whether areas are of 64 bits although 32 do.
    wide: bool,
}

/// The item of one invocation's work. The voxels do not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Items {
    /// A cell if that is little work, for the device at hand; else some of its pixels.
    #[default]
    Auto,
    /// A cell, unless that is more than an invocation may do.
    Cells,
    /// Pixels of a cell, which a workgroup shares.
    Pixels,
}

impl Tuning {
    fn new(gpu: &Gpu, items: Items) -> Tuning {
        let small = match items {
            Items::Pixels => 0,
            Items::Cells => COLUMN_CELL_PASSES,
            // One invocation after the other: the fewer idle ones the better.
            Items::Auto if gpu.is_software() => COLUMN_CELL_PASSES,
            // Thousands at once: none should be long.
            Items::Auto => 512,
        };
        Tuning {
            small,
            part: 1 << 28,
            wide: false,
        }
    }
}

/// Turns a mesh into voxels on the device.
///
/// The mesh may change at any time, its connectivity as well ([`DeviceVoxelizer::reload`]): each cell
/// is visited by itself, and nothing is found out beforehand.
#[derive(Debug)]
pub struct DeviceVoxelizer {
    gpu: Gpu,
    voxelizer: Voxelizer,
    tuning: Tuning,
    space: Space,
    grid: DeviceGrid,
    range: (f64, f64),
    layout: wgpu::BindGroupLayout,
    groups: Vec<wgpu::BindGroupLayout>,
    columns: columns::Columns,
    programs: Programs,
    resolve: wgpu::ComputePipeline,
    mesh: Mesh,
    sums: wgpu::Buffer,
    tallies: wgpu::Buffer,
    put: wgpu::BindGroup,
    parts: Vec<Part>,
}

/// Buffers that hold a mesh, which grow and never shrink.
#[derive(Debug)]
struct Mesh {
    vertices: Table,
    cells: Table,
    cell_scalars: wgpu::Buffer,
    triangles: Table,
    lists: wgpu::Buffer,
    group: wgpu::BindGroup,
    cell_count: u32,
}

/// Layers of the volume that fit into the accumulation buffer.
#[derive(Debug)]
struct Part {
    layers: (usize, usize),
    /// One for each offset.
    passes: Vec<Pass>,
    resolve: wgpu::Buffer,
    resolved: wgpu::BindGroup,
}

#[derive(Debug)]
struct Pass {
    of_grid: Work,
    work: wgpu::Buffer,
    group: wgpu::BindGroup,
}

impl DeviceVoxelizer {
    /// Compiles the passes and uploads `mesh`; [`DeviceVoxelizer::voxelize`] makes the voxels, whose
    /// centers are the samples of `lattice`.
    ///
    /// # Errors
    /// As [`Voxelizer::voxelize`]; a volume or a mesh that the device does not hold; arithmetic and
    /// cells that have no shaders.
    pub fn new(
        gpu: &Gpu,
        voxelizer: &Voxelizer,
        mesh: &TetMesh,
        lattice: &Lattice,
    ) -> Result<DeviceVoxelizer, Error> {
        DeviceVoxelizer::with_items(gpu, voxelizer, mesh, lattice, Items::Auto)
    }

    /// The same with another choice of what an invocation takes.
    ///
    /// # Errors
    /// As [`DeviceVoxelizer::new`].
    pub fn with_items(
        gpu: &Gpu,
        voxelizer: &Voxelizer,
        mesh: &TetMesh,
        lattice: &Lattice,
        items: Items,
    ) -> Result<DeviceVoxelizer, Error> {
        DeviceVoxelizer::tuned(gpu, voxelizer, mesh, lattice, Tuning::new(gpu, items))
    }

    fn tuned(
        gpu: &Gpu,
        voxelizer: &Voxelizer,
        mesh: &TetMesh,
        lattice: &Lattice,
        tuning: Tuning,
    ) -> Result<DeviceVoxelizer, Error> {
        lattice.validate()?;
        voxel_count(lattice.dims)?;
        let range = voxelizer.range(mesh);
        let space = Space::new(lattice, voxelizer.options().columns);
        let kind = voxelizer.options().cells;
        check(voxelizer.options())?;
        let snapped = Snapped::new(mesh, voxelizer.options(), &space, range)?;
        let grid = DeviceGrid::new(gpu, lattice, Texels::Covered, Some(range_of_floats(range)))?;

        let compute = ShaderStages::COMPUTE;
        let layout = gpu.layout(LABEL, compute, &[TABLE, TABLE, READ, TABLE, WRITE, WRITE])?;
        let put_layout = gpu.layout(LABEL, compute, &[WRITE, WRITE])?;
        let work_layout = gpu.layout(LABEL, compute, &[READ])?;
        let resolve_layout = gpu.layout(LABEL, compute, &[UNIFORM, READ, SAMPLES])?;
        let resolve = gpu.compute_pipeline(&ComputeProgram {
            label: LABEL,
            source: RESOLVE,
            entry: Some("cs_resolve"),
            constants: vec![],
            groups: vec![resolve_layout.clone()],
        })?;
        let columns = columns::Columns::new(gpu)?;

        let [nx, ny, nz] = space.dims();
        let layer = SUM_BYTES * (nx * ny) as u64;
        let limits = gpu.limits();
        let most = tuning.part.min(limits.max_storage_buffer_binding_size);
        let depth = ((most / layer) as usize).clamp(1, nz);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let sums = gpu.buffer("voxel-hw::sums", layer * depth as u64, usage)?;
        let tallies = gpu.buffer("voxel-hw::tallies", 4 * TALLIES as u64, usage)?;
        let put = gpu.checked(LABEL, 0, || {
            let resources = [&sums, &tallies].map(|b| b.as_entire_binding());
            group(gpu, LABEL, &put_layout, &resources)
        })?;

        let offsets = voxelizer.offsets().iter();
        let bits = place_bits(voxelizer.options().arithmetic);
        let offsets: Vec<[i32; 3]> = offsets.map(|o| parts(space.turn(*o), bits)).collect();
        let part = |first: usize| -> Result<Part, Error> {
            let end = (first + depth).min(nz);
            let pass = |(index, offset): (usize, &[i32; 3])| -> Result<Pass, Error> {
                let of_grid = Work {
                    dims: space.dims().map(|d| d as i32),
                    offset: *offset,
                    first: first as i32,
                    end: end as i32,
                    small: tuning.small,
                    flipped: u32::from(lattice.direction.determinant() < 0.0),
                    is_first: u32::from(first == 0 && index == 0),
                    ..Work::default()
                };
                let work = gpu.upload("voxel-hw::work", &[of_grid], BufferUsages::STORAGE)?;
                let group = gpu.checked(LABEL, 0, || {
                    group(gpu, LABEL, &work_layout, &[work.as_entire_binding()])
                })?;
                Ok(Pass {
                    of_grid,
                    work,
                    group,
                })
            };
            let bytes = size_of::<Resolve>() as u64;
            let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
            let resolve = gpu.buffer("voxel-hw::resolve", bytes, usage)?;
            let resolved = gpu.checked(LABEL, 0, || {
                let view = grid.texture().create_view(&Default::default());
                let resources = [
                    resolve.as_entire_binding(),
                    sums.as_entire_binding(),
                    wgpu::BindingResource::TextureView(&view),
                ];
                group(gpu, LABEL, &resolve_layout, &resources)
            })?;
            Ok(Part {
                layers: (first, end),
                passes: offsets
                    .iter()
                    .enumerate()
                    .map(pass)
                    .collect::<Result<_, _>>()?,
                resolve,
                resolved,
            })
        };
        let parts = (0..nz).step_by(depth).map(part).collect::<Result<_, _>>()?;

        let groups = vec![layout.clone(), put_layout, work_layout];
        let of = (groups.as_slice(), voxelizer, tuning);
        let programs = programs(gpu, of, &snapped)?;
        let mesh = Mesh::new(
            gpu,
            &layout,
            &columns,
            None,
            &snapped,
            snapped.cells(mesh, kind),
        )?;
        let made = DeviceVoxelizer {
            gpu: gpu.clone(),
            voxelizer: voxelizer.clone(),
            tuning,
            space,
            grid,
            range,
            layout,
            groups,
            columns,
            programs,
            resolve,
            mesh,
            sums,
            tallies,
            put,
            parts,
        };
        made.write_numbers()?;
        Ok(made)
    }

    /// Uploads another mesh, whatever it has in common with the one before. Buffers are used again
    /// unless they are too small.
    ///
    /// # Errors
    /// As [`DeviceVoxelizer::new`].
    pub fn reload(&mut self, mesh: &TetMesh) -> Result<(), Error> {
        let lattice = *self.grid.lattice();
        self.reload_on(mesh, &lattice)
    }

    /// The same for voxels in other places. The texture is the same where there are as many along each
    /// axis.
    ///
    /// # Errors
    /// As [`DeviceVoxelizer::new`].
    pub fn reload_on(&mut self, mesh: &TetMesh, lattice: &Lattice) -> Result<(), Error> {
        lattice.validate()?;
        let shape = |lattice: &Lattice| (lattice.dims, lattice.direction.determinant() < 0.0);
        if shape(lattice) != shape(self.grid.lattice()) {
            let (gpu, voxelizer) = (&self.gpu, &self.voxelizer);
            *self = DeviceVoxelizer::tuned(gpu, voxelizer, mesh, lattice, self.tuning)?;
            return Ok(());
        }
        let space = Space::new(lattice, self.voxelizer.options().columns);
        let range = self.voxelizer.range(mesh);
        let kind = self.voxelizer.options().cells;
        let snapped = Snapped::new(mesh, self.voxelizer.options(), &space, range)?;
        let texture = self.grid.texture().clone();
        let of_floats = Some(range_of_floats(range));
        let grid = DeviceGrid::from_texture(texture, lattice, Texels::Covered, of_floats)?;
        let gpu = &self.gpu;
        let of = (self.groups.as_slice(), &self.voxelizer, self.tuning);
        let programs = programs(gpu, of, &snapped)?;
        let (layout, columns, old) = (&self.layout, &self.columns, Some(&self.mesh));
        let mesh = Mesh::new(
            gpu,
            layout,
            columns,
            old,
            &snapped,
            snapped.cells(mesh, kind),
        )?;
        self.mesh = mesh;
        self.space = space;
        self.programs = programs;
        self.grid = grid;
        self.range = range;
        self.write_numbers()
    }

    /// Writes what depends on the number of cells and on their range.
    fn write_numbers(&self) -> Result<(), Error> {
        let [nx, ny, _] = self.space.dims();
        let axes = self.space.axes();
        let unit = |of: usize| [0, 1, 2].map(|axis| u32::from(axis == axes[of]));
        let (low, high) = self.range;
        let resolve = Resolve {
            low: low as f32,
            high: high as f32,
            steps: match self.voxelizer.options().voxel_size {
                VoxelSize::Bits8 => 255.0,
                VoxelSize::Bits16 => 65535.0,
                // Finer than samples are.
                VoxelSize::Bits32 | VoxelSize::Float => 0.0,
            },
            samples: self.voxelizer.offsets().len() as f32,
            across_x: unit(0),
            across_y: unit(1),
            along: unit(2),
            ..Resolve::default()
        };
        for part in &self.parts {
            let (first, end) = part.layers;
            let resolve = Resolve {
                dims: [nx, ny, end - first].map(|d| d as u32),
                first: first as u32,
                ..resolve
            };
            self.gpu.write(LABEL, &part.resolve, &[resolve])?;
            for pass in &part.passes {
                let work = Work {
                    cell_count: self.mesh.cell_count,
                    ..pass.of_grid
                };
                self.gpu.write(LABEL, &pass.work, &[work])?;
            }
        }
        Ok(())
    }

    /// Records the passes that make the voxels; the caller submits.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        for part in &self.parts {
            self.encode_part(encoder, part);
        }
    }

    fn encode_part(&self, encoder: &mut wgpu::CommandEncoder, part: &Part) {
        encoder.clear_buffer(&self.sums, 0, None);
        if part.layers.0 == 0 {
            encoder.clear_buffer(&self.tallies, 0, None);
        }
        for pass in &part.passes {
            let groups = [&self.mesh.group, &self.put, &pass.group];
            self.columns
                .record(encoder, &self.programs, &groups, self.mesh.cell_count);
        }
        let [nx, ny, _] = self.space.dims();
        let (first, end) = part.layers;
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("voxel-hw::resolve"),
            timestamp_writes: None,
        });
        pass.set_pipeline(&self.resolve);
        pass.set_bind_group(0, &part.resolved, &[]);
        pass.dispatch_workgroups(nx.div_ceil(64) as u32, ny as u32, (end - first) as u32);
    }

    /// Makes the voxels, and waits until they are there.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn voxelize(&self) -> Result<(), Error> {
        let mut encoder = self.encoder();
        self.encode(&mut encoder);
        self.gpu.finish(encoder)
    }

    /// The voxels as a texture: a scalar in the field's unit, and the share of samples in the mesh.
    /// Clones share the texture, and see what is voxelized later.
    pub fn grid(&self) -> &DeviceGrid {
        &self.grid
    }

    /// Makes the voxels and reads them back: to the last bit those of [`Voxelizer::voxelize`]. Of its
    /// counts those of cells are known, and how many voxels were written.
    ///
    /// # Errors
    /// Errors of the device, and a lack of memory.
    pub fn voxels(&self) -> Result<VoxelVolume, Error> {
        let [nx, ny, _] = self.space.dims();
        let mut buffer = AccumulationBuffer::new(self.space, self.range)?;
        let mut writes = 0;
        for part in &self.parts {
            let (first, end) = part.layers;
            let layer = nx * ny;
            let mut encoder = self.encoder();
            self.encode_part(&mut encoder, part);
            let bytes = SUM_BYTES * (layer * (end - first)) as u64;
            let copy = read_back(&self.gpu, &mut encoder, Source::Buffer(&self.sums, bytes))?;
            self.gpu.finish(encoder)?;
            let sums: Vec<[u32; 3]> = copy.read()?;
            for (index, [low, high, count]) in sums.into_iter().enumerate() {
                let sum = u64::from(high) << 32 | u64::from(low);
                let at = [index % nx, index / nx % ny, first + index / layer];
                buffer.add(self.space.index(at.map(|i| i as i32)), sum, count);
                writes += u64::from(count);
            }
        }
        let mut encoder = self.encoder();
        let tallies = Source::Buffer(&self.tallies, self.tallies.size());
        let copy = read_back(&self.gpu, &mut encoder, tallies)?;
        self.gpu.finish(encoder)?;
        let tallies: Vec<u32> = copy.read()?;
        buffer.count(Counts {
            cells: self.mesh.cell_count.into(),
            outside: tallies[0].into(),
            without_value: tallies[1].into(),
            degenerate: tallies[2].into(),
            inverted: tallies[3].into(),
            writes,
            ..Counts::default()
        });
        buffer.finish(&self.voxelizer)
    }

    fn encoder(&self) -> wgpu::CommandEncoder {
        let device = self.gpu.device();
        device.create_command_encoder(&Default::default())
    }

    /// Bytes on the device beside the grid's: the mesh, and the accumulation buffer.
    pub fn bytes(&self) -> u64 {
        let mesh = &self.mesh;
        mesh.vertices.bytes()
            + mesh.cells.bytes()
            + mesh.triangles.bytes()
            + mesh.cell_scalars.size()
            + mesh.lists.size()
            + self.sums.size()
    }
}

/// The texture that is filled.
const SAMPLES: wgpu::BindingType = wgpu::BindingType::StorageTexture {
    access: wgpu::StorageTextureAccess::WriteOnly,
    format: wgpu::TextureFormat::Rg32Float,
    view_dimension: wgpu::TextureViewDimension::D3,
};

/// Refuses what has no shaders.
pub(crate) fn check(options: &VoxelizerOptions) -> Result<(), Error> {
    match (options.arithmetic, options.cells) {
        (Arithmetic::Float, Cells::AsGiven) => Err(Error::Unsupported {
            renderer: NAME,
            what: "cells as they are, in floats, on a device".into(),
            reason: "floats are for tetrahedra there, and integers for all cells".into(),
        }),
        _ => Ok(()),
    }
}

/// Programs for the numbers of `snapped`.
fn programs(
    gpu: &Gpu,
    (groups, voxelizer, tuning): (&[wgpu::BindGroupLayout], &Voxelizer, Tuning),
    snapped: &Snapped,
) -> Result<Programs, Error> {
    let options = voxelizer.options();
    let yes = |yes: bool| f64::from(u8::from(yes));
    let mut constants = vec![
        ("CELL_DATA", yes(!snapped.cell_scalars.is_empty())),
        ("ROUNDED", yes(options.first_voxel == FirstVoxel::Rounded)),
        ("PLACE_BITS", place_bits(options.arithmetic).into()),
    ];
    let source = match (options.arithmetic, options.cells) {
        (Arithmetic::Float, _) => {
            constants.push(sides::constant(gpu)?);
            TETRAHEDRA_FLOAT
        }
        (Arithmetic::FixedPoint, cells) => {
            constants.push(("WIDE", yes(snapped.is_wide || tuning.wide)));
            match cells {
                Cells::Tetrahedra => TETRAHEDRA,
                Cells::AsGiven => POLYHEDRA,
            }
        }
    };
    Programs::new(
        gpu,
        &ComputeProgram {
            label: LABEL,
            source,
            entry: None,
            constants,
            groups: groups.to_vec(),
        },
    )
}

impl Mesh {
    /// Uploads a mesh, into the buffers of `old` where they have the room.
    fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        columns: &columns::Columns,
        old: Option<&Mesh>,
        snapped: &Snapped,
        cells: &[[u32; 4]],
    ) -> Result<Mesh, Error> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let buffer = |label: &str, count: usize, bytes: usize, old: Option<&wgpu::Buffer>| {
            grown(gpu, label, (count, bytes), usage, old)
        };
        let (points, cell_count) = (snapped.vertices.len(), cells.len());
        let vertices = Table::new(gpu, "voxel-hw::vertices", points, old.map(|o| &o.vertices))?;
        let table = Table::new(gpu, "voxel-hw::cells", cell_count, old.map(|o| &o.cells))?;
        let triangles = Table::new(
            gpu,
            "voxel-hw::triangles",
            snapped.triangles.len(),
            old.map(|o| &o.triangles),
        )?;
        let lists = buffer(
            "voxel-hw::lists",
            cell_count,
            LIST_BYTES,
            old.map(|o| &o.lists),
        )?;
        let scalars = buffer(
            "voxel-hw::cell scalars",
            snapped.cell_scalars.len(),
            4,
            old.map(|o| &o.cell_scalars),
        )?;
        let group = gpu.checked(LABEL, 0, || {
            let views = [&vertices, &table, &triangles].map(Table::view);
            let [of_vertices, of_cells, of_triangles] = &views;
            let resources = [
                wgpu::BindingResource::TextureView(of_vertices),
                wgpu::BindingResource::TextureView(of_cells),
                scalars.as_entire_binding(),
                wgpu::BindingResource::TextureView(of_triangles),
                columns.counts().as_entire_binding(),
                lists.as_entire_binding(),
            ];
            group(gpu, LABEL, layout, &resources)
        })?;
        vertices.write(gpu, cast_slice(&snapped.vertices))?;
        table.write(gpu, cast_slice(cells))?;
        triangles.write(gpu, cast_slice(&snapped.triangles))?;
        gpu.write(LABEL, &scalars, &snapped.cell_scalars)?;
        Ok(Mesh {
            vertices,
            cells: table,
            triangles,
            cell_scalars: scalars,
            lists,
            group,
            cell_count: cell_count as u32,
        })
    }
}
