//! Ultra-wideband radar logs: readers, zero-timing, background removal, gating, spectra.
//!
//! ```text
//! file ──read──► RadarLog ──radargram──► Radargram ──clean::*──► Radargram ──spectrum_at──► Spectrum
//!                (whole scans, report)   (one window, even clock)
//!                                            ├──align::*────► offset between the clocks, delay
//!                                            └──quality::*──► outliers, coupling, spectrum, surface
//! ```
//!
//! | format | read | written | recognised by |
//! | --- | --- | --- | --- |
//! | MRM capture of a PulsON 400-series radio ([`mrm`]) | with or without configuration and serial prefix | yes, byte for byte | messages in its first bytes |
//! | MRM-RET text log ([`ret`]) | all events | configuration, control, scans | event names in its first lines |
//! | neutral NPZ ([`npz`]) | `data` or `spectrum`, any number type | yes | ZIP signature |
//!
//! Readers stream, deliver whole scans only, report skipped data ([`ReadReport`]), and allocate memory only
//! for data that are present, whatever sizes a header claims ([`Limits`]). Long operations can be cancelled
//! and report their progress ([`Control`]).
//!
//! From a file to spectra, with the height of each trace known:
//!
//! ```
//! use acerra_radar::clean::{self, Background, Gate, SurfaceOptions, ZeroTiming};
//! use acerra_radar::{Limits, RadarFile, RadargramOptions, Spectrum, read};
//!
//! fn spectra(file: std::fs::File, height_m: &[f64]) -> Result<Spectrum, Box<dyn std::error::Error>> {
//!     let RadarFile::Log(log) = read(file, &Limits::default())? else {
//!         return Err("a log was expected".into());
//!     };
//!     let raw = log.radargram(&RadargramOptions::default())?.radargram;
//!     let method = ZeroTiming::FirstTrace(SurfaceOptions::default());
//!     let timed = clean::zero_timing(raw, height_m, &method)?.radargram;
//!     let clean = clean::remove_background(timed, Background::Mean)?;
//!     let gated = clean::apply_gate(clean, height_m, &Gate::default())?;
//!     let frequency_hz: Vec<f64> = (0..341).map(|i| 3.1e9 + 5e6 * f64::from(i)).collect();
//!     Ok(clean::spectrum_at(&gated, &frequency_hz)?)
//! }
//! ```

pub mod align;
pub mod clean;
pub mod mrm;
pub mod npz;
pub mod quality;
pub mod ret;

mod clock;
mod constants;
mod limits;
mod log;
mod logged;
mod open;
mod radargram;
mod report;
mod runs;
mod scan;
mod select;
mod spectrum;
mod value;

pub use acerra_control::{Cancelled, Control};
pub use clock::{ClockBasis, ClockStretch, Numbering, RadioClock, recover_clock};
pub use constants::{DEFAULT_STEP_BINS, FAST_TIME_BIN_S, SPEED_OF_LIGHT_M_S, two_way_delay_s};
pub use limits::Limits;
pub use log::{ConfigEvent, LogFormat, RadarLog, ReadError};
pub use logged::{LoggedClock, LoggedClockError};
pub use npz::{NeutralContent, NeutralFile};
pub use open::{OpenError, RadarFile, read};
pub use radargram::{Radargram, RadargramError, Samples};
pub use report::{Blemish, BlemishKind, Place, ReadReport};
pub use runs::{LogRadargram, RadargramOptions, Run, RunChoice, RunError};
pub use scan::{Filtering, Scan, ScanWindow};
pub use select::{MovingOptions, moving_traces};
pub use spectrum::Spectrum;
