//! Chooses an algorithm and its settings by what a picture needs: an error, a time, a memory.
//!
//! 1. `sample` casts some two thousand rays of the ground truth through the scene: how much work the
//!    picture is (`features`), and what it has to be in these pixels.
//! 2. `calibrate` has measured all `candidates` on a few small scenes, once for each machine,
//!    optical model and kind of volume; `cache` keeps that. `fit` makes sums of terms of it, which
//!    say what to expect of other scenes.
//! 3. `decide` tries the candidates of which most is expected on the scene itself, where
//!    `measure` draws them and the sample says how wrong they are, until no other is expected to
//!    be better.
//!
//! ```no_run
//! # fn main() -> Result<(), tetrascope::core::Error> {
//! use tetrascope::choose::{Chooser, Need};
//! use tetrascope::scene::{SceneFile, VolumeSource};
//! use tetrascope::{Context, volumes};
//!
//! let file = SceneFile::new(VolumeSource {
//!     file: Some("fin.vtu".into()),
//!     ..VolumeSource::default()
//! });
//! let volume = volumes::load(&file.volume)?.volume;
//! let scene = file.resolve(&volume)?;
//! let need = Need {
//!     error: Some(1e-3),
//!     ..Need::default()
//! };
//! let context = Context::new();
//! let mut chooser = Chooser::new(&context).telling(|line| eprintln!("{line}"));
//! let choice = chooser.choose(&volume, &scene.appearance, &scene.view, &need)?;
//! println!("{}", choice.report().join("\n"));
//! // `choice.frame` is the picture; another view of the volume is drawn by
//! let renderer = (choice.algorithm.build)(&context, &volume, &scene.appearance, &choice.settings)?;
//! # Ok(())
//! # }
//! ```
//!
//! # Limits
//! The truth has to draw the scene, so that grids which stay in their files are refused. What
//! counts as a frame's time is that of a frame once all is prepared; [`Found::prepare`] says what
//! that took. Memory is that of the volume ([`FrameStats::bytes_resident`]), not of images.

mod cache;
mod calibrate;
mod candidates;
mod decide;
mod features;
mod fit;
mod measure;
mod report;
mod sample;
mod words;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};
#[cfg(doc)]
use tetrascope_core::FrameStats;
use tetrascope_core::{Appearance, Error, Frame, OpticalModel, View, Volume};
use tetrascope_reference::{Reference, ReferenceOptions};

use crate::{Algorithm, Context, Settings};
use cache::Machine;
pub use cache::user_cache;
use calibrate::{Calibration, Kind, rmse};
use candidates::{Setup, candidates};
use decide::{Candidate, EXACT, decide};
use report::bytes;
use sample::Sample;
pub use sample::SampledError;

/// Frames of a trial are timed for so long.
const ENOUGH: Duration = Duration::from_millis(600);

/// The demands on a picture; `None` is not asked for.
///
/// With an error, the fastest setting is chosen that keeps it; without, the most exact one within
/// the budget. Where none can keep both, the error is kept and the budget gives way. The memory
/// never does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Need {
    /// The RMSE against the truth, over all pixels and channels of premultiplied linear RGBA.
    pub error: Option<f64>,
    /// The time of a frame: from the call until its pixels are in memory, once all is prepared.
    pub budget: Option<Duration>,
    /// Bytes that the volume may take, on the device or in memory.
    pub memory: Option<u64>,
}

/// How much is measured in a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effort {
    /// Every setting that a comparison tries, on scenes of up to some 60,000 cells: one or two minutes.
    #[default]
    Full,
    /// Each algorithm with its defaults alone, on two tiny scenes: for tests.
    Quick,
}

/// The expectations of a setting on a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Time of a frame.
    pub seconds: f64,
    /// A factor by which the time may be more or less, 1 or more.
    pub spread: f64,
    /// That the volume takes.
    pub bytes: f64,
    /// The least and the greatest RMSE.
    pub error: [f64; 2],
}

/// The measurements of a setting on a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    /// Time of a frame: the least of several, as everything else that the machine does only adds to it.
    pub seconds: f64,
    /// For what lasts between frames, such as the upload of the volume, seconds.
    pub prepare: f64,
    /// That the volume takes.
    pub bytes: u64,
    /// Against the truth.
    pub error: SampledError,
}

/// A demand that no setting keeps beside the rest.
#[derive(Clone, Debug, PartialEq)]
pub enum GivesWay {
    /// No setting is known to be as exact; RMSE.
    Error {
        /// The error that was asked for.
        wanted: f64,
        /// The error that came out, as far as the sample tells.
        found: f64,
    },
    /// No setting is as fast; seconds.
    Budget {
        /// The time that was asked for.
        wanted: f64,
        /// The time that came out.
        found: f64,
    },
}

/// A setting that was tried on the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// The algorithm, and settings where they are not its defaults.
    pub name: String,
    /// The expectations.
    pub expected: Expected,
    /// The measurements.
    pub found: Found,
}

/// A setting that could be chosen for a scene.
pub struct Considered {
    /// The algorithm, and settings where they are not its defaults.
    pub name: String,
    /// The algorithm.
    pub algorithm: &'static Algorithm,
    /// Its settings.
    pub settings: Settings,
    /// The expectations of it, before anything is tried.
    pub expected: Expected,
}

/// The choice for a scene, and the picture.
pub struct Choice {
    /// The algorithm.
    pub algorithm: &'static Algorithm,
    /// Its settings.
    pub settings: Settings,
    /// The demands.
    pub need: Need,
    /// The picture.
    pub frame: Frame,
    /// The trial of this setting.
    pub trial: Trial,
    /// All trials, in order, with this one.
    pub trials: Vec<Trial>,
    /// The demands that give way.
    pub gives_way: Vec<GivesWay>,
    /// How many settings there were to choose from.
    pub considered: usize,
    /// Settings that could not be drawn after all, a sentence each.
    pub failures: Vec<String>,
}

/// Chooses algorithms and settings on one machine.
pub struct Chooser<'a> {
    context: &'a Context,
    effort: Effort,
    folder: Option<PathBuf>,
    say: Box<dyn Fn(&str) + 'a>,
    /// `None` until the file is read.
    known: Option<Vec<Calibration>>,
}

impl Expected {
    /// The geometric mean of the errors.
    pub(crate) fn middle_error(&self) -> f64 {
        (self.error[0] * self.error[1]).sqrt()
    }
}

impl Need {
    /// Refuses a need of nothing, and numbers that no picture keeps.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what: String, help: &str| {
            Err(Error::Usage {
                what,
                help: Some(help.into()),
            })
        };
        match self {
            Need {
                error: None,
                budget: None,
                memory: None,
            } => wrong(
                "nothing that a picture has to keep".into(),
                "give an error, a budget or a memory",
            ),
            Need {
                error: Some(error), ..
            } if !(*error > 0.0 && error.is_finite()) => wrong(
                format!("an error of {error}"),
                "give an RMSE of more than 0, such as 1e-3",
            ),
            Need {
                budget: Some(Duration::ZERO),
                ..
            } => wrong("a budget of 0 s".into(), "give a time such as 16ms"),
            Need {
                memory: Some(0), ..
            } => wrong("a memory of 0 bytes".into(), "give a size such as 512MB"),
            _ => Ok(()),
        }
    }
}

impl<'a> Chooser<'a> {
    /// A chooser for what `context` draws on. It keeps measurements for itself alone.
    pub fn new(context: &'a Context) -> Chooser<'a> {
        Chooser {
            context,
            effort: Effort::default(),
            folder: None,
            say: Box::new(|_| ()),
            known: None,
        }
    }

    /// The same; measurements are kept in a file in this folder, such as [`user_cache`].
    pub fn keeping_in(self, folder: PathBuf) -> Chooser<'a> {
        Chooser {
            folder: Some(folder),
            known: None,
            ..self
        }
    }

    /// The same with another effort for calibrations.
    pub fn with_effort(self, effort: Effort) -> Chooser<'a> {
        Chooser { effort, ..self }
    }

    /// The same; `say` is told what is being measured, one line each.
    pub fn telling(self, say: impl Fn(&str) + 'a) -> Chooser<'a> {
        Chooser {
            say: Box::new(say),
            ..self
        }
    }

    /// Forgets what was measured of this machine, also what is in the file.
    pub fn recalibrate(&mut self) {
        self.known = Some(Vec::new());
    }

    /// Chooses by trials on the scene, and draws it.
    ///
    /// The first call for an optical model and a kind of volume calibrates, unless a file has it.
    ///
    /// # Errors
    /// [`Error::Usage`] where the need is invalid or nothing fits into its memory;
    /// [`Error::Unsupported`] where the truth does not draw the scene; what the last trial says
    /// where none succeeds.
    pub fn choose(
        &mut self,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
        need: &Need,
    ) -> Result<Choice, Error> {
        need.validate()?;
        let (sample, options) = self.options(volume, appearance, view)?;
        let groups: Vec<&str> = options.iter().map(|(s, _)| s.algorithm.name).collect();
        let group = |name: &str| groups.iter().position(|g| *g == name).unwrap_or_default();
        let candidate = |(setup, expected): &(Setup, Expected)| Candidate {
            group: group(setup.algorithm.name),
            expected: expected.clone(),
        };
        let all: Vec<Candidate> = options.iter().map(candidate).collect();
        let mut frames: BTreeMap<usize, Frame> = BTreeMap::new();
        let mut exact: Option<(usize, SampledError)> = None;
        let decision = decide(need, &all, &mut |index| {
            let setup = &options[index].0;
            (self.say)(&format!("trying {}", setup.name()));
            let drawn = measure::draw(self.context, volume, appearance, view, setup, ENOUGH)?;
            let mut error = sample.error(&drawn.frame);
            match &exact {
                Some((of, exact)) => {
                    error = error.beside(rmse(&frames[of], &drawn.frame), exact);
                }
                None if error.keeps(EXACT) => exact = Some((index, error.clone())),
                None => {}
            }
            let found = Found {
                seconds: drawn.seconds,
                prepare: drawn.prepare,
                bytes: drawn.frame.stats.bytes_resident,
                error,
            };
            frames.insert(index, drawn.frame);
            Ok(found)
        })?;
        let trial = |(index, found): &(usize, Found)| Trial {
            name: options[*index].0.name(),
            expected: options[*index].1.clone(),
            found: found.clone(),
        };
        let chosen = decision.trials.iter().find(|(i, _)| *i == decision.chosen);
        let chosen = chosen.expect("what is chosen was tried");
        let setup = &options[decision.chosen].0;
        let failures = decision.failures.iter();
        let failures = failures.map(|(i, error)| format!("{}: {error}", options[*i].0.name()));
        Ok(Choice {
            algorithm: setup.algorithm,
            settings: setup.settings.clone(),
            need: need.clone(),
            frame: frames.remove(&decision.chosen).expect("it was drawn"),
            trial: trial(chosen),
            trials: decision.trials.iter().map(trial).collect(),
            gives_way: decision.gives_way,
            considered: options.len(),
            failures: failures.collect(),
        })
    }

    /// All that there is to choose from for a scene, with what is expected of it.
    ///
    /// # Errors
    /// Where the truth does not draw the scene, and where it cannot be calibrated.
    pub fn considered(
        &mut self,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
    ) -> Result<Vec<Considered>, Error> {
        let (_, options) = self.options(volume, appearance, view)?;
        let considered = options.into_iter().map(|(setup, expected)| Considered {
            name: setup.name(),
            algorithm: setup.algorithm,
            settings: setup.settings,
            expected,
        });
        Ok(considered.collect())
    }

    /// As [`Chooser::considered`], but nothing is measured for it: empty where nothing was before
    /// of this optical model and kind of volume. `reference` draws the volume in this look.
    ///
    /// # Errors
    /// Those of [`Reference::render_pixels`].
    pub fn expected_if_measured(
        &mut self,
        reference: &Reference,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
    ) -> Result<Vec<Considered>, Error> {
        let (model, effort) = (appearance.optical_model, self.effort);
        if self.kept(model, Kind::of(volume)).is_none() {
            return Ok(Vec::new());
        }
        let sample = Sample::new(reference, volume, appearance, view)?;
        let Some(calibration) = self.kept(model, Kind::of(volume)) else {
            return Ok(Vec::new());
        };
        let considered = candidates(model, volume.kind(), effort)
            .into_iter()
            .filter_map(|setup| {
                let supports = setup.algorithm.supports;
                supports(volume, appearance, view, &setup.settings).ok()?;
                Some(Considered {
                    name: setup.name(),
                    expected: calibration.expect(&setup, &sample.features)?,
                    algorithm: setup.algorithm,
                    settings: setup.settings,
                })
            });
        Ok(considered.collect())
    }

    /// The truth of a scene, and what draws it, with what is expected.
    fn options(
        &mut self,
        volume: &Volume,
        appearance: &Appearance,
        view: &View,
    ) -> Result<(Sample, Vec<(Setup, Expected)>), Error> {
        let kind = Kind::of(volume);
        let reference = Reference::new(volume, appearance, &ReferenceOptions::default())?;
        let sample = Sample::new(&reference, volume, appearance, view)?;
        drop(reference);
        let (model, effort) = (appearance.optical_model, self.effort);
        let calibration = self.calibration(model, kind)?;
        let drawn = candidates(model, volume.kind(), effort)
            .into_iter()
            .filter_map(|setup| {
                let supports = setup.algorithm.supports;
                supports(volume, appearance, view, &setup.settings).ok()?;
                let expected = calibration.expect(&setup, &sample.features)?;
                Some((setup, expected))
            });
        let options = drawn.collect();
        Ok((sample, options))
    }

    /// The measurements of an optical model and a kind of volume; makes them if there are none.
    fn calibration(&mut self, model: OpticalModel, kind: Kind) -> Result<&Calibration, Error> {
        // Borrowed anew, as what is made is kept beside it.
        if self.kept(model, kind).is_some() {
            return Ok(self.kept(model, kind).expect("it is kept"));
        }
        let machine = Machine::of(self.context);
        let known = self.known.get_or_insert_default();
        let same = |c: &Calibration| (c.model, c.kind, c.effort) == (model, kind, self.effort);
        let begun = known.iter().position(same).unwrap_or_else(|| {
            known.push(Calibration::begin(model, kind, self.effort));
            known.len() - 1
        });
        let mut is_kept = true;
        while !known[begun].is_whole() {
            known[begun].measure_next(self.context, &self.say)?;
            if let Some(folder) = self.folder.as_ref().filter(|_| is_kept)
                && let Err(why) = cache::write(folder, &machine, known)
            {
                (self.say)(&format!("what was measured cannot be kept: {why}"));
                is_kept = false;
            }
        }
        Ok(&known[begun])
    }

    /// The measurements made before, if they are whole; reads the file at the first call.
    fn kept(&mut self, model: OpticalModel, kind: Kind) -> Option<&Calibration> {
        if self.known.is_none() {
            let read = match &self.folder {
                Some(folder) => cache::read(folder, &Machine::of(self.context)),
                None => Ok(Vec::new()),
            };
            self.known = Some(read.unwrap_or_else(|why| {
                (self.say)(&format!(
                    "what was measured is damaged and measured anew: {why}"
                ));
                Vec::new()
            }));
        }
        let effort = self.effort;
        let same = |c: &Calibration| (c.model, c.kind, c.effort) == (model, kind, effort);
        let mut known = self.known.iter().flatten();
        known.find(|c| same(c) && c.is_whole())
    }
}

#[cfg(test)]
mod tests;
