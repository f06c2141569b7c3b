//! View-independent cell projection: draw each tetrahedron by its faces.
//!
//! M. Weiler, M. Kraus, T. Ertl, "Hardware-Based View-Independent Cell Projection",
//! IEEE Symposium on Volume Visualization 2002.
//!
//! What the device keeps does not depend on the view (§3.1): vertices, cells and
//! scalars. Reading order:
//!
//! 1. `volume` uploads the mesh, each vertex once (§8: "reuse vertices of the mesh"),
//!    and leaves out cells that cannot show.
//! 2. `frame` is the camera, in coordinates that stay small.
//! 3. `passes::order` (`order.wgsl`) keys and sorts the cells, back to front, where
//!    the optical model asks for it (§6).
//! 4. `passes::cell` (`cell.wgsl`) rasterizes faces, finds in each fragment where the
//!    ray enters and leaves (§3.2) and integrates between (§5.1).
//! 5. `tetrascope_gpu::gather` puts the sum over the background.
//!
//! # Departures from the paper
//! - *Back faces are drawn and the entry is found*; the paper draws front faces and
//!   finds the exit. Both cover the same pixels, but in a cell around the eye only the
//!   back faces are in front of it, and the entry is then the eye itself.
//! - *Scalars are weighted means of a face's vertices*, with weights from the ray in
//!   the face; the paper's equation 1 follows the gradient, which overshoots in thin
//!   cells. The same weights choose the entry, in place of equation 3 (whose sign, as
//!   printed, is wrong).
//! - *No texture holds the integral* (§5.1): each fragment splits its segment at the
//!   transfer function's knots and integrates in closed form.
//! - *Blending is in f32* where the device can; the paper had 8 bits.
//!
//! # Limits
//! - `EmissionAbsorption` draws cells in the order of their centroids, which is not
//!   always the order of visibility; graded meshes show it most.
//! - The rasterizer snaps vertices, mostly to 1/256 of a pixel, and so gives a few
//!   pixels along edges to a cell that their ray just misses. What is drawn there is
//!   off by what 1/256 of a pixel makes of the chord: on 3000 cells at 96x96 up to
//!   9e-3 in such a pixel, 8e-5 in the picture's root mean square.
//! - Where the device cannot blend f32, sums are kept in f16 and the frame says so.
//! - A face that crosses the plane through the eye is clipped by the rasterizer, in
//!   whose rounding a pixel there may be lost or doubled.

mod frame;
mod gpu_data;
mod options;
mod passes;
mod renderer;
mod volume;

pub use options::{CellLayout, ExitSearch, Integration, Order, ProjectionOptions};
pub use renderer::Projection;
