//! One step per pass, as published, against one dispatch.

use tetrascope_core::glam::{DVec2, DVec3};
use tetrascope_core::mesh::{Association, FACES};
use tetrascope_core::{
    Appearance, CameraFit, ClipPlane, DepthCue, Error, Frame, Knot, OpticalModel, Projection,
    Scalars, TransferFunction, View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_raycast_peel::counters::{
    FRAGMENTS, LAYERS, LEAST_TILE_PASSES, LOST_RAYS, MOST_TILE_PASSES, TILES_DRAWN, TILES_SKIPPED,
};
use tetrascope_raycast_peel::{Crossings, Passes, RaycastOptions, RaycastPeel};
use tetrascope_testing::{
    self as testing, ImageError, cells, cutting, exactly, fitted, inside, ramp, split,
    stacked_plates, truth, view,
};

use crate::common::{draw, scene};

const SIDE: u32 = 40;

fn ping_pong() -> RaycastOptions {
    RaycastOptions {
        passes: Passes::PingPong,
        ..RaycastOptions::default()
    }
}

/// With the published planes and bias.
fn by_planes() -> RaycastOptions {
    RaycastOptions {
        crossings: Crossings::Planes,
        ..ping_pong()
    }
}

/// RMSE over the pixels that are not listed, and the pixels that differ by more than
/// `outlier` in a channel.
pub(crate) fn difference(a: &Frame, b: &Frame, outlier: f64) -> (f64, Vec<usize>) {
    let mut outliers = Vec::new();
    let mut sum = 0.0;
    for (pixel, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        let errors = [0, 1, 2, 3].map(|c| f64::from(a[c] - b[c]).abs());
        if errors.iter().any(|&e| e > outlier) {
            outliers.push(pixel);
        } else {
            sum += errors.iter().map(|e| e * e).sum::<f64>();
        }
    }
    ((sum / (4 * a.pixels.len()) as f64).sqrt(), outliers)
}

/// The distance from a pixel's center to the nearest edge of the boundary on the
/// image, pixels.
fn distance_to_edge(volume: &Volume, view: &View, pixel: usize) -> f64 {
    let Volume::Mesh(mesh) = volume else {
        panic!("a mesh")
    };
    let (right, up, forward) = view.camera.axes();
    let side = f64::from(view.width);
    let on_image = |point: DVec3| {
        let p = point - view.camera.position;
        let half = match view.camera.projection {
            Projection::Perspective { view_angle } => {
                let depth = p.dot(forward);
                if depth <= 0.0 {
                    return None;
                }
                depth * (view_angle.to_radians() / 2.0).tan()
            }
            Projection::Orthographic { parallel_scale } => parallel_scale,
        };
        let x = p.dot(right) / half;
        let y = -p.dot(up) / half;
        Some((DVec2::new(x, y) + 1.0) * side / 2.0)
    };
    let center = DVec2::new(
        (pixel % view.width as usize) as f64,
        (pixel / view.width as usize) as f64,
    ) + 0.5;
    let mut least = f64::INFINITY;
    for &(cell, opposite) in mesh.boundary_faces() {
        let points = mesh.cell_points(cell as usize);
        let corners = FACES[usize::from(opposite)].map(|corner| on_image(points[corner]));
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if let (Some(a), Some(b)) = (corners[a], corners[b]) {
                let along = (center - a).dot(b - a) / (b - a).length_squared().max(1e-30);
                let nearest = a + along.clamp(0.0, 1.0) * (b - a);
                least = least.min(nearest.distance(center));
            }
        }
    }
    least
}

fn views(volume: &Volume) -> Vec<(&'static str, View)> {
    let inside = inside(volume);
    vec![
        (
            "perspective",
            fitted(volume, CameraFit::PlusIso, false, SIDE),
        ),
        (
            "orthographic",
            fitted(volume, CameraFit::MinusIso, true, SIDE),
        ),
        ("inside", view(inside, SIDE)),
        ("orthographic, inside", view(cutting(volume), SIDE)),
    ]
}

/// Both forms integrate in the same way; by planes they differ in where a ray crosses a face: by
/// planes and gradients here, by positive weights there. Either errs by some 2⁻²² of
/// a chord, which steep transfer functions amplify tenfold: 3e-6.
const RMSE: f64 = 1e-5;

/// Beyond this a pixel needs another reason than rounding: a grazing ray's chord errs
/// by 2⁻²² over the sine of its angle.
pub(crate) const OUTLIER: f64 = 3e-4;

/// The bits of a pixel to which rasterizers snap vertices: 8 on llvmpipe and most GPUs, and what
/// Vulkan promises (`subPixelPrecisionBits` among its required limits), 4, which is all that
/// SwiftShader has. Each of an edge's two ends moves by at most half of the grid along x and y,
/// so whether a ray within √½ of the grid of an edge comes in is the rasterizer's guess.
const SNAP_BITS: [i32; 2] = [8, 4];

/// How many times as wide as with 8 bits the rasterizer's grid may be, given outliers that
/// nothing but the grid explains: how far they are from edges says only how wide it is at least,
/// and where 8 bits do not explain them it may be as wide as Vulkan lets it be.
pub(crate) fn grid_width(what: &str, volume: &Volume, view: &View, outliers: &[usize]) -> usize {
    let away = outliers.iter();
    let away = away.map(|&pixel| distance_to_edge(volume, view, pixel));
    let away = away.fold(0.0, f64::max);
    let reach = |bits: i32| 0.5f64.sqrt() * 0.5f64.powi(bits);
    let grid = SNAP_BITS.into_iter().find(|bits| away <= reach(*bits));
    let bits = grid.unwrap_or_else(|| panic!("{what}: {away} from an edge"));
    1 << (SNAP_BITS[0] - bits)
}

/// Outliers among 1600 rays, from where many run along the lattice, where the grid has 8
/// bits. The strip along an edge in which rays are outliers is as wide as the grid.
const OUTLIERS: usize = 3;

#[test]
fn by_planes_a_step_a_pass_agrees_but_at_edges() {
    let Some(gpu) = testing::gpu("by_planes_a_step_a_pass_agrees_but_at_edges") else {
        return;
    };
    for (name, cells) in [
        ("sphere", 5000),
        ("heat-sink", 4000),
        ("torus", 4000),
        ("delaunay", 2000),
        ("graded", 3000),
        ("staircase", 23),
    ] {
        let (volume, appearance) = scene(name, cells);
        for model in OpticalModel::VOLUMETRIC {
            let appearance = Appearance {
                optical_model: model,
                ..appearance.clone()
            };
            for (from, view) in views(&volume) {
                let single = RaycastOptions::default();
                let single = draw(&gpu, &volume, &appearance, &single, &view);
                let frame = draw(&gpu, &volume, &appearance, &by_planes(), &view);
                let scale = single
                    .pixels
                    .iter()
                    .flatten()
                    .fold(1.0, |a: f32, b| a.max(*b));
                let outlier = OUTLIER * f64::from(scale);
                let (rmse, outliers) = difference(&single, &frame, outlier);
                let what = format!("{name}, {}, {from}", model.name());
                println!("{what}: rmse {rmse:.1e} of {scale:.1}, outliers {outliers:?}");
                assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{what}");
                assert!(rmse <= RMSE * f64::from(scale), "{what}: {rmse:e}");
                let width = grid_width(&what, &volume, &view, &outliers);
                let most = OUTLIERS * width;
                assert!(outliers.len() <= most, "{what}: {width}, {outliers:?}");
            }
        }
    }
}

/// Where both cross by sides there are no outliers to explain: only sums of some hundred cells
/// are rounded otherwise, by 2⁻²⁴ each, and interpolations at the eye.
#[test]
fn by_sides_a_step_a_pass_is_one_dispatch() {
    let test = "by_sides_a_step_a_pass_is_one_dispatch";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let mut scenes: Vec<_> = [
        ("heat-sink", 2000),
        ("torus", 2000),
        ("delaunay", 1000),
        ("graded", 2000),
        ("staircase", 23),
    ]
    .map(|(name, cells)| (name, scene(name, cells)))
    .into();
    let (volume, appearance) = scene("sphere", 1000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a mesh")
    };
    let with = |association, values| {
        let name = "s".into();
        let scalars = Scalars {
            name,
            association,
            values,
        };
        Volume::Mesh(mesh.with_scalars(scalars).expect("as many values"))
    };
    let mean = |cell| mesh.cell_scalars(cell).iter().sum::<f64>() / 4.0;
    let per_cell = (0..mesh.cell_count()).map(mean).collect();
    let per_cell = with(Association::Cell, per_cell);
    let mut holes = mesh.scalars().values.clone();
    holes.iter_mut().step_by(17).for_each(|s| *s = f64::NAN);
    let holes = with(Association::Point, holes);
    scenes.push(("cell scalars", (per_cell, appearance.clone())));
    scenes.push(("holes", (holes, appearance)));
    let (staircase, appearance) = scene("staircase", 23);
    let Volume::Mesh(mesh) = &staircase else {
        panic!("a mesh")
    };
    scenes.push(("faces in one place", (split(mesh), appearance)));
    // A flat cell between two pairs that share no diagonal: on its front the scalar is 0 in the
    // middle, on its back 1, and a ray that leaves it may be back by a rounding.
    let top = [[0, 1, 2, 4], [0, 2, 3, 4]];
    let bottom = [[0, 1, 3, 5], [1, 2, 3, 5]];
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let points = [&square[..], &[[0.5, 0.5, 1.0], [0.5, 0.5, -1.0]]].concat();
    let values = [0.0, 1.0, 0.0, 1.0, 0.5, 0.5];
    // Either way round: without a volume none is the wrong one.
    for (name, flat) in [
        ("a flat cell", [1, 0, 2, 3]),
        ("the other way round", [0, 1, 2, 3]),
    ] {
        let saddle = cells(&points, &[&top[..], &[flat], &bottom].concat(), &values);
        let style = ramp(&saddle);
        scenes.push((name, (saddle, style)));
    }
    // Two cells on the same side of the face between them.
    let folded = [[0, 1, 2, 4], [0, 1, 2, 6]];
    let points = [&points[..], &[[0.6, 0.3, 0.4]]].concat();
    let values = [0.0, 1.0, 0.2, 0.9, 0.5, 0.5, 0.7];
    let folded = cells(&points, &folded, &values);
    let style = ramp(&folded);
    scenes.push(("a folded mesh", (folded, style)));
    // Two cells in one place, of which the first is met first.
    let twice = [&square[..3], &points[4..5], &square[..3], &points[4..5]].concat();
    let values = [0.0, 0.2, 0.1, 0.3, 0.9, 1.0, 0.8, 0.7];
    let twice = cells(&twice, &[[0, 1, 2, 3], [4, 5, 6, 7]], &values);
    let style = ramp(&twice);
    scenes.push(("two cells in one place", (twice, style)));
    for (name, (volume, appearance)) in scenes {
        let mut views = views(&volume);
        // Rays pass the mesh hundreds of units from their anchors.
        let mut wide = views[2].1;
        wide.camera.projection = Projection::Perspective { view_angle: 179.9 };
        views.push(("wide", wide));
        for (from, view) in views {
            let single = RaycastOptions::default();
            let single = draw(&gpu, &volume, &appearance, &single, &view);
            let frame = draw(&gpu, &volume, &appearance, &ping_pong(), &view);
            let ImageError { rmse, max, .. } = ImageError::against(&exactly(&single), &frame);
            assert_eq!(frame.stats.get(LOST_RAYS), Some(0), "{name}, {from}");
            if name == "a folded mesh" {
                // A path's cells are seen in its order, and the two forms may begin at
                // different ends of it.
                continue;
            }
            // λ of 573, half a unit over the cosine of 89.95°, is rounded by 2⁻¹⁵ wherever a ray
            // crosses one of some twenty faces.
            let knots = appearance.transfer_function.knots().iter();
            let extinction = knots.fold(0.0, |most: f64, knot| most.max(knot.extinction));
            let unit = volume.bounds().size().max_element(); // at most one is normalized
            let most = match from {
                "wide" => 20.0 * extinction * unit / f64::from(1 << 15),
                _ => 1e-5,
            };
            println!("{name}, {from}: by sides {rmse:.1e}, {max:.1e} of {most:.1e}");
            assert!(max <= most, "{name}, {from}: {max:e}");
            if name == "holes" && from != "wide" {
                // A corner without a scalar and a weight of 1e-5 once made a scalar beyond
                // all intervals, and a loop that had no end. As in `reference.rs`.
                let exact = truth(&volume, &appearance).render_exact(&view);
                let max = ImageError::against(&exact.expect("a frame").pixels, &single).max;
                assert!(max <= 1e-4, "{name}, {from}: {max:e}");
            }
        }
    }
}

#[test]
fn tiles_and_queries_change_work_and_no_pixel() {
    let Some(gpu) = testing::gpu("tiles_and_queries_change_work_and_no_pixel") else {
        return;
    };
    for kind in [ping_pong(), by_planes()] {
        tiles_and_queries(&gpu, kind);
    }
}

fn tiles_and_queries(gpu: &Gpu, kind: RaycastOptions) {
    let (volume, appearance) = scene("torus", 2000);
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let with = |tiles, query_interval| {
        let options = RaycastOptions {
            tiles,
            query_interval,
            ..kind
        };
        draw(gpu, &volume, &appearance, &options, &view)
    };
    let whole = with(1, 1);
    let pixels = u64::from(SIDE * SIDE);
    let [least, most] = tile_passes(&whole);
    assert!(least == most && whole.stats.get(FRAGMENTS) == Some(pixels * most));
    assert_eq!(
        (whole.stats.get(TILES_DRAWN), whole.stats.get(TILES_SKIPPED)),
        (Some(1), Some(0))
    );
    for (tiles, interval) in [(1, 7), (3, 1), (8, 1), (8, 5)] {
        let frame = with(tiles, interval);
        assert!(frame.pixels == whole.pixels, "{tiles} {interval}");
        let [least, longest] = tile_passes(&frame);
        assert!(longest >= most && longest < most + u64::from(interval));
        if tiles == 8 {
            // The corners and the hole show nothing; the rim is done before the middle.
            assert!(
                frame.stats.get(TILES_SKIPPED) >= Some(4),
                "{:?}",
                frame.stats
            );
            assert!(least < longest);
            let drawn = frame.stats.get(TILES_DRAWN).expect("counted");
            let tile = pixels / 64;
            let fragments = frame.stats.get(FRAGMENTS).expect("counted");
            // Each tile drawn took between `least` and `longest` steps, and not all the most.
            assert!(fragments >= drawn * tile * least && fragments < drawn * tile * longest);
        }
    }
}

/// The least and the greatest number of steps' passes among the tiles drawn.
fn tile_passes(frame: &Frame) -> [u64; 2] {
    [LEAST_TILE_PASSES, MOST_TILE_PASSES].map(|of| frame.stats.get(of).expect("counted"))
}

/// The passes that are recorded beside steps: three clears, the layers' entries with their queries and
/// tallies, and the display.
fn overhead(frame: &Frame, entries: u64) -> u64 {
    3 + 2 * entries + frame.stats.get(LAYERS).expect("counted") + 1
}

#[test]
fn convex_meshes_are_not_peeled() {
    let Some(gpu) = testing::gpu("convex_meshes_are_not_peeled") else {
        return;
    };
    for kind in [ping_pong(), by_planes()] {
        not_peeled(&gpu, kind);
    }
}

fn not_peeled(gpu: &Gpu, kind: RaycastOptions) {
    let (volume, appearance) = scene("sphere", 1000);
    let options = RaycastOptions {
        query_interval: 1,
        ..kind
    };
    let frame = |volume: &Volume, appearance: &Appearance| {
        let view = fitted(volume, CameraFit::PlusIso, true, SIDE);
        draw(gpu, volume, appearance, &options, &view)
    };
    let convex = frame(&volume, &appearance);
    let [_, most] = tile_passes(&convex);
    // A query after every step.
    assert_eq!(convex.stats.get(LAYERS), Some(1));
    assert_eq!(convex.stats.passes, overhead(&convex, 1) + 2 * most);

    let (volume, appearance) = scene("heat-sink", 1000);
    let peeled = frame(&volume, &appearance);
    let layers = peeled.stats.get(LAYERS).expect("counted");
    // One more layer is peeled, and found empty.
    assert!(layers > 1);
    assert!(peeled.stats.passes >= overhead(&peeled, layers + 1));
}

#[test]
fn nothing_to_see_takes_no_step() {
    let Some(gpu) = testing::gpu("nothing_to_see_takes_no_step") else {
        return;
    };
    let (volume, appearance) = scene("heat-sink", 1000);
    let mut view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let away = 2.0 * view.camera.position - view.camera.focal_point;
    view.camera.focal_point = away;
    for kind in [ping_pong(), by_planes()] {
        let frame = draw(&gpu, &volume, &appearance, &kind, &view);
        assert_eq!(frame.stats.get(FRAGMENTS), Some(0));
        assert_eq!(frame.stats.get(TILES_DRAWN), Some(0));
        assert_eq!(frame.stats.get(MOST_TILE_PASSES), None);
        assert_eq!(frame.stats.passes, overhead(&frame, 1));
        let background = view.premultiplied_background().map(|c| c as f32);
        assert!(frame.pixels.iter().all(|p| *p == background));
    }
}

/// The paper's bias of 0.1 is 0.0045 of the Blunt Fin's extent: what comes so close behind
/// the last entry is lost. The default resolves it.
#[test]
fn the_papers_bias_hides_what_is_thin() {
    let Some(gpu) = testing::gpu("the_papers_bias_hides_what_is_thin") else {
        return;
    };
    let volume = stacked_plates(2);
    let knot = |scalar| Knot {
        scalar,
        color: DVec3::ONE,
        extinction: 400.0,
    };
    let function = TransferFunction::new(vec![knot(0.0), knot(1.0)]).expect("valid knots");
    let appearance = Appearance::new(function, OpticalModel::Absorption);
    let view = fitted(&volume, CameraFit::PlusZ, true, SIDE);
    let opacity = |peel_bias| {
        let options = RaycastOptions {
            peel_bias,
            ..by_planes()
        };
        let frame = draw(&gpu, &volume, &appearance, &options, &view);
        let center = frame.pixel(SIDE / 2 + 1, SIDE / 2 - 3)[3];
        // Over a background of one half.
        (f64::from(center), frame.stats.get(LAYERS))
    };
    let expected = |plates: f64| 1.0 - 0.5 * (-400.0 * 0.0008 * plates).exp();
    let (both, layers) = opacity(RaycastOptions::default().peel_bias);
    // Places on a ray are known to 2⁻²² of half an extent, of four faces.
    let close = 400.0 * 4.0 / f64::from(1 << 22);
    assert!((both - expected(2.0)).abs() < close, "{both}");
    assert_eq!(layers, Some(2));
    let (one, layers) = opacity(0.0045);
    assert!((one - expected(1.0)).abs() < close, "{one}");
    assert_eq!(layers, Some(1));
}

#[test]
fn rays_stop_at_the_papers_opacity() {
    let Some(gpu) = testing::gpu("rays_stop_at_the_papers_opacity") else {
        return;
    };
    let (volume, mut appearance) = scene("sphere", 3000);
    let knots = appearance.transfer_function.knots().iter().map(|k| Knot {
        extinction: 4.0 * k.extinction,
        ..*k
    });
    appearance.transfer_function = TransferFunction::new(knots.collect()).expect("valid knots");
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    for kind in [ping_pong(), by_planes()] {
        stop(&gpu, &volume, &appearance, &view, kind);
    }
}

fn stop(gpu: &Gpu, volume: &Volume, appearance: &Appearance, view: &View, kind: RaycastOptions) {
    let with = |stop_opacity| {
        let options = RaycastOptions {
            stop_opacity,
            query_interval: 1,
            ..kind
        };
        draw(gpu, volume, appearance, &options, view)
    };
    let (exact, stopped) = (with(1.0), with(0.95));
    let pairs = exact
        .pixels
        .iter()
        .flatten()
        .zip(stopped.pixels.iter().flatten());
    let worst = pairs.fold(0.0, |w: f32, (a, b)| w.max((a - b).abs()));
    // Colors are at most 1 here, so what is hidden is at most what shines through.
    assert!(worst > 0.0 && worst <= 0.05, "{worst}");
    assert!(stopped.stats.get(FRAGMENTS) < exact.stats.get(FRAGMENTS));
    assert_eq!(stopped.stats.get(LOST_RAYS), Some(0));
}

#[test]
fn a_mesh_takes_144_bytes_a_cell_and_by_sides_96() {
    let Some(gpu) = testing::gpu("a_mesh_takes_144_bytes_a_cell_and_by_sides_96") else {
        return;
    };
    let (volume, appearance) = scene("sphere", 5000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a mesh")
    };
    let renderer = RaycastPeel::new(&gpu, &volume, &appearance, &by_planes()).expect("a mesh");
    // And three corners of 20 bytes per boundary face, and a handful of intervals; the
    // last row of the textures may have room for more cells.
    let row = (mesh.cell_count() as f64 / 3.0).sqrt().ceil() as u64;
    let least = 144 * mesh.cell_count() as u64
        + 60 * mesh.boundary_faces().len() as u64
        + 48 * (appearance.transfer_function.knots().len() as u64 + 1);
    let bytes = renderer.bytes_resident();
    assert!(
        bytes >= least && bytes < least + 144 * row,
        "{bytes} {least}"
    );
    // No normals but for one texel; a boundary face is its cell and its opposite corner.
    let renderer = RaycastPeel::new(&gpu, &volume, &appearance, &ping_pong()).expect("a mesh");
    let faces = mesh.boundary_faces().len() as u64;
    let least = least - 48 * (mesh.cell_count() as u64 + faces);
    let bytes = renderer.bytes_resident();
    assert!(
        bytes >= least && bytes < least + 96 * row + 16,
        "{bytes} {least}"
    );
}

#[test]
fn new_scalars_and_styles_give_what_a_new_renderer_gives() {
    let Some(gpu) = testing::gpu("new_scalars_and_styles_give_what_a_new_renderer_gives") else {
        return;
    };
    for kind in [ping_pong(), by_planes()] {
        new_scalars(&gpu, kind);
    }
}

fn new_scalars(gpu: &Gpu, kind: RaycastOptions) {
    let (volume, appearance) = scene("heat-sink", 1000);
    let Volume::Mesh(mesh) = &volume else {
        panic!("a mesh")
    };
    let view = fitted(&volume, CameraFit::PlusIso, false, SIDE);
    let mut renderer = RaycastPeel::new(gpu, &volume, &appearance, &kind).expect("a mesh");
    let mut check = |volume: &Volume, appearance: &Appearance, what: &str| {
        renderer.reload(volume).expect("a mesh");
        renderer.restyle(appearance).expect("a style");
        let frame = renderer.render(&view).expect("a frame");
        let new = draw(gpu, volume, appearance, &kind, &view);
        assert!(frame.pixels == new.pixels, "{what}");
    };
    let field = |association, values| Scalars {
        name: "s".into(),
        association,
        values,
    };
    let values = mesh.scalars().values.iter().map(|s| 130.0 - s).collect();
    let turned = mesh
        .with_scalars(field(Association::Point, values))
        .expect("as many values");
    check(&Volume::Mesh(turned), &appearance, "scalars");
    let values = (0..mesh.cell_count()).map(|c| 60.0 * c as f64 / mesh.cell_count() as f64);
    let cells = field(Association::Cell, values.collect());
    let per_cell = mesh.with_scalars(cells).expect("as many values");
    let emission = Appearance {
        optical_model: OpticalModel::Emission,
        ..appearance.clone()
    };
    check(&Volume::Mesh(per_cell), &emission, "association and style");
    let (sphere, _) = scene("sphere", 700);
    check(&sphere, &emission, "geometry");
}

#[test]
fn what_makes_no_sense_is_refused() {
    let Some(gpu) = testing::gpu("what_makes_no_sense_is_refused") else {
        return;
    };
    let (volume, appearance) = scene("sphere", 100);
    let defaults = ping_pong();
    for options in [
        RaycastOptions {
            tiles: 0,
            ..defaults
        },
        RaycastOptions {
            tiles: 9,
            ..defaults
        },
        RaycastOptions {
            query_interval: 0,
            ..defaults
        },
        RaycastOptions {
            stop_opacity: 0.0,
            ..defaults
        },
        RaycastOptions {
            stop_opacity: f32::NAN,
            ..defaults
        },
        RaycastOptions {
            peel_bias: -1.0,
            ..defaults
        },
        RaycastOptions {
            peel_bias: f32::INFINITY,
            ..defaults
        },
    ] {
        let refused = RaycastPeel::new(&gpu, &volume, &appearance, &options);
        assert!(matches!(refused, Err(Error::Invalid { .. })), "{options:?}");
    }
    let surfaces = Appearance {
        optical_model: OpticalModel::Isosurfaces,
        ..appearance.clone()
    };
    let cued = Appearance {
        depth_cue: Some(DepthCue { strength: 0.5 }),
        ..appearance.clone()
    };
    let clipped = Appearance {
        clip_planes: vec![ClipPlane {
            point: DVec3::ZERO,
            normal: DVec3::X,
        }],
        ..appearance.clone()
    };
    let mut drawn = RaycastPeel::new(&gpu, &volume, &appearance, &defaults).expect("a mesh");
    for (what, refused) in [
        ("isosurfaces", surfaces),
        ("a depth cue", cued),
        ("clip planes", clipped),
    ] {
        let message = format!(
            "raycast-peel does not draw {what} with passes=ping-pong: that is as published, with \
             the volumetric models alone; passes=single has it"
        );
        let new = RaycastPeel::new(&gpu, &volume, &refused, &defaults).expect_err("unsupported");
        assert_eq!(new.to_string(), message);
        assert_eq!(
            drawn
                .restyle(&refused)
                .expect_err("unsupported")
                .to_string(),
            message
        );
        let single = RaycastOptions::default();
        assert!(RaycastPeel::new(&gpu, &volume, &refused, &single).is_ok());
    }
}
