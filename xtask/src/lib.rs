//! The harness: everything that needs more than one crate.
//!
//! [`compare`] draws scenes with every algorithm and judges them by [`metrics`];
//! [`report`] writes what came out, with the [`answer`], [`diagrams`] of [`panel`]s, [`picture`]s and the [`figures`] that
//! a benchmark has measured; [`sweep`] runs the model of a machine, and [`voxel_figures`] draws its
//! paper's figures again; [`dashboard`] keeps what benchmarks measure and [`bench`] compares two revisions';
//! [`stability`] draws stiff and extreme cases; [`fuzz`] runs libFuzzer; [`gallery`] draws
//! the pictures of the guides; [`setup`] gets a machine ready to draw; [`snapshots`] are reviewed pictures
//! and texts; [`testing`] is what the tests here share.
#![cfg(feature = "harness")]

pub mod answer;
pub mod bench;
mod cargo;
pub mod compare;
pub mod dashboard;
pub mod diagrams;
#[cfg(test)]
mod documents;
pub mod figures;
pub mod fuzz;
pub mod gallery;
pub mod limits;
pub mod machine;
pub mod metrics;
pub mod output;
mod page;
pub mod panel;
pub mod picture;
pub mod plot;
pub mod rays;
pub mod report;
pub mod setup;
pub mod snapshots;
pub mod stability;
pub mod sweep;
pub mod testing;
pub mod voxel_figures;
