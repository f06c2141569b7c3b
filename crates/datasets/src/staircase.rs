//! Prakash and Manohar's staircase: 23 hexahedra of one scalar.
//!
//! The paper says only this of it (section 6.2): it contains 23 cells, is a
//! regular grid, and "all the vertices have the same scalar value". The rest is
//! our reconstruction, a staircase around a corner: on a floor of 3 × 3 cells
//! stand columns of 4 − max(i, j) cells, which are 4 + 3 · 3 + 5 · 2 = 23.

use std::sync::Arc;

use tetrascope_core::mesh::{Association, Split};
use tetrascope_core::{CameraFit, Cells, Error, Scalars, TetMesh};

use crate::lattice::{Lattice, nearest_factors};
use crate::{Dataset, Look, MOST_CELLS, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "staircase",
    about: "23 hexahedra of one scalar, non-convex; sizes count hexahedra",
    paper: "Prakash, Manohar 1995, section 6.2 (cells and scalar; the shape is a reconstruction)",
    default_cells: 23,
    max_cells: MOST_CELLS / 6,
    seeded: false,
    make: Make::Mesh(make),
    cells: None,
    look,
};

/// Cells along each axis of the box around the stairs.
const SIZE: [usize; 3] = [3, 3, 4];

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    // Parts of a cell along each axis.
    let parts = nearest_factors(cells, 23);
    let axis = |a: usize| {
        (0..=SIZE[a] * parts[a])
            .map(|i| i as f64 / parts[a] as f64)
            .collect()
    };
    let lattice = Lattice {
        axes: [axis(0), axis(1), axis(2)],
    };
    let mut corners = Vec::new();
    let [nx, ny, nz] = lattice.cubes();
    let strides = lattice.strides();
    for (k, j) in (0..nz).flat_map(|k| (0..ny).map(move |j| (k, j))) {
        let is_inside = |i: &usize| k / parts[2] < 4 - (i / parts[0]).max(j / parts[1]);
        for i in (0..nx).filter(is_inside) {
            let first = i + j * strides[1] + k * strides[2];
            // VTK's order: around the lower face, then around the upper one.
            for (x, y, z) in HEXAHEDRON {
                corners.push((first + x + y * strides[1] + z * strides[2]) as u32);
            }
        }
    }
    let used = lattice.used(&mut corners);
    let count = corners.len() / HEXAHEDRON.len();
    let cells = Cells {
        types: vec![12; count],
        offsets: (0..=count).map(|i| 8 * i as u64).collect(),
        connectivity: corners.into_iter().map(u64::from).collect(),
    };
    let points = lattice.points();
    let points: Vec<_> = used.iter().map(|&p| points[p as usize]).collect();
    let scalars = Scalars {
        name: "scalar".into(),
        association: Association::Point,
        values: vec![1.0; points.len()],
    };
    // The paper fills them as they are.
    TetMesh::keeping_cells(points, Arc::new(cells), scalars, Split::default())
}

/// The corners of a VTK hexahedron in its cube.
const HEXAHEDRON: [(usize, usize, usize); 8] = [
    (0, 0, 0),
    (1, 0, 0),
    (1, 1, 0),
    (0, 1, 0),
    (0, 0, 1),
    (1, 0, 1),
    (1, 1, 1),
    (0, 1, 1),
];

/// One color; a cell's edge takes away nearly half of the light.
fn look() -> Look {
    Look {
        fit: CameraFit::PlusIso,
        knots: vec![knot(1.0, [0.95, 0.62, 0.18], 0.6)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: Option<u64>) -> TetMesh {
        DATASET.mesh(&Options { cells, seed: None }).expect("valid")
    }

    #[test]
    fn there_are_23_cells_of_one_scalar() {
        let mesh = mesh(None);
        assert_eq!(mesh.report().cells_by_type.get(&12), Some(&23));
        assert_eq!(mesh.source_cell(mesh.cell_count() - 1), 22);
        assert_eq!(mesh.cells().expect("kept").types, [12; 23]);
        assert_eq!(mesh.scalar_range(), Some((1.0, 1.0)));
        // Unit cubes; sixths round.
        assert!((checks::volume(&mesh) - 23.0).abs() < 1e-13);
    }

    // From above, below and the two walls it is 3 × 3, 3 × 3 and twice
    // 4 + 3 + 2 = 9, and as much from the opposite sides: stairs hide nothing.
    #[test]
    fn the_surface_is_that_of_stairs() {
        for cells in [23, 23 * 8, 23 * 12, 23 * 64] {
            let mesh = mesh(Some(cells));
            checks::conforms(&mesh);
            checks::positive(&mesh);
            let area: f64 = checks::boundary(&mesh)
                .iter()
                .map(|f| {
                    let [a, b, c] = f.map(|p| mesh.points()[p as usize]);
                    (b - a).cross(c - a).length() / 2.0
                })
                .sum();
            assert!((area - 54.0).abs() < 1e-10, "{area}");
            assert!((checks::volume(&mesh) - 23.0).abs() < 1e-10);
            assert_eq!(mesh.source_cell(mesh.cell_count() - 1) as u64, cells - 1);
        }
    }
}
