//! Significance of a correction: points that were not used for it must gain.

use acerra_imaging::ImagingError;

use crate::fit::{Fitted, Problem, Stage};
use crate::gain::{gains_db, peak_powers};
use crate::model::Model;

/// Number of subsets of the points; each subset is held out of one estimate.
const FOLDS: usize = 2;
/// Least number of points of which some can be held out.
pub(crate) const LEAST_TO_FOLD: usize = 2;

/// Gain of the points' peaks.
#[derive(Clone, Debug)]
pub(crate) struct Gains {
    /// Gain of each point, dB.
    pub point_db: Vec<f64>,
    /// Mean gain, weighted by the points' amplitudes, dB.
    pub mean_db: f64,
    /// Standard error of the mean gain, dB.
    pub sigma_db: f64,
    /// Least gain of a point by the whole estimate, dB.
    pub worst_db: f64,
}

impl Gains {
    /// Mean gain weighted by the points' amplitudes: clutter near weak points makes the peaks of weak points
    /// fluctuate.
    fn of(point_db: Vec<f64>, before: &[f64], power: &[f64]) -> Self {
        let weight: Vec<f64> = power.iter().map(|p| p.sqrt()).collect();
        let total = weight.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        let each = || point_db.iter().zip(&weight);
        let mean_db = each().map(|(g, w)| g * w).sum::<f64>() / total;
        let scatter: f64 = each().map(|(g, w)| (w * (g - mean_db)).powi(2)).sum();
        let count = point_db.len() as f64;
        let sigma_db = if count > 1.0 {
            (scatter * count / (count - 1.0)).sqrt() / total
        } else {
            0.0
        };
        Self {
            point_db,
            mean_db,
            sigma_db,
            worst_db: gains_db(before, power)
                .into_iter()
                .fold(f64::INFINITY, f64::min),
        }
    }
}

/// Gain of each point by an estimate from other points alone, or by the whole estimate where there are too
/// few points.
///
/// `start` is the model at which the estimates begin, before phases are used.
pub(crate) fn held_out_gains(
    problem: &Problem,
    start: &Model,
    stages: &[Stage],
    fitted: &Fitted,
) -> Result<Gains, ImagingError> {
    let places = &fitted.model.places;
    let nominal = problem.nominal(places.clone());
    let before = peak_powers(
        problem,
        &nominal,
        &problem.places_in(&nominal, &fitted.model),
    );
    let power = peak_powers(problem, &fitted.model, places);
    if places.len() < LEAST_TO_FOLD {
        return Ok(Gains::of(gains_db(&before, &power), &before, &power));
    }
    let mut point_db = vec![0.0; places.len()];
    for fold in 0..FOLDS {
        let guides: Vec<bool> = (0..places.len()).map(|k| k % FOLDS != fold).collect();
        let begin = start.with_places(places.clone());
        let alone = problem.fit_through(begin, stages, &guides)?;
        let there = problem.places_in(&alone.model, &fitted.model);
        let after = peak_powers(problem, &alone.model, &there);
        let gains = gains_db(&before, &after);
        for k in (0..places.len()).filter(|k| !guides[*k]) {
            point_db[k] = gains[k];
        }
    }
    Ok(Gains::of(point_db, &before, &power))
}
