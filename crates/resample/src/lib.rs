//! Resampling of tetrahedral meshes into regular grids, on the device.
//!
//! R. Westermann, "The Rendering of Unstructured Grids Revisited", Joint
//! Eurographics / IEEE TCVG Symposium on Visualization 2001.
//!
//! A mesh becomes the samples of a regular grid, cell by cell, in any order: no sorting, no
//! adjacency and nothing that is found out beforehand, so a mesh whose places and connectivity
//! change with every frame costs the same as one that does not.
//!
//! 1. `placed` takes vertices into the grid's own units, in f64, and leaves there each
//!    vertex's nearest sample and its distance from it (`mesh.wgsl`).
//! 2. `direct` records the passes. `fill.wgsl` goes through the columns of samples that a cell meets,
//!    cells with much to do apart (`arrange.wgsl`), and `column.wgsl` finds the part of a column in
//!    the cell and writes the samples there.
//! 3. [`Resampler`] is a mesh and its grid (§3).
//! 4. [`Resampling`] draws a mesh by the slices of its grid (§3.2), with
//!    [`Slicing`](tetrascope_slicing::Slicing).
//!
//! # Departures from the paper
//! - *Columns for slices* ([`Passes::Direct`]). The paper draws the cross section of a cell in
//!   every slice, as triangles with two weight textures. Here a column of samples meets the two
//!   faces of the cell that it crosses, and what is between them is interpolated: the same
//!   linear interpolant without textures, with an error of rounding alone.
//! - *Every sample in the mesh is written by one cell.* `sides.wgsl` decides which columns cross a
//!   face; both of its cells compute the place where from the same numbers in the same order,
//!   and each takes the samples from its first face, included, to its second, excluded.
//! - *No list of active elements*: a cell's samples are all written at once, so no slice has to
//!   know which cells it meets.
//!
//! # Limits
//! - A sample exactly on the mesh's surface belongs to it on one side and not on the other, as
//!   those of a half-open box. A grid that reaches exactly to the mesh's bounds has layers of samples
//!   outside; one that is a millionth smaller does not.
//! - Where faces lie in one place but differ, as between cubes with different diagonals, rounding
//!   may leave out a sample on them, or let it be written twice.
//! - Where rounding swaps the faces of a cell a sample may be written twice, with values equal but for
//!   rounding; which of them stays may differ from run to run. That is so in cells thinner than 2⁻²² of
//!   their extent, and for columns that pass an edge by as little as f64 rounds it.
//! - Vertices are where rounding puts them, off by at most 2⁻²⁴ of their distance from a column. Where a
//!   field rises by its whole range within less than some 10⁻³ of a cell's extent, that can be more
//!   than 10⁻⁵ of the range.
//! - Scalars are rounded to f32 in the field's unit, as the grid holds them.

pub mod counters;
mod direct;
mod entry;
mod gpu_data;
mod options;
mod placed;
mod renderer;
mod resampler;

pub use entry::ENTRY;
pub use options::{MAX_SAMPLES, MIN_SAMPLES, Outside, Passes, ResamplerOptions, ResamplingOptions};
pub use renderer::Resampling;
pub use resampler::Resampler;

use tetrascope_core::{Abilities, Error};
pub use tetrascope_slicing::Domain;

/// The algorithm's name.
pub const NAME: &str = "resample";

/// What it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = tetrascope_slicing::ABILITIES;

/// What slices refuse is refused by this algorithm.
fn renamed(error: Error) -> Error {
    match error {
        Error::Unsupported { what, reason, .. } => Error::Unsupported {
            renderer: NAME,
            what,
            reason,
        },
        other => other,
    }
}
