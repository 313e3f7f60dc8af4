//! Input of the filter at one epoch: the measurements of rover and base.

use super::moving_base::MovedBase;
use crate::measurements::constellation::{SatelliteState, Unusable};
use crate::measurements::measurement::Epoch;
use crate::measurements::zero::{ZeroDifference, zero_differences};
use crate::options::PpkOptions;
use crate::single::SinglePoint;
use crate::solution::NotFixedReason;
use std::sync::{Arc, OnceLock};

/// The rover's epoch with all data that do not depend on the filter.
pub(crate) struct RoverEpoch {
    /// Measurements, shared between preparations with different masks.
    pub epoch: Arc<Epoch>,
    pub states: Vec<Result<SatelliteState, Unusable>>,
    /// The states before implausible pseudoranges were removed, where any were.
    pub all_states: Option<Vec<Result<SatelliteState, Unusable>>>,
    pub single: Result<SinglePoint, (NotFixedReason, [f64; 3])>,
    /// Zero differences at the single-point position, computed once for all passes.
    pub zero: OnceLock<Arc<[ZeroDifference]>>,
    /// Unflagged slips found by forward and backward passes, independent of the filter.
    pub unflagged_slips: [OnceLock<UnflaggedSlips>; 2],
}

/// (common index, slot) of phases that slipped without a flag.
pub(crate) type UnflaggedSlips = Arc<[(usize, usize)]>;

impl RoverEpoch {
    /// Zero differences at a position; those at the single-point position are computed once.
    pub(crate) fn zero_at(
        &self,
        options: &PpkOptions,
        place_ecef_m: [f64; 3],
    ) -> Arc<[ZeroDifference]> {
        let compute =
            || zero_differences(options, &self.epoch, &self.states, place_ecef_m, false).into();
        match &self.single {
            Ok(single) if single.position_ecef_m == place_ecef_m => {
                Arc::clone(self.zero.get_or_init(compute))
            }
            _ => compute(),
        }
    }
}

/// The base's data for a rover epoch.
pub(crate) struct BaseView<'a> {
    pub epoch: &'a Epoch,
    pub zero: Arc<[ZeroDifference]>,
    /// Position of the base for these data.
    pub place_ecef_m: [f64; 3],
    /// Position of a moving base at the rover's time.
    pub moved: Option<MovedBase>,
    /// Rover tag minus base tag (s); of a moving base the time between the two receptions.
    pub age_s: f64,
    /// Time that enters the clock noise (s).
    pub noise_age_s: f64,
}
