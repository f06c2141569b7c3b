//! Cells cut into clusters along the Hilbert curve, in bounded memory.
//!
//! No file is sorted: the cells are listed again and again. A first pass counts how many lie on
//! each stretch of the curve; then neighboring stretches are taken together as long as their cells
//! fit in memory, and for each such group one pass keeps its cells, sorts them and cuts them.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::hilbert::{self, END};
use crate::mesh::Association;
use crate::{Bounds, Error, Stop, TetMesh};

/// Cells that can be listed again and again, in any number.
///
/// Positions are finite, and cells name points that exist.
pub trait CellSource: Sync {
    /// A box around all cells' points; the curve goes through it.
    fn bounds(&self) -> Bounds;

    /// The name of the field, and where its values are.
    fn field(&self) -> (&str, Association);

    /// How many cells there are.
    fn cell_count(&self) -> u64;

    /// The points of a cell.
    fn cell(&self, cell: u64) -> [u32; 4];

    /// The position of a point, world space.
    fn point(&self, point: u32) -> DVec3;

    /// The value at a point, or in a cell where the values are those of cells.
    fn value(&self, point_or_cell: u64) -> f64;
}

impl CellSource for TetMesh {
    fn bounds(&self) -> Bounds {
        TetMesh::bounds(self)
    }

    fn field(&self) -> (&str, Association) {
        (&self.scalars().name, self.scalars().association)
    }

    fn cell_count(&self) -> u64 {
        TetMesh::cell_count(self) as u64
    }

    fn cell(&self, cell: u64) -> [u32; 4] {
        self.tetrahedra()[cell as usize]
    }

    fn point(&self, point: u32) -> DVec3 {
        self.points()[point as usize]
    }

    fn value(&self, point_or_cell: u64) -> f64 {
        let place = match self.scalars().association {
            Association::Point => point_or_cell as usize,
            Association::Cell => self.source_cell(point_or_cell as usize),
        };
        self.scalars().values[place]
    }
}

/// How cells are cut.
#[derive(Clone, Debug)]
pub struct Cut {
    /// The most cells of a cluster.
    pub most_cells: u32,
    /// Bytes for the cells that are sorted at once, 16 for each; parts take memory besides.
    pub memory: u64,
    /// Where to ask whether to go on.
    pub stop: Stop,
}

impl Default for Cut {
    /// 2¹⁸ cells, and 1 GiB: 67 million cells at once.
    fn default() -> Cut {
        Cut {
            most_cells: 1 << 18,
            memory: 1 << 30,
            stop: Stop::new(),
        }
    }
}

/// The cells of a cluster, and the points that they use, in the order in which the source has these.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// World space.
    pub points: Vec<DVec3>,
    /// Indices into `points`.
    pub tetrahedra: Vec<[u32; 4]>,
    /// Where the values are.
    pub association: Association,
    /// One value for each point or for each cell.
    pub values: Vec<f64>,
}

/// A cell and its place on the curve.
#[derive(Clone, Copy)]
struct Placed {
    place: u64,
    cell: u64,
}

/// Bytes of a cell while it is sorted.
const BYTES_PER_CELL: u64 = size_of::<Placed>() as u64;

/// Stretches of the curve that a pass tells apart.
const STRETCHES: u64 = 1 << 18;

/// Cells whose places are found at a time.
const CHUNK: u64 = 1 << 20;

/// Cuts all cells of `source` into parts along the curve, and hands them to `take` in that order.
///
/// The same source and [`Cut::most_cells`] give the same parts, whatever the memory and the number of
/// threads, but for where groups of cells that are sorted together end.
///
/// # Errors
/// [`Error::Invalid`] for clusters without a cell, [`Error::Stopped`], and those of `take`.
pub fn cut(
    source: &dyn CellSource,
    limits: &Cut,
    take: &mut dyn FnMut(Part) -> Result<(), Error>,
) -> Result<(), Error> {
    if limits.most_cells == 0 {
        return Err(Error::invalid("clusters of 0 cells"));
    }
    let capacity = (limits.memory / BYTES_PER_CELL).max(limits.most_cells.into());
    let mut groups = Vec::new();
    find_groups(source, limits, 0..END, capacity, &mut groups)?;
    for group in groups {
        let mut cells = Vec::with_capacity(group.cells as usize);
        list(source, limits, &group.places, |placed| {
            cells.extend_from_slice(placed)
        })?;
        cells.par_sort_unstable_by_key(|placed| (placed.place, placed.cell));
        // As many as are needed, and nearly equal.
        let parts = group.cells.div_ceil(limits.most_cells.into()).max(1);
        let bound = |part: u64| (group.cells * part / parts) as usize;
        let ranges: Vec<Range<usize>> = (0..parts).map(|i| bound(i)..bound(i + 1)).collect();
        // A few at a time, as parts take memory, too.
        for ranges in ranges.chunks(rayon::current_num_threads()) {
            limits.stop.check()?;
            let made = ranges
                .par_iter()
                .map(|range| part(source, &cells[range.clone()]));
            let made: Vec<Part> = made.collect();
            made.into_iter().try_for_each(&mut *take)?;
        }
    }
    Ok(())
}

/// A stretch of the curve whose cells are sorted at once.
struct Group {
    places: Range<u64>,
    cells: u64,
}

/// Parts a stretch of the curve into groups of at most `capacity` cells. A place of the curve is not parted: there,
/// a group may be larger.
fn find_groups(
    source: &dyn CellSource,
    limits: &Cut,
    places: Range<u64>,
    capacity: u64,
    groups: &mut Vec<Group>,
) -> Result<(), Error> {
    let width = (places.end - places.start).div_ceil(STRETCHES);
    let mut counts = vec![0_u64; (places.end - places.start).div_ceil(width) as usize];
    list(source, limits, &places, |placed| {
        for placed in placed {
            counts[((placed.place - places.start) / width) as usize] += 1;
        }
    })?;
    let mut open: Option<Group> = None;
    for (stretch, &cells) in (0..).zip(&counts) {
        if cells == 0 {
            continue;
        }
        let start = places.start + stretch * width;
        let stretch = start..(start + width).min(places.end);
        match &mut open {
            Some(group) if group.cells + cells <= capacity => {
                group.cells += cells;
                group.places.end = stretch.end;
                continue;
            }
            _ => groups.extend(open.take()),
        }
        if cells > capacity && width > 1 {
            find_groups(source, limits, stretch, capacity, groups)?;
        } else {
            open = Some(Group {
                places: stretch,
                cells,
            });
        }
    }
    groups.extend(open);
    Ok(())
}

/// Hands the cells on a stretch of the curve to `take`, some at a time, by increasing number.
fn list(
    source: &dyn CellSource,
    limits: &Cut,
    places: &Range<u64>,
    mut take: impl FnMut(&[Placed]),
) -> Result<(), Error> {
    let bounds = source.bounds();
    let placed = |cell: u64| {
        let corners = source.cell(cell).map(|point| source.point(point));
        // Quarters first: a sum of huge positions could overflow.
        let center: DVec3 = corners.iter().map(|corner| *corner * 0.25).sum();
        let place = hilbert::place(&bounds, center);
        places.contains(&place).then_some(Placed { place, cell })
    };
    let count = source.cell_count();
    for first in (0..count).step_by(CHUNK as usize) {
        limits.stop.check()?;
        let chunk = first..(first + CHUNK).min(count);
        let found: Vec<Placed> = chunk.into_par_iter().filter_map(placed).collect();
        take(&found);
    }
    Ok(())
}

/// The part with these cells.
fn part(source: &dyn CellSource, cells: &[Placed]) -> Part {
    let corners: Vec<[u32; 4]> = cells
        .iter()
        .map(|placed| source.cell(placed.cell))
        .collect();
    let mut used: Vec<u32> = corners.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let local = |point: &u32| used.binary_search(point).expect("it is used") as u32;
    let tetrahedra = corners.iter().map(|corners| corners.each_ref().map(local));
    let (_, association) = source.field();
    let values = match association {
        Association::Point => used
            .iter()
            .map(|&point| source.value(point.into()))
            .collect(),
        Association::Cell => cells
            .iter()
            .map(|placed| source.value(placed.cell))
            .collect(),
    };
    Part {
        tetrahedra: tetrahedra.collect(),
        points: used.iter().map(|&point| source.point(point)).collect(),
        association,
        values,
    }
}
