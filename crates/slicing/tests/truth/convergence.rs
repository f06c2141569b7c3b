//! How fast pictures approach the truth as slices get closer.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Grid, OpticalModel};
use tetrascope_gpu::Gpu;
use tetrascope_slicing::{Integration, SlabEnds, SlicingOptions, StepLength};

use crate::support::*;

/// A Gaussian ball that does not end inside of the box.
fn ball(n: usize) -> Grid {
    grid(&cube(n), |p| {
        (-(p - DVec3::splat(0.5)).length_squared() / 0.08).exp()
    })
}

/// The negative slope of log error over log slices per voxel, by least squares.
fn order(errors: &[(f64, f64)]) -> f64 {
    let points: Vec<(f64, f64)> = errors.iter().map(|(n, e)| (n.ln(), e.ln())).collect();
    let count = points.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / count;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let covariance = mean(&|p| (p.0 - x) * (p.1 - y));
    -covariance / mean(&|p| (p.0 - x) * (p.0 - x))
}

/// The views that converge: from outside, in both projections.
const VIEWS: [&str; 2] = ["perspective", "orthographic"];

/// Errors of `options` against the exact picture at 1 to 16 slices per voxel.
fn errors(
    gpu: &Gpu,
    options: &SlicingOptions,
    grid: &Grid,
    model: OpticalModel,
    wanted: &str,
) -> Vec<(f64, f64)> {
    // Light that nothing hides adds up; so little of it leaves the picture below 1.
    let most = if model == OpticalModel::Emission {
        1.5
    } else {
        6.0
    };
    let appearance = appearance(&ramp(most), model);
    let found = views(grid).into_iter().find(|(name, _)| *name == wanted);
    let (_, view) = found.expect("listed");
    let truth = truth(grid, &appearance, &view);
    [1.0, 2.0, 4.0, 8.0, 16.0]
        .map(|slices_per_voxel| {
            let options = SlicingOptions {
                slices_per_voxel,
                ..options.clone()
            };
            let frame = draw(gpu, grid, &appearance, &options, &view);
            (slices_per_voxel, difference(&frame, &truth).0)
        })
        .to_vec()
}

/// That errors fall at second order, from 1e-3 at two slices per voxel.
///
/// Trapezoids and midpoints have it. The order is measured where errors are above 1e-6, as
/// blending 16 · 9 · √3 slabs in f32 loses up to 250 · 2⁻²⁴ = 1.5e-5, though hundreds of
/// roundings that go either way lose a twentieth of that.
fn assert_second_order(name: &str, integration: Integration) {
    let Some(gpu) = testing::gpu(name) else {
        return;
    };
    let options = SlicingOptions {
        integration,
        ..Default::default()
    };
    let models = OpticalModel::VOLUMETRIC.into_iter();
    for model in models.filter(|model| *model != OpticalModel::MaximumIntensity) {
        for view in VIEWS {
            let mut errors = errors(&gpu, &options, &ball(9), model, view);
            errors.retain(|(_, error)| *error > 1e-6);
            let order = order(&errors);
            eprintln!("{integration:?} {model:?} {view}: order {order:.2}, {errors:?}");
            assert!(errors.len() >= 4, "{model:?} {view}: {errors:?}");
            assert!(errors[1].1 <= 1e-3, "{model:?} {view}: {errors:?}");
            assert!(
                (order - 2.0).abs() < 0.2,
                "{model:?} {view}: {order} {errors:?}"
            );
        }
    }
}

/// The greatest of samples h apart misses a smooth maximum by O(h²), and one in a kink, as
/// trilinear interpolation has at faces between cells, by O(h). In the middle of slabs it
/// also misses a ray's ends by h/2, so that all is of first order; samples at both ends of
/// slabs have them, and something between first and second order is left. How deep
/// kinks are falls with the size of cells.
#[test]
fn maxima_converge_at_first_order() {
    let Some(gpu) = testing::gpu("maxima_converge_at_first_order") else {
        return;
    };
    let orders = [
        (Integration::PostClassified, 0.8..1.2),
        (Integration::Slabs, 0.8..2.2),
    ];
    for (integration, orders) in orders {
        let options = SlicingOptions {
            integration,
            ..Default::default()
        };
        let model = OpticalModel::MaximumIntensity;
        for view in VIEWS {
            let errors = errors(&gpu, &options, &ball(17), model, view);
            let order = order(&errors);
            eprintln!("{integration:?} {model:?} {view}: order {order:.2}, {errors:?}");
            assert!(errors[1].1 <= 1e-3, "{integration:?} {view}: {errors:?}");
            assert!(
                orders.contains(&order),
                "{integration:?} {view}: {order} {errors:?}"
            );
        }
    }
}

/// The error that is left with 64 slices per voxel, some 900 slabs per ray, is that of f32: at most 900 · 2⁻²⁴ =
/// 5e-5, of which roundings that go either way leave about 1/√900.
#[test]
fn the_floor_is_that_of_f32() {
    let Some(gpu) = testing::gpu("the_floor_is_that_of_f32") else {
        return;
    };
    let grid = ball(9);
    let appearance = appearance(&ramp(6.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&grid).swap_remove(0);
    let truth = truth(&grid, &appearance, &view);
    for integration in [Integration::PostClassified, Integration::Slabs] {
        let options = SlicingOptions {
            integration,
            slices_per_voxel: 64.0,
            ..Default::default()
        };
        let frame = draw(&gpu, &grid, &appearance, &options, &view);
        let (rmse, most) = difference(&frame, &truth);
        eprintln!("{integration:?}: RMSE {rmse:.1e}, at most {most:.1e}");
        assert!(
            rmse < 2e-6 && most < 5e-5,
            "{integration:?}: {rmse:e} {most:e}"
        );
    }
}

/// Slabs between samples, in every model and both projections.
#[test]
fn slabs_converge_at_second_order() {
    assert_second_order("slabs_converge_at_second_order", Integration::Slabs);
}

/// Post-classification in the slabs' middles, as the transfer function is continuous.
#[test]
fn post_classification_converges_at_second_order() {
    let name = "post_classification_converges_at_second_order";
    assert_second_order(name, Integration::PostClassified);
}

/// The published slices count whole where a ray enters and leaves: first order.
#[test]
fn whole_slices_converge_at_first_order() {
    let options = SlicingOptions {
        integration: Integration::PostClassified,
        slab_ends: SlabEnds::Whole,
        ..Default::default()
    };
    let Some(gpu) = testing::gpu("whole_slices_converge_at_first_order") else {
        return;
    };
    // Opaque at the borders, so that they show.
    let grid = grid(&cube(9), |_| 0.5);
    let appearance = appearance(&ramp(3.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&grid).swap_remove(0);
    let truth = truth(&grid, &appearance, &view);
    let errors: Vec<(f64, f64)> = [1.0, 2.0, 4.0, 8.0, 16.0]
        .into_iter()
        .map(|slices_per_voxel| {
            let options = SlicingOptions {
                slices_per_voxel,
                ..options.clone()
            };
            let frame = draw(&gpu, &grid, &appearance, &options, &view);
            (slices_per_voxel, difference(&frame, &truth).0)
        })
        .collect();
    eprintln!("{errors:?}, order {:.2}", order(&errors));
    // Where a ray's end falls between planes varies from pixel to pixel, so that the RMSE is
    // that of an even distribution and follows the slope closely.
    assert!((order(&errors) - 1.0).abs() < 0.2, "{errors:?}");
}

// Uncorrected planar slices are 1/cos θ too thin: in a uniform box seen at the angle θ
// the optical depth is too small by 1 − cos θ.
#[test]
fn planar_steps_lose_depth_at_an_angle() {
    let Some(gpu) = testing::gpu("planar_steps_lose_depth_at_an_angle") else {
        return;
    };
    let grid = grid(&cube(5), |_| 1.0);
    let appearance = appearance(&ramp(1.5), OpticalModel::Absorption);
    let (name, mut view) = views(&grid).swap_remove(3);
    assert_eq!(name, "inside");
    view.background = [0.0, 0.0, 0.0, 0.0];
    let options = SlicingOptions {
        step_length: StepLength::Planar,
        ..Default::default()
    };
    let planar = draw(&gpu, &grid, &appearance, &options, &view);
    let (_, _, forward) = view.camera.axes();
    let truth = pixels(&view, |ray| {
        let (start, end) = span(&grid, ray);
        let cosine = ray.direction.dot(forward);
        [0.0, 0.0, 0.0, -(-1.5 * (end - start) * cosine).exp_m1()]
    });
    let (_, most) = difference(&planar, &truth);
    // Blending of some 20 slabs in f32.
    assert!(most < 5e-6, "{most:e}");
    let exact = draw(&gpu, &grid, &appearance, &Default::default(), &view);
    assert!(
        between(&planar, &exact).1 > 0.01,
        "the correction must show"
    );
}
