//! Grids that need not fit in memory.

use std::fmt::Debug;
use std::sync::Arc;

use crate::grid::{Interpolation, Lattice, SampleType, Samples};
use crate::pick::pick_samples;
use crate::{Error, Grid};

/// A box of samples: `size` of them from `low` on, along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// The first sample.
    pub low: [usize; 3],
    /// How many along each axis.
    pub size: [usize; 3],
}

impl Region {
    /// How many samples.
    pub fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// The index at which each row of samples along x begins in a grid of `dims`, by
    /// increasing y, then z.
    pub fn rows(self, dims: [usize; 3]) -> impl Iterator<Item = usize> {
        let Region { low, size } = self;
        (0..size[2]).flat_map(move |z| {
            (0..size[1]).map(move |y| low[0] + dims[0] * (low[1] + y + dims[1] * (low[2] + z)))
        })
    }
}

/// A regular grid whose samples are read region by region.
pub trait BrickSource: Debug + Send + Sync {
    /// Where the samples lie; never changes.
    fn lattice(&self) -> Lattice;

    /// Their type; never changes.
    fn sample_type(&self) -> SampleType;

    /// The samples of `region`, which lies inside of the lattice, x fastest.
    fn read(&self, region: Region) -> Result<Samples, Error>;

    /// Whether there is a [coverage](crate::grid::coverage) besides, which is not read.
    fn has_coverage(&self) -> bool {
        false
    }
}

impl BrickSource for Grid {
    fn lattice(&self) -> Lattice {
        *Grid::lattice(self)
    }

    fn sample_type(&self) -> SampleType {
        self.samples().sample_type()
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        fn rows<T: Copy>(all: &[T], dims: [usize; 3], region: Region) -> Vec<T> {
            let mut out = Vec::with_capacity(region.count());
            for start in region.rows(dims) {
                out.extend_from_slice(&all[start..start + region.size[0]]);
            }
            out
        }
        let dims = self.dims();
        Ok(match self.samples() {
            Samples::U8(v) => Samples::U8(rows(v, dims, region)),
            Samples::U16(v) => Samples::U16(rows(v, dims, region)),
            Samples::I16(v) => Samples::I16(rows(v, dims, region)),
            Samples::F32(v) => Samples::F32(rows(v, dims, region)),
        })
    }

    fn has_coverage(&self) -> bool {
        self.coverage().is_some()
    }
}

/// A grid that stays where it is, in a file as a rule, and is read in parts.
///
/// Cheap to clone: clones share the source.
#[derive(Clone, Debug)]
pub struct GridStream {
    source: Arc<dyn BrickSource>,
    range: Option<(f64, f64)>,
    missing: u64,
    /// Some samples, from which defaults follow.
    picked: Arc<Vec<f64>>,
}

/// A source whose samples are interpolated in another way.
#[derive(Debug)]
struct Interpolated {
    source: Arc<dyn BrickSource>,
    interpolation: Interpolation,
}

impl BrickSource for Interpolated {
    fn lattice(&self) -> Lattice {
        Lattice {
            interpolation: self.interpolation,
            ..self.source.lattice()
        }
    }

    fn sample_type(&self) -> SampleType {
        self.source.sample_type()
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        self.source.read(region)
    }
}

/// Samples that are read at a time to find their range.
const SLAB: usize = 1 << 22;

impl GridStream {
    /// Reads all samples once, slab by slab, for their range and to count those without a
    /// value; keeps about a million of them, 8 MiB, to choose a look by.
    ///
    /// # Errors
    /// Those of [`Lattice::validate`], and those of the source; [`Error::Invalid`] for one
    /// with coverage, which is not read in parts.
    pub fn new(source: Arc<dyn BrickSource>) -> Result<GridStream, Error> {
        let lattice = source.lattice();
        lattice.validate()?;
        if source.has_coverage() {
            return Err(Error::Invalid {
                what: "a grid with coverage that is to be read in parts".into(),
                help: Some("keep it in memory, as `Volume::Grid`".into()),
            });
        }
        let [nx, ny, nz] = lattice.dims;
        // As many rows as fit, at least one; of a row all samples.
        let rows = (SLAB / nx).clamp(1, ny);
        let layers = (SLAB / nx / ny).clamp(1, nz);
        let total = lattice.dims.iter().product();
        let mut range: Option<(f64, f64)> = None;
        let mut missing = 0;
        let mut picked = Vec::new();
        for z in (0..nz).step_by(layers) {
            for y in (0..ny).step_by(rows) {
                let samples = source.read(Region {
                    low: [0, y, z],
                    size: [nx, rows.min(ny - y), layers.min(nz - z)],
                })?;
                missing += samples.missing();
                range = match (range, samples.range()) {
                    (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
                    (a, b) => a.or(b),
                };
                let start = nx * (y + ny * z);
                pick_samples(&samples, start, total, &mut picked);
            }
        }
        Ok(GridStream {
            source,
            range,
            missing,
            picked: Arc::new(picked),
        })
    }

    /// The same samples, interpolated in this way.
    ///
    /// # Errors
    /// Those of [`Lattice::validate`].
    pub fn interpolated(self, interpolation: Interpolation) -> Result<GridStream, Error> {
        let source: Arc<dyn BrickSource> = Arc::new(Interpolated {
            source: self.source,
            interpolation,
        });
        source.lattice().validate()?;
        Ok(GridStream { source, ..self })
    }

    /// Where the samples come from.
    pub fn source(&self) -> &Arc<dyn BrickSource> {
        &self.source
    }

    /// The least and greatest finite sample, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        self.range
    }

    /// How many samples are not finite, which is to have no value.
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// The samples of [`pick_samples`]: at most [`MOST_PICKED`](crate::pick::MOST_PICKED), evenly spread.
    pub fn picked(&self) -> &[f64] {
        &self.picked
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;

    fn grid_of_bytes() -> Grid {
        let samples = Samples::U8((0..8).collect());
        let grid = Grid::new([2; 3], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
        grid.expect("valid")
    }

    #[test]
    fn parts_are_cut_out_and_the_range_is_that_of_all() {
        let samples = Samples::I16((0..60).map(|i| i - 7).collect());
        let grid = Grid::new([3, 4, 5], DVec3::ZERO, DVec3::ONE, DMat3::IDENTITY, samples);
        let grid = grid.expect("valid");
        let region = Region {
            low: [1, 2, 3],
            size: [2, 2, 1],
        };
        let part = grid.read(region).expect("inside");
        let at = |x: i16, y: i16, z: i16| x + 3 * (y + 4 * z) - 7;
        let expected = [at(1, 2, 3), at(2, 2, 3), at(1, 3, 3), at(2, 3, 3)];
        assert_eq!(part, Samples::I16(expected.to_vec()));
        let stream = GridStream::new(Arc::new(grid)).expect("read");
        assert_eq!(stream.scalar_range(), Some((-7.0, 52.0)));
        assert_eq!(stream.missing(), 0);
        let covered = grid_of_bytes().covered(vec![1.0; 8]).expect("shares");
        assert!(
            GridStream::new(Arc::new(covered)).is_err(),
            "its coverage would be lost"
        );
        let cells = stream.interpolated(Interpolation::Nearest).expect("valid");
        assert_eq!(cells.source().lattice().cells(), [3, 4, 5]);
        assert_eq!(cells.scalar_range(), Some((-7.0, 52.0)));
    }
}
