//! Integer least squares by LAMBDA: decorrelation, then a depth-first search.
//!
//! Source: Teunissen (1995), "The least-squares ambiguity decorrelation adjustment"; Chang, Yang
//! and Zhou (2005), "MLAMBDA" (symmetric pivoting only where it lowers the conditional variance,
//! and a shrinking search).

/// Nodes the search may visit before it gives up.
const LARGEST_SEARCH: usize = 10_000;

/// The best integer vectors and their costs.
#[derive(Debug, Clone, PartialEq)]
pub struct IntegerCandidates {
    /// Integer vectors, best first.
    pub integers: Vec<Vec<f64>>,
    /// (a − z)ᵀQ⁻¹(a − z) of each, ascending.
    pub costs: Vec<f64>,
    /// Variances (cycle²) of the decorrelated ambiguities, each given the ones after it.
    pub conditional_variances: Vec<f64>,
}

impl IntegerCandidates {
    /// How probable it is that the best vector is the right one, if the true covariance is
    /// `variance_factor` times the one given: the probability of finding it by rounding one
    /// decorrelated ambiguity after the other, a lower bound (Teunissen 1999, "An optimality
    /// property of the integer least-squares estimator").
    ///
    /// ```
    /// let found = acerra_gnss::integer_least_squares(&[5.2], &[0.01], 2)?;
    /// assert!(found.success_rate(1.0) > 0.999); // half a cycle is five standard deviations
    /// assert!((found.success_rate(25.0) - 0.6827).abs() < 1e-4); // … and one
    /// # Ok::<(), acerra_gnss::LambdaError>(())
    /// ```
    #[must_use]
    pub fn success_rate(&self, variance_factor: f64) -> f64 {
        self.conditional_variances
            .iter()
            .map(|variance| share_within(0.5 / (variance * variance_factor).sqrt()))
            .product()
    }
}

/// Why there is no integer solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LambdaError {
    /// The covariance is not positive definite (or not finite).
    #[error("covariance of the float ambiguities is not positive definite at index {index}")]
    NotPositiveDefinite {
        /// Where the factorisation failed.
        index: usize,
    },
    /// The covariance does not have n² elements.
    #[error("expected a covariance of {expected} elements, found {found}")]
    Shape {
        /// n².
        expected: usize,
        /// Elements given.
        found: usize,
    },
    /// The search visited too many nodes.
    #[error("integer search gave up after {visited} nodes")]
    SearchTooLong {
        /// Nodes visited.
        visited: usize,
    },
}

/// The `count` integer vectors nearest to `float` (length n, cycles) in the metric of
/// `covariance` (n × n row-major, cycle²).
///
/// # Errors
/// See [`LambdaError`].
///
/// ```
/// // Two strongly correlated ambiguities: rounding each alone would give (5, 10).
/// let found = acerra_gnss::integer_least_squares(&[5.4, 10.3], &[0.1, 0.099, 0.099, 0.1], 2)?;
/// assert_eq!(found.integers[0], [5.0, 10.0]);
/// assert!(found.costs[0] <= found.costs[1]);
/// # Ok::<(), acerra_gnss::LambdaError>(())
/// ```
pub fn integer_least_squares(
    float: &[f64],
    covariance: &[f64],
    count: usize,
) -> Result<IntegerCandidates, LambdaError> {
    let n = float.len();
    if covariance.len() != n * n {
        return Err(LambdaError::Shape {
            expected: n * n,
            found: covariance.len(),
        });
    }
    if n == 0 || count == 0 {
        return Ok(IntegerCandidates {
            integers: vec![],
            costs: vec![],
            conditional_variances: vec![],
        });
    }
    // Whole cycles are taken off first: the transformed floats then keep all their digits.
    let whole: Vec<f64> = float.iter().map(|a| a.round()).collect();
    let rest: Vec<f64> = float.iter().zip(&whole).map(|(a, w)| a - w).collect();
    let mut factor = Factor::new(covariance, rest)?;
    factor.reduce();
    let (found, costs) = factor.search(count)?;
    let integers = found
        .iter()
        .map(|z| {
            let mut integers = factor.restore(z);
            integers.iter_mut().zip(&whole).for_each(|(v, w)| *v += w);
            integers
        })
        .collect();
    Ok(IntegerCandidates {
        integers,
        costs,
        conditional_variances: factor.diagonal,
    })
}

/// The share of a normal distribution within `limit` standard deviations of its mean, to 1e-7
/// (Abramowitz and Stegun 1964, 7.1.26).
fn share_within(limit: f64) -> f64 {
    const COEFFICIENTS: [f64; 5] = [
        0.254_829_592,
        -0.284_496_736,
        1.421_413_741,
        -1.453_152_027,
        1.061_405_429,
    ];
    let x = limit / std::f64::consts::SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * x);
    let polynomial = COEFFICIENTS.iter().rev().fold(0.0, |sum, c| (sum + c) * t);
    1.0 - polynomial * (-x * x).exp()
}

/// Nearest whole number to `x`, without a call into the mathematical library: processors without
/// SSE 4.1 have no instruction for it. Of two that are as near, the even one.
fn nearest(x: f64) -> f64 {
    /// 1.5·2⁵²: sums with it have no room for fractions.
    const SHIFT: f64 = 6_755_399_441_055_744.0;
    /// 2⁵¹, up to which they have room for the rest.
    const LARGEST: f64 = 2_251_799_813_685_248.0;
    if x.abs() < LARGEST {
        (x + SHIFT) - SHIFT
    } else {
        x.round_ties_even()
    }
}

/// Q = LᵀDL with unit lower triangular L; the floats after the integer transformation Z so far, and
/// its inverse transpose. Matrices are stored by columns.
struct Factor {
    n: usize,
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    float: Vec<f64>,
    inverse_transposed: Vec<f64>,
}

/// Two columns of n elements at once.
fn columns(matrix: &mut [f64], n: usize, low: usize, high: usize) -> (&mut [f64], &mut [f64]) {
    let (before, after) = matrix.split_at_mut(high * n);
    (&mut before[low * n..(low + 1) * n], &mut after[..n])
}

/// Exchanges variables `a` < `b` of a symmetric matrix of which rows up to `b` hold what is left to
/// factorise, each up to the diagonal.
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
    /// Factorises with the variable of least conditional variance last, then of those before it, and
    /// so on (Chang, Yang and Zhou 2005): few neighbours are left to be exchanged.
    fn new(covariance: &[f64], float: Vec<f64>) -> Result<Self, LambdaError> {
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
    fn reduce(&mut self) {
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
                // Only the pairs beside the two exchanged have changed.
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
    fn restore(&self, z: &[f64]) -> Vec<f64> {
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
    fn search(&self, count: usize) -> Result<(Vec<Vec<f64>>, Vec<f64>), LambdaError> {
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

    fn check(found: &IntegerCandidates, expected: &[(&[f64], f64)]) {
        for (k, (integers, cost)) in expected.iter().enumerate() {
            assert_eq!(found.integers[k], *integers);
            assert!(
                (found.costs[k] - cost).abs() < 1e-4,
                "{} {cost}",
                found.costs[k]
            );
        }
    }

    #[test]
    fn six_ambiguities() {
        let n = 6;
        let mut q = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                q[i * n + j] = match (i, j) {
                    (5, 5) => 0.434_339,
                    (i, j) if i == j => 0.227_134,
                    (5, _) | (_, 5) => 0.103_473,
                    _ => 0.112_202,
                };
            }
        }
        let a = [
            1_585_184.171,
            -6_716_599.430,
            3_915_742.905,
            7_627_233.455,
            9_565_990.879,
            989_457_273.200,
        ];
        let found = integer_least_squares(&a, &q, 2).unwrap();
        let best = [
            1_585_184.0,
            -6_716_599.0,
            3_915_743.0,
            7_627_234.0,
            9_565_991.0,
            989_457_273.0,
        ];
        let mut second = best;
        second[1] = -6_716_600.0;
        second[3] = 7_627_233.0;
        check(&found, &[(&best, 3.507_984), (&second, 3.708_456)]);
    }

    #[test]
    fn ten_ambiguities() {
        let n = 10;
        let mut q = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let (diagonal, off) = match (i < 5, j < 5) {
                    (true, true) => (0.446_320, 0.223_160),
                    (false, false) => (0.735_063, 0.367_531),
                    _ => (0.572_775, 0.286_388),
                };
                q[i * n + j] = if i % 5 == j % 5 { diagonal } else { off };
            }
        }
        let a = [
            -13_324_172.755_747,
            -10_668_894.713_608,
            -7_157_225.010_770,
            -6_149_367.974_367,
            -7_454_133.571_066,
            -5_969_200.494_550,
            8_336_734.058_423,
            6_186_974.084_502,
            -17_549_093.883_655,
            -13_970_158.922_370,
        ];
        let best = [
            -13_324_188.0,
            -10_668_901.0,
            -7_157_236.0,
            -6_149_379.0,
            -7_454_143.0,
            -5_969_220.0,
            8_336_726.0,
            6_186_960.0,
            -17_549_108.0,
            -13_970_171.0,
        ];
        let mut second = best;
        second[1] = -10_668_908.0;
        second[6] = 8_336_717.0;
        let found = integer_least_squares(&a, &q, 2).unwrap();
        check(&found, &[(&best, 1_506.435_789), (&second, 1_612.811_795)]);
    }

    #[test]
    fn indefinite_covariances_are_refused() {
        let refused = integer_least_squares(&[0.1, 0.2], &[1.0, 2.0, 2.0, 1.0], 2);
        assert!(matches!(
            refused,
            Err(LambdaError::NotPositiveDefinite { .. })
        ));
        let refused = integer_least_squares(&[0.1], &[f64::NAN], 2);
        assert!(matches!(
            refused,
            Err(LambdaError::NotPositiveDefinite { .. })
        ));
        let refused = integer_least_squares(&[0.1], &[], 2);
        assert!(matches!(refused, Err(LambdaError::Shape { .. })));
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

    fn cost(q: &[f64], n: usize, difference: &[f64]) -> f64 {
        let q = nalgebra::DMatrix::from_row_slice(n, n, q);
        let d = nalgebra::DVector::from_row_slice(difference);
        d.dot(&q.lu().solve(&d).unwrap())
    }

    fn determinant(columns: &[f64], n: usize) -> f64 {
        nalgebra::DMatrix::from_column_slice(n, n, columns).determinant()
    }

    proptest! {
        #[test]
        fn nothing_within_reach_is_better(
            entries in prop::collection::vec(-0.6..0.6f64, 9),
            float in prop::collection::vec(-0.5..0.5f64, 3),
        ) {
            let n = 3;
            let q = covariance(&entries, n);
            let found = integer_least_squares(&float, &q, 2).unwrap();
            let mut all: Vec<f64> = (0..7usize.pow(3))
                .map(|code| {
                    let z = [code % 7, code / 7 % 7, code / 49].map(|v| v as f64 - 3.0);
                    let d: Vec<f64> = float.iter().zip(z).map(|(a, z)| a - z).collect();
                    cost(&q, n, &d)
                })
                .collect();
            all.sort_by(f64::total_cmp);
            for (k, least) in all.iter().take(2).enumerate() {
                // The search may reach beyond the brute-force cube, never do worse inside it.
                prop_assert!(found.costs[k] <= least * (1.0 + 1e-9) + 1e-9);
                let d: Vec<f64> =
                    float.iter().zip(&found.integers[k]).map(|(a, z)| a - z).collect();
                prop_assert!((cost(&q, n, &d) - found.costs[k]).abs() < 1e-6);
                prop_assert!(found.integers[k].iter().all(|z| z.fract() == 0.0));
            }
        }

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
