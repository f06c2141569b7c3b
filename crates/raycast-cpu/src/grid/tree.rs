//! Bricks of cells: the range of scalars in each, and which cells show in an appearance.
//!
//! Three levels: bricks of 16³ cells, blocks of 4³, and cells. A brick has a word with a bit for
//! each of its blocks, which says whether anything shows there, and each block one for its cells.
//! Ranges of bricks are kept from appearance to appearance; cells are looked at only in bricks
//! whose range shows, and bricks in which nothing does have no words. These say how far a ray may
//! leap: for each of the eight octants of directions, the side of the greatest cube of bricks in
//! which nothing shows that begins there.

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
    /// The range of the samples that have a value and are covered; `low > high` where there is none.
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

/// The neighborhood of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Look {
    /// Which cells of its block show; see [`bit`].
    Cells(u64),
    /// Nothing shows in a cube of so many blocks of 2^`shift` cells along each axis.
    Nothing { shift: u32, blocks: u32 },
}

/// The ranges of a grid's bricks, and what of it shows.
#[derive(Clone, Debug)]
pub(crate) struct Tree {
    cells: [u32; 3],
    /// A power of two that is at least 16 and as many as the most cells along an axis.
    side: u32,
    bricks_along: [usize; 3],
    ranges: Vec<Range>,
    bricks: Vec<Brick>,
    /// For each brick, how many bricks a ray of each octant may leap; 0 where something shows.
    leaps: [Vec<u8>; 8],
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
        let count = bricks_along.iter().product::<usize>();
        let range = |index: usize| Range::new(field, &Box16::new(field, bricks_along, index));
        Ok(Tree {
            cells: field.cells.map(|cells| cells as u32),
            side: (most as u32).next_power_of_two().max(16),
            bricks_along,
            ranges: (0..count).into_par_iter().map(range).collect(),
            bricks: Vec::new(),
            leaps: Default::default(),
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
        self.bricks.clear();
        self.words.clear();
        for (blocks, words) in found {
            let mut brick = Brick {
                blocks,
                words: EMPTY,
            };
            if blocks != 0 {
                brick.words = (self.words.len() / 64) as u32;
                self.words.extend(words);
            }
            self.bricks.push(brick);
        }
        let bricks = &self.bricks;
        let octants = self.leaps.par_iter_mut().enumerate();
        octants.for_each(|(octant, leaps)| *leaps = leaps_of(bricks, along, octant));
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

    /// The neighborhood of a cell for a ray of this octant: bit i says that it falls along axis i.
    #[inline(always)]
    pub(crate) fn look(&self, [x, y, z]: [u32; 3], octant: usize) -> Look {
        let brick = [(x >> 4) as usize, (y >> 4) as usize, (z >> 4) as usize];
        let index = index_of(brick, self.bricks_along);
        let brick = self.bricks[index];
        if brick.blocks == 0 {
            return Look::Nothing {
                shift: 4,
                blocks: self.leaps[octant][index].into(),
            };
        }
        let block = bit([x >> 2, y >> 2, z >> 2]);
        match brick.blocks >> block & 1 {
            0 => Look::Nothing {
                shift: 2,
                blocks: 1,
            },
            _ => Look::Cells(self.words[brick.words as usize * 64 + block as usize]),
        }
    }

    /// Bytes of all that is kept.
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = size_of_val(&self.ranges[..])
            + 8 * size_of_val(&self.leaps[0][..])
            + size_of_val(&self.bricks[..])
            + size_of_val(&self.words[..]);
        bytes as u64
    }
}

/// For each brick, the side of the greatest cube of bricks in which nothing shows and of which
/// this is the first on a ray of this octant; at most 255.
///
/// One more than the least side of the seven neighbors ahead. Beyond the grid there is nothing.
fn leaps_of(bricks: &[Brick], along: [usize; 3], octant: usize) -> Vec<u8> {
    let mut leaps = vec![0u8; bricks.len()];
    for step in 0..bricks.len() {
        // From the far end to the near one along each axis.
        let place = places(step, along);
        let place = [0, 1, 2].map(|axis| match octant >> axis & 1 {
            0 => along[axis] - 1 - place[axis],
            _ => place[axis],
        });
        let index = index_of(place, along);
        if bricks[index].blocks != 0 {
            continue;
        }
        let ahead = |neighbor: usize| {
            let mut at = place;
            for axis in (0..3).filter(|axis| neighbor >> axis & 1 == 1) {
                at[axis] = match octant >> axis & 1 {
                    0 => Some(at[axis] + 1).filter(|p| *p < along[axis])?,
                    _ => at[axis].checked_sub(1)?,
                };
            }
            Some(leaps[index_of(at, along)])
        };
        let least = (1..8).map(|n| ahead(n).unwrap_or(u8::MAX)).min();
        leaps[index] = least.unwrap_or(0).saturating_add(1);
    }
    leaps
}

/// The number of a part in its block of 4³, by its coordinates.
#[inline(always)]
pub(crate) fn bit([x, y, z]: [u32; 3]) -> u32 {
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
