//! How samples are taken.

/// How the samples in a cell are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Passes {
    /// The part of each column of samples that is in the cell, computed: neither triangles nor
    /// weight textures, and no error but that of rounding.
    #[default]
    Direct,
}

impl Passes {
    /// All, in the order of their names.
    pub const ALL: [Passes; 1] = [Passes::Direct];

    /// The name that people write.
    pub fn name(self) -> &'static str {
        match self {
            Passes::Direct => "direct",
        }
    }
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
