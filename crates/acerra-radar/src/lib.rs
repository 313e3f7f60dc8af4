//! Ultra-wideband radar logs: readers, zero-timing, background removal, gating, spectra.

pub mod npz;

mod constants;
mod limits;
mod radargram;
mod scan;
mod spectrum;

pub use constants::{DEFAULT_STEP_BINS, FAST_TIME_BIN_S, SPEED_OF_LIGHT_M_S, two_way_delay_s};
pub use limits::Limits;
pub use npz::{NeutralContent, NeutralFile};
pub use radargram::{Radargram, RadargramError, Samples};
pub use scan::{Filtering, Scan, ScanWindow};
pub use spectrum::Spectrum;
