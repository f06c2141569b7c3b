//! A regular grid of samples, kept in the type in which they were stored.

pub mod coverage;
mod lattice;
mod placing;
mod raw;
mod source;

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::{Bounds, Error, is_value};

pub use lattice::{Interpolation, Lattice};
pub use raw::{ByteOrder, RawLayout, RawNumber};
pub use source::{BrickSource, GridStream, Region};

/// Samples at the points of a regular lattice, x fastest.
///
/// Sample (i, j, k) lies where [`Lattice`] says and has index
/// `i + dims[0] * (j + dims[1] * k)`. Cheap to clone: clones share the samples.
#[derive(Clone, Debug)]
pub struct Grid {
    lattice: Lattice,
    samples: Arc<Samples>,
    coverage: Option<Arc<Vec<f32>>>,
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

/// The type of a grid's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// Unsigned bytes.
    U8,
    /// Unsigned 16-bit integers.
    U16,
    /// Signed 16-bit integers.
    I16,
    /// 32-bit floats; NaN is transparent.
    F32,
}

impl SampleType {
    /// The name that people write and read.
    pub fn name(self) -> &'static str {
        match self {
            SampleType::U8 => "u8",
            SampleType::U16 => "u16",
            SampleType::I16 => "i16",
            SampleType::F32 => "f32",
        }
    }

    /// Bytes of one sample.
    pub fn bytes(self) -> usize {
        match self {
            SampleType::U8 => 1,
            SampleType::U16 | SampleType::I16 => 2,
            SampleType::F32 => 4,
        }
    }
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

    /// How many bytes they take.
    pub fn bytes(&self) -> u64 {
        self.len() as u64 * self.sample_type().bytes() as u64
    }

    /// Their type.
    pub fn sample_type(&self) -> SampleType {
        match self {
            Samples::U8(_) => SampleType::U8,
            Samples::U16(_) => SampleType::U16,
            Samples::I16(_) => SampleType::I16,
            Samples::F32(_) => SampleType::F32,
        }
    }

    /// The least and greatest finite sample, if there is any.
    pub fn range(&self) -> Option<(f64, f64)> {
        fn of<T: Copy + Into<f64>>(samples: &[T]) -> Option<(f64, f64)> {
            let numbers = samples.iter().map(|s| (*s).into());
            let (low, high) = numbers
                .filter(|s: &f64| s.is_finite())
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
                    (s.min(low), s.max(high))
                });
            (low <= high).then_some((low, high))
        }
        match self {
            Samples::U8(v) => of(v),
            Samples::U16(v) => of(v),
            Samples::I16(v) => of(v),
            Samples::F32(v) => of(v),
        }
    }

    /// How many samples are not finite, which is to have no value.
    pub fn missing(&self) -> u64 {
        match self {
            Samples::F32(v) => v.iter().filter(|s| !s.is_finite()).count() as u64,
            _ => 0,
        }
    }

    /// Sample `index` as a number.
    #[inline]
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
    /// A grid of at least two samples along each axis, with trilinear interpolation.
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
        let lattice = Lattice {
            dims,
            origin,
            spacing,
            direction,
            interpolation: Interpolation::Linear,
        };
        Grid::on(lattice, samples)
    }

    /// The grid of `samples` on `lattice`; see [`Lattice::validate`].
    pub fn on(lattice: Lattice, samples: Samples) -> Result<Grid, Error> {
        let count = lattice.validate()?;
        if samples.len() != count {
            return Err(Error::invalid(format!(
                "a grid of {:?} has {count} samples, {} were given",
                lattice.dims,
                samples.len()
            )));
        }
        Ok(Grid {
            lattice,
            samples: Arc::new(samples),
            coverage: None,
        })
    }

    /// The same samples, of which so much is there, x fastest, each in [0, 1]; see
    /// [`coverage`]. Samples without a value get 0.
    ///
    /// # Errors
    /// [`Error::Invalid`] for another number of them, and for one that is not in [0, 1].
    pub fn covered(self, mut coverage: Vec<f32>) -> Result<Grid, Error> {
        let count = self.samples.len();
        if coverage.len() != count {
            return Err(Error::invalid(format!(
                "a grid of {count} samples needs as many coverages, {} were given",
                coverage.len()
            )));
        }
        for (i, share) in coverage.iter_mut().enumerate() {
            if !(0.0..=1.0).contains(share) {
                return Err(Error::Invalid {
                    what: format!("the coverage {share} of sample {i}"),
                    help: Some("give shares from 0, outside, to 1, inside".into()),
                });
            }
            if !is_value(self.samples.get(i)) {
                *share = 0.0;
            }
        }
        Ok(Grid {
            coverage: Some(Arc::new(coverage)),
            ..self
        })
    }

    /// Where the samples lie.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Samples along each axis.
    pub fn dims(&self) -> [usize; 3] {
        self.lattice.dims
    }

    /// Where sample (0, 0, 0) lies, world space.
    pub fn origin(&self) -> DVec3 {
        self.lattice.origin
    }

    /// The distance between neighboring samples along each axis, world units.
    pub fn spacing(&self) -> DVec3 {
        self.lattice.spacing
    }

    /// The axes' directions, one per column.
    pub fn direction(&self) -> DMat3 {
        self.lattice.direction
    }

    /// The samples, x fastest.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// How much of each sample is there, x fastest, in [0, 1]; `None` for all of all. What is
    /// not covered has no scalar, whatever its sample says.
    pub fn coverage(&self) -> Option<&[f32]> {
        self.coverage.as_ref().map(|coverage| coverage.as_slice())
    }

    /// Where the point (i, j, k) of the lattice lies; fractions are allowed.
    pub fn world_from_lattice(&self, lattice: DVec3) -> DVec3 {
        self.lattice.point(lattice)
    }

    /// How many voxel cells there are.
    pub fn cell_count(&self) -> usize {
        self.lattice.cells().iter().product()
    }

    /// The box around all cells.
    pub fn bounds(&self) -> Bounds {
        self.lattice.bounds()
    }

    /// The least and greatest finite sample that is covered, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        let Some(coverage) = &self.coverage else {
            return self.samples.range();
        };
        let covered = (0..coverage.len()).filter(|i| coverage[*i] > 0.0);
        covered
            .map(|i| self.samples.get(i))
            .fold(None, |range, scalar| {
                let (low, high) = range.unwrap_or((scalar, scalar));
                Some((scalar.min(low), scalar.max(high)))
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
    fn coverage_is_of_values_and_the_range_of_what_is_covered() {
        let samples = Samples::F32(vec![f32::NAN, 1.0, 2.0, 3.0, 9.0, -5.0, 1.0, f32::INFINITY]);
        let grid = grid([2, 2, 2], samples).expect("the grid is valid");
        let coverage = vec![1.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.25, 0.75];
        let covered = grid.clone().covered(coverage).expect("shares");
        let expected = [0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.25, 0.0];
        assert_eq!(covered.coverage(), Some(&expected[..]));
        assert_eq!(covered.scalar_range(), Some((1.0, 3.0)));
        let nothing = grid.clone().covered(vec![0.0; 8]).expect("shares");
        assert_eq!(nothing.scalar_range(), None);
        for wrong in [vec![1.0; 7], vec![1.5; 8], vec![-0.1; 8], vec![f32::NAN; 8]] {
            assert!(grid.clone().covered(wrong).is_err());
        }
    }

    #[test]
    fn not_a_number_is_outside_the_range() {
        let samples = Samples::F32(vec![f32::NAN, 1.0, 2.0, 3.0, 1.0, 1.0, 1.0, f32::INFINITY]);
        let grid = grid([2, 2, 2], samples).expect("the grid is valid");
        assert_eq!(grid.scalar_range(), Some((1.0, 3.0)));
    }
}
