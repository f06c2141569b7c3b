//! Meshes against the ground truth.

mod common;

mod look;
mod models;
mod parts;
mod reference;
mod same;
