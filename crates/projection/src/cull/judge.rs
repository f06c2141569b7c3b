//! Which cells show, and in how many pieces and parts.

use tetrascope_core::OpticalModel;
use tetrascope_f32::KnotPair;

use super::Judged;

/// The most parts of a piece, which are counted in 8 bits.
pub(super) const MOST_PARTS: u32 = 255;

/// Intervals that a cell may have to be looked at for its parts.
pub(super) const MOST_LOOKED_AT: usize = 64;

/// Up to so many intervals are counted and not bisected, which is faster.
pub(super) const FEW: usize = 32;

/// Cells of which the intervals are counted together.
pub(super) const BLOCK: usize = 256;

/// The judgment of every cell.
#[derive(Debug, PartialEq)]
pub(super) struct Verdicts {
    /// The first and the last interval of its scalars, 16 bits each.
    pub(super) ranges: Vec<u32>,
    /// In what it is drawn.
    pub(super) shares: Vec<Share>,
}

/// In what a cell is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Share {
    /// Its pieces, one for each interval of its scalars; 0 if it is not drawn.
    pub(super) pieces: u16,
    /// The parts of each, for `segment_weights`; more than [`MOST_PARTS`] if that is unknown.
    pub(super) parts: u16,
}

/// Sums over some cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Total {
    pub(super) cells: u32,
    pub(super) pieces: u64,
    pub(super) parts: u64,
    /// Whether the parts of one are unknown.
    pub(super) is_uncounted: bool,
}

impl Total {
    fn add(&mut self, share: Share) {
        self.cells += u32::from(share.pieces > 0);
        self.pieces += u64::from(share.pieces);
        self.parts += u64::from(share.pieces) * u64::from(share.parts);
        self.is_uncounted |= share.pieces > 0 && u32::from(share.parts) > MOST_PARTS;
    }
}

/// How many of so many cells a thread takes.
pub(super) fn chunk(cells: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // Below that a thread costs more than it gains.
    cells.div_ceil(cores).max(1 << 14)
}

/// Does `work` for each of `tasks` in a thread of its own, the last in this one.
pub(super) fn in_threads<T: Send>(mut tasks: Vec<T>, work: impl Fn(T) + Sync) {
    let last = tasks.pop();
    std::thread::scope(|scope| {
        for task in tasks {
            let work = &work;
            scope.spawn(move || work(task));
        }
        last.map(&work);
    });
}

/// An appearance as [`Judge::all`] compares cells with it.
pub(super) struct Judge<'a> {
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
    pub(super) pieces: bool,
}

impl Judge<'_> {
    pub(super) fn new<'a>(judged: &Judged<'a>) -> Judge<'a> {
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
    pub(super) fn all(&self, extents: &[[f32; 2]], longest: &[f32]) -> (Verdicts, Vec<Total>) {
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

    /// The share of a cell whose scalars are in the intervals from `first` to `last`.
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

pub(super) fn shows(model: OpticalModel, [r, g, b, extinction]: [f32; 4]) -> bool {
    match model {
        OpticalModel::MaximumIntensity => r > 0.0 || g > 0.0 || b > 0.0,
        _ => extinction > 0.0,
    }
}

/// As `sample_interval` of `transfer_function.wgsl`.
pub(super) fn sampled(i: &KnotPair, scalar: f32) -> [f32; 4] {
    let to_high = ((scalar - i.low) * i.inverse_width).clamp(0.0, 1.0);
    let to_low = ((i.high - scalar) * i.inverse_width).clamp(0.0, 1.0);
    std::array::from_fn(|n| i.at_low[n] * to_low + i.at_high[n] * to_high)
}
