//! `render`: a volume to a picture; of several, [`series`](crate::series) makes as many.

use std::path::PathBuf;

use serde_json::{Value, json};
use tetrascope::choose::Need;
use tetrascope::cli::use_threads;
use tetrascope::core::{Error, Frame, Volume, VolumeRenderer as _};
use tetrascope::io::image::{self, write_image};
use tetrascope::provenance::Input;
use tetrascope::scene::Scene;
use tetrascope::{Algorithm, Context, Settings, emptiness};

use crate::args::RenderArgs;
use crate::need::choice_json;
use crate::output::{Output, Stop};
use crate::picture::{Picture, Times};
use crate::scene::Request;
use crate::series::{self, Steps};

pub(crate) fn run(args: &RenderArgs, output: &Output) -> Result<(), Stop> {
    // Refuse what can be refused at once before the volume is read.
    let how = How::of(args)?;
    if let Some(threads) = args.threads {
        use_threads(threads.into())?;
    }
    if let Some(steps) = Steps::find_for(args)? {
        return series::run(args, &steps, how, output);
    }
    let request = Request::new(&args.scene, args.scene.volume.first())?;
    let path = match &args.output {
        Some(path) => path.clone(),
        None => {
            let mut name = request.stem();
            name.push(".png");
            PathBuf::from(name)
        }
    };
    image::check_path(&path)?;

    let (loaded, load) = request.load(output)?;
    let inputs = Input::all_of(&loaded)?;
    let volume = &loaded.volume;
    let how = how.for_volume(volume)?;
    let scene = request.resolve(volume, output)?;
    let drawn = how.draw(args, (volume, &scene), output)?;
    let Drawn {
        algorithm, frame, ..
    } = drawn;
    for note in &frame.stats.notes {
        output.note(format_args!("  {note}"));
    }
    let warning = emptiness::explain(volume, &scene.appearance, &scene.view, &frame);

    let picture = Picture {
        algorithm,
        settings: drawn.settings,
        loaded: &loaded,
        inputs,
        scene,
        adapter: drawn.adapter,
        frame,
    };
    let ((), write) = output.timed(&format!("writing {}", path.display()), || {
        write_image(&path, &picture.frame, &picture.metadata())
    })?;
    if let Some(warning) = &warning {
        output.warning(warning);
    }
    for line in picture.statistics() {
        output.detail(format_args!("  {line}"));
    }
    if !output.json() {
        return output.written(&path);
    }
    let times = Times {
        load,
        prepare: drawn.prepare,
        render: drawn.render,
        write,
    };
    let mut report = picture.report(&times, warning.as_ref());
    if let Some(choice) = drawn.choice {
        report["choice"] = choice;
    }
    report["output"] = json!(path.to_string_lossy());
    output.json_result(&report)
}

/// The way to an algorithm.
pub(crate) enum How {
    /// An algorithm that the command line names.
    Named(&'static Algorithm, Settings),
    /// The algorithm that meets this need best.
    Need(Need),
}

/// A picture, and how it was drawn.
struct Drawn {
    algorithm: &'static Algorithm,
    settings: Settings,
    frame: Frame,
    /// In words; `None` if the CPU drew.
    adapter: Option<String>,
    /// Seconds.
    prepare: f64,
    render: f64,
    /// As JSON, if the algorithm was chosen.
    choice: Option<Value>,
}

impl How {
    fn of(args: &RenderArgs) -> Result<How, Error> {
        if let Some(need) = args.need.need()? {
            return Ok(How::Need(need));
        }
        let algorithm = tetrascope::algorithm(&args.algorithm)?;
        let settings = Settings::parse(algorithm, args.settings.iter().map(String::as_str))?;
        Ok(How::Named(algorithm, settings))
    }

    /// A mesh in clusters is drawn in the memory that is given, by the one algorithm that does.
    fn for_volume(self, volume: &Volume) -> Result<How, Error> {
        let (How::Need(need), Volume::Clusters(_)) = (&self, volume) else {
            return Ok(self);
        };
        let (None, None, Some(memory)) = (need.error, need.budget, need.memory) else {
            return Err(Error::Usage {
                what: "an error or a time cannot choose for a mesh in clusters: the ground truth needs it in memory"
                    .into(),
                help: Some("leave out --error and --budget".into()),
            });
        };
        let algorithm = tetrascope::algorithm(tetrascope::raycast_cpu::NAME)?;
        let setting = format!("memory={}", memory / 1_000_000);
        let settings = Settings::parse(algorithm, [&setting[..]])?;
        Ok(How::Named(algorithm, settings))
    }

    fn draw(
        self,
        args: &RenderArgs,
        (volume, scene): (&Volume, &Scene),
        output: &Output,
    ) -> Result<Drawn, Error> {
        match self {
            How::Named(algorithm, settings) => {
                draw_by(algorithm, settings, (volume, scene), output)
            }
            How::Need(need) => {
                scene.view.check_memory(BYTES_PER_PIXEL)?;
                let context = Context::new();
                let choice = args.need.choose(&need, (volume, scene), &context, output)?;
                Ok(Drawn {
                    choice: Some(choice_json(&choice)),
                    algorithm: choice.algorithm,
                    adapter: context.adapter().filter(|_| choice.algorithm.needs_gpu),
                    prepare: choice.trial.found.prepare,
                    render: choice.trial.found.seconds,
                    settings: choice.settings,
                    frame: choice.frame,
                })
            }
        }
    }
}

/// Draws by an algorithm.
fn draw_by(
    algorithm: &'static Algorithm,
    settings: Settings,
    (volume, scene): (&Volume, &Scene),
    output: &Output,
) -> Result<Drawn, Error> {
    (algorithm.supports)(volume, &scene.appearance, &scene.view, &settings)?;
    scene.view.check_memory(BYTES_PER_PIXEL)?;
    let context = match output.progress() {
        Some(progress) => Context::new().with_progress(progress),
        None => Context::new(),
    };
    for line in settings.idle(algorithm, volume.kind()) {
        output.note(format_args!("  {line}"));
    }
    let shown = settings.that_matter(algorithm, volume.kind());
    let what = format!("preparing {} {shown}", algorithm.name);
    let (renderer, prepare) = output.timed(what.trim_end(), || {
        (algorithm.build)(&context, volume, &scene.appearance, &settings)
    })?;
    let adapter = context.adapter();
    if let Some(adapter) = &adapter {
        output.note(format_args!("  {adapter}"));
    }
    let what = format!("drawing {}x{} pixels", scene.view.width, scene.view.height);
    let (frame, render) = output.timed(&what, || renderer.render(&scene.view))?;
    Ok(Drawn {
        algorithm,
        settings,
        frame,
        adapter,
        prepare,
        render,
        choice: None,
    })
}

/// Memory for a pixel of any algorithm's picture, at least: the frame with its depths, and the
/// file as it is and packed.
pub(crate) const BYTES_PER_PIXEL: u64 = 16 + 4 + 16 + 16;
