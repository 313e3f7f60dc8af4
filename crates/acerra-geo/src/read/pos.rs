//! RTKLIB's solution text (`.pos`).
//!
//! Three columns of "sd" are signed roots of covariances: sign(c)·√|c|.

use std::io::BufRead;

use super::assemble::{Assembler, Axes, Record, Stamp};
use super::digits::{Digits, degrees_in_m};
use super::error::quoted;
use super::lines::{Line, Lines};
use super::pos_header::{Header, Layout, Scale, column_line, degrees, words};
use super::{ReadError, ReadOptions, ReadReport, ReadWarning, TrajectoryFormat};
use crate::geodesy::{EnuFrame, Geodetic};
use crate::matrix::{Matrix3, Vector3, norm};
use crate::time::{Calendar, GpsTime};
use crate::trajectory::{Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};

/// JST is ahead of UTC by nine hours.
const JST_AHEAD_OF_UTC_S: f64 = 32_400.0;

/// Whether a comment line is RTKLIB's list of columns.
pub(super) fn is_column_line(text: &str) -> bool {
    column_line(text).is_some()
}

/// Whether a line begins as a solution does: a time, a position, a quality.
pub(super) fn is_data_line(text: &str) -> bool {
    let w = words(text);
    let calendar = w.len() >= 6 && w[0].split('/').count() == 3 && w[1].split(':').count() == 3;
    let week = w.len() >= 7
        && w[0]
            .parse()
            .is_ok_and(|week: u32| (1..=9_999).contains(&week))
        && w[1].contains('.')
        && w[1]
            .parse()
            .is_ok_and(|tow: f64| (0.0..=604_800.0).contains(&tow))
        && w[5].parse().is_ok_and(|q: u32| q <= 9);
    (calendar || week) && w[2..5].iter().all(|w| w.parse::<f64>().is_ok())
}

pub(super) fn read<R: BufRead>(
    lines: &mut Lines<R>,
    options: &ReadOptions,
) -> Result<(Trajectory, ReadReport), ReadError> {
    let mut all = Assembler::new(options, ReadReport::new(TrajectoryFormat::RtklibPos));
    let mut header = Header::default();
    let mut bad_deviations: Option<(u64, u64)> = None;
    let mut digits = PositionDigits::default();

    while let Some(line) = lines.next()? {
        if line.text.trim().is_empty() {
            continue;
        }
        if line.text.starts_with('%') {
            header.take(&line, &mut all.report)?;
            continue;
        }
        let w = words(&line.text);
        let layout = match header.layout {
            Some(layout) => layout,
            None => {
                let layout = layout_without_header(&line, &w)?;
                all.report.warnings.push(ReadWarning::NoHeader);
                header.layout = Some(layout);
                layout
            }
        };
        digits.take(&w, layout);
        let stamp = Stamp::Gps(time(&line, &w, header.scale.unwrap_or(Scale::Gpst))?);
        let (fix, deviations_good) =
            fix(
                &line,
                w.get(2..).unwrap_or_default(),
                layout,
                |place| match header.geoid_heights {
                    true => all.above_ellipsoid(place),
                    false => place,
                },
            )?;
        if !deviations_good {
            let (count, _) = bad_deviations.get_or_insert((0, line.number));
            *count += 1;
        }
        let record = Record {
            line: line.number,
            stamp,
            fix,
        };
        all.push(record, line.read_bytes)?;
    }

    if let Some((count, first_line)) = bad_deviations {
        all.report
            .warnings
            .push(ReadWarning::BadDeviations { count, first_line });
    }
    all.report.resolution_m = header.layout.and_then(|layout| digits.steps_m(layout));
    let axes = match (header.layout, header.base_m) {
        (Some(Layout::Baseline), Some(base)) => Axes::Local(Frame::Enu(EnuFrame::from_ecef(base))),
        (Some(Layout::Baseline), None) => {
            if options.origin.is_none() {
                all.report.warnings.push(ReadWarning::BaseUnknown);
            }
            Axes::Local(Frame::Local)
        }
        _ => Axes::Ecef {
            reference_m: header.base_m,
        },
    };
    all.finish(&axes, TimeOrigin::Relative, lines.count())
}

/// Digits of the three coordinates, and the latitude of the first position.
#[derive(Default)]
struct PositionDigits {
    each: [Digits; 3],
    latitude_deg: Option<f64>,
}

impl PositionDigits {
    fn take(&mut self, w: &[&str], layout: Layout) {
        let at = match layout {
            Layout::DegreesMinutesSeconds => [4, 7, 8],
            _ => [2, 3, 4],
        };
        for (digits, at) in self.each.iter_mut().zip(at) {
            if let Some(text) = w.get(at) {
                digits.take(text);
            }
        }
        if self.latitude_deg.is_none() {
            self.latitude_deg = w.get(2).and_then(|w| w.parse().ok());
        }
    }

    /// Steps east, north and up (m).
    fn steps_m(&self, layout: Layout) -> Option<Vector3> {
        let [first, second, third] = self.each.each_ref().map(Digits::step);
        let [first, second, third] = [first?, second?, third.unwrap_or(0.0)];
        let [longitude_m, latitude_m] = degrees_in_m(self.latitude_deg?);
        Some(match layout {
            Layout::Degrees => [second * longitude_m, first * latitude_m, third],
            Layout::DegreesMinutesSeconds => [
                second * longitude_m / 3_600.0,
                first * latitude_m / 3_600.0,
                third,
            ],
            Layout::Ecef => [first.max(second).max(third); 3],
            Layout::Baseline => [first, second, third],
        })
    }
}

/// The layout that numbers alone can give away: ECEF by its length, degrees by their nine
/// decimals against a baseline's four. Anything else is left to the user.
fn layout_without_header(line: &Line<'_>, w: &[&str]) -> Result<Layout, ReadError> {
    let Some([a, b, c]) = w.get(2..5).and_then(|w| <[&str; 3]>::try_from(w).ok()) else {
        return Err(line.malformed("a time and a position", quoted(&line.text)));
    };
    let p = [
        line.metres("coordinate", a)?,
        line.metres("coordinate", b)?,
        line.metres("coordinate", c)?,
    ];
    let decimals = |word: &str| word.split_once('.').map_or(0, |(_, d)| d.len());
    if (6e6..7e6).contains(&norm(p)) {
        Ok(Layout::Ecef)
    } else if decimals(a) >= 7 && decimals(b) >= 7 && p[0].abs() <= 90.0 && p[1].abs() <= 360.0 {
        Ok(Layout::Degrees)
    } else if decimals(a) == 4 && decimals(b) == 4 && decimals(c) == 4 {
        Ok(Layout::Baseline)
    } else {
        Err(ReadError::Header {
            line: line.number,
            problem: format!(
                "no header line names the columns, and the numbers {a} {b} {c} could be more than \
                 one kind of position"
            ),
        })
    }
}

/// The instant of a solution: calendar, or week and seconds of week.
fn time(line: &Line<'_>, w: &[&str], scale: Scale) -> Result<GpsTime, ReadError> {
    let [first, second] = match w {
        [first, second, ..] => [*first, *second],
        _ => return Err(line.malformed("a date and a time", quoted(&line.text))),
    };
    if !first.contains('/') {
        let week = line.number_in("GPS week", first, 0.0..=9_999.0, "0 to 9999")?;
        if week.fract() != 0.0 {
            return Err(line.malformed("a whole GPS week", quoted(first)));
        }
        let tow = line.number_in("seconds of week", second, 0.0..=604_800.0, "0 to 604800")?;
        let t = GpsTime::from_week_tow(week as i64, tow);
        return Ok(match scale {
            Scale::Gpst => t,
            // RTKLIB writes the week and seconds of the shifted clock.
            Scale::Utc => t + utc_shift(t),
            Scale::Jst => {
                let t = t - JST_AHEAD_OF_UTC_S;
                t + utc_shift(t)
            }
        });
    }
    let date: Vec<&str> = first.split('/').collect();
    let clock: Vec<&str> = second.split(':').collect();
    let (&[y, mo, d], &[h, mi, s]) = (date.as_slice(), clock.as_slice()) else {
        return Err(line.malformed("yyyy/mm/dd hh:mm:ss", quoted(&format!("{first} {second}"))));
    };
    let bad = || line.malformed("yyyy/mm/dd hh:mm:ss", quoted(&format!("{first} {second}")));
    let seconds: f64 = s.parse().map_err(|_| bad())?;
    let calendar = Calendar::new(
        y.parse().map_err(|_| bad())?,
        mo.parse().map_err(|_| bad())?,
        d.parse().map_err(|_| bad())?,
        h.parse().map_err(|_| bad())?,
        mi.parse().map_err(|_| bad())?,
        seconds,
    )
    .map_err(|e| line.malformed("a date and a time", e.to_string()))?;
    let utc = |c: &Calendar| {
        GpsTime::from_utc(c).map_err(|e| line.malformed("a time of UTC", e.to_string()))
    };
    match scale {
        Scale::Gpst => Ok(GpsTime::from_calendar(&calendar)),
        Scale::Utc => utc(&calendar),
        Scale::Jst => {
            let back = GpsTime::from_calendar(&calendar) - JST_AHEAD_OF_UTC_S;
            utc(&back.to_calendar())
        }
    }
}

/// GPST − UTC for a clock reading of UTC that was counted as if it were GPST.
fn utc_shift(reading: GpsTime) -> f64 {
    GpsTime::from_utc(&reading.to_calendar()).map_or(0.0, |t| t - reading)
}

/// The position and the columns after it. For positions on the Earth the result is in ECEF axes. The flag is
/// false where standard deviations were present but unusable.
fn fix(
    line: &Line<'_>,
    w: &[&str],
    layout: Layout,
    above_ellipsoid: impl FnOnce(Geodetic) -> Geodetic,
) -> Result<(Fix, bool), ReadError> {
    let position_words = if layout == Layout::DegreesMinutesSeconds {
        7
    } else {
        3
    };
    if w.len() < position_words + 2 {
        return Err(line.malformed(
            format!("{} columns or more", position_words + 4),
            format!("{} in {}", w.len() + 2, quoted(&line.text)),
        ));
    }
    let (position, rest) = w.split_at(position_words);
    let geodetic = match layout {
        Layout::Degrees => Some(Geodetic::from_degrees(
            line.number_in("latitude", position[0], -90.0..=90.0, "−90° to 90°")?,
            line.number_in("longitude", position[1], -360.0..=360.0, "−360° to 360°")?,
            line.metres("height", position[2])?,
        )),
        Layout::DegreesMinutesSeconds => {
            let mut n = [0.0; 6];
            for (n, word) in n.iter_mut().zip(position) {
                *n = line.number_in("angle", word, -360.0..=360.0, "−360 to 360")?;
            }
            let latitude = degrees(position[0], n[0], n[1], n[2]);
            if latitude.abs() > 90.0 {
                return Err(ReadError::OutOfRange {
                    line: line.number,
                    field: "latitude".to_owned(),
                    value: latitude,
                    expected: "−90° to 90°",
                });
            }
            let longitude = degrees(position[3], n[3], n[4], n[5]);
            Some(Geodetic::from_degrees(
                latitude,
                longitude,
                line.metres("height", position[6])?,
            ))
        }
        Layout::Ecef | Layout::Baseline => None,
    };
    let local_axes = geodetic.map(above_ellipsoid).map(EnuFrame::new);
    let mut fix = Fix::new(
        0.0,
        match &local_axes {
            Some(frame) => frame.origin_in_ecef_m(),
            None => [
                line.metres("x", position[0])?,
                line.metres("y", position[1])?,
                line.metres("z", position[2])?,
            ],
        },
    );
    let q = line.number_in("Q", rest[0], 0.0..=9.0, "0 to 9")?;
    fix.status = SolutionStatus::from_rtklib_q(q as u32);
    fix.satellites = Some(line.number_in("ns", rest[1], 0.0..=999.0, "0 to 999")? as u16);

    let mut deviations_good = true;
    if let Some(words) = rest.get(2..8) {
        let mut sd = [0.0; 6];
        for (sd, word) in sd.iter_mut().zip(words) {
            *sd = word
                .parse()
                .map_err(|_| line.malformed("a standard deviation", quoted(word)))?;
        }
        let covariance = covariance(&sd, local_axes.is_some());
        deviations_good = covariance.is_some();
        fix.covariance_m2 = match &local_axes {
            Some(frame) => covariance.map(|c| frame.ecef_covariance_from_enu(&c)),
            None => covariance,
        };
    } else if rest.len() > 2 {
        return Err(line.malformed("six standard deviations", format!("{}", rest.len() - 2)));
    }
    if let Some(word) = rest.get(8) {
        fix.age_s = Some(line.number("age", word)?);
    }
    if let Some(word) = rest.get(9) {
        fix.ratio = Some(line.number("ratio", word)?);
    }
    if let Some(words) = rest.get(10..13) {
        let mut v = [0.0; 3];
        for (v, word) in v.iter_mut().zip(words) {
            *v = line.number("velocity", word)?;
        }
        fix.velocity_m_s = Some(match &local_axes {
            // Written north, east, up.
            Some(frame) => frame.ecef_vector_from_enu([v[1], v[0], v[2]]),
            None => v,
        });
    }
    Ok((fix, deviations_good))
}

/// The covariance of signed roots: three deviations, then first-second, second-third,
/// third-first. Those of geodetic solutions count north first. None when not finite.
fn covariance(sd: &[f64; 6], north_first: bool) -> Option<Matrix3> {
    if sd.iter().any(|s| !s.is_finite() || s.abs() > 1e8) {
        return None;
    }
    let c = sd.map(|s| s * s.abs());
    let (first, second) = if north_first { (1, 0) } else { (0, 1) };
    let mut m = [[0.0; 3]; 3];
    m[first][first] = c[0].abs();
    m[second][second] = c[1].abs();
    m[2][2] = c[2].abs();
    for (i, j, c) in [(first, second, c[3]), (second, 2, c[4]), (2, first, c[5])] {
        m[i][j] = c;
        m[j][i] = c;
    }
    Some(m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::distance;
    use crate::read::read_trajectory;

    const BASE: &str = "% ref pos   : 35.132057068  139.624306577    73.9077\n";

    fn read_text(text: &str) -> Result<(Trajectory, ReadReport), ReadError> {
        read_trajectory(text.as_bytes(), &ReadOptions::default())
    }

    fn columns(scale: &str, names: &str) -> String {
        format!("{BASE}%\n%  {scale}  {names}  Q  ns\r\n")
    }

    #[test]
    fn all_layouts_give_the_same_place() -> Result<(), ReadError> {
        let base = Geodetic::from_degrees(35.132_057_068, 139.624_306_577, 73.907_7);
        let frame = EnuFrame::new(base);
        let want = [-953.34, 3_196.24, -6.4];
        let place = frame.geodetic_from_enu(want);
        let [x, y, z] = frame.ecef_from_enu(want);
        let dms = |deg: f64| {
            let d = deg.abs().floor();
            let m = ((deg.abs() - d) * 60.0).floor();
            format!(
                "{d:4.0} {m:02.0} {:010.7}",
                (deg.abs() - d - m / 60.0) * 3600.0
            )
        };
        let (lat, lon, h) = (place.latitude_deg(), place.longitude_deg(), place.height_m);
        for (names, position) in [
            (
                "latitude(deg) longitude(deg)  height(m)",
                format!("{lat:14.9} {lon:14.9} {h:10.4}"),
            ),
            (
                "latitude(d'\") longitude(d'\")  height(m)",
                format!("{} {} {h:10.4}", dms(lat), dms(lon)),
            ),
            (
                "x-ecef(m) y-ecef(m) z-ecef(m)",
                format!("{x:14.4} {y:14.4} {z:14.4}"),
            ),
            (
                "e-baseline(m) n-baseline(m) u-baseline(m)",
                "-953.3400 3196.2400 -6.4000".to_owned(),
            ),
        ] {
            for (scale, stamp) in [
                ("GPST", "2005/04/02 00:00:13.000"),
                ("UTC", "2005/04/02 00:00:00.000"),
                ("JST", "2005/04/02 09:00:00.000"),
                ("GPST", "1316 518413.000"),
                ("UTC", "1316 518400.000"),
                ("JST", "1316 550800.000"),
            ] {
                let row = format!(
                    "{stamp} {position}  1  7 0.0062 0.0082 0.0192 0.0031 -0.0078 -0.0066 0.00 9.9\r\n"
                );
                let head = columns(scale, names);
                for text in [
                    format!("{head}{row}"),
                    format!("{head}{}", row.replace("  ", ",")),
                ] {
                    let (track, report) = read_text(&text)?;
                    let fix = &track.fixes()[0];
                    assert!(
                        distance(fix.position_m, want) < 2e-4,
                        "{text} {:?}",
                        fix.position_m
                    );
                    assert_eq!(
                        track.gps_time_at(fix.time_s).map(|t| t.to_string()),
                        Some("2005/04/02 00:00:13.000".to_owned()),
                        "{text}"
                    );
                    assert_eq!(fix.status, SolutionStatus::Fixed);
                    assert_eq!(
                        (fix.satellites, fix.age_s, fix.ratio),
                        (Some(7), Some(0.0), Some(9.9))
                    );
                    assert!(report.warnings.is_empty() && report.skipped.is_empty());
                }
            }
        }
        Ok(())
    }

    #[test]
    fn geodetic_heights_are_raised_by_a_geoid() -> Result<(), ReadError> {
        let text = "%  (lat/lon/height=WGS84/geodetic,Q=1:fix,2:float,ns=# of satellites)\n\
                    %  GPST  latitude(deg) longitude(deg) height(m)  Q  ns\n\
                    2005/04/02 00:00:00.0 35.132057068 139.624306577 40.0000 1 7\n";
        let read = |options| read_trajectory(text.as_bytes(), &options);
        let height_m = |track: &Trajectory| track.geodetic().expect("on the Earth")[0].height_m;
        let (track, report) = read(ReadOptions::default())?;
        assert!((height_m(&track) - 40.0).abs() < 1e-6);
        assert_eq!(report.warnings, [ReadWarning::GeoidHeights]);
        let (track, report) = read(ReadOptions::over_a_flat_geoid(20.0))?;
        assert!((height_m(&track) - 60.0).abs() < 1e-5);
        assert_eq!(report.warnings, []);
        Ok(())
    }

    #[test]
    fn separators_of_every_dialect_and_a_base_glued_to_its_sign() -> Result<(), ReadError> {
        // RTKLIB's out-fieldsep; Emlid Studio's columns.
        let row = |sep: &str| {
            [
                "2023/06/24 20:22:50.402",
                "60.000000100",
                "-139.000000200",
                "1900.5000",
                "1",
                "10",
            ]
            .join(sep)
        };
        for (base, separator) in [
            ("60.000000000, -139.000000000, 1900.0000", ","),
            ("60.000000000; -139.000000000; 1900.0000", ";"),
            ("60.000000000-139.000000000 1900.0000", "  "),
        ] {
            let names = [
                "%  GPST",
                "latitude(deg)",
                "longitude(deg)",
                "height(m)",
                "Q",
                "ns",
            ];
            let text = format!(
                "% ref pos   : {base}\n{}\n{}\n",
                names.join(separator),
                row(separator)
            );
            let (track, report) = read_text(&text)?;
            let [east, north, up] = track.fixes()[0].position_m;
            assert!((east + 0.0112).abs() < 1e-3, "{text} {east}");
            assert!((north - 0.0111).abs() < 1e-3, "{text} {north}");
            assert!((up - 0.5).abs() < 1e-6);
            assert!(report.warnings.is_empty());
            let steps = report.resolution_m.expect("digits");
            assert!(
                (steps[1] - 1.113e-4).abs() < 1e-6 && steps[2] == 1e-4,
                "{steps:?}"
            );
        }
        Ok(())
    }

    #[test]
    fn rounding_enters_the_deviations() -> Result<(), ReadError> {
        let mut text = columns("GPST", "latitude(deg) longitude(deg) height(m)");
        for k in 0..20 {
            text += &format!(
                "2005/04/02 00:00:{k:02}.0 35.{:06}000 139.{:06}000 {:.1}000 1 7 0.03 0.01 0.02 0 0 0\n",
                132_057 + k,
                624_306 + 2 * k,
                73.9 + 0.1 * f64::from(k)
            );
        }
        let (track, report) = read_text(&text)?;
        // Six decimals of a degree: 0.111 m; trailing zeros carry no information.
        let step = report.resolution_m.expect("digits");
        assert!(
            (step[1] - 0.1113).abs() < 1e-3 && (step[2] - 0.1).abs() < 1e-9,
            "{step:?}"
        );
        assert!(
            report
                .warnings
                .contains(&ReadWarning::Coarse { step_m: step })
        );
        let sd = track.fixes()[3].standard_deviation_m().expect("known");
        let with = |sd: f64, step: f64| sd.hypot(step / 12f64.sqrt());
        for (found, expected) in sd.iter().zip([
            with(0.01, step[0]),
            with(0.03, step[1]),
            with(0.02, step[2]),
        ]) {
            assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        }
        Ok(())
    }

    #[test]
    fn signed_roots_become_covariances_in_the_right_axes() -> Result<(), ReadError> {
        // North 3 cm, east 1 cm, up 2 cm; equal in both layouts.
        let llh = columns("GPST", "latitude(deg) longitude(deg) height(m)")
            + "2005/04/02 00:00:00.0 35.132057068 139.624306577 73.9077 1 7 0.03 0.01 0.02 -0.012 0.009 0.015\n";
        let enu = columns("GPST", "e-baseline(m) n-baseline(m) u-baseline(m)")
            + "2005/04/02 00:00:00.0 0.0000 0.0000 0.0000 1 7 0.01 0.03 0.02 -0.012 0.015 0.009\n";
        for text in [llh, enu] {
            let (track, _) = read_text(&text)?;
            let c = track.fixes()[0].covariance_m2.expect("a covariance");
            let want = [
                [1e-4, -1.44e-4, 0.81e-4],
                [-1.44e-4, 9e-4, 2.25e-4],
                [0.81e-4, 2.25e-4, 4e-4],
            ];
            for (c, want) in c.iter().flatten().zip(want.iter().flatten()) {
                // Digits of 0.1 mm add 10⁻⁹ m².
                assert!((c - want).abs() < 2e-9, "{text} {c} {want}");
            }
        }
        Ok(())
    }

    #[test]
    fn without_a_header_only_the_clear_is_taken() -> Result<(), ReadError> {
        let llh = "2005/04/02 00:00:00.000   35.132057068  139.624306577    73.9077   1   7\n";
        let (track, report) = read_text(llh)?;
        assert_eq!(report.warnings, [ReadWarning::NoHeader]);
        assert_eq!(track.fixes()[0].position_m, [0.0; 3]);
        let enu = "2005/04/02 00:00:00.000   -953.3392      3196.2386        -6.4026   1   7\n";
        let (track, report) = read_text(enu)?;
        assert_eq!(track.frame(), &Frame::Local);
        assert!(report.warnings.contains(&ReadWarning::BaseUnknown));
        let open = "2005/04/02 00:00:00.000   35.13 139.62 73.9   1   7\n";
        assert!(matches!(
            read_text(open),
            Err(ReadError::Header { line: 1, .. })
        ));
        Ok(())
    }

    #[test]
    fn what_is_wrong_is_said_with_its_line() {
        let head = columns("GPST", "e-baseline(m) n-baseline(m) u-baseline(m)");
        for (row, want) in [
            (
                "2005/04/02 00:00:00.000 1 2 nan 1 7\n",
                "line 4: z is NaN, expected a finite number",
            ),
            (
                "2005/04/02 00:00:00.000 1 2 x 1 7\n",
                "line 4: expected a number for z, found 'x'",
            ),
            (
                "2005/04/31 00:00:00.000 1 2 3 1 7\n",
                "line 4: expected a date and a time, found day is 31, expected a day of that month",
            ),
            (
                "2005/04/02 00:00:00.000 1 2 3 12 7\n",
                "line 4: Q is 12, expected 0 to 9",
            ),
            ("time_s,x_m,y_m,z_m\n", "line 4: GPS week"),
            ("2005/04/02 00:00:00.000 1 2 1e99 1 7\n", "line 4: z is"),
        ] {
            let error = read_text(&format!("{head}{row}"))
                .expect_err(row)
                .to_string();
            if !want.starts_with("line 4: GPS week") {
                assert!(error.starts_with(want), "{error}");
            }
            assert!(error.starts_with("line 4: "), "{error}");
        }
        let cut = format!("{head}2005/04/02 00:00:00.000 1 2 3 1 7\n2005/04/02 00:00:01.000 1 2");
        assert!(matches!(
            read_text(&cut),
            Err(ReadError::CutOff { line: 5, .. })
        ));
        assert!(matches!(
            read_text(&head),
            Err(ReadError::NoPositions { .. })
        ));
        let two = format!("{head}2005/04/02 00:00:00.000 1 2 3 1 7\n%  UTC  x-ecef(m)\n");
        assert!(matches!(
            read_text(&two),
            Err(ReadError::Header { line: 5, .. })
        ));
    }
}
