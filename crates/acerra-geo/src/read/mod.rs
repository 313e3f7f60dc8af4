//! Readers of trajectory files, recognised from content.
//!
//! | format | what is read |
//! | --- | --- |
//! | RTKLIB `.pos` | latitude/longitude/height in degrees or d-m-s, ECEF, E/N/U baseline; calendar or week and seconds; GPST, UTC, JST; any separator; with or without header |
//! | CSV with a header | `time_s,x_m,y_m,z_m` and many synonyms, see [`csv columns`](TrajectoryFormat::Csv) |
//! | NMEA 0183 | GGA, dated by RMC or ZDA, standard deviations by GST |
//! | OptiTrack Motive export | 1.2x CSV; a rigid body (or marker), Y up turned to z up |
//!
//! Lines may end in LF, CR LF or CR.
//!
//! Positions are given in one local frame: about the requested origin, else the base station in the header of
//! a `.pos` file, else the first good position. GNSS times become GPS seconds of week.
//!
//! Skipped data are counted in the [`ReadReport`] with the reason and the first line; impossible data are an
//! error with the line.

mod assemble;
mod csv;
mod csv_columns;
mod csv_heights;
mod csv_row;
mod csv_seen;
mod csv_time;
mod digits;
mod error;
mod format;
mod lines;
mod motive;
mod motive_header;
mod nmea;
mod options;
mod pos;
mod pos_header;
mod report;
mod sniff;

pub use csv_heights::HeightDatum;
pub use error::ReadError;
pub use format::TrajectoryFormat;
pub use options::ReadOptions;
pub use report::{ReadReport, ReadWarning, SkipReason, Skipped};
pub use sniff::sniff;

use std::io::{BufRead, Cursor, Read};

use crate::trajectory::Trajectory;

/// Number of bytes of a file for [`sniff`].
pub const SNIFF_BYTES: usize = 64 * 1024;

/// Reads a trajectory of any known format.
///
/// The input is read once, front to back, in the memory of its positions.
///
/// # Errors
/// [`ReadError`], with the line if there is one; the caller adds the path.
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
