//! VTK XML unstructured grids, `.vtu`, and images, `.vti`.
//!
//! *VTK XML Formats*, the VTK documentation. Read are all four encodings
//! (appended raw, which ParaView writes by default, appended base64, inline
//! base64, ASCII), uncompressed or compressed with zlib or LZ4, with 32- and
//! 64-bit headers, in both byte orders and with numbers of any type. Pieces
//! become one mesh and keep their own points. Cells that `vtkGhostType` marks as
//! duplicate or hidden, or that touch a hidden point, are left out. Of several
//! time steps the first is read.
//!
//! A vector field is its components and its magnitude: `Velocity-x`,
//! `Velocity-magnitude`.
//!
//! An image's samples keep their type; `Origin`, `Spacing` and `Direction` say where they
//! lie, and its pieces become one grid. Hidden points are NaN. Large ones that are appended
//! raw and in one piece stay in their file.

mod decode;
mod document;
mod image;

use glam::DVec3;
use tetrascope_core::Error;
use tetrascope_core::glam;
use tetrascope_core::mesh::Association;

use self::decode::Decoder;
use self::document::{ArrayElement, Document, Piece};
use crate::MeshData;
use crate::fields::{Array, take_ghosts, to_scalars};
use crate::grid::GridData;
use crate::read::{FileData, check};
use crate::source::{Source, count};

/// Reads a `.vtu` or `.vti` file.
pub(crate) fn read(source: &Source) -> Result<FileData, Error> {
    let document = Document::parse(source)?;
    match &document.image {
        Some(image) => image::read(source, &document, image).map(FileData::Grid),
        None => read_mesh(source, &document).map(FileData::Mesh),
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

fn read_mesh(source: &Source, document: &Document) -> Result<MeshData, Error> {
    let decoder = Decoder::new(source, document);
    let mut data = MeshData {
        notes: document.notes.clone(),
        ..MeshData::default()
    };
    data.cells.offsets.push(0);
    // Pieces without cells add nothing, and their arrays are often absent.
    let pieces: Vec<&Piece> = document.pieces.iter().filter(|p| p.cells > 0).collect();
    if pieces.len() > 1 {
        data.notes
            .push(format!("{} joined", count(pieces.len() as u64, "piece")));
    }
    let mut arrays = Vec::new();
    for (i, piece) in pieces.iter().enumerate() {
        let read = read_fields(&decoder, piece)?;
        if i == 0 {
            arrays = read;
        } else {
            join(&mut arrays, read, &mut data.notes);
        }
        read_piece(source, &decoder, piece, &mut data)?;
    }
    let ghosts = take_ghosts(&mut arrays);
    data.fields = to_scalars(arrays);
    check(&source.path, &data)?;
    data.remove_ghosts(source, &ghosts)?;
    Ok(data)
}

/// Adds the points and cells of a piece.
fn read_piece(
    source: &Source,
    decoder: &Decoder,
    piece: &Piece,
    data: &mut MeshData,
) -> Result<(), Error> {
    let base = data.points.len() as u64;
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
    let values = decoder.floats(coordinates, piece.points)?;
    data.points
        .extend(values.chunks_exact(3).map(DVec3::from_slice));
    drop(values);
    let named = |name: &str| -> Result<&ArrayElement, Error> {
        piece
            .topology
            .iter()
            .find(|array| array.name.eq_ignore_ascii_case(name))
            .ok_or_else(|| source.error("<Cells>", format!("there is no array '{name}'")))
    };
    let types = decoder.indices(named("types")?, piece.cells)?;
    for (cell, kind) in types.into_iter().enumerate() {
        let kind = u8::try_from(kind).map_err(|_| {
            source.error(
                "array 'types'",
                format!("cell {cell} is of type {kind}, and VTK has none above 255"),
            )
        })?;
        data.cells.types.push(kind);
    }
    // VTK writes where each cell ends; the last end is the length of the connectivity.
    let ends = decoder.indices(named("offsets")?, piece.cells)?;
    let length = ends.last().copied().unwrap_or(0);
    let connectivity = decoder.indices(named("connectivity")?, length)?;
    let start = data.cells.connectivity.len() as u64;
    for (cell, end) in ends.into_iter().enumerate() {
        if end > length {
            return Err(source.error(
                "array 'offsets'",
                format!("cell {cell} ends at {end}, after the last of {length} points of cells"),
            ));
        }
        data.cells.offsets.push(start + end);
    }
    for (i, point) in connectivity.into_iter().enumerate() {
        if point >= piece.points {
            return Err(source.error(
                "array 'connectivity'",
                format!(
                    "value {i} is point {point}, but the piece has {}",
                    count(piece.points, "point")
                ),
            ));
        }
        data.cells.connectivity.push(base + point);
    }
    Ok(())
}

/// The point and cell data of a piece.
fn read_fields(decoder: &Decoder, piece: &Piece) -> Result<Vec<Array>, Error> {
    let mut arrays = Vec::new();
    for (association, elements, tuples) in [
        (Association::Point, &piece.point_data, piece.points),
        (Association::Cell, &piece.cell_data, piece.cells),
    ] {
        for (i, element) in elements.iter().enumerate() {
            let name = if element.name.is_empty() {
                format!("unnamed-{i}")
            } else {
                element.name.clone()
            };
            arrays.push(Array {
                active: piece.active(association) == Some(element.name.as_str()),
                name,
                association,
                components: element.components as usize,
                values: decoder.floats(element, tuples)?,
            });
        }
    }
    Ok(arrays)
}

/// Appends the arrays of another piece; those that are not in both are left out.
fn join(arrays: &mut Vec<Array>, mut other: Vec<Array>, notes: &mut Vec<String>) {
    arrays.retain_mut(|array| {
        let twin = other.iter().position(|o| {
            o.name == array.name
                && o.association == array.association
                && o.components == array.components
        });
        match twin {
            Some(twin) => array.values.append(&mut other.swap_remove(twin).values),
            None => notes.push(format!(
                "array '{}' left out: not every piece has it",
                array.name
            )),
        }
        twin.is_some()
    });
    for array in other {
        notes.push(format!(
            "array '{}' left out: not every piece has it",
            array.name
        ));
    }
}
