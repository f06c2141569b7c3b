//! The cells of a mesh, one after the other, with triangles for faces. Nothing is asked of
//! their neighbors.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Lattice;
use tetrascope_core::mesh::{Association, FACES, volume_corners, volume_faces};
use tetrascope_core::{Error, TetMesh, is_value};

use crate::cell::Cell;
use crate::face::{Corner, Number};
use crate::fixed::PLACE_BITS;
use crate::options::{Arithmetic, Cells, MOST_SIDE};

/// The triangles of a tetrahedron: counterclockwise from outside where it is positively oriented.
pub(crate) fn tetrahedron() -> [[u8; 3]; 4] {
    FACES.map(|face| face.map(|corner| corner as u8))
}

/// A polyhedron in voxel space, where voxel (i, j, k) is the cube from there to (i, j, k) + 1.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polyhedron {
    /// Corners, in voxels.
    pub(crate) corners: Vec<DVec3>,
    /// Their scalars, in the field's unit.
    pub(crate) scalars: Vec<f64>,
    /// Triangles, counterclockwise from outside if `orientation` is positive.
    pub(crate) faces: Vec<[u8; 3]>,
    /// The sign of the volume that the cell has by its maker's word.
    pub(crate) orientation: i8,
}

/// From world to voxel space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToVoxels {
    origin: DVec3,
    linear: DMat3,
    /// Whether right hands become left ones.
    mirrors: bool,
}

impl ToVoxels {
    /// The centers of voxels are the samples of `lattice`, which is valid.
    pub(crate) fn new(lattice: &Lattice) -> ToVoxels {
        ToVoxels {
            origin: lattice.origin,
            linear: lattice.linear().inverse(),
            // That of the linear part may be too small or too large for a float.
            mirrors: lattice.direction.determinant() < 0.0,
        }
    }

    pub(crate) fn place(&self, world: DVec3) -> DVec3 {
        self.linear * (world - self.origin) + 0.5
    }
}

/// Gives `take` every cell of `mesh`.
///
/// # Errors
/// Those of `take`; [`Cells::AsGiven`] of a mesh that did not keep them.
pub(crate) fn for_each_cell(
    mesh: &TetMesh,
    cells: Cells,
    to_voxels: &ToVoxels,
    mut take: impl FnMut(usize, &Polyhedron) -> Result<(), Error>,
) -> Result<(), Error> {
    let points = mesh.points();
    let mut polyhedron = Polyhedron::default();
    match cells {
        Cells::Tetrahedra => {
            polyhedron.faces.extend(tetrahedron());
            polyhedron.orientation = if to_voxels.mirrors { -1 } else { 1 };
            for (index, tetrahedron) in mesh.tetrahedra().iter().enumerate() {
                polyhedron.corners.clear();
                let places = tetrahedron.map(|p| to_voxels.place(points[p as usize]));
                polyhedron.corners.extend(places);
                polyhedron.scalars.clear();
                polyhedron.scalars.extend(mesh.cell_scalars(index));
                take(index, &polyhedron)?;
            }
        }
        Cells::AsGiven => {
            let Some(cells) = mesh.cells() else {
                return Err(Error::Usage {
                    what: "the mesh has not kept the cells that it was made from".into(),
                    help: Some("choose tetrahedra, which a mesh of nothing else consists of, or keep the cells when the mesh is made".into()),
                });
            };
            let places = places(mesh);
            let scalars = mesh.scalars();
            for (index, &cell_type) in cells.types.iter().enumerate() {
                let (Some(count), Some(faces)) =
                    (volume_corners(cell_type), volume_faces(cell_type))
                else {
                    continue;
                };
                let first = cells.offsets[index] as usize;
                let corners = &cells.connectivity[first..first + count];
                polyhedron.corners.clear();
                let voxels = corners.iter().map(|p| to_voxels.place(points[*p as usize]));
                polyhedron.corners.extend(voxels);
                polyhedron.scalars.clear();
                let values = corners.iter().map(|p| match scalars.association {
                    Association::Point => scalars.values[*p as usize],
                    Association::Cell => scalars.values[index],
                });
                polyhedron.scalars.extend(values);
                polyhedron.faces.clear();
                for face in faces {
                    // A fan from the smallest corner, as `Split::SmallestIndex` has it.
                    let key = |i: &usize| (places[corners[*i] as usize], corners[*i]);
                    let least = (0..face.len())
                        .min_by_key(|i| key(&face[*i]))
                        .expect("faces have corners");
                    let at = |i: usize| face[(least + i) % face.len()] as u8;
                    let fan = (1..face.len() - 1).map(|i| [at(0), at(i), at(i + 1)]);
                    polyhedron.faces.extend(fan);
                }
                // Files have cells of both orientations.
                polyhedron.orientation = f64::volume_sign(
                    &corners_of::<f64>(&polyhedron, (0.0, 0.0)),
                    &polyhedron.faces,
                );
                take(index, &polyhedron)?;
            }
        }
    }
    Ok(())
}

/// For each point, the least with the same position.
fn places(mesh: &TetMesh) -> Vec<u32> {
    let mut places: Vec<u32> = (0..mesh.points().len() as u32).collect();
    for (points, at) in mesh.tetrahedra().iter().zip(mesh.places()) {
        for (point, place) in points.iter().zip(at) {
            places[*point as usize] = *place;
        }
    }
    places
}

/// A scalar's share of the range, from 0 to 1.
pub(crate) fn relative(scalar: f64, (low, high): (f64, f64)) -> f64 {
    match high > low {
        true => ((scalar - low) / (high - low)).clamp(0.0, 1.0),
        false => 0.0,
    }
}

fn corners_of<N: Number>(polyhedron: &Polyhedron, range: (f64, f64)) -> Vec<Corner<N>> {
    let corners = polyhedron.corners.iter().zip(&polyhedron.scalars);
    corners
        .map(|(place, scalar)| N::corner(*place, relative(*scalar, range)))
        .collect()
}

/// Whether a cell can reach a voxel.
pub(crate) enum Reach {
    /// It cannot.
    Outside,
    /// It may; its extent along the longest axis, in voxels.
    Near(f64),
}

/// Whether cell number `index` with these corners, in voxels, can reach one of `dims` voxels, for some
/// offset.
///
/// # Errors
/// A cell wider than the fixed-point numbers allow.
pub(crate) fn reach(
    index: usize,
    corners: &[DVec3],
    dims: [usize; 3],
    arithmetic: Arithmetic,
) -> Result<Reach, Error> {
    if !corners.iter().all(|c| c.is_finite()) {
        return Err(Error::Invalid {
            what: format!("cell {index} is farther away than voxels can be counted"),
            help: Some("take larger voxels".into()),
        });
    }
    let low = corners.iter().fold(DVec3::INFINITY, |low, c| low.min(*c));
    let high = corners
        .iter()
        .fold(DVec3::NEG_INFINITY, |high, c| high.max(*c));
    // An offset moves it by half a voxel at most, and snapping, away from 0, by half a step.
    let margin = DVec3::splat(0.5 + 0.5 / f64::from(1 << PLACE_BITS));
    let dims = DVec3::from_array(dims.map(|d| d as f64));
    let is_near = high.cmpgt(-margin).all() && low.cmplt(dims + margin).all();
    if !is_near {
        return Ok(Reach::Outside);
    }
    let widest = (high - low).max_element();
    let is_fixed = arithmetic == Arithmetic::FixedPoint;
    if is_fixed && widest > MOST_SIDE as f64 || !widest.is_finite() {
        return Err(Error::Invalid {
            what: format!("cell {index} is {widest} voxels wide"),
            help: Some(format!(
                "fixed point, and the device, hold cells of {MOST_SIDE} voxels: take larger ones, or \
                 floats on the CPU"
            )),
        });
    }
    Ok(Reach::Near(widest))
}

/// A cell in the numbers that it is voxelized in, or why it is not.
pub(crate) enum Prepared<N> {
    /// To be voxelized.
    Cell(Cell<N>),
    /// It cannot reach any voxel.
    Outside,
    /// Some corner has no value.
    WithoutValue,
    /// It has no volume.
    Degenerate,
    /// Snapping or rounding turned it inside out; its neighbors own its voxels.
    Inverted,
}

/// Prepares cell number `index` for a volume of `dims`.
///
/// # Errors
/// A cell wider than the fixed-point numbers allow.
pub(crate) fn prepare<N: Number>(
    index: usize,
    polyhedron: &Polyhedron,
    range: (f64, f64),
    dims: [usize; 3],
    arithmetic: Arithmetic,
) -> Result<Prepared<N>, Error> {
    if !polyhedron.scalars.iter().all(|s| is_value(*s)) {
        return Ok(Prepared::WithoutValue);
    }
    if let Reach::Outside = reach(index, &polyhedron.corners, dims, arithmetic)? {
        return Ok(Prepared::Outside);
    }
    let corners = corners_of::<N>(polyhedron, range);
    let sign = N::volume_sign(&corners, &polyhedron.faces);
    Ok(match (sign, polyhedron.orientation) {
        (0, _) | (_, 0) => Prepared::Degenerate,
        (sign, orientation) if sign != orientation => Prepared::Inverted,
        _ => Prepared::Cell(Cell {
            corners,
            faces: polyhedron.faces.clone(),
            inside_out: sign < 0,
        }),
    })
}
