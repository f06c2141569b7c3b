//! Resampling of tetrahedral meshes into regular grids, on the device.
//!
//! R. Westermann, "The Rendering of Unstructured Grids Revisited", Joint
//! Eurographics / IEEE TCVG Symposium on Visualization 2001.
//!
//! A mesh becomes the samples of a regular grid, cell by cell, in any order: no sorting, no
//! adjacency and nothing that is found out beforehand, so a mesh whose places and connectivity
//! change with every frame costs the same as one that does not.
//!
//! | section | file |
//! |---|---|
//! | | `placed` takes vertices into the grid's own units, in f64, and leaves there each vertex's nearest sample and its distance from it (`mesh.wgsl`) |
//! | 2, triangles of a cell as it is seen | `triangles.wgsl`, and its twin `triangles` |
//! | 2.1, weights | `weights` makes both textures, `section.wgsl` draws a slice with them |
//! | 3, 3.1, active elements | `elements.wgsl` makes all triangles once, `active.wgsl` lists those of a slab |
//! | 3.2, resampling | `textured` records the passes, and copies slice by slice into the grid |
//! | 3.2, rendering | `mesh_slices`: [`MeshSlices`] draws a picture slice by slice, without a grid |
//! | 4, one pass | `fs_both` of `section.wgsl` |
//! | in place of 2 to 4, [`Passes::Direct`] | `direct` records the passes. `columns/fill.wgsl` goes through the columns of samples that a cell meets, cells with much to do apart, and `column.wgsl` finds the part of a column in the cell and writes the samples there |
//!
//! [`Resampler`] is a mesh and its grid. [`Resampling`] draws a mesh by the slices of its grid, with
//! [`Slicing`](tetrascope_slicing::Slicing), and [`MeshSlices`] without one.
//!
//! # Departures from the paper
//! - *Columns for slices* ([`Passes::Direct`], the default). The paper draws the cross section of a
//!   cell in every slice, as triangles with two weight textures. Here a column of samples meets the
//!   two faces of the cell that it crosses, and what is between them is interpolated: the same
//!   linear interpolant without textures, with an error of rounding alone. It needs no list of active
//!   elements, as a cell's samples are all written at once.
//! - *Every sample in the mesh is written by one cell* there. `sides.wgsl` decides which columns cross
//!   a face; both of its cells compute the place where from the same numbers in the same order,
//!   and each takes the samples from its first face, included, to its second, excluded.
//!
//! And in what is drawn ([`Passes::Two`], [`Passes::One`]):
//! - *Texture coordinates are shares of each cell's thickness*. The paper scales all by one texture
//!   matrix, so by the thickest cell, and thin cells have few texels or one. So a scalar is off by
//!   what half a texel is of its own cell's range, whatever the others are like; see `weights`.
//! - *Weights of the middles of texels*, not of their corners: no weight is 0/0, and alpha is
//!   1 wherever both distances are positive. The paper does not say how textures are filtered: here by the
//!   nearest texel, which 32-bit floats always can, and a linear one would mix alpha with what is not
//!   drawn.
//! - *Vertices that the rasterizer rounds*, to 1/256 of a pixel or even 1/16, move faces differently as
//!   seen from both sides, and leave gaps. What that does to distances and scalars is taken back, and
//!   what is outside of a cell by no more than it explains is drawn as if on its face, behind what
//!   other cells draw. Without both, a rasterizer that rounds to 1/16 of a pixel left out 400 of 75 000
//!   samples inside of a mesh; with them, one, and one that rounds to 1/256 none.
//! - *The mesh is drawn larger* by 1/128 of a pixel at the grid's edges, which is taken back as well: so
//!   samples just inside of a mesh that ends with the grid are not left out.
//! - *A depth test* decides between two cells that cover one sample, which blending would add up: the one
//!   that comes first in the mesh, in both passes.
//! - *Triangles that rounding turns over are not drawn*; the rest of the fan covers them.
//! - *Scalars are 32-bit floats*, in a target with two components, the second of which is coverage.
//!   Where the device cannot add those up, the second pass reads what the first has drawn.
//! - *Triangles are made for the whole mesh, once*, not when a slab begins; the distances of a slice are
//!   differences from stored places, not updated from slice to slice, which would add up rounding.
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
//! - What is drawn is off by up to 1/N of the range of a cell with N weights a side. The mesh's surface
//!   may be off by what vertices are rounded by, at most 1/64 of a sample where that is 1/256 of a
//!   pixel. Along the axis of slices both sides of a surface belong to the mesh.
//! - Should a device round the programs of two passes differently, they may disagree whether a sample is
//!   in a cell; then its scalar lacks what the second adds. No device seen so far does that.
//! - Rasterizers interpolate across a cell in 32-bit floats: across 2ᵏ samples it is off by some 2ᵏ⁻²³
//!   of one, which matters in cells thousands of times larger than the grid.
//! - What is drawn takes 52 bytes for each cell beside the mesh, in buffers that hold all of them.
//! - A picture's border is that of the samples: it fades over one sample's distance, at first order. Greatest
//!   colors and isosurfaces have no extinction that could fade, and end where a cell of the grid
//!   has a sample outside, so up to a sample's distance inside of the mesh.
//!
//! # In an application with its own wgpu
//! ```no_run
//! use tetrascope_core::grid::Lattice;
//! use tetrascope_core::{Appearance, Bounds, Error, View, Volume, VolumeRenderer as _};
//! use tetrascope_gpu::wgpu;
//! use tetrascope_gpu::{Draw as _, Gpu, Target};
//! use tetrascope_resample::{Domain, Resampling, ResamplingOptions};
//!
//! /// A simulation whose mesh moves within `bounds`, and whose scalars stay within a range: with
//! /// both given, a step makes no buffer anew, but where there are more cells than ever before.
//! fn prepare(
//!     (device, queue): (&wgpu::Device, &wgpu::Queue),
//!     first: &Volume,
//!     appearance: &Appearance,
//!     (bounds, scalar_range): (Bounds, Option<(f64, f64)>),
//! ) -> Result<Resampling, Error> {
//!     let gpu = Gpu::from_device(device.clone(), queue.clone());
//!     let dims = Lattice::dims_over(&bounds, 192);
//!     let options = ResamplingOptions {
//!         lattice: Some(Lattice::over(&bounds, dims)?),
//!         domain: Some(Domain { bounds, scalar_range }),
//!         ..ResamplingOptions::default()
//!     };
//!     Resampling::new(&gpu, first, appearance, &options)
//! }
//!
//! /// Every step: another mesh, with other cells if it likes, and a frame of it.
//! fn step(
//!     renderer: &mut Resampling,
//!     mesh: &Volume,
//!     encoder: &mut wgpu::CommandEncoder,
//!     (view, target): (&View, &Target),
//! ) -> Result<(), Error> {
//!     renderer.reload(mesh)?;
//!     // The application submits; the statistics, which wait for that, are left alone.
//!     let _ = renderer.encode(encoder, view, target)?;
//!     Ok(())
//! }
//! ```

pub mod counters;
mod direct;
mod entry;
mod gpu_data;
mod mesh_slices;
mod options;
mod placed;
mod renderer;
mod resampler;
mod slabs;
mod textured;
#[cfg(test)]
mod triangles;
mod weights;

pub use entry::ENTRY;
pub use mesh_slices::{Evaluation, MeshSlices, MeshSlicesOptions, Shading};
pub use options::{
    MAX_SAMPLES, MIN_SAMPLES, Mode, Outside, Passes, ResamplerOptions, ResamplingOptions,
};
pub use renderer::Resampling;
pub use resampler::Resampler;
pub use slabs::Drawn;

use tetrascope_core::{Abilities, Error};
pub use tetrascope_slicing::Domain;

/// The algorithm's name.
pub const NAME: &str = "resample";

/// The parts of an appearance that it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = tetrascope_slicing::ABILITIES;

/// Says in the name of this algorithm that slices refuse something.
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
