//! What a mesh reader returns.

use std::path::PathBuf;

use glam::DVec3;
use tetrascope_core::glam;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error, Scalars, TetMesh};

use crate::fields::{Array, GHOST_LEVELS};
use crate::source::{Source, count};

/// An unstructured mesh as a file holds it, with all its fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// Positions, world space. Some may be used by no cell.
    pub points: Vec<DVec3>,
    /// Cells of any type; every index is checked against `points`.
    pub cells: Cells,
    /// Every scalar field; a vector is its components and its magnitude. The
    /// file's active scalars come first, then scalars, then parts of vectors,
    /// then identifiers.
    pub fields: Vec<Scalars>,
    /// What was found out, repaired or left out: one sentence each.
    pub notes: Vec<String>,
    /// The files that were read: the mesh's and, with Plot3D, the solution's.
    pub files: Vec<PathBuf>,
}

impl MeshData {
    /// The least and greatest finite value of each field, at points that cells use.
    pub fn field_ranges(&self) -> Vec<Option<(f64, f64)>> {
        let used = self.used_points();
        self.fields
            .iter()
            .map(|field| self.range(field, &used))
            .collect()
    }

    /// Each field as "density [0.19, 4.98] (point)".
    ///
    /// The range is that of the finite values at points that cells use.
    pub fn field_list(&self) -> Vec<String> {
        self.fields
            .iter()
            .zip(self.field_ranges())
            .map(|(field, range)| {
                let range = match range {
                    Some((low, high)) => format!("[{}, {}]", short(low), short(high)),
                    None => "[no finite value]".into(),
                };
                let association = match field.association {
                    Association::Point => "point",
                    Association::Cell => "cell",
                };
                format!("{} {range} ({association})", field.name)
            })
            .collect()
    }

    /// The field of that name. Without a name: the first that is not the same
    /// everywhere, or simply the first.
    ///
    /// # Errors
    /// [`Error::NoSuchField`] lists what there is, with ranges;
    /// [`Error::Invalid`] if there is no field at all.
    pub fn field(&self, name: Option<&str>) -> Result<&Scalars, Error> {
        Ok(&self.fields[self.field_index(name)?])
    }

    /// The tetrahedra of this mesh with one of its fields, chosen as by
    /// [`MeshData::field`].
    ///
    /// # Errors
    /// As [`MeshData::field`] and [`TetMesh::new`].
    pub fn into_mesh(mut self, field: Option<&str>) -> Result<TetMesh, Error> {
        let index = self.field_index(field)?;
        let scalars = self.fields.swap_remove(index);
        self.fields = Vec::new(); // large, and not needed while the mesh is built
        TetMesh::new(self.points, &self.cells, scalars)
    }

    /// How many cells of each VTK type there are, by type.
    pub fn cell_counts(&self) -> Vec<(u8, usize)> {
        let mut counts = [0; 256];
        for &kind in &self.cells.types {
            counts[usize::from(kind)] += 1;
        }
        (0..=255)
            .zip(counts)
            .filter(|&(_, count)| count > 0)
            .collect()
    }

    fn field_index(&self, name: Option<&str>) -> Result<usize, Error> {
        if self.fields.is_empty() {
            return Err(Error::Invalid {
                what: "the mesh has no scalar field to draw".into(),
                help: Some(
                    "give the file that holds the fields with --solution FILE, or choose a mesh with point or cell data"
                        .into(),
                ),
            });
        }
        let Some(name) = name else {
            let used = self.used_points();
            let varies = |field: &Scalars| {
                self.range(field, &used)
                    .is_some_and(|(low, high)| low < high)
            };
            return Ok(self.fields.iter().position(varies).unwrap_or(0));
        };
        self.fields
            .iter()
            .position(|field| field.name == name)
            .ok_or_else(|| Error::NoSuchField {
                name: name.into(),
                available: self.field_list(),
            })
    }

    /// The least and greatest finite value that cells use.
    fn range(&self, field: &Scalars, used: &[bool]) -> Option<(f64, f64)> {
        let all_used = field.association == Association::Cell;
        field
            .values
            .iter()
            .zip(
                used.iter()
                    .map(|&u| u || all_used)
                    .chain(std::iter::repeat(all_used)),
            )
            .filter(|&(value, used)| used && value.is_finite())
            .fold(None, |range, (&value, _)| match range {
                None => Some((value, value)),
                Some((low, high)) => Some((value.min(low), value.max(high))),
            })
    }

    /// Whether any cell uses each point.
    fn used_points(&self) -> Vec<bool> {
        let mut used = vec![false; self.points.len()];
        for &point in &self.cells.connectivity {
            if let Some(used) = used.get_mut(point as usize) {
                *used = true;
            }
        }
        used
    }

    /// Leaves out duplicate and hidden cells and those with a hidden point
    /// (vtkDataSetAttributes: DUPLICATECELL 1, HIDDENCELL 32, HIDDENPOINT 2).
    /// Each array of `ghosts` has one value a point or a cell.
    pub(crate) fn remove_ghosts(&mut self, source: &Source, ghosts: &[Array]) -> Result<(), Error> {
        let mut keep = vec![true; self.cells.types.len()];
        for ghost in ghosts {
            let flags = |index: usize| ghost.values.get(index).map_or(0, |&f| f as u64);
            let mask = if ghost.name == GHOST_LEVELS {
                u64::MAX
            } else {
                1 | 32
            };
            for (cell, keep) in keep.iter_mut().enumerate() {
                let hidden = match ghost.association {
                    Association::Cell => flags(cell) & mask != 0,
                    Association::Point if ghost.name == GHOST_LEVELS => false,
                    Association::Point => self.cells.connectivity
                        [self.cells.offsets[cell] as usize..self.cells.offsets[cell + 1] as usize]
                        .iter()
                        .any(|&p| flags(p as usize) & 2 != 0),
                };
                *keep &= !hidden;
            }
        }
        self.retain_cells(&keep, "they are ghosts (duplicate or hidden)");
        if self.cells.types.is_empty() {
            return Err(source.error(
                "the ghost array",
                "every cell is marked as duplicate or hidden",
            ));
        }
        Ok(())
    }

    /// Removes the cells for which `keep` is false, with their values, and
    /// notes how many there were and why. `keep` has one entry a cell.
    pub(crate) fn retain_cells(&mut self, keep: &[bool], why: &str) {
        let removed = keep.iter().filter(|&&keep| !keep).count() as u64;
        if removed == 0 {
            return;
        }
        let mut kept = Cells {
            offsets: vec![0],
            ..Cells::default()
        };
        for (cell, _) in keep.iter().enumerate().filter(|&(_, &keep)| keep) {
            kept.types.push(self.cells.types[cell]);
            let points = self.cells.offsets[cell] as usize..self.cells.offsets[cell + 1] as usize;
            kept.connectivity
                .extend_from_slice(&self.cells.connectivity[points]);
            kept.offsets.push(kept.connectivity.len() as u64);
        }
        self.cells = kept;
        for field in &mut self.fields {
            if field.association == Association::Cell {
                let mut flags = keep.iter();
                field
                    .values
                    .retain(|_| *flags.next().expect("one flag a value"));
            }
        }
        self.notes
            .push(format!("{} left out: {why}", count(removed, "cell")));
    }
}

/// One hexahedron between each eight neighboring points of a block whose points
/// begin at `base`; point (i, j, k) is number i + ni (j + nj k) of the block.
pub(crate) fn add_hexahedra(cells: &mut Cells, dimensions: [u64; 3], base: u64) {
    let [ni, nj, nk] = dimensions;
    for k in 0..nk.saturating_sub(1) {
        for j in 0..nj.saturating_sub(1) {
            for i in 0..ni.saturating_sub(1) {
                let p = base + i + ni * (j + nj * k);
                // VTK's order: around the face k, then around the face k + 1.
                let face = [p, p + 1, p + 1 + ni, p + ni];
                cells.connectivity.extend(face);
                cells.connectivity.extend(face.map(|p| p + ni * nj));
                cells.types.push(12); // VTK_HEXAHEDRON
                cells.offsets.push(cells.connectivity.len() as u64);
            }
        }
    }
}

/// Six significant digits at most.
fn short(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-4..1e7).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let decimals = (5 - magnitude.max(1e-4).log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scalars(name: &str, association: Association, values: &[f64]) -> Scalars {
        Scalars {
            name: name.into(),
            association,
            values: values.into(),
        }
    }

    /// Two tetrahedra on five points, and a sixth point that none uses.
    fn data() -> MeshData {
        MeshData {
            points: vec![
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::Z,
                DVec3::ONE,
                DVec3::splat(9.0),
            ],
            cells: Cells {
                types: vec![10, 10],
                offsets: vec![0, 4, 8],
                connectivity: vec![0, 1, 2, 3, 1, 2, 3, 4],
            },
            fields: vec![
                scalars("flat", Association::Point, &[1.0, 1.0, 1.0, 1.0, 1.0, 2.0]),
                scalars(
                    "t",
                    Association::Point,
                    &[0.5, f64::NAN, 1e-9, 3.0, 2.0, 7.0],
                ),
                scalars("c", Association::Cell, &[-1.0, 250_000.25]),
            ],
            notes: Vec::new(),
            files: Vec::new(),
        }
    }

    #[test]
    fn fields_are_listed_with_the_range_that_cells_use() {
        let list = data().field_list();
        assert_eq!(
            list,
            [
                "flat [1, 1] (point)",
                "t [1.0000e-9, 3] (point)",
                "c [-1, 250000] (cell)"
            ]
        );
    }

    #[test]
    fn the_first_field_that_varies_is_the_default() {
        assert_eq!(data().field(None).expect("there are fields").name, "t");
        assert_eq!(data().field(Some("c")).expect("it exists").name, "c");
        let error = data().field(Some("x")).expect_err("there is no x");
        assert!(
            error.to_string().contains("t [1.0000e-9, 3] (point)"),
            "{error}"
        );
        let empty = MeshData::default();
        assert!(empty.field(None).is_err());
    }

    #[test]
    fn leaving_out_a_cell_keeps_the_values_of_the_others() {
        let mut data = data();
        data.retain_cells(&[false, true], "a reason");
        assert_eq!(data.cells.connectivity, [1, 2, 3, 4]);
        assert_eq!(data.cells.offsets, [0, 4]);
        assert_eq!(data.fields[2].values, [250_000.25]);
        assert_eq!(data.fields[0].values.len(), 6);
        assert_eq!(data.notes, ["1 cell left out: a reason"]);
    }
}
