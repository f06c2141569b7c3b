//! Voxels of the device against those of the CPU.

use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::grid::Interpolation;
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
