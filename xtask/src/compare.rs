//! Draws scenes with every algorithm and sets error against time.
//!
//! 1. `plan` turns names and files into scenes.
//! 2. `contender`s are built, one an algorithm and setting; the ground truth draws.
//! 3. Frames are drawn in turn, so that what slows the machine slows all alike.
//! 4. `judge` compares errors with what was promised, and the report is written.
//!
//! Finished parts of a run are kept in `parts`, from which the same run goes on if it was interrupted.

mod contender;
mod judge;
mod parts;
pub mod peak;
mod peer;
mod plan;
mod scaling;

pub use plan::resolve;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use tetrascope::Context;
use tetrascope::choose::Need;
use tetrascope::core::{Error, Volume};
use tetrascope::scene::Scene;
use tetrascope_testing::ImageError;

use self::contender::{Contender, milliseconds};
use self::judge::{checks, model_report, truth_of};
use self::parts::{Part, Parts};
use self::peer::Peer;
use crate::answer::winners;
use crate::output::{phase, print, progress, write};
use crate::picture::{shown, signed_map};
use crate::report::{
    Difference, Extras, ModelReport, Outcome, Picture, Pictures, Row, SceneReport,
};
use crate::{figures, machine, setup, sweep};

/// Options of `cargo xtask compare`.
#[derive(Clone, Debug, clap::Args)]
pub struct Options {
    /// Mesh files, scene files (.toml, .json) or data sets [default: sphere heat-sink angiography]
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
    /// Name the fastest setting of each scene whose RMSE is at most this, as 1e-3
    #[arg(long, value_name = "RMSE", value_parser = Need::parse_error)]
    pub error: Option<f64>,
    /// Name the most exact setting of each scene that draws in this time, as 16ms
    #[arg(long, value_name = "TIME", value_parser = Need::parse_budget)]
    pub budget: Option<Duration>,
    /// Draw with another program's renderers, too: VTK's by Python
    #[arg(long, value_parser = [peer::VTK])]
    pub peer: Option<String>,
    /// Measure how times grow with cells and pixels, too: some minutes more
    #[arg(long)]
    pub scaling: bool,
    /// Measure the most memory that each takes, in a process of its own: as long again
    #[arg(long)]
    pub memory: bool,
    /// Small meshes and pictures and one timed frame: are all bounds kept?
    #[arg(long, conflicts_with_all = ["size", "repeat"])]
    pub check: bool,
}

/// Runs the comparison, prints the table and writes the report.
///
/// Returns whether every error is within its bound.
pub fn run(options: &Options) -> Result<bool, Error> {
    let plan = plan::plan(options)?;
    let peer = options.peer.as_ref().map(|_| Peer::find()).transpose()?;
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
    let folder = options
        .out
        .clone()
        .unwrap_or_else(|| machine::target().join("compare"));
    let version = peer.as_ref().map(|peer| peer.version.as_str());
    let parts = Parts::open(&folder, options, (adapter.as_ref().ok(), version));
    let context = Context::new();
    let mut report = machine::describe(adapter, plan.repeat);
    report.machine.peer = version.map(String::from);
    let mut pictures = Pictures::default();
    let progress = progress(plan.scenes.iter().map(|s| s.models.len() as u64).sum());
    let session = Session {
        context: &context,
        plan: &plan,
        peer: peer.as_ref(),
        memory: options.memory,
        parts: &parts,
        progress: &progress,
    };
    for index in 0..plan.scenes.len() {
        let (scene, resumed) = session.scene(index, &mut pictures)?;
        report.checks.extend(checks(&scene));
        report.scenes.push(scene);
        report.resumed += resumed;
    }
    if options.scaling {
        report.scaling = scaling::measure(&context, &plan, &progress)?;
    }
    progress.finish_and_clear();
    let mut extras = Extras {
        figures: Vec::new(),
        machine: sweep::last(),
    };
    for algorithm in &plan.algorithms {
        let drawn =
            |row: &Row| row.algorithm == algorithm.name && matches!(row.outcome, Outcome::Drawn(_));
        let mut models = report.scenes.iter().flat_map(|scene| &scene.models);
        if models.any(|model| model.rows.iter().any(drawn)) {
            extras.figures.extend(figures::measured(algorithm));
        }
    }

    match options.json {
        true => print(&report.to_json())?,
        false => print(&report.to_table())?,
    }
    let need = Need {
        error: options.error,
        budget: options.budget,
        memory: None,
    };
    if need != Need::default() && !options.json {
        for winner in winners(&report, &need) {
            print(&format!("{}\n", winner.says()))?;
        }
    }
    let page = folder.join("index.html");
    write(&folder.join("report.json"), report.to_json())?;
    write(&page, report.to_html(&pictures, &extras))?;
    parts.finish();
    if report.resumed > 0 {
        eprintln!(
            "{} pictures are those of a run that was interrupted",
            report.resumed
        );
    }
    eprintln!("wrote {}", page.display());
    for miss in report.checks.iter().filter(|check| !check.passed) {
        eprintln!("missed: {}: {}", miss.subject, miss.found());
    }
    eprintln!("{}", report.verdict());
    Ok(report.passed())
}

/// Things that drawing a scene needs.
struct Session<'a> {
    context: &'a Context,
    plan: &'a plan::Plan,
    peer: Option<&'a Peer>,
    memory: bool,
    parts: &'a Parts,
    progress: &'a ProgressBar,
}

impl Session<'_> {
    /// Compares under each optical model of one scene, and says how many of them an earlier run has
    /// done.
    fn scene(&self, index: usize, pictures: &mut Pictures) -> Result<(SceneReport, usize), Error> {
        let planned = &self.plan.scenes[index];
        phase(self.progress, &format!("{}: loading", planned.name));
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
        let mut resumed = 0;
        for (m, &model) in planned.models.iter().enumerate() {
            let mut scene = plan::resolve(&planned.file, model, volume)?;
            if planned.orthographic {
                scene.view.camera = scene.view.camera.to_orthographic();
            }
            let place = (index, m);
            let what = format!("{}: {}", planned.name, model.name());
            let part = match self.parts.read(place, &scene, &report.sha256) {
                Some(part) => {
                    phase(self.progress, &format!("{what}: done before"));
                    resumed += 1;
                    part
                }
                None => {
                    phase(self.progress, &what);
                    let contenders = self.draw(volume, &scene, &what)?;
                    let mut part = Part {
                        model: model_report(&scene, model, &contenders),
                        pictures: show(&contenders),
                    };
                    if self.memory {
                        self.measure_memory(&mut part.model, &what);
                    }
                    let truth = truth_of(&contenders).map(|(_, frame)| frame);
                    if let Some((peer, truth)) = self.peer.zip(truth) {
                        phase(self.progress, &format!("{what}: {}", peer.version));
                        let (context, repeat) = (self.context, self.plan.repeat);
                        let drawn = peer.draw(context, volume, &scene, truth, repeat)?;
                        part.model.rows.extend(drawn.0);
                        // One of its mappers is enough to look at.
                        part.pictures.extend(drawn.1.into_iter().next());
                    }
                    self.parts.write(place, &part, &report.sha256)?;
                    part
                }
            };
            report.models.push(part.model);
            pictures.insert(place, part.pictures);
            self.progress.inc(1);
        }
        Ok((report, resumed))
    }

    /// The most memory that each row's picture takes.
    fn measure_memory(&self, model: &mut ModelReport, what: &str) {
        phase(self.progress, &format!("{what}: memory"));
        for row in &mut model.rows {
            if let Outcome::Drawn(drawn) = &mut row.outcome {
                drawn.peak_bytes = peak::of(&model.scene, &row.algorithm, &row.setting);
            }
        }
    }

    /// Builds every contender and draws its frames, the ground truth's first.
    fn draw(&self, volume: &Volume, scene: &Scene, what: &str) -> Result<Vec<Contender>, Error> {
        let mut contenders = Vec::new();
        for &algorithm in &self.plan.algorithms {
            for setting in algorithm.sweep_of(scene.appearance.optical_model, volume.kind()) {
                self.progress
                    .set_message(format!("{what}: {} {setting}", algorithm.name));
                let mut contender =
                    Contender::new(self.context, (algorithm, setting), volume, scene)?;
                contender.draw(scene, 0);
                contenders.push(contender);
            }
        }
        for round in 1..=self.plan.repeat {
            self.progress.set_message(format!(
                "{what}: frame {round} of {} of each",
                self.plan.repeat
            ));
            for contender in &mut contenders {
                contender.draw(scene, round);
            }
        }
        for contender in &mut contenders {
            contender.restyle(scene);
        }
        Ok(contenders)
    }
}

/// The pictures: the truth, then each algorithm with its defaults, or with the first setting that
/// draws. Others are told apart by their numbers.
fn show(contenders: &[Contender]) -> Vec<Picture> {
    let truth = truth_of(contenders).map(|(_, frame)| frame);
    let by_algorithm = contenders.chunk_by(|a, b| a.algorithm.name == b.algorithm.name);
    let chosen = by_algorithm.filter_map(|settings| {
        let drawn = || settings.iter().filter(|c| c.frame.is_some());
        let contender = drawn().find(|c| c.is_default()).or(drawn().next())?;
        let frame = contender.frame.as_ref()?;
        let truth = truth.filter(|_| !contender.algorithm.is_truth());
        Some(Picture {
            algorithm: contender.algorithm.name.into(),
            setting: contender.setting.into(),
            image: shown(frame),
            difference: truth.map(|truth| Difference {
                map: signed_map(truth, frame),
                worst_pixel: ImageError::between(truth, frame).worst_pixel,
            }),
        })
    });
    chosen.collect()
}
