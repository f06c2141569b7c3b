//! Pictures from tables of integrals against the ground truth.

use tetrascope_core::glam::DVec3;
use tetrascope_core::{Appearance, Frame, Knot, OpticalModel, TransferFunction, View, Volume};
use tetrascope_gpu::{Gpu, Integration};
use tetrascope_projection::{Order, ProjectionOptions};
use tetrascope_testing::{self as testing, between};

use crate::common::{crooked, drawn, mesh, truth};

/// Greatest extinction times the mesh's diagonal.
const DEPTH: f64 = 4.0;

/// Intervals of [`smooth`].
const KNOTS: u32 = 256;

/// Half a wave of extinction and waves of color over the scalars of `volume`, with so
/// many knots that no table sees corners.
fn smooth(volume: &Volume) -> TransferFunction {
    let (low, high) = volume.scalar_range().expect("scalars");
    let knots = (0..=KNOTS).map(|k| {
        let x = f64::from(k) / f64::from(KNOTS);
        let wave = |at: f64| 0.5 + 0.5 * (std::f64::consts::TAU * (0.5 * x + at)).sin();
        Knot {
            scalar: low + (high - low) * x,
            color: DVec3::new(wave(0.0), wave(0.3), wave(0.7)),
            extinction: DEPTH / volume.bounds().diagonal() * wave(0.85),
        }
    });
    TransferFunction::new(knots.collect()).expect("sorted")
}

fn tabled(
    gpu: &Gpu,
    volume: &Volume,
    appearance: &Appearance,
    integration: Integration,
    view: &View,
) -> Frame {
    let options = ProjectionOptions {
        integration,
        order: Order::PerPixel,
        ..ProjectionOptions::default()
    };
    drawn(gpu, volume, appearance, view, &options)
}

/// The longest edge over the diagonal.
fn longest(volume: &Volume) -> f64 {
    let Volume::Mesh(mesh) = volume else {
        panic!("a mesh");
    };
    let edges = (0..mesh.cell_count()).flat_map(|cell| {
        let p = mesh.cell_points(cell);
        [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)].map(|(i, j)| p[i].distance(p[j]))
    });
    edges.fold(0.0, f64::max) / volume.bounds().diagonal()
}

/// A bound of the error of any pixel, for the transfer function [`smooth`].
///
/// With scalars in [0, 1] and the diagonal as the unit of length, extinction is at most
/// Σ = [`DEPTH`] and bends by at most Σ π²/2; its product with color by at most
/// Σ (π²/2 + 2 (π/2)² + π²/2). Bilinear interpolation of a mean over an interval, which bends
/// a third as much as the function with either end, errs by at most h²/12 of that, where
/// h = 1/(n − 1); as the function bends in [`KNOTS`] corners, by h (h + 1/KNOTS)/12. That is
/// per unit of length. Along the length, in steps of λh (λ the longest edge), interpolation
/// of an opacity loses at most Σ² l λh/2, and as much light where colors are at most 1.
/// A ray's segments have lengths of at most 1 in sum; an error of opacity reaches a channel
/// that is at most 1 once in the segment and once in what is behind it.
fn bound(model: OpticalModel, integration: Integration, longest: f64) -> f64 {
    use std::f64::consts::PI;
    let (n, steps) = match integration {
        Integration::Table2d { n } => (n, 0.0),
        Integration::Table3d { n } => (n, longest),
        _ => return 0.0,
    };
    let h = 1.0 / f64::from(n - 1);
    let means = h * (h + 1.0 / f64::from(KNOTS)) / 12.0 * DEPTH * PI * PI;
    let depth = means / 2.0;
    let shallow = DEPTH * DEPTH * steps * h / 2.0;
    match model {
        OpticalModel::Emission => 1.5 * means,
        // A maximum changes as fast as the color with either end, by up to π/2, and has
        // corners; samples are on average at most h/2 from either.
        OpticalModel::MaximumIntensity => PI / 2.0 * h,
        OpticalModel::Absorption => depth + shallow,
        _ => 1.5 * means + depth + 2.0 * shallow,
    }
}

#[test]
fn pictures_from_tables_are_within_the_bound_of_their_samples() {
    let Some(gpu) = testing::gpu("pictures_from_tables_are_within_the_bound_of_their_samples")
    else {
        return;
    };
    for name in ["sphere", "heat-sink", "graded"] {
        let volume = mesh(name, 1500);
        let longest = longest(&volume);
        for optical_model in OpticalModel::VOLUMETRIC {
            let appearance = Appearance::new(smooth(&volume), optical_model);
            for (orthographic, n) in [(false, 16), (true, 64)] {
                let view = crooked(&volume, orthographic, 64);
                let truth = truth(&volume, &appearance, &view);
                let two = Integration::Table2d { n };
                let three = Integration::Table3d { n };
                let tables = match optical_model {
                    OpticalModel::EmissionAbsorption => vec![three],
                    OpticalModel::Absorption => vec![two, three],
                    _ => vec![two],
                };
                for integration in tables {
                    let frame = tabled(&gpu, &volume, &appearance, integration, &view);
                    let (rms, greatest) = between(&frame, &truth);
                    let bound = bound(optical_model, integration, longest);
                    let subject = format!("{name} {optical_model:?} {integration:?}");
                    eprintln!("{subject}: RMSE {rms:.1e}, max {greatest:.1e}, bound {bound:.1e}");
                    assert!(greatest <= bound, "{subject}");
                    // Rounding alone is under this: the table was used.
                    assert!(greatest > 2e-6, "{subject}");
                }
            }
        }
    }
}

// Second order in the picture too. Along the length that holds where segments are longer
// than its samples are apart, as on this mesh of cells of one size; 5 % of the exponent is
// the share of those that are not, and of rounding at the last.
#[test]
fn pictures_converge_in_second_order() {
    let Some(gpu) = testing::gpu("pictures_converge_in_second_order") else {
        return;
    };
    let volume = mesh("sphere", 1500);
    let view = crooked(&volume, false, 64);
    type OfSide = fn(u32) -> Integration;
    let cases: [(OpticalModel, OfSide); 4] = [
        (OpticalModel::Emission, |n| Integration::Table2d { n }),
        (OpticalModel::Absorption, |n| Integration::Table2d { n }),
        (OpticalModel::Absorption, |n| Integration::Table3d { n }),
        (OpticalModel::EmissionAbsorption, |n| Integration::Table3d {
            n,
        }),
    ];
    for (optical_model, table) in cases {
        let appearance = Appearance::new(smooth(&volume), optical_model);
        let truth = truth(&volume, &appearance, &view);
        let errors = [9, 17, 33, 65].map(|n| {
            let frame = tabled(&gpu, &volume, &appearance, table(n), &view);
            between(&frame, &truth).0
        });
        let order = (errors[0] / errors[3]).log2() / 3.0;
        eprintln!(
            "{optical_model:?} {:?}: {errors:?}, order {order:.2}",
            table(9)
        );
        assert!((order - 2.0).abs() <= 0.1, "{optical_model:?}: {order}");
    }
}
