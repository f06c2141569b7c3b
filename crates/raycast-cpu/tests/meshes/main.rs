//! Meshes against the ground truth.

mod common;

mod clusters;
mod look;
mod models;
mod parts;
mod reference;
mod same;
