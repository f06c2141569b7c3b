//! `info`: what a mesh or a grid consists of and what is wrong with it.

mod clusters;
mod grid;

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};
use tetrascope::core::mesh::{BoundaryStatistics, MeshReport, type_name};
use tetrascope::core::{Bounds, Error, OpticalModel, TetMesh, Volume, number};
use tetrascope::io::read_steps;
use tetrascope::scene::{default_side, default_unit_distance};
use tetrascope::volumes::{self, BareMesh, Contents, FieldSummary, Loaded};

use crate::args::InfoArgs;
use crate::output::{Output, Stop};
use crate::scene::{source, usage};

pub(crate) fn run(args: &InfoArgs, output: &Output) -> Result<(), Stop> {
    let source = source(Some(&args.volume), &args.options)?;
    volumes::check(&source).map_err(usage)?;
    let what = format!("loading {}", args.volume.display());
    let (contents, _) = output.timed(&what, || volumes::examine(&source))?;
    let file = source.file.as_deref();
    let steps = file.map_or(Ok(Vec::new()), steps_of)?;
    let loaded = match contents {
        Contents::Bare(bare) => return print(|| Facts::of_bare(&bare), &steps, output),
        Contents::Drawable(loaded) => loaded,
    };
    match &loaded.volume {
        Volume::Mesh(mesh) => print(|| Facts::of(&loaded, mesh), &steps, output),
        Volume::Grid(grid) => grid::print(
            &loaded,
            grid.lattice(),
            grid.samples().sample_type(),
            &steps,
            output,
        ),
        Volume::Stream(stream) => {
            let source = stream.source();
            grid::print(
                &loaded,
                &source.lattice(),
                source.sample_type(),
                &steps,
                output,
            )
        }
        Volume::Clusters(mesh) => clusters::print(&loaded, mesh, output),
        _ => Err(Error::invalid("`info` describes meshes and grids").into()),
    }
}

/// Finds and prints the facts of a mesh.
fn print<'a>(
    facts: impl FnOnce() -> Facts<'a>,
    steps: &[f64],
    output: &Output,
) -> Result<(), Stop> {
    let (facts, _) = output.timed("examining the mesh", || Ok(facts()))?;
    if output.json() {
        let mut json = facts.json();
        json["steps"] = json!(steps);
        return output.json_result(&json);
    }
    let mut lines = facts.text();
    lines.splice(0..0, step_line(steps));
    output.lines(&lines)
}

/// The times of the steps that a file holds; none of a file of samples alone.
fn steps_of(path: &Path) -> Result<Vec<f64>, Error> {
    match read_steps(path) {
        // It was read by what the command line says is in it.
        Err(Error::Format { .. }) => Ok(Vec::new()),
        steps => steps,
    }
}

/// How many time steps there are, and when.
fn step_line(times: &[f64]) -> Option<String> {
    const MOST: usize = 8;
    let last = times.len().checked_sub(1)?;
    let mut words: Vec<String> = times.iter().take(MOST).map(f64::to_string).collect();
    if last >= MOST {
        words.push(format!("… {}", times[last]));
    }
    let words = words.join(", ");
    Some(format!(
        "time steps     {}, 0 to {last}, at {words}",
        times.len()
    ))
}

/// The unit distance of a first picture.
fn unit_distance(volume: &Volume) -> f64 {
    let (side, _) = default_side(volume);
    let (toward_eye, _) = side.axes();
    default_unit_distance(volume, OpticalModel::EmissionAbsorption, -toward_eye).0
}

/// The fields, a line each.
fn fields(fields: &[FieldSummary]) -> Vec<String> {
    let mut lines = vec!["fields".into()];
    if fields.is_empty() {
        lines.push("  no fields".into());
    }
    for FieldSummary {
        name,
        association,
        range,
        drawn,
        missing,
        offset,
    } in fields
    {
        let range = match range {
            Some(range) => number::range(*range),
            None => "no finite value".into(),
        };
        let offset = match offset {
            0.0 => String::new(),
            offset => format!(" + {}", number::exact(*offset)),
        };
        let missing = match missing {
            None | Some(0) => String::new(),
            Some(missing) => format!(", {missing} without a value"),
        };
        let drawn = if *drawn { ", drawn" } else { "" };
        lines.push(format!(
            "  {name} {range}{offset} ({association}{missing}{drawn})"
        ));
    }
    lines
}

/// The notes, one per line.
fn notes(notes: &[String]) -> Vec<String> {
    let mut lines = vec!["notes".into()];
    if notes.is_empty() {
        lines.push("  none: no problems found".into());
    }
    lines.extend(notes.iter().map(|note| format!("  {note}")));
    lines
}

/// Facts about a mesh.
struct Facts<'a> {
    cells_by_type: BTreeMap<u8, usize>,
    points: usize,
    fields: &'a [FieldSummary],
    /// The one that is drawn.
    field: Option<&'a str>,
    bounds: Bounds,
    /// Facts about the cells of a mesh with volume cells.
    cells: Option<CellFacts<'a>>,
    /// The unit distance of a mesh that can be drawn.
    unit_distance: Option<f64>,
    notes: Vec<String>,
}

/// Facts about volume cells.
struct CellFacts<'a> {
    report: MeshReport,
    volume: f64,
    boundary: &'a BoundaryStatistics,
}

impl CellFacts<'_> {
    fn of(mesh: &TetMesh) -> CellFacts<'_> {
        CellFacts {
            report: mesh.report(),
            volume: mesh.volume(),
            boundary: mesh.boundary_statistics(),
        }
    }
}

impl Facts<'_> {
    fn of<'a>(loaded: &'a Loaded, mesh: &'a TetMesh) -> Facts<'a> {
        let cells = CellFacts::of(mesh);
        Facts {
            cells_by_type: cells.report.cells_by_type.clone(),
            points: mesh.points().len(),
            fields: &loaded.fields,
            field: Some(&loaded.field),
            bounds: mesh.bounds(),
            cells: Some(cells),
            unit_distance: Some(unit_distance(&loaded.volume)),
            notes: loaded.notes.clone(),
        }
    }

    fn of_bare(bare: &BareMesh) -> Facts<'_> {
        let mut notes = vec![format!("{}: there is nothing to draw", bare.why)];
        notes.extend(bare.notes.iter().cloned());
        Facts {
            cells_by_type: bare.cells_by_type.clone(),
            points: bare.points,
            fields: &bare.fields,
            field: None,
            bounds: bare.bounds,
            cells: bare.mesh.as_ref().map(CellFacts::of),
            unit_distance: None,
            notes,
        }
    }

    fn text(&self) -> Vec<String> {
        let mut lines = vec!["cells".to_owned()];
        for (&kind, count) in &self.cells_by_type {
            lines.push(format!("  {} × {count}", type_name(kind)));
        }
        if self.cells_by_type.is_empty() {
            lines.push("  no cells".into());
        }
        let cells = self.cells.as_ref();
        let tetrahedra = cells.map_or(0, |cells| cells.report.tetrahedra);
        lines.push(format!("tetrahedra     {tetrahedra}"));
        lines.push(format!("points         {}", self.points));
        lines.extend(fields(self.fields));
        if !self.bounds.is_empty() {
            lines.push(format!("bounds         {}", number::bounds(&self.bounds)));
        }
        if let Some(cells) = cells {
            lines.push(format!("volume         {}", number::rounded(cells.volume)));
            lines.push(format!("boundary       {}", shape(cells.boundary)));
        }
        if let Some(distance) = self.unit_distance {
            lines.push(format!("unit distance  {}", number::rounded(distance)));
        }
        lines.extend(notes(&self.notes));
        lines
    }

    fn json(&self) -> Value {
        let types = self.cells_by_type.iter();
        let types = types.map(
            |(&kind, count)| json!({"vtk_type": kind, "name": type_name(kind), "count": count}),
        );
        let boundary = |b: &BoundaryStatistics| {
            json!({
                "faces": b.faces,
                "edges": b.edges,
                "vertices": b.vertices,
                "components": b.components,
                "euler_characteristic": b.euler_characteristic,
                "closed": b.closed,
                "convex": b.convex,
            })
        };
        let cells = self.cells.as_ref();
        let bounds = [self.bounds.min, self.bounds.max];
        json!({
            "cells": types.collect::<Vec<Value>>(),
            "tetrahedra": cells.map_or(0, |cells| cells.report.tetrahedra),
            "points": self.points,
            "coincident_points": cells.map_or(0, |cells| cells.report.coincident_points),
            "joined_faces": cells.map_or(0, |cells| cells.report.joined_faces),
            "crossed_faces": cells.map_or(0, |cells| cells.report.crossed_faces),
            "fields": self.fields,
            "field": self.field,
            "bounds": (!self.bounds.is_empty()).then_some(bounds),
            "volume": cells.map(|cells| cells.volume),
            "boundary": cells.map(|cells| boundary(cells.boundary)),
            "unit_distance": self.unit_distance,
            "notes": self.notes,
        })
    }
}

/// The boundary in a line.
fn shape(b: &BoundaryStatistics) -> String {
    let convex = if b.convex { "convex" } else { "not convex" };
    let closed = if b.closed {
        "closed"
    } else {
        "not a closed surface"
    };
    let parts = match b.components {
        1 => "one part".into(),
        n => format!("{n} parts"),
    };
    format!(
        "{} triangles, {convex}, {closed}, {parts}, Euler characteristic {}",
        b.faces, b.euler_characteristic
    )
}
