//! Tetrahedral meshes drawn by many processes (ranks), each of which has a part: sort-last.
//!
//! S. Molnar, M. Cox, D. Ellsworth, H. Fuchs, "A Sorting Classification of Parallel Rendering", 1994, for the
//! class; T. Peterka, D. Goodell, R. Ross, H. Shen, R. Thakur, "A Configurable Algorithm for Parallel
//! Image-Compositing Applications", 2009, for radix-k; A. Sahistan et al., "Scalable Visualization of Large-Scale
//! Unstructured Meshes on GPUs", 2022, for parts that are not convex.
//!
//! 1. [`partition`] spreads pieces over ranks by their bytes; [`part`] is what a rank then has of a mesh, and [`pieces`] reads
//!    it from files.
//! 2. [`communicator`] is how ranks talk: [`threads`] in one process, `mpi` (feature `mpi`) between many; [`collective`]
//!    gathers and agrees, and [`failure`] is what all hear if one fails.
//! 3. [`renderer`] draws: each rank casts rays through its part with `tetrascope-raycast-cpu`; [`exchange`] hands
//!    each rank the tiles of the picture that it owns, `message` says in which bytes, and rank 0 gathers the pixels.
//! 4. [`times`] is what a picture took at each rank; [`model`] predicts what many ranks take, from measures of few.
//!
//! # What is exchanged
//! A ray gathers a *run* in each stretch of a part: light, transmittance, and where it begins and ends. Compositing is
//! associative where an end is the next beginning, to the last bit, so that parts of any shape give the picture of the
//! whole: a ray may leave a part and come back. Tiles without runs are not sent.
//!
//! # Limits
//! - Cells that two parts have both, without a mark that one is a ghost, are drawn twice.
//! - Tetrahedral meshes alone: grids, and meshes in one part, are what `tetrascope` draws.

mod busy;
pub mod collective;
pub mod communicator;
pub mod exchange;
pub mod failure;
mod message;
pub mod model;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod part;
pub mod partition;
pub mod pieces;
pub mod renderer;
pub mod threads;
pub mod times;

pub use communicator::Communicator;
pub use exchange::Exchange;
pub use failure::Failure;
pub use part::Share;
pub use renderer::{Picture, RankRenderer};
pub use times::Times;
