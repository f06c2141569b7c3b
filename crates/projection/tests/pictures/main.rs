//! Pictures of cell projection against the ground truth.

mod common;

mod look;
mod order;
mod parts;
mod per_vertex;
mod surfaces;
mod tables;
mod truth;
