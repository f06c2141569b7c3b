//! The fixed-point numbers: everything is exact but scalars, and after the setup of a face, an
//! edge or a column there are additions and comparisons alone.
//!
//! # How many bits
//! A number is a whole part and a rest: value = whole + rest / divisor, with 0 ≤ rest < divisor. A
//! step adds both and carries, so nothing is ever rounded on the way (Bresenham's line). The
//! bounds below are for a cell at most 2¹⁰ voxels wide ([`MOST_SIDE`](crate::MOST_SIDE)) that is at
//! most half a voxel from the volume, and is then moved by as much: voxel coordinates are between
//! −1025 and 2049.
//!
//! | quantity | unit | bound | why |
//! |---|---|---|---|
//! | coordinate | 2⁻⁸ voxel | 2²⁰ | i32 |
//! | difference of coordinates d | 2⁻⁸ voxel | 2¹⁸ | of one cell |
//! | vertex scalar | 2⁻²⁴ range | 2²⁴ | i32, both ends included |
//! | area D = d d − d d | | 2³⁷ | 38 bits |
//! | slopes of depth, numerators | | 2³⁷ | as D |
//! | slopes of the scalar, numerators | | 2⁴³ | 2 · 2²⁴ · 2¹⁸ |
//! | depth at a pixel, numerator | | 2⁵⁶ | 2 · 2³⁷ · 2¹⁸: i64 |
//! | scalar at a pixel, numerator | | 2⁶² | 2 · 2⁴³ · 2¹⁸: i64 |
//! | step of a pixel, numerators | | 2⁵⁶, 2⁵⁷ | slopes, times 2⁸, times 2¹¹ or 2⁶ |
//! | depth | 2⁻¹⁹ voxel | 2³¹ | i32: 2049 · 2¹⁹ is about 2³⁰ |
//! | face's and voxel's scalar | 2⁻³⁰ range | 2³⁰ | i32 |
//! | scalar at a voxel, numerator | | 2⁵⁹ | 2²⁹ · 2³⁰: i64 |
//! | step of a voxel, numerator | | 2⁴⁹ | 2³⁰ · 2¹⁹ |
//! | six times the volume | | 2⁶¹ | at most 20 triangles, determinants of at most (√3 2¹⁸)³ |
//!
//! So per pixel a face keeps two whole parts of 32 bits and two rests of 38; per voxel a column
//! keeps a whole part and a rest of 32. Whole parts wrap around: the step of a steep
//! face does not fit, but where the face is, it does, and sums modulo 2³² do not depend on the way
//! there. A shader needs 64-bit products, sums and quotients for the setup, which two 32-bit words
//! make, and carries into a second word for the rests of faces.
//!
//! # How exact
//! Which pixels a face covers, and before which voxel it lies there, is decided from the exact
//! numbers. A face's scalar at a pixel is rounded down to 2⁻³⁰ of the range, its depth for the
//! interpolation along z to 2⁻¹⁹ voxels.

use tetrascope_core::glam::DVec3;

use crate::face::{Corner, Extent, Fragment, Number, Range32, VALUE_BITS, Window};

/// Vertices lie on multiples of 2⁻⁸ voxels.
pub const PLACE_BITS: u32 = 8;

/// Depths are multiples of 2⁻¹⁹ voxels.
pub const DEPTH_BITS: u32 = 19;

/// Scalars of vertices are multiples of 2⁻²⁴ of the field's range.
pub const SCALAR_BITS: u32 = 24;

const ONE: i32 = 1 << PLACE_BITS;
const HALF: i32 = ONE / 2;

/// A number that changes in equal steps: `whole + rest / divisor`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Walk {
    whole: i32,
    rest: u64,
}

impl Walk {
    /// numerator / divisor.
    fn quotient(numerator: i64, divisor: u64) -> Walk {
        let divisor = divisor as i64;
        Walk {
            // A step that does not fit wraps, as its sums do.
            whole: numerator.div_euclid(divisor) as i32,
            rest: numerator.rem_euclid(divisor) as u64,
        }
    }

    /// (base + numerator / divisor) · 2^bits.
    fn scaled(base: i32, numerator: i64, divisor: u64, bits: u32) -> Walk {
        let Walk { whole, rest } = Walk::quotient(numerator, divisor);
        let fine = rest << bits;
        Walk {
            whole: (base.wrapping_add(whole) << bits).wrapping_add((fine / divisor) as i32),
            rest: fine % divisor,
        }
    }

    fn add(&mut self, step: Walk, divisor: u64) {
        self.whole = self.whole.wrapping_add(step.whole);
        self.rest += step.rest;
        if self.rest >= divisor {
            self.rest -= divisor;
            self.whole = self.whole.wrapping_add(1);
        }
    }

    fn subtract(&mut self, step: Walk, divisor: u64) {
        self.whole = self.whole.wrapping_sub(step.whole);
        if self.rest < step.rest {
            self.rest += divisor;
            self.whole = self.whole.wrapping_sub(1);
        }
        self.rest -= step.rest;
    }

    fn ceiling(self) -> i32 {
        self.whole.wrapping_add(i32::from(self.rest > 0))
    }
}

/// The first pixel whose center is not less than `coordinate`.
fn pixel(coordinate: i32) -> i32 {
    // ⌈(c − 128) / 256⌉
    (coordinate - HALF + ONE - 1) >> PLACE_BITS
}

/// The coordinate of a pixel's center.
fn center(pixel: i32) -> i32 {
    (pixel << PLACE_BITS) + HALF
}

/// A face's slopes, over one divisor.
pub(crate) struct Face {
    divisor: u64,
    depth: [Walk; 2],
    scalar: [Walk; 2],
}

/// A face at a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    depth: Walk,
    scalar: Walk,
}

impl Sample {
    fn forward(&mut self, face: &Face, axis: usize) {
        self.depth.add(face.depth[axis], face.divisor);
        self.scalar.add(face.scalar[axis], face.divisor);
    }

    fn back(&mut self, face: &Face, axis: usize) {
        self.depth.subtract(face.depth[axis], face.divisor);
        self.scalar.subtract(face.scalar[axis], face.divisor);
    }
}

/// The differences of a triangle's corners from its first: x, y, z, scalar.
fn sides([a, b, c]: &[Corner<i32>; 3]) -> [[i64; 4]; 2] {
    [b, c].map(|p| [p.x - a.x, p.y - a.y, p.z - a.z, p.scalar - a.scalar].map(i64::from))
}

/// Twice the area of a triangle's projection.
fn area([u, v]: &[[i64; 4]; 2]) -> i64 {
    u[0] * v[1] - v[0] * u[1]
}

const DEPTH_SHIFT: u32 = DEPTH_BITS - PLACE_BITS;
const SCALAR_SHIFT: u32 = VALUE_BITS - SCALAR_BITS;

impl Number for i32 {
    type Face = Face;
    type Sample = Sample;

    fn corner(place: DVec3, scalar: f64) -> Corner<i32> {
        let [x, y, z] = place
            .to_array()
            .map(|c| (c * f64::from(ONE)).round() as i32);
        Corner {
            x,
            y,
            z,
            scalar: (scalar * f64::from(1 << SCALAR_BITS)).round() as i32,
        }
    }

    fn translate(corner: &Corner<i32>, offset: DVec3) -> Corner<i32> {
        // Opposite offsets stay opposite.
        let [x, y, z] = offset
            .to_array()
            .map(|c| (c * f64::from(ONE)).round() as i32);
        Corner {
            x: corner.x + x,
            y: corner.y + y,
            z: corner.z + z,
            scalar: corner.scalar,
        }
    }

    fn volume_sign(corners: &[Corner<i32>], faces: &[[u8; 3]]) -> i8 {
        let origin = corners[0];
        let from = |i: u8| {
            let p = corners[usize::from(i)];
            [p.x - origin.x, p.y - origin.y, p.z - origin.z].map(i64::from)
        };
        let volume: i64 = faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(from);
                a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            })
            .sum();
        volume.signum() as i8
    }

    fn pixels(coordinates: impl Iterator<Item = i32>) -> Range32 {
        let (low, high) = coordinates.fold((i32::MAX, i32::MIN), |(low, high), c| {
            (low.min(c), high.max(c))
        });
        (pixel(low), pixel(high))
    }

    fn winding(triangle: &[Corner<i32>; 3]) -> i8 {
        area(&sides(triangle)).signum() as i8
    }

    fn form_buffers(
        triangle: &[Corner<i32>; 3],
        window: &Window,
        extents: &mut Vec<Extent<Sample>>,
    ) -> Face {
        let [u, v] = sides(triangle);
        let area = area(&[u, v]);
        let divisor = area.unsigned_abs();
        // value(x, y) = value(a) + (slope[0] (x − a.x) + slope[1] (y − a.y)) / |area|
        let slopes = |of: usize| {
            let sign = area.signum();
            [
                sign * (u[of] * v[1] - v[of] * u[1]),
                sign * (u[0] * v[of] - v[0] * u[of]),
            ]
        };
        let (depth, scalar) = (slopes(2), slopes(3));
        let step = |slopes: [i64; 2], bits: u32| {
            slopes.map(|slope| Walk::quotient(slope << (PLACE_BITS + bits), divisor))
        };
        let face = Face {
            divisor,
            depth: step(depth, DEPTH_SHIFT),
            scalar: step(scalar, SCALAR_SHIFT),
        };

        // The first column not left of each of the two edges that a scan line meets.
        let (first, end) = <i32 as Number>::pixels(triangle.iter().map(|p| p.y));
        let (first, end) = (first.max(window.rows.start), end.min(window.rows.end));
        extents.clear();
        let nothing = Walk { whole: 0, rest: 0 };
        let empty = Sample {
            depth: nothing,
            scalar: nothing,
        };
        extents.extend((first..end).map(|row| Extent {
            row,
            columns: (i32::MAX, i32::MIN),
            left: empty,
        }));
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let (low, high) = match (triangle[from], triangle[to]) {
                (a, b) if a.y <= b.y => (a, b),
                (a, b) => (b, a),
            };
            let rows = (pixel(low.y).max(first), pixel(high.y).min(end));
            if rows.0 >= rows.1 {
                continue;
            }
            let rise = u64::from(high.y.abs_diff(low.y));
            let run = i64::from(high.x - low.x);
            let mut x = Walk::scaled(low.x, run * i64::from(center(rows.0) - low.y), rise, 0);
            let step = Walk::quotient(run << PLACE_BITS, rise);
            for row in rows.0..rows.1 {
                let column = pixel(x.ceiling());
                let Extent { columns, .. } = &mut extents[(row - first) as usize];
                *columns = (columns.0.min(column), columns.1.max(column));
                x.add(step, rise);
            }
        }

        // Depth and scalar at the first column: straight up from one scan line to the next, then
        // along it.
        let mut at: Option<(i32, Sample)> = None;
        extents.retain_mut(|extent| {
            if let Some((_, sample)) = &mut at {
                sample.forward(&face, 1);
            }
            let (left, right) = extent.columns;
            let (left, right) = (
                left.max(window.columns.start),
                right.min(window.columns.end),
            );
            if left >= right {
                return false;
            }
            extent.columns = (left, right);
            let (column, sample) = at.get_or_insert_with(|| {
                let a = triangle[0];
                let dx = i64::from(center(left) - a.x);
                let dy = i64::from(center(extent.row) - a.y);
                let value = |base, slope: [i64; 2], bits| {
                    Walk::scaled(base, slope[0] * dx + slope[1] * dy, divisor, bits)
                };
                let sample = Sample {
                    depth: value(a.z, depth, DEPTH_SHIFT),
                    scalar: value(a.scalar, scalar, SCALAR_SHIFT),
                };
                (left, sample)
            });
            while *column < left {
                sample.forward(&face, 0);
                *column += 1;
            }
            while *column > left {
                sample.back(&face, 0);
                *column -= 1;
            }
            extent.left = *sample;
            true
        });
        face
    }

    fn step(face: &Face, sample: &mut Sample) {
        sample.forward(face, 0);
    }

    fn fragment(_: &Face, sample: &Sample) -> Fragment<i32> {
        // ⌈z − 1/2⌉ of the exact depth.
        let half = 1 << (DEPTH_BITS - 1);
        Fragment {
            voxel: (sample.depth.ceiling() - half + 2 * half - 1) >> DEPTH_BITS,
            depth: sample.depth.whole,
            scalar: sample.scalar.whole,
        }
    }

    fn fill(
        front: &Fragment<i32>,
        back: &Fragment<i32>,
        (first, end): Range32,
        at_center: bool,
        mut write: impl FnMut(i32, u32),
    ) {
        // Both were rounded down, and voxel centers are multiples of both units, so the first
        // voxel's center is still between them.
        let depth = i64::from(back.depth) - i64::from(front.depth);
        let rise = i64::from(back.scalar) - i64::from(front.scalar);
        // A front face at a voxel's center and a back face less than a unit behind it.
        let Some(depth) = u64::try_from(depth).ok().filter(|d| *d > 0) else {
            (first..end).for_each(|voxel| write(voxel, front.scalar as u32));
            return;
        };
        let start = match at_center {
            true => {
                (i64::from(first) << DEPTH_BITS) + (1 << (DEPTH_BITS - 1)) - i64::from(front.depth)
            }
            false => i64::from(first - front.voxel) << DEPTH_BITS,
        };
        let mut scalar = Walk::scaled(front.scalar, start * rise, depth, 0);
        // Not used by a single voxel, for which it may not fit.
        let step = Walk::quotient(rise << DEPTH_BITS, depth);
        for voxel in first..end {
            write(voxel, scalar.whole as u32);
            scalar.add(step, depth);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::scan_convert;

    /// Numbers in [0, below): SplitMix64 (G. Steele, D. Lea, C. Flood, 2014).
    fn random(mut state: u64) -> impl FnMut(i32) -> i32 {
        move |below| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 33) as i32 % below
        }
    }

    /// A triangle at a pixel in 128 bits: ⌈z − 1/2⌉, ⌊2¹⁹ z⌋ and ⌊2³⁰ s⌋, in voxels and ranges; `None`
    /// where it does not cover the pixel's center, moved by (ε, ε²).
    fn exact(triangle: &[Corner<i32>; 3], (column, row): (i32, i32)) -> Option<Fragment<i32>> {
        let [x, y] = [center(column), center(row)].map(i128::from);
        let wide = triangle.map(|c| [c.x, c.y, c.z, c.scalar].map(i128::from));
        let cross = |p: [i128; 4], q: [i128; 4]| {
            let edge = [q[0] - p[0], q[1] - p[1]];
            let sign = edge[0] * (y - p[1]) - edge[1] * (x - p[0]);
            // ε along x, then ε² along y.
            let moved = if edge[1] != 0 { -edge[1] } else { edge[0] };
            (
                sign,
                if sign != 0 {
                    sign.signum()
                } else {
                    moved.signum()
                },
            )
        };
        let [a, b, c] = wide;
        let sides = [cross(b, c), cross(c, a), cross(a, b)];
        if !(sides[0].1 == sides[1].1 && sides[1].1 == sides[2].1) {
            return None;
        }
        let area: i128 = sides.iter().map(|s| s.0).sum();
        let value = |of: usize| -> i128 {
            let shares = sides.iter().zip(wide);
            shares.map(|(side, corner)| side.0 * corner[of]).sum()
        };
        let floor = |numerator: i128, bits: u32| {
            let (n, d) = match area > 0 {
                true => (numerator << bits, area),
                false => (-(numerator << bits), -area),
            };
            n.div_euclid(d)
        };
        // ⌈z − 1/2⌉ = −⌊1/2 − z⌋ for z in 1/256.
        let voxel = -floor(i128::from(HALF) * area - value(2), 0).div_euclid(1 << PLACE_BITS);
        Some(Fragment {
            voxel: voxel as i32,
            depth: floor(value(2), DEPTH_SHIFT) as i32,
            scalar: floor(value(3), SCALAR_SHIFT) as i32,
        })
    }

    fn check(triangle: &[Corner<i32>; 3], window: &Window, step: usize) {
        if i32::winding(triangle) == 0 {
            return;
        }
        let mut extents = Vec::new();
        let face = i32::form_buffers(triangle, window, &mut extents);
        let mut found = std::collections::HashMap::new();
        scan_convert::<i32>(&face, &extents, |column, row, fragment| {
            let before = found.insert((column, row), fragment);
            assert!(before.is_none());
            assert!(window.columns.contains(&column) && window.rows.contains(&row));
        });
        let rows = window.rows.clone().step_by(step);
        for pixel in rows.flat_map(|row| {
            let columns = window.columns.clone().step_by(step);
            columns.map(move |column| (column, row))
        }) {
            let truth = exact(triangle, pixel);
            assert_eq!(found.get(&pixel), truth.as_ref(), "{triangle:?} {pixel:?}");
        }
    }

    #[test]
    fn faces_are_exact_at_every_pixel() {
        let mut random = random(1);
        for round in 0..4000 {
            // Within and around eight pixels, also on their centers and corners.
            let grid = [1, 64, 128][round % 3];
            let mut number = || random(12 * ONE / grid) * grid - 2 * ONE;
            let triangle = [(); 3].map(|()| {
                let [x, y, z, scalar] = [(); 4].map(|()| number());
                Corner {
                    x,
                    y,
                    z,
                    scalar: scalar.abs() << 12,
                }
            });
            let window = Window {
                columns: 0..8,
                rows: 0..7,
            };
            check(&triangle, &window, 1);
        }
    }

    /// Depths less than 2⁻¹⁹ voxels behind a voxel's center are behind it.
    #[test]
    fn rests_decide_as_well() {
        let side = 12 * ONE;
        // The first row's centers are 1/3072 of the triangle's height from its lower edge, and so
        // much, in 1/256 voxels, is z more than 1/2 voxel there.
        let corner = |x, y, z| Corner { x, y, z, scalar: 0 };
        let triangle = [
            corner(0, HALF - 1, HALF),
            corner(side, HALF - 1, HALF),
            corner(0, HALF - 1 + side, HALF + 1),
        ];
        let window = Window {
            columns: 0..8,
            rows: 0..1,
        };
        let mut extents = Vec::new();
        let face = i32::form_buffers(&triangle, &window, &mut extents);
        let fragment = i32::fragment(&face, &extents[0].left);
        assert_eq!((fragment.voxel, fragment.depth), (1, 1 << (DEPTH_BITS - 1)));
        check(&triangle, &window, 1);
    }

    /// The bounds of the module: cells of 1024 voxels, as far away as they may be, with the
    /// steepest slopes. Overflow panics in tests.
    #[test]
    fn the_widest_cells_are_exact_as_well() {
        let mut random = random(2);
        let side = 1024 * ONE;
        for round in 0..60 {
            let first = [-1024 * ONE - HALF, 0, 1024 * ONE + HALF];
            let [x0, y0, z0] = [(); 3].map(|()| first[random(3) as usize]);
            let mut triangle = [(); 3].map(|()| Corner {
                x: x0 + random(side + 1),
                y: y0 + random(side + 1),
                z: z0 + random(side + 1),
                scalar: random((1 << SCALAR_BITS) + 1),
            });
            // Corners of the box, and slivers.
            for corner in triangle.iter_mut().take(round % 4) {
                let pick = |low: i32, bit: i32| low + bit * side;
                corner.x = pick(x0, random(2));
                corner.y = pick(y0, random(2));
                corner.z = pick(z0, random(2));
                corner.scalar = random(2) << SCALAR_BITS;
            }
            if round % 5 == 0 {
                triangle[2].x = triangle[1].x + random(3) - 1;
                triangle[2].y = triangle[1].y;
            }
            let window = Window {
                columns: 0..1024,
                rows: 0..1024,
            };
            check(&triangle, &window, 31);
        }
    }

    #[test]
    fn columns_are_exact_in_every_voxel() {
        let mut random = random(3);
        for round in 0..2000 {
            let depth = |voxels: i32, part: i32| (voxels << DEPTH_BITS) + part;
            let most = [4, 40, 1023][round % 3];
            let near = depth(random(1024 - most), random(1 << DEPTH_BITS));
            let far = near + depth(random(most), random(1 << DEPTH_BITS));
            let first_center = |depth: i32| {
                let half = 1 << (DEPTH_BITS - 1);
                (depth + half - 1) >> DEPTH_BITS
            };
            let [front, back] = [near, far].map(|depth| Fragment {
                voxel: first_center(depth),
                depth,
                scalar: random((1 << VALUE_BITS) + 1),
            });
            // Part of the column may be outside of the volume.
            let first = front.voxel + random(2).min(back.voxel - front.voxel);
            for at_center in [true, false] {
                let mut next = first;
                i32::fill(
                    &front,
                    &back,
                    (first, back.voxel),
                    at_center,
                    |voxel, scalar| {
                        assert_eq!(voxel, next);
                        next += 1;
                        let past = match at_center {
                            true => {
                                (i128::from(voxel) << DEPTH_BITS) + (1 << (DEPTH_BITS - 1))
                                    - i128::from(near)
                            }
                            false => i128::from(voxel - front.voxel) << DEPTH_BITS,
                        };
                        let rise = i128::from(back.scalar) - i128::from(front.scalar);
                        let thickness = i128::from(far - near).max(1);
                        let truth = i128::from(front.scalar) + (past * rise).div_euclid(thickness);
                        assert_eq!(i128::from(scalar), truth);
                    },
                );
                assert_eq!(next, back.voxel.max(first));
            }
        }
    }
}
