//! Figure 5 of Westermann 2001: how long it takes to resample, part by part
//! (`resample/figure 5/heat-sink 128x128x128/render`), and what a mesh costs that is made anew in
//! every frame.
//!
//! The paper's parts: the list of active elements (Ael), rendering (Rnd), reading pixels back
//! (ToR), and making a 3D texture of them (ToT). Here the first is what happens to a mesh on its
//! way to the device, and there is no last one: samples are made where they are drawn.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use tetrascope::Context;
use tetrascope::core::grid::Lattice;
use tetrascope::core::{TetMesh, Volume, VolumeRenderer as _};
use tetrascope::datasets::wave;
use tetrascope::gpu::Gpu;
use tetrascope::resample::{
    Domain, Outside, Resampler, ResamplerOptions, Resampling, ResamplingOptions,
};
use tetrascope::scene::{SceneFile, VolumeSource};
use tetrascope_benches::papers::RESAMPLED;

/// The device, or why there is none.
fn gpu(context: &Context) -> Option<&Gpu> {
    tetrascope_benches::gpu(context, tetrascope::resample::NAME)
}

/// The meshes of the figure; one in a file only where that is.
fn meshes() -> Vec<(&'static str, TetMesh)> {
    let mut all = vec![("heat-sink", tetrascope_testing::data_set("heat-sink", None))];
    if let Some(fin) = tetrascope_testing::blunt_fin("resample") {
        all.push(("blunt-fin", fin));
    }
    all
}

fn figure_5(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    for (name, mesh) in meshes() {
        for row in RESAMPLED.iter().filter(|row| row.mesh == name) {
            let group = row.group();
            let [list, render, readback, texture] = row.seconds;
            println!(
                "{group}: published Ael {list} s, Rnd {render} s, ToR {readback} s, ToT {texture} s; here {} cells",
                mesh.cell_count()
            );
            let mut group = criterion.benchmark_group(group);
            group
                .sample_size(10)
                .sampling_mode(SamplingMode::Flat)
                .warm_up_time(Duration::from_millis(1))
                .measurement_time(Duration::from_millis(500));
            let lattice = Lattice::over(&mesh.bounds(), row.dims).expect("a box");
            let options = ResamplerOptions::default();
            let made = Resampler::new(gpu, &mesh, &lattice, &options);
            let mut resampler = made.expect("it fits");
            group.bench_function("list", |b| {
                b.iter(|| {
                    resampler.reload(&mesh).expect("it fits");
                    let encoder = gpu.device().create_command_encoder(&Default::default());
                    gpu.finish(encoder).expect("uploaded");
                });
            });
            group.bench_function("render", |b| {
                b.iter(|| resampler.resample().expect("samples"));
            });
            group.bench_function("readback", |b| {
                b.iter(|| black_box(resampler.read_back(Outside::Uncovered).expect("samples")));
            });
            group.finish();
        }
    }
}

/// Cells of the wave, about, and samples along its longest axis.
const WAVE: (u64, usize) = (100_000, 128);

/// Not criterion's: medians of frames drawn in turn, so that what slows the machine slows both: of
/// a mesh with other points, cells and scalars in each, and of one that stands still.
fn change(_: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let steps: Vec<TetMesh> = (0..16)
        .map(|step| wave(WAVE.0, step).expect("a valid size"))
        .collect();
    let volumes: Vec<Volume> = steps.iter().cloned().map(Volume::Mesh).collect();
    let mut bounds = steps[0].bounds();
    for step in &steps[1..] {
        let other = step.bounds();
        (bounds.min, bounds.max) = (bounds.min.min(other.min), bounds.max.max(other.max));
    }
    let ranges = volumes.iter().filter_map(Volume::scalar_range);
    let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    let mut file = SceneFile::new(VolumeSource::default());
    (file.image.width, file.image.height) = (Some(256), Some(256));
    let scene = file.resolve(&volumes[0]).expect("a valid scene");
    let dims = Lattice::dims_over(&bounds, WAVE.1);
    let options = ResamplingOptions {
        lattice: Some(Lattice::over(&bounds, dims).expect("a box")),
        domain: Some(Domain {
            bounds,
            scalar_range: range,
        }),
        ..Default::default()
    };
    let made = || Resampling::new(gpu, &volumes[0], &scene.appearance, &options);
    let mut renderers = [made().expect("it fits"), made().expect("it fits")];
    let mut seconds = [Vec::new(), Vec::new()];
    // Buffers grow in the first round.
    for round in 0..3 {
        let mut allocations = 0;
        for step in &volumes {
            for (volume, (renderer, seconds)) in [step, &volumes[0]]
                .into_iter()
                .zip(renderers.iter_mut().zip(&mut seconds))
            {
                let start = Instant::now();
                let before = gpu.allocations();
                renderer.reload(volume).expect("it fits");
                allocations += gpu.allocations() - before;
                black_box(renderer.render(&scene.view).expect("a frame"));
                if round > 0 {
                    seconds.push(start.elapsed().as_secs_f64());
                }
            }
        }
        println!("resample/change: round {round}: {allocations} buffers were made anew");
    }
    let [moving, still] = seconds.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    println!(
        "resample/change: {} cells, {dims:?} samples: made anew {moving:.4} s, still {still:.4} s, \
         ratio {:.3}",
        steps[0].cell_count(),
        moving / still
    );
}

criterion_group!(benches, figure_5, change);
criterion_main!(benches);
