//! The samples of a grid as rays meet them.

use tetrascope_core::Grid;
use tetrascope_core::grid::coverage::THERE;
use tetrascope_core::grid::{Interpolation, Samples};

/// A grid with what finding a cell's corners takes.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) grid: Grid,
    /// Cells along each axis.
    pub(crate) cells: [usize; 3],
    /// Whether each sample fills a cell of its own.
    pub(crate) fills_cells: bool,
    /// From the index of a cell's first corner to those of all eight, x fastest; all 0 where
    /// the one sample is all corners.
    offsets: [usize; 8],
}

impl Field {
    pub(crate) fn new(grid: &Grid) -> Field {
        let [nx, ny, _] = grid.dims();
        let lattice = grid.lattice();
        let fills_cells = lattice.interpolation == Interpolation::Nearest;
        let corner = |i: usize| (i & 1) + nx * ((i >> 1 & 1) + ny * (i >> 2));
        Field {
            cells: lattice.cells(),
            fills_cells,
            offsets: match fills_cells {
                true => [0; 8],
                false => std::array::from_fn(corner),
            },
            grid: grid.clone(),
        }
    }

    /// Samples along each axis that a brick of `cells` cells has.
    pub(crate) fn samples_of(&self, cells: usize) -> usize {
        cells + usize::from(!self.fills_cells)
    }

    /// The index of a cell's first corner.
    #[inline(always)]
    pub(crate) fn first(&self, [x, y, z]: [u32; 3]) -> usize {
        let [nx, ny, _] = self.grid.dims();
        x as usize + nx * (y as usize + ny * z as usize)
    }

    /// The samples at the corners of a cell, x fastest. Every type of samples fits f32.
    #[inline(always)]
    pub(crate) fn corners(&self, cell: [u32; 3]) -> [f32; 8] {
        let first = self.first(cell);
        let (row, layer) = (self.offsets[2], self.offsets[4]);
        let one = self.offsets[1];
        #[inline(always)]
        fn of<T: Copy + Into<f32>>(
            samples: &[T],
            first: usize,
            [one, row, layer]: [usize; 3],
        ) -> [f32; 8] {
            // One check of bounds for each pair.
            let pair = |at: usize| {
                let pair = &samples[at..=at + one];
                (pair[0].into(), pair[one].into())
            };
            let ((a, b), (c, d)) = (pair(first), pair(first + row));
            let ((e, f), (g, h)) = (pair(first + layer), pair(first + layer + row));
            [a, b, c, d, e, f, g, h]
        }
        let steps = [one, row, layer];
        match self.grid.samples() {
            Samples::U8(v) => of(v, first, steps),
            Samples::U16(v) => of(v, first, steps),
            Samples::I16(v) => of(v, first, steps),
            Samples::F32(v) => of(v, first, steps),
            other => self.offsets.map(|offset| other.get(first + offset) as f32),
        }
    }

    /// How much of the samples at the corners of a cell is there.
    pub(crate) fn coverages(&self, cell: [u32; 3]) -> Option<[f64; 8]> {
        let coverage = self.grid.coverage()?;
        let first = self.first(cell);
        Some(self.offsets.map(|offset| coverage[first + offset].into()))
    }

    /// The corners as f64, NaN where less than [`THERE`] of a sample is.
    pub(crate) fn corners_there(&self, cell: [u32; 3]) -> [f64; 8] {
        let mut corners = self.corners(cell).map(f64::from);
        if let Some(coverages) = self.coverages(cell) {
            for (corner, coverage) in corners.iter_mut().zip(coverages) {
                if coverage < f64::from(THERE) {
                    *corner = f64::NAN;
                }
            }
        }
        corners
    }

    /// Bytes of the samples and of their coverage.
    pub(crate) fn bytes(&self) -> u64 {
        let coverage = self.grid.coverage().map_or(0, size_of_val);
        self.grid.samples().bytes() + coverage as u64
    }
}
