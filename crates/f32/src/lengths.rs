//! Lengths of rays in the cells of a mesh.

use rayon::prelude::*;
use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::FACES;

use crate::Normalization;

/// The longest edge of any cell, normalized: no ray is longer in a cell. 0 for a mesh without
/// cells.
pub fn longest_edge(mesh: &TetMesh, normalization: &Normalization) -> f32 {
    let edges = |cell| {
        let [a, b, c, d]: [DVec3; 4] = mesh.cell_points(cell);
        // Normalized first, so that no square overflows.
        let edges = [a - b, a - c, a - d, b - c, b - d, c - d].map(|e| e / normalization.scale);
        edges.map(DVec3::length_squared)
    };
    let longest = |cell| edges(cell).into_iter().fold(0.0, f64::max);
    let squares = (0..mesh.cell_count()).into_par_iter().map(longest);
    squares.reduce(|| 0.0, f64::max).sqrt() as f32
}

/// The mean length of a line in a cell of `mesh`, over all lines that meet it and all
/// cells, each as often as lines meet it; in world units, 0 for a mesh without cells.
///
/// 4 Σ V / Σ S of the cells' volumes and surfaces (Cauchy and Crofton: a convex body's mean
/// chord is 4 V / S, and lines meet it in proportion to S).
pub fn mean_chord(mesh: &TetMesh) -> f64 {
    let (mut volumes, mut surfaces) = (0.0, 0.0);
    for cell in 0..mesh.cell_count() {
        let points = mesh.cell_points(cell);
        let [p, q, r] = [1, 2, 3].map(|i| points[i] - points[0]);
        volumes += p.cross(q).dot(r).abs() / 6.0;
        surfaces += FACES
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|corner| points[corner]);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum::<f64>();
    }
    if surfaces > 0.0 {
        4.0 * volumes / surfaces
    } else {
        0.0
    }
}
