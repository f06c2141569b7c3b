//! Every renderer with every setting of its sweep against the ground truth.

use tetrascope::Promise;
use tetrascope::core::glam::DVec3;
use tetrascope::core::{Camera, OpticalModel, Projection, View, Volume};
use tetrascope::scene::{Scene, SceneFile, VolumeSource};
use xtask::compare::resolve;
use xtask::limits::{ROUNDING, limit, outliers};
use xtask::testing::{Failures, algorithms, draw, drawn_by, promised, truth};

const SIDE: u32 = 96;

/// A small data set.
struct Case {
    dataset: &'static str,
    cells: u64,
    /// The RMSE allowed in `EmissionAbsorption` to cells that are sorted by their centers:
    /// about twice what was measured, from outside and from inside. The truth of such an
    /// order has no bound on uneven cells; that the others are right shows
    /// that it is the order which errs.
    rough: f64,
}

const CASES: &[Case] = &[
    // Cells of one size: two of neighbors may swap.
    Case {
        dataset: "sphere",
        cells: 3000,
        rough: 2e-5,
    },
    Case {
        dataset: "orbital",
        cells: 3000,
        rough: 8e-4,
    },
    // Long thin cells in fins, beside cubes.
    Case {
        dataset: "heat-sink",
        cells: 3000,
        rough: 1e-2,
    },
    Case {
        dataset: "staircase",
        cells: 23,
        rough: ROUNDING.0,
    },
    Case {
        dataset: "torus",
        cells: 3000,
        rough: 4e-3,
    },
    // Cells of very different size and slivers: centers say little about the order.
    Case {
        dataset: "delaunay",
        cells: 3000,
        rough: 1.5e-3,
    },
    Case {
        dataset: "graded",
        cells: 3000,
        rough: 3e-3,
    },
];

fn load(case: &Case) -> (Volume, SceneFile) {
    let dataset = tetrascope::datasets::find(case.dataset).expect("listed");
    let mut file = tetrascope::volumes::scene(dataset);
    file.volume = VolumeSource {
        cells: Some(case.cells),
        ..file.volume
    };
    (file.image.width, file.image.height) = (Some(SIDE), Some(SIDE));
    let volume = tetrascope::volumes::load(&file.volume)
        .expect("a data set")
        .volume;
    (volume, file)
}

/// The scene's own view, the same in parallel, and one from inside.
fn views(scene: &Scene, volume: &Volume) -> Vec<(&'static str, View)> {
    let (view, camera) = (scene.view, scene.view.camera);
    let bounds = volume.bounds();
    let parallel = camera.to_orthographic();
    // Off the center, where symmetric meshes have their vertices.
    let eye = bounds.center() + bounds.size() * DVec3::new(0.13, -0.07, 0.11);
    let inside = Camera {
        position: eye,
        focal_point: eye + (camera.focal_point - camera.position),
        projection: Projection::Perspective { view_angle: 70.0 },
        ..camera
    };
    vec![
        ("perspective", view),
        (
            "orthographic",
            View {
                camera: parallel,
                ..view
            },
        ),
        (
            "inside",
            View {
                camera: inside,
                ..view
            },
        ),
    ]
}

fn compare(model: OpticalModel) {
    let mut failures = Failures::default();
    let algorithms = algorithms(model.name());
    for case in CASES {
        let (volume, file) = load(case);
        let scene = resolve(&file, model, &volume).expect("a valid scene");
        for (from, view) in views(&scene, &volume) {
            let expected = truth(&volume, &scene.appearance, &view);
            for algorithm in algorithms.iter().filter(|a| !a.is_truth()) {
                for setting in (algorithm.sweep)(model) {
                    let promise = promised(algorithm, setting);
                    if promise == Promise::Open {
                        continue;
                    }
                    let Some(frame) = draw(algorithm, setting, &volume, &scene.appearance, &view)
                    else {
                        continue;
                    };
                    let name = format!(
                        "{} {setting}: {}, {}, {from} ({})",
                        algorithm.name,
                        case.dataset,
                        model.name(),
                        drawn_by(algorithm)
                    );
                    let limit = limit(promise, model, frame.stats.order_proven, Some(case.rough));
                    let limit = limit.expect("a rough order has its bound");
                    let outliers = outliers(model);
                    failures.compare_most(&name, &expected, &frame, limit, outliers);
                }
            }
        }
    }
    failures.finish();
}

#[test]
fn emission_absorption() {
    compare(OpticalModel::EmissionAbsorption);
}

#[test]
fn emission() {
    compare(OpticalModel::Emission);
}

#[test]
fn absorption() {
    compare(OpticalModel::Absorption);
}

#[test]
fn maximum_intensity() {
    compare(OpticalModel::MaximumIntensity);
}

#[test]
fn isosurfaces() {
    compare(OpticalModel::Isosurfaces);
}

// A comparison has to be able to fail: another scene's truth must not pass.
#[test]
#[should_panic(expected = "greatest difference")]
fn another_picture_fails() {
    let (volume, file) = load(&CASES[0]);
    let scene = resolve(&file, OpticalModel::EmissionAbsorption, &volume).expect("a valid scene");
    let views = views(&scene, &volume);
    let pictures: Vec<_> = views
        .iter()
        .map(|(_, view)| truth(&volume, &scene.appearance, view))
        .collect();
    let mut failures = Failures::default();
    failures.compare(
        "harness: another picture",
        &pictures[0],
        &pictures[1],
        CASES[0].rough,
        1.0,
    );
    failures.finish();
}
