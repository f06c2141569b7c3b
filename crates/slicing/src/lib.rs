//! Slices of regular grids, computed in the vertex stage.
//!
//! C. Rezk Salama, A. Kolb, "A Vertex Program for Efficient Box-Plane Intersection",
//! Vision, Modeling and Visualization 2005.
//!
//! A stack of planes, parallel to the image, cuts the volume into slabs. Six vertices a
//! plane and box go in, and a vertex program makes them the polygon in which the plane
//! cuts the box. So boxes can be small, and those that are empty are left out.
//!
//! 1. [`box_plane`] has the program's tables and the program on the CPU (§4, §5); its
//!    WGSL is `box_plane.wgsl`. [`Slicer::Cpu`] cuts all polygons there instead, in
//!    `polygons`, for comparison.
//! 2. Samples come from a [`BrickSource`](tetrascope_core::grid::BrickSource), in memory or
//!    in a file. `voxels` keeps them in textures (§3.1), and `octree` knows their least and
//!    greatest values, box by box, and visits boxes back to front (§6); `skip` tells which
//!    of them the transfer function shows. [`Traversal::Gpu`] does so on the device, all
//!    boxes at once: `cull` (`cull.wgsl`).
//!    Or they are on the device already, in a [`DeviceGrid`](tetrascope_gpu::DeviceGrid) that a
//!    compute pass has made ([`Slicing::from_device`]): `ranges` (`ranges.wgsl`) finds the values
//!    of boxes there, and `float_table` is what tells which of them show.
//! 3. `frame` is the camera in the volume's lattice, and `frustum` what it sees of it.
//! 4. `slice` draws boxes, each an instance of one stack of polygons ([`Slicer::VertexProgram`]).
//!    `slab.wgsl` is the part of a ray that a fragment stands for, `slice.wgsl` what it adds to a
//!    pixel (§7), and `surface.wgsl` the isosurface that it meets, which hides what was drawn
//!    before. `count` counts fragments.
//! 5. Unless asked for polygons, `rays.wgsl` takes the same slabs ray by ray ([`Slicer::Rays`]):
//!    `table` has the boxes in which it looks, and `runs` says how many slabs one fragment takes.
//!
//! # Departures from the paper
//! - *Slabs are drawn ray by ray*, front to back, in one fragment for hundreds of them
//!   ([`Slicer::Rays`]). They are those of the polygons, to the last bit, but for the order in
//!   which they are added up. Neighbors share a sample, what is behind all that shows is left
//!   out, and a software adapter need not draw and blend millions of small polygons.
//! - *A plane stands for a slab* around it, which is cut where the volume, a clip plane
//!   or the eye ends it, and is as long as the ray in it. [`SlabEnds::Whole`] and
//!   [`StepLength::Planar`] are the published slices.
//! - *An edge is cut if its ends lie on different sides of the plane.* The published
//!   test, [`PlaneTest::Published`], misses one path in fifty one rounding error before
//!   a corner.
//! - *Boxes are enlarged* in the vertex program by what a ray advances in half a slab,
//!   and a fragment is dropped unless its slab's middle is in the box. So each slab of
//!   each ray is drawn exactly once, whatever the rasterizer does at the borders, and a
//!   picture does not depend on how the volume is divided, to the last bit but for the
//!   order of blending.
//! - *Slabs are integrated* between the samples at both ends
//!   ([`Integration::Slabs`]); the published post-classification is
//!   [`Integration::PostClassified`].
//! - *Bricks are slots of one texture*, not textures of their own: one draw has them all.
//!   Which level of the octree they are is [`SlicingOptions::brick_level`].
//! - *Boxes outside of the image* or behind clip planes are skipped, too.
//! - *Isosurfaces are met in voxel cells* ([`Crossing::Cells`]), where the field along a ray
//!   is a cubic, and lit by the interpolant's gradient; [`Crossing::Corrected`],
//!   [`Crossing::Linear`] and [`Gradient::CentralDifferences`] are what slices alone see.
//! - *Interpolation is in f32* ([`Filtering::Exact`]); texture units may have fractions of
//!   8 bits.
//! - *A cell with a sample that is not finite is transparent*: slabs are cut where rays enter
//!   and leave such cells.
//! - *Blending is in f32* where the device can.
//!
//! # Limits
//! - [`Integration::PostClassified`] and [`SlabEnds::Whole`] are of first order where samples
//!   are not finite: a slab is drawn whole, or not at all.
//! - A picture has isosurfaces or a volume, as everywhere in this workspace; a surface in a
//!   volume is a thin tent of the transfer function.
//! - [`Crossing::Corrected`] and [`Crossing::Linear`] miss what a ray meets twice in a slab.
//! - Samples that fill cells of their own are drawn cell by cell within each slab, exactly;
//!   they have no gradient, so shading and isosurfaces do nothing there.
//! - What is streamed cannot be recorded into a caller's encoder.
//! - A grid with [coverage](tetrascope_core::grid::coverage) is on the device as a whole, as is
//!   any [`DeviceGrid`](tetrascope_gpu::DeviceGrid); it has no shading, and its samples do not
//!   fill cells.
//!
//! # In an application with its own wgpu
//! [`Slicing::from_device`] has another example: a grid that a compute pass writes.
//! ```no_run
//! use tetrascope_core::{Appearance, Error, Grid, View, Volume};
//! use tetrascope_gpu::wgpu::{self, TextureFormat};
//! use tetrascope_gpu::{Draw as _, Gpu, Over, Target};
//! use tetrascope_slicing::{Slicing, SlicingOptions};
//!
//! /// Uploads a grid, once; `reload` and `restyle` follow what changes.
//! fn prepare(
//!     (device, queue): (&wgpu::Device, &wgpu::Queue),
//!     grid: Grid,
//!     appearance: &Appearance,
//! ) -> Result<Slicing, Error> {
//!     let gpu = Gpu::from_device(device.clone(), queue.clone());
//!     let options = SlicingOptions {
//!         slices_per_voxel: 4.0, // half the distance of the default, a quarter of the error
//!         ..SlicingOptions::default()
//!     };
//!     Slicing::new(&gpu, &Volume::Grid(grid), appearance, &options)
//! }
//!
//! /// Every frame: draws the grid over what the application has drawn into `color`.
//! fn draw(
//!     slicing: &Slicing,
//!     encoder: &mut wgpu::CommandEncoder,
//!     view: &View,
//!     (color, format): (&wgpu::TextureView, TextureFormat),
//! ) -> Result<(), Error> {
//!     let target = Target {
//!         over: Over::WhatIsThere,
//!         ..Target::new(color, format)
//!     };
//!     // The application submits; the statistics, which wait for that, are left alone.
//!     let _ = slicing.encode(encoder, view, &target)?;
//!     Ok(())
//! }
//! ```

pub mod box_plane;
mod boxes;
mod cells;
mod count;
pub mod counters;
mod cull;
mod entry;
mod float_table;
mod frame;
mod frustum;
mod gpu_data;
mod maxima;
mod octree;
mod options;
mod polygons;
mod ranges;
mod renderer;
mod runs;
mod samples;
mod skip;
mod slice;
mod table;
mod texels;
mod voxels;

pub use entry::ENTRY;
pub use options::{
    Crossing, Domain, Filtering, Gradient, Integration, Level, MAX_LEVEL, MAX_SLICES_PER_VOXEL,
    MIN_SLICES_PER_VOXEL, Phong, PlaneTest, Shading, SlabEnds, Slicer, SlicingOptions, StepLength,
    Storage, Traversal,
};
pub use renderer::Slicing;

use tetrascope_core::Abilities;

/// The algorithm's name.
pub const NAME: &str = "slicing";

/// The parts of an appearance that it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;
