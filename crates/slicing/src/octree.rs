//! The octree of least and greatest samples, and its traversal in visibility order (§6).

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{BrickSource, Region, SampleType, Samples};
use tetrascope_core::{Appearance, Error};

use crate::boxes::{Boxes, Place, places};
use crate::frustum::Frustum;
use crate::skip::SkipTable;

/// About how many samples are read at a time, where bricks are not larger.
const RUN_SAMPLES: usize = 1 << 22;

/// Least and greatest samples of nested boxes.
#[derive(Debug)]
pub(crate) struct Octree {
    pub(crate) boxes: Boxes,
    /// By level and number of the box: least and greatest sample; empty (least above
    /// greatest) without any that is finite.
    ranges: Vec<Vec<[f32; 2]>>,
    sample_type: SampleType,
    /// Whether some sample is not finite, and so has no value.
    pub(crate) gaps: bool,
}

/// From where the volume is seen, lattice space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Viewer {
    /// From one point.
    Eye(DVec3),
    /// Along one direction.
    Direction(DVec3),
}

/// The boxes and the view of a traversal.
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
        let boxes = Boxes::new(source.lattice().cells());
        let ranges = (0..=boxes.deepest()).map(|level| {
            let count = boxes.divisions(level).iter().product();
            vec![[f32::INFINITY, f32::NEG_INFINITY]; count]
        });
        let mut octree = Octree {
            boxes,
            ranges: ranges.collect(),
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
        let boxes = self.boxes;
        let (brick_level, deepest) = (brick_level(&boxes, |_| true), boxes.deepest());
        let bricks = boxes.divisions(brick_level);
        let per_brick = [0, 1, 2].map(|a| boxes.divisions(deepest)[a] / bricks[a]);
        let brick_samples: usize = boxes.box_size(brick_level).iter().product();
        let run = (RUN_SAMPLES / brick_samples).clamp(1, bricks[0]);
        let runs = [bricks[0].div_ceil(run), bricks[1], bricks[2]];
        for [first, y, z] in places(runs).map(|[x, y, z]| [x * run, y, z]) {
            let count = run.min(bricks[0] - first);
            let of_bricks = (first..first + count)
                .filter_map(|x| boxes.region(brick_level, [x, y, z], reach))
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
                let Some(part) = boxes.region(deepest, place, reach) else {
                    continue;
                };
                let part = Region {
                    low: [0, 1, 2].map(|a| part.low[a] - region.low[a]),
                    size: part.size,
                };
                let (range, gaps) = range(&samples, region.size, part);
                self.ranges[deepest as usize][boxes.index(deepest, place)] = range;
                self.gaps |= gaps;
            }
        }
        Ok(())
    }

    /// Fills every level from the one below.
    fn gather(&mut self) {
        let boxes = self.boxes;
        for level in (0..boxes.deepest()).rev() {
            for place in places(boxes.divisions(level + 1)) {
                let [low, high] = self.range(level + 1, place);
                let above = boxes.ancestor(level + 1, place, level);
                let range = &mut self.ranges[level as usize][boxes.index(level, above)];
                *range = [range[0].min(low), range[1].max(high)];
            }
        }
    }

    /// The least and greatest sample of a box.
    pub(crate) fn range(&self, level: u32, place: Place) -> [f32; 2] {
        self.ranges[level as usize][self.boxes.index(level, place)]
    }

    /// The table that tells by a range of samples whether `appearance` shows any of it.
    pub(crate) fn table(&self, appearance: &Appearance) -> SkipTable {
        SkipTable::new(appearance, self.sample_type)
    }

    /// The range of each box of a level, x fastest, as entries of `table`.
    pub(crate) fn entries(&self, level: u32, table: &SkipTable) -> Vec<[u32; 2]> {
        let ranges = self.ranges[level as usize].iter();
        ranges
            .map(|[low, high]| table.entries((*low).into(), (*high).into()))
            .collect()
    }

    /// Which boxes can show.
    pub(crate) fn visibility(&self, table: &SkipTable) -> Visibility {
        let levels: Vec<Vec<bool>> = self
            .ranges
            .iter()
            .map(|level| {
                level
                    .iter()
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
        let shows = seen
            .visibility
            .contains(level, self.boxes.index(level, place));
        let (low, size) = (self.boxes.low(level, place), self.boxes.box_size(level));
        if !shows || !seen.frustum.shows(low, size) {
            return;
        }
        if level == seen.last {
            found.push(place);
            return;
        }
        let size = self.boxes.box_size(level + 1);
        let halvings = self.boxes.halvings(self.boxes.deepest());
        // The far child of each axis, then the near one; one child where it is not halved.
        let children = [0, 1, 2].map(|a| {
            if level >= halvings[a] {
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
                .take(if level < halvings[a] { 2 } else { 1 })
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

/// Cells along an axis of a brick, at most, unless the octree is not that deep.
const BRICK_CELLS: usize = 64;

/// The first level whose boxes are small enough for bricks and, by their sizes in cells, fit.
pub(crate) fn brick_level(boxes: &Boxes, fits: impl Fn([usize; 3]) -> bool) -> u32 {
    boxes.first_level(|size| size.iter().all(|s| *s <= BRICK_CELLS) && fits(size))
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
