//! `voxelize_all_cells` and `voxel_accumulation_buffer` (sections 2.2 and 3.1).

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh, TransferFunction, is_value, number};

use crate::cell::{Buffers, Events, Fill, Side};
use crate::face::{Number, VALUE_BITS};
use crate::options::{Arithmetic, VoxelizerOptions, voxel_count};
use crate::source::{Polyhedron, Prepared, ToVoxels, for_each_cell, prepare};
use crate::space::Space;
use crate::volume::{ColorVolume, VoxelVolume};

/// Turns meshes into voxels.
#[derive(Clone, Debug)]
pub struct Voxelizer {
    options: VoxelizerOptions,
    offsets: Vec<DVec3>,
}

/// Counts of the work, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Cells that were visited, each once.
    pub cells: u64,
    /// Those that cannot reach a voxel.
    pub outside: u64,
    /// Cells with a scalar that is not a value.
    pub without_value: u64,
    /// Those without volume, as they are or once snapped.
    pub degenerate: u64,
    /// Those that snapping or rounding turned inside out. They are left out, and where their
    /// neighbors overlap in their place voxels are written twice.
    pub inverted: u64,
    /// Triangles that were scan converted, for all offsets together, as all that follow.
    pub faces: u64,
    /// Pixels of these triangles.
    pub fragments: u64,
    /// Pixels at which a cell's buffers were read.
    pub columns: u64,
    /// Voxels that were written.
    pub writes: u64,
}

impl Voxelizer {
    /// A voxelizer with these options.
    ///
    /// # Errors
    /// Those of [`Offsets::points`](crate::Offsets::points), and an invalid scalar range.
    pub fn new(options: VoxelizerOptions) -> Result<Voxelizer, Error> {
        if let Some((low, high)) = options.scalar_range
            && !(is_value(low) && is_value(high) && low <= high)
        {
            return Err(Error::Invalid {
                what: format!("a scalar range of {}", number::range((low, high))),
                help: Some("give two numbers, the lower one first".into()),
            });
        }
        Ok(Voxelizer {
            offsets: options.offsets.points()?,
            options,
        })
    }

    /// The options.
    pub fn options(&self) -> &VoxelizerOptions {
        &self.options
    }

    /// The offsets of the samples of a voxel from its center, in voxels.
    pub fn offsets(&self) -> &[DVec3] {
        &self.offsets
    }

    /// The voxels of `mesh` whose centers are the samples of `lattice`.
    ///
    /// A voxel's scalar is the mean over the samples in it that are in the mesh, its coverage
    /// their share.
    ///
    /// # Errors
    /// A lattice without voxels or with too many, and more memory than there is;
    /// [`Cells::AsGiven`](crate::Cells::AsGiven) of a mesh that did not keep its cells; with
    /// [`Arithmetic::FixedPoint`], a cell more than [`MOST_SIDE`](crate::MOST_SIDE) voxels wide.
    pub fn voxelize(&self, mesh: &TetMesh, lattice: &Lattice) -> Result<VoxelVolume, Error> {
        let space = Space::new(lattice, self.options.columns);
        let mut buffer = AccumulationBuffer::new(space, self.range(mesh))?;
        self.add_mesh(mesh, &mut buffer)?;
        buffer.finish(self)
    }

    /// The same with the transfer function before the mean, as the paper's pseudo code has it:
    /// emission and extinction are averaged over all samples of a voxel, and are 0 where there
    /// is not a cell. For the order "mean first" see [`VoxelVolume::classify`].
    ///
    /// # Errors
    /// As [`Voxelizer::voxelize`].
    pub fn voxelize_colors(
        &self,
        mesh: &TetMesh,
        lattice: &Lattice,
        transfer_function: &TransferFunction,
    ) -> Result<ColorVolume, Error> {
        let space = Space::new(lattice, self.options.columns);
        let mut buffer = ColorBuffer::new(space, self.range(mesh), transfer_function)?;
        self.add_mesh(mesh, &mut buffer)?;
        buffer.finish(self.offsets.len())
    }

    /// The range whose ends are the least and the greatest scalar that voxels hold.
    pub(crate) fn range(&self, mesh: &TetMesh) -> (f64, f64) {
        let range = self.options.scalar_range.or(mesh.scalar_range());
        range.unwrap_or((0.0, 0.0))
    }

    pub(crate) fn add_mesh(&self, mesh: &TetMesh, target: &mut impl Target) -> Result<(), Error> {
        match self.options.arithmetic {
            Arithmetic::FixedPoint => self.add_cells::<i32>(mesh, target),
            Arithmetic::Float => self.add_cells::<f64>(mesh, target),
        }
    }

    fn add_cells<N: Number>(&self, mesh: &TetMesh, target: &mut impl Target) -> Result<(), Error> {
        let mut buffers = Buffers::<N>::default();
        let to_voxels = ToVoxels::new(&target.space().turned());
        for_each_cell(mesh, self.options.cells, &to_voxels, |index, polyhedron| {
            self.add_cell(index, polyhedron, &mut buffers, target)
        })
    }

    /// Voxelizes one cell for each offset: it is the cell that moves, so a sample is taken on the
    /// other side of the voxel's center, which is among the offsets as well.
    pub(crate) fn add_cell<N: Number>(
        &self,
        index: usize,
        polyhedron: &Polyhedron,
        buffers: &mut Buffers<N>,
        target: &mut impl Target,
    ) -> Result<(), Error> {
        let (space, range) = (*target.space(), target.range());
        let dims = space.dims();
        let prepared = prepare(index, polyhedron, range, dims, self.options.arithmetic)?;
        target.cell(polyhedron.corners.len(), polyhedron.faces.len());
        let counts = target.counts();
        counts.cells += 1;
        let cell = match prepared {
            Prepared::Cell(cell) => cell,
            Prepared::Outside => {
                counts.outside += 1;
                return Ok(());
            }
            Prepared::WithoutValue => {
                counts.without_value += 1;
                return Ok(());
            }
            Prepared::Degenerate => {
                counts.degenerate += 1;
                return Ok(());
            }
            Prepared::Inverted => {
                counts.inverted += 1;
                return Ok(());
            }
        };
        let into = Fill {
            dims: dims.map(|d| d as i32),
            first_voxel: self.options.first_voxel,
        };
        for offset in &self.offsets {
            buffers.voxelize(&cell, space.turn(*offset), into, target);
        }
        Ok(())
    }
}

/// Where voxels are written.
pub(crate) trait Target: Events {
    fn space(&self) -> &Space;
    fn range(&self) -> (f64, f64);
    fn counts(&mut self) -> &mut Counts;
}

/// The accumulation volume buffer: sums, and how many numbers they are of.
///
/// Integers, so that the order of cells does not matter.
#[derive(Debug)]
pub(crate) struct AccumulationBuffer {
    space: Space,
    range: (f64, f64),
    sums: Vec<u64>,
    writes: Vec<u32>,
    counts: Counts,
}

impl AccumulationBuffer {
    pub(crate) fn new(space: Space, range: (f64, f64)) -> Result<AccumulationBuffer, Error> {
        space.lattice().validate()?;
        let count = voxel_count(space.dims())?;
        Ok(AccumulationBuffer {
            space,
            range,
            sums: zeros(count)?,
            writes: zeros(count)?,
            counts: Counts::default(),
        })
    }

    /// Adds what was summed elsewhere to voxel `index`.
    pub(crate) fn add(&mut self, index: usize, sum: u64, writes: u32) {
        self.sums[index] += sum;
        self.writes[index] += writes;
    }

    /// Adds counts of the work.
    #[cfg(feature = "gpu")]
    pub(crate) fn count(&mut self, counts: Counts) {
        self.counts = counts;
    }

    pub(crate) fn finish(self, voxelizer: &Voxelizer) -> Result<VoxelVolume, Error> {
        VoxelVolume::new(
            *self.space.lattice(),
            self.range,
            voxelizer,
            &self.sums,
            self.writes,
            self.counts,
        )
    }
}

impl Target for AccumulationBuffer {
    fn space(&self) -> &Space {
        &self.space
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }

    fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }
}

impl Events for AccumulationBuffer {
    fn face(&mut self, _: Side) {
        self.counts.faces += 1;
    }

    fn fragment(&mut self, _: Side, _: (i32, i32)) {
        self.counts.fragments += 1;
    }

    fn column(&mut self, _: (i32, i32), voxels: u32) {
        self.counts.columns += 1;
        self.counts.writes += u64::from(voxels);
    }

    fn voxel(&mut self, at: [i32; 3], scalar: u32) {
        let index = self.space.index(at);
        self.sums[index] += u64::from(scalar);
        self.writes[index] += 1;
    }
}

/// The same for colors, in f64.
#[derive(Debug)]
struct ColorBuffer<'a> {
    space: Space,
    range: (f64, f64),
    transfer_function: &'a TransferFunction,
    sums: Vec<[f64; 4]>,
    writes: Vec<u32>,
    counts: Counts,
}

impl<'a> ColorBuffer<'a> {
    fn new(
        space: Space,
        range: (f64, f64),
        transfer_function: &'a TransferFunction,
    ) -> Result<ColorBuffer<'a>, Error> {
        space.lattice().validate()?;
        let count = voxel_count(space.dims())?;
        Ok(ColorBuffer {
            space,
            range,
            transfer_function,
            sums: zeros(count)?,
            writes: zeros(count)?,
            counts: Counts::default(),
        })
    }

    fn finish(self, samples: usize) -> Result<ColorVolume, Error> {
        let mut voxels = zeros(self.sums.len())?;
        for ((voxel, sum), writes) in voxels.iter_mut().zip(&self.sums).zip(&self.writes) {
            // Cells that overlap count as one.
            let samples = f64::from(*writes).max(samples as f64);
            *voxel = sum.map(|s| (s / samples) as f32);
        }
        Ok(ColorVolume::new(*self.space.lattice(), voxels, self.counts))
    }
}

impl Target for ColorBuffer<'_> {
    fn space(&self) -> &Space {
        &self.space
    }

    fn range(&self) -> (f64, f64) {
        self.range
    }

    fn counts(&mut self) -> &mut Counts {
        &mut self.counts
    }
}

impl Events for ColorBuffer<'_> {
    fn face(&mut self, _: Side) {
        self.counts.faces += 1;
    }

    fn fragment(&mut self, _: Side, _: (i32, i32)) {
        self.counts.fragments += 1;
    }

    fn column(&mut self, _: (i32, i32), voxels: u32) {
        self.counts.columns += 1;
        self.counts.writes += u64::from(voxels);
    }

    fn voxel(&mut self, at: [i32; 3], scalar: u32) {
        let scalar = in_range(self.range, f64::from(scalar));
        let emitted = emitted(self.transfer_function, scalar);
        let index = self.space.index(at);
        for (sum, value) in self.sums[index].iter_mut().zip(emitted) {
            *sum += value;
        }
        self.writes[index] += 1;
    }
}

/// A scalar in units of 2^−[`VALUE_BITS`] of `range`, in the field's unit.
pub(crate) fn in_range((low, high): (f64, f64), scalar: f64) -> f64 {
    low + (high - low) * (scalar / f64::from(1 << VALUE_BITS))
}

/// Color times extinction, and extinction.
pub(crate) fn emitted(transfer_function: &TransferFunction, scalar: f64) -> [f64; 4] {
    let Some((color, extinction)) = transfer_function.sample(scalar) else {
        return [0.0; 4];
    };
    let [r, g, b] = (color * extinction).to_array();
    [r, g, b, extinction]
}

/// Zeros, or an error where there is no memory for them.
pub(crate) fn zeros<T: Copy + Default>(count: usize) -> Result<Vec<T>, Error> {
    let mut zeros = Vec::new();
    match zeros.try_reserve_exact(count) {
        Ok(()) => zeros.resize(count, T::default()),
        Err(_) => {
            return Err(Error::NoMemory {
                what: format!("a voxel volume of {count} voxels"),
                bytes: (count * size_of::<T>()) as u64,
            });
        }
    }
    Ok(zeros)
}
