//! On which side of the ray an edge passes, decided without any tolerance.
//!
//! Vertices are sheared so that the ray is the origin of the plane. The rounded point *is* the
//! vertex for this ray: for any four points of the plane and an origin on none of their six
//! lines, the origin lies in exactly 0 or 2 of the four triangles. So cells that share a face agree
//! about it, whatever their shapes, and a ray that comes into a cell leaves it.

use fearless_simd::prelude::*;

use crate::simd::{MOST_LANES, PerLane, each, store};

/// A vertex as each lane's ray sees it: across the ray, along it, and its scalar.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner<S: Simd> {
    pub(super) x: S::f32s,
    pub(super) y: S::f32s,
    pub(super) z: S::f32s,
    pub(super) scalar: S::f32s,
}

/// How each lane's ray shears.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear<S: Simd> {
    pub(super) through: [S::f32s; 2],
    pub(super) slope: [S::f32s; 2],
}

impl<S: Simd> Shear<S> {
    /// The only code that shears a vertex: the same vertex has the same bits wherever a ray meets
    /// it.
    #[inline(always)]
    pub(super) fn corner(&self, [x, y, z, scalar]: [S::f32s; 4]) -> Corner<S> {
        Corner {
            x: self.slope[0].mul_add(z, x - self.through[0]),
            y: self.slope[1].mul_add(z, y - self.through[1]),
            z,
            scalar,
        }
    }
}

impl<S: Simd> Corner<S> {
    /// This where `mask` is, else `other`.
    #[inline(always)]
    pub(super) fn or(self, mask: S::mask32s, other: Corner<S>) -> Corner<S> {
        Corner {
            x: mask.select(self.x, other.x),
            y: mask.select(self.y, other.y),
            z: mask.select(self.z, other.z),
            scalar: mask.select(self.scalar, other.scalar),
        }
    }
}

/// Twice the area that the origin, a and b span, with its sign, and whether it is positive: on
/// which side the edge from a to b passes.
///
/// Two rounded products are compared. Rounding is monotone: where they differ their order is right.
/// Where they are equal, as `tied` says, [`Side::untied`] decides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<S: Simd> {
    pub(super) area: S::f32s,
    pub(super) is_positive: S::mask32s,
    pub(super) tied: S::mask32s,
}

impl<S: Simd> Side<S> {
    #[inline(always)]
    pub(super) fn of(a: &Corner<S>, b: &Corner<S>) -> Side<S> {
        let (left, right) = (a.x * b.y, a.y * b.x);
        Side {
            area: left - right,
            is_positive: left.simd_gt(right),
            tied: left.simd_eq(right),
        }
    }

    /// The same with ties decided.
    #[inline(always)]
    pub(super) fn untied(self, simd: S, a: &Corner<S>, b: &Corner<S>) -> Side<S> {
        if !self.tied.any_true() {
            return self;
        }
        let mut values = [[0.0; MOST_LANES]; 4];
        for (values, vector) in values.iter_mut().zip([a.x, a.y, b.x, b.y]) {
            store::<S>(vector, values);
        }
        let decided = break_ties(
            &values,
            self.is_positive.to_bitmask(),
            self.tied.to_bitmask(),
        );
        Side {
            is_positive: S::mask32s::from_bitmask(simd, decided),
            ..self
        }
    }
}

/// Decides for the lanes in `tied`: by the exact products, and where those are equal by moving the
/// ray by (e, e²), e → 0: the ray, not the mesh, so every face sees the same ray.
#[cold]
#[inline(never)]
fn break_ties([ax, ay, bx, by]: &[PerLane<f32>; 4], positive: u64, tied: u64) -> u64 {
    let mut decided = positive;
    for lane in (0..MOST_LANES).filter(|lane| tied >> lane & 1 == 1) {
        if exactly_positive([ax[lane], ay[lane]], [bx[lane], by[lane]]) {
            decided |= 1 << lane;
        }
    }
    decided
}

/// Products of f32 are exact in f64.
fn exactly_positive([ax, ay]: [f32; 2], [bx, by]: [f32; 2]) -> bool {
    let left = f64::from(ax) * f64::from(by);
    let right = f64::from(ay) * f64::from(bx);
    if left != right {
        return left > right;
    }
    if ay != by { ay > by } else { bx > ax }
}

/// The shares of b and c in the point at which the ray crosses face abc, neither negative, given
/// twice the areas of bc, ca and ab with the ray.
///
/// Products of f32 err by 2⁻²⁴ of themselves, so for a sliver, l long and h wide as the ray sees it,
/// they name a point up to e l beside the ray, e = 2⁻²⁴ l / h: much farther than vertices are rounded.
/// The rest of the equation is solved once more. That leaves some 2⁻²⁴ l, as if the ray had moved,
/// and e² l.
#[inline(always)]
pub(super) fn shares<S: Simd>(
    simd: S,
    [a, b, c]: [&Corner<S>; 3],
    [of_a, of_b, of_c]: [S::f32s; 3],
) -> [S::f32s; 2] {
    let zero = S::f32s::splat(simd, 0.0);
    let area = of_a + of_b + of_c;
    let is_edge_on = area.abs().simd_lt(S::f32s::splat(simd, 1e-37));
    // Seen edge on, any of its points will do: the first.
    let scale = is_edge_on.select(zero, S::f32s::splat(simd, 1.0) / area);
    let (b_x, b_y) = (b.x - a.x, b.y - a.y);
    let (c_x, c_y) = (c.x - a.x, c.y - a.y);
    let (rough_b, rough_c) = (of_b * scale, of_c * scale);
    let left_x = rough_c.mul_add(c_x, rough_b.mul_add(b_x, a.x)) * scale;
    let left_y = rough_c.mul_add(c_y, rough_b.mul_add(b_y, a.y)) * scale;
    let share_b = rough_b + left_y.mul_sub(c_x, left_x * c_y);
    let share_c = rough_c + left_x.mul_sub(b_y, left_y * b_x);
    each!([share_b, share_c], share => share.max(zero))
}

/// A mean of a face's corners, as a's and shares of b's and c's differences from it, so that what
/// rounding leaves is relative to the face's extent, and a constant stays one.
#[inline(always)]
pub(super) fn mean<S: Simd>([share_b, share_c]: [S::f32s; 2], [a, b, c]: [S::f32s; 3]) -> S::f32s {
    a + share_c.mul_add(c - a, share_b * (b - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_are_decided_by_exact_products_and_then_by_the_moved_ray() {
        // 1 + 2⁻²³ squared and 1 + 2⁻²² times 1 round to the same number.
        let (e, one) = (f32::EPSILON, 1.0_f32);
        let (a, b) = ([one + e, one], [one + 2.0 * e, one + e]);
        assert_eq!(a[0] * b[1], a[1] * b[0]);
        assert!(exactly_positive(a, b) && !exactly_positive(b, a));
        // The ray is on the line: moved to the right it has the line up on its left.
        let (down, up) = ([0.0, -1.0], [0.0, 1.0]);
        assert_ne!(exactly_positive(down, up), exactly_positive(up, down));
        let (left, right) = ([-1.0, 0.0], [1.0, 0.0]);
        assert!(exactly_positive(left, right) && !exactly_positive(right, left));
    }
}
