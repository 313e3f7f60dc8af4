//! Constraints on the errors over the flight: zero mean and zero trend of each axis.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, Vector3};

use crate::information::Axes;

/// Number of constrained sums on each axis: mean and trend.
const HELD_SUMS: usize = 2;
/// Number of constrained sums on all axes.
const HELD: usize = 3 * HELD_SUMS;

/// Weights of each pulse in the constrained sums; empty without constraints.
#[derive(Clone, Debug, Default)]
pub(crate) struct Held {
    weights: Vec<[f64; HELD_SUMS]>,
}

/// An estimate conditioned on zero sums, with its covariances.
pub(crate) struct Conditioned<'a> {
    pub error_m: &'a mut [Vector3<f64>],
    pub covariance_m2: &'a mut [Matrix3<f64>],
    pub parameter: &'a mut DVector<f64>,
    pub parameter_covariance: &'a mut DMatrix<f64>,
    pub with_shared: &'a mut [Axes],
}

impl Held {
    /// Constraints of zero mean and zero trend over the abscissa.
    pub fn mean_and_trend(abscissa: &[f64]) -> Self {
        let count = abscissa.len() as f64;
        let centre = abscissa.iter().sum::<f64>() / count;
        let reach = abscissa
            .iter()
            .map(|t| (t - centre).abs())
            .fold(0.0, f64::max);
        let weights = |t: &f64| [1.0 / count, (t - centre) / (count * reach.max(1e-300))];
        Self {
            weights: abscissa.iter().map(weights).collect(),
        }
    }

    /// Appends the weights of pulse `m` in the constrained sums to the columns `right`: one column per sum
    /// and axis.
    pub fn with_forces(&self, m: usize, right: Axes) -> Axes {
        let Some(weights) = self.weights.get(m) else {
            return right;
        };
        let before = right.ncols();
        let mut right = right.resize_horizontally(before + HELD, 0.0);
        for (k, weight) in weights.iter().enumerate() {
            for axis in 0..3 {
                right[(axis, before + 3 * k + axis)] = *weight;
            }
        }
        right
    }

    /// Conditions an estimate on the sums; `response` is Cov(δ, sums) of each pulse, `pulled` Cov(θ, sums).
    /// `None` where the sums have no variance.
    pub fn condition(
        &self,
        response: &[Axes],
        pulled: &DMatrix<f64>,
        estimate: Conditioned,
    ) -> Option<()> {
        if self.weights.is_empty() {
            return Some(());
        }
        let mut sums = DVector::<f64>::zeros(HELD);
        let mut variance = DMatrix::<f64>::zeros(HELD, HELD);
        for (m, weights) in self.weights.iter().enumerate() {
            for (k, weight) in weights.iter().enumerate() {
                for axis in 0..3 {
                    sums[3 * k + axis] += weight * estimate.error_m[m][axis];
                    for j in 0..HELD {
                        variance[(3 * k + axis, j)] += weight * response[m][(axis, j)];
                    }
                }
            }
        }
        let jitter = 1e-12 * variance.trace().abs().max(f64::MIN_POSITIVE);
        let symmetric = 0.5 * (&variance + variance.transpose());
        let factor = Cholesky::new(symmetric + DMatrix::identity(HELD, HELD) * jitter)?;
        let force = factor.solve(&sums);
        let inverse = factor.inverse();
        let shared = estimate.with_shared.first().map_or(0, Axes::ncols);
        let pulled_shared = pulled.rows(pulled.nrows() - shared, shared).transpose();
        for (m, own) in response.iter().enumerate() {
            let moved = own * &force;
            estimate.error_m[m] -= Vector3::new(moved[0], moved[1], moved[2]);
            let known = own * &inverse * own.transpose();
            estimate.covariance_m2[m] -= Matrix3::from_fn(|i, j| known[(i, j)]);
            estimate.with_shared[m] -= own * &inverse * &pulled_shared;
        }
        *estimate.parameter -= pulled * &force;
        *estimate.parameter_covariance -= pulled * inverse * pulled.transpose();
        Some(())
    }
}
