//! From voxel cell to voxel cell along a ray, with leaps over bricks in which nothing shows.

use tetrascope_core::glam::DVec3;

use super::tree::{Look, Tree, bit};

/// A straight line in the space of cells, `origin + t · slope`, t in world units.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Line {
    pub(crate) origin: DVec3,
    pub(crate) slope: DVec3,
}

/// The way of a ray through a grid, as far as it is walked.
///
/// Planes are crossed at (k − origin)/slope, computed for each plane by itself, so that rounding
/// keeps these times in order. Axes along which the ray falls are mirrored: cell c becomes
/// `side − 1 − c`, which flips its bits, as `side` is a power of two. So all coordinates only
/// rise, and blocks that are aligned stay aligned.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Walk {
    /// Mirrored.
    origin: [f64; 3],
    slope: [f64; 3],
    /// t of the plane k is k · `pace` + `late`.
    pace: [f64; 3],
    late: [f64; 3],
    /// The last cell along each axis, mirrored.
    last: [u32; 3],
    flip: [u32; 3],
    /// Which axes are mirrored, as bits.
    octant: usize,
    cell: [u32; 3],
    /// When the present cell is left along each axis.
    leaves: [f64; 3],
    /// Which cells show in the present block, once that was looked up.
    word: Option<u64>,
    t: f64,
    end: f64,
    /// Cells passed over in leaps.
    pub(crate) skipped: u64,
}

/// The stretch of positive length that the line and a cell have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) cell: [u32; 3],
    pub(crate) t_in: f64,
    pub(crate) t_out: f64,
}

impl Stretch {
    /// Where in the cell the line is at `t`, as shares of its sides.
    #[inline(always)]
    pub(crate) fn place(&self, line: &Line, t: f64) -> [f64; 3] {
        let at =
            |axis: usize| line.origin[axis] + t * line.slope[axis] - f64::from(self.cell[axis]);
        [at(0), at(1), at(2)]
    }

    /// The same, kept in [0, 1], which rounding may leave.
    pub(crate) fn clamped(&self, line: &Line, t: f64) -> [f64; 3] {
        self.place(line, t).map(|share| share.clamp(0.0, 1.0))
    }
}

impl Walk {
    /// The way from t = `near` to `far` through `tree`'s cells; `None` if there is none.
    pub(crate) fn new(line: Line, tree: &Tree, [near, far]: [f64; 2]) -> Option<Walk> {
        let (mut start, mut end) = (near, far);
        let mut walk = Walk::default();
        let side = tree.side();
        for axis in 0..3 {
            let (origin, slope) = (line.origin[axis], line.slope[axis]);
            let cells = tree.cells()[axis];
            if slope == 0.0 {
                if !(0.0..=f64::from(cells)).contains(&origin) {
                    return None;
                }
                walk.origin[axis] = origin;
                walk.late[axis] = f64::INFINITY;
                walk.last[axis] = cells - 1;
                continue;
            }
            let falls = slope < 0.0;
            let (first, origin) = match falls {
                true => (f64::from(side - cells), f64::from(side) - origin),
                false => (0.0, origin),
            };
            let slope = slope.abs();
            let pace = slope.recip();
            // A slope below the least normal number has no reciprocal: no plane is reached.
            let late = match pace.is_finite() {
                true => -origin * pace,
                false => f64::INFINITY,
            };
            let pace = if pace.is_finite() { pace } else { 0.0 };
            walk.origin[axis] = origin;
            walk.slope[axis] = slope;
            walk.pace[axis] = pace;
            walk.late[axis] = late;
            walk.last[axis] = if falls { side - 1 } else { cells - 1 };
            walk.flip[axis] = if falls { side - 1 } else { 0 };
            walk.octant |= usize::from(falls) << axis;
            if late.is_finite() {
                start = start.max(first * pace + late);
                end = end.min((first + f64::from(cells)) * pace + late);
            } else if !(first..=first + f64::from(cells)).contains(&origin) {
                return None;
            }
        }
        if !(start < end && end.is_finite()) {
            return None;
        }
        walk.t = start;
        walk.end = end;
        for axis in 0..3 {
            let place = walk.origin[axis] + start * walk.slope[axis];
            let last = walk.last[axis];
            let first = last + 1 - tree.cells()[axis];
            // The cast saturates.
            walk.cell[axis] = (place as u32).clamp(first, last);
            walk.leaves[axis] = walk.crosses(axis, walk.cell[axis] + 1);
        }
        Some(walk)
    }

    /// The next cell in which something shows.
    pub(crate) fn next(&mut self, tree: &Tree) -> Option<Stretch> {
        while self.t < self.end {
            let cell = [
                self.cell[0] ^ self.flip[0],
                self.cell[1] ^ self.flip[1],
                self.cell[2] ^ self.flip[2],
            ];
            if self.word.is_none() {
                self.word = match tree.look(cell, self.octant) {
                    Look::Cells(word) => Some(word),
                    Look::Nothing { shift, blocks } => {
                        self.leap(shift, blocks);
                        continue;
                    }
                };
            }
            let (axis, leaves) = least(self.leaves);
            let (t_in, t_out) = (self.t, leaves.min(self.end));
            self.t = self.t.max(leaves);
            let next = self.cell[axis] + 1;
            let shows = self.word.is_some_and(|word| word >> bit(cell) & 1 == 1);
            if next & 3 == 0 {
                self.word = None;
            }
            if next > self.last[axis] {
                self.t = f64::INFINITY;
            }
            self.cell[axis] = next;
            self.leaves[axis] = self.crosses(axis, next + 1);
            if shows && t_out > t_in {
                return Some(Stretch { cell, t_in, t_out });
            }
        }
        None
    }

    /// When the plane between cells `plane` − 1 and `plane` is crossed.
    #[inline(always)]
    fn crosses(&self, axis: usize, plane: u32) -> f64 {
        f64::from(plane) * self.pace[axis] + self.late[axis]
    }

    /// Passes over a cube of `blocks` blocks, each of 2^`shift` cells, whose first is that of the
    /// present cell.
    fn leap(&mut self, shift: u32, blocks: u32) {
        let plane = self.cell.map(|cell| ((cell >> shift) + blocks) << shift);
        let (across, leaves) = least([
            self.crosses(0, plane[0]),
            self.crosses(1, plane[1]),
            self.crosses(2, plane[2]),
        ]);
        let leaves = leaves.max(self.t);
        let until = leaves.min(self.end);
        for (axis, plane) in plane.into_iter().enumerate() {
            let before = self.cell[axis];
            let place = self.origin[axis] + until * self.slope[axis];
            // The cast saturates.
            let mut cell = (place as u32).clamp(before, plane - 1);
            if axis == across && leaves < self.end {
                cell = plane;
            }
            self.cell[axis] = cell;
            self.skipped += u64::from(cell - before);
            self.leaves[axis] = self.crosses(axis, cell + 1);
        }
        self.t = match self.cell[across] > self.last[across] {
            true => f64::INFINITY,
            false => leaves,
        };
    }
}

/// Which of three numbers is the least, and that number. Without branches, as which one it is
/// cannot be foretold.
#[inline(always)]
fn least([x, y, z]: [f64; 3]) -> (usize, f64) {
    let (other, second) = (1 + usize::from(z < y), y.min(z));
    (other * usize::from(second < x), x.min(second))
}
