//! Small reviewed pictures, which catch drift; they do not define what is right.
//!
//! `cargo xtask bless` accepts what the last run left in `target/snapshots`. Only the
//! ground truth, which is the same everywhere, and Mesa's llvmpipe, which everybody
//! can run, may bless.

use tetrascope::core::OpticalModel;
use tetrascope::scene::VolumeSource;
use xtask::picture::shown;
use xtask::testing::{self, Failures, algorithms, check_snapshot, draw, drawn_by};

const SIDE: u32 = 128;

/// Data set, cells, model.
const PICTURES: &[(&str, u64, OpticalModel)] = &[
    ("sphere", 3000, OpticalModel::EmissionAbsorption),
    ("sphere", 3000, OpticalModel::Emission),
    ("sphere", 3000, OpticalModel::Absorption),
    ("sphere", 3000, OpticalModel::MaximumIntensity),
    ("orbital", 3000, OpticalModel::EmissionAbsorption),
    ("heat-sink", 3000, OpticalModel::EmissionAbsorption),
    ("staircase", 23, OpticalModel::EmissionAbsorption),
    ("torus", 3000, OpticalModel::EmissionAbsorption),
    ("delaunay", 3000, OpticalModel::EmissionAbsorption),
    ("graded", 3000, OpticalModel::EmissionAbsorption),
];

/// Steps of 255 that may differ. The ground truth: one, where the mathematical
/// library rounds the other way. On a GPU: another driver's f32, and cells with equal
/// keys in another order, make two more.
fn steps(needs_gpu: bool) -> u8 {
    if needs_gpu { 3 } else { 1 }
}

#[test]
fn pictures_are_as_reviewed() {
    let mut failures = Failures::default();
    for algorithm in algorithms("snapshots") {
        let adapter = drawn_by(algorithm);
        let may_bless = !algorithm.needs_gpu || adapter.contains("llvmpipe");
        for &(dataset, cells, model) in PICTURES {
            let mut file =
                tetrascope::volumes::scene(tetrascope::datasets::find(dataset).expect("listed"));
            file.volume = VolumeSource {
                cells: Some(cells),
                ..file.volume
            };
            (file.image.width, file.image.height) = (Some(SIDE), Some(SIDE));
            let volume = tetrascope::volumes::load(&file.volume)
                .expect("a data set")
                .volume;
            let scene = testing::scene(&file, model, &volume);
            let Some(frame) = draw(algorithm, "", &volume, &scene.appearance, &scene.view) else {
                continue;
            };
            let name = format!("{dataset}-{}-{}", model.name(), algorithm.name);
            let steps = steps(algorithm.needs_gpu);
            if let Err(why) = check_snapshot(&name, &shown(&frame), steps, may_bless) {
                failures.push(format!("{why} (drawn by {adapter})"));
            }
        }
    }
    failures.finish();
}
