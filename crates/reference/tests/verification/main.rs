//! The ground truth against closed forms, against itself, and against hostile input.

mod closed_forms;
mod scenes;
