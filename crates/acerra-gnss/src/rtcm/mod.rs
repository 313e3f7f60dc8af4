//! RTCM 3 logs (RTCM standard 10403.3): messages of a base, or the log of a receiver.
//!
//! | messages | content |
//! | --- | --- |
//! | 1002, 1004, 1010, 1012 | GPS and GLONASS observations of the first generation |
//! | 1074–1077, 1084–1087 … 1134–1137 | multiple signal messages 4 to 7 of every system |
//! | 1019, 1020, 1042, 1044, 1045, 1046 | ephemerides |
//! | 1005–1008, 1033 | position, antenna and receiver of the station |
//! | 1013 | date |
//!
//! Other messages are counted. Observation messages give the time of the week only: the week comes
//! from message 1013, from the ephemerides, or from a time that the caller states.

mod ephemeris;
pub mod frame;
mod legacy;
mod lock;
mod log;
mod measurement;
mod msm;
mod signals;
mod station;
mod time;
mod window;

pub(crate) use log::counts;
pub use log::{RtcmHints, RtcmLog, read_rtcm};
pub use time::DateSource;
