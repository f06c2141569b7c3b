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

use std::ops::Range;

use rayon::prelude::*;

use super::adjacency::ascending;
use super::cell_type::{HEXAHEDRON, Kind, Shape, VOXEL};
use super::five::FiveSplit;
use super::orientation::orientation;
use super::places::Places;
use super::{Cells, TETRAHEDRON as TYPE_TETRAHEDRON, check_point, corners_of, lies_well};
use crate::Error;
use crate::groups::{Groups, marked};
use glam::DVec3;

/// Cells that one thread looks at in a row.
const CHUNK: usize = 4096;

/// How cells that are not tetrahedra are cut.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Split {
    /// Each face from its smallest vertex, for any mixture of cells. A structured
    /// grid gets 6 tetrahedra per hexahedron, all around one diagonal.
    #[default]
    SmallestIndex,
    /// 5 tetrahedra per hexahedron, mirrored from one to the next, as in most papers on
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
    /// Empty where each tetrahedron is a cell of its own.
    pub(super) sources: Vec<u32>,
    /// Input cells in the opposite orientation.
    pub(super) flipped: usize,
    /// Input cells some of whose pieces are inverted relative to the others.
    pub(super) folded: usize,
    /// Tetrahedra left out because two of their corners are at one place.
    pub(super) collapsed: usize,
    /// Tetrahedra without volume.
    pub(super) degenerate: usize,
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
    in_chunks(cells.types.len(), |range| {
        let mut pieces = Pieces::default();
        let mut scratch = Vec::new();
        for cell in range {
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
}

/// The corners of `cells`, if all of them are tetrahedra between points that exist, one behind
/// the other.
pub(super) fn as_tetrahedra(point_count: usize, cells: &Cells) -> Option<Vec<[u32; 4]>> {
    let (tetrahedra, rest) = cells.connectivity.as_chunks::<4>();
    let is_plain = rest.is_empty()
        && !tetrahedra.is_empty()
        && cells.types.len() == tetrahedra.len()
        && cells.types.iter().all(|kind| *kind == TYPE_TETRAHEDRON)
        && cells.offsets.len() == tetrahedra.len() + 1
        && cells
            .offsets
            .iter()
            .zip((0..).step_by(4))
            .all(|(&offset, place)| offset == place);
    let limit = u32::try_from(point_count).ok()?;
    let exist = |points: &[u64; 4]| points.iter().all(|point| *point < u64::from(limit));
    if !is_plain || !tetrahedra.par_iter().all(exist) {
        return None;
    }
    let narrow = |&[a, b, c, d]: &[u64; 4]| [a as u32, b as u32, c as u32, d as u32];
    Some(tetrahedra.par_iter().map(narrow).collect())
}

/// Checks that the points of tetrahedra exist and lie where arithmetic works.
pub(super) fn check_tetrahedra(points: &[DVec3], tetrahedra: &[[u32; 4]]) -> Result<(), Error> {
    let chunks = tetrahedra.par_chunks(CHUNK);
    let greatest = chunks.map(|cells| cells.as_flattened().iter().fold(0, |a, &b| a.max(b)));
    let greatest = greatest.max().unwrap_or(0) as usize;
    let exist = tetrahedra.is_empty() || greatest < points.len();
    if exist && points.par_iter().with_min_len(CHUNK).all(lies_well) {
        return Ok(());
    }
    // A point that is wrong may be one that no cell has.
    let check = |(cell, corners): (usize, &[u32; 4])| {
        let mut corners = corners.iter();
        corners.try_for_each(|&point| check_point(points, cell, point.into()).map(drop))
    };
    // The first error by number, whatever the threads do.
    let checked = tetrahedra.par_iter().enumerate().map(check);
    checked.find_first(Result::is_err).unwrap_or(Ok(()))
}

/// Checked tetrahedra as pieces, oriented where they lie. In parallel.
pub(super) fn orient_tetrahedra(
    points: &[DVec3],
    mut tetrahedra: Vec<[u32; 4]>,
    places: &Places,
) -> Pieces {
    let orient = |cells: &mut [[u32; 4]]| {
        let [mut flipped, mut degenerate, mut collapsed] = [0; 3];
        // Memory that is asked for together arrives together.
        let mut positions = [[DVec3::ZERO; 4]; 16];
        for cells in cells.chunks_mut(positions.len()) {
            for (position, cell) in positions.iter_mut().zip(&*cells) {
                *position = corners_of(*cell, points);
            }
            for (position, cell) in positions.iter().zip(cells) {
                if places.coincide(*cell) {
                    collapsed += 1;
                    continue;
                }
                let found = orientation(*position);
                if found.sign < 0 {
                    flipped += 1;
                    cell.swap(2, 3);
                }
                // In the other order, all numbers are the same but for their signs.
                degenerate += usize::from(found.degenerate);
            }
        }
        [flipped, degenerate, collapsed]
    };
    let found = tetrahedra.par_chunks_mut(CHUNK).map(orient);
    let [flipped, degenerate, collapsed] = found.reduce(|| [0; 3], sum);
    let mut pieces = Pieces {
        tetrahedra,
        flipped,
        degenerate,
        collapsed,
        ..Pieces::default()
    };
    if collapsed > 0 {
        pieces.keep(|tetrahedron| !places.coincide(*tetrahedron));
    }
    pieces
}

fn sum<const N: usize>(a: [usize; N], b: [usize; N]) -> [usize; N] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// The pieces of all cells, by cell, of which `cut` makes those of some; at least one of each
/// cell is expected. In parallel.
fn in_chunks(
    cell_count: usize,
    cut: impl Fn(Range<usize>) -> Result<Pieces, Error> + Sync,
) -> Result<Pieces, Error> {
    /// How many chunks are in memory before they are joined.
    const CHUNKS: usize = 64;
    let mut all = Pieces::default();
    all.reserve(cell_count);
    let chunks: Vec<usize> = (0..cell_count.div_ceil(CHUNK)).collect();
    for chunks in chunks.chunks(CHUNKS) {
        let ranges = chunks.par_iter().map(|&chunk| {
            let start = chunk * CHUNK;
            start..(start + CHUNK).min(cell_count)
        });
        let pieces: Vec<Result<Pieces, Error>> = ranges.map(&cut).collect();
        for pieces in pieces {
            all.append(pieces?);
        }
    }
    Ok(all)
}

impl Pieces {
    /// Makes room for as many tetrahedra.
    fn reserve(&mut self, count: usize) {
        self.tetrahedra.reserve_exact(count);
        self.sources.reserve_exact(count);
    }

    /// Adds the pieces of other cells.
    fn append(&mut self, other: Pieces) {
        self.tetrahedra.extend(other.tetrahedra);
        self.sources.extend(other.sources);
        self.flipped += other.flipped;
        self.folded += other.folded;
        self.collapsed += other.collapsed;
        self.degenerate += other.degenerate;
    }
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
            let found = orientation(corners_of(tetrahedron, points));
            positive |= found.sign > 0;
            negative |= found.sign < 0;
            if found.sign < 0 {
                // In this order, all numbers are the same but for their signs.
                tetrahedron.swap(2, 3);
            }
            self.degenerate += usize::from(found.degenerate);
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
    /// Keeps the first of the tetrahedra that have the same four places, and returns how many
    /// were removed. In parallel, and O(n) as [`Adjacency`](super::adjacency::Adjacency) is.
    pub(super) fn remove_duplicates(&mut self, places: &Places, point_count: usize) -> usize {
        let sorted = |corners: &[u32; 4]| ascending(corners.map(|p| places.of(p))).map(|(p, _)| p);
        let groups = Groups::new(&self.tetrahedra, point_count, |cell| [sorted(cell)[0]]);
        let find = |cells: &mut Vec<([u32; 4], u32)>, least: usize| {
            let members = groups.members(least).iter();
            cells.clear();
            cells.extend(members.map(|&cell| (sorted(&self.tetrahedra[cell as usize]), cell)));
            cells.sort_unstable();
            let pairs = cells.windows(2);
            let repeated = pairs.filter(|pair| pair[0].0 == pair[1].0);
            repeated.map(|pair| pair[1].1).collect::<Vec<u32>>()
        };
        let repeated = (0..groups.count()).into_par_iter();
        let repeated = repeated.map_init(Vec::new, find);
        let repeated: Vec<u32> = repeated.flatten_iter().collect();
        if repeated.is_empty() {
            return 0;
        }
        let mut is_kept = vec![true; self.tetrahedra.len()];
        for &cell in &repeated {
            is_kept[cell as usize] = false;
        }
        let mut kept = is_kept.iter();
        self.keep(|_| kept.next() == Some(&true));
        repeated.len()
    }

    /// Leaves out the others.
    fn keep(&mut self, is_kept: impl FnMut(&[u32; 4]) -> bool) {
        if self.sources.is_empty() {
            self.sources = (0..).take(self.tetrahedra.len()).collect();
        }
        let kept: Vec<bool> = self.tetrahedra.iter().map(is_kept).collect();
        let mut of_cell = kept.iter();
        self.tetrahedra.retain(|_| of_cell.next() == Some(&true));
        let mut of_cell = kept.iter();
        self.sources.retain(|_| of_cell.next() == Some(&true));
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
    let corners = |cell: usize| {
        let shape = Kind::of(cells.types[cell]).shape();
        let corners = shape.map_or(0, |shape| shape.corners);
        cell_indices(cells, cell)[..corners].iter()
    };
    let cells = (0..cells.types.len()).into_par_iter();
    let corners = cells.flat_map_iter(corners);
    marked(point_count, corners.map(|&point| point as usize))
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
