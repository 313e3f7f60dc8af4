//! Integer least squares by LAMBDA: decorrelation, then a depth-first search.
//!
//! Source: Teunissen (1995), "The least-squares ambiguity decorrelation adjustment"; Chang, Yang
//! and Zhou (2005), "MLAMBDA" (symmetric pivoting only where it lowers the conditional variance,
//! and a shrinking search).

mod error;
mod factor;

pub use error::LambdaError;
use factor::Factor;

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
    /// Probability that the best vector is the right one, if the true covariance is `variance_factor` times
    /// the given covariance: the probability of finding it by rounding one decorrelated ambiguity after the
    /// other, a lower bound (Teunissen 1999, "An optimality property of the integer least-squares
    /// estimator").
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
    // Whole cycles are subtracted first, so that the transformed floats keep all their digits.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
    }
}
