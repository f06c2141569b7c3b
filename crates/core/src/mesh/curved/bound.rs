//! How far straight parts are from a curved cell at most.
//!
//! On a straight cell with corners vᵢ a function f is replaced by its interpolant I. At
//! x = Σ λᵢ vᵢ Taylor's formula gives |I f − f| ≤ ½ Σ λᵢ sup |D²f (vᵢ − x, vᵢ − x)|; for a constant
//! D²f, I f − f = ½ Σ_{i<j} λᵢ λⱼ D²f (vᵢ − vⱼ, vᵢ − vⱼ), and Σ_{i<j} λᵢ λⱼ ≤ 3/8 for four corners, 1/3 for
//! three and 1/4 for two. Parts are n times smaller, so everything is in units of 1/n².
//!
//! - *Tetrahedra*: D²f is constant. Parts' edges are those of the cell and the line through the middle of
//!   an octahedron: 3/16 of the greatest second difference along these.
//! - *Hexahedra*: with f in Bernstein's form second differences of the coefficients bound the derivatives
//!   M. Within a part λ has a variance of at most 1/4 along each axis, so that
//!   |I f − f| ≤ ⅛ (M_xx + M_yy + M_zz + 2 (M_xy + M_yz + M_xz)), whichever way a part is cut.
//! - *Wedges*: so along the axis, ⅛ M_zz. In the triangle vᵢ − x has barycentric coordinates c with
//!   D² (c, c) = −Σ_{k<l} cₖ cₗ D² (kl), by edges kl; Σ λᵢ Σ |cₖ cₗ| is greatest in the middle, 5/9, so that
//!   5/18 of the greatest second difference along edges are enough. For the mixed derivative K of an
//!   edge and the axis ½ K, as a corner is off the mean by at most one edge and, on average, half
//!   of the axis.
//! - *Pyramids*: rational. Three times the distance of the nodes in the middle of edges from straight ones,
//!   or that of the base's middle, is an estimate; it held for all random ones that were tried.

use glam::DVec3;

use super::shapes::{Curved, Family, TETRAHEDRON_EDGES, TRIANGLE_EDGES};

impl Curved {
    /// n² times what straight parts are off by, for a function with these values at the cell's
    /// nodes; for a scalar only x counts. NaN where a value is.
    pub(super) fn bend(&self, values: &[DVec3]) -> f64 {
        let full = self.fill(values);
        match self.family {
            Family::Tetrahedron => tetrahedron(&full),
            Family::Hexahedron => hexahedron(&full),
            Family::Wedge => wedge(&full),
            Family::Pyramid => pyramid(&full),
        }
    }
}

/// The greatest length; NaN if one is.
fn greatest(vectors: impl IntoIterator<Item = DVec3>) -> f64 {
    let lengths = vectors.into_iter().map(DVec3::length);
    lengths.fold(0.0, |most, length| match length > most || length.is_nan() {
        true => length,
        false => most,
    })
}

fn tetrahedron(f: &[DVec3]) -> f64 {
    let along = |edge: usize| {
        let [i, j] = TETRAHEDRON_EDGES[edge];
        4.0 * (f[i] + f[j] - 2.0 * f[4 + edge])
    };
    let edges: [DVec3; 6] = std::array::from_fn(along);
    let [e01, e12, e02, e03, e13, e23] = edges;
    // From the middle of edge 01 to that of 23, twice: Σᵢⱼ −cᵢ cⱼ D²(ij) with c = (−1, −1, 1, 1).
    let through = e02 + e03 + e12 + e13 - e01 - e23;
    3.0 / 16.0 * greatest(edges.into_iter().chain([through]))
}

/// Bernstein's coefficients of the values at 0, ½ and 1.
fn bernstein([start, middle, end]: [DVec3; 3]) -> [DVec3; 3] {
    [start, 2.0 * middle - 0.5 * (start + end), end]
}

fn hexahedron(values: &[DVec3]) -> f64 {
    let mut b = values.to_vec();
    let strides = [1, 3, 9];
    let starts = |axis: usize| (0..27).filter(move |p| p / strides[axis] % 3 == 0);
    for (axis, &s) in strides.iter().enumerate() {
        for p in starts(axis) {
            [b[p], b[p + s], b[p + 2 * s]] = bernstein([b[p], b[p + s], b[p + 2 * s]]);
        }
    }
    let mut sum = 0.0;
    for (axis, &s) in strides.iter().enumerate() {
        sum += greatest(starts(axis).map(|p| 2.0 * (b[p] - 2.0 * b[p + s] + b[p + 2 * s])));
        for &t in &strides[axis + 1..] {
            let is_inner = |p: &usize| p / s % 3 < 2 && p / t % 3 < 2;
            let mixed = |p: usize| 4.0 * (b[p + s + t] - b[p + s] - b[p + t] + b[p]);
            sum += 2.0 * greatest((0..27).filter(is_inner).map(mixed));
        }
    }
    sum / 8.0
}

fn wedge(values: &[DVec3]) -> f64 {
    let mut b = values.to_vec();
    for layer in [0, 6, 12] {
        for (node, [i, j]) in (3..).zip(TRIANGLE_EDGES) {
            let line = [b[layer + i], b[layer + node], b[layer + j]];
            b[layer + node] = bernstein(line)[1];
        }
    }
    for p in 0..6 {
        [b[p], b[p + 6], b[p + 12]] = bernstein([b[p], b[p + 6], b[p + 12]]);
    }
    let along_z = greatest((0..6).map(|p| 2.0 * (b[p] - 2.0 * b[p + 6] + b[p + 12])));
    let edges = (0..3).flat_map(|edge| [0, 6, 12].map(|layer| (edge, layer)));
    let along_edges = greatest(edges.map(|(edge, layer)| {
        let [i, j] = TRIANGLE_EDGES[edge];
        2.0 * (b[layer + i] + b[layer + j] - 2.0 * b[layer + 3 + edge])
    }));
    // The coefficient of corners i and k, and the derivative along an edge by it.
    let coefficient = |i: usize, k: usize| match i == k {
        true => i,
        false => {
            3 + TRIANGLE_EDGES
                .iter()
                .position(|e| e.contains(&i) && e.contains(&k))
                .expect("an edge")
        }
    };
    let mut mixed = Vec::new();
    for [i, j] in TRIANGLE_EDGES {
        for k in 0..3 {
            let slope =
                |layer: usize| 2.0 * (b[layer + coefficient(j, k)] - b[layer + coefficient(i, k)]);
            mixed.extend([[0, 6], [6, 12]].map(|[low, high]| 2.0 * (slope(high) - slope(low))));
        }
    }
    along_edges * 5.0 / 18.0 + along_z / 8.0 + greatest(mixed) / 2.0
}

fn pyramid(f: &[DVec3]) -> f64 {
    let edges = [
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [0, 4],
        [1, 4],
        [2, 4],
        [3, 4],
    ];
    let off = |(node, [i, j]): (usize, [usize; 2])| f[node] - 0.5 * (f[i] + f[j]);
    let corners = f[0] + f[1] + f[2] + f[3];
    let middle = 0.5 * (f[5] + f[6] + f[7] + f[8]) - 0.25 * corners;
    let diagonals = [[0, 2], [1, 3]].map(|[i, j]| middle - 0.5 * (f[i] + f[j]));
    3.0 * greatest((5..).zip(edges).map(off).chain(diagonals))
}
