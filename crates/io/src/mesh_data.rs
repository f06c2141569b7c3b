//! Meshes as their readers return them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use tetrascope_core::glam;
use tetrascope_core::groups::marked;
use tetrascope_core::mesh::curved::{self, Straightened, Straightening};
use tetrascope_core::mesh::{Association, volume_corners};
use tetrascope_core::{Cells, Error, Scalars, TetMesh, number};

use crate::fields::{
    Array, Choice, GHOST_LEVELS, Loaded, MOST_COMPONENTS, Part, association_name, choose, is_wide,
};
use crate::polyhedra::{Added, Polyhedra};
use crate::source::{count, format_error, reserve, room};

/// An unstructured mesh as a file holds it, with all its fields.
#[derive(Clone, Debug, Default)]
pub struct MeshData {
    /// Positions, world space. Some may be used by no cell.
    pub points: Vec<DVec3>,
    /// Cells of any type; every index is checked against `points`.
    pub cells: Cells,
    /// Every scalar field; a vector is its components and its magnitude. The
    /// file's active scalars come first, then scalars, then parts of vectors,
    /// then identifiers and masks. Their values are read when they are asked for.
    pub fields: Vec<MeshField>,
    /// Findings, repairs and omissions, one sentence each.
    pub notes: Vec<String>,
    /// The files that were read: the mesh's and, with Plot3D, the solution's.
    pub files: Vec<PathBuf>,
    /// The arrays that the fields are parts of.
    pub(crate) arrays: Vec<Array>,
    /// Whether each of the file's cells is among `cells`; empty if all are.
    pub(crate) kept_cells: Vec<bool>,
    /// The faces of polyhedra, until these are cut.
    pub(crate) polyhedra: Option<Box<Polyhedra>>,
    /// The points and cells that polyhedra became. They are in `points` and `cells`, but not in the arrays.
    pub(crate) added: Option<Box<Added>>,
    /// Arrays that cannot be drawn, by name, and why.
    pub(crate) left_out: Vec<(String, String)>,
}

/// A scalar field of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshField {
    /// Name in the file: `T`, `stress-XY`, `velocity-magnitude`.
    pub name: String,
    /// Where its values live.
    pub association: Association,
    /// The least and greatest finite value that volume cells use, if there is any.
    pub range: Option<(f64, f64)>,
    /// How many values that volume cells use are not finite.
    pub missing: u64,
    /// Index of its array among those of the mesh, and the part that it is.
    array: usize,
    part: Part,
}

impl MeshField {
    /// A field of which only this is known: it has no values.
    pub(crate) fn described(field: &crate::lists::PieceField) -> MeshField {
        MeshField {
            name: field.name.clone(),
            association: field.association,
            range: field.range,
            missing: 0,
            array: 0,
            part: Part::Component(0),
        }
    }
}

impl MeshData {
    /// Each field as "density [0.19, 4.98] (point)".
    ///
    /// The range is that of the finite values that volume cells use.
    pub fn field_list(&self) -> Vec<String> {
        let line = |field: &MeshField| {
            let range = match field.range {
                Some(range) => number::range(range),
                None => "[no finite value]".into(),
            };
            let association = association_name(field.association);
            format!("{} {range} ({association})", field.name)
        };
        self.fields.iter().map(line).collect()
    }

    /// The number of the field that a name means, and what is to be said about the choice.
    ///
    /// A name is one of those listed, with `cell:` or `point:` before it, or ` (cell)` or
    /// ` (point)` behind it, where it is at points and in cells. A vector's own name is
    /// its magnitude. Where the file does not name components, `v-x` or `s-xy` (or `v_x`,
    /// `v:x`, `v.x`) is taken for the component that it is by custom. Without a name: the first field that is not the
    /// same everywhere, or simply the first.
    ///
    /// # Errors
    /// [`Error::NoSuchField`] lists what there is, with ranges;
    /// [`Error::Invalid`] if there is no field at all, or the array was left out.
    pub fn choose(&self, name: Option<&str>) -> Result<(usize, Option<String>), Error> {
        let fields = self.fields.iter();
        let names: Vec<_> = fields.map(|f| (f.name.as_str(), f.association)).collect();
        if let Some(Choice { index, note }) =
            choose(&names, name, |i| is_wide(self.fields[i].range))
        {
            return Ok((index, note));
        }
        let is_wanted = |(array, _): &&(String, String)| {
            let rest = name.map_or(Some(""), |name| name.strip_prefix(array.as_str()));
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
        };
        if let Some((array, why)) = self.left_out.iter().find(is_wanted) {
            return Err(Error::Invalid {
                what: format!("array '{array}' cannot be drawn: {why}"),
                help: None,
            });
        }
        if self.fields.is_empty() {
            return Err(Error::Invalid {
                what: "the mesh has no scalar field to draw".into(),
                help: Some(self.without_fields()),
            });
        }
        Err(Error::NoSuchField {
            name: name.unwrap_or_default().into(),
            available: self.field_list(),
        })
    }

    /// A hint where there is no field.
    fn without_fields(&self) -> String {
        let is_plot3d = |file: &PathBuf| {
            let extension = file.extension().unwrap_or_default().to_string_lossy();
            crate::plot3d::has_extension(&extension.to_ascii_lowercase())
        };
        match self.files.first().is_some_and(is_plot3d) {
            true => "give the file that holds the fields with `solution`".into(),
            false => {
                "write it again with the values that it has at its points or in its cells".into()
            }
        }
    }

    /// The field that [`MeshData::choose`] finds, with its values.
    ///
    /// # Errors
    /// As [`MeshData::choose`] and [`MeshData::scalars`].
    pub fn field(&self, name: Option<&str>) -> Result<Scalars, Error> {
        self.scalars(self.choose(name)?.0)
    }

    /// Reads the values of field number `field`: one per point or per cell.
    ///
    /// # Errors
    /// Those of the file, if it is read only now, and too little memory.
    ///
    /// # Panics
    /// If there are not so many fields.
    pub fn scalars(&self, field: usize) -> Result<Scalars, Error> {
        let MeshField {
            name, array, part, ..
        } = &self.fields[field];
        let array = &self.arrays[*array];
        Ok(Scalars {
            name: name.clone(),
            association: array.association,
            values: self.values(array, *part)?,
        })
    }

    /// All numbers of an array: those of the first point or cell, then those of the next.
    pub(crate) fn tuples(&self, array: &Array) -> Result<Vec<f64>, Error> {
        if array.components == 1 {
            return self.values(array, Part::Component(0));
        }
        let parts = (0..array.components).map(|c| self.values(array, Part::Component(c)));
        let parts = parts.collect::<Result<Vec<_>, _>>()?;
        let mut tuples = room(parts.iter().map(Vec::len).sum())?;
        for i in 0..parts[0].len() {
            tuples.extend(parts.iter().map(|part| part[i]));
        }
        Ok(tuples)
    }

    /// The values of a part of an array, at each point or cell.
    fn values(&self, array: &Array, part: Part) -> Result<Vec<f64>, Error> {
        let association = array.association;
        let needed = match (association, &self.added) {
            (Association::Point, None) => self.points.len(),
            (Association::Point, Some(added)) => self.points.len() - added.points(),
            (Association::Cell, None) => self.cells.types.len(),
            (Association::Cell, Some(added)) => added.copies.len(),
        };
        let mut values = room(needed)?;
        self.each_tuple(array, |tuple| {
            // The array was counted when it was found.
            if values.len() < needed {
                values.push(part.of(tuple));
            }
        })?;
        match (association, &self.added) {
            (_, None) => {}
            (Association::Point, Some(added)) => added.extend_points(&mut values)?,
            (Association::Cell, Some(added)) => values = added.spread_cells(&values)?,
        }
        Ok(values)
    }

    /// A mesh in memory as a reader returns one, with its scalars for a field; for example to
    /// write it.
    ///
    /// # Errors
    /// Too little memory.
    pub fn of(mesh: &TetMesh) -> Result<MeshData, Error> {
        let cells = match mesh.cells() {
            Some(cells) => (**cells).clone(),
            None => {
                let corners = mesh.tetrahedra().as_flattened();
                Cells {
                    types: vec![10; mesh.tetrahedra().len()], // VTK_TETRA
                    offsets: (0..=corners.len() as u64).step_by(4).collect(),
                    connectivity: corners.iter().map(|&point| point.into()).collect(),
                }
            }
        };
        let data = MeshData {
            points: mesh.points().to_vec(),
            cells,
            ..MeshData::default()
        };
        let Scalars {
            name,
            association,
            mut values,
        } = mesh.scalars().clone();
        if association == Association::Cell && mesh.cells().is_none() {
            let of_cell = (0..mesh.cell_count()).map(|cell| values[mesh.source_cell(cell)]);
            values = of_cell.collect();
        }
        let tuples = values.len();
        let numbers = Arc::new(Loaded(values));
        data.with_arrays(vec![Array::scalar(&name, association, tuples, numbers)])
    }

    /// This mesh with field number `field` alone, and what says how its cells are curved.
    ///
    /// # Errors
    /// As [`MeshData::scalars`].
    ///
    /// # Panics
    /// If there are not so many fields.
    pub fn with_field(mut self, field: usize) -> Result<MeshData, Error> {
        let Scalars {
            name,
            association,
            values,
        } = self.scalars(field)?;
        let tuples = values.len();
        let numbers = Arc::new(Loaded(values));
        let mut arrays = vec![Array::scalar(&name, association, tuples, numbers)];
        for array in self.shape_arrays().filter(|array| array.name != name) {
            let values = self.tuples(array)?;
            arrays.push(Array {
                tuples: values.len() / array.components,
                numbers: Arc::new(Loaded(values)),
                ..array.clone()
            });
        }
        let alone = MeshData {
            points: std::mem::take(&mut self.points),
            cells: std::mem::take(&mut self.cells),
            notes: std::mem::take(&mut self.notes),
            files: std::mem::take(&mut self.files),
            ..MeshData::default()
        };
        alone.with_arrays(arrays)
    }

    fn with_arrays(mut self, arrays: Vec<Array>) -> Result<MeshData, Error> {
        self.add_fields(arrays)?;
        Ok(self)
    }

    /// The tetrahedra of this mesh with one of its fields, chosen as by
    /// [`MeshData::choose`], and cells of other types as they are.
    ///
    /// # Errors
    /// As [`MeshData::field`] and [`TetMesh::new`].
    pub fn into_mesh(self, field: Option<&str>) -> Result<TetMesh, Error> {
        let field = self.choose(field)?.0;
        self.into_mesh_of(field)
    }

    /// As [`MeshData::into_mesh`], with field number `field`.
    ///
    /// # Errors
    /// As [`MeshData::scalars`] and [`TetMesh::new`].
    ///
    /// # Panics
    /// If there are not so many fields.
    pub fn into_mesh_of(mut self, field: usize) -> Result<TetMesh, Error> {
        let scalars = self.scalars(field)?;
        self.arrays = Vec::new(); // they may hold the file's bytes
        TetMesh::from_cells(self.points, self.cells, scalars)
    }

    /// The points and cells of this mesh and the values of fields, with curved cells cut into straight
    /// ones: [`straighten`](curved::straighten).
    ///
    /// # Errors
    /// As [`straighten`](curved::straighten), and those of the file, where arrays are read only now.
    pub fn into_straight(
        self,
        scalars: Vec<Scalars>,
        how: Straightening,
    ) -> Result<Straightened, Error> {
        let extra = self.extra()?;
        let MeshData { points, cells, .. } = self; // arrays may hold the file's bytes
        curved::straighten(points, cells, scalars, &extra, how)
    }

    /// Adds the scalar fields that arrays offer, by rank, with their ranges. Each array has
    /// a tuple for each point or cell of the file.
    ///
    /// # Errors
    /// Those of the file, where arrays are read only now.
    pub(crate) fn add_fields(&mut self, mut arrays: Vec<Array>) -> Result<(), Error> {
        arrays.sort_by_key(Array::rank); // stable
        let mut cells = self.cells.types.iter();
        let is_volume: Vec<bool> = match &self.added {
            None => cells.map(|&t| volume_corners(t).is_some()).collect(),
            // The first piece of a polyhedron is a volume as all are.
            Some(added) => {
                let first = |&n: &u32| cells.nth((n as usize).saturating_sub(1));
                let kinds = added.copies.iter().map(first);
                kinds
                    .map(|kind| kind.is_some_and(|&t| volume_corners(t).is_some()))
                    .collect()
            }
        };
        let corners = self.volume_corners();
        for array in arrays {
            let parts = array.parts();
            let used = match array.association {
                Association::Point => &corners,
                Association::Cell => &is_volume,
            };
            let mut ranges = vec![(None, 0); parts.len()];
            let mut index = 0;
            self.each_tuple(&array, |tuple| {
                if used.get(index) == Some(&true) {
                    for ((_, part), (range, missing)) in parts.iter().zip(&mut ranges) {
                        let value = part.of(tuple);
                        widen(range, value);
                        *missing += u64::from(!value.is_finite());
                    }
                }
                index += 1;
            })?;
            for ((name, part), (range, missing)) in parts.into_iter().zip(ranges) {
                self.fields.push(MeshField {
                    name,
                    association: array.association,
                    range,
                    missing,
                    array: self.arrays.len(),
                    part,
                });
            }
            if array.colors {
                self.notes.push(format!(
                    "'{}' holds colors, which are drawn as numbers: a channel, or the magnitude of three",
                    array.name
                ));
            }
            self.arrays.push(array);
        }
        Ok(())
    }

    /// Calls `each` with the tuples of the points or cells that are kept.
    fn each_tuple(&self, array: &Array, mut each: impl FnMut(&[f64])) -> Result<(), Error> {
        let kept: &[bool] = match array.association {
            Association::Point => &[],
            Association::Cell => &self.kept_cells,
        };
        let mut tuple = [0.0; MOST_COMPONENTS];
        let (mut filled, mut index) = (0, 0);
        array.numbers.each(&mut |value| {
            tuple[filled] = value;
            filled += 1;
            if filled == array.components {
                if kept.get(index) != Some(&false) {
                    each(&tuple[..filled]);
                }
                filled = 0;
                index += 1;
            }
        })
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

    /// Whether each point is a corner of a volume cell.
    fn volume_corners(&self) -> Vec<bool> {
        let Cells {
            types,
            offsets,
            connectivity,
        } = &self.cells;
        let corners = |(&cell_type, ends): (&u8, &[u64])| {
            let points = &connectivity[ends[0] as usize..ends[1] as usize];
            points.iter().take(volume_corners(cell_type).unwrap_or(0))
        };
        let cells = types.par_iter().zip(offsets.par_windows(2));
        let corners = cells.flat_map_iter(corners);
        marked(self.points.len(), corners.map(|&point| point as usize))
    }

    /// How many corners of volume cells lie exactly where another does. [`TetMesh`] takes them
    /// for one, so that the cells there are neighbors.
    pub(crate) fn coincident_points(&self) -> usize {
        let used = self.volume_corners();
        let mut corners: Vec<usize> = (0..self.points.len()).filter(|&p| used[p]).collect();
        // Adding 0 turns −0 into +0, which is at the same place.
        let place = |point: &usize| self.points[*point].to_array().map(|x| (x + 0.0).to_bits());
        corners.par_sort_unstable_by_key(place);
        let pairs = corners.par_windows(2);
        pairs
            .filter(|pair| place(&pair[0]) == place(&pair[1]))
            .count()
    }

    /// Leaves out duplicate and hidden cells and those with a hidden point
    /// (vtkDataSetAttributes: DUPLICATECELL 1, HIDDENCELL 32, HIDDENPOINT 2).
    /// Each array of `ghosts` has one value a point or a cell.
    pub(crate) fn remove_ghosts(&mut self, path: &Path, ghosts: &[Array]) -> Result<(), Error> {
        self.remove_all_ghosts(ghosts)?;
        if self.cells.types.is_empty() {
            return Err(format_error(
                path,
                "the ghost array",
                "every cell is marked as duplicate or hidden",
            ));
        }
        Ok(())
    }

    /// As [`MeshData::remove_ghosts`], also where that leaves no cell.
    pub(crate) fn remove_all_ghosts(&mut self, ghosts: &[Array]) -> Result<(), Error> {
        let mut keep = vec![true; self.cells.types.len()];
        for ghost in ghosts {
            let mut values = Vec::new();
            ghost.numbers.each(&mut |flags| values.push(flags as u64))?;
            let flags = |index: usize| values.get(index).map_or(0, |&flags| flags);
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
        // Cells may have been removed before: those that were kept are judged now.
        let mut flags = keep.iter();
        if self.kept_cells.is_empty() {
            self.kept_cells = keep.to_vec();
        } else {
            for kept in self.kept_cells.iter_mut().filter(|kept| **kept) {
                *kept = *flags.next().expect("one flag per cell that was kept");
            }
        }
        self.notes
            .push(format!("{} left out: {why}", count(removed, "cell")));
    }
}

/// One hexahedron between each eight neighboring points of a block whose points
/// begin at `base`; point (i, j, k) is number i + ni (j + nj k) of the block.
///
/// The points are in memory, so that their number does not overflow; a dimension of 0 makes no cells.
pub(crate) fn add_hexahedra(
    cells: &mut Cells,
    dimensions: [u64; 3],
    base: u64,
) -> Result<(), Error> {
    let [ni, nj, nk] = dimensions;
    let number: usize = dimensions
        .map(|n| (n as usize).saturating_sub(1))
        .iter()
        .product();
    reserve(&mut cells.connectivity, 8 * number)?;
    reserve(&mut cells.offsets, number)?;
    reserve(&mut cells.types, number)?;
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
    Ok(())
}

/// Makes a range hold `value`, if that is finite.
fn widen(range: &mut Option<(f64, f64)>, value: f64) {
    if value.is_finite() {
        let (low, high) = range.unwrap_or((value, value));
        *range = Some((value.min(low), value.max(high)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(name: &str, association: Association, values: &[f64]) -> Array {
        Array {
            name: name.into(),
            association,
            components: 1,
            component_names: Vec::new(),
            tuples: values.len(),
            numbers: Arc::new(Loaded(values.into())),
            active: false,
            colors: false,
        }
    }

    fn arrays() -> Vec<Array> {
        vec![
            array("flat", Association::Point, &[1.0, 1.0, 1.0, 1.0, 1.0, 2.0]),
            array(
                "t",
                Association::Point,
                &[0.5, f64::NAN, 1e-9, 3.0, 2.0, 7.0],
            ),
            array("c", Association::Cell, &[-1.0, 250_000.25]),
        ]
    }

    /// Two tetrahedra on five points, and a sixth point that none uses.
    fn mesh() -> MeshData {
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
            ..MeshData::default()
        }
    }

    fn data() -> MeshData {
        let mut data = mesh();
        data.add_fields(arrays()).expect("in memory");
        data
    }

    #[test]
    fn fields_are_listed_with_the_range_that_cells_use() {
        let list = data().field_list();
        assert_eq!(
            list,
            [
                "flat [1, 1] (point)",
                "t [1e-9, 3] (point)",
                "c [-1, 250000.2] (cell)"
            ]
        );
        let missing: Vec<u64> = data().fields.iter().map(|f| f.missing).collect();
        assert_eq!(missing, [0, 1, 0]);
    }

    #[test]
    fn the_first_field_that_varies_is_the_default() {
        assert_eq!(data().field(None).expect("there are fields").name, "t");
        assert_eq!(data().field(Some("c")).expect("it exists").name, "c");
        let error = data().field(Some("x")).expect_err("there is no x");
        assert!(error.to_string().contains("t [1e-9, 3] (point)"), "{error}");
        let empty = MeshData::default();
        assert!(empty.field(None).is_err());
    }

    #[test]
    fn leaving_out_a_cell_keeps_the_values_of_the_others() {
        let mut data = mesh();
        data.retain_cells(&[false, true], "a reason");
        data.add_fields(arrays()).expect("in memory");
        assert_eq!(data.cells.connectivity, [1, 2, 3, 4]);
        assert_eq!(data.cells.offsets, [0, 4]);
        let values = |field| data.scalars(field).expect("in memory").values;
        assert_eq!(values(2), [250_000.25]);
        assert_eq!(data.fields[2].range, Some((250_000.25, 250_000.25)));
        assert_eq!(values(0).len(), 6);
        assert_eq!(data.notes, ["1 cell left out: a reason"]);
    }

    #[test]
    fn cells_can_be_left_out_twice() {
        let mut data = mesh();
        let Cells {
            types,
            offsets,
            connectivity,
        } = &mut data.cells;
        types.push(10);
        offsets.push(12);
        connectivity.extend([0, 2, 3, 4]);
        data.retain_cells(&[true, false, true], "a reason");
        data.retain_cells(&[false, true], "another");
        let cells = array("c", Association::Cell, &[1.0, 2.0, 3.0]);
        data.add_fields(vec![cells]).expect("in memory");
        assert_eq!(data.field(Some("c")).expect("it exists").values, [3.0]);
    }

    #[test]
    fn cells_without_volume_do_not_make_a_field_vary() {
        let mut data = mesh();
        data.cells.types[1] = 9; // a quadrilateral
        let cells = array("zone", Association::Cell, &[1.0, 2.0]);
        data.add_fields(vec![cells, array("t", Association::Point, &[1.0; 6])])
            .expect("in memory");
        assert_eq!(data.fields[0].range, Some((1.0, 1.0)));
        assert_eq!(data.fields[1].range, Some((1.0, 1.0)));
    }
}
