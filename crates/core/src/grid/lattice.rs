//! Where the samples of a grid lie.

use glam::{DMat3, DVec3};

use crate::{Bounds, Error};

/// Where the samples of a regular grid lie, without the samples.
///
/// Sample (i, j, k) is at `origin + direction * (spacing * (i, j, k))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Samples along each axis, 2 or more.
    pub dims: [usize; 3],
    /// Where sample (0, 0, 0) lies, world space.
    pub origin: DVec3,
    /// The distance of neighbors along each axis, world units, positive.
    pub spacing: DVec3,
    /// The axes' directions, one a column; orthogonal to five digits.
    pub direction: DMat3,
}

impl Lattice {
    /// A lattice whose neighbors along axis i are `axes[i]` apart, world space; an axis
    /// may point anywhere, as files with flipped or turned axes have it.
    ///
    /// Refuses what [`Lattice::validate`] refuses.
    pub fn from_axes(dims: [usize; 3], origin: DVec3, axes: [DVec3; 3]) -> Result<Lattice, Error> {
        let spacing = DVec3::from_array(axes.map(DVec3::length));
        let [x, y, z] = [0, 1, 2].map(|i| axes[i] / spacing[i]);
        let lattice = Lattice {
            dims,
            origin,
            spacing,
            direction: DMat3::from_cols(x, y, z),
        };
        lattice.validate()?;
        Ok(lattice)
    }

    /// How many samples there are; refuses a lattice that holds no volume.
    ///
    /// # Errors
    /// Fewer than 2 samples along an axis or more than can be counted, numbers that are
    /// not finite, spacing that is not positive, and axes that are not orthogonal.
    pub fn validate(&self) -> Result<usize, Error> {
        let Lattice {
            dims,
            origin,
            spacing,
            direction,
        } = self;
        let count = dims
            .iter()
            .try_fold(1usize, |n, &d| n.checked_mul(d))
            .filter(|_| dims.iter().all(|&d| d >= 2))
            .ok_or_else(|| {
                Error::invalid(format!(
                    "a grid needs at least 2 samples an axis, this one has {dims:?}"
                ))
            })?;
        if !(origin.is_finite() && spacing.is_finite() && spacing.cmpgt(DVec3::ZERO).all()) {
            return Err(Error::invalid(format!(
                "a grid needs a finite origin and positive spacing, got {origin} and {spacing}"
            )));
        }
        // Files store directions with about six digits.
        let turned = direction.transpose() * *direction;
        if !turned.abs_diff_eq(DMat3::IDENTITY, 1e-5) {
            return Err(Error::invalid(
                "a grid's direction matrix must be orthogonal: shear is not drawn",
            ));
        }
        Ok(count)
    }

    /// Cells along each axis: one less than samples.
    pub fn cells(&self) -> [usize; 3] {
        self.dims.map(|d| d - 1)
    }

    /// From lattice to world space, the linear part.
    pub fn linear(&self) -> DMat3 {
        self.direction * DMat3::from_diagonal(self.spacing)
    }

    /// Where the point (i, j, k) of the lattice lies, world space; fractions are allowed.
    pub fn point(&self, lattice: DVec3) -> DVec3 {
        self.origin + self.direction * (self.spacing * lattice)
    }

    /// The box around all samples, world space.
    pub fn bounds(&self) -> Bounds {
        let far = self.cells().map(|c| c as f64);
        Bounds::of((0..8).map(|corner: usize| {
            let pick = |axis: usize| (corner >> axis & 1) as f64 * far[axis];
            self.point(DVec3::new(pick(0), pick(1), pick(2)))
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_become_spacing_and_direction() {
        let axes = [DVec3::NEG_Y * 2.0, DVec3::X * 3.0, DVec3::NEG_Z * 0.5];
        let lattice = Lattice::from_axes([2, 3, 4], DVec3::ONE, axes).expect("orthogonal");
        assert_eq!(lattice.spacing, DVec3::new(2.0, 3.0, 0.5));
        assert_eq!(lattice.point(DVec3::ONE), DVec3::new(4.0, -1.0, 0.5));
        for wrong in [
            [DVec3::X, DVec3::X, DVec3::Z],
            [DVec3::X, DVec3::ZERO, DVec3::Z],
            [DVec3::X, DVec3::NAN, DVec3::Z],
        ] {
            assert!(Lattice::from_axes([2; 3], DVec3::ZERO, wrong).is_err());
        }
    }
}
