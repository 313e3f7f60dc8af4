//! Covariances of fixes, scaled by the residuals of the phases.
//!
//! The model states one phase noise for every receiver and place. The residuals of a fix, about a position
//! that uses three of their degrees of freedom, measure the phase noise: their mean square in units of the
//! model's is the factor from the stated covariance to the true one (the a posteriori variance of unit
//! weight).

use crate::filter::epoch_result::EpochResult;
use crate::solution::Quality;

/// Half window (s) about an epoch within which residuals count.
const HALF_WINDOW_S: f64 = 30.0;
/// Weight of the whole run's residuals, in degrees of freedom of the window.
const RUN_FREEDOM: f64 = 30.0;
/// Degrees of freedom from which a run's residuals are used.
const LEAST_FREEDOM: f64 = 20.0;
/// Factors are kept within these bounds.
const FACTORS: [f64; 2] = [0.1, 25.0];

/// Scales the covariances of the fixes of one pass, given in the order of the pass.
pub(crate) fn scale_covariances(results: &mut [EpochResult]) {
    let is_fixed = |r: &EpochResult| r.quality == Some(Quality::Fixed);
    let sums: Vec<[f64; 2]> = results
        .iter()
        .map(|r| {
            if is_fixed(r) {
                r.phase_misfit
            } else {
                [0.0; 2]
            }
        })
        .collect();
    let add = |a: [f64; 2], b: &[f64; 2]| [a[0] + b[0], a[1] + b[1]];
    let run = sums.iter().fold([0.0; 2], add);
    if run[1] < LEAST_FREEDOM {
        return;
    }
    let of_run = run[0] / run[1];
    let times: Vec<_> = results.iter().map(|r| r.time).collect();
    let (mut start, mut end) = (0, 0);
    let mut window = [0.0; 2];
    for k in 0..results.len() {
        while end < results.len() && times[end].seconds_since(times[k]).abs() <= HALF_WINDOW_S {
            window = add(window, &sums[end]);
            end += 1;
        }
        while times[start].seconds_since(times[k]).abs() > HALF_WINDOW_S {
            window = [window[0] - sums[start][0], window[1] - sums[start][1]];
            start += 1;
        }
        if is_fixed(&results[k]) {
            let factor = (window[0] + RUN_FREEDOM * of_run) / (window[1] + RUN_FREEDOM);
            let factor = factor.clamp(FACTORS[0], FACTORS[1]);
            for value in results[k].covariance_ecef_m2.as_flattened_mut() {
                *value *= factor;
            }
        }
    }
}
