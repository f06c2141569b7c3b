//! Findings and repairs while a mesh was built.

use std::collections::BTreeMap;

use super::type_name;

/// Counts of what a mesh consists of and of what is wrong with it.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct MeshReport {
    /// How many input cells there are of each VTK type, drawn or not.
    pub cells_by_type: BTreeMap<u8, usize>,
    /// Tetrahedra that are drawn.
    pub tetrahedra: usize,
    /// Input cells whose corners came in the opposite orientation; fixed. Wedges are
    /// not counted, as both of their orders are in use.
    pub flipped: usize,
    /// Input cells so warped that some of their tetrahedra are inverted relative to
    /// the others. Each is oriented for itself, so they overlap.
    pub folded: usize,
    /// Tetrahedra without volume; kept, as they hold the mesh together, and harmless.
    ///
    /// The test is relative to the cell: its determinant is within the rounding
    /// error of its own evaluation in f64 (Shewchuk 1997, bound A), so that its
    /// coordinates cannot tell it from a flat one.
    pub degenerate: usize,
    /// Tetrahedra left out because two of their corners are one point or coincide; they
    /// have no inside, and the cells on their two sides share a face directly.
    pub collapsed: usize,
    /// Tetrahedra left out because an earlier one has the same four corners: the same
    /// points, or points that coincide with them, whose values are not drawn then.
    /// Both together would fill their space twice.
    pub duplicates: usize,
    /// Curved cells, drawn by their corners.
    pub quadratic: usize,
    /// Cells that are points, curves or surfaces, by VTK type; left out.
    pub skipped: BTreeMap<u8, usize>,
    /// Points that no cell names. (Those in the middle of a curved cell's edges are named.)
    pub unused_points: usize,
    /// Points that lie exactly where an earlier one does, of those that tetrahedra use.
    pub coincident_points: usize,
    /// Faces between two tetrahedra that have different points there, which coincide:
    /// they are neighbors, and each keeps its own values.
    pub joined_faces: usize,
    /// Cells with a quadrilateral that is so far from planar that the diagonals along which
    /// it can be cut pass each other at more than a hundredth of their length.
    pub warped: usize,
    /// The greatest such distance in any cell, as a part of the longer diagonal.
    pub warp: f64,
    /// Faces that three or more tetrahedra share; each takes it as boundary.
    pub crowded_faces: usize,
    /// Quadrilaterals of cells that were cut along one diagonal where the two triangles on their other side are cut along the
    /// other: none of the four has a neighbor. Nothing is lost where the quadrilateral is planar.
    pub crossed_faces: usize,
    /// Infinite or undefined values, at points that tetrahedra use or in cells; transparent.
    pub non_finite_scalars: usize,
}

impl MeshReport {
    /// One line on each thing that a user may want to know; empty for a clean mesh.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        };
        for (&cell_type, &count) in &self.skipped {
            note(
                count,
                &format!("× {}: no volume, left out", type_name(cell_type)),
            );
        }
        note(
            self.quadratic,
            "curved cells are drawn by their corners, with straight edges and linear fields",
        );
        note(self.flipped, "cells had the opposite orientation: fixed");
        note(self.folded, "cells are folded, so parts of them overlap");
        note(
            self.warped,
            &format!(
                "cells have faces that are not planar: each is cut along one diagonal, and the other passes it at up to {:.2} of its length",
                self.warp
            ),
        );
        note(self.degenerate, "tetrahedra have no volume: harmless");
        note(
            self.collapsed,
            "tetrahedra had two corners at one place: left out, harmless",
        );
        note(
            self.duplicates,
            "tetrahedra were there already: drawn once, by the first",
        );
        note(
            self.joined_faces,
            "faces were joined whose points coincide without being the same",
        );
        note(
            self.crowded_faces,
            "faces belong to more than two tetrahedra: cells overlap there, or the mesh is folded",
        );
        note(
            self.crossed_faces,
            "faces of cells meet tetrahedra that are cut along the other diagonal: exact where they are planar, else with gaps or overlaps as thick as they are warped",
        );
        note(self.unused_points, "points belong to no cell");
        note(
            self.non_finite_scalars,
            "scalars are not finite: transparent where NaN",
        );
        notes
    }
}
