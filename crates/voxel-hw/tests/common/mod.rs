//! What tests of voxels share.

use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::{Knot, TetMesh, TransferFunction};
use tetrascope_voxel_hw::{Arithmetic, VoxelVolume, Voxelizer, VoxelizerOptions};

pub(crate) const FIXED_AND_FLOAT: [Arithmetic; 2] = [Arithmetic::FixedPoint, Arithmetic::Float];

/// Unit voxels from the origin.
pub(crate) fn lattice(dims: [usize; 3]) -> Lattice {
    Lattice {
        dims,
        origin: DVec3::splat(0.5),
        spacing: DVec3::ONE,
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Nearest,
    }
}

pub(crate) fn options(arithmetic: Arithmetic) -> VoxelizerOptions {
    VoxelizerOptions {
        arithmetic,
        ..VoxelizerOptions::default()
    }
}

/// The unit voxels of `mesh` from the origin.
pub(crate) fn voxelize(mesh: &TetMesh, dims: [usize; 3], options: VoxelizerOptions) -> VoxelVolume {
    let voxelizer = Voxelizer::new(options).expect("valid options");
    voxelizer.voxelize(mesh, &lattice(dims)).expect("voxels")
}

/// Voxel `index`'s place along the axes.
pub(crate) fn voxel(index: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [index % nx, index / nx % ny, index / (nx * ny)]
}

/// The center of voxel `index` of unit voxels from the origin.
pub(crate) fn center(index: usize, dims: [usize; 3]) -> DVec3 {
    DVec3::from(voxel(index, dims).map(|c| c as f64 + 0.5))
}

pub(crate) fn affine(p: DVec3) -> f64 {
    1.0 + 0.3 * p.x - 0.7 * p.y + 1.1 * p.z
}

/// Some rotation.
pub(crate) fn rotation(seed: u64) -> DMat3 {
    let mut random = random(seed);
    let quaternion = DQuat::from_xyzw(random(), random(), random(), random());
    DMat3::from_quat(quaternion.normalize())
}

/// Moves the inner vertices of a lattice of n³ cubes by up to `most` along each axis.
pub(crate) fn jitter(points: &mut [DVec3], n: usize, most: f64, seed: u64) {
    let mut random = random(seed);
    let side = n + 1;
    for (i, point) in points.iter_mut().enumerate() {
        let place = [i % side, i / side % side, i / (side * side)];
        if place.iter().all(|c| (1..n).contains(c)) {
            *point += most * DVec3::new(random(), random(), random());
        }
    }
}

/// Numbers in [−1, 1): SplitMix64 (G. Steele, D. Lea, C. Flood, 2014).
pub(crate) fn random(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// One color, and extinction by scalar.
pub(crate) fn transfer_function(extinction: &[(f64, f64)]) -> TransferFunction {
    let knot = |&(scalar, extinction): &(f64, f64)| Knot {
        scalar,
        color: DVec3::new(0.5, 0.25, 1.0),
        extinction,
    };
    TransferFunction::new(extinction.iter().map(knot).collect()).expect("knots")
}
