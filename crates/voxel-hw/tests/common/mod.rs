//! Tools that tests of voxels share.

use tetrascope_core::TetMesh;
use tetrascope_core::glam::{DMat3, DQuat, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};
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

/// A linear field.
pub(crate) fn field(p: DVec3) -> f64 {
    1.0 + 0.3 * p.x - 0.7 * p.y + 1.1 * p.z
}

/// Some rotation.
pub(crate) fn rotation(seed: u64) -> DMat3 {
    let mut random = random(seed);
    let quaternion = DQuat::from_xyzw(random(), random(), random(), random());
    DMat3::from_quat(quaternion.normalize())
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
