//! Carrier-phase differential GNSS (PPK): readers, positioning, ambiguity resolution.

mod atmosphere;
mod collect;
pub mod conf;
pub mod crinex;
mod engine;
mod events;
mod file;
mod geometry;
pub mod input;
mod lambda;
mod navigation;
mod observation;
mod options;
mod orbit;
pub mod pos;
mod ppk;
mod recorded;
pub mod rinex;
mod satellite;
mod select;
mod signal;
mod solution;
pub mod ubx;

pub use atmosphere::{Mapping, Niell, saastamoinen_m};
pub use file::{GnssFile, read_gnss, read_navigation, read_observations};
pub use geometry::{LineOfSight, azimuth_elevation_rad, line_of_sight};
pub use lambda::{IntegerCandidates, LambdaError, integer_least_squares};
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
pub use orbit::{OrbitRates, OrbitState};
pub use ppk::{PpkError, TimeSpan, process};
pub use recorded::{RecordedEpoch, RecordedSatellite};
pub use satellite::{SatelliteId, SatelliteIdError, System, SystemSet};
pub use select::{SignalChoice, rank, select_signals};
pub use signal::{FREQUENCY_L1_HZ, FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S, SignalCode};
pub use solution::{
    BaseGap, EventPosition, LostEpoch, MissingNavigation, NotFixedReason, PpkSolution, PpkSummary,
    PpkWarning, Quality, SatelliteResidual, Solution,
};
