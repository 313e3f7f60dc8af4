//! Dates and clock readings, without a time scale.

use super::TimeError;

/// 1980-01-06 00:00 counted from 1970-01-01 00:00 (s).
pub(super) const GPS_EPOCH_FROM_1970_S: i64 = 315_964_800;

/// A date and a clock reading, in whatever time scale the context says.
///
/// ```
/// use acerra_geo::time::Calendar;
///
/// let c = Calendar::new(2026, 11, 21, 12, 30, 15.25)?;
/// assert_eq!(c.to_string(), "2026/11/21 12:30:15.250");
/// assert!(Calendar::new(2026, 2, 29, 0, 0, 0.0).is_err());
/// # Ok::<(), acerra_geo::time::TimeError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calendar {
    /// Gregorian year, 1970 to 2099.
    pub year: i32,
    /// Month, 1 to 12.
    pub month: u8,
    /// Day of the month, from 1.
    pub day: u8,
    /// Hour, 0 to 23.
    pub hour: u8,
    /// Minute, 0 to 59.
    pub minute: u8,
    /// Whole seconds, 0 to 59, or 60 in a leap second of UTC.
    pub second: u8,
    /// Fraction of the second, in \[0, 1).
    pub fraction: f64,
}

const fn is_leap_year(year: i32) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

const fn days_in_month(year: i32, month: u8) -> u8 {
    match month {
        2 if is_leap_year(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01 to a Gregorian date, by counting years from March, when the leap day is
/// the last of the year.
const fn days_from_1970(year: i32, month: u8, day: u8) -> i64 {
    let y = if month > 2 { year } else { year - 1 } as i64;
    let m = (month as i64 + 9) % 12;
    let day_of_year = (153 * m + 2) / 5 + day as i64 - 1;
    365 * y + y.div_euclid(4) - y.div_euclid(100) + y.div_euclid(400) + day_of_year - 719_468
}

/// The Gregorian date of a day counted from 1970-01-01.
const fn date_from_days(days: i64) -> (i32, u8, u8) {
    let z = days + 719_468;
    let era = z.div_euclid(146_097);
    let day_of_era = z.rem_euclid(146_097);
    let year_of_era =
        (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let m = (5 * day_of_year + 2) / 153;
    let day = (day_of_year - (153 * m + 2) / 5 + 1) as u8;
    let month = if m < 10 { m + 3 } else { m - 9 } as u8;
    let year = (era * 400 + year_of_era) as i32 + if month <= 2 { 1 } else { 0 };
    (year, month, day)
}

/// The full year of a two-digit one: below 80 is 20xx, else 19xx. Others are returned as they are.
#[must_use]
pub const fn full_year(year: i32) -> i32 {
    match year {
        0..80 => 2000 + year,
        80..100 => 1900 + year,
        _ => year,
    }
}

impl Calendar {
    /// A date and clock reading, checked.
    ///
    /// # Errors
    /// [`TimeError::Field`] for a year outside 1970–2099, a day the month does not have, or a
    /// clock field out of range. A second may be up to (not including) 61: whether that minute
    /// has a leap second is for the time scale to judge.
    pub fn new(
        year: i32,
        month: u8,
        day: u8,
        hour: u8,
        minute: u8,
        second: f64,
    ) -> Result<Self, TimeError> {
        let check = |ok: bool, field, value: f64, expected| {
            if ok {
                Ok(())
            } else {
                Err(TimeError::Field {
                    field,
                    value,
                    expected,
                })
            }
        };
        check(
            (1970..2100).contains(&year),
            "year",
            year.into(),
            "1970 to 2099",
        )?;
        check((1..=12).contains(&month), "month", month.into(), "1 to 12")?;
        check(
            (1..=days_in_month(year, month)).contains(&day),
            "day",
            day.into(),
            "a day of that month",
        )?;
        check(hour < 24, "hour", hour.into(), "0 to 23")?;
        check(minute < 60, "minute", minute.into(), "0 to 59")?;
        check(
            (0.0..61.0).contains(&second),
            "second",
            second,
            "0 to below 61",
        )?;
        let whole = second.floor();
        Ok(Self {
            year,
            month,
            day,
            hour,
            minute,
            second: whole as u8,
            fraction: second - whole,
        })
    }

    /// Whole seconds from 1970-01-01 00:00 on the same clock, leap seconds not counted.
    ///
    /// A reading of 60 s counts as the first second of the next minute.
    #[must_use]
    pub const fn seconds_from_1970(&self) -> i64 {
        days_from_1970(self.year, self.month, self.day) * 86_400
            + self.hour as i64 * 3_600
            + self.minute as i64 * 60
            + self.second as i64
    }

    /// The reading of a clock `seconds` whole seconds and `fraction` (in \[0, 1)) after
    /// 1970-01-01 00:00.
    #[must_use]
    pub const fn from_seconds_since_1970(seconds: i64, fraction: f64) -> Self {
        let (year, month, day) = date_from_days(seconds.div_euclid(86_400));
        let of_day = seconds.rem_euclid(86_400);
        Self {
            year,
            month,
            day,
            hour: (of_day / 3_600) as u8,
            minute: (of_day / 60 % 60) as u8,
            second: (of_day % 60) as u8,
            fraction,
        }
    }

    /// Seconds of the minute with their fraction.
    #[must_use]
    pub fn second_f64(&self) -> f64 {
        f64::from(self.second) + self.fraction
    }

    /// Day of the year, from 1.
    #[must_use]
    pub const fn day_of_year(&self) -> u16 {
        (days_from_1970(self.year, self.month, self.day) - days_from_1970(self.year, 1, 1) + 1)
            as u16
    }
}

/// `yyyy/mm/dd hh:mm:ss.sss`; the format's precision (`{:.1}`, default 3) gives the decimals.
///
/// The fraction is cut, not rounded: round before, with
/// [`GpsTime::rounded`](super::GpsTime::rounded), so that the carry reaches the date.
impl std::fmt::Display for Calendar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let decimals = f.precision().unwrap_or(3).min(12);
        write!(
            f,
            "{:04}/{:02}/{:02} {:02}:{:02}:{:02}",
            self.year, self.month, self.day, self.hour, self.minute, self.second
        )?;
        if decimals > 0 {
            let units = 10f64.powi(decimals as i32);
            // A hair is added so that a fraction just rounded to these decimals is not cut below.
            let digits = (self.fraction * units + 1e-3).floor().min(units - 1.0);
            write!(f, ".{:0decimals$}", digits as u64)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_day_of_130_years_returns() {
        let mut days = days_from_1970(1970, 1, 1);
        assert_eq!(days, 0);
        for year in 1970..2100 {
            for month in 1..=12u8 {
                for day in 1..=days_in_month(year, month) {
                    assert_eq!(days_from_1970(year, month, day), days);
                    assert_eq!(date_from_days(days), (year, month, day));
                    days += 1;
                }
            }
        }
        assert_eq!(days, 47_482);
    }

    #[test]
    fn day_of_year_counts_the_leap_day() -> Result<(), TimeError> {
        assert_eq!(Calendar::new(2024, 12, 31, 0, 0, 0.0)?.day_of_year(), 366);
        assert_eq!(Calendar::new(2023, 3, 1, 0, 0, 0.0)?.day_of_year(), 60);
        Ok(())
    }

    #[test]
    fn impossible_fields_are_named() {
        for (result, field) in [
            (Calendar::new(1969, 1, 1, 0, 0, 0.0), "year"),
            (Calendar::new(2000, 13, 1, 0, 0, 0.0), "month"),
            (Calendar::new(2001, 2, 29, 0, 0, 0.0), "day"),
            (Calendar::new(2001, 2, 28, 24, 0, 0.0), "hour"),
            (Calendar::new(2001, 2, 28, 0, 60, 0.0), "minute"),
            (Calendar::new(2001, 2, 28, 0, 0, 61.0), "second"),
            (Calendar::new(2001, 2, 28, 0, 0, f64::NAN), "second"),
        ] {
            assert!(matches!(result, Err(TimeError::Field { field: f, .. }) if f == field));
        }
    }

    #[test]
    fn two_digit_years() {
        assert_eq!(
            (full_year(79), full_year(80), full_year(2005)),
            (2079, 1980, 2005)
        );
    }
}
