//! Bricks of cells: the range of scalars in each, and which cells show in an appearance.
//!
//! Four levels, each a block of 4³ of the next: groups of 64³ cells, bricks of 16³, blocks of 4³,
//! and cells. A level is a word of 64 bits for each block, of which one says whether anything
//! shows in a part of it. Ranges of bricks are kept from appearance to appearance; cells are
//! looked at only in bricks whose range shows, and bricks in which nothing does have no words.

use rayon::prelude::*;
use tetrascope_core::Error;
use tetrascope_core::grid::coverage::THERE;

use super::field::Field;
use super::shows::Shows;

/// Cells along each axis of a brick.
const BRICK: usize = 16;

/// In place of the number of a brick's words, where nothing shows.
const EMPTY: u32 = u32::MAX;

/// The scalars in a brick, rounded to nothing: samples fit f32.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    /// Of the samples that have a value and are covered; `low > high` where there is none.
    low: f32,
    high: f32,
    /// Whether a sample has no value, or may count as without.
    has_gaps: bool,
}

/// A brick in an appearance.
#[derive(Clone, Copy, Debug)]
struct Brick {
    /// Which of its blocks show.
    blocks: u64,
    /// Where its words are, in units of 64.
    words: u32,
}

/// The ranges of a grid's bricks, and what of it shows.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    cells: [u32; 3],
    /// A power of two that is at least 64 and as many as the most cells along an axis.
    side: u32,
    bricks_along: [usize; 3],
    groups_along: [usize; 3],
    ranges: Vec<Range>,
    groups: Vec<u64>,
    bricks: Vec<Brick>,
    /// Which cells show, by block.
    words: Vec<u64>,
}

impl Tree {
    /// The ranges of all bricks; nothing shows yet.
    ///
    /// # Errors
    /// More cells along an axis than this counts.
    pub(crate) fn new(field: &Field) -> Result<Tree, Error> {
        let most = field.cells.into_iter().max().unwrap_or(1);
        if most > 1 << 30 {
            return Err(Error::Unsupported {
                renderer: crate::NAME,
                what: format!("a grid of {:?} cells", field.cells),
                reason: "it counts up to 2^30 along an axis".into(),
            });
        }
        let bricks_along = field.cells.map(|cells| cells.div_ceil(BRICK));
        let groups_along = bricks_along.map(|bricks| bricks.div_ceil(4));
        let count = bricks_along.iter().product::<usize>();
        let range = |index: usize| Range::new(field, &Box16::new(field, bricks_along, index));
        Ok(Tree {
            cells: field.cells.map(|cells| cells as u32),
            side: (most as u32).next_power_of_two().max(64),
            bricks_along,
            groups_along,
            ranges: (0..count).into_par_iter().map(range).collect(),
            groups: Vec::new(),
            bricks: Vec::new(),
            words: Vec::new(),
        })
    }

    /// Finds what of the grid shows.
    pub(crate) fn restyle(&mut self, field: &Field, shows: &Shows) {
        let along = self.bricks_along;
        let found: Vec<(u64, Vec<u64>)> = (0..self.ranges.len())
            .into_par_iter()
            .map(|index| {
                let range = self.ranges[index];
                let may = shows.range(range.low, range.high) || shows.gaps() && range.has_gaps;
                if !may {
                    return (0, Vec::new());
                }
                words_of(field, &Box16::new(field, along, index), shows)
            })
            .collect();
        self.groups = vec![0; self.groups_along.iter().product()];
        self.bricks.clear();
        self.words.clear();
        for (index, (blocks, words)) in found.into_iter().enumerate() {
            let mut brick = Brick {
                blocks,
                words: EMPTY,
            };
            if blocks != 0 {
                brick.words = (self.words.len() / 64) as u32;
                self.words.extend(words);
                let place = places(index, along);
                let group = index_of(place.map(|p| p / 4), self.groups_along);
                self.groups[group] |= 1 << bit(place.map(|p| p as u32));
            }
            self.bricks.push(brick);
        }
    }

    /// Cells along each axis.
    #[inline(always)]
    pub(crate) fn cells(&self) -> [u32; 3] {
        self.cells
    }

    /// The side of the cube of cells in which walks mirror.
    #[inline(always)]
    pub(crate) fn side(&self) -> u32 {
        self.side
    }

    /// Whether anything shows in a cell, and else the largest block around it in which nothing
    /// does: the logarithm of its side to the base of two.
    #[inline(always)]
    pub(crate) fn look(&self, cell: [u32; 3]) -> (bool, u32) {
        let group = index_of(cell.map(|c| (c >> 6) as usize), self.groups_along);
        let bricks = self.groups[group];
        if bricks >> bit(cell.map(|c| c >> 4)) & 1 == 0 {
            return (false, if bricks == 0 { 6 } else { 4 });
        }
        let brick = self.bricks[index_of(cell.map(|c| (c >> 4) as usize), self.bricks_along)];
        let block = bit(cell.map(|c| c >> 2));
        if brick.blocks >> block & 1 == 0 {
            return (false, 2);
        }
        let word = self.words[brick.words as usize * 64 + block as usize];
        (word >> bit(cell) & 1 == 1, 0)
    }

    /// Bytes of all that is kept.
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = size_of_val(&self.ranges[..])
            + size_of_val(&self.groups[..])
            + size_of_val(&self.bricks[..])
            + size_of_val(&self.words[..]);
        bytes as u64
    }
}

/// The number of a part in its block of 4³, by its coordinates.
#[inline(always)]
fn bit([x, y, z]: [u32; 3]) -> u32 {
    (x & 3) | (y & 3) << 2 | (z & 3) << 4
}

#[inline(always)]
fn index_of([x, y, z]: [usize; 3], [nx, ny, _]: [usize; 3]) -> usize {
    x + nx * (y + ny * z)
}

fn places(index: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [index % nx, index / nx % ny, index / (nx * ny)]
}

/// Where a brick lies.
#[derive(Clone, Copy, Debug)]
struct Box16 {
    /// Its first cell.
    first: [usize; 3],
    /// Cells along each axis, at most [`BRICK`].
    cells: [usize; 3],
    /// Samples along each axis.
    samples: [usize; 3],
}

impl Box16 {
    fn new(field: &Field, along: [usize; 3], index: usize) -> Box16 {
        let first = places(index, along).map(|p| p * BRICK);
        let cells = [0, 1, 2].map(|axis| BRICK.min(field.cells[axis] - first[axis]));
        Box16 {
            first,
            cells,
            samples: cells.map(|cells| field.samples_of(cells)),
        }
    }

    /// Calls `row` with the number of a row of samples in the box and the indices of its samples.
    fn rows(&self, field: &Field, mut row: impl FnMut(usize, std::ops::Range<usize>)) {
        let [nx, ny, _] = field.grid.dims();
        let [x, y, z] = self.first;
        for k in 0..self.samples[2] {
            for j in 0..self.samples[1] {
                let from = x + nx * (y + j + ny * (z + k));
                row(j + self.samples[1] * k, from..from + self.samples[0]);
            }
        }
    }
}

impl Range {
    fn new(field: &Field, place: &Box16) -> Range {
        let mut range = Range {
            low: f32::INFINITY,
            high: f32::NEG_INFINITY,
            has_gaps: false,
        };
        let samples = field.grid.samples();
        let coverage = field.grid.coverage();
        place.rows(field, |_, indices| {
            for index in indices {
                let sample = samples.get(index) as f32;
                let coverage = coverage.map_or(1.0, |coverage| coverage[index]);
                range.has_gaps |= !sample.is_finite() || coverage < THERE;
                if sample.is_finite() && coverage > 0.0 {
                    range.low = range.low.min(sample);
                    range.high = range.high.max(sample);
                }
            }
        });
        range
    }
}

/// Samples along an axis of a brick, at most.
const SIDE: usize = BRICK + 1;

/// Which blocks and cells of a brick show.
fn words_of(field: &Field, place: &Box16, shows: &Shows) -> (u64, Vec<u64>) {
    // The range of each sample, then of the samples at each cell's corners. What has no value
    // has all scalars, and what is not covered has none.
    let mut low = vec![0.0f32; SIDE * SIDE * SIDE];
    let mut high = low.clone();
    let samples = field.grid.samples();
    let coverage = field.grid.coverage();
    let [sx, sy, sz] = place.samples;
    place.rows(field, |row, indices| {
        for (i, index) in indices.enumerate() {
            let sample = samples.get(index) as f32;
            let at = i + sx * row;
            [low[at], high[at]] = match coverage.map(|coverage| coverage[index]) {
                Some(0.0) if shows.fades() => [f32::INFINITY, f32::NEG_INFINITY],
                Some(share) if share < THERE && !shows.fades() => ALL,
                _ if !sample.is_finite() => ALL,
                _ => [sample; 2],
            };
        }
    });
    if !field.fills_cells {
        for step in [1, sx, sx * sy] {
            for i in 0..(sx * sy * sz).saturating_sub(step) {
                low[i] = low[i].min(low[i + step]);
                high[i] = high[i].max(high[i + step]);
            }
        }
    }
    let mut words = vec![0u64; 64];
    let mut blocks = 0;
    for z in 0..place.cells[2] {
        for y in 0..place.cells[1] {
            for x in 0..place.cells[0] {
                let at = x + sx * (y + sy * z);
                let is_gap = low[at] == ALL[0] || high[at] == ALL[1];
                let is_there = match is_gap {
                    true => shows.gaps(),
                    false => shows.range(low[at], high[at]),
                };
                if is_there {
                    let cell = [x as u32, y as u32, z as u32];
                    let block = bit(cell.map(|c| c >> 2));
                    blocks |= 1 << block;
                    words[block as usize] |= 1 << bit(cell);
                }
            }
        }
    }
    (blocks, words)
}

/// The range of what has no value.
const ALL: [f32; 2] = [f32::NEG_INFINITY, f32::INFINITY];
