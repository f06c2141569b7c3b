//! Opacity between two points, with VTK's midpoint and sharpness.

use super::OpacityPoint;

/// VTK keeps midpoints this far from the points.
const NEAREST_MIDPOINT: f64 = 1e-5;

/// Sharpness from here on is a step at the midpoint.
pub(super) const STEP: f64 = 0.99;

/// Sharpness up to here is two straight lines that meet at the midpoint.
pub(super) const LINEAR: f64 = 0.01;

/// Where in (0, 1) between a point and the next the midpoint is.
pub(super) fn midpoint(from: &OpacityPoint) -> f64 {
    from.midpoint
        .clamp(NEAREST_MIDPOINT, 1.0 - NEAREST_MIDPOINT)
}

/// The opacity at `s` in (0, 1) between a point and the next; the first point's midpoint and
/// sharpness count.
pub(super) fn between(from: &OpacityPoint, to: &OpacityPoint, s: f64) -> f64 {
    let middle = midpoint(from);
    // The midpoint becomes the half.
    let s = match s < middle {
        true => 0.5 * s / middle,
        false => 0.5 + 0.5 * (s - middle) / (1.0 - middle),
    };
    let (a, b, sharpness) = (from.opacity, to.opacity, from.sharpness);
    if sharpness > STEP {
        return if s < 0.5 { a } else { b };
    }
    if sharpness < LINEAR {
        return a * (1.0 - s) + b * s;
    }
    // Each half is bent toward its end, and a cubic of Hermite goes through.
    let power = 1.0 + 10.0 * sharpness;
    let s = match s < 0.5 {
        true => 0.5 * (2.0 * s).powf(power),
        false => 1.0 - 0.5 * (2.0 * (1.0 - s)).powf(power),
    };
    let (s2, s3) = (s * s, s * s * s);
    let slope = (1.0 - sharpness) * (b - a);
    let value = (2.0 * s3 - 3.0 * s2 + 1.0) * a
        + (3.0 * s2 - 2.0 * s3) * b
        + (s3 - 2.0 * s2 + s) * slope
        + (s3 - s2) * slope;
    value.clamp(a.min(b), a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(opacity: f64, midpoint: f64, sharpness: f64) -> OpacityPoint {
        OpacityPoint {
            scalar: 0.0,
            opacity,
            midpoint,
            sharpness,
        }
    }

    #[test]
    fn the_middle_of_opacity_is_at_the_midpoint() {
        let end = point(0.9, 0.5, 0.0);
        for sharpness in [0.0, 0.2, 0.5, 0.9] {
            for middle in [0.1, 0.5, 0.8] {
                let from = point(0.1, middle, sharpness);
                // Both ways of the half meet there: the cubic at s = ½ is the mean.
                assert!((between(&from, &end, middle) - 0.5).abs() < 1e-12);
                assert!((between(&from, &end, 1e-12) - 0.1).abs() < 1e-9);
                assert!((between(&from, &end, 1.0 - 1e-12) - 0.9).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn sharpness_goes_from_lines_to_a_step() {
        let end = point(1.0, 0.5, 0.0);
        assert_eq!(between(&point(0.0, 0.5, 0.0), &end, 0.25), 0.25);
        assert_eq!(between(&point(0.0, 0.25, 0.0), &end, 0.125), 0.25);
        let step = point(0.0, 0.3, 1.0);
        assert_eq!([0.29, 0.31].map(|s| between(&step, &end, s)), [0.0, 1.0]);
        // The formula by hand, sharpness ½ at s = ¼: s' = ½ · ½⁶ = 1/128; then
        // 3 s'² − 2 s'³ + ½ (s'³ − 2 s'² + s' + s'³ − s'²).
        let s = 1.0 / 128.0_f64;
        let by_hand = 3.0 * s * s - 2.0 * s * s * s + 0.5 * (2.0 * s * s * s - 3.0 * s * s + s);
        let found = between(&point(0.0, 0.5, 0.5), &end, 0.25);
        assert!((found - by_hand).abs() < 1e-15, "{found} {by_hand}");
    }
}
