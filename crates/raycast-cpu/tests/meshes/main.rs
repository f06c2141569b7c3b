//! Meshes against the ground truth.

mod models;
