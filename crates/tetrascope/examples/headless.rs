//! Draws a generated data set to a PNG file, without a window.
//!
//!     cargo run --example headless -- picture.png orbital projection
//!
//! All three arguments may be left out: the file, the data set and the algorithm, which is one
//! of `tetrascope algorithms`. `reference` draws on the CPU, where there is no graphics adapter.
//! The picture shows the data set from the side and in the colors that suit it.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use tetrascope::core::{Error, VolumeRenderer as _};
use tetrascope::{Context, Settings, algorithm, datasets, help, io, volumes};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            if let Some(help) = help(&error) {
                eprintln!("  help: {help}");
            }
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = |default: &str| arguments.next().unwrap_or_else(|| default.into());
    let path = argument("headless.png");
    let dataset = datasets::find(&argument("orbital"))?;
    let algorithm = algorithm(&argument("projection"))?;
    // Refuse a bad path before the work, not after it.
    io::image::check_path(Path::new(&path))?;

    // A scene says little; `resolve` completes it from the volume.
    let mut file = volumes::scene(dataset);
    (file.image.width, file.image.height) = (Some(640), Some(480));
    let loaded = volumes::load(&file.volume)?;
    let scene = file.resolve(&loaded.volume)?;

    let start = Instant::now();
    let context = Context::new();
    let settings = Settings::defaults(algorithm);
    let renderer = (algorithm.build)(&context, &loaded.volume, &scene.appearance, &settings)?;
    let prepared = start.elapsed();
    let frame = renderer.render(&scene.view)?;
    let drawn = start.elapsed() - prepared;
    io::write_image(Path::new(&path), &frame, &[])?;

    let adapter = context.adapter().unwrap_or_else(|| "the CPU".into());
    println!("{}: {}", dataset.name, loaded.description);
    println!("drawn by {} on {adapter}", algorithm.name);
    println!("prepared in {prepared:.2?}, drawn in {drawn:.2?}");
    println!("wrote {path}");
    Ok(())
}
