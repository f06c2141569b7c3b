//! Figures 4 and 5 of Rezk Salama and Kolb, and what moving to the vertex stage gains:
//! `slicing/figure 4/aneurism/hides a third/16`, where 16 is the number of boxes per axis.
//!
//! Slices are shaded as published: post-classification, filtered by the texture unit; of
//! figure 5 also lit by gradients on the fly. `cargo xtask compare` draws the figures from
//! criterion's results. Images are small, and two volumes and five subdivisions are drawn, so that
//! the figures take less than five minutes on a software adapter with two cores; `TETRASCOPE_SIDE=512`
//! gives the paper's size, `TETRASCOPE_WHOLE=1` another volume and every subdivision.

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, criterion_group, criterion_main,
};
use tetrascope::Context;
use tetrascope::core::glam::DVec3;
use tetrascope::core::{
    Appearance, Camera, CameraFit, Knot, OpticalModel, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope::datasets::angiography;
use tetrascope::gpu::Gpu;
use tetrascope::io::{FileData, ReadOptions, read_file};
use tetrascope::slicing::counters::{BRICKS_DRAWN, FRAGMENTS, GEOMETRY_BYTES, VERTICES};
use tetrascope::slicing::{
    Filtering, Integration, Level, Shading, Slicer, Slicing, SlicingOptions, Traversal,
};

/// Pixels per side, unless `TETRASCOPE_SIDE` says otherwise.
const SIDE: u32 = 64;

fn side() -> u32 {
    let side = std::env::var("TETRASCOPE_SIDE");
    let side = side.ok().and_then(|side| side.parse().ok());
    side.unwrap_or(SIDE)
}

/// Whether all volumes and subdivisions are drawn.
fn is_whole() -> bool {
    std::env::var_os("TETRASCOPE_WHOLE").is_some_and(|value| value != "0")
}

/// The subdivisions of the figures, 2ⁿ boxes along each axis: those that the paper's text names, none,
/// one between them and one behind.
fn levels_drawn() -> Vec<u32> {
    match is_whole() {
        true => (0..=6).collect(),
        false => vec![0, 2, 4, 5, 6],
    }
}

/// The device, or why there is none.
fn gpu(context: &Context) -> Option<&Gpu> {
    tetrascope_benches::gpu(context, tetrascope::slicing::NAME)
}

/// A grid in a file; without it, says that it is skipped.
fn file(name: &str) -> Option<Volume> {
    let path = tetrascope_testing::file("slicing", name)?;
    match read_file(&path, &ReadOptions::default()).expect("a valid file") {
        FileData::Grid(grid) => Some(grid.into_volume(None).expect("it has a field").0),
        FileData::Mesh(_) | FileData::Clusters(_) => panic!("{} is not a grid", path.display()),
    }
}

/// The volumes of the figures.
fn volumes() -> Vec<(&'static str, Volume)> {
    let generated = || angiography([512, 512, 96], 1).map(Volume::Grid).ok();
    let all = [
        ("aneurism", file("aneurism.vti")),
        (
            "CT_AVM",
            is_whole().then(|| file("CT_AVM.nii.gz")).flatten(),
        ),
        ("angiography", generated()),
    ];
    all.into_iter()
        .filter_map(|(name, volume)| Some((name, volume?)))
        .collect()
}

/// Transparent below `share` of the range of scalars.
fn hides(volume: &Volume, share: f64) -> Appearance {
    let (low, high) = volume.scalar_range().expect("there are samples");
    let thick = 40.0 / volume.bounds().diagonal();
    let knots = [(share, 0.0), (share, 0.2 * thick), (1.0, thick)];
    let knots = knots.map(|(share, extinction)| Knot {
        scalar: low + share * (high - low),
        color: DVec3::new(1.0, 0.4 + 0.5 * share.max(0.0), 0.3),
        extinction,
    });
    let tf = TransferFunction::new(knots.to_vec()).expect("sorted");
    Appearance::new(tf, OpticalModel::EmissionAbsorption)
}

fn view(volume: &Volume) -> View {
    View {
        camera: Camera::fit(&volume.bounds(), CameraFit::PlusIso, false, 1.0),
        width: side(),
        height: side(),
        background: [0.0; 4],
    }
}

/// Slices as published, one per sample.
fn published(level: Level, shading: Shading) -> SlicingOptions {
    SlicingOptions {
        slices_per_voxel: 1.0,
        integration: Integration::PostClassified,
        filtering: Filtering::Hardware,
        slicer: Slicer::VertexProgram,
        level,
        shading,
        ..SlicingOptions::default()
    }
}

fn quick(group: &mut BenchmarkGroup<WallTime>) {
    group
        .sample_size(10)
        .sampling_mode(SamplingMode::Flat)
        .warm_up_time(Duration::from_millis(1))
        .measurement_time(Duration::from_millis(500));
}

/// Frames against subdivision: two transfer functions, unshaded and shaded.
fn figures(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    for (name, volume) in volumes() {
        for (figure, shading) in [(4, Shading::None), (5, Shading::Phong(Default::default()))] {
            for (hidden, share) in [("a third", 1.0 / 3.0), ("a half", 0.5)] {
                let group = format!("slicing/figure {figure}/{name}/hides {hidden}");
                let mut group = criterion.benchmark_group(group);
                quick(&mut group);
                let look = hides(&volume, share);
                let view = view(&volume);
                for level in levels_drawn() {
                    let options = published(Level::Fixed(level), shading);
                    let slicing = Slicing::new(gpu, &volume, &look, &options);
                    let slicing = slicing.expect("the volume fits");
                    let id = BenchmarkId::from_parameter(1 << level);
                    group.bench_function(id, |b| {
                        b.iter(|| black_box(slicing.render(&view).expect("drawn before")));
                    });
                }
                group.finish();
            }
        }
    }
}

/// Who cuts and who orders boxes, and the bytes that it takes.
fn stages(criterion: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let volume = Volume::Grid(angiography([256, 256, 96], 1).expect("a valid size"));
    let (look, view) = (hides(&volume, 0.5), view(&volume));
    let mut group = criterion.benchmark_group("slicing/stages/angiography");
    quick(&mut group);
    for (name, slicer, traversal) in [
        ("polygons on the CPU", Slicer::Cpu, Traversal::Cpu),
        (
            "polygons in the vertex stage",
            Slicer::VertexProgram,
            Traversal::Cpu,
        ),
        (
            "boxes on the GPU too",
            Slicer::VertexProgram,
            Traversal::Gpu,
        ),
        ("rays", Slicer::Rays, Traversal::Cpu),
    ] {
        let options = SlicingOptions {
            slicer,
            traversal,
            ..published(Level::Fixed(5), Shading::None)
        };
        let slicing = Slicing::new(gpu, &volume, &look, &options).expect("the volume fits");
        let stats = slicing.render(&view).expect("a picture").stats;
        println!(
            "{name}: {} boxes, {} vertices, {} bytes a frame",
            stats.get(BRICKS_DRAWN).unwrap_or(0),
            stats.get(VERTICES).unwrap_or(0),
            stats.get(GEOMETRY_BYTES).unwrap_or(0)
        );
        group.bench_function(name, |b| {
            b.iter(|| black_box(slicing.render(&view).expect("drawn before")));
        });
    }
    group.finish();
}

/// Not criterion's: ratios of medians of frames drawn in turn, so that what slows the
/// machine slows both. A volume that is opaque everywhere at the level that is chosen
/// against one box, which may cost 5 % at most; and the aneurism at the best level.
fn levels(_: &mut Criterion) {
    let context = Context::new();
    let Some(gpu) = gpu(&context) else { return };
    let Some(volume) = file("aneurism.vti") else {
        return;
    };
    let view = view(&volume);
    for (name, share) in [("opaque", -1.0), ("hides a third", 1.0 / 3.0)] {
        let look = hides(&volume, share);
        let renderers = [Level::Fixed(0), Level::Auto].map(|level| {
            let options = SlicingOptions {
                level,
                ..SlicingOptions::default()
            };
            Slicing::new(gpu, &volume, &look, &options).expect("the volume fits")
        });
        let mut seconds = [Vec::new(), Vec::new()];
        let mut stats = [None, None];
        for _ in 0..5 {
            for (i, renderer) in renderers.iter().enumerate() {
                let start = Instant::now();
                let frame = renderer.render(&view).expect("a picture");
                seconds[i].push(start.elapsed().as_secs_f64());
                stats[i] = Some(frame.stats);
            }
        }
        let [one, auto] = seconds.map(|mut times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        });
        let fragments = stats
            .clone()
            .map(|s| s.and_then(|s| s.get(FRAGMENTS)).unwrap_or(0));
        let boxes = stats.map(|s| s.and_then(|s| s.get(BRICKS_DRAWN)).unwrap_or(0));
        println!(
            "aneurism, {name}: one box {:.3} s, auto {:.3} s, ratio {:.3}; fragments {} and {}; \
             {} boxes",
            one,
            auto,
            auto / one,
            fragments[0],
            fragments[1],
            boxes[1]
        );
    }
}

criterion_group!(benches, figures, stages, levels);
criterion_main!(benches);
