//! What every Tetrascope renderer shares: no GPU, no files.
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

pub use glam;

pub mod appearance;
pub mod camera;
pub mod colormap;
pub mod entry;
pub mod error;
pub mod frame;
pub mod grid;
pub mod mesh;
pub mod number;
pub mod optics;
pub mod pick;
pub mod renderer;
pub mod settings;
pub mod text;
pub mod transfer_function;
pub mod view;
pub mod volume;

pub use appearance::{
    Abilities, Appearance, ClipPlane, DepthCue, DirectionalLight, Isosurface, Lighting,
    OpticalModel,
};
pub use camera::{Camera, CameraFit, Projection, Ray};
pub use entry::{Entry, Promise};
pub use error::{Error, ErrorKind};
pub use frame::{Counter, Frame, FrameStats};
pub use grid::Grid;
pub use mesh::{Cells, Scalars, TetMesh};
pub use renderer::VolumeRenderer;
pub use settings::{Setting, Settings, Values};
pub use transfer_function::{Knot, TransferFunction};
pub use view::View;
pub use volume::{Bounds, Volume, is_value};
