//! Tables 1 to 3 of Weiler, Kraus and Ertl, and how a frame's cost grows with the cells:
//! `projection/tables/sphere/149k cells/twelve-floats`.
//!
//! Frames are drawn as theirs were: emission, unsorted, parallel rays, ray parameters at
//! vertices, in each layout of cells. Megabytes per second are bytes per cell times cells per
//! second, as in the paper.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use tetrascope::core::{OpticalModel, Projection, View, Volume, VolumeRenderer};
use tetrascope::scene::{Scene, SceneFile, VolumeSource};
use tetrascope::{Algorithm, Context, Renderer, Settings, volumes};

/// Pixels per side of the tables' frames; the paper does not give its own.
const SIDE: u32 = 256;

const LAYOUTS: [&str; 3] = ["twelve-floats", "twelve-shorts", "shared-vertices"];

fn algorithm() -> &'static Algorithm {
    tetrascope::algorithm(tetrascope::projection::NAME).expect("registered")
}

fn renderer(context: &Context, volume: &Volume, scene: &Scene, settings: &[&str]) -> Renderer {
    let algorithm = algorithm();
    let settings = Settings::parse(algorithm, settings.iter().copied()).expect("valid settings");
    let built = (algorithm.build)(context, volume, &scene.appearance, &settings);
    built.expect("the mesh fits")
}

/// A volume with its scene in emission, seen by parallel rays.
fn load(file: &SceneFile) -> (Volume, Scene) {
    let volume = volumes::load(&file.volume).expect("a valid volume").volume;
    let mut scene = file.resolve(&volume).expect("a valid scene");
    scene.appearance.optical_model = OpticalModel::Emission;
    scene.view.camera.projection = Projection::Orthographic {
        parallel_scale: volume.bounds().diagonal() / 2.0,
    };
    (volume, scene)
}

/// The Blunt Fin, where it is at hand.
fn blunt_fin() -> Option<SceneFile> {
    let path = tetrascope_testing::file("projection", "bluntfinxyz.bin")?;
    Some(SceneFile::new(VolumeSource {
        file: Some(path),
        field: Some("density".into()),
        ..VolumeSource::default()
    }))
}

fn data_set(name: &str, cells: Option<u64>) -> SceneFile {
    let mut file = volumes::scene(tetrascope::datasets::find(name).expect("listed"));
    file.volume.cells = cells.or(file.volume.cells);
    file
}

fn tables(criterion: &mut Criterion) {
    let context = Context::new();
    if let Err(error) = context.gpu() {
        eprintln!("skipped: projection: {error}");
        return;
    }
    let mut scenes: Vec<(&str, SceneFile)> =
        blunt_fin().map(|f| ("bluntfin", f)).into_iter().collect();
    scenes.extend(["heat-sink", "orbital", "sphere"].map(|name| (name, data_set(name, None))));
    for (name, file) in scenes {
        let (volume, scene) = load(&file);
        let cells = volume.cell_count() as u64;
        let view = View {
            width: SIDE,
            height: SIDE,
            ..scene.view
        };
        let group = format!("projection/tables/{name}/{}k cells", (cells + 500) / 1000);
        let mut group = criterion.benchmark_group(group);
        group
            .sample_size(10)
            .measurement_time(Duration::from_secs(3))
            .throughput(Throughput::Elements(cells));
        for layout in LAYOUTS {
            let layout_setting = format!("layout={layout}");
            let settings = ["exit=per-vertex", layout_setting.as_str()];
            let algorithm = algorithm();
            let parsed = Settings::parse(algorithm, settings).expect("valid settings");
            let renderer = match (algorithm.build)(&context, &volume, &scene.appearance, &parsed) {
                Ok(renderer) => renderer,
                Err(error) => {
                    eprintln!("skipped: {name}, {layout}: {error}");
                    continue;
                }
            };
            group.bench_function(layout, |b| {
                b.iter(|| black_box(renderer.render(&view).expect("drawn before")));
            });
            let (seconds, bytes) = (fastest(&renderer, &view, 3), bytes(&renderer, &view));
            let rate = cells as f64 / seconds;
            println!(
                "{name}, {layout}: {cells} cells, {bytes:.0} bytes each, {:.2} frames/s, \
                 {:.0} k cells/s, {:.0} MB/s",
                1.0 / seconds,
                rate / 1e3,
                rate * bytes / 1e6
            );
        }
        group.finish();
    }
}

fn bytes(renderer: &dyn VolumeRenderer, view: &View) -> f64 {
    let stats = renderer.render(view).expect("drawn before").stats;
    stats.bytes_per_cell.expect("projection counts")
}

/// Seconds of the fastest of `count` frames.
fn fastest(renderer: &dyn VolumeRenderer, view: &View, count: usize) -> f64 {
    let frame = |_| {
        let start = Instant::now();
        black_box(renderer.render(view).expect("a picture"));
        start.elapsed().as_secs_f64()
    };
    (0..count).map(frame).fold(f64::INFINITY, f64::min)
}

/// Not criterion's: what counts is one number over all sizes, the exponent p of a
/// frame's time ~ cellsᵖ, by least squares of the logarithms.
fn linearity(_: &mut Criterion) {
    let context = Context::new();
    if let Err(error) = context.gpu() {
        eprintln!("skipped: projection: {error}");
        return;
    }
    for side in [32, 512] {
        let mut logarithms = Vec::new();
        for cells in [10_000, 32_000, 100_000, 320_000, 1_000_000] {
            let (volume, scene) = load(&data_set("sphere", Some(cells)));
            let renderer = renderer(&context, &volume, &scene, &["order=unsorted"]);
            let view = View {
                width: side,
                height: side,
                ..scene.view
            };
            let seconds = fastest(&renderer, &view, 5);
            let cells = volume.cell_count() as f64;
            println!("{side}x{side}, {cells} cells: {:.1} ms", 1e3 * seconds);
            logarithms.push((cells.ln(), seconds.ln()));
        }
        let n = logarithms.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| logarithms.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(|l| l.0), mean(|l| l.1));
        let rise: f64 = logarithms.iter().map(|l| (l.0 - x) * (l.1 - y)).sum();
        let run: f64 = logarithms.iter().map(|l| (l.0 - x).powi(2)).sum();
        let gpu = context.gpu().expect("drawn with");
        println!(
            "{side}x{side}: time ~ cells^{:.3} on {}",
            rise / run,
            gpu.describe()
        );
    }
}

criterion_group!(benches, tables, linearity);
criterion_main!(benches);
