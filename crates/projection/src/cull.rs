//! Which cells can show, whenever appearance or scalars change, and the list of what is drawn.
//!
//! On the CPU, which knows the least and the greatest scalar of each cell: how many items there are
//! decides what is allocated, so a device would be waited for twice. 187 000 cells take some 2 ms on
//! two cores, and twice that if they are drawn in pieces; passes took 136 ms on llvmpipe, half of that
//! in barriers. Lists that an edit leaves as they were stay on the device.
//!
//! Left out are cells without volume, cells with a scalar that is NaN, and cells whose scalars map
//! to nothing: no extinction, or black where only color counts. Where isosurfaces are drawn, cells
//! that none goes through.

use std::sync::Arc;

use tetrascope_core::{Error, OpticalModel};
use tetrascope_f32::KnotPair;
use tetrascope_gpu::Gpu;
use tetrascope_gpu::wgpu::{self, BufferUsages};

use crate::volume::{Field, Geometry};

/// Pieces a cell, on average, beyond which cells are drawn whole. On llvmpipe a piece costs
/// as much as a turn of the loop; elsewhere, memory.
const MOST_PIECES: u64 = 2;

/// The most parts of a piece, which are counted in 8 bits.
const MOST_PARTS: u32 = 255;

/// Intervals that a cell may have to be looked at for its parts.
const MOST_LOOKED_AT: usize = 64;

/// Up to so many intervals are counted and not bisected, which is faster.
const FEW: usize = 32;

/// What a list without pieces has, as in `order.wgsl`.
const NO_CELL: u32 = u32::MAX;

/// Cells of which the intervals are counted together.
const BLOCK: usize = 256;

/// What is left to draw.
#[derive(Debug)]
pub(crate) struct Culled {
    /// The first and the last interval of each of the mesh's cells, 16 bits each.
    pub(crate) ranges: wgpu::Buffer,
    /// The items that are drawn: cells or, where `in_pieces`, those. It may have room for more.
    pub(crate) drawn: wgpu::Buffer,
    /// A cell and what of it is drawn, by piece; see `pieces.wgsl`.
    pub(crate) pieces: wgpu::Buffer,
    pub(crate) items: u32,
    pub(crate) cells: u32,
    pub(crate) in_pieces: bool,
    /// Whether pieces are in parts, none of an optical depth above 1.
    pub(crate) in_parts: bool,
    /// The verdicts that the buffers were made from: the next list takes over those that stay.
    verdicts: Arc<Verdicts>,
}

/// What an order that is made on the CPU has to know of the cells that are drawn.
#[derive(Clone, Debug, Default)]
pub(crate) struct Listed {
    /// Their indices.
    pub(crate) cells: Arc<[u32]>,
    /// The first piece of each of the mesh's cells, and the end of the last, where cells are
    /// drawn in pieces.
    starts: Option<Arc<[u32]>>,
    is_made: bool,
}

impl Listed {
    /// The items of `cells`, in their order.
    pub(crate) fn items_of(&self, cells: Vec<u32>) -> Vec<u32> {
        let Some(starts) = &self.starts else {
            return cells;
        };
        let pieces = |cell: u32| starts[cell as usize]..starts[cell as usize + 1];
        cells.into_iter().flat_map(pieces).collect()
    }
}

/// What decides.
pub(crate) struct Judged<'a> {
    pub(crate) geometry: &'a Geometry,
    pub(crate) field: &'a Field,
    pub(crate) model: OpticalModel,
    pub(crate) intervals: &'a [KnotPair],
    /// Of isosurfaces, in the unit of the scalars.
    pub(crate) isovalues: &'a [f32],
    /// Whether cells may be drawn in pieces.
    pub(crate) pieces: bool,
}

/// The judgment of every cell.
#[derive(Debug, PartialEq)]
struct Verdicts {
    /// The first and the last interval of its scalars, 16 bits each.
    ranges: Vec<u32>,
    /// In what it is drawn.
    shares: Vec<Share>,
}

/// In what a cell is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Share {
    /// Its pieces, one for each interval of its scalars; 0 if it is not drawn.
    pieces: u16,
    /// The parts of each, for `segment_weights`; more than [`MOST_PARTS`] if that is unknown.
    parts: u16,
}

/// Sums over some cells.
#[derive(Clone, Copy, Debug, Default)]
struct Total {
    cells: u32,
    pieces: u64,
    parts: u64,
    /// Whether the parts of one are unknown.
    is_uncounted: bool,
}

impl Total {
    fn add(&mut self, share: Share) {
        self.cells += u32::from(share.pieces > 0);
        self.pieces += u64::from(share.pieces);
        self.parts += u64::from(share.pieces) * u64::from(share.parts);
        self.is_uncounted |= share.pieces > 0 && u32::from(share.parts) > MOST_PARTS;
    }
}

/// In what all cells are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Unit {
    Cell,
    Piece,
    Part,
}

impl Unit {
    fn items(self, share: Share) -> u32 {
        match self {
            Unit::Cell => u32::from(share.pieces > 0),
            Unit::Piece => share.pieces.into(),
            Unit::Part => u32::from(share.pieces) * u32::from(share.parts),
        }
    }
}

/// Lists what of `judged` is drawn; also for the CPU if it asks, else that list is empty. What is
/// the same as in `last` is taken from there.
pub(crate) fn cull(
    gpu: &Gpu,
    judged: &Judged,
    is_listed: bool,
    last: Option<(&Culled, &Listed)>,
) -> Result<(Culled, Listed), Error> {
    let extents = &judged.field.extents;
    let (verdicts, totals) = Judge::new(judged).all(extents, &judged.geometry.longest_edges);
    let mut total = Total::default();
    for t in &totals {
        total.cells += t.cells;
        total.pieces += t.pieces;
        total.parts += t.parts;
        total.is_uncounted |= t.is_uncounted;
    }
    let fit = |items: u64| {
        let most = MOST_PIECES * u64::from(total.cells);
        judged.pieces && items <= most && items <= u64::from(u32::MAX / 4)
    };
    let in_parts =
        fit(total.parts) && !total.is_uncounted && judged.model == OpticalModel::EmissionAbsorption;
    let in_pieces = in_parts || fit(total.pieces);
    let unit = match (in_pieces, in_parts) {
        (_, true) => Unit::Part,
        (true, false) => Unit::Piece,
        (false, false) => Unit::Cell,
    };
    let storage = BufferUsages::STORAGE;
    let ranges = match last {
        Some((last, _)) if last.verdicts.ranges == verdicts.ranges => last.ranges.clone(),
        _ => gpu.upload("the cells' intervals", &verdicts.ranges, storage)?,
    };
    let is_same = |last: &(&Culled, &Listed)| {
        (last.0.in_pieces, last.0.in_parts) == (in_pieces, in_parts)
            && last.1.is_made == is_listed
            && last.0.verdicts.shares == verdicts.shares
    };
    if let Some((last, listed)) = last.filter(is_same) {
        let culled = Culled {
            ranges,
            drawn: last.drawn.clone(),
            pieces: last.pieces.clone(),
            verdicts: Arc::new(verdicts),
            ..*last
        };
        return Ok((culled, listed.clone()));
    }
    let Lists {
        cells,
        mut pieces,
        starts,
    } = lists(&verdicts.shares, &totals, unit);
    let items = match in_pieces {
        true => pieces.len(),
        false => cells.len(),
    };
    // Pieces are numbered, and that list is good for any that are not more.
    let numbered = |last: &(&Culled, &Listed)| {
        last.0.in_pieces && (items as u64..=8 * items as u64).contains(&(last.0.drawn.size() / 4))
    };
    let label = "the list of drawn cells";
    let drawn = match (in_pieces, last.filter(numbered)) {
        (true, Some((last, _))) => last.drawn.clone(),
        (true, None) => {
            let numbers: Vec<u32> = (0..items as u32).collect();
            gpu.upload(label, &numbers, storage)?
        }
        (false, _) => gpu.upload(label, &cells, storage)?,
    };
    if pieces.is_empty() {
        pieces.push([NO_CELL, 0]);
    }
    let listed = match is_listed {
        true => Listed {
            cells: cells.into(),
            starts: in_pieces.then(|| starts.into()),
            is_made: true,
        },
        false => Listed::default(),
    };
    let culled = Culled {
        ranges,
        drawn,
        pieces: gpu.upload("the cells' pieces", &pieces, storage)?,
        items: items as u32,
        cells: total.cells,
        in_pieces,
        in_parts,
        verdicts: Arc::new(verdicts),
    };
    Ok((culled, listed))
}

/// The lists that are uploaded.
struct Lists {
    cells: Vec<u32>,
    /// As in [`Culled::pieces`]; empty where cells are drawn whole.
    pieces: Vec<[u32; 2]>,
    /// As in [`Listed`]; empty where cells are drawn whole.
    starts: Vec<u32>,
}

/// Lists cells with these shares, of which each chunk comes to one of `totals`.
fn lists(shares: &[Share], totals: &[Total], unit: Unit) -> Lists {
    let in_pieces = unit != Unit::Cell;
    let items = |total: &Total| match unit {
        Unit::Cell => 0,
        Unit::Piece => total.pieces as usize,
        Unit::Part => total.parts as usize,
    };
    let all: usize = totals.iter().map(items).sum();
    let mut made = Lists {
        cells: vec![0; totals.iter().map(|total| total.cells as usize).sum()],
        pieces: vec![[0; 2]; all],
        starts: vec![0; if in_pieces { shares.len() + 1 } else { 0 }],
    };
    let (mut cells, mut pieces) = (&mut made.cells[..], &mut made.pieces[..]);
    let mut starts = &mut made.starts[..];
    let (mut first_cell, mut first_item) = (0_u32, 0_u32);
    let mut tasks = Vec::new();
    for (shares, total) in shares.chunks(chunk(shares.len())).zip(totals) {
        let (own_cells, own_pieces, own_starts);
        (own_cells, cells) = cells.split_at_mut(total.cells as usize);
        (own_pieces, pieces) = pieces.split_at_mut(items(total));
        (own_starts, starts) = starts.split_at_mut(if in_pieces { shares.len() } else { 0 });
        tasks.push((
            shares, first_cell, first_item, own_cells, own_pieces, own_starts,
        ));
        first_cell += shares.len() as u32;
        first_item += items(total) as u32;
    }
    if let [end] = starts {
        *end = all as u32;
    }
    in_threads(
        tasks,
        |(shares, first_cell, first_item, cells, pieces, starts)| {
            let (mut cells, mut pieces) = (cells.iter_mut(), pieces.iter_mut());
            let mut starts = starts.iter_mut();
            let mut item = first_item;
            for (cell, share) in (first_cell..).zip(shares) {
                if let Some(start) = starts.next() {
                    *start = item;
                }
                if share.pieces == 0 {
                    continue;
                }
                if let Some(place) = cells.next() {
                    *place = cell;
                }
                if !in_pieces {
                    continue;
                }
                item += unit.items(*share);
                let parts = match unit {
                    Unit::Part => u32::from(share.parts),
                    _ => 1,
                };
                for piece in 0..u32::from(share.pieces) {
                    for part in 0..parts {
                        if let Some(place) = pieces.next() {
                            *place = [cell, piece | part << 16 | (parts - 1) << 24];
                        }
                    }
                }
            }
        },
    );
    made
}

/// How many of so many cells a thread takes.
fn chunk(cells: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // Below that a thread costs more than it gains.
    cells.div_ceil(cores).max(1 << 14)
}

/// Does `work` for each of `tasks` in a thread of its own, the last in this one.
fn in_threads<T: Send>(mut tasks: Vec<T>, work: impl Fn(T) + Sync) {
    let last = tasks.pop();
    std::thread::scope(|scope| {
        for task in tasks {
            let work = &work;
            scope.spawn(move || work(task));
        }
        last.map(&work);
    });
}

/// What cells are judged by.
struct Judge<'a> {
    model: OpticalModel,
    intervals: &'a [KnotPair],
    /// The lower ends of all intervals but the first.
    ends: Vec<f32>,
    /// For each interval the next, from it on, at one end of which something shows.
    next_shown: Vec<u32>,
    isovalues: Vec<f32>,
    /// The greatest extinction.
    densest: f32,
    /// Whether cells may be drawn in pieces.
    pieces: bool,
}

impl Judge<'_> {
    fn new<'a>(judged: &Judged<'a>) -> Judge<'a> {
        let intervals = judged.intervals;
        let shows = |at: &[f32; 4]| shows(judged.model, *at);
        let mut next = u32::MAX;
        let mut next_shown = vec![next; intervals.len()];
        for (index, interval) in intervals.iter().enumerate().rev() {
            if shows(&interval.at_low) || shows(&interval.at_high) {
                next = index as u32;
            }
            next_shown[index] = next;
        }
        let mut isovalues = judged.isovalues.to_vec();
        isovalues.sort_by(f32::total_cmp);
        Judge {
            model: judged.model,
            intervals,
            ends: intervals[1..].iter().map(|interval| interval.low).collect(),
            next_shown,
            isovalues,
            densest: intervals
                .iter()
                .flat_map(|i| [i.at_low[3], i.at_high[3]])
                .fold(0.0, f32::max),
            pieces: judged.pieces,
        }
    }

    /// Judges cells with these least and greatest scalars and longest edges, on all cores. Also
    /// says what each [`chunk`] of them comes to.
    fn all(&self, extents: &[[f32; 2]], longest: &[f32]) -> (Verdicts, Vec<Total>) {
        let chunk = chunk(extents.len());
        let mut verdicts = Verdicts {
            ranges: vec![0; extents.len()],
            shares: vec![Share::default(); extents.len()],
        };
        let mut totals = vec![Total::default(); extents.len().div_ceil(chunk)];
        let ranges = verdicts.ranges.chunks_mut(chunk);
        let shares = verdicts.shares.chunks_mut(chunk);
        let given = extents.chunks(chunk).zip(longest.chunks(chunk));
        let found = ranges.zip(shares).zip(&mut totals);
        in_threads(
            given.zip(found).collect(),
            |(given, ((ranges, shares), total))| {
                let given = given.0.chunks(BLOCK).zip(given.1.chunks(BLOCK));
                let found = ranges.chunks_mut(BLOCK).zip(shares.chunks_mut(BLOCK));
                for ((extents, longest), (ranges, shares)) in given.zip(found) {
                    self.block(extents, longest, ranges, shares);
                    shares.iter().for_each(|share| total.add(*share));
                }
            },
        );
        (verdicts, totals)
    }

    /// Judges up to [`BLOCK`] cells.
    fn block(
        &self,
        extents: &[[f32; 2]],
        longest: &[f32],
        ranges: &mut [u32],
        shares: &mut [Share],
    ) {
        // The interval that one enters at the least scalar on the way up, and at the greatest on
        // the way down: what only touches a knot is not beyond it.
        let (mut above, mut below) = ([0_u32; BLOCK], [0_u32; BLOCK]);
        let intervals = above.iter_mut().zip(&mut below);
        if self.ends.len() <= FEW {
            // Ends outside and cells inside, so that this is compiled to vectors.
            for end in &self.ends {
                for ((above, below), [low, high]) in above.iter_mut().zip(&mut below).zip(extents) {
                    *above += u32::from(end <= low);
                    *below += u32::from(end < high);
                }
            }
        } else {
            for ((above, below), [low, high]) in intervals.zip(extents) {
                *above = self.ends.partition_point(|end| end <= low) as u32;
                *below = self.ends.partition_point(|end| end < high) as u32;
            }
        }
        let given = extents.iter().zip(longest).zip(above.iter().zip(&below));
        let found = ranges.iter_mut().zip(shares);
        for (((extent, longest), (above, below)), (range, share)) in given.zip(found) {
            // A constant on a knot is on both of its sides.
            let (first, last) = (*above.min(below), *above.max(below));
            if !extent[0].is_nan() {
                *range = first | last << 16;
                *share = self.share([first, last].map(|i| i as usize), *extent, *longest);
            }
        }
    }

    /// Of a cell with scalars in the intervals from `first` to `last`.
    fn share(&self, [first, last]: [usize; 2], [low, high]: [f32; 2], longest: f32) -> Share {
        let is_constant = low == high;
        let shown = match self.model {
            OpticalModel::Isosurfaces => self.has_isovalue(low, high),
            _ if is_constant => self.shows_at(first, low) || self.shows_at(last, low),
            // Where one end of an interval shows, all of its inside does.
            _ => self.next_shown[first] as usize <= last,
        };
        if longest == 0.0 || !shown {
            return Share::default();
        }
        if !self.pieces {
            return Share {
                pieces: 1,
                parts: 1,
            };
        }
        let pieces = match is_constant {
            true => 1,
            false => (last - first) as u16 + 1,
        };
        // Almost all are, and `parts` would say so: it samples no more than the densest, but for
        // a few roundings.
        let is_thin = self.densest * longest <= 0.999;
        let parts = match is_thin {
            true => 1,
            false => self.parts([first, last], [low, high], longest) as u16,
        };
        Share { pieces, parts }
    }

    /// Whether low < v ≤ high for one of the isovalues, as `surfaces.wgsl` decides.
    fn has_isovalue(&self, low: f32, high: f32) -> bool {
        let first = self.isovalues.partition_point(|value| *value <= low);
        self.isovalues
            .get(first)
            .is_some_and(|value| *value <= high)
    }

    fn shows_at(&self, index: usize, scalar: f32) -> bool {
        shows(self.model, sampled(&self.intervals[index], scalar))
    }

    /// Into how many parts of one optical depth at most the ray's way through a cell is cut.
    fn parts(&self, [first, last]: [usize; 2], [low, high]: [f32; 2], longest: f32) -> u32 {
        if self.model != OpticalModel::EmissionAbsorption {
            return 1;
        }
        if last - first >= MOST_LOOKED_AT {
            return MOST_PARTS + 1;
        }
        let mut densest = 0.0_f32;
        for i in &self.intervals[first..=last] {
            let at = |scalar: f32| sampled(i, scalar.clamp(i.low, i.high))[3];
            densest = densest.max(at(low)).max(at(high));
        }
        // More than f32 loses in all this.
        let deepest = densest * longest * 1.00001;
        match deepest <= MOST_PARTS as f32 {
            true => (deepest.ceil() as u32).max(1),
            false => MOST_PARTS + 1,
        }
    }
}

fn shows(model: OpticalModel, [r, g, b, extinction]: [f32; 4]) -> bool {
    match model {
        OpticalModel::MaximumIntensity => r > 0.0 || g > 0.0 || b > 0.0,
        _ => extinction > 0.0,
    }
}

/// As `sample_interval` of `transfer_function.wgsl`.
fn sampled(i: &KnotPair, scalar: f32) -> [f32; 4] {
    let to_high = ((scalar - i.low) * i.inverse_width).clamp(0.0, 1.0);
    let to_low = ((i.high - scalar) * i.inverse_width).clamp(0.0, 1.0);
    std::array::from_fn(|n| i.at_low[n] * to_low + i.at_high[n] * to_high)
}

impl Culled {
    /// The same cells, `listed`, drawn whole.
    pub(crate) fn whole(&self, gpu: &Gpu, listed: &[u32]) -> Result<Culled, Error> {
        let storage = BufferUsages::STORAGE;
        Ok(Culled {
            ranges: self.ranges.clone(),
            drawn: gpu.upload("the list of drawn cells", listed, storage)?,
            pieces: gpu.upload("the cells' pieces", &[[NO_CELL, 0]], storage)?,
            items: listed.len() as u32,
            cells: self.cells,
            in_pieces: false,
            in_parts: false,
            verdicts: self.verdicts.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;
    use tetrascope_core::mesh::{Association, Scalars};
    use tetrascope_core::{Knot, TetMesh, TransferFunction};
    use tetrascope_f32::{Domain, ScalarMap};
    use tetrascope_gpu::transfer_function::knot_pairs;

    use super::*;
    use crate::options::CellLayout;

    /// A row of cells; each has the four scalars that `of` gives it, or the first.
    fn row(association: Association, cells: u32, of: impl Fn(u32) -> [f64; 4]) -> TetMesh {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let corner = |cell: u32, i: usize| match (cell % 13, i) {
            // Flat.
            (7, 3) => corners[1] + corners[2] + f64::from(cell) * DVec3::X,
            _ => corners[i] + f64::from(cell) * DVec3::X,
        };
        let points = (0..cells).flat_map(|c| (0..4).map(move |i| corner(c, i)));
        let values = match association {
            Association::Point => (0..cells).flat_map(&of).collect(),
            Association::Cell => (0..cells).map(|c| of(c)[0]).collect(),
        };
        let scalars = Scalars {
            name: "s".into(),
            association,
            values,
        };
        let cells = (0..cells)
            .map(|c| [0, 1, 2, 3].map(|i| 4 * c + i))
            .collect();
        TetMesh::from_tetrahedra(points.collect(), cells, scalars).expect("valid")
    }

    /// Two ramps with nothing between, a step, and one color without extinction.
    fn function() -> TransferFunction {
        let knot = |scalar, extinction, color: f64| Knot {
            scalar,
            color: DVec3::splat(color),
            extinction,
        };
        let knots = vec![
            knot(0.0, 0.0, 0.0),
            knot(1.0, 1.0, 1.0),
            knot(2.0, 0.0, 0.0),
            knot(4.0, 0.0, 0.0),
            knot(4.0, 3.0, 0.0),
            knot(5.0, 3.0, 0.0),
            knot(5.0, 0.0, 0.0),
            knot(6.0, 0.0, 0.5),
            knot(7.0, 0.0, 0.0),
        ];
        TransferFunction::new(knots).expect("sorted")
    }

    /// Quarters, so that f32 has them and many are on knots.
    fn scalars(cell: u32) -> [f64; 4] {
        let start = f64::from(cell * 7 % 41) / 4.0 - 1.0;
        let step = f64::from(cell % 5) / 4.0;
        let last = if cell % 17 == 3 {
            f64::NAN
        } else {
            start + step
        };
        [start, start + step * 0.5, last, start]
    }

    /// What the docs of this file say, cell by cell.
    fn is_shown(mesh: &TetMesh, cell: usize, model: OpticalModel, isovalues: &[f64]) -> bool {
        let values: [f64; 4] = mesh.cell_scalars(cell);
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if cell % 13 == 7 || values.iter().any(|s| s.is_nan()) {
            return false;
        }
        // Inside of the cell: what it only touches does not count, unless it is constant.
        let inside = if low < high { 1e-6 } else { 0.0 };
        let (low_in, high_in) = (low + inside, high - inside);
        match model {
            OpticalModel::Isosurfaces => isovalues.iter().any(|v| low < *v && *v <= high),
            OpticalModel::MaximumIntensity => function().max_color(low_in, high_in) > 0.0,
            _ => function().max_extinction(low_in, high_in) > 0.0,
        }
    }

    #[test]
    fn the_list_is_that_of_the_cells_that_show() {
        let Some(gpu) = tetrascope_testing::gpu("the_list_is_that_of_the_cells_that_show") else {
            return;
        };
        let isovalues = [3.25, 0.5, 5.0];
        // On one thread and on several.
        for cells in [1, 257, 70_001] {
            for association in [Association::Point, Association::Cell] {
                let mesh = row(association, cells, scalars);
                let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
                let map = ScalarMap::of_appearance(
                    &tetrascope_core::Appearance::new(function(), OpticalModel::Emission),
                    mesh.scalar_range(),
                );
                let layout = CellLayout::SharedVertices;
                let field = Field::upload(&gpu, &geometry, &mesh, map, layout).expect("it fits");
                let intervals = knot_pairs(&function(), &map, &geometry.normalization);
                let intervals = intervals.expect("few knots");
                for model in OpticalModel::ALL {
                    let expected = (0..mesh.cell_count())
                        .filter(|cell| is_shown(&mesh, *cell, model, &isovalues));
                    let expected: Vec<u32> = expected.map(|cell| cell as u32).collect();
                    for pieces in [false, true] {
                        let culled = cull(
                            &gpu,
                            &Judged {
                                geometry: &geometry,
                                field: &field,
                                model,
                                intervals: &intervals,
                                isovalues: &isovalues.map(|v| map.scalar(v)),
                                pieces,
                            },
                            true,
                            None,
                        );
                        let (culled, listed) = culled.expect("it fits");
                        let (listed, starts) = (listed.cells, listed.starts);
                        let what = format!("{cells} {association:?} {model:?} {pieces}");
                        assert_eq!(listed[..], expected, "{what}");
                        assert_eq!(culled.cells as usize, expected.len(), "{what}");
                        let Some(starts) = starts else {
                            assert_eq!(culled.items, culled.cells, "{what}");
                            continue;
                        };
                        assert!(pieces);
                        assert_eq!(starts.len(), mesh.cell_count() + 1);
                        let many = |cell: usize| starts[cell + 1] - starts[cell];
                        for cell in 0..mesh.cell_count() {
                            let drawn = expected.binary_search(&(cell as u32)).is_ok();
                            assert_eq!(many(cell) > 0, drawn, "{what} {cell}");
                        }
                        assert_eq!(starts[mesh.cell_count()], culled.items, "{what}");
                    }
                }
            }
        }
    }

    /// Buffers of an earlier list that stay are taken over, and nothing else.
    #[test]
    fn what_an_edit_leaves_as_it_was_is_kept() {
        let Some(gpu) = tetrascope_testing::gpu("what_an_edit_leaves_as_it_was_is_kept") else {
            return;
        };
        let mesh = row(Association::Point, 20_000, scalars);
        let geometry = Geometry::upload(&gpu, &mesh, Domain::of(&mesh)).expect("it fits");
        let model = OpticalModel::EmissionAbsorption;
        let map = ScalarMap::of(&function());
        let layout = CellLayout::SharedVertices;
        let field = Field::upload(&gpu, &geometry, &mesh, map, layout).expect("it fits");
        // The same, other colors, a knot elsewhere, and one more that shows.
        let edits: [fn(&mut Vec<Knot>); 4] = [
            |_| {},
            |knots| knots[1].color *= 0.5,
            |knots| knots[1].scalar = 1.25,
            |knots| knots[7].extinction = 1.0,
        ];
        for pieces in [false, true] {
            let made = |edit: fn(&mut Vec<Knot>), last| {
                let mut knots = function().knots().to_vec();
                edit(&mut knots);
                let edited = TransferFunction::new(knots).expect("sorted");
                let intervals = knot_pairs(&edited, &map, &geometry.normalization);
                let judged = Judged {
                    geometry: &geometry,
                    field: &field,
                    model,
                    intervals: &intervals.expect("few knots"),
                    isovalues: &[],
                    pieces,
                };
                cull(&gpu, &judged, true, last).expect("it fits")
            };
            let first = made(edits[0], None);
            for (index, edit) in edits.into_iter().enumerate() {
                let next = made(edit, Some((&first.0, &first.1)));
                let fresh = made(edit, None);
                let what = format!("edit {index}, pieces {pieces}");
                assert_eq!(next.0.ranges == first.0.ranges, index != 2, "{what}");
                let is_kept = index < if pieces { 2 } else { 3 };
                assert_eq!(next.0.pieces == first.0.pieces, is_kept, "{what}");
                assert_eq!(next.1.cells, fresh.1.cells, "{what}");
                assert_eq!(next.1.starts, fresh.1.starts, "{what}");
                assert_eq!(next.0.items, fresh.0.items, "{what}");
                // All lists follow from these.
                assert_eq!(next.0.verdicts, fresh.0.verdicts, "{what}");
                assert_eq!(next.0.in_pieces, fresh.0.in_pieces, "{what}");
                assert_eq!(next.0.in_parts, fresh.0.in_parts, "{what}");
                let room = next.0.drawn.size() / 4;
                assert!(room >= u64::from(next.0.items), "{what}");
            }
        }
    }
}
