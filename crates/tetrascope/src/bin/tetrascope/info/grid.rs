//! `info` of a regular grid.

use serde_json::json;
use tetrascope::core::glam::DMat3;
use tetrascope::core::grid::{Interpolation, Lattice, SampleType};
use tetrascope::core::scene::default_unit_distance;
use tetrascope::core::{Bounds, OpticalModel};
use tetrascope::volumes::Loaded;

use super::{fields, notes};
use crate::output::{Output, Stop};

/// Prints what the grid on `lattice` consists of.
pub(super) fn print(
    loaded: &Loaded,
    lattice: &Lattice,
    sample_type: SampleType,
    output: &Output,
) -> Result<(), Stop> {
    let [nx, ny, nz] = lattice.dims;
    let cells: usize = lattice.cells().iter().product();
    let Bounds { min, max } = lattice.bounds();
    let DMat3 {
        x_axis,
        y_axis,
        z_axis,
    } = lattice.direction;
    let model = OpticalModel::EmissionAbsorption;
    let unit_distance = default_unit_distance(&loaded.volume, model).0;
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
            "bounds": [min, max],
            "unit_distance": unit_distance,
            "notes": loaded.notes,
        }));
    }
    let mut lines = vec![
        format!("samples        {nx}×{ny}×{nz} of {}", sample_type.name()),
        format!("cells          {cells}"),
    ];
    let filled = match lattice.interpolation {
        Interpolation::Linear => "linear, between samples",
        Interpolation::Nearest => "nearest, each sample fills a cell",
    };
    lines.push(format!("interpolation  {filled}"));
    lines.extend(fields(loaded));
    let space = match loaded.space {
        Some(space) => format!("{space} (x to the left, y to the back, z to the head)"),
        None => "the file's own".into(),
    };
    lines.push(format!("space          {space}"));
    lines.push(format!("origin         {}", lattice.origin));
    lines.push(format!("spacing        {}", lattice.spacing));
    lines.push(format!("axes           {x_axis}, {y_axis}, {z_axis}"));
    lines.push(format!("bounds         {min} to {max}"));
    lines.push(format!("unit distance  {unit_distance}"));
    lines.extend(notes(loaded));
    output.lines(&lines)
}
