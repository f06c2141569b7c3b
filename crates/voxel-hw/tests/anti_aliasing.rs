//! Errors of voxels, and how they fall with the number of samples.

mod common;

use std::sync::OnceLock;

use common::{FIXED_AND_FLOAT, field};
use tetrascope_core::TetMesh;
use tetrascope_core::glam::DVec3;
use tetrascope_testing::{kuhn, mesh};
use tetrascope_voxel_hw::errors::exact_coverage;
use tetrascope_voxel_hw::{Arithmetic, Offsets, VoxelErrors, VoxelizerOptions};

const DIMS: [usize; 3] = [40; 3];

/// A box of eight lattice cells, turned.
fn turned_box(seed: u64) -> TetMesh {
    let turn = common::rotation(seed);
    let (points, cells) = kuhn(2, DVec3::splat(-1.0), DVec3::ONE, |_| true);
    let size = DVec3::new(11.0, 10.0, 9.0);
    let points = points.iter().map(|p| turn * (*p * size) + 20.1);
    mesh((points.collect(), cells), field)
}

/// Six of them, with their parts of voxels.
fn meshes() -> &'static [(TetMesh, Vec<f64>)] {
    static MESHES: OnceLock<Vec<(TetMesh, Vec<f64>)>> = OnceLock::new();
    MESHES.get_or_init(|| {
        let measured = |seed| {
            let mesh = turned_box(seed);
            let exact = exact_coverage(&mesh, &common::lattice(DIMS)).expect("memory");
            (mesh, exact)
        };
        (0..6).map(measured).collect()
    })
}

fn errors(arithmetic: Arithmetic, offsets: Offsets) -> Vec<VoxelErrors> {
    let options = VoxelizerOptions {
        offsets,
        ..common::options(arithmetic)
    };
    let measure = |(mesh, exact): &(TetMesh, Vec<f64>)| {
        let volume = common::voxelize(mesh, DIMS, options);
        VoxelErrors::against(&volume, exact, field)
    };
    meshes().iter().map(measure).collect()
}

/// The root of the mean of squares over all meshes.
fn coverage_rms(errors: &[VoxelErrors]) -> f64 {
    let squares: f64 = errors
        .iter()
        .map(|e| e.coverage_rms.powi(2) * e.border as f64)
        .sum();
    let border: usize = errors.iter().map(|e| e.border).sum();
    (squares / border as f64).sqrt()
}

#[test]
fn exact_parts_add_up_to_the_volume() {
    for (mesh, coverage) in meshes() {
        let sum: f64 = coverage.iter().sum();
        // 64 000 parts with errors of at most 10⁻¹³ each, most of which are 0 or 1.
        assert!((sum - mesh.volume()).abs() < 1e-9, "{sum}");
        assert!(coverage.iter().all(|c| (0.0..1.0 + 1e-9).contains(c)));
    }
}

/// See [`tetrascope_voxel_hw::errors`]: n⁻² for planes in general, n⁻¹ for those along an axis. For
/// planes of all directions the RMS is 0.224, 0.0585, 0.0263, 0.0149 and 0.0096 (20 000 of them); ours
/// are 18, and some are nearly along an axis.
#[test]
fn coverage_converges_faster_than_the_samples_along_an_axis() {
    let planes = [0.224, 0.0585, 0.0263, 0.0149, 0.0096];
    for arithmetic in FIXED_AND_FLOAT {
        let mut found = Vec::new();
        for (n, plane) in (1u32..).zip(planes) {
            let errors = errors(arithmetic, Offsets::Regular(n));
            let rms = coverage_rms(&errors);
            let most = errors.iter().map(|e| e.coverage_max).fold(0.0, f64::max);
            let volume = errors.iter().map(|e| e.volume.abs()).fold(0.0, f64::max);
            let missed: usize = errors.iter().map(|e| e.missed).sum();
            println!(
                "{arithmetic:?} {n}: RMS {rms:.4}, most {most:.3}, missed {missed}, volume {volume:.1e}"
            );
            assert!((1.0..1.5).contains(&(rms / plane)), "{n}: {rms} {plane}");
            assert!(errors.iter().all(|e| e.border > 1000 && e.inside > 1000));
            found.push(rms);
        }
        let order = (found[0] / found[4]).ln() / 5f64.ln();
        assert!(order > 1.5, "{order}");
    }
}

/// N random samples have √(c (1 − c) / N) each. In pairs of opposites a plane through the center has
/// one of each pair on either side, so theirs is less. Cut voxels have c (1 − c) of 1/4 at most.
#[test]
fn random_samples_converge_with_their_root() {
    for seed in 1..3 {
        let mut rms = Vec::new();
        for count in [8, 64, 512] {
            let offsets = Offsets::Uniform { count, seed };
            rms.push(coverage_rms(&errors(Arithmetic::FixedPoint, offsets)));
            let most = 0.5 / f64::from(count).sqrt();
            println!("uniform {count}: RMS {:.4}", rms[rms.len() - 1]);
            // Of one set of points for all voxels; 1.5 for its luck.
            assert!(rms[rms.len() - 1] < 1.5 * most, "{count}");
        }
        assert!(rms[2] < rms[1] && rms[1] < rms[0], "{rms:?}");
    }
    // A Gaussian weighs the voxel's middle more, so its coverage is another one: it converges, but not
    // to the share of the volume.
    let of = |count| {
        let offsets = Offsets::Gaussian {
            count,
            deviation: 0.25,
            seed: 1,
        };
        coverage_rms(&errors(Arithmetic::FixedPoint, offsets))
    };
    let (few, many) = (of(8), of(512));
    println!("Gaussian 8: RMS {few:.4}, 512: {many:.4}");
    assert!(many < few && many > 0.01, "{few} {many}");
}

/// The mean of the samples of a whole voxel is the field at its center.
#[test]
fn linear_fields_stay_linear() {
    let offsets = [
        Offsets::Regular(1),
        Offsets::Regular(3),
        Offsets::Regular(5),
        Offsets::Uniform { count: 7, seed: 1 },
        Offsets::Gaussian {
            count: 16,
            deviation: 0.2,
            seed: 1,
        },
    ];
    for arithmetic in FIXED_AND_FLOAT {
        for offsets in offsets {
            for errors in errors(arithmetic, offsets) {
                // Fixed point moves vertices by 2⁻⁹ along each axis, and the slopes' magnitudes add
                // up to 2.1; scalars of a range of 50 have 24 bits. Floats: 24 bits alone.
                let snap = match arithmetic {
                    Arithmetic::FixedPoint => 2.1 * 2f64.powi(-9),
                    Arithmetic::Float => 0.0,
                };
                let bound = snap + 50.0 * 2f64.powi(-23);
                assert!(errors.scalar_max <= bound, "{offsets:?} {errors:?}");
                // Nor is anything found where nothing is, but for snapping.
                assert!(errors.spurious <= usize::from(snap > 0.0) * 8, "{errors:?}");
            }
        }
    }
}

/// A sum over many voxels errs less than each: samples inside are as often too many as too few.
#[test]
fn volumes_are_kept() {
    for (n, most) in [(1, 0.01), (2, 0.003), (4, 0.001)] {
        for errors in errors(Arithmetic::FixedPoint, Offsets::Regular(n)) {
            // About 2000 border voxels with an RMS as above, on a volume of 7920, three deviations:
            // 3 √2000 0.224 / 7920 = 0.004 for one sample, and four times less for two.
            assert!(errors.volume.abs() < most, "{n}: {errors:?}");
        }
    }
}

/// Whole voxels of a mesh without any border have no errors at all.
#[test]
fn aligned_boxes_have_no_errors() {
    let mesh = mesh(kuhn(3, DVec3::ZERO, DVec3::splat(6.0), |_| true), field);
    for n in 1..=5 {
        let options = VoxelizerOptions {
            offsets: Offsets::Regular(n),
            ..VoxelizerOptions::default()
        };
        let volume = common::voxelize(&mesh, [8; 3], options);
        let errors = VoxelErrors::of(&volume, &mesh, field).expect("memory");
        assert_eq!((errors.inside, errors.border), (216, 0));
        assert_eq!((errors.missed, errors.spurious), (0, 0));
        // Exact parts are rounded.
        assert!(
            errors.volume.abs() < 1e-12 && errors.coverage_max < 1e-12,
            "{errors:?}"
        );
    }
}
