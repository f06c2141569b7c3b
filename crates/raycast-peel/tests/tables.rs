//! Segments from tables of the integral, in both forms.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, DepthCue, Error, Frame, Knot, OpticalModel, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_datasets::{Options, find};
use tetrascope_gpu::{Gpu, testing};
use tetrascope_raycast_peel::{Integration, Passes, RaycastOptions, RaycastPeel};

/// A sphere under a transfer function without steps, dense enough to hide its back.
fn scene(model: OpticalModel) -> (Volume, Appearance, View) {
    let options = Options {
        cells: Some(3000),
        ..Options::default()
    };
    let mesh = find("sphere").expect("a data set").mesh(&options);
    let volume = Volume::Mesh(mesh.expect("a mesh"));
    let (low, high) = volume.scalar_range().expect("scalars");
    let size = volume.bounds().diagonal();
    let knot = |share: f64, color, depth: f64| Knot {
        scalar: low + share * (high - low),
        color,
        extinction: depth / size,
    };
    let function = TransferFunction::new(vec![
        knot(0.1, DVec3::X, 0.5),
        knot(0.5, DVec3::new(0.2, 1.0, 0.3), 3.0),
        knot(0.9, DVec3::Z, 6.0),
    ]);
    let view = View {
        camera: Camera::fit(&volume.bounds(), CameraFit::PlusIso, false, 1.0),
        width: 40,
        height: 40,
        background: [0.1, 0.2, 0.3, 0.5],
    };
    let appearance = Appearance::new(function.expect("valid knots"), model);
    (volume, appearance, view)
}

fn draw(
    gpu: &Gpu,
    (volume, appearance, view): &(Volume, Appearance, View),
    passes: Passes,
    integration: Integration,
) -> Frame {
    let options = RaycastOptions {
        passes,
        integration,
        ..RaycastOptions::default()
    };
    let renderer = RaycastPeel::new(gpu, volume, appearance, &options).expect("a mesh");
    renderer.render(view).expect("a frame")
}

fn rmse(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let sum: f64 = pairs.map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / (4 * a.pixels.len()) as f64).sqrt()
}

/// The table's error is of second order in its samples' distance: from 16 to 32 samples a
/// side it falls to about a quarter; a third leaves room for the knots between samples,
/// whose error falls more slowly. A maximum has an edge in the table and errs in
/// first order there, by up to its slope times the distance, 2/31. Both forms read the
/// same table.
#[test]
fn tables_converge_and_both_forms_agree() {
    let Some(gpu) = testing::gpu("tables_converge_and_both_forms_agree") else {
        return;
    };
    type OfSide = fn(u32) -> Integration;
    let two: OfSide = |n| Integration::Table2d { n };
    let three: OfSide = |n| Integration::Table3d { n };
    for (model, of_side) in [
        (OpticalModel::EmissionAbsorption, three),
        (OpticalModel::Absorption, two),
        (OpticalModel::Absorption, three),
        (OpticalModel::Emission, two),
        (OpticalModel::MaximumIntensity, two),
    ] {
        let scene = scene(model);
        let exact = draw(&gpu, &scene, Passes::Single, Integration::Exact);
        let [coarse, fine] = [16, 32].map(of_side);
        let coarse = draw(&gpu, &scene, Passes::Single, coarse);
        let single = draw(&gpu, &scene, Passes::Single, fine);
        let ping_pong = draw(&gpu, &scene, Passes::PingPong, fine);
        let (coarse, single_error) = (rmse(&exact, &coarse), rmse(&exact, &single));
        let apart = rmse(&single, &ping_pong);
        let what = format!("{}, {fine:?}", model.name());
        println!("{what}: {coarse:.1e}, {single_error:.1e}; forms {apart:.1e}");
        assert!(single_error > 1e-9, "{what}: there is no table");
        let (most, fall) = match model {
            OpticalModel::MaximumIntensity => (2.0 / 31.0, 1.5),
            _ => (1e-3, 3.0),
        };
        assert!(single_error < most, "{what}: {single_error:e}");
        assert!(single_error < coarse / fall, "{what}: {single_error:e}");
        // As where both integrate exactly (`ping_pong.rs`).
        assert!(apart <= 1e-5, "{what}: {apart:e}");
    }
}

#[test]
fn what_no_table_has_is_refused() {
    let Some(gpu) = testing::gpu("what_no_table_has_is_refused") else {
        return;
    };
    let (volume, appearance, _) = scene(OpticalModel::EmissionAbsorption);
    for passes in [Passes::Single, Passes::PingPong] {
        let options = RaycastOptions {
            passes,
            integration: Integration::Table2d { n: 64 },
            ..RaycastOptions::default()
        };
        let refused = RaycastPeel::new(&gpu, &volume, &appearance, &options);
        assert!(matches!(refused, Err(Error::Unsupported { .. })));
    }
    let cued = Appearance {
        depth_cue: Some(DepthCue { strength: 0.5 }),
        ..appearance
    };
    let options = RaycastOptions {
        integration: Integration::Table3d { n: 64 },
        ..RaycastOptions::default()
    };
    let refused = RaycastPeel::new(&gpu, &volume, &cued, &options);
    assert!(matches!(refused, Err(Error::Unsupported { .. })));
}
