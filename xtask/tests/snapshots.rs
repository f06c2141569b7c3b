//! Small reviewed pictures, which catch drift; they do not define what is right.
//!
//! `cargo xtask bless` accepts what the last run left in `target/snapshots`. Only the
//! ground truth, which is the same everywhere, and Mesa's llvmpipe, which everybody
//! can run, may bless.

use tetrascope::core::{Camera, OpticalModel, View, Volume};
use tetrascope::scene::{SceneFile, VolumeSource};
use xtask::compare::resolve;
use xtask::picture::shown;
use xtask::testing::{Failures, algorithms, check_snapshot, draw, drawn_by};

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

/// The view of reviewed pictures: from the data set's side, around the bounding sphere, which
/// is farther away than the default ([`Camera::frame`]).
fn reviewed(file: &SceneFile, view: &View, volume: &Volume) -> View {
    let from = file.camera.fit.expect("data sets name a side");
    let aspect = f64::from(view.width) / f64::from(view.height);
    View {
        camera: Camera::fit(&volume.bounds(), from, false, aspect),
        ..*view
    }
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
            let scene = resolve(&file, model, &volume).expect("a valid scene");
            let view = reviewed(&file, &scene.view, &volume);
            let Some(frame) = draw(algorithm, "", &volume, &scene.appearance, &view) else {
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
