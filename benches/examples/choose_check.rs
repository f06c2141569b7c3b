//! How good choices are: on scenes that no calibration has, chosen settings against all others,
//! which are measured for it.
//!
//! With an error, a choice is good if its true RMSE is within the error and its time within 1.5
//! times that of the fastest that keeps it. With a budget, if its time is within the budget (and
//! 10 % of it, as times vary) and its RMSE within 1.5 times that of the most exact in time; where
//! nothing is in time, if its time is within 1.5 times the least.
//!
//! Arguments: the names of scenes, as below [default: all]. `TETRASCOPE_CACHE` names the folder for
//! calibrations [default: that of the user].

use std::path::PathBuf;
use std::time::{Duration, Instant};

use tetrascope::choose::{Chooser, Considered, Need, user_cache};
use tetrascope::core::{Error, Frame, OpticalModel, View, Volume, VolumeRenderer as _};
use tetrascope::reference::{Reference, ReferenceOptions};
use tetrascope::scene::{Scene, SceneFile, VolumeSource};
use tetrascope::{Context, Renderer, datasets, volumes};
use tetrascope_testing::ImageError;

/// An RMSE below which all are equally exact: rounding in f32.
const EXACT: f64 = 1e-5;

/// Rounds in which every setting draws a frame that is timed.
const ROUNDS: usize = 4;

/// A setting that took longer is not drawn again.
const SLOW: f64 = 3.0;

/// Name, data set, cells, width, height, model, whether it has a color map in place of its knots.
type Spec = (
    &'static str,
    &'static str,
    u64,
    u32,
    u32,
    OpticalModel,
    bool,
);

const SCENES: [Spec; 8] = [
    (
        "orbital",
        "orbital",
        30_000,
        192,
        192,
        OpticalModel::EmissionAbsorption,
        false,
    ),
    (
        "orbital-large",
        "orbital",
        150_000,
        128,
        128,
        OpticalModel::EmissionAbsorption,
        true,
    ),
    (
        "heat-sink",
        "heat-sink",
        20_000,
        320,
        240,
        OpticalModel::EmissionAbsorption,
        true,
    ),
    (
        "staircase",
        "staircase",
        5_000,
        256,
        256,
        OpticalModel::EmissionAbsorption,
        false,
    ),
    (
        "graded",
        "graded",
        40_000,
        160,
        160,
        OpticalModel::EmissionAbsorption,
        true,
    ),
    (
        "emission",
        "orbital",
        25_000,
        200,
        150,
        OpticalModel::Emission,
        false,
    ),
    (
        "absorption",
        "heat-sink",
        40_000,
        160,
        160,
        OpticalModel::Absorption,
        false,
    ),
    (
        "grid",
        "angiography",
        80,
        192,
        192,
        OpticalModel::EmissionAbsorption,
        true,
    ),
];

fn needs() -> Vec<(&'static str, Need)> {
    let error = |error| Need {
        error: Some(error),
        ..Need::default()
    };
    let budget = |milliseconds| Need {
        budget: Some(Duration::from_millis(milliseconds)),
        ..Need::default()
    };
    vec![
        ("error 1e-2", error(1e-2)),
        ("error 1e-3", error(1e-3)),
        ("budget 50 ms", budget(50)),
        ("budget 200 ms", budget(200)),
    ]
}

fn make(spec: &Spec) -> Result<(Volume, Scene), Error> {
    let &(_, name, cells, width, height, model, is_colorful) = spec;
    let (mut file, volume) = if name == "angiography" {
        let side = cells as usize;
        let grid = datasets::angiography([side, side, side / 2], 7)?;
        (SceneFile::new(VolumeSource::default()), Volume::Grid(grid))
    } else {
        let mut file = volumes::scene(datasets::find(name)?);
        file.volume.cells = Some(cells);
        let volume = volumes::load(&file.volume)?.volume;
        (file, volume)
    };
    if is_colorful {
        file.appearance.transfer_function = None;
    }
    file.appearance.optical_model = Some(model);
    (file.image.width, file.image.height) = (Some(width), Some(height));
    let scene = file.resolve(&volume)?;
    Ok((volume, scene))
}

/// A setting, as it is.
struct Measured {
    setting: Considered,
    renderer: Renderer,
    times: Vec<f64>,
    rmse: f64,
}

impl Measured {
    /// The least: what else the machine does only adds to it.
    fn seconds(&self) -> f64 {
        self.times.iter().copied().fold(f64::INFINITY, f64::min)
    }
}

fn measure(
    context: &Context,
    volume: &Volume,
    scene: &Scene,
    considered: Vec<Considered>,
) -> Result<Vec<Measured>, Error> {
    let view: &View = &scene.view;
    let truth = Reference::new(volume, &scene.appearance, &ReferenceOptions::default())?;
    let truth = truth.render_exact(view)?.pixels;
    let rmse = |frame: &Frame| ImageError::against(&truth, frame).rmse;
    let mut all = Vec::new();
    for setting in considered {
        let build = setting.algorithm.build;
        let drawn = build(context, volume, &scene.appearance, &setting.settings)
            .and_then(|renderer| Ok((renderer.render(view)?, renderer)));
        match drawn {
            Ok((frame, renderer)) => all.push(Measured {
                rmse: rmse(&frame),
                setting,
                renderer,
                times: Vec::new(),
            }),
            Err(error) => println!("    {}: {error}", setting.name),
        }
    }
    for _ in 0..ROUNDS {
        for measured in &mut all {
            if measured.times.iter().sum::<f64>() < SLOW {
                let start = Instant::now();
                measured.renderer.render(view)?;
                measured.times.push(start.elapsed().as_secs_f64());
            }
        }
    }
    Ok(all)
}

/// Whether the choice is good, and beside what.
fn judge<'a>(need: &Need, chosen: &Measured, all: &'a [Measured]) -> (bool, Option<&'a Measured>) {
    let fastest = |all: &mut dyn Iterator<Item = &'a Measured>| {
        all.min_by(|a, b| a.seconds().total_cmp(&b.seconds()))
    };
    let near = |best: &Measured| chosen.seconds() <= 1.5 * best.seconds();
    if let Some(error) = need.error {
        let best = fastest(&mut all.iter().filter(|m| m.rmse <= error));
        return (chosen.rmse <= error && best.is_some_and(near), best);
    }
    let budget = need.budget.unwrap_or(Duration::MAX).as_secs_f64();
    let in_time = all.iter().filter(|m| m.seconds() <= budget);
    let best = in_time.min_by(|a, b| {
        let rank = |m: &Measured| m.rmse.max(EXACT);
        let time = a.seconds().total_cmp(&b.seconds());
        rank(a).total_cmp(&rank(b)).then(time)
    });
    match best {
        Some(best) => {
            let good = chosen.seconds() <= 1.1 * budget;
            (
                good && chosen.rmse <= 1.5 * best.rmse.max(EXACT),
                Some(best),
            )
        }
        None => {
            let best = fastest(&mut all.iter());
            (best.is_some_and(near), best)
        }
    }
}

fn main() -> Result<(), Error> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let context = Context::new();
    let mut chooser = Chooser::new(&context).telling(|line| eprintln!("{line}"));
    let folder = std::env::var_os("TETRASCOPE_CACHE").map(PathBuf::from);
    if let Some(folder) = folder.or_else(user_cache) {
        chooser = chooser.keeping_in(folder);
    }
    let (mut good, mut cases) = (0, 0);
    for spec in &SCENES {
        if !wanted.is_empty() && !wanted.iter().any(|name| name == spec.0) {
            continue;
        }
        let (volume, scene) = make(spec)?;
        println!(
            "{}: {} cells, {}x{}",
            spec.0,
            volume.cell_count(),
            spec.3,
            spec.4
        );
        let mut choices = Vec::new();
        for (name, need) in needs() {
            let start = Instant::now();
            let choice = chooser.choose(&volume, &scene.appearance, &scene.view, &need)?;
            choices.push((name, need, choice, start.elapsed().as_secs_f64()));
        }
        let considered = chooser.considered(&volume, &scene.appearance, &scene.view)?;
        let all = measure(&context, &volume, &scene, considered)?;
        for m in &all {
            let Considered { name, expected, .. } = &m.setting;
            let [found, seconds, spread] =
                [m.seconds() * 1e3, expected.seconds * 1e3, expected.spread];
            let [least, greatest] = expected.error;
            let rmse = m.rmse;
            eprintln!(
                "    {name}: {found:.1} ms of {seconds:.1} (x{spread:.1}), {rmse:.1e} of {least:.0e} to {greatest:.0e}"
            );
        }
        let mut ratios: Vec<f64> = all
            .iter()
            .map(|m| (m.seconds() / m.setting.expected.seconds).ln())
            .collect();
        ratios.sort_by(f64::total_cmp);
        if let (Some(low), Some(high)) = (ratios.first(), ratios.last()) {
            let middle = ratios[ratios.len() / 2];
            println!(
                "  measured over expected: {:.2} to {:.2}, median {:.2}",
                low.exp(),
                high.exp(),
                middle.exp()
            );
        }
        for (name, need, choice, took) in choices {
            let Some(chosen) = all.iter().find(|m| m.setting.name == choice.trial.name) else {
                println!("  {name}: {} draws no longer", choice.trial.name);
                cases += 1;
                continue;
            };
            let (is_good, best) = judge(&need, chosen, &all);
            cases += 1;
            good += usize::from(is_good);
            let say = |m: &Measured| {
                let milliseconds = m.seconds() * 1e3;
                format!("{} ({milliseconds:.1} ms, {:.1e})", m.setting.name, m.rmse)
            };
            println!(
                "  {name}: {}: {}; best {}; {} trials, {took:.1} s in all, sampled {:.1e}",
                if is_good { "good" } else { "MISSED" },
                say(chosen),
                best.map_or("none".into(), say),
                choice.trials.len(),
                choice.trial.found.error.rmse,
            );
        }
    }
    println!("{good} of {cases} are within 1.5 times of the best");
    Ok(())
}
