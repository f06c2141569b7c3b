//! The work-precision diagrams of the last `cargo xtask compare`, from its `report.json`.

use std::path::Path;

use serde::{Deserialize, Serialize};
use tetrascope::core::Error;

use crate::diagrams::{snug, style, words};
use crate::panel::{Panel, Point, STYLES, Series, mark};
use crate::plot::decades;
use crate::report::REPORT_VERSION;

/// All diagrams, and what they are of.
#[derive(Debug, Serialize)]
pub struct Precision {
    /// The git revision that was compared.
    pub revision: Option<String>,
    /// When, in UTC.
    pub date: String,
    /// The graphics adapter.
    pub adapter: Option<String>,
    /// Names, classes of colors and markers of the algorithms.
    pub legend: Vec<(String, String, &'static str)>,
    /// By scene, then by model: names and SVGs.
    pub scenes: Vec<(String, Vec<(String, String)>)>,
}

#[derive(Deserialize)]
struct Report {
    program: Program,
    machine: Machine,
    scenes: Vec<Scene>,
}

#[derive(Deserialize)]
struct Program {
    revision: Option<String>,
    started: String,
}

#[derive(Deserialize)]
struct Machine {
    adapter: Option<String>,
}

#[derive(Deserialize)]
struct Scene {
    name: String,
    models: Vec<Model>,
}

#[derive(Deserialize)]
struct Model {
    model: String,
    truth_bound: Option<f64>,
    rows: Vec<Row>,
}

#[derive(Deserialize)]
struct Row {
    algorithm: String,
    setting: String,
    outcome: Outcome,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Outcome {
    Drawn(Drawn),
    Skipped(serde::de::IgnoredAny),
}

#[derive(Deserialize)]
struct Drawn {
    error: Option<Errors>,
    frame_ms: f64,
}

#[derive(Deserialize)]
struct Errors {
    /// Null where it is infinite.
    rmse: Option<f64>,
}

const X_NAME: &str = "time per frame, ms";

/// The diagrams of a report; `None` where there is no such file or nothing that can be compared.
///
/// # Errors
/// A file that cannot be read or is not a report of this version.
pub fn read(path: &Path) -> Result<Option<Precision>, Error> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => {
            return Err(Error::Io {
                action: "cannot read",
                path: path.into(),
                source,
            });
        }
    };
    let wrong = |what: String| Error::Format {
        path: path.into(),
        at: "its beginning".into(),
        what,
        help: Some("run `cargo xtask compare` again, or delete the file".into()),
    };
    #[derive(Deserialize)]
    struct Version {
        version: u32,
    }
    let parsed: Result<Version, _> = serde_json::from_slice(&bytes);
    let Version { version } = parsed.map_err(|e| wrong(format!("not a report: {e}")))?;
    if version != REPORT_VERSION {
        let what = format!("a report of version {version}, this program reads {REPORT_VERSION}");
        return Err(wrong(what));
    }
    let report: Result<Report, _> = serde_json::from_slice(&bytes);
    Ok(report
        .map_err(|e| wrong(format!("not a report: {e}")))?
        .diagrams())
}

impl Row {
    /// Milliseconds and, but for the truth, the RMSE.
    fn drawn(&self) -> Option<(f64, Option<f64>)> {
        match &self.outcome {
            Outcome::Drawn(drawn) => {
                let error = drawn.error.as_ref();
                let rmse = error.map(|error| error.rmse.unwrap_or(f64::INFINITY));
                Some((drawn.frame_ms, rmse))
            }
            Outcome::Skipped(_) => None,
        }
    }
}

impl Report {
    fn diagrams(self) -> Option<Precision> {
        let rows = || {
            let models = self.scenes.iter().flat_map(|scene| &scene.models);
            models.flat_map(|model| &model.rows)
        };
        let mut legend = Vec::new();
        for algorithm in tetrascope::algorithms() {
            let compared = |row: &Row| matches!(row.drawn(), Some((_, Some(_))));
            if rows().any(|row| row.algorithm == algorithm.name && compared(row)) {
                let style = style(algorithm.name);
                let class = format!("s{}", style % STYLES);
                legend.push((algorithm.name.to_owned(), class, mark(style)));
            }
        }
        let scenes = self
            .scenes
            .iter()
            .map(|scene| (scene.name.clone(), scene.panels()));
        let scenes: Vec<_> = scenes.filter(|(_, panels)| !panels.is_empty()).collect();
        (!scenes.is_empty()).then_some(Precision {
            revision: self.program.revision,
            date: self.program.started,
            adapter: self.machine.adapter,
            legend,
            scenes,
        })
    }
}

impl Scene {
    /// One panel for each model; they share their axes.
    fn panels(&self) -> Vec<(String, String)> {
        let is_plain = |x: &f64| *x > 0.0 && x.is_finite();
        let drawn = || {
            let rows = self.models.iter().flat_map(|model| &model.rows);
            rows.filter_map(Row::drawn)
        };
        let bounds = self.models.iter().filter_map(|model| model.truth_bound);
        let x = snug(drawn().map(|(time, _)| time).filter(is_plain));
        let errors = drawn().filter_map(|(_, rmse)| rmse).chain(bounds);
        let y = decades(errors.filter(is_plain));
        if !x.0.is_finite() || !y.0.is_finite() {
            return Vec::new();
        }
        let panels = self.models.iter().filter_map(|model| {
            let series = model.series();
            let truth = model.rows.iter().filter_map(Row::drawn);
            let panel = Panel {
                title: format!("{}, {}: RMSE against {X_NAME}", self.name, model.model),
                x_name: X_NAME,
                x,
                y,
                series: &series,
                truth: truth
                    .filter(|(_, rmse)| rmse.is_none())
                    .map(|(time, _)| time)
                    .next(),
                truth_bound: model.truth_bound,
            };
            Some((model.model.clone(), panel.to_svg()?))
        });
        panels.collect()
    }
}

impl Model {
    fn series(&self) -> Vec<Series> {
        let by_algorithm = self.rows.chunk_by(|a, b| a.algorithm == b.algorithm);
        let series = by_algorithm.map(|rows| Series {
            algorithm: style(&rows[0].algorithm),
            name: rows[0].algorithm.clone(),
            points: rows
                .iter()
                .filter_map(|row| {
                    let (x, error) = row.drawn()?;
                    Some(Point {
                        x,
                        error: error?,
                        label: words(&row.setting),
                    })
                })
                .collect(),
        });
        series.filter(|series| !series.points.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As `compare` writes it, with fields that are not read left out.
    fn report(version: u32) -> String {
        format!(
            r#"{{"version":{version},"program":{{"revision":"abc","started":"2026-01-01T00:00:00Z"}},
            "machine":{{"adapter":"llvmpipe"}},"scenes":[{{"name":"<ball>","models":[{{
            "model":"emission","truth_bound":1e-8,"rows":[
            {{"algorithm":"reference","setting":"","outcome":{{"drawn":{{"error":null,"frame_ms":200}}}}}},
            {{"algorithm":"projection","setting":"order=mpvo","outcome":{{"drawn":{{"error":{{"rmse":1e-7}},
            "frame_ms":20}}}}}},
            {{"algorithm":"projection","setting":"","outcome":{{"drawn":{{"error":{{"rmse":null}},"frame_ms":20}}}}}},
            {{"algorithm":"slicing","setting":"","outcome":{{"skipped":"a mesh"}}}}]}}]}}]}}"#
        )
    }

    #[test]
    fn a_report_becomes_diagrams() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("report.json");
        assert!(read(&path).expect("no file is no error").is_none());
        std::fs::write(&path, report(REPORT_VERSION)).expect("written");
        let precision = read(&path)
            .expect("a report")
            .expect("a picture is compared");
        assert_eq!(precision.legend.len(), 1);
        assert_eq!(precision.legend[0].0, "projection");
        let (scene, panels) = &precision.scenes[0];
        assert_eq!((scene.as_str(), panels.len()), ("<ball>", 1));
        let svg = &panels[0].1;
        assert!(svg.contains("projection mpvo: RMSE 1.00e-7") && svg.contains("&lt;ball&gt;"));
        assert!(
            svg.contains("the ground truth") && !svg.contains("default"),
            "{svg}"
        );
    }

    #[test]
    fn another_version_is_refused_in_words() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("report.json");
        for (text, words) in [(report(99), "version 99"), ("{}".into(), "not a report")] {
            std::fs::write(&path, text).expect("written");
            let error = read(&path).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
