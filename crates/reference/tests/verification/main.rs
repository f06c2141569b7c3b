//! The ground truth against closed forms, against itself, and against hostile input.

mod adversarial;
mod closed_forms;
mod grid_cells;
mod grid_look;
mod grids;
mod look;
mod metamorphic;
mod scenes;
