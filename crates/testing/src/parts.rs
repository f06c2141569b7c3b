//! A mesh in parts, as processes that share one have it.

use std::collections::{BTreeSet, HashMap};

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Scalars, TetMesh};

/// Four meshes of the cells of `mesh`, one for each quadrant around its middle. Each has the
/// points that its cells use, in their order.
pub fn quarters(mesh: &TetMesh) -> [TetMesh; 4] {
    let middle = mesh.bounds().center();
    let quadrant = |cell: usize| {
        let side = mesh.cell_points(cell).iter().sum::<DVec3>() / 4.0 - middle;
        usize::from(side.x > 0.0) + 2 * usize::from(side.y > 0.0)
    };
    [0, 1, 2, 3].map(|quarter| {
        let cells = (0..mesh.cell_count()).filter(|cell| quadrant(*cell) == quarter);
        let cells: Vec<[u32; 4]> = cells.map(|cell| mesh.tetrahedra()[cell]).collect();
        let used: BTreeSet<u32> = cells.iter().flatten().copied().collect();
        let numbers: HashMap<u32, u32> = used.iter().copied().zip(0..).collect();
        let points = used.iter().map(|point| mesh.points()[*point as usize]);
        let values = used
            .iter()
            .map(|point| mesh.scalars().values[*point as usize]);
        let points = points.collect();
        let values = values.collect();
        let cells = cells.iter().map(|cell| cell.map(|point| numbers[&point]));
        let cells = cells.collect();
        let scalars = Scalars {
            values,
            ..mesh.scalars().clone()
        };
        TetMesh::from_tetrahedra(points, cells, scalars).expect("a part of a mesh")
    })
}
