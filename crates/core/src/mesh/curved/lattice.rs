//! The points in a cell that is cut into n parts along each edge, and the cells between them.
//!
//! A point is given by weights of the cell's corners, as integers, so that what two cells say of a
//! point on their face is the same to the last bit.

/// Points and cells that one cell becomes.
#[derive(Clone, Debug)]
pub(super) struct Lattice {
    /// For each point the corners whose weight is not 0, in parts of [`whole`].
    pub(super) points: Vec<Vec<(usize, u64)>>,
    /// VTK's type, and places among the points.
    pub(super) cells: Vec<(u8, Vec<usize>)>,
}

/// Divisible by all numbers up to 16, the most parts.
const DIVISIBLE: u64 = 720_720;

/// The sum of a point's weights of corners: divisible by each product of three numbers of parts
/// that occurs.
pub(super) fn whole(parts: usize) -> u64 {
    DIVISIBLE * (parts as u64).pow(3)
}

/// Corners of weight 0 left out.
fn named<const N: usize>(weights: [u64; N]) -> Vec<(usize, u64)> {
    (0..N)
        .zip(weights)
        .filter(|(_, weight)| *weight != 0)
        .collect()
}

/// Tetrahedra: n³ of them. What is between four at the corners is an octahedron, and becomes four.
pub(super) fn tetrahedron(n: usize) -> Lattice {
    let unit = whole(n) / n as u64;
    let mut points = Vec::new();
    let mut index = vec![0; (n + 1).pow(3)];
    let at = |i: usize, j: usize, k: usize| i + (n + 1) * (j + (n + 1) * k);
    for k in 0..=n {
        for j in 0..=n - k {
            for i in 0..=n - k - j {
                index[at(i, j, k)] = points.len();
                points.push(named([n - i - j - k, i, j, k].map(|w| w as u64 * unit)));
            }
        }
    }
    let mut cells = Vec::new();
    for k in 0..n {
        for j in 0..n - k {
            for i in 0..n - k - j {
                let p = |a: usize, b: usize, c: usize| index[at(i + a, j + b, k + c)];
                let mut add = |corners: [usize; 4]| cells.push((10, corners.to_vec()));
                add([p(0, 0, 0), p(1, 0, 0), p(0, 1, 0), p(0, 0, 1)]);
                if i + j + k + 2 <= n {
                    // The octahedron, around the line from its first corner to its last.
                    let (first, last) = (p(1, 0, 0), p(0, 1, 1));
                    let ring = [p(0, 1, 0), p(1, 1, 0), p(1, 0, 1), p(0, 0, 1)];
                    for side in 0..4 {
                        add([first, last, ring[(side + 1) % 4], ring[side]]);
                    }
                }
                if i + j + k + 3 <= n {
                    add([p(1, 0, 1), p(1, 1, 0), p(0, 1, 1), p(1, 1, 1)]);
                }
            }
        }
    }
    Lattice { points, cells }
}

/// Hexahedra: n³ of them.
pub(super) fn hexahedron(n: usize) -> Lattice {
    let unit = whole(n) / (n as u64).pow(3);
    let mut points = Vec::new();
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n {
                let [x, y, z] = [i, j, k].map(|w| [(n - w) as u64, w as u64]);
                let weight = |a: usize, b: usize, c: usize| x[a] * y[b] * z[c] * unit;
                points.push(named([
                    weight(0, 0, 0),
                    weight(1, 0, 0),
                    weight(1, 1, 0),
                    weight(0, 1, 0),
                    weight(0, 0, 1),
                    weight(1, 0, 1),
                    weight(1, 1, 1),
                    weight(0, 1, 1),
                ]));
            }
        }
    }
    let side = n + 1;
    let mut cells = Vec::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n {
                let p = i + side * (j + side * k);
                let lower = [p, p + 1, p + 1 + side, p + side];
                let upper = lower.map(|p| p + side * side);
                cells.push((12, [lower, upper].concat()));
            }
        }
    }
    Lattice { points, cells }
}

/// Wedges: n³ of them.
pub(super) fn wedge(n: usize) -> Lattice {
    let unit = whole(n) / (n as u64).pow(2);
    let mut points = Vec::new();
    let mut index = vec![0; (n + 1).pow(3)];
    let at = |i: usize, j: usize, k: usize| i + (n + 1) * (j + (n + 1) * k);
    for k in 0..=n {
        for j in 0..=n {
            for i in 0..=n - j {
                index[at(i, j, k)] = points.len();
                let triangle = [n - i - j, i, j].map(|w| w as u64 * unit);
                let [a, b, c] = triangle.map(|w| w * (n - k) as u64);
                let [d, e, f] = triangle.map(|w| w * k as u64);
                points.push(named([a, b, c, d, e, f]));
            }
        }
    }
    let mut cells = Vec::new();
    for k in 0..n {
        for j in 0..n {
            for i in 0..n - j {
                let p = |a: usize, b: usize, c: usize| index[at(i + a, j + b, k + c)];
                let mut add = |corners: [[usize; 2]; 3]| {
                    let layer = |c: usize| corners.map(|[a, b]| p(a, b, c));
                    cells.push((13, [layer(0), layer(1)].concat()));
                };
                add([[0, 0], [1, 0], [0, 1]]);
                if i + j + 2 <= n {
                    add([[1, 0], [1, 1], [0, 1]]);
                }
            }
        }
    }
    Lattice { points, cells }
}

/// Pyramids, upright and upside down, and tetrahedra between them.
pub(super) fn pyramid(n: usize) -> Lattice {
    let mut points = Vec::new();
    let mut first = Vec::new();
    for k in 0..=n {
        first.push(points.len());
        let m = n - k;
        let top = whole(n) / n as u64 * k as u64;
        for j in 0..=m {
            for i in 0..=m {
                // Bilinear in a square of m parts, whose corners have m of n parts in all.
                let unit = match m {
                    0 => 0,
                    _ => whole(n) / (n * m) as u64,
                };
                let corner = |x: usize, y: usize| (x * y) as u64 * unit;
                let base = [
                    corner(m - i, m - j),
                    corner(i, m - j),
                    corner(i, j),
                    corner(m - i, j),
                ];
                let [a, b, c, d] = base;
                points.push(named([a, b, c, d, top]));
            }
        }
    }
    let at = |i: usize, j: usize, k: usize| first[k] + i + (n - k + 1) * j;
    let square = |i: usize, j: usize, k: usize| {
        [
            at(i, j, k),
            at(i + 1, j, k),
            at(i + 1, j + 1, k),
            at(i, j + 1, k),
        ]
    };
    let mut cells = Vec::new();
    for k in 0..n {
        let m = n - k;
        for j in 0..m {
            for i in 0..m {
                let top = at(i, j, k + 1);
                cells.push((14, [&square(i, j, k)[..], &[top]].concat()));
                let (inner_i, inner_j) = (i + 1 < m, j + 1 < m);
                if inner_i && inner_j {
                    let below = at(i + 1, j + 1, k);
                    let [a, b, c, d] = square(i, j, k + 1);
                    cells.push((14, vec![a, d, c, b, below]));
                }
                let next = [at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)];
                if inner_i {
                    let corners = vec![next[0], next[1], top, at(i + 1, j, k + 1)];
                    cells.push((10, corners));
                }
                if inner_j {
                    let corners = vec![next[1], next[2], top, at(i, j + 1, k + 1)];
                    cells.push((10, corners));
                }
            }
        }
    }
    Lattice { points, cells }
}
