//! Carrier-phase differential GNSS (PPK): readers, positioning, ambiguity resolution.

mod navigation;
mod observation;
mod options;
mod satellite;
mod signal;
mod solution;

pub use navigation::{
    Ephemeris, GlonassEphemeris, KeplerEphemeris, Klobuchar, Navigation, SbasEphemeris,
};
pub use observation::{
    AntennaOffset, EPOCH_TOLERANCE_S, EventKind, EventRecord, LossOfLock, ObservationData,
    ObservationEpoch, SatelliteObservation, SignalObservation, StationInfo,
};
pub use options::{
    AmbiguityMode, BasePosition, Cn0Mask, Dynamics, FilterDirection, GlonassAmbiguity,
    PartialAmbiguity, PositioningMode, PpkOptions, RuleSet,
};
pub use satellite::{SatelliteId, SatelliteIdError, System, SystemSet};
pub use signal::{FREQUENCY_L1_HZ, FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S, SignalCode};
pub use solution::{
    BaseGap, EventPosition, LostEpoch, MissingNavigation, NotFixedReason, PpkSolution, PpkSummary,
    PpkWarning, Quality, SatelliteResidual, Solution,
};
