//! One row of a table: position, time and details.

use super::assemble::Stamp;
use super::csv_columns::{Column, Columns, Role, Separator};
use super::csv_seen::Seen;
use super::csv_time::{is_calendar, of_1970, of_a_clock, of_calendar};
use super::error::quoted;
use super::lines::Line;
use super::nmea::status_of_quality;
use super::{HeightDatum, ReadError, ReadOptions};
use crate::geodesy::{EnuFrame, Geodetic};
use crate::matrix::Vector3;
use crate::time::GpsTime;
use crate::trajectory::{Attitude, Fix, SolutionStatus};

/// One row of the table, seen through its columns.
pub(super) struct Row<'a> {
    pub(super) line: &'a Line<'a>,
    pub(super) cells: &'a [&'a str],
    pub(super) columns: &'a Columns,
    pub(super) options: &'a ReadOptions,
}

impl Row<'_> {
    fn cell(&self, role: Role) -> Option<(&str, &Column)> {
        let column = self.columns.columns.iter().find(|c| c.role == role)?;
        Some((self.cells[column.index], column))
    }

    /// A number in its base unit; `None` where the column is missing or the cell is empty.
    fn number(&self, role: Role, name: &str) -> Result<Option<f64>, ReadError> {
        match self.cell(role) {
            None | Some(("", _)) => Ok(None),
            Some((text, column)) => {
                let value = self.line.number(name, &self.with_point(text))?;
                Ok(Some(value * column.scale))
            }
        }
    }

    /// Three numbers that belong together; `None` where all are missing or empty.
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

    /// A place by latitude, longitude and the chosen height, converted to a height above the ellipsoid where possible.
    fn place(
        &self,
        [latitude, longitude, height]: Vector3,
        datum: HeightDatum,
        seen: &mut Seen,
    ) -> Result<Geodetic, ReadError> {
        self.in_range("latitude", latitude, 90.0, "−90° to 90°")?;
        self.in_range("longitude", longitude, 360.0, "−360° to 360°")?;
        seen.latitude_deg.get_or_insert(latitude);
        let place = Geodetic::from_degrees(latitude, longitude, height);
        if datum != HeightDatum::Sea {
            return Ok(place);
        }
        Ok(self.options.above_ellipsoid(place).unwrap_or_else(|| {
            seen.not_raised += 1;
            place
        }))
    }

    /// The position, and the covariance in the same axes.
    pub(super) fn position(&self, seen: &mut Seen) -> Result<Option<Fix>, ReadError> {
        let axes3 = |f: fn(usize) -> Role| [f(0), f(1), f(2)];
        let has_local = self.columns.has(Role::Local(0));
        let mut roles = axes3(if has_local { Role::Local } else { Role::Ecef });
        let (position, enu) = if has_local {
            (self.three(axes3(Role::Local), ["x", "y", "z"])?, None)
        } else if let (true, Some((height, datum))) =
            (self.columns.has(Role::Latitude), self.columns.height)
        {
            roles = [Role::Latitude, Role::Longitude, height];
            let names = ["latitude", "longitude", "height"];
            match self.three(roles, names)? {
                Some(numbers) => {
                    let frame = EnuFrame::new(self.place(numbers, datum, seen)?);
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
        for (digits, role) in seen.digits.iter_mut().zip(roles) {
            if let Some((text, _)) = self.cell(role) {
                digits.take(text);
            }
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

    pub(super) fn stamp(&self, seen: &mut Seen) -> Result<Stamp, ReadError> {
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
                let scale = column.has_unit.then_some(column.scale);
                return of_1970(self.line, text, scale, role == Role::GpstUnix);
            }
        }
        if let (Some((date, _)), Some((clock, _))) = (self.cell(Role::Date), self.cell(Role::Time))
            && is_calendar(date)
        {
            let (time, has_zone) = of_calendar(self.line, date, clock)?;
            seen.without_zone += u64::from(!has_zone);
            return Ok(Stamp::Gps(time));
        }
        for role in [Role::DateTime, Role::Time, Role::Elapsed] {
            let Some((text, column)) = self.cell(role) else {
                continue;
            };
            if is_calendar(text) {
                let (date, clock) = text.split_once(['T', 't', ' ']).unwrap_or((text, ""));
                let (time, has_zone) = of_calendar(self.line, date, clock)?;
                let is_utc = role == Role::DateTime;
                seen.without_zone += u64::from(!has_zone && !is_utc);
                if let (true, Some(fine_s)) = (is_utc, self.finer_s()) {
                    seen.pairs.push((time, fine_s));
                }
                return Ok(Stamp::Gps(time));
            }
            let text = self.with_point(text);
            let scale = column.has_unit.then_some(column.scale);
            let stamp = of_a_clock(self.line, &text, scale)?;
            if let Stamp::Seconds(s) = stamp {
                seen.note_whole(s);
            }
            return Ok(stamp);
        }
        let number = self.number(Role::Trace, "trace")?;
        if let Some(number) = number.filter(|n| n.fract() == 0.0 && *n >= 0.0) {
            return Ok(Stamp::Seconds(number));
        }
        let expected = match self.columns.has_trace_numbers() {
            true => "the number of a trace",
            false => "a time",
        };
        Err(self.line.malformed(expected, quoted(&self.line.text)))
    }

    /// The reading of a clock in a separate column, next to a date (s).
    fn finer_s(&self) -> Option<f64> {
        [Role::Time, Role::Elapsed].into_iter().find_map(|role| {
            let (text, column) = self.cell(role)?;
            let scale = column.has_unit.then_some(column.scale)?;
            let value: f64 = self.with_point(text).parse().ok()?;
            value.is_finite().then_some(value * scale)
        })
    }

    /// A comma among semicolons is a decimal comma.
    fn with_point<'t>(&self, text: &'t str) -> std::borrow::Cow<'t, str> {
        if self.columns.separator == Separator::Char(';') && text.contains(',') {
            text.replace(',', ".").into()
        } else {
            text.into()
        }
    }

    pub(super) fn details(&self, fix: &mut Fix) -> Result<(), ReadError> {
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
        } else if let Some((text, _)) = self.cell(Role::StatusWord) {
            fix.status = SolutionStatus::from_name(text).unwrap_or(SolutionStatus::Unknown);
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
        } else if let (Some(roll), Some(pitch), Some(heading)) = (
            self.number(Role::Roll, "roll")?,
            self.number(Role::Pitch, "pitch")?,
            self.number(Role::Heading, "heading")?,
        ) {
            fix.attitude = Attitude::from_euler([roll, pitch, heading].map(f64::to_radians));
        }
        Ok(())
    }
}
