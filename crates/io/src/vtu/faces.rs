//! The faces of polyhedra, in both layouts of `.vtu` files.
//!
//! Until VTK 9.3, `faces` lists for each polyhedron how many faces it has and for each of these
//! how many points it has, and which; `faceoffsets` says where each polyhedron ends, and −1 for
//! other cells. Since VTK 9.4, `face_offsets` says where each face ends in
//! `face_connectivity`, and `polyhedron_offsets` where each cell ends in `polyhedron_to_faces`.

use tetrascope_core::Error;

use super::Opened;
use super::document::{ArrayElement, Piece};
use crate::pieces::{Budget, Faces, check_ends};
use crate::polyhedra::POLYHEDRON;

/// Reads the faces of the polyhedra of a piece, whose cells have the types `kinds`.
pub(super) fn read(
    budget: &Budget,
    file: &Opened,
    piece: &Piece,
    kinds: &[u8],
) -> Result<Faces, Error> {
    let named = |name: &str| {
        let is_it = |array: &&ArrayElement| array.name.eq_ignore_ascii_case(name);
        piece.topology.iter().find(is_it)
    };
    match (named("face_connectivity"), named("faces")) {
        (Some(points), _) => by_number(budget, file, piece, points, &named),
        (None, Some(stream)) => by_cell(budget, file, piece, stream, &named, kinds),
        (None, None) => {
            let what = "there are polyhedra, but no array 'faces' or 'face_connectivity'";
            Err(file.source.error("<Cells>", what))
        }
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
        check_ends(&ends, |what| source.error(format!("array '{name}'"), what))?;
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
    let mut faces = Faces::default();
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
