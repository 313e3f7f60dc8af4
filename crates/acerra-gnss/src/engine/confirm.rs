//! Retrospective confirmation of ambiguity fixes: integers that passed the ratio test while their
//! success rate was low count once the same integers are found with certainty, before or after.

use super::constellation::Constellation;
use super::epoch_result::EpochResult;
use super::fixed_integers::FixedIntegers;
use crate::solution::{NotFixedReason, Quality};

/// Calls fixes float that neither are certain themselves nor have the integers of the nearest
/// certain fix before or after them. `results` are those of one pass, in its order.
///
/// Fixes under integers that were `withdrawn` later confirm nothing, themselves included.
pub(crate) fn confirm(
    results: &mut [EpochResult],
    needed: f64,
    withdrawn: &[u32],
    constellation: &Constellation,
) {
    for result in results.iter_mut() {
        if let Some(own) = &mut result.integers {
            own.certain &= !withdrawn.contains(&own.generation);
        }
    }
    let mut confirmed = vec![false; results.len()];
    let mut confirm_along = |order: &mut dyn Iterator<Item = usize>| {
        let mut nearest: Option<&FixedIntegers> = None;
        for k in order {
            let Some(own) = &results[k].integers else {
                continue;
            };
            if own.certain || nearest.is_some_and(|certain| own.same_as(certain, constellation)) {
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
