//! Pieces of a mesh, from one file or several, and how they become one.
//!
//! Each piece keeps its own points. Where these lie exactly at those of another piece, cells of
//! both that have a face there become neighbors. Readers say what a piece is by [`Piece`]; what
//! follows is the same for all of them.

mod arrays;
mod faces;
pub(crate) mod sections;

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::mesh::{Association, volume_corners};
use tetrascope_core::{Error, glam};

#[cfg(test)]
pub(crate) use self::arrays::MOST_FILLED;
pub(crate) use self::arrays::{Fields, PieceArray};
pub(crate) use self::faces::{Faces, check_ends};

use self::arrays::find_arrays;
use crate::MeshData;
use crate::fields::{Numbers, take_ghosts};
use crate::mesh_data::add_hexahedra;
use crate::polyhedra::POLYHEDRON;
use crate::read::check;
use crate::source::{count, format_error_with_help, reserve, room};

/// Takes indices, one part after the other.
pub(crate) type EachIndices<'f> = &'f mut dyn FnMut(&[u64]) -> Result<(), Error>;

/// A piece as its file holds it.
pub(crate) trait Piece {
    /// Its name in a file that lists several.
    fn name(&self) -> Option<&str>;

    fn points(&self) -> u64;

    fn cells(&self) -> u64;

    /// How many points there are along each axis, if the cells are the hexahedra between them.
    fn dimensions(&self) -> Option<[u64; 3]>;

    /// Calls `each` with the VTK types of the cells.
    fn types(&self, each: EachIndices) -> Result<(), Error>;

    /// Where each cell ends in the connectivity.
    fn ends(&self) -> Result<Vec<u64>, Error>;

    /// Calls `each` with the points of the cells, `length` of them.
    fn connectivity(&self, length: u64, each: EachIndices) -> Result<(), Error>;

    /// The faces of the polyhedra among the cells, whose types are `kinds`.
    fn faces(&self, budget: &Budget, kinds: &[u8]) -> Result<Faces, Error>;

    /// Calls `each` with x, y and z of each point.
    fn each_coordinate(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error>;

    /// The arrays at points or in cells.
    fn arrays(&self, association: Association) -> Vec<PieceArray<'_>>;

    /// The numbers of one of these arrays, a tuple for each point or cell.
    fn numbers(&self, association: Association, array: usize) -> Arc<dyn Numbers>;

    /// Whether hexahedra of any order have the numbering that VTK had before version 9.
    fn is_before_vtk_9(&self) -> bool {
        false
    }

    /// An error at a place in the file.
    fn error(&self, at: &str, what: String) -> Error;
}

/// Joins pieces to a mesh, which gets the notes that `data` has. Pieces without cells add
/// nothing.
pub(crate) fn join<P: Piece>(
    budget: &Budget,
    pieces: Vec<P>,
    fields: Fields,
    data: MeshData,
) -> Result<MeshData, Error> {
    join_as(Role::Whole, budget, pieces, fields, data)
}

/// The use that a mesh is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// To be the whole. It has cells.
    Whole,
    /// To be a part of a mesh, the others of which are read elsewhere. It may have no cells, and its points are in an order that
    /// others agree on, as cells are cut by it ([`by_place`]).
    Part,
}

/// As [`join`], for a role.
pub(crate) fn join_as<P: Piece>(
    role: Role,
    budget: &Budget,
    mut pieces: Vec<P>,
    fields: Fields,
    mut data: MeshData,
) -> Result<MeshData, Error> {
    // Their arrays are often absent.
    pieces.retain(|piece| piece.cells() > 0);
    if role == Role::Part && pieces.is_empty() {
        return Ok(data);
    }
    let points = read_cells(budget, &mut pieces, fields, &mut data)?;
    let joined = data.notes.len();
    let kept = keep_points(budget, points, &mut data)?;
    read_points(&pieces, kept.as_deref(), &mut data)?;
    let mut arrays = find_arrays(&pieces, fields, &mut data);
    if let Some(kept) = kept {
        for array in &mut arrays {
            if array.association == Association::Point {
                array.tuples = kept.len();
                array.numbers = kept_numbers(array.numbers.clone(), array.components, &kept);
            }
        }
    }
    check(&budget.path, &data, &arrays)?;
    let mut end = 0;
    let ends = pieces.iter().map(|piece| {
        end += piece.cells() as usize; // counted
        (end, piece.is_before_vtk_9())
    });
    let ends: Vec<(usize, bool)> = ends.collect();
    data.renumber_old(&arrays, |cell| {
        let piece = ends.partition_point(|(end, _)| *end <= cell);
        ends.get(piece).is_some_and(|(_, is_old)| *is_old)
    })?;
    if role == Role::Part {
        by_place(&mut data, &mut arrays)?;
    }
    let ghosts = take_ghosts(&mut arrays);
    match role {
        Role::Whole => data.remove_ghosts(&budget.path, &ghosts)?,
        Role::Part => data.remove_all_ghosts(&ghosts)?,
    }
    if data.cells.types.is_empty() {
        return Ok(data);
    }
    if let Some(polyhedra) = data.polyhedra.take() {
        polyhedra.split(&budget.path, &mut data, budget.most)?;
    }
    if pieces.len() > 1 {
        let pieces = count(pieces.len() as u64, "piece");
        let note = match data.coincident_points() {
            0 => format!("{pieces} joined"),
            points => format!(
                "{pieces} joined: {} where others are, and neighbors share faces there",
                match points {
                    1 => "1 point lies exactly".into(),
                    _ => format!("{points} points lie exactly"),
                }
            ),
        };
        data.notes.insert(joined, note);
    }
    data.add_fields(arrays)?;
    Ok(data)
}

/// The most bytes that points and cells of rectilinear grids may take, which files only imply:
/// as many as samples of packed grids.
pub(crate) fn most_implied(file_bytes: u64) -> u64 {
    (1 << 30) + 64 * file_bytes
}

/// The most bytes that points and cells may take in memory.
///
/// Cells that differ do not compress well: an index that changes takes a byte and more of
/// a compressed file, so that a cell of 41 bytes in memory takes 2.6 or more in the file.
/// Thirty-two times the files thus refuses only cells that repeat each other thousands of
/// times, in a file that is damaged or made to take all memory.
pub(crate) struct Budget {
    /// The file that errors are about.
    path: PathBuf,
    /// The bytes of all files.
    file_bytes: u64,
    most: u64,
}

impl Budget {
    /// For the file at `path`, which has `file_bytes` with those that it lists. Some points and
    /// cells may be only `implied`.
    pub(crate) fn new(path: PathBuf, file_bytes: u64, implied: bool) -> Budget {
        Budget {
            path,
            file_bytes,
            most: match implied {
                true => most_implied(file_bytes),
                false => (32 << 20) + 32 * file_bytes,
            },
        }
    }

    /// Whether so many cells with so many indices are within it.
    pub(crate) fn check(&self, cells: u64, indices: u64) -> Result<(), Error> {
        let bytes = cells
            .saturating_mul(9)
            .saturating_add(indices.saturating_mul(8));
        if bytes <= self.most {
            return Ok(());
        }
        let cells = count(cells, "cell");
        Err(self.error("the cells", &format!("{cells} with {indices} points")))
    }

    /// There are more of something than there can be.
    fn error(&self, at: &str, many: &str) -> Error {
        format_error_with_help(
            &self.path,
            at,
            format!(
                "{many}: so many different ones cannot be in {} bytes",
                self.file_bytes
            ),
            "the file is damaged; write it again",
        )
    }
}

/// Reads the cells of all pieces; returns how many points these have. Where all fields are
/// read, pieces without volume are left out.
fn read_cells<P: Piece>(
    budget: &Budget,
    pieces: &mut Vec<P>,
    fields: Fields,
    data: &mut MeshData,
) -> Result<u64, Error> {
    let mut points = 0_u64;
    data.cells.offsets.push(0);
    let mut flat = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        let cells = data.cells.types.len();
        append_cells(budget, piece, points, data)?;
        let is_flat = data.cells.types[cells..]
            .iter()
            .all(|kind| volume_corners(*kind).is_none() && *kind != POLYHEDRON);
        // Polyhedra are volumes, so that none is counted here.
        if fields == Fields::All && is_flat {
            data.cells.types.truncate(cells);
            data.cells.offsets.truncate(cells + 1);
            let end = *data.cells.offsets.last().expect("it begins with 0");
            data.cells.connectivity.truncate(end as usize);
            let name = piece.name().unwrap_or_default();
            let note = format!("'{name}' left out: it has no cells with a volume");
            data.notes.push(note);
            flat.push(i);
            continue;
        }
        points = points
            .checked_add(piece.points())
            .filter(|&all| i64::try_from(all).is_ok())
            .ok_or_else(|| piece.error("the points", format!("{} cannot be", piece.points())))?;
    }
    let mut number = 0..;
    pieces.retain(|_| {
        number
            .next()
            .is_some_and(|i| flat.binary_search(&i).is_err())
    });
    Ok(points)
}

/// Reads the cells of a piece whose points begin at number `first`.
fn append_cells(
    budget: &Budget,
    piece: &impl Piece,
    first: u64,
    data: &mut MeshData,
) -> Result<(), Error> {
    let cells = &mut data.cells;
    // Text takes a digit and a blank for each number, so that it needs no such bound.
    let (all_cells, all_indices) = (
        (cells.types.len() as u64).saturating_add(piece.cells()),
        cells.connectivity.len() as u64,
    );
    if let Some(dimensions) = piece.dimensions() {
        let indices = piece.cells().saturating_mul(8);
        budget.check(all_cells, all_indices.saturating_add(indices))?;
        return add_hexahedra(cells, dimensions, first);
    }
    budget.check(all_cells, all_indices)?;
    let first_cell = cells.types.len();
    piece.types(&mut |kinds| {
        for &kind in kinds {
            let cell = cells.types.len() - first_cell;
            let kind = u8::try_from(kind).map_err(|_| {
                piece.error(
                    "array 'types'",
                    format!("cell {cell} is of type {kind}, and VTK has none above 255"),
                )
            })?;
            cells.types.push(kind);
        }
        Ok(())
    })?;
    // VTK writes where each cell ends; the last end is the length of the connectivity.
    let ends = piece.ends()?;
    let length = ends.last().copied().unwrap_or(0);
    budget.check(all_cells, all_indices.saturating_add(length))?;
    let start = cells.connectivity.len() as u64;
    reserve(&mut cells.offsets, ends.len())?;
    for (cell, end) in ends.into_iter().enumerate() {
        if end > length {
            return Err(piece.error(
                "array 'offsets'",
                format!("cell {cell} ends at {end}, after the last of {length} points of cells"),
            ));
        }
        cells.offsets.push(start + end);
    }
    piece.connectivity(length, &mut |indices| {
        let done = cells.connectivity.len() as u64 - start;
        if done == 0 {
            reserve(&mut cells.connectivity, length as usize)?;
        }
        let points = piece.points();
        if let Some(i) = indices.iter().position(|&point| point >= points) {
            return Err(piece.error(
                "array 'connectivity'",
                format!(
                    "value {} is point {}, but the piece has {}",
                    done + i as u64,
                    indices[i],
                    count(points, "point")
                ),
            ));
        }
        let joined = indices.iter().map(|point| first + point);
        cells.connectivity.extend(joined);
        Ok(())
    })?;
    match cells.types[first_cell..].contains(&POLYHEDRON) {
        true => {
            let faces = piece.faces(budget, &cells.types[first_cell..])?;
            faces.put(budget, piece, (first, first_cell), data)
        }
        false => Ok(()),
    }
}

/// If all points would take more memory than there is reason for, those that cells use, in
/// ascending order; cells then count only them.
fn keep_points(
    budget: &Budget,
    points: u64,
    data: &mut MeshData,
) -> Result<Option<Arc<[u64]>>, Error> {
    const POINT: u64 = size_of::<DVec3>() as u64;
    let indices = &mut data.cells.connectivity;
    let cells = 9 * data.cells.types.len() as u64 + 8 * indices.len() as u64;
    let for_points = budget.most.saturating_sub(cells);
    if points.saturating_mul(POINT) <= for_points {
        return Ok(None);
    }
    let mut used: Vec<u64> = room(indices.len())?;
    used.extend_from_slice(indices);
    used.sort_unstable();
    used.dedup();
    if used.len() as u64 * POINT > for_points {
        return Err(budget.error("the points", &format!("{} points", used.len())));
    }
    for index in indices {
        *index = used.partition_point(|&point| point < *index) as u64;
    }
    data.notes.push(format!(
        "{} left out: no cell uses them",
        count(points - used.len() as u64, "point")
    ));
    Ok(Some(used.into()))
}

/// Reads the points of all pieces, or those of them whose numbers are in `kept`.
fn read_points<P: Piece>(
    pieces: &[P],
    kept: Option<&[u64]>,
    data: &mut MeshData,
) -> Result<(), Error> {
    let all = pieces.iter().map(Piece::points).sum::<u64>();
    // Either is within the budget.
    data.points = room(kept.map_or(all as usize, <[u64]>::len))?;
    let mut kept = kept.map(|kept| kept.iter().copied().peekable());
    let (mut point, mut filled, mut number) = ([0.0; 3], 0, 0);
    for piece in pieces {
        let points = &mut data.points;
        piece.each_coordinate(&mut |value| {
            point[filled] = value;
            filled += 1;
            if filled < 3 {
                return;
            }
            filled = 0;
            let is_kept = kept
                .as_mut()
                .is_none_or(|kept| kept.next_if_eq(&number).is_some());
            if is_kept {
                points.push(DVec3::from_array(point));
            }
            number += 1;
        })?;
    }
    Ok(())
}

/// Puts the points in the order of their places, least x, y, z first, unless all cells with a volume are tetrahedra.
///
/// Faces with four corners and more are cut by the order of their corners. Parts of a mesh that are read one by one number
/// their points each by itself, but where these lie, all know.
fn by_place(data: &mut MeshData, arrays: &mut [crate::fields::Array]) -> Result<(), Error> {
    const TETRAHEDRON: u8 = 10;
    let is_cut =
        |&kind: &u8| kind == POLYHEDRON || (kind != TETRAHEDRON && volume_corners(kind).is_some());
    if !data.cells.types.iter().any(is_cut) {
        return Ok(());
    }
    let count = data.points.len();
    let mut order: Vec<u64> = room(count)?;
    order.extend(0..count as u64);
    // Adding 0 turns −0 into +0, which is at the same place.
    let place = |point: u64| data.points[point as usize].to_array().map(|x| x + 0.0);
    order.sort_by(|&a, &b| {
        let axes = place(a).into_iter().zip(place(b));
        let mut differing = axes.map(|(a, b)| a.total_cmp(&b));
        differing
            .find(|order| order.is_ne())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut number: Vec<u64> = room(count)?;
    number.resize(count, 0);
    for (new, &old) in (0..).zip(&order) {
        number[old as usize] = new;
    }
    for point in &mut data.cells.connectivity {
        *point = number[*point as usize];
    }
    data.points = order.iter().map(|&old| data.points[old as usize]).collect();
    let order: Arc<[u64]> = order.into();
    for array in arrays {
        if array.association == Association::Point {
            array.numbers = Arc::new(Ordered {
                numbers: array.numbers.clone(),
                components: array.components,
                order: order.clone(),
            });
        }
    }
    Ok(())
}

/// The tuples of an array in another order.
#[derive(Debug)]
struct Ordered {
    numbers: Arc<dyn Numbers>,
    components: usize,
    /// The number of each tuple in `numbers`.
    order: Arc<[u64]>,
}

impl Numbers for Ordered {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut values = room(self.order.len() * self.components)?;
        self.numbers.each(&mut |value| values.push(value))?;
        for &tuple in &*self.order {
            let first = tuple as usize * self.components;
            values[first..first + self.components]
                .iter()
                .for_each(|value| each(*value));
        }
        Ok(())
    }
}

/// The numbers of those tuples of an array whose numbers are in `tuples`, ascending.
pub(crate) fn kept_numbers(
    numbers: Arc<dyn Numbers>,
    components: usize,
    tuples: &Arc<[u64]>,
) -> Arc<dyn Numbers> {
    Arc::new(Kept {
        numbers,
        components,
        tuples: tuples.clone(),
    })
}

/// See [`kept_numbers`].
#[derive(Debug)]
struct Kept {
    numbers: Arc<dyn Numbers>,
    components: usize,
    /// Which tuples, in ascending order.
    tuples: Arc<[u64]>,
}

impl Numbers for Kept {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut kept = self.tuples.iter().peekable();
        let (mut tuple, mut component) = (0, 0);
        self.numbers.each(&mut |value| {
            if kept.peek() == Some(&&tuple) {
                each(value);
            }
            component += 1;
            if component == self.components {
                kept.next_if_eq(&&tuple);
                component = 0;
                tuple += 1;
            }
        })
    }
}
