//! Where the samples of a grid lie.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::{Bounds, Error, number};

/// The scalar between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// Trilinear: samples are the corners of cells, of which there is one less along each axis.
    #[default]
    Linear,
    /// That of the nearest sample: each sample fills a cell of its own around itself, as cell
    /// data and labels do.
    Nearest,
}

impl Interpolation {
    /// Both, by name.
    pub const ALL: [Interpolation; 2] = [Interpolation::Linear, Interpolation::Nearest];

    /// The name that people write.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Linear => "linear",
            Interpolation::Nearest => "nearest",
        }
    }
}

/// Where the samples of a regular grid lie, without the samples.
///
/// Sample (i, j, k) is at `origin + direction * (spacing * (i, j, k))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Samples along each axis: 2 or more, or 1 or more that fill cells.
    pub dims: [usize; 3],
    /// Where sample (0, 0, 0) lies, world space.
    pub origin: DVec3,
    /// The distance of neighbors along each axis, world units, positive.
    pub spacing: DVec3,
    /// The axes' directions, one per column; orthogonal to five digits.
    pub direction: DMat3,
    /// The scalar between samples.
    pub interpolation: Interpolation,
}

impl Lattice {
    /// A lattice whose neighbors along axis i are `axes[i]` apart, world space; an axis
    /// may point anywhere, as files with flipped or turned axes have it.
    ///
    /// Refuses what [`Lattice::validate`] refuses.
    pub fn from_axes(
        dims: [usize; 3],
        origin: DVec3,
        axes: [DVec3; 3],
        interpolation: Interpolation,
    ) -> Result<Lattice, Error> {
        // Squares of tiny and of huge lengths do not fit; those of shares of them do.
        let length = |axis: DVec3| match axis.abs().max_element() {
            most if most > 0.0 => (axis / most).length() * most,
            most => most,
        };
        let spacing = DVec3::from_array(axes.map(length));
        let [x, y, z] = [0, 1, 2].map(|i| axes[i] / spacing[i]);
        let lattice = Lattice {
            dims,
            origin,
            spacing,
            direction: DMat3::from_cols(x, y, z),
            interpolation,
        };
        lattice.validate()?;
        Ok(lattice)
    }

    /// How many samples there are; refuses a lattice that holds no volume.
    ///
    /// # Errors
    /// Fewer than 2 samples along an axis that is interpolated, none at all, or more than can
    /// be counted; numbers that are not finite, spacing that is not positive or so small
    /// that its reciprocal is infinite, a far end that is not finite, and axes that are not
    /// orthogonal.
    pub fn validate(&self) -> Result<usize, Error> {
        let Lattice {
            dims,
            origin,
            spacing,
            direction,
            interpolation,
        } = self;
        let least = match interpolation {
            Interpolation::Linear => 2,
            Interpolation::Nearest => 1,
        };
        let count = dims
            .iter()
            .try_fold(1usize, |n, &d| n.checked_mul(d))
            .filter(|_| dims.iter().all(|&d| d >= least))
            .ok_or_else(|| {
                Error::invalid(format!(
                    "a grid needs at least {least} samples along each axis, this one has {dims:?}"
                ))
            })?;
        if !(origin.is_finite() && spacing.is_finite() && spacing.cmpgt(DVec3::ZERO).all()) {
            return Err(Error::invalid(format!(
                "a grid needs a finite origin and positive spacing, got {origin:?} and {spacing:?}"
            )));
        }
        if !spacing.recip().is_finite() {
            return Err(Error::invalid(format!(
                "a grid's spacing must have a finite reciprocal, {} is too small",
                number::vector(*spacing)
            )));
        }
        // Files store directions with about six digits.
        let turned = direction.transpose() * *direction;
        if !turned.abs_diff_eq(DMat3::IDENTITY, 1e-5) {
            return Err(Error::invalid(
                "a grid's direction matrix must be orthogonal: shear is not drawn",
            ));
        }
        // Also the square of its diagonal, which distances need.
        let Bounds { min, max } = self.bounds();
        if !(min.is_finite() && max.is_finite() && (max - min).length_squared().is_finite()) {
            return Err(Error::invalid(format!(
                "a grid of {dims:?} samples {spacing:?} apart is too large to measure"
            )));
        }
        Ok(count)
    }

    /// Cells along each axis: one less than samples, or as many where these fill cells.
    pub fn cells(&self) -> [usize; 3] {
        match self.interpolation {
            Interpolation::Linear => self.dims.map(|d| d - 1),
            Interpolation::Nearest => self.dims,
        }
    }

    /// Where the first cell begins along each axis, in lattice space.
    pub fn first(&self) -> f64 {
        match self.interpolation {
            Interpolation::Linear => 0.0,
            Interpolation::Nearest => -0.5,
        }
    }

    /// From lattice to world space, the linear part.
    pub fn linear(&self) -> DMat3 {
        self.direction * DMat3::from_diagonal(self.spacing)
    }

    /// Where the point (i, j, k) of the lattice lies, world space; fractions are allowed.
    pub fn point(&self, lattice: DVec3) -> DVec3 {
        self.origin + self.direction * (self.spacing * lattice)
    }

    /// The eight corners of the box around all cells, world space, x fastest.
    pub fn corners(&self) -> [DVec3; 8] {
        let first = self.first();
        let cells = self.cells().map(|c| c as f64);
        std::array::from_fn(|corner| {
            let pick = |axis: usize| first + (corner >> axis & 1) as f64 * cells[axis];
            self.point(DVec3::new(pick(0), pick(1), pick(2)))
        })
    }

    /// The box around all cells, world space.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.corners())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_become_spacing_and_direction() {
        let axes = [DVec3::NEG_Y * 2.0, DVec3::X * 3.0, DVec3::NEG_Z * 0.5];
        let lattice = Lattice::from_axes([2, 3, 4], DVec3::ONE, axes, Interpolation::Linear);
        let lattice = lattice.expect("orthogonal");
        assert_eq!(lattice.spacing, DVec3::new(2.0, 3.0, 0.5));
        assert_eq!(lattice.point(DVec3::ONE), DVec3::new(4.0, -1.0, 0.5));
        for wrong in [
            [DVec3::X, DVec3::X, DVec3::Z],
            [DVec3::X, DVec3::ZERO, DVec3::Z],
            [DVec3::X, DVec3::NAN, DVec3::Z],
        ] {
            let lattice = Lattice::from_axes([2; 3], DVec3::ZERO, wrong, Interpolation::Linear);
            assert!(lattice.is_err());
        }
    }

    fn of_spacing(x: f64) -> Result<Lattice, Error> {
        let axes = [DVec3::X * x, DVec3::Y, DVec3::Z];
        Lattice::from_axes([2; 3], DVec3::ZERO, axes, Interpolation::Linear)
    }

    #[test]
    fn spacing_without_a_reciprocal_and_grids_without_an_end_are_refused() {
        // 1/x overflows below 2⁻¹⁰²⁴.
        for fine in [1e-307, 1e-200, 1e100] {
            assert_eq!(of_spacing(fine).expect("fine").spacing.x, fine);
        }
        for wrong in [1e-310, 5e-324, 1e308, f64::INFINITY] {
            let error = of_spacing(wrong).expect_err("no volume").to_string();
            assert!(!error.contains('\n') && error.len() < 120, "{error}");
        }
    }

    #[test]
    fn samples_that_fill_cells_reach_half_a_spacing_farther() {
        let axes = [DVec3::X, DVec3::NEG_Y * 2.0, DVec3::Z];
        let origin = DVec3::new(0.5, -1.0, 0.5);
        let of = |interpolation| Lattice::from_axes([3, 2, 1], origin, axes, interpolation);
        assert!(of(Interpolation::Linear).is_err());
        let lattice = of(Interpolation::Nearest).expect("one layer is a volume");
        assert_eq!(lattice.cells(), [3, 2, 1]);
        let Bounds { min, max } = lattice.bounds();
        assert_eq!(
            (min, max),
            (DVec3::new(0.0, -4.0, 0.0), DVec3::new(3.0, 0.0, 1.0))
        );
    }
}
