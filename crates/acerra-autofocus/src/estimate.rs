//! The way from data to corrected positions.

use acerra_imaging::{Control, ImageGrid, Pulses};
use nalgebra::{Matrix3, Vector3};

use crate::error::AutofocusError;
use crate::fit::{Fitted, Problem, Stage};
use crate::ground::Ground;
use crate::model::Model;
use crate::outcome::{Autofocused, Decision, PointFound};
use crate::prior::PositionPrior;
use crate::profiles::Profiles;
use crate::search::Search;
use crate::significance::{Gains, LEAST_TO_FOLD, held_out_gains};
use crate::smoother::Path;
use crate::template::{Template, mean_amplitudes};

/// Requirements on an autofocus.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AutofocusOptions {
    /// Most points that are used; 24 by default.
    pub most_points: usize,
    /// Standard errors by which the mean gain of points left out must exceed zero; 2 by default.
    pub significance: f64,
    /// Rms correction, in prior deviations, beyond which the echoes are not believed to be those of
    /// fixed points; 4 by default.
    pub most_sigmas: f64,
}

impl Default for AutofocusOptions {
    fn default() -> Self {
        Self {
            most_points: 24,
            significance: 2.0,
            most_sigmas: 4.0,
        }
    }
}

/// Gain below which a correction is not worth a change of the positions (dB).
const LEAST_GAIN_DB: f64 = 0.02;
/// Points found by delays below which the coherent image is searched as well.
const FEW_POINTS: usize = 4;
/// Rounds of dropping points that are not prominent.
const PRUNINGS: usize = 3;
/// Coherence of a prominent point's echoes along the flight.
const LEAST_COHERENCE: f64 = 0.4;
/// Amplitude of a prominent point over the strongest's.
const LEAST_AMPLITUDE: f64 = 0.1;
/// Prominent points stand so many range resolutions apart.
const APART_CELLS: f64 = 1.5;

/// Estimates the positions' errors from the echoes of prominent points on `grid`.
///
/// `grid` is where points are looked for; pixels of half the finest resolution do. The frequencies
/// must be evenly spaced.
///
/// # Errors
/// Frequencies that are not even, a prior that does not fit the pulses or is no covariance, pixels
/// that cannot be imaged, cancellation.
pub fn autofocus<'a>(
    pulses: Pulses<'a>,
    grid: impl Into<ImageGrid<'a>>,
    prior: &PositionPrior,
    options: &AutofocusOptions,
    control: Control,
) -> Result<Autofocused, AutofocusError> {
    prior.check(pulses.len())?;
    if pulses.frequency_step_hz().is_none() || pulses.frequency_hz().len() < 8 {
        return Err(AutofocusError::UnevenFrequencies);
    }
    let ground = Ground::new(grid.into());
    let factor = prior.factors()?;
    let nothing = |decision| unchanged(&pulses, &factor, decision);
    let has_echo = pulses.spectrum().iter().any(|v| v.norm_sqr() > 0.0);
    if !has_echo {
        return Ok(nothing(Decision::NoPoints));
    }
    if factor.iter().all(|l| l.norm() == 0.0) {
        return Ok(nothing(Decision::NothingToCorrect));
    }
    let path = Path::new(factor.clone(), &prior.abscissa, prior.correlation);
    let path = if prior.without_trend {
        path.without_trend(&prior.abscissa)
    } else {
        path
    };
    let range_m = ranges_m(&pulses, &ground, prior);
    let amplitudes = mean_amplitudes(pulses.spectrum(), pulses.frequency_hz().len());
    let template = Template::new(
        amplitudes,
        pulses.frequency_hz(),
        pulses.light_speed_m_s(),
        range_m[1] - range_m[0],
    );
    let profiles = Profiles::new(&pulses, &template, range_m, control)?;
    let problem = Problem {
        profiles: &profiles,
        template: &template,
        ground,
        nominal_m: pulses.position_m(),
        path: &path,
        delay_sigma_m: prior.delay_sigma_m,
        control,
    };
    let search = Search {
        problem,
        pulses,
        most_points: options.most_points.max(1),
    };
    let Some(reached) = best_fit(&search)? else {
        return Ok(nothing(Decision::NoPoints));
    };
    let Reached {
        start,
        stages,
        fitted,
    } = reached;
    let gains = held_out_gains(&problem, &start, stages, &fitted)?;
    Ok(outcome(&pulses, &problem, fitted, &gains, options))
}

/// A maximum of the posterior, and how it was reached.
struct Reached {
    /// Where the stages began, with the points that were kept.
    start: Model,
    stages: &'static [Stage],
    fitted: Fitted,
}

/// The maximum reached from delays, or from the coherent image where delays give few points and it
/// explains more; none where no point stands out.
fn best_fit(search: &Search) -> Result<Option<Reached>, AutofocusError> {
    let start = search.by_envelopes()?;
    let by_delays = reach(search, start, &[Stage::Envelope, Stage::Phase])?;
    let points = by_delays
        .as_ref()
        .map_or(0, |r| r.fitted.model.places.len());
    if points >= FEW_POINTS {
        return Ok(by_delays);
    }
    let nominal = Model::nominal(search.pulses.len(), Vec::new());
    let by_image = reach(search, search.by_phases(nominal)?, &[Stage::Phase])?;
    Ok(match (by_delays, by_image) {
        (Some(a), Some(b)) => {
            let noise = |r: &Reached| search.problem.histories(&r.fitted.model).noise;
            let noise = noise(&a).min(noise(&b));
            let score = |r: &Reached| search.penalised(&r.fitted.model, noise);
            Some(if score(&b) < score(&a) { b } else { a })
        }
        (a, b) => a.or(b),
    })
}

/// Fits from a start, dropping points that turn out not to be prominent.
fn reach(
    search: &Search,
    start: Model,
    stages: &'static [Stage],
) -> Result<Option<Reached>, AutofocusError> {
    if start.places.is_empty() {
        return Ok(None);
    }
    let problem = &search.problem;
    let all = vec![true; start.places.len()];
    let mut start = start;
    let mut fitted = problem.fit_through(start.clone(), stages, &all)?;
    for _ in 0..PRUNINGS {
        let kept = prominent(problem, &fitted.model);
        if kept.len() == fitted.model.places.len() {
            break;
        }
        if kept.is_empty() {
            return Ok(None);
        }
        let keep =
            |model: &Model| model.with_places(kept.iter().map(|k| model.places[*k]).collect());
        start = keep(&start);
        let all = vec![true; kept.len()];
        fitted = problem.fit(keep(&fitted.model), Stage::Phase, &all, None)?;
    }
    Ok(Some(Reached {
        start,
        stages,
        fitted,
    }))
}

/// Points that keep their phase along the flight, are not far weaker than the strongest, and do not
/// stand beside a stronger one; indices, rising.
fn prominent(problem: &Problem, model: &Model) -> Vec<usize> {
    let coherence = problem.histories(model).coherence();
    let points = model.points_m(&problem.ground);
    let strongest = coherence.iter().map(|c| c[0]).fold(0.0, f64::max);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| coherence[*b][0].total_cmp(&coherence[*a][0]));
    let apart_m = APART_CELLS * problem.template.cell_m;
    let mut kept: Vec<usize> = Vec::new();
    for k in order {
        let [amplitude, share] = coherence[k];
        let is_apart = |other: &usize| (points[*other] - points[k]).norm() > apart_m;
        if share >= LEAST_COHERENCE
            && amplitude >= LEAST_AMPLITUDE * strongest
            && problem.ground.holds(model.places[k])
            && kept.iter().all(is_apart)
        {
            kept.push(k);
        }
    }
    kept.sort_unstable();
    kept
}

/// Ranges that profiles must hold.
fn ranges_m(pulses: &Pulses, ground: &Ground, prior: &PositionPrior) -> [f64; 2] {
    let grid = ground.grid();
    let corners: Vec<Vector3<f64>> = (0..=16)
        .flat_map(|a| (0..=16).map(move |b| (a, b)))
        .map(|(a, b)| {
            let at = |share: usize, size: usize| share * (size - 1) / 16;
            Vector3::from(grid.point_m(at(a, grid.columns()), at(b, grid.rows())))
        })
        .collect();
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for p in pulses.position_m() {
        for q in &corners {
            let range = (q - Vector3::from(*p)).norm();
            least = least.min(range);
            most = most.max(range);
        }
    }
    let sigma = prior
        .covariance_m2
        .iter()
        .map(|c| (c[0][0] + c[1][1] + c[2][2]).sqrt())
        .fold(0.0, f64::max);
    let spacing = (corners[0] - corners[18]).norm();
    let margin = 1.0 + 6.0 * sigma + 6.0 * prior.delay_sigma_m + spacing;
    [(least - margin).max(0.0), most + margin]
}

/// Positions as stated.
fn unchanged(pulses: &Pulses, factor: &[Matrix3<f64>], decision: Decision) -> Autofocused {
    let covariance: Vec<Matrix3<f64>> = factor.iter().map(|l| l * l.transpose()).collect();
    Autofocused {
        decision,
        position_m: pulses.position_m().to_vec(),
        correction_m: vec![[0.0; 3]; pulses.len()],
        sigma_m: covariance.iter().map(deviations).collect(),
        covariance_m2: covariance.iter().map(rows_of).collect(),
        delay_m: 0.0,
        points: Vec::new(),
        gain_db: 0.0,
        gain_sigma_db: 0.0,
        predicted_loss_db: 0.0,
        correction_in_sigmas: 0.0,
        unobserved: [1.0; 3],
    }
}

fn points_of(fitted: &Fitted) -> usize {
    fitted.model.places.len()
}

fn outcome(
    pulses: &Pulses,
    problem: &Problem,
    fitted: Fitted,
    gains: &Gains,
    options: &AutofocusOptions,
) -> Autofocused {
    let model = &fitted.model;
    let prior: Vec<Matrix3<f64>> = problem
        .path
        .factor
        .iter()
        .map(|l| l * l.transpose())
        .collect();
    let sigmas = in_sigmas(model, &prior);
    let significant =
        gains.mean_db > options.significance * gains.sigma_db && gains.mean_db > LEAST_GAIN_DB;
    // A single point cannot be left out: it must move as the prior expects all the more.
    let lone = points_of(&fitted) < LEAST_TO_FOLD;
    let most_sigmas = options.most_sigmas * if lone { 0.5 } else { 1.0 };
    let decision = if sigmas > most_sigmas {
        Decision::AgainstPrior
    } else if significant {
        Decision::Applied
    } else {
        Decision::NotSignificant
    };
    let points = model.points_m(&problem.ground);
    Autofocused {
        decision,
        position_m: if decision == Decision::Applied {
            model.positions_m(pulses.position_m())
        } else {
            pulses.position_m().to_vec()
        },
        correction_m: model.error_m.iter().map(|e| [e[0], e[1], e[2]]).collect(),
        sigma_m: fitted.posterior.error_m2.iter().map(deviations).collect(),
        covariance_m2: fitted.posterior.error_m2.iter().map(rows_of).collect(),
        delay_m: model.delay_m,
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
        gain_db: gains.mean_db,
        gain_sigma_db: gains.sigma_db,
        predicted_loss_db: predicted_loss_db(problem, &points, &prior),
        correction_in_sigmas: sigmas,
        unobserved: unobserved(&fitted.posterior.error_m2, &prior),
    }
}

/// Loss of the points' peaks by errors of this covariance, Eq. (5): e^{−φ²}, φ = κσ along the line of
/// sight; mean over points and pulses, dB.
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
