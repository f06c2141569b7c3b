//! Isosurfaces and depth cue against the exact pictures.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::{
    Appearance, ClipPlane, DepthCue, DirectionalLight, Frame, Grid, Isosurface, Lighting,
    OpticalModel, View, Volume, VolumeRenderer as _,
};
use tetrascope_reference::ReferenceImage;
use tetrascope_slicing::counters::{BRICKS_DRAWN, BRICKS_SKIPPED};
use tetrascope_slicing::{
    Crossing, Gradient, Integration, Level, Phong, Shading, Slicing, SlicingOptions, Storage,
    Traversal,
};

use crate::support::*;

/// Surfaces at shares of the way from `low` to `high`.
fn surfaces((low, high): (f64, f64), shares: &[f64]) -> Appearance {
    let colors = [[1.0, 0.3, 0.2], [0.2, 0.9, 0.4], [0.3, 0.5, 1.0]];
    let surface = |(share, color): (&f64, [f64; 3])| Isosurface {
        value: low + share * (high - low),
        color: color.into(),
    };
    let mut look = appearance(&ramp(5.0), OpticalModel::Isosurfaces);
    look.isosurfaces = shares.iter().zip(colors).map(surface).collect();
    look
}

fn lights() -> Lighting {
    let light = |toward, color| DirectionalLight { toward, color };
    Lighting {
        ambient: 0.1,
        lights: vec![
            light(DVec3::new(1.0, -2.0, -1.0), DVec3::new(0.5, 0.6, 0.7)),
            light(DVec3::new(-3.0, 1.0, 2.0), DVec3::new(0.9, 0.1, 0.4)),
        ],
    }
}

fn exact(grid: &Grid, look: &Appearance, view: &View) -> ReferenceImage {
    let volume = Volume::Grid(grid.clone());
    let image = testing::truth(&volume, look).render_exact(view);
    image.expect("the view is valid")
}

/// Where the picture is off by more than `most` in color or, relative to `size`, in depth;
/// and how many pixels show a surface.
fn off(frame: &Frame, truth: &ReferenceImage, most: f64, size: f64) -> (usize, usize) {
    let depths = frame.depths.as_ref().expect("surfaces have depths");
    let exact = truth.depths.as_ref().expect("surfaces have depths");
    let (mut wrong, mut shown) = (0, 0);
    for i in 0..exact.len() {
        let colors = frame.pixels[i].iter().zip(truth.pixels[i]);
        let color = colors.map(|(a, b)| (f64::from(*a) - b).abs());
        let color = color.fold(0.0, f64::max);
        assert!(color.is_finite());
        let depth = if exact[i].is_finite() {
            shown += 1;
            (f64::from(depths[i]) - exact[i]).abs() / size
        } else {
            f64::from(u8::from(depths[i].is_finite()))
        };
        wrong += usize::from(color > most || depth > most);
    }
    (wrong, shown)
}

/// Lumps of all directions, in [0, 1] or so, over a place of any size.
fn lumps(place: &Place) -> impl Fn(DVec3) -> f64 + use<> {
    let place = *place;
    move |p: DVec3| {
        let far = DVec3::from_array(place.dims.map(|d| (d - 1) as f64)) * place.spacing;
        let q = place.direction.transpose() * (p - place.origin) / far;
        0.5 + 0.3 * (7.0 * q.x + 2.0 * q.y).sin() * (5.0 * q.z - 3.0 * q.y).cos()
            + 0.2 * (q.x - q.z)
    }
}

// The crossing is a root of the cell's cubic in f32: places are right to a few 2⁻²⁴ of the
// volume, 1e-5 with the far origin of one of them, and colors to as much of the gradient's
// change over a cell. Where a ray grazes a surface or passes a cell's edge either side may
// be seen: two pixels in a thousand.
#[test]
fn surfaces_are_met_in_cells() {
    let Some(gpu) = testing::gpu("surfaces_are_met_in_cells") else {
        return;
    };
    for place in [cube(12), skewed()] {
        let field = lumps(&place);
        let scaled = |p: DVec3| 200.0 * field(p) - 20.0;
        let grids = [
            grid(&place, &field),
            grid_of(&place, |p| scaled(p).clamp(0.0, 255.0) as u8, Samples::U8),
            grid_of(&place, |p| scaled(p) as i16 - 300, Samples::I16),
            grid_of(&place, |p| (60.0 * scaled(p).max(0.0)) as u16, Samples::U16),
        ];
        for grid in grids {
            let range = grid.scalar_range().expect("numbers");
            let mut look = surfaces(range, &[0.613, 0.337, 0.851]);
            look.lighting = lights();
            let (mut wrong, mut shown) = (0, 0);
            for (_, view) in views(&grid) {
                let truth = exact(&grid, &look, &view);
                let frame = draw(&gpu, &grid, &look, &Default::default(), &view);
                let found = off(&frame, &truth, 2e-3, grid.bounds().diagonal());
                (wrong, shown) = (wrong + found.0, shown + found.1);
            }
            assert!(shown > 2000 && wrong * 500 < shown, "{wrong} of {shown}");
        }
    }
}

// What is found in cells does not depend on how far slices are apart.
#[test]
fn cells_need_no_slices() {
    let Some(gpu) = testing::gpu("cells_need_no_slices") else {
        return;
    };
    let place = cube(10);
    let grid = grid(&place, lumps(&place));
    let look = surfaces((0.0, 1.0), &[0.613, 0.337]);
    let (_, view) = views(&grid).swap_remove(0);
    let truth = exact(&grid, &look, &view);
    for slices_per_voxel in [0.5, 1.0, 3.0, 8.0] {
        let options = SlicingOptions {
            slices_per_voxel,
            ..Default::default()
        };
        let frame = draw(&gpu, &grid, &look, &options, &view);
        let (wrong, shown) = off(&frame, &truth, 2e-3, 1.0);
        assert!(
            shown > 500 && wrong * 500 < shown,
            "{slices_per_voxel}: {wrong} of {shown}"
        );
    }
}

// A straight line between a slab's ends is off by h²/8 of the field's second derivative
// over its first: second order in places. Corrections leave rounding, and rays that meet a
// surface twice in a slab, which both miss; cells miss none.
#[test]
fn crossings_between_slices_converge() {
    let Some(gpu) = testing::gpu("crossings_between_slices_converge") else {
        return;
    };
    let place = cube(9);
    // A ball, whose samples along a ray make a chain of straight lines and bends.
    let grid = grid(&place, |p| {
        (p - DVec3::splat(0.5)).length_squared() + 0.3 * p.x * p.y * p.z
    });
    let look = surfaces((0.0, 0.5), &[0.31]);
    let (_, view) = views(&grid).swap_remove(0);
    let truth = exact(&grid, &look, &view);
    let depths = truth.depths.as_ref().expect("surfaces have depths");
    let error = |crossing, slices_per_voxel| {
        let options = SlicingOptions {
            slices_per_voxel,
            crossing,
            ..Default::default()
        };
        let frame = draw(&gpu, &grid, &look, &options, &view);
        let found = frame.depths.as_ref().expect("surfaces have depths");
        // The mean over rays that are seen to meet the surface.
        let pairs = found
            .iter()
            .zip(depths)
            .filter(|(a, b)| a.is_finite() && b.is_finite());
        let offs: Vec<f64> = pairs.map(|(a, b)| (f64::from(*a) - b).abs()).collect();
        let missed = found
            .iter()
            .zip(depths)
            .filter(|(a, b)| a.is_finite() != b.is_finite());
        let mean = offs.iter().sum::<f64>() / offs.len() as f64;
        (mean, missed.count(), difference(&frame, &truth.pixels).0)
    };
    let mut lines = Vec::new();
    for slices in [1.0, 2.0, 4.0, 8.0] {
        let [linear, corrected, cells] =
            [Crossing::Linear, Crossing::Corrected, Crossing::Cells].map(|c| error(c, slices));
        for (name, (mean, missed, rmse)) in [
            ("linear", linear),
            ("corrected", corrected),
            ("cells", cells),
        ] {
            eprintln!("{slices} {name}: off by {mean:.1e}, {missed} missed, RMSE {rmse:.1e}");
        }
        // Depths of 2 in f32, from numbers as large in normalized units.
        assert!(corrected.0 < 2e-6 && cells.0 < 2e-6);
        assert_eq!(cells.1, 0);
        lines.push((linear.0, corrected.1));
    }
    let order = (lines[0].0 / lines[3].0).log2() / 3.0;
    assert!((order - 2.0).abs() < 0.2, "{order} {lines:?}");
    assert!(lines[3].1 < lines[0].1, "{lines:?}");
}

// Central differences of |p|², sampled, are exactly 2 p between samples too, so that a ball's
// normals are radial and light follows in closed form at the crossing.
#[test]
fn central_differences_light_a_ball() {
    let Some(gpu) = testing::gpu("central_differences_light_a_ball") else {
        return;
    };
    let place = cube(17);
    let center = DVec3::splat(0.5);
    let grid = grid(&place, |p| (p - center).length_squared());
    // Within the border, where differences have both sides.
    let mut look = surfaces((0.0, 1.0), &[0.12]);
    look.lighting = lights();
    for level in [Level::Fixed(0), Level::Fixed(1)] {
        let options = SlicingOptions {
            gradient: Gradient::CentralDifferences,
            storage: Storage::Bricks,
            level,
            ..Default::default()
        };
        for (name, mut view) in views(&grid).into_iter().take(3) {
            view.background = [0.0; 4];
            let frame = draw(&gpu, &grid, &look, &options, &view);
            let truth = exact(&grid, &look, &view);
            let depths = truth.depths.as_ref().expect("surfaces have depths");
            let lights = look.lighting.resolved(view.camera.axes().2);
            let (mut shown, mut wrong) = (0, 0);
            for (i, &t) in depths.iter().enumerate() {
                if t.is_infinite() {
                    continue;
                }
                let ray = view.ray(i as u32 % view.width, i as u32 / view.width);
                let normal = ray.at(t) - center;
                let color = look.isosurfaces[0].color;
                let want = look.lighting.shade(&lights, color, normal, ray.direction);
                let got = frame.pixels[i];
                let error = (0..3).map(|c| (f64::from(got[c]) - want[c]).abs());
                // Differences of scalars near 0.12, right to 2⁻²⁵, over 2/16 of a gradient
                // of 0.7: 4e-7, and 2e-6 of places.
                wrong += usize::from(error.fold(0.0, f64::max) > 1e-4);
                shown += 1;
            }
            assert!(
                shown > 200 && wrong * 100 < shown,
                "{name}: {wrong} of {shown}"
            );
        }
    }
}

// Clip planes cut surfaces open, the cue darkens them, and neither boxes nor streaming
// change a pixel.
#[test]
fn cut_cued_and_streamed_surfaces() {
    let Some(gpu) = testing::gpu("cut_cued_and_streamed_surfaces") else {
        return;
    };
    let place = Place {
        dims: [70, 66, 20],
        ..cube(70)
    };
    let grid = grid(&place, lumps(&place));
    let mut look = surfaces((0.0, 1.0), &[0.613, 0.337]);
    look.depth_cue = Some(DepthCue { strength: 0.8 });
    look.clip_planes = vec![ClipPlane {
        point: grid.bounds().center(),
        normal: DVec3::new(1.0, 0.3, -0.2),
    }];
    let small = SlicingOptions {
        slices_per_voxel: 1.0,
        ..Default::default()
    };
    for (name, view) in views(&grid) {
        let truth = exact(&grid, &look, &view);
        let frame = draw(&gpu, &grid, &look, &small, &view);
        let (wrong, shown) = off(&frame, &truth, 4e-3, grid.bounds().diagonal());
        assert!(
            shown > 200 && wrong * 200 < shown,
            "{name}: {wrong} of {shown}"
        );
        // One brick of 37 · 35 · 22 floats and its copy.
        let streamed = SlicingOptions {
            memory_budget: 300_000,
            ..small.clone()
        };
        let again = draw(&gpu, &grid, &look, &streamed, &view);
        assert!(again.stats.bytes_uploaded > 0, "{name}");
        assert_eq!(again.pixels, frame.pixels, "{name}");
        assert_eq!(again.depths, frame.depths, "{name}");
        // The device finds the same boxes, of those around a surface.
        let found = SlicingOptions {
            traversal: Traversal::Gpu,
            level: Level::Fixed(3),
            ..small.clone()
        };
        let again = draw(&gpu, &grid, &look, &found, &view);
        assert!(again.stats.get(BRICKS_SKIPPED) > Some(0), "{name}");
        assert_eq!(again.pixels, frame.pixels, "{name}");
    }
}

// Beside a gap, and where there is nothing to see.
#[test]
fn gaps_have_no_surfaces() {
    let Some(gpu) = testing::gpu("gaps_have_no_surfaces") else {
        return;
    };
    let place = cube(12);
    let field = lumps(&place);
    let torn = grid(&place, |p| if p.x > 0.6 { f64::NAN } else { field(p) });
    for gradient in [Gradient::Auto, Gradient::CentralDifferences] {
        let look = surfaces((0.0, 1.0), &[0.613, 0.337]);
        let options = SlicingOptions {
            gradient,
            ..Default::default()
        };
        let (mut wrong, mut shown) = (0, 0);
        for (_, view) in views(&torn) {
            let truth = exact(&torn, &look, &view);
            let frame = draw(&gpu, &torn, &look, &options, &view);
            let most = if gradient == Gradient::Auto {
                2e-3
            } else {
                2.0
            };
            let found = off(&frame, &truth, most, 1.0);
            (wrong, shown) = (wrong + found.0, shown + found.1);
        }
        assert!(shown > 500 && wrong * 500 < shown, "{wrong} of {shown}");
    }
    let look = surfaces((0.0, 1.0), &[3.0]);
    let (_, view) = views(&torn).swap_remove(0);
    let frame = draw(&gpu, &torn, &look, &Default::default(), &view);
    assert_eq!(frame.stats.get(BRICKS_DRAWN), Some(0));
    let depths = frame.depths.expect("surfaces have depths");
    assert!(depths.iter().all(|d| *d == f32::INFINITY));
}

#[test]
fn a_renderer_changes_between_volumes_and_surfaces() {
    let Some(gpu) = testing::gpu("a_renderer_changes_between_volumes_and_surfaces") else {
        return;
    };
    let place = cube(20);
    let grid = grid(&place, lumps(&place));
    let volume = Volume::Grid(grid.clone());
    let looks = [
        appearance(&ramp(5.0), OpticalModel::EmissionAbsorption),
        surfaces((0.0, 1.0), &[0.613, 0.337]),
    ];
    let (_, view) = views(&grid).swap_remove(0);
    for storage in [Storage::Auto, Storage::Bricks] {
        let options = SlicingOptions {
            integration: Integration::PostClassified,
            storage,
            ..Default::default()
        };
        let mut slicing = Slicing::new(&gpu, &volume, &looks[0], &options).expect("it fits");
        for look in [&looks[1], &looks[0], &looks[1]] {
            slicing.restyle(look).expect("it fits");
            let frame = slicing.render(&view).expect("drawn");
            let new = draw(&gpu, &grid, look, &options, &view);
            let (_, most) = between(&frame, &new);
            // Floats keep their unit where it has the digits, so the last one may differ.
            assert!(most < 1e-4 && shows(&frame), "{most:e}");
            let surfaces = look.optical_model == OpticalModel::Isosurfaces;
            assert_eq!(frame.depths.is_some(), surfaces);
        }
    }
}

// The same bars as without a cue: 1e-3 at two slices per voxel, and second order.
#[test]
fn a_depth_cue_dims_what_is_far() {
    let Some(gpu) = testing::gpu("a_depth_cue_dims_what_is_far") else {
        return;
    };
    let grid = grid(&cube(9), |p| {
        (-(p - DVec3::splat(0.5)).length_squared() / 0.08).exp()
    });
    for model in OpticalModel::VOLUMETRIC {
        let most = if model == OpticalModel::Emission {
            1.5
        } else {
            6.0
        };
        let mut look = appearance(&ramp(most), model);
        look.depth_cue = Some(DepthCue { strength: 0.9 });
        for (name, view) in views(&grid).into_iter().take(2) {
            let truth = truth(&grid, &look, &view);
            let errors = [2.0, 4.0, 8.0].map(|slices_per_voxel| {
                let options = SlicingOptions {
                    slices_per_voxel,
                    ..Default::default()
                };
                difference(&draw(&gpu, &grid, &look, &options, &view), &truth).0
            });
            assert!(errors[0] < 1e-3, "{model:?} {name}: {errors:?}");
            let order = (errors[0] / errors[2]).log2() / 2.0;
            // Maxima are of first order, and better where they are seen.
            let orders = if model == OpticalModel::MaximumIntensity {
                0.5..2.5
            } else {
                1.8..2.2
            };
            assert!(orders.contains(&order), "{model:?} {name}: {errors:?}");
            // It does something, unless there is no light.
            let plain = Appearance {
                depth_cue: None,
                ..look.clone()
            };
            let plain = draw(&gpu, &grid, &plain, &Default::default(), &view);
            let (_, change) = difference(&plain, &truth);
            assert_eq!(
                change > 0.05,
                model != OpticalModel::Absorption,
                "{model:?} {change}"
            );
        }
    }
}

// A lit volume fades as an unlit one does: in a uniform cue all light by one factor.
#[test]
fn a_lit_volume_fades_too() {
    let Some(gpu) = testing::gpu("a_lit_volume_fades_too") else {
        return;
    };
    // One sheet of samples beside the eye's plane: all depths are about the same.
    let place = Place {
        dims: [2, 9, 9],
        ..cube(9)
    };
    let grid = grid(&place, |p| p.y);
    let (name, mut view) = views(&grid).swap_remove(2);
    assert_eq!(name, "along an axis");
    view.background = [0.0; 4];
    let options = SlicingOptions {
        shading: Shading::Phong(Phong::default()),
        gradient: Gradient::Trilinear,
        ..Default::default()
    };
    let mut look = appearance(&ramp(30.0), OpticalModel::EmissionAbsorption);
    let plain = draw(&gpu, &grid, &look, &options, &view);
    look.depth_cue = Some(DepthCue { strength: 0.8 });
    let cued = draw(&gpu, &grid, &look, &options, &view);
    assert!(shows(&plain));
    for (cued, plain) in cued.pixels.iter().zip(&plain.pixels) {
        assert_eq!(cued[3], plain[3]);
        for c in 0..3 {
            // From 1 at the front to 0.2 at the back of the box.
            let (low, high) = (0.2 * plain[c] - 1e-6, plain[c] + 1e-6);
            assert!((low..=high).contains(&cued[c]), "{} {}", cued[c], plain[c]);
        }
    }
    assert!(between(&cued, &plain).1 > 0.05);
}
