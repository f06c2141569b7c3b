//! The Hilbert curve in three dimensions.
//!
//! J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707, 2004.

use glam::DVec3;

use crate::Bounds;

/// Bits along each axis.
pub const BITS: u32 = 16;

/// One more than the greatest number of a place on the curve.
pub const END: u64 = 1 << (3 * BITS);

/// How far along the curve through a box a point is: below [`END`].
///
/// The curve is that of the cube around `bounds` with its least corner; a point outside counts as
/// the nearest inside.
pub fn place(bounds: &Bounds, point: DVec3) -> u64 {
    let size = bounds.size().max_element();
    let size = if size > 0.0 { size } else { 1.0 };
    let cells = f64::from(1_u32 << BITS);
    // Conversions clamp to 0 and to the greatest number.
    let cell = |x: f64| ((x * cells) as u32).min((1 << BITS) - 1);
    let at = (point - bounds.min) / size;
    index([cell(at.x), cell(at.y), cell(at.z)])
}

/// The number along the curve of a cell of the lattice of 2¹⁶ cells along each axis.
fn index(mut x: [u32; 3]) -> u64 {
    // Inverse undo.
    let mut q = 1 << (BITS - 1);
    while q > 1 {
        let p = q - 1;
        for i in 0..3 {
            if x[i] & q != 0 {
                x[0] ^= p;
            } else {
                let t = (x[0] ^ x[i]) & p;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
        q >>= 1;
    }
    // Gray code.
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut t = 0;
    let mut q = 1 << (BITS - 1);
    while q > 1 {
        if x[2] & q != 0 {
            t ^= q - 1;
        }
        q >>= 1;
    }
    // The first axis has the most significant of each three bits.
    let [a, b, c] = x.map(|x| spread(x ^ t));
    a << 2 | b << 1 | c
}

/// Bit i of `value` at place 3 i.
fn spread(value: u32) -> u64 {
    let mut x = u64::from(value);
    for (shift, mask) in [
        (16, 0x0000_0000_ff00_00ff),
        (8, 0x0000_00f0_0f00_f00f),
        (4, 0x0000_0c30_c30c_30c3),
        (2, 0x0000_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_spread_three_apart() {
        for value in [0, 1, 0x8000, 0xffff, 0xabcd, 0x1234] {
            let slow = (0..16).fold(0, |x: u64, i| x | u64::from(value >> i & 1) << (3 * i));
            assert_eq!(spread(value), slow, "{value:x}");
        }
    }

    /// Steps of one cell, each of them once: the curve of the whole lattice is that of its first
    /// cells, eight times larger each time.
    #[test]
    fn neighbors_on_the_curve_are_neighbors_in_space() {
        const SIDE: u32 = 16;
        let cells =
            (0..SIDE).flat_map(|x| (0..SIDE).flat_map(move |y| (0..SIDE).map(move |z| [x, y, z])));
        let mut along: Vec<(u64, [u32; 3])> = cells.map(|cell| (index(cell), cell)).collect();
        along.sort_unstable();
        let places = along.iter().map(|(place, _)| *place);
        assert!(places.eq(0..u64::from(SIDE * SIDE * SIDE)));
        for pair in along.windows(2) {
            let apart: u32 = (0..3).map(|i| pair[0].1[i].abs_diff(pair[1].1[i])).sum();
            assert_eq!(apart, 1, "{pair:?}");
        }
    }

    #[test]
    fn every_point_has_a_place() {
        let bounds = Bounds::of([DVec3::ZERO, DVec3::new(4.0, 2.0, 1.0)]);
        for point in [DVec3::splat(-9.0), bounds.max, DVec3::NAN, DVec3::INFINITY] {
            assert!(place(&bounds, point) < END);
        }
        assert!(place(&Bounds::EMPTY, DVec3::ONE) < END);
        let flat = Bounds::of([DVec3::ONE]);
        assert!(place(&flat, DVec3::ONE) < END);
    }
}
