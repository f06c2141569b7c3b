//! Counters of frames.

use tetrascope_core::Counter;
use tetrascope_slicing::counters::{
    BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES,
};

/// Samples of the grid that the mesh was resampled to.
pub const SAMPLES: Counter = Counter {
    name: "samples",
    unit: "samples",
    about: "Samples of the grid that the mesh was resampled to.",
};

/// All that frames may count: the grid, and its slices.
pub const ALL: &[Counter] = &[
    SAMPLES,
    BRICKS_DRAWN,
    BRICKS_SKIPPED,
    VERTICES,
    FRAGMENTS,
    GEOMETRY_BYTES,
];
