//! One cell against rays: which faces a ray crosses, where, and at which scalars.

use tetrascope_core::glam::{DVec2, DVec3};

use crate::predicate::{area, edge_sign};

/// A cell in a [`RayFrame`](crate::frame::RayFrame), vertices by increasing index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    x: [f64; 4],
    y: [f64; 4],
    z: [f64; 4],
    /// The factor of a ray's position before it is subtracted: z, or 1
    /// in an orthographic view.
    shear: [f64; 4],
    scalars: [f64; 4],
    /// A bound on the length of edges.
    diameter: f64,
}

/// The part that a ray and a cell have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    /// Whether it has no length, yet the scalar changes on it.
    pub(crate) is_layer: bool,
    /// Where it enters and leaves; z_in ≤ z_out.
    pub(crate) z_in: f64,
    pub(crate) z_out: f64,
    /// The scalars there.
    pub(crate) scalar_in: f64,
    pub(crate) scalar_out: f64,
    /// The sum over both faces of the diameter over twice the area that a face
    /// shows to the ray: how strongly its barycentric coordinates react to a
    /// shift of the ray.
    pub(crate) sensitivity: f64,
}

impl Crossing {
    /// The scalar at `z` between both ends: a convex combination again, which rounding
    /// must not take out of their range. So a constant stays one, on the step of a
    /// transfer function too.
    pub(crate) fn scalar_at(&self, z: f64) -> f64 {
        let (before, after) = (z - self.z_in, self.z_out - z);
        let mean = (after * self.scalar_in + before * self.scalar_out) / (before + after);
        let low = least(self.scalar_in, self.scalar_out);
        let high = greatest(self.scalar_in, self.scalar_out);
        // As in `meet_at`, a NaN stays.
        let mean = if mean < low { low } else { mean };
        if mean > high { high } else { mean }
    }
}

/// The edges (i, j) of vertices, i < j, in the order of the arrays below.
const EDGES: [(usize, usize); 6] = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];

/// A face (i, j, k), i < j < k, by its vertices and its edges (i, j), (i, k), (j, k).
const FACES: [([usize; 3], [usize; 3]); 4] = [
    ([0, 1, 2], [0, 1, 3]),
    ([0, 1, 3], [0, 2, 4]),
    ([0, 2, 3], [1, 2, 5]),
    ([1, 2, 3], [3, 4, 5]),
];

/// The greatest difference that rounding makes of two scalars at one point, in parts of the cell's range: a ray through
/// an edge or a vertex meets two faces there.
const GRAZED: f64 = 1e-9;

impl Cell {
    pub(crate) fn new(vertices: [DVec3; 4], scalars: [f64; 4], perspective: bool) -> Cell {
        let z = vertices.map(|v| v.z);
        let min = vertices.iter().fold(DVec3::INFINITY, |m, v| m.min(*v));
        let max = vertices.iter().fold(DVec3::NEG_INFINITY, |m, v| m.max(*v));
        Cell {
            x: vertices.map(|v| v.x),
            y: vertices.map(|v| v.y),
            z,
            shear: if perspective { z } else { [1.0; 4] },
            scalars,
            diameter: (max - min).length(),
        }
    }

    /// The least and greatest z.
    pub(crate) fn z_range(&self) -> (f64, f64) {
        range(&self.z)
    }

    /// The least and greatest scalar, of those that are numbers.
    pub(crate) fn scalar_range(&self) -> (f64, f64) {
        range(&self.scalars)
    }

    /// A box in the image plane around all rays that meet the cell before the
    /// eye, up to a relative rounding of 4ε; `None` if it reaches to infinity.
    pub(crate) fn outline(&self) -> Option<(DVec2, DVec2)> {
        if range(&self.shear).0 <= 0.0 {
            return None; // some vertex is behind the eye
        }
        let at = |i: usize| DVec2::new(self.x[i], self.y[i]) / self.shear[i];
        let [a, b, c, d] = [at(0), at(1), at(2), at(3)];
        let (min, max) = (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)));
        (min.is_finite() && max.is_finite()).then_some((min, max))
    }

    /// The greatest rate of change of the scalar, in scalars per unit of the
    /// frame; infinite or NaN in a flat cell whose scalars differ.
    pub(crate) fn gradient(&self) -> f64 {
        let at = |i: usize| DVec3::new(self.x[i], self.y[i], self.z[i]);
        let [a, b, c] = [1, 2, 3].map(|i| at(i) - at(0));
        let [p, q, r] = [1, 2, 3].map(|i| self.scalars[i] - self.scalars[0]);
        let sum = p * b.cross(c) + q * c.cross(a) + r * a.cross(b);
        if sum == DVec3::ZERO {
            return 0.0;
        }
        (sum / a.dot(b.cross(c))).length()
    }

    /// The vertices' distances above the rays at `y`.
    #[inline]
    pub(crate) fn above(&self, y: f64) -> [f64; 4] {
        std::array::from_fn(|i| self.y[i] - y * self.shear[i])
    }

    /// Calls `found` with the lane and the crossing of each of `N` rays at `xs`
    /// that meets the cell's whole line; `above` is for their common y.
    #[inline]
    pub(crate) fn cross<const N: usize>(
        &self,
        above: &[f64; 4],
        xs: &[f64; N],
        mut found: impl FnMut(usize, Crossing),
    ) {
        // Sheared vertices, then twice the signed areas that edges span with the
        // ray. Plain loops over lanes: the compiler turns them into vectors.
        let mut beside = [[0.0; N]; 4];
        for (i, beside) in beside.iter_mut().enumerate() {
            for (beside, x) in beside.iter_mut().zip(xs) {
                *beside = self.x[i] - x * self.shear[i];
            }
        }
        let mut areas = [[0.0; N]; 6];
        for (area, (i, j)) in areas.iter_mut().zip(EDGES) {
            for lane in 0..N {
                area[lane] = beside[i][lane] * above[j] - above[i] * beside[j][lane];
            }
        }
        // In the top bit, whether a ray crosses a face or needs a closer look.
        let mut hits = [0u64; N];
        for (_, [ij, ik, jk]) in FACES {
            for lane in 0..N {
                hits[lane] |= crossed(areas[ij][lane], areas[ik][lane], areas[jk][lane]);
            }
        }
        for area in &areas {
            for lane in 0..N {
                hits[lane] |= u64::from(area[lane] == 0.0) << 63;
            }
        }
        for lane in 0..N {
            if hits[lane] >> 63 == 0 {
                continue;
            }
            let mut weights: [f64; 6] = [0.0; 6];
            let mut tie = false;
            for (edge, (i, j)) in EDGES.into_iter().enumerate() {
                weights[edge] = area([beside[i][lane], above[i]], [beside[j][lane], above[j]]);
                tie |= areas[edge][lane] == 0.0;
            }
            let faces = if tie {
                let at = |i: usize| [beside[i][lane], above[i]];
                faces_at(EDGES.map(|(i, j)| edge_sign(at(i), at(j))))
            } else {
                let mut faces = 0;
                for (face, (_, [ij, ik, jk])) in FACES.into_iter().enumerate() {
                    let bit = crossed(areas[ij][lane], areas[ik][lane], areas[jk][lane]) >> 63;
                    faces |= (bit as u32) << face;
                }
                faces
            };
            if faces != 0 {
                found(lane, self.crossing(faces, &weights));
            }
        }
    }

    /// Where a ray that crosses `faces`, a bit for each, meets them.
    #[inline]
    fn crossing(&self, faces: u32, areas: &[f64; 6]) -> Crossing {
        // Exactly two are crossed: see `predicate`.
        let (first, second) = (faces.trailing_zeros(), 31 - faces.leading_zeros());
        let (a, b) = (self.meet(first, areas), self.meet(second, areas));
        let (entry, exit) = if a.0 <= b.0 { (a, b) } else { (b, a) };
        let is_layer = entry.0 == exit.0 && {
            let (low, high) = self.scalar_range();
            (exit.1 - entry.1).abs() > GRAZED * (high - low)
        };
        Crossing {
            is_layer,
            z_in: entry.0,
            z_out: exit.0,
            scalar_in: entry.1,
            scalar_out: exit.1,
            sensitivity: self.diameter * (a.2 + b.2),
        }
    }

    /// The ray's place on a face, for [`Cell::meet_at`].
    #[inline(always)]
    fn meet(&self, face: u32, areas: &[f64; 6]) -> (f64, f64, f64) {
        // Spelled out, so that the indices are constants.
        match face {
            0 => self.meet_at(0, areas),
            1 => self.meet_at(1, areas),
            2 => self.meet_at(2, areas),
            _ => self.meet_at(3, areas),
        }
    }

    /// z, scalar and one over the shown area where a ray meets a face.
    ///
    /// Convex weights: neither can leave the range of the face's vertices, however
    /// thin the cell. Both cells of a face do the same operations on the same bits.
    #[inline(always)]
    fn meet_at(&self, face: usize, areas: &[f64; 6]) -> (f64, f64, f64) {
        let ([i, j, k], [ij, ik, jk]) = FACES[face];
        let (wi, wj, wk) = (areas[jk].abs(), areas[ik].abs(), areas[ij].abs());
        let sum = wi + wj + wk;
        if sum == 0.0 {
            // Edge-on to the last bit: any point of it is as good.
            return (self.z[i], self.scalars[i], f64::INFINITY);
        }
        let inverse = 1.0 / sum;
        let mean = |values: &[f64; 4]| {
            let (vi, vj, vk) = (values[i], values[j], values[k]);
            let mean = (wi * vi + wj * vj + wk * vk) * inverse;
            // Rounding alone could take it out, and a constant must stay one. A NaN
            // fails both comparisons and stays.
            let low = least(vi, least(vj, vk));
            let high = greatest(vi, greatest(vj, vk));
            let mean = if mean < low { low } else { mean };
            if mean > high { high } else { mean }
        };
        (mean(&self.z), mean(&self.scalars), inverse)
    }
}

/// The least and greatest of four numbers; a NaN is passed over.
fn range(values: &[f64; 4]) -> (f64, f64) {
    let [a, b, c, d] = *values;
    (a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
}

/// The lesser of two; `f64::min` spends instructions on NaN.
#[inline]
fn least(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two; see [`least`].
#[inline]
fn greatest(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// In the top bit, whether a ray crosses the face (i, j, k), given areas that are not 0:
/// those of (i, j), (j, k) and (k, i) have one sign.
///
/// The difference of two rounded products has the sign of their comparison.
#[inline(always)]
fn crossed(ij: f64, ik: f64, jk: f64) -> u64 {
    let [ij, ik, jk] = [ij.to_bits(), ik.to_bits(), jk.to_bits()];
    !(ij ^ jk) & (ij ^ ik)
}

/// The faces that a ray crosses, a bit for each, given the signs of the edges.
fn faces_at(signs: [i32; 6]) -> u32 {
    let crossed = FACES.iter().map(|(_, [ij, ik, jk])| {
        signs[*ij] != 0 && signs[*ij] == signs[*jk] && signs[*ij] == -signs[*ik]
    });
    crossed.enumerate().fold(0, |faces, (face, crossed)| {
        faces | u32::from(crossed) << face
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Cell {
        let vertices = [
            DVec3::new(0.0, 0.0, 1.0),
            DVec3::new(1.0, 0.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
            DVec3::new(0.0, 0.0, 2.0),
        ];
        Cell::new(vertices, [1.0, 2.0, 3.0, 5.0], false)
    }

    fn crossings<const N: usize>(cell: &Cell, y: f64, xs: [f64; N]) -> Vec<(usize, Crossing)> {
        let mut all = Vec::new();
        cell.cross(&cell.above(y), &xs, |lane, crossing| {
            all.push((lane, crossing))
        });
        all
    }

    // In the reference cell the ray at (x, y) has the length 1 − x − y, and the
    // scalar 1 + x + 2 y + 4 (z − 1).
    #[test]
    fn lengths_and_scalars_in_the_reference_cell() {
        let xs = [0.125, 0.5, 0.7, -0.1];
        let found = crossings(&unit(), 0.25, xs);
        assert_eq!(found.len(), 3, "{found:?}");
        for (lane, crossing) in found {
            let (x, y) = (xs[lane], 0.25);
            let length = 1.0 - x - y;
            assert!((crossing.z_in - 1.0).abs() < 1e-15);
            assert!((crossing.z_out - crossing.z_in - length).abs() < 1e-15);
            assert!((crossing.scalar_in - (1.0 + x + 2.0 * y)).abs() < 1e-15);
            assert!((crossing.scalar_out - crossing.scalar_in - 4.0 * length).abs() < 1e-14);
        }
    }

    #[test]
    fn lanes_do_not_matter() {
        let xs: [f64; 16] = std::array::from_fn(|i| i as f64 / 16.0);
        let together = crossings(&unit(), 0.25, xs);
        let alone = xs.iter().enumerate().flat_map(|(lane, &x)| {
            let found = crossings(&unit(), 0.25, [x]);
            found.into_iter().map(move |(_, crossing)| (lane, crossing))
        });
        assert_eq!(together, alone.collect::<Vec<_>>());
    }

    #[test]
    fn a_face_seen_edge_on_and_a_flat_cell_do_no_harm() {
        // x = 0 lies in a face of the cell, which the shifted ray passes inside.
        let found = crossings(&unit(), 0.25, [0.0]);
        assert_eq!(found.len(), 1);
        assert!((found[0].1.z_out - 1.75).abs() < 1e-15);
        let mut flat = unit();
        flat.z = [1.0; 4];
        let flat = Cell::new(
            std::array::from_fn(|i| DVec3::new(flat.x[i], flat.y[i], 1.0)),
            flat.scalars,
            false,
        );
        for (_, crossing) in crossings(&flat, 0.25, [0.0, 0.1, 0.2]) {
            assert_eq!(crossing.z_in, crossing.z_out);
        }
    }

    #[test]
    fn a_scalar_that_is_no_number_spoils_every_crossing() {
        let mut cell = unit();
        for vertex in 0..4 {
            cell.scalars = [1.0; 4];
            cell.scalars[vertex] = f64::NAN;
            let (_, crossing) = crossings(&cell, 0.25, [0.25])[0];
            assert!(crossing.scalar_in.is_nan() || crossing.scalar_out.is_nan());
        }
    }
}
