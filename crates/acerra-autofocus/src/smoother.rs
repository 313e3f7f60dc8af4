//! Joint estimate of a path and of further parameters from linear observations.
//!
//! Observations of pulse m are y = h·δ_m + aᵀθ + v with the error δ_m = L_m z_m of its position, z a
//! [`process`](crate::process) and θ parameters with Gaussian priors: [`passes`](crate::passes) over the
//! pulses, then θ from the residuals of the path, then the [`held`](crate::held) sums.

use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, Vector3};

use crate::held::{Conditioned, Held};
use crate::information::{Axes, Observations, PulseInformation};
use crate::passes::Passes;
use crate::prior::Correlation;

/// Prior process of the position errors along the pulses.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Root L of each pulse's prior covariance.
    pub factor: Vec<Matrix3<f64>>,
    passes: Passes,
    held: Held,
}

/// Estimates with their posterior covariances.
#[derive(Clone, Debug)]
pub(crate) struct Smoothed {
    /// Error of each pulse's position, m.
    pub error_m: Vec<Vector3<f64>>,
    /// Posterior covariance of each error, m².
    pub covariance_m2: Vec<Matrix3<f64>>,
    /// C⁻¹δ, with C the prior covariance of all errors: Σ δ·C⁻¹δ is the prior's square.
    pub force: Vec<Vector3<f64>>,
    /// The parameters.
    pub parameter: DVector<f64>,
    /// Posterior covariance of the parameters.
    pub parameter_covariance: DMatrix<f64>,
    /// Covariance of each pulse's error with the shared parameters, m times their unit.
    pub with_shared: Vec<Axes>,
}

impl Path {
    pub fn new(factor: Vec<Matrix3<f64>>, abscissa: &[f64], correlation: Correlation) -> Self {
        Self {
            factor,
            passes: Passes::new(abscissa, correlation),
            held: Held::default(),
        }
    }

    /// This process conditioned on zero mean and zero trend over the abscissa.
    pub fn without_trend(self, abscissa: &[f64]) -> Self {
        Self {
            held: Held::mean_and_trend(abscissa),
            ..self
        }
    }

    /// The most probable path and parameters; `None` where the parameters' normal matrix is not positive
    /// definite.
    pub fn smooth(&self, observations: &Observations) -> Option<Smoothed> {
        let scaled = self.scaled(&observations.pulses);
        let columns = scaled.first().map_or(1, |p| p.right.ncols());
        let mut cross = observations.cross.clone().resize(columns, columns, 0.0);
        let filtered = self.passes.forward(&scaled, &mut cross);
        let (parameter, parameter_covariance) = solve(&cross, &observations.variance)?;
        let parameters = parameter.len();
        // Effect of each held sum's force on the parameters.
        let rest = columns - 1 - parameters;
        let pulled = &parameter_covariance * cross.view((1, 1 + parameters), (parameters, rest));
        let mut smoothed = Smoothed {
            error_m: Vec::with_capacity(scaled.len()),
            covariance_m2: Vec::with_capacity(scaled.len()),
            force: Vec::with_capacity(scaled.len()),
            parameter,
            parameter_covariance,
            with_shared: Vec::with_capacity(scaled.len()),
        };
        let shared = observations.shared;
        let mut response = Vec::with_capacity(scaled.len());
        for (l, passed) in self.factor.iter().zip(self.passes.backward(&filtered)) {
            let value = passed.value;
            let of_parameters = value.columns(1, parameters);
            let spread = of_parameters * &smoothed.parameter_covariance;
            let from_parameters = &spread * of_parameters.transpose();
            let total = passed.covariance + Matrix3::from_fn(|i, j| from_parameters[(i, j)]);
            smoothed
                .error_m
                .push(l * combine(&value, &smoothed.parameter));
            smoothed.covariance_m2.push(l * total * l.transpose());
            smoothed
                .with_shared
                .push(l * -spread.columns(parameters - shared, shared));
            response.push(l * (value.columns(1 + parameters, rest) - of_parameters * &pulled));
        }
        let estimate = Conditioned {
            error_m: &mut smoothed.error_m,
            covariance_m2: &mut smoothed.covariance_m2,
            parameter: &mut smoothed.parameter,
            parameter_covariance: &mut smoothed.parameter_covariance,
            with_shared: &mut smoothed.with_shared,
        };
        self.held.condition(&response, &pulled, estimate)?;
        for (m, pulse) in observations.pulses.iter().enumerate() {
            let push = combine(&pulse.right, &smoothed.parameter);
            let force = push - pulse.information * smoothed.error_m[m];
            smoothed.force.push(force);
        }
        Some(smoothed)
    }

    /// Observations in terms of z, with the weights of the constrained sums as further columns.
    fn scaled(&self, pulses: &[PulseInformation]) -> Vec<PulseInformation> {
        let scale = |(m, p): (usize, &PulseInformation)| {
            let information = p.information;
            let right = self.held.with_forces(m, p.right.clone());
            PulseInformation { information, right }.scaled(&self.factor[m])
        };
        pulses.iter().enumerate().map(scale).collect()
    }
}

/// The observations' column less the parameters' columns times the parameters.
fn combine(columns: &Axes, parameter: &DVector<f64>) -> Vector3<f64> {
    let mut sum: Vector3<f64> = columns.column(0).into();
    for (j, p) in parameter.iter().enumerate() {
        for i in 0..3 {
            sum[i] -= columns[(i, 1 + j)] * p;
        }
    }
    sum
}

/// The parameters from [y, A]ᵀΣ⁻¹[y, A] and their prior variances.
fn solve(cross: &DMatrix<f64>, variance: &[f64]) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let count = variance.len();
    if count == 0 {
        return Some((DVector::zeros(0), DMatrix::zeros(0, 0)));
    }
    // In units of the prior deviations the normal matrix is I plus a positive one.
    let scale: Vec<f64> = variance.iter().map(|v| v.sqrt()).collect();
    let normal = DMatrix::from_fn(count, count, |i, j| {
        let unit = f64::from(u8::from(i == j));
        unit + scale[i] * scale[j] * 0.5 * (cross[(1 + i, 1 + j)] + cross[(1 + j, 1 + i)])
    });
    let right = DVector::from_fn(count, |i, _| scale[i] * cross[(1 + i, 0)]);
    let factor = Cholesky::new(normal)?;
    let solution = factor.solve(&right);
    let inverse = factor.inverse();
    Some((
        DVector::from_fn(count, |i, _| scale[i] * solution[i]),
        DMatrix::from_fn(count, count, |i, j| scale[i] * scale[j] * inverse[(i, j)]),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The estimate by the dense normal equations.
    #[test]
    fn path_and_parameters_are_those_of_dense_least_squares() {
        let correlation = Correlation::Matern52 { length: 0.6 };
        let (pulses, parameters) = (7, 2);
        let abscissa: Vec<f64> = (0..pulses).map(|m| 0.2 * m as f64).collect();
        let factor = Matrix3::new(0.3, 0.0, 0.0, 0.1, 0.5, 0.0, -0.1, 0.2, 0.7);
        let variance = vec![4.0, 0.25];
        let rows: Vec<(usize, Vector3<f64>, [f64; 3], f64)> = (0..3 * pulses)
            .filter(|k| k / 3 != 4) // one pulse sees nothing
            .map(|k| {
                let t = k as f64;
                let h = Vector3::new(t.sin(), (1.3 * t).cos(), (0.7 * t).sin());
                (
                    k / 3,
                    h,
                    [(2.1 * t).sin(), (0.4 * t).cos(), 1.0],
                    0.1 + 0.05 * (k % 4) as f64,
                )
            })
            .collect();

        let mut observations = Observations {
            pulses: vec![PulseInformation::none(parameters); pulses],
            cross: DMatrix::zeros(3, 3),
            variance: variance.clone(),
            shared: 1,
        };
        let size = 3 * pulses + parameters;
        let mut prior = DMatrix::<f64>::zeros(3 * pulses, 3 * pulses);
        for a in 0..pulses {
            for b in 0..pulses {
                let rho = correlation.at(abscissa[a] - abscissa[b]);
                let block = factor * factor.transpose() * rho;
                prior.view_mut((3 * a, 3 * b), (3, 3)).copy_from(&block);
            }
        }
        let precision = prior.clone().try_inverse().unwrap();
        let mut normal = DMatrix::<f64>::zeros(size, size);
        normal
            .view_mut((0, 0), (3 * pulses, 3 * pulses))
            .copy_from(&precision);
        for (j, v) in variance.iter().enumerate() {
            normal[(3 * pulses + j, 3 * pulses + j)] = 1.0 / v;
        }
        let mut right = DVector::<f64>::zeros(size);
        for (m, h, [y, a0, a1], v) in &rows {
            let mut row = DVector::<f64>::zeros(size);
            (0..3).for_each(|i| row[3 * m + i] = h[i]);
            row[3 * pulses] = *a0;
            row[3 * pulses + 1] = *a1;
            normal += &row * row.transpose() / *v;
            right += &row * (*y / v);
            let all = DVector::from_vec(vec![*y, *a0, *a1]);
            observations.cross += &all * all.transpose() / *v;
            let p = &mut observations.pulses[*m];
            p.information += h * h.transpose() / *v;
            p.right += h * all.transpose() / *v;
        }
        let dense = normal.clone().try_inverse().unwrap();
        let expected = &dense * right;

        let path = Path::new(vec![factor; pulses], &abscissa, correlation);
        let found = path.smooth(&observations).unwrap();
        let mut square = 0.0;
        for m in 0..pulses {
            for i in 0..3 {
                assert!((found.error_m[m][i] - expected[3 * m + i]).abs() < 1e-9);
                for j in 0..3 {
                    let c = dense[(3 * m + i, 3 * m + j)];
                    assert!((found.covariance_m2[m][(i, j)] - c).abs() < 1e-9);
                }
            }
            square += found.force[m].dot(&found.error_m[m]);
            assert_eq!(found.with_shared[m].ncols(), 1);
            for i in 0..3 {
                let c = dense[(3 * m + i, size - 1)];
                assert!((found.with_shared[m][(i, 0)] - c).abs() < 1e-9);
            }
        }
        for j in 0..parameters {
            assert!((found.parameter[j] - expected[3 * pulses + j]).abs() < 1e-9);
        }
        let delta = expected.rows(0, 3 * pulses);
        assert!((square - (delta.transpose() * precision * delta)[(0, 0)]).abs() < 1e-7);

        // The estimate conditioned on zero mean and trend, computed directly.
        let centre = abscissa[pulses - 1] / 2.0;
        let mut sums = DMatrix::<f64>::zeros(size, 6);
        for m in 0..pulses {
            for axis in 0..3 {
                sums[(3 * m + axis, axis)] = 1.0;
                sums[(3 * m + axis, 3 + axis)] = abscissa[m] - centre;
            }
        }
        let gain = &dense * &sums * (sums.transpose() * &dense * &sums).try_inverse().unwrap();
        let conditioned = &expected - &gain * (sums.transpose() * &expected);
        let left = &dense - &gain * sums.transpose() * &dense;
        let found = path.without_trend(&abscissa).smooth(&observations).unwrap();
        for m in 0..pulses {
            for i in 0..3 {
                assert!((found.error_m[m][i] - conditioned[3 * m + i]).abs() < 1e-8);
                let c = left[(3 * m + i, 3 * m + i)];
                assert!((found.covariance_m2[m][(i, i)] - c).abs() < 1e-8);
                let c = left[(3 * m + i, size - 1)];
                assert!((found.with_shared[m][(i, 0)] - c).abs() < 1e-8);
            }
        }
        for j in 0..parameters {
            assert!((found.parameter[j] - conditioned[3 * pulses + j]).abs() < 1e-8);
        }
    }
}
