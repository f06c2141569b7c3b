//! Structured and rectilinear grids, `.vts` and `.vtr`: points numbered along three axes.
//!
//! Both are meshes of hexahedra, one between each eight neighboring points. A rectilinear grid
//! whose coordinates are evenly spaced, but for the rounding of their numbers, is a regular
//! grid.

use glam::{DMat3, DVec3};
use tetrascope_core::{Error, glam};

use super::decode::Decoder;
use super::document::{Document, Image, Piece};
use super::{Opened, Part, image, read_mesh};
use crate::grid::number::Number;
use crate::pieces::Fields;
use crate::read::FileData;
use crate::source::Source;

/// A `StructuredGrid` or `RectilinearGrid` element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Structure {
    /// The first and last point along each axis.
    pub(super) extent: [i64; 6],
    /// Points are those of three axes, else each has its own.
    pub(super) rectilinear: bool,
}

/// How many points an extent has along each axis; `None` if they cannot be counted.
pub(super) fn dimensions(extent: &[i64; 6]) -> Option<[u64; 3]> {
    let mut dimensions = [0; 3];
    for (axis, points) in dimensions.iter_mut().enumerate() {
        let more = extent[2 * axis + 1].checked_sub(extent[2 * axis])?;
        // VTK's empty extents end before they begin.
        *points = u64::try_from(more.checked_add(1)?).unwrap_or(0);
    }
    Some(dimensions)
}

/// How many points and cells an extent has; `None` if they cannot be counted.
pub(super) fn counts(extent: &[i64; 6]) -> Option<(u64, u64)> {
    let dimensions = dimensions(extent)?;
    let product = |numbers: [u64; 3]| {
        let product = numbers.iter().try_fold(1_u64, |n, &d| n.checked_mul(d))?;
        i64::try_from(product).ok().map(|_| product)
    };
    let points = product(dimensions)?;
    Some((points, product(dimensions.map(|n| n.saturating_sub(1)))?))
}

/// Checks that the pieces lie in the whole extent and are enough to fill it.
pub(super) fn check(source: &Source, document: &Document) -> Result<(), Error> {
    let Some(Structure { extent: whole, .. }) = &document.structure else {
        return Ok(());
    };
    check_pieces(source, whole, document.pieces.iter())
}

/// Checks that `pieces` lie in the extent `whole` and are enough to fill it.
pub(super) fn check_pieces<'a>(
    source: &Source,
    whole: &[i64; 6],
    pieces: impl Iterator<Item = &'a Piece<'a>>,
) -> Result<(), Error> {
    let mut covered = 0_u64;
    for piece in pieces {
        if piece.cells == 0 {
            continue;
        }
        let extent = &piece.extent;
        let is_inside = |axis: usize| {
            whole[2 * axis] <= extent[2 * axis] && extent[2 * axis + 1] <= whole[2 * axis + 1]
        };
        if !(0..3).all(is_inside) {
            return Err(source.error(
                "<Piece>",
                format!("the extent {extent:?} is not in the whole, {whole:?}"),
            ));
        }
        covered = covered.saturating_add(piece.cells);
    }
    let (_, needed) = counts(whole).ok_or_else(|| uncountable(source, whole))?;
    if covered < needed {
        return Err(source.error_with_help(
            "<Piece>",
            format!("pieces with {covered} cells where {needed} are needed"),
            "a piece is missing; write the file again",
        ));
    }
    Ok(())
}

/// The error of an extent for which there is no [`counts`].
pub(super) fn uncountable(source: &Source, extent: &[i64; 6]) -> Error {
    source.error("<Piece>", format!("the extent {extent:?} cannot be"))
}

/// Reads the grid that the pieces of `files` make; `source` is the file that was asked for.
pub(super) fn read(
    source: &Source,
    files: &[Opened],
    structure: &Structure,
) -> Result<FileData, Error> {
    let [i, j, k] = dimensions(&structure.extent).unwrap_or_default();
    if [i, j, k].iter().any(|&points| points < 2) {
        return Err(source.error_with_help(
            "the extent",
            format!("a grid of {i}×{j}×{k} points has no volume"),
            "volume rendering needs at least 2 points along each axis",
        ));
    }
    if structure.rectilinear
        && let Some((image, note)) = regular(files, structure)?
    {
        let mut grid = image::read(source, files, &image)?;
        grid.notes.push(note);
        return Ok(FileData::Grid(grid));
    }
    read_mesh(source, files, Fields::Common).map(FileData::Mesh)
}

/// Calls `each` with the coordinates x, y and z of all points of a piece of a rectilinear grid.
pub(super) fn each_coordinate(
    source: &Source,
    decoder: &Decoder,
    piece: &Piece,
    each: &mut dyn FnMut(f64),
) -> Result<(), Error> {
    let axis = |axis| coordinates(source, decoder, piece, axis);
    each_point(&[axis(0)?, axis(1)?, axis(2)?], each);
    Ok(())
}

/// Calls `each` with x, y and z of all points of a rectilinear grid with these axes.
pub(crate) fn each_point([xs, ys, zs]: &[Vec<f64>; 3], each: &mut dyn FnMut(f64)) {
    for &z in zs {
        for &y in ys {
            for &x in xs {
                [x, y, z].into_iter().for_each(&mut *each);
            }
        }
    }
}

/// The most points along an axis of a rectilinear grid.
pub(crate) const MOST_POINTS: u64 = 1 << 21;

/// The coordinates of a piece of a rectilinear grid along an axis.
fn coordinates(
    source: &Source,
    decoder: &Decoder,
    piece: &Piece,
    axis: usize,
) -> Result<Vec<f64>, Error> {
    let element = piece.coordinates.get(axis).filter(|e| e.components == 1);
    let element = element.ok_or_else(|| {
        source.error(
            "<Coordinates>",
            "a rectilinear grid needs three arrays of one component",
        )
    })?;
    let points = dimensions(&piece.extent).unwrap_or_default()[axis];
    if points > MOST_POINTS {
        return Err(source.error(
            "<Coordinates>",
            format!("{points} points along an axis; {MOST_POINTS} are read"),
        ));
    }
    let mut values = Vec::new();
    decoder.each_float(element, points, &mut |value| values.push(value))?;
    Ok(values)
}

/// The regular grid that a rectilinear one is, and what is to be said about it, if its
/// coordinates are evenly spaced.
fn regular(files: &[Opened], structure: &Structure) -> Result<Option<(Image, String)>, Error> {
    let has_cells = |part: &Part| part.piece.cells > 0;
    let mut parts: Vec<Part> = files
        .iter()
        .flat_map(Opened::parts)
        .filter(has_cells)
        .collect();
    let (mut origin, mut spacing, mut worst) = ([0.0; 3], [0.0; 3], 0.0_f64);
    for axis in 0..3 {
        let low = structure.extent[2 * axis];
        parts.sort_by_key(|part| part.piece.extent[2 * axis]);
        let mut all: Vec<f64> = Vec::new();
        let mut epsilon = 0.0_f64;
        for Part { file, piece } in &parts {
            let values = coordinates(file.source, &file.decoder, piece, axis)?;
            let start = (piece.extent[2 * axis] - low) as usize; // it is in the whole
            let known = all.get(start..).unwrap_or_default();
            let is_same = known.iter().zip(&values).all(|(a, b)| a == b);
            // A gap is filled by no other piece, as they come in order.
            if start > all.len() || !is_same {
                return Ok(None);
            }
            let more = values.get(known.len()..).unwrap_or_default();
            all.extend_from_slice(more);
            epsilon = epsilon.max(match piece.coordinates[axis].kind {
                Number::F32 => f32::EPSILON.into(),
                _ => f64::EPSILON,
            });
        }
        let Some((first, step, off)) = even_steps(&all, epsilon) else {
            return Ok(None);
        };
        origin[axis] = first - step * low as f64;
        spacing[axis] = step;
        worst = worst.max(off);
    }
    let image = Image {
        extent: structure.extent,
        origin: DVec3::from_array(origin),
        spacing: DVec3::from_array(spacing),
        direction: DMat3::IDENTITY,
    };
    Ok(Some((image, note_of_steps(worst))))
}

/// A note on coordinates that are off by this share of a step.
pub(crate) fn note_of_steps(off: f64) -> String {
    format!("the coordinates are evenly spaced to {off:.1e} of a step: the grid is regular")
}

/// First coordinate, step, and the share of the step by which any coordinate is off, if
/// coordinates are evenly spaced. `epsilon` is that of their numbers.
///
/// They may be off by the rounding of their numbers and of a sum of them, 4ε of the largest,
/// or by a ten-thousandth of a step, as numbers of six written digits are; never by more than
/// a quarter of a step.
pub(crate) fn even_steps(coordinates: &[f64], epsilon: f64) -> Option<(f64, f64, f64)> {
    let (&first, &last) = (coordinates.first()?, coordinates.last()?);
    let step = (last - first) / (coordinates.len() - 1) as f64;
    let largest = first.abs().max(last.abs());
    let most = (4.0 * epsilon * largest).max(1e-4 * step.abs());
    let most = most.min(0.25 * step.abs());
    let mut worst = 0.0_f64;
    let is_even = coordinates.iter().zip(0_u32..).all(|(&x, i)| {
        let off = (x - (first + step * f64::from(i))).abs();
        worst = worst.max(off);
        off <= most // not so for NaN
    });
    let is_even = is_even && step != 0.0 && step.is_finite();
    is_even.then(|| (first, step, worst / step.abs()))
}

#[cfg(test)]
mod tests;
