//! How long a frame of the aneurism takes, and how far it is from the reference.
//!
//!     TETRASCOPE_DATA=/path/to/data cargo run --release -p tetrascope-slicing \
//!         --example slice_times -- [runs] [side] [SETTING=VALUE,SETTING=VALUE]...
//!
//! For each argument with settings: the median, the least and the greatest time of interleaved
//! frames, RMSE and greatest difference of all four channels, fragments. Opacity rises from the
//! scalar 30 to 255 over a unit distance of one voxel.

use std::time::Instant;

use tetrascope_core::colormap::Colormap;
use tetrascope_core::transfer_function::OpacityRamp;
use tetrascope_core::{
    Appearance, CameraFit, Frame, OpticalModel, Settings, TransferFunction, VolumeRenderer as _,
};
use tetrascope_io::{FileData, ReadOptions, read_file};
use tetrascope_slicing::{ENTRY, Slicing, SlicingOptions, counters};
use tetrascope_testing::{ImageError, fitted, truth};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let mut number = |default: usize| {
        let number = arguments.next().map(|a| a.parse().expect("a number"));
        number.unwrap_or(default)
    };
    let (runs, side) = (number(5), number(512) as u32);
    let mut settings: Vec<String> = arguments.collect();
    if settings.is_empty() {
        settings = ["1", "2", "4", "8"].map(|n| format!("slices={n}")).to_vec();
    }
    let Some(gpu) = tetrascope_testing::gpu("slice_times") else {
        return;
    };
    let Some(path) = tetrascope_testing::file("slice_times", "aneurism.vti") else {
        return;
    };
    let FileData::Grid(data) = read_file(&path, &ReadOptions::default()).expect("a file") else {
        panic!("it is a grid");
    };
    let (volume, _) = data.into_volume(None).expect("a field");
    let ramp = OpacityRamp {
        range: (30.0, 255.0),
        ..OpacityRamp::default()
    };
    let function = TransferFunction::from_ramp(Colormap::Viridis, &ramp, 1.0, 33).expect("a ramp");
    let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
    let view = fitted(&volume, CameraFit::PlusIso, false, side);
    let renderers: Vec<Slicing> = settings
        .iter()
        .map(|settings| {
            let parts = settings.split(',').filter(|s| !s.is_empty());
            let settings = Settings::parse(&ENTRY, parts).expect("settings");
            let options = SlicingOptions::from_settings(&settings);
            Slicing::new(&gpu, &volume, &appearance, &options).expect("it draws all")
        })
        .collect();
    let mut times = vec![Vec::new(); renderers.len()];
    let mut frames: Vec<Option<Frame>> = vec![None; renderers.len()];
    for run in 0..=runs {
        for (i, renderer) in renderers.iter().enumerate() {
            let start = Instant::now();
            let frame = renderer.render(&view).expect("a picture");
            // The first frame makes what lasts.
            if run > 0 {
                times[i].push(start.elapsed().as_secs_f64());
            }
            frames[i] = Some(frame);
        }
    }
    let exact = truth(&volume, &appearance)
        .render_exact(&view)
        .expect("the truth");
    for (i, settings) in settings.iter().enumerate() {
        times[i].sort_by(f64::total_cmp);
        let frame = frames[i].as_ref().expect("it was drawn");
        let error = ImageError::against(&exact.pixels, frame);
        let count = |counter| frame.stats.get(counter).unwrap_or(0);
        println!(
            "{settings}: median {:.4} s ({:.4} to {:.4}), RMSE {:.1e}, most {:.1e}, {} boxes of {}, \
             {} fragments",
            times[i][runs / 2],
            times[i][0],
            times[i][runs - 1],
            error.rmse,
            error.max,
            count(counters::BRICKS_DRAWN),
            count(counters::BRICKS_DRAWN) + count(counters::BRICKS_SKIPPED),
            count(counters::FRAGMENTS),
        );
    }
    if let Some(folder) = std::env::var_os("SLICE_TIMES_PICTURES") {
        let folder = std::path::PathBuf::from(folder);
        for (i, frame) in frames.iter().flatten().enumerate() {
            let path = folder.join(format!("{i}.png"));
            tetrascope_io::write_image(&path, frame, &[]).expect("it is written");
        }
    }
}
