//! Meaning of the columns of a table.

use super::csv_heights::{self, Above};
use super::{HeightDatum, ReadError};

/// Meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Role {
    Time,
    /// A date with its time of day, as text.
    DateTime,
    /// A date alone; [`Self::Time`] is the time of day then.
    Date,
    /// Time since some start, if there is no other.
    Elapsed,
    GpsWeek,
    TimeOfWeek,
    GpstUnix,
    Unix,
    /// Number of a radar's trace, for want of a time.
    Trace,
    Local(usize),
    Ecef(usize),
    Latitude,
    Longitude,
    Height(Above),
    Deviation(usize),
    Velocity(usize),
    Quaternion(usize),
    Roll,
    Pitch,
    Heading,
    RtklibQ,
    NmeaQuality,
    Status,
    /// A logger's word for the kind of solution.
    StatusWord,
    Satellites,
    Age,
    Ratio,
}

/// A column that was understood.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    pub index: usize,
    pub role: Role,
    /// Factor to SI units (degrees stay degrees).
    pub scale: f64,
    /// Whether the header names the unit.
    pub has_unit: bool,
}

/// The columns of a table.
#[derive(Debug)]
pub(super) struct Columns {
    pub separator: Separator,
    pub columns: Vec<Column>,
    /// The column of heights above the Earth, and their datum.
    pub height: Option<(Role, HeightDatum)>,
    pub unused: Vec<String>,
    /// Number of columns that the header names.
    pub width: usize,
}

/// Separator of the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Char(char),
    Blanks,
}

impl Separator {
    fn of(header: &str) -> Self {
        [';', ',', '\t']
            .into_iter()
            .find(|&c| header.contains(c))
            .map_or(Self::Blanks, Self::Char)
    }

    /// The cells of a line, trimmed, quotes taken off.
    pub fn split(self, line: &str) -> Vec<&str> {
        fn take(cell: &str) -> &str {
            let cell = cell.trim();
            cell.strip_prefix('"')
                .and_then(|c| c.strip_suffix('"'))
                .unwrap_or(cell)
        }
        match self {
            Self::Char(c) => line.split(c).map(take).collect(),
            Self::Blanks => line.split_whitespace().map(take).collect(),
        }
    }
}

/// Lower case, everything but letters and digits as one underscore between words.
fn plain(name: &str) -> String {
    let mut out = String::with_capacity(name.len());
    for c in name.chars() {
        if c.is_alphanumeric() {
            out.extend(c.to_lowercase());
        } else if !out.is_empty() && !out.ends_with('_') {
            out.push('_');
        }
    }
    out.trim_end_matches('_').to_owned()
}

/// The role of a name without its unit.
fn role(name: &str) -> Option<Role> {
    let axis = |c: char| match c {
        'x' | 'e' => Some(0),
        'y' | 'n' => Some(1),
        'z' | 'u' => Some(2),
        _ => None,
    };
    Some(match name {
        "time" | "t" | "timestamp" | "seconds" => Role::Time,
        "utc" | "datetime" | "datetime_utc" | "time_utc" | "utc_time" | "date_time"
        | "date_time_utc" | "timestamp_utc" => Role::DateTime,
        "date" | "date_utc" | "utc_date" => Role::Date,
        "elapsed" | "elapsed_time" => Role::Elapsed,
        "gps_week" | "week" => Role::GpsWeek,
        "tow" | "gps_tow" | "sow" | "gps_sow" => Role::TimeOfWeek,
        "gpst_unix" => Role::GpstUnix,
        "unix" | "unix_time" | "utc_unix" => Role::Unix,
        "trace" | "trace_number" | "trace_no" => Role::Trace,
        "x" | "east" | "e" | "easting" | "x_east" | "pos_x" | "position_x" => Role::Local(0),
        "y" | "north" | "n" | "northing" | "y_north" | "pos_y" | "position_y" => Role::Local(1),
        "z" | "up" | "u" | "z_up" | "pos_z" | "position_z" => Role::Local(2),
        "ecef_x" | "x_ecef" => Role::Ecef(0),
        "ecef_y" | "y_ecef" => Role::Ecef(1),
        "ecef_z" | "z_ecef" => Role::Ecef(2),
        "lat" | "latitude" => Role::Latitude,
        "lon" | "lng" | "long" | "longitude" => Role::Longitude,
        "roll" => Role::Roll,
        "pitch" => Role::Pitch,
        "heading" | "yaw" | "compass_heading" => Role::Heading,
        "qw" | "q_w" => Role::Quaternion(0),
        "qx" | "q_x" => Role::Quaternion(1),
        "qy" | "q_y" => Role::Quaternion(2),
        "qz" | "q_z" => Role::Quaternion(3),
        "q" | "quality" | "fix_quality" => Role::RtklibQ,
        "nmea_quality" | "gga_quality" => Role::NmeaQuality,
        "rtk_status" | "fix_status" | "fix_type" => Role::StatusWord,
        "status" | "solution" | "solution_status" => Role::Status,
        "ns" | "satellites" | "num_sats" | "sats" => Role::Satellites,
        "age" => Role::Age,
        "ratio" => Role::Ratio,
        "vx" | "v_x" | "ve" | "v_east" | "vel_x" | "velocity_x" => Role::Velocity(0),
        "vy" | "v_y" | "vn" | "v_north" | "vel_y" | "velocity_y" => Role::Velocity(1),
        "vz" | "v_z" | "vu" | "v_up" | "vel_z" | "velocity_z" => Role::Velocity(2),
        _ if csv_heights::above(name).is_some() => Role::Height(csv_heights::above(name)?),
        _ => {
            let of = ["sd", "std", "sigma", "stdev"]
                .into_iter()
                .find_map(|p| name.strip_prefix(p))
                .map(|rest| rest.trim_start_matches('_'))?;
            match of {
                "east" => Role::Deviation(0),
                "north" => Role::Deviation(1),
                "up" => Role::Deviation(2),
                _ => {
                    let mut letters = of.chars();
                    match (letters.next(), letters.next()) {
                        (Some(c), None) => Role::Deviation(axis(c)?),
                        _ => return None,
                    }
                }
            }
        }
    })
}

/// A unit that may follow a name, and its size.
fn unit(name: &str, role: Role) -> Option<f64> {
    let length = |unit: &str| match unit {
        "m" => Some(1.0),
        "mm" => Some(1e-3),
        "cm" => Some(1e-2),
        "km" => Some(1e3),
        "ft" | "feet" | "foot" => Some(0.3048),
        _ => None,
    };
    match role {
        Role::Time | Role::Elapsed | Role::TimeOfWeek | Role::GpstUnix | Role::Unix | Role::Age => {
            match name {
                "s" | "sec" | "second" | "seconds" => Some(1.0),
                "ms" | "msec" | "millisecond" | "milliseconds" => Some(1e-3),
                "us" | "usec" | "microsecond" | "microseconds" => Some(1e-6),
                "ns" | "nsec" | "nanosecond" | "nanoseconds" => Some(1e-9),
                _ => None,
            }
        }
        Role::Local(_) | Role::Ecef(_) | Role::Height(_) | Role::Deviation(_) => length(name),
        Role::Latitude | Role::Longitude | Role::Roll | Role::Pitch | Role::Heading => match name {
            "deg" | "degree" | "degrees" => Some(1.0),
            "rad" | "radians" => Some(180.0 / std::f64::consts::PI),
            _ => None,
        },
        Role::Velocity(_) => match name {
            "m_s" | "mps" => Some(1.0),
            "mm_s" => Some(1e-3),
            "cm_s" => Some(1e-2),
            _ => None,
        },
        _ => None,
    }
}

/// Role, size of the unit, and whether the name has one.
fn understood(name: &str) -> Option<(Role, f64, bool)> {
    let name = plain(name);
    if let Some(role) = role(&name) {
        return Some((role, 1.0, false));
    }
    // The unit is the text after one of the underscores.
    name.match_indices('_').find_map(|(at, _)| {
        let role = role(&name[..at])?;
        Some((role, unit(&name[at + 1..], role)?, true))
    })
}

/// Roles of which a later column is passed over: loggers write them more than once.
const FIRST_COUNTS: [Role; 3] = [Role::Roll, Role::Pitch, Role::Heading];

impl Columns {
    fn of(header: &str) -> Self {
        let separator = Separator::of(header);
        let names = separator.split(header);
        let mut columns: Vec<Column> = Vec::new();
        let mut unused = Vec::new();
        for (index, name) in names.iter().enumerate() {
            match understood(name) {
                Some((role, ..))
                    if (FIRST_COUNTS.contains(&role) || matches!(role, Role::Height(_)))
                        && columns.iter().any(|c| c.role == role) =>
                {
                    unused.push((*name).to_owned());
                }
                Some((role, scale, has_unit)) => columns.push(Column {
                    index,
                    role,
                    scale,
                    has_unit,
                }),
                None => unused.push((*name).to_owned()),
            }
        }
        Self {
            separator,
            columns,
            height: None,
            unused,
            width: names.len(),
        }
    }

    /// The name of the column of times, where they count from an unknown zero without a unit.
    pub fn clock_without_unit(&self, header: &str) -> Option<String> {
        let precise = [Role::GpsWeek, Role::GpstUnix, Role::Unix, Role::DateTime];
        if precise.into_iter().any(|role| self.has(role)) {
            return None;
        }
        let column = [Role::Time, Role::Elapsed]
            .into_iter()
            .find_map(|role| self.columns.iter().find(|c| c.role == role))?;
        let names = self.separator.split(header);
        (!column.has_unit).then(|| names[column.index].to_owned())
    }

    pub fn has(&self, role: Role) -> bool {
        self.columns.iter().any(|c| c.role == role)
    }

    fn has_time(&self) -> bool {
        [
            Role::Time,
            Role::DateTime,
            Role::Elapsed,
            Role::TimeOfWeek,
            Role::GpstUnix,
            Role::Unix,
        ]
        .iter()
        .any(|&r| self.has(r))
    }

    fn has_position(&self) -> bool {
        (0..3).all(|i| self.has(Role::Local(i)))
            || (0..3).all(|i| self.has(Role::Ecef(i)))
            || (self.has(Role::Latitude) && self.has(Role::Longitude) && self.height.is_some())
    }

    /// Whether trace numbers replace times.
    pub fn has_trace_numbers(&self) -> bool {
        self.has(Role::Trace) && !self.has_time()
    }

    /// Whether a line could be the header of a trajectory: a time, and at least one coordinate.
    pub fn recognised(header: &str) -> bool {
        let columns = Self::of(header);
        let coordinate = columns
            .columns
            .iter()
            .any(|c| matches!(c.role, Role::Local(_) | Role::Ecef(_) | Role::Latitude));
        (columns.has_time() || columns.has(Role::Trace)) && coordinate
    }

    /// The columns of a header line.
    pub fn from_header(
        line: u64,
        header: &str,
        heights: Option<HeightDatum>,
    ) -> Result<Self, ReadError> {
        let mut columns = Self::of(header);
        let names = columns.separator.split(header);
        let problem = |problem: String| Err(ReadError::Header { line, problem });
        for (i, a) in columns.columns.iter().enumerate() {
            if let Some(b) = columns.columns[i + 1..].iter().find(|b| b.role == a.role) {
                return problem(format!(
                    "columns '{}' and '{}' mean the same",
                    names[a.index], names[b.index]
                ));
            }
        }
        let is_height = |c: &&Column| matches!(c.role, Role::Height(_));
        if !columns.has(Role::Local(0)) {
            let found: Vec<(Above, &str)> = (columns.columns.iter())
                .filter_map(|c| match c.role {
                    Role::Height(above) => Some((above, names[c.index])),
                    _ => None,
                })
                .collect();
            let chosen = csv_heights::choose(line, &found, heights)?;
            columns.height = chosen.map(|(above, datum)| (Role::Height(above), datum));
        }
        let chosen = columns.height.map(|(role, _)| role);
        let others = columns.columns.iter().filter(is_height);
        let others = others.filter(|c| Some(c.role) != chosen);
        let passed_over: Vec<String> = others.map(|c| names[c.index].to_owned()).collect();
        columns.unused.extend(passed_over);
        if columns.has_time() {
            let traces = columns.columns.iter().filter(|c| c.role == Role::Trace);
            let unused: Vec<String> = traces.map(|c| names[c.index].to_owned()).collect();
            columns.unused.extend(unused);
        } else if !columns.has(Role::Trace) {
            return problem(
                "no column of time (time_s, or gps_week and tow_s) or trace".to_owned(),
            );
        }
        if columns.has(Role::TimeOfWeek) && !columns.has(Role::GpsWeek) && !columns.has(Role::Time)
        {
            return problem("seconds of week need a column gps_week".to_owned());
        }
        if !columns.has_position() {
            return problem(
                "no complete position (x_m, y_m, z_m; or east, north, up; or lat, lon, height; or \
                 ecef_x, ecef_y, ecef_z)"
                    .to_owned(),
            );
        }
        Ok(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_their_units() {
        for (name, want) in [
            ("time(millisecond)", Some((Role::Time, 1e-3))),
            (
                "altitude_above_seaLevel(feet)",
                Some((Role::Height(Above::Stated(HeightDatum::Sea)), 0.3048)),
            ),
            (
                "Ellipsoid Height (m)",
                Some((Role::Height(Above::Stated(HeightDatum::Ellipsoid)), 1.0)),
            ),
            ("Altitude", Some((Role::Height(Above::Open), 1.0))),
            ("compass_heading(degrees)", Some((Role::Heading, 1.0))),
            ("time_s", Some((Role::Time, 1.0))),
            ("Time (ms)", Some((Role::Time, 1e-3))),
            ("X [mm]", Some((Role::Local(0), 1e-3))),
            ("up_m", Some((Role::Local(2), 1.0))),
            ("gpst_unix_s", Some((Role::GpstUnix, 1.0))),
            ("Longitude (deg)", Some((Role::Longitude, 1.0))),
            ("sd_x_m", Some((Role::Deviation(0), 1.0))),
            ("sdn(m)", Some((Role::Deviation(1), 1.0))),
            ("sigma_up_cm", Some((Role::Deviation(2), 1e-2))),
            ("vz_m_s", Some((Role::Velocity(2), 1.0))),
            ("ecef_y_m", Some((Role::Ecef(1), 1.0))),
            ("nmea_quality", Some((Role::NmeaQuality, 1.0))),
            ("ns", Some((Role::Satellites, 1.0))),
            ("temperature", None),
            ("sdne_m", None),
            ("", None),
        ] {
            let found = understood(name).map(|(role, scale, _)| (role, scale));
            assert_eq!(found, want, "{name}");
        }
    }
}
