//! Gauss–Legendre rules on [0, 1].

use std::sync::LazyLock;

/// Nodes and weights of the n-point rule: exact for polynomials of degree 2 n − 1.
pub(crate) type Rule = Vec<(f64, f64)>;

/// Rules by the greatest optical depth for which they serve; see [`rule`].
static RULES: LazyLock<[(f64, Rule); 5]> = LazyLock::new(|| {
    [
        (1e-5, 6),
        (1e-3, 8),
        (0.03, 10),
        (0.25, 12),
        (LARGEST_DEPTH, 16),
    ]
    .map(|(depth, n)| (depth, nodes(n)))
});

/// The greatest optical depth for which there is a rule.
pub(crate) const LARGEST_DEPTH: f64 = 1.0;

/// The 4-point rule, exact up to degree 7.
pub(crate) static FOUR: LazyLock<Rule> = LazyLock::new(|| nodes(4));

/// The rule for ∫ x σ l e^(−∫σ l) dτ, where x and σ are linear in a monotone cubic and
/// ∫σ l over the whole is `depth`, at most [`LARGEST_DEPTH`].
///
/// Expanding the exponential gives degrees 6, 10, 14, … with factors 1, depth,
/// depth²/2, …, so that few nodes do where the depth is small. The limits are measured:
/// on monotone cubics of all shapes, x from 0 to 1, no error exceeds 3e-14 of `depth`
/// (test `rules_are_as_exact_as_they_say`).
pub(crate) fn rule(depth: f64) -> &'static Rule {
    let found = RULES.iter().find(|(limit, _)| depth <= *limit);
    &found.unwrap_or(&RULES[RULES.len() - 1]).1
}

/// The n-point rule, from the roots of Pₙ by Newton's method.
fn nodes(n: usize) -> Rule {
    let node = |i: usize| {
        // Abramowitz & Stegun 22.16.6: within 1e-2 of the root, where Newton converges.
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut before, mut value) = (1.0, x);
            for k in 2..=n {
                let k = k as f64;
                let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
                (before, value) = (value, next);
            }
            slope = n as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..n).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    // ∫ xᵏ = 1/(k + 1) up to degree 2 n − 1; rounding of n positive terms.
    #[test]
    fn rules_are_exact_for_polynomials() {
        for n in [1, 2, 4, 6, 8, 10, 12, 16] {
            let rule = nodes(n);
            assert_eq!(rule.len(), n);
            for degree in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = 1.0 / (degree as f64 + 1.0);
                assert!(
                    (sum - exact).abs() < 2e-15,
                    "{n} {degree} {:e}",
                    sum - exact
                );
            }
        }
    }
}
