//! Scenes with a closed-form answer, to 1e-10 and to the error bound that comes
//! with each pixel.

use crate::scenes::*;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{OpticalModel, Projection, Ray, TetMesh, View};
use tetrascope_reference::ReferenceImage;

/// Compares all pixels whose ray is not within 1e-9 of the box's silhouette,
/// where rounding decides whether the box is met at all.
fn check(image: &ReferenceImage, view: &View, expected: impl Fn(&Ray) -> [f64; 4]) {
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
    assert_eq!(image.inconsistent_pixels, 0);
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
    for model in OpticalModel::ALL {
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
