//! How the octree divides a grid into boxes; nothing about what is in them.

use tetrascope_core::grid::Region;

use crate::options::MAX_LEVEL;

/// An axis is halved while its boxes keep about this many cells.
const LEAST_CELLS: usize = 8;

/// Nested boxes of cells.
///
/// Level l divides each axis into 2^l boxes, or as many as it has at most; all boxes of a
/// level have the same size, so those at the far ends may reach out of the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Boxes {
    /// Cells of the volume along each axis.
    pub(crate) cells: [usize; 3],
    /// How often each axis is halved.
    halvings: [u32; 3],
    /// Cells of a box of the deepest level.
    leaf: [usize; 3],
}

/// A box of one level, by its place along each axis.
pub(crate) type Place = [usize; 3];

impl Boxes {
    /// Those of a grid with so many cells along each axis.
    pub(crate) fn new(cells: [usize; 3]) -> Boxes {
        let halvings = cells.map(|c| {
            // One more, as 256 samples have 255 cells.
            let deep = ((c + 1) / LEAST_CELLS).max(1).ilog2();
            deep.min(MAX_LEVEL)
        });
        Boxes {
            cells,
            halvings,
            leaf: [0, 1, 2].map(|a| cells[a].div_ceil(1 << halvings[a])),
        }
    }

    /// The number of the deepest level; the whole volume is level 0.
    pub(crate) fn deepest(&self) -> u32 {
        self.halvings.into_iter().max().unwrap_or(0)
    }

    /// How often each axis is halved down to this level.
    pub(crate) fn halvings(&self, level: u32) -> [u32; 3] {
        self.halvings.map(|h| level.min(h))
    }

    /// The first level whose boxes, by their sizes in cells, fit; or the deepest.
    pub(crate) fn first_level(&self, fits: impl Fn([usize; 3]) -> bool) -> u32 {
        let fits = |level: &u32| fits(self.box_size(*level));
        (0..self.deepest()).find(fits).unwrap_or(self.deepest())
    }

    /// Cells along each axis of a box.
    pub(crate) fn box_size(&self, level: u32) -> [usize; 3] {
        [0, 1, 2].map(|a| self.leaf[a] << (self.halvings[a] - level.min(self.halvings[a])))
    }

    /// How many boxes a level has along each axis, those outside of the volume too.
    pub(crate) fn divisions(&self, level: u32) -> [usize; 3] {
        self.halvings(level).map(|h| 1 << h)
    }

    /// How many boxes a level has, those outside of the volume not counted.
    pub(crate) fn box_count(&self, level: u32) -> usize {
        let size = self.box_size(level);
        (0..3).map(|a| self.cells[a].div_ceil(size[a])).product()
    }

    /// The box's number among those of its level.
    pub(crate) fn index(&self, level: u32, place: Place) -> usize {
        let [x, y, _] = self.divisions(level);
        place[0] + x * (place[1] + y * place[2])
    }

    /// The box of level `above` that contains this one.
    pub(crate) fn ancestor(&self, level: u32, place: Place, above: u32) -> Place {
        [0, 1, 2].map(|a| {
            let h = self.halvings[a];
            place[a] >> (level.min(h) - above.min(h))
        })
    }

    /// The box's least corner, lattice space.
    pub(crate) fn low(&self, level: u32, place: Place) -> [usize; 3] {
        let size = self.box_size(level);
        [0, 1, 2].map(|a| place[a] * size[a])
    }

    /// The samples of a box and `reach` around it, as far as there are any; `None` if the
    /// box lies outside of the volume.
    pub(crate) fn region(&self, level: u32, place: Place, reach: usize) -> Option<Region> {
        let (low, size) = (self.low(level, place), self.box_size(level));
        let outside = (0..3).any(|a| low[a] >= self.cells[a]);
        let first = low.map(|l| l.saturating_sub(reach));
        let last = [0, 1, 2].map(|a| (low[a] + size[a] + reach).min(self.cells[a]));
        (!outside).then(|| Region {
            low: first,
            size: [0, 1, 2].map(|a| last[a] + 1 - first[a]),
        })
    }
}

/// Every place in a lattice of boxes, x fastest.
pub(crate) fn places(divisions: [usize; 3]) -> impl Iterator<Item = Place> {
    let [nx, ny, nz] = divisions;
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}
