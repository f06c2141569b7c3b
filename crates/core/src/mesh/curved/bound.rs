//! How far straight parts are from a curved cell at most.
//!
//! On a straight cell with corners vᵢ a function f is replaced by its interpolant I. At
//! x = Σ λᵢ vᵢ Taylor's formula gives |I f − f| ≤ ½ Σ λᵢ sup |D²f (vᵢ − x, vᵢ − x)|; for a constant
//! D²f, I f − f = ½ Σ_{i<j} λᵢ λⱼ D²f (vᵢ − vⱼ, vᵢ − vⱼ), and Σ_{i<j} λᵢ λⱼ ≤ 3/8 for four corners, 1/3 for
//! three and 1/4 for two. Parts are n times smaller, so everything is in units of 1/n². Derivatives are bounded by their
//! coefficients in Bernstein's form (`net`), in the whole cell.
//!
//! - *Tetrahedra*: parts' edges are those of the cell and the line through the middle of an octahedron. M is the
//!   greatest second derivative along these. Where D²f is constant (order 2), 3/16 M. Else vᵢ − x has barycentric
//!   coordinates c with D² (c, c) = −Σ_{k<l} cₖ cₗ D² (kl), by edges kl, and
//!   Σ λᵢ Σ |cₖ cₗ| = 3/2 − 7/2 Σ λ² + 2 Σ λ³ is greatest in the middle, 3/4, so that 3/8 M are enough. (At a maximum
//!   two coordinates that are not 0 are equal or have the sum 7/6, which is too much.)
//! - *Hexahedra*: with second derivatives M along the axes. Within a part λ has a variance of at most 1/4 along each
//!   axis, so that |I f − f| ≤ ⅛ (M_xx + M_yy + M_zz + 2 (M_xy + M_yz + M_xz)), whichever way a part is cut.
//! - *Wedges*: so along the axis, ⅛ M_zz. In the triangle, as for tetrahedra, the sum is 5/9 in the middle, so that
//!   5/18 of the greatest second derivative along edges are enough. For the mixed derivative K of an
//!   edge and the axis ½ K, as a corner is off the mean by at most one edge and, on average, half
//!   of the axis.
//! - *Pyramids*: rational. Three times the distance of the nodes in the middle of edges from straight ones,
//!   or that of the base's middle, is an estimate; it held for all random ones that were tried.
//!
//! Bézier cells with weights have f = g/w + o, with the polynomials w, the weights, of least coefficient m, and g, the weighted
//! distances from a point o among the coefficients of f, of which none is farther than R. As g = (f − o) w,
//!
//!   f_a w = g_a − (f − o) w_a,   f_ab w = g_ab − f_a w_b − f_b w_a − (f − o) w_ab,
//!
//! so that |f_a| ≤ (|g_a| + R |w_a|) / m and |f_ab| ≤ (|g_ab| + |f_a| |w_b| + |f_b| |w_a| + R |w_ab|) / m.

use glam::DVec3;

use super::form::Basis;
use super::net::{Net, greatest};
use super::shapes::{Curved, Family, PYRAMID_EDGES, TETRAHEDRON_EDGES, TRIANGLE_EDGES};
use crate::Bounds;

impl Curved {
    /// n² times what straight parts are off by, for a function with these values at the cell's
    /// nodes; for a scalar only x counts. NaN where a value is.
    ///
    /// `weights` are those of a rational cell's nodes.
    pub(super) fn bend(&self, values: &[DVec3], weights: Option<&[f64]>) -> f64 {
        if self.is_pyramid() {
            return pyramid(values);
        }
        let full = self.fill(values);
        // Less is lost to rounding near the origin, and rational functions are bounded by their distance from it.
        let box_of = Bounds::of(full.iter().copied().filter(|value| value.is_finite()));
        let origin = 0.5 * (box_of.min + box_of.max);
        let near = full.into_iter().map(|value| value - origin);
        let function = match (self.basis, weights) {
            (Basis::Lagrange, _) => {
                Function::Polynomial(Net::of_values(&self.factors, near.collect()))
            }
            (Basis::Bernstein, None) => {
                Function::Polynomial(Net::new(&self.factors, near.collect()))
            }
            (Basis::Bernstein, Some(weights)) => self.rational(near.collect(), weights),
        };
        match self.family {
            Family::Tetrahedron => tetrahedron(&function, self.order),
            Family::Wedge => wedge(&function),
            _ => hexahedron(&function),
        }
    }

    fn rational(&self, coefficients: Vec<DVec3>, weights: &[f64]) -> Function<'_> {
        let weights = weights.iter().map(|weight| DVec3::X * *weight);
        let weights = self.fill(&weights.collect::<Vec<_>>());
        if weights.iter().all(|weight| weight.x == weights[0].x) {
            return Function::Polynomial(Net::new(&self.factors, coefficients));
        }
        let weighted = coefficients.iter().zip(&weights).map(|(c, w)| *c * w.x);
        Function::Rational {
            weighted: Net::new(&self.factors, weighted.collect()),
            radius: greatest(coefficients),
            least: weights.iter().map(|w| w.x).fold(f64::INFINITY, f64::min),
            weights: Net::new(&self.factors, weights),
        }
    }
}

/// Barycentric coordinates of a direction, of a factor by its number.
type Direction = (usize, [f64; 4]);

enum Function<'a> {
    Polynomial(Net<'a>),
    /// As above: g, w, R and m.
    Rational {
        weighted: Net<'a>,
        weights: Net<'a>,
        radius: f64,
        least: f64,
    },
}

impl Function<'_> {
    /// A bound of the second derivative along two directions.
    fn second(&self, a: Direction, b: Direction) -> f64 {
        let derivative = |net: &Net, (number, direction): Direction| {
            net.derivative(number, direction).greatest()
        };
        let second = |net: &Net| derivative(&net.derivative(a.0, a.1), b);
        match self {
            Function::Polynomial(net) => second(net),
            Function::Rational {
                weighted,
                weights,
                radius,
                least,
            } => {
                let [w_a, w_b] = [a, b].map(|d| derivative(weights, d));
                let first =
                    |d: Direction, w_d: f64| (derivative(weighted, d) + radius * w_d) / least;
                let (f_a, f_b) = (first(a, w_a), first(b, w_b));
                (second(weighted) + f_a * w_b + f_b * w_a + radius * second(weights)) / least
            }
        }
    }
}

/// The greatest number; NaN if one is.
fn most(numbers: impl IntoIterator<Item = f64>) -> f64 {
    greatest(numbers.into_iter().map(|x| DVec3::X * x))
}

/// From one corner of a factor to another.
fn edge([from, to]: [usize; 2]) -> [f64; 4] {
    let mut direction = [0.0; 4];
    (direction[from], direction[to]) = (-1.0, 1.0);
    direction
}

fn tetrahedron(function: &Function, order: usize) -> f64 {
    let edges = TETRAHEDRON_EDGES.map(edge);
    // From the middle of edge 01 to that of 23, twice.
    let through = [-1.0, -1.0, 1.0, 1.0];
    let along = |direction| function.second((0, direction), (0, direction));
    let share = match (function, order) {
        (Function::Polynomial(_), ..=2) => 3.0 / 16.0,
        _ => 3.0 / 8.0,
    };
    share * most(edges.into_iter().chain([through]).map(along))
}

fn hexahedron(function: &Function) -> f64 {
    let axis = |number: usize| (number, edge([0, 1]));
    let mut sum = 0.0;
    for a in 0..3 {
        sum += function.second(axis(a), axis(a));
        for b in a + 1..3 {
            sum += 2.0 * function.second(axis(a), axis(b));
        }
    }
    sum / 8.0
}

fn wedge(function: &Function) -> f64 {
    let axis = (1, edge([0, 1]));
    let edges = || TRIANGLE_EDGES.map(|ends| (0, edge(ends))).into_iter();
    let along_z = function.second(axis, axis);
    let along_edges = most(edges().map(|edge| function.second(edge, edge)));
    let mixed = most(edges().map(|edge| function.second(edge, axis)));
    along_edges * 5.0 / 18.0 + along_z / 8.0 + mixed / 2.0
}

fn pyramid(f: &[DVec3]) -> f64 {
    let off = |(node, [i, j]): (usize, [usize; 2])| f[node] - 0.5 * (f[i] + f[j]);
    let corners = f[0] + f[1] + f[2] + f[3];
    let middle = 0.5 * (f[5] + f[6] + f[7] + f[8]) - 0.25 * corners;
    let diagonals = [[0, 2], [1, 3]].map(|[i, j]| middle - 0.5 * (f[i] + f[j]));
    3.0 * greatest((5..).zip(PYRAMID_EDGES).map(off).chain(diagonals))
}
