//! A scene: which volume, how it looks, from where; as TOML or JSON.
//!
//! [`SceneFile`] is what a person writes, nearly all of it optional.
//! [`SceneFile::resolve`] fills the rest from the volume and gives a [`Scene`],
//! which is complete and prints as a scene file again.
//!
//! Reading order: `file` reads and parses; `source`, `camera` and `appearance` are the
//! parts of a scene as written; `complete` fills in what they leave out, by `defaults`,
//! which looks at how the field's values are spread (`distribution`). Defaults ask a `subject`,
//! which is a volume or a [`Survey`] of several. `preset` has transfer functions as people edit them
//! and as ParaView keeps them, `values` the histogram beside which they do.
//!
//! ```
//! use tetrascope_core::glam::DVec3;
//! use tetrascope_core::mesh::Association;
//! use tetrascope_core::{Scalars, TetMesh, Volume};
//! use tetrascope_scene::SceneFile;
//!
//! let text = "version = 1\n[appearance]\ncolormap = \"magma\"";
//! let file = SceneFile::parse(text, "scene.toml".as_ref())?;
//! let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let scalars = Scalars {
//!     name: "height".into(),
//!     association: Association::Point,
//!     values: vec![0.0, 0.0, 0.0, 1.0],
//! };
//! let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3]], scalars)?;
//! let scene = file.resolve(&Volume::Mesh(mesh))?;
//! assert_eq!(scene.appearance.transfer_function.range(), (0.0, 1.0));
//! assert_eq!(scene.defaults[0], "camera: fit+iso");
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

mod appearance;
mod camera;
mod complete;
mod defaults;
mod distribution;
mod file;
mod nearest;
mod preset;
mod source;
mod subject;
mod survey;
mod values;

pub use appearance::{AppearanceSpec, IsosurfaceSpec};
pub use camera::{CameraSpec, ProjectionKind};
pub use complete::Scene;
pub use defaults::{default_side, default_unit_distance};
pub use file::{ImageSpec, MAX_SCENE_BYTES, SCENE_VERSION, SceneFile};
pub use nearest::nearest;
pub use preset::{ColorPoint, ColorSpace, MAX_PRESET_POINTS, OpacityPoint, Preset, ReadPreset};
pub use source::VolumeSource;
pub use survey::Survey;
pub use values::FieldValues;
