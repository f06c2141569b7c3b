//! Build, restyle and frame time of every algorithm: `projection/sphere/149k cells/frame`.
//!
//! Times are wall times with the readback in them; `cargo xtask compare` gives device
//! times beside errors.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use tetrascope::core::{OpticalModel, VolumeRenderer as _};
use tetrascope::{Context, Settings};
use tetrascope_benches::cases;

fn frames(criterion: &mut Criterion) {
    let context = Context::new();
    for case in cases() {
        for algorithm in tetrascope::algorithms() {
            if algorithm.needs_gpu
                && let Err(error) = context.gpu()
            {
                eprintln!("skipped: {}: {error}", algorithm.name);
                continue;
            }
            let (volume, scene) = (&case.volume, &case.scene);
            let settings = Settings::defaults(algorithm);
            if let Err(error) =
                (algorithm.supports)(volume, &scene.appearance, &scene.view, &settings)
            {
                eprintln!("skipped: {error}");
                continue;
            }
            let build = || {
                (algorithm.build)(&context, volume, &scene.appearance, &settings)
                    .expect("the algorithm draws this scene")
            };
            let mut group = criterion.benchmark_group(format!("{}/{}", algorithm.name, case.name));
            group
                .sample_size(10)
                .measurement_time(Duration::from_secs(5));
            group.bench_function("build", |b| b.iter(|| black_box(build())));

            let mut renderer = build();
            let mut emission = scene.appearance.clone();
            emission.optical_model = OpticalModel::Emission;
            group.bench_function("restyle", |b| {
                // To another model and back: the same one could be left alone.
                b.iter(|| {
                    renderer.restyle(&emission).expect("every model is drawn");
                    renderer.restyle(&scene.appearance).expect("drawn before");
                });
            });
            for model in OpticalModel::VOLUMETRIC {
                let mut appearance = scene.appearance.clone();
                appearance.optical_model = model;
                if (algorithm.supports)(volume, &appearance, &scene.view, &settings).is_err() {
                    continue;
                }
                renderer
                    .restyle(&appearance)
                    .expect("a supported appearance");
                group.bench_function(format!("frame/{}", model.name()), |b| {
                    b.iter(|| black_box(renderer.render(&scene.view).expect("drawn before")));
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
