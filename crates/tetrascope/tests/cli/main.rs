//! The program as its users meet it: what it prints, writes and returns.

mod bad_input;
mod choose;
mod clusters;
#[cfg(feature = "resample")]
mod convert;
mod curved;
mod dicom;
mod faults;
mod first;
mod grids;
mod lists;
mod pictures;
mod program;
#[cfg(feature = "resample")]
mod resampling;
mod series;
mod steps;
mod texts;
mod usage;
mod voxels;
