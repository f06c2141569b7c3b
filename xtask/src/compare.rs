//! Draws scenes with every algorithm and sets error against time.
//!
//! 1. `plan` turns names and files into scenes.
//! 2. `Contender`s are built, one an algorithm and setting; the ground truth draws.
//! 3. Frames are drawn in turn, so that what slows the machine slows all alike.
//! 4. Errors are judged and the report is written.

mod plan;

pub use plan::resolve;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use tetrascope::core::{Error, Frame, OpticalModel, Volume, VolumeRenderer};
use tetrascope::scene::Scene;
use tetrascope::{Algorithm, Context, Renderer, Settings};
use tetrascope_testing::ImageError;

use crate::diagrams::words;
use crate::limits::{ROUGH_ORDER, limit, outliers, rmse_with_outliers};
use crate::metrics::{Errors, median};
use crate::output::{phase, progress, write};
use crate::picture::{difference_map, shown};
use crate::report::{Check, Drawn, ErrorSource, ModelReport, Outcome, Pictures, Row, SceneReport};
use crate::{figures, machine, setup, sweep};

/// What to compare.
#[derive(clap::Args)]
pub struct Options {
    /// Mesh files, scene files (.toml, .json) or data sets [default: sphere orbital heat-sink]
    #[arg(value_name = "FILE|DATASET|SCENE")]
    pub scenes: Vec<String>,
    /// The field of mesh files
    #[arg(long)]
    pub field: Option<String>,
    /// Algorithms, separated by commas [default: all]
    #[arg(long, value_delimiter = ',')]
    pub algorithms: Vec<String>,
    /// Optical models, separated by commas [default: all for data sets, a file's own for files]
    #[arg(long, value_delimiter = ',')]
    pub models: Vec<String>,
    /// Image size [default: a scene file's own, else 256x256]
    #[arg(long, value_name = "WxH")]
    pub size: Option<String>,
    /// Draw in parallel projection what a scene has in perspective, as large at the focal point
    #[arg(long)]
    pub orthographic: bool,
    /// Frames timed of each algorithm and setting
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repeat: u32,
    /// The folder of index.html and report.json [default: target/compare]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the report as JSON in place of the table
    #[arg(long)]
    pub json: bool,
}

/// Runs the comparison, prints the table and writes the report.
///
/// Returns whether every error is within its bound.
pub fn run(options: &Options) -> Result<bool, Error> {
    let plan = plan::plan(options)?;
    let adapter = match plan.algorithms.iter().any(|a| a.needs_gpu) {
        true => setup::setup(),
        false => Err(Error::NoAdapter {
            reason: "no algorithm here needs one".into(),
            help: None,
        }),
    };
    if let Err(error) = &adapter {
        eprintln!("{error}; drawing on the CPU alone");
    }
    let context = Context::new();
    let mut report = machine::describe(adapter, options.repeat);
    let mut pictures = Pictures::default();
    let progress = progress(plan.scenes.iter().map(|s| s.models.len() as u64).sum());
    for (index, planned) in plan.scenes.iter().enumerate() {
        let scene = scene(&context, &plan, planned, index, &progress, &mut pictures)?;
        report.checks.extend(checks(&scene));
        report.scenes.push(scene);
    }
    progress.finish_and_clear();
    for algorithm in &plan.algorithms {
        let drawn =
            |row: &Row| row.algorithm == algorithm.name && matches!(row.outcome, Outcome::Drawn(_));
        let mut models = report.scenes.iter().flat_map(|scene| &scene.models);
        if models.any(|model| model.rows.iter().any(drawn)) {
            pictures.add_figures(figures::measured(algorithm));
        }
    }
    pictures.set_machine(sweep::last());

    match options.json {
        true => print!("{}", report.to_json()),
        false => print!("{}", report.to_table()),
    }
    let folder = options
        .out
        .clone()
        .unwrap_or_else(|| machine::target().join("compare"));
    let page = folder.join("index.html");
    write(&folder.join("report.json"), report.to_json())?;
    write(&page, report.to_html(&pictures))?;
    eprintln!("wrote {}", page.display());
    for miss in report.checks.iter().filter(|check| !check.passed) {
        eprintln!("missed: {}: {}", miss.subject, miss.found());
    }
    eprintln!("{}", report.verdict());
    Ok(report.passed())
}

/// Compares under each optical model of one scene.
fn scene(
    context: &Context,
    plan: &plan::Plan,
    planned: &plan::PlannedScene,
    index: usize,
    progress: &ProgressBar,
    pictures: &mut Pictures,
) -> Result<SceneReport, Error> {
    phase(progress, &format!("{}: loading", planned.name));
    let start = Instant::now();
    let loaded = tetrascope::volumes::load(&planned.file.volume)?;
    let load_ms = milliseconds(start.elapsed());
    let volume = &loaded.volume;
    let convex = match volume {
        Volume::Mesh(mesh) => Some(mesh.boundary_statistics().convex),
        Volume::Grid(_) | Volume::Stream(_) => Some(true),
        _ => None,
    };
    let mut report = SceneReport {
        name: planned.name.clone(),
        cells: volume.cell_count(),
        convex,
        load_ms,
        sha256: machine::fingerprints(&loaded.files),
        notes: loaded.notes.clone(),
        models: Vec::new(),
    };
    for (m, &model) in planned.models.iter().enumerate() {
        phase(progress, &format!("{}: {}", planned.name, model.name()));
        let mut scene = plan::resolve(&planned.file, model, volume)?;
        if planned.orthographic {
            scene.view.camera = scene.view.camera.to_orthographic();
        }
        let contenders = draw(context, plan, volume, &scene)?;
        show(&contenders, (index, m), pictures);
        report.models.push(model_report(&scene, model, &contenders));
        progress.inc(1);
    }
    Ok(report)
}

/// An algorithm with a setting, and what it has drawn.
struct Contender {
    algorithm: &'static Algorithm,
    setting: &'static str,
    settings: Settings,
    renderer: Result<Renderer, Error>,
    prepare: Duration,
    wall_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    frame: Option<Frame>,
}

/// Builds every contender and draws its frames, the ground truth's first.
fn draw(
    context: &Context,
    plan: &plan::Plan,
    volume: &Volume,
    scene: &Scene,
) -> Result<Vec<Contender>, Error> {
    let mut contenders = Vec::new();
    for &algorithm in &plan.algorithms {
        if algorithm.needs_gpu {
            // The device is made once a program: no algorithm is charged for it.
            // An error comes up again in `build`.
            _ = context.gpu();
        }
        for &setting in (algorithm.sweep)(scene.appearance.optical_model) {
            let settings = Settings::parse(algorithm, setting.split(','))?;
            let start = Instant::now();
            let renderer = (algorithm.supports)(volume, &scene.appearance, &scene.view, &settings)
                .and_then(|()| (algorithm.build)(context, volume, &scene.appearance, &settings));
            contenders.push(Contender {
                algorithm,
                setting,
                settings,
                renderer,
                prepare: start.elapsed(),
                wall_ms: Vec::new(),
                gpu_ms: Vec::new(),
                frame: None,
            });
        }
    }
    // Round 0 warms caches and is not counted.
    for round in 0..=plan.repeat {
        for contender in &mut contenders {
            if contender.spent_ms() < ENOUGH_MS {
                contender.draw(scene, round > 0);
            }
        }
    }
    Ok(contenders)
}

/// Frames of a setting are not repeated any more once they took so long in all, as a default run has
/// hundreds of settings.
const ENOUGH_MS: f64 = 1000.0;

impl Contender {
    /// What counted frames took.
    fn spent_ms(&self) -> f64 {
        self.wall_ms.iter().sum()
    }

    fn draw(&mut self, scene: &Scene, counted: bool) {
        let Ok(renderer) = &self.renderer else { return };
        let start = Instant::now();
        match renderer.render(&scene.view) {
            Ok(frame) => {
                if counted {
                    self.wall_ms.push(milliseconds(start.elapsed()));
                    self.gpu_ms.extend(frame.stats.gpu_seconds.map(|s| s * 1e3));
                }
                self.frame = Some(frame);
            }
            Err(error) => {
                self.renderer = Err(error);
                self.frame = None;
            }
        }
    }

    fn is_default(&self) -> bool {
        self.settings == Settings::defaults(self.algorithm)
    }

    /// The numbers, if there is a picture.
    fn outcome(&self, truth: Option<&Frame>) -> Outcome {
        let (frame, error) = match (&self.frame, &self.renderer) {
            (Some(frame), _) => (frame, None),
            (None, Err(error)) => return Outcome::Skipped(error.to_string()),
            (None, Ok(_)) => unreachable!("a renderer draws or fails"),
        };
        let error = error.or_else(|| {
            let truth = truth.filter(|_| !self.algorithm.is_truth())?;
            Some(Errors::between(truth, frame))
        });
        // Device time only where every frame has it.
        let on_device = self.gpu_ms.len() == self.wall_ms.len();
        let times = if on_device {
            &self.gpu_ms
        } else {
            &self.wall_ms
        };
        let middle = |times: &[f64]| median(times).expect("at least one frame is timed");
        let least = times.iter().copied().fold(f64::INFINITY, f64::min);
        let most = times.iter().copied().fold(0.0, f64::max);
        Outcome::Drawn(Box::new(Drawn {
            error,
            prepare_ms: milliseconds(self.prepare),
            frame_ms: middle(times),
            frame_range_ms: [least, most],
            clock: if on_device { "gpu" } else { "wall" },
            wall_ms: middle(&self.wall_ms),
            stats: frame.stats.clone(),
        }))
    }
}

fn model_report(scene: &Scene, model: OpticalModel, contenders: &[Contender]) -> ModelReport {
    let truth = truth_of(contenders).map(|(_, frame)| frame);
    let rows = contenders.iter().map(|contender| Row {
        algorithm: contender.algorithm.name,
        setting: contender.setting.into(),
        settings: contender.settings.to_string(),
        is_default: contender.is_default(),
        promise: (contender.algorithm.promise)(&contender.settings),
        outcome: contender.outcome(truth),
    });
    ModelReport {
        model: model.name(),
        scene: scene.to_toml(),
        defaults: scene.defaults.clone(),
        size: [scene.view.width, scene.view.height],
        truth_bound: truth.and_then(|frame| frame.stats.error_bound),
        rows: rows.collect(),
        sources: sources(contenders),
    }
}

/// What tells the sources of each algorithm's error apart, where all of it was drawn.
fn sources(contenders: &[Contender]) -> Vec<ErrorSource> {
    let of_one = |settings: &[Contender]| {
        let algorithm = settings[0].algorithm;
        let drawn = |setting: &str| {
            let contender = settings.iter().find(|c| c.setting == setting)?;
            let name = format!("{} {setting}", algorithm.name);
            Some((name, contender.frame.as_ref()?))
        };
        let compared = algorithm.sources.iter().map(|source| {
            let (with, frame) = drawn(source.with)?;
            let (against, right) = match source.without {
                Some(setting) => drawn(setting)?,
                None => truth_of(contenders)?,
            };
            Some(ErrorSource {
                source: source.name,
                with,
                against,
                error: ImageError::between(right, frame),
            })
        });
        // Where one is not drawn, the others say nothing about a whole.
        compared.collect::<Option<Vec<_>>>().unwrap_or_default()
    };
    let by_algorithm = contenders.chunk_by(|a, b| a.algorithm.name == b.algorithm.name);
    by_algorithm.flat_map(of_one).collect()
}

/// The truth's name and picture.
fn truth_of(contenders: &[Contender]) -> Option<(String, &Frame)> {
    let truth = contenders.iter().find(|c| c.algorithm.is_truth())?;
    Some((truth.algorithm.name.into(), truth.frame.as_ref()?))
}

/// The pictures: the truth, then each algorithm with its defaults, or with the first setting that
/// draws, and the difference. Others are told apart by their numbers.
fn show(contenders: &[Contender], place: (usize, usize), pictures: &mut Pictures) {
    let truth = truth_of(contenders).map(|(_, frame)| frame);
    for settings in contenders.chunk_by(|a, b| a.algorithm.name == b.algorithm.name) {
        let drawn = || settings.iter().filter(|c| c.frame.is_some());
        let Some(contender) = drawn().find(|c| c.is_default()).or(drawn().next()) else {
            continue;
        };
        let frame = contender.frame.as_ref().expect("filtered above");
        let name = contender.algorithm.name;
        if contender.algorithm.is_truth() {
            pictures.add(place, name, "the ground truth", shown(frame));
            continue;
        }
        let caption = words(contender.setting);
        pictures.add(place, name, &caption, shown(frame));
        if let Some(truth) = truth {
            let map = difference_map(truth, frame);
            pictures.add_difference(place, &format!("{name}: difference"), &caption, map);
        }
    }
}

/// What is demanded of a scene's errors, by what each algorithm promises. Without a truth, that one
/// is there.
fn checks(scene: &SceneReport) -> Vec<Check> {
    let mut checks = Vec::new();
    for model in &scene.models {
        let named = OpticalModel::ALL
            .into_iter()
            .find(|m| m.name() == model.model)
            .expect("the report names models");
        let subject = format!("{} {}", scene.name, model.model);
        if model.truth().is_none() {
            checks.push(Check::without_truth(subject));
            continue;
        }
        for row in &model.rows {
            let Outcome::Drawn(drawn) = &row.outcome else {
                continue;
            };
            let convex = scene.convex == Some(true);
            let rough = convex.then_some(ROUGH_ORDER);
            let limit = limit(row.promise, named, &drawn.stats, rough);
            let (Some(limit), Some(error)) = (limit, &drawn.error) else {
                continue;
            };
            let subject = format!("{subject} {} {}", row.algorithm, row.setting);
            let found = (error.image.rmse, error.max_without(outliers(named)));
            let limit = (rmse_with_outliers(limit, named, model.size), limit.1);
            checks.push(Check::new(subject.trim_end().into(), found, limit));
        }
    }
    checks
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::tests::frame;
    use tetrascope::Promise;

    /// The checks of one row whose RMSE is 1.5e-4, in emission and absorption.
    fn checks_of(promise: Promise, convex: bool) -> Vec<Check> {
        let mut report = crate::report::tests::report("sphere");
        let scene = &mut report.scenes[0];
        scene.convex = Some(convex);
        scene.models[0].rows[1].promise = promise;
        checks(scene)
    }

    #[test]
    fn what_is_promised_is_demanded() {
        for (promise, convex, passed) in [
            (Promise::Exact, false, false),
            (Promise::Within(1e-3), false, true),
            (Promise::RoughOrder, true, true),
        ] {
            let checks = checks_of(promise, convex);
            assert_eq!(checks.len(), 1, "{promise:?}");
            assert_eq!(checks[0].passed, passed, "{promise:?}");
        }
    }

    #[test]
    fn nothing_is_demanded_where_nothing_is_promised() {
        assert!(checks_of(Promise::Open, true).is_empty());
        assert!(checks_of(Promise::RoughOrder, false).is_empty());
    }

    /// A report on a picture of 256×256 pixels that an exact algorithm changed so, judged.
    fn judged(change: impl Fn(&mut Frame)) -> crate::report::Report {
        let truth = frame(256, vec![[0.25, 0.5, 0.125, 0.75]; 256 * 256]);
        let mut image = truth.clone();
        change(&mut image);
        let mut report = crate::report::tests::report("sphere");
        let model = &mut report.scenes[0].models[0];
        model.size = [256, 256];
        let Outcome::Drawn(drawn) = &mut model.rows[1].outcome else {
            panic!("it is drawn");
        };
        drawn.error = Some(Errors::between(&truth, &image));
        report.checks = checks(&report.scenes[0]);
        report
    }

    #[test]
    fn identical_pictures_pass() {
        let report = judged(|_| ());
        assert_eq!(report.checks.len(), 1);
        assert!(report.passed());
    }

    /// Its RMSE is 1e-3 / √(4 · 256²) = 2e-6, which rounding may reach; 1e-3 it may not.
    #[test]
    fn one_pixel_that_differs_fails() {
        let report = judged(|image| image.pixels[9][1] += 1e-3);
        let check = &report.checks[0];
        assert!(check.rmse < Some(check.limit) && !report.passed());
    }

    #[test]
    fn a_difference_in_alpha_alone_fails() {
        assert!(!judged(|image| image.pixels.iter_mut().for_each(|p| p[3] += 1e-3)).passed());
    }

    #[test]
    fn not_a_number_fails() {
        assert!(!judged(|image| image.pixels[9][2] = f32::NAN).passed());
    }

    #[test]
    fn a_missing_truth_fails() {
        let mut report = judged(|_| ());
        report.scenes[0].models[0].rows[0].outcome = Outcome::Skipped("too large".into());
        report.checks = checks(&report.scenes[0]);
        assert_eq!(report.checks.len(), 1);
        assert!(!report.passed());
        report.scenes[0].models[0].rows.remove(0);
        report.checks = checks(&report.scenes[0]);
        assert!(!report.passed());
        assert!(report.checks[0].found().contains("no ground truth"));
    }

    #[test]
    fn no_check_at_all_fails() {
        let mut report = judged(|_| ());
        report.checks.clear();
        assert!(!report.passed());
        assert!(report.verdict().contains("nothing was checked"));
        // Where nothing is promised there is nothing to check.
        report.scenes[0].models[0].rows[1].promise = Promise::Open;
        assert!(report.passed());
        assert!(report.verdict().contains("no picture"));
    }
}
