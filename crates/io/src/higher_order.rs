//! Facts of VTK's files on cells of any order beside their types and points: orders that differ along the axes,
//! weights of points, and the numbering of old files.

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;
use tetrascope_core::mesh::curved::{Extra, exchanged, is_straightened};

use crate::MeshData;
use crate::fields::Array;
use crate::source::count;

/// The array of the orders of cells along three axes.
const DEGREES: &str = "HigherOrderDegrees";

/// The array of the weights of points in rational Bézier cells.
const WEIGHTS: &str = "RationalWeights";

/// Whether an array says how cells are curved, and is not a field to look at.
pub(crate) fn says_shape(name: &str) -> bool {
    name == DEGREES || name == WEIGHTS
}

/// Whether a cell's points beyond its corners have a numbering that VTK has changed: hexahedra
/// of any order.
pub(crate) fn is_renumbered(kind: u8) -> bool {
    matches!(kind, 67 | 72 | 79)
}

fn find<'a>(arrays: &'a [Array], name: &str) -> Option<&'a Array> {
    let (association, components) = match name {
        DEGREES => (Association::Cell, 3),
        _ => (Association::Point, 1),
    };
    let is_it = |array: &&Array| {
        array.name == name && array.association == association && array.components == components
    };
    arrays.iter().find(is_it)
}

impl MeshData {
    /// The file's facts on curved cells, if there are any for which these count.
    ///
    /// # Errors
    /// Those of the file, where arrays are read only now.
    pub(crate) fn extra(&self) -> Result<Extra, Error> {
        let is_of_any_order = |kind: &u8| *kind > 64 && is_straightened(*kind);
        if !self.cells.types.iter().any(is_of_any_order) {
            return Ok(Extra::default());
        }
        let mut extra = Extra::default();
        if let Some(degrees) = find(&self.arrays, DEGREES) {
            extra.degrees = self.tuples(degrees)?.as_chunks::<3>().0.to_vec();
        }
        if let Some(weights) = find(&self.arrays, WEIGHTS) {
            extra.weights = self.tuples(weights)?;
            // Blocks without weights, which a note says.
            let missing = extra.weights.iter_mut().filter(|weight| weight.is_nan());
            missing.for_each(|weight| *weight = 1.0);
        }
        Ok(extra)
    }

    /// The arrays that say how this mesh's cells are curved.
    pub(crate) fn shape_arrays(&self) -> impl Iterator<Item = &Array> {
        let arrays = [DEGREES, WEIGHTS].into_iter();
        arrays.filter_map(|name| find(&self.arrays, name))
    }

    /// Gives hexahedra of any order the numbering of VTK 9, where `is_old` says of a cell that it has the one before.
    ///
    /// VTK's readers do so by the version of the file: those of XML before 2.1 (`vtkXMLUnstructuredDataReader::ReadPiece`,
    /// vtkXMLUnstructuredGridReader.cxx) and legacy ones before 5.1 (vtkUnstructuredGridReader.cxx), by
    /// `vtkUpdateCellsV8toV9`. `arrays` are of all cells. What no order fits stays as it is, to be refused where it
    /// is drawn.
    ///
    /// # Errors
    /// Those of the file, where the array of orders is read only now.
    pub(crate) fn renumber_old(
        &mut self,
        arrays: &[Array],
        is_old: impl Fn(usize) -> bool,
    ) -> Result<(), Error> {
        let kinds = self.cells.types.iter().enumerate();
        let old = kinds.filter(|(cell, kind)| is_renumbered(**kind) && is_old(*cell));
        let old: Vec<usize> = old.map(|(cell, _)| cell).collect();
        if old.is_empty() {
            return Ok(());
        }
        let mut degrees = Vec::new();
        if let Some(array) = find(arrays, DEGREES) {
            array.numbers.each(&mut |degree| degrees.push(degree))?;
        }
        let mut renumbered = 0;
        let mut before = Vec::new();
        for cell in old {
            let ends = [cell, cell + 1].map(|cell| self.cells.offsets[cell] as usize);
            let Some(points) = self.cells.connectivity.get_mut(ends[0]..ends[1]) else {
                continue; // refused by the check of all cells
            };
            let given = degrees.as_chunks::<3>().0.get(cell);
            let orders = match given {
                Some(given) => given.map(|degree| degree as usize), // saturating
                None => {
                    [(points.len() as f64).cbrt().round() as usize; 3].map(|n| n.saturating_sub(1))
                }
            };
            // More would be too many for any product of them.
            let is_order = |order: &usize| (1..1000).contains(order);
            let needed = || orders.map(|order| order + 1).iter().product::<usize>();
            if !orders.iter().all(is_order) || needed() != points.len() || orders[2] == 1 {
                continue;
            }
            before.clear();
            before.extend_from_slice(points);
            for (point, old) in points.iter_mut().zip(exchanged(orders)) {
                *point = before[old];
            }
            renumbered += 1;
        }
        if renumbered > 0 {
            self.notes.push(format!(
                "{} of any order renumbered: the file's version says that VTK 8 or an older one numbered the points on edges",
                count(renumbered, "hexahedron").replace("hexahedrons", "hexahedra")
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
