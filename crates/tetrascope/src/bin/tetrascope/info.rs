//! `info`: what a mesh or a grid consists of and what is wrong with it.

mod grid;

use serde_json::{Value, json};
use tetrascope::core::mesh::{BoundaryStatistics, MeshReport, type_name};
use tetrascope::core::scene::default_unit_distance;
use tetrascope::core::{Bounds, Error, OpticalModel, TetMesh, Volume};
use tetrascope::volumes::{self, FieldSummary, Loaded};

use crate::args::InfoArgs;
use crate::output::{Output, Stop};
use crate::scene::{source, usage};

pub(crate) fn run(args: &InfoArgs, output: &Output) -> Result<(), Stop> {
    let source = source(Some(&args.volume), &args.options)?;
    volumes::check(&source).map_err(usage)?;
    let what = format!("loading {}", args.volume.display());
    let (loaded, _) = output.timed(&what, || volumes::load(&source))?;
    let mesh = match &loaded.volume {
        Volume::Mesh(mesh) => mesh,
        Volume::Grid(grid) => {
            return grid::print(
                &loaded,
                grid.lattice(),
                grid.samples().sample_type(),
                output,
            );
        }
        Volume::Stream(stream) => {
            let source = stream.source();
            return grid::print(&loaded, &source.lattice(), source.sample_type(), output);
        }
        _ => return Err(Error::invalid("`info` describes meshes and grids").into()),
    };
    let (facts, _) = output.timed("examining the mesh", || Ok(Facts::of(&loaded, mesh)))?;
    if output.json() {
        return output.json_result(&facts.json());
    }
    output.lines(&facts.text())
}

/// The fields, a line each.
fn fields(loaded: &Loaded) -> Vec<String> {
    let mut lines = vec!["fields".into()];
    for FieldSummary {
        name,
        association,
        range,
        drawn,
        missing,
        offset,
    } in &loaded.fields
    {
        let range = match range {
            Some((low, high)) => format!("[{low}, {high}]"),
            None => "no finite value".into(),
        };
        let offset = match offset {
            0.0 => String::new(),
            offset => format!(" + {offset}"),
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

/// What was noticed, a line each.
fn notes(loaded: &Loaded) -> Vec<String> {
    let mut lines = vec!["notes".into()];
    if loaded.notes.is_empty() {
        lines.push("  none: no problems found".into());
    }
    lines.extend(loaded.notes.iter().map(|note| format!("  {note}")));
    lines
}

struct Facts<'a> {
    loaded: &'a Loaded,
    mesh: &'a TetMesh,
    bounds: Bounds,
    report: MeshReport,
    boundary: &'a BoundaryStatistics,
    unit_distance: f64,
}

impl Facts<'_> {
    fn of<'a>(loaded: &'a Loaded, mesh: &'a TetMesh) -> Facts<'a> {
        let model = OpticalModel::EmissionAbsorption;
        Facts {
            loaded,
            mesh,
            bounds: mesh.bounds(),
            report: mesh.report(),
            boundary: mesh.boundary_statistics(),
            unit_distance: default_unit_distance(&loaded.volume, model).0,
        }
    }

    fn text(&self) -> Vec<String> {
        let mut lines = vec!["cells".to_owned()];
        for (&kind, count) in &self.report.cells_by_type {
            lines.push(format!("  {} × {count}", type_name(kind)));
        }
        lines.push(format!("tetrahedra     {}", self.report.tetrahedra));
        lines.push(format!("points         {}", self.mesh.points().len()));
        lines.extend(fields(self.loaded));
        let Bounds { min, max } = self.bounds;
        lines.push(format!("bounds         {min} to {max}"));
        lines.push(format!("volume         {}", self.mesh.volume()));
        lines.push(format!("boundary       {}", self.shape()));
        lines.push(format!("unit distance  {}", self.unit_distance));
        lines.extend(notes(self.loaded));
        lines
    }

    /// The boundary in a line.
    fn shape(&self) -> String {
        let b = self.boundary;
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

    fn json(&self) -> Value {
        let r = &self.report;
        let b = self.boundary;
        let types = r.cells_by_type.iter();
        let types = types.map(
            |(&kind, count)| json!({"vtk_type": kind, "name": type_name(kind), "count": count}),
        );
        json!({
            "cells": types.collect::<Vec<Value>>(),
            "tetrahedra": r.tetrahedra,
            "points": self.mesh.points().len(),
            "coincident_points": r.coincident_points,
            "joined_faces": r.joined_faces,
            "fields": self.loaded.fields,
            "field": self.mesh.scalars().name,
            "bounds": [self.bounds.min, self.bounds.max],
            "volume": self.mesh.volume(),
            "boundary": {
                "faces": b.faces,
                "edges": b.edges,
                "vertices": b.vertices,
                "components": b.components,
                "euler_characteristic": b.euler_characteristic,
                "closed": b.closed,
                "convex": b.convex,
            },
            "unit_distance": self.unit_distance,
            "notes": self.loaded.notes,
        })
    }
}
