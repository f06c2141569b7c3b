//! Figures of papers, frames a second against subdivision, from the results that
//! `cargo bench -p tetrascope-benches` has left.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use tetrascope::Algorithm;

use crate::machine;
use crate::plot;

/// What was measured of an algorithm's figures.
#[derive(Debug, Serialize)]
pub struct Measured {
    /// The algorithm's name.
    pub algorithm: &'static str,
    /// What the figures are.
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
    /// What is in it.
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
    /// Boxes an axis and frames a second, ascending.
    pub points: Vec<(u32, f64)>,
}

/// What criterion calls a benchmark; the group is "ALGORITHM/figure 4/VOLUME/LOOK".
#[derive(Deserialize)]
struct Benchmark {
    group_id: String,
    value_str: Option<String>,
}

/// What criterion makes of its times.
#[derive(Deserialize)]
struct Estimates {
    median: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    /// Nanoseconds.
    point_estimate: f64,
}

/// The figures of an algorithm that the last benchmark has measured; none where it was not run.
pub fn measured(algorithm: &Algorithm) -> Option<Measured> {
    let of = |name| std::env::var_os(name).map(PathBuf::from);
    // As criterion chooses it.
    let folder = of("CRITERION_HOME")
        .or_else(|| Some(of("CARGO_TARGET_DIR")?.join("criterion")))
        .unwrap_or_else(|| machine::target().join("criterion"));
    let measured = Measured {
        algorithm: algorithm.name,
        about: algorithm.figures?,
        figures: read(&folder, algorithm.name),
    };
    (!measured.figures.is_empty()).then_some(measured)
}

/// By volume and look; by boxes an axis: frames a second.
type Rates = BTreeMap<(String, String), BTreeMap<u32, f64>>;

fn read(folder: &Path, algorithm: &str) -> Vec<Figure> {
    let mut rates: BTreeMap<String, Rates> = BTreeMap::new();
    for group in folders(folder) {
        for result in folders(&group) {
            if let Some((figure, volume, look, boxes, rate)) = result_of(&result, algorithm) {
                let lines = rates.entry(figure).or_default();
                let line = lines.entry((volume, look)).or_default();
                line.insert(boxes, rate);
            }
        }
    }
    rates
        .into_iter()
        .map(|(name, lines)| figure(name, &lines))
        .collect()
}

/// The folders in a folder, or none.
fn folders(of: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(of) else {
        return Vec::new();
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.filter(|path| path.is_dir()).collect()
}

/// Figure, volume, look, boxes an axis and frames a second, if that is what was measured.
fn result_of(folder: &Path, algorithm: &str) -> Option<(String, String, String, u32, f64)> {
    let read = |name: &str| std::fs::read(folder.join("new").join(name)).ok();
    let benchmark: Benchmark = serde_json::from_slice(&read("benchmark.json")?).ok()?;
    let estimates: Estimates = serde_json::from_slice(&read("estimates.json")?).ok()?;
    let parts: Vec<&str> = benchmark.group_id.split('/').collect();
    let [name, figure, volume, look] = parts[..] else {
        return None;
    };
    let boxes = benchmark.value_str?.parse().ok()?;
    let seconds = estimates.median.point_estimate * 1e-9;
    let is_figure =
        name == algorithm && figure.starts_with("figure ") && seconds > 0.0 && boxes > 0;
    is_figure.then(|| {
        (
            figure.into(),
            volume.into(),
            look.into(),
            boxes,
            seconds.recip(),
        )
    })
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
        let write = |group: &str, value: &str, nanoseconds: f64| {
            let place = folder.path().join(group.replace('/', "_"));
            let place = place.join(value).join("new");
            std::fs::create_dir_all(&place).expect("made");
            let benchmark = format!(r#"{{"group_id":"{group}","value_str":"{value}"}}"#);
            let estimates = format!(r#"{{"median":{{"point_estimate":{nanoseconds}}}}}"#);
            std::fs::write(place.join("benchmark.json"), benchmark).expect("written");
            std::fs::write(place.join("estimates.json"), estimates).expect("written");
        };
        write("slicing/figure 4/aneurism/hides a third", "1", 5e8);
        write("slicing/figure 4/aneurism/hides a third", "16", 1e8);
        write("slicing/figure 4/aneurism/hides a half", "1", 4e8);
        write("slicing/figure 5/tooth/hides a half", "64", 2e9);
        write("slicing/stages/tooth", "cpu", 2e9);
        write("projection/tables/sphere", "3", 2e9);
        write("other/figure 4/aneurism/hides a half", "1", 1e8);
        std::fs::create_dir_all(folder.path().join("report")).expect("made");
        let figures = read(folder.path(), "slicing");
        assert_eq!(figures.len(), 2);
        assert_eq!(figures[0].name, "figure 4");
        let third = &figures[0].lines[1];
        assert_eq!(third.name, "aneurism, hides a third");
        assert_eq!((third.volume, third.look), (0, 1));
        assert_eq!(third.points, [(1, 2.0), (16, 10.0)]);
        assert_eq!(figures[1].lines[0].points, [(64, 0.5)]);
        assert!(figures[0].chart.contains("boxes an axis"));
        assert!(read(&folder.path().join("report"), "slicing").is_empty());
    }
}
