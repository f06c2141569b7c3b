//! The papers' tables: what they print beside what was measured here.

use serde::Serialize;
use tetrascope_benches::papers::{Column, Paper, Quantity, Row, is_of, papers};

use super::criterion::{Measurement, Results};
use super::page::short;
use crate::figures;

/// A paper with its tables.
#[derive(Debug, Serialize)]
pub struct ShownPaper {
    /// The algorithm's name.
    pub algorithm: &'static str,
    /// Authors and year.
    pub name: &'static str,
    /// A note on what is not printed or not measured.
    pub note: &'static str,
    /// All tables.
    pub tables: Vec<ShownTable>,
    /// Figures without numbers, as they were measured here: names and SVGs.
    pub figures: Vec<(String, String)>,
    /// A description of these figures.
    pub about_figures: &'static str,
    /// The figures' lines.
    pub legend: Vec<String>,
}

/// A table.
#[derive(Debug, Serialize)]
pub struct ShownTable {
    /// "table 1".
    pub name: &'static str,
    /// The caption.
    pub about: &'static str,
    /// The paper's hardware.
    pub hardware: &'static str,
    /// A note on what differs here.
    pub note: &'static str,
    /// Heads of the columns.
    pub columns: Vec<&'static str>,
    /// Each row's name, and for each column what the paper prints and what was measured.
    pub rows: Vec<(String, Vec<[String; 2]>)>,
}

/// All papers beside `results`.
pub fn shown(results: &Results) -> Vec<ShownPaper> {
    papers()
        .into_iter()
        .map(|paper| one(paper, results))
        .collect()
}

fn one(paper: Paper, results: &Results) -> ShownPaper {
    let algorithm = tetrascope::algorithm(paper.algorithm).expect("papers are of algorithms");
    let measured = figures::of_results(algorithm, results);
    let (about_figures, figures) = measured.map_or(("", Vec::new()), |m| (m.about, m.figures));
    let lines = figures.first().map_or(&[][..], |figure| &figure.lines);
    ShownPaper {
        algorithm: paper.algorithm,
        name: paper.name,
        note: paper.note,
        about_figures,
        legend: lines.iter().map(|line| line.name.clone()).collect(),
        figures: figures.into_iter().map(|f| (f.name, f.chart)).collect(),
        tables: paper
            .tables
            .into_iter()
            .map(|table| ShownTable {
                name: table.name,
                about: table.about,
                hardware: table.hardware,
                note: table.note,
                columns: table.columns.iter().map(|column| column.name).collect(),
                rows: table
                    .rows
                    .iter()
                    .map(|row| (row.name.clone(), cells(row, &table.columns, results)))
                    .collect(),
            })
            .collect(),
    }
}

/// The printed and the measured numbers, in words, for each column.
fn cells(row: &Row, columns: &[Column], results: &Results) -> Vec<[String; 2]> {
    let cells = columns.iter().enumerate().map(|(i, column)| {
        let printed = row.printed.get(i).copied();
        let words = |range: Option<(f64, f64)>, number: fn(f64) -> String| {
            range.map_or("–".into(), |(low, high)| words(number(low), number(high)))
        };
        let measured = measured(row, column, results);
        [
            words(printed, |number| number.to_string()),
            words(measured, short),
        ]
    });
    cells.collect()
}

fn words(low: String, high: String) -> String {
    match low == high {
        true => low,
        false => format!("{low} to {high}"),
    }
}

/// The least and the greatest number of a row and column; `None` where nothing was measured.
fn measured(row: &Row, column: &Column, results: &Results) -> Option<(f64, f64)> {
    let here = |column: &Column| {
        let all = results.measurements.iter();
        all.filter(|m| is_of(row, column, &m.id))
            .collect::<Vec<_>>()
    };
    let numbers: Vec<f64> = match column.quantity {
        Quantity::Counted => {
            let counted = results.counted.iter().filter(|(id, _)| {
                let ends = [" least", " most"].into_iter();
                let mut ids = ends.filter_map(|end| id.strip_suffix(end));
                ids.any(|id| is_of(row, column, id))
            });
            counted.map(|(_, value)| *value).collect()
        }
        Quantity::GainOver(base) => {
            let base = Column {
                function: base,
                ..column.clone()
            };
            let base = here(&base).first()?.median.value;
            let all = here(column).into_iter();
            all.map(|m| 100.0 * (base / m.median.value - 1.0)).collect()
        }
        quantity => {
            let all = here(column).into_iter();
            all.filter_map(|m| number(quantity, m)).collect()
        }
    };
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = numbers.iter().fold(ends, |(low, high), &number| {
        (low.min(number), high.max(number))
    });
    (!numbers.is_empty()).then_some((low, high))
}

fn number(quantity: Quantity, measurement: &Measurement) -> Option<f64> {
    let seconds = measurement.median.value / 1e9;
    Some(match quantity {
        Quantity::Rate(frames) => frames / seconds,
        Quantity::KiloCells(frames) => cells_of(measurement)? * frames / seconds / 1e3,
        Quantity::Megabytes(bytes) => cells_of(measurement)? * bytes / seconds / 1e6,
        Quantity::Milliseconds(frames) => 1e3 * seconds / frames,
        Quantity::Seconds => seconds,
        Quantity::GainOver(_) | Quantity::Counted | Quantity::Missing => return None,
    })
}

/// As the benchmark says, or from its id, "187k cells".
fn cells_of(measurement: &Measurement) -> Option<f64> {
    let of_id = || {
        let mut parts = measurement.id.split('/');
        let thousands = parts.find_map(|part| part.strip_suffix("k cells"))?;
        Some(1e3 * thousands.parse::<f64>().ok()?)
    };
    measurement.elements.map(|e| e as f64).or_else(of_id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dashboard::history::tests::measured as timed;

    fn cell(results: &Results, algorithm: &str, place: (&str, usize, usize)) -> [String; 2] {
        let papers = shown(results);
        let paper = papers
            .iter()
            .find(|p| p.algorithm == algorithm)
            .expect("known");
        let (table, row, column) = place;
        let table = paper
            .tables
            .iter()
            .find(|t| t.name == table)
            .expect("a table");
        table.rows[row].1[column].clone()
    }

    #[test]
    fn what_is_measured_stands_beside_what_is_printed() {
        let mut results = Results {
            measurements: vec![
                timed(
                    "projection/tables/sphere/149k cells/twelve-floats",
                    100.0,
                    1,
                ),
                timed(
                    "raycast-peel/tables/blunt/187k cells/table-2d-fixed/4x4",
                    600.0,
                    1,
                ),
                timed(
                    "raycast-peel/tables/blunt/187k cells/table-3d/4x4",
                    1200.0,
                    1,
                ),
                timed("resample/figure 5/heat-sink 64x64x64/render", 30.0, 1),
                timed("slicing/figure 5/angiography/hides a third/1", 300.0, 1),
                timed("slicing/figure 5/angiography/hides a third/16", 100.0, 1),
            ],
            ..Results::default()
        };
        results.measurements[0].elements = Some(148_955);
        for (end, passes) in [("least", 300.0), ("most", 400.0)] {
            let id = format!("raycast-peel/tables/blunt/187k cells/table-3d/passes {end}");
            results.counted.insert(id, passes);
        }
        for (algorithm, place, words) in [
            ("projection", ("table 1", 3, 0), ["1.65", "10.0"]),
            // 148 955 cells in a tenth of a second, of 720 bytes each.
            ("projection", ("table 1", 3, 1), ["245", "1490"]),
            ("projection", ("table 1", 3, 2), ["176", "1072"]),
            ("projection", ("table 2", 3, 0), ["2.53", "–"]),
            // Sums over three cameras: 200 ms and 400 ms a frame.
            ("raycast-peel", ("table 3", 1, 3), ["188 to 406", "200"]),
            (
                "raycast-peel",
                ("table 1", 1, 0),
                ["2.13 to 7.09", "2.50 to 5.00"],
            ),
            (
                "raycast-peel",
                ("table 1", 1, 1),
                ["398 to 1320", "468 to 935"],
            ),
            (
                "raycast-peel",
                ("table 2", 1, 1),
                ["392 to 542", "300 to 400"],
            ),
            ("raycast-peel", ("table 2", 1, 0), ["341 to 439", "–"]),
            ("resample", ("figure 5", 0, 1), ["1.4", "0.030"]),
            ("resample", ("figure 5", 0, 3), ["0.03", "–"]),
            ("slicing", ("figure 5, in words", 0, 0), ["150", "200"]),
            ("slicing", ("figure 5, in words", 0, 1), ["150", "–"]),
        ] {
            assert_eq!(
                cell(&results, algorithm, place),
                words,
                "{algorithm} {place:?}"
            );
        }
    }
}
