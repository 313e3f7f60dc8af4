//! Decision of an estimate: whether its correction is applied, and the report on it.

use acerra_imaging::Pulses;
use nalgebra::{Matrix3, Vector3};

use crate::fit::{Fitted, Problem};
use crate::globals::Global;
use crate::model::Model;
use crate::outcome::{Autofocused, Decision, GlobalFound, PointFound};
use crate::prior::PositionPrior;
use crate::significance::{Gains, LEAST_TO_FOLD};

/// Gain below which a correction is not applied (dB).
const LEAST_GAIN_DB: f64 = 0.02;
/// Loss of a point by a correction from which the point counts as worse (dB): smaller losses are due to
/// clutter about the point.
const WORSE_DB: f64 = 0.1;
/// Criteria of a correction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Least mean gain of the held-out points, in standard errors above zero.
    pub significance: f64,
    /// Greatest rms correction in prior deviations.
    pub most_sigmas: f64,
}

/// The outcome that leaves the stated positions unchanged.
pub(crate) fn unchanged(
    pulses: &Pulses,
    prior: &PositionPrior,
    factor: &[Matrix3<f64>],
    decision: Decision,
) -> Autofocused {
    let covariance: Vec<Matrix3<f64>> = factor.iter().map(|l| l * l.transpose()).collect();
    Autofocused {
        decision,
        position_m: pulses.position_m().to_vec(),
        correction_m: vec![[0.0; 3]; pulses.len()],
        sigma_m: covariance.iter().map(deviations).collect(),
        covariance_m2: covariance.iter().map(rows_of).collect(),
        globals: found_of(&prior.globals, |_, g| (0.0, g.sigma)),
        points: Vec::new(),
        ghosts: 0,
        gain_db: 0.0,
        gain_sigma_db: 0.0,
        predicted_loss_db: 0.0,
        correction_in_sigmas: 0.0,
        unobserved: [1.0; 3],
    }
}

/// The decision from a maximum of the posterior and the gains of held-out points.
pub(crate) fn outcome(
    pulses: &Pulses,
    problem: &Problem,
    fitted: Fitted,
    gains: &Gains,
    limits: Limits,
) -> Autofocused {
    let model = &fitted.model;
    let own_prior: Vec<Matrix3<f64>> = problem
        .path
        .factor
        .iter()
        .map(|l| l * l.transpose())
        .collect();
    let sigmas = in_sigmas(model, &own_prior);
    let globals = found_of(problem.globals, |j, _| {
        (model.globals[j], fitted.posterior.global_sigma[j])
    });
    let farthest = globals
        .iter()
        .map(|g| (g.value / g.prior_sigma).abs())
        .fold(0.0, f64::max);
    let significant =
        gains.mean_db > limits.significance * gains.sigma_db && gains.mean_db > LEAST_GAIN_DB;
    let decision = if sigmas.max(farthest) > limits.most_sigmas {
        Decision::AgainstPrior
    } else if model.places.len() < LEAST_TO_FOLD {
        // A single point cannot be held out, and no other test distinguishes the track's error from the
        // point's motion.
        Decision::LonePoint
    } else if !significant {
        Decision::NotSignificant
    } else if gains.worst_db < -WORSE_DB {
        Decision::Worsens
    } else {
        Decision::Applied
    };
    let points = model.points_m(&problem.ground);
    let corrected_m = problem.positions_m(model);
    Autofocused {
        decision,
        position_m: if decision == Decision::Applied {
            corrected_m.clone()
        } else {
            pulses.position_m().to_vec()
        },
        correction_m: corrected_m
            .iter()
            .zip(pulses.position_m())
            .map(|(c, p)| [0, 1, 2].map(|i| c[i] - p[i]))
            .collect(),
        sigma_m: fitted.posterior.error_m2.iter().map(deviations).collect(),
        covariance_m2: fitted.posterior.error_m2.iter().map(rows_of).collect(),
        globals,
        points: points
            .iter()
            .enumerate()
            .map(|(k, p)| PointFound {
                position_m: [p[0], p[1], p[2]],
                sigma_m: fitted.place_sigma_m[k],
                residual_m: fitted.residual_m[k],
                gain_db: gains.point_db[k],
            })
            .collect(),
        ghosts: ghosts(&problem.ranges_m(model), problem.template.cell_m),
        gain_db: gains.mean_db,
        gain_sigma_db: gains.sigma_db,
        predicted_loss_db: predicted_loss_db(problem, &points, &own_prior),
        correction_in_sigmas: sigmas,
        unobserved: unobserved(&fitted.posterior.error_m2, &problem.prior_m2()),
    }
}

/// Number of points whose ranges, `[M][K]`, m, differ from an earlier point's by less than `within_m` rms.
fn ghosts(ranges_m: &[Vec<f64>], within_m: f64) -> usize {
    let apart_m = |a: usize, b: usize| {
        let square = |ranges: &Vec<f64>| (ranges[a] - ranges[b]).powi(2);
        (ranges_m.iter().map(square).sum::<f64>() / ranges_m.len() as f64).sqrt()
    };
    let points = ranges_m.first().map_or(0, Vec::len);
    let is_ghost = |k: &usize| (0..*k).any(|other| apart_m(*k, other) < within_m);
    (0..points).filter(is_ghost).count()
}

fn found_of(globals: &[Global], of: impl Fn(usize, &Global) -> (f64, f64)) -> Vec<GlobalFound> {
    let found = |(j, global): (usize, &Global)| {
        let (value, sigma) = of(j, global);
        GlobalFound {
            name: global.name.clone(),
            value,
            sigma,
            prior_sigma: global.sigma,
        }
    };
    globals.iter().enumerate().map(found).collect()
}

/// Loss of the points' peaks by position errors of covariance `prior`, Eq. (5): e^{−φ²}, φ = κσ along the
/// line of sight; mean over points and pulses, dB.
fn predicted_loss_db(problem: &Problem, points: &[Vector3<f64>], prior: &[Matrix3<f64>]) -> f64 {
    let mut sum = 0.0;
    for (p, c) in problem.nominal_m.iter().zip(prior) {
        for q in points {
            let sight = (q - Vector3::from(*p)).normalize();
            sum += sight.dot(&(c * sight)) * problem.template.carrier.powi(2);
        }
    }
    let mean = sum / (prior.len() * points.len()).max(1) as f64;
    10.0 * std::f64::consts::LOG10_E * mean
}

/// Rms of the corrections in units of their prior deviations.
fn in_sigmas(model: &Model, prior: &[Matrix3<f64>]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (e, c) in model.error_m.iter().zip(prior) {
        for axis in 0..3 {
            if c[(axis, axis)] > 0.0 {
                sum += e[axis] * e[axis] / c[(axis, axis)];
                count += 1.0;
            }
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

fn unobserved(posterior: &[Matrix3<f64>], prior: &[Matrix3<f64>]) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let of = |c: &[Matrix3<f64>]| c.iter().map(|c| c[(axis, axis)]).sum::<f64>();
        let before = of(prior);
        if before > 0.0 {
            of(posterior) / before
        } else {
            1.0
        }
    })
}

fn deviations(c: &Matrix3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|i| c[(i, i)].max(0.0).sqrt())
}

fn rows_of(c: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| c[(i, j)]))
}
