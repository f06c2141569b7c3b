//! Appearances with as many parts as shaders' loops allow; see `tetrascope_shaders::loops`.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, DepthCue, Isosurface, OpticalModel, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_shaders::loops::MOST_KNOTS;
use tetrascope_slicing::{Crossing, Slicing, SlicingOptions};

use crate::support::*;

/// Saw teeth of so many knots over [0, 1].
fn teeth(count: usize, most: f64) -> TransferFunction {
    let knots = (0..count).map(|i| {
        let up = f64::from(u8::from(i % 2 == 1));
        let share = i as f64 / (count - 1) as f64;
        knot(share, [share, up, 1.0 - up], most * up)
    });
    TransferFunction::new(knots.collect()).expect("sorted")
}

/// Each pixel takes long.
fn small(view: View) -> View {
    View {
        width: 12,
        height: 12,
        ..view
    }
}

/// One slab goes through all intervals of the longest transfer function, where all of it is
/// thin, and where it hides what is behind.
#[test]
fn a_slab_goes_through_all_knots() {
    let Some(gpu) = testing::gpu("a_slab_goes_through_all_knots") else {
        return;
    };
    let grid = grid(&cube(2), |p| p.dot(DVec3::new(0.5, 0.3, 0.2)));
    let options = SlicingOptions {
        slices_per_voxel: 0.5,
        ..Default::default()
    };
    let cue = DepthCue { strength: 0.6 };
    for most in [0.7, 60.0] {
        let tf = teeth(MOST_KNOTS, most);
        for model in OpticalModel::VOLUMETRIC {
            for depth_cue in [None, Some(cue)] {
                let look = Appearance {
                    depth_cue,
                    ..appearance(&tf, model)
                };
                for (name, view) in views(&grid).into_iter().take(2) {
                    let view = small(view);
                    let truth = truth(&grid, &look, &view);
                    let frame = draw(&gpu, &grid, &look, &options, &view);
                    let (rmse, off) = difference(&frame, &truth);
                    // 2¹⁴ pieces added up in f32 are off by 2¹⁴ · 2⁻²⁴ at most, of what they
                    // are at most: without absorption the light of the whole depth.
                    let scale = if model == OpticalModel::Emission {
                        most
                    } else {
                        1.0
                    };
                    assert!(
                        off < 1e-3 * f64::max(scale, 1.0),
                        "{name} {model:?} {most} {depth_cue:?}: {rmse:e} {off:e}"
                    );
                }
            }
        }
    }
    let volume = Volume::Grid(grid);
    let look = appearance(&teeth(MOST_KNOTS + 1, 1.0), OpticalModel::Emission);
    let error = Slicing::new(&gpu, &volume, &look, &options).expect_err("one knot more");
    assert!(error.to_string().contains("knots"), "{error}");
}

/// A ray finds the nearest of thousands of surfaces, on its way up and down.
#[test]
fn thousands_of_surfaces_are_searched() {
    let Some(gpu) = testing::gpu("thousands_of_surfaces_are_searched") else {
        return;
    };
    let ball = |p: DVec3| 1.0 - (p - DVec3::splat(0.5)).length();
    for field in [
        grid(&cube(9), ball),
        grid(&cube(9), |p| 1.0 - ball(p)),
        grid(&cube(2), |p| p.x + p.y * p.z),
    ] {
        let (low, high) = field.scalar_range().expect("numbers");
        let mut look = appearance(&ramp(1.0), OpticalModel::Isosurfaces);
        // Not in order, and only in the inner half of the range.
        look.isosurfaces = (0..3_000_u32)
            .map(|i| {
                let i = i * 7919 % 3_000;
                let share = 0.25 + 0.5 * f64::from(i) / 3_000.0;
                let shade = f64::from(i % 97) / 97.0;
                Isosurface {
                    value: low + share * (high - low),
                    color: DVec3::new(share, 0.3 + 0.1 * shade, 1.0 - share),
                }
            })
            .collect();
        for crossing in [Crossing::Cells, Crossing::Linear] {
            let options = SlicingOptions {
                crossing,
                ..Default::default()
            };
            for (name, view) in views(&field) {
                let view = small(view);
                let truth = truth(&field, &look, &view);
                let frame = draw(&gpu, &field, &look, &options, &view);
                let (rmse, _) = difference(&frame, &truth);
                // Neighbors differ by a tenth of green, where rounding decides which is met,
                // and where a ray starts between two. A surface that is missed shows the
                // background, or one far behind.
                let most = if crossing == Crossing::Cells {
                    0.02
                } else {
                    0.1
                };
                assert!(rmse < most, "{name} {crossing:?}: {rmse:e}");
                assert!(frame.depths.is_some());
            }
        }
    }
}

/// More lights than a loop may have are refused.
#[test]
fn too_many_lights_are_refused() {
    let Some(gpu) = testing::gpu("too_many_lights_are_refused") else {
        return;
    };
    let volume = Volume::Grid(grid(&cube(3), |p| p.x));
    let mut look = appearance(&ramp(1.0), OpticalModel::Isosurfaces);
    look.isosurfaces = vec![Isosurface {
        value: 0.5,
        color: DVec3::ONE,
    }];
    let light = tetrascope_core::DirectionalLight {
        toward: DVec3::Z,
        color: DVec3::splat(1.0 / 256.0),
    };
    let most = tetrascope_shaders::loops::MOST_LIGHTS;
    assert_eq!(most, tetrascope_core::Lighting::MOST_LIGHTS);
    look.lighting.lights = vec![light; most];
    let mut slicing = Slicing::new(&gpu, &volume, &look, &Default::default()).expect("as many");
    look.lighting.lights.push(light);
    assert!(slicing.restyle(&look).is_err());
}
