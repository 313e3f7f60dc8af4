//! A file of positions, whatever its kind: text, or the log of an autopilot or a robot.

use std::io::{BufRead, Cursor, Read};
use std::path::PathBuf;
use std::sync::Arc;

use acerra_autopilot::{GimbalChoice, LogError, LogOptions, LogReport, read_log};
use acerra_geo::geodesy::Geodetic;
use acerra_geo::geoid::{GeoidError, GeoidGrid};
use acerra_geo::read::{ReadError, ReadOptions, ReadReport, read_trajectory};
use acerra_geo::trajectory::Trajectory;

use crate::choices::HeightDatum;

/// Options for reading a file of positions.
#[derive(Clone, Debug, Default)]
pub struct TrajectoryFileOptions {
    /// Origin of the local frame; by default the file's origin, or its first position.
    pub origin: Option<Geodetic>,
    /// Rigid body of a motion-capture export that holds several.
    pub rigid_body: Option<String>,
    /// Source of the positions in an autopilot's log.
    pub source: Option<String>,
    /// Source of the attitudes in an autopilot's log.
    pub attitude_source: Option<String>,
    /// Source of each position's attitude in addition to the vehicle's, of an autopilot's log.
    pub gimbal: GimbalChoice,
    /// Whether the first of several sources is used, with a remark that names the others.
    pub takes_first_source: bool,
    /// Vertical datum of the heights of a table, where its header states none.
    pub height_datum: Option<HeightDatum>,
    /// Grid of the geoid, which converts heights above the sea to heights above the ellipsoid.
    pub geoid: Option<PathBuf>,
    /// Whether a table may give numbers of traces in place of times.
    pub trace_numbers: bool,
}

/// A file of positions.
#[derive(Clone, Debug)]
pub struct TrajectoryFile {
    /// The positions.
    pub trajectory: Trajectory,
    /// Remarks of the reader.
    pub report: TrajectoryReport,
}

/// Remarks of the reader of a file of positions.
#[derive(Clone, Debug)]
pub enum TrajectoryReport {
    /// Remarks on a text file.
    Text(ReadReport),
    /// Remarks on the log of an autopilot or a robot.
    Log(LogReport),
}

/// Reason for which a file of positions cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryFileError {
    /// The file's start cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// A text that cannot be used.
    #[error(transparent)]
    Text(#[from] ReadError),
    /// A log that cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The grid of the geoid cannot be read.
    #[error("[image] geoid: {0}")]
    Geoid(#[from] GeoidError),
    /// A source is named for a file without sources.
    #[error(
        "[trajectory] {key}: expected the log of an autopilot or a robot, which has sources, found another kind"
    )]
    NoSources {
        /// The key.
        key: &'static str,
    },
    /// The attitude of a gimbal is requested of a file that cannot hold one.
    #[error(
        "[image] antenna_axis: expected the log of an autopilot or a robot, which may hold the attitude of a \
         gimbal, found another kind"
    )]
    NoGimbal,
    /// A file of an unknown kind.
    #[error(
        "not a trajectory in a known format (RTKLIB .pos, CSV with a header, NMEA GGA, OptiTrack Motive \
         export, ArduPilot .bin, PX4 .ulg, MAVLink .tlog, MCAP of ROS 2); it begins with {found}"
    )]
    UnknownFormat {
        /// Beginning of the file.
        found: String,
    },
}

/// Reads a file of positions; its kind is recognised from its content.
///
/// # Errors
/// A file of unknown kind, or an unusable file; the caller adds the path.
pub fn read_trajectory_file(
    mut reader: impl BufRead,
    options: &TrajectoryFileOptions,
) -> Result<TrajectoryFile, TrajectoryFileError> {
    let mut start = Vec::new();
    let head = acerra_autopilot::SNIFF_BYTES as u64;
    reader.by_ref().take(head).read_to_end(&mut start)?;
    let format = acerra_autopilot::sniff(&start);
    let whole = Cursor::new(start).chain(reader);
    match format {
        Some(_) => from_log(whole, options),
        None => from_text(whole, options),
    }
}

fn from_log(
    reader: impl Read,
    options: &TrajectoryFileOptions,
) -> Result<TrajectoryFile, TrajectoryFileError> {
    let mut reading = LogOptions::default();
    reading.origin = options.origin;
    reading.source.clone_from(&options.source);
    reading.attitude_source.clone_from(&options.attitude_source);
    reading.gimbal.clone_from(&options.gimbal);
    reading.takes_first = options.takes_first_source;
    if let Some(path) = &options.geoid {
        reading.geoid = Some(Arc::new(GeoidGrid::read(path)?));
    }
    let (trajectory, report) = read_log(reader, &reading)?;
    Ok(TrajectoryFile {
        trajectory,
        report: TrajectoryReport::Log(report),
    })
}

fn from_text(
    reader: impl BufRead,
    options: &TrajectoryFileOptions,
) -> Result<TrajectoryFile, TrajectoryFileError> {
    for (key, name) in [
        ("source", &options.source),
        ("attitude_source", &options.attitude_source),
    ] {
        if name.is_some() {
            return Err(TrajectoryFileError::NoSources { key });
        }
    }
    if options.gimbal != GimbalChoice::None {
        return Err(TrajectoryFileError::NoGimbal);
    }
    let mut reading = ReadOptions::default();
    reading.origin = options.origin;
    reading.rigid_body.clone_from(&options.rigid_body);
    reading.trace_numbers = options.trace_numbers;
    reading.heights = options.height_datum.map(Into::into);
    if let Some(path) = &options.geoid {
        reading.geoid = Some(Arc::new(GeoidGrid::read(path)?));
    }
    let read = read_trajectory(reader, &reading).map_err(|error| match error {
        ReadError::UnknownFormat { found } => TrajectoryFileError::UnknownFormat { found },
        error => error.into(),
    });
    let (trajectory, report) = read?;
    Ok(TrajectoryFile {
        trajectory,
        report: TrajectoryReport::Text(report),
    })
}

impl TrajectoryFile {
    /// Whether the file gives the positions in a local frame.
    #[must_use]
    pub const fn has_local_axes(&self) -> bool {
        match &self.report {
            TrajectoryReport::Text(report) => report.is_local,
            TrajectoryReport::Log(report) => report.is_local(),
        }
    }

    /// Step of the last digit of the positions east, north and up (m); `None` for logs.
    #[must_use]
    pub const fn resolution_m(&self) -> Option<[f64; 3]> {
        match &self.report {
            TrajectoryReport::Text(report) => report.resolution_m,
            TrajectoryReport::Log(_) => None,
        }
    }

    /// Omissions and assumptions, as sentences.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        match &self.report {
            TrajectoryReport::Text(report) => {
                let skipped = (report.skipped_total() > 0).then(|| report.to_string());
                let warnings = report.warnings.iter().map(ToString::to_string);
                skipped.into_iter().chain(warnings).collect()
            }
            TrajectoryReport::Log(report) => {
                report.warnings.iter().map(ToString::to_string).collect()
            }
        }
    }

    /// Omissions of a text file, in short; the remarks on a log.
    #[must_use]
    pub fn skipped(&self) -> Option<String> {
        match &self.report {
            TrajectoryReport::Text(report) => match report.skipped_total() {
                0 => None,
                count => Some(format!("{count} lines skipped")),
            },
            TrajectoryReport::Log(_) => Some(self.remarks().join("; ")).filter(|r| !r.is_empty()),
        }
    }

    /// The report on the log of an autopilot or a robot.
    #[must_use]
    pub const fn log(&self) -> Option<&LogReport> {
        match &self.report {
            TrajectoryReport::Text(_) => None,
            TrajectoryReport::Log(report) => Some(report),
        }
    }
}
