//! The week in which a log was recorded: observation messages give only the time within a week, or a day.

use acerra_geo::time::{Calendar, GpsTime, SECONDS_PER_WEEK};

use super::frame::{Piece, pieces};
use super::measurement::TimeTag;
use super::station;
use crate::orbits::bits::BitCursor;
use crate::rinex::{moscow_time, nearest_week};

/// First week assumed for ten-bit week numbers without other information: the week of 7 April 2019.
const FIRST_WEEK_OF_TEN_BITS: i64 = 2048;

/// Source of a log's date.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum DateSource {
    /// Message 1013, which states the day.
    SystemParameters,
    /// The week number of Galileo or BeiDou ephemerides, or the day of GLONASS ones.
    Ephemerides,
    /// The ten-bit week of GPS or QZSS ephemerides, completed by the time stated.
    TenBitsAndStated,
    /// The ten-bit week of GPS or QZSS ephemerides, the latest one before the log's file was written.
    TenBitsAndFile,
    /// The ten-bit week of GPS or QZSS ephemerides alone: one of 1024 weeks since April 2019.
    TenBits,
    /// The time stated by the caller.
    Stated,
}

/// A time near a log's observations (within a few days), and its source. `stated` is any time within half a
/// week of the log; a date in the log itself takes precedence.
pub(super) fn date_of(
    log: &[u8],
    stated: Option<GpsTime>,
    not_after: Option<GpsTime>,
) -> Option<(GpsTime, DateSource)> {
    // Of the weeks 1024 apart, the week nearest to the stated time is used, or else the last week before the
    // file was written.
    let (since, source) = match (stated, not_after) {
        (Some(t), _) => (t.week() - 512, DateSource::TenBitsAndStated),
        (None, Some(t)) => (t.week() - 1023, DateSource::TenBitsAndFile),
        (None, None) => (FIRST_WEEK_OF_TEN_BITS, DateSource::TenBits),
    };
    let (mut dates, mut weeks, mut ten_bits) = (Vec::new(), Vec::new(), Vec::new());
    for piece in pieces(log) {
        let Piece::Frame(frame) = piece else { continue };
        if frame.number == 1013 {
            dates.extend(station::date(frame.payload));
        }
        weeks.extend(full_date(frame.number, frame.payload));
        ten_bits.extend(ten_bit_date(frame.number, frame.payload, since));
    }
    for (times, source) in [
        (dates, DateSource::SystemParameters),
        (weeks, DateSource::Ephemerides),
        (ten_bits, source),
    ] {
        if let Some(date) = median(times) {
            return Some((date, source));
        }
    }
    stated.map(|t| (t, DateSource::Stated))
}

/// The median, which single wrong dates do not move.
fn median(mut times: Vec<GpsTime>) -> Option<GpsTime> {
    times.sort();
    times.get(times.len() / 2).copied()
}

/// The reference time of an ephemeris whose message gives the date unambiguously.
fn full_date(number: u16, payload: &[u8]) -> Option<GpsTime> {
    let mut bits = BitCursor::new(payload);
    match number {
        1042 => {
            bits.skip(18)?;
            let week = bits.unsigned(13)?.cast_signed();
            bits.skip(4 + 14 + 5)?;
            let toc_s = bits.unsigned(17)? as f64 * 8.0;
            Some(GpsTime::from_bdt_week_sow(week, toc_s))
        }
        1045 | 1046 => {
            bits.skip(18)?;
            let week = bits.unsigned(12)?.cast_signed();
            bits.skip(10 + 8 + 14)?;
            let toc_s = bits.unsigned(14)? as f64 * 60.0;
            Some(GpsTime::from_week_tow(week + 1024, toc_s))
        }
        1020 => {
            // Time of the frame, then N_T behind F_T; N_4 behind N_A and τ_c, where given.
            bits.skip(27)?;
            let frame_s =
                bits.unsigned(5)? * 3600 + bits.unsigned(6)? * 60 + bits.unsigned(1)? * 30;
            bits.skip(268 - 39)?;
            let day = bits.unsigned(11)?.cast_signed();
            bits.skip(2)?;
            let given = bits.flag()?;
            bits.skip(11 + 32)?;
            let four_years = i32::try_from(bits.unsigned(5)?).ok()?;
            if !given || four_years == 0 || !(1..=1461).contains(&day) {
                return None;
            }
            let start = Calendar::new(1996 + 4 * (four_years - 1), 1, 1, 0, 0, 0.0).ok()?;
            let seconds = start.seconds_from_1970() + (day - 1) * 86_400 + frame_s.cast_signed();
            GpsTime::from_glonass(&Calendar::from_seconds_since_1970(seconds, 0.0)).ok()
        }
        _ => None,
    }
}

/// The reference time of a GPS or QZSS ephemeris in the first 1024 weeks from `since` on.
fn ten_bit_date(number: u16, payload: &[u8], since: i64) -> Option<GpsTime> {
    let mut bits = BitCursor::new(payload);
    let (before, between) = match number {
        1019 => (18, 4 + 2 + 14 + 8),
        1044 => {
            bits.skip(16)?;
            let toc_s = bits.unsigned(16)? as f64 * 16.0;
            bits.skip(446 - 32)?;
            let week = bits.unsigned(10)?.cast_signed();
            return Some(in_era(week, toc_s, since));
        }
        _ => return None,
    };
    bits.skip(before)?;
    let week = bits.unsigned(10)?.cast_signed();
    bits.skip(between)?;
    let toc_s = bits.unsigned(16)? as f64 * 16.0;
    Some(in_era(week, toc_s, since))
}

fn in_era(week: i64, toc_s: f64, since: i64) -> GpsTime {
    GpsTime::from_week_tow(since + (week - since).rem_euclid(1024), toc_s)
}

/// The instant nearest to `near` with the tag `tag`; `None` for a tag outside the week or day.
pub(super) fn resolve(tag: TimeTag, near: GpsTime) -> Option<GpsTime> {
    let seconds = |ms: u32| f64::from(ms) * 1e-3;
    let week_s = SECONDS_PER_WEEK as f64;
    match tag {
        TimeTag::GpsWeek(ms) => (seconds(ms) < week_s).then(|| on_milliseconds(near, ms)),
        TimeTag::BeidouWeek(ms) => (seconds(ms) < week_s)
            .then(|| on_milliseconds(near - 14.0, ms) + acerra_geo::time::BDT_BEHIND_GPST_S as f64),
        // A leap second may make the day a second longer.
        TimeTag::GlonassDay(ms) => (ms < 86_401_000)
            .then(|| moscow_time(near, seconds(ms)))
            .flatten(),
    }
}

/// The time with `ms` milliseconds of the week that is nearest to `near`, without rounding of seconds in
/// floating point.
fn on_milliseconds(near: GpsTime, ms: u32) -> GpsTime {
    let whole = nearest_week(near, f64::from(ms / 1000));
    GpsTime::new(whole.seconds(), f64::from(ms % 1000) * 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_find_their_week_and_day() {
        let near = GpsTime::from_week_tow(2262, 3.0);
        let at = |tag| resolve(tag, near).unwrap();
        assert_eq!(
            at(TimeTag::GpsWeek(604_799_900)),
            GpsTime::new(2262 * SECONDS_PER_WEEK - 1, 0.9)
        );
        assert_eq!(at(TimeTag::GpsWeek(200)), GpsTime::from_week_tow(2262, 0.2));
        // BeiDou's week begins 14 s after that of GPS.
        assert_eq!(
            at(TimeTag::BeidouWeek(604_790_000)),
            GpsTime::from_week_tow(2262, 4.0)
        );
        assert_eq!(
            at(TimeTag::BeidouWeek(500)),
            GpsTime::from_week_tow(2262, 14.5)
        );
        assert_eq!(resolve(TimeTag::GpsWeek(604_800_000), near), None);
        // Sunday 0:00:03 GPS time is Sunday 2:59:45 in Moscow.
        let moscow = (2 * 3600 + 59 * 60 + 45) * 1000 + 250;
        assert_eq!(
            at(TimeTag::GlonassDay(moscow)),
            GpsTime::from_week_tow(2262, 3.25)
        );
    }

    #[test]
    fn ten_bits_of_the_week_count_from_the_era() {
        assert_eq!(in_era(214, 0.0, 2048).week(), 2262);
        assert_eq!(in_era(214, 0.0, 1238 - 512).week(), 1238);
        assert_eq!(in_era(1023, 0.0, 2048).week(), 3071);
    }
}
