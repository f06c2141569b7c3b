//! Segments from tables of the integral, in both forms.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, CameraFit, DepthCue, Error, Frame, Knot, OpticalModel, TetMesh, TransferFunction,
    View, Volume,
};
use tetrascope_f32::mean_chord;
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::counters::CELL_VISITS;
use tetrascope_raycast_peel::{Integration, Passes, RaycastOptions, RaycastPeel};
use tetrascope_testing::{self as testing, ImageError, data_set, exactly, fitted};

use crate::common;

/// A sphere under a transfer function without steps, dense enough to hide its back.
fn scene(model: OpticalModel) -> (Volume, Appearance, View) {
    let volume = Volume::Mesh(data_set("sphere", Some(3000)));
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
    let view = fitted(&volume, CameraFit::PlusIso, false, 40);
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
    common::draw(gpu, volume, appearance, &options, view)
}

fn rmse(a: &Frame, b: &Frame) -> f64 {
    ImageError::against(&exactly(b), a).rmse
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

/// With σ alike everywhere each cell on a ray adds σ L to its optical depth, L being the mean
/// chord, so that depths are whole multiples of that and add up to all cells visited. The
/// view is along no lattice direction: no visit is without length. A depth up to 1 is known
/// from an opacity in f32, rounded in each of some 50 cells, to 50 e 2⁻²⁴: 1e-5 of the
/// greatest, and of one of 50 cells 5e-4.
#[test]
fn fixed_lengths_count_cells() {
    let Some(gpu) = testing::gpu("fixed_lengths_count_cells") else {
        return;
    };
    let small = data_set("sphere", Some(3000));
    // So that a normalized unit is more than one of the world.
    let points = small.points().iter().map(|&p| 5.0 * p).collect();
    let (cells, scalars) = (small.tetrahedra().to_vec(), small.scalars().clone());
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars).expect("a mesh");
    let length = mean_chord(&mesh);
    let volume = Volume::Mesh(mesh);
    let mut view = fitted(&volume, CameraFit::PlusIso, false, 40);
    view.background = [0.0; 4];
    view.camera.position += volume.bounds().size() * DVec3::new(0.31, 0.17, 0.0);
    let extinction = 0.02 / length;
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::ONE,
        extinction,
    };
    let (low, high) = volume.scalar_range().expect("scalars");
    // Knots of half the range: the table reaches beyond them.
    let knots = vec![knot(low), knot((low + high) / 2.0)];
    let function = TransferFunction::new(knots).expect("valid knots");
    for model in [OpticalModel::Absorption, OpticalModel::EmissionAbsorption] {
        let scene = (
            volume.clone(),
            Appearance::new(function.clone(), model),
            view,
        );
        let integration = Integration::TableFixed { n: 8 };
        let single = draw(&gpu, &scene, Passes::Single, integration);
        let ping_pong = draw(&gpu, &scene, Passes::PingPong, integration);
        for frame in [&single, &ping_pong] {
            let mut sum = 0.0;
            for pixel in &frame.pixels {
                let depth = -(-f64::from(pixel[3])).ln_1p();
                let cells = depth / 0.02;
                assert!((cells - cells.round()).abs() < 5e-3, "{pixel:?}: {cells}");
                sum += cells.round();
            }
            assert_eq!(Some(sum as u64), single.stats.get(CELL_VISITS));
        }
    }
}

/// The table's resolution is not what errs: the error stays as it becomes finer.
#[test]
fn fixed_lengths_err_by_lengths() {
    let Some(gpu) = testing::gpu("fixed_lengths_err_by_lengths") else {
        return;
    };
    let scene = scene(OpticalModel::EmissionAbsorption);
    let exact = draw(&gpu, &scene, Passes::Single, Integration::Exact);
    let error = |passes, n| {
        let frame = draw(&gpu, &scene, passes, Integration::TableFixed { n });
        (rmse(&exact, &frame), frame)
    };
    let (coarse, _) = error(Passes::Single, 32);
    let (fine, single) = error(Passes::Single, 256);
    let (_, ping_pong) = error(Passes::PingPong, 256);
    let apart = rmse(&single, &ping_pong);
    println!("fixed lengths: {coarse:.2e}, {fine:.2e}; forms {apart:.1e}");
    assert!(fine > 0.9 * coarse && fine > 1e-3, "{coarse:e} {fine:e}");
    assert!(apart <= 1e-5, "{apart:e}");
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
