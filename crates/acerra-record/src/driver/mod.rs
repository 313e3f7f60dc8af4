//! The driver of a PulsON 400-series radio: requests with retries, configuration with read-back,
//! continuous scanning that survives lost packets, silences and restarts.

mod counts;
mod error;
mod intake;
mod request;
mod sequence;
mod setup;
mod watch;

pub use counts::LinkCounts;
pub use error::DriverError;
pub use intake::{Intake, Taken};
pub use request::{Driver, RequestOptions};
pub use sequence::{Sequence, Standing};
pub use setup::{Mismatch, SAMPLE_QUANTUM, Setup, first_mismatch, window_samples};
pub use watch::{Event, WatchOptions, Watched};
