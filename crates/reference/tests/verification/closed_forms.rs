//! Scenes with a closed-form answer, to 1e-10 and to the error bound that comes
//! with each pixel.

use crate::scenes::*;
use tetrascope_core::glam::DVec3;
use tetrascope_core::optics::segment_weights;
use tetrascope_core::{OpticalModel, Projection, Ray, TetMesh, View};
use tetrascope_reference::ReferenceImage;

/// Compares all pixels whose ray is not within 1e-9 of the box's silhouette,
/// where rounding decides whether the box is met at all.
pub(crate) fn check(image: &ReferenceImage, view: &View, expected: impl Fn(&Ray) -> [f64; 4]) {
    let mut worst = 0.0f64;
    for row in 0..view.height {
        for column in 0..view.width {
            let i = (row * view.width + column) as usize;
            let ray = view.ray(column, row);
            let expected = expected(&ray);
            for (got, want) in image.pixels[i].iter().zip(expected) {
                let error = (got - want).abs();
                assert!(
                    error <= image.error_bound[i],
                    "pixel ({column}, {row}) is {:?}, not {expected:?}; bound {}",
                    image.pixels[i],
                    image.error_bound[i]
                );
                worst = worst.max(error);
            }
        }
    }
    assert!(worst <= 1e-10, "worst error {worst}");
    assert_eq!(image.inconsistent_pixels, 0, "{view:?}");
}

fn cube(n: usize, scalar: impl Fn(DVec3) -> f64) -> TetMesh {
    mesh(kuhn(n, DVec3::ZERO, DVec3::ONE), scalar)
}

fn length(ray: &Ray) -> f64 {
    box_interval(ray, DVec3::ZERO, DVec3::ONE).map_or(0.0, |(a, b)| b - a)
}

// Uniform σ and c: α = 1 − e^(−σ l) and c α on a chord of length l, from everywhere.
#[test]
fn a_homogeneous_cube() {
    let color = [0.9, 0.5, 0.2];
    let sigma = 1.7;
    for model in OpticalModel::VOLUMETRIC {
        let look = appearance(vec![knot(0.0, color, sigma)], model);
        let truth = reference(&cube(4, |p| p.x), &look);
        for view in views(40) {
            let image = truth.render_exact(&view).expect("a valid view");
            check(&image, &view, |ray| {
                let tau = sigma * length(ray);
                let alpha = -(-tau).exp_m1();
                let light = |c: f64| match model {
                    OpticalModel::EmissionAbsorption => c * alpha,
                    OpticalModel::Emission => c * tau,
                    OpticalModel::MaximumIntensity if tau > 0.0 => c,
                    _ => 0.0,
                };
                let alpha = match model {
                    OpticalModel::EmissionAbsorption | OpticalModel::Absorption => alpha,
                    _ => 0.0,
                };
                [light(color[0]), light(color[1]), light(color[2]), alpha]
            });
        }
    }
}

// The reference cell seen along +z at (x, y) is 1 − x − y long; the image sums to its volume, 1/6.
#[test]
fn the_reference_cell() {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let cell = mesh((points, vec![[0, 1, 2, 3]]), |_| 0.0);
    let look = appearance(vec![knot(0.0, [1.0; 3], 1.0)], OpticalModel::Emission);
    let truth = reference(&cell, &look);
    let projection = Projection::Orthographic {
        parallel_scale: 0.5,
    };
    let size = 64;
    let view = view(
        [0.5, 0.5, -1.0],
        [0.5, 0.5, 0.0],
        [0.0, 1.0, 0.0],
        projection,
        size,
    );
    let image = truth.render_exact(&view).expect("a valid view");
    check(&image, &view, |ray| {
        let length = (1.0 - ray.origin.x - ray.origin.y).max(0.0);
        [length, length, length, 0.0]
    });
    // The midpoint rule is exact on pixels that the diagonal does not cut. Those
    // it cuts, n of them h wide, have their centers on it: each lacks ∫∫ (1−x−y) = h³/6.
    let h = 1.0 / f64::from(size);
    let sum: f64 = image.pixels.iter().map(|p| p[0] * h * h).sum();
    let missing = f64::from(size) * h * h * h / 6.0;
    assert!((sum + missing - 1.0 / 6.0).abs() < 1e-12, "{sum}");
}

// c = 1 before a background of 1: every pixel is 1, whatever the extinction.
#[test]
fn a_white_furnace() {
    let knots = vec![
        knot(0.0, [1.0; 3], 0.0),
        knot(0.4, [1.0; 3], 30.0),
        knot(0.5, [1.0; 3], 0.1),
        knot(1.0, [1.0; 3], 2.0),
    ];
    let look = appearance(knots, OpticalModel::EmissionAbsorption);
    let truth = reference(
        &cube(5, |p| (7.0 * p.x + 5.0 * p.y * p.z).sin().abs()),
        &look,
    );
    for view in views(24) {
        let view = View {
            background: [1.0; 4],
            ..view
        };
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |_| [1.0; 4]);
    }
}

// s = x: along a ray x(t) the depth is k ∫ x dt = k (x_in + x_out)/2 l, from every
// direction; and the color 1 − x with it is the single segment of `core::optics`.
#[test]
fn a_linear_field_is_one_segment() {
    let knots = vec![
        knot(0.0, [1.0, 0.5, 0.0], 0.0),
        knot(1.0, [0.0, 0.5, 1.0], 6.0),
    ];
    let look = appearance(knots, OpticalModel::EmissionAbsorption);
    let truth = reference(&cube(5, |p| p.x), &look);
    for view in views(24) {
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |ray| {
            let Some((t_in, t_out)) = box_interval(ray, DVec3::ZERO, DVec3::ONE) else {
                return [0.0; 4];
            };
            let (a, b) = (ray.at(t_in).x, ray.at(t_out).x);
            let length = t_out - t_in;
            let alpha = -(-3.0 * (a + b) * length).exp_m1();
            let (front, back) = segment_weights(6.0 * a * length, 6.0 * b * length);
            let red = (1.0 - a) * front + (1.0 - b) * back;
            [red, 0.5 * alpha, a * front + b * back, alpha]
        });
    }
}

// σ₀ on s₁ < s < s₂ and s = x: τ = σ₀ (s₂ − s₁) / |dx/dt| where the chord spans both;
// and a tent of half-width ε and height 1/ε: τ = 1 / |dx/dt|.
#[test]
fn steps_and_tents_count_once_in_any_mesh() {
    let black = [0.0; 3];
    let sigma = 2.0;
    let step = vec![
        knot(0.3, black, 0.0),
        knot(0.3, black, sigma),
        knot(0.7, black, sigma),
        knot(0.7, black, 0.0),
    ];
    let tent = |half: f64| {
        vec![
            knot(0.51 - half, black, 0.0),
            knot(0.51, black, 1.0 / half),
            knot(0.51 + half, black, 0.0),
        ]
    };
    let projection = Projection::Perspective { view_angle: 10.0 };
    let up = [0.0, 0.0, 1.0];
    let view = view([5.0, 0.6, 0.4], [0.5; 3], up, projection, 24);
    for (knots, area) in [
        (step, sigma * 0.4),
        (tent(0.2), 1.0),
        (tent(1e-3), 1.0),
        (tent(1e-6), 1.0),
    ] {
        for n in [1, 4, 7] {
            let look = appearance(knots.clone(), OpticalModel::Absorption);
            let truth = reference(&cube(n, |p| p.x), &look);
            let image = truth.render_exact(&view).expect("a valid view");
            for row in 0..view.height {
                for column in 0..view.width {
                    let ray = view.ray(column, row);
                    let Some((t_in, t_out)) = box_interval(&ray, DVec3::ZERO, DVec3::ONE) else {
                        continue;
                    };
                    if ray.at(t_in).x < 0.8 || ray.at(t_out).x > 0.2 {
                        continue; // it leaves through a side
                    }
                    let alpha = -(-area / ray.direction.x.abs()).exp_m1();
                    let i = (row * view.width + column) as usize;
                    let error = (image.pixels[i][3] - alpha).abs();
                    assert!(
                        error <= image.error_bound[i],
                        "{error} of {}",
                        image.error_bound[i]
                    );
                    // A tent's own knots are known to 2⁻⁵³ / half of its width.
                    assert!(error <= 1e-10, "{error}");
                }
            }
        }
    }
}

// The greatest value of a linear field on a chord is at one of its ends.
#[test]
fn the_greatest_of_a_linear_field() {
    let knots = vec![knot(0.0, [0.0; 3], 0.0), knot(1.0, [1.0, 2.0, 0.5], 1.0)];
    let look = appearance(knots, OpticalModel::MaximumIntensity);
    let truth = reference(&cube(4, |p| p.dot(DVec3::new(0.2, 0.3, 0.5))), &look);
    for view in views(24) {
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |ray| {
            let greatest = box_interval(ray, DVec3::ZERO, DVec3::ONE).map_or(0.0, |(a, b)| {
                let at = |t: f64| ray.at(t).dot(DVec3::new(0.2, 0.3, 0.5));
                at(a).max(at(b))
            });
            [greatest, 2.0 * greatest, 0.5 * greatest, 0.0]
        });
    }
}

// A cube of side 3 with a hole of side 1: two chords of 1 through the middle.
#[test]
fn a_hollow_cube() {
    let (points, cells) = kuhn(3, DVec3::ZERO, DVec3::splat(3.0));
    let center = |cell: &[u32; 4]| cell.iter().map(|&p| points[p as usize]).sum::<DVec3>() / 4.0;
    let middle = DVec3::splat(1.5);
    let cells: Vec<_> = cells
        .iter()
        .filter(|cell| (center(cell) - middle).abs().max_element() > 0.5)
        .copied()
        .collect();
    let look = appearance(
        vec![knot(0.0, [0.3, 0.6, 0.9], 0.8)],
        OpticalModel::Emission,
    );
    let truth = reference(&mesh((points.clone(), cells), |p| p.x), &look);
    let up = [0.0, 1.0, 0.0];
    for (eye, angle) in [
        ([1.5, 1.5, -4.0], 30.0),
        ([7.1, 3.3, -4.0], 40.0),
        ([1.4, 1.6, 1.5], 100.0),
    ] {
        let projection = Projection::Perspective { view_angle: angle };
        let view = view(eye, [1.5, 1.5, 1.6], up, projection, 32);
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |ray| {
            let chord = |low: f64, high: f64| {
                let (low, high) = (DVec3::splat(low), DVec3::splat(high));
                box_interval(ray, low, high).map_or(0.0, |(a, b)| b - a)
            };
            let tau = 0.8 * (chord(0.0, 3.0) - chord(1.0, 2.0));
            [0.3 * tau, 0.6 * tau, 0.9 * tau, 0.0]
        });
    }
}

// σ = e^(−r²/w²) on a ray at the distance ρ from the center: τ = w √π e^(−ρ²/w²) erf(…),
// nearly all of it inside the cube for w = 0.12. A linear interpolant is off by O(h²).
#[test]
fn a_gaussian_converges_at_second_order() {
    let w = 0.12;
    let middle = DVec3::splat(0.5);
    let projection = Projection::Orthographic {
        parallel_scale: 0.3,
    };
    let view = view([3.0, 2.0, 1.0], [0.5; 3], [0.0, 0.0, 1.0], projection, 16);
    let error = |n: usize| {
        let field = cube(n, |p| (-(p - middle).length_squared() / (w * w)).exp());
        let knots = vec![knot(0.0, [0.0; 3], 0.0), knot(1.0, [1.0; 3], 1.0)];
        let truth = reference(&field, &appearance(knots, OpticalModel::Absorption));
        let image = truth.render_exact(&view).expect("a valid view");
        let mut sum = 0.0;
        for row in 0..view.height {
            for column in 0..view.width {
                let ray = view.ray(column, row);
                let rho = (middle - ray.origin).cross(ray.direction).length();
                let tau = w * std::f64::consts::PI.sqrt() * (-rho * rho / (w * w)).exp();
                sum += (-(-image.pixel(column, row)[3]).ln_1p() - tau).powi(2);
            }
        }
        sum.sqrt()
    };
    let (coarse, fine) = (error(16), error(32));
    let order = (coarse / fine).log2();
    assert!(
        (1.8..2.3).contains(&order),
        "order {order}: {coarse} to {fine}"
    );
}

// Three limbs on a base: a ray along x meets them one after the other, each of its own
// color: C = Σ cᵢ αᵢ Π Tⱼ over what is in front. A wrong order of re-entry would show.
#[test]
fn limbs_are_met_in_order() {
    let (points, cells) = kuhn(5, DVec3::ZERO, DVec3::splat(5.0));
    let center = |cell: &[u32; 4]| cell.iter().map(|&p| points[p as usize]).sum::<DVec3>() / 4.0;
    let is_kept = |cell: &&[u32; 4]| {
        let c = center(cell);
        c.z < 1.0 || (c.x as usize).is_multiple_of(2)
    };
    let cells: Vec<_> = cells.iter().filter(is_kept).copied().collect();
    let colors = [[0.9, 0.1, 0.2], [0.2, 0.8, 0.1], [0.1, 0.3, 0.7]];
    let sigma = 0.4;
    // Steps between the limbs.
    let knots = [0.0, 1.5, 1.5, 3.5, 3.5, 5.0].into_iter().enumerate();
    let knots = knots.map(|(i, x)| knot(x, colors[i / 2], sigma)).collect();
    let look = appearance(knots, OpticalModel::EmissionAbsorption);
    let truth = reference(&mesh((points.clone(), cells), |p| p.x), &look);
    for (eye, ahead) in [([-4.0, 2.4, 3.1], 1.0), ([9.0, 2.7, 2.9], -1.0)] {
        let projection = Projection::Perspective { view_angle: 8.0 };
        let focus = [eye[0] + ahead, eye[1], eye[2]];
        let view = view(eye, focus, [0.0, 0.0, 1.0], projection, 24);
        let image = truth.render_exact(&view).expect("a valid view");
        check(&image, &view, |ray| {
            let mut limbs: Vec<usize> = vec![0, 1, 2];
            if ahead < 0.0 {
                limbs.reverse();
            }
            let (mut light, mut depth) = ([0.0; 3], 0.0f64);
            for limb in limbs {
                let low = DVec3::new(2.0 * limb as f64, 0.0, 1.0);
                let high = DVec3::new(low.x + 1.0, 5.0, 5.0);
                let (a, b) = box_interval(ray, low, high).expect("rays are nearly along x");
                let tau = sigma * (b - a);
                let seen = (-depth).exp() * -(-tau).exp_m1();
                for (light, color) in light.iter_mut().zip(colors[limb]) {
                    *light += color * seen;
                }
                depth += tau;
            }
            [light[0], light[1], light[2], -(-depth).exp_m1()]
        });
    }
}

// A ball of radius 1: the chord at the distance ρ from its center is 2 √(1 − ρ²). Its
// mesh, cones over triangles with their corners on the sphere, is off by O(h²) inside.
#[test]
fn a_ball_converges_at_second_order() {
    let ball = |n: usize| {
        let mut points = vec![DVec3::ZERO, DVec3::Z, DVec3::NEG_Z];
        let ring = |i: usize, j: usize| (3 + (i - 1) * 2 * n + j % (2 * n)) as u32;
        for i in 1..n {
            let (sin, cos) = (std::f64::consts::PI * i as f64 / n as f64).sin_cos();
            for j in 0..2 * n {
                let (y, x) = (std::f64::consts::PI * j as f64 / n as f64).sin_cos();
                points.push(DVec3::new(sin * x, sin * y, cos));
            }
        }
        let mut cells = Vec::new();
        for j in 0..2 * n {
            cells.push([0, 1, ring(1, j), ring(1, j + 1)]);
            cells.push([0, 2, ring(n - 1, j), ring(n - 1, j + 1)]);
            for i in 1..n - 1 {
                let (a, b) = (ring(i, j), ring(i, j + 1));
                let (c, d) = (ring(i + 1, j), ring(i + 1, j + 1));
                cells.push([0, a, b, c]);
                cells.push([0, b, c, d]);
            }
        }
        mesh((points, cells), |_| 0.0)
    };
    let look = appearance(vec![knot(0.0, [1.0; 3], 1.0)], OpticalModel::Emission);
    let projection = Projection::Orthographic {
        parallel_scale: 0.55, // √2 · 0.55 < 0.8: clear of the silhouette
    };
    let view = view([3.0, 2.0, 1.0], [0.0; 3], [0.0, 0.0, 1.0], projection, 24);
    let error = |n: usize| {
        let image = reference(&ball(n), &look)
            .render_exact(&view)
            .expect("a valid view");
        assert_eq!(image.inconsistent_pixels, 0);
        let mut sum = 0.0;
        for row in 0..view.height {
            for column in 0..view.width {
                let ray = view.ray(column, row);
                let rho = ray.origin.cross(ray.direction).length_squared();
                sum += (image.pixel(column, row)[0] - 2.0 * (1.0 - rho).sqrt()).powi(2);
            }
        }
        sum.sqrt()
    };
    let (coarse, fine) = (error(16), error(32));
    let order = (coarse / fine).log2();
    assert!(
        (1.8..2.2).contains(&order),
        "order {order}: {coarse} to {fine}"
    );
}

// Light that nothing hides: in parallel rays the image's sum times a pixel's area is
// Σ V · mean(c σ) over cells, from every side. The field is a hat over one point, so
// the picture is continuous and the midpoint rule of step h errs by about (h/w)²
// of the sum on a support of width w = 1/2.
#[test]
fn emission_sums_to_the_same_from_every_side() {
    let n = 4;
    let hat = |p: DVec3| if p == DVec3::splat(0.5) { 1.0 } else { 0.0 };
    let cube = cube(n, hat);
    let total: f64 = (0..cube.cell_count())
        .map(|cell| {
            let [a, b, c, d] = cube.cell_points(cell);
            let volume = (b - a).dot((c - a).cross(d - a)).abs() / 6.0;
            volume * cube.cell_scalars(cell).iter().sum::<f64>() / 4.0
        })
        .sum();
    let knots = vec![knot(0.0, [1.0; 3], 0.0), knot(1.0, [1.0; 3], 1.0)];
    let truth = reference(&cube, &appearance(knots, OpticalModel::Emission));
    let (size, half) = (96, 0.5);
    let step = 2.0 * half / f64::from(size);
    for eye in [
        [2.3, 1.1, -1.7],
        [0.5, 0.5, -2.0],
        [2.5, 2.5, 2.5],
        [0.4, -3.0, 0.9],
    ] {
        let projection = Projection::Orthographic {
            parallel_scale: half,
        };
        let view = view(eye, [0.5; 3], [0.1, 0.9, 0.2], projection, size);
        let image = truth.render_exact(&view).expect("a valid view");
        let sum: f64 = image.pixels.iter().map(|p| p[0]).sum::<f64>() * step * step;
        let error = (sum / total - 1.0).abs();
        assert!(error <= (step / 0.5).powi(2), "from {eye:?}: {error:e}");
    }
}
