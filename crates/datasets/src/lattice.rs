//! Boxes of cubes, cut into tetrahedra that agree across the cubes' faces.

use tetrascope_core::glam::DVec3;

/// A tensor-product lattice: points at every (x, y, z) of three increasing lists.
///
/// Point (i, j, k) has the index i + j·nx + k·nx·ny, with nx and ny points along
/// the first two axes; cubes are counted likewise.
pub(crate) struct Lattice {
    pub(crate) axes: [Vec<f64>; 3],
}

/// How a cube becomes tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Split {
    /// One tetrahedron inside and four corners, mirrored from cube to cube: the
    /// fewest cells, and of good shape.
    Five,
    /// Kuhn's: a tetrahedron for each order of the axes, all around the diagonal
    /// from (0, 0, 0) to (1, 1, 1); the same in every cube.
    Six,
}

impl Split {
    pub(crate) fn cells(self) -> u64 {
        match self {
            Split::Five => 5,
            Split::Six => 6,
        }
    }

    /// The tetrahedra of a cube, positively oriented. Corner c of a cube is at
    /// (c & 1, c >> 1 & 1, c >> 2).
    fn pattern(self, odd: bool) -> &'static [[u8; 4]] {
        match (self, odd) {
            (Split::Five, false) => &[
                [0, 5, 3, 6],
                [0, 1, 3, 5],
                [0, 3, 2, 6],
                [0, 6, 4, 5],
                [3, 6, 5, 7],
            ],
            (Split::Five, true) => &[
                [1, 2, 4, 7],
                [0, 1, 2, 4],
                [1, 3, 2, 7],
                [1, 4, 5, 7],
                [2, 6, 4, 7],
            ],
            // By order of the axes: xyz, yzx, zxy; xzy, yxz, zyx.
            (Split::Six, _) => &[
                [0, 1, 3, 7],
                [0, 2, 6, 7],
                [0, 4, 5, 7],
                [0, 5, 1, 7],
                [0, 3, 2, 7],
                [0, 6, 4, 7],
            ],
        }
    }
}

impl Lattice {
    /// The cube [−half, half]³, cut into `n` parts along each axis.
    pub(crate) fn centered(half: f64, n: [usize; 3]) -> Lattice {
        // 2i − n is exact, so the lattice is symmetric to the last bit.
        let axis = |n: usize| {
            (0..=n)
                .map(|i| half * (2.0 * i as f64 - n as f64) / n as f64)
                .collect()
        };
        Lattice { axes: n.map(axis) }
    }

    /// How many cubes there are along each axis.
    pub(crate) fn cubes(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| self.axes[a].len() - 1)
    }

    /// How far apart the indices of neighbors along each axis are.
    pub(crate) fn strides(&self) -> [usize; 3] {
        let [x, y, _] = &self.axes;
        [1, x.len(), x.len() * y.len()]
    }

    /// All points, by index.
    pub(crate) fn points(&self) -> Vec<DVec3> {
        let [xs, ys, zs] = &self.axes;
        let mut points = Vec::with_capacity(xs.len() * ys.len() * zs.len());
        for &z in zs {
            for &y in ys {
                points.extend(xs.iter().map(|&x| DVec3::new(x, y, z)));
            }
        }
        points
    }

    /// The point with this index.
    pub(crate) fn point(&self, point: u32) -> DVec3 {
        let [xs, ys, zs] = &self.axes;
        let point = point as usize;
        let row = point / xs.len();
        DVec3::new(xs[point % xs.len()], ys[row % ys.len()], zs[row / ys.len()])
    }

    /// How many tetrahedra all cubes are.
    pub(crate) fn cell_count(&self, split: Split) -> u64 {
        split.cells() * self.cubes().map(|n| n as u64).iter().product::<u64>()
    }

    /// One of them, by its number in [`Lattice::tetrahedra`].
    pub(crate) fn tetrahedron(&self, split: Split, number: u64) -> [u32; 4] {
        let (cube, piece) = (number / split.cells(), number % split.cells());
        let [nx, ny, _] = self.cubes().map(|n| n as u64);
        let [i, j, k] = [cube % nx, cube / nx % ny, cube / (nx * ny)];
        let [_, y, z] = self.strides().map(|stride| stride as u64);
        let first = i + j * y + k * z;
        split.pattern((i + j + k) % 2 == 1)[piece as usize].map(|corner| {
            let c = u64::from(corner);
            (first + (c & 1) + (c >> 1 & 1) * y + (c >> 2) * z) as u32
        })
    }

    /// The points that cells have as `corners`, increasing; the corners are
    /// renumbered to be indices into them.
    pub(crate) fn used(&self, corners: &mut [u32]) -> Vec<u32> {
        let count: usize = self.axes.iter().map(Vec::len).product();
        let mut renumbered = vec![0u32; count];
        for &p in corners.iter() {
            renumbered[p as usize] = 1;
        }
        let mut used = Vec::new();
        for (p, new) in renumbered.iter_mut().enumerate() {
            if *new == 1 {
                *new = used.len() as u32;
                used.push(p as u32);
            }
        }
        for p in corners {
            *p = renumbered[*p as usize];
        }
        used
    }

    /// The tetrahedra of all cubes.
    pub(crate) fn tetrahedra(&self, split: Split) -> Vec<[u32; 4]> {
        self.tetrahedra_where(split, |_| true)
    }

    /// The tetrahedra of all cubes, six each, around one of their four diagonals: that from
    /// corner `diagonal`, 0 to 3, to the corner opposite.
    pub(crate) fn tetrahedra_along(&self, diagonal: u64) -> Vec<[u32; 4]> {
        // Kuhn's six, mirrored; one mirror turns them inside out.
        let mirrors = (diagonal & 3) as u8;
        let pattern = Split::Six.pattern(false).iter().map(|tet| {
            let [a, b, c, d] = tet.map(|corner| corner ^ mirrors);
            match mirrors.count_ones() % 2 {
                0 => [a, b, c, d],
                _ => [a, c, b, d],
            }
        });
        let pattern: Vec<[u8; 4]> = pattern.collect();
        self.cut(|_| true, |_| &pattern)
    }

    /// The tetrahedra of the cubes (i, j, k) that `keep` keeps.
    pub(crate) fn tetrahedra_where(
        &self,
        split: Split,
        keep: impl Fn([usize; 3]) -> bool,
    ) -> Vec<[u32; 4]> {
        self.cut(keep, |odd| split.pattern(odd))
    }

    /// Cuts the cubes that are kept by a pattern, which may be another for every second cube.
    fn cut<'a>(
        &self,
        keep: impl Fn([usize; 3]) -> bool,
        pattern: impl Fn(bool) -> &'a [[u8; 4]],
    ) -> Vec<[u32; 4]> {
        let [nx, ny, nz] = self.cubes();
        let strides = self.strides();
        let mut tetrahedra = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in (0..nx).filter(|&i| keep([i, j, k])) {
                    let first = i + j * strides[1] + k * strides[2];
                    let corner = |c: u8| {
                        let c = c as usize;
                        (first + (c & 1) + (c >> 1 & 1) * strides[1] + (c >> 2) * strides[2]) as u32
                    };
                    let pattern = pattern((i + j + k) % 2 == 1);
                    tetrahedra.extend(pattern.iter().map(|tet| tet.map(corner)));
                }
            }
        }
        tetrahedra
    }
}

/// Cubes along each axis of a nearly cubic lattice whose tetrahedra come nearest
/// to `cells`; the axes differ by one at most.
pub(crate) fn nearest_dimensions(cells: u64, split: Split) -> [usize; 3] {
    nearest_factors(cells, split.cells())
}

/// Three nearly equal factors whose product times `unit` comes nearest to `target`.
pub(crate) fn nearest_factors(target: u64, unit: u64) -> [usize; 3] {
    let n = ((target / unit) as f64).cbrt() as u64;
    (n.max(2) - 1..n + 2)
        .flat_map(|n| [[n, n, n], [n + 1, n, n], [n + 1, n + 1, n]])
        .min_by_key(|d| target.abs_diff(unit * d.iter().product::<u64>()))
        .expect("there are candidates")
        .map(|n| n as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::checks;
    use tetrascope_core::TetMesh;

    fn mesh(lattice: &Lattice, split: Split) -> TetMesh {
        let points = lattice.points();
        let values = vec![0.0; points.len()];
        let scalars = checks::point_scalars(values);
        TetMesh::from_tetrahedra(points, lattice.tetrahedra(split), scalars).expect("valid")
    }

    // Odd and even sizes, uneven spacing: faces agree and the box is filled.
    #[test]
    fn both_splits_fill_the_box_and_agree_across_faces() {
        let lattice = Lattice {
            axes: [
                vec![0.0, 0.5, 2.0, 3.0],
                vec![-1.0, 0.0, 4.0],
                vec![0.0, 0.25, 1.0],
            ],
        };
        for split in [Split::Five, Split::Six] {
            let mesh = mesh(&lattice, split);
            assert_eq!(mesh.cell_count() as u64, 12 * split.cells());
            checks::conforms(&mesh);
            checks::positive(&mesh);
            // 3 × 5 × 1; all coordinates are dyadic, so only the sixths round.
            assert!((checks::volume(&mesh) - 15.0).abs() < 1e-13);
            // Two triangles on each of the 2 (3·2 + 2·2 + 3·2) outer squares.
            assert_eq!(checks::boundary(&mesh).len(), 64);
        }
    }

    #[test]
    fn dimensions_come_as_near_as_they_can() {
        assert_eq!(nearest_dimensions(148_955, Split::Five), [31, 31, 31]);
        assert_eq!(nearest_dimensions(1, Split::Six), [1, 1, 1]);
        for cells in (5..200_000).step_by(997) {
            let d = nearest_dimensions(cells, Split::Five);
            let made = 5 * d.iter().product::<usize>() as u64;
            // Half the step from n³ to n²(n + 1), relative: 1/(2n).
            let n = d[2] as f64;
            let error = made.abs_diff(cells) as f64 / made as f64;
            assert!(error <= 0.5 * (n + 1.0) / (n * n), "{cells}: {d:?}");
        }
    }

    #[test]
    fn the_lattice_is_symmetric_to_the_last_bit() {
        let lattice = Lattice::centered(1.0, [31, 7, 10]);
        for axis in &lattice.axes {
            for (a, b) in axis.iter().zip(axis.iter().rev()) {
                assert_eq!(*a, -b);
            }
        }
    }
}
