//! The thread that compares complete pictures with the truth.
//!
//! Where the truth is cheap enough, a sample of pixels says how wrong each complete picture is;
//! the difference in all pixels is drawn when it is asked for. Both end when an input comes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;
use serde_json::json;
use tetrascope_core::colormap::Colormap;
use tetrascope_core::{Appearance, Error, Frame, FrameStats, Stop, VolumeRenderer as _};
use tetrascope_reference::{Reference, ReferenceOptions};

use super::encoded::{Caption, Encoded, Kind};
use super::quick::Expectation;
use super::renderers::Setup;
use super::session::Event;
use super::shared::{Complete, Shared};
use super::state::Field;
use crate::choose::{Chooser, SampledError};

/// Wakes now and then, should nobody wake it.
const LONG: Duration = Duration::from_secs(3600);

/// The most cells of a volume whose error is told unasked: the truth keeps some 200 bytes of each.
const UNASKED: usize = 4_000_000;

/// Decades below the greatest difference that are shown.
const DECADES: f64 = 4.0;

/// How wrong a complete picture is.
#[derive(Clone, Debug, Serialize)]
pub struct Estimate {
    /// The version of the state.
    pub version: u64,
    /// By a sample of the truth; `None` if there is none.
    pub error: Option<SampledError>,
    /// Why there is none.
    pub why: Option<String>,
    /// Whether it is there for the asking.
    pub on_demand: bool,
    /// Seconds.
    pub seconds: f64,
}

/// The truth of a volume in a look.
struct Truth {
    reference: Reference,
    field: Arc<Field>,
    appearance: Appearance,
}

/// The task for a complete picture.
enum Task {
    Estimate,
    Difference,
}

pub(crate) fn work(shared: &Shared) {
    let stop = Stop::new();
    let mut truth: Option<Truth> = None;
    // Models and kinds of volume whose measurements were looked up.
    let mut asked = Vec::new();
    while let Some((task, complete)) = next(shared, &stop) {
        let version = complete.state.version;
        let begun = Instant::now();
        let result = judge(shared, &mut truth, &stop, &task, &complete, &mut asked);
        shared.update(|inbox| inbox.judge_stop = None);
        match result {
            Ok(()) => {}
            Err(Error::Stopped) => continue,
            Err(error) => {
                let estimate = Estimate {
                    version,
                    error: None,
                    why: Some(error.to_string()),
                    on_demand: false,
                    seconds: begun.elapsed().as_secs_f64(),
                };
                (shared.tell)(Event::Estimate(Arc::new(estimate)));
                if matches!(task, Task::Difference) {
                    shared.problem(&error, None);
                }
            }
        }
        shared.update(|inbox| match task {
            Task::Estimate => (inbox.judged, inbox.wants_estimate) = (version, false),
            Task::Difference => inbox.differed = version,
        });
    }
}

/// Waits for a complete picture that is to be judged; `None` at the end.
fn next(shared: &Shared, stop: &Stop) -> Option<(Task, Complete)> {
    let mut inbox = shared.lock();
    loop {
        if inbox.is_closing {
            return None;
        }
        let version = inbox.state.version;
        let complete = inbox.complete.clone();
        let complete = complete.filter(|c| c.state.version == version && inbox.rests().is_ok());
        if let Some(complete) = complete {
            let task = if inbox.wants_difference && inbox.differed != version {
                Some(Task::Difference)
            } else if inbox.judged != version {
                let cells = complete.state.field.volume().cell_count();
                if cells <= UNASKED || inbox.wants_estimate {
                    Some(Task::Estimate)
                } else {
                    inbox.judged = version;
                    let estimate = Estimate {
                        version,
                        error: None,
                        why: None,
                        on_demand: true,
                        seconds: 0.0,
                    };
                    (shared.tell)(Event::Estimate(Arc::new(estimate)));
                    None
                }
            } else if inbox.wants_estimate {
                Some(Task::Estimate)
            } else {
                None
            };
            if let Some(task) = task {
                stop.clear();
                inbox.judge_stop = Some(stop.clone());
                return Some((task, complete));
            }
        }
        let wait = inbox.rests().err().unwrap_or(LONG);
        inbox = shared.wait(inbox, wait);
    }
}

fn judge(
    shared: &Shared,
    truth: &mut Option<Truth>,
    stop: &Stop,
    task: &Task,
    complete: &Complete,
    asked: &mut Vec<(tetrascope_core::OpticalModel, u64)>,
) -> Result<(), Error> {
    let begun = Instant::now();
    let state = &complete.state;
    let (field, scene) = (&state.field, &state.scene);
    let reference = follow(truth, stop, field, &scene.appearance)?;
    stop.check()?;
    match task {
        Task::Estimate => {
            let volume = field.volume();
            let key = (scene.appearance.optical_model, field.id);
            if let Some(folder) = &shared.measurements
                && !asked.contains(&key)
                && has_measurements(folder)
            {
                asked.push(key);
                let mut chooser = Chooser::new(shared.renderers.context());
                chooser = chooser.keeping_in(folder.clone());
                let expected = chooser.expected_if_measured(
                    reference,
                    volume,
                    &scene.appearance,
                    &scene.view,
                )?;
                let expected = expected.into_iter().map(|considered| Expectation {
                    setup: Setup {
                        algorithm: considered.algorithm,
                        settings: considered.settings,
                    },
                    seconds: considered.expected.seconds,
                    error: considered.expected.error[1],
                });
                *shared.measured.lock().expect("nothing panics with it") = expected.collect();
            }
            let error = SampledError::of(
                reference,
                volume,
                &scene.appearance,
                &scene.view,
                &complete.frame,
            )?;
            let estimate = Estimate {
                version: state.version,
                error: Some(error),
                why: None,
                on_demand: false,
                seconds: begun.elapsed().as_secs_f64(),
            };
            (shared.tell)(Event::Estimate(Arc::new(estimate)));
        }
        Task::Difference => {
            // A message for each percent, whatever threads say.
            let told = AtomicU32::new(0);
            let tell = |share: f64| {
                let percent = (100.0 * share) as u32;
                if told.fetch_max(percent, Ordering::Relaxed) < percent {
                    (shared.tell)(Event::Progress(state.version, share));
                }
            };
            let image = reference.render_with_progress(&scene.view, &tell)?;
            let draw = begun.elapsed();
            let (picture, found) = difference(&complete.frame, &image.pixels);
            let bound = image.error_bound.iter().copied().fold(0.0, f64::max);
            let caption = Caption {
                id: shared.next_picture(),
                version: state.version,
                kind: Kind::Difference,
                full: [picture.width, picture.height],
                setup: &complete.setup,
                input: None,
                waited: Duration::ZERO,
                draw,
                adapter: None,
                more: json!({
                    "rmse": found.rmse,
                    "greatest": found.greatest,
                    "decades": DECADES,
                    "truth_bound": bound,
                }),
            };
            let encoded = Encoded::new(&picture, caption)?;
            (shared.tell)(Event::Picture(Arc::new(encoded)));
        }
    }
    Ok(())
}

/// The truth of this volume in this look; its BVH is made anew only for another geometry.
fn follow<'a>(
    truth: &'a mut Option<Truth>,
    stop: &Stop,
    field: &Arc<Field>,
    appearance: &Appearance,
) -> Result<&'a Reference, Error> {
    if let Some(kept) = truth {
        let mut follow = || {
            if kept.field.id != field.id {
                kept.reference.reload(field.volume())?;
                kept.field = field.clone();
            }
            if kept.appearance != *appearance {
                kept.reference.restyle(appearance)?;
                kept.appearance = appearance.clone();
            }
            Ok::<(), Error>(())
        };
        if follow().is_err() {
            *truth = None;
        }
    }
    if truth.is_none() {
        let options = ReferenceOptions::default();
        let reference = Reference::new(field.volume(), appearance, &options)?;
        *truth = Some(Truth {
            reference: reference.with_stop(stop.clone()),
            field: field.clone(),
            appearance: appearance.clone(),
        });
    }
    Ok(&truth.as_ref().expect("made above").reference)
}

fn has_measurements(folder: &std::path::Path) -> bool {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return false;
    };
    entries.flatten().any(|entry| {
        let name = entry.file_name();
        name.to_string_lossy().starts_with("calibration-")
    })
}

/// Differences of a picture to the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Differences {
    /// Over all pixels and channels of premultiplied linear RGBA.
    pub(crate) rmse: f64,
    /// The greatest difference of a channel.
    pub(crate) greatest: f64,
}

/// The differences, and a picture of them: the greatest of each pixel's channels on a logarithmic
/// scale of [`DECADES`] below the greatest of all, in the colors of inferno.
pub(crate) fn difference(frame: &Frame, truth: &[[f64; 4]]) -> (Frame, Differences) {
    let (mut squares, mut greatest) = (0.0, 0.0_f64);
    let mut worst = Vec::with_capacity(truth.len());
    for (pixel, truth) in frame.pixels.iter().zip(truth) {
        let mut most = 0.0_f64;
        for (a, b) in pixel.iter().zip(truth) {
            let off = (f64::from(*a) - b).abs();
            // NaN is as wrong as can be.
            let off = if off.is_nan() { f64::INFINITY } else { off };
            squares += off * off;
            most = most.max(off);
        }
        greatest = greatest.max(most);
        worst.push(most);
    }
    let color = |off: &f64| {
        let share = match *off > 0.0 {
            true => 1.0 + (off / greatest).log10() / DECADES,
            false => 0.0,
        };
        // Infinite over infinite is as wrong as can be, too.
        let share = if share.is_nan() { 1.0 } else { share };
        let [r, g, b] = Colormap::Inferno.linear_rgb(share).as_vec3().to_array();
        [r, g, b, 1.0]
    };
    let pixels = worst.iter().map(color).collect();
    let size = (frame.width, frame.height);
    let picture = Frame::new(size, pixels, FrameStats::default());
    let rmse = (squares / (4.0 * truth.len().max(1) as f64)).sqrt();
    (picture, Differences { rmse, greatest })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_are_counted_over_all_channels_and_the_worst_is_brightest() {
        let mut frame = Frame::new((2, 2), vec![[0.5; 4]; 4], FrameStats::default());
        let truth = vec![[0.5; 4]; 4];
        let (picture, none) = difference(&frame, &truth);
        assert_eq!((none.rmse, none.greatest), (0.0, 0.0));
        let darkest = picture.pixels[0];
        assert!(picture.pixels.iter().all(|p| *p == darkest));
        frame.pixels[1][2] = 0.75;
        frame.pixels[2][0] = 0.5 + 0.25 / 1e5;
        let (picture, found) = difference(&frame, &truth);
        // One channel of sixteen is off by a quarter.
        assert!((found.rmse - 0.25 / 4.0).abs() < 1e-9 && found.greatest == 0.25);
        let light = |i: usize| picture.pixels[i][..3].iter().sum::<f32>();
        assert!(
            light(1) > light(0) && light(2) == light(0),
            "five decades below"
        );
        frame.pixels[3][1] = f32::NAN;
        let (picture, found) = difference(&frame, &truth);
        assert_eq!((found.rmse, found.greatest), (f64::INFINITY, f64::INFINITY));
        assert!(picture.pixels[3][0] > picture.pixels[0][0]);
    }
}
