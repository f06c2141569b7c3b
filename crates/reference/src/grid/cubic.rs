//! A cubic on [0, 1] by its Bernstein coefficients, and where it is monotone.

/// Σ bᵢ Bᵢ³(τ), 0 ≤ τ ≤ 1, with the Bernstein polynomials B.
///
/// The curve stays between the least and the greatest coefficient, so what is made by
/// convex combinations of samples never leaves their range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

/// A part of a cubic, rescaled to [0, 1], on which it only rises or only falls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Monotone {
    /// Where the part begins and ends in the whole.
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) cubic: Cubic,
}

impl Cubic {
    /// The trilinear interpolant of `corners` (x fastest) on the straight way from
    /// `entry` to `exit`, each in [0, 1]³.
    ///
    /// Its polar form is the interpolant with each coordinate taken from either end; the
    /// coefficients are its means over one and two exits.
    pub(crate) fn trilinear(corners: &[f64; 8], entry: [f64; 3], exit: [f64; 3]) -> Cubic {
        if corners.iter().all(|c| *c == corners[0]) {
            return Cubic([corners[0]; 4]);
        }
        let ends = |axis: usize| [entry[axis], exit[axis]];
        // along_x[e][yz], along_y[e_x + 2 e_y][z]
        let along_x =
            ends(0).map(|f| [0, 1, 2, 3].map(|yz| mix(corners[2 * yz], corners[2 * yz + 1], f)));
        let y = ends(1);
        let along_y = [0, 1, 2, 3].map(|e| {
            let row = along_x[e & 1];
            [0, 1].map(|z| mix(row[2 * z], row[2 * z + 1], y[e >> 1]))
        });
        let z = ends(2);
        let at = |e: usize| mix(along_y[e & 3][0], along_y[e & 3][1], z[e >> 2]);
        let mean = |a: f64, b: f64, c: f64| {
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            ((a + b + c) / 3.0).clamp(low, high)
        };
        Cubic([
            at(0),
            mean(at(1), at(2), at(4)),
            mean(at(3), at(5), at(6)),
            at(7),
        ])
    }

    /// The value at `tau`.
    pub(crate) fn at(&self, tau: f64) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|i| mix(self.0[i], self.0[i + 1], tau));
        mix(mix(a, b, tau), mix(b, c, tau), tau)
    }

    /// The parts before and after `tau` (de Casteljau).
    pub(crate) fn split(&self, tau: f64) -> [Cubic; 2] {
        let [b0, b1, b2, b3] = self.0;
        let [a, b, c] = [mix(b0, b1, tau), mix(b1, b2, tau), mix(b2, b3, tau)];
        let [d, e] = [mix(a, b, tau), mix(b, c, tau)];
        let middle = mix(d, e, tau);
        [Cubic([b0, a, d, middle]), Cubic([middle, e, c, b3])]
    }

    /// The part between two places.
    pub(crate) fn part(&self, from: f64, to: f64) -> Cubic {
        let before = if to < 1.0 { self.split(to)[0] } else { *self };
        if from <= 0.0 {
            return before;
        }
        before.split((from / to).clamp(0.0, 1.0))[1]
    }

    /// The parts between extremes, at most three; `Err` if the cubic is constant.
    ///
    /// An extreme that rounding hides or invents lies where the cubic is level to
    /// rounding, and so does as little harm as rounding.
    pub(crate) fn monotone(&self) -> Monotones {
        let [b0, b1, b2, b3] = self.0;
        let mut places = [0.0, 1.0, 1.0, 1.0];
        let rising = b0 <= b1 && b1 <= b2 && b2 <= b3;
        let falling = b0 >= b1 && b1 >= b2 && b2 >= b3;
        let mut count = 1;
        if !(rising || falling) {
            // A third of the derivative: d0 (1−τ)² + 2 d1 τ(1−τ) + d2 τ².
            for tau in roots([b1 - b0, b2 - b1, b3 - b2]) {
                if tau > places[count - 1] && tau < 1.0 {
                    places[count] = tau;
                    count += 1;
                }
            }
        }
        places[count] = 1.0;
        Monotones {
            cubic: *self,
            places,
            count,
            next: 0,
        }
    }
}

/// The roots of d0 (1−τ)² + 2 d1 τ(1−τ) + d2 τ², by increasing τ; NaN where there is none.
///
/// In power form a τ² + 2 b τ + c with a = d0 − 2 d1 + d2, b = d1 − d0, c = d0, whose
/// discriminant is b² − a c = d1² − d0 d2; roots without cancellation, q/a and c/q.
fn roots([d0, d1, d2]: [f64; 3]) -> [f64; 2] {
    // Powers of two do not round; the greatest becomes about 1, so that no square overflows.
    let scale = d0.abs().max(d1.abs()).max(d2.abs());
    let [d0, d1, d2] = [d0 / scale, d1 / scale, d2 / scale];
    let discriminant = d1 * d1 - d0 * d2;
    if discriminant.is_nan() || discriminant <= 0.0 {
        // A double root is no extreme.
        return [f64::NAN; 2];
    }
    let (a, b) = ((d0 - d1) + (d2 - d1), d1 - d0);
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, d0 / q);
    if first < second {
        [first, second]
    } else {
        [second, first]
    }
}

/// The monotone stretches that [`Cubic::monotone`] gives.
#[derive(Clone, Debug)]
pub(crate) struct Monotones {
    cubic: Cubic,
    places: [f64; 4],
    count: usize,
    next: usize,
}

impl Iterator for Monotones {
    type Item = Monotone;

    fn next(&mut self) -> Option<Monotone> {
        if self.next == self.count {
            return None;
        }
        let (from, to) = (self.places[self.next], self.places[self.next + 1]);
        self.next += 1;
        Some(Monotone {
            from,
            to,
            cubic: self.cubic.part(from, to),
        })
    }
}

impl Monotone {
    /// The values at both ends.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.cubic.0[0], self.cubic.0[3]]
    }

    /// Where in [0, 1] the part takes the `value`; the nearer end if it does not.
    ///
    /// Bisection, hastened by Newton's steps where they stay in the bracket.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let [front, back] = self.ends();
        let sign = if front <= back { 1.0 } else { -1.0 };
        let excess = |tau: f64| sign * (self.cubic.at(tau) - value);
        let (mut low, mut high) = (0.0, 1.0);
        if sign * (front - value) >= 0.0 {
            return low;
        }
        if sign * (back - value) <= 0.0 {
            return high;
        }
        let [b0, b1, b2, b3] = self.cubic.0;
        let slopes = [b1 - b0, b2 - b1, b3 - b2].map(|d| 3.0 * sign * d);
        let mut tau = ((value - front) / (back - front)).clamp(0.0, 1.0);
        // 53 halvings reach the last bit; Newton's steps are usually done after six.
        for _ in 0..64 {
            let here = excess(tau);
            if here == 0.0 {
                return tau;
            }
            if here < 0.0 {
                low = tau;
            } else {
                high = tau;
            }
            let [d0, d1, d2] = slopes;
            let slope = mix(mix(d0, d1, tau), mix(d1, d2, tau), tau);
            let newton = tau - here / slope;
            // The bracket's middle where the step leaves it or would go on for long.
            let next = if newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            if (next - tau).abs() <= f64::EPSILON || high - low <= f64::EPSILON {
                return next;
            }
            tau = next;
        }
        0.5 * (low + high)
    }
}

/// a (1−f) + b f, between a and b however it is rounded.
#[inline]
fn mix(a: f64, b: f64, f: f64) -> f64 {
    let mean = a * (1.0 - f) + b * f;
    let (low, high) = if a < b { (a, b) } else { (b, a) };
    if mean < low {
        low
    } else if mean > high {
        high
    } else {
        mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few hundred cubics, among them those with double and triple roots.
    fn cubics() -> Vec<Cubic> {
        let mut all = vec![
            Cubic([0.0, 0.0, 0.0, 1.0]),
            Cubic([0.0, 1.0, 0.0, 1.0]),
            Cubic([1.0, -1.0, -1.0, 1.0]), // touches −0.5 at the middle
            Cubic([-1.0, 1.0, -1.0, 1.0]), // level at the middle
            Cubic([0.0, 1e-300, 3e-300, 2e-300]),
            Cubic([1e300, -1e300, 1e300, 0.0]),
        ];
        let mut state = 7u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        all.extend((0..300).map(|_| Cubic([random(), random(), random(), random()])));
        all
    }

    // Between 33 places of each part the values never turn back by more than rounding,
    // 8 ε of the greatest coefficient.
    #[test]
    fn parts_are_monotone_and_join() {
        for cubic in cubics() {
            let size = cubic.0.iter().fold(0.0f64, |m, b| m.max(b.abs()));
            let mut last = 0.0;
            for part in cubic.monotone() {
                assert_eq!(part.from, last);
                last = part.to;
                let [front, back] = part.ends();
                let sign = if front <= back { 1.0 } else { -1.0 };
                let values = (0..=32).map(|i| part.cubic.at(f64::from(i) / 32.0));
                let values: Vec<f64> = values.collect();
                for pair in values.windows(2) {
                    assert!(
                        sign * (pair[1] - pair[0]) >= -8.0 * f64::EPSILON * size,
                        "{cubic:?}"
                    );
                }
                for i in 0..=8 {
                    let tau = f64::from(i) / 8.0;
                    let whole = cubic.at(part.from + tau * (part.to - part.from));
                    assert!((part.cubic.at(tau) - whole).abs() <= 16.0 * f64::EPSILON * size);
                }
            }
            assert_eq!(last, 1.0);
        }
    }

    // What is found takes the value to rounding, 16 ε of the greatest coefficient.
    #[test]
    fn a_place_takes_its_value() {
        for cubic in cubics() {
            let size = cubic.0.iter().fold(0.0f64, |m, b| m.max(b.abs()));
            for part in cubic.monotone() {
                let [front, back] = part.ends();
                for i in 0..=16 {
                    let f = f64::from(i) / 16.0;
                    let value = front * (1.0 - f) + back * f;
                    let tau = part.place(value);
                    let off = (part.cubic.at(tau) - value).abs();
                    assert!(
                        off <= 16.0 * f64::EPSILON * size,
                        "{cubic:?} {value} {off:e}"
                    );
                }
                let (low, high) = (front.min(back), front.max(back));
                let beyond = [part.place(low - size), part.place(high + size)];
                assert!(beyond.iter().all(|tau| *tau == 0.0 || *tau == 1.0));
            }
        }
    }

    // Against the interpolant itself, along a diagonal way.
    #[test]
    fn a_trilinear_cell_is_a_cubic_on_a_line() {
        let corners = [1.0, -2.0, 0.5, 4.0, 3.0, 0.25, -1.0, 2.0];
        let (entry, exit) = ([0.1, 0.9, 0.3], [0.8, 0.0, 1.0]);
        let cubic = Cubic::trilinear(&corners, entry, exit);
        for i in 0..=20 {
            let tau = f64::from(i) / 20.0;
            let p = [0, 1, 2].map(|a| entry[a] + tau * (exit[a] - entry[a]));
            let mut value = 0.0;
            for (corner, sample) in corners.iter().enumerate() {
                let weight = |axis: usize| match corner >> axis & 1 {
                    1 => p[axis],
                    _ => 1.0 - p[axis],
                };
                value += sample * weight(0) * weight(1) * weight(2);
            }
            assert!((cubic.at(tau) - value).abs() < 4e-15, "{tau}");
        }
        let constant = Cubic::trilinear(&[0.3; 8], entry, exit);
        assert_eq!(constant, Cubic([0.3; 4]));
    }
}
