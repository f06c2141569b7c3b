//! View-independent cell projection: draw each tetrahedron by its faces.
//!
//! M. Weiler, M. Kraus, T. Ertl, "Hardware-Based View-Independent Cell Projection",
//! IEEE Symposium on Volume Visualization 2002.
//!
//! The data on the device do not depend on the view (§3.1): vertices, cells and
//! scalars. Reading order:
//!
//! 1. `mesh` uploads the mesh, each vertex once (§8: "reuse vertices of the mesh").
//!    Whenever the appearance changes, `classified` has the transfer function; `cull` leaves out cells that cannot show, and lists
//!    the others in pieces, one for each interval of the transfer function, where those are
//!    few. `passes::transform` (`transform.wgsl`) takes the vertices to camera space, once a
//!    frame.
//! 2. `frame` is the camera, in coordinates that stay small.
//! 3. The order of cells (§6, "compatible with any published cell sorting algorithm"),
//!    where the optical model asks for one; [`Order::Auto`] takes `mpvo` where that is known
//!    to be right, else `tiles` and `passes::lists`:
//!    - `passes::order` (`order.wgsl`) sorts the cells by their centroids on the device, or
//!      `centroids` on the CPU;
//!    - `mpvo` finds what is behind what across faces (Williams 1992);
//!    - `tiles` and `passes::lists` (`fill.wgsl`, `composite.wgsl`) keep the fragments
//!      and sort them in each pixel (Carpenter's A-buffer).
//! 4. `passes::cell` draws the cells. `footprint.wgsl` puts a quadrilateral around each;
//!    `chord.wgsl` finds in each fragment where the ray enters and leaves (§3.2);
//!    `cell.wgsl` integrates between (§5.1): over a piece (`pieces.wgsl`), over the cell's
//!    intervals (`segment.wgsl`) or from the tables of `preintegration` of tetrascope-gpu
//!    (`preintegration/lookup.wgsl`).
//!
//!    With [`ExitSearch::PerVertex`] as published, `passes::faces` takes its place: front
//!    faces are drawn, `faces.wgsl` computes ray parameters at their vertices (§4.2, §4.3)
//!    and `face.wgsl` takes the least of what is interpolated (§4.1). Its vertices are
//!    shared or in the layouts of `faces` (§6: 720 bytes per cell, §7: 456).
//! 5. Isosurfaces (§5.2) take one pass in place of these: `passes::surface`
//!    (`surface.wgsl`) finds in each fragment where the ray meets the nearest, shades it by
//!    the cell's gradient, and lets the depth buffer hide the others, so no order is
//!    needed; `among.wgsl` puts them among an application's own geometry
//!    ([`tetrascope_gpu::SceneDepth`]).
//! 6. `gather` of tetrascope-gpu (`resolve.wgsl`) puts the sum over the background.
//!
//! # Departures from the paper
//! - *Footprints are drawn, and fragments decide*; the paper draws front faces and
//!   leaves to the rasterizer which pixels they cover. Rasterizers snap vertices, mostly
//!   to 1/256 of a pixel, and then disagree with the ray: on 3000 cells of a torus at
//!   96x96 some pixels were off by 9e-3. Here a cell is drawn as one quadrilateral a
//!   sixteenth of a pixel larger than its silhouette, and a face is crossed if the ray
//!   passes its three edges on the same side, which all cells of an edge see alike
//!   (`sides.wgsl`). The same serves cells around the eye.
//! - *Scalars are weighted means of a face's vertices*, with weights from the ray in
//!   the face; the paper's equation 1 follows the gradient, which overshoots in thin
//!   cells. The sides choose the exit, in place of equation 3 (whose sign, as printed,
//!   is wrong).
//! - *Pieces of a cell are drawn in turn*, so that no fragment loops or searches. Planes of
//!   one scalar part them, and the eye's own scalar gives their order. A piece that may be
//!   deeper than 1 is drawn in parts, each an equal share of every ray's way through it.
//! - *Vertices' layouts are read as buffers*, by the vertex's number, so that sorted cells
//!   need no new indices: `glDrawArrays` in any order. Offsets are of the planes that
//!   equation 4 decodes. Numbers that have no known range are halves of f32 in the layout
//!   of 16 bits.
//! - *No texture holds the integral* (§5.1) by default: each fragment splits its segment
//!   at the transfer function's knots and integrates in closed form. With
//!   [`Integration::Table2d`] and [`Integration::Table3d`] textures do, filled on the
//!   device whenever the appearance changes. Their scalars are those of the transfer
//!   function's knots, not of the field, and they are interpolated in f32 by hand.
//! - *Isosurfaces are met where the scalar along the ray crosses their value*. The
//!   scalar at a face is computed in the same order for both of its cells, so that one of
//!   them has the crossing and there are no gaps to hide. The paper's table, in which
//!   surfaces are thickened against gaps, is [`SurfaceSearch::Table`]. Normals are those
//!   of the cells, as in the paper, but lights count in each fragment, and the depth
//!   written is the surface's, not the face's.
//! - *Blending is in f32* where the device can; the paper had 8 bits.
//! - *No fragment is counted before it is kept.* Boxes around cells bound how many
//!   there can be, and the image is cut into tiles that are sure to fit
//!   ([`ProjectionOptions::fragment_bytes`]).
//!
//! # Limits
//! - [`Order::Auto`] sorts fragments in each pixel in meshes that are not convex, which takes
//!   two to three times as long as an order of cells in the scenes of `compare` on llvmpipe, and
//!   memory for each fragment.
//! - [`Order::Centroid`] is not always the order of visibility; graded meshes show it most:
//!   on real files a picture was off by up to 0.25.
//! - [`Order::Mpvo`] is known to be right in convex meshes alone, where no cells hide each
//!   other in a cycle. It orders the parts of others by their distance, which is a guess, and
//!   breaks cycles; a note of the frame says so
//!   ([`FrameStats::order_proven`](tetrascope_core::FrameStats::order_proven)). On SPX, the
//!   Blunt Fin and the heat-sink it guesses right (RMSE 1.3e-7 and less at 512x512, in both
//!   projections), on another conforming mesh it was off by 2e-3, and with hanging nodes by 6e-4.
//! - [`Order::PerPixel`] sorts by where rays enter cells, so it is exact where cells do not
//!   overlap. Long lists are sorted in turns, n ⌈log₂ n⌉/16 384 of them for the n boxes around
//!   cells that a pixel may be in; a pixel that is not done after the last is counted
//!   (`lost_rays`) and noted.
//! - A transfer function has at most 16 384 knots, so that no loop over its pieces is so long
//!   that a device ends it.
//! - [`ExitSearch::PerVertex`] is for parallel rays alone, without per-pixel order and
//!   isosurfaces. The rasterizer decides there what a face covers, and a ray through a
//!   vertex may miss a cell (§4.3): on 3000 cells of a sphere at 96x96 the RMSE is 3e-6 and
//!   no pixel is singular; in 16 bits it is 3e-4. At 512x512, in emission, no pixel of the
//!   Blunt Fin (RMSE 3e-6) or SPX (7e-8) is off by 0.02, and 36 of the heat-sink are, by up
//!   to 0.46: its vertices are on a lattice, and some rays go through them. Minimum textures
//!   ([`ExitSearch::PerVertexTexture`]) lose stretched cells: with 64 samples per side a cube
//!   errs by 3e-5 and a bar eight times as long by 2e-3.
//! - Tables err by the square of their samples' distance where the transfer function is
//!   smooth (3e-5 in a picture for 64 samples per side), but by no less than it at steps;
//!   and a segment shorter than one sample of the length is too clear by the share σ h/2,
//!   h being that sample: cells much smaller than the longest edge show it.
//! - Where the device cannot blend f32, sums are kept in f16 and the frame says so,
//!   except with [`Order::PerPixel`], which does not blend.
//!
//! # In an application with its own wgpu
//! ```no_run
//! use tetrascope_core::glam::DMat4;
//! use tetrascope_core::{Appearance, Error, View, Volume};
//! use tetrascope_gpu::wgpu::{self, TextureFormat};
//! use tetrascope_gpu::{Draw as _, Gpu, Over, SceneDepth, Target};
//! use tetrascope_projection::{CellProjection, ProjectionOptions};
//!
//! /// Draws a volume among what the application has drawn into `color` and `depth`.
//! fn draw(
//!     (device, queue): (&wgpu::Device, &wgpu::Queue),
//!     (volume, appearance, view): (&Volume, &Appearance, &View),
//!     (color, format): (&wgpu::TextureView, TextureFormat),
//!     (depth, clip_from_world): (&wgpu::Texture, DMat4),
//! ) -> Result<(), Error> {
//!     // Once, and `reload` or `restyle` when something changes:
//!     let gpu = Gpu::from_device(device.clone(), queue.clone());
//!     let options = ProjectionOptions::default();
//!     let renderer = CellProjection::new(&gpu, volume, appearance, &options)?;
//!     // Every frame:
//!     let target = Target {
//!         over: Over::WhatIsThere,
//!         depth: Some(SceneDepth {
//!             texture: depth,
//!             clip_from_world,
//!         }),
//!         ..Target::new(color, format)
//!     };
//!     let mut encoder = device.create_command_encoder(&Default::default());
//!     let recorded = renderer.encode(&mut encoder, view, &target)?;
//!     queue.submit([encoder.finish()]);
//!     // Only who wants them waits for the statistics.
//!     println!("{:?}", recorded.statistics()?);
//!     Ok(())
//! }
//! ```

mod centroids;
mod classified;
pub mod counters;
mod cull;
mod entry;
mod faces;
mod frame;
mod gpu_data;
mod mesh;
mod mpvo;
mod options;
mod passes;
mod renderer;
mod tiles;

pub use entry::ENTRY;
pub use options::{
    CellLayout, Domain, ExitSearch, Integration, Order, ProjectionOptions, Sort, SurfaceSearch,
};
pub use renderer::CellProjection;

use tetrascope_core::Abilities;

/// The name in lists and messages.
pub const NAME: &str = "projection";

/// The parts of an appearance that it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;
