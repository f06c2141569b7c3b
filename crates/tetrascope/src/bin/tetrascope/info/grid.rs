//! `info` of a regular grid.

use serde_json::json;
use tetrascope::core::glam::DMat3;
use tetrascope::core::grid::{Interpolation, Lattice, SampleType};
use tetrascope::core::number::{bounds, rounded, vector};
use tetrascope::volumes::Loaded;

use super::{fields, notes, step_line, unit_distance};
use crate::output::{Output, Stop};

/// Prints what the grid on `lattice` consists of.
pub(super) fn print(
    loaded: &Loaded,
    lattice: &Lattice,
    sample_type: SampleType,
    steps: &[f64],
    output: &Output,
) -> Result<(), Stop> {
    let [nx, ny, nz] = lattice.dims;
    let cells: usize = lattice.cells().iter().product();
    let bounding_box = lattice.bounds();
    let DMat3 {
        x_axis,
        y_axis,
        z_axis,
    } = lattice.direction;
    let unit_distance = unit_distance(&loaded.volume);
    if output.json() {
        return output.json_result(&json!({
            "dims": lattice.dims,
            "samples": sample_type.name(),
            "interpolation": lattice.interpolation,
            "cells": cells,
            "fields": loaded.fields,
            "field": loaded.field,
            "space": loaded.space,
            "origin": lattice.origin,
            "spacing": lattice.spacing,
            "axes": [x_axis, y_axis, z_axis],
            "bounds": [bounding_box.min, bounding_box.max],
            "unit_distance": unit_distance,
            "steps": steps,
            "notes": loaded.notes,
        }));
    }
    let mut lines: Vec<String> = step_line(steps).into_iter().collect();
    lines.extend([
        format!("samples        {nx}×{ny}×{nz} of {}", sample_type.name()),
        format!("cells          {cells}"),
    ]);
    let filled = match lattice.interpolation {
        Interpolation::Linear => "linear, between samples",
        Interpolation::Nearest => "nearest, each sample fills a cell",
    };
    lines.push(format!("interpolation  {filled}"));
    lines.extend(fields(&loaded.fields));
    let space = match loaded.space {
        Some(space) => format!("{space} (x to the left, y to the back, z to the head)"),
        None => "the file's own".into(),
    };
    lines.push(format!("space          {space}"));
    lines.push(format!("origin         {}", vector(lattice.origin)));
    lines.push(format!("spacing        {}", vector(lattice.spacing)));
    let axes = [x_axis, y_axis, z_axis].map(vector).join(", ");
    lines.push(format!("axes           {axes}"));
    lines.push(format!("bounds         {}", bounds(&bounding_box)));
    lines.push(format!("unit distance  {}", rounded(unit_distance)));
    lines.extend(notes(&loaded.notes));
    output.lines(&lines)
}
