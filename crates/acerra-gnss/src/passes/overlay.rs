//! Fixes of one attempt, for epochs at which another attempt has none.

use crate::filter::epoch_result::EpochResult;
use crate::observations::observation::EPOCH_TOLERANCE_S;
use crate::solution::{NotFixedReason, Quality};

/// Distance (m) beyond which fixes have different integers.
const DIFFERENT_PLACE_M: f64 = 0.1;

/// Inserts the fixes of `other` where `results` have none. Of two fixes at different places the fix confirmed
/// by a pass in the other direction is used, otherwise neither.
pub(crate) fn overlay(results: &mut [EpochResult], other: Vec<EpochResult>) {
    let mut other = other.into_iter().peekable();
    for result in results {
        while other
            .next_if(|o| o.tag.seconds_since(result.tag) < -EPOCH_TOLERANCE_S)
            .is_some()
        {}
        let near = |o: &EpochResult| o.tag.seconds_since(result.tag) <= EPOCH_TOLERANCE_S;
        let Some(better) = other.next_if(near) else {
            continue;
        };
        let fixed = |r: &EpochResult| r.quality == Some(Quality::Fixed);
        if !fixed(&better) {
            continue;
        }
        if !fixed(result) {
            *result = better;
            continue;
        }
        let distance_m = result.distance_m(&better);
        if distance_m > DIFFERENT_PLACE_M {
            match (result.anchored, better.anchored) {
                (true, false) => {}
                (false, true) => *result = better,
                _ => {
                    result.quality = Some(Quality::Float);
                    result.reason = Some(NotFixedReason::PassesDisagree { distance_m });
                    result.widen_to(&better);
                }
            }
        }
    }
}
