//! Ray casting from tetrahedron to tetrahedron, on the GPU.
//!
//! F. Bernardon, C. Pagot, J. Comba, C. Silva, "GPU-based Tiled Ray Casting
//! using Depth Peeling", 2004.
//!
//! Two forms, [`Passes`]. In today's, all steps of a ray in one dispatch:
//!
//! 1. [`layout`](tetrascope_f32::layout) packs the mesh (the paper's section 4.1 and figure 8).
//! 2. [`tiles`](tetrascope_f32::tiles) lists the boundary faces where the rays of each tile may come in and
//!    come back (3.3, 3.4); or `single/layers.rs` and `peel.wgsl` peel the boundary (3.4).
//! 3. `raycast_peel/walk.wgsl` decides which face a ray crosses (3.2).
//! 4. `crossings.wgsl` finds the next boundary faces of a ray, `follow.wgsl` takes it from
//!    cell to cell, `gather.wgsl` integrates (3.2, 4.2), and `march.wgsl` is a ray's loop.
//! 5. `single/budget.rs` bounds what one dispatch does, as devices end loops that take too long;
//!    `single/cast.rs` records one dispatch, or as many as the rays need, with `state.wgsl`
//!    between them.
//!
//! As published, one step per pass, in `ping_pong` and its shaders:
//!
//! 1. `ping_pong/mesh.rs` packs the mesh into textures (4.1, figure 8).
//! 2. `ping_pong/tiles.rs` cuts the image (3.3, figure 5).
//! 3. `entry.wgsl` finds where rays come in (phase 1) and peels the boundary (phase 2, 3.4).
//! 4. `step.wgsl` takes each ray through one cell (phase 3a, 3.2).
//! 5. `retire.wgsl` moves idle rays before the others, and a query asks whether any
//!    are left (phase 3b).
//! 6. `display.wgsl` shows what was gathered (phase 4).
//! 7. `ping_pong/frame.rs` is figure 7: which pass when, and when to end.
//!
//! How a ray crosses faces there is one of two: [`Crossings::Planes`] as published, in
//! `planes.wgsl`, or, by default, [`Crossings::Sides`] with the decisions of `walk.wgsl`, in
//! `sides.wgsl` and `entry_sides.wgsl`.
//!
//! In both forms `mesh.rs` has what `reload` changes, `style.rs` what `restyle` changes, and
//! `frame.rs` what a frame records.
//!
//! # Departures from the paper
//! In [`Passes::Single`]:
//! - A ray is followed to its end in one dispatch; the paper takes one pass per step,
//!   as its hardware had no loops. So there is no state between passes, no
//!   occlusion query and no retirement of rays; work groups are the tiles. Where a ray passes
//!   more cells, or crosses the boundary more often, than a dispatch may (some ten
//!   thousand cells, some hundred parts), the picture is drawn again in several dispatches, between
//!   which 256 bytes of each ray are kept, for 2¹⁷ rays at a time, and in which lists of
//!   boundary faces are trees of depths. The next frames begin so.
//! - The paper peels the boundary layer by layer with a bias of 0.1 on depths.
//!   Here a ray finds all its boundary faces in its tile's list, or in layers that are in
//!   the order of depth and face, and those
//!   that belong together are paired by following the ray. There is no bias and
//!   no other tolerance; `walk.wgsl` says why a ray cannot be lost. What it assumes
//!   of products is asked of each device once (`sides` of `tetrascope-gpu`).
//! - Scalars and depths come from positive weights of a face's corners, not from
//!   a cell's gradient, which overshoots on slivers; what f32 loses of a sliver's weights is
//!   taken back (`sides.wgsl`).
//! - A cell takes 20 bytes instead of 144; where a field jumps between cells that touch without
//!   sharing points, 16 more for the cell's own scalars.
//!
//! In [`Passes::PingPong`]:
//! - Depths along rays count from a plane through the mesh, not from the eye, so that
//!   f32 resolves them from however far.
//! - A cell is named by whole texels, −1 is outside; the paper has texture coordinates
//!   and 0, a cell's own number.
//! - A ray whose color is done is left as it is; the paper sends it outside.
//! - Depth along a ray never goes back, in flat cells either: the paper would look a
//!   negative length up.
//! - A ray that finds no face to leave by is given up and counted; the paper's would
//!   go on to a neighbor at a depth of 999 999.
//! - A layer is peeled for all tiles together, so that the boundary is transformed once.
//! - Rays begin at the eye where it is in a cell, and before the mesh in orthographic
//!   views, whatever is behind the camera being cut off.
//! - Where a cell is flat its gradient is the least that fits its scalars.
//! - Steps end after as many passes as there are cells, so that no ray hangs.
//! - With [`Crossings::Sides`] none of the paper's geometry is left, but all of its passes and
//!   textures: a cell's faces are crossed as in [`Passes::Single`], the texel of gradient and
//!   scalar has the scalars of the four corners, and there are no normals (96 bytes per cell). A
//!   boundary face is drawn as a rectangle of pixels, its rays decide, and layers are in the
//!   order of (λ, cell), where nothing ties and nothing is lost. On the seven meshes of
//!   `tests/pictures/models.rs`, in the four models that both draw and at 512x512, the forms then
//!   agree to 1.4e-6 of the greatest light in every channel of every pixel. By planes they
//!   do not (Limits).
//!
//! In both the ray integral is evaluated in closed form unless a table is asked for
//! (`preintegration` of `tetrascope-gpu`); the paper always reads one. Its table with three
//! axes is [`Integration::Table3d`], and its table with two, for which every segment is
//! equally long, [`Integration::TableFixed`]: the paper does not say how long, here it is
//! the mean of all cells. That errs by lengths, not by resolution: 1.7e-2 (RMSE) on a
//! sphere of 3000 cells, with 32 samples per side and with 256. [`Integration::Table2d`] is
//! not the paper's: exact in length, for the optical models whose integral is linear in it.
//!
//! # Measured
//! On llvmpipe (Mesa 22.3.6), a busy machine, medians of five frames drawn in turn;
//! `benches/raycast_peel.rs` does it again. All but the rays was measured before dispatches were
//! bounded and the weights of slivers mended.
//! - Growth: on the sphere from 20 480 to 1 998 740 cells at 256x256 a frame of
//!   [`Passes::Single`] visits 1.16 to 5.32 M cells and takes 0.13 to 0.59 s of CPU: both grow as
//!   the cells to the power of 0.33.
//! - Tiles: of the Blunt Fin at 512x512 [`Passes::PingPong`] shades 73 M fragments with one tile
//!   and 22 M with 4x4, in 327 passes. With
//!   [`Crossings::Planes`] that was 7.3 and 5.3 s of wall time, but 2.15 and 2.08 s of CPU: the
//!   depth test already rejects, block by block, what the tiles spare. Medians of fifteen on a
//!   quiet machine: 1.71 s of wall time with one tile and 1.64 s with 4x4 by sides, 1.70 and
//!   1.61 s by planes.
//! - Rays: of 103 809 024 that are aimed at vertices, at edges and along faces, on the meshes of
//!   `single::aimed`, none was lost and none crossed the boundary an odd number of times.
//! - Entry: lists of boundary faces by tile beat peeled layers ([`Entries`]) and a hierarchy of
//!   boxes ([`tiles`](tetrascope_f32::tiles)).
//! - Order in memory: [`Locality`].
//!
//! # Limits
//! - Tetrahedral meshes; a grid is unsupported.
//! - Where cells overlap (a folded mesh), a ray sees the cells of each path in
//!   the path's order; [`Passes::PingPong`] may begin at the other end of it.
//! - With [`Crossings::Planes`] [`Passes::PingPong`] inherits the paper's errors. The rasterizer
//!   decides where a ray comes in, and it snaps vertices to 1/256 of a pixel: a ray that close to
//!   an edge of the boundary can be missed or begin in the wrong place. Of six small scenes
//!   from four places in four optical models, 153 600 rays in 96 pictures, that shows in
//!   8, at one ray each. What comes back within the bias behind its last entry is not seen. A
//!   plane's λ and a gradient's scalar err in proportion to a cell's thinness.
//! - So it is with all that was traced of SPX. At 512x512, in two views and four models, at most
//!   5 of 262 144 rays a picture are more than 1e-5 off by planes, on llvmpipe (Mesa 22.3.6), and
//!   none by sides: ten rays in all. None takes another way through cells: from where f64
//!   says that they come in, planes in f32 take each through f64's cells. One, 1e-5 off, grazes
//!   a face at a cosine of 8e-4, where a plane's λ is 4e-6 off. The others come in wrong,
//!   2e-4 to 1.1e-3 of a pixel from an edge of the boundary. Where two front faces share that edge
//!   the rasterizer takes the other face, and 1e-5 to 4e-4 of light is off. On an outline it
//!   misses rays that are inside for less than 3e-5 of half the extent, which maximum intensity
//!   alone shows, by 0.64. And at one ridge, in the way of a ray inside of the mesh, it draws a
//!   front face that f64 misses by 9e-4 of a pixel: what lies behind is counted twice, and
//!   7e-2 of light is off, the most with emission and absorption.
//! - With [`Crossings::Sides`] two programs decide about one ray, the one where it comes in and
//!   the one that steps: a device that compiles their arithmetic differently would lose rays that
//!   come in within a rounding of an edge. They are counted; llvmpipe has none. So it is with
//!   [`Entries::PeeledLayers`], a fragment shader that peels and a compute shader that marches;
//!   on llvmpipe both decide alike.
//! - [`Crossings::Sides`] knows the front of a face by the order of its cell's corners, which is
//!   made the same for all cells that are joined by faces, those without volume too. A mesh that
//!   cannot be ordered so, as it turns around like a Möbius strip, would lose rays and count them.
//! - Points that coincide exactly are one vertex, and faces between them are passed through as
//!   any face is. Cells that touch in another way are parts of the mesh of their own.
//! - Rays that one dispatch does not finish cost a frame twice, once. A ray that is
//!   given up or lost is counted and spoken of in the frame's notes.
//! - [`Passes::PingPong`] integrates in at most 16 384 intervals of the transfer function, all in one
//!   step.
//! - [`Passes::PingPong`] draws all faces of the boundary for each layer of it: 4096 bodies behind
//!   each other, 16 384 faces, in 8x8 pixels took 49 158 passes and 203 s of CPU (RMSE
//!   4.0e-6, in one dispatch 3.5e-6). Faces before the last layer could be left out, which
//!   saves half at most.
//! - [`Passes::PingPong`] draws no isosurfaces, depth cue or clip planes, and cannot be recorded
//!   into the caller's encoder, as the CPU reads occlusion queries between passes.
//!
//! # In an application with its own wgpu
//! ```no_run
//! use tetrascope_core::{Appearance, Error, TetMesh, View, Volume, VolumeRenderer as _};
//! use tetrascope_gpu::wgpu::{self, TextureFormat};
//! use tetrascope_gpu::{Draw as _, Gpu, Target};
//! use tetrascope_raycast_peel::{Domain, RaycastOptions, RaycastPeel, counters};
//!
//! /// Draws the steps of a time series, which share their geometry ([`TetMesh::with_scalars`]).
//! fn draw(
//!     (device, queue): (&wgpu::Device, &wgpu::Queue),
//!     (steps, scalar_range): (&[TetMesh], (f64, f64)),
//!     (appearance, view): (&Appearance, &View),
//!     (color, format): (&wgpu::TextureView, TextureFormat),
//! ) -> Result<(), Error> {
//!     let gpu = Gpu::from_device(device.clone(), queue.clone());
//!     let [first, ..] = steps else { return Ok(()) };
//!     let options = RaycastOptions {
//!         // Numbers are relative to the whole series, so that steps agree to the last bit.
//!         domain: Some(Domain { scalar_range: Some(scalar_range), ..Domain::of(first) }),
//!         ..RaycastOptions::default()
//!     };
//!     let volume = Volume::Mesh(first.clone());
//!     let mut renderer = RaycastPeel::new(&gpu, &volume, appearance, &options)?;
//!     for step in steps {
//!         renderer.reload(&Volume::Mesh(step.clone()))?; // uploads scalars alone
//!         let mut encoder = device.create_command_encoder(&Default::default());
//!         // Over the view's background, as all of the texture is written.
//!         let target = Target::new(color, format);
//!         let recorded = renderer.encode(&mut encoder, view, &target)?;
//!         queue.submit([encoder.finish()]);
//!         // Waits for the device.
//!         let stats = recorded.statistics()?;
//!         assert_eq!(stats.get(counters::LOST_RAYS), Some(0));
//!     }
//!     Ok(())
//! }
//! ```

pub mod counters;
mod entry;
mod gpu_data;
mod integral;
mod options;
mod ping_pong;
mod renderer;
mod single;

pub use entry::ENTRY;
pub use options::{
    Crossings, Domain, Entries, INTEGRATIONS, Integration, Locality, MAX_TILES, Passes,
    RaycastOptions,
};
pub use renderer::RaycastPeel;

use tetrascope_core::Abilities;

/// The name in lists and messages.
pub const NAME: &str = "raycast-peel";

/// The parts of an appearance that it draws beyond the volumetric optical models; [`Passes::PingPong`] draws none of them.
pub const ABILITIES: Abilities = Abilities::ALL;
