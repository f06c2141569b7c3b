//! Volume cells into tetrahedra that agree across shared faces.
//!
//! J. Dompierre, P. Labbé, M.-G. Vallet, R. Camarero, "How to Subdivide Pyramids,
//! Prisms and Hexahedra into Tetrahedra", 1999: every quadrilateral is cut from its
//! smallest vertex, which both of its cells know; a cell is cut into the cone from
//! its own smallest vertex over the triangles of the faces that do not contain it.
//! (For a hexahedron whose diagonals allow it, five tetrahedra instead of six.)
//!
//! # Departures from the paper
//! Vertices are ordered by the least index among the points at the same place, then by
//! index. Blocks that touch without sharing points thus cut their common faces alike.
//! A tetrahedron with two corners at one place (from collapsed cells) is left out: the
//! cells on its two sides then share the face directly.

use rayon::prelude::*;

use super::cell_type::{HEXAHEDRON, Kind, Shape, VOXEL};
use super::five::FiveSplit;
use super::orientation::orientation;
use super::places::Places;
use super::sort::sort_by_point;
use super::{Cells, check_point};
use crate::Error;
use glam::DVec3;

/// How cells that are not tetrahedra are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Split {
    /// Each face from its smallest vertex, for any mixture of cells. A structured
    /// grid gets 6 tetrahedra a hexahedron, all around one diagonal.
    #[default]
    SmallestIndex,
    /// 5 tetrahedra a hexahedron, mirrored from one to the next, as in most papers on
    /// structured grids. Of the two ways for each connected part, the one that
    /// inverts fewer tetrahedra is taken.
    ///
    /// Possible only where hexahedra can be colored alternately. Across a seam whose
    /// sides have different points at the same places, faces are cut alike where the
    /// colors allow it, else independently.
    FiveAlternating,
}

/// Tetrahedra, the input cell of each, and what was noticed on the way.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    pub(super) tetrahedra: Vec<[u32; 4]>,
    pub(super) sources: Vec<u32>,
    /// Input cells in the opposite orientation.
    pub(super) flipped: usize,
    /// Input cells some of whose pieces are inverted relative to the others.
    pub(super) folded: usize,
    /// Tetrahedra left out because two of their corners are at one place.
    pub(super) collapsed: usize,
}

/// Checks everything that `cells` claims.
pub(super) fn check_cells(points: &[DVec3], cells: &Cells) -> Result<(), Error> {
    let cell_count = cells.types.len();
    let offsets = &cells.offsets;
    let entries = cells.connectivity.len() as u64;
    if offsets.len() != cell_count + 1 {
        return Err(Error::invalid(format!(
            "{cell_count} cells need {} offsets, there are {}",
            cell_count + 1,
            offsets.len()
        )));
    }
    if offsets[0] != 0 || offsets[cell_count] != entries {
        return Err(Error::invalid(format!(
            "cell offsets run from {} to {}; they must run from 0 to {entries}, the length of the connectivity",
            offsets[0], offsets[cell_count]
        )));
    }
    if let Some(cell) = offsets.windows(2).position(|pair| pair[0] > pair[1]) {
        return Err(Error::invalid(format!(
            "cell {cell} begins at {} in the connectivity and ends before, at {}",
            offsets[cell],
            offsets[cell + 1]
        )));
    }
    // From here on every offset is at most the connectivity's length.
    let check = |cell: usize| {
        let kind = Kind::of(cells.types[cell]);
        let indices = cell_indices(cells, cell);
        kind.check(cell, cells.types[cell], indices.len())?;
        let corners = kind.shape().map_or(0, |shape| shape.corners);
        for &point in &indices[..corners] {
            check_point(points, cell, point)?;
        }
        for &point in &indices[corners..] {
            if point >= points.len() as u64 {
                check_point(points, cell, point)?;
            }
        }
        Ok(())
    };
    // The first error by number, whatever the threads do.
    (0..cell_count)
        .into_par_iter()
        .with_min_len(4096)
        .map(check)
        .find_first(Result::is_err)
        .unwrap_or(Ok(()))
}

/// Cuts checked cells. Parallel; the result does not depend on the number of threads.
pub(super) fn split_cells(
    points: &[DVec3],
    cells: &Cells,
    places: &Places,
    split: Split,
) -> Result<Pieces, Error> {
    let cutter = match split {
        Split::SmallestIndex => Cutter::SmallestIndex,
        Split::FiveAlternating => Cutter::FiveAlternating(FiveSplit::new(points, cells, places)?),
    };
    const CHUNK: usize = 4096;
    let cell_count = cells.types.len();
    let chunks: Vec<Result<Pieces, Error>> = (0..cell_count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut pieces = Pieces::default();
            let mut scratch = Vec::new();
            for cell in chunk * CHUNK..((chunk + 1) * CHUNK).min(cell_count) {
                let Some(shape) = Kind::of(cells.types[cell]).shape() else {
                    continue;
                };
                scratch.clear();
                let corners = corners(cells, cell, shape);
                cutter.cut(cell, &corners[..shape.corners], shape, places, &mut scratch)?;
                pieces.add(points, places, cell, shape, &scratch);
            }
            Ok(pieces)
        })
        .collect();
    let mut all = Pieces::default();
    for chunk in chunks {
        let chunk = chunk?;
        all.tetrahedra.extend(chunk.tetrahedra);
        all.sources.extend(chunk.sources);
        all.flipped += chunk.flipped;
        all.folded += chunk.folded;
        all.collapsed += chunk.collapsed;
    }
    Ok(all)
}

impl Pieces {
    /// Adds the pieces of one cell, all of which its shape says are positively oriented.
    pub(super) fn add(
        &mut self,
        points: &[DVec3],
        places: &Places,
        cell: usize,
        shape: &Shape,
        tetrahedra: &[[u32; 4]],
    ) {
        let (mut positive, mut negative) = (false, false);
        for &(mut tetrahedron) in tetrahedra {
            if places.coincide(tetrahedron) {
                self.collapsed += 1;
                continue;
            }
            let sign = orientation(tetrahedron.map(|p| points[p as usize])).sign;
            positive |= sign > 0;
            negative |= sign < 0;
            if sign < 0 {
                tetrahedron.swap(2, 3);
            }
            self.tetrahedra.push(tetrahedron);
            self.sources
                .push(u32::try_from(cell).expect("cells were counted"));
        }
        self.folded += usize::from(positive && negative);
        // Both orders of a wedge are in use: neither is wrong.
        let fixed = negative && !positive && shape != &super::cell_type::WEDGE;
        self.flipped += usize::from(fixed);
    }
}

impl Pieces {
    /// Keeps the first of the tetrahedra that have the same four places, and returns
    /// how many were removed. O(n): see [`sort_by_point`].
    pub(super) fn remove_duplicates(&mut self, places: &Places, point_count: usize) -> usize {
        let keys = self
            .tetrahedra
            .iter()
            .zip(0_u32..)
            .map(|(&corners, index)| {
                let mut corners = corners.map(|p| places.of(p));
                corners.sort_unstable();
                (corners, index)
            });
        let keys = sort_by_point(keys, point_count, |(corners, _)| corners[0]);
        let repeated = |pair: &[([u32; 4], u32)]| pair[0].0 == pair[1].0;
        let mut is_repeated = vec![false; self.tetrahedra.len()];
        let mut removed = 0;
        for pair in keys.windows(2).filter(|pair| repeated(pair)) {
            is_repeated[pair[1].1 as usize] = true;
            removed += 1;
        }
        if removed > 0 {
            let mut drop = is_repeated.iter();
            self.tetrahedra.retain(|_| drop.next() == Some(&false));
            let mut drop = is_repeated.iter();
            self.sources.retain(|_| drop.next() == Some(&false));
        }
        removed
    }
}

enum Cutter {
    SmallestIndex,
    FiveAlternating(FiveSplit),
}

impl Cutter {
    fn cut(
        &self,
        cell: usize,
        corners: &[u32],
        shape: &Shape,
        places: &Places,
        out: &mut Vec<[u32; 4]>,
    ) -> Result<(), Error> {
        match self {
            Cutter::SmallestIndex => {
                cut_from_smallest(corners, shape, places, out);
                Ok(())
            }
            Cutter::FiveAlternating(five) => five.cut(cell, corners, shape, places, out),
        }
    }
}

/// The position in `face` of its smallest corner: by place, then by index.
pub(super) fn smallest(places: &Places, corners: &[u32], face: &[usize]) -> usize {
    (0..face.len())
        .min_by_key(|&i| (places.of(corners[face[i]]), corners[face[i]]))
        .expect("faces have corners")
}

fn cut_from_smallest(corners: &[u32], shape: &Shape, places: &Places, out: &mut Vec<[u32; 4]>) {
    if shape.corners == 4 {
        out.push([corners[0], corners[1], corners[2], corners[3]]);
        return;
    }
    let apex = (0..corners.len())
        .min_by_key(|&i| (places.of(corners[i]), corners[i]))
        .expect("cells have corners");
    let first = out.len();
    cone(
        corners,
        shape,
        apex,
        |face| smallest(places, corners, face),
        out,
    );
    if shape.faces.len() == 6 && shape.corners == 8 {
        merge_around_far_corner(corners[far_corner(shape, apex)], places, first, out);
    }
}

/// The tetrahedra from a corner over the faces that do not contain it; each face is a
/// fan from the corner that `start` names by its position in the face.
pub(super) fn cone(
    corners: &[u32],
    shape: &Shape,
    apex: usize,
    start: impl Fn(&[usize]) -> usize,
    out: &mut Vec<[u32; 4]>,
) {
    let apex = corners[apex];
    for face in shape.faces {
        if face.iter().any(|&i| corners[i] == apex) {
            continue;
        }
        let first = start(face);
        let corner = |i: usize| corners[face[(first + i) % face.len()]];
        for i in 1..face.len() - 1 {
            out.push([apex, corner(0), corner(i), corner(i + 1)]);
        }
    }
}

/// The corner of a hexahedron or voxel that shares no face with `corner`.
fn far_corner(shape: &Shape, corner: usize) -> usize {
    (0..8)
        .find(|far| {
            !shape
                .faces
                .iter()
                .any(|face| face.contains(far) && face.contains(&corner))
        })
        .expect("every corner of a hexahedron has an opposite one")
}

/// Where no diagonal ends in the far corner, three tetrahedra around the edge from apex
/// to far corner become two: five in all, and better shaped.
fn merge_around_far_corner(far: u32, places: &Places, first: usize, out: &mut Vec<[u32; 4]>) {
    let is_around = |t: &[u32; 4]| t[1..].contains(&far);
    if out.len() - first != 6 || out[first..].iter().filter(|t| is_around(t)).count() != 3 {
        return;
    }
    let around: Vec<[u32; 4]> = out[first..].iter().copied().filter(is_around).collect();
    // Turned so that the far corner leads: outward triangles (far, p, q), (far, q, r), (far, r, p).
    let rim = around.iter().map(|&[_, a, b, c]| match far {
        far if far == a => (b, c),
        far if far == b => (c, a),
        _ => (a, b),
    });
    let rim: Vec<(u32, u32)> = rim.collect();
    let (p, q) = rim[0];
    let Some(&(_, r)) = rim.iter().find(|(from, _)| *from == q) else {
        return;
    };
    let apex = around[0][0];
    if !places.coincide([apex, far, p, q, r]) && rim.contains(&(r, p)) {
        let mut kept: Vec<[u32; 4]> = out.drain(first..).filter(|t| !is_around(t)).collect();
        kept.extend([[apex, p, q, r], [far, p, r, q]]);
        out.append(&mut kept);
    }
}

/// The points that are corners of checked cells.
pub(super) fn used_corners(point_count: usize, cells: &Cells) -> Vec<bool> {
    let mut used = vec![false; point_count];
    for cell in 0..cells.types.len() {
        if let Some(shape) = Kind::of(cells.types[cell]).shape() {
            for &point in &corners(cells, cell, shape)[..shape.corners] {
                used[point as usize] = true;
            }
        }
    }
    used
}

/// A checked cell's corners, in the order of its shape.
pub(super) fn corners(cells: &Cells, cell: usize, shape: &Shape) -> [u32; 12] {
    let mut corners = [0; 12];
    for (corner, &point) in corners[..shape.corners]
        .iter_mut()
        .zip(cell_indices(cells, cell))
    {
        *corner = u32::try_from(point).expect("checked with the cells");
    }
    corners
}

fn cell_indices(cells: &Cells, cell: usize) -> &[u64] {
    // Offsets are at most the connectivity's length, which is a usize.
    let at = |i: usize| usize::try_from(cells.offsets[i]).expect("checked with the cells");
    &cells.connectivity[at(cell)..at(cell + 1)]
}

/// Whether a shape is one that splits into five.
pub(super) fn is_hexahedron(shape: &Shape) -> bool {
    shape == &HEXAHEDRON || shape == &VOXEL
}
