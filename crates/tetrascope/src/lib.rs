//! Volume rendering of unstructured meshes: pick an algorithm, know its error.
//!
//! Tetrascope draws tetrahedra, hexahedra, wedges and pyramids as they are, or resampled where
//! that is asked for. Each algorithm is a published one in a crate of its own; a ground
//! truth with a known error bound judges them all. This crate is the way in: the
//! registry of [`mod@algorithms`], [`volumes`] from files and data sets, and the command
//! line, `tetrascope`.
//!
//! ```
//! use tetrascope::core::VolumeRenderer as _;
//! use tetrascope::scene::{SceneFile, VolumeSource};
//! use tetrascope::{Context, Settings, algorithm, io, volumes};
//!
//! let mut file = SceneFile::new(VolumeSource {
//!     dataset: Some("sphere".into()), // or `file: Some("fin.vtu".into())`
//!     cells: Some(2000),
//!     ..VolumeSource::default()
//! });
//! file.image.width = Some(64);
//! let volume = volumes::load(&file.volume)?.volume;
//! let scene = file.resolve(&volume)?; // fills in camera, colors and opacity
//! let algorithm = algorithm("reference")?;
//! let settings = Settings::defaults(algorithm);
//! let renderer = (algorithm.build)(&Context::new(), &volume, &scene.appearance, &settings)?;
//! let frame = renderer.render(&scene.view)?; // premultiplied linear RGBA in f32
//! # let folder = tempfile::tempdir().expect("a folder for the picture");
//! # let path = folder.path().join("sphere.png");
//! io::write_image(&path, &frame, &[("Title".into(), "Sphere".into())])?;
//! # Ok::<(), tetrascope::core::Error>(())
//! ```
//!
//! # Features
//! One a renderer: `reference` and `raycast-cpu` (CPU), `projection`, `raycast-peel`, `resample`,
//! `slicing` and `voxel-hw` (GPU); `choose` picks among those that are compiled in; `cli` is the
//! program and `view` its viewer in the browser. Without them this crate reads and describes volumes and draws none.

pub use tetrascope_core as core;
pub use tetrascope_datasets as datasets;
#[cfg(feature = "gpu")]
pub use tetrascope_gpu as gpu;
pub use tetrascope_io as io;
#[cfg(feature = "projection")]
pub use tetrascope_projection as projection;
#[cfg(feature = "raycast-cpu")]
pub use tetrascope_raycast_cpu as raycast_cpu;
#[cfg(feature = "raycast-peel")]
pub use tetrascope_raycast_peel as raycast_peel;
#[cfg(feature = "reference")]
pub use tetrascope_reference as reference;
#[cfg(feature = "resample")]
pub use tetrascope_resample as resample;
pub use tetrascope_scene as scene;
#[cfg(feature = "slicing")]
pub use tetrascope_slicing as slicing;
#[cfg(feature = "voxel-hw")]
pub use tetrascope_voxel_hw as voxel_hw;

pub mod algorithms;
#[cfg(feature = "choose")]
pub mod choose;
#[cfg(feature = "cli")]
pub mod cli;
mod context;
pub mod emptiness;
mod help;
#[cfg(feature = "cli")]
pub mod provenance;
mod renderer;
#[cfg(feature = "resample")]
pub mod resampling;
#[cfg(feature = "signals")]
pub mod signals;
#[cfg(feature = "view")]
pub mod view;
pub mod volumes;

pub use algorithms::{Algorithm, algorithm, algorithms, truth};
pub use context::{Context, Progress};
pub use help::help;
pub use renderer::Renderer;
pub use tetrascope_core::{Entry, Promise, Setting, Settings, Values};

/// The program in the README is compiled as a test.
#[cfg(all(doctest, feature = "raycast-peel"))]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The algorithm in the guide is compiled as a test, and run.
#[cfg(all(doctest, feature = "reference"))]
#[doc = include_str!("../../../docs/adding-an-algorithm.md")]
struct AddingAnAlgorithm;
