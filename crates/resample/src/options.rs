//! How samples are taken, and how they are drawn.

use std::ops::RangeInclusive;

use tetrascope_core::grid::Lattice;
use tetrascope_core::scalar_units::Floats;
use tetrascope_core::{Error, ScalarUnits, Settings, TetMesh};
use tetrascope_slicing::{Domain, SlicingOptions};

use crate::ENTRY;
use crate::mesh_slices::MeshSlicesOptions;

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
    /// Cross sections of cells by triangles and two textures of weights, as published: what front
    /// faces give, and then what back faces add.
    Two,
    /// The same in one pass, as published for texture combiners.
    One,
}

tetrascope_core::choices! {
    Passes: "direct" = Direct, "two" = Two, "one" = One;
}

/// Options of [`Resampler`](crate::Resampler).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ResamplerOptions {
    /// How the samples in a cell are found.
    pub passes: Passes,
    /// Width and height of the textures of weights, in texels: an even number from 32 to 1024. A
    /// scalar is off by at most the cell's range divided by it. [`Passes::Direct`] has none.
    pub weights: u32,
    /// Parts of the grid along its third axis, from 1 on, each of which has a list of the cells that
    /// meet it; no more than slices. It changes nothing in the samples. [`Passes::Direct`] has
    /// none.
    pub slabs: u32,
}

impl Default for ResamplerOptions {
    fn default() -> Self {
        ResamplingOptions::default().resampler
    }
}

impl ResamplerOptions {
    /// # Errors
    /// A number that is out of range.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        let ResamplerOptions {
            passes: _,
            weights,
            slabs,
        } = *self;
        if slabs == 0 {
            return Err(Error::Usage {
                what: "no slabs; valid are 1 and more".into(),
                help: None,
            });
        }
        check_weights(weights)
    }
}

/// Refuses textures of a size that is out of range.
pub(crate) fn check_weights(side: u32) -> Result<(), Error> {
    let (least, most) = (WEIGHTS.start(), WEIGHTS.end());
    match WEIGHTS.contains(&side) && side.is_multiple_of(2) {
        true => Ok(()),
        false => Err(Error::Usage {
            what: format!(
                "textures of {side} weights a side; valid are even numbers from {least} to {most}"
            ),
            help: None,
        }),
    }
}

/// Valid sizes of textures of weights.
pub(crate) const WEIGHTS: RangeInclusive<u32> = 32..=1024;

/// The value of a sample outside of the mesh in a [`Grid`](tetrascope_core::Grid).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Outside {
    /// A [coverage](tetrascope_core::grid::coverage) of 0.
    #[default]
    Uncovered,
    /// NaN, and no coverage.
    Nan,
}

/// Between a mesh and its picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Mode {
    /// A grid of samples, which stays while the camera moves.
    #[default]
    Grid,
    /// Slices of the mesh that face the camera, drawn as they come ([`MeshSlices`]).
    ///
    /// [`MeshSlices`]: crate::MeshSlices
    Slices,
}

tetrascope_core::choices! {
    Mode: "grid" = Grid, "slices" = Slices;
}

/// Options of [`Resampling`](crate::Resampling).
#[derive(Clone, Debug, PartialEq)]
pub struct ResamplingOptions {
    /// The representation between the mesh and its picture.
    pub mode: Mode,
    /// Samples along the longest axis of the mesh's box, [`MIN_SAMPLES`] to [`MAX_SAMPLES`]; they
    /// are about as far apart along the others.
    pub samples: usize,
    /// Where samples are taken instead, for a part of a mesh, or for one that moves: what is
    /// drawn ends where they do. A mesh whose box changes may have other samples, and buffers,
    /// in each step unless this is given.
    pub lattice: Option<Lattice>,
    /// Where and of which scalars all is that is to be drawn alike, such as the steps of a series;
    /// the samples' own if there is none. With it and a `lattice` [`reload`] makes nothing anew.
    ///
    /// [`reload`]: tetrascope_core::VolumeRenderer::reload
    pub domain: Option<Domain>,
    /// How samples are taken.
    pub resampler: ResamplerOptions,
    /// How a mesh is cut in [`Mode::Slices`]; in `domain`, if there is one.
    pub mesh_slices: MeshSlicesOptions,
    /// How they are drawn, in `domain`. Polygons cut on the CPU, and bricks, are refused.
    pub slicing: SlicingOptions,
}

/// The defaults of [`ENTRY`]'s settings.
impl Default for ResamplingOptions {
    fn default() -> Self {
        ResamplingOptions::from_settings(&Settings::defaults(&ENTRY))
    }
}

impl ResamplingOptions {
    /// How a mesh is cut.
    pub(crate) fn mesh_slices(&self) -> MeshSlicesOptions {
        MeshSlicesOptions {
            domain: self.domain.or(self.mesh_slices.domain),
            ..self.mesh_slices
        }
    }

    /// How samples are drawn.
    pub(crate) fn slicing(&self) -> SlicingOptions {
        SlicingOptions {
            domain: self.domain.map(Domain::of_floats).or(self.slicing.domain),
            ..self.slicing.clone()
        }
    }

    /// The units in which samples of `mesh` are taken: 32-bit floats hold few values of a field that is
    /// nearly constant.
    pub(crate) fn units(&self, mesh: &TetMesh) -> ScalarUnits {
        let domain = self.domain.or(self.slicing.domain);
        let range = domain.map_or_else(|| mesh.scalar_range(), |domain| domain.scalar_range);
        ScalarUnits::of_range(range, Floats::F32)
    }

    /// The same of a field in other units.
    pub(crate) fn in_units(&self, units: &ScalarUnits) -> ResamplingOptions {
        let moved = |domain: Domain| domain.in_units(units);
        let mut options = self.clone();
        options.domain = options.domain.map(moved);
        options.slicing.domain = options.slicing.domain.map(moved);
        options
    }

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
