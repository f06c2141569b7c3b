//! Measures every candidate on a few scenes, from which [`Fit`]s follow.
//!
//! The scenes differ in all that a time depends on: cells, pixels, how many of these the volume
//! covers, how many cells a ray meets, and knots of the transfer function. Smaller ones come
//! first, so that what is hopelessly slow is found out early and left out of the others.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};
use tetrascope_core::colormap::Colormap;
use tetrascope_core::{Error, Frame, OpticalModel, Volume, VolumeKind};
use tetrascope_datasets as datasets;
use tetrascope_reference::{Reference, ReferenceOptions};
use tetrascope_scene::{Scene, SceneFile, VolumeSource};

use super::candidates::{Setup, candidates};
use super::features::Features;
use super::fit::Fit;
use super::sample::Sample;
use super::{Effort, Expected, measure};
use crate::{Context, volumes};

/// Frames are timed for so long.
const ENOUGH: Duration = Duration::from_millis(100);

/// A setting is hopeless, and not tried on more scenes, if it takes more seconds for a frame than
/// the first and as many times those of the fastest as the second, or if it takes more than the
/// third in all. Exact ones are as exact and faster.
const HOPELESS: (f64, f64, f64) = (0.25, 8.0, 4.0);

/// A setting that was measured on fewer scenes is unknown.
const FEWEST: usize = 3;

/// No picture in f32 is nearer to the truth: numbers up to 1 are rounded by up to 2⁻²⁵.
const ROUNDING: f64 = 3e-8;

/// By how much an error may exceed all that were seen, or fall below them.
const ERROR_SPREAD: f64 = 1.5;

/// Between a scene's expected and measured time there is at least this factor, as machines have
/// other things to do; what a fit says of itself goes no further than the second.
const SPREAD: [f64; 2] = [1.3, 3.0];

/// Tetrahedra or voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    Mesh,
    Grid,
}

impl Kind {
    /// The kind of a volume.
    pub(crate) fn of(volume: &Volume) -> Kind {
        match volume {
            Volume::Grid(_) => Kind::Grid,
            _ => Kind::Mesh,
        }
    }

    /// The kind of the volumes that are measured for it.
    fn of_volumes(self) -> VolumeKind {
        match self {
            Kind::Mesh => VolumeKind::Mesh,
            Kind::Grid => VolumeKind::Grid,
        }
    }
}

/// The measurements for one optical model and kind of volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Calibration {
    pub(crate) model: OpticalModel,
    pub(crate) kind: Kind,
    pub(crate) effort: Effort,
    /// Those of the list of scenes that were measured: the first ones, where it was interrupted.
    scenes: Vec<Features>,
    measured: Vec<Measured>,
    /// Settings that are not tried on more scenes, by name.
    hopeless: Vec<String>,
}

/// One setting on one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Measured {
    algorithm: String,
    setting: String,
    /// The index of the scene.
    scene: usize,
    seconds: f64,
    bytes: f64,
    /// Against the truth, over all pixels.
    rmse: f64,
}

/// A scene to measure.
struct Spec {
    volume: Shape,
    side: u32,
    /// Whether a color map of many knots takes the place of the data set's few.
    is_colorful: bool,
    /// How much farther away than where the volume fills the picture.
    distance: f64,
}

enum Shape {
    /// A data set and its cells.
    Mesh(&'static str, u64),
    /// The angiography, samples along each axis.
    Grid([usize; 3]),
}

fn specs(kind: Kind, effort: Effort) -> Vec<Spec> {
    let spec = |volume, side, is_colorful, distance| Spec {
        volume,
        side,
        is_colorful,
        distance,
    };
    let mesh = Shape::Mesh;
    let grid = Shape::Grid;
    match (kind, effort) {
        (Kind::Mesh, Effort::Full) => vec![
            spec(mesh("sphere", 2_000), 48, false, 1.0),
            spec(mesh("delaunay", 3_000), 112, true, 1.0),
            spec(mesh("sphere", 8_000), 160, true, 2.5),
            spec(mesh("torus", 12_000), 144, false, 1.0),
            spec(mesh("delaunay", 20_000), 64, false, 1.0),
            spec(mesh("torus", 40_000), 48, true, 1.0),
            spec(mesh("sphere", 60_000), 112, true, 1.0),
            spec(mesh("delaunay", 60_000), 80, false, 1.0),
        ],
        (Kind::Grid, Effort::Full) => vec![
            spec(grid([24, 24, 12]), 48, true, 1.0),
            spec(grid([32, 32, 16]), 128, false, 1.0),
            spec(grid([48, 48, 24]), 160, true, 2.5),
            spec(grid([64, 64, 32]), 96, false, 1.0),
            spec(grid([96, 96, 24]), 112, true, 1.0),
            spec(grid([128, 128, 48]), 80, true, 1.0),
        ],
        (Kind::Mesh, Effort::Quick) => vec![
            spec(mesh("sphere", 600), 24, false, 1.0),
            spec(mesh("sphere", 1200), 48, false, 1.0),
        ],
        (Kind::Grid, Effort::Quick) => vec![
            spec(grid([8, 8, 4]), 24, false, 1.0),
            spec(grid([16, 16, 8]), 48, false, 1.0),
        ],
    }
}

impl Spec {
    fn make(&self, model: OpticalModel) -> Result<(Volume, Scene), Error> {
        let (mut file, volume) = match self.volume {
            Shape::Mesh(name, cells) => {
                let mut file = volumes::scene(datasets::find(name)?);
                file.volume.cells = Some(cells);
                let volume = volumes::load(&file.volume)?.volume;
                (file, volume)
            }
            Shape::Grid(dims) => {
                let grid = datasets::angiography(dims, 1)?;
                let file = SceneFile::new(VolumeSource::default());
                (file, Volume::Grid(grid))
            }
        };
        file.appearance.optical_model = Some(model);
        match (self.is_colorful, &self.volume) {
            (true, _) => {
                file.appearance.transfer_function = None;
                file.appearance.colormap = Some(Colormap::Viridis);
            }
            (false, Shape::Grid(_)) => {
                file.appearance.transfer_function = Some(datasets::find("sphere")?.look().knots);
                rescale(&mut file, &volume);
            }
            (false, Shape::Mesh(..)) => {}
        }
        (file.image.width, file.image.height) = (Some(self.side), Some(self.side));
        let mut scene = file.resolve(&volume)?;
        let camera = &mut scene.view.camera;
        camera.position = camera.focal_point.lerp(camera.position, self.distance);
        Ok((volume, scene))
    }
}

/// Stretches the transfer function's few knots over the volume's scalars, with an extinction that
/// leaves it half transparent.
fn rescale(file: &mut SceneFile, volume: &Volume) {
    let (Some(knots), Some((low, high))) = (
        &mut file.appearance.transfer_function,
        volume.scalar_range(),
    ) else {
        return;
    };
    let (first, last) = (knots[0].scalar, knots[knots.len() - 1].scalar);
    for knot in knots {
        let share = (knot.scalar - first) / (last - first);
        knot.scalar = low + share * (high - low);
        knot.extinction = share / volume.bounds().diagonal();
    }
}

impl Calibration {
    /// A calibration in which nothing was measured yet.
    pub(crate) fn begin(model: OpticalModel, kind: Kind, effort: Effort) -> Calibration {
        Calibration {
            model,
            kind,
            effort,
            scenes: Vec::new(),
            measured: Vec::new(),
            hopeless: Vec::new(),
        }
    }

    /// Whether every scene was measured.
    pub(crate) fn is_whole(&self) -> bool {
        self.scenes.len() >= specs(self.kind, self.effort).len()
    }

    /// Measures the next scene, unless all were; tells `say` which it is, and at the last what was left out.
    ///
    /// # Errors
    /// Where the ground truth does not draw; an algorithm that fails is left out. The calibration is as
    /// before then.
    pub(crate) fn measure_next(
        &mut self,
        context: &Context,
        say: &dyn Fn(&str),
    ) -> Result<(), Error> {
        let setups = candidates(self.model, self.kind.of_volumes(), self.effort);
        let specs = specs(self.kind, self.effort);
        let number = self.scenes.len();
        let Some(spec) = specs.get(number) else {
            return Ok(());
        };
        say(&format!(
            "calibrating, {} of {}: {} settings, once for this machine; if interrupted it goes on from here",
            number + 1,
            specs.len(),
            setups.len() - self.hopeless.len(),
        ));
        let (volume, scene) = spec.make(self.model)?;
        let reference = Reference::new(&volume, &scene.appearance, &ReferenceOptions::default())?;
        let truth = reference.render_exact(&scene.view)?.to_frame();
        let sample = Sample::new(&reference, &volume, &scene.appearance, &scene.view)?;
        let mut took = Vec::new();
        for setup in &setups {
            if self.hopeless.contains(&setup.name()) {
                continue;
            }
            let start = Instant::now();
            let measured = measured(context, setup, (&volume, &scene), &truth, number);
            if let Some(measured) = measured {
                took.push((setup, measured.seconds, start.elapsed().as_secs_f64()));
                self.measured.push(measured);
            }
        }
        self.scenes.push(sample.features);
        let fastest = took.iter().map(|t| t.1).fold(f64::INFINITY, f64::min);
        let (slow, times, in_all) = HOPELESS;
        for (setup, seconds, all) in took {
            // The truth is what is left where all else fails. The first scene compiles.
            let far = seconds > slow && seconds > times * fastest;
            let is_hopeless = far || (number > 0 && all > in_all);
            if is_hopeless && !setup.algorithm.is_truth() {
                self.hopeless.push(setup.name());
            }
        }
        if self.is_whole() && !self.hopeless.is_empty() {
            say(&format!(
                "  {} slow settings were measured on fewer scenes",
                self.hopeless.len()
            ));
        }
        Ok(())
    }

    /// The expectations of a setting on a scene; `None` if it was not measured.
    pub(crate) fn expect(&self, setup: &Setup, features: &Features) -> Option<Expected> {
        let of_setup =
            |m: &&Measured| m.algorithm == setup.algorithm.name && m.setting == setup.setting;
        let measured: Vec<&Measured> = self.measured.iter().filter(of_setup).collect();
        let scenes = measured.iter().filter_map(|m| self.scenes.get(m.scene));
        let scenes: Vec<&Features> = scenes.collect();
        if scenes.len() != measured.len() || scenes.len() < FEWEST.min(self.scenes.len()) {
            return None;
        }
        let of = |f: fn(&Measured) -> f64| measured.iter().map(|m| f(m)).collect::<Vec<f64>>();
        let times: Vec<[f64; 6]> = scenes.iter().map(|f| f.of_time()).collect();
        let sizes: Vec<[f64; 2]> = scenes.iter().map(|f| f.of_bytes()).collect();
        let time = Fit::new(&times, &of(|m| m.seconds.max(1e-9)))?;
        let memory = Fit::new(&sizes, &of(|m| m.bytes.max(1.0)))?;
        let errors = of(|m| m.rmse);
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let greatest = errors.iter().copied().fold(0.0, f64::max);
        Some(Expected {
            seconds: time.at(&features.of_time()),
            spread: time.spread.clamp(SPREAD[0], SPREAD[1]),
            bytes: memory.at(&features.of_bytes()),
            error: [
                (least / ERROR_SPREAD).max(ROUNDING),
                (greatest * ERROR_SPREAD).max(ROUNDING),
            ],
        })
    }
}

/// One setting on one scene; `None` if it does not draw it.
fn measured(
    context: &Context,
    setup: &Setup,
    (volume, scene): (&Volume, &Scene),
    truth: &Frame,
    number: usize,
) -> Option<Measured> {
    let Scene {
        appearance, view, ..
    } = scene;
    (setup.algorithm.supports)(volume, appearance, view, &setup.settings).ok()?;
    let drawn = measure::draw(context, volume, appearance, view, setup, ENOUGH).ok()?;
    let rmse = rmse(truth, &drawn.frame);
    rmse.is_finite().then(|| Measured {
        algorithm: setup.algorithm.name.into(),
        setting: setup.setting.into(),
        scene: number,
        seconds: drawn.seconds,
        bytes: drawn.frame.stats.bytes_resident as f64,
        rmse,
    })
}

/// √(mean of squared differences) over all pixels and channels.
pub(crate) fn rmse(truth: &Frame, frame: &Frame) -> f64 {
    let channels = truth
        .pixels
        .iter()
        .flatten()
        .zip(frame.pixels.iter().flatten());
    let squares = channels.map(|(t, p)| (f64::from(*t) - f64::from(*p)).powi(2));
    (squares.sum::<f64>() / (4 * truth.pixels.len().max(1)) as f64).sqrt()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A calibration in which nothing was measured but what is made up.
    pub(crate) fn made_up() -> Calibration {
        let (volume, scene) = specs(Kind::Mesh, Effort::Quick)[0]
            .make(OpticalModel::EmissionAbsorption)
            .expect("it is made");
        let options = ReferenceOptions::default();
        let reference = Reference::new(&volume, &scene.appearance, &options).expect("it draws");
        let sample = Sample::new(&reference, &volume, &scene.appearance, &scene.view);
        Calibration {
            model: OpticalModel::EmissionAbsorption,
            kind: Kind::Mesh,
            effort: Effort::Quick,
            scenes: vec![sample.expect("it draws").features],
            hopeless: Vec::new(),
            measured: vec![Measured {
                algorithm: "reference".into(),
                setting: String::new(),
                scene: 0,
                seconds: 0.25,
                bytes: 1e6,
                rmse: 1.0 / 3.0,
            }],
        }
    }

    #[test]
    fn every_scene_is_made_in_every_model() {
        for kind in [Kind::Mesh, Kind::Grid] {
            for model in OpticalModel::ALL {
                let specs = specs(kind, Effort::Quick);
                for spec in specs {
                    let (volume, scene) = spec.make(model).expect("it is made");
                    assert_eq!(scene.appearance.optical_model, model);
                    assert_eq!(matches!(volume, Volume::Grid(_)), kind == Kind::Grid);
                }
            }
        }
    }

    // What was kept of an interrupted run is gone on from, and nothing is measured twice.
    #[test]
    fn a_calibration_goes_on_where_it_was() {
        let context = Context::new();
        let mut calibration = Calibration::begin(OpticalModel::Emission, Kind::Grid, Effort::Quick);
        let lines = std::cell::RefCell::new(Vec::new());
        let say = |line: &str| lines.borrow_mut().push(line.to_owned());
        calibration.measure_next(&context, &say).expect("it draws");
        assert!(!calibration.is_whole());
        let text = serde_json::to_string(&calibration).expect("it is JSON");
        let mut read: Calibration = serde_json::from_str(&text).expect("it is JSON");
        read.measure_next(&context, &say).expect("it draws");
        assert!(read.is_whole());
        assert_eq!(read.scenes[..1], calibration.scenes);
        assert!(read.measured.starts_with(&calibration.measured));
        assert!(read.measured.len() > calibration.measured.len());
        let before = read.clone();
        read.measure_next(&context, &say).expect("there is none");
        assert_eq!(read, before);
        let lines = lines.into_inner();
        let scenes: Vec<&String> = lines.iter().filter(|l| l.contains("calibrating")).collect();
        assert!(
            scenes.len() == 2 && scenes[1].contains("2 of 2"),
            "{lines:?}"
        );
    }

    #[test]
    fn the_scene_that_was_measured_takes_what_it_took() {
        let calibration = made_up();
        let model = OpticalModel::EmissionAbsorption;
        let setups = candidates(model, VolumeKind::Mesh, Effort::Full);
        let features = &calibration.scenes[0];
        let expected = calibration.expect(&setups[0], features).expect("measured");
        assert!((expected.seconds - 0.25).abs() < 1e-9 && (expected.bytes - 1e6).abs() < 1.0);
        assert!((expected.error[1] - 0.5).abs() < 1e-12, "{expected:?}");
        if let Some(other) = setups.get(1) {
            assert_eq!(calibration.expect(other, features), None);
        }
    }

    #[test]
    fn a_scene_that_is_not_there_is_nothing_measured() {
        let mut calibration = made_up();
        calibration.measured[0].scene = 9;
        let model = OpticalModel::EmissionAbsorption;
        let setups = candidates(model, VolumeKind::Mesh, Effort::Quick);
        assert_eq!(calibration.expect(&setups[0], &calibration.scenes[0]), None);
    }
}
