//! GPS time: whole seconds since 1980-01-06 and the fraction.

use std::cmp::Ordering;
use std::ops::{Add, Sub};

use super::calendar::GPS_EPOCH_FROM_1970_S;
use super::{Calendar, TimeError, gpst_minus_utc_at_gpst_s, gpst_minus_utc_at_utc_s};

/// Seconds in a week.
pub const SECONDS_PER_WEEK: i64 = 604_800;

/// GPST − BDT (s): BeiDou time had the leap seconds of 2006-01-01.
pub const BDT_BEHIND_GPST_S: i64 = 14;

/// GPS week − BeiDou week.
pub const BDT_WEEK_OFFSET: i64 = 1_356;

/// Moscow time, the scale of GLONASS, is ahead of UTC by this much (s).
const GLONASS_AHEAD_OF_UTC_S: i64 = 10_800;

/// An instant of GPS time (GPST): whole seconds since 1980-01-06 00:00 and a fraction in \[0, 1).
///
/// Galileo and QZSS time are taken as GPST. Equality and order are exact.
///
/// ```
/// use acerra_geo::time::{Calendar, GpsTime};
///
/// let t = GpsTime::from_calendar(&Calendar::new(2026, 11, 21, 0, 0, 0.0)?);
/// assert_eq!((t.week(), t.tow_s()), (2445, 518_400.0));
/// assert_eq!(t.to_utc().to_string(), "2026/11/20 23:59:42.000");
/// let later = t + 0.1;
/// assert!((later - t - 0.1).abs() < 1e-16);
/// # Ok::<(), acerra_geo::time::TimeError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpsTime {
    seconds: i64,
    fraction: f64,
}

impl Eq for GpsTime {}

impl PartialOrd for GpsTime {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for GpsTime {
    fn cmp(&self, other: &Self) -> Ordering {
        self.seconds
            .cmp(&other.seconds)
            .then(self.fraction.total_cmp(&other.fraction))
    }
}

impl GpsTime {
    /// 1980-01-06 00:00 GPST.
    pub const EPOCH: Self = Self {
        seconds: 0,
        fraction: 0.0,
    };

    /// Whole seconds since 1980-01-06 00:00 GPST plus any finite number of seconds, brought to a
    /// fraction in \[0, 1). A non-finite `plus_s` counts as zero: readers reject it before.
    #[must_use]
    pub fn new(seconds: i64, plus_s: f64) -> Self {
        if !plus_s.is_finite() {
            return Self {
                seconds,
                fraction: 0.0,
            };
        }
        let whole = plus_s.floor();
        let mut seconds = seconds.saturating_add(whole as i64);
        let mut fraction = plus_s - whole;
        // A tiny negative plus_s floors to −1 and rounds to a fraction of one.
        if fraction >= 1.0 {
            seconds = seconds.saturating_add(1);
            fraction = 0.0;
        }
        // No negative zero: equality and the total order must agree.
        Self {
            seconds,
            fraction: fraction + 0.0,
        }
    }

    /// Whole seconds since 1980-01-06 00:00.
    #[must_use]
    pub const fn seconds(self) -> i64 {
        self.seconds
    }

    /// Fraction of the second, in \[0, 1).
    #[must_use]
    pub const fn fraction(self) -> f64 {
        self.fraction
    }

    /// From a GPS week (not modulo 1024) and seconds of week (any finite number).
    #[must_use]
    pub fn from_week_tow(week: i64, tow_s: f64) -> Self {
        Self::new(week.saturating_mul(SECONDS_PER_WEEK), tow_s)
    }

    /// GPS week, counted from 1980-01-06 without wrapping.
    #[must_use]
    pub const fn week(self) -> i64 {
        self.seconds.div_euclid(SECONDS_PER_WEEK)
    }

    /// Seconds of the GPS week, in \[0, 604800).
    #[must_use]
    pub fn tow_s(self) -> f64 {
        self.seconds.rem_euclid(SECONDS_PER_WEEK) as f64 + self.fraction
    }

    /// From a BeiDou week and seconds of week (BDT, 14 s behind GPST).
    #[must_use]
    pub fn from_bdt_week_sow(week: i64, sow_s: f64) -> Self {
        let start = week
            .saturating_add(BDT_WEEK_OFFSET)
            .saturating_mul(SECONDS_PER_WEEK);
        Self::new(start.saturating_add(BDT_BEHIND_GPST_S), sow_s)
    }

    /// From a date and clock reading in GPST.
    #[must_use]
    pub const fn from_calendar(calendar: &Calendar) -> Self {
        Self {
            seconds: calendar.seconds_from_1970() - GPS_EPOCH_FROM_1970_S,
            fraction: calendar.fraction,
        }
    }

    /// Date and clock reading in GPST.
    #[must_use]
    pub const fn to_calendar(self) -> Calendar {
        Calendar::from_seconds_since_1970(self.seconds + GPS_EPOCH_FROM_1970_S, self.fraction)
    }

    /// From a date and clock reading in UTC.
    ///
    /// # Errors
    /// [`TimeError::Field`] for second 60 of a minute that had no leap second.
    pub fn from_utc(utc: &Calendar) -> Result<Self, TimeError> {
        let utc_s = utc.seconds_from_1970();
        let mut ahead = gpst_minus_utc_at_utc_s(utc_s);
        if utc.second == 60 {
            // 23:59:60 reads as midnight of the next day, before the new difference holds.
            let before = gpst_minus_utc_at_utc_s(utc_s - 1);
            if before == ahead {
                return Err(TimeError::Field {
                    field: "second",
                    value: utc.second_f64(),
                    expected: "0 to below 60: that minute had no leap second",
                });
            }
            ahead = before;
        }
        Ok(Self {
            seconds: utc_s + ahead - GPS_EPOCH_FROM_1970_S,
            fraction: utc.fraction,
        })
    }

    /// Date and clock reading in UTC; second 60 inside a leap second.
    #[must_use]
    pub fn to_utc(self) -> Calendar {
        let (ahead, in_leap_second) = gpst_minus_utc_at_gpst_s(self.seconds);
        let utc_s = self.seconds + GPS_EPOCH_FROM_1970_S - ahead;
        if in_leap_second {
            let mut utc = Calendar::from_seconds_since_1970(utc_s - 1, self.fraction);
            utc.second = 60;
            return utc;
        }
        Calendar::from_seconds_since_1970(utc_s, self.fraction)
    }

    /// GPST − UTC (s) at this instant.
    #[must_use]
    pub fn gpst_minus_utc_s(self) -> i64 {
        gpst_minus_utc_at_gpst_s(self.seconds).0
    }

    /// From seconds since 1970-01-01 00:00 UTC, leap seconds not counted (a computer's clock).
    #[must_use]
    pub fn from_unix(seconds: i64, plus_s: f64) -> Self {
        let t = Self::new(seconds, plus_s);
        let ahead = gpst_minus_utc_at_utc_s(t.seconds);
        Self {
            seconds: t.seconds.saturating_add(ahead - GPS_EPOCH_FROM_1970_S),
            fraction: t.fraction,
        }
    }

    /// From a date and clock reading in GLONASS time, UTC + 3 h.
    ///
    /// # Errors
    /// As [`Self::from_utc`].
    pub fn from_glonass(moscow: &Calendar) -> Result<Self, TimeError> {
        let mut utc = Calendar::from_seconds_since_1970(
            moscow.seconds_from_1970() - i64::from(moscow.second) - GLONASS_AHEAD_OF_UTC_S,
            moscow.fraction,
        );
        utc.second = moscow.second;
        Self::from_utc(&utc)
    }

    /// Date and clock reading in GLONASS time, UTC + 3 h.
    #[must_use]
    pub fn to_glonass(self) -> Calendar {
        let utc = self.to_utc();
        let mut moscow = Calendar::from_seconds_since_1970(
            utc.seconds_from_1970() - i64::from(utc.second) + GLONASS_AHEAD_OF_UTC_S,
            utc.fraction,
        );
        moscow.second = utc.second;
        moscow
    }

    /// `self − earlier` (s), without loss at small differences.
    #[must_use]
    pub fn seconds_since(self, earlier: Self) -> f64 {
        self.seconds.saturating_sub(earlier.seconds) as f64 + (self.fraction - earlier.fraction)
    }

    /// The instant to print with a number of decimals: a fraction that would print as the next second is
    /// carried, others are rounded.
    #[must_use]
    pub fn rounded(self, decimals: usize) -> Self {
        let units = 10f64.powi(decimals.min(12) as i32);
        let rounded = (self.fraction * units).round();
        if rounded >= units {
            Self {
                seconds: self.seconds.saturating_add(1),
                fraction: 0.0,
            }
        } else {
            Self {
                seconds: self.seconds,
                fraction: rounded / units,
            }
        }
    }

    /// `yyyy/mm/dd hh:mm:ss.sss` in GPST with a number of decimals, carried where necessary.
    ///
    /// ```
    /// use acerra_geo::time::GpsTime;
    /// let t = GpsTime::from_week_tow(2445, 518_399.999_6);
    /// assert_eq!(t.format_calendar(3), "2026/11/21 00:00:00.000");
    /// assert_eq!(t.format_week_tow(3), "2445 518400.000");
    /// ```
    #[must_use]
    pub fn format_calendar(self, decimals: usize) -> String {
        format!("{:.decimals$}", self.rounded(decimals).to_calendar())
    }

    /// `yyyy/mm/dd hh:mm:ss.sss` in UTC with a number of decimals, carried where necessary.
    #[must_use]
    pub fn format_utc(self, decimals: usize) -> String {
        format!("{:.decimals$}", self.rounded(decimals).to_utc())
    }

    /// `wwww ssssss.sss`: week and seconds of week with a number of decimals, carried where necessary.
    #[must_use]
    pub fn format_week_tow(self, decimals: usize) -> String {
        let t = self.rounded(decimals);
        let width = if decimals > 0 { 7 + decimals } else { 6 };
        format!("{:4} {:width$.decimals$}", t.week(), t.tow_s())
    }
}

impl Add<f64> for GpsTime {
    type Output = Self;

    fn add(self, seconds: f64) -> Self {
        if !seconds.is_finite() {
            return self;
        }
        // Whole part and fraction apart, so that adding 1e6 s costs no digits of the fraction.
        let whole = seconds.trunc();
        Self::new(
            self.seconds.saturating_add(whole as i64),
            self.fraction + (seconds - whole),
        )
    }
}

impl Sub<f64> for GpsTime {
    type Output = Self;

    fn sub(self, seconds: f64) -> Self {
        self + -seconds
    }
}

impl Sub for GpsTime {
    type Output = f64;

    fn sub(self, earlier: Self) -> f64 {
        self.seconds_since(earlier)
    }
}

/// GPST, `yyyy/mm/dd hh:mm:ss.sss`; the format's precision gives the decimals.
impl std::fmt::Display for GpsTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.format_calendar(f.precision().unwrap_or(3)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(y: i32, mo: u8, d: u8, h: u8, mi: u8, s: f64) -> Calendar {
        Calendar::new(y, mo, d, h, mi, s).expect("a date")
    }

    #[test]
    fn weeks_of_gps_and_beidou() {
        let t = GpsTime::from_calendar(&at(2026, 11, 21, 0, 0, 0.0));
        assert_eq!((t.week(), t.tow_s()), (2445, 518_400.0));
        assert_eq!(GpsTime::from_bdt_week_sow(1089, 518_386.0), t);
        assert_eq!(t.gpst_minus_utc_s(), 18);
        let t = GpsTime::from_week_tow(1400, 86_400.0);
        assert_eq!(t.to_calendar(), at(2006, 11, 6, 0, 0, 0.0));
    }

    #[test]
    fn leap_second_of_2016_has_its_own_name_and_order() {
        let before = GpsTime::from_utc(&at(2016, 12, 31, 23, 59, 59.5)).expect("UTC");
        let inside = GpsTime::from_utc(&at(2016, 12, 31, 23, 59, 60.5)).expect("UTC");
        let after = GpsTime::from_utc(&at(2017, 1, 1, 0, 0, 0.5)).expect("UTC");
        assert_eq!((inside - before, after - inside), (1.0, 1.0));
        assert_eq!(inside.to_utc(), at(2016, 12, 31, 23, 59, 60.5));
        assert_eq!(after.to_utc(), at(2017, 1, 1, 0, 0, 0.5));
        assert!(GpsTime::from_utc(&at(2018, 12, 31, 23, 59, 60.0)).is_err());
        assert_eq!(inside.to_glonass(), at(2017, 1, 1, 2, 59, 60.5));
        assert_eq!(GpsTime::from_glonass(&inside.to_glonass()), Ok(inside));
    }

    #[test]
    fn unix_seconds() {
        let t = GpsTime::from_unix(1_539_087_731, 0.25);
        assert_eq!(t.to_utc(), at(2018, 10, 9, 12, 22, 11.25));
        assert_eq!(t.to_calendar(), at(2018, 10, 9, 12, 22, 29.25));
    }

    #[test]
    fn printed_tags_carry() {
        let t = GpsTime::from_calendar(&at(2023, 12, 31, 23, 59, 59.0)) + 0.9996;
        assert_eq!(t.format_calendar(3), "2024/01/01 00:00:00.000");
        assert_eq!(t.format_calendar(4), "2023/12/31 23:59:59.9996");
        assert_eq!(t.format_calendar(0), "2024/01/01 00:00:00");
        assert_eq!(
            GpsTime::from_week_tow(1316, 5.25).format_week_tow(3),
            "1316      5.250"
        );
    }

    #[test]
    fn a_tiny_negative_step_keeps_the_fraction_below_one() {
        let t = GpsTime::new(10, -1e-20);
        assert_eq!((t.seconds(), t.fraction()), (10, 0.0));
        assert_eq!(GpsTime::new(10, -0.0), GpsTime::new(10, 0.0));
    }
}
