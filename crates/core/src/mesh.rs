//! Unstructured meshes: any linear cells in, tetrahedra out.

use std::sync::Arc;

use glam::DVec3;

use crate::{Bounds, Error};

/// Cells in VTK's layout: cell i has the type `types[i]` and the points
/// `connectivity[offsets[i]..offsets[i + 1]]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cells {
    /// VTK's numbers: 10 tetra, 11 voxel, 12 hexahedron, 13 wedge, 14 pyramid,
    /// 24…27 their quadratic forms, …
    pub types: Vec<u8>,
    /// One more than there are cells, not decreasing, from 0 to the length of `connectivity`.
    pub offsets: Vec<u64>,
    /// Point indices.
    pub connectivity: Vec<u64>,
}

/// Where a field's values live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Association {
    /// One value a point, linear in each tetrahedron.
    Point,
    /// One value an input cell, constant in it.
    Cell,
}

/// A scalar field on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Scalars {
    /// What the file calls it.
    pub name: String,
    /// Where the values live.
    pub association: Association,
    /// One a point or one an input cell; NaN is transparent.
    pub values: Vec<f64>,
}

/// A tetrahedral mesh with one scalar field.
///
/// Cheap to clone: geometry is shared, also between meshes that differ in their
/// scalars alone ([`TetMesh::with_scalars`]).
#[derive(Clone, Debug)]
pub struct TetMesh {
    geometry: Arc<Geometry>,
    scalars: Arc<Scalars>,
}

#[derive(Debug)]
struct Geometry {
    points: Vec<DVec3>,
    tetrahedra: Vec<[u32; 4]>,
    /// The input cell of each tetrahedron; empty when each is its own.
    sources: Vec<u32>,
    input_cell_count: usize,
}

impl TetMesh {
    /// Splits `cells` into tetrahedra that agree across shared faces.
    pub fn new(points: Vec<DVec3>, cells: &Cells, scalars: Scalars) -> Result<TetMesh, Error> {
        let _ = (points, cells, scalars);
        unimplemented!("written next")
    }

    /// A mesh of tetrahedra; orientation is fixed where it is wrong.
    pub fn from_tetrahedra(
        points: Vec<DVec3>,
        tetrahedra: Vec<[u32; 4]>,
        scalars: Scalars,
    ) -> Result<TetMesh, Error> {
        let input_cell_count = tetrahedra.len();
        Ok(TetMesh {
            geometry: Arc::new(Geometry {
                points,
                tetrahedra,
                sources: Vec::new(),
                input_cell_count,
            }),
            scalars: Arc::new(scalars),
        })
    }

    /// The same geometry with another field; nothing is rebuilt.
    pub fn with_scalars(&self, scalars: Scalars) -> Result<TetMesh, Error> {
        let _ = self.geometry.input_cell_count;
        Ok(TetMesh {
            geometry: self.geometry.clone(),
            scalars: Arc::new(scalars),
        })
    }

    /// Whether `other` has the very same geometry, so that only scalars need an upload.
    pub fn shares_geometry(&self, other: &TetMesh) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry)
    }

    /// Positions, world space.
    pub fn points(&self) -> &[DVec3] {
        &self.geometry.points
    }

    /// Point indices of each cell, positively oriented:
    /// (p₁ − p₀) · ((p₂ − p₀) × (p₃ − p₀)) ≥ 0, with 0 for a degenerate cell.
    pub fn tetrahedra(&self) -> &[[u32; 4]] {
        &self.geometry.tetrahedra
    }

    /// How many tetrahedra there are.
    pub fn cell_count(&self) -> usize {
        self.geometry.tetrahedra.len()
    }

    /// The input cell that tetrahedron `cell` was cut from.
    pub fn source_cell(&self, cell: usize) -> usize {
        match self.geometry.sources.get(cell) {
            Some(&source) => source as usize,
            None => cell,
        }
    }

    /// The field.
    pub fn scalars(&self) -> &Scalars {
        &self.scalars
    }

    /// The positions of a cell's points.
    pub fn cell_points(&self, cell: usize) -> [DVec3; 4] {
        self.geometry.tetrahedra[cell].map(|p| self.geometry.points[p as usize])
    }

    /// The scalars at a cell's points: the linear function that it carries.
    ///
    /// All equal for cell data, so one path serves both.
    pub fn cell_scalars(&self, cell: usize) -> [f64; 4] {
        match self.scalars.association {
            Association::Point => {
                self.geometry.tetrahedra[cell].map(|p| self.scalars.values[p as usize])
            }
            Association::Cell => [self.scalars.values[self.source_cell(cell)]; 4],
        }
    }

    /// The box around all points that cells use.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(
            self.geometry
                .tetrahedra
                .iter()
                .flatten()
                .map(|&p| self.geometry.points[p as usize]),
        )
    }

    /// The least and greatest finite scalar that cells use, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        (0..self.cell_count())
            .flat_map(|c| self.cell_scalars(c))
            .filter(|s| s.is_finite())
            .fold(None, |range, s| match range {
                None => Some((s, s)),
                Some((low, high)) => Some((s.min(low), s.max(high))),
            })
    }

    /// The neighbor of each cell across the face opposite its vertex 0…3;
    /// [`NO_NEIGHBOR`] at the boundary. Found on first use and kept.
    pub fn neighbors(&self) -> &[[u32; 4]] {
        unimplemented!("written next")
    }

    /// The boundary faces as (cell, opposite vertex 0…3). Found on first use and kept.
    pub fn boundary_faces(&self) -> &[(u32, u8)] {
        unimplemented!("written next")
    }
}

/// In place of a cell index: there is no cell.
pub const NO_NEIGHBOR: u32 = u32::MAX;
