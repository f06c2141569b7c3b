//! From voxel cell to voxel cell along a ray.

use tetrascope_core::glam::DVec3;

/// A straight line in lattice space, `origin + t · slope`, t in world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub(crate) origin: DVec3,
    pub(crate) slope: DVec3,
}

/// The cells on a line, front to back.
///
/// The planes of each axis are crossed at (k − origin)/slope, computed for each plane by
/// itself: rounding keeps these times in order, and the walk merges three ordered lists.
/// So it ends after at most as many steps as there are planes, and its stretches lie end
/// to end, whatever faces, edges or corners the line runs through; ties make stretches
/// of no length.
#[derive(Clone, Debug)]
pub(crate) struct Walk {
    line: Line,
    /// The last cell along each axis.
    last: [i64; 3],
    cell: [i64; 3],
    /// When the present cell is left along each axis.
    leaves: [f64; 3],
    t: f64,
    end: f64,
    /// The axis across which the present cell was entered.
    across: Option<usize>,
    /// The axis across which the line leaves the last cell; `None` where it ends inside.
    pub(crate) exit: Option<usize>,
}

/// The stretch that the line and a cell have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) cell: [usize; 3],
    pub(crate) t_in: f64,
    pub(crate) t_out: f64,
    /// The axis across which the line enters; `None` where it begins inside.
    pub(crate) across: Option<usize>,
}

impl Stretch {
    /// Where in the cell the line is at `t`, as shares of its sides.
    pub(crate) fn place(&self, line: &Line, t: f64) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let place = line.origin[axis] + t * line.slope[axis];
            (place - self.cell[axis] as f64).clamp(0.0, 1.0)
        })
    }
}

impl Walk {
    /// The way from t = `near` to `far` through `cells` cells along each axis; `None` if
    /// there is none.
    pub(crate) fn new(line: Line, cells: [usize; 3], [near, far]: [f64; 2]) -> Option<Walk> {
        let (mut start, mut across) = (near, None);
        let (mut end, mut exit) = (far, None);
        for (axis, cells) in cells.into_iter().enumerate() {
            let (origin, slope) = (line.origin[axis], line.slope[axis]);
            let far = cells as f64;
            if slope == 0.0 {
                if !(0.0..=far).contains(&origin) {
                    return None;
                }
                continue;
            }
            let (first, last) = if slope > 0.0 { (0.0, far) } else { (far, 0.0) };
            let (enters, leaves) = ((first - origin) / slope, (last - origin) / slope);
            if enters > start {
                (start, across) = (enters, Some(axis));
            }
            if leaves < end {
                (end, exit) = (leaves, Some(axis));
            }
        }
        if !(start < end && end.is_finite()) {
            return None;
        }
        let mut walk = Walk {
            line,
            last: cells.map(|c| c as i64 - 1),
            cell: [0; 3],
            leaves: [f64::INFINITY; 3],
            t: start,
            end,
            across,
            exit,
        };
        for axis in 0..3 {
            walk.locate(axis);
        }
        Some(walk)
    }

    /// Finds the cell along `axis` at the present t, by the times of its planes.
    fn locate(&mut self, axis: usize) {
        let (origin, slope) = (self.line.origin[axis], self.line.slope[axis]);
        let last = self.last[axis];
        // The cast saturates, the clamp does the rest.
        let mut cell = ((origin + self.t * slope).floor() as i64).clamp(0, last);
        if slope == 0.0 {
            self.cell[axis] = cell;
            return;
        }
        let step = if slope > 0.0 { 1 } else { -1 };
        let inside = |c: i64| (0..=last).contains(&c);
        while inside(cell + step) && self.leaves_at(axis, cell) <= self.t {
            cell += step;
        }
        while inside(cell - step) && self.leaves_at(axis, cell - step) > self.t {
            cell -= step;
        }
        self.cell[axis] = cell;
        self.leaves[axis] = self.leaves_at(axis, cell);
    }

    /// When the line leaves `cell` along `axis`.
    fn leaves_at(&self, axis: usize, cell: i64) -> f64 {
        let slope = self.line.slope[axis];
        let plane = if slope > 0.0 { cell + 1 } else { cell };
        (plane as f64 - self.line.origin[axis]) / slope
    }
}

impl Iterator for Walk {
    type Item = Stretch;

    fn next(&mut self) -> Option<Stretch> {
        if self.t >= self.end {
            return None;
        }
        let [x, y, z] = self.leaves;
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        let stretch = Stretch {
            cell: self.cell.map(|c| c as usize),
            t_in: self.t,
            t_out: self.leaves[axis].min(self.end),
            across: self.across,
        };
        self.t = self.leaves[axis];
        self.across = Some(axis);
        let step = if self.line.slope[axis] > 0.0 { 1 } else { -1 };
        let next = self.cell[axis] + step;
        if (0..=self.last[axis]).contains(&next) {
            self.cell[axis] = next;
            self.leaves[axis] = self.leaves_at(axis, next);
        } else {
            self.t = self.end;
        }
        Some(stretch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walk(origin: [f64; 3], slope: [f64; 3], cells: [usize; 3]) -> Vec<Stretch> {
        let line = Line {
            origin: origin.into(),
            slope: slope.into(),
        };
        let whole = [0.0, f64::INFINITY];
        Walk::new(line, cells, whole)
            .into_iter()
            .flatten()
            .collect()
    }

    /// End to end, without doubling, each stretch where its cell is to 1e-12.
    fn check(stretches: &[Stretch], origin: [f64; 3], slope: [f64; 3]) {
        for pair in stretches.windows(2) {
            assert_eq!(pair[0].t_out, pair[1].t_in);
        }
        for s in stretches {
            assert!(s.t_in <= s.t_out);
            for t in [s.t_in, s.t_out] {
                for axis in 0..3 {
                    let at = origin[axis] + t * slope[axis] - s.cell[axis] as f64;
                    assert!((-1e-12..=1.0 + 1e-12).contains(&at), "{s:?} {axis} {at}");
                }
            }
        }
    }

    #[test]
    fn faces_edges_corners_and_axes_lose_nothing() {
        let cells = [4, 3, 5];
        let mut count = 0;
        // Every origin on a half-integer lattice, every direction of a 5³ star.
        for o in 0..(11 * 9 * 13) {
            let origin = [o % 11, o / 11 % 9, o / 99].map(|c| f64::from(c) * 0.5 - 0.5);
            for d in 0..125 {
                let slope = [d % 5, d / 5 % 5, d / 25].map(|c| f64::from(c) - 2.0);
                if slope == [0.0; 3] {
                    continue;
                }
                let found = walk(origin, slope, cells);
                check(&found, origin, slope);
                let (mut start, mut end) = (0.0f64, f64::INFINITY);
                let mut outside = false;
                for axis in 0..3 {
                    let far = cells[axis] as f64;
                    if slope[axis] == 0.0 {
                        outside |= origin[axis] < 0.0 || origin[axis] > far;
                        continue;
                    }
                    let a = -origin[axis] / slope[axis];
                    let b = (far - origin[axis]) / slope[axis];
                    start = start.max(a.min(b));
                    end = end.min(a.max(b));
                }
                let chord = if outside { 0.0 } else { (end - start).max(0.0) };
                let length: f64 = found.iter().map(|s| s.t_out - s.t_in).sum();
                assert!((length - chord).abs() < 1e-12, "{origin:?} {slope:?}");
                count += usize::from(chord > 0.0);
            }
        }
        assert!(count > 10_000);
    }

    #[test]
    fn a_part_of_the_way_is_that_part() {
        let line = Line {
            origin: DVec3::new(-1.0, 0.25, 0.5),
            slope: DVec3::X,
        };
        let part = |stretch| Walk::new(line, [4, 3, 5], stretch).into_iter().flatten();
        let found: Vec<Stretch> = part([1.5, 3.25]).collect();
        assert_eq!(found.len(), 3);
        assert_eq!(
            (found[0].t_in, found[0].cell[0], found[0].across),
            (1.5, 0, None)
        );
        assert_eq!((found[2].t_out, found[2].cell[0]), (3.25, 2));
        assert_eq!(part([6.0, 9.0]).count(), 0);
        assert_eq!(part([3.0, f64::NEG_INFINITY]).count(), 0);
    }

    #[test]
    fn tiny_and_huge_slopes_end() {
        for slope in [
            [1e-300, 1.0, 0.0],
            [5e-324, 1.0, 1e-320],
            [1e300, 1.0, 1.0],
            [1e-9, 1.0 - 1e-16, 1e-12],
        ] {
            let found = walk([1.0, -2.0, 2.0], slope, [4, 3, 5]);
            assert!(found.len() <= 15, "{found:?}");
            assert!(found.windows(2).all(|p| p[0].t_out == p[1].t_in));
        }
        assert!(walk([9.0, 0.0, 0.0], [1.0, 0.0, 0.0], [4, 3, 5]).is_empty());
        assert!(walk([f64::NAN, 0.0, 0.0], [1.0, 0.0, 0.0], [4, 3, 5]).is_empty());
    }
}
