//! `common/optics.wgsl` against `tetrascope_core::optics`, on thousands of segments.

use tetrascope_core::optics::{RayIntegral, Segment};
use tetrascope_core::{OpticalModel, TransferFunction};
use tetrascope_gpu::{Gpu, Integration};
use tetrascope_testing as testing;

use crate::support::{Probe, bumps, random, table};

fn on_device(
    gpu: &Gpu,
    tf: &TransferFunction,
    model: OpticalModel,
    probes: &[Probe],
) -> Vec<([f32; 4], f32)> {
    let none = table(gpu, tf, model, Integration::Exact, 1.0);
    crate::support::on_device(gpu, tf, model, &none, probes)
}

/// Segments with depths from 1e-7 to 1e4, some short in scalar, some constant, and
/// some beyond the transfer function's ends.
fn probes(seed: u32) -> Vec<Probe> {
    let mut next = random(seed);
    (0..4000)
        .map(|i| {
            let front = (1.5 * next() - 0.25) as f32;
            let spread = 10_f64.powf(-6.0 * next()) * (next() - 0.5);
            let back = match i % 8 {
                0 => front,
                1..4 => (1.5 * next() - 0.25) as f32,
                _ => front + spread as f32,
            };
            let length = 10_f64.powf(11.0 * next() - 7.0) as f32;
            Probe {
                front,
                back,
                length,
            }
        })
        .collect()
}

#[test]
fn every_model_matches_the_reference_integral() {
    let Some(gpu) = testing::gpu("every_model_matches_the_reference_integral") else {
        return;
    };
    let probes = probes(1);
    let tf = bumps(1.0);
    for model in OpticalModel::VOLUMETRIC {
        let answers = on_device(&gpu, &tf, model, &probes);
        let mut worst = 0.0_f64;
        for (probe, (answer, opacity)) in probes.iter().zip(&answers) {
            let mut truth = RayIntegral::new(&tf, model);
            truth.add(&Segment {
                front: f64::from(probe.front),
                back: f64::from(probe.back),
                length: f64::from(probe.length),
            });
            let depth = truth.optical_depth();
            let light = truth.light();
            let alpha = -(-depth).exp_m1();
            // Against what the segment could add at most: its opacity, of which colors
            // here are at most a share of 1; its emission; or 1.
            let emission = f64::from(probe.length);
            let (scale, tolerance) = match model {
                // Per piece 3.2e-8 of α by the polynomial and 2e-7 by its few roundings. WGSL's
                // `exp` may be off by 3 + 2 |x| ulp, so e^(−τ) between pieces by
                // 2⁻²⁴ (3 + 2τ) e^(−τ) τ-wise at most 3e-7; sampling σ at f32 scalars
                // and lengths adds 8 ulp of each m, e^(−m) m ≤ 0.37. In sum, for at
                // most 7 pieces that share the opacity: 2.3e-7 + 3e-7 + 2e-7.
                OpticalModel::EmissionAbsorption => (alpha, 8e-7),
                // A few roundings each: 16 ulp of the whole; near a zero of σ the
                // color's share is relative to the length.
                OpticalModel::Emission => (emission, 1e-6),
                OpticalModel::Absorption => (emission, 1e-6),
                // Interpolated in f32 between values at most 1: 4 ulp. A scalar that
                // is rounded to a knot's other side is 2⁻²⁴ off at slopes ≤ 10.
                _ => (1.0, 1e-6),
            };
            let off = (0..3)
                .map(|c| (f64::from(answer[c]) - light[c]).abs())
                .fold(0.0, f64::max);
            let off = match model {
                OpticalModel::Absorption => off.max((f64::from(answer[3]) - depth).abs()),
                OpticalModel::EmissionAbsorption => off.max((f64::from(*opacity) - alpha).abs()),
                _ => off,
            };
            let relative = off / scale;
            worst = worst.max(relative);
            assert!(
                relative <= tolerance,
                "{model:?}: {answer:?} {opacity}, truth {light} {depth}, \
                 front {} back {} length {}: {relative:e}",
                probe.front,
                probe.back,
                probe.length
            );
        }
        eprintln!("{model:?}: worst {worst:e}");
        assert!(worst > 0.0, "f32 is not f64: nothing was compared");
    }
}

#[test]
fn extreme_extinctions_give_numbers() {
    let Some(gpu) = testing::gpu("extreme_extinctions_give_numbers") else {
        return;
    };
    let probes: Vec<Probe> = [0.0, 1e-30, 1e-8, 1.0, 88.0, 1e6, 1e30]
        .into_iter()
        .flat_map(|length| {
            [(0.0, 1.0), (1.0, 0.0), (0.3, 0.3), (0.26, 0.27)].map(|(front, back)| Probe {
                front,
                back,
                length,
            })
        })
        .collect();
    for most in [0.0, 1e-30, 1.0, 1e30] {
        let answers = on_device(
            &gpu,
            &bumps(most),
            OpticalModel::EmissionAbsorption,
            &probes,
        );
        for (probe, (answer, opacity)) in probes.iter().zip(answers) {
            let sane = (0.0..=1.0).contains(&opacity)
                && answer[..3].iter().all(|c| (0.0..=1.0001).contains(c));
            assert!(sane, "{answer:?} {opacity} at {most} and {}", probe.length);
        }
    }
}
