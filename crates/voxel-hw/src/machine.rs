//! The machine that the paper proposes (sections 5.1 to 5.4): RealityEngine, with voxels.
//!
//! K. Akeley, "RealityEngine Graphics", SIGGRAPH 1993, is the machine without. A cell goes from the
//! host to a geometry engine, which classifies and sets up its triangles; these go over the
//! triangle bus to all fragment generators, each of which rasterizes its own pixels and
//! sends fragments to its own image engines, which keep the two frame- and z-buffers. Then the image
//! engines send back the pixels that the cell touched, and the fragment generators interpolate
//! between the two and write the voxels into their texture memories. When all cells are done the
//! texture memories are made alike.
//!
//! 1. [`config`] is the machine's numbers, each with its source.
//! 2. `interleave` says which engine has which pixel.
//! 3. `engines` counts what each engine does while the voxelizer runs; each fragment generator
//!    writes the voxels of its own pixels into a texture memory of its own.
//! 4. `merge` says what it takes to make texture memories alike.
//! 5. [`report`] is what was counted.
//! 6. [`sensitivity`] halves and doubles each assumption, and says which moves the answer most.
//!
//! # What this is
//! A deterministic count of events, weighed with cycles: neither queues nor memory banks are
//! simulated. Two times bound what a machine with these weights needs: one in which all stages
//! work at once without ever waiting, and one in which the image engines wait for all fragments of
//! a cell, and everything waits for them. The voxels are those of [`Voxelizer::voxelize`], to the
//! last bit, though each engine has made its own part alone.
//!
//! The paper "can only surmise" a performance (section 7), and most weights are our assumptions: they
//! are good for comparing variants of the machine, not for saying how fast it would have been.
//!
//! # What it says
//! With the default weights, 8 bits per voxel and one sample each:
//! - *Many small cells*: 148 955 tetrahedra into 128³ voxels take 29.8 million cycles, 0.6 s, in the
//!   geometry engines and 17.2 million on the triangle bus; fragment generators scan convert in 3.5
//!   million. 2³ samples per voxel take eight times as long, as every cell is sent again.
//! - *Few large cells*: 23 hexahedra into 96 × 96 × 128 voxels take 0.07 million cycles, and then
//!   0.75 million until all texture memories are alike, one texel of the bus per cycle; by way of the
//!   host it is 1.2 million.
//! - *Image engines* that voxelize need neither pixels sent back nor the fragment generators' time, but a
//!   column of 128 voxels of 8 bits beside both buffers is 1152 bits, and a pixel has 1024.
//! - *The interleaving* keeps fragment generators within a few percent of each other, also for small
//!   cells. That of image engines evens out over many cells.
//!
//! # Limits
//! Drawing the voxels (section 4) takes no time here.

pub mod config;
mod engines;
mod interleave;
mod merge;
pub mod report;
pub mod sensitivity;

use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh};

pub use config::{MachineConfig, Merge, PARAMETERS, Parameter, Source, Voxelizing};
pub use report::{Buses, Load, MachineReport, Stage};
pub use sensitivity::Sensitivity;

use crate::volume::VoxelVolume;
use crate::voxelizer::Voxelizer;
use engines::Engines;

impl Voxelizer {
    /// The voxels of `mesh` as a machine makes them, and what it did.
    ///
    /// # Errors
    /// As [`Voxelizer::voxelize`], and a machine that cannot be ([`MachineConfig`]).
    pub fn simulate(
        &self,
        mesh: &TetMesh,
        lattice: &Lattice,
        config: &MachineConfig,
    ) -> Result<(VoxelVolume, MachineReport), Error> {
        config.check()?;
        let mut engines = Engines::new(self, lattice, self.range(mesh), config)?;
        self.add_mesh(mesh, &mut engines)?;
        engines.finish(self)
    }
}
