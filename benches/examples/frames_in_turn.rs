//! Draws a frame by each of some algorithms each time that a line comes in and prints the seconds of
//! each, so that another program can have its turn in between: `benches/peers/vtk_frames.py` does.
//!
//! Arguments: a scene file, and algorithms, each as `NAME` or `NAME:KEY=VALUE,KEY=VALUE`. First comes
//! a line for each of them: its error (RMSE of all channels, and the greatest) against the ground truth,
//! and the adapter of all. The camera is moved a little before each frame, as in VTK's turn.

use std::io::{BufRead as _, Write as _};
use std::path::Path;
use std::time::Instant;

use tetrascope::core::{Error, View, VolumeRenderer as _};
use tetrascope::scene::SceneFile;
use tetrascope::{Context, Settings, algorithm, truth, volumes};

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some((scene, wanted)) = arguments.split_first() else {
        return Err(Error::invalid(
            "give a scene file and algorithms, such as scene.toml raycast-cpu",
        ));
    };
    let file = SceneFile::read(Path::new(scene))?;
    let volume = volumes::load(&file.volume)?.volume;
    let scene = file.resolve(&volume)?;
    let context = Context::new();
    let build = |named: &str| {
        let (name, settings) = named.split_once(':').unwrap_or((named, ""));
        let algorithm = algorithm(name)?;
        let settings = settings.split(',').filter(|s| !s.is_empty());
        let settings = Settings::parse(algorithm, settings)?;
        (algorithm.build)(&context, &volume, &scene.appearance, &settings)
    };
    let renderers = wanted.iter().map(|named| build(named));
    let renderers = renderers.collect::<Result<Vec<_>, Error>>()?;
    if let Some(truth) = truth() {
        let exact = build(truth.name)?.render(&scene.view)?;
        for (name, renderer) in wanted.iter().zip(&renderers) {
            let frame = renderer.render(&scene.view)?;
            let pairs = frame
                .pixels
                .iter()
                .flatten()
                .zip(exact.pixels.iter().flatten());
            let differences = pairs.map(|(a, b)| f64::from((a - b).abs()));
            let (mut sum, mut most) = (0.0, 0.0_f64);
            for difference in differences {
                sum += difference * difference;
                most = most.max(difference);
            }
            let rmse = (sum / (4 * frame.pixels.len()) as f64).sqrt();
            let adapter = context.adapter().unwrap_or_default();
            println!("{name}: rmse {rmse:.1e}, max {most:.1e}; {adapter}");
        }
    }
    for (turn, _) in std::io::stdin()
        .lock()
        .lines()
        .map_while(Result::ok)
        .enumerate()
    {
        let mut camera = scene.view.camera;
        // A thousandth of the distance to and fro: nothing of a frame can be kept.
        let step = if turn % 2 == 0 { 1e-3 } else { -1e-3 };
        camera.position += step * (camera.focal_point - camera.position);
        let view = View {
            camera,
            ..scene.view
        };
        let mut seconds = Vec::new();
        for renderer in &renderers {
            let start = Instant::now();
            renderer.render(&view)?;
            seconds.push(start.elapsed().as_secs_f64().to_string());
        }
        println!("{}", seconds.join(" "));
        // Nobody who waits for it is there if it fails.
        let _ = std::io::stdout().flush();
    }
    Ok(())
}
