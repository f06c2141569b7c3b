//! The types and the mathematics that all Tetrascope renderers share: no GPU, no files.
//!
//! Reading order: [`mesh`] and [`grid`] hold a [`Volume`]; [`transfer_function`]
//! and [`appearance`] say how it looks; [`optics`] defines the one integral that
//! all renderers approximate; [`camera`] and [`view`] say from where; [`renderer`]
//! is the trait, and [`frame`] what comes out; an [`entry`] is what an algorithm says about
//! itself and its [`settings`].
//!
//! # The integral
//! Along a ray x(t) = origin + t d with |d| = 1 and t ≥ 0, extinction σ(t) ≥ 0
//! per world unit and color c(t) in linear RGB:
//!
//! L = ∫ c(t) σ(t) exp(−∫₀ᵗ σ) dt + exp(−∫ σ) L_background
//!
//! (N. Max, "Optical Models for Direct Volume Rendering", 1995.)
//!
//! # From numbers to light
//! ```
//! use tetrascope_core::colormap::Colormap;
//! use tetrascope_core::glam::DVec3;
//! use tetrascope_core::mesh::Association;
//! use tetrascope_core::optics::{RayIntegral, Segment};
//! use tetrascope_core::{Appearance, Camera, CameraFit, OpticalModel, Scalars, TetMesh};
//! use tetrascope_core::{TransferFunction, View, Volume, view};
//!
//! // One tetrahedron, hot at one of its corners.
//! let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let scalars = Scalars {
//!     name: "temperature".into(),
//!     association: Association::Point,
//!     values: vec![280.0, 280.0, 280.0, 300.0],
//! };
//! let volume = Volume::Mesh(TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars)?);
//!
//! // Colors from viridis; opacity rises to its greatest over one world unit.
//! let range = volume.scalar_range().expect("the values are finite");
//! let colors = TransferFunction::from_colormap(Colormap::Viridis, range, 1.0, 33)?;
//! let appearance = Appearance::new(colors, OpticalModel::EmissionAbsorption);
//! let view = View {
//!     camera: Camera::frame(volume.outline(), CameraFit::PlusIso, false, 4.0 / 3.0),
//!     width: 640,
//!     height: 480,
//!     background: view::BLACK,
//! };
//! // Every renderer takes these three: `Reference::new(&volume, &appearance, …)?.render(&view)`.
//!
//! // A ray through half a unit of it gathers light, and lets the rest of the background through.
//! let mut ray = RayIntegral::new(&appearance.transfer_function, appearance.optical_model);
//! ray.add(&Segment { front: 285.0, back: 295.0, length: 0.5 });
//! let [r, g, b, a] = ray.over(view.premultiplied_background());
//! assert!(g > r && g > b && a == 1.0); // the middle of viridis is green
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

pub use glam;

pub mod appearance;
pub mod camera;
pub mod clusters;
pub mod colormap;
pub mod entry;
pub mod error;
pub mod frame;
pub mod grid;
pub mod groups;
pub mod mesh;
pub mod number;
pub mod optics;
pub mod pick;
pub mod renderer;
pub mod scalar_units;
pub mod settings;
pub mod stop;
pub mod text;
pub mod transfer_function;
mod unit;
pub mod view;
pub mod volume;

pub use unit::Unit;

pub use appearance::{
    Abilities, Appearance, ClipPlane, DepthCue, DirectionalLight, Isosurface, Lighting,
    OpticalModel,
};
pub use camera::{Camera, CameraFit, Framing, Projection, Ray};
pub use entry::{Entry, Promise};
pub use error::{Error, ErrorKind};
pub use frame::{Counter, Frame, FrameStats};
pub use grid::Grid;
pub use mesh::{Cells, Scalars, TetMesh};
pub use renderer::VolumeRenderer;
pub use scalar_units::ScalarUnits;
pub use settings::{Setting, Settings, Values};
pub use stop::Stop;
pub use transfer_function::{Knot, TransferFunction};
pub use view::View;
pub use volume::{Bounds, Volume, VolumeKind, is_value};
