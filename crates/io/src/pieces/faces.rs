//! The faces of polyhedra.

use tetrascope_core::Error;

use super::{Budget, Piece};
use crate::MeshData;
use crate::polyhedra::POLYHEDRON;
use crate::source::count;

/// The faces of the polyhedra of a piece, of which one may belong to two cells.
#[derive(Default)]
pub(crate) struct Faces {
    /// The numbers of the faces of one cell after the other.
    pub(crate) of_cells: Vec<u64>,
    /// Where those of each cell end.
    pub(crate) cell_ends: Vec<u64>,
    pub(crate) points: Vec<u64>,
    /// Where each face ends among the points.
    pub(crate) face_ends: Vec<u64>,
}

impl Faces {
    /// Puts the faces' points in the place of the points of the polyhedra of `piece`, whose
    /// first point and cell are given by their numbers in the mesh.
    pub(super) fn put(
        &self,
        budget: &Budget,
        piece: &impl Piece,
        (first_point, first_cell): (u64, usize),
        data: &mut MeshData,
    ) -> Result<(), Error> {
        let is_outside = |&point: &u64| point >= piece.points();
        if let Some(i) = self.points.iter().position(is_outside) {
            let what = format!(
                "value {i} is point {}, but the piece has {}",
                self.points[i],
                count(piece.points(), "point")
            );
            return Err(piece.error("the faces of polyhedra", what));
        }
        let start = data.cells.offsets[first_cell];
        let old = data.cells.connectivity.split_off(start as usize);
        let mut old_start = start;
        let connectivity = &mut data.cells.connectivity;
        for cell in first_cell..data.cells.types.len() {
            let old_end = data.cells.offsets[cell + 1];
            let old_cell = old.get((old_start - start) as usize..(old_end - start) as usize);
            old_start = old_end;
            if data.cells.types[cell] == POLYHEDRON {
                let mut sizes = Vec::new();
                for &face in self.of_cell(cell - first_cell) {
                    let points = self.points_of(face);
                    let indices = (connectivity.len() + points.len()) as u64;
                    // A face may be listed again and again.
                    budget.check(data.cells.types.len() as u64, indices)?;
                    connectivity.extend(points.iter().map(|point| first_point + point));
                    sizes.push(points.len() as u32); // the file holds them
                }
                let polyhedra = data.polyhedra.get_or_insert_default();
                polyhedra.push(cell, sizes.into_iter());
            } else {
                let old_cell = old_cell.ok_or_else(|| {
                    let what = format!("cell {} ends before it begins", cell - first_cell);
                    piece.error("array 'offsets'", what)
                })?;
                connectivity.extend_from_slice(old_cell);
            }
            data.cells.offsets[cell + 1] = connectivity.len() as u64;
        }
        Ok(())
    }

    fn of_cell(&self, cell: usize) -> &[u64] {
        let start = cell
            .checked_sub(1)
            .map_or(0, |before| self.cell_ends[before]);
        &self.of_cells[start as usize..self.cell_ends[cell] as usize]
    }

    fn points_of(&self, face: u64) -> &[u64] {
        let face = face as usize;
        let start = face
            .checked_sub(1)
            .map_or(0, |before| self.face_ends[before]);
        &self.points[start as usize..self.face_ends[face] as usize]
    }
}

/// Refuses ends that descend; `wrong` makes an error of what is wrong.
pub(crate) fn check_ends(ends: &[u64], wrong: impl FnOnce(String) -> Error) -> Result<(), Error> {
    match ends.array_windows().position(|[a, b]| a > b) {
        None => Ok(()),
        Some(i) => Err(wrong(format!(
            "value {} is {}, less than the one before",
            i + 1,
            ends[i + 1]
        ))),
    }
}
