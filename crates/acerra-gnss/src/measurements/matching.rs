//! Choice of the base epoch for a rover epoch.

use super::measurement::Epoch;
use crate::observations::observation::EPOCH_TOLERANCE_S;

/// Index of the base epoch nearest to a rover epoch, for both directions of the filter.
pub(crate) fn nearest_base(base: &[Epoch], rover: &Epoch) -> Option<usize> {
    let apart_s = |k: usize| base[k].tag.seconds_since(rover.tag).abs();
    let after = base.partition_point(|b| b.tag < rover.tag);
    let places = [after.checked_sub(1), Some(after)].into_iter().flatten();
    places
        .filter(|&k| k < base.len())
        .min_by(|&a, &b| apart_s(a).total_cmp(&apart_s(b)))
}

/// Index of the base epoch for a rover epoch: forward the last base epoch not after the rover's, backward the
/// first not before it; at the ends of the log the nearest.
pub(crate) fn matching_base(base: &[Epoch], rover: &Epoch, backward: bool) -> Option<usize> {
    let last = base.len().checked_sub(1)?;
    if backward {
        let first_after =
            base.partition_point(|b| b.tag.seconds_since(rover.tag) < -EPOCH_TOLERANCE_S);
        Some(first_after.min(last))
    } else {
        let after = base.partition_point(|b| b.tag.seconds_since(rover.tag) <= EPOCH_TOLERANCE_S);
        Some(after.saturating_sub(1))
    }
}
