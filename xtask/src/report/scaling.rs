//! How the time of a frame grows with cells and pixels.

use serde::{Deserialize, Serialize};

use crate::diagrams::{LegendItem, snug, style};
use crate::panel::{Panel, Point, Series};

/// An algorithm's times over sizes of one data set.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct Scaling {
    /// The algorithm's name.
    pub algorithm: String,
    /// The data set.
    pub dataset: String,
    /// Cells, and the median time of a frame in milliseconds.
    pub cells: Vec<(f64, f64)>,
    /// Pixels, and the median time of a frame in milliseconds.
    pub pixels: Vec<(f64, f64)>,
    /// p where time grows as cellsᵖ, by least squares of logarithms.
    pub cells_exponent: f64,
    /// p where time grows as pixelsᵖ.
    pub pixels_exponent: f64,
}

impl Scaling {
    /// Nothing measured yet.
    pub fn new(algorithm: &str, dataset: &str) -> Scaling {
        Scaling {
            algorithm: algorithm.into(),
            dataset: dataset.into(),
            cells: Vec::new(),
            pixels: Vec::new(),
            cells_exponent: 0.0,
            pixels_exponent: 0.0,
        }
    }

    /// With exponents; `None` where there are not two sizes of each.
    pub fn fitted(self) -> Option<Scaling> {
        Some(Scaling {
            cells_exponent: exponent(&self.cells)?,
            pixels_exponent: exponent(&self.pixels)?,
            ..self
        })
    }
}

/// The slope of log y over log x by least squares; `None` where there are not two different x.
fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<(f64, f64)> = points
        .iter()
        .filter(|(x, y)| *x > 0.0 && *y > 0.0)
        .map(|(x, y)| (x.ln(), y.ln()))
        .collect();
    let count = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / count;
    let (x_mean, y_mean) = (mean(|p| p.0), mean(|p| p.1));
    let spread: f64 = logs.iter().map(|(x, _)| (x - x_mean).powi(2)).sum();
    let along: f64 = logs.iter().map(|(x, y)| (x - x_mean) * (y - y_mean)).sum();
    (spread > 0.0).then(|| along / spread)
}

/// The section of a page.
#[derive(Debug, Serialize)]
pub(super) struct ScalingSection<'a> {
    rows: &'a [Scaling],
    legend: Vec<LegendItem>,
    /// Subjects, each with an SVG.
    panels: Vec<(String, String)>,
}

/// The section of these; `None` where nothing was measured.
pub(super) fn section(rows: &[Scaling]) -> Option<ScalingSection<'_>> {
    let mut legend: Vec<LegendItem> = Vec::new();
    for row in rows {
        if legend.iter().all(|item| item.name != row.algorithm) {
            legend.push(LegendItem::of(&row.algorithm));
        }
    }
    let by_dataset = rows.chunk_by(|a, b| a.dataset == b.dataset);
    let panels = by_dataset.flat_map(|rows| {
        let cells = panel(rows, "cells", |row| &row.cells);
        let pixels = panel(rows, "pixels", |row| &row.pixels);
        [cells, pixels]
    });
    let panels: Vec<_> = panels.flatten().collect();
    (!panels.is_empty()).then_some(ScalingSection {
        rows,
        legend,
        panels,
    })
}

fn panel(
    rows: &[Scaling],
    x_name: &'static str,
    points: impl Fn(&Scaling) -> &Vec<(f64, f64)>,
) -> Option<(String, String)> {
    let all = || rows.iter().flat_map(&points).copied();
    let title = format!("{}, time against {x_name}", rows.first()?.dataset);
    let series: Vec<Series> = rows
        .iter()
        .map(|row| Series {
            algorithm: style(&row.algorithm),
            name: row.algorithm.clone(),
            points: points(row)
                .iter()
                .map(|&(x, ms)| Point {
                    x,
                    error: ms,
                    label: String::new(),
                })
                .collect(),
        })
        .collect();
    let panel = Panel {
        title: title.clone(),
        x_name,
        x: snug(all().map(|point| point.0)),
        y: snug(all().map(|point| point.1)),
        y_name: "time per frame, ms",
        has_front: false,
        series: &series,
        truth: None,
        truth_bound: None,
    };
    Some((title, panel.to_svg()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_slopes_of_logarithms() {
        let power = |p: f64| [10.0, 40.0, 160.0].map(|x: f64| (x, 3.0 * x.powf(p)));
        for p in [0.0, 0.5, 1.0, -2.0] {
            let found = exponent(&power(p)).expect("three sizes");
            assert!((found - p).abs() < 1e-12, "{found} for {p}");
        }
        assert_eq!(exponent(&[(10.0, 1.0)]), None);
        assert_eq!(exponent(&[(10.0, 1.0), (10.0, 2.0)]), None);
    }

    #[test]
    fn a_section_has_two_panels_for_each_data_set() {
        let row = |algorithm, dataset| Scaling {
            cells: vec![(1e4, 10.0), (4e4, 20.0)],
            pixels: vec![(64.0, 1.0), (256.0, 4.0)],
            ..Scaling::new(algorithm, dataset)
        };
        let rows = [
            row("reference", "sphere"),
            row("projection", "sphere"),
            row("slicing", "angiography"),
        ];
        let rows: Vec<Scaling> = rows.into_iter().filter_map(Scaling::fitted).collect();
        assert!((rows[0].cells_exponent - 0.5).abs() < 1e-12);
        let section = section(&rows).expect("measured");
        assert_eq!((section.panels.len(), section.legend.len()), (4, 3));
        assert!(section.panels[1].1.contains("time per frame, ms"));
        assert!(super::section(&[]).is_none());
        assert!(Scaling::new("reference", "sphere").fitted().is_none());
    }
}
