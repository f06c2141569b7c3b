//! A quantity that grows with a scene, as a sum of terms none of which is negative.

/// A sum of `N` terms, fitted to measurements.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fit<const N: usize> {
    /// The factor of each term, 0 or more.
    coefficients: [f64; N],
    /// The geometric standard deviation of measurements around it, at least 1.
    pub(crate) spread: f64,
}

impl<const N: usize> Fit<N> {
    /// Fits measurements, more than 0, of scenes with these terms; `None` without any.
    ///
    /// Relative differences are made small, so that small scenes count as much as large ones.
    /// There are at most half as many terms as measurements: more would follow the noise.
    pub(crate) fn new(terms: &[[f64; N]], measured: &[f64]) -> Option<Fit<N>> {
        if measured.is_empty() {
            return None;
        }
        let relative = terms
            .iter()
            .zip(measured)
            .map(|(row, m)| row.map(|t| t / m));
        let rows: Vec<[f64; N]> = relative.collect();
        let most = (measured.len() / 2).max(1);
        let coefficients = non_negative_least_squares(&rows, &vec![1.0; rows.len()], most)?;
        let fit = Fit {
            coefficients,
            spread: 1.0,
        };
        let logs = terms.iter().zip(measured);
        let squares: f64 = logs.map(|(row, m)| (m / fit.at(row)).ln().powi(2)).sum();
        let used = coefficients.iter().filter(|c| **c > 0.0).count();
        let left = measured.len().saturating_sub(used).max(1);
        Some(Fit {
            spread: (squares / left as f64).sqrt().exp(),
            ..fit
        })
    }

    /// The value for a scene with these terms.
    pub(crate) fn at(&self, terms: &[f64; N]) -> f64 {
        let products = self.coefficients.iter().zip(terms);
        products.map(|(c, t)| c * t).sum()
    }
}

/// The x ≥ 0 with at most `most` numbers that are not 0 for which |A x − b|² is least; `None` if
/// there is none but 0, or a number is not finite. `rows` are those of A.
///
/// The numbers that are not 0 solve the least squares of their columns alone, so all sets of
/// columns are tried: there are 2ᴺ, and `N` is small.
fn non_negative_least_squares<const N: usize>(
    rows: &[[f64; N]],
    b: &[f64],
    most: usize,
) -> Option<[f64; N]> {
    let mut best: Option<(f64, [f64; N])> = None;
    for set in 1_u32..1 << N {
        let columns: Vec<usize> = (0..N).filter(|i| set >> i & 1 == 1).collect();
        if columns.len() > most {
            continue;
        }
        let Some(solution) = least_squares(rows, b, &columns) else {
            continue;
        };
        if solution.iter().any(|x| *x < 0.0) {
            continue;
        }
        let mut x = [0.0; N];
        columns.iter().zip(solution).for_each(|(&i, s)| x[i] = s);
        let residual = |(row, b): (&[f64; N], &f64)| {
            let sum: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum();
            (sum - b).powi(2)
        };
        let square: f64 = rows.iter().zip(b).map(residual).sum();
        // Of two that fit alike but for rounding, the one found first, with fewer columns or
        // earlier ones.
        if square.is_finite() && best.is_none_or(|(least, _)| square < least * (1.0 - 1e-9)) {
            best = Some((square, x));
        }
    }
    best.map(|(_, x)| x)
}

/// The least squares of some columns, by the normal equations of columns of length 1; `None` if the
/// columns depend on each other.
fn least_squares<const N: usize>(
    rows: &[[f64; N]],
    b: &[f64],
    columns: &[usize],
) -> Option<Vec<f64>> {
    // What is left of a column of length 1 beside the others, squared: less is their rounding.
    const INDEPENDENT: f64 = 1e-10;
    let n = columns.len();
    let dot = |f: &dyn Fn(usize) -> f64| (0..rows.len()).map(f).sum::<f64>();
    let lengths = columns.iter().map(|&c| dot(&|r| rows[r][c].powi(2)).sqrt());
    let lengths: Vec<f64> = lengths.collect();
    if lengths.iter().any(|l| !(*l > 0.0 && l.is_finite())) {
        return None;
    }
    let mut matrix = vec![vec![0.0; n + 1]; n];
    for i in 0..n {
        for j in 0..n {
            let product = dot(&|r| rows[r][columns[i]] * rows[r][columns[j]]);
            matrix[i][j] = product / (lengths[i] * lengths[j]);
        }
        matrix[i][n] = dot(&|r| rows[r][columns[i]] * b[r]) / lengths[i];
    }
    // Gauss: of a positive definite matrix, without exchanges.
    for i in 0..n {
        if matrix[i][i] < INDEPENDENT {
            return None;
        }
        let row = matrix[i].clone();
        for below in matrix.iter_mut().skip(i + 1) {
            let factor = below[i] / row[i];
            below
                .iter_mut()
                .zip(&row)
                .for_each(|(m, r)| *m -= factor * r);
        }
    }
    let mut x = vec![0.0; n];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| matrix[i][j] * x[j]).sum();
        x[i] = (matrix[i][n] - known) / matrix[i][i];
    }
    x.iter_mut().zip(lengths).for_each(|(x, l)| *x /= l);
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Scenes with 1, a number that grows and one that jumps.
    fn scenes() -> Vec<[f64; 3]> {
        let numbers = (0..8).map(|i| [1.0, f64::from(1 << i), [1e3, 3e5][i % 2]]);
        numbers.collect()
    }

    #[test]
    fn what_is_a_sum_of_terms_is_found_again() {
        let scenes = scenes();
        let sum = |s: &[f64; 3]| 2e-3 * s[0] + 5e-4 * s[1] + 1e-8 * s[2];
        let times: Vec<f64> = scenes.iter().map(sum).collect();
        let fit = Fit::new(&scenes, &times).expect("measurements");
        // The normal equations square the condition: half of f64's digits are left.
        for (found, known) in fit.coefficients.iter().zip([2e-3, 5e-4, 1e-8]) {
            assert!((found / known - 1.0).abs() < 1e-6, "{:?}", fit.coefficients);
        }
        assert!(fit.spread < 1.0 + 1e-6);
        let larger = [1.0, 1e4, 1e7];
        assert!((fit.at(&larger) / sum(&larger) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_takes_less_time_for_more_work() {
        // Falls with the second term: unconstrained, its coefficient would be negative.
        let scenes = scenes();
        let times: Vec<f64> = scenes.iter().map(|s| 1.0 - 1e-3 * s[1]).collect();
        let fit = Fit::new(&scenes, &times).expect("measurements");
        assert_eq!(fit.coefficients[1], 0.0);
        assert!(fit.coefficients[0] > 0.0);
        assert!(fit.coefficients.iter().all(|c| *c >= 0.0));
    }

    /// By hand: of x₀ + t x₁ through (0, 1), (1, 0), (2, 0) the slope would be −1/2; without it
    /// the mean is left.
    #[test]
    fn a_known_problem_has_its_known_solution() {
        let rows = [[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]];
        let x = non_negative_least_squares(&rows, &[1.0, 0.0, 0.0], 2).expect("a solution");
        assert!((x[0] - 1.0 / 3.0).abs() < 1e-12 && x[1] == 0.0, "{x:?}");
        let x = non_negative_least_squares(&rows, &[0.0, 1.0, 2.0], 2).expect("a solution");
        assert!(x[0] < 1e-12 && (x[1] - 1.0).abs() < 1e-12, "{x:?}");
    }

    #[test]
    fn few_and_dependent_measurements_give_a_fit_still() {
        let one = Fit::new(&[[1.0, 5.0, 5.0]], &[0.25]).expect("one is enough");
        assert!((one.at(&[1.0, 5.0, 5.0]) - 0.25).abs() < 1e-12);
        assert_eq!(Fit::<3>::new(&[], &[]), None);
        // Two terms that are the same, and one that is 0.
        let scenes: Vec<[f64; 3]> = (1..9).map(|i| [f64::from(i), f64::from(i), 0.0]).collect();
        let times: Vec<f64> = scenes.iter().map(|s| 3.0 * s[0]).collect();
        let fit = Fit::new(&scenes, &times).expect("measurements");
        assert!((fit.at(&[10.0, 10.0, 0.0]) - 30.0).abs() < 1e-9);
    }

    #[test]
    fn the_spread_is_that_of_the_measurements() {
        // Twice and half the truth in turn: ln 2 around it, and one coefficient.
        let scenes = vec![[1.0]; 8];
        let times: Vec<f64> = (0..8).map(|i| [2.0, 0.5][i % 2]).collect();
        let fit = Fit::new(&scenes, &times).expect("measurements");
        let at = fit.at(&[1.0]);
        let squares = 4.0 * ((2.0 / at).ln().powi(2) + (0.5 / at).ln().powi(2));
        assert!((fit.spread - (squares / 7.0).sqrt().exp()).abs() < 1e-12);
        assert!(fit.spread > 2.0);
    }
}
