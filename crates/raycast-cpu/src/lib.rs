//! Ray casting on the CPU, in vectors of rays: from tetrahedron to tetrahedron through meshes,
//! from voxel cell to voxel cell through regular grids.

pub mod counters;
mod entry;
mod grid;
mod mesh;
mod options;
mod renderer;
mod simd;

pub use entry::{ENTRY, supports};
pub use options::RaycastCpuOptions;
pub use renderer::RaycastCpu;

use tetrascope_core::Abilities;

/// The name in lists and messages.
pub const NAME: &str = "raycast-cpu";

/// What it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;
