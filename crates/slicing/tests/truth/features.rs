//! Gaps, clip planes, light, filtering, and the renderer's contract.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Samples;
use tetrascope_core::{
    Appearance, Bounds, ClipPlane, OpticalModel, TransferFunction, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::memory::{Source, read_back};
use tetrascope_gpu::wgpu::{TextureFormat, TextureUsages};
use tetrascope_gpu::{Draw as _, Target};
use tetrascope_slicing::counters::BRICKS_DRAWN;
use tetrascope_slicing::{
    Filtering, Integration, Level, Phong, PlaneTest, Shading, Slicing, SlicingOptions, Traversal,
};

use crate::support::*;

/// A cell with a NaN at a corner is transparent; its neighbors are not.
#[test]
fn not_a_number_is_transparent() {
    let Some(gpu) = testing::gpu("not_a_number_is_transparent") else {
        return;
    };
    // NaN beyond the plane x = 0.5: cells from sample 4 on lie behind it.
    let field = |p: DVec3| if p.x > 0.51 { f64::NAN } else { 0.8 };
    let with_gaps = grid(&cube(9), field);
    let half = Place {
        dims: [5, 9, 9],
        ..cube(9)
    };
    let half = grid(&half, |_| 0.8);
    let appearance = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&with_gaps) {
        for integration in [Integration::PostClassified, Integration::Slabs] {
            // A slab that ends in a gap is left out whole, so slabs are thin here.
            let options = SlicingOptions {
                integration,
                slices_per_voxel: 64.0,
                ..Default::default()
            };
            let gap = draw(&gpu, &with_gaps, &appearance, &options, &view);
            let solid = draw(&gpu, &half, &appearance, &options, &view);
            // One slab, 1/512 long, σ = 3.3 in it: 6.5e-3.
            let (_, most) = between(&gap, &solid);
            assert!(most < 7e-3, "{name} {integration:?}: {most:e}");
        }
    }
}

// A uniform box cut by planes is a smaller uniform box.
#[test]
fn clip_planes_cut_exactly() {
    let Some(gpu) = testing::gpu("clip_planes_cut_exactly") else {
        return;
    };
    let volume = grid(&cube(9), |_| 0.8);
    let kept = Bounds {
        min: DVec3::new(0.21, 0.0, 0.33),
        max: DVec3::new(0.83, 0.47, 2.0),
    };
    let smaller = Place {
        dims: [3, 3, 3],
        origin: kept.min,
        spacing: (kept.max.min(DVec3::ONE) - kept.min) / 2.0,
        ..cube(3)
    };
    let smaller = grid(&smaller, |_| 0.8);
    let tf = ramp(5.0);
    let whole = appearance(&tf, OpticalModel::EmissionAbsorption);
    let cut = Appearance {
        clip_planes: ClipPlane::of_box(&kept).to_vec(),
        ..whole.clone()
    };
    for (name, view) in views(&volume) {
        let clipped = draw(&gpu, &volume, &cut, &Default::default(), &view);
        let truth = truth(&smaller, &whole, &view);
        let (rmse, most) = difference(&clipped, &truth);
        // As for a uniform box; in a pixel whose ray meets a cut's edge, as much.
        assert!(most < 2e-5, "{name}: {rmse:e} {most:e}");
    }
}

// In a linear field the gradient is the same everywhere, so light is a constant factor:
// c (ambient + diffuse |n · d|) for a ray along d.
#[test]
fn light_follows_the_gradient() {
    let Some(gpu) = testing::gpu("light_follows_the_gradient") else {
        return;
    };
    let place = skewed();
    let center = grid(&place, |_| 0.0).bounds().center();
    let slope = DVec3::new(0.2, -0.3, 0.25);
    let grid = grid(&place, |p| 0.5 + (p - center).dot(slope));
    let tf = ramp(4.0);
    let phong = Phong {
        specular: 0.0,
        ..Default::default()
    };
    for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
        let appearance = appearance(&tf, model);
        for (name, mut view) in views(&grid) {
            view.background = [0.0; 4];
            let options = SlicingOptions {
                shading: Shading::Phong(phong),
                ..Default::default()
            };
            let lit = draw(&gpu, &grid, &appearance, &options, &view);
            let plain = draw(&gpu, &grid, &appearance, &Default::default(), &view);
            let mut rays = pixels(&view, |ray| {
                let facing = ray.direction.dot(slope.unit()).abs();
                [facing, 0.0, 0.0, 0.0]
            })
            .into_iter();
            let truth: Vec<[f64; 4]> = plain
                .pixels
                .iter()
                .map(|p| {
                    let facing = rays.next().expect("one ray a pixel")[0];
                    let light = phong.ambient + phong.diffuse * facing;
                    let [r, g, b, a] = p.map(f64::from);
                    [r * light, g * light, b * light, a]
                })
                .collect();
            let (_, most) = difference(&lit, &truth);
            // Differences of scalars that are right to 2⁻²³ over two samples, of which the
            // field changes by 0.02 at least along its steepest axis: 1e-5, times 2.
            assert!(most < 1e-4, "{name} {model:?}: {most:e}");
        }
    }
}

/// +∞ beside −∞, NaN and numbers beyond f32, as a grid has them that was not read from a
/// file: none is a value, for the reference as for slices, and slabs converge to it as they
/// do elsewhere.
#[test]
fn slabs_end_where_there_is_no_value() {
    let Some(gpu) = testing::gpu("slabs_end_where_there_is_no_value") else {
        return;
    };
    let none = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -1e300, 1e39];
    let center = DVec3::new(0.55, 0.4, 0.6);
    let field = |p: DVec3| {
        let number = (8.0 * (p.x + 2.0 * p.y + 3.0 * p.z)).round() as usize;
        let value = 0.6 + 0.3 * (5.0 * p.x + 2.0 * p.y).sin() * (4.0 * p.z).cos();
        let inside = (p - center).length() < 0.3;
        if inside {
            none[number % none.len()]
        } else {
            value
        }
    };
    let grid = grid(&cube(9), field);
    let tf = ramp(4.0);
    for model in OpticalModel::VOLUMETRIC {
        // Its error is that of extremes between slabs' ends.
        if model == OpticalModel::MaximumIntensity {
            continue;
        }
        let appearance = appearance(&tf, model);
        for (name, view) in views(&grid) {
            let truth = truth(&grid, &appearance, &view);
            let [coarse, fine] = [2.0, 8.0].map(|slices_per_voxel| {
                let options = SlicingOptions {
                    slices_per_voxel,
                    ..Default::default()
                };
                let frame = draw(&gpu, &grid, &appearance, &options, &view);
                difference(&frame, &truth).0
            });
            // Second order: a sixteenth, down to where f32 ends. At first order, a quarter
            // of far more.
            let context = format!("{name} {model:?}: {coarse:e} {fine:e}");
            let least = f64::max(coarse / 8.0, 2e-6);
            assert!(coarse < 2e-3 && fine < least, "{context}");
        }
    }
}

// Texture units have at least 8 bits of fraction: an error of 1/512 of the difference of
// neighbors, here at most 1/4 of the range, and σ L ≤ 8 · its slope.
#[test]
fn texture_units_filter_almost_as_well() {
    let Some(gpu) = testing::gpu("texture_units_filter_almost_as_well") else {
        return;
    };
    let wave = |p: DVec3| 0.5 + 0.5 * (7.0 * p.x).sin() * (5.0 * p.y + 3.0 * p.z).cos();
    let place = cube(20);
    let grids = [
        (
            grid_of(&place, |p| (255.0 * wave(p)) as u8, Samples::U8),
            0.0,
            255.0,
        ),
        (
            grid_of(&place, |p| (60_000.0 * wave(p)) as u16, Samples::U16),
            0.0,
            60_000.0,
        ),
        (
            grid_of(
                &place,
                |p| (60_000.0 * wave(p) - 30_000.0) as i16,
                Samples::I16,
            ),
            -3e4,
            3e4,
        ),
        (grid(&place, wave), 0.0, 1.0),
    ];
    for (grid, low, high) in grids {
        let tf = TransferFunction::new(vec![
            knot(low, [0.1, 0.3, 0.9], 0.0),
            knot(high, [1.0, 0.9, 0.6], 8.0),
        ]);
        let appearance = appearance(&tf.expect("sorted"), OpticalModel::EmissionAbsorption);
        let (_, view) = views(&grid).swap_remove(0);
        let exact = draw(&gpu, &grid, &appearance, &Default::default(), &view);
        let options = SlicingOptions {
            filtering: Filtering::Hardware,
            ..Default::default()
        };
        let filtered = draw(&gpu, &grid, &appearance, &options, &view);
        let (rmse, most) = between(&exact, &filtered);
        // Errors along a ray have both signs; if they all had one: 8 · 1/512 · 1/4.
        assert!(most < 4e-3, "{rmse:e} {most:e}");
        let fallback = filtered
            .stats
            .notes
            .iter()
            .any(|n| n.contains("does not filter"));
        assert!(most > 0.0 || fallback, "the texture unit was not used");
    }
}

/// Bytes that differ by 1 from neighbor to neighbor, over a transfer function that sees a
/// fifth of one: what is read between them must not be rounded to bytes again.
#[test]
fn texture_units_make_slopes_of_bytes() {
    let Some(gpu) = testing::gpu("texture_units_make_slopes_of_bytes") else {
        return;
    };
    let place = cube(41);
    let grid = grid_of(&place, |p| (100.0 + 40.0 * p.y).round() as u8, Samples::U8);
    let tf = TransferFunction::new(vec![
        knot(100.0, [0.1, 0.3, 0.9], 0.0),
        knot(140.0, [1.0, 0.9, 0.6], 8.0),
    ]);
    let appearance = appearance(&tf.expect("sorted"), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&grid) {
        let options = SlicingOptions {
            filtering: Filtering::Hardware,
            ..Default::default()
        };
        let filtered = draw(&gpu, &grid, &appearance, &options, &view);
        let exact = draw(&gpu, &grid, &appearance, &Default::default(), &view);
        let (rmse, most) = between(&exact, &filtered);
        // 1/512 of the difference, a 40th of the range: 8/512/40 = 4e-4. Where bytes are half
        // floats, the result may be one: 2⁻¹² of 140, over the range: 8 · 8.5e-4. Rounding
        // to bytes is off by half of one: 8 · 0.5/40 = 0.1.
        let half_floats = 8.0 * 140.0 / 4096.0 / 40.0;
        assert!(most < 4e-4 + half_floats, "{name}: {rmse:e} {most:e}");
        assert!(
            filtered.stats.notes.is_empty(),
            "bytes are filtered everywhere"
        );
    }
}

/// The device's time of a frame is within the time of the wall clock.
#[test]
fn gpu_time_is_part_of_the_frames_time() {
    let Some(gpu) = testing::gpu("gpu_time_is_part_of_the_frames_time") else {
        return;
    };
    let grid = grid(&cube(30), |p| p.length() / 2.0);
    let appearance = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&grid).swap_remove(0);
    for traversal in [Traversal::Cpu, Traversal::Gpu] {
        let options = SlicingOptions {
            traversal,
            slices_per_voxel: 16.0,
            ..Default::default()
        };
        // The second frame is drawn on a device that has drawn.
        for _ in 0..2 {
            let stats = draw(&gpu, &grid, &appearance, &options, &view).stats;
            let seconds = stats.gpu_seconds;
            assert!(seconds.is_none_or(|s| s > 0.0 && s <= stats.cpu_seconds));
            // Some 3000 pixels of 400 slabs take more than a millisecond of any CPU.
            let least = if gpu.is_software() { 1e-3 } else { 0.0 };
            assert!(seconds.unwrap_or(0.0) >= least, "{seconds:?}");
        }
    }
}

/// The published test draws the same picture, but for planes just before a corner.
#[test]
fn both_plane_tests_draw_the_same() {
    let Some(gpu) = testing::gpu("both_plane_tests_draw_the_same") else {
        return;
    };
    let grid = grid(&cube(20), |p| p.length() / 2.0);
    let appearance = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    for (name, view) in views(&grid) {
        let of = |plane_test| SlicingOptions {
            plane_test,
            level: Level::Fixed(1),
            ..Default::default()
        };
        let sides = draw(&gpu, &grid, &appearance, &of(PlaneTest::Sides), &view);
        let published = draw(&gpu, &grid, &appearance, &of(PlaneTest::Published), &view);
        let (rmse, _) = between(&sides, &published);
        // At most a polygon or two of some hundred is torn.
        assert!(rmse < 1e-2, "{name}: {rmse:e}");
    }
}

#[test]
fn the_callers_texture_gets_the_same_picture() {
    let Some(gpu) = testing::gpu("the_callers_texture_gets_the_same_picture") else {
        return;
    };
    let grid = grid(&cube(10), |p| p.length() / 2.0);
    let (_, view) = views(&grid).swap_remove(0);
    let appearance = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let options = SlicingOptions::default();
    let slicing = Slicing::new(&gpu, &Volume::Grid(grid), &appearance, &options).expect("it fits");
    let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
    let size = (view.width, view.height);
    let target = gpu
        .texture("target", size, TextureFormat::Rgba8Unorm, usage)
        .expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let target_view = target.create_view(&Default::default());
    let recorded = slicing.encode(
        &mut encoder,
        &view,
        &Target::new(&target_view, target.format()),
    );
    let copy = read_back(&gpu, &mut encoder, Source::Texture(&target)).expect("a copy");
    gpu.finish(encoder).expect("drawn");
    let bytes: Vec<[u8; 4]> = copy.read().expect("readable");
    let frame = slicing.render(&view).expect("drawn");
    let stats = recorded.expect("recorded").statistics().expect("counted");
    assert_eq!(stats.get(BRICKS_DRAWN), frame.stats.get(BRICKS_DRAWN));
    for (byte, float) in bytes.iter().flatten().zip(frame.pixels.iter().flatten()) {
        // Rounded to the nearest of 255 steps.
        assert!((f32::from(*byte) / 255.0 - float).abs() <= 0.51 / 255.0);
    }
}

#[test]
fn a_changed_renderer_draws_like_a_new_one() {
    let Some(gpu) = testing::gpu("a_changed_renderer_draws_like_a_new_one") else {
        return;
    };
    let first = grid(&cube(20), |p| p.length() / 2.0);
    let second = grid(&skewed(), |p| {
        (p - DVec3::new(1000.0, -2000.0, 500.0)).length() / 3.0
    });
    let narrow = TransferFunction::new(vec![
        knot(0.4, [1.0, 0.0, 0.0], 0.0),
        knot(0.41, [0.0, 1.0, 0.0], 9.0),
    ]);
    let looks = [
        appearance(&ramp(5.0), OpticalModel::EmissionAbsorption),
        appearance(&narrow.expect("sorted"), OpticalModel::Emission),
    ];
    let options = SlicingOptions::default();
    let volume = Volume::Grid(first.clone());
    let mut slicing = Slicing::new(&gpu, &volume, &looks[0], &options).expect("it fits");
    let (_, view) = views(&first).swap_remove(0);
    slicing.restyle(&looks[1]).expect("it fits");
    let changed = slicing.render(&view).expect("drawn");
    assert_eq!(
        changed.pixels,
        draw(&gpu, &first, &looks[1], &options, &view).pixels
    );
    slicing
        .reload(&Volume::Grid(second.clone()))
        .expect("it fits");
    let (_, view) = views(&second).swap_remove(1);
    let changed = slicing.render(&view).expect("drawn");
    assert_eq!(
        changed.pixels,
        draw(&gpu, &second, &looks[1], &options, &view).pixels
    );
}

#[test]
fn what_it_cannot_draw_is_refused() {
    let Some(gpu) = testing::gpu("what_it_cannot_draw_is_refused") else {
        return;
    };
    let volume = Volume::Grid(grid(&cube(3), |_| 0.5));
    let appearance = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let bad = [
        SlicingOptions {
            slices_per_voxel: f64::NAN,
            ..Default::default()
        },
        SlicingOptions {
            slices_per_voxel: 0.1,
            ..Default::default()
        },
        SlicingOptions {
            level: Level::Fixed(99),
            ..Default::default()
        },
        SlicingOptions {
            memory_budget: 10,
            ..Default::default()
        },
    ];
    for options in bad {
        let error = Slicing::new(&gpu, &volume, &appearance, &options);
        assert!(error.is_err(), "{options:?}");
    }
    // More slices than a frame may have: an extreme angle of view.
    let options = SlicingOptions {
        slices_per_voxel: 64.0,
        ..Default::default()
    };
    let slicing = Slicing::new(&gpu, &volume, &appearance, &options).expect("it fits");
    let (_, mut view) = views(&grid(&cube(3), |_| 0.5)).swap_remove(0);
    view.camera.projection = tetrascope_core::Projection::Perspective {
        view_angle: 179.99999,
    };
    assert!(slicing.render(&view).is_err());
}
