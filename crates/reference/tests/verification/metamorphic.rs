//! Changes that must not change the picture, or must change it in a known way.

use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::{Camera, OpticalModel, Projection, TetMesh, View, Volume};
use tetrascope_reference::{Reference, ReferenceImage, ReferenceOptions};

use crate::scenes::*;

const MODEL: OpticalModel = OpticalModel::EmissionAbsorption;

fn knots() -> Vec<tetrascope_core::Knot> {
    vec![
        knot(0.0, [0.1, 0.4, 0.9], 0.2),
        knot(0.4, [0.9, 0.1, 0.3], 5.0),
        knot(0.5, [0.9, 0.9, 0.3], 0.0),
        knot(1.0, [0.2, 1.0, 0.6], 2.0),
    ]
}

fn wave(p: DVec3) -> f64 {
    0.5 + 0.5 * (5.0 * p.x + 3.0 * p.y - 4.0 * p.z).sin()
}

fn lattice() -> (Vec<DVec3>, Vec<[u32; 4]>) {
    kuhn(5, DVec3::ZERO, DVec3::ONE)
}

fn draw(mesh: &TetMesh, view: &View) -> ReferenceImage {
    let truth = reference(mesh, &appearance(knots(), MODEL));
    truth.render_exact(view).expect("a valid view")
}

fn generic() -> View {
    views(32)[0]
}

/// Both images' bounds hold, so they may differ by their sum.
fn assert_same(a: &ReferenceImage, b: &ReferenceImage) {
    for (i, (p, q)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        for (x, y) in p.iter().zip(q) {
            let bound = a.error_bound[i] + b.error_bound[i];
            assert!(
                (x - y).abs() <= bound,
                "pixel {i}: {p:?} and {q:?}, bound {bound}"
            );
            assert!((x - y).abs() <= 1e-10, "pixel {i}: {p:?} and {q:?}");
        }
    }
}

/// The mesh and the camera, both moved.
fn moved(map: impl Fn(DVec3) -> DVec3, turn: impl Fn(DVec3) -> DVec3) -> (TetMesh, View) {
    let (points, cells) = lattice();
    let values = points.iter().map(|p| wave(*p)).collect();
    let points = points.into_iter().map(&map).collect();
    let mesh = TetMesh::from_tetrahedra(points, cells, point_scalars(values)).expect("valid");
    let view = generic();
    let camera = Camera {
        position: map(view.camera.position),
        focal_point: map(view.camera.focal_point),
        view_up: turn(view.camera.view_up),
        projection: view.camera.projection,
    };
    (mesh, View { camera, ..view })
}

#[test]
fn rigid_motions_and_far_from_the_origin() {
    let still = draw(&mesh(lattice(), wave), &generic());
    let turn = DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(2.1));
    let (turned, view) = moved(|p| turn * p, |v| turn * v);
    assert_same(&still, &draw(&turned, &view));
    let quarter = |p: DVec3| DVec3::new(-p.y, p.x, p.z);
    let (turned, view) = moved(quarter, quarter);
    assert_same(&still, &draw(&turned, &view));
    // Moving by 1e7 rounds the points themselves to 2⁻²⁹; on a lattice of eighths they
    // and the camera are exact.
    let (points, cells) = kuhn(4, DVec3::ZERO, DVec3::ONE);
    let values: Vec<f64> = points.iter().map(|p| wave(*p)).collect();
    let view = View {
        camera: Camera {
            position: DVec3::new(2.25, 1.125, -1.75),
            ..generic().camera
        },
        ..generic()
    };
    let images = [0.0, 1e3, 1e7, -1e12].map(|far| {
        let by = DVec3::new(far, 2.0 * far, -far);
        let points = points.iter().map(|p| *p + by).collect();
        let scalars = point_scalars(values.clone());
        let mesh = TetMesh::from_tetrahedra(points, cells.clone(), scalars).expect("valid");
        let camera = Camera {
            position: view.camera.position + by,
            focal_point: view.camera.focal_point + by,
            ..view.camera
        };
        draw(&mesh, &View { camera, ..view })
    });
    for image in &images {
        assert_eq!(image.inconsistent_pixels, 0);
    }
    // All numbers but the BVH's are the same.
    for image in &images[1..3] {
        assert_eq!(images[0].pixels, image.pixels);
    }
    assert_same(&images[0], &images[3]);
}

#[test]
fn powers_of_two_change_no_bit_and_others_only_the_last() {
    let still = draw(&mesh(lattice(), wave), &generic());
    let scaled = |factor: f64| {
        let (mesh, view) = moved(|p| factor * p, |v| v);
        let mut knots = knots();
        for knot in &mut knots {
            knot.extinction /= factor;
        }
        let truth = reference(&mesh, &appearance(knots, MODEL));
        truth.render_exact(&view).expect("a valid view")
    };
    for exponent in [-40, -1, 3, 40] {
        let image = scaled(2f64.powi(exponent));
        assert_eq!(still.pixels, image.pixels, "2^{exponent}");
        assert_eq!(still.error_bound, image.error_bound, "2^{exponent}");
    }
    for factor in [1e-12, 3.0, 1e12] {
        assert_same(&still, &scaled(factor));
    }
}

#[test]
fn the_order_of_cells_and_points_does_not_matter() {
    let (points, cells) = lattice();
    for view in views(20) {
        let still = draw(&mesh((points.clone(), cells.clone()), wave), &view);
        // 7 and the number of cells, 750, are coprime.
        let count = cells.len();
        let permuted: Vec<_> = (0..count).map(|i| cells[7 * i % count]).collect();
        let image = draw(&mesh((points.clone(), permuted), wave), &view);
        assert_eq!(still.pixels, image.pixels);
        let last = points.len() as u32 - 1;
        let reversed: Vec<_> = points.iter().rev().copied().collect();
        let cells = cells.iter().map(|c| c.map(|p| last - p)).collect();
        assert_same(&still, &draw(&mesh((reversed, cells), wave), &view));
    }
}

#[test]
fn refinement_of_a_linear_field_changes_nothing() {
    let linear = |p: DVec3| p.dot(DVec3::new(0.3, 0.5, 0.2));
    let (points, cells) = kuhn(3, DVec3::ZERO, DVec3::ONE);
    // 1 to 4 at a point inside, and 1 to 2 at the middle of the cube's diagonals.
    let mut inner = (points.clone(), Vec::new());
    for cell in &cells {
        let new = inner.0.len() as u32;
        let corners = cell.map(|p| points[p as usize]);
        inner.0.push(corners.iter().sum::<DVec3>() / 4.0);
        for i in 0..4 {
            let mut part = *cell;
            part[i] = new;
            inner.1.push(part);
        }
    }
    let mut halves = (points.clone(), Vec::new());
    for cell in &cells {
        // One point a cell: unwelded, so that faces meet without sharing points.
        let new = halves.0.len() as u32;
        halves
            .0
            .push((points[cell[0] as usize] + points[cell[3] as usize]) / 2.0);
        halves.1.push([new, cell[1], cell[2], cell[3]]);
        halves.1.push([cell[0], cell[1], cell[2], new]);
    }
    // 1 to 8 at the middles of all edges: a cell at each vertex, and four around a diagonal
    // of the octahedron that they leave.
    let mut eighths = (points.clone(), Vec::new());
    for cell in &cells {
        let mut middle = |i: usize, j: usize| {
            let [a, b] = [cell[i], cell[j]].map(|p| points[p as usize]);
            eighths.0.push((a + b) / 2.0);
            eighths.0.len() as u32 - 1
        };
        let [a, b, c, d] = *cell;
        let (ab, ac, ad) = (middle(0, 1), middle(0, 2), middle(0, 3));
        let (bc, bd, cd) = (middle(1, 2), middle(1, 3), middle(2, 3));
        eighths.1.extend([
            [a, ab, ac, ad],
            [ab, b, bc, bd],
            [ac, bc, c, cd],
            [ad, bd, cd, d],
            [ab, cd, ac, ad],
            [ab, cd, ad, bd],
            [ab, cd, bd, bc],
            [ab, cd, bc, ac],
        ]);
    }
    for view in views(20) {
        let still = draw(&mesh((points.clone(), cells.clone()), linear), &view);
        for finer in [&inner, &halves, &eighths] {
            let image = draw(&mesh(finer.clone(), linear), &view);
            assert_same(&still, &image);
            assert_eq!(image.inconsistent_pixels, 0);
        }
    }
}

// Cell by cell, in an order that makes holes and islands: no ray's transparency rises, and no
// maximum falls. More extinction hides more, and brighter colors are no darker. All to the
// bounds of both images.
#[test]
fn more_of_anything_shows_no_less() {
    let (points, cells) = kuhn(2, DVec3::ZERO, DVec3::ONE);
    // 29 is coprime to the 48 cells, so that each comes once.
    let order: Vec<[u32; 4]> = (0..cells.len()).map(|i| cells[i * 29 % 48]).collect();
    let view = views(24).swap_remove(0);
    let image = |count: usize, model, knots: Vec<tetrascope_core::Knot>| {
        let part = mesh((points.clone(), order[..count].to_vec()), wave);
        let truth = reference(&part, &appearance(knots, model));
        truth.render_exact(&view).expect("a valid view")
    };
    // Whether `channels` are nowhere less than before; how much more there is in all.
    let grows = |less: &ReferenceImage, more: &ReferenceImage, channels: &[usize]| {
        let mut sum = 0.0;
        for i in 0..less.pixels.len() {
            let bound = less.error_bound[i] + more.error_bound[i];
            for &c in channels {
                let growth = more.pixels[i][c] - less.pixels[i][c];
                assert!(growth >= -bound, "pixel {i}: {growth:e}, bound {bound:e}");
                sum += growth;
            }
        }
        sum
    };
    let models = [
        (MODEL, &[3][..]),
        (OpticalModel::Absorption, &[3]),
        (OpticalModel::Emission, &[0, 1, 2]),
        (OpticalModel::MaximumIntensity, &[0, 1, 2]),
    ];
    for (model, channels) in models {
        let mut grown = 0.0;
        let mut before = image(1, model, knots());
        for count in 2..=order.len() {
            let after = image(count, model, knots());
            grown += grows(&before, &after, channels);
            before = after;
        }
        assert!(grown > 10.0, "{model:?}: {grown}");
    }
    let changed = |change: fn(&mut tetrascope_core::Knot)| {
        let mut knots = knots();
        knots.iter_mut().for_each(change);
        knots
    };
    let plain = image(48, MODEL, knots());
    let denser = image(
        48,
        MODEL,
        changed(|k| k.extinction = 1.5 * k.extinction + 0.1),
    );
    assert!(grows(&plain, &denser, &[3]) > 1.0);
    let brighter = image(48, MODEL, changed(|k| k.color = 0.5 * k.color + 0.5));
    assert!(grows(&plain, &brighter, &[0, 1, 2]) > 1.0);
}

#[test]
fn slivers_and_orientation_change_nothing() {
    let (points, cells) = lattice();
    let still = draw(&mesh((points.clone(), cells.clone()), wave), &generic());
    let flipped = cells.iter().map(|&[a, b, c, d]| [a, b, d, c]).collect();
    let image = draw(&mesh((points.clone(), flipped), wave), &generic());
    assert_eq!(still.pixels, image.pixels);
    // Flat cells: a vertex twice, three points of a line, four of a plane, all one point.
    let mut more = cells.clone();
    more.extend([
        [0, 0, 1, 40],
        [0, 1, 2, 3],
        [0, 1, 6, 7],
        [5; 4],
        [3, 2, 8, 9],
    ]);
    let image = draw(&mesh((points.clone(), more), wave), &generic());
    assert_same(&still, &image);
    assert_eq!(image.inconsistent_pixels, 0);
}

#[test]
fn coincident_faces_are_as_good_as_shared_ones() {
    let half = |x: f64| kuhn(3, DVec3::new(x, 0.0, 0.0), DVec3::new(x + 0.5, 1.0, 1.0));
    let (mut points, mut cells) = half(0.0);
    let (more, others) = half(0.5);
    let shift = points.len() as u32;
    points.extend(more);
    cells.extend(others.into_iter().map(|c| c.map(|p| p + shift)));
    // Welded: the same points once.
    let mut welded: Vec<DVec3> = Vec::new();
    let place: Vec<u32> = points
        .iter()
        .map(|p| {
            let found = welded.iter().position(|q| q == p);
            found.unwrap_or_else(|| {
                welded.push(*p);
                welded.len() - 1
            }) as u32
        })
        .collect();
    assert!(welded.len() < points.len());
    let joined = cells.iter().map(|c| c.map(|p| place[p as usize])).collect();
    for view in views(20) {
        let apart = draw(&mesh((points.clone(), cells.clone()), wave), &view);
        assert_same(
            &apart,
            &draw(&mesh((welded.clone(), Vec::clone(&joined)), wave), &view),
        );
        assert_eq!(apart.inconsistent_pixels, 0);
    }
}

#[test]
fn the_optics_scale_as_the_integral_does() {
    let cube = mesh(lattice(), wave);
    let view = generic();
    let draw = |knots, model| {
        let truth = reference(&cube, &appearance(knots, model));
        truth.render_exact(&view).expect("a valid view")
    };
    let plain = draw(knots(), MODEL);
    // c and 1 − c add to α.
    let mut inverse = knots();
    for knot in &mut inverse {
        knot.color = DVec3::ONE - knot.color;
    }
    let complement = draw(inverse, MODEL);
    // σ → 3 σ takes T to its third power.
    let mut denser = knots();
    for knot in &mut denser {
        knot.extinction *= 3.0;
    }
    let cubed = draw(denser, MODEL);
    for ((p, q), r) in plain
        .pixels
        .iter()
        .zip(&complement.pixels)
        .zip(&cubed.pixels)
    {
        for channel in 0..3 {
            assert!((p[channel] + q[channel] - p[3]).abs() < 1e-13);
            assert!(p[channel] >= 0.0 && p[channel] <= p[3]);
        }
        assert!(((1.0 - p[3]).powi(3) - (1.0 - r[3])).abs() < 1e-13);
        assert!(r[3] >= p[3]);
    }
    // A knot on the line between its neighbors, up to rounding of its own numbers.
    let mut redundant = knots();
    redundant.insert(1, knot(0.2, [0.5, 0.25, 0.6], 2.6));
    assert_same(&plain, &draw(redundant, MODEL));
    // s → 4 − 2 s with the knots mapped, which reverses them; exact in binary.
    let mapped = mesh(lattice(), |p| 4.0 - 2.0 * wave(p));
    let mut reversed = knots();
    reversed.reverse();
    for knot in &mut reversed {
        knot.scalar = 4.0 - 2.0 * knot.scalar;
    }
    let truth = reference(&mapped, &appearance(reversed, MODEL));
    assert_same(&plain, &truth.render_exact(&view).expect("a valid view"));
}

#[test]
fn seen_from_behind_what_commutes_is_the_same() {
    let cube = mesh(lattice(), wave);
    let projection = Projection::Orthographic {
        parallel_scale: 0.8,
    };
    let front = view([3.0, 2.0, -1.0], [0.5; 3], [0.0, 0.0, 1.0], projection, 24);
    let behind = View {
        camera: Camera {
            position: 2.0 * front.camera.focal_point - front.camera.position,
            ..front.camera
        },
        ..front
    };
    for model in [
        OpticalModel::Emission,
        OpticalModel::Absorption,
        OpticalModel::MaximumIntensity,
    ] {
        let truth = reference(&cube, &appearance(knots(), model));
        let a = truth.render_exact(&front).expect("a valid view");
        let b = truth.render_exact(&behind).expect("a valid view");
        for row in 0..24 {
            for column in 0..24 {
                let (p, q) = (a.pixel(column, row), b.pixel(23 - column, row));
                for (x, y) in p.iter().zip(q) {
                    assert!((x - y).abs() < 1e-12, "{model:?}: {p:?} {q:?}");
                }
            }
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let volume = Volume::Mesh(mesh(lattice(), wave));
    let look = appearance(knots(), MODEL);
    let images = [1, 2, 3].map(|threads| {
        let options = ReferenceOptions {
            threads: Some(threads),
        };
        let truth = Reference::new(&volume, &look, &options).expect("a valid mesh");
        let view = View {
            width: 50,
            height: 37,
            ..generic()
        };
        truth.render_exact(&view).expect("a valid view")
    });
    for image in &images[1..] {
        assert_eq!(images[0].pixels, image.pixels);
        assert_eq!(images[0].error_bound, image.error_bound);
    }
}

#[test]
fn a_single_ray_sees_what_a_pixel_sees() {
    let truth = reference(&mesh(lattice(), wave), &appearance(knots(), MODEL));
    for view in views(12) {
        let image = truth.render_exact(&view).expect("a valid view");
        for row in 0..view.height {
            for column in 0..view.width {
                let trace = truth.trace(&view.ray(column, row)).expect("a valid ray");
                let bound =
                    trace.error_bound + image.error_bound[(row * view.width + column) as usize];
                for (x, y) in trace.pixel.iter().zip(image.pixel(column, row)) {
                    assert!((x - y).abs() <= bound, "{trace:?}, bound {bound}");
                    assert!((x - y).abs() <= 1e-12, "{trace:?}");
                }
            }
        }
    }
}
