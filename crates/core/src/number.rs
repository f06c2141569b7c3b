//! Numbers as people read them in messages and lists.
//!
//! Rust prints 1e-300 as 300 zeros and 1e300 as 301 digits; a fixed number of decimals
//! makes 1e-9 a zero. Here the size of a number decides on its form.

use glam::DVec3;

use crate::Bounds;

/// From here on numbers are written with a power of ten: f64 holds all integers below 9e15.
const LARGE: f64 = 1e15;

/// Below this magnitude numbers are written with a power of ten.
const SMALL: f64 = 1e-4;

/// Significant digits of [`rounded`].
const DIGITS: usize = 6;

/// `value` with as few digits as tell it apart from its neighbors: reading the text gives
/// `value` again.
///
/// A number that f32 holds has the digits that tell it apart in f32, as it was stored in
/// that type as a rule: 0.1 for 0.10000000149011612. Reading that text as f32 gives `value`.
/// Whole numbers below 10¹⁵ are written in full.
pub fn exact(value: f64) -> String {
    if value == 0.0 {
        return "0".into(); // also for −0, which is the same number
    }
    if !value.is_finite() {
        return match value {
            _ if value.is_nan() => "NaN".into(),
            f64::INFINITY => "inf".into(),
            _ => "-inf".into(),
        };
    }
    let powers = !(SMALL..LARGE).contains(&value.abs());
    let narrow = value as f32;
    // Subnormal f32 have too few digits to have been written as such.
    let is_narrow =
        narrow.is_normal() && f64::from(narrow) == value && (value.fract() != 0.0 || powers);
    match (is_narrow, powers) {
        (true, true) => format!("{narrow:e}"),
        (true, false) => narrow.to_string(),
        (false, true) => format!("{value:e}"),
        (false, false) => value.to_string(),
    }
}

/// `value` rounded to six significant digits, for what was computed.
pub fn rounded(value: f64) -> String {
    let rounded = format!("{value:.precision$e}", precision = DIGITS - 1);
    exact(rounded.parse().unwrap_or(value))
}

/// How many things there are, as "1 cluster" or "2 clusters": the two words are given.
pub fn count(count: u64, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// The range from `low` to `high`, as `[low, high]`, each end rounded to a millionth of the range's width or to four
/// digits, whichever is finer; equal ends are written in full.
pub fn range((low, high): (f64, f64)) -> String {
    let width = high - low;
    let end = |value: f64| {
        let digits = (value.abs() / width).log10().ceil() + 7.0;
        // Of no width, of infinite width, or without a number at all: in full.
        if !digits.is_finite() || digits >= 17.0 {
            return exact(value);
        }
        let digits = digits.max(4.0) as usize;
        let rounded = format!("{value:.precision$e}", precision = digits - 1);
        let rounded: f64 = rounded.parse().unwrap_or(value);
        let [rounded, full] = [exact(rounded), exact(value)];
        if rounded.len() < full.len() {
            rounded
        } else {
            full
        }
    };
    format!("[{}, {}]", end(low), end(high))
}

/// A point or a direction, as `[x, y, z]`.
pub fn vector(v: DVec3) -> String {
    format!("[{}, {}, {}]", exact(v.x), exact(v.y), exact(v.z))
}

/// A box, as `[x, y, z] to [x, y, z]`.
pub fn bounds(bounds: &Bounds) -> String {
    format!("{} to {}", vector(bounds.min), vector(bounds.max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_fits_the_size() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-17.0, "-17"),
            (0.1, "0.1"),
            (-0.25, "-0.25"),
            (1e-4, "0.0001"),
            (9.5e-5, "9.5e-5"),
            (1e-9, "1e-9"),
            (-1e-300, "-1e-300"),
            (f64::from_bits(1), "5e-324"),
            (123_456.789, "123456.789"),
            (16_777_217.0, "16777217"),
            (999_999_999_999_999.0, "999999999999999"),
            (1e15, "1e15"),
            (864_691_135_000_000_768.0, "8.646911350000008e17"),
            (1e300, "1e300"),
            (f64::MAX, "1.7976931348623157e308"),
            (1_600_000_000.5, "1600000000.5"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
            (f64::NEG_INFINITY, "-inf"),
        ] {
            assert_eq!(exact(value), text);
            assert!(exact(value).len() <= 24, "{text}");
            if value.is_finite() {
                assert_eq!(exact(value).parse(), Ok(value), "{text}");
            }
        }
    }

    // 0.1 as f32 is 0.100000001490116…; its digits in f64 tell nothing that was written.
    #[test]
    fn what_was_stored_in_f32_has_its_digits() {
        for (stored, text) in [
            (0.1_f32, "0.1"),
            (1.0 / 3.0, "0.33333334"),
            (2.5e-7, "2.5e-7"),
            (-4.9775, "-4.9775"),
            (16_777_216.0, "16777216"),
            (1e36, "1e36"),
        ] {
            assert_eq!(exact(stored.into()), text);
            assert_eq!(text.parse(), Ok(stored));
        }
    }

    #[test]
    fn computed_numbers_have_six_digits() {
        for (value, text) in [
            (1.0 / 3.0, "0.333333"),
            (2e-9 / 3.0, "6.66667e-10"),
            (1_234_567.8, "1234570"),
            (999_999.96, "1000000"),
            (1e300 / 3.0, "3.33333e299"),
            (-2.0, "-2"),
            (0.0, "0"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(rounded(value), text);
        }
    }

    #[test]
    fn one_thing_is_not_several() {
        let words = [0, 1, 2].map(|n| count(n, "cluster", "clusters"));
        assert_eq!(words, ["0 clusters", "1 cluster", "2 clusters"]);
    }

    #[test]
    fn ranges_and_boxes_are_made_of_numbers() {
        for ((low, high), text) in [
            ((-1e-9, 1e40), "[-1e-9, 1e40]"),
            ((0.0, 1.0 / 3.0), "[0, 0.3333333]"),
            ((2.0, 101_325.123_456_789), "[2, 101325.12]"),
            (
                (101_324.999_1, 101_325.001_234_567_8),
                "[101324.9991, 101325.001234568]",
            ),
            ((1.234_567e-12, 1.0), "[1.235e-12, 1]"),
            (
                (1.0 / 3.0, 1.0 / 3.0),
                "[0.3333333333333333, 0.3333333333333333]",
            ),
            (
                (f64::MIN, f64::MAX),
                "[-1.7976931348623157e308, 1.7976931348623157e308]",
            ),
            ((f64::NAN, f64::INFINITY), "[NaN, inf]"),
        ] {
            assert_eq!(range((low, high)), text);
        }
        let unit = Bounds {
            min: DVec3::ZERO,
            max: DVec3::new(1e-9, 0.5, 2.0),
        };
        assert_eq!(bounds(&unit), "[0, 0, 0] to [1e-9, 0.5, 2]");
    }
}
