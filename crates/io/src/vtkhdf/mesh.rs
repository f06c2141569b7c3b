//! Unstructured, structured and rectilinear grids as meshes.

use std::ops::Range;
use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use super::arrays::{FieldArray, lattice_arrays, listed_arrays, note_left_out};
use super::{Kind, MOST_PAIRS, MOST_PARTS, Step};
use crate::MeshData;
use crate::fields::Numbers;
use crate::grid::number::Number;
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::hdf5::{Dataset, Group, View};
use crate::pieces::{self, Budget, EachIndices, Faces, Fields, PieceArray, check_ends};

/// Reads the mesh of a group at a time step.
pub(super) fn read(
    group: &Group,
    kind: Kind,
    step: Step,
    notes: Vec<String>,
) -> Result<MeshData, Error> {
    let mut data = MeshData {
        notes,
        ..MeshData::default()
    };
    let parts = parts(group, kind, step, None, &mut data)?;
    join(
        group,
        kind == Kind::Rectilinear,
        parts,
        Fields::Common,
        data,
    )
}

/// Joins the parts of a file. Points and cells may be only `implied`.
pub(super) fn join(
    root: &Group,
    implied: bool,
    parts: Vec<Part>,
    fields: Fields,
    data: MeshData,
) -> Result<MeshData, Error> {
    let file = &root.file;
    let mut bytes = 0_u64;
    for part in &parts {
        bytes = bytes.saturating_add(part.bytes()?);
        if bytes > most_unpacked(file.length) {
            return Err(root.error_with_help(
                format!(
                    "{bytes} bytes are packed in {}, which is refused",
                    file.length
                ),
                UNPACK,
            ));
        }
    }
    let budget = Budget::new(file.path.clone(), file.length, implied);
    pieces::join(&budget, parts, fields, data)
}

/// A partition of a mesh, or all of a structured one.
pub(super) struct Part {
    block: Arc<Block>,
    /// Its points among those of the file.
    points: Range<u64>,
    /// Its cells among those of the file.
    cells: Range<u64>,
    topology: Topology,
}

/// A group that holds a mesh.
struct Block {
    group: Group,
    name: Option<String>,
    /// Where the step that is read begins.
    first_point: u64,
    first_cell: u64,
    arrays: [Vec<FieldArray>; 2],
}

/// How cells use points.
enum Topology {
    Listed {
        points: View,
        types: View,
        /// Where each cell begins, and where the last ends.
        offsets: View,
        connectivity: View,
        faces: Option<Box<FaceRows>>,
    },
    Structured {
        dimensions: [u64; 3],
        points: Points,
    },
}

enum Points {
    Each(View),
    /// Along each axis.
    Axes([Vec<f64>; 3]),
}

/// Where the faces of polyhedra are, as [`Faces`]; ends are behind a 0. They may be absent
/// where no cell is a polyhedron.
struct FaceRows {
    of_cells: Range<u64>,
    cell_ends: Range<u64>,
    points: Range<u64>,
    face_ends: Range<u64>,
}

/// The numbers of a partition's things, and where they begin.
struct Counts {
    numbers: Vec<u64>,
    next: u64,
}

impl Counts {
    /// The counts that `dataset` holds for `parts`, the first of which begins at `start`.
    fn of(group: &Group, dataset: &str, parts: &Range<u64>, start: u64) -> Result<Counts, Error> {
        let numbers = needed(group, dataset)?.view(&[], parts.clone())?;
        if numbers.count() != parts.end - parts.start {
            return Err(group.error(format!("'{dataset}' needs a number for each part")));
        }
        Ok(Counts {
            numbers: numbers.indices()?,
            next: start,
        })
    }

    /// The range of a part.
    fn take(&mut self, part: usize) -> Result<Range<u64>, String> {
        let start = self.next;
        let end = start.checked_add(self.numbers[part]);
        self.next = end.ok_or_else(|| format!("part {part} cannot be so large"))?;
        Ok(start..self.next)
    }
}

/// A dataset that must be there.
fn needed(group: &Group, name: &str) -> Result<Dataset, Error> {
    let found = group.dataset(name)?;
    found.ok_or_else(|| group.error(format!("there is no dataset '{name}'")))
}

/// The parts of the mesh of a group. Notes and arrays that are left out go to `data`.
pub(super) fn parts(
    group: &Group,
    kind: Kind,
    step: Step,
    name: Option<String>,
    data: &mut MeshData,
) -> Result<Vec<Part>, Error> {
    match kind {
        Kind::Unstructured => partitions(group, step, name, data),
        _ => structured(group, kind, step, name, data).map(|part| vec![part]),
    }
}

fn partitions(
    group: &Group,
    step: Step,
    name: Option<String>,
    data: &mut MeshData,
) -> Result<Vec<Part>, Error> {
    let at = |name: &str| match step {
        Some((steps, step)) => steps.at(name, step),
        None => Ok(None),
    };
    let first_part = at("PartOffsets")?.unwrap_or(0);
    let all = needed(group, "NumberOfPoints")?;
    let all = all.shape().first().copied().unwrap_or(0);
    let number = at("NumberOfParts")?.unwrap_or(all.saturating_sub(first_part));
    if number > MOST_PARTS {
        return Err(group.error(format!("{number} parts; up to {MOST_PARTS} are read")));
    }
    let of_parts = first_part..first_part.saturating_add(number);
    let first = |name: &str| at(name).map(|first| first.unwrap_or(0));
    let (first_point, first_cell) = (first("PointOffsets")?, first("CellOffsets")?);
    let counts = |name: &str, start| Counts::of(group, name, &of_parts, start);
    let mut points = counts("NumberOfPoints", first_point)?;
    let mut cells = counts("NumberOfCells", first_cell)?;
    let mut indices = counts("NumberOfConnectivityIds", first("ConnectivityIdOffsets")?)?;
    let mut faces = match group.dataset("FaceConnectivity")? {
        None => None,
        Some(_) => Some([
            counts(
                "NumberOfFaceConnectivityIds",
                first("FaceConnectivityOffsets")?,
            )?,
            counts("NumberOfFaces", first("FaceOffsetsOffsets")?)?,
            counts(
                "NumberOfPolyhedronToFaceIds",
                first("PolyhedronToFaceIdOffsets")?,
            )?,
        ]),
    };
    let block = Arc::new(Block {
        group: group.clone(),
        name,
        first_point,
        first_cell,
        arrays: [
            listed_arrays(group, Association::Point, (step, first_point), data)?,
            listed_arrays(group, Association::Cell, (step, first_cell), data)?,
        ],
    });
    let arrays = block.arrays.iter().map(Vec::len).sum::<usize>() as u64;
    if number.saturating_mul(arrays) > MOST_PAIRS {
        return Err(group.error(format!(
            "{arrays} arrays of {number} parts; up to {MOST_PAIRS} pairs are read"
        )));
    }
    let [coordinates, types, offsets, connectivity] =
        ["Points", "Types", "Offsets", "Connectivity"].map(|name| needed(group, name));
    let (coordinates, types, offsets, connectivity) =
        (coordinates?, types?, offsets?, connectivity?);
    let mut parts = Vec::new();
    for (part, before) in (0..number as usize).zip(first_part..) {
        let wrong = |what| group.error(what);
        let points = points.take(part).map_err(wrong)?;
        let cells = cells.take(part).map_err(wrong)?;
        let indices = indices.take(part).map_err(wrong)?;
        let mut of_faces = Vec::new();
        for counts in faces.iter_mut().flatten() {
            of_faces.push(counts.take(part).map_err(wrong)?);
        }
        if cells.is_empty() {
            continue;
        }
        // A part has an offset more than cells, as a part has a face's end more than faces.
        let with_zero = |range: &Range<u64>| {
            let start = range.start.saturating_add(before);
            let length = range.end - range.start;
            start..start.saturating_add(length).saturating_add(1)
        };
        let faces = match &of_faces[..] {
            [indices, of_part, of_cells] => Some(Box::new(FaceRows {
                of_cells: of_cells.clone(),
                cell_ends: with_zero(&cells),
                points: indices.clone(),
                face_ends: with_zero(of_part),
            })),
            _ => None,
        };
        if coordinates.shape().get(1..) != Some(&[3]) {
            let what = format!(
                "points of shape {:?} have no 3 coordinates",
                coordinates.shape()
            );
            return Err(coordinates.error(what));
        }
        let part = Part {
            topology: Topology::Listed {
                points: coordinates.view(&[], points.clone())?,
                types: types.view(&[], cells.clone())?,
                offsets: offsets.view(&[], with_zero(&cells))?,
                connectivity: connectivity.view(&[], indices)?,
                faces,
            },
            block: block.clone(),
            points,
            cells,
        };
        parts.push(part);
    }
    Ok(parts)
}

/// The points along each axis of a structured or rectilinear grid.
pub(super) fn dimensions(group: &Group) -> Result<[u64; 3], Error> {
    let numbers = group.numbers("Dimensions")?.unwrap_or_default();
    let sizes: Result<[f64; 3], _> = numbers.try_into();
    let Ok(sizes) = sizes else {
        return Err(group.error("there is no attribute 'Dimensions' of three numbers"));
    };
    let [i, j, k] = sizes.map(|size| size as u64); // saturating
    let points = [i, j, k].iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
    if [i, j, k].iter().any(|&size| size < 2) {
        return Err(group.error_with_help(
            format!("a grid of {i}×{j}×{k} points has no volume"),
            "volume rendering needs at least 2 points along each axis",
        ));
    }
    match points.and_then(|points| i64::try_from(points).ok()) {
        Some(_) => Ok([i, j, k]),
        None => Err(group.error(format!("a grid of {i}×{j}×{k} points cannot be"))),
    }
}

/// The numbers of a rectilinear grid along an axis, and the ε of their type.
pub(super) fn axis(
    group: &Group,
    (axis, points): (usize, u64),
    step: Step,
) -> Result<(Vec<f64>, f64), Error> {
    let name = ["XCoordinates", "YCoordinates", "ZCoordinates"][axis];
    let start = match step {
        Some((steps, step)) => steps.at(&format!("{name}Offsets"), step)?.unwrap_or(0),
        None => 0,
    };
    let dataset = needed(group, name)?;
    if points > crate::vtu::structured::MOST_POINTS {
        return Err(dataset.error(format!("{points} points along an axis are not read")));
    }
    let view = dataset.view(&[], start..start.saturating_add(points))?;
    if view.count() != points {
        return Err(dataset.error("it needs one number for each point"));
    }
    let epsilon = match dataset.number() {
        Some(Number::F32) => f32::EPSILON.into(),
        _ => f64::EPSILON,
    };
    Ok((view.floats()?, epsilon))
}

fn structured(
    group: &Group,
    kind: Kind,
    step: Step,
    name: Option<String>,
    data: &mut MeshData,
) -> Result<Part, Error> {
    let dimensions = dimensions(group)?;
    let [i, j, k] = dimensions;
    let points = match kind {
        Kind::Rectilinear => Points::Axes([
            axis(group, (0, i), step)?.0,
            axis(group, (1, j), step)?.0,
            axis(group, (2, k), step)?.0,
        ]),
        _ => {
            let points = needed(group, "Points")?;
            if points.shape() != [k, j, i, 3] {
                let shape = points.shape();
                return Err(points.error(format!("{shape:?} where [{k}, {j}, {i}, 3] is needed")));
            }
            Points::Each(points.view(&[], 0..k)?)
        }
    };
    let arrays = |association, data: &mut MeshData| {
        lattice_arrays(group, association, (dimensions, step), &mut data.left_out)
    };
    let arrays = [
        arrays(Association::Point, data)?,
        arrays(Association::Cell, data)?,
    ];
    note_left_out(data);
    Ok(Part {
        block: Arc::new(Block {
            group: group.clone(),
            name,
            first_point: 0,
            first_cell: 0,
            arrays,
        }),
        points: 0..i * j * k, // counted
        cells: 0..(i - 1) * (j - 1) * (k - 1),
        topology: Topology::Structured { dimensions, points },
    })
}

impl Part {
    fn field_arrays(&self, association: Association) -> (&[FieldArray], &Range<u64>, u64) {
        let [of_points, of_cells] = &self.block.arrays;
        match association {
            Association::Point => (of_points, &self.points, self.block.first_point),
            Association::Cell => (of_cells, &self.cells, self.block.first_cell),
        }
    }

    /// How many bytes its points and fields have in the file. Refuses arrays that are shorter
    /// than the part needs.
    fn bytes(&self) -> Result<u64, Error> {
        let mut bytes = (self.points.end - self.points.start).saturating_mul(24);
        for association in [Association::Point, Association::Cell] {
            let (arrays, rows, first) = self.field_arrays(association);
            for array in arrays {
                bytes = bytes.saturating_add(array.view(rows, first)?.bytes());
            }
        }
        Ok(bytes)
    }

    /// The ends that follow a 0 in a list of them.
    fn ends(&self, list: &View) -> Result<Vec<u64>, Error> {
        let mut ends = list.indices()?;
        if ends.first() != Some(&0) {
            let what = format!(
                "the offsets of a part begin with {:?}, not with 0",
                ends.first()
            );
            return Err(self.block.group.error(what));
        }
        ends.remove(0);
        Ok(ends)
    }
}

impl pieces::Piece for Part {
    fn name(&self) -> Option<&str> {
        self.block.name.as_deref()
    }

    fn points(&self) -> u64 {
        self.points.end - self.points.start
    }

    fn cells(&self) -> u64 {
        self.cells.end - self.cells.start
    }

    fn dimensions(&self) -> Option<[u64; 3]> {
        match self.topology {
            Topology::Structured { dimensions, .. } => Some(dimensions),
            Topology::Listed { .. } => None,
        }
    }

    fn types(&self, each: EachIndices) -> Result<(), Error> {
        match &self.topology {
            Topology::Listed { types, .. } => types.each_indices(each),
            Topology::Structured { .. } => Ok(()),
        }
    }

    fn ends(&self) -> Result<Vec<u64>, Error> {
        match &self.topology {
            Topology::Listed { offsets, .. } => self.ends(offsets),
            Topology::Structured { .. } => Ok(Vec::new()),
        }
    }

    fn connectivity(&self, length: u64, each: EachIndices) -> Result<(), Error> {
        let Topology::Listed { connectivity, .. } = &self.topology else {
            return Ok(());
        };
        if connectivity.count() != length {
            let what = format!("{} indices where {length} are needed", connectivity.count());
            return Err(self.block.group.error(what));
        }
        connectivity.each_indices(each)
    }

    fn faces(&self, budget: &Budget, _: &[u8]) -> Result<Faces, Error> {
        let wrong = |what: &str| self.block.group.error(what);
        let Topology::Listed {
            faces: Some(faces), ..
        } = &self.topology
        else {
            return Err(wrong(
                "there are polyhedra, but no dataset 'FaceConnectivity'",
            ));
        };
        let view = |name: &str, rows: &Range<u64>| {
            budget.check(0, rows.end - rows.start)?;
            needed(&self.block.group, name)?.view(&[], rows.clone())
        };
        let faces = Faces {
            of_cells: view("PolyhedronToFaces", &faces.of_cells)?.indices()?,
            cell_ends: self.ends(&view("PolyhedronOffsets", &faces.cell_ends)?)?,
            points: view("FaceConnectivity", &faces.points)?.indices()?,
            face_ends: self.ends(&view("FaceOffsets", &faces.face_ends)?)?,
        };
        let ends = [
            (&faces.cell_ends, faces.of_cells.len(), "PolyhedronOffsets"),
            (&faces.face_ends, faces.points.len(), "FaceOffsets"),
        ];
        for (ends, length, name) in ends {
            check_ends(ends, |what| wrong(&format!("of '{name}', {what}")))?;
            let last = ends.last().copied().unwrap_or(0);
            if last > length as u64 {
                return Err(wrong(&format!("'{name}' ends at {last} of {length}")));
            }
        }
        let number = faces.face_ends.len() as u64;
        match faces.of_cells.iter().find(|&&face| face >= number) {
            Some(face) => Err(wrong(&format!("a polyhedron has face {face} of {number}"))),
            None => Ok(faces),
        }
    }

    fn each_coordinate(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        match &self.topology {
            Topology::Listed { points, .. }
            | Topology::Structured {
                points: Points::Each(points),
                ..
            } => points.each_float(each),
            Topology::Structured {
                points: Points::Axes(axes),
                ..
            } => {
                crate::vtu::structured::each_point(axes, each);
                Ok(())
            }
        }
    }

    fn arrays(&self, association: Association) -> Vec<PieceArray<'_>> {
        let (arrays, ..) = self.field_arrays(association);
        let arrays = arrays.iter().map(|array| PieceArray {
            name: &array.name,
            components: array.components,
            component_names: &[],
            active: array.active,
            // Bytes, three or four at a time, are colors nearly always.
            colors: array.number == Number::U8 && matches!(array.components, 3 | 4),
        });
        arrays.collect()
    }

    fn numbers(&self, association: Association, array: usize) -> Arc<dyn Numbers> {
        let (arrays, rows, first) = self.field_arrays(association);
        let view = arrays[array].view(rows, first);
        Arc::new(view.expect("`Part::bytes` has made it before"))
    }

    fn error(&self, at: &str, what: String) -> Error {
        self.block.group.error(format!("{at}: {what}"))
    }
}
