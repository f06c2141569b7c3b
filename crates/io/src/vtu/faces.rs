//! The faces of polyhedra, in both layouts of `.vtu` files.
//!
//! Until VTK 9.3, `faces` lists for each polyhedron how many faces it has and for each of these
//! how many points it has, and which; `faceoffsets` says where each polyhedron ends, and −1 for
//! other cells. Since VTK 9.4, `face_offsets` says where each face ends in
//! `face_connectivity`, and `polyhedron_offsets` where each cell ends in `polyhedron_to_faces`.

use tetrascope_core::Error;

use super::document::{ArrayElement, Piece};
use super::{Budget, Opened};
use crate::MeshData;
use crate::polyhedra::POLYHEDRON;
use crate::source::{Source, count};

/// The faces of the polyhedra of a piece, of which one may belong to two cells.
struct Faces {
    /// The numbers of the faces of one cell after the other.
    of_cells: Vec<u64>,
    /// Where those of each cell end.
    cell_ends: Vec<u64>,
    points: Vec<u64>,
    /// Where each face ends among the points.
    face_ends: Vec<u64>,
}

/// Reads the faces of the polyhedra of a piece, whose first point and cell are given by their
/// numbers in the mesh, and puts their points in the place of the cells' own.
pub(super) fn read(
    budget: &Budget,
    file: &Opened,
    piece: &Piece,
    (first_point, first_cell): (u64, usize),
    data: &mut MeshData,
) -> Result<(), Error> {
    let source = file.source;
    let named = |name: &str| {
        let is_it = |array: &&ArrayElement| array.name.eq_ignore_ascii_case(name);
        piece.topology.iter().find(is_it)
    };
    let kinds = &data.cells.types[first_cell..];
    let faces = match (named("face_connectivity"), named("faces")) {
        (Some(points), _) => by_number(budget, file, piece, points, &named)?,
        (None, Some(stream)) => by_cell(budget, file, piece, stream, &named, kinds)?,
        (None, None) => {
            let what = "there are polyhedra, but no array 'faces' or 'face_connectivity'";
            return Err(source.error("<Cells>", what));
        }
    };
    if let Some(i) = faces.points.iter().position(|&point| point >= piece.points) {
        let what = format!(
            "value {i} is point {}, but the piece has {}",
            faces.points[i],
            count(piece.points, "point")
        );
        return Err(source.error("the faces of polyhedra", what));
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
            for &face in faces.of_cell(cell - first_cell) {
                let points = faces.points_of(face);
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
                source.error("array 'offsets'", what)
            })?;
            connectivity.extend_from_slice(old_cell);
        }
        data.cells.offsets[cell + 1] = connectivity.len() as u64;
    }
    Ok(())
}

impl Faces {
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

/// Reads the layout since VTK 9.4.
fn by_number<'a>(
    budget: &Budget,
    file: &Opened,
    piece: &Piece,
    points: &ArrayElement,
    named: &impl Fn(&str) -> Option<&'a ArrayElement<'a>>,
) -> Result<Faces, Error> {
    let source = file.source;
    let needed = |name: &str| {
        named(name).ok_or_else(|| source.error("<Cells>", format!("there is no array '{name}'")))
    };
    let ends = |name: &str, values: u64| {
        let ends = file.decoder.indices(needed(name)?, values)?;
        check_ends(source, name, &ends)?;
        Ok::<_, Error>(ends)
    };
    let last = |ends: &[u64]| ends.last().copied().unwrap_or(0);
    let cell_ends = ends("polyhedron_offsets", piece.cells)?;
    let of_cells = needed("polyhedron_to_faces")?;
    budget.check(0, last(&cell_ends))?;
    let of_cells = file.decoder.indices(of_cells, last(&cell_ends))?;
    let faces = of_cells
        .iter()
        .max()
        .map_or(0, |face| face.saturating_add(1));
    budget.check(0, faces)?;
    let face_ends = ends("face_offsets", faces)?;
    budget.check(0, last(&face_ends))?;
    Ok(Faces {
        points: file.decoder.indices(points, last(&face_ends))?,
        of_cells,
        cell_ends,
        face_ends,
    })
}

fn check_ends(source: &Source, name: &str, ends: &[u64]) -> Result<(), Error> {
    let Some(i) = ends.array_windows().position(|[a, b]| a > b) else {
        return Ok(());
    };
    let what = format!(
        "value {} is {}, less than the one before",
        i + 1,
        ends[i + 1]
    );
    Err(source.error(format!("array '{name}'"), what))
}

/// Reads the layout until VTK 9.3.
fn by_cell<'a>(
    budget: &Budget,
    file: &Opened,
    piece: &Piece,
    stream: &ArrayElement,
    named: &impl Fn(&str) -> Option<&'a ArrayElement<'a>>,
    kinds: &[u8],
) -> Result<Faces, Error> {
    let source = file.source;
    let element = named("faceoffsets")
        .ok_or_else(|| source.error("<Cells>", "there is no array 'faceoffsets'"))?;
    if element.components != 1 {
        return Err(source.error("array 'faceoffsets'", "offsets have one component each"));
    }
    // Below 0 where a cell has none.
    let mut stream_ends: Vec<i64> = Vec::new();
    let decoder = &file.decoder;
    decoder.each_float(element, piece.cells, &mut |end| {
        stream_ends.push(end as i64)
    })?;
    let length = stream_ends.iter().max().map_or(0, |&end| end.max(0));
    // The list, and at most as many points, faces and ends of faces.
    budget.check(0, 4_u64.saturating_mul(length as u64))?;
    let values = decoder.indices(stream, length as u64)?;
    let mut faces = Faces {
        of_cells: Vec::new(),
        cell_ends: Vec::new(),
        points: Vec::new(),
        face_ends: Vec::new(),
    };
    let mut rest = values.as_slice();
    let take = |rest: &mut &[u64]| {
        let (&first, others) = rest.split_first()?;
        *rest = others;
        usize::try_from(first).ok()
    };
    for (cell, (&kind, &end)) in kinds.iter().zip(&stream_ends).enumerate() {
        if kind == POLYHEDRON {
            let mut read = || {
                let count = take(&mut rest)?;
                for _ in 0..count {
                    let size = take(&mut rest)?;
                    let (points, others) = rest.split_at_checked(size)?;
                    rest = others;
                    faces.points.extend_from_slice(points);
                    faces.of_cells.push(faces.face_ends.len() as u64);
                    faces.face_ends.push(faces.points.len() as u64);
                }
                let is_end = (values.len() - rest.len()) as i64 == end;
                is_end.then_some(())
            };
            read().ok_or_else(|| {
                let what = format!("the faces of cell {cell} do not end at {end}");
                source.error("array 'faces'", what)
            })?;
        }
        faces.cell_ends.push(faces.of_cells.len() as u64);
    }
    Ok(faces)
}
