//! The base's zero differences, computed once for all passes.

use std::sync::{Arc, OnceLock};

use super::zero::ZeroDifference;

/// Zero differences of the two base epochs around each rover epoch.
pub(crate) struct BaseZeros(Vec<[OnceLock<Arc<[ZeroDifference]>>; 2]>);

impl BaseZeros {
    /// Room for so many rover epochs.
    pub(crate) fn new(rover_epochs: usize) -> Self {
        Self((0..rover_epochs).map(|_| Default::default()).collect())
    }

    /// Those of base epoch `base` for rover epoch `rover`: computed where they are asked for first.
    ///
    /// The epochs before and after the rover's are neighbours, so that their indices differ in
    /// parity.
    pub(crate) fn get(
        &self,
        rover: usize,
        base: usize,
        compute: impl FnOnce() -> Vec<ZeroDifference>,
    ) -> Arc<[ZeroDifference]> {
        let place = &self.0[rover][base % 2];
        Arc::clone(place.get_or_init(|| compute().into()))
    }
}
