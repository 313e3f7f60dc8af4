//! Reasons why a log cannot be used.

use acerra_geo::trajectory::TrajectoryError;

use crate::format::LogFormat;

/// Reason why a log cannot be used. Bytes count from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LogError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Nothing in it.
    #[error("the file is empty")]
    Empty,
    /// No reader knows this.
    #[error(
        "not the log of an autopilot or a robot (ArduPilot .bin, PX4 .ulg, MAVLink .tlog, MCAP); it \
         begins with the bytes {found}"
    )]
    Unrecognised {
        /// How the file begins.
        found: String,
    },
    /// The file ends within a record.
    #[error(
        "byte {offset}: the file is cut off within a {what}: expected {expected} bytes, found {found} (cut \
         the file at byte {offset} to use the data before it)"
    )]
    CutOff {
        /// Offset at which the record begins.
        offset: u64,
        /// The record.
        what: String,
        /// Length (bytes).
        expected: u64,
        /// Bytes that are there.
        found: u64,
    },
    /// A record violates its format.
    #[error("byte {offset}: expected {expected}, found {found}")]
    Malformed {
        /// Offset at which the record begins.
        offset: u64,
        /// Content expected.
        expected: String,
        /// Content found.
        found: String,
    },
    /// Too much of the file belongs to no record.
    #[error(
        "byte {offset}: {bytes} of {total} bytes from here on belong to no record of a {format}: \
         another file's, or damaged"
    )]
    Damaged {
        /// Place of the first of them.
        offset: u64,
        /// Number of all of them.
        bytes: u64,
        /// Bytes of the file.
        total: u64,
        /// The kind of file.
        format: LogFormat,
    },
    /// Larger than the limit set.
    #[error("byte {offset}: more than {limit} {what}, the limit set for reading")]
    Limit {
        /// Where.
        offset: u64,
        /// Kind of the excess.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// A log of the right kind without a usable position.
    #[error("no position in this {format}{why}")]
    NoPositions {
        /// The kind of file.
        format: LogFormat,
        /// Sources that exist instead, or empty.
        why: String,
    },
    /// More than one source, and none chosen.
    #[error("several sources of {what}, choose one by {key}: {}", names.join(", "))]
    SeveralSources {
        /// Of positions, attitudes or gimbals.
        what: &'static str,
        /// The key that names one.
        key: &'static str,
        /// Content of the log.
        names: Vec<String>,
    },
    /// The requested source is absent.
    #[error(
        "{key} = \"{wanted}\": the log has no such source of {what}; {}",
        if names.is_empty() { "it has none".to_owned() } else { format!("it has {}", names.join(", ")) }
    )]
    NoSuchSource {
        /// Of positions, attitudes or gimbals.
        what: &'static str,
        /// The key that names it.
        key: &'static str,
        /// Request.
        wanted: String,
        /// Content of the log.
        names: Vec<String>,
    },
    /// A gimbal is requested of a log without one.
    #[error("no attitude of a gimbal in this {format}: expected {expected}")]
    NoGimbal {
        /// The kind of file.
        format: LogFormat,
        /// What would give it.
        expected: String,
    },
    /// Attitudes of a gimbal, none of which gives its direction at the positions.
    #[error(
        "{source_name}: none of its {samples} attitudes gives the direction of the gimbal at a position: \
         {why}"
    )]
    GimbalUnusable {
        /// The gimbal's source.
        source_name: String,
        /// Its attitudes.
        samples: usize,
        /// Missing part.
        why: &'static str,
    },
    /// Times without relation to GPS time.
    #[error(
        "{source_name}: its times count from the start of the autopilot, and no record of the log relates \
         them to GPS time ({expected})"
    )]
    NoGpsTime {
        /// The source of the positions.
        source_name: String,
        /// Records that would relate them.
        expected: &'static str,
    },
    /// Pairs of clock readings that do not agree with one another.
    #[error(
        "the autopilot's clock against GPS time: only {agreeing} of {pairs} readings agree within \
         {tolerance_s} s; the time is not known"
    )]
    ClockUnknown {
        /// Readings that agree.
        agreeing: usize,
        /// All of them.
        pairs: usize,
        /// Tolerance (s).
        tolerance_s: f64,
    },
    /// Most positions cannot be used.
    #[error("{bad} of {total} positions of {source_name} have times that do not advance")]
    TimesUnordered {
        /// Unusable positions.
        bad: usize,
        /// All positions.
        total: usize,
        /// Their source.
        source_name: String,
    },
    /// The positions lie outside the grid of the geoid.
    #[error("the grid of the geoid does not cover {latitude_deg:.4}°, {longitude_deg:.4}°")]
    OutsideGeoid {
        /// Latitude (degrees).
        latitude_deg: f64,
        /// Longitude (degrees).
        longitude_deg: f64,
    },
    /// The positions do not make a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

impl LogError {
    /// A file that no reader knows.
    pub(crate) fn unrecognised(start: &[u8]) -> Self {
        let bytes: Vec<String> = start.iter().take(8).map(|b| format!("{b:02x}")).collect();
        Self::Unrecognised {
            found: bytes.join(" "),
        }
    }
}
