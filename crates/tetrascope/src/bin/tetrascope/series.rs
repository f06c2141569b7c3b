//! `render` of a series: a frame for each step, all in one scene.
//!
//! [`Steps`] are the files, which [`pattern`], [`natural`] and collections put in order, or the
//! time steps of one file;
//! [`Common`] is what frames share, found from all steps before the first is drawn, so that
//! nothing flickers; [`frame_name`] names frames. One step is in memory at a time.

mod common;
mod frame_name;
mod natural;
mod pattern;
mod resume;
mod steps;
mod tally;

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use tetrascope::core::{Error, Volume, VolumeRenderer as _};
use tetrascope::io::Step;
use tetrascope::io::image::{self, write_image};
use tetrascope::provenance::Input;
use tetrascope::scene::Scene;
use tetrascope::volumes::{self, Loaded};
use tetrascope::{Algorithm, Context, Renderer, Settings, emptiness};

use crate::args::RenderArgs;
use crate::output::{Output, StepError, Stop, Watch};
use crate::picture::{Picture, Times};
use crate::render::{BYTES_PER_PIXEL, How};
use crate::scene::Request;

pub(crate) use common::Common;
pub(crate) use steps::Steps;
use steps::{choose, describe, frame_name};
use tally::Tally;

/// The hint for a frame that cannot be drawn.
const RESUME: &str = "--resume goes on with the frames that are not there yet";

pub(crate) fn run(args: &RenderArgs, steps: &Steps, how: How, output: &Output) -> Result<(), Stop> {
    let name = frame_name(args.output.as_deref())?;
    let numbers = steps.numbers(args.series.steps)?;
    image::check_path(&name.path(numbers[0]))?;
    let request = Request::new(&args.scene, Some(&steps.first().file))?;
    let shuffled = steps.is_shuffled.then(|| Error::Invalid {
        what: "the files are drawn as they are named, which is not the order of their numbers"
            .into(),
        help: Some("a quoted pattern, such as 'step_*.vtu', has step_2 before step_10".into()),
    });
    if let Some(warning) = &shuffled {
        output.warning(warning);
    }
    let common = match args.series.each_step {
        true => None,
        false => Some(Common::find(&request, steps, output)?),
    };

    let (algorithm, settings) = match how {
        How::Named(algorithm, settings) => (algorithm, settings),
        How::Need(need) => {
            // The first frame that is drawn speaks for all.
            let step = &steps.list[numbers[0]];
            let (loaded, scene) =
                load(&request, common.as_ref(), step, None).map_err(at(step, None))?;
            scene.view.check_memory(BYTES_PER_PIXEL)?;
            let scene = (&loaded.volume, &scene);
            let context = Context::new();
            let choice = args.need.choose(&need, scene, &context, output);
            let choice = choice.map_err(at(step, None))?;
            (choice.algorithm, choice.settings)
        }
    };

    let watch = output.watch(numbers.len());
    let context = match watch.progress() {
        Some(progress) => Context::new().with_progress(progress),
        None => Context::new(),
    };
    let mut series = Series {
        algorithm,
        settings,
        context,
        request,
        common,
        renderer: None,
        previous: None,
    };
    // What must not be drawn over is found before anything is drawn.
    let mut there = vec![false; numbers.len()];
    if args.series.resume {
        for (there, &number) in there.iter_mut().zip(&numbers) {
            *there = series.is_drawn(&steps.list[number], &name.path(number))?;
        }
    }
    let mut tally = Tally::default();
    for (&number, there) in numbers.iter().zip(there) {
        let step = &steps.list[number];
        let path = name.path(number);
        if there {
            tally.skip(step, &path);
            watch.end();
            continue;
        }
        watch.begin(&format!("frame {number}, {}", describe(step)));
        let started = Instant::now();
        let help = tally.has_frames().then_some(RESUME);
        let drawn = series.draw(step, &path, &watch).map_err(at(step, help))?;
        watch.end();
        let seconds = started.elapsed().as_secs_f64();
        let what = describe(step);
        watch.line(format_args!("{}: {what} ({seconds:.2} s)", path.display()));
        let (report, warning) = drawn;
        tally.add(step, &path, output.json().then_some(report), warning);
        if !output.json() {
            match watch.written(&path) {
                // Who has read enough of the names may want the frames still.
                Ok(()) | Err(Stop::ClosedPipe) => {}
                Err(stop) => return Err(stop),
            }
        }
    }
    drop(watch);
    let scene = series.common.map(|common| json!(common.scene.to_file()));
    tally.print(scene, shuffled.as_ref(), output)
}

/// Names the step's file in an error.
fn at(step: &Step, help: Option<&'static str>) -> impl FnOnce(Error) -> Stop {
    let file = step.file.clone();
    move |error| Stop::Step(Box::new(StepError { error, file, help }))
}

/// A series that is being drawn.
struct Series {
    algorithm: &'static Algorithm,
    settings: Settings,
    context: Context,
    request: Request,
    /// `None` if each step has a scene of its own.
    common: Option<Common>,
    /// Built for the first step that is drawn, and reloaded for the others.
    renderer: Option<Renderer>,
    /// The mesh that was drawn last: the next one may be in the same place.
    previous: Option<Volume>,
}

impl Series {
    /// Whether the frame of a step is there; an error if what is there is something else.
    fn is_drawn(&mut self, step: &Step, path: &Path) -> Result<bool, Stop> {
        if !path.exists() {
            return Ok(false);
        }
        let scene = match &self.common {
            Some(common) => common.scene_of(step),
            None => self.load(step).map_err(at(step, None))?.1,
        };
        let (algorithm, settings) = (self.algorithm, &self.settings);
        Ok(resume::is_drawn(path, algorithm, settings, &scene)?)
    }

    /// Draws a step and writes its frame; gives what is to be said of it, and why it shows
    /// nothing if so.
    fn draw(
        &mut self,
        step: &Step,
        path: &Path,
        watch: &Watch,
    ) -> Result<(Value, Option<Error>), Error> {
        let mut laps = Laps(Instant::now());
        let (loaded, scene) = self.load(step)?;
        let load = laps.next();
        let volume = &loaded.volume;
        (self.algorithm.supports)(volume, &scene.appearance, &scene.view, &self.settings)?;
        scene.view.check_memory(BYTES_PER_PIXEL)?;
        let inputs = Input::all_of(&loaded)?;
        laps.next();
        let renderer = match (&mut self.renderer, &self.common) {
            (Some(renderer), Some(_)) => {
                renderer.reload(volume)?;
                renderer
            }
            // What a restyle keeps would depend on the steps before.
            (slot, _) => {
                let build = self.algorithm.build;
                slot.insert(build(
                    &self.context,
                    volume,
                    &scene.appearance,
                    &self.settings,
                )?)
            }
        };
        let prepare = laps.next();
        let frame = renderer.render(&scene.view)?;
        let render = laps.next();
        for note in &frame.stats.notes {
            watch.detail(format_args!("  {note}"));
        }
        let warning = emptiness::explain(volume, &scene.appearance, &scene.view, &frame);
        laps.next();
        let picture = Picture {
            algorithm: self.algorithm,
            settings: self.settings.clone(),
            loaded: &loaded,
            inputs,
            scene,
            adapter: self.context.adapter(),
            frame,
        };
        let metadata = picture.metadata();
        write_image(path, &picture.frame, &metadata)?;
        for line in picture.statistics() {
            watch.detail(format_args!("  {line}"));
        }
        let times = Times {
            load,
            prepare,
            render,
            write: laps.next(),
        };
        let report = picture.report(&times, warning.as_ref());
        self.previous = match loaded.volume {
            Volume::Mesh(mesh) => Some(Volume::Mesh(mesh)),
            _ => None,
        };
        Ok((report, warning))
    }

    /// A step and its scene.
    fn load(&mut self, step: &Step) -> Result<(Loaded, Scene), Error> {
        let previous = self.previous.take();
        load(&self.request, self.common.as_ref(), step, previous.as_ref())
    }
}

/// A step and its scene, with what it shares with the step before.
fn load(
    request: &Request,
    common: Option<&Common>,
    step: &Step,
    previous: Option<&Volume>,
) -> Result<(Loaded, Scene), Error> {
    if let Some(common) = common {
        let scene = common.scene_of(step);
        return Ok((common.load(&scene.source, previous)?, scene));
    }
    let mut request = request.clone();
    choose(&mut request.file.volume, step);
    let loaded = volumes::load_step(&request.file.volume, previous)?;
    let scene = request.complete(request.file.resolve(&loaded.volume))?;
    Ok((loaded, scene))
}

/// A stopwatch.
struct Laps(Instant);

impl Laps {
    /// Seconds since the last call, or the beginning.
    fn next(&mut self) -> f64 {
        let before = std::mem::replace(&mut self.0, Instant::now());
        (self.0 - before).as_secs_f64()
    }
}
