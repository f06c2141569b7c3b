//! Samples that fill cells of their own, as the slices need them.

use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::glam::DVec3;
use tetrascope_core::grid::{BrickSource, Interpolation, Lattice, Region, SampleType, Samples};

/// A source as one whose cells lie between samples: the sample of each cell stands at its
/// lower corner, and the last along each axis twice. The shaders read no other of a cell
/// (`NEAREST` in `slab.wgsl`).
#[derive(Debug)]
pub(crate) struct CellCorners {
    source: Arc<dyn BrickSource>,
}

/// `source`, or what stands for it if its samples fill cells of their own.
pub(crate) fn between_samples(source: Arc<dyn BrickSource>) -> Arc<dyn BrickSource> {
    match source.lattice().interpolation {
        Interpolation::Nearest => Arc::new(CellCorners { source }),
        _ => source,
    }
}

impl BrickSource for CellCorners {
    fn lattice(&self) -> Lattice {
        let lattice = self.source.lattice();
        Lattice {
            dims: lattice.dims.map(|d| d + 1),
            origin: lattice.point(DVec3::splat(lattice.first())),
            interpolation: Interpolation::Linear,
            ..lattice
        }
    }

    fn sample_type(&self) -> SampleType {
        self.source.sample_type()
    }

    fn read(&self, region: Region) -> Result<Samples, Error> {
        let dims = self.source.lattice().dims;
        // What is there of the region; all of it but a last layer.
        let low = [0, 1, 2].map(|a| region.low[a].min(dims[a] - 1));
        let size = [0, 1, 2].map(|a| (region.low[a] + region.size[a]).min(dims[a]) - low[a]);
        let samples = self.source.read(Region { low, size })?;
        if size == region.size {
            return Ok(samples);
        }
        fn widen<T: Copy>(samples: &[T], size: [usize; 3], to: [usize; 3]) -> Vec<T> {
            let at = |i: usize, axis: usize| i.min(size[axis] - 1);
            let mut wide = Vec::with_capacity(to.iter().product());
            for z in 0..to[2] {
                for y in 0..to[1] {
                    let row = size[0] * (at(y, 1) + size[1] * at(z, 2));
                    wide.extend((0..to[0]).map(|x| samples[row + at(x, 0)]));
                }
            }
            wide
        }
        let to = region.size;
        Ok(match samples {
            Samples::U8(v) => Samples::U8(widen(&v, size, to)),
            Samples::U16(v) => Samples::U16(widen(&v, size, to)),
            Samples::I16(v) => Samples::I16(widen(&v, size, to)),
            Samples::F32(v) => Samples::F32(widen(&v, size, to)),
            _ => return Err(Error::invalid("samples of an unknown type")),
        })
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::Grid;
    use tetrascope_core::glam::DMat3;

    use super::*;

    #[test]
    fn the_last_samples_stand_twice() {
        let lattice = Lattice {
            dims: [3, 2, 1],
            origin: DVec3::new(0.5, 1.0, 1.5),
            spacing: DVec3::new(1.0, 2.0, 3.0),
            direction: DMat3::IDENTITY,
            interpolation: Interpolation::Nearest,
        };
        let grid = Grid::on(lattice, Samples::U8((0..6).collect())).expect("valid");
        let corners = between_samples(Arc::new(grid));
        assert_eq!(corners.lattice().bounds(), lattice.bounds());
        assert_eq!(corners.lattice().cells(), lattice.cells());
        let read = |low, size| corners.read(Region { low, size }).expect("inside");
        let layer = [0, 1, 2, 2, 3, 4, 5, 5, 3, 4, 5, 5];
        assert_eq!(
            read([0; 3], [4, 3, 2]),
            Samples::U8([layer, layer].concat())
        );
        assert_eq!(read([1, 0, 0], [2, 2, 1]), Samples::U8(vec![1, 2, 4, 5]));
        assert_eq!(read([3, 2, 1], [1, 1, 1]), Samples::U8(vec![5]));
    }
}
