//! Statistics of the times of two programs in rounds in turn.

use std::collections::{BTreeMap, BTreeSet};

use crate::dashboard::history::Verdict;

/// Medians by benchmark: of the base, then of the working tree.
pub type Round = [BTreeMap<String, f64>; 2];

/// The distance from 1 that a ratio may have and still be noise, whatever its interval: runs in turn share
/// what slows the machine, but not where memory of a program happens to lie.
pub const NOISE: f64 = 0.03;

/// A benchmark's time in the working tree, in units of that in the base.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The benchmark.
    pub id: String,
    /// The geometric mean over the rounds.
    pub ratio: f64,
    /// The interval in which the ratio is with a confidence of 95 %.
    pub interval: (f64, f64),
    /// Rounds in which both ran.
    pub rounds: usize,
}

impl Comparison {
    /// Whether the ratio is beyond noise: 1 is not in its interval, and it is farther from 1 than
    /// [`NOISE`].
    pub fn verdict(&self) -> Verdict {
        let (low, high) = self.interval;
        if low > 1.0 && self.ratio > 1.0 + NOISE {
            Verdict::Slower
        } else if high < 1.0 && self.ratio < 1.0 / (1.0 + NOISE) {
            Verdict::Faster
        } else {
            Verdict::Within
        }
    }

    /// Whether the working tree is slower.
    pub fn is_slower(&self) -> bool {
        self.verdict() == Verdict::Slower
    }
}

/// All benchmarks that both have run in two rounds at least, by id.
pub fn compare(rounds: &[Round]) -> Vec<Comparison> {
    let mut logarithms: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for [base, new] in rounds {
        for (id, before) in base {
            if let Some(after) = new.get(id) {
                logarithms
                    .entry(id)
                    .or_default()
                    .push((after / before).ln());
            }
        }
    }
    let several = logarithms.into_iter().filter(|(_, logs)| logs.len() > 1);
    several.map(|(id, logs)| of_logarithms(id, &logs)).collect()
}

/// Times of one program scatter by factors, so logarithms of ratios are taken as normal: their mean
/// has a Student's t interval.
fn of_logarithms(id: &str, logarithms: &[f64]) -> Comparison {
    let n = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / n;
    let squares: f64 = logarithms.iter().map(|x| (x - mean).powi(2)).sum();
    let error = (squares / (n - 1.0) / n).sqrt();
    let reach = quantile(logarithms.len() - 1) * error;
    Comparison {
        id: id.into(),
        ratio: mean.exp(),
        interval: ((mean - reach).exp(), (mean + reach).exp()),
        rounds: logarithms.len(),
    }
}

/// 97.5 % of Student's t distribution are below this, by degrees of freedom (every table of it has
/// these); beyond the table, the last one, which is a little more than the limit of 1.960.
fn quantile(freedom: usize) -> f64 {
    const TABLE: [f64; 30] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
        2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
        2.052, 2.048, 2.045, 2.042,
    ];
    TABLE[(freedom - 1).min(TABLE.len() - 1)]
}

/// Benchmarks that only one side has.
pub fn alone(rounds: &[Round], side: usize) -> Vec<String> {
    let ids = |side: usize| -> BTreeSet<&String> {
        rounds.iter().flat_map(|round| round[side].keys()).collect()
    };
    let alone = ids(side);
    alone
        .difference(&ids(1 - side))
        .map(|id| (*id).clone())
        .collect()
}

/// The comparisons as a table for a terminal.
pub fn table(comparisons: &[Comparison]) -> String {
    let widths = comparisons.iter().map(|c| c.id.chars().count());
    let width = widths.max().unwrap_or(0).max("benchmark".len());
    let mut table = format!(
        "{:<width$}  {:>6}  {:>16}  verdict\n",
        "benchmark", "ratio", "95 % interval"
    );
    for c in comparisons {
        let (low, high) = c.interval;
        let verdict = match c.verdict() {
            Verdict::Slower => "slower",
            Verdict::Faster => "faster",
            Verdict::Within => "within noise",
        };
        table += &format!(
            "{:<width$}  {:>6.3}  {:>16}  {verdict}\n",
            c.id,
            c.ratio,
            format!("{low:.3} to {high:.3}")
        );
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounds in which the base takes the first and the working tree the second of each pair.
    fn rounds(id: &str, times: &[(f64, f64)]) -> Vec<Round> {
        let of = |time| BTreeMap::from([(id.to_owned(), time)]);
        times
            .iter()
            .map(|&(base, new)| [of(base), of(new)])
            .collect()
    }

    fn verdict(times: &[(f64, f64)]) -> Verdict {
        compare(&rounds("a", times))[0].verdict()
    }

    #[test]
    fn the_ratio_is_the_geometric_mean_with_its_interval() {
        let found = &compare(&rounds("a", &[(1.0, 2.0), (1.0, 8.0)]))[0];
        assert!((found.ratio - 4.0).abs() < 1e-12);
        // The logarithms are ln 4 ± ln 2: their mean has an error of ln 2, and t is 12.706.
        let reach = 2f64.powf(12.706);
        assert!((found.interval.1 / (4.0 * reach) - 1.0).abs() < 1e-12);
        assert!((found.interval.0 * reach / 4.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_slows_both_alike_is_no_change() {
        assert_eq!(
            verdict(&[(1.0, 1.0), (3.0, 3.0), (2.0, 2.0)]),
            Verdict::Within
        );
        // Each round is twice as slow as the one before, the working tree by a fifth more.
        let drifting = [(1.0, 1.2), (2.0, 2.42), (4.0, 4.78), (8.0, 9.6)];
        assert_eq!(verdict(&drifting), Verdict::Slower);
        let turned = drifting.map(|(base, new)| (new, base));
        assert_eq!(verdict(&turned), Verdict::Faster);
    }

    #[test]
    fn what_scatters_or_is_small_is_noise() {
        // A fifth slower on average, and once faster by as much.
        assert_eq!(
            verdict(&[(1.0, 1.5), (1.0, 0.8), (1.0, 1.4), (1.0, 1.1)]),
            Verdict::Within
        );
        // Always slower, and by two percent.
        assert_eq!(
            verdict(&[(1.0, 1.02), (1.0, 1.021), (1.0, 1.019)]),
            Verdict::Within
        );
    }

    #[test]
    fn benchmarks_of_one_side_or_one_round_are_not_compared() {
        let mut two = rounds("both", &[(1.0, 1.0), (1.0, 1.0)]);
        two[0][0].insert("gone".into(), 1.0);
        two[1][1].insert("added".into(), 1.0);
        two[0][0].insert("once".into(), 1.0);
        two[0][1].insert("once".into(), 1.0);
        let found = compare(&two);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].id.as_str(), found[0].rounds), ("both", 2));
        assert_eq!(
            (alone(&two, 0), alone(&two, 1)),
            (vec!["gone".into()], vec!["added".into()])
        );
        let table = table(&found);
        assert!(
            table.contains("both") && table.contains("within noise"),
            "{table}"
        );
    }
}
