//! Estimate of a path and of parameters beside it from linear observations.
//!
//! Observations of pulse m are y = h·δ_m + aᵀθ + v with the error δ_m = L_m z_m of its position, z a
//! [`process`](crate::process) and θ parameters with Gaussian priors. The path is estimated by a
//! Kalman filter and the modified Bryson–Fraser smoother (Bierman 1973), which invert no covariance;
//! θ by carrying its columns through the filter beside the observations (de Jong 1991).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, OMatrix, U3, U9, Vector3};

use crate::prior::Correlation;
use crate::process::{StateMatrix, stationary, transition};

/// One state for the observations and each parameter.
type States = OMatrix<f64, U9, Dyn>;
/// One value per axis for the observations and each parameter.
type Axes = OMatrix<f64, U3, Dyn>;

/// What one pulse's observations say: HᵀR⁻¹H of its position and HᵀR⁻¹[y, A].
#[derive(Clone, Debug)]
pub(crate) struct PulseInformation {
    /// HᵀR⁻¹H, 1/m².
    pub information: Matrix3<f64>,
    /// HᵀR⁻¹[y, A], `[3, 1 + parameters]`.
    pub right: Axes,
}

impl PulseInformation {
    pub fn none(parameters: usize) -> Self {
        Self {
            information: Matrix3::zeros(),
            right: Axes::zeros(1 + parameters),
        }
    }

    /// The same in terms of z, δ = L z.
    fn scaled(&self, factor: &Matrix3<f64>) -> Self {
        let t = factor.transpose();
        Self {
            information: t * self.information * factor,
            right: t * &self.right,
        }
    }
}

/// All observations.
#[derive(Clone, Debug)]
pub(crate) struct Observations {
    /// Pulse by pulse.
    pub pulses: Vec<PulseInformation>,
    /// [y, A]ᵀR⁻¹[y, A] over all pulses.
    pub cross: DMatrix<f64>,
    /// Prior variance of each parameter.
    pub variance: Vec<f64>,
}

/// The process along the pulses.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Factor L of each pulse's prior covariance.
    pub factor: Vec<Matrix3<f64>>,
    steps: Vec<(StateMatrix, StateMatrix)>,
    stationary: StateMatrix,
    /// Weights of each pulse in sums over the flight that are zero; none where nothing is held.
    held: Vec<[f64; HELD_SUMS]>,
}

/// Sums over the flight that are held at zero on each axis: mean and trend.
const HELD_SUMS: usize = 2;
/// Constraints on all axes.
const HELD: usize = 3 * HELD_SUMS;

/// Estimates with their posterior covariances.
#[derive(Clone, Debug)]
pub(crate) struct Smoothed {
    /// Error of each pulse's position, m.
    pub error_m: Vec<Vector3<f64>>,
    /// Its posterior covariance, m².
    pub covariance_m2: Vec<Matrix3<f64>>,
    /// C⁻¹δ, with C the prior covariance of all errors: Σ δ·C⁻¹δ is the prior's square.
    pub force: Vec<Vector3<f64>>,
    /// The parameters.
    pub parameter: DVector<f64>,
    /// Their posterior covariance.
    pub parameter_covariance: DMatrix<f64>,
}

/// What the filter keeps of a pulse for the smoother.
struct Filtered {
    /// Covariance and states predicted.
    covariance: StateMatrix,
    states: States,
    /// (I + N P)⁻¹N and (I + N P)⁻¹(n − N x).
    gain: Matrix3<f64>,
    innovation: Axes,
}

impl Path {
    pub fn new(factor: Vec<Matrix3<f64>>, abscissa: &[f64], correlation: Correlation) -> Self {
        let steps = abscissa
            .windows(2)
            .map(|w| transition(correlation, w[1] - w[0]))
            .collect();
        Self {
            factor,
            steps,
            stationary: stationary(correlation),
            held: Vec::new(),
        }
    }

    /// The same process given that it has neither mean nor trend over the abscissa.
    pub fn without_trend(self, abscissa: &[f64]) -> Self {
        let count = abscissa.len() as f64;
        let centre = abscissa.iter().sum::<f64>() / count;
        let reach = abscissa
            .iter()
            .map(|t| (t - centre).abs())
            .fold(0.0, f64::max);
        let weights = |t: &f64| [1.0 / count, (t - centre) / (count * reach.max(1e-300))];
        Self {
            held: abscissa.iter().map(weights).collect(),
            ..self
        }
    }

    /// The most probable path and parameters; none where the parameters' normal matrix is no
    /// covariance's inverse.
    pub fn smooth(&self, observations: &Observations) -> Option<Smoothed> {
        let scaled = self.scaled(&observations.pulses);
        let columns = scaled.first().map_or(1, |p| p.right.ncols());
        let mut cross = observations.cross.clone().resize(columns, columns, 0.0);
        let filtered = self.filter(&scaled, &mut cross);
        let (parameter, parameter_covariance) = solve(&cross, &observations.variance)?;
        let mut smoothed = Smoothed {
            error_m: Vec::with_capacity(scaled.len()),
            covariance_m2: Vec::with_capacity(scaled.len()),
            force: Vec::with_capacity(scaled.len()),
            parameter,
            parameter_covariance,
        };
        let parameters = smoothed.parameter.len();
        // What each constraint's force does to the parameters.
        let pulled = &smoothed.parameter_covariance
            * cross.view((1, 1 + parameters), (parameters, columns - 1 - parameters));
        let response = self.backwards(&filtered, &mut smoothed, &pulled);
        self.hold(&response, &pulled, &mut smoothed)?;
        for (m, pulse) in observations.pulses.iter().enumerate() {
            let push = combine(&pulse.right, &smoothed.parameter);
            let force = push - pulse.information * smoothed.error_m[m];
            smoothed.force.push(force);
        }
        Some(smoothed)
    }

    /// Observations in terms of z, with the forces of what is held as further columns.
    fn scaled(&self, pulses: &[PulseInformation]) -> Vec<PulseInformation> {
        let scale = |(m, p): (usize, &PulseInformation)| {
            let mut right = p.right.clone();
            if let Some(weights) = self.held.get(m) {
                let before = right.ncols();
                right = right.resize_horizontally(before + HELD, 0.0);
                for (k, weight) in weights.iter().enumerate() {
                    for axis in 0..3 {
                        right[(axis, before + 3 * k + axis)] = *weight;
                    }
                }
            }
            let information = p.information;
            PulseInformation { information, right }.scaled(&self.factor[m])
        };
        pulses.iter().enumerate().map(scale).collect()
    }

    /// Conditions the estimate on the sums that are held at zero; `response` is Cov(δ, sums) of each
    /// pulse, `pulled` Cov(θ, sums).
    fn hold(
        &self,
        response: &[Axes],
        pulled: &DMatrix<f64>,
        smoothed: &mut Smoothed,
    ) -> Option<()> {
        if self.held.is_empty() {
            return Some(());
        }
        let mut sums = DVector::<f64>::zeros(HELD);
        let mut variance = DMatrix::<f64>::zeros(HELD, HELD);
        for (m, weights) in self.held.iter().enumerate() {
            for (k, weight) in weights.iter().enumerate() {
                for axis in 0..3 {
                    sums[3 * k + axis] += weight * smoothed.error_m[m][axis];
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
        for (m, own) in response.iter().enumerate() {
            let moved = own * &force;
            smoothed.error_m[m] -= Vector3::new(moved[0], moved[1], moved[2]);
            let known = own * &inverse * own.transpose();
            smoothed.covariance_m2[m] -= Matrix3::from_fn(|i, j| known[(i, j)]);
        }
        smoothed.parameter -= pulled * &force;
        smoothed.parameter_covariance -= pulled * inverse * pulled.transpose();
        Some(())
    }

    /// Runs forward; takes from `cross` what the path explains.
    fn filter(&self, pulses: &[PulseInformation], cross: &mut DMatrix<f64>) -> Vec<Filtered> {
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
            let right = pulse.right.tr_mul(&value);
            *cross += value.tr_mul(&(n * &value)) - &right - right.transpose();
            *cross -= rest.tr_mul(&(own * &innovation));
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

    /// Runs backward; appends errors and covariances in the order of the pulses, and returns what
    /// the forces of what is held do to each.
    fn backwards(
        &self,
        filtered: &[Filtered],
        smoothed: &mut Smoothed,
        pulled: &DMatrix<f64>,
    ) -> Vec<Axes> {
        let parameters = smoothed.parameter.len();
        let columns = 1 + parameters + pulled.ncols();
        let mut response = Vec::with_capacity(filtered.len());
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

            let value: Axes = at.states.fixed_rows::<3>(0) - to_own.tr_mul(&adjoint);
            let own: Matrix3<f64> = at.covariance.fixed_view::<3, 3>(0, 0).into();
            let left = own - to_own.transpose() * adjoint_information * to_own;
            let of_parameters = value.columns(1, parameters);
            let from_parameters =
                of_parameters * &smoothed.parameter_covariance * of_parameters.transpose();
            let l = &self.factor[m];
            let of_held = value.columns(1 + parameters, pulled.ncols());
            response.push(l * (of_held - of_parameters * pulled));
            smoothed
                .error_m
                .push(l * combine(&value, &smoothed.parameter));
            let total = Matrix3::from_fn(|i, j| left[(i, j)] + from_parameters[(i, j)]);
            smoothed.covariance_m2.push(l * total * l.transpose());
            if m > 0 {
                let (phi, _) = &self.steps[m - 1];
                adjoint = phi.transpose() * adjoint;
                adjoint_information = phi.transpose() * adjoint_information * phi;
            }
        }
        smoothed.error_m.reverse();
        smoothed.covariance_m2.reverse();
        response.reverse();
        response
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

    /// The same estimate by the dense normal equations.
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
        }
        for j in 0..parameters {
            assert!((found.parameter[j] - expected[3 * pulses + j]).abs() < 1e-9);
        }
        let delta = expected.rows(0, 3 * pulses);
        assert!((square - (delta.transpose() * precision * delta)[(0, 0)]).abs() < 1e-7);

        // The same given that mean and trend vanish: conditioning by hand.
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
            }
        }
        for j in 0..parameters {
            assert!((found.parameter[j] - conditioned[3 * pulses + j]).abs() < 1e-8);
        }
    }
}
