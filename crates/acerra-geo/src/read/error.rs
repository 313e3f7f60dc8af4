//! Reasons why a trajectory file cannot be read.

use super::TrajectoryFormat;
use crate::trajectory::TrajectoryError;

/// Reason why a trajectory file cannot be read. Lines count from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Nothing in it.
    #[error("the file is empty")]
    Empty,
    /// No reader knows this.
    #[error(
        "not a trajectory in a known format (RTKLIB .pos, CSV with a header, NMEA GGA, \
         OptiTrack Motive export); it begins with {found}"
    )]
    UnknownFormat {
        /// Beginning of the file.
        found: String,
    },
    /// A line violates its format.
    #[error("line {line}: expected {expected}, found {found}")]
    Malformed {
        /// Line number, from 1.
        line: u64,
        /// Value expected.
        expected: String,
        /// Text found.
        found: String,
    },
    /// The last line is incomplete.
    #[error(
        "line {line}: the file is cut off here: expected {expected}, found {found} and no end of line \
         (remove that line to use the lines before it)"
    )]
    CutOff {
        /// Line number, from 1.
        line: u64,
        /// Value expected.
        expected: String,
        /// Text found.
        found: String,
    },
    /// A number is NaN or infinite.
    #[error("line {line}: {field} is {value}, expected a finite number")]
    NotFinite {
        /// Line number, from 1.
        line: u64,
        /// Quantity.
        field: String,
        /// Value found.
        value: f64,
    },
    /// A number lies where none can.
    #[error("line {line}: {field} is {value}, expected {expected}")]
    OutOfRange {
        /// Line number, from 1.
        line: u64,
        /// Quantity.
        field: String,
        /// Value found.
        value: f64,
        /// Valid values.
        expected: &'static str,
    },
    /// The header lacks a column, or names one twice.
    #[error("line {line}: {problem}")]
    Header {
        /// Line number, from 1.
        line: u64,
        /// Defect found.
        problem: String,
    },
    /// A column of heights without a datum.
    #[error(
        "line {line}: column '{column}' does not name the datum of its heights: state it, [trajectory] \
         height_datum = \"ellipsoid\", \"sea\" or \"takeoff\""
    )]
    HeightsOpen {
        /// The header's line.
        line: u64,
        /// The column's name.
        column: String,
    },
    /// A column of times without a unit, whose steps cannot be seconds of a flight.
    #[error(
        "line {line}: column '{column}' counts whole numbers in steps of {step} and names no unit: name it \
         time_s or time_ms"
    )]
    UnitOpen {
        /// The header's line.
        line: u64,
        /// The column's name.
        column: String,
        /// Median step.
        step: f64,
    },
    /// A file of the right kind without a position.
    #[error("no position in this {format} file{why}")]
    NoPositions {
        /// The kind of file.
        format: TrajectoryFormat,
        /// Data skipped instead, or empty.
        why: String,
    },
    /// Most records cannot be used.
    #[error("{bad} of {total} records are unusable, from line {line} on: {reason}")]
    MostlyBad {
        /// Unusable records.
        bad: u64,
        /// All records.
        total: u64,
        /// The first unusable one.
        line: u64,
        /// Fault of most of them.
        reason: String,
    },
    /// More than one body, and none chosen.
    #[error("several rigid bodies, choose one by name: {}", names.join(", "))]
    SeveralBodies {
        /// Names.
        names: Vec<String>,
    },
    /// The requested body is absent.
    #[error(
        "no rigid body or marker named '{wanted}'; there {}",
        if names.is_empty() { "is none".to_owned() } else { format!("are: {}", names.join(", ")) }
    )]
    NoSuchBody {
        /// Request.
        wanted: String,
        /// Content found.
        names: Vec<String>,
    },
    /// Larger than the limit set.
    #[error("line {line}: more than {limit} {what}, the limit set for reading")]
    Limit {
        /// Line number, from 1.
        line: u64,
        /// Kind of the excess.
        what: &'static str,
        /// The limit.
        limit: usize,
    },
    /// The positions do not make a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// A text for a message: quoted, control characters escaped, cut at 60 characters.
pub(super) fn quoted(text: &str) -> String {
    let mut out: String = text
        .trim()
        .chars()
        .take(60)
        .collect::<String>()
        .escape_debug()
        .collect();
    if text.trim().chars().count() > 60 {
        out.push('…');
    }
    format!("'{out}'")
}
