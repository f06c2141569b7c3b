//! A mesh in the numbers of fixed point, as the device takes it.

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh, is_value};

use crate::face::Number;
use crate::fixed::{DEPTH_BITS, PLACE_BITS};
use crate::options::{Arithmetic, Cells, VoxelizerOptions};
use crate::source::{Reach, ToVoxels, for_each_cell, reach, relative};
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
    /// Cells other than tetrahedra: the first triangle, how many, the sign of the cell's volume and
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
    /// A cell that is wider than fixed point allows; [`Cells::AsGiven`] of a mesh that did not keep
    /// them.
    pub(crate) fn new(
        mesh: &TetMesh,
        options: &VoxelizerOptions,
        space: &Space,
        range: (f64, f64),
    ) -> Result<Snapped, Error> {
        match options.cells {
            Cells::Tetrahedra => {
                Snapped::of_tetrahedra(mesh, place_bits(options.arithmetic), space, range)
            }
            Cells::AsGiven => Snapped::of_polyhedra(mesh, space, range),
        }
    }

    fn of_tetrahedra(
        mesh: &TetMesh,
        bits: u32,
        space: &Space,
        range: (f64, f64),
    ) -> Result<Snapped, Error> {
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
        let vertices = places.iter().enumerate().map(|(index, place)| {
            let scalar = match of_points {
                true => snapped_scalar(values[index], range),
                false => 0,
            };
            vertex(*place, bits, scalar)
        });
        let cell_scalars = match of_points {
            true => Vec::new(),
            false => {
                let cells = 0..mesh.cell_count();
                cells
                    .map(|c| snapped_scalar(values[mesh.source_cell(c)], range))
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

    /// Each cell has vertices of its own, with scalars.
    fn of_polyhedra(mesh: &TetMesh, space: &Space, range: (f64, f64)) -> Result<Snapped, Error> {
        let (to_voxels, dims) = (ToVoxels::new(&space.turned()), space.dims());
        let mut made = Snapped {
            vertices: Vec::new(),
            cell_scalars: Vec::new(),
            polyhedra: Vec::new(),
            triangles: Vec::new(),
            is_wide: false,
        };
        for_each_cell(mesh, Cells::AsGiven, &to_voxels, |index, cell| {
            let corners = &cell.corners;
            if let Reach::Near(extent) = reach(index, corners, dims, Arithmetic::FixedPoint)? {
                made.is_wide |= extent > NARROW;
            }
            let first = made.vertices.len() as u32;
            let pairs = corners.iter().zip(&cell.scalars);
            made.vertices.extend(
                pairs.map(|(place, s)| vertex(*place, PLACE_BITS, snapped_scalar(*s, range))),
            );
            let orientation = i32::from(cell.orientation) as u32;
            let (at, count) = (made.triangles.len() as u32, cell.faces.len() as u32);
            made.polyhedra.push([at, count, orientation, 0]);
            let triangles = cell.faces.iter().map(|face| {
                let [a, b, c] = face.map(|corner| first + u32::from(corner));
                [a, b, c, 0]
            });
            made.triangles.extend(triangles);
            Ok(())
        })?;
        Ok(made)
    }

    /// The cells that are uploaded.
    pub(crate) fn cells<'a>(&'a self, mesh: &'a TetMesh, cells: Cells) -> &'a [[u32; 4]] {
        match cells {
            Cells::Tetrahedra => mesh.tetrahedra(),
            Cells::AsGiven => &self.polyhedra,
        }
    }
}

/// Bits of a place in a voxel: with floats as many as depths have, which 32 bits hold for a cell that
/// is near ([`fixed`](crate::fixed)).
pub(crate) fn place_bits(arithmetic: Arithmetic) -> u32 {
    match arithmetic {
        Arithmetic::FixedPoint => PLACE_BITS,
        Arithmetic::Float => DEPTH_BITS,
    }
}

/// A place in parts of a voxel. What is not a number or too far away for an integer is of no cell that
/// is near.
pub(crate) fn parts(place: DVec3, bits: u32) -> [i32; 3] {
    place
        .to_array()
        .map(|c| (c * f64::from(1 << bits)).round() as i32)
}

fn vertex(place: DVec3, bits: u32, scalar: i32) -> [i32; 4] {
    let [x, y, z] = parts(place, bits);
    [x, y, z, scalar]
}

fn snapped_scalar(scalar: f64, range: (f64, f64)) -> i32 {
    match is_value(scalar) {
        true => i32::corner(DVec3::ZERO, relative(scalar, range)).scalar,
        false => NO_VALUE,
    }
}
