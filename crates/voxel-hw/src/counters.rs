//! Counters of frames.

use tetrascope_core::Counter;
use tetrascope_slicing::counters::{
    BRICKS_DRAWN, BRICKS_SKIPPED, FRAGMENTS, GEOMETRY_BYTES, VERTICES,
};

/// Voxels of the grid that was made of the mesh.
pub const VOXELS: Counter = Counter {
    name: "voxels",
    unit: "voxels",
    about: "Voxels of the grid that was made of the mesh.",
};

/// All that frames may count: the grid, and its slices.
pub const ALL: &[Counter] = &[
    VOXELS,
    BRICKS_DRAWN,
    BRICKS_SKIPPED,
    VERTICES,
    FRAGMENTS,
    GEOMETRY_BYTES,
];
