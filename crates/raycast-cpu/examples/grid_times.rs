//! How long a frame of the aneurism takes, and how far it is from the reference.
//!
//!     TETRASCOPE_DATA=/path/to/data cargo run --release -p tetrascope-raycast-cpu \
//!         --example grid_times -- [runs] [threads] [side]
//!
//! For several tolerances: the median, the least and the greatest time of interleaved runs, RMSE
//! and greatest difference of all four channels against the reference, cells integrated and
//! passed over. Opacity rises from the scalar 30 to 255 over a unit distance of one voxel; the
//! second scene is a function of two knots, the third hides nothing.

use std::time::Instant;

use tetrascope_core::colormap::Colormap;
use tetrascope_core::glam::DVec3;
use tetrascope_core::transfer_function::OpacityRamp;
use tetrascope_core::{
    Appearance, CameraFit, Frame, Knot, OpticalModel, TransferFunction, Volume, VolumeRenderer as _,
};
use tetrascope_io::{FileData, ReadOptions, read_file};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions, counters};
use tetrascope_testing::{ImageError, fitted, truth};

fn main() {
    let mut numbers = std::env::args()
        .skip(1)
        .map(|a| a.parse().expect("a number"));
    let runs: usize = numbers.next().unwrap_or(9);
    let threads: usize = numbers.next().unwrap_or(2);
    let side = numbers.next().unwrap_or(512) as u32;
    let Some(path) = tetrascope_testing::file("grid_times", "aneurism.vti") else {
        return;
    };
    let FileData::Grid(data) = read_file(&path, &ReadOptions::default()).expect("a file") else {
        panic!("it is a grid");
    };
    let (volume, _) = data.into_volume(None).expect("a field");
    for (name, function) in functions() {
        let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
        scene(name, &volume, &appearance, (runs, threads, side));
    }
}

fn functions() -> [(&'static str, TransferFunction); 3] {
    let ramp = OpacityRamp {
        range: (30.0, 255.0),
        ..OpacityRamp::default()
    };
    let knots = |low: f64, extinction: f64| {
        let knot = |scalar: f64, extinction: f64| Knot {
            scalar,
            color: DVec3::new(1.0, 0.4 + scalar / 512.0, 0.3),
            extinction,
        };
        TransferFunction::new(vec![knot(low, 0.0), knot(255.0, extinction)]).expect("sorted")
    };
    [
        (
            "opacity from 30 to 255, 33 knots",
            TransferFunction::from_ramp(Colormap::Viridis, &ramp, 1.0, 33).expect("a ramp"),
        ),
        ("extinction from 30 to 255, 2 knots", knots(30.0, 2.0)),
        (
            "extinction from -9 to 255, nothing clear",
            knots(-9.0, 0.05),
        ),
    ]
}

fn load() -> String {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    load.split(' ').take(2).collect::<Vec<_>>().join(" ")
}

fn scene(
    name: &str,
    volume: &Volume,
    appearance: &Appearance,
    (runs, threads, side): (usize, usize, u32),
) {
    let view = fitted(volume, CameraFit::PlusIso, false, side);
    let start = Instant::now();
    let exact = truth(volume, appearance)
        .render_exact(&view)
        .expect("the truth");
    println!("{name}, {side}x{side}, {threads} threads, load {}", load());
    println!("  reference: {:.3} s", start.elapsed().as_secs_f64());
    let settings = [
        (1e-6, 1.0),
        (1e-4, 1.0),
        (1e-3, 0.999),
        (1e-2, 0.99),
        (5e-2, 0.98),
        (1e-1, 0.95),
    ];
    let renderers = settings.map(|(tolerance, stop_opacity)| {
        let options = RaycastCpuOptions {
            tolerance,
            stop_opacity,
            threads: Some(threads),
            ..RaycastCpuOptions::default()
        };
        let start = Instant::now();
        let mut renderer = RaycastCpu::new(volume, appearance, &options).expect("it draws all");
        let built = start.elapsed().as_secs_f64();
        let start = Instant::now();
        renderer.restyle(appearance).expect("it draws all");
        (renderer, built, start.elapsed().as_secs_f64())
    });
    let (_, built, restyled) = &renderers[0];
    println!("  new: {built:.3} s, restyle: {restyled:.3} s");
    let mut times = vec![Vec::new(); renderers.len()];
    let mut frames: Vec<Option<Frame>> = vec![None; renderers.len()];
    for _ in 0..runs {
        for (i, (renderer, ..)) in renderers.iter().enumerate() {
            let start = Instant::now();
            let frame = renderer.render(&view).expect("a picture");
            times[i].push(start.elapsed().as_secs_f64());
            frames[i] = Some(frame);
        }
    }
    for (i, (tolerance, stop_opacity)) in settings.into_iter().enumerate() {
        times[i].sort_by(f64::total_cmp);
        let frame = frames[i].as_ref().expect("it was drawn");
        let error = ImageError::against(&exact.pixels, frame);
        let count = |counter| frame.stats.get(counter).unwrap_or(0);
        println!(
            "  tolerance {tolerance:e}, stop {stop_opacity}: median {:.4} s ({:.4} to {:.4}), \
             RMSE {:.1e}, most {:.1e}, {} visits, {} skipped",
            times[i][runs / 2],
            times[i][0],
            times[i][runs - 1],
            error.rmse,
            error.max,
            count(counters::CELL_VISITS),
            count(counters::CELLS_SKIPPED),
        );
    }
    println!("  load {}", load());
    if let Some(folder) = std::env::var_os("GRID_TIMES_PICTURES") {
        let folder = std::path::PathBuf::from(folder);
        for (i, frame) in frames.iter().flatten().enumerate() {
            let path = folder.join(format!("{i}.png"));
            tetrascope_io::write_image(&path, frame, &[]).expect("it is written");
        }
    }
}
