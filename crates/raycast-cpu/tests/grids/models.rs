//! Every optical model over every kind of grid, against the reference.

use tetrascope_core::grid::{Interpolation, Samples};
use tetrascope_core::{DepthCue, Grid, OpticalModel, Volume, VolumeRenderer as _};
use tetrascope_raycast_cpu::{RaycastCpu, RaycastCpuOptions};
use tetrascope_testing::{tilted, truth};

use super::bench::{
    SLOPE, STEPS, check, difference, drawn, grid_of, look, oblique, samples, views, wave,
};

/// The error that f32 may cause in a pixel and in the mean: light and opacity are sums of at most some hundred
/// parts, each within 2⁻²² of a scalar whose rounding the steepest extinction, 30 over the
/// volume, makes 30 · 2⁻²² · 0.3 of optical depth of; most parts are nearer by ten times.
const SMOOTH: [f64; 2] = [2e-6, 3e-7];

/// The same where a ray meets a step of the transfer function at an angle: where it is crossed
/// moves by 2⁻²² of the range over the slope of the scalar; where a ray grazes it, by the root.
/// The step is 7 of optical depth over the volume, √2⁻²² · 7 / 40 cells.
const STEP: [f64; 2] = [1e-4, 3e-6];

/// A ray along a surface's outline sees it or not, as rounding decides: no bound for one pixel.
/// Here surfaces are found in f64.
const SURFACE: [f64; 2] = [1e-6, 1e-7];

fn bound(model: OpticalModel, is_step: bool) -> [f64; 2] {
    match model {
        OpticalModel::Isosurfaces => SURFACE,
        _ if is_step => STEP,
        _ => SMOOTH,
    }
}

#[test]
fn every_model_of_every_type_is_the_reference() {
    for kind in ["u8", "u16", "i16", "f32"] {
        let volume = grid_of(kind, Interpolation::Linear);
        for model in OpticalModel::ALL {
            for (name, knots) in [("slope", &SLOPE[..]), ("steps", &STEPS[..])] {
                let appearance = look(&volume, knots, model);
                for (i, view) in views(&volume, 40).iter().enumerate() {
                    if i > 0 && kind != "u8" && kind != "f32" {
                        continue;
                    }
                    let name = format!("{kind} {model:?} {name} view {i}");
                    let scene = (&volume, &appearance, view);
                    check(&name, scene, bound(model, knots.len() > 2));
                }
            }
        }
    }
}

#[test]
fn samples_that_fill_cells_are_the_reference() {
    for kind in ["u8", "f32"] {
        let volume = grid_of(kind, Interpolation::Nearest);
        for model in OpticalModel::ALL {
            for knots in [&SLOPE[..], &STEPS[..]] {
                let appearance = look(&volume, knots, model);
                for (i, view) in views(&volume, 40).iter().enumerate() {
                    let name = format!("cells of {kind} {model:?} view {i}");
                    check(&name, (&volume, &appearance, view), SMOOTH);
                }
            }
        }
    }
}

/// The wave with holes: samples without a value, alone and in bulk.
fn with_gaps(kind: &str) -> Volume {
    let dims = [21, 14, 37];
    let Samples::F32(mut values) = samples(dims, "f32", wave) else {
        unreachable!("asked for floats");
    };
    for (i, value) in values.iter_mut().enumerate() {
        let [x, y, z] = [i % 21, i / 21 % 14, i / (21 * 14)];
        let is_hole = i % 97 == 5 || x < 8 && y > 9 || z > 30 && x > 15;
        if is_hole {
            *value = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][i % 3];
        }
    }
    let interpolation = match kind {
        "cells" => Interpolation::Nearest,
        _ => Interpolation::Linear,
    };
    let grid = Grid::on(oblique(dims, interpolation), Samples::F32(values));
    Volume::Grid(grid.expect("a grid"))
}

#[test]
fn what_has_no_value_is_transparent() {
    for kind in ["points", "cells"] {
        let volume = with_gaps(kind);
        for model in OpticalModel::ALL {
            let appearance = look(&volume, &SLOPE, model);
            for view in views(&volume, 40) {
                let name = format!("gaps of {kind} {model:?}");
                check(&name, (&volume, &appearance, &view), bound(model, false));
            }
        }
    }
}

#[test]
fn coverage_is_the_reference() {
    let dims = [21, 14, 37];
    let coverage: Vec<f32> = (0..21 * 14 * 37)
        .map(|i| match i % 7 {
            0 => 0.0,
            1 => 0.3,
            2 => 0.55,
            _ if i / 21 % 14 > 9 => 0.0,
            _ => 1.0,
        })
        .collect();
    for interpolation in Interpolation::ALL {
        let grid = Grid::on(oblique(dims, interpolation), samples(dims, "u8", wave));
        let grid = grid.expect("a grid").covered(coverage.clone());
        let volume = Volume::Grid(grid.expect("shares"));
        for model in OpticalModel::ALL {
            for cue in [None, Some(DepthCue { strength: 0.8 })] {
                let mut appearance = look(&volume, &STEPS, model);
                appearance.depth_cue = cue;
                for view in [views(&volume, 32)[0], views(&volume, 32)[2]] {
                    let name = format!("covered {interpolation:?} {model:?} {cue:?}");
                    check(&name, (&volume, &appearance, &view), bound(model, false));
                }
            }
        }
    }
}

#[test]
fn clip_planes_and_depth_cue_are_the_reference() {
    let volume = grid_of("u16", Interpolation::Linear);
    for model in OpticalModel::ALL {
        for (planes, cue) in [(true, None), (false, Some(0.7)), (true, Some(1.0))] {
            let mut appearance = look(&volume, &STEPS, model);
            if planes {
                appearance.clip_planes = tilted(&volume);
            }
            appearance.depth_cue = cue.map(|strength| DepthCue { strength });
            for view in views(&volume, 40) {
                let name = format!("{model:?} clipped {planes} cue {cue:?}");
                check(&name, (&volume, &appearance, &view), bound(model, true));
            }
        }
    }
}

#[test]
fn rays_end_where_the_scene_begins() {
    let volume = grid_of("u8", Interpolation::Linear);
    for model in OpticalModel::ALL {
        let appearance = look(&volume, &SLOPE, model);
        let view = views(&volume, 40)[0];
        let eye = view.camera.position;
        let far = (volume.bounds().center() - eye).length();
        let ends: Vec<f64> = (0..40 * 40)
            .map(|i| match i % 5 {
                0 => f64::INFINITY,
                1 => -1.0,
                _ => far + (f64::from(i % 23) - 11.0) * 0.6,
            })
            .collect();
        let exact = truth(&volume, &appearance)
            .render_before(&view, &ends)
            .expect("the truth");
        let options = RaycastCpuOptions::default();
        let renderer = RaycastCpu::new(&volume, &appearance, &options).expect("it draws all");
        let frame = renderer.render_before(&view, &ends).expect("a picture");
        let (most, rmse) = difference(&frame.pixels, &exact);
        let bound = bound(model, false);
        assert!(
            most <= bound[0] && rmse <= bound[1],
            "{model:?} {most:e} {rmse:e}"
        );
        let whole = renderer.render(&view).expect("a picture");
        assert_ne!(whole.pixels, frame.pixels, "{model:?}");
    }
}

// Surfaces are found in f64 and their depths rounded once to f32, 2⁻²⁴ of them; 1e-9 of the
// volume's size is left for the roots.
#[test]
fn surfaces_have_depths() {
    let volume = grid_of("f32", Interpolation::Linear);
    let appearance = look(&volume, &SLOPE, OpticalModel::Isosurfaces);
    let mut met = 0;
    for view in views(&volume, 40) {
        let frame = drawn(&volume, &appearance, &view);
        let exact = truth(&volume, &appearance);
        let exact = exact.render(&view).expect("the truth");
        let depths = |frame: &tetrascope_core::Frame| frame.depths.clone().expect("depths");
        for (got, want) in depths(&frame).iter().zip(depths(&exact)) {
            if want.is_finite() {
                met += 1;
                let far = volume.bounds().diagonal() * 1e-9 + f64::from(want) * 1.2e-7;
                assert!(
                    (f64::from(*got) - f64::from(want)).abs() <= far,
                    "{got} {want}"
                );
            } else {
                assert_eq!(*got, want);
            }
        }
    }
    assert!(met > 1000, "{met}");
    let volumetric = look(&volume, &SLOPE, OpticalModel::Emission);
    assert_eq!(
        drawn(&volume, &volumetric, &views(&volume, 8)[0]).depths,
        None
    );
}

#[test]
fn pixels_do_not_depend_on_threads() {
    let volume = grid_of("u8", Interpolation::Linear);
    for model in OpticalModel::ALL {
        let appearance = look(&volume, &STEPS, model);
        let view = views(&volume, 131)[0];
        let frames = [1, 4].map(|threads| {
            let options = RaycastCpuOptions {
                threads: Some(threads),
                ..RaycastCpuOptions::default()
            };
            let renderer = RaycastCpu::new(&volume, &appearance, &options).expect("it draws all");
            renderer.render(&view).expect("a picture")
        });
        let bits = |pixels: &[[f32; 4]]| -> Vec<u32> {
            pixels.iter().flatten().map(|c| c.to_bits()).collect()
        };
        assert_eq!(
            bits(&frames[0].pixels),
            bits(&frames[1].pixels),
            "{model:?}"
        );
        assert_eq!(frames[0].stats.counts, frames[1].stats.counts, "{model:?}");
    }
}
