//! Retrospective confirmation of ambiguity fixes.
//!
//! Two passes in opposite directions of time rest on different codes and meet with different
//! errors. Where both come to the same place by integers, the integers are right; what else has
//! those integers, before or after, is right as well.

use super::constellation::Constellation;
use super::epoch_result::EpochResult;
use super::fixed_integers::FixedIntegers;
use crate::observation::EPOCH_TOLERANCE_S;
use crate::solution::{NotFixedReason, Quality};

/// Fixes of two passes nearer to each other than this are the same (m): a quarter of a wavelength;
/// those of neighbouring integers are further apart.
const SAME_PLACE_M: f64 = 0.05;
/// Time (s) over which passes must agree before that alone counts: in a shorter log both rest on
/// much the same codes.
const AGREEMENT_S: f64 = 60.0;

/// How far two passes agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Agreement {
    /// Epochs at which both fixed at the same place.
    pub agreeing: usize,
    /// Epochs at which both fixed at different places.
    pub contradicting: usize,
}

/// Confirms the fixes of two passes by each other; each is in its own order.
pub(crate) fn confirm_by_each_other(
    passes: [&mut Vec<EpochResult>; 2],
    needed: f64,
    constellation: &Constellation,
) -> Agreement {
    let [forward, backward] = passes;
    let pairs = same_epochs(forward, backward);
    let mut agreement = Agreement::default();
    let mut agreeing = Vec::new();
    for (f, b) in pairs {
        let both = [&forward[f], &backward[b]];
        if both.iter().any(|r| r.quality != Some(Quality::Fixed)) {
            continue;
        }
        if distance_m(both[0], both[1]) < SAME_PLACE_M {
            agreement.agreeing += 1;
            agreeing.push((f, b));
        } else {
            agreement.contradicting += 1;
        }
    }
    let span_s = agreeing.first().zip(agreeing.last()).map_or(0.0, |(a, z)| {
        forward[z.0].time.seconds_since(forward[a.0].time).abs()
    });
    let certain = |r: &EpochResult| r.integers.as_ref().is_some_and(|i| i.certain);
    let mut anchors = [vec![false; forward.len()], vec![false; backward.len()]];
    for (f, b) in agreeing {
        if span_s >= AGREEMENT_S || (certain(&forward[f]) && certain(&backward[b])) {
            anchors[0][f] = true;
            anchors[1][b] = true;
        }
    }
    let [of_forward, of_backward] = anchors;
    keep_confirmed(forward, &of_forward, needed, constellation);
    keep_confirmed(backward, &of_backward, needed, constellation);
    agreement
}

/// Confirms the fixes of one pass alone, by those that are certain themselves.
///
/// Fixes under integers that were `withdrawn` later confirm nothing, themselves included.
pub(crate) fn confirm_alone(
    results: &mut [EpochResult],
    needed: f64,
    withdrawn: &[u32],
    constellation: &Constellation,
) {
    let certain = |r: &EpochResult| {
        let own = r.integers.as_ref();
        own.is_some_and(|i| i.certain && !withdrawn.contains(&i.generation))
    };
    let anchors: Vec<bool> = results.iter().map(certain).collect();
    keep_confirmed(results, &anchors, needed, constellation);
}

/// Indices of the same epoch in a forward and a backward pass.
fn same_epochs(forward: &[EpochResult], backward: &[EpochResult]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::with_capacity(forward.len());
    let mut b = backward.len();
    for (f, result) in forward.iter().enumerate() {
        while b > 0 && backward[b - 1].tag.seconds_since(result.tag) < -EPOCH_TOLERANCE_S {
            b -= 1;
        }
        if b > 0 && backward[b - 1].tag.seconds_since(result.tag) <= EPOCH_TOLERANCE_S {
            pairs.push((f, b - 1));
        }
    }
    pairs
}

fn distance_m(a: &EpochResult, b: &EpochResult) -> f64 {
    let squares = (0..3).map(|k| (a.position_ecef_m[k] - b.position_ecef_m[k]).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Calls fixes float that neither are anchors nor have the integers of the nearest anchor before
/// or after them.
fn keep_confirmed(
    results: &mut [EpochResult],
    anchors: &[bool],
    needed: f64,
    constellation: &Constellation,
) {
    let mut confirmed = anchors.to_vec();
    let mut confirm_along = |order: &mut dyn Iterator<Item = usize>| {
        let mut nearest: Option<&FixedIntegers> = None;
        for k in order {
            let Some(own) = &results[k].integers else {
                continue;
            };
            if anchors[k] || nearest.is_some_and(|certain| own.same_as(certain, constellation)) {
                confirmed[k] = true;
                nearest = Some(own);
            }
        }
    };
    confirm_along(&mut (0..results.len()).rev());
    confirm_along(&mut (0..results.len()));
    for (result, confirmed) in results.iter_mut().zip(confirmed) {
        let Some(own) = result.integers.take() else {
            continue;
        };
        if !confirmed {
            result.quality = Some(Quality::Float);
            result.reason = Some(NotFixedReason::IntegersUncertain {
                success_rate: own.success_rate,
                needed,
            });
            result.position_ecef_m = own.float.position_ecef_m;
            result.covariance_ecef_m2 = own.float.covariance_ecef_m2;
            result.velocity = own.float.velocity;
            for residual in &mut result.residuals {
                residual.fixed = false;
            }
        }
    }
}
