//! Every algorithm held to closed forms, to laws and to the ground truth, in every optical model.
//!
//! One program, as each that is linked takes seconds.

mod among;
mod analytic;
mod comparison;
mod entries;
mod grids;
mod projection;
mod random_scenes;
mod real_data;
mod refusals;
mod resampled;
mod row;
mod stability;
mod voxelized;
