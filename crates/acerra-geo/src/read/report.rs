//! Report of a reader: format, skipped data, assumptions.

use super::TrajectoryFormat;

/// Reason why a record was skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SkipReason {
    /// The record is there, its position is empty (motion capture lost the body).
    EmptyPosition,
    /// The receiver reported that it had no position.
    NoFix,
    /// Its time did not advance: repeated or out of order.
    TimeNotAdvancing,
    /// A sentence whose checksum is wrong.
    Checksum,
    /// A sentence that is not whole.
    Broken,
    /// Height above the sea only, among records with the height above the ellipsoid.
    NoGeoidSeparation,
}

impl std::fmt::Display for SkipReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(match self {
            Self::EmptyPosition => "empty position",
            Self::NoFix => "no fix",
            Self::TimeNotAdvancing => "time repeated or out of order",
            Self::Checksum => "wrong checksum",
            Self::Broken => "broken sentence",
            Self::NoGeoidSeparation => "no geoid separation",
        })
    }
}

/// Records skipped for one reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skipped {
    /// Cause.
    pub reason: SkipReason,
    /// Number.
    pub count: u64,
    /// Line of the first.
    pub first_line: u64,
}

/// Something a user should know before trusting the trajectory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ReadWarning {
    /// The file states neither columns nor time scale.
    NoHeader,
    /// Heights are above the sea, and no geoid was given to convert them to heights above the ellipsoid.
    GeoidHeights,
    /// Heights are above the place of take-off, whose height is unknown.
    HeightsAboveTakeOff,
    /// Dates and times of day without an offset from UTC were taken as UTC.
    TakenAsUtc,
    /// Dates of whole seconds: a finer clock in the same rows was used with them.
    WholeSeconds {
        /// Uncertainty of its zero (s).
        within_s: f64,
    },
    /// Baselines from a base whose position the header does not state.
    BaseUnknown,
    /// Times of day without a date.
    NoDate,
    /// Sentences without a checksum were accepted.
    NoChecksum {
        /// Number.
        count: u64,
    },
    /// Fewer rows than the header promises.
    RowsMissing {
        /// Statement of the header.
        promised: u64,
        /// Content found.
        found: u64,
    },
    /// Rotations are not quaternions and were not read.
    RotationIgnored {
        /// What they are.
        kind: String,
    },
    /// Standard deviations that are not numbers: the covariance is unknown.
    BadDeviations {
        /// Number of records.
        count: u64,
        /// Line of the first.
        first_line: u64,
    },
    /// The last digit of the positions is coarser than carrier-phase accuracy.
    Coarse {
        /// Step east, north and up (m).
        step_m: [f64; 3],
    },
    /// Motion-capture coordinates relative to another body.
    LocalSpace,
    /// A motion-capture file that names no rigid body: one was found by its columns' axes.
    UnnamedBody {
        /// First and last column, from 1.
        columns: [usize; 2],
    },
}

impl std::fmt::Display for ReadWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoHeader => f.write_str("no header: times taken as GPST"),
            Self::GeoidHeights => f.write_str(
                "heights are above the sea and were used as heights above the ellipsoid: origin, terrain and maps \
                 are off by the geoid's height, tens of metres ([image] geoid names a grid of it)",
            ),
            Self::HeightsAboveTakeOff => f.write_str(
                "heights are above the place of take-off: the flight's level is off by that place's height",
            ),
            Self::TakenAsUtc => {
                f.write_str("dates and times that name no time zone were taken as UTC")
            }
            Self::WholeSeconds { within_s } => write!(
                f,
                "dates are of whole seconds: instants are by the finer clock in the same rows, ± \
                 {within_s:.2} s"
            ),
            Self::BaseUnknown => f.write_str(
                "baselines from a base of unknown position: the trajectory has no place on Earth",
            ),
            Self::NoDate => f.write_str("times of day without a date (no RMC or ZDA sentence)"),
            Self::NoChecksum { count } => write!(f, "{count} sentences without a checksum"),
            Self::RowsMissing { promised, found } => {
                write!(f, "the header promises {promised} rows, {found} are there")
            }
            Self::RotationIgnored { kind } => {
                write!(
                    f,
                    "rotation type '{kind}' is not read, only quaternions are"
                )
            }
            Self::BadDeviations { count, first_line } => write!(
                f,
                "{count} records with unusable standard deviations, first on line {first_line}"
            ),
            Self::Coarse {
                step_m: [east, north, up],
            } => write!(
                f,
                "positions are written in steps of {east:.3} m east, {north:.3} m north, {up:.3} m up (more \
                 decimals in the receiver's or logger's output keep its accuracy)"
            ),
            Self::LocalSpace => f.write_str("coordinate space is local, not global"),
            Self::UnnamedBody {
                columns: [first, last],
            } => write!(
                f,
                "no rigid body is named: columns {first} to {last} were taken as one (rotation \
                 X Y Z W, position X Y Z)"
            ),
        }
    }
}

/// Report of a reader: format, skipped data, assumptions.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReadReport {
    /// Kind of file.
    pub format: TrajectoryFormat,
    /// Lines read.
    pub lines: u64,
    /// Records with or without a usable position.
    pub records: u64,
    /// Records skipped.
    pub skipped: Vec<Skipped>,
    /// The file ran backwards in time (a backward pass) and was turned round.
    pub reversed: bool,
    /// The file gives coordinates in a local frame whose axes nothing confirms, even where an origin places
    /// the frame on the Earth.
    pub is_local: bool,
    /// Step of the last digit of the positions east, north and up (m), where the text shows it. Rounding adds
    /// step/√12 to their deviations, as it has been added where the file states any.
    pub resolution_m: Option<[f64; 3]>,
    /// Remarks that a user needs before trusting it.
    pub warnings: Vec<ReadWarning>,
    /// Header entries and choices to be shown: (name, value).
    pub about: Vec<(String, String)>,
    /// Columns of a table that were not used.
    pub unused_columns: Vec<String>,
}

impl ReadReport {
    pub(super) fn new(format: TrajectoryFormat) -> Self {
        Self {
            format,
            lines: 0,
            records: 0,
            skipped: Vec::new(),
            reversed: false,
            is_local: false,
            resolution_m: None,
            warnings: Vec::new(),
            about: Vec::new(),
            unused_columns: Vec::new(),
        }
    }

    pub(super) fn skip(&mut self, reason: SkipReason, line: u64) {
        match self.skipped.iter_mut().find(|s| s.reason == reason) {
            Some(s) => {
                s.count += 1;
                s.first_line = s.first_line.min(line);
            }
            None => self.skipped.push(Skipped {
                reason,
                count: 1,
                first_line: line,
            }),
        }
    }

    pub(super) fn about(&mut self, name: &str, value: impl Into<String>) {
        self.about.push((name.to_owned(), value.into()));
    }

    /// Records skipped for a reason.
    #[must_use]
    pub fn skipped_for(&self, reason: SkipReason) -> u64 {
        self.skipped
            .iter()
            .filter(|s| s.reason == reason)
            .map(|s| s.count)
            .sum()
    }

    /// Records skipped for any reason.
    #[must_use]
    pub fn skipped_total(&self) -> u64 {
        self.skipped.iter().map(|s| s.count).sum()
    }
}

/// `9824 records, 19 skipped: 19 empty position (first on line 5004)`.
impl std::fmt::Display for ReadReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} records", self.records)?;
        if !self.skipped.is_empty() {
            write!(f, ", {} skipped: ", self.skipped_total())?;
            for (i, s) in self.skipped.iter().enumerate() {
                let comma = if i > 0 { ", " } else { "" };
                write!(
                    f,
                    "{comma}{} {} (first on line {})",
                    s.count, s.reason, s.first_line
                )?;
            }
        }
        if self.reversed {
            write!(f, ", turned round in time")?;
        }
        Ok(())
    }
}
