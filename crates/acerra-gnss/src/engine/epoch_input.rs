//! What the filter takes in at one epoch: the rover's measurements and the base's.

use super::constellation::{SatelliteState, Unusable};
use super::measurement::Epoch;
use super::single::SinglePoint;
use super::zero::ZeroDifference;
use crate::solution::NotFixedReason;
use std::sync::Arc;

/// The rover's epoch with everything that does not depend on the filter.
pub(crate) struct RoverEpoch {
    pub epoch: Epoch,
    pub states: Vec<Result<SatelliteState, Unusable>>,
    pub single: Result<SinglePoint, (NotFixedReason, [f64; 3])>,
}

/// The base's data that go with a rover epoch.
pub(crate) struct BaseView<'a> {
    pub epoch: &'a Epoch,
    pub zero: Arc<[ZeroDifference]>,
    /// Rover tag minus base tag (s).
    pub age_s: f64,
    /// Time that enters the clock noise (s).
    pub noise_age_s: f64,
}
