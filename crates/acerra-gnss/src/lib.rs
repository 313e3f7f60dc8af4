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
//! | direction and signal strength of every satellite of a log | [`sky`] |
//! | RTKLIB's `.conf` and `.pos` | [`conf`], [`pos`] |
//!
//! Folders from the ground up; each imports only from those above it in this list:
//!
//! | folder | holds |
//! | --- | --- |
//! | `observations` | satellites, signals, epochs of measurements |
//! | `orbits` | broadcast and precise orbits, ranges, atmospheric delays |
//! | `input`, `rinex`, `crinex`, `ubx`, `rtcm`, `precise`, `antex` | readers |
//! | `options`, `solution` | inputs and results of a run |
//! | `pos`, `conf`, `output` | files of solutions and options |
//! | `control`, `linear` | cancellation and threads; linear algebra |
//! | `measurements` | one epoch as the filter takes it, with assumed noise |
//! | `single`, `stations` | single-point positions; rover and base of an epoch, the sky of a log |
//! | `noise` | noise measured from the log |
//! | `float`, `ambiguity`, `filter` | state and double differences; integers; one epoch's update |
//! | `confirm`, `passes` | confirmation of fixes; a pass over all epochs, two passes merged |
//! | `ppk` | [`process`]: preparation, passes, alternative settings, warnings |
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

mod ambiguity;
pub mod antex;
mod collect;
pub mod conf;
mod confirm;
mod control;
pub mod crinex;
mod file;
mod filter;
mod float;
pub mod input;
mod linear;
mod measurements;
mod noise;
mod observations;
mod options;
mod orbits;
pub mod output;
mod packed;
mod passes;
pub mod pos;
mod ppk;
pub mod precise;
pub mod rinex;
pub mod rtcm;
mod single;
mod sniff;
mod solution;
mod stations;
pub mod ubx;

pub use acerra_control::{Control, Progress};
pub use ambiguity::lambda::{IntegerCandidates, LambdaError, integer_least_squares};
pub use conf::names::UnknownNameError;
pub use file::{GnssFile, read_gnss, read_gnss_near, read_navigation, read_observations};
pub use observations::join::{JoinRemark, LogPart, join_logs};
pub use observations::observation::{
    AntennaOffset, EPOCH_TOLERANCE_S, EventKind, EventRecord, LossOfLock, ObservationData,
    ObservationEpoch, SatelliteObservation, SignalObservation, StationInfo,
};
pub use observations::recorded::{RecordedEpoch, RecordedSatellite};
pub use observations::satellite::{SatelliteId, SatelliteIdError, System, SystemSet};
pub use observations::select::{SignalChoice, rank, select_signals};
pub use observations::signal::{FREQUENCY_L1_HZ, FREQUENCY_SLOTS, SPEED_OF_LIGHT_M_S, SignalCode};
pub use options::{
    AmbiguityMode, BasePosition, BaselineLength, Cn0Mask, Dynamics, FilterDirection,
    GlonassAmbiguity, PartialAmbiguity, PositioningMode, PpkOptions, RuleSet,
};
pub use orbits::atmosphere::{Mapping, Niell, saastamoinen_m};
pub use orbits::geometry::{LineOfSight, azimuth_elevation_rad, line_of_sight};
pub use orbits::navigation::{
    Ephemeris, GlonassEphemeris, KeplerEphemeris, Klobuchar, Navigation, SbasEphemeris,
};
pub use orbits::products::{PreciseGap, PreciseProducts};
pub use orbits::state::{OrbitRates, OrbitState};
pub use ppk::process::{process, process_with};
pub use solution::{
    BaseGap, Baseline, BaselineAttitude, ErrorCorrelation, EventPosition, GlonassDecision, Lasting,
    LostEpoch, MissingNavigation, NotFixedReason, PpkError, PpkSolution, PpkSummary, PpkWarning,
    Quality, SatelliteResidual, Solution, TimeSpan,
};
pub use stations::sky::{SatelliteInSky, SkySample, sky};
