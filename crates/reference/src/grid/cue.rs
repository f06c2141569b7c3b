//! Depth cue: integrals of a part of a cell whose light fades linearly along it.

use super::cubic::Cubic;
use super::integral::{horner, power, quartic_power};
use super::pieces::Piece;
use super::quadrature::{FOUR, rule};

/// A factor that goes linearly from its first to its second number.
pub(crate) type Cue = [f64; 2];

/// The cue of what keeps all of its light.
pub(crate) const NO_CUE: Cue = [1.0; 2];

/// The factors at two shares of the way.
pub(crate) fn part(cue: Cue, from: f64, to: f64) -> Cue {
    if cue == NO_CUE {
        return NO_CUE;
    }
    [from, to].map(|tau| cue[0] * (1.0 - tau) + cue[1] * tau)
}

/// ∫ f x σ l e^(−∫σ l) dτ and ∫ f σ l e^(−∫σ l) dτ over a part: f is the cue, x the
/// scalar's share of the piece, and `quarters` are the Bernstein coefficients of σ l / 4,
/// whose sum is `depth`.
///
/// The cue raises the degree of the integrand by one, which the rules are exact enough for:
/// of degrees 7, 11, 15, … (with powers of the depth) each is exact for as many as
/// without it.
pub(crate) fn absorbed(
    piece: &Piece,
    cubic: &Cubic,
    quarters: &[f64; 4],
    depth: f64,
    cue: Cue,
) -> [f64; 2] {
    let [a, b, c, _] = *quarters;
    // ∫₀^τ of a cubic is the quartic whose Bernstein coefficients are the partial sums.
    let sums = [0.0, a, a + b, (a + b) + c, depth];
    let share = power(cubic.0.map(|s| piece.shares(s)[0]));
    let extinction = power(quarters.map(|q| 4.0 * q));
    let exponent = quartic_power(sums);
    let (mut high, mut all) = (0.0, 0.0);
    for &(tau, weight) in rule(depth) {
        let factor = cue[0] * (1.0 - tau) + cue[1] * tau;
        let emitted = weight * factor * horner(&extinction, tau) * (-horner(&exponent, tau)).exp();
        high += emitted * horner(&share, tau);
        all += emitted;
    }
    [high, all]
}

/// The same without absorption. Of degree 7, for which four points are exact.
pub(crate) fn emitted(piece: &Piece, cubic: &Cubic, length: f64, cue: Cue) -> [f64; 2] {
    let (mut high, mut all) = (0.0, 0.0);
    for &(tau, weight) in FOUR.iter() {
        let scalar = cubic.at(tau);
        let factor = cue[0] * (1.0 - tau) + cue[1] * tau;
        let emitted = weight * factor * piece.extinction(scalar) * length;
        high += emitted * piece.shares(scalar)[0];
        all += emitted;
    }
    [high, all]
}

/// The greatest product of a color's component, linear in the scalar from `colors[0]` at
/// the piece's low end to `colors[1]` at its high end, and the cue.
///
/// The product is a quartic; where its derivative, a cubic, changes sign is an extreme.
pub(crate) fn greatest(piece: &Piece, cubic: &Cubic, colors: [f64; 2], cue: Cue) -> f64 {
    let color = cubic.0.map(|s| {
        let [x, y] = piece.shares(s);
        colors[0] * y + colors[1] * x
    });
    let ends = (color[0] * cue[0]).max(color[3] * cue[1]);
    // Bernstein coefficients of the product of degrees 3 and 1, without those at the ends.
    let inner = [1, 2, 3].map(|i| {
        let share = i as f64 / 4.0;
        (1.0 - share) * color[i] * cue[0] + share * color[i - 1] * cue[1]
    });
    if inner.iter().all(|b| *b <= ends) {
        return ends;
    }
    let [q1, q2, q3] = inner;
    let (q0, q4) = (color[0] * cue[0], color[3] * cue[1]);
    // A fourth of the derivative.
    let slope = Cubic([q1 - q0, q2 - q1, q3 - q2, q4 - q3]);
    let at = |tau: f64| {
        let factor = cue[0] * (1.0 - tau) + cue[1] * tau;
        Cubic(color).at(tau) * factor
    };
    slope.monotone().fold(ends, |most, part| {
        let tau = part.from + part.place(0.0) * (part.to - part.from);
        most.max(at(tau))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    // Against the greatest of 4097 values: near a maximum those are within 1/2 (2⁻¹³)² of
    // the quartic's second derivative, which is at most 12 times the greatest difference
    // of its coefficients: 12 · 4 / 2 · 2⁻²⁶ = 3.6e-7.
    #[test]
    fn the_greatest_is_what_a_search_finds() {
        let piece = Piece {
            low: 0.0,
            high: 1.0,
            colors: Default::default(),
            extinctions: [1.0; 2],
        };
        let mut inside = 0;
        for i in 0..400u32 {
            let digit = |d: u32| f64::from(i / 4u32.pow(d) % 4) / 3.0;
            let cubic = Cubic([digit(0), digit(1), digit(2), digit(3)]);
            for cue in [[1.0, 0.0], [0.9, 0.3], [0.2, 0.8], [0.5, 0.5]] {
                for colors in [[0.0, 1.0], [1.0, 0.2]] {
                    let got = greatest(&piece, &cubic, colors, cue);
                    let value = |tau: f64| {
                        let s = cubic.at(tau);
                        (colors[0] * (1.0 - s) + colors[1] * s)
                            * (cue[0] * (1.0 - tau) + cue[1] * tau)
                    };
                    let searched = (0..=4096).map(|i| value(f64::from(i) / 4096.0));
                    let searched = searched.fold(0.0, f64::max);
                    assert!(
                        got >= searched - 1e-15 && got <= searched + 3.6e-7,
                        "{cubic:?} {cue:?} {colors:?}: {got} {searched}"
                    );
                    inside += usize::from(searched > value(0.0).max(value(1.0)) + 1e-3);
                }
            }
        }
        assert!(inside > 100, "{inside}");
    }
}
