//! Figures of papers, frames per second against subdivision, from the results that
//! `cargo bench -p tetrascope-benches` has left.

use std::collections::BTreeMap;

use serde::Serialize;

use tetrascope::Algorithm;
use tetrascope_benches::results;

use crate::dashboard::criterion::{self, Measurement, Results};
use crate::plot;

/// The measurements of an algorithm's figures.
#[derive(Debug, Serialize)]
pub struct Measured {
    /// The algorithm's name.
    pub algorithm: &'static str,
    /// A description of the figures.
    pub about: &'static str,
    /// One at least.
    pub figures: Vec<Figure>,
}

/// Frames a second against subdivision, for one fragment program.
#[derive(Debug, Serialize)]
pub struct Figure {
    /// "figure 4".
    pub name: String,
    /// An SVG.
    pub chart: String,
    /// The lines in it.
    pub lines: Vec<Line>,
}

/// One volume under one transfer function.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// "aneurism, hides a third".
    pub name: String,
    /// Chooses the color.
    pub volume: usize,
    /// Chooses the dashes.
    pub look: usize,
    /// Boxes an axis and frames per second, ascending.
    pub points: Vec<(u32, f64)>,
}

/// The figures of an algorithm that the last benchmark has measured; none where it was not run.
pub fn measured(algorithm: &Algorithm) -> Option<Measured> {
    algorithm.figures?;
    of_results(algorithm, &criterion::read(&results::folder()))
}

/// The figures of an algorithm among results; none where there are none.
pub fn of_results(algorithm: &Algorithm, results: &Results) -> Option<Measured> {
    let measured = Measured {
        algorithm: algorithm.name,
        about: algorithm.figures?,
        figures: figures(results, algorithm.name),
    };
    (!measured.figures.is_empty()).then_some(measured)
}

/// By volume and look; by boxes per axis: frames per second.
type Rates = BTreeMap<(String, String), BTreeMap<u32, f64>>;

fn figures(results: &Results, algorithm: &str) -> Vec<Figure> {
    let mut rates: BTreeMap<String, Rates> = BTreeMap::new();
    for measurement in &results.measurements {
        if let Some((figure, volume, look, boxes, rate)) = result_of(measurement, algorithm) {
            let lines = rates.entry(figure).or_default();
            let line = lines.entry((volume, look)).or_default();
            line.insert(boxes, rate);
        }
    }
    rates
        .into_iter()
        .map(|(name, lines)| figure(name, &lines))
        .collect()
}

/// Figure, volume, look, boxes per axis and frames per second, if that is what was measured: then the
/// group is "ALGORITHM/figure 4/VOLUME/LOOK".
fn result_of(
    measurement: &Measurement,
    algorithm: &str,
) -> Option<(String, String, String, u32, f64)> {
    let parts: Vec<&str> = measurement.group.split('/').collect();
    let [name, figure, volume, look] = parts[..] else {
        return None;
    };
    let boxes = measurement.value.as_deref()?.parse().ok()?;
    let rate = 1e9 / measurement.median.value;
    let is_figure = name == algorithm && figure.starts_with("figure ") && boxes > 0;
    is_figure.then(|| (figure.into(), volume.into(), look.into(), boxes, rate))
}

fn figure(name: String, lines: &Rates) -> Figure {
    let number = |names: Vec<&String>, wanted: &String| {
        names.iter().position(|name| *name == wanted).unwrap_or(0)
    };
    let sorted = |pick: fn(&(String, String)) -> &String| {
        let mut all: Vec<&String> = lines.keys().map(pick).collect();
        all.sort();
        all.dedup();
        all
    };
    let lines: Vec<Line> = lines
        .iter()
        .map(|((volume, look), points)| Line {
            name: format!("{volume}, {look}"),
            volume: number(sorted(|key| &key.0), volume),
            look: number(sorted(|key| &key.1), look),
            points: points.iter().map(|(boxes, rate)| (*boxes, *rate)).collect(),
        })
        .collect();
    Figure {
        name,
        chart: plot::rate_against_boxes(&lines, (720, 400)),
        lines,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Criterion's files as it lays them out, and others beside them.
    #[test]
    fn results_of_criterion_become_figures() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (id, nanoseconds) in [
            ("slicing/figure 4/aneurism/hides a third/1", 5e8),
            ("slicing/figure 4/aneurism/hides a third/16", 1e8),
            ("slicing/figure 4/aneurism/hides a half/1", 4e8),
            ("slicing/figure 5/tooth/hides a half/64", 2e9),
            ("slicing/stages/tooth/cpu", 2e9),
            ("projection/tables/sphere/3", 2e9),
            ("other/figure 4/aneurism/hides a half/1", 1e8),
        ] {
            criterion::tests::write(folder.path(), id, true, nanoseconds);
        }
        let results = criterion::read(folder.path());
        let figures = figures(&results, "slicing");
        assert_eq!(figures.len(), 2);
        assert_eq!(figures[0].name, "figure 4");
        let third = &figures[0].lines[1];
        assert_eq!(third.name, "aneurism, hides a third");
        assert_eq!((third.volume, third.look), (0, 1));
        assert_eq!(third.points, [(1, 2.0), (16, 10.0)]);
        assert_eq!(figures[1].lines[0].points, [(64, 0.5)]);
        assert!(figures[0].chart.contains("boxes an axis"));
        assert!(super::figures(&results, "raycast-peel").is_empty());
    }
}
