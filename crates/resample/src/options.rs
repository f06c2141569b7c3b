//! How samples are taken, and how they are drawn.

use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, Settings, TetMesh};
use tetrascope_slicing::SlicingOptions;

use crate::ENTRY;

/// The fewest samples along the longest axis of a mesh that are drawn.
pub const MIN_SAMPLES: usize = 2;

/// The most: 64 GiB on the device, if the others are as long.
pub const MAX_SAMPLES: usize = 2048;

/// How the samples in a cell are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Passes {
    /// The part of each column of samples that is in the cell, computed: neither triangles nor
    /// weight textures, and no error but that of rounding.
    #[default]
    Direct,
}

tetrascope_core::choices! {
    Passes: "direct" = Direct;
}

/// Options of [`Resampler`](crate::Resampler).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct ResamplerOptions {
    /// How the samples in a cell are found.
    pub passes: Passes,
}

/// What stands for a sample outside of the mesh in a [`Grid`](tetrascope_core::Grid).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Outside {
    /// A [coverage](tetrascope_core::grid::coverage) of 0.
    #[default]
    Uncovered,
    /// NaN, and no coverage.
    Nan,
}

/// Options of [`Resampling`](crate::Resampling).
#[derive(Clone, Debug, PartialEq)]
pub struct ResamplingOptions {
    /// Samples along the longest axis of the mesh's box, [`MIN_SAMPLES`] to [`MAX_SAMPLES`]; they
    /// are about as far apart along the others.
    pub samples: usize,
    /// Where samples are taken instead, for a part of a mesh, or for one that moves: what is
    /// drawn ends where they do. A mesh whose box changes may have other samples, and buffers,
    /// in each step unless this is given.
    pub lattice: Option<Lattice>,
    /// How samples are taken.
    pub resampler: ResamplerOptions,
    /// How they are drawn. Polygons cut on the CPU, and bricks, are refused.
    pub slicing: SlicingOptions,
}

/// The defaults of [`ENTRY`]'s settings.
impl Default for ResamplingOptions {
    fn default() -> Self {
        ResamplingOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

impl ResamplingOptions {
    /// The places of the samples of `mesh`.
    ///
    /// # Errors
    /// Numbers out of range, a mesh without volume, and what [`Lattice::validate`] refuses.
    pub fn lattice(&self, mesh: &TetMesh) -> Result<Lattice, Error> {
        if let Some(lattice) = &self.lattice {
            lattice.validate()?;
            return Ok(*lattice);
        }
        if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&self.samples) {
            return Err(Error::Invalid {
                what: format!("{} samples along the longest axis", self.samples),
                help: Some(format!("give {MIN_SAMPLES} to {MAX_SAMPLES}; 128 is usual")),
            });
        }
        let bounds = mesh.bounds();
        Lattice::over(&bounds, Lattice::dims_over(&bounds, self.samples))
    }
}
