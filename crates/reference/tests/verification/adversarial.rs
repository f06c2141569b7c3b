//! Rays that hit what rays should not hit, meshes that should not be, and extreme numbers.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::DVec3;
use tetrascope_core::mesh::Association;
use tetrascope_core::{
    Error, OpticalModel, Projection, Ray, Scalars, TetMesh, View, Volume, VolumeRenderer as _,
};
use tetrascope_reference::counters::CELL_VISITS;
use tetrascope_reference::{Reference, ReferenceOptions};

use crate::scenes::*;

const MODEL: OpticalModel = OpticalModel::EmissionAbsorption;

fn grey(extinction: f64) -> tetrascope_core::Appearance {
    appearance(vec![knot(0.0, [1.0; 3], extinction)], MODEL)
}

// Through vertices, along edges, in faces, and along the diagonal at which six cells meet:
// the intervals lie end to end and cover the cube's chord, each stretch once.
#[test]
fn rays_through_vertices_edges_and_faces_lose_and_double_nothing() {
    let n = 4;
    let truth = reference(&mesh(kuhn(n, DVec3::ZERO, DVec3::ONE), |p| p.x), &grey(1.0));
    let directions = [
        DVec3::X,
        DVec3::Y,
        -DVec3::Z,
        DVec3::new(1.0, 1.0, 0.0),
        DVec3::new(0.0, 1.0, 1.0),
        DVec3::new(1.0, 0.0, 1.0),
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(1.0, -1.0, 0.0),
        DVec3::new(1.0, 2.0, 3.0),
        DVec3::new(-1.0, 0.5, 0.25),
    ];
    let mut seen = 0;
    for i in 0..=2 * n {
        for j in 0..=2 * n {
            // Lattice points and the middles between them.
            let through = DVec3::new(0.5, i as f64 / (2 * n) as f64, j as f64 / (2 * n) as f64);
            for direction in directions {
                let direction = direction.unit();
                let ray = Ray {
                    origin: through - 4.0 * direction,
                    direction,
                };
                let trace = truth.trace(&ray).expect("a valid ray");
                assert!(!trace.consistency.overlap && !trace.consistency.crack);
                for pair in trace.intervals.windows(2) {
                    // Where rounding turned a cell inside out that the ray only grazes, its
                    // neighbors overlap by that rounding, 8 ulp of t < 8 at most.
                    let gap = pair[1].t_in - pair[0].t_out;
                    assert!(gap.abs() <= 32.0 * f64::EPSILON, "{ray:?}: {gap}");
                }
                let length: f64 = trace.intervals.iter().map(|s| s.t_out - s.t_in).sum();
                // In a face of the cube the ray is shifted in or out of it.
                let inside = through.cmpgt(DVec3::ZERO).all() && through.cmplt(DVec3::ONE).all();
                let (a, b) = box_interval(&ray, DVec3::ZERO, DVec3::ONE).unwrap_or((0.0, 0.0));
                if inside {
                    assert!((length - (b - a)).abs() < 1e-14, "{ray:?}: {length}");
                    seen += 1;
                } else {
                    assert!(
                        length < 1e-14 || (length - (b - a)).abs() < 1e-14,
                        "{ray:?}"
                    );
                }
            }
        }
    }
    assert_eq!(seen, 7 * 7 * directions.len());
}

#[test]
fn any_extinction_is_exact() {
    let cube = mesh(kuhn(3, DVec3::ZERO, DVec3::ONE), |p| p.x);
    for sigma in [0.0, 1e-30, 1e-8, 1.0, 88.0, 1e6, 1e30] {
        let truth = reference(&cube, &grey(sigma));
        let direction = DVec3::new(0.1, 0.2, 0.9).unit();
        let ray = Ray {
            origin: DVec3::splat(0.4) - 2.0 * direction,
            direction,
        };
        let (a, b) = box_interval(&ray, DVec3::ZERO, DVec3::ONE).expect("it meets the cube");
        let alpha = -(-sigma * (b - a)).exp_m1();
        let pixel = truth.trace(&ray).expect("a valid ray").pixel;
        for channel in pixel {
            // Depth is relative to 1e-14 of itself, so is α at most.
            assert!(
                (channel - alpha).abs() <= 1e-14 * alpha,
                "{sigma}: {channel} {alpha}"
            );
        }
    }
}

// Sixteen layers from 2⁻³⁰ to 1, each 3.7 times as thick as the one below, and a fan of
// 10⁴ needles round one edge.
#[test]
fn thin_layers_and_needles() {
    let (mut points, cells) = kuhn(16, DVec3::ZERO, DVec3::ONE);
    for point in &mut points {
        point.z = 2f64.powf((point.z - 1.0) * 30.0);
    }
    let layers = mesh((points, cells), |p| p.x);
    let bottom = 2f64.powi(-30);
    let low = DVec3::new(0.0, 0.0, bottom);

    let count = 10_000u32;
    let mut points = vec![DVec3::ZERO, DVec3::Z];
    for i in 0..count {
        let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
        points.push(DVec3::new(angle.cos(), angle.sin(), 0.5));
    }
    let cells = (0..count).map(|i| [0, 1, 2 + i, 2 + (i + 1) % count]);
    let fan = mesh((points, cells.collect()), |_| 0.0);

    let projection = Projection::Perspective { view_angle: 25.0 };
    for eye in [[3.0, 2.0, 1.7], [0.5, 0.5, 4.0], [3.0, 0.4, 0.25]] {
        let view = view(eye, [0.5, 0.5, 0.3], [0.0, 1.0, 0.0], projection, 24);
        let image = reference(&layers, &grey(1.0))
            .render_exact(&view)
            .expect("valid");
        for row in 0..24 {
            for column in 0..24 {
                let i = (row * view.width + column) as usize;
                let ray = view.ray(column, row);
                let chord = box_interval(&ray, low, DVec3::ONE).map_or(0.0, |(a, b)| b - a);
                let error = (image.pixels[i][3] + (-chord).exp_m1()).abs();
                assert!(error <= image.error_bound[i].min(1e-10), "{error}");
            }
        }
        let image = reference(&fan, &grey(1.0))
            .render_exact(&view)
            .expect("valid");
        assert_eq!(image.inconsistent_pixels, 0);
    }
    // Through the fan's edge, and beside it, in the plane z = 1/2: a diameter.
    let truth = reference(&fan, &grey(1.0));
    for y in [0.0, 1e-9, 0.3] {
        let ray = Ray {
            origin: DVec3::new(-3.0, y, 0.5),
            direction: DVec3::X,
        };
        let trace = truth.trace(&ray).expect("a valid ray");
        // The polygon of 10⁴ sides is 1 − cos(π/10⁴) = 5e-8 short at most at either end.
        let chord = 2.0 * (1.0 - y * y).sqrt();
        assert!(
            (trace.optical_depth - chord).abs() < 1.1e-7,
            "{y}: {}",
            trace.optical_depth
        );
        for pair in trace.intervals.windows(2) {
            // As in the test of rays through edges: all cells are met at one point of theirs.
            let gap = pair[1].t_in - pair[0].t_out;
            assert!(gap.abs() <= 32.0 * f64::EPSILON, "{y}: {gap}");
        }
    }
}

// Three slabs, each before the next and the last before the first.
#[test]
fn a_cycle_of_three_cells_is_in_order_on_every_ray() {
    let third = std::f64::consts::TAU / 3.0;
    let mut points = Vec::new();
    let mut cells = Vec::new();
    for k in 0..3 {
        let turn = |x: f64, y: f64, z: f64| {
            let (sin, cos) = (third * f64::from(k)).sin_cos();
            DVec3::new(cos * x - sin * y, sin * x + cos * y, z)
        };
        cells.push([0, 1, 2, 3].map(|i| i + 4 * k as u32));
        points.extend([
            turn(-1.2, 0.35, 1.0),
            turn(-1.2, 0.5, 0.9),
            turn(1.2, 0.35, -0.9),
            turn(1.2, 0.5, -0.8),
        ]);
    }
    let mut knots = Vec::new();
    for k in 0..3 {
        let mut color = [0.0; 3];
        color[k] = 1.0;
        knots.push(knot(k as f64, color, 40.0));
    }
    let values = (0..12).map(|i| f64::from(i / 4)).collect();
    let cycle = TetMesh::from_tetrahedra(points, cells, point_scalars(values)).expect("valid");
    let truth = reference(&cycle, &appearance(knots, MODEL));
    let projection = Projection::Orthographic {
        parallel_scale: 1.2,
    };
    let view = view([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0], projection, 64);
    let image = truth.render_exact(&view).expect("a valid view");
    assert_eq!(image.overlapping_pixels, 0);
    let mut before = [[false; 3]; 3];
    for row in 0..64 {
        for column in 0..64 {
            let trace = truth.trace(&view.ray(column, row)).expect("a valid ray");
            for pair in trace.intervals.windows(2) {
                assert!(pair[0].t_out <= pair[1].t_in);
                before[pair[0].cell][pair[1].cell] = true;
            }
        }
    }
    let cycles = (before[0][1] && before[1][2] && before[2][0])
        || (before[1][0] && before[2][1] && before[0][2]);
    assert!(cycles, "{before:?}");
}

#[test]
fn overlaps_and_cracks_are_reported_and_holes_are_not() {
    let projection = Projection::Orthographic {
        parallel_scale: 0.6,
    };
    let view = view(
        [0.51, 0.52, -3.0],
        [0.51, 0.52, 0.0],
        [0.0, 1.0, 0.0],
        projection,
        16,
    );
    let two = |z: f64| {
        let (mut points, mut cells) = kuhn(2, DVec3::ZERO, DVec3::ONE);
        let (more, others) = kuhn(2, DVec3::new(0.0, 0.0, z), DVec3::new(1.0, 1.0, z + 1.0));
        let shift = points.len() as u32;
        points.extend(more);
        cells.extend(others.into_iter().map(|c| c.map(|p| p + shift)));
        let truth = reference(&mesh((points, cells), |p| p.x), &grey(1.0));
        let image = truth.render_exact(&view).expect("a valid view");
        let covered = image.pixels.iter().filter(|p| p[3] > 0.0).count() as u64;
        assert!(covered > 100);
        (
            covered,
            image.overlapping_pixels,
            image.cracked_pixels,
            image.inconsistent_pixels,
        )
    };
    let (all, overlapping, _, inconsistent) = two(0.9);
    assert_eq!((overlapping, inconsistent), (all, all));
    let (all, overlapping, cracked, inconsistent) = two(1.0 + 1e-8);
    assert_eq!((overlapping, cracked, inconsistent), (0, all, all));
    for z in [1.0, 1.5] {
        let (_, overlapping, cracked, inconsistent) = two(z);
        assert_eq!((overlapping, cracked, inconsistent), (0, 0, 0));
    }
    // Cells at the same place as others are left out of a mesh, and counted there.
    let (_, overlapping, cracked, inconsistent) = two(0.0);
    assert_eq!((overlapping, cracked, inconsistent), (0, 0, 0));
}

#[test]
fn cells_across_behind_and_far_beside_the_eye() {
    // One cell, 10⁶ images wide, around the eye; its face is the plane z = 1.
    let w = 1e6;
    let points = vec![
        DVec3::new(-w, -w, 1.0),
        DVec3::new(w, -w, 1.0),
        DVec3::new(0.0, w, 1.0),
        DVec3::new(0.0, 0.0, -w),
    ];
    let cell = mesh((points, vec![[0, 1, 2, 3]]), |_| 0.0);
    let projection = Projection::Perspective { view_angle: 60.0 };
    let view = view([0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], projection, 16);
    let image = reference(&cell, &grey(0.7))
        .render_exact(&view)
        .expect("valid");
    for row in 0..16 {
        for column in 0..16 {
            let i = (row * view.width + column) as usize;
            let depth = 0.7 / view.ray(column, row).direction.z;
            let error = (image.pixels[i][3] + (-depth).exp_m1()).abs();
            assert!(error <= image.error_bound[i].min(1e-9), "{error}");
        }
    }
    // Looking away, there is nothing.
    let camera = tetrascope_core::Camera {
        position: DVec3::new(0.0, 0.0, 2.0),
        focal_point: DVec3::new(0.0, 0.0, 3.0),
        ..view.camera
    };
    let image = reference(&cell, &grey(0.7));
    let image = image.render_exact(&View { camera, ..view }).expect("valid");
    assert_eq!(image.cell_visits, 0);
    assert!(image.pixels.iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn nothing_and_numbers_that_are_none() {
    let empty = TetMesh::from_tetrahedra(vec![], vec![], point_scalars(vec![])).expect("valid");
    let truth = reference(&empty, &grey(1.0));
    let background = [0.25, 0.5, 1.0, 0.5];
    let view = View {
        background,
        ..views(8)[0]
    };
    let image = truth.render_exact(&view).expect("a valid view");
    assert!(image.pixels.iter().all(|p| *p == [0.125, 0.25, 0.5, 0.5]));

    // A NaN makes the cells around it transparent and no others.
    let (points, cells) = kuhn(2, DVec3::ZERO, DVec3::ONE);
    let mut values = vec![0.0; points.len()];
    values[13] = f64::NAN; // the middle, used by every cube
    let holed = TetMesh::from_tetrahedra(points.clone(), cells.clone(), point_scalars(values))
        .expect("valid");
    let kept = cells.iter().filter(|c| !c.contains(&13)).copied().collect();
    let without = mesh((points, kept), |_| 0.0);
    for view in views(16) {
        let a = reference(&holed, &grey(1.0))
            .render_exact(&view)
            .expect("valid");
        let b = reference(&without, &grey(1.0))
            .render_exact(&view)
            .expect("valid");
        assert_eq!(a.pixels, b.pixels);
    }

    let truth = reference(&holed, &grey(1.0));
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        let ray = Ray {
            origin: DVec3::ZERO,
            direction,
        };
        assert!(truth.trace(&ray).is_err());
    }
    let threads = ReferenceOptions { threads: Some(0) };
    let refused = Reference::new(&Volume::Mesh(holed), &grey(1.0), &threads);
    assert!(matches!(refused, Err(Error::Invalid { .. })));
}

#[test]
fn cell_data_is_constant_in_each_cell() {
    let (points, cells) = kuhn(2, DVec3::ZERO, DVec3::ONE);
    let values: Vec<f64> = (0..cells.len()).map(|i| i as f64).collect();
    let scalars = Scalars {
        name: "cell".into(),
        association: Association::Cell,
        values,
    };
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars).expect("valid");
    let knots = vec![knot(0.0, [0.0; 3], 0.0), knot(47.0, [1.0; 3], 47.0)];
    let truth = reference(&mesh, &appearance(knots, OpticalModel::Absorption));
    let direction = DVec3::new(0.3, -0.5, 0.8).unit();
    let ray = Ray {
        origin: DVec3::splat(0.45) - 3.0 * direction,
        direction,
    };
    let trace = truth.trace(&ray).expect("a valid ray");
    let mut depth = 0.0;
    for interval in &trace.intervals {
        assert_eq!(interval.scalar_in, interval.cell as f64);
        assert_eq!(interval.scalar_out, interval.cell as f64);
        depth += interval.scalar_in * (interval.t_out - interval.t_in);
    }
    assert!(trace.intervals.len() > 3);
    assert!((trace.optical_depth - depth).abs() < 1e-12 * depth);
}

#[test]
fn new_scalars_keep_the_bvh_and_new_geometry_replaces_it() {
    let lattice = kuhn(3, DVec3::ZERO, DVec3::ONE);
    let first = mesh(lattice.clone(), |p| p.x);
    let count = first.points().len();
    let second = first
        .with_scalars(point_scalars(vec![0.5; count]))
        .expect("valid");
    let knots = vec![knot(0.0, [0.0; 3], 0.0), knot(1.0, [1.0; 3], 3.0)];
    let look = appearance(knots, MODEL);
    let mut truth = reference(&first, &look);
    let view = views(12)[0];
    let before = truth.render_exact(&view).expect("valid");
    assert_eq!(truth.bvh_builds(), 1);
    truth.reload(&Volume::Mesh(second.clone())).expect("valid");
    assert_eq!(truth.bvh_builds(), 1);
    let after = truth.render_exact(&view).expect("valid");
    assert_ne!(before.pixels, after.pixels);
    let fresh = reference(&second, &look)
        .render_exact(&view)
        .expect("valid");
    assert_eq!(after.pixels, fresh.pixels);
    truth
        .reload(&Volume::Mesh(mesh(lattice, |p| p.x)))
        .expect("valid");
    assert_eq!(truth.bvh_builds(), 2);
    assert_eq!(
        truth.render_exact(&view).expect("valid").pixels,
        before.pixels
    );
    truth.restyle(&grey(2.0)).expect("valid");
    assert_eq!(truth.bvh_builds(), 2);
    assert_ne!(
        truth.render_exact(&view).expect("valid").pixels,
        before.pixels
    );
}

#[test]
fn the_frame_carries_the_bound_and_progress_ends_at_one() {
    let truth = reference(&mesh(kuhn(2, DVec3::ZERO, DVec3::ONE), |p| p.x), &grey(1.0));
    let view = views(40)[0];
    let most = std::sync::Mutex::new(Vec::new());
    let image = truth
        .render_with_progress(&view, &|done| most.lock().expect("no panic").push(done))
        .expect("valid");
    let reported = most.into_inner().expect("no panic");
    assert_eq!(reported.len(), 9);
    assert!(reported.contains(&1.0) && reported.iter().all(|d| *d > 0.0 && *d <= 1.0));
    let frame = truth.render(&view).expect("valid");
    assert_eq!(frame.stats.get(CELL_VISITS), Some(image.cell_visits));
    let bound = frame.stats.error_bound.expect("the reference has a bound");
    // Half an ulp of f32 below 1 is 2⁻²⁵.
    assert!(
        bound > image.worst_error_bound() && bound < image.worst_error_bound() + 2f64.powi(-25)
    );
}
