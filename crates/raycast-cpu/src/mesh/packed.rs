//! A mesh in memory: 32 bytes per cell, so that none lies in two cache lines, and 16 per vertex.

use std::sync::Arc;

use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_f32::layout::AT_BOUNDARY;
use tetrascope_f32::{Domain, Layout, Locality, Normalization, ScalarMap, longest_edge};

/// In place of a scalar that is not a number. Mapped scalars stay below 10³⁰.
pub(super) const NO_SCALAR: f32 = 1e38;

/// From here on a scalar stands for none.
pub(super) const LEAST_NO_SCALAR: f32 = 1e34;

/// A cell as a ray reads it: whoever comes in through a face knows three ids and gets the fourth
/// (`tetrascope_f32::layout`).
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The exclusive or of its vertices' ids.
    pub(super) sum: u32,
    /// Neighbors behind the face opposite each vertex: first the vertex with the least id, then those with
    /// decreasing ids, as ranks are counted down. Behind the boundary a cell of its own stands
    /// for each face, so that what is behind a cell can be read without asking.
    pub(super) neighbors: [u32; 4],
    /// The scalar of cell data.
    pub(super) scalar: f32,
}

/// Position, normalized, and scalar.
pub(super) type Vertex = [f32; 4];

/// Where a field's scalars are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// With the vertices.
    Vertices,
    /// One of each cell.
    Cells,
    /// Four of each cell, as the field jumps where cells touch.
    Corners,
}

impl Kind {
    pub(super) fn of(mesh: &TetMesh) -> Kind {
        match mesh.scalars().association {
            Association::Cell => Kind::Cells,
            Association::Point if mesh.is_continuous() => Kind::Vertices,
            Association::Point => Kind::Corners,
        }
    }
}

/// The data that stay while the geometry does.
#[derive(Debug)]
pub(super) struct Places {
    pub(super) normalization: Normalization,
    /// The corners and the cell of each boundary face.
    pub(super) boundary: Vec<[u32; 4]>,
    /// No ray is longer in a cell than this, normalized.
    pub(super) longest_edge: f32,
    layout: Layout,
}

impl Places {
    /// Which point of the mesh a vertex is.
    fn point_of(&self, vertex: u32) -> usize {
        self.layout.vertex_order[vertex as usize] as usize
    }

    /// Where a vertex of `mesh` is, relative to the mesh's center, in units of its size.
    pub(super) fn point(&self, mesh: &TetMesh, vertex: u32) -> DVec3 {
        self.normalization
            .point(mesh.points()[self.point_of(vertex)])
    }

    /// The scalar of a vertex of `mesh`, unless it is cell data.
    pub(super) fn scalar(&self, mesh: &TetMesh, vertex: u32) -> f64 {
        mesh.scalars().values[self.point_of(vertex)]
    }
}

/// A mesh that rays walk through.
#[derive(Clone, Debug)]
pub(super) struct Packed {
    pub(super) source: TetMesh,
    pub(super) domain: Domain,
    pub(super) places: Arc<Places>,
    pub(super) scalar_map: ScalarMap,
    pub(super) kind: Kind,
    /// The cells, and behind them those that stand for boundary faces, in their order.
    pub(super) cells: Arc<Vec<Cell>>,
    pub(super) cell_count: usize,
    pub(super) vertices: Arc<Vec<Vertex>>,
    /// Corner scalars of each cell by increasing id, for [`Kind::Corners`].
    pub(super) corners: Arc<Vec<[f32; 4]>>,
    /// Whether some scalar is none.
    pub(super) has_gaps: bool,
}

impl Packed {
    pub(super) fn new(source: &TetMesh, domain: Domain, scalar_map: ScalarMap) -> Packed {
        let normalization = Normalization::of(&domain.bounds);
        let count = source.cell_count() as u32;
        let neighbor = |n: u32| match n & AT_BOUNDARY {
            0 => n,
            _ => count + (n & !AT_BOUNDARY),
        };
        let (mut layout, mut cells) = Layout::new(source, Locality::Morton, |sum, neighbors| {
            let [a, b, c, d] = neighbors.map(neighbor);
            Cell {
                sum,
                neighbors: [a, d, c, b],
                scalar: 0.0,
            }
        });
        // With the three ids of its face, one of them is the fourth.
        let outside = layout
            .boundary
            .iter()
            .enumerate()
            .map(|(face, [a, b, ..])| Cell {
                sum: a ^ b,
                neighbors: [count + face as u32; 4],
                scalar: 0.0,
            });
        cells.extend(outside);
        let vertex = |&point: &u32| {
            let position = normalization.position(source.points()[point as usize]);
            position.extend(0.0).to_array()
        };
        let mut packed = Packed {
            source: source.clone(),
            domain,
            scalar_map,
            kind: Kind::of(source),
            cells: Arc::new(cells),
            cell_count: count as usize,
            vertices: Arc::new(layout.vertex_order.iter().map(vertex).collect()),
            corners: Arc::default(),
            has_gaps: false,
            places: Arc::new(Places {
                normalization,
                boundary: std::mem::take(&mut layout.boundary),
                longest_edge: longest_edge(source, &normalization),
                layout,
            }),
        };
        packed.fill();
        packed
    }

    /// The same geometry with the scalars of `source`, mapped by `scalar_map`.
    pub(super) fn with_scalars(
        &self,
        source: &TetMesh,
        domain: Domain,
        scalar_map: ScalarMap,
    ) -> Packed {
        let mut packed = Packed {
            source: source.clone(),
            domain,
            scalar_map,
            kind: Kind::of(source),
            ..self.clone()
        };
        packed.fill();
        packed
    }

    /// Puts the scalars where rays read them.
    fn fill(&mut self) {
        let Packed {
            source,
            places,
            scalar_map,
            kind,
            ..
        } = self;
        let layout = &places.layout;
        let mut has_gaps = false;
        let mut mapped = |value: f64| match value.is_finite() {
            true => scalar_map.scalar(value),
            false => {
                has_gaps = true;
                NO_SCALAR
            }
        };
        let values = &source.scalars().values;
        self.corners = Arc::default();
        match kind {
            Kind::Vertices => {
                let vertices = Arc::make_mut(&mut self.vertices);
                for (vertex, &point) in vertices.iter_mut().zip(&layout.vertex_order) {
                    vertex[3] = mapped(values[point as usize]);
                }
            }
            Kind::Cells => {
                let cells = Arc::make_mut(&mut self.cells);
                for (cell, &old) in cells.iter_mut().zip(&layout.cell_order) {
                    cell.scalar = mapped(values[source.source_cell(old as usize)]);
                }
            }
            Kind::Corners => {
                let of = |cell: u32| source.cell_scalars(cell as usize);
                let corners = layout.of_corners(source, of);
                let corners = corners.into_iter().map(|own| own.map(&mut mapped));
                self.corners = Arc::new(corners.collect());
            }
        }
        self.has_gaps = has_gaps;
    }

    /// The domain's least and greatest scalar, mapped.
    pub(super) fn scalars(&self) -> (f32, f32) {
        self.scalar_map.range(self.domain.scalar_range)
    }

    /// Bytes of all that stays between frames.
    pub(super) fn bytes(&self) -> u64 {
        let layout = &self.places.layout;
        let orders = layout.vertex_order.len() + layout.cell_order.len();
        let bytes = size_of_val(&self.cells[..])
            + size_of_val(&self.vertices[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.places.boundary[..])
            + orders * size_of::<u32>();
        bytes as u64
    }
}
