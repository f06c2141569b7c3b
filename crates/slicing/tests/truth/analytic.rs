//! Volumes with a closed-form answer.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::optics::{RayIntegral, Segment};
use tetrascope_core::{OpticalModel, TransferFunction};
use tetrascope_slicing::{Integration, SlicingOptions};

use crate::support::*;

/// Uniform σ: every slab adds its share whatever there are, so a ray's only numbers are
/// its length and the scalar.
#[test]
fn a_uniform_box_is_exact_with_any_number_of_slabs() {
    let Some(gpu) = testing::gpu("a_uniform_box_is_exact_with_any_number_of_slabs") else {
        return;
    };
    let place = Place {
        dims: [9, 7, 12],
        ..skewed()
    };
    let over = |low: f64, high: f64| {
        let knots = ramp(3.0).knots().to_vec().into_iter();
        let stretched = knots.map(|k| knot(low + k.scalar * (high - low), k.color, k.extinction));
        TransferFunction::new(stretched.collect()).expect("still sorted")
    };
    let grids = [
        (
            grid_of(&place, |_| 150_u8, Samples::U8),
            over(0.0, 255.0),
            150.0,
        ),
        (
            grid_of(&place, |_| 40_000_u16, Samples::U16),
            over(0.3, 60_000.7),
            40_000.0,
        ),
        (
            grid_of(&place, |_| -700_i16, Samples::I16),
            over(-1000.0, 1000.0),
            -700.0,
        ),
        (
            grid_of(&place, |_| 0.7_f32, Samples::F32),
            over(0.0, 1.0),
            f64::from(0.7_f32),
        ),
    ];
    for (grid, tf, scalar) in grids {
        for (name, view) in views(&grid) {
            for optical_model in OpticalModel::VOLUMETRIC {
                let appearance = appearance(&tf, optical_model);
                let truth = pixels(&view, |ray| {
                    let mut integral = RayIntegral::new(&tf, optical_model);
                    let (start, end) = span(&grid, ray);
                    let length = end - start;
                    integral.add(&Segment {
                        front: scalar,
                        back: scalar,
                        length,
                    });
                    integral.over(view.premultiplied_background())
                });
                for slices_per_voxel in [0.5, 1.0, 3.7] {
                    for integration in [Integration::PostClassified, Integration::Slabs] {
                        let options = SlicingOptions {
                            slices_per_voxel,
                            integration,
                            ..Default::default()
                        };
                        let frame = draw(&gpu, &grid, &appearance, &options, &view);
                        let (rmse, most) = difference(&frame, &truth);
                        // n slabs blended in f32 lose n 2⁻²⁴ of what they have, n ≤ 200;
                        // a ray's ends are right to a few 2⁻²⁴ of the volume's size, seen
                        // from 2 sizes away, times σ L ≤ 6: 1.2e-5 + 5e-6. A pixel whose
                        // ray meets an edge within that is right to as much.
                        assert!(
                            most < 2e-5,
                            "{name} {optical_model:?} {integration:?} {slices_per_voxel}: \
                             {rmse:e} {most:e}"
                        );
                    }
                }
            }
        }
    }
}

/// A linear field is linear along a ray, trilinear interpolation reproduces it, and slabs
/// integrate it in closed form: nothing but rounding is left, with any transfer function.
#[test]
fn a_linear_field_is_exact_with_slabs() {
    let Some(gpu) = testing::gpu("a_linear_field_is_exact_with_slabs") else {
        return;
    };
    let place = skewed();
    let center = grid(&place, |_| 0.0).bounds().center();
    let field = |p: DVec3| 0.5 + (p - center).dot(DVec3::new(0.2, -0.3, 0.25));
    let grid = grid(&place, field);
    // A step and a tent, narrower than a slab.
    let tf = TransferFunction::new(vec![
        knot(0.3, [0.1, 0.2, 0.9], 0.0),
        knot(0.45, [0.4, 0.9, 0.1], 0.5),
        knot(0.45, [0.9, 0.1, 0.2], 2.0),
        knot(0.6, [1.0, 0.8, 0.3], 0.1),
        knot(0.602, [1.0, 1.0, 1.0], 9.0),
        knot(0.604, [0.5, 1.0, 1.0], 0.1),
    ])
    .expect("sorted");
    for (name, view) in views(&grid) {
        for optical_model in OpticalModel::VOLUMETRIC {
            let appearance = appearance(&tf, optical_model);
            let truth = pixels(&view, |ray| {
                let mut integral = RayIntegral::new(&tf, optical_model);
                let (start, end) = span(&grid, ray);
                let (front, back) = (field(ray.at(start)), field(ray.at(end)));
                integral.add(&Segment {
                    front,
                    back,
                    length: end - start,
                });
                integral.over(view.premultiplied_background())
            });
            for slices_per_voxel in [0.5, 2.0] {
                let options = SlicingOptions {
                    slices_per_voxel,
                    ..Default::default()
                };
                let frame = draw(&gpu, &grid, &appearance, &options, &view);
                let (rmse, most) = difference(&frame, &truth);
                // As for the uniform box; and the scalar is right to 2⁻²³ of its range, which
                // moves a knot by that over the slope, at least 0.05 a unit for nearly all
                // rays, times σ ≤ 9: 2e-5. Rays along which it hardly changes see the whole
                // step move, so the most is wider than the mean.
                assert!(
                    rmse < 2e-5 && most < 3e-4,
                    "{name} {optical_model:?}: {rmse:e} {most:e}"
                );
            }
        }
    }
}

/// Turned, flipped and stretched grids, against the exact picture.
#[test]
fn any_lattice_is_drawn_where_it_lies() {
    let Some(gpu) = testing::gpu("any_lattice_is_drawn_where_it_lies") else {
        return;
    };
    let place = skewed();
    let center = grid(&place, |_| 0.0).bounds().center();
    let field = |p: DVec3| {
        let q = p - center;
        0.5 + 0.25 * (3.0 * q.x + q.y).sin() + 0.2 * (2.0 * q.z - q.x).cos()
    };
    let grid = grid(&place, field);
    let tf = ramp(4.0);
    for (name, view) in views(&grid) {
        for optical_model in OpticalModel::VOLUMETRIC {
            let appearance = appearance(&tf, optical_model);
            let truth = truth(&grid, &appearance, &view);
            let options = SlicingOptions {
                slices_per_voxel: 8.0,
                ..Default::default()
            };
            let frame = draw(&gpu, &grid, &appearance, &options, &view);
            let (rmse, most) = difference(&frame, &truth);
            // Second order: at 2 slices per voxel it is under 1e-3 (see `convergence`), at 8 a
            // sixteenth of that.
            assert!(rmse < 6e-5, "{name} {optical_model:?}: {rmse:e} {most:e}");
            assert!(most < 1e-3, "{name} {optical_model:?}: {rmse:e} {most:e}");
        }
    }
}

/// A slab of 20 000 : 1, whose samples are a thousandth as far apart along one axis: with as
/// many slices as that takes, seen from all sides.
#[test]
fn a_thin_slab_is_drawn() {
    let Some(gpu) = testing::gpu("a_thin_slab_is_drawn") else {
        return;
    };
    let place = Place {
        dims: [61, 61, 4],
        spacing: DVec3::new(1.0, 1.0, 1e-3),
        ..cube(2)
    };
    let field = |p: DVec3| 0.5 + 0.3 * (0.2 * p.x).sin() * (0.15 * p.y).cos() + 50.0 * p.z;
    let grid = grid(&place, field);
    let look = appearance(&ramp(300.0), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&grid) {
        let view = tetrascope_core::View {
            width: 24,
            height: 24,
            ..view
        };
        let truth = truth(&grid, &look, &view);
        let frame = draw(&gpu, &grid, &look, &Default::default(), &view);
        let (rmse, most) = difference(&frame, &truth);
        // A ray's place along the thin axis is right to 2⁻²⁴ of what it would cross of it in
        // the whole volume, 60 000 voxels: 4e-3 voxels of 3 at either end, of a depth of 0.5.
        assert!(rmse < 1e-3, "{name}: {rmse:e} {most:e}");
    }
}

// Where the scalar is constant and on a step of the transfer function both sides count half:
// σ = (1 + 4)/2, c = (0.2 + 0.8)/2, of any type of samples, on every ray, whatever slabs and
// the eye make of the ray's ends. One rounding error of a scalar would make it 1 or 4.
#[test]
fn a_constant_on_a_step_is_half_of_both_sides() {
    let Some(gpu) = testing::gpu("a_constant_on_a_step_is_half_of_both_sides") else {
        return;
    };
    // Neither is a fraction of what the map to the device's unit divides by.
    let (low, step, high) = (1.0, 7.0, 200.7);
    let knots = vec![
        knot(low, [0.2; 3], 1.0),
        knot(step, [0.2; 3], 1.0),
        knot(step, [0.8; 3], 4.0),
        knot(high, [0.8; 3], 4.0),
    ];
    let tf = TransferFunction::new(knots).expect("sorted");
    let look = appearance(&tf, OpticalModel::EmissionAbsorption);
    for place in [cube(9), skewed()] {
        let grids = [
            grid(&place, |_| step),
            grid_of(&place, |_| step as u8, Samples::U8),
            grid_of(&place, |_| step as u16, Samples::U16),
            grid_of(&place, |_| step as i16, Samples::I16),
        ];
        for grid in grids {
            for (name, view) in views(&grid) {
                let behind = view.premultiplied_background();
                let want = pixels(&view, |ray| {
                    let (start, end) = span(&grid, ray);
                    let tau = 2.5 * (end - start).max(0.0);
                    let alpha = -(-tau).exp_m1();
                    // c σ is a product of means: ∫ c σ T dt = c (1 − T).
                    let over = |c: f64, channel: usize| c * alpha + (1.0 - alpha) * behind[channel];
                    [over(0.5, 0), over(0.5, 1), over(0.5, 2), over(1.0, 3)]
                });
                for integration in [Integration::Slabs, Integration::PostClassified] {
                    let options = SlicingOptions {
                        integration,
                        ..Default::default()
                    };
                    let frame = draw(&gpu, &grid, &look, &options, &view);
                    // As for a uniform box.
                    let (rmse, most) = difference(&frame, &want);
                    assert!(most < 2e-5, "{name} {integration:?}: {rmse:e} {most:e}");
                }
                let truth = truth(&grid, &look, &view);
                let off = truth.iter().flatten().zip(want.iter().flatten());
                let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(off < 1e-10, "{name}: {off:e}");
            }
        }
    }
}
