//! Grids at the edge of what is one.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice, Samples};
use tetrascope_core::{Appearance, CameraFit, Grid, OpticalModel, TransferFunction, Volume};
use tetrascope_testing::{fitted, knot};

use super::bench::{SLOPE, STEPS, check, drawn, look, samples, views, wave};

fn volume(lattice: Lattice, samples: Samples) -> Volume {
    Volume::Grid(Grid::on(lattice, samples).expect("a grid"))
}

fn lattice(dims: [usize; 3], spacing: f64, interpolation: Interpolation) -> Lattice {
    Lattice {
        dims,
        origin: DVec3::splat(-spacing),
        spacing: DVec3::splat(spacing),
        direction: DMat3::IDENTITY,
        interpolation,
    }
}

/// As for smooth fields in `models`.
const SMOOTH: [f64; 2] = [2e-6, 3e-7];

#[test]
fn thin_grids_are_drawn() {
    for dims in [[1, 1, 1], [1, 9, 70], [200, 1, 1], [3, 1, 5]] {
        let volume = volume(
            lattice(dims, 0.25, Interpolation::Nearest),
            samples(dims, "u8", wave),
        );
        for model in OpticalModel::ALL {
            let look = look(&volume, &SLOPE, model);
            for view in views(&volume, 24) {
                check(
                    &format!("{dims:?} {model:?}"),
                    (&volume, &look, &view),
                    SMOOTH,
                );
            }
        }
    }
    for dims in [[2, 2, 2], [2, 9, 140], [300, 2, 2]] {
        let volume = volume(
            lattice(dims, 0.25, Interpolation::Linear),
            samples(dims, "f32", wave),
        );
        for model in [OpticalModel::EmissionAbsorption, OpticalModel::Emission] {
            let look = look(&volume, &SLOPE, model);
            for view in views(&volume, 24) {
                check(
                    &format!("{dims:?} {model:?}"),
                    (&volume, &look, &view),
                    SMOOTH,
                );
            }
        }
    }
}

// A grid looks the same however large it is; 1e-30 and less squared underflow.
#[test]
fn tiny_and_huge_grids_look_the_same() {
    let dims = [9, 8, 11];
    for spacing in [1e-150, 1e-30, 1e-6, 1e6, 1e30, 1e100] {
        let volume = volume(
            lattice(dims, spacing, Interpolation::Linear),
            samples(dims, "u8", wave),
        );
        for model in OpticalModel::ALL {
            // Sums of light do not fit f32 where lengths do not: `validate_in` refuses.
            let look = look(&volume, &SLOPE, model);
            let view = fitted(&volume, CameraFit::PlusIso, false, 24);
            check(
                &format!("{spacing:e} {model:?}"),
                (&volume, &look, &view),
                SMOOTH,
            );
        }
    }
}

// Scalars up to the greatest float, next to small ones.
#[test]
fn huge_values_are_drawn() {
    let dims = [6, 6, 6];
    for huge in [1e10, 1e30, 3e38] {
        let values = (0..216).map(|i| match i % 5 {
            0 => huge,
            1 => -huge,
            _ => 0.1 * (i % 11) as f32,
        });
        let volume = volume(
            lattice(dims, 1.0, Interpolation::Linear),
            Samples::F32(values.collect()),
        );
        for knots in [&SLOPE[..], &STEPS[..]] {
            for model in OpticalModel::VOLUMETRIC {
                let look = look(&volume, knots, model);
                let view = fitted(&volume, CameraFit::PlusIso, false, 24);
                // As steps in `models`.
                check(
                    &format!("{huge:e} {model:?}"),
                    (&volume, &look, &view),
                    [1e-4, 3e-6],
                );
            }
        }
        // A function of the small ones alone: they take 1e-10 of a cell.
        let knots = vec![
            knot(0.0, [0.0; 3], 0.0),
            knot(0.5, [1.0; 3], 2.0),
            knot(1.0, [0.0; 3], 0.0),
        ];
        let function = TransferFunction::new(knots).expect("knots");
        let look = Appearance::new(function, OpticalModel::EmissionAbsorption);
        let view = fitted(&volume, CameraFit::PlusIso, false, 24);
        check(
            &format!("{huge:e} small"),
            (&volume, &look, &view),
            [1e-4, 3e-6],
        );
    }
}

#[test]
fn without_any_value_nothing_shows() {
    let dims = [5, 5, 5];
    let volume = volume(
        lattice(dims, 1.0, Interpolation::Linear),
        Samples::F32(vec![f32::NAN; 125]),
    );
    let function = TransferFunction::new(vec![knot(0.0, [1.0; 3], 1.0)]).expect("a knot");
    for model in OpticalModel::ALL {
        let look = Appearance::new(function.clone(), model);
        let view = fitted(&volume, CameraFit::PlusIso, false, 8);
        let frame = drawn(&volume, &look, &view);
        let background = view.premultiplied_background().map(|c| c as f32);
        assert!(frame.pixels.iter().all(|p| *p == background), "{model:?}");
    }
}

// Extinctions that hide within a ten-thousandth of a cell, and such that never do.
#[test]
fn extinctions_of_any_size_end() {
    let dims = [9, 8, 11];
    let volume = volume(
        lattice(dims, 1.0, Interpolation::Linear),
        samples(dims, "f32", wave),
    );
    for depth in [1e-12, 1e3, 1e6, 1e12, 1e30] {
        let knots = [
            (0.0, [0.2, 0.9, 0.1], 0.0),
            (0.5, [0.9, 0.1, 0.4], depth),
            (1.0, [0.1, 0.3, 1.0], 0.5 * depth),
        ];
        let look = look(&volume, &knots, OpticalModel::EmissionAbsorption);
        let view = fitted(&volume, CameraFit::PlusIso, false, 24);
        // A scalar that rounds by 2⁻²⁴ of the range is a depth of as much, so that in dense
        // media light comes from as far off: colors move by less than 1e-5 for it.
        check(&format!("{depth:e}"), (&volume, &look, &view), [2e-5, 2e-6]);
    }
}
