//! Curved cells of order 2: which of their nodes is where, and the functions between them.
//!
//! Each kind is a *full* set of nodes on which functions are products, and a rule that makes these of
//! the nodes that the cell has: cells without nodes in their faces or in their middle
//! (serendipity) have functions that the full ones contain.
//!
//! Nodes are numbered as in VTK, whose classes `vtkQuadraticTetra`, `vtkQuadraticHexahedron`, … have
//! the same functions, except that of pyramids: those here are G. Bedrosian's ("Shape functions and
//! integration formulas for three-dimensional finite element analysis", 1992), which agree with
//! neighbors on all five faces.

use super::lattice::{self, Lattice, Point};

/// Which functions a cell has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    /// Quadratic in four barycentric coordinates: 10 nodes.
    Tetrahedron,
    /// Quadratic along each of three axes: 27 nodes.
    Hexahedron,
    /// Quadratic in a triangle and along an axis: 18 nodes.
    Wedge,
    /// Rational: 13 nodes.
    Pyramid,
}

/// A kind of curved cell.
#[derive(Clone, Debug)]
pub(super) struct Curved {
    pub(super) family: Family,
    /// Each node of the full set as a sum of the cell's own nodes times weights.
    full: Vec<Vec<(usize, f64)>>,
    /// How many nodes the cell has.
    nodes: usize,
}

/// Edges of a tetrahedron in the order of their nodes, 4 to 9.
pub(super) const TETRAHEDRON_EDGES: [[usize; 2]; 6] =
    [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// The node at place i + 3 j + 9 k of a hexahedron, in steps of half an edge.
const HEXAHEDRON: [usize; 27] = [
    0, 8, 1, 11, 24, 9, 3, 10, 2, //
    16, 22, 17, 20, 26, 21, 19, 23, 18, //
    4, 12, 5, 15, 25, 13, 7, 14, 6,
];

/// Edges of a triangle in the order of their nodes, 3 to 5.
pub(super) const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// The node at place a + 6 k of a wedge: node a of the triangle, in layer k.
const WEDGE: [usize; 18] = [
    0, 1, 2, 6, 7, 8, //
    12, 13, 14, 15, 16, 17, //
    3, 4, 5, 9, 10, 11,
];

impl Curved {
    /// The kind of a cell of VTK's type, if it is one of these.
    pub(super) fn of(cell_type: u8) -> Option<Curved> {
        let (family, nodes) = match cell_type {
            24 => (Family::Tetrahedron, 10),
            25 => (Family::Hexahedron, 20),
            26 => (Family::Wedge, 15),
            27 => (Family::Pyramid, 13),
            29 => (Family::Hexahedron, 27),
            31 => (Family::Wedge, 12),
            32 => (Family::Wedge, 18),
            33 => (Family::Hexahedron, 24),
            _ => return None,
        };
        let full = match family {
            Family::Tetrahedron | Family::Pyramid => {
                (0..nodes).map(|node| vec![(node, 1.0)]).collect()
            }
            Family::Hexahedron => (0..27).map(|place| hexahedron_node(place, nodes)).collect(),
            Family::Wedge => (0..18).map(|place| wedge_node(place, nodes)).collect(),
        };
        Some(Curved {
            family,
            full,
            nodes,
        })
    }

    #[cfg(test)]
    pub(super) fn nodes(&self) -> usize {
        self.nodes
    }

    pub(super) fn is_pyramid(&self) -> bool {
        self.family == Family::Pyramid
    }

    /// The full set of `values` at the cell's nodes.
    pub(super) fn fill(&self, values: &[glam::DVec3]) -> Vec<glam::DVec3> {
        let sum = |node: &Vec<(usize, f64)>| node.iter().map(|&(i, w)| values[i] * w).sum();
        self.full.iter().map(sum).collect()
    }

    /// Points and cells that this cell becomes with so many parts along each edge.
    pub(super) fn lattice(&self, parts: usize) -> Lattice {
        let (places, cells) = match self.family {
            Family::Tetrahedron => lattice::tetrahedron(parts),
            Family::Hexahedron => lattice::hexahedron(parts),
            Family::Wedge => lattice::wedge(parts),
            Family::Pyramid => lattice::pyramid(parts),
        };
        let point = |corners: Vec<(usize, u64)>| {
            let mut shares = [0.0; 8];
            for &(corner, weight) in &corners {
                shares[corner] = weight as f64 / lattice::whole(parts) as f64;
            }
            let full = self.family.functions(&shares);
            let mut weights = vec![0.0; self.nodes];
            for (function, nodes) in full.iter().zip(&self.full) {
                for &(node, weight) in nodes {
                    weights[node] += function * weight;
                }
            }
            let weights: Vec<(usize, f64)> =
                (0..).zip(weights).filter(|(_, w)| *w != 0.0).collect();
            let node = match *weights {
                [(node, 1.0)] => Some(node),
                _ => None,
            };
            Point {
                corners,
                weights,
                node,
            }
        };
        Lattice {
            points: places.into_iter().map(point).collect(),
            cells,
        }
    }
}

impl Family {
    /// The functions of the full set at the point with these weights of corners, whose sum is 1.
    pub(super) fn functions(self, corners: &[f64; 8]) -> Vec<f64> {
        let share = |wanted: &[usize]| wanted.iter().map(|&corner| corners[corner]).sum::<f64>();
        match self {
            Family::Tetrahedron => {
                let b = [0, 1, 2, 3].map(|corner| share(&[corner]));
                let at_corners = b.map(|b| b * (2.0 * b - 1.0));
                let on_edges = TETRAHEDRON_EDGES.map(|[i, j]| 4.0 * b[i] * b[j]);
                [&at_corners[..], &on_edges].concat()
            }
            Family::Hexahedron => {
                let axes = [[1, 2, 5, 6], [2, 3, 6, 7], [4, 5, 6, 7]];
                let [x, y, z] = axes.map(|corners| quadratic(share(&corners)));
                let place = |p: usize| x[p % 3] * y[p / 3 % 3] * z[p / 9];
                (0..27).map(place).collect()
            }
            Family::Wedge => {
                let b = [[0, 3], [1, 4], [2, 5]].map(|corners| share(&corners));
                let z = quadratic(share(&[3, 4, 5]));
                let triangle = triangle(b);
                let place = |p: usize| triangle[p % 6] * z[p / 6];
                (0..18).map(place).collect()
            }
            Family::Pyramid => pyramid(
                share(&[1, 2]) - share(&[0, 3]),
                share(&[2, 3]) - share(&[0, 1]),
                share(&[4]),
            ),
        }
    }
}

/// 1 at 0, at 1/2 and at 1, and 0 at the other two.
fn quadratic(x: f64) -> [f64; 3] {
    [
        (1.0 - x) * (1.0 - 2.0 * x),
        4.0 * x * (1.0 - x),
        x * (2.0 * x - 1.0),
    ]
}

/// The six functions of a triangle at barycentric coordinates.
fn triangle(b: [f64; 3]) -> [f64; 6] {
    let [c0, c1, c2] = b.map(|b| b * (2.0 * b - 1.0));
    let [e0, e1, e2] = TRIANGLE_EDGES.map(|[i, j]| 4.0 * b[i] * b[j]);
    [c0, c1, c2, e0, e1, e2]
}

/// The thirteen functions of a pyramid over the square [−1, 1]², with its top at z = 1 (Bedrosian).
fn pyramid(x: f64, y: f64, z: f64) -> Vec<f64> {
    if z == 1.0 {
        return (0..13)
            .map(|node| if node == 4 { 1.0 } else { 0.0 })
            .collect();
    }
    let down = 1.0 - z;
    let corner = |sx: f64, sy: f64| {
        let inner = (1.0 + sx * x) * (1.0 + sy * y) - z + sx * sy * x * y * z / down;
        0.25 * (sx * x + sy * y - 1.0) * inner
    };
    let [left, right, front, back] = [down - x, down + x, down - y, down + y];
    vec![
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
        z * (2.0 * z - 1.0),
        0.5 * left * right * front / down,
        0.5 * front * back * right / down,
        0.5 * left * right * back / down,
        0.5 * front * back * left / down,
        z * left * front / down,
        z * right * front / down,
        z * right * back / down,
        z * left * back / down,
    ]
}

/// The node at `place` of a hexahedron's full set, in a cell of 20, 24 or 27 nodes.
fn hexahedron_node(place: usize, nodes: usize) -> Vec<(usize, f64)> {
    let node = HEXAHEDRON[place];
    if node < nodes {
        return vec![(node, 1.0)];
    }
    let at = |p: [usize; 3]| p[0] + 3 * p[1] + 9 * p[2];
    let digits = [place % 3, place / 3 % 3, place / 9];
    let free: Vec<usize> = (0..3).filter(|&axis| digits[axis] == 1).collect();
    if free.len() == 2 {
        // In a face: minus a quarter of its corners, half of its edges.
        let mut sum = Vec::new();
        for [a, b] in [
            [0, 0],
            [0, 1],
            [0, 2],
            [1, 0],
            [1, 2],
            [2, 0],
            [2, 1],
            [2, 2],
        ] {
            let mut p = digits;
            (p[free[0]], p[free[1]]) = (a, b);
            let weight = if a == 1 || b == 1 { 0.5 } else { -0.25 };
            sum.push((HEXAHEDRON[at(p)], weight));
        }
        return sum;
    }
    match nodes {
        // As VTK has it: from the layer half way up alone.
        24 => {
            let edges = (16..20).map(|node| (node, -0.25));
            edges.chain((20..24).map(|node| (node, 0.5))).collect()
        }
        // In the middle: minus a quarter of the corners, a quarter of the edges.
        _ => {
            let corners = (0..8).map(|node| (node, -0.25));
            corners.chain((8..20).map(|node| (node, 0.25))).collect()
        }
    }
}

/// The node at `place` of a wedge's full set, in a cell of 12, 15 or 18 nodes.
fn wedge_node(place: usize, nodes: usize) -> Vec<(usize, f64)> {
    let (node, layer) = (place % 6, place / 6);
    match nodes {
        // Linear from the lower to the upper triangle.
        12 if layer == 1 => vec![(WEDGE[node], 0.5), (WEDGE[node + 12], 0.5)],
        15 if layer == 1 && node >= 3 => {
            let [i, j] = TRIANGLE_EDGES[node - 3];
            let corners = [i, j, i + 12, j + 12].map(|p| (WEDGE[p], -0.25));
            let edges = [node, node + 12, i + 6, j + 6].map(|p| (WEDGE[p], 0.5));
            [corners, edges].concat()
        }
        _ => vec![(WEDGE[place], 1.0)],
    }
}
