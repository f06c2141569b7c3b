//! A transfer function in f32, as packets of rays read it.

use tetrascope_core::Appearance;
use tetrascope_core::glam::DVec3;
use tetrascope_f32::knots::{KnotPair, knot_pairs};
use tetrascope_f32::{Normalization, ScalarMap};

use super::field::Field;
use super::pieces::Pieces;

/// Numbers of a [`Row`].
pub(crate) const COLUMNS: usize = 11;

/// A linear stretch between two knots, in terms of the share x of the way from the lower to the
/// upper one: the two mapped scalars, the reciprocal of their difference, extinction at x = 0 and
/// its change up to x = 1, and both of red, green and blue.
pub(crate) type Row = [f32; COLUMNS];

/// Buckets in which the range of the transfer function is looked up.
const BUCKETS: usize = 1024;

/// A transfer function over mapped scalars and lengths in units of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    rows: Vec<Row>,
    /// The last row that begins at or before each bucket of [0, 1].
    buckets: Vec<u32>,
    /// Scalars at which the function jumps, and what a constant there is.
    steps: Vec<(f64, Row)>,
    /// World units in one unit of length, a power of two.
    pub(crate) length: f64,
    /// A sample s is mapped to (s · `half` − `base`) · `unit`; `half` is 1, or 1/2 where the
    /// difference may overflow.
    pub(crate) half: f32,
    pub(crate) base: f32,
    pub(crate) unit: f32,
    /// Which rule integrates the colors.
    pub(crate) rule: &'static Rule,
    /// Whether any row changes in color, so that where its light comes from matters.
    pub(crate) is_colored: bool,
}

/// Nodes of a Gauss-Legendre rule on [0, 1], and for which parts it serves.
#[derive(Debug)]
pub(crate) struct Rule {
    /// Places and weights.
    pub(crate) nodes: &'static [[f32; 2]],
    /// The greatest extinction times length of a part.
    pub(crate) deepest: f32,
    /// How far the weight of the far color may be off.
    error: f64,
}

/// Rules from cheap to exact.
///
/// Errors are measured: the greatest of ∫ x σ l e^(−∫σ l) over 1200 monotone cubics x of all shapes
/// from 0 to 1 or back, for seven extinctions σ linear in x, scaled to this greatest depth.
const RULES: [Rule; 9] = [
    Rule {
        nodes: &THREE,
        deepest: 3.0,
        error: 2.8e-2,
    },
    Rule {
        nodes: &THREE,
        deepest: 1.5,
        error: 9.9e-3,
    },
    Rule {
        nodes: &FOUR,
        deepest: 3.0,
        error: 3.4e-3,
    },
    Rule {
        nodes: &FOUR,
        deepest: 1.0,
        error: 3.2e-4,
    },
    Rule {
        nodes: &SIX,
        deepest: 3.0,
        error: 3.6e-5,
    },
    Rule {
        nodes: &SIX,
        deepest: 2.0,
        error: 9.3e-6,
    },
    Rule {
        nodes: &SIX,
        deepest: 1.0,
        error: 9.8e-7,
    },
    Rule {
        nodes: &EIGHT,
        deepest: 3.0,
        error: 2.2e-7,
    },
    Rule {
        nodes: &EIGHT,
        deepest: 2.0,
        error: 3.6e-8,
    },
];

const THREE: [[f32; 2]; 3] = [
    [0.112_701_66, 0.277_777_8],
    [0.5, 0.444_444_45],
    [0.887_298_35, 0.277_777_8],
];
const FOUR: [[f32; 2]; 4] = [
    [0.069_431_84, 0.173_927_42],
    [0.330_009_5, 0.326_072_57],
    [0.669_990_5, 0.326_072_57],
    [0.930_568_16, 0.173_927_42],
];
const SIX: [[f32; 2]; 6] = [
    [0.033_765_24, 0.085_662_246],
    [0.169_395_3, 0.180_380_79],
    [0.380_690_4, 0.233_956_97],
    [0.619_309_6, 0.233_956_97],
    [0.830_604_7, 0.180_380_79],
    [0.966_234_74, 0.085_662_246],
];
const EIGHT: [[f32; 2]; 8] = [
    [0.019_855_07, 0.050_614_27],
    [0.101_666_76, 0.111_190_52],
    [0.237_233_8, 0.156_853_32],
    [0.408_282_67, 0.181_341_89],
    [0.591_717_3, 0.181_341_89],
    [0.762_766_2, 0.156_853_32],
    [0.898_333_25, 0.111_190_52],
    [0.980_144_9, 0.050_614_27],
];

impl Table {
    pub(crate) fn new(
        appearance: &Appearance,
        pieces: &Pieces,
        field: &Field,
        tolerance: f64,
    ) -> Table {
        let function = &appearance.transfer_function;
        let map = ScalarMap::of(function).in_f32();
        let half = if map.low().abs() > 1e38 { 0.5 } else { 1.0 };
        let spacing = field.grid.spacing().max_element();
        let units = Normalization {
            center: DVec3::ZERO,
            scale: spacing.log2().round().clamp(-1000.0, 1000.0).exp2(),
        };
        let pairs = knot_pairs(function, &map, &units);
        let rows: Vec<Row> = pairs.iter().map(row).collect();
        let buckets = (0..=BUCKETS).map(|bucket| {
            let scalar = bucket as f32 / BUCKETS as f32;
            rows[1..].partition_point(|row| row[0] <= scalar) as u32
        });
        let knots = function.knots().windows(2);
        let steps = knots.filter(|two| two[0].scalar == two[1].scalar);
        let steps = steps.map(|two| {
            let scalar = two[0].scalar;
            let mean = pieces.constant(scalar);
            let [r, g, b] = mean.colors[0].as_vec3().to_array();
            let extinction = units.extinction(mean.extinctions[0]);
            let beyond = 2e30;
            let row = [
                -beyond, beyond, 0.0, extinction, 0.0, r, 0.0, g, 0.0, b, 0.0,
            ];
            (scalar, row)
        });
        let changes = rows
            .iter()
            .map(|row| row[6].abs().max(row[8].abs()).max(row[10].abs()));
        let change = changes.fold(0.0, f32::max);
        let brightest = rows
            .iter()
            .flat_map(|row| [5, 7, 9].map(|column| row[column].max(row[column] + row[column + 1])));
        let brightest = brightest.fold(0.0, f32::max);
        // An error of the far color's weight counts as much as the color changes; under a cue the
        // sum of both weights is by quadrature, too.
        let counts = match appearance.depth_cue {
            None => change.max(f32::MIN_POSITIVE),
            Some(_) => brightest.max(f32::MIN_POSITIVE),
        };
        let allowed = tolerance * f64::from(brightest / counts);
        let rule = RULES.iter().find(|rule| rule.error <= allowed);
        Table {
            buckets: buckets.collect(),
            steps: steps.collect(),
            length: units.scale,
            half,
            base: map.low() as f32 * half,
            unit: map.unit() as f32 / half,
            rule: rule.unwrap_or(&RULES[RULES.len() - 1]),
            is_colored: change > 0.0,
            rows,
        }
    }

    /// The number of the row in which a mapped scalar lies; of a knot, the upper one.
    #[inline(always)]
    pub(crate) fn find(&self, scalar: f32) -> u32 {
        // The cast saturates.
        let bucket = ((scalar * BUCKETS as f32) as usize).min(BUCKETS);
        let mut row = self.buckets[bucket];
        while row > 0 && self.rows[row as usize][0] > scalar {
            row -= 1;
        }
        while self.rows[row as usize][1] <= scalar && row as usize + 1 < self.rows.len() {
            row += 1;
        }
        row
    }

    #[inline(always)]
    pub(crate) fn row(&self, index: u32) -> &Row {
        &self.rows[index as usize]
    }

    /// The row that a constant `sample` on a step has.
    #[inline(always)]
    pub(crate) fn step(&self, sample: f32) -> Option<&Row> {
        let sample = f64::from(sample);
        let found = self.steps.iter().find(|(scalar, _)| *scalar == sample);
        found.map(|(_, row)| row)
    }
}

fn row(pair: &KnotPair) -> Row {
    let [r, g, b, extinction] = pair.at_low;
    let change = |i: usize| pair.at_high[i] - pair.at_low[i];
    [
        pair.low,
        pair.high,
        pair.inverse_width,
        extinction,
        change(3),
        r,
        change(0),
        g,
        change(1),
        b,
        change(2),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value, and the integral from 0, of the cubic with these Bézier ordinates.
    fn cubic([a, b, c, d]: [f64; 4], t: f64) -> (f64, f64) {
        let (u, v) = (1.0 - t, t);
        let value = a * u * u * u + 3.0 * b * u * u * v + 3.0 * c * u * v * v + d * v * v * v;
        // Coefficients of powers of t, integrated.
        let powers = [
            a,
            3.0 * (b - a),
            3.0 * (a - 2.0 * b + c),
            d - 3.0 * c + 3.0 * b - a,
        ];
        let terms = powers.iter().enumerate();
        let integral = terms.map(|(i, p)| p * t.powi(i as i32 + 1) / (i as f64 + 1.0));
        (value, integral.sum())
    }

    /// ∫ x σ l e^(−∫σ l) over a part of the cubic by a rule.
    fn by_rule(
        nodes: &[[f32; 2]],
        shape: [f64; 4],
        [low, high]: [f64; 2],
        from: f64,
        to: f64,
    ) -> f64 {
        let node = |&[u, weight]: &[f32; 2]| {
            let t = from + (to - from) * f64::from(u);
            let (x, sum) = cubic(shape, t);
            let extinction = low + (high - low) * x;
            let depth = low * t + (high - low) * sum;
            f64::from(weight) * (to - from) * x * extinction * (-depth).exp()
        };
        nodes.iter().map(node).sum()
    }

    /// Each rule is as good as it says, and no better by much, on cubics of all shapes.
    #[test]
    fn rules_err_as_they_say() {
        for (i, rule) in RULES.iter().enumerate() {
            let mut worst = 0.0_f64;
            for (p, q) in (0..=10).flat_map(|p| (p..=10).map(move |q| (p, q))) {
                let [p, q] = [p, q].map(|n| f64::from(n) / 10.0);
                for shape in [[0.0, p, q, 1.0], [1.0, q, p, 0.0]] {
                    for ends in [
                        [0.0, 1.0],
                        [1.0, 0.0],
                        [1.0, 1.0],
                        [0.5, 1.0],
                        [1.0, 0.5],
                        [0.1, 1.0],
                        [1.0, 0.1],
                    ] {
                        let ends = ends.map(|end| end * f64::from(rule.deepest));
                        let found = by_rule(rule.nodes, shape, ends, 0.0, 1.0);
                        let exact: f64 = (0..32)
                            .map(|part| {
                                let from = f64::from(part) / 32.0;
                                by_rule(&EIGHT, shape, ends, from, from + 1.0 / 32.0)
                            })
                            .sum();
                        worst = worst.max((found - exact).abs());
                    }
                }
            }
            // Fewer shapes than those of which the errors were measured; nodes in f32 err by 2⁻²⁵.
            println!("rule {i}: {worst:.1e} of {:.1e}", rule.error);
            assert!(worst <= rule.error + 6e-8, "rule {i}: {worst:e}");
            assert!(worst >= rule.error / 10.0, "rule {i}: {worst:e}");
        }
    }
}
