//! Pictures against the exact ones of the same grids.

use tetrascope_core::Unit as _;
use tetrascope_core::appearance::{ClipPlane, DepthCue};
use tetrascope_core::glam::{DMat3, DMat4, DVec3, DVec4};
use tetrascope_core::grid::Samples;
use tetrascope_core::{
    Camera, CameraFit, Grid, Isosurface, OpticalModel, Projection, TransferFunction,
};
use tetrascope_testing::{
    self as testing, Application, Place, between, difference, grid, knot, truth, view,
};

use super::*;

const SIDE: u32 = 32;

const BOTH: [Integration; 2] = [Integration::Slices, Integration::Slabs];

fn with(integration: Integration) -> StacksOptions {
    StacksOptions { integration }
}

fn made(gpu: &Gpu, grid: &Grid, look: &Appearance, integration: Integration) -> Stacks {
    let grid = DeviceGrid::upload(gpu, grid).expect("it fits");
    Stacks::from_device(gpu, &grid, look, &with(integration)).expect("it fits")
}

fn drawn(gpu: &Gpu, grid: &Grid, look: &Appearance, of: Integration, view: &View) -> Frame {
    made(gpu, grid, look, of).render(view).expect("a frame")
}

fn exact(grid: &Grid, look: &Appearance, view: &View) -> Vec<[f64; 4]> {
    let image = truth(&Volume::Grid(grid.clone()), look).render_exact(view);
    image.expect("a view").pixels
}

/// Turned, mirrored and with three different spacings, far from the origin.
fn skewed() -> Place {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).unit(), 0.7);
    Place {
        dims: [14, 23, 9],
        origin: DVec3::new(1000.0, -2000.0, 500.0),
        spacing: DVec3::new(0.1, 0.05, 0.15),
        direction: turn * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)),
    }
}

/// Along each axis of the lattice, from both of its sides and somewhat beside it, parallel and in
/// perspective; and from inside, where rays go along planes and back through the stack.
fn views(grid: &Grid) -> Vec<(String, View)> {
    let bounds = grid.bounds();
    let mut all = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let toward = sign * grid.direction().col(axis);
            let aside = grid.direction().col((axis + 1) % 3);
            let eye = toward + 0.3 * aside - 0.2 * grid.direction().col((axis + 2) % 3);
            for orthographic in [false, true] {
                let mut camera = Camera::fit(&bounds, CameraFit::PlusX, orthographic, 1.0);
                let distance = (camera.position - bounds.center()).length();
                camera.position = bounds.center() + distance * eye.unit();
                camera.view_up = aside;
                let name = format!("axis {axis}, {sign}, parallel: {orthographic}");
                all.push((name, view(camera, SIDE)));
            }
        }
    }
    let inside = testing::inside(&Volume::Grid(grid.clone()));
    all.push(("inside".into(), view(inside, SIDE)));
    let [x, y, z] = [0, 1, 2].map(|axis| grid.direction().col(axis));
    let wide = Camera {
        focal_point: inside.position + x + 0.95 * y + 0.1 * z,
        view_up: z,
        projection: Projection::Perspective { view_angle: 150.0 },
        ..inside
    };
    all.push(("along planes".into(), view(wide, SIDE)));
    all
}

fn ramp(most: f64) -> TransferFunction {
    let knots = vec![
        knot(0.0, [0.1, 0.3, 0.9], 0.0),
        knot(0.4, [0.9, 0.5, 0.2], 0.3 * most),
        knot(1.0, [1.0, 0.9, 0.6], most),
    ];
    TransferFunction::new(knots).expect("sorted")
}

/// A step and a tent narrower than a slab, and denser than a pixel shows through.
fn edgy(most: f64) -> TransferFunction {
    let knots = vec![
        knot(0.3, [0.1, 0.2, 0.9], 0.0),
        knot(0.45, [0.4, 0.9, 0.1], 0.1 * most),
        knot(0.45, [0.9, 0.1, 0.2], 0.3 * most),
        knot(0.6, [1.0, 0.8, 0.3], 0.01 * most),
        knot(0.602, [1.0, 1.0, 1.0], most),
        knot(0.604, [0.5, 1.0, 1.0], 0.01 * most),
    ];
    TransferFunction::new(knots).expect("sorted")
}

/// A field that changes by 1.5 or so over the grid, along all of its axes.
fn linear(place: &Place) -> Grid {
    let center = grid(place, |_| 0.0).bounds().center();
    let turn = place.direction;
    grid(place, |p| {
        0.5 + (p - center).dot(turn * DVec3::new(0.4, -0.6, 0.5))
    })
}

/// A cube's worth of waves, in [0, 1].
fn waves(p: DVec3) -> f64 {
    0.5 + 0.25 * (5.0 * p.x + 2.0 * p.y).sin() + 0.25 * (4.0 * p.z - 3.0 * p.y).cos()
}

/// A ball in the middle of the unit cube that fades over its border.
fn ball(p: DVec3) -> f64 {
    (6.0 * (0.42 - (p - DVec3::splat(0.5)).length())).clamp(0.0, 1.0)
}

fn covered(grid: Grid, coverage: impl Fn(DVec3) -> f64) -> Grid {
    let [nx, ny, nz] = grid.dims();
    let shares = (0..nx * ny * nz).map(|i| {
        let place = [i % nx, i / nx % ny, i / (nx * ny)].map(|i| i as f64);
        coverage(grid.world_from_lattice(DVec3::from_array(place))) as f32
    });
    let shares = shares.collect();
    grid.covered(shares).expect("shares")
}

/// Interpolated linearly, integrated in closed form, and cut where rays enter and leave: whatever
/// the axis, the order and the planes, rounding alone is left. A flipped axis, another order or a
/// slab too much shows.
#[test]
fn a_linear_field_is_exact_with_slabs() {
    let Some(gpu) = testing::gpu("a_linear_field_is_exact_with_slabs") else {
        return;
    };
    let grid = linear(&skewed());
    let samples = DeviceGrid::upload(&gpu, &grid).expect("it fits");
    let mut stacks_seen = [false; 3];
    for most in [9.0, 100.0] {
        for model in OpticalModel::VOLUMETRIC {
            let mut look = Appearance::new(edgy(most), model);
            let options = StacksOptions::default();
            let mut stacks = Stacks::from_device(&gpu, &samples, &look, &options).expect("fits");
            for cued in [false, true] {
                look.depth_cue = cued.then_some(DepthCue { strength: 0.8 });
                stacks.restyle(&look).expect("a look");
                for (name, view) in views(&grid) {
                    let plane = ImagePlane::new(&view, &stacks.layers.normalization);
                    stacks_seen[stacks.stacked(&view, &plane).axis] = true;
                    let frame = stacks.render(&view).expect("a frame");
                    let truth = exact(&grid, &look, &view);
                    let scale = testing::scale(&truth);
                    let (rmse, worst) = difference(&frame, &truth);
                    // As in `slicing`: blending of 23 slabs in f32 loses 23 of 2⁻²⁴, and scalars
                    // that are right to 2⁻²³ of the range move a knot by that over the slope, at
                    // least 0.05 per unit for nearly all rays, times σ: 2e-5 where that is 9.
                    // Rays along which a scalar hardly changes see the whole step move.
                    let bound = 2e-5 * (most / 9.0) * scale;
                    assert!(
                        rmse < bound && worst < 15.0 * bound,
                        "{name} {model:?} {most} {cued}: {rmse:e} {worst:e}"
                    );
                }
            }
        }
    }
    assert_eq!(stacks_seen, [true; 3]);
}

/// One extinction everywhere: what is off is where rays enter and leave.
#[test]
fn published_slices_of_a_uniform_box_are_exact_but_at_its_sides() {
    let Some(gpu) = testing::gpu("published_slices_of_a_uniform_box_are_exact_but_at_its_sides")
    else {
        return;
    };
    let place = skewed();
    let grid = grid(&place, |_| 0.7);
    let look = Appearance::new(ramp(0.6), OpticalModel::Absorption);
    let stacks = made(&gpu, &grid, &look, Integration::Slices);
    for (name, mut view) in views(&grid) {
        if !name.contains("parallel") {
            continue;
        }
        view.background = [0.0; 4];
        let frame = stacks.render(&view).expect("a frame");
        let truth = exact(&grid, &look, &view);
        let plane = ImagePlane::new(&view, &stacks.layers.normalization);
        let axis = stacks.stacked(&view, &plane).axis;
        let extinction = 0.6 * (0.3 + 0.7 * 0.5);
        let inverse = grid.lattice().linear().inverse();
        let cells = DVec3::from_array(grid.lattice().cells().map(|c| c as f64));
        let (mut most, mut whole, mut seen) = (0.0_f64, 0.0_f64, 0);
        for (i, (found, truth)) in std::iter::zip(&frame.pixels, &truth).enumerate() {
            let depth = |alpha: f64| -(-alpha).ln_1p();
            let off = (depth(found[3].into()) - depth(truth[3])).abs();
            most = most.max(off);
            // Whether the ray goes through the first and the last plane.
            let ray = view.ray(i as u32 % SIDE, i as u32 / SIDE);
            let (origin, along) = (
                inverse * (ray.origin - place.origin),
                inverse * ray.direction,
            );
            let ends = [0.0, cells[axis]].map(|layer| {
                let mut at = origin + (layer - origin[axis]) / along[axis] * along;
                at[axis] = layer;
                at.cmpge(DVec3::ZERO).all() && at.cmple(cells).all()
            });
            if ends == [true; 2] {
                (whole, seen) = (whole.max(off), seen + 1);
            }
        }
        // Half of the distance of planes at each side, along rays that are up to 1.3 times as long
        // between planes; and an optical depth of at most 1.5 blended in f32, 23 times: 23 · 2⁻²⁴,
        // and as much for light, over a transmittance of 0.2.
        let bound = extinction * place.spacing[axis] * 1.3;
        eprintln!("{name}: {most:.2e} of {bound:.2e}; {seen} through the stack: {whole:.1e}");
        assert!(most < bound, "{name}: {most} {bound}");
        assert!(seen > 20 && whole < 1.4e-5, "{name}: {whole:e}");
    }
}

/// At first order at the sides of the box, which rays enter and leave between planes, at second in
/// its middle; slabs everywhere at second.
#[test]
fn errors_fall_with_the_distance_of_samples() {
    let Some(gpu) = testing::gpu("errors_fall_with_the_distance_of_samples") else {
        return;
    };
    for has_coverage in [false, true] {
        for model in OpticalModel::VOLUMETRIC {
            let look = Appearance::new(ramp(3.0), model);
            for wanted in [0, 3, 5, 8] {
                let errors = BOTH.map(|integration| {
                    [9, 17, 33, 65].map(|n| {
                        let mut grid = grid(&Place::unit(n - 1), waves);
                        if has_coverage {
                            grid = covered(grid, ball);
                        }
                        let (_, view) = views(&grid).swap_remove(wanted);
                        let frame = drawn(&gpu, &grid, &look, integration, &view);
                        difference(&frame, &exact(&grid, &look, &view)).0
                    })
                });
                let order = |e: [f64; 4]| (e[0] / e[3]).log2() / 3.0;
                let orders = errors.map(order);
                let context =
                    format!("{model:?} {wanted} {has_coverage}: {orders:.2?} {errors:.6?}");
                eprintln!("{context}");
                // Slices: the first at the sides of the box; but what is covered ends inside of it,
                // between planes. Greatest colors jump where the box, or what has a value in it,
                // ends: how many pixels are wrong falls at first order, and the RMSE by its root.
                let least = match (model, has_coverage) {
                    (OpticalModel::MaximumIntensity, false) => [0.4, 1.8],
                    (OpticalModel::MaximumIntensity, true) => [0.4, 0.4],
                    (_, false) => [0.9, 1.9],
                    (_, true) => [1.6, 1.6],
                };
                let all = orders[0] > least[0] && orders[1] > least[1];
                assert!(all, "{context}");
                // Slabs are nearer to the truth, and near: with nine samples along an axis.
                let fades = model != OpticalModel::MaximumIntensity;
                let near = errors[1][0] < 3e-3 && errors[1][3] < 1e-4;
                assert!(!fades || near, "{context}");
            }
        }
    }
}

/// Cameras beside the diagonal of a cube, each of which has another axis most nearly along its own:
/// pictures of three stacks that differ by what each is off, and by what the camera moved.
#[test]
fn three_stacks_agree_along_the_diagonal() {
    let Some(gpu) = testing::gpu("three_stacks_agree_along_the_diagonal") else {
        return;
    };
    let grid = covered(grid(&Place::unit(24), waves), ball);
    let bounds = grid.bounds();
    for model in OpticalModel::VOLUMETRIC {
        let look = Appearance::new(ramp(3.0), model);
        for integration in BOTH {
            for sign in [-1.0, 1.0] {
                for orthographic in [false, true] {
                    let stacks = made(&gpu, &grid, &look, integration);
                    let pictures = [0, 1, 2].map(|axis| {
                        let mut camera = Camera::fit(&bounds, CameraFit::PlusX, orthographic, 1.0);
                        let distance = (camera.position - bounds.center()).length();
                        let mut eye = DVec3::ONE;
                        eye[axis] += 1e-6;
                        camera.position = bounds.center() + sign * distance * eye.unit();
                        let view = view(camera, SIDE);
                        let plane = ImagePlane::new(&view, &stacks.layers.normalization);
                        assert_eq!(stacks.stacked(&view, &plane).axis, axis);
                        let frame = stacks.render(&view).expect("a frame");
                        let error = difference(&frame, &exact(&grid, &look, &view)).0;
                        (frame, error)
                    });
                    for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                        let ((a, off_a), (b, off_b)) = (&pictures[a], &pictures[b]);
                        let apart = between(a, b).0;
                        let context =
                            format!("{model:?} {integration:?}: {apart:e} {off_a:e} {off_b:e}");
                        // The triangle inequality; a camera that moves by 1e-6 changes a thousandth
                        // of what stacks are off.
                        assert!(apart <= 1.01 * (off_a + off_b), "{context}");
                        // Greatest colors jump where the ball ends.
                        let most = match model {
                            OpticalModel::MaximumIntensity => 0.1,
                            _ => 1e-2,
                        };
                        assert!(*off_a < most && apart > 0.0, "{context}");
                    }
                }
            }
        }
    }
}

/// Clip planes cut slabs exactly, and so does what an application has drawn.
#[test]
fn slabs_end_at_clip_planes_and_before_an_applications_geometry() {
    let Some(gpu) = testing::gpu("slabs_end_at_clip_planes_and_before_an_applications_geometry")
    else {
        return;
    };
    let grid = linear(&skewed());
    let (bounds, volume) = (grid.bounds(), Volume::Grid(grid.clone()));
    let whole = Appearance::new(ramp(6.0), OpticalModel::EmissionAbsorption);
    let mut look = whole.clone();
    look.clip_planes = testing::tilted(&volume);
    look.clip_planes.push(ClipPlane {
        point: bounds.center() + 0.2 * bounds.size(),
        normal: DVec3::new(-1.0, -0.2, 0.1),
    });
    for (name, mut view) in views(&grid) {
        let frame = drawn(&gpu, &grid, &look, Integration::Slabs, &view);
        let clipped = exact(&grid, &look, &view);
        let (rmse, most) = difference(&frame, &clipped);
        // As without them: 1e-5, at most 15 times that.
        assert!(rmse < 1e-5 && most < 1.5e-4, "{name}: {rmse:e} {most:e}");
        let uncut = drawn(&gpu, &grid, &whole, Integration::Slabs, &view);
        assert!(
            difference(&uncut, &clipped).0 > 1e-2,
            "{name}: planes cut nothing"
        );
        let slices = drawn(&gpu, &grid, &look, Integration::Slices, &view);
        let error = difference(&slices, &clipped).0;
        assert!(error < 0.1, "{name}: {error}");

        let Projection::Orthographic { parallel_scale } = view.camera.projection else {
            continue;
        };
        if !gpu.features().contains(wgpu::Features::FLOAT32_BLENDABLE) {
            continue;
        }
        view.background = [0.0; 4];
        let (right, up, forward) = view.camera.axes();
        let eye = view.camera.position;
        let distance = (bounds.center() - eye).dot(forward);
        let row = |axis: DVec3, scale: f64| (scale * axis).extend(-scale * axis.dot(eye));
        // The middle of the grid has a depth of 1/2.
        let clip = DMat4::from_cols(
            row(right, parallel_scale.recip()),
            row(up, parallel_scale.recip()),
            row(forward, 0.5 / distance),
            DVec4::W,
        );
        let pixels = (SIDE * SIDE) as usize;
        let there = Application::draw(
            &gpu,
            (SIDE, SIDE),
            &vec![[0.0; 4]; pixels],
            &vec![0.5; pixels],
            TextureFormat::Depth32Float,
        );
        let there = there.expect("drawn");
        let color = there.color.create_view(&Default::default());
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let target = there.target(&color, clip.transpose());
        let stacks = made(&gpu, &grid, &whole, Integration::Slabs);
        let recorded = stacks.encode(&mut encoder, &view, &target);
        gpu.finish(encoder).expect("it runs");
        let stats = recorded.expect("recorded").statistics().expect("read");
        let (found, _) = there.read(&gpu).expect("read");
        let found = Frame::new((SIDE, SIDE), found, stats);
        let before = truth(&volume, &whole).render_before(&view, &vec![distance; pixels]);
        let (rmse, most) = difference(&found, &before.expect("a frame").pixels);
        assert!(rmse < 1e-5 && most < 1.5e-4, "{name}: {rmse:e} {most:e}");
        let hidden = difference(&found, &exact(&grid, &whole, &view)).0;
        assert!(hidden > 1e-2, "{name}: nothing was hidden");
    }
}

/// Voxels that are covered whole are drawn as those without coverage; halves are half as dense; and what
/// is outside does not matter.
#[test]
fn coverage_scales_extinction_and_what_is_outside_does_not_count() {
    let Some(gpu) = testing::gpu("coverage_scales_extinction_and_what_is_outside_does_not_count")
    else {
        return;
    };
    let plain = grid(&Place::unit(12), waves);
    let (whole, half) = (
        covered(plain.clone(), |_| 1.0),
        covered(plain.clone(), |_| 0.5),
    );
    for (name, view) in views(&plain) {
        for integration in BOTH {
            for model in OpticalModel::VOLUMETRIC {
                let look = |most| Appearance::new(ramp(most), model);
                let draw = |grid, most| drawn(&gpu, grid, &look(most), integration, &view);
                let thin = draw(&plain, 2.0);
                let context = format!("{name} {integration:?} {model:?}");
                // Means with products of 1, which round nothing; a shader may fuse them.
                let most = between(&thin, &draw(&whole, 2.0)).1;
                assert!(most < 2e-6, "{context}: {most:e}");
                // Means of four products round, and the quotient: 8 of 2⁻²⁴ of a scalar, whose
                // colors change by at most 2.5 of it.
                let most = between(&thin, &draw(&half, 4.0)).1;
                assert!(most < 2e-6, "{context}: {most:e}");
            }
        }
    }
    let look = Appearance::new(ramp(5.0), OpticalModel::EmissionAbsorption);
    let (_, view) = views(&plain).swap_remove(0);
    for integration in BOTH {
        let frames = [0.5, -1e30, 1e38, f64::NAN].map(|outside| {
            let field = |p| if ball(p) > 0.0 { waves(p) } else { outside };
            let grid = covered(grid(&Place::unit(12), field), ball);
            drawn(&gpu, &grid, &look, integration, &view).pixels
        });
        assert!(frames.iter().all(|f| *f == frames[0]), "{integration:?}");
    }
}

/// A camera in the grid sees rays along planes, and a frame says so.
#[test]
fn rays_along_planes_are_noted() {
    let Some(gpu) = testing::gpu("rays_along_planes_are_noted") else {
        return;
    };
    let grid = grid(&Place::unit(32), waves);
    let look = Appearance::new(ramp(3.0), OpticalModel::EmissionAbsorption);
    let all = views(&grid);
    let outside = all[0].1;
    let along = all.last().expect("from inside").1;
    for integration in BOTH {
        let errors = [outside, along].map(|view| {
            let frame = drawn(&gpu, &grid, &look, integration, &view);
            let noted = frame
                .stats
                .notes
                .iter()
                .any(|note| note.contains("any number"));
            (difference(&frame, &exact(&grid, &look, &view)), noted)
        });
        eprintln!("{integration:?}: {errors:?}");
        assert!(!errors[0].1 && errors[1].1);
        // Rays that go along planes meet many in no place, and some by chance: a few percent. Slabs
        // have what is at the ends of such rays.
        let most = match integration {
            Integration::Slices => 0.1,
            Integration::Slabs => 0.03,
        };
        assert!(errors[1].0.0 < most);
    }
}

#[test]
fn reloaded_and_restyled_is_as_made_anew() {
    let Some(gpu) = testing::gpu("reloaded_and_restyled_is_as_made_anew") else {
        return;
    };
    let first = grid(&Place::unit(12), waves);
    let second = grid(&Place::unit(12), |p| waves(p * p));
    let third = covered(linear(&skewed()), |_| 0.7);
    let options = StacksOptions::default();
    let look = Appearance::new(ramp(3.0), OpticalModel::EmissionAbsorption);
    let other = Appearance::new(edgy(3.0), OpticalModel::Emission);
    let mut on_device = DeviceGrid::upload(&gpu, &first).expect("it fits");
    on_device = DeviceGrid::from_texture(
        on_device.texture().clone(),
        first.lattice(),
        on_device.texels(),
        Some((0.0, 1.0)),
    )
    .expect("the same");
    let mut stacks = Stacks::from_device(&gpu, &on_device, &look, &options).expect("it fits");
    let same = |stacks: &Stacks, grid: &Grid, look: &Appearance, step: &str| {
        for (name, view) in [0, 5, 9].map(|i| views(grid).swap_remove(i)) {
            let expected = drawn(&gpu, grid, look, Integration::Slabs, &view);
            let found = stacks.render(&view).expect("a frame");
            assert!(expected.pixels == found.pixels, "{step}, {name}");
        }
    };
    same(&stacks, &first, &look, "as made");
    // The same texture, written anew by recorded commands: nothing is made.
    let samples = DeviceGrid::upload(&gpu, &second).expect("it fits");
    let write = |encoder: &mut wgpu::CommandEncoder| {
        let [from, to] = [&samples, &on_device].map(|grid| grid.texture().as_image_copy());
        encoder.copy_texture_to_texture(from, to, samples.texture().size());
    };
    let before = gpu.allocations();
    stacks.reload_made(&on_device, write).expect("it fits");
    assert_eq!(gpu.allocations(), before);
    same(&stacks, &second, &look, "written anew");
    let back = DeviceGrid::upload(&gpu, &first).expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let [from, to] = [&back, &on_device].map(|grid| grid.texture().as_image_copy());
    encoder.copy_texture_to_texture(from, to, back.texture().size());
    stacks.refresh(&mut encoder).expect("recorded");
    gpu.finish(encoder).expect("it runs");
    same(&stacks, &first, &look, "refreshed");
    stacks.restyle(&other).expect("a look");
    same(&stacks, &first, &other, "restyled");
    stacks
        .reload(&Volume::Grid(third.clone()))
        .expect("it fits");
    same(&stacks, &third, &other, "another grid");
    stacks
        .reload(&Volume::Grid(second.clone()))
        .expect("it fits");
    stacks.restyle(&look).expect("a look");
    same(&stacks, &second, &look, "and back");
    // Three stacks and the grid, and a transfer function of four intervals.
    let (_, view) = views(&second).swap_remove(0);
    let frame = stacks.render(&view).expect("a frame");
    let knots = 4 * size_of::<tetrascope_f32::KnotPair>() as u64;
    assert_eq!(frame.stats.bytes_resident, 4 * (13 * 13 * 13 * 4) + knots);
}

/// Each step of a change is refused in turn: the picture stays.
#[test]
fn an_error_leaves_the_picture_as_it_was() {
    let Some(gpu) = testing::gpu("an_error_leaves_the_picture_as_it_was") else {
        return;
    };
    let first = grid(&Place::unit(8), waves);
    let (look, other) = (
        Appearance::new(ramp(3.0), OpticalModel::EmissionAbsorption),
        Appearance::new(edgy(3.0), OpticalModel::Absorption),
    );
    let mut stacks = made(&gpu, &first, &look, Integration::Slabs);
    let (first, second) = (Volume::Grid(first), Volume::Grid(linear(&skewed())));
    let view = testing::fitted(&first, CameraFit::PlusIso, false, SIDE);
    let before = stacks.render(&view).expect("a frame").pixels;
    for change in ["reload", "restyle"] {
        let mut refused = 0;
        for step in 0..60 {
            gpu.refuse_after(Some(step));
            let changed = match change {
                "reload" => stacks.reload(&second),
                _ => stacks.restyle(&other),
            };
            gpu.refuse_after(None);
            if changed.is_ok() {
                break;
            }
            refused += 1;
            let frame = stacks.render(&view).expect("a frame");
            assert!(frame.pixels == before, "{change}, step {step}");
        }
        eprintln!("{change}: {refused} steps");
        assert!(refused > 1 && refused < 60, "{change}: {refused} steps");
        stacks.reload(&first).expect("it fits");
        stacks.restyle(&look).expect("a look");
    }
}

#[test]
fn what_is_not_drawn_is_refused_in_words() {
    let Some(gpu) = testing::gpu("what_is_not_drawn_is_refused_in_words") else {
        return;
    };
    let options = StacksOptions::default();
    let look = Appearance::new(ramp(1.0), OpticalModel::EmissionAbsorption);
    let plain = grid(&Place::unit(4), waves);
    let volume = Volume::Grid(plain.clone());
    let mut surfaces = testing::surfaces(&volume, look.clone());
    surfaces.isosurfaces = vec![Isosurface {
        value: 0.5,
        color: DVec3::ONE,
    }];
    let gaps = grid(&Place::unit(4), |p| if p.x > 0.9 { f64::NAN } else { 0.5 });
    let nearest = Lattice {
        interpolation: Interpolation::Nearest,
        ..*plain.lattice()
    };
    let filling = DeviceGrid::new(&gpu, &nearest, Texels::Values, None).expect("it fits");
    let upload = |grid: &Grid| DeviceGrid::upload(&gpu, grid).expect("it fits");
    let (view, mut broken) = (
        views(&plain).swap_remove(0).1,
        views(&plain).swap_remove(0).1,
    );
    broken.width = 0;
    for (grid, look, words) in [
        (upload(&plain), &surfaces, "isosurfaces"),
        (upload(&gaps), &look, "samples without a value"),
        (filling, &look, "samples that fill cells"),
    ] {
        let error = Stacks::from_device(&gpu, &grid, look, &options).expect_err(words);
        assert!(matches!(error, Error::Unsupported { .. }), "{error}");
        let known = Stacks::supports(grid.lattice(), grid.texels(), look, &view, &options);
        for error in [error, known.expect_err(words)] {
            let error = error.to_string();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
    }
    let supports = |view| Stacks::supports(plain.lattice(), Texels::Covered, &look, view, &options);
    supports(&view).expect("drawn");
    assert!(supports(&broken).is_err());
    // More layers than a texture has, but not more texels than a side.
    let most = gpu.limits().max_texture_array_layers;
    if most < gpu.limits().max_texture_dimension_3d {
        let long = Lattice {
            dims: [2, most as usize + 1, 2],
            ..*plain.lattice()
        };
        let long = DeviceGrid::new(&gpu, &long, Texels::Values, None).expect("it fits");
        let error = Stacks::from_device(&gpu, &long, &look, &options).expect_err("too many");
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
        assert!(error.to_string().contains("layers"), "{error}");
    }
    let mut stacks = made(&gpu, &plain, &look, Integration::Slabs);
    let mesh = Volume::Mesh(testing::data_set("sphere", Some(100)));
    let error = stacks.reload(&mesh).expect_err("a mesh").to_string();
    assert!(error.contains("regular grid"), "{error}");
}

/// Mapped to nothing, a grid is not drawn; greatest colors do not ask for extinction.
#[test]
fn what_maps_to_nothing_is_not_drawn() {
    let Some(gpu) = testing::gpu("what_maps_to_nothing_is_not_drawn") else {
        return;
    };
    let grid = testing::grid_of(&Place::unit(4), |_| 3.0_f32, Samples::F32);
    let nothing = TransferFunction::new(vec![knot(3.5, [0.6; 3], 0.0), knot(4.0, [1.0; 3], 1.0)]);
    let nothing = nothing.expect("sorted");
    let (_, view) = views(&grid).swap_remove(0);
    for model in OpticalModel::VOLUMETRIC {
        let look = Appearance::new(nothing.clone(), model);
        let frame = drawn(&gpu, &grid, &look, Integration::Slabs, &view);
        let passes = frame.stats.passes;
        let expected = if model == OpticalModel::MaximumIntensity {
            2
        } else {
            1
        };
        assert_eq!(passes, expected, "{model:?}");
        let most = difference(&frame, &exact(&grid, &look, &view)).1;
        // A background of three components, and greatest colors, in f32.
        assert!(most < 1e-7, "{model:?}: {most:e}");
    }
}

#[test]
fn the_uniform_has_the_layout_of_its_twin() {
    use tetrascope_shaders::assert_layout;
    use tetrascope_shaders::stacks::RECTANGLE;

    assert_layout!(
        RECTANGLE,
        CameraUniform {
            right,
            up,
            forward,
            origin,
            origin_x,
            origin_y,
            along,
            along_x,
            along_y,
            cells,
            extent,
            slope,
            inverse_reach,
            size,
            anchor_depth,
            w_per_depth,
            w_constant,
            ahead,
            rectangle_count,
            raw_unit,
            raw_base,
            raw_most
        }
    );
}
