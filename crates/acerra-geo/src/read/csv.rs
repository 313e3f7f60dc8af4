//! Tables with a header line.

use std::io::BufRead;

use super::assemble::{Assembler, Axes, Record, Stamp};
use super::csv_columns::{Columns, Role};
use super::csv_row::Row;
use super::csv_seen::Seen;
use super::error::quoted;
use super::lines::{Line, Lines};
use super::{ReadError, ReadOptions, ReadReport, SkipReason, TrajectoryFormat};
use crate::geodesy::{EnuFrame, Geodetic};
use crate::time::GpsTime;
use crate::trajectory::{Frame, TimeOrigin, Trajectory};

/// Comment entries of `trajectory.csv` with the origin and the zero of the clock: see `crate::write`.
#[derive(Default)]
struct Stated {
    origin: Option<Geodetic>,
    second_zero: Option<GpsTime>,
}

pub(super) fn read<R: BufRead>(
    lines: &mut Lines<R>,
    options: &ReadOptions,
) -> Result<(Trajectory, ReadReport), ReadError> {
    let mut all = Assembler::new(options, ReadReport::new(TrajectoryFormat::Csv));
    let mut stated = Stated::default();
    let mut columns: Option<Columns> = None;
    let mut clock: Option<Clock> = None;
    let mut seen = Seen::default();
    while let Some(line) = lines.next()? {
        let text = line.text.trim();
        if text.is_empty() {
            continue;
        }
        if let Some(comment) = text.strip_prefix('#') {
            stated.take(&line, comment)?;
            continue;
        }
        let Some(columns) = &columns else {
            let found = Columns::from_header(line.number, text, options.heights)?;
            if found.has_trace_numbers() && !options.trace_numbers {
                return Err(ReadError::Header {
                    line: line.number,
                    problem: "numbers of traces and no column of time: only [trajectory] file of a campaign takes \
                              these"
                        .to_owned(),
                });
            }
            seen.header_line = line.number;
            seen.time_column = found.clock_without_unit(text);
            all.report.unused_columns.clone_from(&found.unused);
            columns = Some(found);
            continue;
        };
        let cells = columns.separator.split(text);
        let extra_is_empty = cells.iter().skip(columns.width).all(|c| c.is_empty());
        if cells.len() < columns.width || !extra_is_empty {
            let expected = format!("{} columns as in the header", columns.width);
            return Err(line.malformed(expected, format!("{} in {}", cells.len(), quoted(text))));
        }
        let row = Row {
            line: &line,
            cells: &cells,
            columns,
            options,
        };
        let Some(mut fix) = row.position(&mut seen)? else {
            all.skip(SkipReason::EmptyPosition, line.number);
            continue;
        };
        let stamp = row.stamp(&mut seen)?;
        let this = Clock::of(&stamp);
        if *clock.get_or_insert(this) != this {
            return Err(line.malformed("the same kind of time as before", quoted(text)));
        }
        row.details(&mut fix)?;
        let record = Record {
            line: line.number,
            stamp,
            fix,
        };
        all.push(record, line.read_bytes)?;
    }
    seen.assess(columns.as_ref(), &mut all)?;
    let ecef = columns.as_ref().is_some_and(|c| !c.has(Role::Local(0)));
    let axes = match (ecef, stated.origin) {
        (true, _) => Axes::Ecef { reference_m: None },
        (false, Some(origin)) => Axes::Local(Frame::Enu(EnuFrame::new(origin))),
        (false, None) => Axes::Local(Frame::Local),
    };
    let clock = match stated.second_zero {
        _ if columns.as_ref().is_some_and(Columns::has_trace_numbers) => TimeOrigin::TraceNumbers,
        Some(zero) => TimeOrigin::Gps(zero),
        None => TimeOrigin::Relative,
    };
    all.finish(&axes, clock, lines.count())
}

/// Kind of time of a file.
#[derive(Clone, Copy, PartialEq)]
enum Clock {
    Gps,
    Own,
}

impl Clock {
    fn of(stamp: &Stamp) -> Self {
        match stamp {
            Stamp::Gps(_) => Self::Gps,
            Stamp::Seconds(_) => Self::Own,
        }
    }
}

impl Stated {
    fn take(&mut self, line: &Line<'_>, comment: &str) -> Result<(), ReadError> {
        let Some((key, value)) = comment.split_once(':') else {
            return Ok(());
        };
        let words: Vec<&str> = value.split_whitespace().collect();
        match (key.trim(), words.as_slice()) {
            ("origin_deg_m", &[latitude, longitude, height]) => {
                self.origin = Some(Geodetic::from_degrees(
                    line.number_in("latitude", latitude, -90.0..=90.0, "−90° to 90°")?,
                    line.number_in("longitude", longitude, -360.0..=360.0, "−360° to 360°")?,
                    line.metres("height", height)?,
                ));
            }
            ("second_zero_gps_week_tow_s", &[week, tow]) => {
                let week = line.number_in("GPS week", week, 0.0..=9_999.0, "0 to 9999")?;
                let tow = line.number_in("seconds of week", tow, 0.0..=604_800.0, "0 to 604800")?;
                self.second_zero = Some(GpsTime::from_week_tow(week as i64, tow));
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::{HeightDatum, ReadWarning, read_trajectory};
    use crate::trajectory::SolutionStatus;

    fn read_text(text: &str) -> Result<(Trajectory, ReadReport), ReadError> {
        read_trajectory(text.as_bytes(), &ReadOptions::default())
    }

    #[test]
    fn separators_units_and_decimal_commas() -> Result<(), ReadError> {
        for text in [
            "time_s,x_m,y_m,z_m\n1.5,2.25,3,4\n",
            "Time (ms);X [mm];Y [mm];Z [mm];Remark\r\n1500;2250,0;3000,0;4000,0;windy\r\n",
            "t\teast\tnorth\tup\n1.5\t2.25\t3\t4\n",
            "t x y z\n 1.5   2.25 3 4",
            "\"t\",\"x\",\"y\",\"z\"\n\"1.5\",\"2.25\",\"3\",\"4\"\n",
            "z,y,x,t\n4,3,2.25,1.5\n\n",
        ] {
            let (track, report) = read_text(text)?;
            let fix = &track.fixes()[0];
            assert_eq!(
                (fix.time_s, fix.position_m),
                (1.5, [2.25, 3.0, 4.0]),
                "{text}"
            );
            assert_eq!(fix.status, SolutionStatus::External);
            assert_eq!(
                report.unused_columns.len(),
                usize::from(text.contains("Remark"))
            );
        }
        Ok(())
    }

    #[test]
    fn numbers_of_traces_stand_for_times_where_there_are_none() -> Result<(), ReadError> {
        let numbered = |text: &str| {
            let options = ReadOptions {
                trace_numbers: true,
                ..ReadOptions::default()
            };
            read_trajectory(text.as_bytes(), &options)
        };
        let text = "trace,x_m,y_m,z_m\n1,0,0,2\n11,0.5,0,2\n";
        let refused = read_text(text).unwrap_err().to_string();
        assert!(refused.contains("numbers of traces"), "{refused}");
        let (track, report) = numbered(text)?;
        assert_eq!(track.time_origin(), TimeOrigin::TraceNumbers);
        assert_eq!((track.start_s(), track.end_s()), (1.0, 11.0));
        assert!(report.unused_columns.is_empty());
        let (track, report) = read_text("trace,time_s,x_m,y_m,z_m\n1,0.2,0,0,2\n2,0.4,1,0,2\n")?;
        assert_eq!(track.time_origin(), TimeOrigin::Relative);
        assert_eq!(track.start_s(), 0.2);
        assert_eq!(report.unused_columns, ["trace"]);
        for bad in ["1.5", "-1", "x"] {
            let text = format!("trace,x_m,y_m,z_m\n{bad},0,0,2\n3,1,0,2\n");
            let found = numbered(&text).unwrap_err().to_string();
            assert!(found.contains("line 2"), "{found}");
        }
        Ok(())
    }

    #[test]
    fn clocks() -> Result<(), ReadError> {
        for (text, want) in [
            (
                "gpst_unix_s,x,y,z\n1539087731.123456789,0,0,0\n",
                "2018/10/09 12:22:11.123456789",
            ),
            (
                "unix_s,x,y,z\n1539087731.5,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "gps_week,tow_s,x,y,z\n2022,217331.25,0,0,0\n",
                "2018/10/09 12:22:11.250000000",
            ),
            (
                "time,x,y,z\n2018-10-09T12:22:11.5Z,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "utc,x,y,z\n2018-10-09 12:22:11.5,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "time,x,y,z\n2018-10-09T14:22:11.5+02:00,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "time,x,y,z\n2018-10-09T06:52:11.5-0530,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "Elapsed,Date,Time,x,y,z\n578298,2018/10/09,12:22:11.500,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            // Counts since 1970 that can only be milli- or microseconds.
            (
                "timestamp,x,y,z\n1539087731500,0,0,0\n",
                "2018/10/09 12:22:29.500000000",
            ),
            (
                "unix,x,y,z\n1539087731500250,0,0,0\n",
                "2018/10/09 12:22:29.500250000",
            ),
        ] {
            let (track, _) = read_text(text)?;
            let t = track.gps_time_at(track.start_s()).expect("an instant");
            assert_eq!(t.format_calendar(9), want, "{text}");
        }
        Ok(())
    }

    #[test]
    fn places_on_the_earth_and_their_axes() -> Result<(), ReadError> {
        let text = "time_s,lat,lon,height,sdn_m,sde_m,sdu_m,q\n\
                    0,40.9,14.2,60,0.02,0.01,0.04,2\n1,40.9,14.2,64,0.02,0.01,0.04,1\n";
        let (track, _) = read_text(text)?;
        // The first *fixed* position is the origin.
        assert!(crate::matrix::distance(track.fixes()[0].position_m, [0.0, 0.0, -4.0]) < 1e-8);
        let sd = track.fixes()[0].standard_deviation_m().expect("known");
        assert!(crate::matrix::distance(sd, [0.01, 0.02, 0.04]) < 1e-9);
        assert_eq!(track.status_counts().to_string(), "1 fixed, 1 float");
        let options = ReadOptions::default().with_origin(Geodetic::from_degrees(40.9, 14.2, 0.0));
        let (track, _) = read_trajectory(text.as_bytes(), &options)?;
        assert!((track.fixes()[1].position_m[2] - 64.0).abs() < 1e-8);
        Ok(())
    }

    #[test]
    fn faults_have_lines() {
        for (text, want) in [
            ("time_s,x_m,y_m,z_m\n0,1,2,inf\n", "line 2: z is inf"),
            (
                "time_s,x_m,y_m,z_m\n0,1,,3\n",
                "line 2: expected all of x, y, z",
            ),
            (
                "time_s,x_m,y_m,z_m\n0,1,2,3\n1,1",
                "line 3: the file is cut off here",
            ),
            (
                "time_s,x_m,y_m,z_m\n0,1,2,3\n1,1\n",
                "line 3: expected 4 columns as in the header, found 2",
            ),
            (
                "time_s,x_m,y_m,z_m\n0,1,2,3,4\n",
                "line 2: expected 4 columns",
            ),
            ("time_s,x_m,y_m\n", "line 1: no complete position"),
            (
                "time_s,x_m,x_mm,y,z\n",
                "line 1: columns 'x_m' and 'x_mm' mean the same",
            ),
            ("time_s,x_m,y_m,z_m\n", "no position in this CSV table file"),
            (
                "time_s,x_m,y_m,z_m\n0,,,\n",
                "no position in this CSV table file: 1 records, all skipped, first empty position on line 2",
            ),
            (
                "time_s,lat,lon,height\n0,91,0,0\n",
                "line 2: latitude is 91",
            ),
            (
                "time_s,x,y,z,status\n0,1,2,3,maybe\n",
                "line 2: expected a status: fixed",
            ),
            (
                "time,x,y,z\n2018-10-09T12:22:11Z,0,0,0\n5,0,0,0\n",
                "line 3: expected the same kind",
            ),
            (
                "time,x,y,z\n2018-13-09T12:22:11Z,0,0,0\n",
                "line 2: expected a date and time of UTC",
            ),
            ("time_s,x,y,z\n1e300,0,0,0\n", "line 2: time is"),
            (
                "time_s,x,y,z\n1721469150000,0,0,0\n",
                "line 2: time is 1721469150000, expected seconds within 1e11",
            ),
        ] {
            let error = read_text(text).expect_err(text).to_string();
            assert!(error.starts_with(want), "{error}");
        }
    }

    /// AirData's columns: dates of whole seconds, milliseconds, feet, two kinds of height.
    #[test]
    fn whole_seconds_are_refined_by_the_clock_in_the_same_row() -> Result<(), ReadError> {
        let mut text = "time(millisecond),datetime(utc),latitude,longitude,\
                        height_above_takeoff(feet),altitude_above_seaLevel(feet), pitch(degrees), \
                        roll(degrees), compass_heading(degrees)\n"
            .to_owned();
        for k in 0..40 {
            // Zero of the milliseconds is 12:22:11.35.
            let second = 11 + (350 + 200 * k) / 1000;
            text += &format!(
                "{},2018-10-09 12:22:{second:02},40.9596{k:05},14.3696{k:05},32.8,{:.1},1.5,-2.5,90.0\n",
                200 * k,
                246.1 + 0.1 * f64::from(k)
            );
        }
        let (track, report) = read_text(&text)?;
        let start = track.gps_time_at(track.start_s()).expect("an instant");
        let expected = GpsTime::from_utc(
            &crate::time::Calendar::new(2018, 10, 9, 12, 22, 11.35).expect("date"),
        );
        let off_s = start - expected.expect("UTC");
        assert!(off_s.abs() < 0.11, "{off_s}");
        assert_eq!(
            track.sample_interval_s().map(|s| (1e6 * s).round()),
            Some(2e5)
        );
        let place = track.geodetic().expect("on the Earth")[0];
        assert!((place.height_m - 246.1 * 0.3048).abs() < 1e-6);
        assert!(report.warnings.contains(&ReadWarning::GeoidHeights));
        assert!(
            report
                .warnings
                .iter()
                .any(|w| matches!(w, ReadWarning::WholeSeconds { within_s } if *within_s < 0.11))
        );
        assert!(
            report
                .unused_columns
                .contains(&"height_above_takeoff(feet)".to_owned())
        );
        // Nose to the east, 1.5° up, left side 2.5° down.
        let attitude = track.fixes()[0].attitude.expect("attitude");
        let nose = attitude.rotate([1.0, 0.0, 0.0]);
        assert!(nose[0] > 0.999 && (nose[2] - 1.5f64.to_radians().sin()).abs() < 1e-9);
        let left = attitude.rotate([0.0, 1.0, 0.0]);
        assert!(left[1] > 0.99 && left[2] < -0.04, "{left:?}");
        Ok(())
    }

    #[test]
    fn heights_are_what_the_header_or_the_caller_says() -> Result<(), ReadError> {
        let read = |text: &str, heights| {
            let options = ReadOptions {
                heights,
                ..ReadOptions::default()
            };
            read_trajectory(text.as_bytes(), &options)
        };
        let height = |text: &str, heights| -> Result<f64, ReadError> {
            Ok(read(text, heights)?.0.geodetic().expect("on the Earth")[0].height_m)
        };
        let open = "time_s,lat,lon,altitude\n0,40.9,14.2,60\n";
        let error = read(open, None).expect_err("open").to_string();
        assert!(
            error.starts_with("line 1: column 'altitude' does not name"),
            "{error}"
        );
        assert!((height(open, Some(HeightDatum::Ellipsoid))? - 60.0).abs() < 1e-9);
        let (_, report) = read(open, Some(HeightDatum::Sea))?;
        assert!(report.warnings.contains(&ReadWarning::GeoidHeights));
        let (_, report) = read(open, Some(HeightDatum::TakeOff))?;
        assert!(report.warnings.contains(&ReadWarning::HeightsAboveTakeOff));
        // The ellipsoid's where there are several; the others are reported as not used.
        let several =
            "time_s,lat,lon,Altitude,ALT:Altitude,Ellipsoidal Height\n0,40.9,14.2,27,2,75\n";
        let (track, report) = read(several, None)?;
        assert!((track.geodetic().expect("place")[0].height_m - 75.0).abs() < 1e-9);
        assert_eq!(report.unused_columns, ["ALT:Altitude", "Altitude"]);
        let stated = "time_s,lat,lon,hae\n0,40.9,14.2,60\n";
        assert!(read(stated, Some(HeightDatum::Sea)).is_err());
        // A grid of the geoid raises heights above the sea: 20 m everywhere here.
        let options = ReadOptions::over_a_flat_geoid(20.0);
        let msl = "time_s,lat,lon,altitude_msl\n0,40.9,14.2,60\n";
        let (track, report) = read_trajectory(msl.as_bytes(), &options)?;
        assert!((track.geodetic().expect("place")[0].height_m - 80.0).abs() < 1e-5);
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
        Ok(())
    }

    #[test]
    fn milliseconds_without_a_name_are_asked_for() {
        let rows = |name: &str| {
            let rows: String = (0..9).map(|k| format!("{},{k},0,0\n", 200 * k)).collect();
            format!("{name},x,y,z\n{rows}")
        };
        let error = read_text(&rows("time")).expect_err("open").to_string();
        assert!(
            error.starts_with("line 1: column 'time' counts whole numbers in steps of 200"),
            "{error}"
        );
        let (track, _) = read_text(&rows("time_ms")).expect("stated");
        assert!((track.sample_interval_s().expect("rows") - 0.2).abs() < 1e-9);
        assert!(read_text(&rows("time_s")).is_ok());
    }
}
