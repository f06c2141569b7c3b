//! The findings of `compare`: the numbers as JSON, and one page for people.
//!
//! Here are the data, which `report.md` describes; `table` writes them for a terminal, and `page`
//! with `pictures` for a browser.

mod numbers;
mod page;
mod pictures;
mod scaling;
mod skipped;
mod table;

pub use numbers::{bytes, milliseconds, scientific};
pub use page::Extras;
pub use pictures::{Difference, Picture, Pictures};
pub use scaling::Scaling;

pub(crate) use numbers::thousands;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tetrascope::core::FrameStats;
use tetrascope::{Promise, Settings};
use tetrascope_testing::ImageError;

use crate::metrics::Errors;

/// The version of the JSON's layout, which `report.md` describes: it grows when a field goes or
/// changes its meaning, and not when one is added.
pub const REPORT_VERSION: u32 = 3;

/// Everything that a run found, and everything that its numbers depend on.
#[derive(Debug, Deserialize, Serialize)]
pub struct Report {
    /// [`REPORT_VERSION`].
    pub version: u32,
    /// Program, version and source revision.
    pub program: Program,
    /// The machine that it ran on.
    pub machine: Machine,
    /// Frames timed of each row at most, after the one that is judged.
    pub repeat: u32,
    /// How many of the scenes' models were drawn by a run before, which was interrupted.
    pub resumed: usize,
    /// The scenes that were drawn.
    pub scenes: Vec<SceneReport>,
    /// How times grow with cells and pixels, where that was asked.
    pub scaling: Vec<Scaling>,
    /// The demands on the errors.
    pub checks: Vec<Check>,
}

/// The program that made a report.
#[derive(Debug, Deserialize, Serialize)]
pub struct Program {
    /// "tetrascope".
    pub name: String,
    /// The crates' version.
    pub version: String,
    /// The git revision, with "-dirty" where files were changed; `None` outside a checkout.
    pub revision: Option<String>,
    /// When the run began, UTC, as in RFC 3339.
    pub started: String,
    /// The command line.
    pub command: String,
    /// "release", or "debug" where assertions were on and times mean little.
    pub build: String,
}

/// The machine that a report was made on.
#[derive(Debug, Deserialize, Serialize)]
pub struct Machine {
    /// The operating system.
    pub os: String,
    /// The processor's architecture.
    pub architecture: String,
    /// The processor's name, where the system tells it.
    pub processor: Option<String>,
    /// Threads that run at a time.
    pub threads: usize,
    /// The graphics adapter: name, kind, backend, driver.
    pub adapter: Option<String>,
    /// Why there is no adapter.
    pub no_adapter: Option<String>,
    /// The peer and its version, "VTK 9.5.0"; `None` where none was asked.
    pub peer: Option<String>,
}

/// A scene, under one or more optical models.
#[derive(Debug, Deserialize, Serialize)]
pub struct SceneReport {
    /// The user's name for it: a data set or a file.
    pub name: String,
    /// How many tetrahedra or voxel cells.
    pub cells: usize,
    /// Whether the mesh is convex, as far as is known.
    pub convex: Option<bool>,
    /// Read or generate, milliseconds.
    pub load_ms: f64,
    /// SHA-256 of each input file, hexadecimal, by name.
    pub sha256: BTreeMap<String, String>,
    /// Findings and repairs of the reader.
    pub notes: Vec<String>,
    /// Under each optical model.
    pub models: Vec<ModelReport>,
}

/// A scene under one optical model.
#[derive(Debug, Deserialize, Serialize)]
pub struct ModelReport {
    /// The optical model's name.
    pub model: String,
    /// The resolved scene as TOML; draws the very same picture.
    pub scene: String,
    /// The choices for everything that the scene left out.
    pub defaults: Vec<String>,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The truth's own error bound, absolute.
    pub truth_bound: Option<f64>,
    /// One an algorithm and setting.
    pub rows: Vec<Row>,
    /// Where the error of some rows comes from.
    pub sources: Vec<ErrorSource>,
}

/// A part of an algorithm's error that two of its settings tell apart.
#[derive(Debug, Deserialize, Serialize)]
pub struct ErrorSource {
    /// The cause, in words.
    pub source: String,
    /// The algorithm and setting that has it.
    pub with: String,
    /// The picture without it, with which it is compared.
    pub against: String,
    /// The difference.
    pub error: ImageError,
}

/// One algorithm with one setting.
#[derive(Debug, Deserialize, Serialize)]
pub struct Row {
    /// The algorithm's name.
    pub algorithm: String,
    /// The settings, "key=value,…"; empty for the defaults.
    pub setting: String,
    /// Every setting's value.
    pub settings: String,
    /// Whether these are the algorithm's defaults.
    pub is_default: bool,
    /// How near to the truth it is meant to be.
    #[serde(skip, default = "nothing_promised")]
    pub promise: Promise,
    /// The outcome.
    pub outcome: Outcome,
}

/// The outcome of a row.
#[derive(Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// A picture.
    Drawn(Box<Drawn>),
    /// Why there is no picture.
    Skipped(String),
}

/// A picture's numbers. Times of one kind come from one clock.
#[derive(Debug, Deserialize, Serialize)]
pub struct Drawn {
    /// Against the truth; `None` for the truth itself.
    pub error: Option<Errors>,
    /// From volume and appearance to a renderer that can draw, milliseconds.
    pub prepare_ms: f64,
    /// The wall time of the first frame, milliseconds; errors are those of this frame.
    pub first_ms: f64,
    /// The median time of a frame from a camera that moves, milliseconds.
    pub frame_ms: f64,
    /// The quickest and the slowest of these frames, milliseconds.
    pub frame_range_ms: [f64; 2],
    /// How many these are; 0 where `frame_ms` is the first frame's, as it took long.
    pub frames: usize,
    /// "gpu" where `frame_ms` is between timestamps on the device, else "wall".
    pub clock: String,
    /// The median wall time a frame, readback included, milliseconds.
    pub wall_ms: f64,
    /// Another look at the same volume, milliseconds; `None` where it was not tried.
    pub restyle_ms: Option<f64>,
    /// The most memory that a process took that drew this alone, bytes; `None` where it was not
    /// measured.
    pub peak_bytes: Option<u64>,
    /// The first frame's own account.
    pub stats: Stats,
}

/// A frame's own account ([`FrameStats`]), as it can be read back.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Stats {
    /// Wall time of the frame on the CPU, readback included, seconds.
    pub cpu_seconds: f64,
    /// Time on the device, seconds.
    pub gpu_seconds: Option<f64>,
    /// Render and compute passes recorded.
    pub passes: u64,
    /// Bytes of the volume sent to the device for this frame.
    pub bytes_uploaded: u64,
    /// Bytes of the volume that stay between frames.
    pub bytes_resident: u64,
    /// Bytes that one of the volume's cells takes on average.
    pub bytes_per_cell: Option<f64>,
    /// Whether the order of cells is known to be right.
    pub order_proven: Option<bool>,
    /// The image's worst error bound, absolute, if the renderer has one.
    pub error_bound: Option<f64>,
    /// Fallbacks that were taken, a sentence each.
    pub notes: Vec<String>,
    /// Counts of the algorithm, by name.
    #[serde(flatten)]
    pub counts: BTreeMap<String, u64>,
}

impl From<&FrameStats> for Stats {
    fn from(stats: &FrameStats) -> Stats {
        let counts = stats.counts.iter();
        Stats {
            cpu_seconds: stats.cpu_seconds,
            gpu_seconds: stats.gpu_seconds,
            passes: stats.passes,
            bytes_uploaded: stats.bytes_uploaded,
            bytes_resident: stats.bytes_resident,
            bytes_per_cell: stats.bytes_per_cell,
            order_proven: stats.order_proven,
            error_bound: stats.error_bound,
            notes: stats.notes.clone(),
            counts: counts
                .map(|count| (count.counter.name.into(), count.value))
                .collect(),
        }
    }
}

/// The promise of a row that was read back, until somebody asks its algorithm.
fn nothing_promised() -> Promise {
    Promise::Open
}

/// Bounds on an error, and whether both were kept.
#[derive(Debug, Deserialize, Serialize)]
pub struct Check {
    /// Scene, model, algorithm and setting.
    pub subject: String,
    /// The RMSE; `None` where there is no truth to compare with.
    pub rmse: Option<f64>,
    /// The most that it may be.
    pub limit: f64,
    /// The greatest error, without that of pixels that may differ by anything.
    pub max: Option<f64>,
    /// The most that it may be.
    pub max_limit: f64,
    /// Whether both are.
    pub passed: bool,
}

impl Check {
    /// Judges RMSE and greatest error.
    pub fn new(subject: String, found: (f64, f64), (limit, max_limit): (f64, f64)) -> Check {
        let (rmse, max) = found;
        Check {
            subject,
            rmse: Some(rmse),
            limit,
            max: Some(max),
            max_limit,
            passed: rmse <= limit && max <= max_limit,
        }
    }

    /// A check that cannot be made, and so fails.
    pub fn without_truth(subject: String) -> Check {
        Check {
            subject,
            rmse: None,
            limit: 0.0,
            max: None,
            max_limit: 0.0,
            passed: false,
        }
    }

    /// The error and the most that is allowed, in words.
    pub fn found(&self) -> String {
        match (self.rmse, self.max) {
            (Some(rmse), Some(max)) => format!(
                "RMSE {}, at most {} allowed; greatest error {}, at most {} allowed",
                scientific(rmse),
                scientific(self.limit),
                scientific(max),
                scientific(self.max_limit)
            ),
            _ => "no ground truth to compare with".into(),
        }
    }
}

impl ModelReport {
    /// Asks the algorithms what rows that were read back promise; others promise nothing.
    pub(crate) fn promise_again(&mut self) {
        for row in &mut self.rows {
            let promised = tetrascope::algorithm(&row.algorithm).and_then(|algorithm| {
                let settings = Settings::parse(algorithm, row.setting.split(','))?;
                Ok((algorithm.promise)(&settings))
            });
            row.promise = promised.unwrap_or(Promise::Open);
        }
    }

    /// The truth's numbers, where it was drawn.
    pub fn truth(&self) -> Option<&Drawn> {
        self.rows.iter().find_map(|row| match &row.outcome {
            Outcome::Drawn(drawn) if row.promise == Promise::Truth => Some(&**drawn),
            _ => None,
        })
    }
}

impl Report {
    /// Whether every bound was kept, and checked where there is one.
    pub fn passed(&self) -> bool {
        let was_checked = !self.checks.is_empty() || !self.has_bounds();
        was_checked && self.checks.iter().all(|check| check.passed)
    }

    /// Whether some picture has a bound to keep, whatever the scene is like.
    fn has_bounds(&self) -> bool {
        let models = self.scenes.iter().flat_map(|scene| &scene.models);
        models.flat_map(|model| &model.rows).any(|row| {
            let promised = matches!(row.promise, Promise::Exact | Promise::Within(_));
            promised && matches!(row.outcome, Outcome::Drawn(_))
        })
    }

    /// The same in words.
    pub fn verdict(&self) -> String {
        let missed = self.checks.iter().filter(|check| !check.passed).count();
        match (self.checks.len(), missed) {
            (0, _) if self.has_bounds() => "nothing was checked, though there are bounds".into(),
            (0, _) => "no picture here has a bound to keep".into(),
            (all, 0) => format!("all {all} bounds kept"),
            (all, missed) => format!("{missed} of {all} bounds missed"),
        }
    }

    /// Reads a report that [`Report::to_json`] has written; what is promised is asked again.
    ///
    /// # Errors
    /// The fault, in words.
    pub fn from_json(json: &[u8]) -> Result<Report, String> {
        #[derive(Deserialize)]
        struct Version {
            version: u32,
        }
        let no_report = |error| format!("not a report: {error}");
        let Version { version } = serde_json::from_slice(json).map_err(no_report)?;
        if version != REPORT_VERSION {
            return Err(format!(
                "a report of version {version}, and this program reads {REPORT_VERSION}"
            ));
        }
        let mut report: Report = serde_json::from_slice(json).map_err(no_report)?;
        let models = report.scenes.iter_mut().flat_map(|scene| &mut scene.models);
        models.for_each(ModelReport::promise_again);
        Ok(report)
    }

    /// The report as JSON.
    pub fn to_json(&self) -> String {
        let mut json = serde_json::to_string_pretty(self).expect("a report is plain data");
        json.push('\n');
        json
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn report(name: &str) -> Report {
        let error = ImageError {
            rmse: 1.5e-4,
            max: 1e-3,
            psnr: Some(76.5),
            worst_pixel: [1, 2],
        };
        let drawn = |error| Drawn {
            error,
            prepare_ms: 12.0,
            first_ms: 6.0,
            frame_ms: 3.5,
            frame_range_ms: [3.0, 4.0],
            frames: 2,
            clock: "gpu".into(),
            wall_ms: 5.0,
            restyle_ms: Some(1.0),
            peak_bytes: None,
            stats: Stats::default(),
        };
        let row = |algorithm: &str, setting: &str, outcome| Row {
            algorithm: algorithm.into(),
            setting: setting.into(),
            settings: "order=centroid".into(),
            is_default: true,
            promise: match algorithm {
                "reference" => Promise::Truth,
                _ => Promise::Exact,
            },
            outcome,
        };
        let rows = vec![
            row("reference", "", Outcome::Drawn(Box::new(drawn(None)))),
            row(
                "projection",
                "order=centroid",
                Outcome::Drawn(Box::new(drawn(Some(Errors::of(error))))),
            ),
            row(
                "projection",
                "order=exact",
                Outcome::Skipped("no <adapter>".into()),
            ),
        ];
        Report {
            version: REPORT_VERSION,
            program: Program {
                name: "tetrascope".into(),
                version: "0.0.0".into(),
                revision: None,
                started: "2026-01-01T00:00:00Z".into(),
                command: "compare".into(),
                build: "release".into(),
            },
            machine: Machine {
                os: "linux".into(),
                architecture: "x86_64".into(),
                processor: None,
                threads: 2,
                adapter: None,
                no_adapter: Some("none found".into()),
                peer: None,
            },
            repeat: 3,
            resumed: 0,
            scenes: vec![SceneReport {
                name: name.into(),
                cells: 148_955,
                convex: Some(true),
                load_ms: 1.0,
                sha256: BTreeMap::new(),
                notes: vec!["a note".into()],
                models: vec![ModelReport {
                    model: "emission-absorption".into(),
                    scene: "version = 1".into(),
                    defaults: vec![],
                    size: [4, 4],
                    truth_bound: Some(1e-12),
                    rows,
                    sources: vec![ErrorSource {
                        source: "order alone".into(),
                        with: "projection order=centroid".into(),
                        against: "reference".into(),
                        error,
                    }],
                }],
            }],
            scaling: Vec::from_iter(
                Scaling {
                    cells: vec![(1e4, 10.0), (4e4, 20.0)],
                    pixels: vec![(64.0, 1.0), (256.0, 4.0)],
                    ..Scaling::new("projection", "sphere")
                }
                .fitted(),
            ),
            checks: vec![Check::new("sphere".into(), (1.5e-4, 1e-3), (1e-4, 1e-2))],
        }
    }

    pub(crate) fn drawn_with(rmse: f64, frame_ms: f64) -> Outcome {
        let mut report = report("");
        let Outcome::Drawn(mut drawn) = report.scenes[0].models[0].rows.swap_remove(1).outcome
        else {
            panic!("it is drawn");
        };
        drawn.frame_ms = frame_ms;
        drawn.error.as_mut().expect("compared").image.rmse = rmse;
        Outcome::Drawn(drawn)
    }

    /// The same, with an algorithm of which nothing is drawn.
    pub(crate) fn with_settings_that_draw_nothing() -> Report {
        let mut report = report("sphere");
        for (setting, why) in [("a=1", "no grid"), ("a=2", "no grid"), ("a=3", "too large")] {
            report.scenes[0].models[0].rows.push(Row {
                algorithm: "slicing".into(),
                setting: setting.into(),
                settings: setting.into(),
                is_default: false,
                promise: Promise::Open,
                outcome: Outcome::Skipped(why.into()),
            });
        }
        report
    }

    #[test]
    fn one_missed_bound_fails_the_report() {
        let mut report = report("sphere");
        assert!(!report.passed());
        report.checks[0].passed = true;
        assert!(report.passed());
    }

    #[test]
    fn json_has_the_numbers() {
        let json: serde_json::Value =
            serde_json::from_str(&report("sphere").to_json()).expect("valid JSON");
        assert_eq!(json["version"], REPORT_VERSION);
        let row = &json["scenes"][0]["models"][0]["rows"][1];
        let error = &row["outcome"]["drawn"]["error"];
        assert_eq!(
            (&error["rmse"], &error["worst_pixel"]),
            (&1.5e-4.into(), &[1, 2].into())
        );
        assert_eq!(error["percentiles"]["p99.9"], 9e-4);
    }

    #[test]
    fn what_was_written_reads_back() {
        let mut report = report("sphere");
        let model = &mut report.scenes[0].models[0];
        let Outcome::Drawn(drawn) = &mut model.rows[1].outcome else {
            panic!("it is drawn");
        };
        drawn.stats.counts = [("fragments".to_owned(), 7)].into();
        let error = drawn.error.as_mut().expect("compared");
        (error.image.rmse, error.worst) = (f64::INFINITY, vec![f64::INFINITY, 1.0]);
        let written = report.to_json();
        let read = Report::from_json(written.as_bytes()).expect("what was written");
        assert_eq!(written, read.to_json());
        let Outcome::Drawn(drawn) = &read.scenes[0].models[0].rows[1].outcome else {
            panic!("it is drawn");
        };
        let error = drawn.error.as_ref().expect("compared");
        assert_eq!(
            (error.image.rmse, error.worst[0]),
            (f64::INFINITY, f64::INFINITY)
        );
    }

    #[test]
    fn another_version_is_refused_in_words() {
        let other = report("")
            .to_json()
            .replace(&format!("\"version\": {REPORT_VERSION}"), "\"version\": 99");
        for (text, words) in [(&*other, "version 99"), ("{}", "not a report")] {
            let error = Report::from_json(text.as_bytes()).expect_err(words);
            assert!(error.contains(words), "{error}");
        }
    }

    /// Every name in `value`, but for those that are data: settings, counts and files.
    fn names(value: &serde_json::Value, into: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                for (name, field) in fields {
                    into.push(name.clone());
                    if !["counts", "sha256"].contains(&name.as_str()) {
                        names(field, into);
                    }
                }
            }
            serde_json::Value::Array(items) => items.iter().for_each(|item| names(item, into)),
            _ => {}
        }
    }

    #[test]
    fn every_field_of_the_json_is_described() {
        let json = serde_json::from_str(&report("sphere").to_json()).expect("valid JSON");
        let mut found = Vec::new();
        names(&json, &mut found);
        assert!(found.len() > 50, "{found:?}");
        let schema = include_str!("../report.md");
        for name in found {
            assert!(schema.contains(&format!("`{name}`")), "{name}");
        }
        assert!(schema.contains(&format!("version {REPORT_VERSION}")));
    }
}
