//! The order in which people count: step_2 before step_10.

use std::cmp::Ordering;

/// Compares names, runs of digits in them as numbers.
pub(crate) fn compare(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    while let (Some(x), Some(y)) = (left.chars().next(), right.chars().next()) {
        let order = if x.is_ascii_digit() && y.is_ascii_digit() {
            let (m, n) = (digits(&mut left), digits(&mut right));
            m.len().cmp(&n.len()).then(m.cmp(n))
        } else {
            left = &left[x.len_utf8()..];
            right = &right[y.len_utf8()..];
            x.cmp(&y)
        };
        if order.is_ne() {
            return order;
        }
    }
    // Names that differ in leading zeros alone differ still.
    left.len().cmp(&right.len()).then(a.cmp(b))
}

/// Takes the digits at the beginning; gives them without zeros in front.
fn digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text.find(|c: char| !c.is_ascii_digit());
    let (number, rest) = text.split_at(end.unwrap_or(text.len()));
    *text = rest;
    number.trim_start_matches('0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_as_such() {
        let sorted = [
            "",
            "a",
            "a1",
            "a01",
            "a2",
            "a2b",
            "a10",
            "a10b2",
            "a10b10",
            "a99999999999999999999999",
            "b",
            "é1",
        ];
        for (i, a) in sorted.iter().enumerate() {
            for (j, b) in sorted.iter().enumerate() {
                let expected = match (*a, *b) {
                    // Equal numbers: by their bytes.
                    ("a1", "a01") => Ordering::Greater,
                    ("a01", "a1") => Ordering::Less,
                    _ => i.cmp(&j),
                };
                assert_eq!(compare(a, b), expected, "{a} {b}");
            }
        }
    }
}
