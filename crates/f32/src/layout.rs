//! A mesh packed for rays that walk from cell to cell: 20 bytes per cell and 16 per vertex.
//!
//! A cell is the exclusive or of its four vertex ids and its four neighbors by
//! increasing id of the opposite vertex: whoever comes in through a face knows
//! three ids and gets the fourth. (A. Aman, S. Demirci, U. Güdükbay, "Compact
//! Tetrahedralization-based Acceleration Structures for Ray Tracing", 2022, Tet20.)
//!
//! Points at one place are one vertex ([`TetMesh::places`]), so that a ray goes on from cell
//! to cell where cells touch and share no points.

use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::NO_NEIGHBOR;

/// A neighbor with this bit set is the boundary face of the other bits.
pub const AT_BOUNDARY: u32 = 1 << 31;

/// Cells and vertices in the order in which they lie in memory.
#[derive(Debug)]
pub struct Layout {
    /// The exclusive or of each cell's vertex ids.
    pub sums: Vec<u32>,
    /// What is behind the faces opposite each cell's vertices, by increasing id.
    pub neighbors: Vec<[u32; 4]>,
    /// Vertex ids and the cell behind, one per boundary face.
    pub boundary: Vec<[u32; 4]>,
    /// The mesh's own number of each vertex: of one point at each place that cells use.
    pub vertex_order: Vec<u32>,
    /// The mesh's own number of each cell.
    pub cell_order: Vec<u32>,
}

/// The order in which cells and vertices lie in memory.
///
/// CPU seconds a frame of 256x256 on a sphere of 2 M cells, 5.3 M visits, medians of five frames
/// drawn in turn on llvmpipe (Mesa 22.3.6, a busy machine): 0.63 along a Morton curve, 0.66 in
/// the lattice's own order, 0.82 breadth-first from neighbor to neighbor, 1.15 at random. So
/// Morton is worth little for a mesh that a lattice has ordered, and 1.8 for one without order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Locality {
    /// As the mesh has them.
    AsGiven,
    /// Along a Morton curve through their centers, so that rays side by side
    /// read memory side by side.
    Morton,
}

tetrascope_core::choices! {
    Locality: "morton" = Morton, "as-given" = AsGiven;
}

impl Layout {
    /// Packs `mesh`.
    pub fn new(mesh: &TetMesh, locality: Locality) -> Layout {
        let cells = mesh.places();
        let cell_order = cell_order(mesh, locality);
        let point = |point: u32| mesh.points()[point as usize];
        let used = used(mesh);
        let vertex_order = match locality {
            Locality::AsGiven => used,
            Locality::Morton => morton_order(mesh, used, point),
        };
        let cell_at = inverse(&cell_order);
        let vertex_at = vertex_at(mesh, &vertex_order);
        let mut sums = Vec::with_capacity(cells.len());
        let mut neighbors = Vec::with_capacity(cells.len());
        let mut boundary = Vec::new();
        for (cell, &old) in cell_order.iter().enumerate() {
            let ids = cells[old as usize].map(|v| vertex_at[v as usize]);
            sums.push(ids[0] ^ ids[1] ^ ids[2] ^ ids[3]);
            neighbors.push(by_id(ids).map(|corner| {
                let neighbor = mesh.neighbors()[old as usize][corner];
                if neighbor == NO_NEIGHBOR {
                    let [a, b, c] = face_opposite(ids, corner);
                    boundary.push([a, b, c, cell as u32]);
                    AT_BOUNDARY | (boundary.len() - 1) as u32
                } else {
                    cell_at[neighbor as usize]
                }
            }));
        }
        Layout {
            sums,
            neighbors,
            boundary,
            vertex_order,
            cell_order,
        }
    }

    /// Four values per cell, by increasing vertex id of the corner, in the order of the cells;
    /// `of` gives those of the mesh's cell with that number, in the mesh's order.
    pub fn of_corners<T>(&self, mesh: &TetMesh, of: impl Fn(u32) -> [T; 4]) -> Vec<[T; 4]>
    where
        T: Copy,
    {
        let vertex_at = vertex_at(mesh, &self.vertex_order);
        let cells = self.cell_order.iter();
        cells
            .map(|&cell| {
                let own = of(cell);
                by_id(mesh.places()[cell as usize].map(|v| vertex_at[v as usize])).map(|i| own[i])
            })
            .collect()
    }
}

/// The places that cells use, increasing.
fn used(mesh: &TetMesh) -> Vec<u32> {
    let mut is_used = vec![false; mesh.points().len()];
    for &place in mesh.places().iter().flatten() {
        is_used[place as usize] = true;
    }
    let numbered = (0..).zip(is_used);
    numbered
        .filter(|(_, is)| *is)
        .map(|(place, _)| place)
        .collect()
}

/// The vertex at each place, by the mesh's own number.
fn vertex_at(mesh: &TetMesh, vertex_order: &[u32]) -> Vec<u32> {
    let mut vertices = vec![0; mesh.points().len()];
    for (vertex, &place) in (0..).zip(vertex_order) {
        vertices[place as usize] = vertex;
    }
    vertices
}

/// The mesh's own number of each cell, in the order in which they are to lie in memory.
pub fn cell_order(mesh: &TetMesh, locality: Locality) -> Vec<u32> {
    let center = |cell: u32| mesh.cell_points(cell as usize).iter().sum::<DVec3>() / 4.0;
    let cells = (0..mesh.cell_count() as u32).collect();
    match locality {
        Locality::AsGiven => cells,
        Locality::Morton => morton_order(mesh, cells, center),
    }
}

/// The corners 0…3 by increasing vertex id.
fn by_id(ids: [u32; 4]) -> [usize; 4] {
    let mut corners = [0, 1, 2, 3];
    corners.sort_unstable_by_key(|&corner| ids[corner]);
    corners
}

/// The other three ids, increasing: one order for both sides of a face.
fn face_opposite(ids: [u32; 4], corner: usize) -> [u32; 3] {
    let mut face = [0, 1, 2].map(|i| ids[(corner + 1 + i) % 4]);
    face.sort_unstable();
    face
}

/// Where each number lies in `order`.
pub fn inverse(order: &[u32]) -> Vec<u32> {
    let mut places = vec![0; order.len()];
    for (place, &old) in order.iter().enumerate() {
        places[old as usize] = place as u32;
    }
    places
}

/// Items by the Morton code of their position in the mesh's box.
fn morton_order(mesh: &TetMesh, mut order: Vec<u32>, position: impl Fn(u32) -> DVec3) -> Vec<u32> {
    let bounds = mesh.bounds();
    let size = bounds.size().max_element().max(f64::MIN_POSITIVE);
    let code = |item: u32| {
        // 21 bits an axis fill a u64.
        let p = (position(item) - bounds.min) / size * f64::from((1u32 << 21) - 1);
        spread(p.x as u32) | spread(p.y as u32) << 1 | spread(p.z as u32) << 2
    };
    order.sort_by_cached_key(|&item| code(item));
    order
}

/// Bit i of `value` at place 3 i.
fn spread(value: u32) -> u64 {
    let mut x = u64::from(value & 0x1f_ffff);
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}
