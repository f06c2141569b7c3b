//! Grids with coverage against the definition in `tetrascope_core::grid::coverage`.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::coverage::covered;
use tetrascope_core::grid::{BrickSource, Samples};
use tetrascope_core::optics::over;
use tetrascope_core::{
    Appearance, Error, Frame, Grid, OpticalModel, Ray, TransferFunction, View, Volume,
    VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_shaders::slicing::{SLICE_COVERED, SLICE_DEVICE, SLICE_FLOAT};
use tetrascope_slicing::counters::BRICKS_SKIPPED;
use tetrascope_slicing::{Integration, Shading, Slicing, SlicingOptions};

use crate::support::*;

/// The models whose extinction coverage scales.
const MODELS: [OpticalModel; 3] = [
    OpticalModel::EmissionAbsorption,
    OpticalModel::Emission,
    OpticalModel::Absorption,
];

/// Smooth, in [0, 1].
fn field(p: DVec3) -> f64 {
    0.5 + 0.25 * (5.0 * p.x + 2.0 * p.y).sin() + 0.25 * (4.0 * p.z - 3.0 * p.y).cos()
}

/// A ball that fills the cube's middle and fades over its border; 0 and 1 are exact.
fn ball(p: DVec3) -> f64 {
    (6.0 * (0.42 - (p - DVec3::splat(0.5)).length())).clamp(0.0, 1.0)
}

/// `grid` with a coverage by a formula of the world position.
fn with(grid: &Grid, coverage: impl Fn(DVec3) -> f64) -> Grid {
    let [nx, ny, nz] = grid.dims();
    let shares = (0..nx * ny * nz).map(|i| {
        let place = [i % nx, i / nx % ny, i / (nx * ny)].map(|i| i as f64);
        coverage(grid.world_from_lattice(DVec3::from_array(place))) as f32
    });
    grid.clone().covered(shares.collect()).expect("shares")
}

/// The integral by so many steps, straight from the definition, each of one color and extinction.
fn by_steps(
    grid: &Grid,
    look: &Appearance,
    ray: &Ray,
    background: [f64; 4],
    steps: u32,
) -> [f64; 4] {
    let (start, end) = span(grid, ray);
    let step = (end - start).max(0.0) / f64::from(steps);
    let (dims, samples) = (grid.dims(), grid.samples());
    let shares = grid.coverage().expect("covered");
    let model = look.optical_model;
    let (mut light, mut depth) = (DVec3::ZERO, 0.0_f64);
    for i in 0..steps {
        let t = start + (f64::from(i) + 0.5) * step;
        let p = (ray.origin + t * ray.direction - grid.origin()) / grid.spacing();
        let base = [0, 1, 2].map(|a| (p[a].max(0.0) as usize).min(dims[a] - 2));
        let index = |corner: usize| {
            let [x, y, z] = [0, 1, 2].map(|a| base[a] + (corner >> a & 1));
            x + dims[0] * (y + dims[1] * z)
        };
        let corners = std::array::from_fn(|corner| samples.get(index(corner)));
        let coverage = std::array::from_fn(|corner| f64::from(shares[index(corner)]));
        let place = (p - DVec3::from_array(base.map(|b| b as f64))).clamp(DVec3::ZERO, DVec3::ONE);
        let Some(point) = covered(&corners, &coverage, place) else {
            continue;
        };
        let sample = look.transfer_function.sample(point.scalar);
        let (color, extinction) = sample.expect("a number");
        let part = point.coverage * extinction * step;
        light += match model {
            OpticalModel::Emission => color * part,
            OpticalModel::EmissionAbsorption => color * (-depth).exp() * -(-part).exp_m1(),
            _ => DVec3::ZERO,
        };
        if model != OpticalModel::Emission {
            depth += part;
        }
    }
    over(model, light, depth, background)
}

/// Along axes, so that a point of the lattice is a quotient.
fn cube_of(n: usize) -> Grid {
    grid(&cube(n), field)
}

fn small(view: View) -> View {
    View {
        width: 24,
        height: 24,
        ..view
    }
}

/// The exact picture against steps straight from the definition. A step is 2e-4 long; where light
/// bends from cell to cell, by up to 36 per unit (extinction 3, coverage 6 per unit), the rule of
/// midpoints errs by an eighth of that times the step squared: 25 times 1.8e-7 on a ray, and as
/// much again where colors bend.
#[test]
fn the_exact_picture_is_the_definition() {
    let grid = with(&cube_of(13), ball);
    for model in MODELS {
        let look = appearance(&ramp(3.0), model);
        for (name, view) in views(&grid) {
            let view = small(view);
            let image = testing::truth(&Volume::Grid(grid.clone()), &look)
                .render_exact(&view)
                .expect("a view");
            let background = view.premultiplied_background();
            let steps = pixels(&view, |ray| by_steps(&grid, &look, ray, background, 8000));
            let off = std::iter::zip(&image.pixels, &steps).flat_map(|(a, b)| {
                let channels = std::iter::zip(a, b);
                channels.map(|(a, b)| (a - b).abs()).collect::<Vec<f64>>()
            });
            let most = off.fold(0.0, f64::max);
            assert!(most < 1e-5, "{model:?} {name}: {most:e}");
            let bound = image.worst_error_bound();
            assert!(bound < 1e-9, "{model:?} {name}: {bound:e}");
        }
    }
}

/// A slab of length h errs by a product of changes of coverage and color over it, and where
/// the volume's border bends: second order.
#[test]
fn pictures_converge_to_the_definition() {
    let Some(gpu) = testing::gpu("pictures_converge_to_the_definition") else {
        return;
    };
    let grid = with(&cube_of(13), ball);
    for model in MODELS {
        let look = appearance(&ramp(3.0), model);
        for wanted in [0, 1, 3] {
            let (name, view) = views(&grid).swap_remove(wanted);
            let view = small(view);
            let truth = truth(&grid, &look, &view);
            for integration in [Integration::Slabs, Integration::PostClassified] {
                let errors = [1.0, 2.0, 4.0, 8.0].map(|slices_per_voxel| {
                    let options = SlicingOptions {
                        slices_per_voxel,
                        integration,
                        ..Default::default()
                    };
                    let frame = draw(&gpu, &grid, &look, &options, &view);
                    difference(&frame, &truth).0
                });
                let order = (errors[0] / errors[3]).log2() / 3.0;
                let context = format!("{model:?} {integration:?} {name}: {errors:?}, {order}");
                assert!(errors[1] < 2e-3 && errors[3] < 1.5e-4, "{context}");
                assert!(order > 1.6, "{context}");
            }
        }
    }
}

// Interpolation and division by 1 round nothing that is not rounded without them, in themselves.
#[test]
fn a_grid_that_is_covered_whole_is_drawn_as_one_without_coverage() {
    let Some(gpu) = testing::gpu("a_grid_that_is_covered_whole_is_drawn_as_one_without_coverage")
    else {
        return;
    };
    let plain = grid(&skewed(), |p| field(0.01 * (p - skewed().origin)));
    let whole = with(&plain, |_| 1.0);
    for model in MODELS {
        for integration in [Integration::Slabs, Integration::PostClassified] {
            let options = SlicingOptions {
                integration,
                ..Default::default()
            };
            let look = appearance(&ramp(0.7), model);
            for (name, view) in views(&plain) {
                let [a, b] = [&plain, &whole].map(|g| draw(&gpu, g, &look, &options, &view));
                assert_near(&a, &b, &format!("{model:?} {integration:?} {name}"));
            }
        }
    }
}

/// Half of everything, by coverage and by extinction: factors of two round nothing.
#[test]
fn half_covered_is_half_as_dense() {
    let Some(gpu) = testing::gpu("half_covered_is_half_as_dense") else {
        return;
    };
    let plain = cube_of(13);
    let half = with(&plain, |_| 0.5);
    for model in MODELS {
        for (name, view) in views(&plain) {
            let look = |most| appearance(&ramp(most), model);
            let thin = draw(&gpu, &plain, &look(2.0), &Default::default(), &view);
            let covered = draw(&gpu, &half, &look(4.0), &Default::default(), &view);
            // Means of four products round, and the quotient: 8 of 2⁻²⁴ of a scalar, whose
            // colors change by at most 2.5 of it.
            let (_, most) = between(&thin, &covered);
            assert!(most < 2e-6, "{model:?} {name}: {most:e}");
        }
    }
}

/// Neither numbers nor NaN outside change anything; nor do samples without a value inside,
/// which are outside.
#[test]
fn what_is_outside_does_not_count() {
    let Some(gpu) = testing::gpu("what_is_outside_does_not_count") else {
        return;
    };
    let look = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let draw_with = |outside: f64| {
        let outer = |p: DVec3| if ball(p) > 0.0 { field(p) } else { outside };
        let grid = with(&grid(&cube(13), outer), ball);
        let (_, view) = views(&grid).swap_remove(0);
        draw(&gpu, &grid, &look, &Default::default(), &view)
    };
    let frames: Vec<Frame> = [0.5, -1e30, 1e38, f64::NAN, f64::INFINITY]
        .map(draw_with)
        .into();
    assert!(shows(&frames[0]));
    for frame in &frames[1..] {
        assert!(
            frame.pixels == frames[0].pixels,
            "the same shader, and the same numbers"
        );
    }
    // What the CPU is told to be covered, but has no value.
    let holes = |p: DVec3| if p.x + p.y > 1.2 { f64::NAN } else { field(p) };
    let cut = |p: DVec3| if p.x + p.y > 1.2 { 0.0 } else { ball(p) };
    let (a, b) = (with(&grid(&cube(13), holes), ball), with(&cube_of(13), cut));
    let (_, view) = views(&a).swap_remove(0);
    let [a, b] = [&a, &b].map(|grid| draw(&gpu, grid, &look, &Default::default(), &view));
    assert!(a.pixels == b.pixels, "the same texels");
}

/// A grid without coverage has none on the device, and its shader none to read.
#[test]
fn coverage_takes_nothing_where_there_is_none() {
    let Some(gpu) = testing::gpu("coverage_takes_nothing_where_there_is_none") else {
        return;
    };
    assert!(SLICE_COVERED.contains("covered_voxel"));
    for program in [SLICE_DEVICE, SLICE_FLOAT] {
        assert!(!program.contains("covered_voxel"));
    }
    let plain = cube_of(40);
    let covered = with(&plain, ball);
    let look = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&plain).swap_remove(0);
    let bytes = [&plain, &covered].map(|grid| {
        let stats = draw(&gpu, grid, &look, &Default::default(), &view).stats;
        assert_eq!(stats.bytes_uploaded, 0, "all was there before the frame");
        stats.bytes_resident / 40_u64.pow(3)
    });
    assert_eq!(bytes, [4, 8]);
    // A corner of the cube is outside of the ball, and so are its boxes.
    let stats = draw(&gpu, &covered, &look, &Default::default(), &view).stats;
    assert!(stats.get(BRICKS_SKIPPED).expect("counted") > 0);
}

/// Greatest colors and isosurfaces know samples that are half there or more and no others, in
/// the exact picture and in slices: the same numbers as without coverage and with gaps.
#[test]
fn without_extinction_a_sample_is_there_or_not() {
    let Some(gpu) = testing::gpu("without_extinction_a_sample_is_there_or_not") else {
        return;
    };
    let covered = with(&cube_of(13), ball);
    let shares = covered.coverage().expect("covered");
    let is_partly = |share: &f32| *share > 0.0 && *share < 1.0;
    assert!(shares.iter().any(is_partly));
    let there = |p: DVec3| if ball(p) < 0.5 { f64::NAN } else { field(p) };
    let gaps = grid(&cube(13), there);
    let volume = Volume::Grid(covered.clone());
    let greatest = appearance(&ramp(5.0), OpticalModel::MaximumIntensity);
    let surfaces = testing::surfaces(
        &volume,
        appearance(&ramp(5.0), OpticalModel::EmissionAbsorption),
    );
    for look in [&greatest, &surfaces] {
        let options = SlicingOptions::default();
        // From a model that sees coverage to one that does not, and back.
        let light = appearance(&ramp(5.0), OpticalModel::Emission);
        let mut slicing = Slicing::new(&gpu, &volume, &light, &options).expect("it fits");
        for (name, view) in views(&covered) {
            let view = small(view);
            let context = format!("{:?} {name}", look.optical_model);
            let [a, b] = [&covered, &gaps].map(|grid| truth(grid, look, &view));
            assert!(a == b, "{context}");
            let expected = draw(&gpu, &gaps, look, &options, &view);
            assert!(shows(&expected) || name == "inside", "{context}");
            let before = slicing.render(&view).expect("a view");
            slicing.restyle(look).expect("it draws it");
            let found = slicing.render(&view).expect("a view");
            assert_near(&found, &expected, &context);
            slicing.restyle(&light).expect("it draws it");
            let after = slicing.render(&view).expect("a view");
            assert!(after.pixels == before.pixels, "{context}");
        }
    }
}

fn refusal(gpu: &Gpu, volume: &Volume, look: &Appearance, options: &SlicingOptions) -> Error {
    Slicing::new(gpu, volume, look, options).expect_err("it has no meaning")
}

#[test]
fn what_coverage_does_not_mean_is_refused() {
    let Some(gpu) = testing::gpu("what_coverage_does_not_mean_is_refused") else {
        return;
    };
    let covered = with(&cube_of(5), ball);
    let source: std::sync::Arc<dyn BrickSource> = std::sync::Arc::new(covered.clone());
    let volume = Volume::Grid(covered);
    let plain = SlicingOptions::default();
    let volumetric = appearance(&ramp(5.0), OpticalModel::EmissionAbsorption);
    let lit = SlicingOptions {
        shading: Shading::Phong(Default::default()),
        ..Default::default()
    };
    let poor = SlicingOptions {
        memory_budget: 8 * 5_u64.pow(3) - 1,
        ..Default::default()
    };
    for (look, options, words) in [
        (&volumetric, &lit, "shading of a grid with coverage"),
        (&volumetric, &poor, "not streamed, needs 1000 bytes"),
    ] {
        let error = refusal(&gpu, &volume, look, options).to_string();
        assert!(error.contains(words), "{error}");
    }
    let error = Slicing::from_source(&gpu, source, &volumetric, &plain).expect_err("lost");
    assert!(
        error.to_string().contains("a source with coverage"),
        "{error}"
    );
    let (_, view) = views(&cube_of(5)).swap_remove(0);
    let bytes = grid_of(&cube(5), |p| (255.0 * field(p)) as u8, Samples::U8);
    let tf = TransferFunction::new(vec![
        knot(0.0, DVec3::ONE, 0.0),
        knot(255.0, DVec3::ONE, 5.0),
    ]);
    let look = appearance(&tf.expect("sorted"), OpticalModel::Absorption);
    let frame = draw(&gpu, &with(&bytes, |_| 0.5), &look, &plain, &view);
    assert!(
        frame.pixels.iter().any(|p| p[3] > 0.1),
        "samples of any type"
    );
}
