//! Stiff and extreme cases, drawn by every algorithm: who keeps what it promises on the day that data
//! is ugly.
//!
//! 1. [`suite`] is all cases: scenes, and what is known of their pictures (`case`), in emission and
//!    absorption; [`under`] is those that mean something in another optical model (`models`).
//! 2. The ground truth draws each and is held to what is known: closed forms, other pictures of the
//!    same, laws of physics.
//! 3. Every algorithm draws it with each setting that promises something, and with its default one, and
//!    is held to its promise (`judge`). Nothing may fail, be infinite, or take a minute.
//! 4. The `matrix` says how far each algorithm was from the truth in each case, and `page` shows it. What is
//!    wrong is `kept` as a scene that `tetrascope render` opens.

mod case;
mod geometry;
mod grids;
mod judge;
mod kept;
mod laws;
mod matrix;
mod models;
mod page;
mod scenes;
mod stiff;
mod stress;
mod values;
mod views;
mod watch;

pub use case::{Case, Expected, Group, Light, Shot};
pub use judge::{Judgment, Outcome};
pub use kept::keep;
pub use matrix::{Cell, Line, Matrix};
pub use models::{OTHERS, surfaces};
pub use stiff::row;

use std::path::PathBuf;
use std::time::Duration;

use tetrascope::core::{Error, OpticalModel};
use tetrascope::{Algorithm, Context, Promise, Settings};

use self::judge::{Truth, judge, judge_truth};
use self::watch::Watch;
use crate::output::{phase, print, progress, write};
use crate::{machine, setup};

/// Options of `cargo xtask stability`.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Options {
    /// Only cases whose name or group contains one of these [default: all]
    #[arg(value_name = "CASE")]
    pub cases: Vec<String>,
    /// Algorithms, separated by commas; the ground truth is always one [default: all]
    #[arg(long, value_delimiter = ',')]
    pub algorithms: Vec<String>,
    /// Optical models, separated by commas [default: all]
    #[arg(long, value_delimiter = ',', value_parser = model)]
    pub models: Vec<OpticalModel>,
    /// Draw what takes long, too
    #[arg(long)]
    pub long: bool,
    /// The folder of index.html, and of scenes that are drawn wrongly [default: target/stability]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// List the cases and draw none
    #[arg(long)]
    pub list: bool,
}

/// How long a picture may take before it counts as hanging: all take milliseconds.
const HANGS: Duration = Duration::from_secs(120);

/// The same of a case that is drawn where it is asked for: one step per pass takes minutes.
const LONG_HANGS: Duration = Duration::from_secs(1200);

/// Every case.
pub fn suite() -> Vec<Case> {
    let groups = [
        stiff::cases(),
        geometry::cases(),
        geometry::hard(),
        views::cases(),
        values::cases(),
        grids::cases(),
        laws::cases(),
    ];
    groups.into_iter().flatten().collect()
}

/// Those of the suite that mean something in this model, in it.
pub fn under(model: OpticalModel) -> Vec<Case> {
    let mut cases = suite();
    let is_of = |case: &Case| case.shots[0].appearance.optical_model == model;
    let others: Vec<Case> = cases
        .iter()
        .filter_map(|case| models::under(model, case))
        .collect();
    cases.retain(is_of);
    cases.extend(others);
    cases.sort_by_key(|case| case.group);
    cases
}

fn model(name: &str) -> Result<OpticalModel, String> {
    let found = OpticalModel::ALL.into_iter().find(|m| m.name() == name);
    let names = OpticalModel::ALL.map(OpticalModel::name).join(", ");
    found.ok_or_else(|| format!("the optical models are {names}"))
}

/// Cases that take minutes each, and are drawn where they are asked for.
pub fn long() -> Vec<Case> {
    vec![stiff::long_row()]
}

/// Draws the suite, prints the matrix, writes the page, and returns whether nothing is wrong.
pub fn run(options: &Options) -> Result<bool, Error> {
    let cases = chosen(options)?;
    if options.list {
        for case in &cases {
            print(&format!("{case:?}\n"))?;
        }
        return Ok(true);
    }
    let algorithms = algorithms(&options.algorithms)?;
    let adapter = match algorithms.iter().any(|algorithm| algorithm.needs_gpu) {
        true => setup::setup()
            .inspect_err(|error| eprintln!("{error}; drawing on the CPU alone"))
            .ok(),
        false => None,
    };
    let matrix = Matrix::draw(&cases, &algorithms, &Context::new())?;
    let ratios = stress::ratios(&cases)?;
    let stress = stress::sentence(&ratios);
    print(&format!("{}{stress}\n", matrix.to_table()))?;
    let folder = options
        .out
        .clone()
        .unwrap_or_else(|| machine::target().join("stability"));
    for (case, line) in cases.iter().zip(&matrix.lines) {
        if !line.is_well() {
            for (number, shot) in case.shots.iter().enumerate() {
                let path = keep(&folder, &format!("{case:?} {number}"), shot)?;
                eprintln!("kept {}", path.display());
            }
        }
    }
    let page = folder.join("index.html");
    write(&page, matrix.to_html(adapter.as_deref(), &stress))?;
    eprintln!("wrote {}", page.display());
    for fault in matrix.faults() {
        eprintln!("{fault}");
    }
    let too_long = ratios.iter().filter(|(_, ratio)| *ratio > stress::MOST);
    let too_long: Vec<&String> = too_long.map(|(case, _)| case).collect();
    for case in &too_long {
        eprintln!(
            "{case}: the ground truth takes more than {} times as long",
            stress::MOST
        );
    }
    eprintln!("{}", matrix.verdict());
    Ok(matrix.passed() && too_long.is_empty())
}

/// The cases of the models that are asked for whose names contain one of those that are.
fn chosen(options: &Options) -> Result<Vec<Case>, Error> {
    let is_asked = |m: &OpticalModel| options.models.is_empty() || options.models.contains(m);
    let models = OpticalModel::ALL.into_iter().filter(is_asked);
    let mut cases: Vec<Case> = models.flat_map(under).collect();
    if options.long {
        cases.extend(long());
    }
    cases.sort_by_key(|case| case.group);
    let names = &options.cases;
    let is_named = |case: &Case, name: &String| format!("{case:?}").contains(name.as_str());
    if let Some(name) = names
        .iter()
        .find(|name| !cases.iter().any(|case| is_named(case, name)))
    {
        return Err(Error::Usage {
            what: format!("no case has '{name}' in its name"),
            help: Some("`cargo xtask stability --list` lists them".into()),
        });
    }
    cases.retain(|case| names.is_empty() || names.iter().any(|name| is_named(case, name)));
    Ok(cases)
}

/// Those that were asked for, in the registry's order, without the ground truth.
fn algorithms(names: &[String]) -> Result<Vec<&'static Algorithm>, Error> {
    for name in names {
        tetrascope::algorithm(name)?;
    }
    let is_asked = |a: &&Algorithm| names.is_empty() || names.iter().any(|name| name == a.name);
    let others = tetrascope::algorithms().iter().filter(|a| !a.is_truth());
    Ok(others.filter(is_asked).collect())
}

impl Matrix {
    /// Draws `cases` with the ground truth and with these algorithms.
    ///
    /// # Errors
    /// The ground truth does not draw a case.
    pub fn draw(
        cases: &[Case],
        algorithms: &[&'static Algorithm],
        context: &Context,
    ) -> Result<Matrix, Error> {
        let progress = progress(cases.len() as u64);
        let columns = algorithms.iter().map(|algorithm| algorithm.name);
        let mut matrix = Matrix::new(columns.collect());
        for case in cases {
            let watch = Watch::new(if case.is_long { LONG_HANGS } else { HANGS });
            phase(&progress, &format!("{case:?}"));
            let draw = |shot| {
                let _watched = watch.over(format!("{case:?}: the ground truth"));
                Truth::of(shot, &case.expected)
            };
            let truths = case.shots.iter().map(draw).collect::<Result<Vec<_>, _>>()?;
            let cells = algorithms.iter().map(|algorithm| {
                if algorithm.needs_gpu && context.gpu().is_err() {
                    return Cell::NotDrawn("there is no graphics adapter".into());
                }
                let of = |setting: &'static str| {
                    let _watched = watch.over(format!("{case:?}: {} {setting}", algorithm.name));
                    (setting, judge(case, &truths, (algorithm, setting), context))
                };
                Cell::of(settings(algorithm, case).into_iter().map(of).collect())
            });
            matrix.lines.push(Line {
                group: case.group,
                name: case.name.clone(),
                truth: judge_truth(case, &truths),
                cells: cells.collect(),
            });
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(matrix)
    }
}

/// Thresholds at which rays may stop, beside those of the sweep.
const STOPS: [&str; 2] = ["stop-opacity=0.5", "stop-opacity=0.99999994"];

/// The settings to draw: from the sweep under a case's optical model, those that promise something, and the first, which
/// is the most usual; where it is stiff, rays that stop early, too.
fn settings(algorithm: &Algorithm, case: &Case) -> Vec<&'static str> {
    let model = case.shots[0].appearance.optical_model;
    let sweep = (algorithm.sweep)(model).iter().copied().enumerate();
    let is_held = |(i, setting): &(usize, &'static str)| {
        let settings = Settings::parse(algorithm, setting.split(',')).expect("the sweep is valid");
        *i == 0 || (algorithm.promise)(&settings) != Promise::Open
    };
    let held = sweep.filter(is_held).map(|(_, setting)| setting);
    let stops = STOPS.into_iter().filter(|stop| {
        case.group == Group::Stiff && Settings::parse(algorithm, stop.split(',')).is_ok()
    });
    held.chain(stops).collect()
}
