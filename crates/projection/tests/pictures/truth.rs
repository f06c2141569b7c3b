//! Cell projection against the ground truth.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{
    Appearance, Camera, CameraFit, Error, Knot, OpticalModel, Projection, TetMesh,
    TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::memory::Source;
use tetrascope_gpu::{Draw as _, Gpu, Target, read_back, wgpu};
use tetrascope_projection::counters::{
    BYTES_PER_VIEW, CELLS_DRAWN, CELLS_SKIPPED, CELLS_SORTED, FRAGMENTS_SORTED, VISIBILITY_CYCLES,
};
use tetrascope_projection::{CellProjection, Order, ProjectionOptions, Sort};
use tetrascope_testing::{self as testing, between, kuhn, mesh};

use crate::common::{EXACT, crooked, drawn, scene, truth};

/// From two sides, from a crooked one and along an axis, both projections, and from inside.
fn views(volume: &Volume) -> Vec<(&'static str, View)> {
    let bounds = volume.bounds();
    let fit = |side, orthographic| Camera::fit(&bounds, side, orthographic, 1.0);
    // Not a vertex: an irrational share of the box.
    let eye = bounds.min + bounds.size() * DVec3::new(0.41, 0.47, 0.53);
    let inside = Camera {
        position: eye,
        focal_point: eye + bounds.diagonal() * DVec3::new(0.7, 0.4, -0.2),
        view_up: DVec3::Z,
        projection: Projection::Perspective { view_angle: 75.0 },
    };
    let plane_inside = Camera {
        projection: Projection::Orthographic {
            parallel_scale: 0.3 * bounds.diagonal(),
        },
        ..inside
    };
    let crooked = |orthographic| crooked(volume, orthographic, 96);
    let view = |camera| View {
        camera,
        ..crooked(true)
    };
    vec![
        ("perspective", crooked(false)),
        ("orthographic", crooked(true)),
        ("along an axis", view(fit(CameraFit::PlusX, true))),
        ("inside", view(inside)),
        ("plane inside", view(plane_inside)),
    ]
}

/// Draws `name` in every view, in the model that needs `order`, or for
/// [`Order::Unsorted`] in those that need none, and compares with the truth.
fn compare(test: &str, name: &str, cells: u64, order: Order, (rmse, worst): (f64, f64)) {
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let (volume, transfer_function) = scene(name, cells);
    let options = ProjectionOptions {
        order,
        ..ProjectionOptions::default()
    };
    for optical_model in OpticalModel::VOLUMETRIC {
        if optical_model.commutes() != (order == Order::Unsorted) {
            continue;
        }
        let appearance = Appearance::new(transfer_function.clone(), optical_model);
        let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
        for (from, view) in views(&volume) {
            let picture = renderer.render(&view).expect("nothing can fail");
            let truth = truth(&volume, &appearance, &view);
            let found = between(&picture, &truth);
            eprintln!(
                "{name} {order:?} {optical_model:?} {from}: RMSE {:.1e}, max {:.1e}, \
                 cycles {:?}, fragments {:?}",
                found.0,
                found.1,
                picture.stats.get(VISIBILITY_CYCLES),
                picture.stats.get(FRAGMENTS_SORTED),
            );
            assert!(
                found.0 <= rmse && found.1 <= worst,
                "{name} {order:?} {optical_model:?} {from}: {found:?}"
            );
        }
    }
}

/// Where cells are drawn in the wrong order. Exchanging neighbors changes the light by
/// α₁ α₂ |c₁ − c₂|; with cells a fifteenth of these meshes wide and opacities up to 1/3 in
/// one, that is up to 1/9, and one pixel in some thousand has such a pair.
const MISORDERED: (f64, f64) = (3e-3, 1.0 / 9.0);

#[test]
fn the_sphere_is_drawn_right() {
    let test = "the_sphere_is_drawn_right";
    compare(test, "sphere", 3000, Order::Centroid, MISORDERED);
}

#[test]
fn the_torus_is_drawn_right() {
    let test = "the_torus_is_drawn_right";
    compare(test, "torus", 3000, Order::Centroid, MISORDERED);
}

// The same keys but for rounding, and ties in the same order: a crooked view of a mesh has
// no two cells so near to one distance, or they do not hide each other.
#[test]
fn centroids_are_sorted_alike_on_the_device_and_on_the_cpu() {
    let test = "centroids_are_sorted_alike_on_the_device_and_on_the_cpu";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    for name in ["sphere", "torus"] {
        let (volume, transfer_function) = scene(name, 3000);
        let model = OpticalModel::EmissionAbsorption;
        let appearance = Appearance::new(transfer_function, model);
        for (from, view) in views(&volume) {
            let [gpu_frame, cpu_frame] = [Sort::Gpu, Sort::Cpu].map(|sort| {
                let options = ProjectionOptions {
                    order: Order::Centroid,
                    sort,
                    ..ProjectionOptions::default()
                };
                drawn(&gpu, &volume, &appearance, &view, &options)
            });
            assert_eq!(gpu_frame.stats.bytes_uploaded, 0);
            assert!(cpu_frame.stats.bytes_uploaded > 0);
            assert_eq!(
                gpu_frame.stats.get(CELLS_SORTED),
                cpu_frame.stats.get(CELLS_SORTED)
            );
            let (rmse, worst) = between(&gpu_frame, &cpu_frame);
            assert!(worst < 1e-6, "{name} {from}: {rmse:e} {worst:e}");
        }
    }
}

#[test]
fn models_that_commute_are_exact_in_any_order() {
    let test = "models_that_commute_are_exact_in_any_order";
    for name in ["sphere", "orbital", "heat-sink", "torus", "graded"] {
        compare(test, name, 3000, Order::Unsorted, EXACT);
    }
}

// Knots on the lines between others change nothing but the number of intervals: cells
// with more than two, on average, are not drawn in pieces.
#[test]
fn cells_in_many_intervals_are_exact() {
    let Some(gpu) = testing::gpu("cells_in_many_intervals_are_exact") else {
        return;
    };
    let (volume, coarse) = scene("sphere", 3000);
    let (low, high) = coarse.range();
    let shares = (1..200).map(|i| low + (high - low) * f64::from(i) / 200.0);
    let knot = |scalar| {
        let (color, extinction) = coarse.sample(scalar).expect("a number");
        Knot {
            scalar,
            color,
            extinction,
        }
    };
    let mut knots: Vec<Knot> = shares.map(knot).collect();
    knots.extend(coarse.knots());
    knots.sort_by(|a, b| a.scalar.total_cmp(&b.scalar));
    let fine = TransferFunction::new(knots).expect("sorted");
    let options = ProjectionOptions {
        order: Order::Mpvo,
        ..ProjectionOptions::default()
    };
    for model in OpticalModel::VOLUMETRIC {
        let appearance = Appearance::new(fine.clone(), model);
        let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
        for (from, view) in views(&volume) {
            let picture = renderer.render(&view).expect("a picture");
            let found = between(&picture, &truth(&volume, &appearance, &view));
            let (rmse, worst) = EXACT;
            assert!(
                found.0 <= rmse && found.1 <= worst,
                "{model:?} {from}: {found:?}"
            );
        }
    }
}

// Through the hole of a torus and between the fins a ray comes back to the mesh.
#[test]
fn mpvo_orders_parts_by_their_distance() {
    let test = "mpvo_orders_parts_by_their_distance";
    for name in ["heat-sink", "torus"] {
        compare(test, name, 3000, Order::Mpvo, MISORDERED);
    }
}

#[test]
fn sorting_in_each_pixel_is_exact_in_any_mesh() {
    let test = "sorting_in_each_pixel_is_exact_in_any_mesh";
    for name in ["sphere", "orbital", "heat-sink", "torus", "graded"] {
        compare(test, name, 3000, Order::PerPixel, EXACT);
    }
}

#[test]
fn mpvo_is_exact_in_convex_meshes() {
    let test = "mpvo_is_exact_in_convex_meshes";
    for name in ["sphere", "orbital", "graded"] {
        compare(test, name, 3000, Order::Mpvo, EXACT);
    }
}

/// A ring of tetrahedra, each sharing faces with the next two, whose shared faces all
/// lean the same way: from +z each cell hides the next, all around.
fn leaning_ring() -> Volume {
    let count = 36_u32;
    let points = (0..count).map(|i| {
        let around = f64::from(i) * std::f64::consts::TAU / 3.0;
        let (z, out) = around.sin_cos();
        let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU + 0.3 * z;
        DVec3::new((3.0 + out) * angle.cos(), (3.0 + out) * angle.sin(), z)
    });
    let points: Vec<DVec3> = points.collect();
    let cells = (0..count).map(|i| [0, 1, 2, 3].map(|k| (i + k) % count));
    let cells: Vec<[u32; 4]> = cells.collect();
    let scalars = testing::point_scalars((0..count).map(|i| f64::from(i % 7) / 6.0).collect());
    Volume::Mesh(TetMesh::from_tetrahedra(points, cells, scalars).expect("a valid mesh"))
}

#[test]
fn cycles_are_counted_and_sorting_in_each_pixel_has_none() {
    let Some(gpu) = testing::gpu("cycles_are_counted_and_sorting_in_each_pixel_has_none") else {
        return;
    };
    let volume = leaning_ring();
    let knot = |scalar, color, extinction| Knot {
        scalar,
        color,
        extinction,
    };
    let knots = vec![knot(0.0, DVec3::X, 0.5), knot(1.0, DVec3::Y, 2.0)];
    let appearance = Appearance::new(
        TransferFunction::new(knots).expect("two knots"),
        OpticalModel::EmissionAbsorption,
    );
    let view = View {
        camera: Camera::fit(&volume.bounds(), CameraFit::PlusZ, true, 1.0),
        width: 96,
        height: 96,
        background: [0.0; 4],
    };
    let truth = truth(&volume, &appearance, &view);
    let drawn = |order| {
        let options = ProjectionOptions {
            order,
            ..ProjectionOptions::default()
        };
        let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
        renderer.render(&view).expect("a picture")
    };
    let mpvo = drawn(Order::Mpvo);
    assert!(
        mpvo.stats.get(VISIBILITY_CYCLES) > Some(0),
        "{:?}",
        mpvo.stats
    );
    assert_eq!(
        mpvo.pixels,
        drawn(Order::Mpvo).pixels,
        "broken at one place"
    );
    let exact = between(&drawn(Order::PerPixel), &truth);
    let (rmse, worst) = EXACT;
    assert!(exact.0 <= rmse && exact.1 <= worst, "{exact:?}");
    // Somewhere a cell that is drawn too late shows: the test can tell.
    let (_, broken) = between(&mpvo, &truth);
    assert!(broken > worst, "{broken:e}");
}

#[test]
fn tiles_lose_no_fragment() {
    let Some(gpu) = testing::gpu("tiles_lose_no_fragment") else {
        return;
    };
    let (volume, transfer_function) = scene("torus", 1000);
    let appearance = Appearance::new(transfer_function, OpticalModel::EmissionAbsorption);
    let view = views(&volume)[0].1;
    let drawn = |fragment_bytes| {
        let options = ProjectionOptions {
            order: Order::PerPixel,
            fragment_bytes,
            ..ProjectionOptions::default()
        };
        let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
        renderer.render(&view)
    };
    let whole = drawn(1 << 28).expect("a picture");
    // The vertices; one tile, two passes; and the resolve pass.
    assert_eq!(whole.stats.passes, 4);
    // Rows of some hundred pixels, and parts of rows.
    for bytes in [24 * 5000, 24 * 600] {
        let tiled = drawn(bytes).expect("a picture");
        assert!(tiled.stats.passes > 10, "{}", tiled.stats.passes);
        assert_eq!(
            tiled.stats.get(FRAGMENTS_SORTED),
            whole.stats.get(FRAGMENTS_SORTED)
        );
        // The same fragments in the same order: the same bits.
        assert_eq!(tiled.pixels, whole.pixels);
    }
    let error = drawn(24).expect_err("pixels have more than one fragment");
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

/// A cube of n³ smaller ones, six tetrahedra each around a diagonal (Kuhn), with one
/// scalar everywhere.
fn homogeneous(n: usize, keep: impl Fn([usize; 3]) -> bool) -> Volume {
    Volume::Mesh(mesh(kuhn(n, DVec3::ZERO, DVec3::ONE, keep), |_| 1.0))
}

fn constant(extinction: f64, optical_model: OpticalModel) -> Appearance {
    let knot = Knot {
        scalar: 1.0,
        color: DVec3::new(0.5, 1.0, 0.25),
        extinction,
    };
    Appearance::new(
        TransferFunction::new(vec![knot]).expect("one knot"),
        optical_model,
    )
}

// Uniform σ: α = 1 − e^(−σ l) on a chord of length l, whatever the cells. A pixel that a
// shared face covers twice, or not at all, would be off by a cell's part.
#[test]
fn shared_faces_leave_no_seams() {
    let Some(gpu) = testing::gpu("shared_faces_leave_no_seams") else {
        return;
    };
    let volume = homogeneous(8, |_| true);
    for model in [OpticalModel::EmissionAbsorption, OpticalModel::Absorption] {
        let appearance = constant(2.0, model);
        // 64 pixels over 8 cubes: every boundary between cells lies on a pixel's
        // border, and with 72 on its center.
        for size in [64, 72, 72 + 1] {
            let camera = Camera {
                position: DVec3::new(0.5, 0.5, 3.0),
                focal_point: DVec3::splat(0.5),
                view_up: DVec3::Y,
                projection: Projection::Orthographic {
                    parallel_scale: 0.5,
                },
            };
            let view = View {
                camera,
                width: size,
                height: size,
                background: [0.0; 4],
            };
            let frame = drawn(&gpu, &volume, &appearance, &view, &Default::default());
            let expected = -(-2.0_f64).exp_m1();
            for (i, pixel) in frame.pixels.iter().enumerate() {
                // 24 cells at most on a ray, each off by less than 2⁻²² of its depth.
                let off = (f64::from(pixel[3]) - expected).abs();
                assert!(off < 2e-6, "{model:?}: pixel {i} of {size}²: {}", pixel[3]);
            }
        }
    }
}

// The cube's middle third is missing: chords there are 1 − 1/3.
#[test]
fn holes_are_left_out() {
    let Some(gpu) = testing::gpu("holes_are_left_out") else {
        return;
    };
    let volume = homogeneous(3, |cube| cube != [1, 1, 1]);
    let camera = Camera::fit(&volume.bounds(), CameraFit::PlusZ, true, 1.0);
    let view = View {
        camera,
        width: 63,
        height: 63,
        background: [0.0; 4],
    };
    let frame = drawn(
        &gpu,
        &volume,
        &constant(1.0, OpticalModel::Absorption),
        &view,
        &Default::default(),
    );
    let alpha = |column, row| f64::from(frame.pixel(column, row)[3]);
    assert!((alpha(31, 31) + (-2.0_f64 / 3.0).exp_m1()).abs() < 1e-6);
    // Beside the hole: a third of the cube is 12 pixels of its √3-times wider image.
    assert!((alpha(31 + 9, 31) + (-1.0_f64).exp_m1()).abs() < 1e-6);
    assert_eq!(alpha(0, 0), 0.0);
}

// σ l with the eye in the middle of a unit cube: l = 1/2 straight ahead.
#[test]
fn a_cell_around_the_eye_starts_at_the_eye() {
    let Some(gpu) = testing::gpu("a_cell_around_the_eye_starts_at_the_eye") else {
        return;
    };
    let volume = homogeneous(1, |_| true);
    let camera = Camera {
        position: DVec3::splat(0.5),
        focal_point: DVec3::new(0.5, 0.5, 0.0),
        view_up: DVec3::Y,
        projection: Projection::Perspective { view_angle: 60.0 },
    };
    let view = View {
        camera,
        width: 65,
        height: 65,
        background: [0.0; 4],
    };
    let appearance = constant(1.0, OpticalModel::EmissionAbsorption);
    let frame = drawn(&gpu, &volume, &appearance, &view, &Default::default());
    for (column, row) in [(32, 32), (0, 0), (64, 7), (11, 50)] {
        let ray = view.ray(column, row);
        // All of these rays leave through the face z = 0.
        let chord = 0.5 / -ray.direction.z;
        let off = f64::from(frame.pixel(column, row)[3]) + (-chord).exp_m1();
        assert!(off.abs() < 2e-6, "({column}, {row}): {off:e}");
    }
}

#[test]
fn what_is_left_out_is_counted() {
    let Some(gpu) = testing::gpu("what_is_left_out_is_counted") else {
        return;
    };
    let (volume, transfer_function) = scene("sphere", 3000);
    let cells = volume.cell_count() as u64;
    let Volume::Mesh(mesh) = &volume else {
        panic!("the sphere is a mesh");
    };
    let view = views(&volume)[0].1;
    let mut appearance = Appearance::new(transfer_function, OpticalModel::EmissionAbsorption);
    let options = ProjectionOptions {
        order: Order::Centroid,
        sort: Sort::Gpu,
        ..ProjectionOptions::default()
    };
    let mut renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
    let tf = &appearance.transfer_function;
    let shows = |cell| {
        let s = mesh.cell_scalars(cell);
        let (low, high) = (
            s.into_iter().fold(s[0], f64::min),
            s.into_iter().fold(s[0], f64::max),
        );
        tf.max_extinction(low, high) > 0.0
    };
    let shown = (0..mesh.cell_count()).filter(|c| shows(*c)).count() as u64;
    assert!(
        0 < shown && shown < cells,
        "the scene hides some cells and shows some"
    );
    let stats = renderer.render(&view).expect("a picture").stats;
    assert_eq!(stats.get(CELLS_DRAWN), Some(shown));
    assert_eq!(stats.get(CELLS_SKIPPED), Some(cells - shown));
    assert_eq!(stats.get(CELLS_SORTED), Some(shown));
    assert_eq!(stats.passes, 4);
    // Four indices and a range a cell, four numbers per vertex as it is and as the eye sees
    // it, and for each of one or two pieces a cell: what it is of, its index, and two keys
    // and two values to sort it. The last row of vertices and small tables are left out.
    let vertices = mesh.points().len() as u64;
    let of_mesh = 20 * cells + 32 * vertices;
    let tables = 16 * 2048 + 16 * 768 + 8192;
    let bytes = of_mesh + 28 * shown..of_mesh + 56 * shown + tables;
    assert!(
        bytes.contains(&stats.bytes_resident),
        "{} not in {bytes:?}",
        stats.bytes_resident
    );

    appearance.optical_model = OpticalModel::Absorption;
    renderer.restyle(&appearance).expect("it fits");
    let stats = renderer.render(&view).expect("a picture").stats;
    assert_eq!((stats.get(CELLS_SORTED), stats.passes), (Some(0), 3));

    // No cell has a scalar.
    let mut scalars = mesh.scalars().clone();
    scalars.values.fill(f64::NAN);
    let blank = Volume::Mesh(mesh.with_scalars(scalars).expect("as many values"));
    renderer.reload(&blank).expect("it fits");
    let frame = renderer.render(&view).expect("a picture");
    assert_eq!(
        (frame.stats.get(CELLS_DRAWN), frame.stats.get(CELLS_SKIPPED)),
        (Some(0), Some(cells))
    );
    let background = view.premultiplied_background().map(|c| c as f32);
    assert!(frame.pixels.iter().all(|p| *p == background));
}

// Target of the layout of shared vertices: at most 64 bytes per cell, all of them whatever
// the view.
#[test]
fn a_cell_takes_at_most_64_bytes() {
    let Some(gpu) = testing::gpu("a_cell_takes_at_most_64_bytes") else {
        return;
    };
    for name in ["sphere", "heat-sink", "orbital"] {
        let (volume, transfer_function) = scene(name, 30_000);
        let view = crooked(&volume, false, 16);
        for model in OpticalModel::VOLUMETRIC {
            let appearance = Appearance::new(transfer_function.clone(), model);
            for (order, _) in Order::ALL.map(|(word, order)| (order, word)) {
                for sort in [Sort::Gpu, Sort::Cpu] {
                    let options = ProjectionOptions {
                        order,
                        sort,
                        ..ProjectionOptions::default()
                    };
                    let stats = drawn(&gpu, &volume, &appearance, &view, &options).stats;
                    let per_view = stats.get(BYTES_PER_VIEW).expect("counted");
                    let lasting = stats.bytes_resident - per_view;
                    let a_cell = |bytes: u64| bytes as f64 / volume.cell_count() as f64;
                    let [lasting, per_view] = [lasting, per_view].map(a_cell);
                    eprintln!("{name} {model:?} {order:?}: {lasting:.1} and {per_view:.1}");
                    assert!(lasting <= 64.0, "{name} {model:?} {order:?}: {lasting}");
                    // 16 bytes per vertex, and two keys and two values for each of two pieces.
                    assert!(0.0 < per_view && per_view <= 8.0 + 32.0, "{per_view}");
                }
            }
        }
    }
}

#[test]
fn a_changed_renderer_draws_like_a_new_one() {
    let Some(gpu) = testing::gpu("a_changed_renderer_draws_like_a_new_one") else {
        return;
    };
    let (volume, transfer_function) = scene("sphere", 1000);
    let view = views(&volume)[0].1;
    let first = constant(1.0, OpticalModel::Emission);
    let options = ProjectionOptions::default();
    let mut renderer = CellProjection::new(&gpu, &volume, &first, &options).expect("it fits");
    // From a model that is not sorted to one that is.
    let second = Appearance::new(transfer_function, OpticalModel::EmissionAbsorption);
    renderer.restyle(&second).expect("it fits");
    let changed = renderer.render(&view).expect("a picture");
    // Scalars kept their map of the first transfer function: rounded elsewhere, by
    // 2⁻²⁴ of a width like that of the second.
    let (rmse, _) = between(
        &changed,
        &drawn(&gpu, &volume, &second, &view, &Default::default()),
    );
    assert!(rmse < 1e-6, "{rmse:e}");

    let (other, _) = scene("torus", 500);
    renderer.reload(&other).expect("it fits");
    let view = views(&other)[0].1;
    let changed = renderer.render(&view).expect("a picture");
    let (rmse, _) = between(
        &changed,
        &drawn(&gpu, &other, &second, &view, &Default::default()),
    );
    assert!(rmse < 1e-6, "{rmse:e}");
}

#[test]
fn the_callers_texture_gets_the_same_picture() {
    let Some(gpu) = testing::gpu("the_callers_texture_gets_the_same_picture") else {
        return;
    };
    // The application's device, its encoder, its texture and format.
    let gpu = Gpu::from_device(gpu.device().clone(), gpu.queue().clone());
    let volume = homogeneous(2, |_| true);
    let view = views(&volume)[0].1;
    let appearance = constant(3.0, OpticalModel::EmissionAbsorption);
    let options = ProjectionOptions::default();
    let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let size = (view.width, view.height);
    let texture = gpu.texture(
        "the application's",
        size,
        wgpu::TextureFormat::Rgba8Unorm,
        usage,
    );
    let texture = texture.expect("it fits");
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let target = texture.create_view(&Default::default());
    let target = Target::new(&target, texture.format());
    let recorded = renderer.encode(&mut encoder, &view, &target);
    let copy = read_back(&gpu, &mut encoder, Source::Texture(&texture)).expect("a copy");
    gpu.finish(encoder).expect("nothing can fail");
    let bytes: Vec<[u8; 4]> = copy.read().expect("readable");
    let frame = renderer.render(&view).expect("a picture");
    let stats = recorded.expect("recorded").statistics().expect("counted");
    assert_eq!(stats.get(CELLS_DRAWN), frame.stats.get(CELLS_DRAWN));
    for (byte, pixel) in bytes.iter().zip(&frame.pixels) {
        for (b, p) in byte.iter().zip(pixel) {
            assert!(
                (f32::from(*b) - 255.0 * p).abs() <= 0.51,
                "{byte:?} {pixel:?}"
            );
        }
    }
}

#[test]
fn what_it_cannot_draw_is_refused() {
    let Some(gpu) = testing::gpu("what_it_cannot_draw_is_refused") else {
        return;
    };
    let appearance = constant(1.0, OpticalModel::Emission);
    let volume = homogeneous(1, |_| true);
    let options = ProjectionOptions {
        order: Order::Unsorted,
        ..ProjectionOptions::default()
    };
    let renderer = CellProjection::new(&gpu, &volume, &appearance, &options).expect("it fits");
    let mut view = views(&volume)[0].1;
    view.width = gpu.limits().max_texture_dimension_2d + 1;
    let error = renderer.render(&view).expect_err("no texture is so wide");
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    view.width = 0;
    let error = renderer.render(&view).expect_err("no pixels");
    assert!(matches!(error, Error::Invalid { .. }), "{error}");
}
