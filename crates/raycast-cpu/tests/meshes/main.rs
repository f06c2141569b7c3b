//! Meshes against the ground truth.

mod common;

mod look;
mod models;
mod reference;
mod same;
