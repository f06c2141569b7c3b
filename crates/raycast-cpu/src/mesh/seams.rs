//! Where a ray crosses a face at which a part of a mesh ends: the same to the last bit in both parts.
//!
//! Within a part, a cell takes over from the one before where the ray crosses the face between them. Two
//! parts compute it each by itself, and have the corners in orders of their own. Were the depths different,
//! segments would not meet; were the scalars, a surface at this value could be in neither part, or in both.
//! So the corners are ordered by what they are, and all is in f64, whose sums are the same in every lane.

use super::packed::{LEAST_NO_SCALAR, NO_SCALAR, Vertex};

/// z and scalar where a ray crosses a face; `through` and `slope` as in `rays::BlockRays`.
///
/// It lies between the corners'. Seen edge on, any of the face's points will do: the first corner.
pub(super) fn crossing(through: [f32; 2], slope: [f32; 2], corners: [Vertex; 3]) -> [f32; 2] {
    let mut corners = corners;
    corners.sort_unstable_by_key(|corner| corner.map(f32::to_bits));
    let has_gap = corners.iter().any(|corner| corner[3] >= LEAST_NO_SCALAR);
    let corners = corners.map(|corner| corner.map(f64::from));
    let [a, b, c] = corners.map(|[x, y, z, _]| {
        [(x, 0), (y, 1)]
            .map(|(x, axis)| f64::from(slope[axis]) * z + (x - f64::from(through[axis])))
    });
    let area = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let areas = [area(b, c), area(c, a), area(a, b)];
    let way = (areas[0] + areas[1] + areas[2]).signum();
    // The rule of sides has decided that the ray crosses the face, of rounded corners.
    let shares = areas.map(|area| (area * way).max(0.0));
    let whole: f64 = shares.iter().sum();
    let mean = |i: usize| {
        let first = corners[0][i];
        if whole <= 0.0 || whole.is_nan() {
            return first as f32;
        }
        let rest = (1..3).map(|j| shares[j] / whole * (corners[j][i] - first));
        let values = corners.map(|corner| corner[i]);
        let least = values.into_iter().fold(f64::INFINITY, f64::min);
        let greatest = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        (first + rest.sum::<f64>()).clamp(least, greatest) as f32
    };
    [mean(2), if has_gap { NO_SCALAR } else { mean(3) }]
}

#[cfg(test)]
mod tests {
    use tetrascope_testing::Random;

    use super::*;

    /// However the corners are given, also where the ray goes through an edge or a corner, and along the face.
    #[test]
    fn every_order_gives_the_same_bits() {
        let mut random = Random(7);
        let mut number = || random.bits() as f32 / u32::MAX as f32 * 2.0 - 1.0;
        for case in 0..2000 {
            let mut corners = [[0.0; 4]; 3].map(|corner: [f32; 4]| corner.map(|_| number()));
            let mut through = [number() * 0.3, number() * 0.3];
            let slope = [number(), number()];
            let meet = |[x, y, z, _]: Vertex| [slope[0] * z + x, slope[1] * z + y];
            match case % 4 {
                0 => through = meet(corners[0]),
                1 => corners[2] = [0, 1, 2, 3].map(|i| 0.5 * (corners[0][i] + corners[1][i])),
                2 => corners[1] = corners[0],
                _ => {}
            }
            let [a, b, c] = corners;
            let first = crossing(through, slope, [a, b, c]);
            for other in [[a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
                let found = crossing(through, slope, other);
                assert_eq!(found.map(f32::to_bits), first.map(f32::to_bits), "{case}");
            }
            for (i, value) in [(2, first[0]), (3, first[1])] {
                let values = corners.map(|corner| corner[i]);
                let within =
                    values.iter().any(|v| *v <= value) && values.iter().any(|v| *v >= value);
                assert!(within, "{case}");
            }
        }
    }

    #[test]
    fn a_mean_is_that_of_the_corners_and_a_constant_stays_one() {
        let corners = [
            [0.0, 0.0, 1.0, 0.1],
            [3.0, 0.0, 1.0, 0.1],
            [0.0, 3.0, 4.0, 0.1],
        ];
        // Along z through (1, 1): a third of each corner.
        let [z, scalar] = crossing([1.0, 1.0], [0.0; 2], corners);
        assert_eq!((z, scalar), (2.0, 0.1));
        let gap = corners.map(|[x, y, z, _]| [x, y, z, if z > 1.0 { NO_SCALAR } else { 0.1 }]);
        assert_eq!(crossing([1.0, 1.0], [0.0; 2], gap), [2.0, NO_SCALAR]);
    }
}
