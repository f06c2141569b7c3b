//! A mesh packed for rays that walk from cell to cell: 20 bytes per cell and 16 per vertex.
//!
//! A cell is the exclusive or of its four vertex ids and its four neighbors by
//! increasing id of the opposite vertex: whoever comes in through a face knows
//! three ids and gets the fourth. (A. Aman, S. Demirci, U. Güdükbay, "Compact
//! Tetrahedralization-based Acceleration Structures for Ray Tracing", 2022, Tet20.)
//!
//! Points at one place are one vertex ([`TetMesh::places`]), so that a ray goes on from cell
//! to cell where cells touch and share no points.

use rayon::prelude::*;
use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_core::groups::Groups;
use tetrascope_core::mesh::NO_NEIGHBOR;

/// A neighbor with this bit set is the boundary face of the other bits.
pub const AT_BOUNDARY: u32 = 1 << 31;

/// The order in which cells and vertices lie in memory, and the boundary between them.
#[derive(Debug)]
pub struct Layout {
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
    /// Packs `mesh`; gives its cells, too, in their order, each made by `cell`.
    ///
    /// That gets the exclusive or of the cell's vertex ids, and what is behind the faces opposite
    /// its vertices, by increasing id. There is room for one more cell per boundary face.
    ///
    /// In parallel; takes 12 bytes per cell while it is made, besides what it returns.
    pub fn new<T: Send>(
        mesh: &TetMesh,
        locality: Locality,
        cell: impl Fn(u32, [u32; 4]) -> T + Sync,
    ) -> (Layout, Vec<T>) {
        let cell_order = cell_order(mesh, locality);
        let point = |point: u32| mesh.points()[point as usize];
        let used = used(mesh);
        let vertex_order = match locality {
            Locality::AsGiven => used,
            Locality::Morton => morton_order(mesh, used, point),
        };
        let cell_at = inverse(&cell_order);
        let vertex_at = vertex_at(mesh, &vertex_order);
        let places = mesh.places();
        let ids = |old: u32| {
            let [a, b, c, d] = places[old as usize];
            let id = |place: u32| vertex_at[place as usize];
            [id(a), id(b), id(c), id(d)]
        };

        // By cell, and in it by increasing id of the opposite vertex.
        let faces = mesh.boundary_faces().par_iter();
        let faces =
            faces.map(|&(old, corner)| (cell_at[old as usize], ids(old)[usize::from(corner)]));
        let mut faces: Vec<(u32, u32)> = faces.collect();
        faces.par_sort_unstable();
        let boundary = faces.par_iter().map(|&(cell, id)| {
            let ids = ids(cell_order[cell as usize]);
            let corner = ids.iter().position(|other| *other == id);
            let [a, b, c] = face_opposite(ids, corner.expect("an id of the cell's own"));
            [a, b, c, cell]
        });
        let boundary: Vec<[u32; 4]> = boundary.collect();

        let neighbors_of = mesh.neighbors();
        let packed = |(place, &old): (usize, &u32)| {
            let ids = ids(old);
            let mut neighbors = [0; 4];
            for (neighbor, corner) in neighbors.iter_mut().zip(by_id(ids)) {
                *neighbor = match neighbors_of[old as usize][corner] {
                    NO_NEIGHBOR => {
                        let face = faces.binary_search(&(place as u32, ids[corner]));
                        AT_BOUNDARY | face.expect("it is a boundary face") as u32
                    }
                    other => cell_at[other as usize],
                };
            }
            cell(ids[0] ^ ids[1] ^ ids[2] ^ ids[3], neighbors)
        };
        let mut cells = Vec::with_capacity(cell_order.len() + boundary.len());
        cells.par_extend(cell_order.par_iter().enumerate().map(packed));
        let layout = Layout {
            boundary,
            vertex_order,
            cell_order,
        };
        (layout, cells)
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
    let is_apart = std::ptr::eq(mesh.places(), mesh.tetrahedra());
    if is_apart {
        return mesh.points_in_use().collect();
    }
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
    let center = |cell: u32| {
        let [a, b, c, d] = mesh.cell_points(cell as usize);
        (a + b + c + d) / 4.0
    };
    let cells = (0..mesh.cell_count() as u32).collect();
    match locality {
        Locality::AsGiven => cells,
        Locality::Morton => morton_order(mesh, cells, center),
    }
}

/// The corners 0…3 by increasing vertex id; ids differ.
fn by_id(ids: [u32; 4]) -> [usize; 4] {
    let mut corners = [0; 4];
    for (corner, id) in ids.iter().enumerate() {
        // Its rank; no branch depends on the ids.
        let rank = ids
            .iter()
            .map(|other| usize::from(other < id))
            .sum::<usize>();
        corners[rank] = corner;
    }
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

/// Items by the Morton code of their position in the mesh's box, and where these are the same by
/// number; `items` ascend. In parallel.
fn morton_order(
    mesh: &TetMesh,
    items: Vec<u32>,
    position: impl Fn(u32) -> DVec3 + Sync,
) -> Vec<u32> {
    let bounds = mesh.bounds();
    let size = bounds.size().max_element().max(f64::MIN_POSITIVE);
    let code = |item: u32| {
        // 21 bits per axis fill a u64.
        let p = (position(item) - bounds.min) / size * f64::from((1u32 << 21) - 1);
        spread(p.x as u32) | spread(p.y as u32) << 1 | spread(p.z as u32) << 2
    };
    let codes: Vec<u64> = items.par_iter().map(|&item| code(item)).collect();
    // The first bits of the code part the box into cubes with a few dozen items each, were these
    // spread evenly.
    let bits = 3 * (items.len() / 32).max(1).ilog(8);
    let cubes = Groups::new(&codes, 1 << bits, |code| [(code >> (63 - bits)) as u32]);
    let mut order = cubes.sorted_by_key(|number| codes[number as usize]);
    for place in &mut order {
        *place = items[*place as usize];
    }
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
