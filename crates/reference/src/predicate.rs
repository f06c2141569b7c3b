//! On which side of an edge a ray passes: exact, and never undecided.
//!
//! A cell's vertices are sheared along the ray into two dimensions, so that the
//! ray becomes the origin. Every cell that uses a vertex sees the same bits for
//! it, and the sign below is that of the exact determinant of those bits, so all
//! cells around an edge agree on which side the ray passes.
//!
//! For any four points in the plane and a point on none of their six lines, that
//! point lies in exactly none or two of the four triangles. Hence a ray crosses
//! none or two faces of a cell, whatever rounding did to the vertices, flat and
//! inverted cells included: nothing is lost and nothing doubled.

/// The sign of a × b for sheared vertices `a` and `b`: 1, −1, or 0 when they coincide.
///
/// A ray that meets the edge's line is taken to pass at (ε, ε²) from the origin,
/// with ε > 0 smaller than any number. That moves the ray, not the mesh, so all
/// cells see the same generic ray.
pub(crate) fn edge_sign(a: [f64; 2], b: [f64; 2]) -> i32 {
    let (p, q) = (a[0] * b[1], a[1] * b[0]);
    // Rounding is monotone: rounded products that differ are in the right order.
    if p != q {
        return sign(p, q);
    }
    match exact_order(a, b) {
        0 => {}
        order => return order,
    }
    // (a − r) × (b − r) for r = (ε, ε²) is a × b + ε (a_y − b_y) + ε² (b_x − a_x) + O(ε³).
    match sign(a[1], b[1]) {
        0 => sign(b[0], a[0]),
        order => order,
    }
}

/// a × b for sheared vertices `a` and `b`, with a relative error of at most 65 · 2⁻⁵³.
///
/// Where the products cancel, the difference of their rounded values can be all
/// noise. That of a face seen edge-on is, and weights made of noise name a point
/// of the face that is not on the ray.
#[inline]
pub(crate) fn area(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (p, q) = (a[0] * b[1], a[1] * b[0]);
    let area = p - q;
    if 64.0 * area.abs() > p.abs() + q.abs() {
        return area;
    }
    // The products' rounding errors, exact unless they underflow (Kahan).
    area + (a[0].mul_add(b[1], -p) - a[1].mul_add(b[0], -q))
}

/// The sign of a × b with products that round alike, exactly.
fn exact_order(a: [f64; 2], b: [f64; 2]) -> i32 {
    // Powers of two keep the products' rounding errors, which have half the
    // exponent of ε² of the products, above the least subnormal number.
    let (a, b) = (normalized(a), normalized(b));
    let (p, q) = (a[0] * b[1], a[1] * b[0]);
    if p != q {
        return sign(p, q);
    }
    // A product is its rounding plus an error that a fused multiply-add gives exactly.
    sign(a[0].mul_add(b[1], -p), a[1].mul_add(b[0], -q))
}

/// `v` times a power of two that brings its greater component near 1.
fn normalized(v: [f64; 2]) -> [f64; 2] {
    let size = v[0].abs().max(v[1].abs());
    if size == 0.0 {
        return v;
    }
    let scale = power_of_two(size);
    [v[0] / scale, v[1] / scale]
}

/// 1 where p > q, −1 where p < q, else 0.
fn sign(p: f64, q: f64) -> i32 {
    i32::from(p > q) - i32::from(p < q)
}

/// The greatest power of two that is at most `x`; the least normal number for anything smaller.
pub(crate) fn power_of_two(x: f64) -> f64 {
    f64::from_bits(x.max(f64::MIN_POSITIVE).to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounded_products_that_tie_are_told_apart() {
        let e = f64::EPSILON;
        // (1 + e)(1 − e) = 1 − e² rounds to 1, as 1 · 1 does.
        let (a, b) = ([1.0 + e, 1.0], [1.0, 1.0 - e]);
        assert_eq!(a[0] * b[1], a[1] * b[0]);
        assert_eq!(edge_sign(a, b), -1);
        assert_eq!(edge_sign(b, a), 1);
        // So small that the products are 0.
        let tiny = 1e-200;
        let (a, b) = (a.map(|x| x * tiny), b.map(|x| x * tiny));
        assert_eq!(edge_sign(a, b), -1);
    }

    #[test]
    fn cancelled_areas_keep_their_digits() {
        let e = f64::EPSILON;
        assert_eq!(area([1.0 + e, 1.0], [1.0, 1.0 - e]), -e * e);
        assert_eq!(area([3.0, 1.0], [1.0, 2.0]), 5.0);
    }

    #[test]
    fn collinear_vertices_follow_the_shifted_ray() {
        // The ray at the origin on the edge from (−1, 0) to (1, 0) is seen from (ε, ε²), above it.
        assert_eq!(edge_sign([-1.0, 0.0], [1.0, 0.0]), 1);
        // Beside the y axis, ε decides.
        assert_eq!(edge_sign([0.0, -1.0], [0.0, 1.0]), -1);
        assert_eq!(edge_sign([0.0, 0.0], [0.0, 0.0]), 0);
    }

    // The parity theorem with the worst of inputs: all points on a small lattice.
    #[test]
    fn a_ray_crosses_none_or_two_faces_of_any_cell() {
        let points: Vec<[f64; 2]> = (0..25)
            .map(|i| [f64::from(i % 5) - 2.0, f64::from(i / 5) - 2.0])
            .collect();
        let crossed = |a: [f64; 2], b, c| {
            let s = edge_sign(a, b);
            s != 0 && s == edge_sign(b, c) && s == edge_sign(c, a)
        };
        for &a in &points {
            for &b in &points {
                for &c in &points {
                    for &d in &points {
                        let faces = [
                            crossed(a, b, c),
                            crossed(a, b, d),
                            crossed(a, c, d),
                            crossed(b, c, d),
                        ];
                        let count = faces.iter().filter(|f| **f).count();
                        assert!(count == 0 || count == 2, "{a:?} {b:?} {c:?} {d:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn powers_of_two() {
        assert_eq!(power_of_two(5.0), 4.0);
        assert_eq!(power_of_two(4.0), 4.0);
        assert_eq!(power_of_two(0.3), 0.25);
        assert_eq!(power_of_two(0.0), f64::MIN_POSITIVE);
    }
}
