//! Numbers that leave f64, and what renderers make of them before any device is involved.
//!
//! Reading order: [`normalization`] is the one place where numbers are rounded to f32, relative
//! to a [`domain`];
//! [`knots`] and [`look`] round an appearance with it. [`lengths`] and [`depth`] bound
//! what a ray meets in a cell. [`image_plane`] is the camera of a view.
//! [`layout`] packs a mesh for rays that walk from cell to cell; [`rays`] and [`tiles`] find where those of a view may enter it.
//!
//! # Words
//! - *Normalized space* is world space moved to the volume's center and divided by about half
//!   its size, so that the volume lies in the cube [−1, 1]³. Lengths and extinctions are
//!   normalized alike.
//! - A *mapped scalar* has the transfer function's range as [0, 1] ([`ScalarMap`]).
//! - A ray's *anchor* is where it starts to count: a point of it near the volume, so that f32
//!   resolves depths along the ray however far the eye is.

pub mod depth;
pub mod domain;
pub mod image_plane;
pub mod knots;
pub mod layout;
pub mod lengths;
pub mod look;
pub mod normalization;
pub mod rays;
pub mod tiles;

pub use depth::{ANY_SCALAR, deepest};
pub use domain::Domain;
pub use image_plane::ImagePlane;
pub use knots::KnotPair;
pub use layout::{Layout, Locality};
pub use lengths::{longest_edge, mean_chord};
pub use look::Look;
pub use normalization::{Normalization, ScalarMap};
pub use rays::Rays;
pub use tiles::Tiles;
