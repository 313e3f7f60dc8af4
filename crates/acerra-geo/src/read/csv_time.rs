//! Times of tables: numbers of some clock, dates and times of day as text.

use super::ReadError;
use super::assemble::Stamp;
use super::error::quoted;
use super::lines::Line;
use crate::time::{Calendar, GpsTime};

/// 1980-01-06 counted from 1970-01-01 (s).
const GPS_EPOCH_FROM_1970_S: i64 = 315_964_800;

/// Sizes of the units in which clocks count from 1970, and the least count of the years 1973 to 2103 in each:
/// the ranges of the units do not overlap.
const UNITS: [(f64, f64); 4] = [(1.0, 1e8), (1e-3, 1e11), (1e-6, 1e14), (1e-9, 1e17)];
/// Range of such a count, largest to least.
const YEARS: f64 = 42.0;

/// The size of the unit (s) in which a number counts from 1970; none for other numbers.
fn unit_from_1970_s(value: f64) -> Option<f64> {
    UNITS
        .iter()
        .find(|(_, least)| (*least..YEARS * least).contains(&value))
        .map(|(unit_s, _)| *unit_s)
}

/// Seconds since 1970, whole and rest apart: one f64 would keep a quarter of a microsecond. `scale` is the unit where
/// the header names it.
fn from_1970(line: &Line<'_>, text: &str, scale: Option<f64>) -> Result<(i64, f64), ReadError> {
    let value = line.number_in("time", text, -1e21..=1e21, "a count since 1970")?;
    let scale = scale.or_else(|| unit_from_1970_s(value)).unwrap_or(1.0);
    let seconds = value * scale;
    if seconds.abs() > 1e11 {
        return Err(ReadError::OutOfRange {
            line: line.number,
            field: "time".to_owned(),
            value: seconds,
            expected: "seconds since 1970",
        });
    }
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    if let (Ok(whole), Ok(part)) = (whole.parse::<i64>(), format!("0.{part}").parse::<f64>())
        && whole >= 0
        && let per_second = (1.0 / scale).round() as i64
        && per_second >= 1
    {
        let rest = (whole % per_second) as f64 + part;
        return Ok((whole / per_second, rest * scale));
    }
    Ok((seconds.floor() as i64, seconds - seconds.floor()))
}

/// A count since 1970 of GPS time or UTC.
pub(super) fn of_1970(
    line: &Line<'_>,
    text: &str,
    scale: Option<f64>,
    is_gpst: bool,
) -> Result<Stamp, ReadError> {
    let (whole, part) = from_1970(line, text, scale)?;
    Ok(Stamp::Gps(if is_gpst {
        GpsTime::new(whole - GPS_EPOCH_FROM_1970_S, part)
    } else {
        GpsTime::from_unix(whole, part)
    }))
}

/// A number of a clock that the header does not name: milli-, micro- or nanoseconds since 1970 where its size
/// excludes other units, else seconds from an unknown zero.
pub(super) fn of_a_clock(
    line: &Line<'_>,
    text: &str,
    scale: Option<f64>,
) -> Result<Stamp, ReadError> {
    let value = line.number("time", text)?;
    if scale.is_none() && unit_from_1970_s(value).is_some_and(|unit_s| unit_s < 1.0) {
        return of_1970(line, text, None, false);
    }
    let seconds = value * scale.unwrap_or(1.0);
    if seconds.abs() > 1e11 {
        return Err(ReadError::OutOfRange {
            line: line.number,
            field: "time".to_owned(),
            value: seconds,
            expected: "seconds within 1e11 (milliseconds are named time_ms)",
        });
    }
    Ok(Stamp::Seconds(seconds))
}

/// Whether a cell holds a date or a time of day rather than a number.
pub(super) fn is_calendar(text: &str) -> bool {
    text.get(4..5).is_some_and(|c| c == "-" || c == "/") && text.len() >= 8
}

/// An instant of `yyyy-mm-dd` and `hh:mm:ss.sss` (or `yyyy/mm/dd`), with the difference from UTC as `Z`, `+hh:mm`,
/// `+hhmm` or `+hh`. The flag is whether the difference is stated; without one the time is taken as UTC.
pub(super) fn of_calendar(
    line: &Line<'_>,
    date: &str,
    clock: &str,
) -> Result<(GpsTime, bool), ReadError> {
    let bad = || {
        line.malformed(
            "a number of seconds or yyyy-mm-ddThh:mm:ss[.sss][Z or +hh:mm]",
            quoted(&format!("{date} {clock}")),
        )
    };
    let clock = clock.trim();
    let (clock, ahead_s) = match clock.strip_suffix(['Z', 'z']) {
        Some(clock) => (clock, Some(0.0)),
        None => match clock.rfind(['+', '-']) {
            Some(at) => (
                &clock[..at],
                Some(ahead_of_utc_s(&clock[at..]).ok_or_else(bad)?),
            ),
            None => (clock, None),
        },
    };
    let date: Vec<&str> = date.trim().split(['-', '/']).collect();
    let clock: Vec<&str> = clock.trim().split(':').collect();
    let (&[y, mo, d], &[h, mi, s]) = (date.as_slice(), clock.as_slice()) else {
        return Err(bad());
    };
    let calendar = Calendar::new(
        y.parse().map_err(|_| bad())?,
        mo.parse().map_err(|_| bad())?,
        d.parse().map_err(|_| bad())?,
        h.parse().map_err(|_| bad())?,
        mi.parse().map_err(|_| bad())?,
        s.parse().map_err(|_| bad())?,
    );
    let utc = calendar.and_then(|c| match ahead_s {
        None | Some(0.0) => GpsTime::from_utc(&c),
        Some(ahead_s) => GpsTime::from_utc(&(GpsTime::from_calendar(&c) - ahead_s).to_calendar()),
    });
    let utc = utc.map_err(|e| line.malformed("a date and time of UTC", e.to_string()))?;
    Ok((utc, ahead_s.is_some()))
}

/// `+hh:mm`, `+hhmm` or `+hh` (s).
fn ahead_of_utc_s(text: &str) -> Option<f64> {
    let (sign, digits) = match text.split_at_checked(1)? {
        ("+", digits) => (1.0, digits),
        ("-", digits) => (-1.0, digits),
        _ => return None,
    };
    let digits = digits.replace(':', "");
    if !digits.bytes().all(|b| b.is_ascii_digit()) || ![2, 4].contains(&digits.len()) {
        return None;
    }
    let hours: f64 = digits[..2].parse().ok()?;
    let minutes: f64 = digits.get(2..4).map_or(Some(0.0), |m| m.parse().ok())?;
    (hours <= 15.0 && minutes < 60.0).then_some(sign * (3_600.0 * hours + 60.0 * minutes))
}

/// Relation of dates in whole seconds to a finer clock in the same rows: the instant of the finer clock's
/// zero, and its uncertainty (s). None where the dates are fine enough, or do not fit that clock.
pub(super) fn zero_of_finer(pairs: &[(GpsTime, f64)]) -> Option<(GpsTime, f64)> {
    let (first, _) = *pairs.first()?;
    let repeats = pairs
        .windows(2)
        .any(|w| w[0].0 == w[1].0 && w[0].1 < w[1].1);
    if !repeats {
        return None;
    }
    // Dates are cut to whole seconds: the instant lies within the second after the date.
    let zeros = || pairs.iter().map(|(date, fine_s)| (*date - first) - fine_s);
    let least = zeros().fold(f64::NEG_INFINITY, f64::max);
    let most = zeros().fold(f64::INFINITY, f64::min) + 1.0;
    (most > least).then(|| (first + 0.5 * (least + most), 0.5 * (most - least)))
}
