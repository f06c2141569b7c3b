//! Scenes with a closed form.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Appearance, OpticalModel, TransferFunction, Volume};
use tetrascope_testing::{Place, grid, knot};

use super::bench::{along_z, drawn, white_surface};

/// f32 pixels round to 2⁻²⁵, and parts of cells to as much each; their depths are compensated.
const BOUND: f64 = 4e-7;

fn near(got: [f32; 4], want: [f64; 4]) {
    for channel in 0..4 {
        let off = (f64::from(got[channel]) - want[channel]).abs();
        assert!(off < BOUND, "{got:?} {want:?}");
    }
}

// Uniform σ over a length of 1: α = 1 − e^(−σ), and light of one color c is c α.
#[test]
fn a_constant_field_is_beers_law() {
    let volume = Volume::Grid(grid(&Place::unit(7), |_| 0.5));
    let view = along_z(DVec3::new(0.5, 0.5, 0.5), 0.4, 9);
    for sigma in [1e-6, 0.01, 1.0, 6.0, 1e3, 1e20] {
        let knots = vec![knot(0.5, [0.9, 0.6, 0.3], sigma)];
        let function = TransferFunction::new(knots).expect("a knot");
        let background = view.premultiplied_background();
        let alpha = -(-sigma).exp_m1();
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Absorption] {
            let frame = drawn(&volume, &Appearance::new(function.clone(), model), &view);
            let glow = if model == OpticalModel::Absorption {
                0.0
            } else {
                alpha
            };
            let light = |c: f64, b: f64| glow * c + (1.0 - alpha) * b;
            let want = [
                light(0.9, background[0]),
                light(0.6, background[1]),
                light(0.3, background[2]),
                alpha + (1.0 - alpha) * background[3],
            ];
            for pixel in frame.pixels {
                near(pixel, want);
            }
        }
    }
}

// On a step both sides count half.
#[test]
fn a_constant_on_a_step_is_its_mean() {
    let volume = Volume::Grid(grid(&Place::unit(4), |_| 0.5));
    let view = along_z(DVec3::splat(0.5), 0.4, 5);
    let knots = vec![
        knot(0.0, [0.0; 3], 0.0),
        knot(0.5, [0.0; 3], 0.0),
        knot(0.5, [1.0, 0.5, 0.0], 3.0),
        knot(1.0, [1.0, 0.5, 0.0], 3.0),
    ];
    let function = TransferFunction::new(knots).expect("knots");
    let look = Appearance::new(function, OpticalModel::EmissionAbsorption);
    let alpha = -(-1.5f64).exp_m1();
    let background = view.premultiplied_background();
    let light = |c: f64, b: f64| alpha * c + (1.0 - alpha) * b;
    for pixel in drawn(&volume, &look, &view).pixels {
        near(
            pixel,
            [
                light(0.5, background[0]),
                light(0.25, background[1]),
                light(0.0, background[2]),
                alpha + (1.0 - alpha) * background[3],
            ],
        );
    }
}

// The scalar is z, and so are extinction over 4 and color. Seen from z = 1 down: with u = 1 − z,
// τ(u) = 4 (u − u²/2), so α = 1 − e^(−2), and the light ∫ z 4 z e^(−τ) du = [−z e^(−τ)] − ∫ e^(−τ) du
// = 1 − ∫₀¹ e^(−2 + 2 z²) dz = 1 − D(√2)/√2 with Dawson's integral D, e^(−x²) ∫₀ˣ e^(t²) dt.
#[test]
fn a_linear_ramp_is_dawsons_integral() {
    let volume = Volume::Grid(grid(&Place::unit(8), |p| p.z));
    let view = along_z(DVec3::splat(0.5), 0.4, 7);
    let function = vec![knot(0.0, [0.0; 3], 0.0), knot(1.0, [1.0; 3], 4.0)];
    let function = TransferFunction::new(function).expect("knots");
    // By the midpoint rule with 2²⁰ steps, which is off by less than 1e-12.
    let steps = 1 << 20;
    let midpoints = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps));
    let mean = midpoints.map(|z| (2.0 * z * z - 2.0).exp()).sum::<f64>() / f64::from(steps);
    let (light, passed) = (1.0 - mean, (-2.0f64).exp());
    let background = view.premultiplied_background();
    let look = Appearance::new(function.clone(), OpticalModel::EmissionAbsorption);
    for pixel in drawn(&volume, &look, &view).pixels {
        near(
            pixel,
            [
                light + passed * background[0],
                light + passed * background[1],
                light + passed * background[2],
                1.0 - passed + passed * background[3],
            ],
        );
    }
    // ∫ 4 z² dz = 4/3, and the greatest color is 1.
    for (model, light) in [
        (OpticalModel::Emission, 4.0 / 3.0 + background[0]),
        (OpticalModel::MaximumIntensity, 1.0),
    ] {
        let look = Appearance::new(function.clone(), model);
        for pixel in drawn(&volume, &look, &view).pixels {
            assert!(
                (f64::from(pixel[0]) - light).abs() < BOUND,
                "{model:?} {pixel:?}"
            );
        }
    }
}

// The plane z = 0.3, seen face-on from z = 10.5, has its own color, and lies 10.2 away.
#[test]
fn a_flat_surface_is_where_it_is() {
    let volume = Volume::Grid(grid(&Place::unit(5), |p| p.z));
    let view = along_z(DVec3::splat(0.5), 0.4, 7);
    let function = TransferFunction::new(vec![knot(0.0, [0.0; 3], 0.0)]).expect("a knot");
    let mut look = Appearance::new(function, OpticalModel::Isosurfaces);
    look.isosurfaces = vec![white_surface(0.3)];
    let frame = drawn(&volume, &look, &view);
    for depth in frame.depths.expect("depths") {
        // Samples in f32 move the plane by 2⁻²⁵, and the depth rounds to 2⁻²².
        assert!((f64::from(depth) - 10.2).abs() < 1e-6, "{depth}");
    }
    for pixel in frame.pixels {
        near(pixel, [1.0; 4]);
    }
}
