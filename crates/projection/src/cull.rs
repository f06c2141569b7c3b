//! Which cells can show, whenever appearance or scalars change, and the list of what is drawn.
//!
//! On the CPU, which knows the least and the greatest scalar of each cell: how many items there are
//! decides what is allocated, so a device would be waited for twice. 187 000 cells take some 8 ms;
//! passes took 136 ms on llvmpipe, half of that in barriers.
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

/// What is left to draw.
#[derive(Debug)]
pub(crate) struct Culled {
    /// The first and the last interval of each of the mesh's cells, 16 bits each.
    pub(crate) ranges: wgpu::Buffer,
    /// The items that are drawn: cells or, where `in_pieces`, those.
    pub(crate) drawn: wgpu::Buffer,
    /// A cell and what of it is drawn, by piece; see `pieces.wgsl`.
    pub(crate) pieces: wgpu::Buffer,
    pub(crate) items: u32,
    pub(crate) cells: u32,
    pub(crate) in_pieces: bool,
    /// Whether pieces are in parts, none of an optical depth above 1.
    pub(crate) in_parts: bool,
}

/// What an order that is made on the CPU has to know of the cells that are drawn.
#[derive(Clone, Debug, Default)]
pub(crate) struct Listed {
    /// Their indices.
    pub(crate) cells: Arc<[u32]>,
    /// The first piece of each of the mesh's cells, and the end of the last, where cells are
    /// drawn in pieces.
    starts: Option<Arc<[u32]>>,
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

/// In what a cell is drawn.
#[derive(Clone, Copy, Debug, Default)]
struct Verdict {
    /// The first and the last interval of its scalars.
    range: [u16; 2],
    /// Its pieces, one for each of those; 0 if it is not drawn.
    pieces: u32,
    /// The parts of each, for `segment_weights`; more than [`MOST_PARTS`] if that is unknown.
    parts: u32,
}

/// Lists what of `judged` is drawn; also for the CPU if it asks, else that list is empty.
pub(crate) fn cull(gpu: &Gpu, judged: &Judged, is_listed: bool) -> Result<(Culled, Listed), Error> {
    let judge = Judge::new(judged);
    let verdicts = judge.all(&judged.field.extents, &judged.geometry.longest_edges);
    let shown = || (0_u32..).zip(&verdicts).filter(|(_, v)| v.pieces > 0);
    let (mut cells, mut pieces, mut parts, mut uncounted) = (0_u32, 0_u64, 0_u64, false);
    for (_, verdict) in shown() {
        cells += 1;
        pieces += u64::from(verdict.pieces);
        parts += u64::from(verdict.pieces) * u64::from(verdict.parts);
        uncounted |= verdict.parts > MOST_PARTS;
    }
    let fit = |items: u64| {
        judged.pieces && items <= MOST_PIECES * u64::from(cells) && items <= u64::from(u32::MAX / 4)
    };
    let in_parts = fit(parts) && !uncounted && judged.model == OpticalModel::EmissionAbsorption;
    let in_pieces = in_parts || fit(pieces);
    let items_of = |verdict: &Verdict| match (in_pieces, in_parts) {
        (_, true) => verdict.pieces * verdict.parts,
        (true, false) => verdict.pieces,
        (false, false) => 1,
    };
    let mut list: Vec<[u32; 2]> = Vec::new();
    let drawn: Vec<u32> = match in_pieces {
        false => shown().map(|(cell, _)| cell).collect(),
        true => {
            list.reserve(if in_parts { parts } else { pieces } as usize);
            for (cell, verdict) in shown() {
                let parts = if in_parts { verdict.parts } else { 1 };
                for piece in 0..verdict.pieces {
                    let what = |part: u32| piece | part << 16 | (parts - 1) << 24;
                    list.extend((0..parts).map(|part| [cell, what(part)]));
                }
            }
            (0..list.len() as u32).collect()
        }
    };
    let mut listed = Listed::default();
    if is_listed {
        listed.cells = shown().map(|(cell, _)| cell).collect();
        listed.starts = in_pieces.then(|| {
            let mut start = 0;
            let starts = verdicts.iter().map(|verdict| {
                let items = if verdict.pieces > 0 {
                    items_of(verdict)
                } else {
                    0
                };
                start += items;
                start - items
            });
            let mut starts: Vec<u32> = starts.collect();
            starts.push(drawn.len() as u32);
            starts.into()
        });
    }
    let packed = |v: &Verdict| u32::from(v.range[0]) | u32::from(v.range[1]) << 16;
    let ranges: Vec<u32> = verdicts.iter().map(packed).collect();
    if list.is_empty() {
        list.push([NO_CELL, 0]);
    }
    let storage = BufferUsages::STORAGE;
    let culled = Culled {
        ranges: gpu.upload("the cells' intervals", &ranges, storage)?,
        drawn: gpu.upload("the list of drawn cells", &drawn, storage)?,
        pieces: gpu.upload("the cells' pieces", &list, storage)?,
        items: drawn.len() as u32,
        cells,
        in_pieces,
        in_parts,
    };
    Ok((culled, listed))
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
        }
    }

    /// Judges cells with these least and greatest scalars and longest edges, on all cores.
    fn all(&self, extents: &[[f32; 2]], longest: &[f32]) -> Vec<Verdict> {
        let mut verdicts = vec![Verdict::default(); extents.len()];
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        // Below that a thread costs more than it gains.
        let share = extents.len().div_ceil(cores).max(1 << 14);
        std::thread::scope(|scope| {
            let chunks = verdicts.chunks_mut(share);
            for ((verdicts, extents), longest) in
                chunks.zip(extents.chunks(share)).zip(longest.chunks(share))
            {
                let mut judge = move || {
                    let cells = extents.iter().zip(longest);
                    for (verdict, (extent, longest)) in verdicts.iter_mut().zip(cells) {
                        *verdict = self.verdict(*extent, *longest);
                    }
                };
                match extents.len() < share {
                    // The last, or the only one.
                    true => judge(),
                    false => drop(scope.spawn(judge)),
                }
            }
        });
        verdicts
    }

    fn verdict(&self, [low, high]: [f32; 2], longest: f32) -> Verdict {
        if low.is_nan() {
            return Verdict::default();
        }
        // What only touches a knot is not beyond it, unless it is constant: then it is on both
        // sides.
        let (above, below) = (self.interval_above(low), self.interval_below(high));
        let (first, last) = (above.min(below), above.max(below));
        let range = [first as u16, last as u16];
        let is_constant = low == high;
        let shown = match self.model {
            OpticalModel::Isosurfaces => self.has_isovalue(low, high),
            _ if is_constant => self.shows_at(first, low) || self.shows_at(last, low),
            // Where one end of an interval shows, all of its inside does.
            _ => self.next_shown[first] as usize <= last,
        };
        if longest == 0.0 || !shown {
            return Verdict {
                range,
                ..Verdict::default()
            };
        }
        Verdict {
            range,
            pieces: match is_constant {
                true => 1,
                false => (last - first) as u32 + 1,
            },
            parts: self.parts([first, last], [low, high], longest),
        }
    }

    /// The interval that one enters at `scalar` on the way up.
    fn interval_above(&self, scalar: f32) -> usize {
        self.count(|end| end <= scalar)
    }

    /// The interval that one enters at `scalar` on the way down.
    fn interval_below(&self, scalar: f32) -> usize {
        self.count(|end| end < scalar)
    }

    fn count(&self, is_below: impl Fn(f32) -> bool) -> usize {
        match self.ends.len() {
            0..=FEW => self.ends.iter().filter(|end| is_below(**end)).count(),
            _ => self.ends.partition_point(|end| is_below(*end)),
        }
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
}
