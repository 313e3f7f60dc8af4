//! Search for the maximum of the posterior, from delays or from the coherent image, with removal of points
//! that turn out not to be prominent.

use crate::error::AutofocusError;
use crate::fit::{Fitted, Problem, Seen, Stage};
use crate::model::Model;
use crate::search::Search;

/// Number of points found by delays below which the coherent image is searched too.
const FEW_POINTS: usize = 4;
/// Rounds of dropping points that are not prominent.
const PRUNINGS: usize = 3;
/// Least coherence of a prominent point's echoes along the flight.
const LEAST_COHERENCE: f64 = 0.4;
/// Least amplitude of a prominent point relative to the strongest point.
const LEAST_AMPLITUDE: f64 = 0.1;
/// Least spacing of prominent points, in range resolutions.
const APART_CELLS: f64 = 1.5;

/// A maximum of the posterior, and the model from which it was reached.
pub(crate) struct Reached {
    /// Model at the beginning of the stages, with the points that were kept.
    pub start: Model,
    /// Stages that led to the maximum.
    pub stages: &'static [Stage],
    pub fitted: Fitted,
}

/// The maximum reached from delays, or the maximum reached from the coherent image where delays give few
/// points and the latter explains more; `None` without a prominent point.
pub(crate) fn best_fit(search: &Search) -> Result<Option<Reached>, AutofocusError> {
    let start = search.by_envelopes()?;
    let by_delays = reach(search, start, &[Stage::Envelope, Stage::Phase])?;
    let points = by_delays
        .as_ref()
        .map_or(0, |r| r.fitted.model.places.len());
    if points >= FEW_POINTS {
        return Ok(by_delays);
    }
    let nominal = search.problem.nominal(Vec::new());
    let by_image = reach(search, search.by_phases(nominal)?, &[Stage::Phase])?;
    Ok(match (by_delays, by_image) {
        (Some(a), Some(b)) => {
            let [seen_a, seen_b] = [&a, &b].map(|r| search.problem.seen(&r.fitted.model));
            let noise = seen_a.histories.noise.min(seen_b.histories.noise);
            let score = |r: &Reached, seen: &Seen| search.penalised(&r.fitted.model, seen, noise);
            Some(if score(&b, &seen_b) < score(&a, &seen_a) {
                b
            } else {
                a
            })
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

/// Points that keep their phase along the flight, are not far weaker than the strongest, and are not adjacent
/// to a stronger point; indices, ascending.
fn prominent(problem: &Problem, model: &Model) -> Vec<usize> {
    let coherence = problem.seen(model).histories.coherence();
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
