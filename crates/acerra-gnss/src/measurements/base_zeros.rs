//! Satellite states and zero differences of the base, computed once for all passes.

use std::sync::{Arc, OnceLock};

use super::constellation::{SatelliteState, Unusable};
use super::zero::ZeroDifference;

/// Data of the two base epochs around each rover epoch.
pub(crate) struct AroundEpochs<T>(Vec<[OnceLock<Arc<[T]>>; 2]>);

/// Zero differences of the base.
pub(crate) type BaseZeros = AroundEpochs<ZeroDifference>;
/// States of the satellites at the base's reception, which depend on no mask.
pub(crate) type BaseStates = AroundEpochs<Result<SatelliteState, Unusable>>;

impl<T> AroundEpochs<T> {
    /// An empty store for `rover_epochs` rover epochs.
    pub(crate) fn new(rover_epochs: usize) -> Self {
        let room = (0..rover_epochs).map(|_| [OnceLock::new(), OnceLock::new()]);
        Self(room.collect())
    }

    /// Zero differences of base epoch `base` for rover epoch `rover`, computed at the first call.
    ///
    /// The epochs before and after the rover's are neighbours, so that their indices differ in
    /// parity.
    pub(crate) fn get(
        &self,
        rover: usize,
        base: usize,
        compute: impl FnOnce() -> Vec<T>,
    ) -> Arc<[T]> {
        let place = &self.0[rover][base % 2];
        Arc::clone(place.get_or_init(|| compute().into()))
    }
}
