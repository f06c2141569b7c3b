//! Cells whose quadrilaterals are not planar.
//!
//! Such a face is a curved surface; cutting it along a diagonal makes two triangles that
//! enclose a thin tetrahedron with the two of the other diagonal.

use glam::DVec3;
use rayon::prelude::*;

use super::Cells;
use super::cell_type::Kind;
use super::split::corners;

/// Faces flatter than this are not counted: a hundredth of a diagonal is hardly seen, and
/// nearly all curvilinear grids have more.
pub(super) const NOTICED: f64 = 0.01;

/// How many checked cells have a face that is warped by more than [`NOTICED`], and the most
/// that any is.
pub(super) fn warped_cells(points: &[DVec3], cells: &Cells) -> (usize, f64) {
    let warp_of = |cell: usize| {
        let Some(shape) = Kind::of(cells.types[cell]).shape() else {
            return 0.0;
        };
        let quads = shape.faces.iter().filter(|face| face.len() == 4);
        if quads.clone().next().is_none() {
            return 0.0;
        }
        let corners = corners(cells, cell, shape);
        let warps = quads.map(|face| {
            let at = |i: usize| points[corners[face[i]] as usize];
            warp([at(0), at(1), at(2), at(3)])
        });
        warps.fold(0.0, f64::max)
    };
    (0..cells.types.len())
        .into_par_iter()
        .with_min_len(4096)
        .map(warp_of)
        .map(|warp| (usize::from(warp > NOTICED), warp))
        .reduce(|| (0, 0.0), |a, b| (a.0 + b.0, a.1.max(b.1)))
}

/// The distance between the lines of a quadrilateral's diagonals, as a part of the longer.
///
/// With diagonals u and v and the vector w between their first ends, it is
/// |w · (u × v)| / |u × v|: 0 for a planar face. 0 as well where they are parallel, as in
/// collapsed faces.
fn warp([a, b, c, d]: [DVec3; 4]) -> f64 {
    let (u, v) = (c - a, d - b);
    let longest = u.length().max(v.length());
    let normal = (u / longest).cross(v / longest);
    match normal.try_normalize() {
        Some(normal) => ((b - a) / longest).dot(normal).abs(),
        None => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_that_is_lifted_warps_its_faces() {
        let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let flat = [
            at(0.0, 0.0, 0.0),
            at(2.0, 0.0, 0.0),
            at(3.0, 1.0, 0.0),
            at(0.0, 1.0, 0.0),
        ];
        assert_eq!(warp(flat), 0.0);
        // Diagonals of length √2 from (0,0,0) to (1,1,h) and from (1,0,0) to (0,1,0): they
        // cross over at (½, ½), at heights h/2 and 0. To first order in h the distance is h/2.
        let h = 1e-3;
        let lifted = [
            at(0.0, 0.0, 0.0),
            at(1.0, 0.0, 0.0),
            at(1.0, 1.0, h),
            at(0.0, 1.0, 0.0),
        ];
        assert!((warp(lifted) - h / 2.0 / 2.0_f64.sqrt()).abs() < h * h);
        // No scale, and no collapsed face, is special.
        assert_eq!(warp(lifted.map(|p| p * 2_f64.powi(200))), warp(lifted));
        assert_eq!(warp([at(0.0, 0.0, 0.0); 4]), 0.0);
        let [a, b, c, _] = lifted;
        assert_eq!(warp([a, b, c, c]), 0.0);
    }
}
