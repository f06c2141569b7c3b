//! Ray casting on the CPU, in vectors of rays: from tetrahedron to tetrahedron through meshes,
//! from voxel cell to voxel cell through regular grids.
//!
//! M. Garrity, "Raytracing Irregular Volume Data", 1990, followed rays from cell to cell first. What a
//! ray decides here is that of `tetrascope-raycast-peel`, on the GPU, and has no tolerance: S. Woop,
//! C. Benthin, I. Wald, "Watertight Ray/Triangle Intersection", 2013, for the sheared rays; A. Aman,
//! S. Demirci, U. Güdükbay, "Compact Tetrahedralization-based Acceleration Structures for Ray Tracing",
//! 2022, for cells that are the exclusive or of their vertices.
//!
//! Reading order: `renderer` has what a renderer does; `mesh`, `clusters` and `grid` say in which order to read
//! what draws meshes, meshes that are read in clusters, and grids; `simd` chooses the instructions, when the program runs: AVX-512,
//! AVX2, NEON, or what every processor of its kind has.
//!
//! # What it is for
//! Pictures without a graphics adapter, as exact as f32 allows, and many times faster than
//! `tetrascope-reference`, which has f64, a bound for each pixel, and no adjacency that could be wrong.
//!
//! # Meshes
//! - Each lane of a vector has a ray of its own; one that ends takes the next, so that lanes are
//!   busy. All rays of a block of pixels share one main axis, or are cast axis by axis.
//! - A segment of a ray is integrated in closed form, in parts of optical depth 1, with a polynomial
//!   that is off by 3.2e-8: it needs no exponential, as transmittance is a product of what
//!   parts leave; what rounding takes from that product is kept beside it.
//! - Pixels do not depend on the number of threads. Between instruction sets they differ by rounding:
//!   SSE2 has no fused products.
//!
//! # Meshes in clusters
//! - A mesh that need not fit in memory ([`Volume::Clusters`](tetrascope_core::Volume::Clusters)) is drawn cluster by
//!   cluster, each in the domain of the whole. What rays gather in each are segments, joined where they meet:
//!   compositing is associative (S. Molnar et al., "A Sorting Classification of Parallel Rendering", 1994;
//!   A. Sahistan et al., "Scalable Visualization of Large-Scale Unstructured Meshes on GPUs", 2022, has
//!   parts that are not convex). The picture is that of one part but for rounding.
//! - Clusters in which the look shows nothing, beside the image, cut away, or covered by what is before
//!   them are not read; frames count them.
//! - [`RaycastCpuOptions::memory`] bounds what is read at once and what is kept for the next frame.
//! - [`RaycastCpu::segments`] gives the segments of what a process has, for others to composite;
//!   [`RaycastCpu::tiles`] gives them joined, a block of pixels at a time.
//!
//! # Limits
//! - AVX2 and SSE2 were at hand for the tests; AVX-512 and NEON take the same code and were not.
//! - Where cells overlap (a folded mesh), a ray sees the cells of each path in the path's order.
//! - Light behind a transmittance of 2⁻²⁶ is left out, which is less than f32 resolves of the greatest
//!   color.
//! - A ray's ways through cells are off by 2⁻²⁴ of the volume's extent: where a cell is a thousandth of
//!   it thick, that is 1e-4 of its light. Its greatest value and its surfaces are seen, however thin it is;
//!   of values of cells, not of points, those of cells thinner than that are lost.
//!
//! # In an application
//! ```
//! use tetrascope_core::glam::DVec3;
//! use tetrascope_core::mesh::Association;
//! use tetrascope_core::{Appearance, Camera, CameraFit, Knot, OpticalModel, Scalars};
//! use tetrascope_core::{TetMesh, TransferFunction, View, Volume, VolumeRenderer as _, view};
//! use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
//!
//! // A tetrahedron of constant extinction 2 that is 1 deep along z at the z axis.
//! let points = vec![DVec3::new(-1.0, -1.0, 0.0), DVec3::X, DVec3::Y, DVec3::Z];
//! let scalars = Scalars {
//!     name: "density".into(),
//!     association: Association::Point,
//!     values: vec![1.0; 4],
//! };
//! let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars)?;
//! let volume = Volume::Mesh(mesh);
//! let knot = Knot { scalar: 1.0, color: DVec3::ONE, extinction: 2.0 };
//! let colors = TransferFunction::new(vec![knot])?;
//! let appearance = Appearance::new(colors, OpticalModel::EmissionAbsorption);
//!
//! let renderer = RaycastCpu::new(&volume, &appearance, &RaycastCpuOptions::default())?;
//! let frame = renderer.render(&View {
//!     camera: Camera {
//!         focal_point: DVec3::ZERO, // the axis goes through the middle of the picture
//!         position: DVec3::new(0.0, 0.0, 5.0),
//!         ..Camera::fit(&volume.bounds(), CameraFit::PlusZ, true, 1.0)
//!     },
//!     width: 65,
//!     height: 65,
//!     background: view::TRANSPARENT,
//! })?;
//! let opacity = frame.pixel(32, 32)[3];
//! assert!((f64::from(opacity) - (1.0 - (-2.0_f64).exp())).abs() < 1e-6);
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

mod clusters;
pub mod counters;
mod entry;
mod grid;
mod mesh;
mod options;
mod renderer;
mod segments;
mod simd;

pub use clusters::{Run, Tile};
pub use entry::{ENTRY, supports};
pub use options::RaycastCpuOptions;
pub use renderer::RaycastCpu;
pub use segments::{PathSegment, PathSegments};
pub use tetrascope_f32::Domain;

use tetrascope_core::Abilities;

/// The name in lists and messages.
pub const NAME: &str = "raycast-cpu";

/// The parts of an appearance that it draws beyond the volumetric optical models.
pub const ABILITIES: Abilities = Abilities::ALL;
