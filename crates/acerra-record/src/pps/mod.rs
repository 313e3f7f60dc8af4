//! Pulses per second that the kernel stamps (Linux PPS: `pps-gpio`, `pps-ldisc`), read as the text that
//! `/sys/class/pps/pps0/assert` shows.

mod source;
mod stamp;

pub use source::{POLL_EVERY, Poll, PpsError, PpsSource};
pub use stamp::{MAX_STAMP_BYTES, PulseStamp, StampError};
