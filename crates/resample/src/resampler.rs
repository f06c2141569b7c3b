//! A mesh and the grid of its samples.

use tetrascope_core::grid::{Lattice, Samples};
use tetrascope_core::{Error, Grid, TetMesh};
use tetrascope_gpu::device_grid::Texels;
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::{DeviceGrid, Gpu, wgpu};

use crate::direct::{Direct, Tuning};
use crate::options::{Outside, Passes, ResamplerOptions};
use crate::placed::{Placed, along};
use crate::slabs::Drawn;
use crate::textured::Textured;

/// Takes samples of a mesh at the points of a lattice, on the device.
///
/// The mesh may change at any time, its connectivity as well ([`Resampler::reload`]); nothing
/// is kept of the old one, and nothing is found out about it beforehand.
#[derive(Debug)]
pub struct Resampler {
    gpu: Gpu,
    options: ResamplerOptions,
    tuning: Tuning,
    grid: DeviceGrid,
    way: Way,
}

/// The passes that take the samples.
#[derive(Debug)]
enum Way {
    Direct(Box<Direct>),
    Textured(Box<Textured>),
}

impl Way {
    /// The axis of the lattice along which columns run, or slices follow each other.
    fn axis(passes: Passes, lattice: &Lattice) -> usize {
        match passes {
            Passes::Direct => along(lattice),
            Passes::Two | Passes::One => 2,
        }
    }
}

impl Resampler {
    /// Compiles the passes and uploads `mesh`; [`Resampler::resample`] takes the samples.
    ///
    /// # Errors
    /// Refusals of [`Lattice::validate`], a grid or a mesh that the device does not hold, a
    /// mesh without volume, and one that is 2³¹ samples or more away; options out of range.
    pub fn new(
        gpu: &Gpu,
        mesh: &TetMesh,
        lattice: &Lattice,
        options: &ResamplerOptions,
    ) -> Result<Resampler, Error> {
        Resampler::tuned(gpu, mesh, lattice, options, Tuning::new(gpu))
    }

    fn tuned(
        gpu: &Gpu,
        mesh: &TetMesh,
        lattice: &Lattice,
        options: &ResamplerOptions,
        tuning: Tuning,
    ) -> Result<Resampler, Error> {
        options.validate()?;
        lattice.validate()?;
        let placed = Placed::new(mesh, lattice, Way::axis(options.passes, lattice))?;
        let grid = DeviceGrid::new(gpu, lattice, Texels::Covered, placed.scalar_range)?;
        let cells = mesh.tetrahedra();
        let way = match options.passes {
            Passes::Direct => Way::Direct(Direct::new(gpu, &grid, &placed, cells, tuning)?.into()),
            Passes::Two | Passes::One => {
                Way::Textured(Textured::new(gpu, &grid, &placed, cells, options, tuning)?.into())
            }
        };
        Ok(Resampler {
            gpu: gpu.clone(),
            options: *options,
            tuning,
            grid,
            way,
        })
    }

    /// Uploads another mesh, whatever it has in common with the one before. The buffers are
    /// used again unless they are too small.
    ///
    /// # Errors
    /// As for [`Resampler::new`]; then the mesh before stays.
    pub fn reload(&mut self, mesh: &TetMesh) -> Result<(), Error> {
        let lattice = *self.grid.lattice();
        self.reload_on(mesh, &lattice)
    }

    /// The same for samples at the points of another lattice. The texture is the same where there
    /// are as many samples along each axis.
    ///
    /// # Errors
    /// As for [`Resampler::new`]; then the mesh and the lattice before stay.
    pub fn reload_on(&mut self, mesh: &TetMesh, lattice: &Lattice) -> Result<(), Error> {
        lattice.validate()?;
        let shape = |lattice: &Lattice| (lattice.dims, lattice.linear().determinant() < 0.0);
        if shape(lattice) != shape(self.grid.lattice()) {
            let (gpu, options) = (&self.gpu, &self.options);
            *self = Resampler::tuned(gpu, mesh, lattice, options, self.tuning)?;
            return Ok(());
        }
        let axis = Way::axis(self.options.passes, lattice);
        let placed = Placed::new(mesh, lattice, axis)?;
        let texture = self.grid.texture().clone();
        let range = placed.scalar_range;
        let grid = DeviceGrid::from_texture(texture, lattice, Texels::Covered, range)?;
        match &mut self.way {
            Way::Direct(direct) => direct.upload(&placed, mesh.tetrahedra())?,
            Way::Textured(textured) => textured.upload(&placed, mesh.tetrahedra())?,
        }
        self.grid = grid;
        Ok(())
    }

    /// Records the passes that take the samples; the caller submits. Whatever the grid held
    /// before is cleared.
    pub fn encode(&self, encoder: &mut wgpu::CommandEncoder) {
        match &self.way {
            Way::Direct(direct) => direct.record(encoder),
            Way::Textured(textured) => textured.record(encoder),
        }
    }

    /// Takes the samples, and waits until they are there.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn resample(&self) -> Result<(), Error> {
        let mut encoder = self
            .gpu
            .device()
            .create_command_encoder(&Default::default());
        self.encode(&mut encoder);
        self.gpu.finish(encoder)
    }

    /// The samples: a coverage of 1 inside of the mesh and 0 outside, and scalars in the
    /// field's unit. Clones share the texture, and see what is resampled later; after
    /// [`Resampler::reload`] only this knows the range of the new scalars.
    pub fn grid(&self) -> &DeviceGrid {
        &self.grid
    }

    /// The samples, read back after [`Resampler::resample`].
    ///
    /// # Errors
    /// Errors of the device.
    pub fn read_back(&self, outside: Outside) -> Result<Grid, Error> {
        let mut encoder = self
            .gpu
            .device()
            .create_command_encoder(&Default::default());
        let source = Source::Texture(self.grid.texture());
        let copy = read_back(&self.gpu, &mut encoder, source)?;
        self.gpu.finish(encoder)?;
        let texels: Vec<[f32; 2]> = copy.read()?;
        let lattice = *self.grid.lattice();
        match outside {
            Outside::Nan => {
                let scalar = |[scalar, coverage]: [f32; 2]| match coverage {
                    0.0 => f32::NAN,
                    _ => scalar,
                };
                let scalars = texels.into_iter().map(scalar);
                Grid::on(lattice, Samples::F32(scalars.collect()))
            }
            Outside::Uncovered => {
                let scalars = texels.iter().map(|t| t[0]).collect();
                let coverage = texels.iter().map(|t| t[1]).collect();
                Grid::on(lattice, Samples::F32(scalars))?.covered(coverage)
            }
        }
    }

    /// How much was drawn by the last [`Resampler::resample`]; `None` for [`Passes::Direct`], which
    /// draws nothing.
    ///
    /// # Errors
    /// Errors of the device.
    pub fn drawn(&self) -> Result<Option<Drawn>, Error> {
        match &self.way {
            Way::Direct(_) => Ok(None),
            Way::Textured(textured) => textured.drawn().map(Some),
        }
    }

    /// Bytes on the device beside the grid's: the mesh, and 8 for each cell to work with, or 52
    /// and two slices or three where cells are drawn.
    pub fn bytes(&self) -> u64 {
        match &self.way {
            Way::Direct(direct) => direct.bytes(),
            Way::Textured(textured) => textured.bytes(),
        }
    }
}

#[cfg(test)]
mod tests;
