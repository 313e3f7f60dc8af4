//! A measurement equation with few non-zero coefficients.

/// Largest number of coefficients of an equation: a position, two biases, and the bias between channels.
const LARGEST: usize = 6;

/// A measurement equation with few non-zero coefficients.
#[derive(Debug, Clone)]
pub(crate) struct SparseRow {
    coefficients: [(usize, f64); LARGEST],
    count: usize,
    pub residual: f64,
}

impl SparseRow {
    /// An equation with the given coefficients, at most six.
    pub(crate) fn new(coefficients: &[(usize, f64)], residual: f64) -> Self {
        let mut row = Self {
            coefficients: [(0, 0.0); LARGEST],
            count: 0,
            residual,
        };
        for &(index, value) in coefficients {
            row.push(index, value);
        }
        row
    }

    /// Adds a coefficient.
    pub(crate) fn push(&mut self, index: usize, value: f64) {
        self.coefficients[self.count] = (index, value);
        self.count += 1;
    }

    /// States and their coefficients.
    pub(crate) fn coefficients(&self) -> &[(usize, f64)] {
        &self.coefficients[..self.count]
    }
}
