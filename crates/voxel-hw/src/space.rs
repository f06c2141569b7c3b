//! The voxels of a lattice with z along columns: the space in which cells are voxelized.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Lattice;

use crate::options::Columns;

/// A lattice, and its axis along which columns run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Space {
    lattice: Lattice,
    axis: usize,
}

impl Space {
    pub(crate) fn new(lattice: &Lattice, columns: Columns) -> Space {
        let [x, y, z] = lattice.dims;
        let axis = match columns {
            Columns::Z => 2,
            // Z where it is no shorter than the others.
            Columns::Longest if z >= x && z >= y => 2,
            Columns::Longest => usize::from(y > x),
        };
        Space {
            lattice: *lattice,
            axis,
        }
    }

    /// As it was given.
    pub(crate) fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The axes of the lattice that are x, y and z here. They turn on, so that hands stay what they are.
    pub(crate) fn axes(&self) -> [usize; 3] {
        [1, 2, 3].map(|i| (self.axis + i) % 3)
    }

    /// The same voxels with these axes.
    pub(crate) fn turned(&self) -> Lattice {
        let Lattice {
            dims,
            spacing,
            direction,
            ..
        } = self.lattice;
        let [x, y, z] = self.axes();
        Lattice {
            dims: [dims[x], dims[y], dims[z]],
            spacing: DVec3::new(spacing[x], spacing[y], spacing[z]),
            direction: DMat3::from_cols(direction.col(x), direction.col(y), direction.col(z)),
            ..self.lattice
        }
    }

    /// Voxels along these axes.
    pub(crate) fn dims(&self) -> [usize; 3] {
        self.axes().map(|axis| self.lattice.dims[axis])
    }

    /// An offset in a voxel of the lattice, along these axes.
    pub(crate) fn turn(&self, offset: DVec3) -> DVec3 {
        DVec3::from(self.axes().map(|axis| offset[axis]))
    }

    /// Where voxel (x, y, z) of these axes is among those of the lattice, x fastest there.
    pub(crate) fn index(&self, at: [i32; 3]) -> usize {
        let mut place = [0; 3];
        for (axis, i) in self.axes().into_iter().zip(at) {
            place[axis] = i as usize;
        }
        let [x, y, z] = place;
        let [nx, ny, _] = self.lattice.dims;
        x + nx * (y + ny * z)
    }
}
