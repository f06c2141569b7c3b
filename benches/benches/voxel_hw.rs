//! How long voxels take (`voxel-hw/blunt-fin 256x128x64/fixed-point`): upload of the mesh, and its
//! voxels on the device.
//!
//! The paper has no times. `resample` stands beside it, which takes samples at the same places.

use std::time::Duration;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use tetrascope::Context;
use tetrascope::core::TetMesh;
use tetrascope::core::grid::Lattice;
use tetrascope::gpu::Gpu;
use tetrascope::resample::{Resampler, ResamplerOptions};
use tetrascope::voxel_hw::{
    Arithmetic, Cells, Columns, DeviceVoxelizer, Items, Offsets, Voxelizer, VoxelizerOptions,
};

fn meshes() -> Vec<(&'static str, TetMesh, [usize; 3])> {
    let sphere = tetrascope_testing::data_set("sphere", None);
    let mut all = vec![("sphere", sphere, [128; 3])];
    if let Some(fin) = tetrascope_testing::blunt_fin("voxel-hw") {
        all.push(("blunt-fin", fin, [256, 128, 64]));
    }
    all
}

/// Names and options; the first is what the renderer takes, with one sample.
fn variants() -> Vec<(&'static str, VoxelizerOptions, Items)> {
    let usual = VoxelizerOptions {
        columns: Columns::Longest,
        ..VoxelizerOptions::default()
    };
    vec![
        ("fixed-point", usual, Items::Auto),
        ("pixels", usual, Items::Pixels),
        (
            "along z",
            VoxelizerOptions {
                columns: Columns::Z,
                ..usual
            },
            Items::Auto,
        ),
        (
            "float",
            VoxelizerOptions {
                arithmetic: Arithmetic::Float,
                ..usual
            },
            Items::Auto,
        ),
        (
            "as given",
            VoxelizerOptions {
                cells: Cells::AsGiven,
                ..usual
            },
            Items::Auto,
        ),
        (
            "2 samples",
            VoxelizerOptions {
                offsets: Offsets::Regular(2),
                ..usual
            },
            Items::Auto,
        ),
    ]
}

fn voxelize(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = tetrascope_benches::gpu(&context, tetrascope::voxel_hw::NAME) else {
        return;
    };
    for (name, mesh, dims) in meshes() {
        let [x, y, z] = dims;
        let mut group = criterion.benchmark_group(format!("voxel-hw/{name} {x}x{y}x{z}"));
        group
            .sample_size(10)
            .sampling_mode(SamplingMode::Flat)
            .warm_up_time(Duration::from_millis(1))
            .measurement_time(Duration::from_millis(500));
        let lattice = Lattice::over(&mesh.bounds(), dims).expect("a box");
        let mut resampler = resampler(gpu, &mesh, &lattice);
        group.bench_function("resample", |b| {
            b.iter(|| {
                resampler.reload(&mesh).expect("it fits");
                resampler.resample().expect("samples");
            });
        });
        for (variant, options, items) in variants() {
            if options.cells == Cells::AsGiven && mesh.cells().is_none() {
                continue;
            }
            let voxelizer = Voxelizer::new(options).expect("valid options");
            let made = DeviceVoxelizer::with_items(gpu, &voxelizer, &mesh, &lattice, items);
            let mut voxelizer = made.expect("it fits");
            group.bench_function(variant, |b| {
                b.iter(|| {
                    voxelizer.reload(&mesh).expect("it fits");
                    voxelizer.voxelize().expect("voxels");
                });
            });
        }
        group.finish();
    }
}

fn resampler(gpu: &Gpu, mesh: &TetMesh, lattice: &Lattice) -> Resampler {
    Resampler::new(gpu, mesh, lattice, &ResamplerOptions::default()).expect("it fits")
}

criterion_group!(benches, voxelize);
criterion_main!(benches);
