//! Voxels of the device against those of the CPU.

use std::sync::Arc;

use tetrascope_core::Scalars;
use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::grid::Interpolation;
use tetrascope_core::mesh::{Association, Split};
use tetrascope_testing::{gpu, kuhn, mesh};

use super::*;
use crate::offsets::Offsets;
use crate::{Columns, VoxelizerOptions};

/// Voxels of some lattice, turned, flipped where `flipped`, of `dims`, around `center`.
fn lattice(dims: [usize; 3], center: DVec3, side: f64, turned: bool, flipped: bool) -> Lattice {
    let rotation = match turned {
        true => DMat3::from_quat(DQuat::from_xyzw(0.3, -0.5, 0.2, 0.7).normalize()),
        false => DMat3::IDENTITY,
    };
    let mirror = DVec3::new(if flipped { -1.0 } else { 1.0 }, 1.0, 1.0);
    let direction = rotation * DMat3::from_diagonal(mirror);
    let half = DVec3::from_array(dims.map(|d| 0.5 * (d as f64 - 1.0)));
    Lattice {
        dims,
        origin: center - direction * (side * half),
        spacing: DVec3::splat(side),
        direction,
        interpolation: Interpolation::Nearest,
    }
}

fn field(p: DVec3) -> f64 {
    (3.0 * p.x).sin() + p.y * p.z
}

/// Asserts that both make the same, in every part of the volume and however work is divided.
fn assert_same(gpu: &Gpu, mesh: &TetMesh, lattice: &Lattice, options: VoxelizerOptions) {
    let voxelizer = Voxelizer::new(options).expect("valid options");
    let expected = voxelizer.voxelize(mesh, lattice).expect("voxels");
    let [nx, ny, _] = lattice.dims;
    for (small, layers, wide) in [(COLUMN_CELL_PASSES, 1 << 20, false), (1, 3, true)] {
        let tuning = Tuning {
            small,
            part: SUM_BYTES * (nx * ny * layers) as u64,
            wide,
        };
        let device = DeviceVoxelizer::tuned(gpu, &voxelizer, mesh, lattice, tuning);
        let found = device.and_then(|d| d.voxels()).expect("voxels");
        assert!(
            found.writes() == expected.writes(),
            "{options:?} {tuning:?}"
        );
        assert!(
            found.voxels() == expected.voxels(),
            "{options:?} {tuning:?}"
        );
        let cells = |c: &Counts| {
            (
                [c.cells, c.outside, c.without_value],
                [c.degenerate, c.inverted, c.writes],
            )
        };
        assert_eq!(cells(found.counts()), cells(expected.counts()));
    }
}

#[test]
fn integers_are_those_of_the_cpu() {
    let Some(gpu) = gpu("integers_are_those_of_the_cpu") else {
        return;
    };
    let cubes = mesh(kuhn(5, DVec3::ZERO, DVec3::ONE, |_| true), field);
    for (turned, flipped) in [(false, false), (true, false), (true, true), (false, true)] {
        for (first_voxel, columns, dims) in [
            (FirstVoxel::Interpolated, Columns::Z, [20, 17, 19]),
            (FirstVoxel::Rounded, Columns::Longest, [23, 17, 19]),
            (FirstVoxel::Rounded, Columns::Longest, [20, 23, 19]),
        ] {
            let place = lattice(dims, DVec3::splat(0.5), 0.06, turned, flipped);
            let options = VoxelizerOptions {
                first_voxel,
                columns,
                ..VoxelizerOptions::default()
            };
            assert_same(&gpu, &cubes, &place, options);
        }
    }
}

#[test]
fn samples_of_a_voxel_are_added_up() {
    let Some(gpu) = gpu("samples_of_a_voxel_are_added_up") else {
        return;
    };
    let cubes = mesh(kuhn(3, DVec3::ZERO, DVec3::ONE, |_| true), field);
    let place = lattice([9, 8, 7], DVec3::splat(0.6), 0.13, true, false);
    for offsets in [Offsets::Regular(3), Offsets::Uniform { count: 5, seed: 1 }] {
        let options = VoxelizerOptions {
            offsets,
            ..VoxelizerOptions::default()
        };
        assert_same(&gpu, &cubes, &place, options);
    }
}

/// Hexahedra of a warped lattice, some of them mirrored, then a wedge and a pyramid beside them.
fn polyhedra(association: Association) -> TetMesh {
    let n = 4;
    let place = |i: usize, j: usize, k: usize| {
        let p = DVec3::new(i as f64, j as f64, k as f64) / (n - 1) as f64;
        let bend = DVec3::new((5.0 * p.y).sin(), (4.0 * p.z).cos(), (6.0 * p.x).sin());
        p + 0.04 * bend
    };
    let mut points = Vec::new();
    for k in 0..n {
        for j in 0..n {
            points.extend((0..n).map(|i| place(i, j, k)));
        }
    }
    let at = |i: usize, j: usize, k: usize| (i + n * (j + n * k)) as u64;
    let (mut types, mut offsets, mut connectivity) = (vec![], vec![0], vec![]);
    let mut add = |cell_type: u8, corners: &[u64]| {
        types.push(cell_type);
        connectivity.extend_from_slice(corners);
        offsets.push(connectivity.len() as u64);
    };
    for k in 0..n - 1 {
        for j in 0..n - 1 {
            for i in 0..n - 1 {
                let ring = |k| {
                    [
                        at(i, j, k),
                        at(i + 1, j, k),
                        at(i + 1, j + 1, k),
                        at(i, j + 1, k),
                    ]
                };
                let (mut low, mut high) = (ring(k), ring(k + 1));
                if (i + j + k) % 3 == 0 {
                    std::mem::swap(&mut low, &mut high);
                }
                add(12, &[low, high].concat());
            }
        }
    }
    let first = points.len() as u64;
    points.extend([
        DVec3::new(1.2, 0.1, 0.1),
        DVec3::new(1.6, 0.2, 0.0),
        DVec3::new(1.3, 0.7, 0.1),
        DVec3::new(1.2, 0.1, 0.5),
        DVec3::new(1.7, 0.2, 0.6),
        DVec3::new(1.4, 0.8, 0.5),
        DVec3::new(1.5, 0.3, 1.0),
    ]);
    add(13, &[0, 1, 2, 3, 4, 5].map(|i| first + i));
    add(14, &[0, 3, 4, 1, 6].map(|i| first + i));
    let values = match association {
        Association::Point => points.iter().map(|p| field(*p)).collect(),
        Association::Cell => (0..types.len()).map(|i| (i * 7 % 11) as f64).collect(),
    };
    let scalars = Scalars {
        name: "f".into(),
        association,
        values,
    };
    let cells = tetrascope_core::Cells {
        types,
        offsets,
        connectivity,
    };
    let mesh = TetMesh::keeping_cells(points, Arc::new(cells), scalars, Split::default());
    mesh.expect("a mesh")
}

#[test]
fn cells_as_given_are_those_of_the_cpu() {
    let Some(gpu) = gpu("cells_as_given_are_those_of_the_cpu") else {
        return;
    };
    for association in [Association::Point, Association::Cell] {
        let mesh = polyhedra(association);
        for (cells, samples) in [
            (Cells::AsGiven, 1),
            (Cells::AsGiven, 2),
            (Cells::Tetrahedra, 1),
        ] {
            let place = lattice([22, 15, 17], DVec3::new(0.8, 0.5, 0.5), 0.08, true, false);
            let options = VoxelizerOptions {
                cells,
                offsets: Offsets::Regular(samples),
                ..VoxelizerOptions::default()
            };
            assert_same(&gpu, &mesh, &place, options);
        }
    }
}

/// Cells without a value, without volume, inside out once snapped, out of reach, and overlapping ones:
/// each is left out, or written, as on the CPU.
#[test]
fn cells_of_every_kind_are_told_apart() {
    let Some(gpu) = gpu("cells_of_every_kind_are_told_apart") else {
        return;
    };
    let mut state = 7_u64;
    // A linear congruential generator, with Knuth's numbers for MMIX.
    let mut number = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut points = Vec::new();
    for cell in 0..400 {
        let corner = DVec3::new(number(), number(), number()) * 3.0 - 1.0;
        let size = [0.8, 0.1, 3e-4, 2e-3][cell % 4];
        // The corners of some lie in a plane.
        let flat = if cell % 7 == 0 { 0.0 } else { 1.0 };
        points.push(corner);
        for _ in 0..3 {
            points.push(corner + DVec3::new(number(), number(), number() * flat) * size);
        }
    }
    let values = points.iter().enumerate().map(|(i, p)| match i % 97 {
        5 => f64::NAN,
        _ => field(*p),
    });
    let scalars = Scalars {
        name: "f".into(),
        association: Association::Point,
        values: values.collect(),
    };
    let cells = (0..400).map(|i| [0, 1, 2, 3].map(|c| 4 * i + c)).collect();
    let mesh = TetMesh::from_tetrahedra(points, cells, scalars).expect("a mesh");
    let place = lattice([24, 20, 18], DVec3::splat(0.4), 0.12, true, false);
    let voxels =
        Voxelizer::new(VoxelizerOptions::default()).and_then(|v| v.voxelize(&mesh, &place));
    let counts = *voxels.expect("voxels").counts();
    assert!(counts.outside > 9 && counts.without_value > 9, "{counts:?}");
    assert!(counts.degenerate > 9 && counts.inverted > 3, "{counts:?}");
    assert_same(&gpu, &mesh, &place, VoxelizerOptions::default());
}

/// Scalars to 10⁻⁶ of the range. Which voxels are in the mesh may differ where a center is on a face but
/// for what floats round: 10⁻⁶ voxels or so, so of turned meshes nowhere; and every one of them is
/// written.
#[test]
fn floats_are_those_of_the_cpu_but_for_rounding() {
    let Some(gpu) = gpu("floats_are_those_of_the_cpu_but_for_rounding") else {
        return;
    };
    let cubes = mesh(kuhn(5, DVec3::ZERO, DVec3::ONE, |_| true), field);
    for (turned, flipped, first_voxel, samples) in [
        (true, false, FirstVoxel::Interpolated, 1),
        (true, true, FirstVoxel::Interpolated, 2),
        (true, false, FirstVoxel::Rounded, 1),
    ] {
        // No center on a face.
        let place = lattice(
            [20, 23, 19],
            DVec3::new(0.503, 0.501, 0.5017),
            0.06,
            turned,
            flipped,
        );
        let options = VoxelizerOptions {
            arithmetic: Arithmetic::Float,
            columns: Columns::Longest,
            first_voxel,
            offsets: Offsets::Regular(samples),
            ..VoxelizerOptions::default()
        };
        let voxelizer = Voxelizer::new(options).expect("valid options");
        let expected = voxelizer.voxelize(&cubes, &place).expect("voxels");
        let made = DeviceVoxelizer::new(&gpu, &voxelizer, &cubes, &place);
        let found = made.and_then(|d| d.voxels()).expect("voxels");
        assert!(found.writes() == expected.writes(), "{options:?}");
        let (low, high) = expected.scalar_range();
        let count = expected.writes().len();
        let errors = (0..count).filter_map(|i| Some(found.scalar(i)? - expected.scalar(i)?));
        let worst = errors.fold(0.0, |worst: f64, e| worst.max(e.abs())) / (high - low);
        eprintln!("{worst:e}");
        assert!(worst < 1e-6, "{worst:e}");
    }
    // A lattice that is aligned with the mesh, the worst case for ties: every center once.
    let place = lattice([20, 20, 20], DVec3::splat(0.5), 0.05, false, false);
    let voxelizer = Voxelizer::new(VoxelizerOptions {
        arithmetic: Arithmetic::Float,
        ..VoxelizerOptions::default()
    });
    let voxelizer = voxelizer.expect("valid options");
    let made = DeviceVoxelizer::new(&gpu, &voxelizer, &cubes, &place);
    let found = made.and_then(|d| d.voxels()).expect("voxels");
    assert!(found.writes().iter().all(|writes| *writes == 1));
}

/// The texture holds what is read back: coverage to the last bit, scalars but for what f32 rounds of the
/// mean's share, three times 2⁻²⁴ or so, and of both ends; with few bits a share beside a tie may be the
/// next step. Also for the widest range that there is.
#[test]
fn the_texture_holds_the_voxels() {
    let Some(gpu) = gpu("the_texture_holds_the_voxels") else {
        return;
    };
    for unit in [1.0, 1.5e38] {
        let cubes = mesh(kuhn(4, DVec3::ZERO, DVec3::ONE, |_| true), |p| {
            unit * field(p)
        });
        let place = lattice([14, 19, 12], DVec3::splat(0.52), 0.09, true, false);
        for (voxel_size, steps) in [
            (VoxelSize::Float, None),
            (VoxelSize::Bits8, Some(255.0)),
            (VoxelSize::Bits16, Some(65535.0)),
        ] {
            let options = VoxelizerOptions {
                voxel_size,
                columns: Columns::Longest,
                offsets: Offsets::Regular(2),
                ..VoxelizerOptions::default()
            };
            let voxelizer = Voxelizer::new(options).expect("valid options");
            let expected = voxelizer.voxelize(&cubes, &place).expect("voxels");
            let made = DeviceVoxelizer::new(&gpu, &voxelizer, &cubes, &place).expect("it fits");
            let mut encoder = made.encoder();
            made.encode(&mut encoder);
            let copy = read_back(&gpu, &mut encoder, Source::Texture(made.grid().texture()));
            gpu.finish(encoder).expect("done");
            let texels: Vec<[f32; 2]> = copy.and_then(|c| c.read()).expect("texels");
            let (low, high) = expected.scalar_range();
            let rounding =
                8.0 * f64::from(f32::EPSILON) * (high - low).max(high.abs().max(low.abs()));
            let mut beside = 0;
            for (index, [scalar, coverage]) in texels.iter().enumerate() {
                assert_eq!(*coverage, expected.coverage(index));
                let Some(truth) = expected.scalar(index) else {
                    continue;
                };
                let error = (f64::from(*scalar) - truth).abs();
                let step = steps.map_or(0.0, |steps| (high - low) / steps);
                assert!(error <= rounding + step, "{voxel_size:?} {error:e}");
                beside += usize::from(error > rounding);
            }
            assert!(beside * 50 < texels.len(), "{beside}");
        }
    }
}
