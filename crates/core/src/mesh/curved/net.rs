//! A cell's function as Bernstein's coefficients, and those of its derivatives.
//!
//! Coefficients are between the least and the greatest value of no function other than theirs: a convex
//! set that holds the coefficients holds all values of the function (G. Farin, "Curves and Surfaces for
//! CAGD", 2002, 4.3). So their greatest length bounds it.

use glam::DVec3;

use super::shapes::Factor;

/// Coefficients in the full set's order: the first factor runs fastest.
pub(super) struct Net<'a> {
    factors: &'a [Factor],
    /// How many functions each factor has now, and how often it was derived.
    sizes: [(usize, usize); 3],
    coefficients: Vec<DVec3>,
}

impl<'a> Net<'a> {
    pub(super) fn new(factors: &'a [Factor], coefficients: Vec<DVec3>) -> Net<'a> {
        let mut sizes = [(1, 0); 3];
        for (size, factor) in sizes.iter_mut().zip(factors) {
            *size = (factor.simplex.indices.len(), 0);
        }
        Net {
            factors,
            sizes,
            coefficients,
        }
    }

    /// The net of values at the nodes of Lagrange's functions.
    pub(super) fn of_values(factors: &'a [Factor], values: Vec<DVec3>) -> Net<'a> {
        let mut net = Net::new(factors, values);
        for (number, factor) in factors.iter().enumerate() {
            let matrix = &factor.to_bernstein;
            net.coefficients = net.along(number, matrix.len(), |row, value| {
                let terms = matrix[row].iter().enumerate();
                terms.map(|(node, weight)| value(node) * *weight).sum()
            });
        }
        net
    }

    /// The derivative by a factor's coordinates along `direction`, barycentric with the sum 0. Of functions
    /// that are constant there is no coefficient left.
    pub(super) fn derivative(&self, number: usize, direction: [f64; 4]) -> Net<'a> {
        let factor = &self.factors[number];
        let (_, times) = self.sizes[number];
        let simplex = match times {
            0 => &factor.simplex,
            _ => &factor.below,
        };
        let (order, raised) = (simplex.order as f64, &simplex.raised);
        let coefficients = self.along(number, raised.len(), |below, value| {
            let corners = raised[below]
                .iter()
                .zip(direction)
                .filter(|(_, c)| *c != 0.0);
            corners.map(|(&at, c)| value(at) * (c * order)).sum()
        });
        let mut sizes = self.sizes;
        sizes[number] = (raised.len(), times + 1);
        Net {
            factors: self.factors,
            sizes,
            coefficients,
        }
    }

    /// The greatest length of a coefficient; NaN if one is.
    pub(super) fn greatest(&self) -> f64 {
        greatest(self.coefficients.iter().copied())
    }

    /// Coefficients of which each is made of those that differ from it in a factor alone.
    fn along(
        &self,
        number: usize,
        count: usize,
        make: impl Fn(usize, &dyn Fn(usize) -> DVec3) -> DVec3,
    ) -> Vec<DVec3> {
        let size = self.sizes[number].0;
        let inner: usize = self.sizes[..number].iter().map(|(size, _)| size).product();
        let outer: usize = self.sizes[number + 1..]
            .iter()
            .map(|(size, _)| size)
            .product();
        let mut made = Vec::with_capacity(inner * count * outer);
        for o in 0..outer {
            for row in 0..count {
                for i in 0..inner {
                    let value = |at: usize| self.coefficients[i + inner * (at + size * o)];
                    made.push(make(row, &value));
                }
            }
        }
        made
    }
}

/// The greatest length; NaN if one is.
pub(super) fn greatest(vectors: impl IntoIterator<Item = DVec3>) -> f64 {
    let lengths = vectors.into_iter().map(DVec3::length);
    lengths.fold(0.0, |most, length| match length > most || length.is_nan() {
        true => length,
        false => most,
    })
}
