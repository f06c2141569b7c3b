//! The same in f64, for each pixel and voxel by itself: nothing is snapped, nothing accumulates.
//!
//! Two cells compute the parts that they share alike: edges from their lower to their upper end, faces from
//! their corners in one order. So columns have neither gaps nor voxels written twice, but where
//! rounding, by 10⁻¹³ voxels or so, swaps two faces of a cell: there voxels may be written twice.

use tetrascope_core::glam::DVec3;

use crate::face::{Corner, Extent, Fragment, Number, Range32, VALUE_BITS, Window};

/// A triangle whose corners are in the order of their places.
pub(crate) struct Face {
    corners: [Corner<f64>; 3],
    area: f64,
}

/// The corners in the order of their places, and whether that order is turned the other way.
fn ordered(triangle: &[Corner<f64>; 3]) -> ([Corner<f64>; 3], bool) {
    let mut corners = *triangle;
    let mut turned = false;
    let key = |c: &Corner<f64>| [c.y, c.x, c.z, c.scalar];
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if key(&corners[j]) < key(&corners[i]) {
            corners.swap(i, j);
            turned = !turned;
        }
    }
    (corners, turned)
}

/// Twice the area of a triangle's projection, in which equal corners give 0.
fn area([a, b, c]: &[Corner<f64>; 3]) -> f64 {
    (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y)
}

/// The first pixel whose center is not less than `coordinate`; far away, the nearest that is
/// an integer.
fn pixel(coordinate: f64) -> i32 {
    (coordinate - 0.5).ceil() as i32
}

fn center(pixel: i32) -> f64 {
    f64::from(pixel) + 0.5
}

impl Number for f64 {
    type Face = Face;
    type Sample = (i32, i32);

    fn corner(place: DVec3, scalar: f64) -> Corner<f64> {
        let [x, y, z] = place.to_array();
        Corner { x, y, z, scalar }
    }

    fn translate(corner: &Corner<f64>, offset: DVec3) -> Corner<f64> {
        Corner {
            x: corner.x + offset.x,
            y: corner.y + offset.y,
            z: corner.z + offset.z,
            scalar: corner.scalar,
        }
    }

    fn volume_sign(corners: &[Corner<f64>], faces: &[[u8; 3]]) -> i8 {
        let place = |i: u8| {
            let p = corners[usize::from(i)];
            DVec3::new(p.x, p.y, p.z)
        };
        let from = |i| place(i) - place(0);
        let volume: f64 = faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(from);
                a.dot(b.cross(c))
            })
            .sum();
        i8::from(volume > 0.0) - i8::from(volume < 0.0)
    }

    fn pixels(coordinates: impl Iterator<Item = f64>) -> Range32 {
        let (low, high) = coordinates.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), c| {
            (low.min(c), high.max(c))
        });
        (pixel(low), pixel(high))
    }

    fn winding(triangle: &[Corner<f64>; 3]) -> i8 {
        let (corners, turned) = ordered(triangle);
        let area = area(&corners);
        let sign = i8::from(area > 0.0) - i8::from(area < 0.0);
        if turned { -sign } else { sign }
    }

    fn form_buffers(
        triangle: &[Corner<f64>; 3],
        window: &Window,
        extents: &mut Vec<Extent<(i32, i32)>>,
    ) -> Face {
        let (corners, _) = ordered(triangle);
        let rows = <f64 as Number>::pixels(corners.iter().map(|p| p.y));
        extents.clear();
        for row in rows.0.max(window.rows.start)..rows.1.min(window.rows.end) {
            let mut columns = (i32::MAX, i32::MIN);
            for (low, high) in [(0, 1), (1, 2), (0, 2)] {
                let (low, high) = (corners[low], corners[high]);
                if !(pixel(low.y)..pixel(high.y)).contains(&row) {
                    continue;
                }
                let share = (center(row) - low.y) / (high.y - low.y);
                let column = pixel(low.x + (high.x - low.x) * share);
                columns = (columns.0.min(column), columns.1.max(column));
            }
            let left = columns.0.max(window.columns.start);
            let right = columns.1.min(window.columns.end);
            if left < right {
                extents.push(Extent {
                    row,
                    columns: (left, right),
                    left: (left, row),
                });
            }
        }
        Face {
            area: area(&corners),
            corners,
        }
    }

    fn step(_: &Face, sample: &mut (i32, i32)) {
        sample.0 += 1;
    }

    fn fragment(face: &Face, &(column, row): &(i32, i32)) -> Fragment<f64> {
        let [a, b, c] = &face.corners;
        let (x, y) = (center(column) - a.x, center(row) - a.y);
        // Shares of b and c, in [0, 1] but for rounding.
        let of_b = (x * (c.y - a.y) - (c.x - a.x) * y) / face.area;
        let of_c = ((b.x - a.x) * y - x * (b.y - a.y)) / face.area;
        let value = |of: fn(&Corner<f64>) -> f64| {
            let (low, high) = [b, c].iter().fold((of(a), of(a)), |(low, high), p| {
                (low.min(of(p)), high.max(of(p)))
            });
            let value = of(a) + of_b * (of(b) - of(a)) + of_c * (of(c) - of(a));
            value.clamp(low, high)
        };
        let depth = value(|p| p.z);
        Fragment {
            voxel: pixel(depth),
            depth,
            scalar: value(|p| p.scalar),
        }
    }

    fn fill(
        front: &Fragment<f64>,
        back: &Fragment<f64>,
        (first, end): Range32,
        at_center: bool,
        mut write: impl FnMut(i32, u32),
    ) {
        for voxel in first..end {
            let past = match at_center {
                true => center(voxel) - front.depth,
                false => f64::from(voxel - front.voxel),
            };
            let depth = back.depth - front.depth;
            let share = if depth > 0.0 { past / depth } else { 0.0 };
            let scalar = front.scalar + share.clamp(0.0, 1.0) * (back.scalar - front.scalar);
            let unit = f64::from(1 << VALUE_BITS);
            write(voxel, (scalar * unit).round().clamp(0.0, unit) as u32);
        }
    }
}
