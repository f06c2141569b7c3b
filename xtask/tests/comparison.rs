//! Every renderer with every setting of its sweep against the ground truth.

use tetrascope::core::glam::DVec3;
use tetrascope::core::scene::VolumeSource;
use tetrascope::core::{Camera, OpticalModel, Projection, Scene, SceneFile, View, Volume};
use xtask::testing::{Failures, admitted, algorithms, draw, drawn_by, promising, truth};

const SIDE: u32 = 96;

/// A small data set and the RMSE that is allowed on it.
struct Case {
    dataset: &'static str,
    cells: u64,
    /// In `EmissionAbsorption`, where cells in the wrong order show.
    ordered: f64,
}

/// In models that commute nothing depends on the order of cells. What is left is f32:
/// 100 cells on a ray of light up to 4 (extinction is scaled to that) add 100 · 4 · 2⁻²⁴ =
/// 2.4e-5, and the geometry 1e-5 as in the analytic test. The allowed error is
/// what the comparison promises for every mesh.
const COMMUTATIVE: f64 = 1e-4;

/// Pixels that may differ by anything, as a rasterizer snaps vertices to 1/256 of a
/// pixel and a ray that close to an edge may see a cell or not. That shows where
/// what is seen jumps: at the silhouette in `MaximumIntensity` (some 1000 of 96² pixels
/// are on that of the heat sink's fins, 1000 · 2/256 = 8), and at slivers, which are
/// deep from their very edge on.
fn outliers(model: OpticalModel, case: &Case) -> usize {
    let jumps = model == OpticalModel::MaximumIntensity || case.dataset == "graded";
    if jumps { 8 } else { 0 }
}

const CASES: &[Case] = &[
    // Cells of one size sorted by their centers: two of neighbors may swap, which
    // moves light by the product of their opacities. The comparison promises 2e-3.
    Case {
        dataset: "sphere",
        cells: 3000,
        ordered: 2e-3,
    },
    Case {
        dataset: "orbital",
        cells: 3000,
        ordered: 2e-3,
    },
    // Coarse cells are larger against the whole and hide more of each other.
    Case {
        dataset: "heat-sink",
        cells: 3000,
        ordered: 1e-2,
    },
    Case {
        dataset: "staircase",
        cells: 23,
        ordered: 1e-2,
    },
    Case {
        dataset: "torus",
        cells: 3000,
        ordered: 1e-2,
    },
    // Cells of very different size and slivers: centers say little about the order.
    Case {
        dataset: "delaunay",
        cells: 3000,
        ordered: 2e-2,
    },
    Case {
        dataset: "graded",
        cells: 3000,
        ordered: 5e-2,
    },
];

fn load(case: &Case) -> (Volume, SceneFile) {
    let dataset = tetrascope::datasets::find(case.dataset).expect("listed");
    let mut file = dataset.scene();
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

fn resolve(file: &SceneFile, model: OpticalModel, volume: &Volume) -> Scene {
    xtask::compare::resolve(file, model, volume).expect("a valid scene")
}

/// The scene's own view, the same in parallel, and one from inside.
fn views(scene: &Scene, volume: &Volume) -> Vec<(&'static str, View)> {
    let (view, camera) = (scene.view, scene.view.camera);
    let bounds = volume.bounds();
    let parallel = Camera {
        projection: Projection::Orthographic {
            parallel_scale: bounds.diagonal() / 2.0,
        },
        ..camera
    };
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
        let scene = resolve(&file, model, &volume);
        for (from, view) in views(&scene, &volume) {
            let expected = truth(&volume, &scene.appearance, &view);
            for algorithm in algorithms.iter().filter(|a| a.name != "reference") {
                for setting in promising(algorithm, model) {
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
                    let rmse = if model.commutes() {
                        COMMUTATIVE
                    } else {
                        case.ordered
                    };
                    let rmse = rmse + admitted(algorithm, setting);
                    failures.compare_most(&name, &expected, &frame, rmse, outliers(model, case));
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

// A comparison that cannot fail is none: another scene's truth must not pass.
#[test]
#[should_panic(expected = "greatest difference")]
fn another_picture_fails() {
    let (volume, file) = load(&CASES[0]);
    let scene = resolve(&file, OpticalModel::EmissionAbsorption, &volume);
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
        CASES[0].ordered,
        1.0,
    );
    failures.finish();
}
