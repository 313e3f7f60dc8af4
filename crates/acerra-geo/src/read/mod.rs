//! Readers of trajectory files, recognised from content.
//!
//! | format | what is read |
//! | --- | --- |
//! | RTKLIB `.pos` | latitude/longitude/height in degrees or d-m-s, ECEF, E/N/U baseline; calendar or week and seconds; GPST, UTC, JST; any separator; with or without header |
//! | CSV with a header | `time_s,x_m,y_m,z_m` and the many other names that mean the same, see [`csv columns`](TrajectoryFormat::Csv) |
//! | NMEA 0183 | GGA, dated by RMC or ZDA, standard deviations by GST |
//! | OptiTrack Motive export | 1.2x CSV; a rigid body (or marker), Y up turned to z up |
//!
//! Lines may end in LF, CR LF or CR.
//!
//! Positions end up in one local frame: about the origin asked for, else the base station that a
//! `.pos` header states, else the first good position. GNSS times become GPS seconds of week.
//!
//! Nothing is dropped in silence: what a reader skips is counted in its [`ReadReport`] with the
//! reason and the first line it happened on; what cannot be meant is an error with its line.

mod assemble;
mod csv;
mod csv_columns;
mod error;
mod lines;
mod motive;
mod motive_header;
mod nmea;
mod pos;
mod pos_header;
mod report;
mod sniff;

pub use error::ReadError;
pub use report::{ReadReport, ReadWarning, SkipReason, Skipped};
pub use sniff::sniff;

use std::io::{BufRead, Cursor, Read};

use crate::geodesy::Geodetic;
use crate::trajectory::Trajectory;

/// How many bytes of a file [`sniff`] is shown.
pub const SNIFF_BYTES: usize = 64 * 1024;

/// The kinds of trajectory file that can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TrajectoryFormat {
    /// RTKLIB's solution text.
    RtklibPos,
    /// A table with a header line: commas, semicolons, tabs or blanks between columns.
    ///
    /// Units may follow a name as `x_mm`, `x (mm)` or `x [mm]`; case does not matter.
    ///
    /// | meaning | names |
    /// | --- | --- |
    /// | time | `time_s`, `time`, `t`, `timestamp` (ISO 8601 text is UTC); `gps_week` with `tow_s`; `gpst_unix_s`; `unix_s` (UTC) |
    /// | position | `x y z`, `east north up`, `e n u`; `lat lon height` (also `latitude`, `longitude`, `lng`, `altitude`, `alt`, `h`), `ecef_x ecef_y ecef_z` |
    /// | standard deviation | `sd_x`, `sdx`, `sigma_x`, `std_x`, … for the same axes; east, north, up for geodetic positions |
    /// | quality | `q` (RTKLIB), `nmea_quality`, `status` (word or RTKLIB's number) |
    /// | others | `vx vy vz`, `qw qx qy qz` (body forward-left-up to east-north-up), `ns`, `age_s`, `ratio` |
    Csv,
    /// NMEA 0183 sentences.
    Nmea,
    /// OptiTrack Motive's CSV export.
    Motive,
}

impl TrajectoryFormat {
    /// A name for messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RtklibPos => "RTKLIB .pos",
            Self::Csv => "CSV table",
            Self::Nmea => "NMEA 0183",
            Self::Motive => "OptiTrack Motive export",
        }
    }
}

impl std::fmt::Display for TrajectoryFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// How to read a trajectory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Origin of the local frame. Geodetic and ECEF positions are expressed about it; positions
    /// that are local already are taken to be about it. None: as the [module](self) says.
    pub origin: Option<Geodetic>,
    /// Which rigid body (or marker) of a motion-capture file; none: the only rigid body.
    pub rigid_body: Option<String>,
    /// The format, when it is known; none: recognised from content.
    pub format: Option<TrajectoryFormat>,
    /// Most positions accepted.
    pub max_fixes: usize,
    /// Longest line accepted (bytes).
    pub max_line_bytes: usize,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            origin: None,
            rigid_body: None,
            format: None,
            max_fixes: 10_000_000,
            max_line_bytes: 1 << 20,
        }
    }
}

impl ReadOptions {
    /// The same with an origin of the local frame.
    #[must_use]
    pub fn with_origin(mut self, origin: Geodetic) -> Self {
        self.origin = Some(origin);
        self
    }

    /// The same with the rigid body of that name.
    #[must_use]
    pub fn with_rigid_body(mut self, name: impl Into<String>) -> Self {
        self.rigid_body = Some(name.into());
        self
    }
}

/// Reads a trajectory of any known format.
///
/// The input is read once, front to back; memory is what the positions need.
///
/// # Errors
/// [`ReadError`], with the line where there is one; the caller adds the path.
///
/// ```
/// use acerra_geo::read::{ReadOptions, TrajectoryFormat, read_trajectory};
///
/// let table = "time_s,x_m,y_m,z_m\n0.0,0,0,4\n0.1,0.15,0,4\n0.2,0.30,0,4.01\n";
/// let (track, report) = read_trajectory(table.as_bytes(), &ReadOptions::default())?;
/// assert_eq!(report.format, TrajectoryFormat::Csv);
/// assert_eq!(track.fixes()[1].position_m, [0.15, 0.0, 4.0]);
///
/// let broken = "time_s,x_m,y_m,z_m\n0.0,0,0,4\n0.1,nan,0,4\n";
/// let error = read_trajectory(broken.as_bytes(), &ReadOptions::default()).unwrap_err();
/// assert_eq!(error.to_string(), "line 3: x is NaN, expected a finite number");
/// # Ok::<(), acerra_geo::read::ReadError>(())
/// ```
pub fn read_trajectory(
    mut reader: impl BufRead,
    options: &ReadOptions,
) -> Result<(Trajectory, ReadReport), ReadError> {
    let mut start = Vec::new();
    reader
        .by_ref()
        .take(SNIFF_BYTES as u64)
        .read_to_end(&mut start)?;
    if start.is_empty() {
        return Err(ReadError::Empty);
    }
    let format = match options.format.or_else(|| sniff(&start)) {
        Some(format) => format,
        None => return Err(sniff::unknown(&start)),
    };
    let whole = Cursor::new(start).chain(reader);
    let mut lines = lines::Lines::new(whole, options.max_line_bytes);
    match format {
        TrajectoryFormat::RtklibPos => pos::read(&mut lines, options),
        TrajectoryFormat::Csv => csv::read(&mut lines, options),
        TrajectoryFormat::Nmea => nmea::read(&mut lines, options),
        TrajectoryFormat::Motive => motive::read(&mut lines, options),
    }
}
