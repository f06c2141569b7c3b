//! How the values of a field are spread, and the range and the background that follow.
//!
//! A color map from the least to the greatest value shows nothing where one sample in a
//! thousand is 1e7 and all others lie in 0…250, where absent samples hold −32768, or where
//! the air around an object has a value in the middle. [`Distribution::choose`] finds these
//! three and leaves all other fields alone.

use tetrascope_core::grid::GridStream;
use tetrascope_core::mesh::Association;
use tetrascope_core::pick::{MOST_PICKED, pick_samples, picks};
use tetrascope_core::{Grid, TetMesh, Volume, number};

/// Fewer values say nothing about how they are spread.
const FEWEST_VALUES: f64 = 32.0;

/// A first or last value is far from all others if the gap to the next one is more than
/// this part of the whole range. −32768 beside 0…4095 is, 0 beside 200…255 is not.
const FAR: f64 = 0.8;

/// The same beyond a gap this many times as wide as the range of all other values.
const VERY_FAR: f64 = 100.0;

/// The least part of all values that is an object of its own, be it far from the others: a
/// smaller one is an outlier, as are one or two values.
const OBJECT: f64 = 5e-3;

/// Programs that write a number for "no value" write one as far from 0 as this: −999,
/// −9999, −32768, 9999, 65535, 1e36.
const MARK: (f64, f64) = (-999.0, 9999.0);

/// The part of all values that may lie beyond the middle ones at each end: 1 of 1000, but
/// up to two values.
const TAIL: f64 = 1e-3;

/// The middle values have a range of their own if it is a smaller part of the whole range.
const NARROW: f64 = 0.1;

/// Half of the volume is background if its values span at most this part of the range.
const BACKGROUND: f64 = 0.05;

/// A background is in the way if, with opacity that rises from the low end of the range, a
/// ray through the volume would find this much opacity in it alone.
const IN_THE_WAY: f64 = 0.3;

/// From the shortest interval that holds half of a normal distribution, ±0.674 standard
/// deviations, to ±3 of them.
const NOISE: f64 = 4.45;

/// Distinct values with how often they occur and what they fill.
#[derive(Clone, Debug)]
pub(crate) struct Distribution {
    /// By increasing value; finite.
    shares: Vec<Share>,
    /// Whether all values were looked at.
    complete: bool,
}

/// One value's part of a field.
#[derive(Clone, Copy, Debug)]
struct Share {
    value: f64,
    /// Samples, points or cells.
    count: f64,
    /// In any unit.
    volume: f64,
}

/// The result of [`Distribution::choose`].
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    /// The scalars to tell apart.
    pub(crate) range: (f64, f64),
    /// Whether `range` is that of all values; else, in words, what it leaves out.
    pub(crate) left_out: Option<String>,
    /// Whether values below the range stand for no value.
    pub(crate) clear_below: bool,
    /// Whether values above the range stand for no value.
    pub(crate) clear_above: bool,
    /// Values that fill most of the volume, and the part of it that they fill.
    pub(crate) background: Option<((f64, f64), f64)>,
}

impl Distribution {
    /// That of the finite values of `volume`; empty without any.
    pub(crate) fn of(volume: &Volume) -> Distribution {
        let mut distribution = match volume {
            Volume::Mesh(mesh) => Distribution::of_mesh(mesh),
            Volume::Grid(grid) => Distribution::of_grid(grid),
            Volume::Stream(stream) => Distribution::of_stream(stream),
            Volume::Clusters(clusters) => {
                Distribution::of_samples(clusters.source().picked(), usize::MAX)
            }
            // Nothing is known of another kind but its range.
            _ => Distribution::new(Vec::new(), false),
        };
        if let Some((low, high)) = volume.scalar_range() {
            distribution.reach(low);
            distribution.reach(high);
        }
        distribution
    }

    fn of_grid(grid: &Grid) -> Distribution {
        let mut total = grid.samples().len();
        let mut picked = Vec::with_capacity(total.min(MOST_PICKED + 1));
        match grid.coverage() {
            None => pick_samples(grid.samples(), 0, total, &mut picked),
            // Of what is there alone.
            Some(coverage) => {
                let covered = picks(0..total, total).filter(|i| coverage[*i] > 0.0);
                picked.extend(covered.map(|i| grid.samples().get(i)));
                if total <= MOST_PICKED {
                    total = picked.len();
                }
            }
        }
        Distribution::of_samples(&picked, total)
    }

    fn of_stream(stream: &GridStream) -> Distribution {
        let total = stream.source().lattice().dims.iter().product();
        Distribution::of_samples(stream.picked(), total)
    }

    fn of_samples(picked: &[f64], total: usize) -> Distribution {
        let share = |&value: &f64| Share {
            value,
            count: 1.0,
            volume: 1.0,
        };
        Distribution::new(picked.iter().map(share).collect(), picked.len() == total)
    }

    /// Values at points count once each and fill a quarter of each cell around them; values
    /// in cells fill their cell.
    fn of_mesh(mesh: &TetMesh) -> Distribution {
        let scale = mesh.bounds().diagonal().recip();
        let volume = |cell: usize| {
            let [a, b, c, d] = mesh.cell_points(cell).map(|p| p * scale);
            let volume = (b - a).dot((c - a).cross(d - a)).abs();
            if volume.is_finite() { volume } else { 0.0 }
        };
        let (count, shares) = match mesh.scalars().association {
            Association::Cell => {
                let count = mesh.cell_count();
                let share = |cell| Share {
                    value: mesh.cell_scalars(cell)[0],
                    count: 1.0,
                    volume: volume(cell),
                };
                (count, picks(0..count, count).map(share).collect())
            }
            Association::Point => {
                let mut filled: Vec<Option<f64>> = vec![None; mesh.points().len()];
                for (cell, corners) in mesh.tetrahedra().iter().enumerate() {
                    let quarter = volume(cell) / 4.0;
                    for &point in corners {
                        *filled[point as usize].get_or_insert(0.0) += quarter;
                    }
                }
                let count = filled.len();
                let share = |point: usize| {
                    Some(Share {
                        value: mesh.scalars().values[point],
                        count: 1.0,
                        volume: filled[point]?,
                    })
                };
                (count, picks(0..count, count).filter_map(share).collect())
            }
        };
        Distribution::new(shares, count <= MOST_PICKED)
    }

    fn new(mut shares: Vec<Share>, complete: bool) -> Distribution {
        shares.retain(|share| share.value.is_finite());
        shares.sort_by(|a, b| a.value.total_cmp(&b.value));
        shares.dedup_by(|next, kept| {
            let same = next.value == kept.value;
            if same {
                kept.count += next.count;
                kept.volume += next.volume;
            }
            same
        });
        Distribution { shares, complete }
    }

    /// That of nothing.
    pub(crate) fn empty() -> Distribution {
        Distribution::new(Vec::new(), true)
    }

    /// Adds the values of another volume, as if it were a part of this one.
    pub(crate) fn add(&mut self, other: Distribution) {
        let mut shares = std::mem::take(&mut self.shares);
        shares.extend(other.shares);
        *self = Distribution::new(shares, self.complete && other.complete);
        while self.shares.len() > MOST_PICKED {
            self.coarsen();
        }
    }

    /// Values by increasing order, with how often each occurs.
    pub(crate) fn counts(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.shares.iter().map(|share| (share.value, share.count))
    }

    /// Whether all values were looked at.
    pub(crate) fn is_complete(&self) -> bool {
        self.complete
    }

    /// How many distinct values are kept.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.shares.len()
    }

    /// Joins neighbors that are nearer than most: what is far from all others stays so, and
    /// the least and the greatest value are kept.
    fn coarsen(&mut self) {
        let gap = |pair: &[Share]| half_gap(pair[0].value, pair[1].value);
        let mut gaps: Vec<f64> = self.shares.windows(2).map(gap).collect();
        let middle = gaps.len() / 2;
        let (_, median, _) = gaps.select_nth_unstable_by(middle, f64::total_cmp);
        let (median, last) = (*median, self.shares.len() - 1);
        let mut joined: Vec<Share> = Vec::with_capacity(self.shares.len());
        let mut is_joined = false;
        for (i, share) in self.shares.iter().enumerate() {
            match joined.last_mut() {
                Some(before) if !is_joined && half_gap(before.value, share.value) <= median => {
                    before.count += share.count;
                    before.volume += share.volume;
                    if i == last {
                        before.value = share.value;
                    }
                    is_joined = true;
                }
                _ => {
                    joined.push(*share);
                    is_joined = false;
                }
            }
        }
        self.shares = joined;
        self.complete = false;
    }

    /// Adds a value that was not among those looked at.
    fn reach(&mut self, value: f64) {
        let place = self.shares.partition_point(|share| share.value < value);
        if self.shares.get(place).is_none_or(|s| s.value != value) {
            let share = Share {
                value,
                count: 1.0,
                volume: 0.0,
            };
            self.shares.insert(place, share);
        }
    }

    /// The range and the background for a first picture; `None` without a finite value.
    ///
    /// A ray crosses `depth` unit distances in the mean.
    pub(crate) fn choose(&self, depth: f64) -> Option<Choice> {
        let (first, last) = (self.shares.first()?, self.shares.last()?);
        let mut choice = Choice {
            range: (first.value, last.value),
            left_out: None,
            clear_below: false,
            clear_above: false,
            background: None,
        };
        if count(&self.shares) < FEWEST_VALUES {
            return Some(choice);
        }
        let kept = without_marks(&self.shares, &mut choice);
        let whole = (kept[0].value, kept[kept.len() - 1].value);
        choice.range = whole;
        if let Some(middle) = middle(kept)
            && half_gap(middle.0, middle.1) < NARROW * half_gap(whole.0, whole.1)
        {
            let reach = middle.1 - middle.0;
            let near =
                |share: &&Share| share.value >= middle.0 - reach && share.value <= middle.1 + reach;
            let mut inside = kept.iter().filter(near).map(|share| share.value);
            let low = inside.next().unwrap_or(middle.0);
            choice.range = (low, inside.next_back().unwrap_or(middle.1).max(middle.1));
        }
        self.find_background(kept, depth, &mut choice);
        choice.left_out = self.left_out(choice.range);
        Some(choice)
    }

    /// The mean of `measure` over the volume.
    pub(crate) fn mean(&self, measure: impl Fn(f64) -> f64) -> f64 {
        let all: f64 = self.shares.iter().map(|share| share.volume).sum();
        let shares = self.shares.iter();
        let sum: f64 = shares.map(|s| s.volume * measure(s.value)).sum();
        sum / all
    }

    /// Finds what fills most of the volume, if it is in the way of what is in it.
    fn find_background(&self, kept: &[Share], depth: f64, choice: &mut Choice) {
        let (low, high) = choice.range;
        let Some((from, to)) = shortest_half(kept) else {
            return;
        };
        let middle = from * 0.5 + to * 0.5;
        let place = half_gap(low, middle) / half_gap(low, high);
        let is_in_the_way = 1.0 - (1.0 - place).powf(depth) > IN_THE_WAY;
        if middle > high {
            choice.clear_above = true;
        } else if middle < low {
            choice.clear_below = true;
        } else if half_gap(from, to) <= BACKGROUND * half_gap(low, high) && is_in_the_way {
            let reach = (to - from) / 2.0 * NOISE;
            let band = ((middle - reach).max(low), (middle + reach).min(high));
            let inside = |share: &&Share| share.value >= band.0 && share.value <= band.1;
            let filled: f64 = kept.iter().filter(inside).map(|share| share.volume).sum();
            let all: f64 = self.shares.iter().map(|share| share.volume).sum();
            choice.background = Some((band, filled / all));
        }
    }

    /// How many values lie outside of `range`, in words.
    fn left_out(&self, range: (f64, f64)) -> Option<String> {
        let inside = |share: &&Share| share.value >= range.0 && share.value <= range.1;
        let inside: f64 = self.shares.iter().filter(inside).map(|s| s.count).sum();
        let all = count(&self.shares);
        (inside < all).then(|| {
            if self.complete {
                format!("{} of {all} values", all - inside)
            } else {
                let percent = number::rounded(100.0 * (all - inside) / all);
                format!("about {percent} % of all values")
            }
        })
    }
}

fn count(shares: &[Share]) -> f64 {
    shares.iter().map(|share| share.count).sum()
}

/// Half the way from `a` to `b`, which is finite whatever they are.
fn half_gap(a: f64, b: f64) -> f64 {
    b * 0.5 - a * 0.5
}

/// The values without first and last ones that are far from all others and outliers or
/// marks for "no value". At least three are left: what is beside two labels may be a third.
fn without_marks<'a>(mut kept: &'a [Share], choice: &mut Choice) -> &'a [Share] {
    let few = (OBJECT * count(kept)).max(2.0);
    while let [first, second, .., last_but_one, last] = kept {
        let width = half_gap(first.value, last.value);
        // Without both: there may be marks at both ends.
        let inner = half_gap(second.value, last_but_one.value);
        let is_far = |gap: f64| gap > FAR * width || gap > VERY_FAR * inner;
        let below = half_gap(first.value, second.value);
        let above = half_gap(last_but_one.value, last.value);
        if is_far(below) && (first.count <= few || first.value <= MARK.0) {
            choice.clear_below = true;
            kept = &kept[1..];
        } else if is_far(above) && (last.count <= few || last.value >= MARK.1) {
            // One sample may be a peak, which is to be seen.
            let others = half_gap(first.value, last_but_one.value);
            let is_mark = last.value >= MARK.1 && above > VERY_FAR * others;
            choice.clear_above |= last.count > 1.0 && is_mark;
            kept = &kept[..kept.len() - 1];
        } else {
            break;
        }
    }
    kept
}

/// The range of all values but [`TAIL`] at each end. Where that is a single value, which
/// most samples share, the same of the others.
fn middle(shares: &[Share]) -> Option<(f64, f64)> {
    let found = between_tails(shares)?;
    if found.0 < found.1 {
        return Some(found);
    }
    let others: Vec<Share> = shares
        .iter()
        .copied()
        .filter(|s| s.value != found.0)
        .collect();
    between_tails(&others).filter(|(low, high)| low < high)
}

fn between_tails(shares: &[Share]) -> Option<(f64, f64)> {
    let all = count(shares);
    if all < FEWEST_VALUES {
        return None;
    }
    let tail = (TAIL * all).max(2.0);
    fn after<'a>(tail: f64, shares: impl Iterator<Item = &'a Share>) -> Option<f64> {
        let mut passed = 0.0;
        for share in shares {
            passed += share.count;
            if passed > tail {
                return Some(share.value);
            }
        }
        None
    }
    Some((
        after(tail, shares.iter())?,
        after(tail, shares.iter().rev())?,
    ))
}

/// The shortest interval whose values fill half of the volume.
fn shortest_half(shares: &[Share]) -> Option<(f64, f64)> {
    let all: f64 = shares.iter().map(|share| share.volume).sum();
    if all <= 0.0 || all.is_nan() {
        return None;
    }
    let mut best: Option<(f64, f64)> = None;
    let (mut filled, mut begin) = (0.0, 0);
    for share in shares {
        filled += share.volume;
        while filled - shares[begin].volume >= all / 2.0 {
            filled -= shares[begin].volume;
            begin += 1;
        }
        let (from, to) = (shares[begin].value, share.value);
        if filled >= all / 2.0 && best.is_none_or(|(a, b)| half_gap(from, to) < half_gap(a, b)) {
            best = Some((from, to));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use tetrascope_core::glam::{DMat3, DVec3};
    use tetrascope_core::grid::Samples;

    use super::*;
    use tetrascope_core::Scalars;

    fn distribution(values: impl IntoIterator<Item = f64>) -> Distribution {
        let picked: Vec<f64> = values.into_iter().collect();
        Distribution::of_samples(&picked, picked.len())
    }

    fn choose(values: impl IntoIterator<Item = f64>) -> Choice {
        distribution(values).choose(10.0).expect("finite values")
    }

    /// `count` values evenly from `low` to `high`.
    fn ramp(count: usize, low: f64, high: f64) -> impl Iterator<Item = f64> {
        (0..count).map(move |i| low + (high - low) * i as f64 / (count - 1) as f64)
    }

    #[test]
    fn ordinary_fields_keep_their_range() {
        let bell = (0..1000).map(|i| {
            let x = (f64::from(i) + 0.5) / 1000.0;
            (x / (1.0 - x)).ln() // the logistic distribution
        });
        let exponential = (0..100_000).map(|i| -(-(f64::from(i) + 0.5) / 1e5).ln_1p());
        let binary = (0..100).map(|i| f64::from(i % 2) * 255.0);
        let zeros = std::iter::repeat_n(0.0, 5000).chain(ramp(50, 10.0, 20.0));
        for values in [
            ramp(1000, -3.0, 5.0).collect::<Vec<f64>>(),
            bell.collect(),
            exponential.collect(),
            binary.collect(),
            zeros.collect(),
            vec![7.0; 100],
            vec![1.0, 2.0, 1e9],
        ] {
            let [low, high] =
                [f64::min, f64::max].map(|f| values.iter().copied().reduce(f).expect("values"));
            let choice = choose(values);
            assert_eq!(choice.range, (low, high));
            assert_eq!(choice.left_out, None);
            assert_eq!(choice.background, None);
            assert!(!choice.clear_below && !choice.clear_above);
        }
        assert_eq!(distribution([f64::NAN]).choose(1.0), None);
    }

    #[test]
    fn one_outlier_is_left_out() {
        for outlier in [1e7, -1e7] {
            let choice = choose(ramp(959, 0.0, 250.0).chain([outlier]));
            assert_eq!(choice.range, (0.0, 250.0));
            assert_eq!(choice.left_out.as_deref(), Some("1 of 960 values"));
            assert!(!choice.clear_above, "a peak is drawn");
        }
    }

    #[test]
    fn padding_below_and_marks_above_are_clear() {
        let padded = std::iter::repeat_n(-32768.0, 600).chain(ramp(500, -1000.0, 3000.0));
        let choice = choose(padded);
        assert_eq!(choice.range, (-1000.0, 3000.0));
        assert!(choice.clear_below && !choice.clear_above);
        assert_eq!(choice.left_out.as_deref(), Some("600 of 1100 values"));
        for mark in [9999.0, 1e36, f64::MAX] {
            let choice = choose(std::iter::repeat_n(mark, 900).chain(ramp(500, 273.0, 310.0)));
            assert_eq!(choice.range, (273.0, 310.0), "{mark}");
            assert!(choice.clear_above && !choice.clear_below, "{mark}");
        }
        // A part of the volume is no mark for having a value far from all others'.
        let noise = || ramp(3000, -0.01, 0.01);
        let choice = choose(noise().chain([4.0; 100]).chain([-4.0; 100]));
        assert_eq!(choice.range, (-4.0, 4.0));
        assert!(choice.background.is_some() && choice.left_out.is_none());
        // Both at once.
        let both = [-f64::MAX, f64::MAX, -f64::MAX, f64::MAX];
        let choice = choose(ramp(100, 0.0, 1.0).chain(both));
        assert_eq!(choice.range, (0.0, 1.0));
        assert!(choice.clear_above && choice.clear_below);
    }

    // 1e6 values of which 20 are spread over five decades above: no gap, but no picture.
    #[test]
    fn a_tail_that_holds_the_range_is_left_out() {
        let tail = (0..20).map(|i| 10f64.powf(3.0 + 0.2 * f64::from(i)));
        let choice = choose(ramp(99_980, 0.0, 250.0).chain(tail));
        assert_eq!(choice.range, (0.0, 250.0));
        assert_eq!(choice.left_out.as_deref(), Some("20 of 100000 values"));
        // The same behind a value that all but 0.1 % share.
        let zeros = std::iter::repeat_n(0.0, 1_000_000);
        let choice = choose(zeros.chain(ramp(900, 100.0, 250.0)).chain([1e6, 3e6]));
        assert_eq!(choice.range, (0.0, 250.0));
    }

    #[test]
    fn what_fills_most_of_the_volume_is_found() {
        // A signed map.
        let map = std::iter::repeat_n(0.0, 4000).chain(ramp(97, -4.0, 4.0));
        let choice = choose(map);
        assert_eq!(choice.range, (-4.0, 4.0));
        let ((low, high), filled) = choice.background.expect("zeros");
        assert_eq!((low, high), (0.0, 0.0));
        assert!((filled - 4001.0 / 4097.0).abs() < 1e-12);
        // Noisy air in the middle: ±3 standard deviations of 3 around 76.
        let noise = (0..700).map(|i| {
            let x = (f64::from(i) + 0.5) / 700.0;
            76.0 + 3.0 * 0.5513 * (x / (1.0 - x)).ln() // logistic, of that deviation
        });
        let choice = choose(noise.chain(ramp(300, 0.0, 255.0)));
        let ((low, high), _) = choice.background.expect("air");
        assert!((60.0..70.0).contains(&low), "{low}");
        assert!((82.0..92.0).contains(&high), "{high}");
        // At the low end the ramp is clear already.
        let air = std::iter::repeat_n(3.0, 900).chain(ramp(300, 0.0, 255.0));
        assert_eq!(choose(air).background, None);
        // A little above it, in a thin volume.
        let air = || std::iter::repeat_n(40.0, 900).chain(ramp(300, 0.0, 255.0));
        let background = |depth| {
            distribution(air())
                .choose(depth)
                .expect("finite")
                .background
        };
        assert!(background(1.0).is_none() && background(10.0).is_some());
    }

    #[test]
    fn of_many_samples_some_are_looked_at_and_the_extremes_always() {
        let n = 4 * 800_001;
        let mut samples: Vec<f32> = (0..n).map(|i| (i % 1000) as f32).collect();
        samples[n / 2] = 1e9;
        let mut picked = Vec::new();
        pick_samples(&Samples::F32(samples.clone()), 0, n, &mut picked);
        assert!(picked.len() <= MOST_PICKED && picked.len() > MOST_PICKED / 2);
        // Part by part the same are picked.
        let mut parts = Vec::new();
        for start in (0..n).step_by(n / 7) {
            let part = samples[start..n.min(start + n / 7)].to_vec();
            pick_samples(&Samples::F32(part), start, n, &mut parts);
        }
        assert_eq!(picked, parts);
        let samples = Samples::F32(samples);
        let [origin, spacing] = [DVec3::ZERO, DVec3::ONE];
        let grid = Grid::new([n / 4, 2, 2], origin, spacing, DMat3::IDENTITY, samples);
        let grid = grid.expect("valid");
        let stream = GridStream::new(Arc::new(grid.clone())).expect("read");
        for volume in [Volume::Grid(grid), Volume::Stream(stream)] {
            let choice = Distribution::of(&volume).choose(10.0).expect("finite");
            assert_eq!(choice.range, (0.0, 999.0));
            assert!(
                choice
                    .left_out
                    .expect("a part")
                    .ends_with("% of all values")
            );
        }
    }

    // A fine cell holds nearly all points, and a coarse one nearly all volume.
    #[test]
    fn background_is_a_matter_of_volume() {
        let mut points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mut cells = vec![[0, 1, 2, 3]];
        let mut values = vec![5.0; 4];
        for i in 0..30_u32 {
            let origin = DVec3::splat(2.0 + f64::from(i));
            points.extend([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| origin + p * 1e-3));
            cells.push([0, 1, 2, 3].map(|p| 4 + 4 * i + p));
            values.extend([f64::from(i) / 2.9; 4]);
        }
        let cell_values = values.iter().copied().step_by(4).chain([0.0; 2]).collect();
        // Enough values to say something: two more of the small cells.
        for i in 30..32_u32 {
            let origin = DVec3::splat(2.0 + f64::from(i));
            points.extend([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|p| origin + p * 1e-3));
            cells.push([0, 1, 2, 3].map(|p| 4 + 4 * i + p));
            values.extend([0.0; 4]);
        }
        for (association, values) in [
            (Association::Point, values),
            (Association::Cell, cell_values),
        ] {
            let scalars = Scalars {
                name: "s".into(),
                association,
                values,
            };
            let mesh = TetMesh::from_tetrahedra(points.clone(), cells.clone(), scalars);
            let volume = Volume::Mesh(mesh.expect("valid"));
            let choice = Distribution::of(&volume).choose(10.0).expect("finite");
            assert_eq!(choice.range, (0.0, 10.0));
            let (band, filled) = choice.background.expect("the large cell");
            assert_eq!(band, (5.0, 5.0));
            assert!(filled > 0.999, "{filled}");
        }
    }
}
