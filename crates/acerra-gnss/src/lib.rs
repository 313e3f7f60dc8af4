//! Positions of a moving receiver from its raw GNSS log and a base station's, to a centimetre, after
//! the flight: readers, carrier-phase differential positioning (PPK), ambiguity resolution.
//!
//! ```text
//!  rover file ─┐              ObservationData ─┐
//!  base file  ─┼─ read_gnss ─▶ ObservationData ─┼─ process(…, &PpkOptions) ─▶ PpkSolution
//!  nav files  ─┘              Navigation      ─┘                                 │
//!                                                 pos::write_pos ◀───────────────┼─ .epochs: Solution
//!                                                 PpkSolution::trajectory() ◀────┤
//!                                                 .lost, .events, .summary ◀─────┘
//! ```
//!
//! | what | where |
//! | --- | --- |
//! | any supported file, recognised by content | [`read_gnss`], [`read_observations`], [`read_navigation`] |
//! | RINEX 2.10–4 observation, navigation 2–4 | [`rinex`] |
//! | Hatanaka-compressed RINEX (CRINEX 1 and 3) | [`crinex`] |
//! | u-blox UBX: RXM-RAW, RAWX, SFRB, SFRBX, TIM-TM2 | [`ubx`] |
//! | RTCM 3: MSM4–7, 1002, 1004, 1010, 1012, ephemerides | [`rtcm`] |
//! | precise orbits and clocks: SP3-c, SP3-d, RINEX clock | [`precise`] |
//! | antenna calibrations: ANTEX | [`antex`] |
//! | one signal per satellite and frequency | [`select_signals`] |
//! | positions | [`process`] with [`PpkOptions`]; [`process_with`] can be followed and cancelled |
//! | two antennas on one vehicle: [`PositioningMode::MovingBase`] | [`Baseline`] |
//! | NMEA, residuals, positions of images, headings | [`output`] |
//! | RTKLIB's `.conf` and `.pos` | [`conf`], [`pos`] |
//!
//! From two raw logs to a solution file (`examples/positions.rs` is the whole program):
//! ```no_run
//! use acerra_gnss::{Navigation, PpkOptions, input::Limits, pos, process, read_gnss};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let rover = read_gnss(std::fs::File::open("rover.ubx")?, Limits::default())?;
//! let base = read_gnss(std::fs::File::open("base.ubx")?, Limits::default())?;
//! println!("{}", rover.report); // what was dropped, and where
//! let mut navigation = Navigation::default();
//! for part in [rover.navigation, base.navigation].into_iter().flatten() {
//!     navigation.merge(part);
//! }
//! let (rover, base) = (rover.observations.unwrap_or_default(), base.observations.unwrap_or_default());
//! let options = PpkOptions::default();
//! let solution = process(&rover, &base, &navigation, &options)?;
//! for warning in &solution.summary.warnings {
//!     println!("{warning}");
//! }
//! let out = std::io::BufWriter::new(std::fs::File::create("rover.pos")?);
//! pos::write_pos(out, &solution, &options, &["rover.ubx".to_owned()], &pos::PosFormat::default())?;
//! # Ok(())
//! # }
//! ```

mod alternatives;
pub mod antex;
mod atmosphere;
mod attempt;
mod baseline;
mod bits;
mod collect;
pub mod conf;
mod control;
pub mod crinex;
mod engine;
mod error_correlation;
mod error_covariance;
mod events;
mod file;
mod geometry;
mod glonass_orbit;
pub mod input;
mod join;
mod lambda;
mod names;
mod navigation;
mod observation;
mod options;
mod orbit;
mod orbit_state;
pub mod output;
mod passes;
pub mod pos;
mod ppk;
mod ppk_error;
pub mod precise;
mod preparation;
mod recorded;
pub mod rinex;
pub mod rtcm;
mod satellite;
mod select;
mod signal;
mod solution;
mod track;
pub mod ubx;
mod workers;

pub use atmosphere::{Mapping, Niell, saastamoinen_m};
pub use baseline::{Baseline, BaselineAttitude};
pub use control::Control;
pub use error_correlation::{ErrorCorrelation, Lasting};
pub use file::{GnssFile, read_gnss, read_gnss_near, read_navigation, read_observations};
pub use geometry::{LineOfSight, azimuth_elevation_rad, line_of_sight};
pub use join::{JoinRemark, LogPart, join_logs};
pub use lambda::{IntegerCandidates, LambdaError, integer_least_squares};
pub use names::UnknownNameError;
pub use navigation::{
    Ephemeris, GlonassEphemeris, KeplerEphemeris, Klobuchar, Navigation, SbasEphemeris,
};
pub use observation::{
    AntennaOffset, EPOCH_TOLERANCE_S, EventKind, EventRecord, LossOfLock, ObservationData,
    ObservationEpoch, SatelliteObservation, SignalObservation, StationInfo,
};
pub use options::{
    AmbiguityMode, BasePosition, BaselineLength, Cn0Mask, Dynamics, FilterDirection,
    GlonassAmbiguity, PartialAmbiguity, PositioningMode, PpkOptions, RuleSet,
};
pub use orbit_state::{OrbitRates, OrbitState};
pub use ppk::{process, process_with};
pub use ppk_error::{PpkError, TimeSpan};
pub use precise::{PreciseGap, PreciseProducts};
pub use recorded::{RecordedEpoch, RecordedSatellite};
pub use satellite::{SatelliteId, SatelliteIdError, System, SystemSet};
pub use select::{SignalChoice, rank, select_signals};
pub use signal::{FREQUENCY_L1_HZ, FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S, SignalCode};
pub use solution::{
    BaseGap, EventPosition, GlonassDecision, LostEpoch, MissingNavigation, NotFixedReason,
    PpkSolution, PpkSummary, PpkWarning, Quality, SatelliteResidual, Solution,
};
