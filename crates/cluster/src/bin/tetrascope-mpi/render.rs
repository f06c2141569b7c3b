//! `render`: a mesh to a picture, by all ranks.

use std::path::{Path, PathBuf};
use std::time::Instant;

use tetrascope::cli::{Output, Request, output};
use tetrascope::core::{Error, Volume};
use tetrascope::io::StepChoice;
use tetrascope::io::image::{check_path, write_image};
use tetrascope::provenance::Input;
use tetrascope::raycast_cpu::{self, RaycastCpuOptions};
use tetrascope::volumes::Loaded;
use tetrascope::{Settings, emptiness};
use tetrascope_cluster::collective::{agree, broadcast};
use tetrascope_cluster::pieces::{Opened, Wanted, open};
use tetrascope_cluster::{Communicator, Exchange, Picture, RankRenderer};

use crate::End;
use crate::args::RenderArgs;
use crate::report::{self, Report};

/// Notes of pieces that are printed; more are counted.
const MOST_NOTES: usize = 20;

pub(crate) fn run(
    ranks: &impl Communicator,
    args: &RenderArgs,
    output: &Output,
) -> Result<(), End> {
    let Asked {
        request,
        path,
        file,
        settings,
        exchange,
    } = agree(ranks, ask(ranks, args))?;
    let source = &request.file.volume;
    let number = source.step.map(StepChoice::Number);
    let wanted = Wanted {
        field: source.field.clone(),
        step: number.or(source.time.map(StepChoice::Time)),
        memory: args.memory,
    };
    output.note(format_args!("reading {}", file.display()));
    let started = Instant::now();
    let opened = open(ranks, &file, &wanted)?;
    let read = started.elapsed().as_secs_f64();
    let loaded = loaded(&opened, &file, ranks.size());
    tell(&loaded, output);

    let volume = &loaded.volume;
    let scene = agree(ranks, request.resolve(volume, output))?;
    agree(ranks, raycast_cpu::supports(volume, &scene.appearance))?;
    let options = RaycastCpuOptions {
        memory: args.memory,
        ..RaycastCpuOptions::from_settings(&settings)
    };
    panic_if_asked(ranks.rank());
    let (share, look) = (&opened.share, &scene.appearance);
    let renderer = RankRenderer::new(ranks, share, look, &options, exchange)?;
    output.note(format_args!(
        "drawing {}x{} pixels",
        scene.view.width, scene.view.height
    ));
    let mut fastest: Option<(f64, Picture)> = None;
    for _ in 0..args.repeat {
        // All begin at once.
        broadcast(ranks, Vec::new())?;
        let started = Instant::now();
        let picture = renderer.render(ranks, &scene.view)?;
        let seconds = started.elapsed().as_secs_f64();
        if fastest.as_ref().is_none_or(|(least, _)| seconds < *least) {
            fastest = Some((seconds, picture));
        }
    }
    let (seconds, picture) = fastest.expect("it is drawn once at least");

    let Some(frame) = picture.frame else {
        // Rank 0 writes.
        agree(ranks, Ok(()))?;
        return Ok(());
    };
    for note in &frame.stats.notes {
        output.note(format_args!("  {note}"));
    }
    let warning = emptiness::explain(volume, &scene.appearance, &scene.view, &frame);
    let report = Report {
        settings: &settings,
        loaded: &loaded,
        scene: &scene,
        frame: &frame,
        times: &picture.times,
        read,
        seconds,
        warning: warning.as_ref(),
    };
    let write = || {
        let inputs = Input::all_of(&loaded)?;
        write_image(&path, &frame, &report.metadata(&inputs)?)
    };
    agree(ranks, write())?;
    if let Some(warning) = &warning {
        output.warning(warning);
    }
    for line in report.lines() {
        output.detail(format_args!("  {line}"));
    }
    let printed = match output.json() {
        true => output.json_result(&report.json(&path)?),
        false => output.written(&path),
    };
    printed.map_err(End::Stop)
}

/// Panics at the rank that this variable of the environment names: for tests of this program.
fn panic_if_asked(rank: usize) {
    let asked = std::env::var("TETRASCOPE_PANIC_AT_RANK");
    if asked.is_ok_and(|asked| asked == rank.to_string()) {
        panic!("as it was asked to");
    }
}

/// The request, before anything of the mesh is read.
struct Asked {
    request: Request,
    /// Where to write.
    path: PathBuf,
    /// The mesh.
    file: PathBuf,
    settings: Settings,
    exchange: Exchange,
}

fn ask(ranks: &impl Communicator, args: &RenderArgs) -> Result<Asked, Error> {
    let algorithm = tetrascope::algorithm(raycast_cpu::NAME)?;
    let settings = Settings::parse(algorithm, args.settings.iter().map(String::as_str))?;
    tetrascope::cli::use_threads(args.threads.into())?;
    let usage = |what: &str, help: &str| {
        Err(Error::Usage {
            what: what.into(),
            help: Some(help.into()),
        })
    };
    if args
        .settings
        .iter()
        .any(|setting| setting.starts_with("memory="))
    {
        return usage("memory is given in one way", "use --memory");
    }
    if args.scene.volume.len() > 1 {
        return usage(
            "several files, and one mesh is drawn",
            "give a .pvtu, .vtm, .pvd or .tsc file",
        );
    }
    let request = Request::new(&args.scene, args.scene.volume.first())?;
    let source = &request.file.volume;
    let Some(file) = source.file.clone() else {
        return usage(
            "a data set, and meshes are read from files",
            "make a file of it with `tetrascope pack NAME --cells N -o NAME.tsc`",
        );
    };
    let other = source.solution.is_some()
        || source.curved.is_some()
        || source.interpolation.is_some()
        || source.has_raw_keys();
    if other {
        return usage(
            "options for Plot3D, curved cells or grids, and pieces of meshes have none of these",
            "leave them out, or use `tetrascope render`",
        );
    }
    let path = args.output.clone().unwrap_or_else(|| {
        let mut name = request.stem();
        name.push(".png");
        PathBuf::from(name)
    });
    // Rank 0 writes, perhaps where others cannot.
    if ranks.rank() == 0 {
        check_path(&path)?;
    }
    let exchange = match args.radix {
        None => Exchange::direct(ranks.size()),
        Some(k) => Exchange::radix(ranks.size(), k.into())?,
    };
    Ok(Asked {
        request,
        path,
        file,
        settings,
        exchange,
    })
}

/// The mesh as one that was loaded.
fn loaded(opened: &Opened, file: &Path, ranks: usize) -> Loaded {
    let whole = &opened.whole;
    let (field, _) = whole.source().field();
    let checksum = whole.source().checksum();
    let count = |noun| report::count(opened.pieces, noun);
    let (kind, files) = match checksum {
        Some(checksum) => (
            format!("{} with the checksum {checksum:08x}", count("cluster")),
            Vec::new(),
        ),
        // The list alone: rank 0 does not read the pieces of others.
        None => (count("piece"), vec![file.to_owned()]),
    };
    let ranks = report::count(ranks, "rank");
    Loaded {
        description: format!(
            "{} tetrahedra in {kind}, field '{field}', at {ranks}",
            whole.cell_count()
        ),
        field: field.to_owned(),
        volume: Volume::Clusters(whole.clone()),
        notes: opened.notes.clone(),
        fields: Vec::new(),
        files,
        space: None,
    }
}

fn tell(loaded: &Loaded, output: &Output) {
    output.note(format_args!("  {}", loaded.description));
    for note in loaded.notes.iter().take(MOST_NOTES) {
        output.note(format_args!("  {note}"));
    }
    let more = loaded.notes.len().saturating_sub(MOST_NOTES);
    if more > 0 {
        output.note(format_args!("  {} more", report::count(more, "note")));
    }
}

impl From<Error> for End {
    fn from(error: Error) -> End {
        End::Stop(output::Stop::Error(error))
    }
}
