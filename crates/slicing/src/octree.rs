//! The octree of least and greatest samples, and its traversal in visibility order (§6).

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{BrickSource, Region, SampleType, Samples};
use tetrascope_core::{Appearance, Error};

use crate::frustum::Frustum;
use crate::options::MAX_LEVEL;
use crate::skip::SkipTable;

/// An axis is halved while its boxes keep about this many cells.
const LEAST_CELLS: usize = 8;

/// Cells along an axis of a brick, at most, unless the octree is not that deep.
const BRICK_CELLS: usize = 64;

/// About how many samples are read at a time, where bricks are not larger.
const RUN_SAMPLES: usize = 1 << 22;

/// Least and greatest samples of nested boxes.
///
/// Level l divides each axis into 2^l boxes, or as many as it has at most; all boxes of a
/// level have the same size, so those at the far ends may reach out of the volume.
#[derive(Debug)]
pub(crate) struct Octree {
    cells: [usize; 3],
    /// How often each axis is halved.
    halvings: [u32; 3],
    /// Cells of a box of the deepest level.
    leaf: [usize; 3],
    levels: Vec<Ranges>,
    sample_type: SampleType,
    /// Whether some sample is not finite, and so has no value.
    pub(crate) gaps: bool,
}

/// The boxes of one level, x fastest.
#[derive(Debug)]
struct Ranges {
    divisions: [usize; 3],
    /// Least and greatest sample; empty (least above greatest) without any that is finite.
    ranges: Vec<[f32; 2]>,
}

/// A box of one level, by its place along each axis.
pub(crate) type Place = [usize; 3];

/// From where the volume is seen, lattice space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Viewer {
    /// From one point.
    Eye(DVec3),
    /// Along one direction.
    Direction(DVec3),
}

/// What a traversal looks at.
struct Seen<'a> {
    visibility: &'a Visibility,
    viewer: Viewer,
    frustum: &'a Frustum,
    /// The level of the boxes that are wanted.
    last: u32,
}

/// Which boxes of each level the transfer function leaves to draw.
#[derive(Debug)]
pub(crate) struct Visibility {
    levels: Vec<Vec<bool>>,
    counts: Vec<usize>,
}

impl Octree {
    /// Reads all samples once; each box includes those `reach` samples around it.
    pub(crate) fn build(source: &dyn BrickSource, reach: usize) -> Result<Octree, Error> {
        let cells = source.lattice().cells();
        let halvings = cells.map(|c| {
            // One more, as 256 samples have 255 cells.
            let deep = ((c + 1) / LEAST_CELLS).max(1).ilog2();
            deep.min(MAX_LEVEL)
        });
        let leaf = [0, 1, 2].map(|a| cells[a].div_ceil(1 << halvings[a]));
        let deepest = halvings.into_iter().max().unwrap_or(0);
        let levels = (0..=deepest).map(|level| {
            let divisions = halvings.map(|h| 1 << level.min(h));
            let count = divisions.iter().product();
            Ranges {
                divisions,
                ranges: vec![[f32::INFINITY, f32::NEG_INFINITY]; count],
            }
        });
        let mut octree = Octree {
            cells,
            halvings,
            leaf,
            levels: levels.collect(),
            sample_type: source.sample_type(),
            gaps: false,
        };
        octree.read(source, reach)?;
        octree.gather();
        Ok(octree)
    }

    /// Fills the deepest level, some bricks in a row at a time, as all samples may not fit
    /// in memory and long rows are read fastest.
    fn read(&mut self, source: &dyn BrickSource, reach: usize) -> Result<(), Error> {
        let (brick_level, deepest) = (self.brick_level(|_| true), self.deepest());
        let bricks = self.levels[brick_level as usize].divisions;
        let per_brick = [0, 1, 2].map(|a| self.levels[deepest as usize].divisions[a] / bricks[a]);
        let brick_samples: usize = self.box_size(brick_level).iter().product();
        let run = (RUN_SAMPLES / brick_samples).clamp(1, bricks[0]);
        let runs = [bricks[0].div_ceil(run), bricks[1], bricks[2]];
        for [first, y, z] in places(runs).map(|[x, y, z]| [x * run, y, z]) {
            let count = run.min(bricks[0] - first);
            let of_bricks = (first..first + count)
                .filter_map(|x| self.region(brick_level, [x, y, z], reach))
                .reduce(|all, next| Region {
                    low: all.low,
                    size: [
                        next.low[0] + next.size[0] - all.low[0],
                        all.size[1],
                        all.size[2],
                    ],
                });
            let Some(region) = of_bricks else {
                continue;
            };
            let samples = source.read(region)?;
            for within in places([count * per_brick[0], per_brick[1], per_brick[2]]) {
                let brick = [first, y, z];
                let place = [0, 1, 2].map(|a| brick[a] * per_brick[a] + within[a]);
                let Some(part) = self.region(deepest, place, reach) else {
                    continue;
                };
                let part = Region {
                    low: [0, 1, 2].map(|a| part.low[a] - region.low[a]),
                    size: part.size,
                };
                let (range, gaps) = range(&samples, region.size, part);
                let index = self.index(deepest, place);
                self.levels[deepest as usize].ranges[index] = range;
                self.gaps |= gaps;
            }
        }
        Ok(())
    }

    /// Fills every level from the one below.
    fn gather(&mut self) {
        for level in (0..self.deepest()).rev() {
            for place in places(self.levels[level as usize + 1].divisions) {
                let [low, high] = self.range(level + 1, place);
                let above = self.parent(level + 1, place);
                let index = self.index(level, above);
                let range = &mut self.levels[level as usize].ranges[index];
                *range = [range[0].min(low), range[1].max(high)];
            }
        }
    }

    /// The number of the deepest level; the whole volume is level 0.
    pub(crate) fn deepest(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// How often each axis is halved down to this level.
    pub(crate) fn halvings(&self, level: u32) -> [u32; 3] {
        self.halvings.map(|h| level.min(h))
    }

    /// The first level whose boxes are small enough for bricks and, by their sizes in cells,
    /// fit.
    pub(crate) fn brick_level(&self, fits: impl Fn([usize; 3]) -> bool) -> u32 {
        let small = |level: &u32| {
            let size = self.box_size(*level);
            size.iter().all(|s| *s <= BRICK_CELLS) && fits(size)
        };
        (0..self.deepest()).find(small).unwrap_or(self.deepest())
    }

    /// Cells along each axis of a box.
    pub(crate) fn box_size(&self, level: u32) -> [usize; 3] {
        [0, 1, 2].map(|a| self.leaf[a] << (self.halvings[a] - level.min(self.halvings[a])))
    }

    /// How many boxes a level has along each axis, those outside of the volume too.
    pub(crate) fn divisions(&self, level: u32) -> [usize; 3] {
        self.levels[level as usize].divisions
    }

    /// How many boxes a level has, those outside of the volume not counted.
    pub(crate) fn box_count(&self, level: u32) -> usize {
        let size = self.box_size(level);
        (0..3).map(|a| self.cells[a].div_ceil(size[a])).product()
    }

    /// The box's number among those of its level.
    pub(crate) fn index(&self, level: u32, place: Place) -> usize {
        let [x, y, _] = self.levels[level as usize].divisions;
        place[0] + x * (place[1] + y * place[2])
    }

    /// The box of level `above` that contains this one.
    pub(crate) fn ancestor(&self, level: u32, place: Place, above: u32) -> Place {
        [0, 1, 2].map(|a| {
            let h = self.halvings[a];
            place[a] >> (level.min(h) - above.min(h))
        })
    }

    fn parent(&self, level: u32, place: Place) -> Place {
        self.ancestor(level, place, level - 1)
    }

    /// The box's least corner, lattice space.
    pub(crate) fn low(&self, level: u32, place: Place) -> [usize; 3] {
        let size = self.box_size(level);
        [0, 1, 2].map(|a| place[a] * size[a])
    }

    /// The samples of a box and `reach` around it, as far as there are any; `None` if the
    /// box lies outside of the volume.
    pub(crate) fn region(&self, level: u32, place: Place, reach: usize) -> Option<Region> {
        let (low, size) = (self.low(level, place), self.box_size(level));
        let outside = (0..3).any(|a| low[a] >= self.cells[a]);
        let first = low.map(|l| l.saturating_sub(reach));
        let last = [0, 1, 2].map(|a| (low[a] + size[a] + reach).min(self.cells[a]));
        (!outside).then(|| Region {
            low: first,
            size: [0, 1, 2].map(|a| last[a] + 1 - first[a]),
        })
    }

    /// The least and greatest sample of a box.
    pub(crate) fn range(&self, level: u32, place: Place) -> [f32; 2] {
        self.levels[level as usize].ranges[self.index(level, place)]
    }

    /// What tells by a range of samples whether `appearance` shows any of it.
    pub(crate) fn table(&self, appearance: &Appearance) -> SkipTable {
        SkipTable::new(appearance, self.sample_type)
    }

    /// The range of each box of a level, x fastest, as entries of `table`.
    pub(crate) fn entries(&self, level: u32, table: &SkipTable) -> Vec<[u32; 2]> {
        let ranges = self.levels[level as usize].ranges.iter();
        ranges
            .map(|[low, high]| table.entries((*low).into(), (*high).into()))
            .collect()
    }

    /// Which boxes can show.
    pub(crate) fn visibility(&self, table: &SkipTable) -> Visibility {
        let levels: Vec<Vec<bool>> = self
            .levels
            .iter()
            .map(|level| {
                let ranges = level.ranges.iter();
                ranges
                    .map(|[low, high]| table.shows((*low).into(), (*high).into()))
                    .collect()
            })
            .collect();
        let counts = levels
            .iter()
            .map(|l| l.iter().filter(|v| **v).count())
            .collect();
        Visibility { levels, counts }
    }

    /// The visible boxes of a level, back to front: each box before all that hide parts
    /// of it. Boxes that are invisible or outside of `frustum` are left out with all that
    /// they contain.
    pub(crate) fn back_to_front(
        &self,
        level: u32,
        visibility: &Visibility,
        viewer: Viewer,
        frustum: &Frustum,
    ) -> Vec<Place> {
        let mut found = Vec::with_capacity(visibility.counts[level as usize]);
        let seen = Seen {
            visibility,
            viewer,
            frustum,
            last: level,
        };
        self.visit(0, [0; 3], &seen, &mut found);
        found
    }

    fn visit(&self, level: u32, place: Place, seen: &Seen, found: &mut Vec<Place>) {
        let shows = seen.visibility.contains(level, self.index(level, place));
        let (low, size) = (self.low(level, place), self.box_size(level));
        if !shows || !seen.frustum.shows(low, size) {
            return;
        }
        if level == seen.last {
            found.push(place);
            return;
        }
        let size = self.box_size(level + 1);
        // The far child of each axis, then the near one; one child where it is not halved.
        let children = [0, 1, 2].map(|a| {
            if level >= self.halvings[a] {
                return [place[a]; 2];
            }
            let (lower, upper) = (2 * place[a], 2 * place[a] + 1);
            let upper_is_far = match seen.viewer {
                Viewer::Eye(eye) => eye[a] < (upper * size[a]) as f64,
                Viewer::Direction(direction) => direction[a] > 0.0,
            };
            if upper_is_far {
                [upper, lower]
            } else {
                [lower, upper]
            }
        });
        let each = |a: usize| {
            children[a]
                .iter()
                .take(if level < self.halvings[a] { 2 } else { 1 })
        };
        for z in each(2) {
            for y in each(1) {
                for x in each(0) {
                    self.visit(level + 1, [*x, *y, *z], seen, found);
                }
            }
        }
    }
}

impl Visibility {
    /// How many boxes of a level can show.
    pub(crate) fn count(&self, level: u32) -> usize {
        self.counts[level as usize]
    }

    /// Whether the box with this number can show.
    pub(crate) fn contains(&self, level: u32, index: usize) -> bool {
        self.levels[level as usize][index]
    }
}

/// Every place in a lattice of boxes, x fastest.
pub(crate) fn places(divisions: [usize; 3]) -> impl Iterator<Item = Place> {
    let [nx, ny, nz] = divisions;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

/// The least and greatest finite sample of a part of `samples`, and whether others are not.
fn range(samples: &Samples, size: [usize; 3], part: Region) -> ([f32; 2], bool) {
    match samples {
        Samples::U8(v) => range_of(v, size, part),
        Samples::U16(v) => range_of(v, size, part),
        Samples::I16(v) => range_of(v, size, part),
        Samples::F32(v) => range_of(v, size, part),
        // Never skipped.
        _ => ([f32::NEG_INFINITY, f32::INFINITY], true),
    }
}

fn range_of<T: Copy + Into<f32>>(all: &[T], size: [usize; 3], part: Region) -> ([f32; 2], bool) {
    let (mut low, mut high, mut gaps) = (f32::INFINITY, f32::NEG_INFINITY, false);
    for z in part.low[2]..part.low[2] + part.size[2] {
        for y in part.low[1]..part.low[1] + part.size[1] {
            let start = part.low[0] + size[0] * (y + size[1] * z);
            for sample in &all[start..start + part.size[0]] {
                let sample: f32 = (*sample).into();
                if !sample.is_finite() {
                    gaps = true;
                    continue;
                }
                low = if sample < low { sample } else { low };
                high = if sample > high { sample } else { high };
            }
        }
    }
    ([low, high], gaps)
}

#[cfg(test)]
mod tests;
