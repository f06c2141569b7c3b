//! Curved cells: which of their nodes is where, and the functions between them.
//!
//! Each kind has a *full* set of functions, products of those of lines, triangles and tetrahedra
//! (`simplex`), and a rule that makes their values of the nodes that the cell has: cells without nodes
//! in their faces or in their middle (serendipity) have functions that the full ones contain.
//!
//! Nodes are numbered as in VTK (`numbering`), whose classes `vtkQuadraticTetra`, `vtkLagrangeWedge`,
//! `vtkBezierHexahedron`, … have the same functions, except that of pyramids: those here are G. Bedrosian's
//! ("Shape functions and integration formulas for three-dimensional finite element analysis", 1992),
//! which agree with neighbors on all five faces.

use super::form::{Basis, Form};
use super::lattice::{self, Lattice};
use super::numbering;
use super::simplex::Simplex;
use crate::mesh::volume_corners;

/// The shape of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Family {
    /// One order.
    Tetrahedron,
    /// An order along each of three axes.
    Hexahedron,
    /// An order in the triangle and one along the axis.
    Wedge,
    /// Rational, with 13 nodes.
    Pyramid,
}

/// The functions of a line, a triangle or a tetrahedron, which those of a cell are products of.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    pub(super) simplex: Simplex,
    /// Functions of the order below.
    pub(super) below: Simplex,
    /// Bernstein's coefficients of values at nodes.
    pub(super) to_bernstein: Vec<Vec<f64>>,
    /// A barycentric coordinate is the sum of the weights of these corners of the cell.
    groups: &'static [&'static [usize]],
}

/// A kind of curved cell.
#[derive(Clone, Debug)]
pub(super) struct Curved {
    pub(super) family: Family,
    pub(super) basis: Basis,
    /// The first runs fastest in the full set; none for pyramids.
    pub(super) factors: Vec<Factor>,
    /// Each value of the full set as a sum of the cell's own nodes times weights.
    full: Vec<Vec<(usize, f64)>>,
    /// How many nodes the cell has.
    pub(super) nodes: usize,
    /// The greatest order of any factor.
    pub(super) order: usize,
}

/// Edges of a tetrahedron.
pub(super) const TETRAHEDRON_EDGES: [[usize; 2]; 6] =
    [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// Edges of a triangle.
pub(super) const TRIANGLE_EDGES: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

/// Edges of a pyramid in the order of its nodes from 5 on.
pub(super) const PYRAMID_EDGES: [[usize; 2]; 8] = [
    [0, 1],
    [1, 2],
    [2, 3],
    [3, 0],
    [0, 4],
    [1, 4],
    [2, 4],
    [3, 4],
];

impl Family {
    /// The corners of the cell whose weights are each barycentric coordinate, for each factor.
    fn groups(self) -> &'static [&'static [&'static [usize]]] {
        match self {
            Family::Tetrahedron => &[&[&[0], &[1], &[2], &[3]]],
            Family::Hexahedron => &[
                &[&[0, 3, 4, 7], &[1, 2, 5, 6]],
                &[&[0, 1, 4, 5], &[2, 3, 6, 7]],
                &[&[0, 1, 2, 3], &[4, 5, 6, 7]],
            ],
            Family::Wedge => &[&[&[0, 3], &[1, 4], &[2, 5]], &[&[0, 1, 2], &[3, 4, 5]]],
            Family::Pyramid => &[],
        }
    }

    pub(super) fn corners(self) -> usize {
        volume_corners(self.straight()).expect("a volume")
    }

    /// VTK's type of the cell with straight edges.
    pub(super) fn straight(self) -> u8 {
        match self {
            Family::Tetrahedron => 10,
            Family::Hexahedron => 12,
            Family::Wedge => 13,
            Family::Pyramid => 14,
        }
    }

    /// Points and cells that a cell becomes with so many parts along each edge.
    pub(super) fn lattice(self, parts: usize) -> Lattice {
        match self {
            Family::Tetrahedron => lattice::tetrahedron(parts),
            Family::Hexahedron => lattice::hexahedron(parts),
            Family::Wedge => lattice::wedge(parts),
            Family::Pyramid => lattice::pyramid(parts),
        }
    }
}

impl Curved {
    pub(super) fn new(form: &Form) -> Curved {
        let family = form.family;
        let [p, q, r] = form.orders;
        let orders = match family {
            Family::Tetrahedron => vec![p],
            Family::Hexahedron => vec![p, q, r],
            Family::Wedge => vec![p, r],
            Family::Pyramid => vec![],
        };
        let factor = |(order, groups): (&usize, &&'static [&'static [usize]])| {
            let simplex = Simplex::new(groups.len(), *order);
            Factor {
                to_bernstein: simplex.to_bernstein(),
                below: Simplex::new(groups.len(), order - 1),
                simplex,
                groups,
            }
        };
        let factors: Vec<Factor> = orders.iter().zip(family.groups()).map(factor).collect();
        Curved {
            full: full_set(form, &factors),
            order: orders.into_iter().max().unwrap_or(2),
            family,
            basis: form.basis,
            factors,
            nodes: form.nodes,
        }
    }

    pub(super) fn is_pyramid(&self) -> bool {
        self.family == Family::Pyramid
    }

    /// The full set of `values` at the cell's nodes.
    pub(super) fn fill(&self, values: &[glam::DVec3]) -> Vec<glam::DVec3> {
        let sum = |node: &Vec<(usize, f64)>| node.iter().map(|&(i, w)| values[i] * w).sum();
        self.full.iter().map(sum).collect()
    }

    /// The functions of the full set at a point, which `scaled` gives: the sum of the weights of
    /// some corners, times an order.
    pub(super) fn functions(&self, scaled: &dyn Fn(&[usize], usize) -> f64) -> Vec<f64> {
        if self.is_pyramid() {
            let share = |corners: &[usize]| scaled(corners, 1);
            return pyramid(
                share(&[1, 2]) - share(&[0, 3]),
                share(&[2, 3]) - share(&[0, 1]),
                share(&[4]),
            );
        }
        let mut product = vec![1.0];
        for Factor {
            simplex, groups, ..
        } in &self.factors
        {
            let mut at = [0.0; 4];
            for (at, corners) in at.iter_mut().zip(*groups) {
                *at = scaled(corners, simplex.order);
            }
            let functions = match self.basis {
                Basis::Lagrange => simplex.lagrange(at),
                Basis::Bernstein => simplex.bernstein(at),
            };
            let outer = functions.iter();
            product = outer
                .flat_map(|f| product.iter().map(move |p| p * f))
                .collect();
        }
        product
    }

    /// The cell's nodes with their functions' values at a point, as [`Curved::functions`]; those that are 0 there
    /// are left out.
    pub(super) fn weights(&self, scaled: &dyn Fn(&[usize], usize) -> f64) -> Vec<(usize, f64)> {
        let mut weights = vec![0.0; self.nodes];
        for (function, nodes) in self.functions(scaled).iter().zip(&self.full) {
            for &(node, weight) in nodes {
                weights[node] += function * weight;
            }
        }
        (0..).zip(weights).filter(|(_, w)| *w != 0.0).collect()
    }

    /// Where each node is: corners with their weights, whose sum is 60³, a multiple of all products of three orders.
    pub(super) fn node_places(&self) -> Vec<Vec<(usize, u64)>> {
        let mut places = vec![Vec::new(); self.nodes];
        if self.is_pyramid() {
            (0..5).for_each(|corner| places[corner] = vec![(corner, 216_000)]);
            for (node, edge) in (5..).zip(PYRAMID_EDGES) {
                places[node] = edge.map(|corner| (corner, 108_000)).to_vec();
            }
            return places;
        }
        for (place, own) in self.full.iter().enumerate() {
            let &[(node, weight)] = &own[..] else {
                continue;
            };
            if weight != 1.0 {
                continue;
            }
            let mut corners = [216_000; 8];
            let mut rest = place;
            let mut is_corner = [false; 8];
            for factor in &self.factors {
                let count = factor.simplex.indices.len();
                let index = factor.simplex.indices[rest % count];
                rest /= count;
                for (group, part) in factor.groups.iter().zip(index) {
                    for &corner in *group {
                        is_corner[corner] = true;
                        corners[corner] =
                            corners[corner] / factor.simplex.order as u64 * part as u64;
                    }
                }
            }
            let named = (0..8).zip(corners);
            places[node] = named.filter(|&(c, w)| is_corner[c] && w > 0).collect();
        }
        places
    }
}

/// For each function of the full set, which nodes it has its value of.
fn full_set(form: &Form, factors: &[Factor]) -> Vec<Vec<(usize, f64)>> {
    let nodes = form.nodes;
    let [p, q, r] = form.orders;
    match form.family {
        Family::Pyramid => (0..nodes).map(|node| vec![(node, 1.0)]).collect(),
        Family::Tetrahedron => {
            let numbers = numbering::tetrahedron(p);
            let of = |index: &[usize; 4]| numbers.iter().position(|i| i == index);
            let indices = factors[0].simplex.indices.iter();
            indices
                .map(|index| vec![(of(index).expect("all have a number"), 1.0)])
                .collect()
        }
        Family::Hexahedron => {
            let place = |place: usize| {
                [
                    place % (p + 1),
                    place / (p + 1) % (q + 1),
                    place / (p + 1) / (q + 1),
                ]
            };
            let all = 0..(p + 1) * (q + 1) * (r + 1);
            all.map(|n| hexahedron_node(place(n), form.orders, nodes))
                .collect()
        }
        Family::Wedge => {
            let triangle = &factors[0].simplex.indices;
            let layers = (0..=r).flat_map(|k| triangle.iter().map(move |index| (*index, k)));
            layers
                .map(|(index, k)| wedge_node([index[0], index[1], index[2]], k, [p, r], nodes))
                .collect()
        }
    }
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

/// The node at a place of a hexahedron, or what stands for it in one of order 2 that has fewer.
fn hexahedron_node(at: [usize; 3], orders: [usize; 3], nodes: usize) -> Vec<(usize, f64)> {
    let node = numbering::hexahedron(at, orders);
    if node < nodes {
        return vec![(node, 1.0)];
    }
    let free: Vec<usize> = (0..3).filter(|&axis| at[axis] == 1).collect();
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
            let mut p = at;
            (p[free[0]], p[free[1]]) = (a, b);
            let weight = if a == 1 || b == 1 { 0.5 } else { -0.25 };
            sum.push((numbering::hexahedron(p, orders), weight));
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

/// The node at a place of a wedge, or what stands for it in one of order 2 with 15 nodes.
fn wedge_node(at: [usize; 3], layer: usize, orders: [usize; 2], nodes: usize) -> Vec<(usize, f64)> {
    let node = numbering::wedge(at, layer, orders);
    if node < nodes {
        return vec![(node, 1.0)];
    }
    // In a side, between two corners of the triangle.
    let free: Vec<usize> = (0..3).filter(|&corner| at[corner] == 1).collect();
    let mut sum = Vec::new();
    for k in [0, 1, 2] {
        for [a, b] in [[2, 0], [1, 1], [0, 2]] {
            let mut p = at;
            (p[free[0]], p[free[1]]) = (a, b);
            match (k == 1, a == 1) {
                (true, true) => continue,
                (false, false) => sum.push((numbering::wedge(p, k, orders), -0.25)),
                _ => sum.push((numbering::wedge(p, k, orders), 0.5)),
            }
        }
    }
    sum
}
