//! How fast pictures approach the truth as slices get closer.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Grid, OpticalModel};
use tetrascope_gpu::testing;
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

fn errors(options: &SlicingOptions) -> Option<Vec<(f64, f64)>> {
    let gpu = testing::gpu("convergence")?;
    let grid = ball(9);
    let appearance = appearance(&ramp(6.0), OpticalModel::EmissionAbsorption);
    let (name, view) = views(&grid).swap_remove(0);
    assert_eq!(name, "perspective");
    let truth = truth(&grid, &appearance, &view, 512.0);
    let errors = [1.0, 2.0, 4.0, 8.0].map(|slices_per_voxel| {
        let options = SlicingOptions {
            slices_per_voxel,
            ..options.clone()
        };
        let frame = draw(&gpu, &grid, &appearance, &options, &view);
        (slices_per_voxel, difference(&frame, &truth).0)
    });
    eprintln!("{options:?}\n{errors:?}, order {:.2}", order(&errors));
    Some(errors.to_vec())
}

/// Trapezoids: second order, and far under 1e-3 at two slices a voxel.
#[test]
fn slabs_converge_at_second_order() {
    let Some(errors) = errors(&SlicingOptions::default()) else {
        return;
    };
    assert!((order(&errors) - 2.0).abs() < 0.2, "{errors:?}");
    assert!(errors[1].1 < 1e-3, "{errors:?}");
}

/// Midpoints: second order too, as the transfer function is continuous.
#[test]
fn post_classification_converges_at_second_order() {
    let options = SlicingOptions {
        integration: Integration::PostClassified,
        ..Default::default()
    };
    let Some(errors) = errors(&options) else {
        return;
    };
    assert!((order(&errors) - 2.0).abs() < 0.2, "{errors:?}");
    assert!(errors[1].1 < 1e-3, "{errors:?}");
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
    let truth = truth(&grid, &appearance, &view, 1.0);
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
