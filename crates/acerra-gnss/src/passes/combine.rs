//! Merging a forward and a backward pass.

use super::float_errors::FloatErrors;
use crate::filter::epoch_result::EpochResult;
use crate::observations::observation::EPOCH_TOLERANCE_S;
use crate::options::PpkOptions;
use crate::solution::{NotFixedReason, Quality};
use nalgebra::{Matrix3, Vector3};

/// Distance on any axis, in standard deviations, beyond which two fixes cannot both be right.
const LARGEST_DISAGREEMENT_SIGMA: f64 = 4.0;

/// Distance below which fixes of a receiver at rest agree (m): half a wavelength.
const LARGEST_STATIC_DISTANCE_M: f64 = 0.1;

/// Merges results in ascending order with results in descending order.
///
/// The better of two qualities wins ("no solution" ranks last); results of equal quality are averaged by
/// their information, and two fixes that disagree are reported as float.
pub(crate) fn combine(
    forward: Vec<EpochResult>,
    backward: Vec<EpochResult>,
    options: &PpkOptions,
    float: &FloatErrors,
) -> Vec<EpochResult> {
    let mut merged = Vec::with_capacity(forward.len().max(backward.len()));
    let mut forward = forward.into_iter().peekable();
    let mut backward = backward.into_iter().rev().peekable();
    loop {
        let ahead_s = match (forward.peek(), backward.peek()) {
            (None, None) => return merged,
            (Some(_), None) => f64::NEG_INFINITY,
            (None, Some(_)) => f64::INFINITY,
            (Some(f), Some(b)) => f.time.seconds_since(b.time),
        };
        if ahead_s < -EPOCH_TOLERANCE_S {
            merged.extend(forward.next());
        } else if ahead_s > EPOCH_TOLERANCE_S {
            merged.extend(backward.next());
        } else if let (Some(f), Some(b)) = (forward.next(), backward.next()) {
            merged.push(pair(f, b, options, float));
        }
    }
}

fn pair(f: EpochResult, b: EpochResult, options: &PpkOptions, float: &FloatErrors) -> EpochResult {
    let none = options.policy().rank_of_none();
    let rank = |r: &EpochResult| r.quality.map_or(none, Quality::number);
    let (rank_f, rank_b) = (rank(&f), rank(&b));
    if rank_f != rank_b {
        return if rank_f < rank_b { f } else { b };
    }
    if f.quality.is_none() {
        return f;
    }
    if f.quality == Some(Quality::Fixed)
        && f.anchored != b.anchored
        && disagreement_m(&f, &b, options).is_some()
    {
        return if f.anchored { f } else { b };
    }
    let mut result = f.clone();
    result.time = f.time - f.time.seconds_since(b.time) / 2.0;
    if f.quality == Some(Quality::Fixed)
        && let Some(distance_m) = disagreement_m(&f, &b, options)
    {
        result.quality = Some(Quality::Float);
        result.reason = Some(NotFixedReason::PassesDisagree { distance_m });
        if options.min_success_rate.is_some() {
            result.widen_to(&b);
            return result;
        }
    }
    if let Some((x, q)) = weighted_mean(
        (&f.position_ecef_m, &f.covariance_ecef_m2),
        (&b.position_ecef_m, &b.covariance_ecef_m2),
    ) {
        result.position_ecef_m = x;
        result.covariance_ecef_m2 = q;
        if f.quality == Some(Quality::Float) {
            let variance_m2 = |r: &EpochResult| (0..3).map(|k| r.covariance_ecef_m2[k][k]).sum();
            let factor = float.of_mean([variance_m2(&f), variance_m2(&b)]);
            for value in result.covariance_ecef_m2.as_flattened_mut() {
                *value *= factor;
            }
        }
        // Two fixes of an epoch use the same phases: their mean is no better than either.
        if options.min_success_rate.is_some() && f.quality == Some(Quality::Fixed) {
            result.covariance_ecef_m2 = std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    (f.covariance_ecef_m2[i][j] + b.covariance_ecef_m2[i][j]) / 2.0
                })
            });
        }
    }
    result
}

/// Distance of two fixes that cannot both be right.
fn disagreement_m(f: &EpochResult, b: &EpochResult, options: &PpkOptions) -> Option<f64> {
    let mut distance2 = 0.0;
    let mut agree = true;
    for k in 0..3 {
        let difference = f.position_ecef_m[k] - b.position_ecef_m[k];
        let variance = f.covariance_ecef_m2[k][k] + b.covariance_ecef_m2[k][k];
        distance2 += difference * difference;
        agree &= difference * difference
            <= LARGEST_DISAGREEMENT_SIGMA * LARGEST_DISAGREEMENT_SIGMA * variance;
    }
    let distance_m = distance2.sqrt();
    // A receiver at rest averages its noise, but not the multipath of each half of the log; only ambiguities
    // of metres distinguish the passes.
    let still = options.tolerates_static_difference();
    let agree = agree || (still && distance_m < LARGEST_STATIC_DISTANCE_M);
    (!agree).then_some(distance_m)
}

type Estimate<'a> = (&'a [f64; 3], &'a [[f64; 3]; 3]);

/// Information-weighted mean of two estimates; `None` when a covariance is singular.
fn weighted_mean(a: Estimate<'_>, b: Estimate<'_>) -> Option<([f64; 3], [[f64; 3]; 3])> {
    let matrix = |q: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| q[i][j]);
    let (qa, qb) = (matrix(a.1).try_inverse()?, matrix(b.1).try_inverse()?);
    let q = (qa + qb).try_inverse()?;
    let x = q * (qa * Vector3::from(*a.0) + qb * Vector3::from(*b.0));
    x.iter().all(|v| v.is_finite()).then(|| {
        (
            [x[0], x[1], x[2]],
            std::array::from_fn(|i| std::array::from_fn(|j| q[(i, j)])),
        )
    })
}
