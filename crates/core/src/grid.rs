//! A regular grid of samples, kept in the type in which they were stored.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::{Bounds, Error};

/// Samples at the points of a regular lattice, x fastest.
///
/// Sample (i, j, k) lies at `origin + direction * (spacing * (i, j, k))` and has
/// index `i + dims[0] * (j + dims[1] * k)`. Cheap to clone: clones share the samples.
#[derive(Clone, Debug)]
pub struct Grid {
    dims: [usize; 3],
    origin: DVec3,
    spacing: DVec3,
    direction: DMat3,
    samples: Arc<Samples>,
}

/// Grid samples as they were stored: never rescaled, never converted.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Samples {
    /// Unsigned bytes.
    U8(Vec<u8>),
    /// Unsigned 16-bit integers.
    U16(Vec<u16>),
    /// Signed 16-bit integers.
    I16(Vec<i16>),
    /// 32-bit floats; NaN is transparent.
    F32(Vec<f32>),
}

impl Samples {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        match self {
            Samples::U8(v) => v.len(),
            Samples::U16(v) => v.len(),
            Samples::I16(v) => v.len(),
            Samples::F32(v) => v.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Sample `index` as a number.
    pub fn get(&self, index: usize) -> f64 {
        match self {
            Samples::U8(v) => v[index].into(),
            Samples::U16(v) => v[index].into(),
            Samples::I16(v) => v[index].into(),
            Samples::F32(v) => v[index].into(),
        }
    }
}

impl Grid {
    /// A grid of at least two samples an axis.
    ///
    /// `spacing` is in world units and positive; `direction` turns and flips
    /// the axes and must be orthogonal.
    pub fn new(
        dims: [usize; 3],
        origin: DVec3,
        spacing: DVec3,
        direction: DMat3,
        samples: Samples,
    ) -> Result<Grid, Error> {
        let count = dims
            .iter()
            .try_fold(1usize, |n, &d| n.checked_mul(d))
            .filter(|_| dims.iter().all(|&d| d >= 2))
            .ok_or_else(|| {
                Error::invalid(format!(
                    "a grid needs at least 2 samples an axis, this one has {dims:?}"
                ))
            })?;
        if samples.len() != count {
            return Err(Error::invalid(format!(
                "a grid of {dims:?} has {count} samples, {} were given",
                samples.len()
            )));
        }
        if !(origin.is_finite() && spacing.is_finite() && spacing.cmpgt(DVec3::ZERO).all()) {
            return Err(Error::invalid(format!(
                "a grid needs a finite origin and positive spacing, got {origin} and {spacing}"
            )));
        }
        // Files store directions with about six digits.
        let turned = direction.transpose() * direction;
        if !turned.abs_diff_eq(DMat3::IDENTITY, 1e-5) {
            return Err(Error::invalid(
                "a grid's direction matrix must be orthogonal: shear is not drawn",
            ));
        }
        Ok(Grid {
            dims,
            origin,
            spacing,
            direction,
            samples: Arc::new(samples),
        })
    }

    /// Samples along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Where sample (0, 0, 0) lies, world space.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The distance between neighboring samples along each axis, world units.
    pub fn spacing(&self) -> DVec3 {
        self.spacing
    }

    /// The axes' directions, one a column.
    pub fn direction(&self) -> DMat3 {
        self.direction
    }

    /// The samples, x fastest.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Where the point (i, j, k) of the lattice lies; fractions are allowed.
    pub fn world_from_lattice(&self, lattice: DVec3) -> DVec3 {
        self.origin + self.direction * (self.spacing * lattice)
    }

    /// How many voxel cells there are: products of one less than the dims.
    pub fn cell_count(&self) -> usize {
        self.dims.iter().map(|d| d - 1).product()
    }

    /// The box around all samples.
    pub fn bounds(&self) -> Bounds {
        let far = DVec3::from_array(self.dims.map(|d| (d - 1) as f64));
        Bounds::of((0..8).map(|corner| {
            let pick = |axis: usize, extent: f64| f64::from(corner >> axis & 1) * extent;
            self.world_from_lattice(DVec3::new(pick(0, far.x), pick(1, far.y), pick(2, far.z)))
        }))
    }

    /// The least and greatest finite sample, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        (0..self.samples.len())
            .map(|i| self.samples.get(i))
            .filter(|s| s.is_finite())
            .fold(None, |range, s| match range {
                None => Some((s, s)),
                Some((low, high)) => Some((s.min(low), s.max(high))),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(dims: [usize; 3], samples: Samples) -> Result<Grid, Error> {
        Grid::new(
            dims,
            DVec3::X,
            DVec3::new(1.0, 2.0, 3.0),
            DMat3::IDENTITY,
            samples,
        )
    }

    #[test]
    fn bounds_follow_origin_spacing_and_direction() {
        let flip = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let samples = Samples::U8((0..24).collect());
        let grid = Grid::new(
            [2, 3, 4],
            DVec3::X,
            DVec3::new(1.0, 2.0, 3.0),
            flip,
            samples,
        )
        .expect("the grid is valid");
        assert_eq!(grid.bounds().min, DVec3::new(0.0, 0.0, 0.0));
        assert_eq!(grid.bounds().max, DVec3::new(1.0, 4.0, 9.0));
        assert_eq!(grid.cell_count(), 6);
        assert_eq!(grid.scalar_range(), Some((0.0, 23.0)));
    }

    #[test]
    fn wrong_sizes_are_refused() {
        assert!(grid([2, 2, 1], Samples::U8(vec![0; 4])).is_err());
        assert!(grid([2, 2, 2], Samples::U8(vec![0; 7])).is_err());
        assert!(grid([usize::MAX, 2, 2], Samples::U8(vec![0; 7])).is_err());
    }

    #[test]
    fn not_a_number_is_outside_the_range() {
        let samples = Samples::F32(vec![f32::NAN, 1.0, 2.0, 3.0, 1.0, 1.0, 1.0, f32::INFINITY]);
        let grid = grid([2, 2, 2], samples).expect("the grid is valid");
        assert_eq!(grid.scalar_range(), Some((1.0, 3.0)));
    }
}
