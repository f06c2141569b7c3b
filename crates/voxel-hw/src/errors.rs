//! How far voxels are from the mesh that they stand for.
//!
//! The paper measures this with the error measures of another paper (Prakash, Manohar,
//! "Error measures and 3D anti-aliasing for voxel data", 1995), which it does not define. These are
//! ours: the scalar against the field, the coverage against the exact volume of cells in
//! a voxel, and what follows from that.

use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::Lattice;
use tetrascope_core::{Error, TetMesh};

use crate::options::{Cells, Columns, voxel_count};
use crate::source::{ToVoxels, for_each_cell};
use crate::space::Space;
use crate::volume::VoxelVolume;
use crate::voxelizer::zeros;

/// Shares of a voxel below this are rounding: a cell's pieces have errors of 10⁻¹⁵ or so of its
/// own volume, and hundreds of cells may meet in a voxel.
const ROUNDING: f64 = 1e-9;

/// Errors of voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoxelErrors {
    /// Voxels that are wholly in the mesh and have a scalar.
    pub inside: usize,
    /// The root of the mean square of (scalar − field at the center) over them.
    pub scalar_rms: f64,
    /// The greatest magnitude of that.
    pub scalar_max: f64,
    /// Voxels of which the mesh fills a part.
    pub border: usize,
    /// The root of the mean square of (coverage − that part) over them.
    pub coverage_rms: f64,
    /// The greatest magnitude of that, over all voxels.
    pub coverage_max: f64,
    /// Voxels that the mesh reaches into and that were not written.
    pub missed: usize,
    /// Voxels that it does not reach into and that were written.
    pub spurious: usize,
    /// Sum of coverages over sum of parts, less 1.
    pub volume: f64,
}

impl VoxelErrors {
    /// The errors of the voxels of `mesh`, whose scalar is `field` at a point in world space.
    ///
    /// # Errors
    /// No memory.
    pub fn of(
        volume: &VoxelVolume,
        mesh: &TetMesh,
        field: impl Fn(DVec3) -> f64,
    ) -> Result<VoxelErrors, Error> {
        let exact = exact_coverage(mesh, volume.lattice())?;
        Ok(VoxelErrors::against(volume, &exact, field))
    }

    /// The same where the mesh's part of each voxel is known: [`exact_coverage`] takes longer than
    /// all the rest.
    ///
    /// # Panics
    /// If these are not as many as there are voxels.
    pub fn against(
        volume: &VoxelVolume,
        exact: &[f64],
        field: impl Fn(DVec3) -> f64,
    ) -> VoxelErrors {
        assert_eq!(exact.len(), volume.writes().len(), "one part per voxel");
        let [nx, ny, _] = volume.dims();
        let mut errors = VoxelErrors::default();
        let (mut total, mut truth) = (0.0, 0.0);
        for (index, &part) in exact.iter().enumerate() {
            let coverage = f64::from(volume.coverage(index));
            total += coverage;
            truth += part;
            let error = coverage - part;
            errors.coverage_max = errors.coverage_max.max(error.abs());
            let (reaches, fills) = (part > ROUNDING, part > 1.0 - ROUNDING);
            if reaches && !fills {
                errors.border += 1;
                errors.coverage_rms += error * error;
            }
            match volume.scalar(index) {
                None => errors.missed += usize::from(reaches),
                Some(_) if !reaches => errors.spurious += 1,
                Some(scalar) if fills => {
                    let place = [index % nx, index / nx % ny, index / (nx * ny)];
                    let center = DVec3::from(place.map(|i| i as f64));
                    let error = (scalar - field(volume.lattice().point(center))).abs();
                    errors.inside += 1;
                    errors.scalar_rms += error * error;
                    errors.scalar_max = errors.scalar_max.max(error);
                }
                Some(_) => {}
            }
        }
        let root = |sum: f64, count: usize| (sum / count.max(1) as f64).sqrt();
        errors.coverage_rms = root(errors.coverage_rms, errors.border);
        errors.scalar_rms = root(errors.scalar_rms, errors.inside);
        if truth > 0.0 {
            errors.volume = total / truth - 1.0;
        }
        errors
    }
}

/// The part of each voxel that is in cells of `mesh`, x fastest; where cells overlap, each
/// counts. Cells without a value count as well.
///
/// # Errors
/// A lattice without voxels or with too many, and more memory than there is.
pub fn exact_coverage(mesh: &TetMesh, lattice: &Lattice) -> Result<Vec<f64>, Error> {
    lattice.validate()?;
    let dims = lattice.dims;
    let mut coverage = zeros(voxel_count(dims)?)?;
    let space = Space::new(lattice, Columns::Z);
    let to_voxels = ToVoxels::new(lattice);
    for_each_cell(mesh, Cells::Tetrahedra, &to_voxels, |_, cell| {
        let corners = [0, 1, 2, 3].map(|i| cell.corners[i]);
        let low = corners.iter().fold(DVec3::INFINITY, |low, c| low.min(*c));
        let high = corners
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, c| high.max(*c));
        let range = |axis: usize| {
            let first = low[axis].floor().max(0.0) as i32;
            first..(high[axis].ceil().min(dims[axis] as f64) as i32)
        };
        // Slabs, then bars, then voxels: each is cut out of the one before.
        let (mut slab, mut bar) = (Vec::new(), Vec::new());
        for z in range(2) {
            between(&[corners], 2, z, &mut slab);
            for y in range(1) {
                between(&slab, 1, y, &mut bar);
                for x in range(0) {
                    let mut voxel = Vec::new();
                    between(&bar, 0, x, &mut voxel);
                    let volume: f64 = voxel.iter().map(volume_of).sum();
                    coverage[space.index([x, y, z])] += volume;
                }
            }
        }
        Ok(())
    })?;
    Ok(coverage)
}

/// The volume of a tetrahedron in the box from `low` to `high`.
///
/// The tetrahedron is cut by the box's planes into tetrahedra, whose volumes are added.
pub fn volume_in_box(tetrahedron: [DVec3; 4], low: DVec3, high: DVec3) -> f64 {
    let mut pieces = vec![tetrahedron];
    for axis in 0..3 {
        for (at, sign) in [(low[axis], -1.0), (high[axis], 1.0)] {
            let mut kept = Vec::new();
            for piece in &pieces {
                cut(piece, |p| sign * (p[axis] - at), &mut kept);
            }
            pieces = kept;
        }
    }
    pieces.iter().map(volume_of).sum()
}

/// Keeps the parts of `pieces` between `at` and `at` + 1 along an axis.
fn between(pieces: &[[DVec3; 4]], axis: usize, at: i32, kept: &mut Vec<[DVec3; 4]>) {
    let at = f64::from(at);
    kept.clear();
    let mut above = Vec::new();
    for piece in pieces {
        cut(piece, |p| at - p[axis], &mut above);
    }
    for piece in &above {
        cut(piece, |p| p[axis] - (at + 1.0), kept);
    }
}

fn volume_of([a, b, c, d]: &[DVec3; 4]) -> f64 {
    (*b - *a).dot((*c - *a).cross(*d - *a)).abs() / 6.0
}

/// Adds to `kept` the part of a tetrahedron at which `distance`, linear in the place, is negative.
fn cut(corners: &[DVec3; 4], distance: impl Fn(DVec3) -> f64, kept: &mut Vec<[DVec3; 4]>) {
    let mut order = [0, 1, 2, 3];
    let distances = corners.map(distance);
    order.sort_unstable_by(|i, j| distances[*i].total_cmp(&distances[*j]));
    let inside = distances.iter().filter(|d| **d < 0.0).count();
    let corner = |i: usize| corners[order[i]];
    // Where the edge from a corner inside to one outside is cut.
    let on = |from: usize, to: usize| {
        let (near, far) = (distances[order[from]], distances[order[to]]);
        corner(from).lerp(corner(to), near / (near - far))
    };
    // A prism between two triangles.
    let mut prism = |[a, b, c]: [DVec3; 3], [d, e, f]: [DVec3; 3]| {
        kept.extend([[a, b, c, f], [a, b, e, f], [a, d, e, f]]);
    };
    match inside {
        0 => {}
        1 => kept.push([corner(0), on(0, 1), on(0, 2), on(0, 3)]),
        2 => prism(
            [corner(0), on(0, 2), on(0, 3)],
            [corner(1), on(1, 2), on(1, 3)],
        ),
        3 => prism([0, 1, 2].map(corner), [0, 1, 2].map(|i| on(i, 3))),
        _ => kept.push(*corners),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];

    // x + y + z < 1 in the cube [0, s]³: s³ up to 1/3; with corners cut off, less
    // 3 (3s − 1 − s)³ … by inclusion and exclusion, Σ (−1)^k C(3, k) (1 − k s)³₊ / 6 taken from 1/6.
    #[test]
    fn parts_of_boxes_are_as_the_formula_says() {
        for s in [0.1, 0.3, 1.0 / 3.0, 0.4, 0.5, 0.7, 1.0, 2.0] {
            let term = |k: f64| (1.0 - k * s).max(0.0).powi(3) / 6.0;
            let truth = 1.0 / 6.0 - 3.0 * term(1.0) + 3.0 * term(2.0) - term(3.0);
            let volume = volume_in_box(UNIT, DVec3::ZERO, DVec3::splat(s));
            // Some 30 pieces of at most 1/6, each with a few roundings.
            assert!((volume - truth).abs() < 1e-15, "{s}: {volume} {truth}");
        }
        assert_eq!(volume_in_box(UNIT, DVec3::ONE, DVec3::splat(2.0)), 0.0);
        assert_eq!(volume_in_box([DVec3::ONE; 4], DVec3::ZERO, DVec3::ONE), 0.0);
    }

    // The eight octants of a box add up to the whole.
    #[test]
    fn parts_add_up() {
        let corners = [
            DVec3::new(-0.7, -0.3, -0.9),
            DVec3::new(0.9, -0.2, -0.1),
            DVec3::new(0.1, 0.8, -0.3),
            DVec3::new(-0.2, 0.1, 0.7),
        ];
        for order in [[0, 1, 2, 3], [3, 1, 0, 2], [2, 3, 1, 0]] {
            let corners = order.map(|i: usize| corners[i]);
            let octants = (0..8).map(|o| {
                let low = DVec3::from([o & 1, o >> 1 & 1, o >> 2].map(|i| f64::from(i) - 1.0));
                volume_in_box(corners, low, low + 1.0)
            });
            let sum: f64 = octants.sum();
            assert!((sum - volume_of(&corners)).abs() < 1e-15, "{sum}");
        }
    }
}
