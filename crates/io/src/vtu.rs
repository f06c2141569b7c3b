//! VTK XML unstructured grids, `.vtu`, and images, `.vti`.
//!
//! *VTK XML Formats*, the VTK documentation. Read are all four encodings
//! (appended raw, which ParaView writes by default, appended base64, inline
//! base64, ASCII), uncompressed or compressed with zlib or LZ4, with 32- and
//! 64-bit headers, in both byte orders and with numbers of any type. Pieces
//! become one mesh and keep their own points. Cells that `vtkGhostType` marks as
//! duplicate or hidden, or that touch a hidden point, are left out. Of several
//! time steps the first is read. The XML may be UTF-8 or, where it says so, ISO-8859-1 or
//! windows-1252.
//!
//! A vector field is its magnitude and its components, which have the file's names
//! (`ComponentName0`…) or numbers: `Velocity-magnitude`, `Velocity-0`, `stress-XY`.
//! Fields are decoded when they are asked for.
//!
//! An image's samples keep their type; `Origin`, `Spacing` and `Direction` say where they
//! lie, and its pieces become one grid. Hidden points are NaN. Large ones that are appended
//! raw and in one piece stay in their file.

mod blocks;
mod decode;
mod document;
mod encoding;
mod image;
mod stored;

use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::glam;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Cells, Error};

pub(crate) use self::document::{attributes, line};
pub(crate) use self::encoding::to_utf8;

use self::decode::Decoder;
use self::document::{ArrayElement, Document, Piece};
use self::stored::{File, Stored};
use crate::MeshData;
use crate::fields::{Array, Numbers, take_ghosts};
use crate::grid::GridData;
use crate::grid::number::Number;
use crate::read::{FileData, check};
use crate::source::{Source, count, reserve, room};

/// Reads a `.vtu` or `.vti` file.
pub(crate) fn read(source: Source) -> Result<FileData, Error> {
    let source = Arc::new(to_utf8(source)?);
    let document = Document::parse(&source)?;
    match &document.image {
        Some(image) => image::read(&source, &document, image).map(FileData::Grid),
        None => read_mesh(&source, &document).map(FileData::Mesh),
    }
}

/// The fields of a `.vti` file of which this is the beginning, left where they are if each
/// stands there as it is and takes more than `above` bytes.
///
/// `None` for others, which [`read`] reads, or refuses with more to say.
pub(crate) fn stream(head: &Source, above: u64) -> Result<Option<GridData>, Error> {
    match Document::parse(head) {
        Ok(document) => image::stream(head, &document, above),
        Err(_) => Ok(None),
    }
}

fn read_mesh(source: &Arc<Source>, document: &Document) -> Result<MeshData, Error> {
    let decoder = Decoder::new(source, document);
    let mut data = MeshData {
        notes: document.notes.clone(),
        ..MeshData::default()
    };
    if document.time_steps > 1 {
        data.notes.push(format!(
            "the file holds {} time steps: the first is read",
            document.time_steps
        ));
    }
    // Pieces without cells add nothing, and their arrays are often absent.
    let pieces: Vec<&Piece> = document.pieces.iter().filter(|p| p.cells > 0).collect();
    if pieces.len() > 1 {
        data.notes
            .push(format!("{} joined", count(pieces.len() as u64, "piece")));
    }
    let points = read_cells(source, &decoder, &pieces, &mut data.cells)?;
    let kept = keep_points(source, points, &mut data)?;
    read_points(source, &decoder, &pieces, kept.as_deref(), &mut data)?;
    let file = File::new(source, document, &decoder);
    let mut arrays = find_arrays(&file, &pieces, &mut data);
    if let Some(kept) = kept {
        for array in &mut arrays {
            if array.association == Association::Point {
                array.tuples = kept.len();
                array.numbers = kept_numbers(array.numbers.clone(), array.components, &kept);
            }
        }
    }
    check(&source.path, &data, &arrays)?;
    let ghosts = take_ghosts(&mut arrays);
    data.remove_ghosts(source, &ghosts)?;
    data.add_fields(arrays)?;
    Ok(data)
}

/// The most bytes that points and cells may take in memory.
///
/// Cells that differ do not compress well: an index that changes takes a byte and more of
/// a compressed file, so that a cell of 41 bytes in memory takes 2.6 or more in the file.
/// Thirty-two times the file thus refuses only cells that repeat each other thousands of
/// times, in a file that is damaged or made to take all memory.
fn budget(source: &Source) -> u64 {
    (32 << 20) + 32 * source.bytes.len() as u64
}

/// Reads the cells of all pieces; returns how many points these have.
fn read_cells(
    source: &Source,
    decoder: &Decoder,
    pieces: &[&Piece],
    cells: &mut Cells,
) -> Result<u64, Error> {
    let mut points = 0_u64;
    let (mut cell_count, mut index_count) = (0_u64, 0_u64);
    let mut check_budget = |more_cells: u64, more_indices: u64| {
        cell_count = cell_count.saturating_add(more_cells);
        index_count = index_count.saturating_add(more_indices);
        let bytes = cell_count
            .saturating_mul(9)
            .saturating_add(index_count.saturating_mul(8));
        if bytes <= budget(source) {
            return Ok(());
        }
        Err(source.error_with_help(
            "<Cells>",
            format!(
                "{} with {index_count} points: so many different ones cannot be in {} bytes",
                count(cell_count, "cell"),
                source.bytes.len()
            ),
            "the file is damaged; write it again",
        ))
    };
    cells.offsets.push(0);
    for piece in pieces {
        let named = |name: &str| -> Result<&ArrayElement, Error> {
            piece
                .topology
                .iter()
                .find(|array| array.name.eq_ignore_ascii_case(name))
                .ok_or_else(|| source.error("<Cells>", format!("there is no array '{name}'")))
        };
        // Text takes a digit and a blank for each number, so that it needs no such bound.
        check_budget(piece.cells, 0)?;
        let start = cells.types.len();
        decoder.each_indices(named("types")?, piece.cells, &mut |kinds| {
            for &kind in kinds {
                let cell = cells.types.len() - start;
                let kind = u8::try_from(kind).map_err(|_| {
                    source.error(
                        "array 'types'",
                        format!("cell {cell} is of type {kind}, and VTK has none above 255"),
                    )
                })?;
                cells.types.push(kind);
            }
            Ok(())
        })?;
        // VTK writes where each cell ends; the last end is the length of the connectivity.
        let ends = decoder.indices(named("offsets")?, piece.cells)?;
        let length = ends.last().copied().unwrap_or(0);
        check_budget(0, length)?;
        let start = cells.connectivity.len() as u64;
        reserve(&mut cells.offsets, ends.len())?;
        for (cell, end) in ends.into_iter().enumerate() {
            if end > length {
                return Err(source.error(
                    "array 'offsets'",
                    format!(
                        "cell {cell} ends at {end}, after the last of {length} points of cells"
                    ),
                ));
            }
            cells.offsets.push(start + end);
        }
        decoder.each_indices(named("connectivity")?, length, &mut |indices| {
            let done = cells.connectivity.len() as u64 - start;
            if done == 0 {
                reserve(&mut cells.connectivity, length as usize)?;
            }
            if indices.iter().any(|&point| point >= piece.points) {
                let (i, point) = (done..)
                    .zip(indices)
                    .find(|(_, point)| **point >= piece.points)
                    .expect("found above");
                return Err(source.error(
                    "array 'connectivity'",
                    format!(
                        "value {i} is point {point}, but the piece has {}",
                        count(piece.points, "point")
                    ),
                ));
            }
            let joined = indices.iter().map(|point| points + point);
            cells.connectivity.extend(joined);
            Ok(())
        })?;
        points = points
            .checked_add(piece.points)
            .filter(|&all| i64::try_from(all).is_ok())
            .ok_or_else(|| source.error("<Piece>", format!("{} points cannot be", piece.points)))?;
    }
    Ok(points)
}

/// If all points would take more memory than there is reason for, those that cells use, in
/// ascending order; cells then count only them.
fn keep_points(
    source: &Source,
    points: u64,
    data: &mut MeshData,
) -> Result<Option<Arc<[u64]>>, Error> {
    const POINT: u64 = size_of::<DVec3>() as u64;
    let indices = &mut data.cells.connectivity;
    let cells = 9 * data.cells.types.len() as u64 + 8 * indices.len() as u64;
    let for_points = budget(source) - cells.min(budget(source));
    if points.saturating_mul(POINT) <= for_points {
        return Ok(None);
    }
    let mut used: Vec<u64> = room(indices.len())?;
    used.extend_from_slice(indices);
    used.sort_unstable();
    used.dedup();
    if used.len() as u64 * POINT > for_points {
        return Err(source.error_with_help(
            "<Points>",
            format!(
                "{} points: so many different ones cannot be in {} bytes",
                used.len(),
                source.bytes.len()
            ),
            "the file is damaged; write it again",
        ));
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
fn read_points(
    source: &Source,
    decoder: &Decoder,
    pieces: &[&Piece],
    kept: Option<&[u64]>,
    data: &mut MeshData,
) -> Result<(), Error> {
    let all = pieces.iter().map(|piece| piece.points).sum::<u64>();
    // Either is within the budget.
    data.points = room(kept.map_or(all as usize, <[u64]>::len))?;
    let mut kept = kept.map(|kept| kept.iter().copied().peekable());
    let (mut point, mut filled, mut number) = ([0.0; 3], 0, 0);
    for piece in pieces {
        let coordinates = piece
            .coordinates
            .first()
            .ok_or_else(|| source.error("<Points>", "the piece has no points"))?;
        if coordinates.components != 3 {
            return Err(source.error(
                "<Points>",
                format!("points have {} components, not 3", coordinates.components),
            ));
        }
        let points = &mut data.points;
        decoder.each_float(coordinates, piece.points, &mut |value| {
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

/// The point and cell data that all pieces have.
fn find_arrays(file: &Arc<File>, pieces: &[&Piece], data: &mut MeshData) -> Vec<Array> {
    let mut arrays = Vec::new();
    for association in [Association::Point, Association::Cell] {
        let elements = pieces
            .iter()
            .map(|piece| elements(piece, association))
            .collect::<Vec<_>>();
        let mut missing: Vec<(&ArrayElement, usize)> = Vec::new();
        for (i, element) in elements
            .first()
            .copied()
            .unwrap_or_default()
            .iter()
            .enumerate()
        {
            let name = if element.name.is_empty() {
                format!("unnamed-{i}")
            } else {
                element.name.clone()
            };
            let twins = elements.iter().map(|others| position(others, element));
            let twins: Vec<Option<usize>> = twins.collect();
            if let Some(piece) = twins.iter().position(Option::is_none) {
                missing.push((element, piece));
                continue;
            }
            let tuples = |piece: &Piece| match association {
                Association::Point => piece.points,
                Association::Cell => piece.cells,
            };
            let parts = twins.into_iter().flatten().zip(&elements).zip(pieces);
            let parts = parts.map(|((at, elements), piece)| (&elements[at], tuples(piece)));
            arrays.push(Array {
                name,
                association,
                components: element.components as usize,
                component_names: element.component_names.clone(),
                tuples: pieces.iter().map(|piece| tuples(piece)).sum::<u64>() as usize, // counted
                numbers: Arc::new(Stored::new(file, parts)),
                active: pieces[0].active(association) == Some(element.name.as_str()),
                // Bytes, three or four at a time, are colors nearly always.
                colors: element.kind == Number::U8 && matches!(element.components, 3 | 4),
            });
        }
        // Of the others, those that the first piece lacks.
        for others in elements.iter().skip(1) {
            for element in others.iter() {
                let is_known = missing.iter().any(|(known, _)| is_twin(known, element));
                if !is_known && position(elements[0], element).is_none() {
                    missing.push((element, 0));
                }
            }
        }
        for (element, piece) in missing {
            let why = format!(
                "piece {} of {} has no such array of {}",
                piece + 1,
                pieces.len(),
                count(element.components, "component")
            );
            data.notes
                .push(format!("array '{}' left out: {why}", element.name));
            data.left_out.push((element.name.clone(), why));
        }
    }
    arrays
}

fn elements<'p>(piece: &'p Piece, association: Association) -> &'p [ArrayElement<'p>] {
    match association {
        Association::Point => &piece.point_data,
        Association::Cell => &piece.cell_data,
    }
}

fn is_twin(a: &ArrayElement, b: &ArrayElement) -> bool {
    a.name == b.name && a.components == b.components
}

fn position(elements: &[ArrayElement], twin: &ArrayElement) -> Option<usize> {
    elements.iter().position(|element| is_twin(element, twin))
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
