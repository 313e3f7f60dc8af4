//! Tables with a header line.

use std::io::BufRead;

use super::assemble::{Assembler, Axes, Record, Stamp};
use super::csv_columns::{Column, Columns, Role, Separator};
use super::error::quoted;
use super::lines::{Line, Lines};
use super::nmea::status_of_quality;
use super::{ReadError, ReadOptions, ReadReport, SkipReason, TrajectoryFormat};
use crate::geodesy::{EnuFrame, Geodetic};
use crate::matrix::Vector3;
use crate::time::{Calendar, GpsTime};
use crate::trajectory::{Attitude, Fix, Frame, SolutionStatus, TimeOrigin, Trajectory};

/// 1980-01-06 counted from 1970-01-01 (s).
const GPS_EPOCH_FROM_1970_S: i64 = 315_964_800;

/// Comment entries of `trajectory.csv` that make it whole: see `crate::write`.
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
            let found = Columns::from_header(line.number, text)?;
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
        };
        let Some(mut fix) = row.position()? else {
            all.skip(SkipReason::EmptyPosition, line.number);
            continue;
        };
        let stamp = row.stamp()?;
        let this = Clock::of(&stamp);
        if *clock.get_or_insert(this) != this {
            return Err(line.malformed("the same kind of time as before", quoted(text)));
        }
        row.details(&mut fix)?;
        all.push(Record {
            line: line.number,
            stamp,
            fix,
        })?;
    }
    let ecef = columns.as_ref().is_some_and(|c| !c.has(Role::Local(0)));
    let axes = match (ecef, stated.origin) {
        (true, _) => Axes::Ecef { reference_m: None },
        (false, Some(origin)) => Axes::Local(Frame::Enu(EnuFrame::new(origin))),
        (false, None) => Axes::Local(Frame::Local),
    };
    let clock = stated
        .second_zero
        .map_or(TimeOrigin::Relative, TimeOrigin::Gps);
    all.finish(&axes, clock, lines.count())
}

/// Which kind of time a file uses.
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

/// One row of the table, seen through its columns.
struct Row<'a> {
    line: &'a Line<'a>,
    cells: &'a [&'a str],
    columns: &'a Columns,
}

impl Row<'_> {
    fn cell(&self, role: Role) -> Option<(&str, &Column)> {
        let column = self.columns.columns.iter().find(|c| c.role == role)?;
        Some((self.cells[column.index], column))
    }

    /// A number, its unit applied; none when the column is missing or the cell is empty.
    fn number(&self, role: Role, name: &str) -> Result<Option<f64>, ReadError> {
        match self.cell(role) {
            None | Some(("", _)) => Ok(None),
            Some((text, column)) => {
                // A comma among semicolons is a decimal comma.
                let value = if self.columns.separator == Separator::Char(';') && text.contains(',')
                {
                    self.line.number(name, &text.replace(',', "."))?
                } else {
                    self.line.number(name, text)?
                };
                Ok(Some(value * column.scale))
            }
        }
    }

    /// Three numbers that go together: all, or none when all are missing or empty.
    fn three(&self, roles: [Role; 3], names: [&str; 3]) -> Result<Option<Vector3>, ReadError> {
        let mut out = [None; 3];
        for ((out, role), name) in out.iter_mut().zip(roles).zip(names) {
            *out = self.number(role, name)?;
        }
        match out {
            [Some(a), Some(b), Some(c)] => Ok(Some([a, b, c])),
            [None, None, None] => Ok(None),
            _ => Err(self.line.malformed(
                format!("all of {}", names.join(", ")),
                quoted(&self.line.text),
            )),
        }
    }

    fn in_range(
        &self,
        name: &str,
        value: f64,
        limit: f64,
        expected: &'static str,
    ) -> Result<f64, ReadError> {
        if value.abs() <= limit {
            Ok(value)
        } else {
            Err(ReadError::OutOfRange {
                line: self.line.number,
                field: name.to_owned(),
                value,
                expected,
            })
        }
    }

    /// The position, and the covariance in the same axes.
    fn position(&self) -> Result<Option<Fix>, ReadError> {
        let axes3 = |f: fn(usize) -> Role| [f(0), f(1), f(2)];
        let has_local = self.columns.has(Role::Local(0));
        let (position, enu) = if has_local {
            (self.three(axes3(Role::Local), ["x", "y", "z"])?, None)
        } else if self.columns.has(Role::Latitude) {
            let roles = [Role::Latitude, Role::Longitude, Role::Height];
            let names = ["latitude", "longitude", "height"];
            match self.three(roles, names)? {
                Some([latitude, longitude, height]) => {
                    self.in_range("latitude", latitude, 90.0, "−90° to 90°")?;
                    self.in_range("longitude", longitude, 360.0, "−360° to 360°")?;
                    let frame = EnuFrame::new(Geodetic::from_degrees(latitude, longitude, height));
                    (Some(frame.origin_in_ecef_m()), Some(frame))
                }
                None => (None, None),
            }
        } else {
            let p = self.three(axes3(Role::Ecef), ["ecef_x", "ecef_y", "ecef_z"])?;
            (p, p.map(EnuFrame::from_ecef))
        };
        let Some(position) = position else {
            return Ok(None);
        };
        for (name, value) in ["x", "y", "z"].iter().zip(position) {
            self.in_range(name, value, 4e8, "within 4e8 m")?;
        }
        let mut fix = Fix::new(0.0, position);
        let deviations = self.three(axes3(Role::Deviation), ["sd_x", "sd_y", "sd_z"])?;
        if let Some(sd) = deviations {
            let mut c = [[0.0; 3]; 3];
            for (i, sd) in sd.into_iter().enumerate() {
                c[i][i] = self
                    .in_range("standard deviation", sd, 1e8, "within 1e8 m")?
                    .powi(2);
            }
            fix.covariance_m2 = Some(enu.map_or(c, |frame| frame.ecef_covariance_from_enu(&c)));
        }
        let velocity = self.three(axes3(Role::Velocity), ["vx", "vy", "vz"])?;
        fix.velocity_m_s = velocity.map(|v| enu.map_or(v, |frame| frame.ecef_vector_from_enu(v)));
        Ok(Some(fix))
    }

    fn stamp(&self) -> Result<Stamp, ReadError> {
        if let (Some(week), Some(tow)) = (
            self.number(Role::GpsWeek, "GPS week")?,
            self.number(Role::TimeOfWeek, "tow")?,
        ) {
            let week = self.in_range("GPS week", week, 9_999.0, "0 to 9999")?;
            let tow = self.in_range("tow", tow, 604_800.0, "0 to 604800")?;
            return Ok(Stamp::Gps(GpsTime::from_week_tow(week as i64, tow)));
        }
        for role in [Role::GpstUnix, Role::Unix] {
            if let Some((text, column)) = self.cell(role) {
                let (whole, part) = self.long_seconds(text, column.scale)?;
                return Ok(Stamp::Gps(match role {
                    Role::GpstUnix => GpsTime::new(whole - GPS_EPOCH_FROM_1970_S, part),
                    _ => GpsTime::from_unix(whole, part),
                }));
            }
        }
        let Some((text, column)) = self.cell(Role::Time) else {
            return Err(self.line.malformed("a time", quoted(&self.line.text)));
        };
        if text.get(4..5) == Some("-") {
            return self.iso_utc(text).map(Stamp::Gps);
        }
        let text = if self.columns.separator == Separator::Char(';') {
            text.replace(',', ".")
        } else {
            text.to_owned()
        };
        let t = self
            .line
            .number_in("time", &text, -1e15..=1e15, "within 1e15")?;
        Ok(Stamp::Seconds(t * column.scale))
    }

    /// Seconds since 1970, whole and rest apart: one f64 would keep a quarter of a microsecond.
    fn long_seconds(&self, text: &str, scale: f64) -> Result<(i64, f64), ReadError> {
        let value = self
            .line
            .number_in("time", text, -1e21..=1e21, "seconds since 1970")?
            * scale;
        self.in_range("time", value, 1e11, "seconds since 1970")?;
        if scale == 1.0
            && let Some((whole, part)) = text.split_once('.')
            && let (Ok(whole), Ok(part)) = (whole.parse::<i64>(), format!("0.{part}").parse())
            && whole >= 0
        {
            return Ok((whole, part));
        }
        Ok((value.floor() as i64, value - value.floor()))
    }

    /// `yyyy-mm-ddThh:mm:ss.sssZ`; the T may be a blank, the Z may lack.
    fn iso_utc(&self, text: &str) -> Result<GpsTime, ReadError> {
        let bad = || {
            self.line.malformed(
                "a number of seconds or yyyy-mm-ddThh:mm:ss[.sss][Z]",
                quoted(text),
            )
        };
        let body = text.strip_suffix(['Z', 'z']).unwrap_or(text);
        let (date, clock) = body.split_once(['T', 't', ' ']).ok_or_else(bad)?;
        let date: Vec<&str> = date.split('-').collect();
        let clock: Vec<&str> = clock.split(':').collect();
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
        )
        .and_then(|c| GpsTime::from_utc(&c));
        calendar.map_err(|e| self.line.malformed("a date and time of UTC", e.to_string()))
    }

    fn details(&self, fix: &mut Fix) -> Result<(), ReadError> {
        if let Some(q) = self.number(Role::RtklibQ, "q")? {
            fix.status = SolutionStatus::from_rtklib_q(q as u32);
        } else if let Some(q) = self.number(Role::NmeaQuality, "quality")? {
            fix.status = status_of_quality(q as u32).unwrap_or(SolutionStatus::Unknown);
        } else if let Some((text, _)) = self.cell(Role::Status) {
            let number = text.parse().ok().map(SolutionStatus::from_rtklib_q);
            fix.status = number
                .or_else(|| SolutionStatus::from_name(text))
                .ok_or_else(|| {
                    let names = SolutionStatus::ALL.map(SolutionStatus::name).join(", ");
                    self.line
                        .malformed(format!("a status: {names}"), quoted(text))
                })?;
        }
        if let Some(n) = self.number(Role::Satellites, "satellites")? {
            fix.satellites = Some(n.clamp(0.0, f64::from(u16::MAX)) as u16);
        }
        fix.age_s = self.number(Role::Age, "age")?;
        fix.ratio = self.number(Role::Ratio, "ratio")?;
        let mut q = [None; 4];
        for (i, q) in q.iter_mut().enumerate() {
            *q = self.number(Role::Quaternion(i), "quaternion")?;
        }
        if let [Some(w), Some(x), Some(y), Some(z)] = q {
            fix.attitude = Some(Attitude::from_quaternion(w, x, y, z).ok_or_else(|| {
                self.line
                    .malformed("a quaternion of some length", format!("{w} {x} {y} {z}"))
            })?);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read_trajectory;

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
        ] {
            let error = read_text(text).expect_err(text).to_string();
            assert!(error.starts_with(want), "{error}");
        }
    }
}
