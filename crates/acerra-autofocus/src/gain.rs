//! Peaks of points in the coherent image, before and after a correction.

use nalgebra::Vector3;
use num_complex::Complex64;
use rayon::prelude::*;

use crate::fit::Problem;
use crate::ground::PixelPlace;
use crate::model::Model;
use crate::ranging::Ranging;

/// Largest distance of a point's peak in the search (m).
const NEARBY_M: f64 = 0.24;
/// Step of the search, and of the last refinement (m).
const STEP_M: f64 = 0.015;
const LAST_STEP_M: f64 = 0.002;

/// Power of each point's peak near `places`, summed over the parts of the flight, with the path of `model`.
pub(crate) fn peak_powers(problem: &Problem, model: &Model, places: &[PixelPlace]) -> Vec<f64> {
    let positions: Vec<Vector3<f64>> = problem
        .positions_m(model)
        .into_iter()
        .map(Vector3::from)
        .collect();
    let ranging = problem.ranging(model);
    places
        .par_iter()
        .map(|place| peak_power(problem, &positions, &ranging, *place))
        .collect()
}

fn peak_power(
    problem: &Problem,
    positions: &[Vector3<f64>],
    ranging: &Ranging,
    place: PixelPlace,
) -> f64 {
    let side_m = problem.ground.tangents_m(place).map(|t| t.norm().max(1e-9));
    let power = |at: PixelPlace| {
        let point = problem.ground.point_m(at);
        let mut sums = vec![Complex64::ZERO; problem.parts.len()];
        for (m, p) in positions.iter().enumerate() {
            let range = ranging.range_m(m, p, &point);
            let turn = Complex64::cis(problem.template.carrier * range) * ranging.turn[m].conj();
            sums[problem.parts.of(m)] += problem.profiles.value(m, range) * turn;
        }
        sums.iter().map(Complex64::norm_sqr).sum::<f64>()
    };
    let shifted = |from: PixelPlace, i: i32, j: i32, step: f64| {
        [
            from[0] + f64::from(i) * step / side_m[0],
            from[1] + f64::from(j) * step / side_m[1],
        ]
    };
    let reach = (NEARBY_M / STEP_M) as i32;
    let mut best = (0.0, place);
    for j in -reach..=reach {
        for i in -reach..=reach {
            let at = shifted(place, i, j, STEP_M);
            let p = power(at);
            if p > best.0 {
                best = (p, at);
            }
        }
    }
    let mut step = 0.5 * STEP_M;
    while step >= LAST_STEP_M {
        let centre = best.1;
        for j in -1..=1 {
            for i in -1..=1 {
                let at = shifted(centre, i, j, step);
                let p = power(at);
                if p > best.0 {
                    best = (p, at);
                }
            }
        }
        step *= 0.5;
    }
    best.0
}

/// Gains in dB of powers `after` over `before`.
pub(crate) fn gains_db(before: &[f64], after: &[f64]) -> Vec<f64> {
    before
        .iter()
        .zip(after)
        .map(|(b, a)| 10.0 * (a.max(f64::MIN_POSITIVE) / b.max(f64::MIN_POSITIVE)).log10())
        .collect()
}
