//! Properties that every mesh must have, for the tests of all data sets.

use std::collections::HashMap;

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Scalars, TetMesh};

pub(crate) fn point_scalars(values: Vec<f64>) -> Scalars {
    Scalars {
        name: "test".into(),
        association: Association::Point,
        values,
    }
}

/// Volume of cell `cell`, positive for a positively oriented one.
fn cell_volume(mesh: &TetMesh, cell: usize) -> f64 {
    let [a, b, c, d] = mesh.cell_points(cell);
    (b - a).dot((c - a).cross(d - a)) / 6.0
}

pub(crate) fn volume(mesh: &TetMesh) -> f64 {
    (0..mesh.cell_count()).map(|c| cell_volume(mesh, c)).sum()
}

/// ∫ f(linear scalar, position) over the mesh by the four-point rule of degree 2.
pub(crate) fn integral(mesh: &TetMesh, f: impl Fn(f64, DVec3) -> f64) -> f64 {
    // Keast's rule: barycentric (a, b, b, b) and permutations, equal weights.
    let a = (5.0 + 3.0 * 5f64.sqrt()) / 20.0;
    let b = (5.0 - 5f64.sqrt()) / 20.0;
    (0..mesh.cell_count())
        .map(|cell| {
            let (p, s) = (mesh.cell_points(cell), mesh.cell_scalars(cell));
            let points = (0..4).map(|corner| {
                let w = |i| if i == corner { a } else { b };
                let x: DVec3 = (0..4).map(|i| w(i) * p[i]).sum();
                f((0..4).map(|i| w(i) * s[i]).sum(), x)
            });
            cell_volume(mesh, cell) * points.sum::<f64>() / 4.0
        })
        .sum()
}

pub(crate) fn positive(mesh: &TetMesh) {
    for cell in 0..mesh.cell_count() {
        let volume = cell_volume(mesh, cell);
        assert!(volume > 0.0, "cell {cell} has volume {volume}");
    }
}

/// Faces of one cell only, each seen from inside in the sense of its cell.
pub(crate) fn boundary(mesh: &TetMesh) -> Vec<[u32; 3]> {
    let mut faces: HashMap<[u32; 3], ([u32; 3], usize)> = HashMap::new();
    for &[a, b, c, d] in mesh.tetrahedra() {
        for face in [[b, d, c], [a, c, d], [a, d, b], [a, b, c]] {
            let mut key = face;
            key.sort_unstable();
            faces.entry(key).or_insert((face, 0)).1 += 1;
        }
    }
    let mut single: Vec<[u32; 3]> = faces
        .into_values()
        .filter(|(_, count)| *count == 1)
        .map(|(face, _)| face)
        .collect();
    single.sort_unstable();
    single
}

/// No face has three cells, neighbors are on different sides, and the boundary is closed.
pub(crate) fn conforms(mesh: &TetMesh) {
    let mut faces: HashMap<[u32; 3], Vec<bool>> = HashMap::new();
    for &[a, b, c, d] in mesh.tetrahedra() {
        for face in [[b, d, c], [a, c, d], [a, d, b], [a, b, c]] {
            let mut key = face;
            key.sort_unstable();
            assert!(
                key[0] != key[1] && key[1] != key[2],
                "collapsed face {key:?}"
            );
            // The sense in which the cell runs around the sorted face.
            let start = face
                .iter()
                .position(|p| *p == key[0])
                .expect("sorted from it");
            faces
                .entry(key)
                .or_default()
                .push(face[(start + 1) % 3] == key[1]);
        }
    }
    for (face, senses) in &faces {
        assert!(
            senses.len() <= 2,
            "face {face:?} has {} cells",
            senses.len()
        );
        assert!(
            senses.len() == 1 || senses[0] != senses[1],
            "cells on one side of {face:?}"
        );
    }
    // Each directed edge of the boundary is met by its opposite as often.
    let mut edges: HashMap<[u32; 2], i64> = HashMap::new();
    for [a, b, c] in boundary(mesh) {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let (key, sign) = if p < q { ([p, q], 1) } else { ([q, p], -1) };
            *edges.entry(key).or_default() += sign;
        }
    }
    assert!(edges.values().all(|sum| *sum == 0), "the boundary is open");
    // Every point is used, so bounds and fields mean what they say.
    let mut used = vec![false; mesh.points().len()];
    mesh.tetrahedra()
        .iter()
        .flatten()
        .for_each(|&p| used[p as usize] = true);
    assert!(used.iter().all(|used| *used), "a point has no cell");
}
