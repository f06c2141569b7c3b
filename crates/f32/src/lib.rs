//! Numbers that leave f64, and what renderers make of them before any device is involved.
//!
//! Reading order: [`normalization`] is the one place where numbers are rounded to f32, relative
//! to a [`domain`]; [`knots`] and [`look`] round an appearance with it. [`lengths`] and
//! [`depth`] bound what a ray meets in a cell, [`flatness`] what rounding makes of it. [`image_plane`] is the camera of a view.
//! [`layout`] packs a mesh for rays that walk from cell to cell; [`rays`] and [`tiles`] find
//! where those of a view may enter it.
//!
//! # Words
//! - *Normalized space* is world space moved to the volume's center and divided by about half
//!   its size, so that the volume lies in the cube [−1, 1]³. Lengths and extinctions are
//!   normalized alike.
//! - A *mapped scalar* has the transfer function's range as [0, 1] ([`ScalarMap`]).
//! - A ray's *anchor* is where it starts to count: a point of it near the volume, so that f32
//!   resolves depths along the ray however far the eye is.
//!
//! # Far from the origin
//! ```
//! use tetrascope_core::Bounds;
//! use tetrascope_core::glam::{DVec3, Vec3};
//! use tetrascope_f32::{Domain, Normalization};
//!
//! // Half of a mesh a meter wide, 6000 km from the origin, where f32 resolves half a meter.
//! let corner = DVec3::new(6.0e6, 0.0, 0.0);
//! let own = Domain {
//!     bounds: Bounds::of([corner, corner + DVec3::new(0.5, 1.0, 1.0)]),
//!     scalar_range: Some((0.0, 0.7)),
//! };
//! // Both halves are relative to the whole, so that their shared points are the same in f32.
//! let whole = Domain {
//!     bounds: Bounds::of([corner, corner + DVec3::ONE]),
//!     scalar_range: Some((0.0, 1.0)),
//! };
//! let domain = own.within(Some(whole))?;
//! let normalization = Normalization::of(&domain.bounds);
//! let middle = corner + DVec3::splat(0.5);
//! assert_eq!(normalization.position(middle), Vec3::ZERO);
//! let millimeter = normalization.position(middle + DVec3::new(1e-3, 0.0, 0.0)).x;
//! assert!((f64::from(millimeter) * normalization.scale - 1e-3).abs() < 1e-8);
//! # Ok::<(), tetrascope_core::Error>(())
//! ```

pub mod depth;
pub mod domain;
pub mod flatness;
pub mod image_plane;
pub mod knots;
pub mod layout;
pub mod lengths;
pub mod look;
pub mod normalization;
pub mod rays;
pub mod tiles;

pub use depth::{ANY_SCALAR, deepest, is_transparent};
pub use domain::Domain;
pub use flatness::say_if_flat;
pub use image_plane::ImagePlane;
pub use knots::KnotPair;
pub use layout::{Layout, Locality};
pub use lengths::{longest_edge, mean_chord};
pub use look::Look;
pub use normalization::{Normalization, ScalarMap};
pub use rays::Rays;
pub use tiles::Tiles;
