//! Decorrelation of ambiguities, and the search of their integers.

use super::error::LambdaError;

/// Nodes the search may visit before it gives up.
const LARGEST_SEARCH: usize = 10_000;

/// Nearest whole number to `x`, without a call into the mathematical library: processors without SSE 4.1 have
/// no instruction for it. Ties go to the even number.
fn nearest(x: f64) -> f64 {
    /// 1.5·2⁵²: sums with this number are rounded to integers.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    /// 2⁵¹, the largest number for which this rounding holds.
    const LARGEST: f64 = 2_251_799_813_685_248.0;
    if x.abs() < LARGEST {
        (x + SHIFT) - SHIFT
    } else {
        x.round_ties_even()
    }
}

/// Q = LᵀDL with unit lower triangular L; the floats after the integer transformation Z so far, and
/// its inverse transpose. Matrices are stored by columns.
pub(crate) struct Factor {
    n: usize,
    lower: Vec<f64>,
    pub(crate) diagonal: Vec<f64>,
    float: Vec<f64>,
    inverse_transposed: Vec<f64>,
}

/// Two columns of n elements at once.
fn columns(matrix: &mut [f64], n: usize, low: usize, high: usize) -> (&mut [f64], &mut [f64]) {
    let (before, after) = matrix.split_at_mut(high * n);
    (&mut before[low * n..(low + 1) * n], &mut after[..n])
}

/// Exchanges variables `a` < `b` of a symmetric matrix whose rows up to `b` are still to be factorised, each
/// up to the diagonal.
fn exchange(lower_rows: &mut [f64], n: usize, a: usize, b: usize) {
    for k in 0..a {
        lower_rows.swap(a * n + k, b * n + k);
    }
    for k in a + 1..b {
        lower_rows.swap(k * n + a, b * n + k);
    }
    lower_rows.swap(a * n + a, b * n + b);
}

impl Factor {
    /// Factorises with the variable of least conditional variance last, then of the remaining ones, and so on
    /// (Chang, Yang and Zhou 2005): few neighbours remain to be exchanged.
    pub(crate) fn new(covariance: &[f64], float: Vec<f64>) -> Result<Self, LambdaError> {
        let n = float.len();
        let mut work = covariance.to_vec();
        let mut lower = vec![0.0; n * n];
        let mut diagonal = vec![0.0; n];
        let mut row = vec![0.0; n];
        let mut order: Vec<usize> = (0..n).collect();
        for i in (0..n).rev() {
            let least = (0..=i).min_by(|a, b| work[a * n + a].total_cmp(&work[b * n + b]));
            if let Some(pivot) = least.filter(|&pivot| pivot != i) {
                exchange(&mut work, n, pivot, i);
                order.swap(pivot, i);
                // Rows of L below that are known already.
                let (a, b) = columns(&mut lower, n, pivot, i);
                a[i + 1..].swap_with_slice(&mut b[i + 1..]);
            }
            let d = work[i * n + i];
            if d.is_nan() || d <= 0.0 || d.is_infinite() {
                return Err(LambdaError::NotPositiveDefinite { index: order[i] });
            }
            diagonal[i] = d;
            let own = &work[i * n..(i + 1) * n];
            for (j, (element, w)) in row.iter_mut().zip(own).enumerate().take(i + 1) {
                *element = w / d;
                lower[j * n + i] = *element;
            }
            for (j, line) in work.chunks_exact_mut(n).enumerate().take(i) {
                let factor = row[j] * d;
                for (w, element) in line.iter_mut().zip(&row).take(j + 1) {
                    *w -= factor * element;
                }
            }
        }
        let mut permutation = vec![0.0; n * n];
        for (column, &row) in order.iter().enumerate() {
            permutation[column * n + row] = 1.0;
        }
        Ok(Self {
            n,
            lower,
            diagonal,
            inverse_transposed: permutation,
            float: order.iter().map(|&k| float[k]).collect(),
        })
    }

    /// Element (row, column) of L.
    fn l(&self, row: usize, column: usize) -> f64 {
        self.lower[column * self.n + row]
    }

    /// Subtracts the nearest integer multiple of column `i` from column `j` (i > j).
    fn reduce_column(&mut self, i: usize, j: usize) {
        let n = self.n;
        let mu = nearest(self.l(i, j));
        if mu == 0.0 {
            return;
        }
        let (target, source) = columns(&mut self.lower, n, j, i);
        for (t, s) in target[i..].iter_mut().zip(&source[i..]) {
            *t -= mu * s;
        }
        self.float[j] -= mu * self.float[i];
        let (source, target) = columns(&mut self.inverse_transposed, n, j, i);
        for (t, s) in target.iter_mut().zip(source) {
            *t += mu * *s;
        }
    }

    /// Exchanges variables j and j + 1; `delta` is the conditional variance this gives j + 1.
    fn swap(&mut self, j: usize, delta: f64) {
        let n = self.n;
        let l = self.l(j + 1, j);
        let eta = self.diagonal[j] / delta;
        let xi = self.diagonal[j + 1] * l / delta;
        self.diagonal[j] = eta * self.diagonal[j + 1];
        self.diagonal[j + 1] = delta;
        for column in self.lower.chunks_exact_mut(n).take(j) {
            if let [a, b] = &mut column[j..j + 2] {
                (*a, *b) = (*b - l * *a, eta * *a + xi * *b);
            }
        }
        self.lower[j * n + j + 1] = xi;
        let (a, b) = columns(&mut self.lower, n, j, j + 1);
        a[j + 2..].swap_with_slice(&mut b[j + 2..]);
        self.float.swap(j, j + 1);
        let (a, b) = columns(&mut self.inverse_transposed, n, j, j + 1);
        a.swap_with_slice(b);
    }

    /// Lowers the conditional variances by exchanging neighbours, then reduces the off-diagonals.
    ///
    /// Whether an exchange lowers a variance depends on the element between the two neighbours
    /// alone, up to a whole number; the others are left for the end.
    pub(crate) fn reduce(&mut self) {
        let n = self.n;
        if n < 2 {
            return;
        }
        let mut j = n - 2;
        loop {
            let l = self.l(j + 1, j);
            let l = l - nearest(l);
            let delta = self.diagonal[j] + l * l * self.diagonal[j + 1];
            if delta + 1e-6 < self.diagonal[j + 1] {
                self.reduce_column(j + 1, j);
                self.swap(j, delta);
                // Only the pairs next to the two exchanged have changed.
                j = (j + 1).min(n - 2);
            } else if j == 0 {
                break;
            } else {
                j -= 1;
            }
        }
        for j in (0..n - 1).rev() {
            for i in j + 1..n {
                self.reduce_column(i, j);
            }
        }
    }

    /// Z⁻ᵀz.
    pub(crate) fn restore(&self, z: &[f64]) -> Vec<f64> {
        let mut a = vec![0.0; self.n];
        for (column, &value) in self.inverse_transposed.chunks_exact(self.n).zip(z) {
            for (a, c) in a.iter_mut().zip(column) {
                *a += c * value;
            }
        }
        a
    }

    /// Depth-first search from the last variable to the first, each level walking outwards from
    /// its conditional mean, inside an ellipsoid that shrinks with every candidate found.
    #[allow(clippy::type_complexity)]
    pub(crate) fn search(&self, count: usize) -> Result<(Vec<Vec<f64>>, Vec<f64>), LambdaError> {
        let n = self.n;
        let center = &self.float;
        let mut found: Vec<(f64, Vec<f64>)> = Vec::with_capacity(count + 1);
        let mut bound = f64::INFINITY;
        let mut room = vec![0.0; 5 * n];
        let (mean, rest) = room.split_at_mut(n);
        let (offset, rest) = rest.split_at_mut(n); // z − mean, of the levels above
        let (z, rest) = rest.split_at_mut(n);
        let (step, cost_above) = rest.split_at_mut(n);
        let outwards = |from: f64| if from <= 0.0 { -1.0 } else { 1.0 };

        let mut k = n - 1;
        mean[k] = center[k];
        z[k] = nearest(mean[k]);
        step[k] = outwards(mean[k] - z[k]);
        for _ in 0..LARGEST_SEARCH {
            offset[k] = z[k] - mean[k];
            let cost = cost_above[k] + offset[k] * offset[k] / self.diagonal[k];
            if cost < bound {
                if k > 0 {
                    k -= 1;
                    cost_above[k] = cost;
                    let column = &self.lower[k * n..(k + 1) * n];
                    let pull: f64 = column[k + 1..]
                        .iter()
                        .zip(&offset[k + 1..])
                        .map(|(l, o)| l * o)
                        .sum();
                    mean[k] = center[k] + pull;
                    z[k] = nearest(mean[k]);
                    step[k] = outwards(mean[k] - z[k]);
                    continue;
                }
                let place = found.partition_point(|(c, _)| *c <= cost);
                found.insert(place, (cost, z.to_vec()));
                found.truncate(count);
                if found.len() == count {
                    bound = found[count - 1].0;
                }
            } else if k == n - 1 {
                let (costs, integers) = found.into_iter().unzip();
                return Ok((integers, costs));
            } else {
                k += 1;
            }
            z[k] += step[k];
            step[k] = -step[k] - outwards(step[k]);
        }
        Err(LambdaError::SearchTooLong {
            visited: LARGEST_SEARCH,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nearest_whole_numbers() {
        let many = (-400..400).map(|k| f64::from(k) * 0.37);
        for x in many.chain([-0.0, 1e15 + 0.5, -1e15 - 0.5, 1e17, -1e300, f64::INFINITY]) {
            assert_eq!(nearest(x), x.round_ties_even(), "{x}");
        }
        assert!(nearest(f64::NAN).is_nan());
    }

    /// Q = AAᵀ + 0.01·I, strongly correlated when A is.
    fn covariance(entries: &[f64], n: usize) -> Vec<f64> {
        let mut q = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                q[i * n + j] = (0..n)
                    .map(|k| entries[i * n + k] * entries[j * n + k])
                    .sum::<f64>();
            }
            q[i * n + i] += 0.01;
        }
        q
    }

    fn determinant(columns: &[f64], n: usize) -> f64 {
        nalgebra::DMatrix::from_column_slice(n, n, columns).determinant()
    }

    proptest! {
        #[test]
        fn the_transformation_keeps_volume(
            entries in prop::collection::vec(-1.0..1.0f64, 36),
        ) {
            let q = covariance(&entries, 6);
            let a: Vec<f64> = (0..6).map(f64::from).collect();
            let mut factor = Factor::new(&q, a.clone()).unwrap();
            let before: f64 = factor.diagonal.iter().product();
            factor.reduce();
            let after: f64 = factor.diagonal.iter().product();
            prop_assert!((before / after - 1.0).abs() < 1e-6);
            prop_assert!((determinant(&factor.inverse_transposed, 6).abs() - 1.0).abs() < 1e-6);
            prop_assert_eq!(factor.restore(&factor.float), a);
        }
    }
}
