//! Regular grids against the ground truth and against closed forms.

mod bench;
mod closed_forms;
mod hostile;
mod models;
mod skipping;
