//! Ray casting from tetrahedron to tetrahedron, on the GPU.
//!
//! F. Bernardon, C. Pagot, J. Comba, C. Silva, "GPU-based Tiled Ray Casting
//! using Depth Peeling", 2004.
//!
//! 1. [`layout`] packs the mesh (the paper's section 4.1 and figure 8).
//! 2. [`tiles`] lists the boundary faces where the rays of each tile may come in and
//!    come back (3.3, 3.4).
//! 3. `raycast_peel/walk.wgsl` decides which face a ray crosses (3.2).
//! 4. `raycast_peel/march.wgsl` follows rays and integrates (3.2, 4.2).
//!
//! # Departures from the paper
//! - A ray is followed to its end in one dispatch; the paper takes a pass a step,
//!   as its hardware had no loops. So there is no state between passes, no
//!   occlusion query and no retirement of rays; work groups are the tiles.
//! - The paper peels the boundary layer by layer with a bias of 0.1 on depths.
//!   Here a ray finds all its boundary faces in its tile's list, and those
//!   that belong together are paired by following the ray. There is no bias and
//!   no other tolerance; `walk.wgsl` says why a ray cannot be lost.
//! - Scalars and depths come from positive weights of a face's corners, not from
//!   a cell's gradient, which overshoots on slivers.
//! - A cell takes 20 bytes instead of 144.
//! - The ray integral is evaluated in closed form; the paper reads a table.
//!
//! # Limits
//! - Tetrahedral meshes; a grid is unsupported.
//! - Where cells overlap (a folded mesh), a ray sees the cells of each path in
//!   the path's order.

mod gpu_data;
mod layout;
mod options;
mod rays;
mod renderer;
mod single;
mod tiles;

pub use options::{Locality, RaycastOptions};
pub use renderer::RaycastPeel;

use tetrascope_core::Abilities;

/// The name in lists and messages.
pub const NAME: &str = "raycast-peel";

/// What it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;
