//! Ultra-wideband radar logs: readers, zero-timing, background removal, gating, spectra.

pub mod align;
pub mod clean;
pub mod mrm;
pub mod npz;
pub mod ret;

mod clock;
mod constants;
mod info;
mod limits;
mod log;
mod open;
mod radargram;
mod report;
mod runs;
mod scan;
mod select;
mod spectrum;
mod value;

pub use clock::{ClockBasis, ClockStretch, Numbering, RadioClock, recover_clock};
pub use constants::{DEFAULT_STEP_BINS, FAST_TIME_BIN_S, SPEED_OF_LIGHT_M_S, two_way_delay_s};
pub use info::{FileInfo, FileKind, Levels, LogInfo, file_info, levels};
pub use limits::Limits;
pub use log::{ConfigEvent, LogFormat, RadarLog, ReadError};
pub use npz::{NeutralContent, NeutralFile};
pub use open::{OpenError, RadarFile, read};
pub use radargram::{Radargram, RadargramError, Samples};
pub use report::{Blemish, BlemishKind, Place, ReadReport};
pub use runs::{LogRadargram, RadargramOptions, Run, RunChoice, RunError};
pub use scan::{Filtering, Scan, ScanWindow};
pub use select::{MovingOptions, moving_traces};
pub use spectrum::Spectrum;
