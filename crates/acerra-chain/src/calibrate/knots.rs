//! Normal equations of unknowns at knots, east, north and up each, in which only neighbouring knots are
//! coupled: a block-tridiagonal matrix, solved in a time that grows with the number of knots.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A symmetric, positive definite, block-tridiagonal matrix.
#[derive(Clone, Debug)]
pub(super) struct Knots {
    /// Blocks on the diagonal.
    own: Vec<Matrix3<f64>>,
    /// Blocks of each knot (rows) with the one after it (columns).
    off_diagonal: Vec<Matrix3<f64>>,
}

impl Knots {
    /// No coupling yet between so many knots.
    pub fn new(count: usize) -> Self {
        Self {
            own: vec![Matrix3::zeros(); count],
            off_diagonal: vec![Matrix3::zeros(); count.saturating_sub(1)],
        }
    }

    /// Adds to the coupling of two unknowns of the same or of neighbouring knots. On the diagonal blocks the
    /// symmetric element needs its own call; off the diagonal this call adds it.
    pub fn add(&mut self, a: usize, b: usize, value: f64) {
        if a / 3 == b / 3 {
            self.own[a / 3][(a % 3, b % 3)] += value;
        } else if a < b {
            self.off_diagonal[a / 3][(a % 3, b % 3)] += value;
        }
    }

    /// The matrix factorised by elimination from the first knot to the last.
    pub fn factorised(&self) -> Factorised<'_> {
        let mut inverse: Vec<Matrix3<f64>> = Vec::with_capacity(self.own.len());
        for (k, own) in self.own.iter().enumerate() {
            let left = match k.checked_sub(1) {
                Some(before) => {
                    let off_diagonal = &self.off_diagonal[before];
                    own - off_diagonal.transpose() * inverse[before] * off_diagonal
                }
                None => *own,
            };
            inverse.push(left.try_inverse().unwrap_or_else(Matrix3::zeros));
        }
        Factorised {
            matrix: self,
            inverse,
        }
    }
}

/// A factorised matrix.
#[derive(Clone, Debug)]
pub(super) struct Factorised<'a> {
    matrix: &'a Knots,
    /// Inverses of the blocks left on the diagonal.
    inverse: Vec<Matrix3<f64>>,
}

impl Factorised<'_> {
    /// The solution for one right-hand side.
    pub fn solve(&self, right: &DVector<f64>) -> DVector<f64> {
        let count = self.inverse.len();
        let at = |k: usize| Vector3::new(right[3 * k], right[3 * k + 1], right[3 * k + 2]);
        let mut reduced: Vec<Vector3<f64>> = Vec::with_capacity(count);
        for k in 0..count {
            let carried = match k.checked_sub(1) {
                Some(before) => {
                    let off_diagonal = &self.matrix.off_diagonal[before];
                    off_diagonal.transpose() * self.inverse[before] * reduced[before]
                }
                None => Vector3::zeros(),
            };
            reduced.push(at(k) - carried);
        }
        let mut solution = DVector::zeros(3 * count);
        let mut after = Vector3::zeros();
        for k in (0..count).rev() {
            let coupled = match self.matrix.off_diagonal.get(k) {
                Some(off_diagonal) => off_diagonal * after,
                None => Vector3::zeros(),
            };
            after = self.inverse[k] * (reduced[k] - coupled);
            (0..3).for_each(|i| solution[3 * k + i] = after[i]);
        }
        solution
    }

    /// The solutions for the columns of a matrix.
    pub fn solve_columns(&self, right: &DMatrix<f64>) -> DMatrix<f64> {
        let columns: Vec<DVector<f64>> = right
            .column_iter()
            .map(|column| self.solve(&column.into_owned()))
            .collect();
        DMatrix::from_fn(right.nrows(), right.ncols(), |i, j| columns[j][i])
    }

    /// Trace of the inverse times another matrix of this structure: the number of unknowns that the data of
    /// the other matrix determine. Only the blocks of the inverse that overlap with the other matrix are
    /// formed (Takahashi's equations).
    pub fn trace_of_inverse_times(&self, other: &Knots) -> f64 {
        let mut trace = 0.0;
        let mut after = Matrix3::zeros();
        for k in (0..self.inverse.len()).rev() {
            let own = self.inverse[k];
            let mut inverse = own;
            if let (Some(off_diagonal), Some(data)) =
                (self.matrix.off_diagonal.get(k), other.off_diagonal.get(k))
            {
                let across = -own * off_diagonal * after;
                inverse -= across * off_diagonal.transpose() * own;
                trace += 2.0 * across.component_mul(data).sum();
            }
            trace += inverse.component_mul(&other.own[k]).sum();
            after = inverse;
        }
        trace
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot go on has failed
mod tests {
    use super::*;

    /// Four knots, with numbers of no symmetry between their axes.
    fn example() -> (Knots, DMatrix<f64>) {
        let mut knots = Knots::new(4);
        let mut dense = DMatrix::zeros(12, 12);
        for a in 0..12_usize {
            for b in 0..12_usize {
                let value = match a.abs_diff(b) {
                    _ if (a / 3).abs_diff(b / 3) > 1 => continue,
                    0 => 9.0 + a as f64,
                    _ => ((a + b) as f64 * 0.7 + (a * b) as f64).sin(),
                };
                knots.add(a, b, value);
                dense[(a, b)] = value;
            }
        }
        (knots, dense)
    }

    #[test]
    fn solutions_and_traces_are_those_of_the_dense_matrix() {
        let (knots, dense) = example();
        let inverse = dense.clone().try_inverse().unwrap();
        let factorised = knots.factorised();
        let right = DMatrix::from_fn(12, 2, |i, j| (i as f64 - 3.0 * j as f64).cos());
        let wrong = factorised.solve_columns(&right) - &inverse * &right;
        assert!(wrong.amax() < 1e-12, "{wrong}");
        // Another matrix with the same blocks.
        let (mut other, mut other_dense) = example();
        other.add(4, 4, 2.5);
        other_dense[(4, 4)] += 2.5;
        let trace = (&inverse * &other_dense).trace();
        assert!((factorised.trace_of_inverse_times(&other) - trace).abs() < 1e-10);
    }

    #[test]
    fn no_knots_have_no_solution_to_give() {
        let none = Knots::new(0);
        assert_eq!(none.factorised().solve(&DVector::zeros(0)).len(), 0);
        assert_eq!(none.factorised().trace_of_inverse_times(&none), 0.0);
    }
}
