//! Time: GPS time as whole seconds and fraction, calendars, leap seconds, other systems' clocks.
//!
//! One `f64` of seconds since 1980 resolves 0.12 µs, in which a GNSS satellite moves 0.4 mm; a
//! [`GpsTime`] therefore keeps whole seconds as an integer, and differences are formed as
//! (difference of integers) + (difference of fractions).

mod calendar;
mod gps;
mod leap;

pub use calendar::{Calendar, full_year};
pub use gps::{BDT_BEHIND_GPST_S, BDT_WEEK_OFFSET, GpsTime, SECONDS_PER_WEEK};
pub use leap::{LEAP_SECONDS, LeapSecond, gpst_minus_utc_at_gpst_s, gpst_minus_utc_at_utc_s};

/// Reason why a time cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TimeError {
    /// A field of a date or clock lies outside its range.
    #[error("{field} is {value}, expected {expected}")]
    Field {
        /// Field.
        field: &'static str,
        /// Value found.
        value: f64,
        /// Valid values.
        expected: &'static str,
    },
}
