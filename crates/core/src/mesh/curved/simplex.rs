//! Polynomials of an order on lines, triangles and tetrahedra, by barycentric coordinates.
//!
//! Functions are numbered by α, whole numbers for each corner whose sum is the order p. Lagrange's is 1
//! at the node α/p and 0 at the other nodes; Bernstein's is p!/α! b^α. Where the functions of a line, a
//! triangle or a tetrahedron are zero on a side, they are those of the side on the others.

/// The greatest order.
pub(super) const MOST_ORDER: usize = 6;

/// The functions of an order.
#[derive(Clone, Debug)]
pub(super) struct Simplex {
    pub(super) order: usize,
    /// α of each function: that of the second corner runs fastest, the first has the rest.
    pub(super) indices: Vec<[usize; 4]>,
    /// For each function β of the order below, and each corner k, the number of β + eₖ.
    pub(super) raised: Vec<[usize; 4]>,
}

impl Simplex {
    /// Two corners are a line, three a triangle, four a tetrahedron.
    pub(super) fn new(corners: usize, order: usize) -> Simplex {
        let indices = indices(corners, order);
        let number = |wanted: [usize; 4]| indices.iter().position(|i| *i == wanted);
        let raise = |below: [usize; 4]| {
            std::array::from_fn(|corner| {
                let mut index = below;
                index[corner] += 1;
                number(index).unwrap_or(0) // corners that there are not
            })
        };
        let below = match order {
            0 => Vec::new(),
            _ => self::indices(corners, order - 1),
        };
        Simplex {
            order,
            raised: below.into_iter().map(raise).collect(),
            indices,
        }
    }

    /// Lagrange's functions where the barycentric coordinates are `scaled` by the order: exact at
    /// nodes, where these are whole.
    pub(super) fn lagrange(&self, scaled: [f64; 4]) -> Vec<f64> {
        // Π over m < α of (p b − m) / (m + 1), for each corner.
        let factor = |corner: usize, count: usize| {
            let steps = (0..count).map(|m| (scaled[corner] - m as f64) / (m + 1) as f64);
            steps.product::<f64>()
        };
        let function = |index: &[usize; 4]| (0..4).map(|k| factor(k, index[k])).product();
        self.indices.iter().map(function).collect()
    }

    /// Bernstein's functions, where the barycentric coordinates are `scaled` by the order.
    pub(super) fn bernstein(&self, scaled: [f64; 4]) -> Vec<f64> {
        let factorial = |n: usize| (1..=n).map(|m| m as f64).product::<f64>();
        let b = scaled.map(|b| b / self.order as f64);
        let function = |index: &[usize; 4]| {
            let factors = (0..4).map(|k| b[k].powi(index[k] as i32) / factorial(index[k]));
            factorial(self.order) * factors.product::<f64>()
        };
        self.indices.iter().map(function).collect()
    }

    /// The matrix that makes Bernstein's coefficients of values at nodes: a row for each coefficient.
    pub(super) fn to_bernstein(&self) -> Vec<Vec<f64>> {
        let at_node = |index: &[usize; 4]| self.bernstein(index.map(|i| i as f64));
        inverse(self.indices.iter().map(at_node).collect())
    }
}

/// All α for so many corners and this sum.
fn indices(corners: usize, order: usize) -> Vec<[usize; 4]> {
    let most = |corner: usize, left: usize| if corner < corners { left } else { 0 };
    let mut indices = Vec::new();
    for l in 0..=most(3, order) {
        for k in 0..=most(2, order - l) {
            for j in 0..=order - l - k {
                indices.push([order - l - k - j, j, k, l]);
            }
        }
    }
    indices
}

/// The inverse of a matrix by Gauss and Jordan. Those here are well conditioned: with 84 functions of order 6,
/// a product of both is off the identity by less than 1e-11.
fn inverse(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = matrix.len();
    for (i, row) in matrix.iter_mut().enumerate() {
        row.extend((0..n).map(|j| if i == j { 1.0 } else { 0.0 }));
    }
    for column in 0..n {
        let size = |row: &usize| matrix[*row][column].abs();
        let pivot = (column..n).max_by(|a, b| size(a).total_cmp(&size(b)));
        matrix.swap(column, pivot.expect("there are rows"));
        let divisor = matrix[column][column];
        matrix[column].iter_mut().for_each(|x| *x /= divisor);
        let pivot_row = matrix[column].clone();
        for (i, row) in matrix.iter_mut().enumerate() {
            let factor = row[column];
            if i != column && factor != 0.0 {
                row.iter_mut()
                    .zip(&pivot_row)
                    .for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
    matrix.iter().map(|row| row[n..].to_vec()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bernstein_coefficients_give_back_the_values() {
        for corners in 2..=4 {
            for order in 1..=MOST_ORDER {
                let simplex = Simplex::new(corners, order);
                let matrix = simplex.to_bernstein();
                for (node, index) in simplex.indices.iter().enumerate() {
                    let functions = simplex.bernstein(index.map(|i| i as f64));
                    for other in 0..functions.len() {
                        let terms = functions.iter().zip(&matrix);
                        let value: f64 = terms.map(|(f, row)| f * row[other]).sum();
                        let expected = if node == other { 1.0 } else { 0.0 };
                        assert!(
                            (value - expected).abs() < 1e-11,
                            "{corners} {order} {value}"
                        );
                    }
                }
            }
        }
    }
}
