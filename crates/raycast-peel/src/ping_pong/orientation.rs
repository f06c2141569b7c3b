//! Which way round cells are, so that a face's two cells see it from opposite sides.
//!
//! [`TetMesh`] orders the corners of a cell so that its volume is positive. A flat cell has none
//! and comes in either order; and where a mesh is folded, two positive cells are on the same
//! side of the face between them. A ray that crosses faces by sides would turn back there.

use std::collections::VecDeque;

use tetrascope_core::TetMesh;
use tetrascope_core::mesh::{FACES, NO_NEIGHBOR};

/// Whether the last two corners of each cell are to be exchanged; see [`ordered`].
///
/// In each part of the mesh most of the volume stays as it is. Where cells cannot be ordered,
/// as in a strip with a twist, some face is still seen from one side by both.
pub(super) fn exchanged(mesh: &TetMesh) -> Vec<bool> {
    let count = mesh.cell_count();
    let mut exchanged: Vec<Option<bool>> = vec![None; count];
    for seed in 0..count {
        if exchanged[seed].is_some() {
            continue;
        }
        exchanged[seed] = Some(false);
        let mut part = vec![seed];
        let mut volume = 0.0;
        let mut queue = VecDeque::from([seed]);
        while let Some(cell) = queue.pop_front() {
            let own = exchanged[cell] == Some(true);
            let size = size(mesh, cell);
            volume += if own { -size } else { size };
            for (opposite, &neighbor) in mesh.neighbors()[cell].iter().enumerate() {
                let next = neighbor as usize;
                if neighbor == NO_NEIGHBOR || exchanged[next].is_some() {
                    continue;
                }
                exchanged[next] = Some(own != turns_back(mesh, cell, opposite, next));
                part.push(next);
                queue.push_back(next);
            }
        }
        if volume < 0.0 {
            for cell in part {
                exchanged[cell] = exchanged[cell].map(|is| !is);
            }
        }
    }
    exchanged.into_iter().map(|is| is == Some(true)).collect()
}

/// The values that a cell has at its corners, the last two `exchanged`.
pub(super) fn ordered<T>(exchanged: bool, [a, b, c, d]: [T; 4]) -> [T; 4] {
    if exchanged {
        [a, b, d, c]
    } else {
        [a, b, c, d]
    }
}

/// Six times the volume of a cell.
fn size(mesh: &TetMesh, cell: usize) -> f64 {
    let [a, b, c, d] = mesh.cell_points(cell);
    (b - a).cross(c - a).dot(d - a).abs()
}

/// Whether `cell` and `next` see the face between them, the one `opposite` a corner of `cell`,
/// from the same side.
fn turns_back(mesh: &TetMesh, cell: usize, opposite: usize, next: usize) -> bool {
    let face = |cell: usize, opposite: usize| {
        let corners = mesh.places()[cell];
        FACES[opposite].map(|corner| corners[corner])
    };
    let own = face(cell, opposite);
    let others = (0..4).map(|opposite| face(next, opposite));
    let mut shared = others.filter(|other| own.iter().all(|id| other.contains(id)));
    shared
        .next()
        .is_some_and(|other| is_odd(other) == is_odd(own))
}

/// Whether three numbers are sorted by an odd number of exchanges.
fn is_odd([a, b, c]: [u32; 3]) -> bool {
    (a > b) ^ (a > c) ^ (b > c)
}
