//! Orders that know whether they are right, and lists longer than one turn sorts.

use std::f64::consts::TAU;
use tetrascope_core::Unit as _;

use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::{Cells, FACES};
use tetrascope_core::{
    Appearance, Camera, Error, Frame, Knot, OpticalModel, Projection, TetMesh, TransferFunction,
    View, Volume, VolumeRenderer as _,
};
use tetrascope_gpu::Gpu;
use tetrascope_projection::counters::{FRAGMENTS_SORTED, LOST_RAYS, VISIBILITY_CYCLES};
use tetrascope_projection::{CellProjection, Order, ProjectionOptions};
use tetrascope_testing::{self as testing, between, point_scalars, split, tetrahedra_of};

use crate::common::{crooked, drawn, mesh, truth};

/// The meaning of a promise to be exact (`limits.rs` of xtask derives it): RMSE and the
/// greatest difference.
const PROMISED: (f64, f64) = (3e-6, 3e-4);

fn with_order(order: Order) -> ProjectionOptions {
    ProjectionOptions {
        order,
        ..ProjectionOptions::default()
    }
}

/// Two colors and an opacity with which an order shows: some 3 depths across the mesh.
fn look(volume: &Volume) -> Appearance {
    let (low, high) = volume.scalar_range().expect("numbers");
    let knot = |share: f64, color, depth: f64| Knot {
        scalar: low + share * (high - low),
        color,
        extinction: depth / volume.bounds().diagonal(),
    };
    let red = DVec3::new(0.9, 0.2, 0.1);
    let blue = DVec3::new(0.1, 0.3, 0.9);
    let knots = vec![knot(0.0, red, 2.0), knot(1.0, blue, 4.0)];
    let function = TransferFunction::new(knots).expect("sorted");
    Appearance::new(function, OpticalModel::EmissionAbsorption)
}

fn of(points: Vec<DVec3>, cells: Vec<[u32; 4]>, scalar: impl Fn(usize, DVec3) -> f64) -> Volume {
    let values = points.iter().enumerate().map(|(i, p)| scalar(i, *p));
    let scalars = point_scalars(values.collect());
    Volume::Mesh(TetMesh::from_tetrahedra(points, cells, scalars).expect("a valid mesh"))
}

/// A cube without its middle: not convex, and rays leave it and come back.
fn hollow() -> Volume {
    lattice(5, |at| at.iter().any(|i| *i != 2), 0.0, 1)
}

/// Cubes of a box of side `n` that `keep` accepts; points inside are moved by up to
/// `shift`, and numbered at random, by which cubes are cut.
fn lattice(n: usize, keep: impl Fn([usize; 3]) -> bool, shift: f64, seed: u64) -> Volume {
    let mut state = seed;
    let mut random = move || {
        // Numerical Recipes' generator; the upper bits are good.
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let side = n + 1;
    let at = |i: usize, n: usize| [i % n, i / n % n, i / (n * n)];
    let mut points: Vec<DVec3> = (0..side * side * side)
        .map(|i| {
            DVec3::from_array(at(i, side).map(|i| match 0 < i && i < n {
                true => i as f64 + shift * (2.0 * random() - 1.0),
                false => i as f64,
            }))
        })
        .collect();
    let mut numbers: Vec<usize> = (0..points.len()).collect();
    for last in (1..numbers.len()).rev() {
        numbers.swap(last, (random() * (last + 1) as f64) as usize);
    }
    let mut placed = points.clone();
    for (point, &number) in points.iter().zip(&numbers) {
        placed[number] = *point;
    }
    points = placed;
    let mut cells = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    for [i, j, k] in (0..n * n * n).map(|c| at(c, n)).filter(|at| keep(*at)) {
        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]];
        for up in [0, 1] {
            let corner = |[x, y]: [usize; 2]| i + x + side * (j + y + side * (k + up));
            let corners = ring.map(|xy| numbers[corner(xy)] as u64);
            cells.connectivity.extend(corners);
        }
        cells.types.push(12);
        cells.offsets.push(cells.connectivity.len() as u64);
    }
    let values = points
        .iter()
        .map(|p| (3.0 * p.x).sin() + p.y * 0.3 - 0.2 * p.z);
    let scalars = testing::point_scalars(values.collect());
    Volume::Mesh(TetMesh::new(points, &cells, scalars).expect("a valid mesh"))
}

/// Two pyramids on one triangle, which one of them has in four parts: points hang in the
/// middle of the other's edges.
fn hanging() -> Volume {
    let [a, b, c] = [0.0, 1.0, 2.0].map(|i: f64| {
        let (y, x) = (i * TAU / 3.0).sin_cos();
        DVec3::new(x, y, 0.0)
    });
    let (below, above) = (DVec3::new(0.1, 0.0, -1.0), DVec3::new(0.0, 0.2, 1.2));
    let middle = |p: DVec3, q: DVec3| 0.5 * (p + q);
    let points = vec![
        a,
        b,
        c,
        below,
        above,
        middle(a, b),
        middle(b, c),
        middle(c, a),
    ];
    let parts = [[0, 5, 7], [5, 1, 6], [7, 6, 2], [5, 6, 7]];
    let mut cells = vec![[0, 1, 2, 3]];
    cells.extend(parts.map(|[p, q, r]| [p, q, r, 4]));
    of(points, cells, |_, p| p.z + 0.3 * p.x)
}

fn check(what: &str, frame: &Frame, truth: &Frame) {
    let (rmse, most) = between(frame, truth);
    let notes = &frame.stats.notes;
    eprintln!("{what}: RMSE {rmse:.1e}, max {most:.1e}, {notes:?}");
    assert!(
        rmse <= PROMISED.0 && most <= PROMISED.1,
        "{what}: {rmse:e} {most:e}"
    );
}

#[test]
fn the_automatic_order_is_exact_in_any_mesh_and_says_which_it_took() {
    let test = "the_automatic_order_is_exact_in_any_mesh_and_says_which_it_took";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let ball = mesh("sphere", 2000);
    let (apart_ball, apart_hollow) = (split(tetrahedra_of(&ball)), split(tetrahedra_of(&hollow())));
    let by_faces = "cells are sorted by their faces: the mesh is convex";
    let parts = "fragments are sorted in each pixel: the mesh's boundary has 2 parts";
    let cases: [(&str, &Volume, &str); 5] = [
        ("convex", &ball, by_faces),
        ("without common points", &apart_ball, by_faces),
        ("hollow", &hollow(), parts),
        ("hollow, without common points", &apart_hollow, parts),
        ("hanging nodes", &hanging(), parts),
    ];
    for (name, volume, note) in cases {
        let appearance = look(volume);
        for orthographic in [false, true] {
            let view = crooked(volume, orthographic, 96);
            let options = ProjectionOptions::default();
            let frame = drawn(&gpu, volume, &appearance, &view, &options);
            assert_eq!(frame.stats.notes, [note], "{name}");
            assert_eq!(frame.stats.order_proven, Some(true), "{name}");
            check(name, &frame, &truth(volume, &appearance, &view));
        }
        // Nothing is ordered where no order is needed.
        let glow = Appearance {
            optical_model: OpticalModel::Emission,
            ..appearance
        };
        let view = crooked(volume, true, 8);
        let frame = drawn(&gpu, volume, &glow, &view, &ProjectionOptions::default());
        assert_eq!(
            (frame.stats.notes.len(), frame.stats.order_proven),
            (0, None)
        );
    }
}

#[test]
fn an_order_by_faces_says_where_it_may_be_wrong() {
    let Some(gpu) = testing::gpu("an_order_by_faces_says_where_it_may_be_wrong") else {
        return;
    };
    for (volume, note) in [
        (mesh("sphere", 500), None),
        (
            hollow(),
            Some("the order of cells may be wrong: the mesh's boundary has 2 parts"),
        ),
        (
            mesh("torus", 500),
            Some("the order of cells may be wrong: the mesh is not convex"),
        ),
    ] {
        let view = crooked(&volume, false, 32);
        let frame = drawn(
            &gpu,
            &volume,
            &look(&volume),
            &view,
            &with_order(Order::Mpvo),
        );
        assert_eq!(frame.stats.notes.first().map(String::as_str), note);
        assert_eq!(frame.stats.order_proven, Some(note.is_none()));
        for order in [Order::Centroid, Order::Unsorted] {
            let frame = drawn(&gpu, &volume, &look(&volume), &view, &with_order(order));
            assert_eq!(frame.stats.order_proven, Some(false), "{order:?}");
        }
    }
}

/// The same mesh with long thin cells: wherever two that share a face can be cut into three
/// around the line between the points opposite, they are, `rounds` times.
fn flipped(volume: &Volume, rounds: usize) -> Volume {
    let mut mesh = tetrahedra_of(volume).clone();
    for _ in 0..rounds {
        let points = mesh.points();
        let volume_of = |[a, b, c, d]: [u32; 4]| {
            let [a, b, c, d] = [a, b, c, d].map(|p| points[p as usize]);
            (b - a).dot((c - a).cross(d - a))
        };
        let mut gone = vec![false; mesh.cell_count()];
        let mut cells = Vec::new();
        for (cell, neighbors) in mesh.neighbors().iter().enumerate() {
            for (face, &neighbor) in neighbors.iter().enumerate() {
                let Some(other) = mesh.tetrahedra().get(neighbor as usize) else {
                    continue;
                };
                let own = mesh.tetrahedra()[cell];
                let far = other.iter().find(|p| !own.contains(p));
                let far = *far.expect("two cells differ");
                let [a, b, c] = FACES[face].map(|corner| own[corner]);
                // The face is counterclockwise from outside, where `far` is.
                let three = [[a, b], [b, c], [c, a]].map(|[p, q]| [own[face], p, q, far]);
                let fits = three.iter().all(|t| volume_of(*t) > 0.02);
                if fits && !gone[cell] && !gone[neighbor as usize] {
                    (gone[cell], gone[neighbor as usize]) = (true, true);
                    cells.extend(three);
                }
            }
        }
        let kept = mesh
            .tetrahedra()
            .iter()
            .zip(&gone)
            .filter(|(_, gone)| !**gone);
        cells.extend(kept.map(|(cell, _)| *cell));
        let scalars = mesh.scalars().clone();
        let volume = mesh.volume();
        mesh = TetMesh::from_tetrahedra(points.to_vec(), cells, scalars).expect("valid");
        assert!(
            (mesh.volume() - volume).abs() < 1e-9,
            "the cells fill the same space"
        );
    }
    Volume::Mesh(mesh)
}

/// A convex mesh in which cells hide each other in a cycle, from some side.
#[test]
fn a_cycle_in_a_convex_mesh_is_sorted_in_each_pixel() {
    let Some(gpu) = testing::gpu("a_cycle_in_a_convex_mesh_is_sorted_in_each_pixel") else {
        return;
    };
    let volume = flipped(&lattice(5, |_| true, 0.2, 3), 3);
    assert!(tetrahedra_of(&volume).boundary_statistics().convex);
    let appearance = look(&volume);
    let [by_faces, automatic] = [Order::Mpvo, Order::Auto].map(|order| {
        CellProjection::new(&gpu, &volume, &appearance, &with_order(order)).expect("it fits")
    });
    let view = (0..60)
        .map(|i| {
            let turn = f64::from(i);
            let view = crooked(&volume, i % 2 == 0, 64);
            let (sin, cos) = turn.sin_cos();
            let center = volume.bounds().center();
            let away = DVec3::new(cos, sin, (0.7 * turn).sin()).unit();
            let camera = Camera {
                position: center + 3.0 * volume.bounds().diagonal() * away,
                focal_point: center,
                ..view.camera
            };
            View { camera, ..view }
        })
        .find(|view| {
            let small = View {
                width: 8,
                height: 8,
                ..*view
            };
            let stats = by_faces.render(&small).expect("a picture").stats;
            stats.get(VISIBILITY_CYCLES) > Some(0)
        })
        .expect("some side has a cycle");
    let broken = by_faces.render(&view).expect("a picture").stats;
    let note = "the order of cells may be wrong: cells hide each other in a cycle";
    assert_eq!(
        (broken.order_proven, &broken.notes[..]),
        (Some(false), &[note.to_owned()][..])
    );
    // Again: what was made for the first is kept.
    for _ in 0..2 {
        let frame = automatic.render(&view).expect("a picture");
        let note = "fragments are sorted in each pixel: cells hide each other in a cycle";
        assert_eq!(frame.stats.notes, [note]);
        assert_eq!(frame.stats.order_proven, Some(true));
        assert!(frame.stats.get(FRAGMENTS_SORTED) > Some(0));
        check("a cycle", &frame, &truth(&volume, &appearance, &view));
    }
}

/// `count` thin cells behind each other along z, each across the whole picture, numbered at
/// random.
fn stack(count: u32) -> Volume {
    let mut points = Vec::new();
    for i in 0..count {
        // A step coprime to the number: every place once.
        let z = f64::from(u32::try_from(u64::from(i) * 7919 % u64::from(count)).expect("less"));
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let r = 4.0 * f64::from(count);
        points.extend([
            corner(-r, -r, z),
            corner(r, -r, z),
            corner(0.0, r, z),
            corner(0.0, 0.0, z + 0.75),
        ]);
    }
    let cells = (0..count).map(|c| [0, 1, 2, 3].map(|i| 4 * c + i));
    of(points, cells.collect(), |i, _| {
        f64::from((i as u32 / 4) % 5)
    })
}

fn sorted_in_pixels(gpu: &Gpu, volume: &Volume, side: u32) -> (Frame, Frame) {
    let bounds = volume.bounds();
    let camera = Camera {
        position: DVec3::new(0.3, 0.4, 2.0 * bounds.max.z),
        focal_point: DVec3::new(0.3, 0.4, 0.0),
        view_up: DVec3::Y,
        projection: Projection::Orthographic {
            parallel_scale: 0.2 * bounds.max.x,
        },
    };
    let view = View {
        camera,
        width: side,
        height: side,
        background: [0.2, 0.3, 0.1, 0.6],
    };
    let knot = |scalar, color| Knot {
        scalar,
        color,
        // Three depths through all, of which cells fill some three eighths.
        extinction: 8.0 / bounds.size().z,
    };
    let knots = vec![knot(0.0, DVec3::X), knot(4.0, DVec3::new(0.0, 0.6, 1.0))];
    let function = TransferFunction::new(knots).expect("sorted");
    let appearance = Appearance::new(function, OpticalModel::EmissionAbsorption);
    let frame = drawn(
        gpu,
        volume,
        &appearance,
        &view,
        &with_order(Order::PerPixel),
    );
    (frame, truth(volume, &appearance, &view))
}

// n ⌈log₂ n⌉ passes: 10 240 are one turn; 53 248 and 300 000 are more, and the last more than
// the 65 535 after which llvmpipe ends a shader's loops. Cells are 3/4 of their distance deep,
// 2/n of what f32 holds to 2⁻²⁴ of 1: a chord is wrong by n 2⁻²⁴ of itself, the sum of n of
// them by √n less of all, τ = 3: 3 √n 2⁻²⁴ = 2.5e-5 for n = 20 000.
#[test]
fn long_lists_are_sorted_in_turns() {
    let Some(gpu) = testing::gpu("long_lists_are_sorted_in_turns") else {
        return;
    };
    for (count, turns) in [(1024, 1), (4096, 4), (20_000, 19)] {
        let (frame, truth) = sorted_in_pixels(&gpu, &stack(count), 6);
        let (rmse, most) = between(&frame, &truth);
        eprintln!("{count}: RMSE {rmse:.1e}, max {most:.1e}");
        assert_eq!(
            frame.stats.get(FRAGMENTS_SORTED),
            Some(36 * u64::from(count))
        );
        // Vertices and the sum over the background, the fill, and the turns.
        assert_eq!(frame.stats.passes, 3 + turns, "{count}");
        assert_eq!(
            (frame.stats.get(LOST_RAYS), frame.stats.order_proven),
            (Some(0), Some(true))
        );
        assert!(rmse <= 2.5e-5 && most <= 1e-4, "{count}: {rmse:e} {most:e}");
    }
}

/// `layers` cubes on top of each other, 1x1x1 in all, with scalars from 0 to 4.
fn column(layers: u64) -> Volume {
    let ring = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let points: Vec<DVec3> = (0..=layers)
        .flat_map(|layer| ring.map(|[x, y]| DVec3::new(x, y, layer as f64 / layers as f64)))
        .collect();
    let mut cells = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    for layer in 0..layers {
        cells.connectivity.extend(4 * layer..4 * layer + 8);
        cells.types.push(12);
        cells.offsets.push(8 * (layer + 1));
    }
    let scalars = testing::point_scalars((0..points.len()).map(|i| (i * 7 % 5) as f64).collect());
    Volume::Mesh(TetMesh::new(points, &cells, scalars).expect("a valid mesh"))
}

// Each ray passes more cells than the 65 535 after which llvmpipe ends a shader's loops, and
// all touch: n = 75 000 chords err as above by 3 √n 2⁻²⁴ = 5e-5.
#[test]
fn the_cells_of_a_long_column_are_sorted() {
    let Some(gpu) = testing::gpu("the_cells_of_a_long_column_are_sorted") else {
        return;
    };
    let volume = column(25_000);
    let from = DVec3::new(0.55, 0.47, 20.0);
    let view = View {
        camera: Camera {
            position: from,
            focal_point: from - DVec3::new(0.03, -0.02, 20.0),
            view_up: DVec3::Y,
            projection: Projection::Perspective { view_angle: 1.0 },
        },
        width: 2,
        height: 2,
        background: [0.2, 0.3, 0.1, 0.6],
    };
    let appearance = look(&volume);
    let frame = drawn(
        &gpu,
        &volume,
        &appearance,
        &view,
        &with_order(Order::PerPixel),
    );
    let (rmse, most) = between(&frame, &truth(&volume, &appearance, &view));
    let fragments = frame.stats.get(FRAGMENTS_SORTED).expect("counted");
    eprintln!("{fragments} fragments: RMSE {rmse:.1e}, max {most:.1e}");
    assert!(fragments >= 4 * 70_000, "{fragments}");
    assert_eq!(frame.stats.get(LOST_RAYS), Some(0));
    assert!(rmse <= 5e-5 && most <= 2e-4, "{rmse:e} {most:e}");
}

#[test]
#[ignore = "takes minutes in debug builds of the reference; by hand"]
fn a_hundred_thousand_fragments_are_sorted_in_a_pixel() {
    let Some(gpu) = testing::gpu("a_hundred_thousand_fragments_are_sorted_in_a_pixel") else {
        return;
    };
    let (frame, truth) = sorted_in_pixels(&gpu, &stack(100_000), 4);
    let (rmse, most) = between(&frame, &truth);
    eprintln!("RMSE {rmse:.1e}, max {most:.1e}");
    assert_eq!(frame.stats.get(LOST_RAYS), Some(0));
    // As above for n = 100 000.
    assert!(rmse <= 6e-5 && most <= 2.5e-4, "{rmse:e} {most:e}");
}

// A cell in as many intervals as there may be: 16 383 pieces of 3 passes each, 49 149 in a
// fragment, below the 65 535 after which llvmpipe ends a shader's loops.
#[test]
fn a_cell_may_be_in_all_intervals_of_a_long_transfer_function() {
    let test = "a_cell_may_be_in_all_intervals_of_a_long_transfer_function";
    let Some(gpu) = testing::gpu(test) else {
        return;
    };
    let points = vec![DVec3::ZERO, 3.0 * DVec3::X, 2.0 * DVec3::Y, DVec3::Z];
    let volume = of(points, vec![[0, 1, 2, 3]], |i, _| [0.0, 1.0, 0.4, 0.7][i]);
    let view = crooked(&volume, false, 12);
    let look = |knots: u32| {
        let knot = |i: u32| {
            let share = f64::from(i) / f64::from(knots - 1);
            Knot {
                scalar: share,
                color: DVec3::new(share, 0.5 + 0.4 * (40.0 * share).sin(), 1.0 - share),
                extinction: 1.0 + f64::from(i % 2),
            }
        };
        let function = TransferFunction::new((0..knots).map(knot).collect()).expect("sorted");
        Appearance::new(function, OpticalModel::EmissionAbsorption)
    };
    // Pieces of 2⁻¹⁴ of the scalars, which f32 holds to 2⁻²⁴, so each is as long as it should
    // be but for a 2⁻¹⁰th; they err in either direction and there are thousands.
    for knots in [4096, 16_384] {
        let appearance = look(knots);
        for order in [Order::Auto, Order::PerPixel] {
            let frame = drawn(&gpu, &volume, &appearance, &view, &with_order(order));
            let (rmse, most) = between(&frame, &truth(&volume, &appearance, &view));
            eprintln!("{knots} knots, {order:?}: RMSE {rmse:.1e}, max {most:.1e}");
            assert!(
                rmse <= 1e-5 && most <= 1e-4,
                "{knots} {order:?}: {rmse:e} {most:e}"
            );
        }
    }
    let refused = CellProjection::new(&gpu, &volume, &look(16_385), &ProjectionOptions::default());
    let error = refused.expect_err("more than a loop may make");
    assert!(
        matches!(error, Error::TooLarge { limit: 16_384, .. }),
        "{error}"
    );
}

#[test]
fn bodies_in_a_row_are_drawn_in_their_order() {
    let Some(gpu) = testing::gpu("bodies_in_a_row_are_drawn_in_their_order") else {
        return;
    };
    let count = 300;
    let points = (0..count).flat_map(|i| {
        let z = 2.0 * f64::from(i);
        [
            [0.0, 0.0, 0.0],
            [9.0, 0.0, 0.1],
            [0.0, 9.0, 0.3],
            [2.0, 3.0, 1.5],
        ]
        .map(|p| DVec3::from_array(p) + DVec3::new(0.0, 0.0, z))
    });
    let cells = (0..count as u32).map(|c| [0, 1, 2, 3].map(|i| 4 * c + i));
    let volume = of(points.collect(), cells.collect(), |i, _| {
        ((i / 4) % 3) as f64
    });
    let appearance = look(&volume);
    for orthographic in [false, true] {
        let camera = Camera {
            position: DVec3::new(2.6, 2.7, 3000.0),
            focal_point: DVec3::new(2.6, 2.7, 0.0),
            view_up: DVec3::Y,
            projection: match orthographic {
                true => Projection::Orthographic {
                    parallel_scale: 5.0,
                },
                false => Projection::Perspective { view_angle: 0.2 },
            },
        };
        let view = View {
            camera,
            width: 48,
            height: 48,
            background: [0.0; 4],
        };
        let frame = drawn(
            &gpu,
            &volume,
            &appearance,
            &view,
            &ProjectionOptions::default(),
        );
        assert!(frame.stats.get(FRAGMENTS_SORTED) > Some(100_000));
        check("a row", &frame, &truth(&volume, &appearance, &view));
    }
}
