//! Kalman filter and modified Bryson–Fraser smoother (Bierman 1973) over the pulses, which invert no
//! covariance; the columns of the parameters are carried along with the observations (de Jong 1991).

use nalgebra::{DMatrix, Dyn, Matrix3, OMatrix, U9};

use crate::information::{Axes, PulseInformation};
use crate::prior::Correlation;
use crate::process::{StateMatrix, stationary, transition};

/// One state for the observations and each parameter.
type States = OMatrix<f64, U9, Dyn>;
/// Data of a pulse that the filter keeps for the smoother.
pub(crate) struct Filtered {
    /// Covariance and states predicted.
    covariance: StateMatrix,
    states: States,
    /// (I + N P)⁻¹N and (I + N P)⁻¹(n − N x).
    gain: Matrix3<f64>,
    innovation: Axes,
}

/// Smoothed quantities of one pulse, given all observations.
pub(crate) struct Passed {
    /// Value of z for the observations and each parameter's column.
    pub value: Axes,
    /// Covariance of z where the parameters are known.
    pub covariance: Matrix3<f64>,
}

/// Filter and smoother for the process z along the pulses.
#[derive(Clone, Debug)]
pub(crate) struct Passes {
    steps: Vec<(StateMatrix, StateMatrix)>,
    stationary: StateMatrix,
}

impl Passes {
    pub fn new(abscissa: &[f64], correlation: Correlation) -> Self {
        let step = |w: &[f64]| transition(correlation, w[1] - w[0]);
        Self {
            steps: abscissa.windows(2).map(step).collect(),
            stationary: stationary(correlation),
        }
    }

    /// Runs forward; subtracts from `cross` the part that the path explains.
    pub fn forward(&self, pulses: &[PulseInformation], cross: &mut DMatrix<f64>) -> Vec<Filtered> {
        let columns = cross.ncols();
        let mut covariance = self.stationary;
        let mut states = States::zeros(columns);
        let mut kept = Vec::with_capacity(pulses.len());
        for (m, pulse) in pulses.iter().enumerate() {
            if m > 0 {
                let (phi, new) = &self.steps[m - 1];
                covariance = phi * covariance * phi.transpose() + new;
                states = phi * states;
            }
            let own: Matrix3<f64> = covariance.fixed_view::<3, 3>(0, 0).into();
            let value: Axes = states.fixed_rows::<3>(0).into_owned();
            let n = &pulse.information;
            // I + N P has the eigenvalues of I + P^½ N P^½, all at least 1.
            let inverse = (Matrix3::identity() + n * own)
                .try_inverse()
                .unwrap_or_else(Matrix3::zeros);
            let rest = &pulse.right - n * &value;
            let gain = inverse * n;
            let innovation = inverse * &rest;
            let updated = &value + own * &innovation;
            take(cross, [&value, &rest], [&pulse.right, &updated]);
            kept.push(Filtered {
                covariance,
                states: states.clone(),
                gain,
                innovation: innovation.clone(),
            });
            let to_own = covariance.fixed_columns::<3>(0).into_owned();
            states += to_own * &innovation;
            covariance -= to_own * gain * to_own.transpose();
            covariance = 0.5 * (covariance + covariance.transpose());
        }
        kept
    }

    /// Runs backward over the data kept by [`Passes::forward`]; results are in the order of the pulses.
    pub fn backward(&self, filtered: &[Filtered]) -> Vec<Passed> {
        let columns = filtered.first().map_or(0, |at| at.states.ncols());
        let mut passed = Vec::with_capacity(filtered.len());
        let mut adjoint = States::zeros(columns);
        let mut adjoint_information = StateMatrix::zeros();
        for (m, at) in filtered.iter().enumerate().rev() {
            let to_own = at.covariance.fixed_columns::<3>(0).into_owned();
            // (I − K H)ᵀ = I − E gainᵀ Eᵀ P, with E the columns of the position.
            let mut keep = StateMatrix::identity();
            let pull = at.gain.transpose() * to_own.transpose();
            for i in 0..3 {
                for j in 0..9 {
                    keep[(i, j)] -= pull[(i, j)];
                }
            }
            adjoint = keep * adjoint;
            let mut top = adjoint.fixed_rows_mut::<3>(0);
            top -= &at.innovation;
            adjoint_information = keep * adjoint_information * keep.transpose();
            let mut corner = adjoint_information.fixed_view_mut::<3, 3>(0, 0);
            corner += at.gain;

            let own: Matrix3<f64> = at.covariance.fixed_view::<3, 3>(0, 0).into();
            passed.push(Passed {
                value: at.states.fixed_rows::<3>(0) - to_own.tr_mul(&adjoint),
                covariance: own - to_own.transpose() * adjoint_information * to_own,
            });
            if m > 0 {
                let (phi, _) = &self.steps[m - 1];
                adjoint = phi.transpose() * adjoint;
                adjoint_information = phi.transpose() * adjoint_information * phi;
            }
        }
        passed.reverse();
        passed
    }
}

/// Takes Σ AᵀB of the pairs from `cross`: Vᵀ[y, A] + rᵀ(V + P(I + N P)⁻¹r) with r = [y, A] − N V is the part
/// that a pulse's path explains.
fn take(cross: &mut DMatrix<f64>, left: [&Axes; 2], right: [&Axes; 2]) {
    let rows = cross.nrows();
    let [a, b] = left.map(|m| m.as_slice().chunks_exact(3));
    let [c, d] = right.map(|m| m.as_slice().chunks_exact(3));
    let columns = cross.as_mut_slice().chunks_exact_mut(rows);
    for ((column, c), d) in columns.zip(c).zip(d) {
        for ((value, a), b) in column.iter_mut().zip(a.clone()).zip(b.clone()) {
            *value -= a[0] * c[0] + a[1] * c[1] + a[2] * c[2];
            *value -= b[0] * d[0] + b[1] * d[1] + b[2] * d[2];
        }
    }
}
