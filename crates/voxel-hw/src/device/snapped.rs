//! A mesh in the numbers of fixed point, as the device takes it.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh, is_value};

use crate::face::Number;
use crate::options::Arithmetic;
use crate::source::{Reach, ToVoxels, reach, relative};
use crate::space::Space;

/// Stands for no scalar; `NO_VALUE` of `work.wgsl`.
const NO_VALUE: i32 = i32::MIN;

/// Vertices, scalars of cells, and what the shaders have to expect.
#[derive(Debug)]
pub(crate) struct Snapped {
    /// Places, and the scalar for a field of points.
    pub(crate) vertices: Vec<[i32; 4]>,
    /// One for each cell; empty for a field of points.
    pub(crate) cell_scalars: Vec<i32>,
    /// Cells that are no tetrahedra: the first triangle, how many, the sign of the cell's volume and
    /// its scalar; empty if all are.
    pub(crate) polyhedra: Vec<[u32; 4]>,
    /// Their corners, in the lower three.
    pub(crate) triangles: Vec<[u32; 4]>,
    /// Whether areas of some cell need more than 32 bits.
    pub(crate) is_wide: bool,
}

/// Cells narrower than this have areas of 32 bits: coordinates relative to a pixel among them are
/// below 2¹⁵, and both products and their difference fit. In voxels, less what snapping adds.
const NARROW: f64 = 127.0;

impl Snapped {
    /// # Errors
    /// A cell that is wider than fixed point allows.
    pub(crate) fn new(mesh: &TetMesh, space: &Space, range: (f64, f64)) -> Result<Snapped, Error> {
        let (to_voxels, dims) = (ToVoxels::new(&space.turned()), space.dims());
        let points = mesh.points();
        let places: Vec<DVec3> = points.iter().map(|p| to_voxels.place(*p)).collect();
        let mut widest: f64 = 0.0;
        for (index, cell) in mesh.tetrahedra().iter().enumerate() {
            let corners = cell.map(|p| places[p as usize]);
            if let Reach::Near(extent) = reach(index, &corners, dims, Arithmetic::FixedPoint)? {
                widest = widest.max(extent);
            }
        }
        let scalars = mesh.scalars();
        let values = &scalars.values;
        let of_points = scalars.association == Association::Point;
        let snapped = |scalar: f64| match is_value(scalar) {
            true => i32::corner(DVec3::ZERO, relative(scalar, range)).scalar,
            false => NO_VALUE,
        };
        let vertices = places.iter().enumerate().map(|(index, place)| {
            // What is not a number or too far away for an integer is of no cell that is near.
            let corner = i32::corner(*place, 0.0);
            let scalar = match of_points {
                true => snapped(values[index]),
                false => 0,
            };
            [corner.x, corner.y, corner.z, scalar]
        });
        let cell_scalars = match of_points {
            true => Vec::new(),
            false => {
                let cells = 0..mesh.cell_count();
                cells
                    .map(|c| snapped(values[mesh.source_cell(c)]))
                    .collect()
            }
        };
        Ok(Snapped {
            vertices: vertices.collect(),
            cell_scalars,
            polyhedra: Vec::new(),
            triangles: Vec::new(),
            is_wide: widest > NARROW,
        })
    }

    /// What is uploaded as cells.
    pub(crate) fn cells<'a>(&'a self, mesh: &'a TetMesh) -> &'a [[u32; 4]] {
        match self.polyhedra.is_empty() {
            true => mesh.tetrahedra(),
            false => &self.polyhedra,
        }
    }
}
