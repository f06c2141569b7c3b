//! The diagrams of a scene: error against time and against memory, one panel for each optical model.

use serde::Serialize;

use crate::panel::{Panel, Point, STYLES, Series, mark};
use crate::plot::decades;
use crate::report::{Drawn, ModelReport, Outcome, SceneReport};

/// All diagrams of a scene. Panels share their axes, so that they can be compared.
#[derive(Debug, Serialize)]
pub struct Diagrams {
    /// The algorithms that are drawn.
    pub legend: Vec<LegendItem>,
    /// Error against the time of a frame, by optical model: its name and an SVG.
    pub time: Vec<(String, String)>,
    /// Error against the bytes that stay between frames.
    pub memory: Vec<(String, String)>,
}

/// An algorithm's color and marker.
#[derive(Debug, Serialize)]
pub struct LegendItem {
    /// The algorithm's name.
    pub name: String,
    /// The class of its color.
    pub class: String,
    /// Its marker, in SVG.
    pub mark: &'static str,
}

impl LegendItem {
    /// An algorithm's.
    pub fn of(algorithm: &str) -> LegendItem {
        LegendItem {
            name: algorithm.into(),
            class: format!("s{}", style(algorithm) % STYLES),
            mark: mark(style(algorithm)),
        }
    }
}

/// Which color and marker an algorithm has: its place in the registry, so that it is the same in
/// every report. The truth comes first there and has none; peers, which are not there, have the last.
pub fn style(algorithm: &str) -> usize {
    let mut drawn = tetrascope::algorithms().iter().filter(|a| !a.is_truth());
    drawn
        .position(|a| a.name == algorithm)
        .unwrap_or(STYLES - 1)
}

const MIB: f64 = (1 << 20) as f64;

impl Diagrams {
    /// The diagrams of a scene; `None` where nothing is drawn that can be compared.
    pub fn of(scene: &SceneReport) -> Option<Diagrams> {
        let compared = |model: &'_ ModelReport| model.rows.iter().filter_map(compared).count() > 0;
        if !scene.models.iter().any(compared) {
            return None;
        }
        let time = |drawn: &Drawn| drawn.frame_ms;
        let memory = |drawn: &Drawn| drawn.stats.bytes_resident as f64 / MIB;
        let mut names: Vec<&str> = Vec::new();
        for row in scene.models.iter().flat_map(|model| &model.rows) {
            if self::compared(row).is_some() && !names.contains(&row.algorithm.as_str()) {
                names.push(&row.algorithm);
            }
        }
        Some(Diagrams {
            legend: names.into_iter().map(LegendItem::of).collect(),
            time: panels(scene, "time per frame, ms", time),
            memory: panels(scene, "resident memory, MiB", memory),
        })
    }
}

/// The picture of a row, and its RMSE against the truth.
fn compared(row: &crate::report::Row) -> Option<(&Drawn, f64)> {
    match &row.outcome {
        Outcome::Drawn(drawn) => Some((drawn, drawn.error.as_ref()?.image.rmse)),
        Outcome::Skipped(_) => None,
    }
}

fn panels(
    scene: &SceneReport,
    x_name: &'static str,
    x_of: impl Fn(&Drawn) -> f64,
) -> Vec<(String, String)> {
    let all = || {
        let rows = scene.models.iter().flat_map(|model| &model.rows);
        rows.filter_map(compared)
    };
    let is_plain = |x: &f64| *x > 0.0 && x.is_finite();
    let truths = scene.models.iter().filter_map(ModelReport::truth);
    let x = snug(
        all()
            .map(|(drawn, _)| drawn)
            .chain(truths)
            .map(&x_of)
            .filter(is_plain),
    );
    let bounds = scene.models.iter().filter_map(|model| model.truth_bound);
    let errors = all().map(|(_, rmse)| rmse).chain(bounds);
    let y = decades(errors.filter(is_plain));
    if !x.0.is_finite() || !y.0.is_finite() {
        return Vec::new();
    }
    let panels = scene.models.iter().filter_map(|model| {
        let by_algorithm = model.rows.chunk_by(|a, b| a.algorithm == b.algorithm);
        let series = by_algorithm.filter_map(|rows| {
            let points: Vec<Point> = rows
                .iter()
                .filter_map(|row| {
                    let (drawn, error) = compared(row)?;
                    Some(Point {
                        x: x_of(drawn),
                        error,
                        label: words(&row.setting),
                    })
                })
                .collect();
            (!points.is_empty()).then(|| Series {
                algorithm: style(&rows[0].algorithm),
                name: rows[0].algorithm.clone(),
                points,
            })
        });
        let panel = Panel {
            title: format!("{}, {}: RMSE against {x_name}", scene.name, model.model),
            x_name,
            x,
            y,
            y_name: "RMSE",
            has_front: true,
            series: &series.collect::<Vec<_>>(),
            truth: model.truth().map(&x_of),
            truth_bound: model.truth_bound,
        };
        Some((model.model.clone(), panel.to_svg()?))
    });
    panels.collect()
}

/// log₁₀ of the range of `values` > 0, a decade at least, and room for markers and labels.
pub(crate) fn snug(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let ends = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = values.fold(ends, |(low, high), value| {
        (low.min(value.log10()), high.max(value.log10()))
    });
    let room = f64::max(0.06 * (high - low), (1.0 - (high - low)) / 2.0);
    (low - room, high + room)
}

/// A setting in few words: "order=per-pixel,table-size=64" as "per-pixel 64". Numbers keep their
/// names, but for sizes; nothing set is "default".
pub fn words(setting: &str) -> String {
    if setting.is_empty() {
        return "default".into();
    }
    let word = |pair: &str| match pair.split_once('=') {
        Some((name, value)) if name.ends_with("size") || value.parse::<f64>().is_err() => {
            value.to_owned()
        }
        _ => pair.to_owned(),
    };
    setting.split(',').map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_model_has_its_panels() {
        let report = crate::report::tests::report("sphere");
        let diagrams = Diagrams::of(&report.scenes[0]).expect("one picture is compared");
        assert_eq!(diagrams.legend.len(), 1);
        assert_eq!(diagrams.legend[0].name, "projection");
        for panels in [&diagrams.time, &diagrams.memory] {
            assert!(panels.iter().all(|panel| panel.0 == "emission-absorption"));
        }
        assert_eq!(diagrams.time.len(), 1);
        assert!(
            diagrams.time[0]
                .1
                .contains("projection centroid: RMSE 1.50e-4")
        );
        // Nothing stays in the memory of the report's one picture.
        assert!(diagrams.memory.is_empty());
    }

    #[test]
    fn algorithms_have_styles_of_their_own() {
        let drawn = tetrascope::algorithms().iter().filter(|a| !a.is_truth());
        let styles: Vec<usize> = drawn.map(|a| style(a.name)).collect();
        assert_eq!(styles, (0..styles.len()).collect::<Vec<_>>());
        // The last is for peers.
        assert!(styles.len() < STYLES);
        assert_eq!(style("vtk"), STYLES - 1);
    }

    #[test]
    fn axes_hold_their_values_and_a_decade_at_least() {
        let (low, high) = snug([10.0, 1000.0].into_iter());
        assert!((low - 0.88).abs() < 1e-12 && (high - 3.12).abs() < 1e-12);
        assert_eq!(snug([10.0].into_iter()), (0.5, 1.5));
    }

    #[test]
    fn settings_are_short() {
        assert_eq!(words(""), "default");
        assert_eq!(words("order=per-pixel,table-size=64"), "per-pixel 64");
        assert_eq!(words("samples=32,passes=one"), "samples=32 one");
    }
}
