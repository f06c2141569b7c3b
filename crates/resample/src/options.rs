//! How samples are taken.

use std::ops::RangeInclusive;

use tetrascope_core::Error;

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

impl Passes {
    /// All, in the order of their names.
    pub const ALL: [Passes; 3] = [Passes::Direct, Passes::Two, Passes::One];

    /// The name that people write.
    pub fn name(self) -> &'static str {
        match self {
            Passes::Direct => "direct",
            Passes::Two => "two",
            Passes::One => "one",
        }
    }
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
        ResamplerOptions {
            passes: Passes::default(),
            weights: 256,
            slabs: 40,
        }
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
const WEIGHTS: RangeInclusive<u32> = 32..=1024;

/// What stands for a sample outside of the mesh in a [`Grid`](tetrascope_core::Grid).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Outside {
    /// A [coverage](tetrascope_core::grid::coverage) of 0.
    #[default]
    Uncovered,
    /// NaN, and no coverage.
    Nan,
}
