//! A cubic on [0, 1] in f64, by its Bernstein coefficients.

/// Σ bᵢ Bᵢ³(τ), 0 ≤ τ ≤ 1; between the least and the greatest coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cubic(pub(crate) [f64; 4]);

/// A part of a cubic on which it only rises or only falls, rescaled to [0, 1].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Monotone {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) cubic: Cubic,
}

impl Cubic {
    /// The trilinear interpolant of `corners`, x fastest, on the straight way from `entry` to
    /// `exit`, each in [0, 1]³: means of its polar form, the interpolant with each coordinate
    /// taken from either end.
    pub(crate) fn trilinear(corners: &[f64; 8], entry: [f64; 3], exit: [f64; 3]) -> Cubic {
        if corners.iter().all(|c| *c == corners[0]) {
            return Cubic([corners[0]; 4]);
        }
        let ends = [entry, exit];
        let at = |x: usize, y: usize, z: usize| {
            let rows = [0, 2, 4, 6].map(|i| mix(corners[i], corners[i + 1], ends[x][0]));
            let planes = [0, 2].map(|i| mix(rows[i], rows[i + 1], ends[y][1]));
            mix(planes[0], planes[1], ends[z][2])
        };
        let mean = |a: f64, b: f64, c: f64| {
            let mean = (a + b + c) / 3.0;
            mean.clamp(a.min(b).min(c), a.max(b).max(c))
        };
        Cubic([
            at(0, 0, 0),
            mean(at(1, 0, 0), at(0, 1, 0), at(0, 0, 1)),
            mean(at(1, 1, 0), at(1, 0, 1), at(0, 1, 1)),
            at(1, 1, 1),
        ])
    }

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
        match from <= 0.0 {
            true => before,
            false => before.split((from / to).clamp(0.0, 1.0))[1],
        }
    }

    /// The parts between extremes.
    pub(crate) fn monotone(&self) -> impl Iterator<Item = Monotone> {
        let [b0, b1, b2, b3] = self.0;
        let slopes = [b1 - b0, b2 - b1, b3 - b2];
        let turns = slopes.iter().any(|s| *s < 0.0) && slopes.iter().any(|s| *s > 0.0);
        let extremes = if turns { roots(slopes) } else { [f64::NAN; 2] };
        let mut places = [0.0, 1.0, 1.0, 1.0];
        let mut count = 1;
        for tau in extremes {
            if tau > places[count - 1] && tau < 1.0 {
                places[count] = tau;
                count += 1;
            }
        }
        places[count] = 1.0;
        let cubic = *self;
        (0..count).map(move |i| Monotone {
            from: places[i],
            to: places[i + 1],
            cubic: cubic.part(places[i], places[i + 1]),
        })
    }
}

/// The roots of d0 (1−τ)² + 2 d1 τ(1−τ) + d2 τ², by increasing τ, without cancellation; NaN where
/// there is none. A double root is no extreme.
fn roots([d0, d1, d2]: [f64; 3]) -> [f64; 2] {
    let scale = d0.abs().max(d1.abs()).max(d2.abs());
    let [d0, d1, d2] = [d0 / scale, d1 / scale, d2 / scale];
    let discriminant = d1 * d1 - d0 * d2;
    if discriminant.is_nan() || discriminant <= 0.0 {
        return [f64::NAN; 2];
    }
    let (a, b) = ((d0 - d1) + (d2 - d1), d1 - d0);
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, d0 / q);
    match first < second {
        true => [first, second],
        false => [second, first],
    }
}

impl Monotone {
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.cubic.0[0], self.cubic.0[3]]
    }

    /// Where in the whole the part takes the `value`; its nearer end if it does not.
    ///
    /// Newton's steps while they stay in a bracket, which is halved where they do not.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let [front, back] = self.ends();
        let sign = if front <= back { 1.0 } else { -1.0 };
        let whole = |tau: f64| self.from + tau * (self.to - self.from);
        if sign * (front - value) >= 0.0 {
            return self.from;
        }
        if sign * (back - value) <= 0.0 {
            return self.to;
        }
        let [b0, b1, b2, b3] = self.cubic.0;
        let slopes = [b1 - b0, b2 - b1, b3 - b2].map(|d| 3.0 * sign * d);
        let (mut low, mut high) = (0.0, 1.0);
        let mut tau = ((value - front) / (back - front)).clamp(0.0, 1.0);
        for _ in 0..64 {
            let excess = sign * (self.cubic.at(tau) - value);
            match excess < 0.0 {
                true => low = tau,
                false => high = tau,
            }
            let [d0, d1, d2] = slopes;
            let slope = mix(mix(d0, d1, tau), mix(d1, d2, tau), tau);
            let newton = tau - excess / slope;
            let next = match newton > low && newton < high {
                true => newton,
                false => 0.5 * (low + high),
            };
            let is_there = excess == 0.0 || (next - tau).abs() <= f64::EPSILON;
            if is_there || high - low <= f64::EPSILON {
                break;
            }
            tau = next;
        }
        whole(tau)
    }
}

/// a (1−f) + b f, between a and b however it is rounded.
#[inline]
fn mix(a: f64, b: f64, f: f64) -> f64 {
    let mean = a * (1.0 - f) + b * f;
    mean.max(a.min(b)).min(a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [[f64; 4]; 5] = [
        [0.0, 1.0, 0.0, 1.0],
        [1.0, -1.0, -1.0, 1.0],
        [-1.0, 1.0, -1.0, 1.0],
        [0.0, 0.0, 0.0, 1.0],
        [0.3, 0.9, -0.4, 0.1],
    ];

    // 16 ε of the greatest coefficient, 1, for a dozen roundings.
    #[test]
    fn a_place_takes_its_value() {
        for cubic in SHAPES.map(Cubic) {
            let mut last = 0.0;
            for part in cubic.monotone() {
                assert_eq!(part.from, last);
                last = part.to;
                let [front, back] = part.ends();
                for i in 0..=16 {
                    let f = f64::from(i) / 16.0;
                    let value = front * (1.0 - f) + back * f;
                    let off = (cubic.at(part.place(value)) - value).abs();
                    assert!(off <= 16.0 * f64::EPSILON, "{cubic:?} {value} {off:e}");
                }
            }
            assert_eq!(last, 1.0);
        }
    }

    #[test]
    fn a_trilinear_cell_is_a_cubic_on_a_line() {
        let corners = [1.0, -2.0, 0.5, 4.0, 3.0, 0.25, -1.0, 2.0];
        let (entry, exit) = ([0.1, 0.9, 0.3], [0.8, 0.0, 1.0]);
        let cubic = Cubic::trilinear(&corners, entry, exit);
        for i in 0..=20 {
            let tau = f64::from(i) / 20.0;
            let p = [0, 1, 2].map(|a| entry[a] + tau * (exit[a] - entry[a]));
            let weight = |corner: usize| {
                let factor = |a: usize| match corner >> a & 1 {
                    1 => p[a],
                    _ => 1.0 - p[a],
                };
                factor(0) * factor(1) * factor(2)
            };
            let value: f64 = (0..8).map(|c| corners[c] * weight(c)).sum();
            assert!((cubic.at(tau) - value).abs() < 4e-15, "{tau}");
        }
    }
}
