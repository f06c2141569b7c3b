//! `render` of a series: a frame for each step, all in one scene.
//!
//! [`Steps`] are the files, which [`pattern`], [`natural`] and collections put in order;
//! [`Common`] is what frames share, found from all steps before the first is drawn, so that
//! nothing flickers; [`frame_name`] names frames. One step is in memory at a time.

mod common;
mod frame_name;
mod natural;
mod pattern;
mod resume;
mod steps;
mod whole;

use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};
use tetrascope::core::{Error, Volume, VolumeRenderer as _};
use tetrascope::io::Step;
use tetrascope::io::image::{self, write_image};
use tetrascope::scene::Scene;
use tetrascope::volumes::{self, Loaded};
use tetrascope::{Algorithm, Context, Renderer, Settings, emptiness, help};

use crate::args::RenderArgs;
use crate::output::{self, Output, Stop};
use crate::picture::{Input, Picture, Times};
use crate::render::BYTES_PER_PIXEL;
use crate::scene::Request;

pub(crate) use common::Common;
pub(crate) use steps::Steps;
use steps::{describe, frame_name};
use whole::Whole;

/// What is told of a frame that cannot be drawn.
const RESUME: &str = "--resume goes on with the frames that are not there yet";

pub(crate) fn run(
    args: &RenderArgs,
    steps: &Steps,
    algorithm: &'static Algorithm,
    settings: Settings,
    output: &Output,
) -> Result<(), Stop> {
    let name = frame_name(args.output.as_deref())?;
    let numbers = steps.numbers(args.series.steps)?;
    image::check_path(&name.path(numbers[0]))?;
    let request = Request::new(&args.scene, Some(&steps.first().file))?;
    if steps.is_shuffled {
        output.warning(&Error::Invalid {
            what: "the files are drawn as they are named, which is not the order of their numbers"
                .into(),
            help: Some("a quoted pattern, such as 'step_*.vtu', has step_2 before step_10".into()),
        });
    }
    let common = match args.series.each_step {
        true => None,
        false => Some(Common::find(&request, steps, output)?),
    };

    let watch = output.steps(numbers.len());
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
        whole: Whole::new(),
    };
    let mut there = vec![false; numbers.len()];
    if args.series.resume {
        for (there, &number) in there.iter_mut().zip(&numbers) {
            let step = &steps.list[number];
            *there = series
                .is_drawn(step, &name.path(number))
                .map_err(at(step, None))?;
        }
    }
    let (mut drawn, mut skipped) = (0, 0);
    let mut reports = Vec::new();
    let mut empty: Option<(usize, Error)> = None;
    for (&number, there) in numbers.iter().zip(there) {
        let step = &steps.list[number];
        let path = name.path(number);
        if there {
            skipped += 1;
            reports.push(report_of(step, &path, false));
            watch.end();
            continue;
        }
        watch.begin(&format!("frame {number}, {}", describe(step)));
        let started = Instant::now();
        let frame = series.draw(step, &path, &watch);
        let (mut report, warning) = frame.map_err(at(step, Some(RESUME)))?;
        watch.end();
        watch.line(format_args!(
            "{}: {} ({:.2} s)",
            path.display(),
            describe(step),
            started.elapsed().as_secs_f64()
        ));
        drawn += 1;
        if let Some(warning) = warning {
            let count = empty.take().map_or(0, |(count, _)| count);
            empty = Some((count + 1, warning));
        }
        if output.json() {
            for (key, value) in report_of(step, &path, true)
                .as_object()
                .into_iter()
                .flatten()
            {
                report[key] = value.clone();
            }
            reports.push(report);
        } else {
            match watch.written(&path) {
                // Who has read enough of the names may want the frames still.
                Ok(()) | Err(Stop::ClosedPipe) => {}
                Err(stop) => return Err(stop),
            }
        }
    }
    drop(watch);
    let there = match skipped {
        0 => String::new(),
        _ => format!(", {skipped} were there"),
    };
    output.note(format_args!(
        "{drawn} of {} frames drawn{there}",
        numbers.len()
    ));
    if let Some((count, warning)) = &empty {
        output.warning(&Error::Invalid {
            what: format!("of {count} of {drawn} frames drawn, {warning}"),
            help: help(warning),
        });
    }
    match output.json() {
        true => output.json_result(&json!({
            "steps": steps.list.len(),
            "drawn": drawn,
            "skipped": skipped,
            "scene": series.common.map(|common| common.scene.to_file()),
            "frames": reports,
        })),
        false => Ok(()),
    }
}

/// Names the step's file in an error.
fn at(step: &Step, help: Option<&'static str>) -> impl FnOnce(Error) -> Stop {
    let file = step.file.clone();
    move |error| Stop::Step { error, file, help }
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
    whole: Whole,
}

impl Series {
    /// Whether the frame of a step is there; an error if what is there is something else.
    fn is_drawn(&mut self, step: &Step, path: &Path) -> Result<bool, Error> {
        if !path.exists() {
            return Ok(false);
        }
        let scene = match &self.common {
            Some(common) => common.scene_of(step),
            None => self.load(step)?.1,
        };
        resume::is_drawn(path, self.algorithm, &self.settings, &scene)
    }

    /// Draws a step and writes its frame; gives what is to be said of it, and why it shows
    /// nothing if so.
    fn draw(
        &mut self,
        step: &Step,
        path: &Path,
        watch: &output::Steps,
    ) -> Result<(Value, Option<Error>), Error> {
        let mut laps = Laps(Instant::now());
        let (loaded, scene) = self.load(step)?;
        let load = laps.next();
        let volume = &loaded.volume;
        (self.algorithm.supports)(volume, &scene.appearance, &scene.view, &self.settings)?;
        scene.view.check_memory(BYTES_PER_PIXEL)?;
        let inputs = loaded.files.iter().map(|path| Input::of(path));
        let inputs = inputs.collect::<Result<Vec<Input>, Error>>()?;
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
        self.whole
            .write(|| write_image(path, &picture.frame, &metadata))?;
        for line in picture.statistics() {
            watch.detail(format_args!("  {line}"));
        }
        let report = picture.report(&Times {
            load,
            prepare,
            render,
            write: laps.next(),
        });
        self.previous = match loaded.volume {
            Volume::Mesh(mesh) => Some(Volume::Mesh(mesh)),
            _ => None,
        };
        Ok((report, warning))
    }

    /// A step and its scene.
    fn load(&mut self, step: &Step) -> Result<(Loaded, Scene), Error> {
        let previous = self.previous.take();
        if let Some(common) = &self.common {
            let scene = common.scene_of(step);
            return Ok((common.load(&scene.source, previous.as_ref())?, scene));
        }
        let mut request = self.request.clone();
        request.file.volume.file = Some(step.file.clone());
        let loaded = volumes::load_step(&request.file.volume, previous.as_ref())?;
        let scene = request.complete(request.file.resolve(&loaded.volume))?;
        Ok((loaded, scene))
    }
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

/// Of a frame, as JSON.
fn report_of(step: &Step, path: &Path, drawn: bool) -> Value {
    json!({
        "output": path.to_string_lossy(),
        "file": step.file.to_string_lossy(),
        "time": step.time,
        "drawn": drawn,
    })
}
