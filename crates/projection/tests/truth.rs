//! Cell projection against the ground truth.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Frame, OpticalModel, Projection as Spread, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_datasets::{Options, find};
use tetrascope_gpu::{Gpu, testing};
use tetrascope_projection::{Projection, ProjectionOptions};
use tetrascope_reference::{Reference, ReferenceOptions};

/// A data set with its own transfer function.
fn scene(name: &str, cells: u64) -> (Volume, TransferFunction) {
    let dataset = find(name).expect("a data set");
    let options = Options {
        cells: Some(cells),
        seed: None,
    };
    let volume = Volume::Mesh(dataset.mesh(&options).expect("a mesh"));
    let scene = dataset.scene().resolve(&volume).expect("a scene");
    (volume, scene.appearance.transfer_function)
}

/// From two sides, from a crooked one and along an axis, both projections, and from inside.
fn views(volume: &Volume) -> Vec<(&'static str, View)> {
    let bounds = volume.bounds();
    let fit = |side, orthographic| Camera::fit(&bounds, side, orthographic, 1.0);
    let crooked = |orthographic| {
        let camera = fit(CameraFit::PlusIso, orthographic);
        Camera {
            position: camera.position + bounds.diagonal() * DVec3::new(0.3, -0.1, 0.07),
            ..camera
        }
    };
    // Not a vertex: an irrational share of the box.
    let eye = bounds.min + bounds.size() * DVec3::new(0.41, 0.47, 0.53);
    let inside = Camera {
        position: eye,
        focal_point: eye + bounds.diagonal() * DVec3::new(0.7, 0.4, -0.2),
        view_up: DVec3::Z,
        projection: Spread::Perspective { view_angle: 75.0 },
    };
    let plane_inside = Camera {
        projection: Spread::Orthographic {
            parallel_scale: 0.3 * bounds.diagonal(),
        },
        ..inside
    };
    let view = |camera| View {
        camera,
        width: 96,
        height: 96,
        background: [0.2, 0.3, 0.1, 0.6],
    };
    vec![
        ("perspective", view(crooked(false))),
        ("orthographic", view(crooked(true))),
        ("along an axis", view(fit(CameraFit::PlusX, true))),
        ("inside", view(inside)),
        ("plane inside", view(plane_inside)),
    ]
}

fn drawn(gpu: &Gpu, volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let options = ProjectionOptions::default();
    let renderer = Projection::new(gpu, volume, appearance, &options).expect("the mesh fits");
    renderer.render(view).expect("nothing can fail")
}

fn truth(volume: &Volume, appearance: &Appearance, view: &View) -> Frame {
    let options = ReferenceOptions::default();
    let reference = Reference::new(volume, appearance, &options).expect("a mesh");
    reference.render(view).expect("a picture")
}

/// Root mean square and greatest difference over all channels.
fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!((a.width, a.height), (b.width, b.height));
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let squares: Vec<f64> = pairs.map(|(x, y)| f64::from(x - y).powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (
        mean.sqrt(),
        squares.iter().copied().fold(0.0, f64::max).sqrt(),
    )
}

/// Draws `name` in every view and model and compares it with the truth.
fn compare(test: &str, name: &str, cells: u64, sorted_tolerance: f64) {
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let (volume, transfer_function) = scene(name, cells);
    for optical_model in OpticalModel::ALL {
        let appearance = Appearance {
            transfer_function: transfer_function.clone(),
            optical_model,
        };
        for (from, view) in views(&volume) {
            let picture = drawn(&gpu, &volume, &appearance, &view);
            let truth = truth(&volume, &appearance, &view);
            let (rmse, worst) = difference(&picture, &truth);
            eprintln!("{name} {optical_model:?} {from}: RMSE {rmse:.1e}, max {worst:.1e}");
            let tolerance = if optical_model.commutes() {
                2e-5
            } else {
                sorted_tolerance
            };
            assert!(
                rmse <= tolerance,
                "{name} {optical_model:?} {from}: {rmse:e}"
            );
        }
    }
}

#[test]
fn the_sphere_is_drawn_right() {
    compare("the_sphere_is_drawn_right", "sphere", 3000, 2e-3);
}

#[test]
fn the_torus_is_drawn_right() {
    compare("the_torus_is_drawn_right", "torus", 3000, 2e-3);
}
