//! Leap seconds between UTC and GPS time.

use super::calendar::{Calendar, GPS_EPOCH_FROM_1970_S};

/// From an instant on, GPST − UTC.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeapSecond {
    /// Whole UTC seconds since 1970-01-01 00:00 (leap seconds not counted) from which it holds.
    pub from_utc_s: i64,
    /// GPST − UTC (s).
    pub gpst_minus_utc_s: i64,
}

const fn row(year: i32, month: u8, gpst_minus_utc_s: i64) -> LeapSecond {
    let midnight = Calendar {
        year,
        month,
        day: 1,
        hour: 0,
        minute: 0,
        second: 0,
        fraction: 0.0,
    };
    LeapSecond {
        from_utc_s: midnight.seconds_from_1970(),
        gpst_minus_utc_s,
    }
}

/// All leap seconds since GPS time began (1980-01-06, difference 0), oldest first.
///
/// IERS Bulletin C; none has been announced after 2017-01-01.
pub const LEAP_SECONDS: [LeapSecond; 18] = [
    row(1981, 7, 1),
    row(1982, 7, 2),
    row(1983, 7, 3),
    row(1985, 7, 4),
    row(1988, 1, 5),
    row(1990, 1, 6),
    row(1991, 1, 7),
    row(1992, 7, 8),
    row(1993, 7, 9),
    row(1994, 7, 10),
    row(1996, 1, 11),
    row(1997, 7, 12),
    row(1999, 1, 13),
    row(2006, 1, 14),
    row(2009, 1, 15),
    row(2012, 7, 16),
    row(2015, 7, 17),
    row(2017, 1, 18),
];

/// GPST − UTC (s) at a UTC instant, in whole UTC seconds since 1970 (leap seconds not counted).
#[must_use]
pub fn gpst_minus_utc_at_utc_s(utc_s: i64) -> i64 {
    LEAP_SECONDS
        .iter()
        .rev()
        .find(|l| utc_s >= l.from_utc_s)
        .map_or(0, |l| l.gpst_minus_utc_s)
}

/// GPST − UTC (s) at a GPST instant, in whole seconds since 1980-01-06; and whether that instant
/// is inside a leap second (23:59:60 UTC).
#[must_use]
pub fn gpst_minus_utc_at_gpst_s(gpst_s: i64) -> (i64, bool) {
    let unix_like = gpst_s + GPS_EPOCH_FROM_1970_S;
    for l in LEAP_SECONDS.iter().rev() {
        let start = l.from_utc_s + l.gpst_minus_utc_s;
        if unix_like >= start {
            return (l.gpst_minus_utc_s, false);
        }
        if unix_like == start - 1 {
            return (l.gpst_minus_utc_s - 1, true);
        }
    }
    (0, false)
}
