//! NMEA 0183: positions of GGA, or of GNS where there is no GGA, dated by RMC or ZDA, with GST's standard deviations.

use std::io::BufRead;

use super::assemble::{Assembler, Axes, Record, Stamp, in_proportion};
use super::digits::{Digits, degrees_in_m};
use super::lines::{Line, Lines};
use super::{ReadError, ReadOptions, ReadReport, ReadWarning, SkipReason, TrajectoryFormat};
use crate::geodesy::{EnuFrame, Geodetic, ecef_from_geodetic};
use crate::time::{Calendar, GpsTime, full_year};
use crate::trajectory::{Fix, SolutionStatus, TimeOrigin, Trajectory};

const DAY_S: f64 = 86_400.0;
/// Standard deviations that positions can have, m, as in the other formats.
const DEVIATIONS_M: std::ops::RangeInclusive<f64> = 0.0..=1e8;

/// The status of GGA's quality; none for "no fix".
pub(super) const fn status_of_quality(quality: u32) -> Option<SolutionStatus> {
    match quality {
        0 => None,
        1 | 3 => Some(SolutionStatus::Single),
        2 => Some(SolutionStatus::Dgps),
        4 => Some(SolutionStatus::Fixed),
        5 => Some(SolutionStatus::Float),
        8 => Some(SolutionStatus::External),
        _ => Some(SolutionStatus::Unknown),
    }
}

/// Whether a line holds the start of a positioning sentence, its checksum right or wrong.
pub(super) fn has_known_sentence(text: &str) -> bool {
    text.split('$').skip(1).any(|s| {
        matches!(
            s.get(2..6),
            Some("GGA," | "GNS," | "RMC," | "ZDA," | "GSA," | "GSV," | "GLL," | "VTG," | "GST,")
        )
    })
}

enum Sentence<'a> {
    Good {
        kind: &'a str,
        fields: Vec<&'a str>,
        checked: bool,
    },
    WrongChecksum,
    Broken,
}

/// Splits the text after a `$`.
fn sentence(text: &str) -> Sentence<'_> {
    let text = text.trim_end();
    let (body, checked) = match text.split_once('*') {
        Some((body, tail)) => {
            let Some(Ok(stated)) = tail.get(..2).map(|t| u8::from_str_radix(t, 16)) else {
                return Sentence::Broken;
            };
            if body.bytes().fold(0, |sum, b| sum ^ b) != stated {
                return Sentence::WrongChecksum;
            }
            (body, true)
        }
        None => (text, false),
    };
    let mut fields = body.split(',');
    match fields.next() {
        Some(kind) if kind.len() >= 3 && kind.bytes().all(|b| b.is_ascii_alphanumeric()) => {
            Sentence::Good {
                kind,
                fields: fields.collect(),
                checked,
            }
        }
        _ => Sentence::Broken,
    }
}

/// The status of GNS's modes, a letter for each constellation: that of the best; none for "no fix".
fn status_of_modes(modes: &str) -> Option<SolutionStatus> {
    let has = |letters: &str| modes.contains(|c| letters.contains(c));
    match () {
        () if has("R") => Some(SolutionStatus::Fixed),
        () if has("F") => Some(SolutionStatus::Float),
        () if has("D") => Some(SolutionStatus::Dgps),
        () if has("AP") => Some(SolutionStatus::Single),
        () if has("EMS") => Some(SolutionStatus::Unknown),
        () => None,
    }
}

/// A position before its date and height are settled.
struct Gga {
    /// Whether it is of a GNS sentence.
    is_gns: bool,
    line: u64,
    /// Seconds from midnight UTC of the day of the first position, or of 1970 once dated.
    time_s: f64,
    latitude_deg: f64,
    longitude_deg: f64,
    height_above_sea_m: f64,
    separation_m: Option<f64>,
    fix: Fix,
}

#[derive(Default)]
struct Log {
    positions: Vec<Gga>,
    /// Digits of longitude, latitude (minutes) and height.
    digits: [Digits; 3],
    /// The last instant a dated sentence gave: UTC seconds since 1970.
    dated_s: Option<f64>,
    /// Positions before this one have their date.
    settled: usize,
    deviations: Option<(f64, [f64; 3])>,
    unchecked: u64,
    bad: u64,
    first_bad: u64,
    good: u64,
}

pub(super) fn read<R: BufRead>(
    lines: &mut Lines<R>,
    options: &ReadOptions,
) -> Result<(Trajectory, ReadReport), ReadError> {
    let mut all = Assembler::new(options, ReadReport::new(TrajectoryFormat::Nmea));
    let mut log = Log::default();
    let mut read_bytes = 0;
    while let Some(line) = lines.next()? {
        let mut parts = line.text.split('$');
        parts.next(); // Content before the first sentence: binary messages, a cut start.
        for part in parts {
            log.take(&line, part, &mut all)?;
        }
        read_bytes = line.read_bytes;
        let bytes_each = size_of::<Gga>() + size_of::<Record>();
        in_proportion(log.positions.len(), bytes_each, line.number, read_bytes)?;
        if log.positions.len() > options.max_fixes {
            return Err(ReadError::Limit {
                line: line.number,
                what: "positions",
                limit: options.max_fixes,
            });
        }
    }
    if log.bad > log.good {
        return Err(ReadError::MostlyBad {
            bad: log.bad,
            total: log.bad + log.good,
            line: log.first_bad,
            reason: "broken sentences or wrong checksums".to_owned(),
        });
    }
    log.finish(&mut all, read_bytes)?;
    all.finish(
        &Axes::Ecef { reference_m: None },
        TimeOrigin::UtcMidnight,
        lines.count(),
    )
}

impl Log {
    fn take(
        &mut self,
        line: &Line<'_>,
        text: &str,
        all: &mut Assembler<'_>,
    ) -> Result<(), ReadError> {
        let (kind, fields) = match sentence(text) {
            Sentence::Good {
                kind,
                fields,
                checked,
            } => {
                self.unchecked += u64::from(!checked);
                (kind, fields)
            }
            Sentence::WrongChecksum => return self.bad(line, SkipReason::Checksum, all),
            Sentence::Broken => return self.bad(line, SkipReason::Broken, all),
        };
        // Proprietary sentences ($P…) have separate names and are skipped.
        let name = if kind.len() == 5 { &kind[2..] } else { "" };
        let understood = match name {
            "GGA" => self.gga(line, &fields, all),
            "GNS" => self.gns(line, &fields, all),
            "RMC" => self.rmc(&fields),
            "ZDA" => self.zda(&fields),
            "GST" => self.gst(&fields),
            _ => Some(()),
        };
        if understood.is_none() {
            return self.bad(line, SkipReason::Broken, all);
        }
        self.good += 1;
        Ok(())
    }

    fn bad(
        &mut self,
        line: &Line<'_>,
        reason: SkipReason,
        all: &mut Assembler<'_>,
    ) -> Result<(), ReadError> {
        if self.bad == 0 {
            self.first_bad = line.number;
        }
        self.bad += 1;
        all.skip(reason, line.number);
        Ok(())
    }

    /// The position of GGA; none when a field is invalid.
    fn gga(&mut self, line: &Line<'_>, f: &[&str], all: &mut Assembler<'_>) -> Option<()> {
        let quality: u32 = f.get(5)?.parse().ok()?;
        let status = status_of_quality(quality);
        self.position(line, f, status, [f.get(10), f.get(12)], all)
    }

    /// The position of GNS, which has modes in place of the quality and no units.
    fn gns(&mut self, line: &Line<'_>, f: &[&str], all: &mut Assembler<'_>) -> Option<()> {
        let status = status_of_modes(f.get(5)?);
        self.position(line, f, status, [f.get(9), f.get(10)], all)?;
        if status.is_some() {
            self.positions.last_mut()?.is_gns = true;
        }
        Some(())
    }

    /// The fields common to both, with the geoid's separation and the age of corrections.
    fn position(
        &mut self,
        line: &Line<'_>,
        f: &[&str],
        status: Option<SolutionStatus>,
        [separation, age]: [Option<&&str>; 2],
        all: &mut Assembler<'_>,
    ) -> Option<()> {
        let Some(status) = status else {
            all.skip(SkipReason::NoFix, line.number);
            return Some(());
        };
        let of_day = time_of_day(f.first()?)?;
        let latitude_deg = angle(f.get(1)?, f.get(2)?, 'N', 'S', 90.0)?;
        let longitude_deg = angle(f.get(3)?, f.get(4)?, 'E', 'W', 180.0)?;
        let height_above_sea_m = finite(f.get(8)?).filter(|h| h.abs() < 4e8)?;
        let separation_m = match separation {
            Some(text) if !text.is_empty() => Some(finite(text).filter(|s| s.abs() < 1e3)?),
            _ => None,
        };
        for (digits, field) in self.digits.iter_mut().zip([3, 1, 8]) {
            digits.take(f.get(field)?);
        }
        let mut fix = Fix::new(0.0, [0.0; 3]);
        fix.status = status;
        fix.satellites = f.get(6).and_then(|n| n.parse().ok());
        fix.age_s = age.and_then(|a| finite(a));
        if let Some((_, sd)) = self.deviations.filter(|(t, _)| *t == of_day) {
            fix.covariance_m2 = Some(diagonal(sd));
        }
        let near = match (self.dated_s, self.positions.last()) {
            (Some(dated), _) => Some(dated),
            (None, Some(before)) => Some(before.time_s),
            (None, None) => None,
        };
        let time_s = near.map_or(of_day, |near| nearest_day(of_day, near));
        self.positions.push(Gga {
            is_gns: false,
            line: line.number,
            time_s,
            latitude_deg,
            longitude_deg,
            height_above_sea_m,
            separation_m,
            fix,
        });
        if self.dated_s.is_some() {
            self.settled = self.positions.len();
        }
        Some(())
    }

    /// The date of a fix; none without a date (before the first fix).
    fn rmc(&mut self, f: &[&str]) -> Option<()> {
        let date = f.get(8).copied().unwrap_or_default();
        if date.is_empty() || f.first()?.is_empty() {
            return Some(());
        }
        if date.len() != 6 || !date.is_ascii() {
            return None;
        }
        let part = |r: std::ops::Range<usize>| date.get(r)?.parse::<u8>().ok();
        self.date(
            i32::from(part(4..6)?),
            part(2..4)?,
            part(0..2)?,
            time_of_day(f[0])?,
        )
    }

    fn zda(&mut self, f: &[&str]) -> Option<()> {
        if f.get(..4)?.iter().any(|f| f.is_empty()) {
            return Some(());
        }
        self.date(
            f[3].parse().ok()?,
            f[2].parse().ok()?,
            f[1].parse().ok()?,
            time_of_day(f[0])?,
        )
    }

    /// A dated instant: also dates the sentences before the first one.
    fn date(&mut self, year: i32, month: u8, day: u8, of_day: f64) -> Option<()> {
        let midnight = Calendar::new(full_year(year), month, day, 0, 0, 0.0).ok()?;
        let dated_s = midnight.seconds_from_1970() as f64 + of_day;
        if self.dated_s.is_none()
            && let Some(last) = self.positions.last()
        {
            // The undated ones ran on from midnight of the first; the last is the nearest.
            let last_dated = nearest_day(last.time_s.rem_euclid(DAY_S), dated_s);
            let shift = last_dated - last.time_s;
            for position in &mut self.positions {
                position.time_s += shift;
            }
            self.settled = self.positions.len();
        }
        self.dated_s = Some(dated_s);
        Some(())
    }

    fn gst(&mut self, f: &[&str]) -> Option<()> {
        let of_day = time_of_day(f.first()?)?;
        let (Some(north), Some(east), Some(up)) =
            (finite(f.get(5)?), finite(f.get(6)?), finite(f.get(7)?))
        else {
            return Some(()); // Empty without a fix.
        };
        let sd = [east, north, up];
        if !sd.iter().all(|sd| DEVIATIONS_M.contains(sd)) {
            return None;
        }
        self.deviations = Some((of_day, sd));
        if let Some(last) = self.positions.last_mut()
            && (last.time_s.rem_euclid(DAY_S) - of_day).abs() < 1e-6
        {
            last.fix.covariance_m2 = Some(diagonal(sd));
        }
        Some(())
    }

    /// Hands the positions on, heights brought to the ellipsoid.
    fn finish(mut self, all: &mut Assembler<'_>, read_bytes: u64) -> Result<(), ReadError> {
        let dated = self.settled > 0;
        if self.positions.iter().any(|p| !p.is_gns) {
            self.positions.retain(|p| !p.is_gns);
        }
        let [longitude, latitude, up] = self.digits.each_ref().map(Digits::step);
        if let (Some(longitude), Some(latitude), Some(first)) =
            (longitude, latitude, self.positions.first())
        {
            let minutes_m = degrees_in_m(first.latitude_deg).map(|m| m / 60.0);
            all.report.resolution_m = Some([
                longitude * minutes_m[0],
                latitude * minutes_m[1],
                up.unwrap_or(0.0),
            ]);
        }
        if !dated && !self.positions.is_empty() {
            all.report.warnings.push(ReadWarning::NoDate);
        }
        if self.unchecked > 0 {
            all.report.warnings.push(ReadWarning::NoChecksum {
                count: self.unchecked,
            });
        }
        let any_separation = self.positions.iter().any(|p| p.separation_m.is_some());
        for p in self.positions {
            if any_separation && p.separation_m.is_none() {
                all.skip(SkipReason::NoGeoidSeparation, p.line);
                continue;
            }
            let above_sea =
                Geodetic::from_degrees(p.latitude_deg, p.longitude_deg, p.height_above_sea_m);
            let place = match p.separation_m {
                Some(separation_m) => Geodetic {
                    height_m: p.height_above_sea_m + separation_m,
                    ..above_sea
                },
                None => all.above_ellipsoid(above_sea),
            };
            let mut fix = p.fix;
            fix.position_m = ecef_from_geodetic(&place);
            fix.covariance_m2 = fix
                .covariance_m2
                .map(|c| EnuFrame::new(place).ecef_covariance_from_enu(&c));
            let stamp = if dated {
                let whole = p.time_s.floor();
                Stamp::Gps(GpsTime::from_unix(whole as i64, micro(p.time_s - whole)))
            } else {
                Stamp::Seconds(p.time_s)
            };
            let record = Record {
                line: p.line,
                stamp,
                fix,
            };
            all.push(record, read_bytes)?;
        }
        Ok(())
    }
}

/// Seconds since 1970 in an f64 keep a quarter of a microsecond: the rest is not data.
fn micro(fraction: f64) -> f64 {
    (fraction * 1e6).round() / 1e6
}

fn finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|v| v.is_finite())
}

const fn diagonal(sd: [f64; 3]) -> [[f64; 3]; 3] {
    [
        [sd[0] * sd[0], 0.0, 0.0],
        [0.0, sd[1] * sd[1], 0.0],
        [0.0, 0.0, sd[2] * sd[2]],
    ]
}

/// `hhmmss.sss` as seconds from midnight.
fn time_of_day(text: &str) -> Option<f64> {
    let two = |r: std::ops::Range<usize>| {
        let digits = text.get(r)?;
        digits
            .bytes()
            .all(|b| b.is_ascii_digit())
            .then(|| digits.parse::<f64>().ok())?
    };
    let (h, m) = (two(0..2)?, two(2..4)?);
    two(4..6)?;
    let s = finite(text.get(4..)?)?;
    (h < 24.0 && m < 60.0 && (0.0..61.0).contains(&s)).then_some(h * 3_600.0 + m * 60.0 + s)
}

/// `dddmm.mmmm` and a letter as degrees.
fn angle(text: &str, letter: &str, plus: char, minus: char, limit: f64) -> Option<f64> {
    let value = finite(text).filter(|v| *v >= 0.0)?;
    let degrees = (value / 100.0).floor();
    let minutes = value - 100.0 * degrees;
    let angle = degrees + minutes / 60.0;
    if minutes >= 60.0 || angle > limit {
        return None;
    }
    match letter.chars().next() {
        Some(c) if c == plus => Some(angle),
        Some(c) if c == minus => Some(-angle),
        _ => None,
    }
}

/// The time with that time of day which lies within half a day of another.
fn nearest_day(of_day: f64, near: f64) -> f64 {
    of_day + ((near - of_day) / DAY_S).round() * DAY_S
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read_trajectory;

    fn with_checksum(body: &str) -> String {
        let sum = body.bytes().fold(0u8, |sum, b| sum ^ b);
        format!("${body}*{sum:02X}\r\n")
    }

    fn gga(clock: &str, quality: u8, separation: &str) -> String {
        with_checksum(&format!(
            "GNGGA,{clock},5316.96100,N,00858.93000,W,{quality},12,0.7,40.000,M,{separation},M,1.0,0000"
        ))
    }

    fn read_text(text: &str) -> Result<(Trajectory, ReadReport), ReadError> {
        read_trajectory(text.as_bytes(), &ReadOptions::default())
    }

    fn stamps(track: &Trajectory) -> Vec<String> {
        let times = track
            .fixes()
            .iter()
            .filter_map(|f| track.gps_time_at(f.time_s));
        times.map(|t| t.format_utc(2)).collect()
    }

    #[test]
    fn dates_cross_midnight_wherever_the_date_stands() -> Result<(), ReadError> {
        let rmc = |clock: &str, date: &str| {
            with_checksum(&format!(
                "GNRMC,{clock},A,5316.961,N,00858.930,W,0.1,0.0,{date},,,R"
            ))
        };
        let before = rmc("235959.00", "081018")
            + &gga("235959.00", 4, "57.3")
            + &gga("000000.00", 4, "57.3")
            + &rmc("000000.00", "091018")
            + &gga("000001.00", 5, "57.3");
        let after = gga("235959.00", 4, "57.3")
            + &gga("000000.00", 4, "57.3")
            + &rmc("000000.00", "091018")
            + &gga("000001.00", 5, "57.3");
        let zda = gga("235959.00", 4, "57.3")
            + &with_checksum("GNZDA,235959.00,08,10,2018,00,00")
            + &gga("000000.00", 4, "57.3")
            + &gga("000001.00", 5, "57.3");
        for text in [before, after, zda] {
            let (track, report) = read_text(&text)?;
            let want = [
                "2018/10/08 23:59:59.00",
                "2018/10/09 00:00:00.00",
                "2018/10/09 00:00:01.00",
            ];
            assert_eq!(stamps(&track), want);
            assert_eq!(track.status_counts().to_string(), "2 fixed, 1 float");
            let place = track.geodetic().expect("on the Earth")[0];
            assert!((place.latitude_deg() - 53.282_683_333_333).abs() < 1e-9);
            assert!((place.longitude_deg() + 8.982_166_666_667).abs() < 1e-9);
            assert!((place.height_m - 97.3).abs() < 1e-6);
            assert!(report.warnings.is_empty());
        }
        Ok(())
    }

    #[test]
    fn heights_without_a_separation_are_raised_by_a_geoid() -> Result<(), ReadError> {
        let text = with_checksum(
            "GNGGA,120000.00,5316.96100,N,00858.93000,E,4,12,0.7,40.000,M,,M,1.0,0000",
        );
        let read = |options| read_trajectory(text.as_bytes(), &options);
        let height_m = |track: &Trajectory| track.geodetic().expect("on the Earth")[0].height_m;
        let (track, report) = read(ReadOptions::default())?;
        assert!((height_m(&track) - 40.0).abs() < 1e-6);
        assert!(report.warnings.contains(&ReadWarning::GeoidHeights));
        let (track, report) = read(ReadOptions::over_a_flat_geoid(20.0))?;
        assert!((height_m(&track) - 60.0).abs() < 1e-5);
        assert!(!report.warnings.contains(&ReadWarning::GeoidHeights));
        Ok(())
    }

    #[test]
    fn noise_is_counted_not_believed() -> Result<(), ReadError> {
        let good = gga("120000.00", 4, "57.3");
        let wrong = gga("120001.00", 4, "57.3").replace("40.000", "49.000");
        let merged = gga("120002.00", 4, "57.3").replace("\r\n", "") + &gga("120003.00", 4, "57.3");
        let cut = "$GNGGA,120004.00,5316.96";
        let text = format!(
            "0.7,40,M*77\r\n{good}{wrong}\u{b5}b\u{1}{merged}{}{}{cut}",
            gga("120003.50", 0, "57.3"),
            gga("120003.70", 4, "")
        );
        let (track, report) = read_text(&text)?;
        assert_eq!(track.fixes().len(), 3);
        assert_eq!(track.time_origin(), TimeOrigin::UtcMidnight);
        for (reason, count) in [
            (SkipReason::Checksum, 1),
            (SkipReason::Broken, 1),
            (SkipReason::NoFix, 1),
            (SkipReason::NoGeoidSeparation, 1),
        ] {
            assert_eq!(report.skipped_for(reason), count, "{reason}");
        }
        assert!(report.warnings.contains(&ReadWarning::NoDate));
        let garbage = good + &wrong.repeat(5);
        assert!(matches!(
            read_text(&garbage),
            Err(ReadError::MostlyBad {
                bad: 5,
                line: 2,
                ..
            })
        ));
        Ok(())
    }

    #[test]
    fn deviations_come_from_gst() -> Result<(), ReadError> {
        let gst = with_checksum("GNGST,120000.00,1.0,,,,0.020,0.010,0.030");
        for text in [
            gga("120000.00", 4, "57.3") + &gst,
            gst.clone() + &gga("120000.00", 4, "57.3"),
        ] {
            let (track, report) = read_text(&text)?;
            let sd = track.fixes()[0].standard_deviation_m().expect("known");
            let step = report.resolution_m.expect("digits");
            let with = |axis: usize, sd: f64| sd.hypot(step[axis] / 12f64.sqrt());
            let expected = [with(0, 0.01), with(1, 0.02), with(2, 0.03)];
            assert!(crate::matrix::distance(sd, expected) < 1e-9);
        }
        Ok(())
    }

    /// A deviation that no receiver means makes a sentence a broken one: the position has none.
    #[test]
    fn deviations_beyond_all_measure_are_skipped() -> Result<(), ReadError> {
        for sd in ["9e115", "-0.02"] {
            let gst = with_checksum(&format!("GNGST,120000.00,1.0,,,,0.020,{sd},0.030"));
            let (track, report) = read_text(&(gga("120000.00", 4, "57.3") + &gst))?;
            let (fix, expected) = (&track.fixes()[0], gga("120000.00", 4, "57.3"));
            assert_eq!(fix, &read_text(&expected)?.0.fixes()[0]);
            assert_eq!(report.skipped_total(), 1);
        }
        Ok(())
    }

    /// GNS alone is read; with GGA present GNS is skipped, as it repeats the positions.
    #[test]
    fn positions_of_gns_where_there_is_no_gga() -> Result<(), ReadError> {
        let gns = |clock: &str, modes: &str| {
            with_checksum(&format!(
                "GNGNS,{clock},5316.96100,N,00858.93000,W,{modes},12,0.7,40.000,57.3,1.0,0000"
            ))
        };
        let alone =
            gns("120000.00", "RRNN") + &gns("120001.00", "FFNN") + &gns("120002.00", "NNNN");
        let (track, report) = read_text(&alone)?;
        assert_eq!(track.status_counts().to_string(), "1 fixed, 1 float");
        assert_eq!(report.skipped_for(SkipReason::NoFix), 1);
        let place = track.geodetic().expect("on the Earth")[0];
        assert!((place.height_m - 97.3).abs() < 1e-6);
        let both = gns("120000.00", "AANN") + &gga("120000.00", 4, "57.3");
        let (track, _) = read_text(&both)?;
        assert_eq!(track.status_counts().to_string(), "1 fixed");
        Ok(())
    }

    /// Four decimals of a minute and one of the height: rounding hides the measurement.
    #[test]
    fn coarse_digits_are_told_and_become_deviations() -> Result<(), ReadError> {
        let text: String = (0..20)
            .map(|k| {
                with_checksum(&format!(
                    "GNGGA,1200{k:02}.00,5316.{:04},N,00858.{:04},W,4,12,0.7,{:.1},M,57.300,M,1.0,0000",
                    9610 + k,
                    9301 + k,
                    40.0 + 0.1 * f64::from(k)
                ))
            })
            .collect();
        let (track, report) = read_text(&text)?;
        let step = report.resolution_m.expect("digits");
        let expected = [0.1110, 0.1855, 0.1];
        for (found, expected) in step.iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 5e-3, "{step:?}");
        }
        assert!(
            report
                .warnings
                .contains(&ReadWarning::Coarse { step_m: step })
        );
        let sd = track.fixes()[0]
            .standard_deviation_m()
            .expect("of rounding");
        assert!((sd[1] - step[1] / 12f64.sqrt()).abs() < 1e-9);
        Ok(())
    }
}
