//! Report of a reader: format, choices, skipped data, assumptions.

use acerra_geo::trajectory::StatusCounts;

use crate::format::LogFormat;
use crate::sample::{Damage, HeightDatum, PairKind, SourceKind};

/// A source of positions in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceSummary {
    /// Name.
    pub name: String,
    /// Source of the positions.
    pub kind: SourceKind,
    /// Positions.
    pub positions: usize,
}

/// A source of attitudes in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct AttitudeSummary {
    /// Name.
    pub name: String,
    /// Attitudes.
    pub attitudes: usize,
}

/// How the autopilot's clock lies to GPS time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockSummary {
    /// Readings of both that the line goes through.
    pub readings: usize,
    /// Readings of another time, left out.
    pub left_out: usize,
    /// Rate of GPS time against the autopilot's clock, less one, in parts per million.
    pub rate_ppm: f64,
    /// Nine tenths of the readings lie within this (s) of the line.
    pub spread_s: f64,
    /// Origin of the readings.
    pub kind: PairKind,
}

/// Report of a reader: format, choices, skipped data, assumptions.
#[derive(Debug, Clone, PartialEq)]
pub struct LogReport {
    /// The kind of log.
    pub format: LogFormat,
    /// All sources of positions.
    pub sources: Vec<SourceSummary>,
    /// All sources of attitudes.
    pub attitude_sources: Vec<AttitudeSummary>,
    /// All sources of a gimbal's attitudes; in MCAP only unambiguous ones.
    pub gimbal_sources: Vec<AttitudeSummary>,
    /// The source whose positions the trajectory has.
    pub source: SourceSummary,
    /// The source of its attitudes, if any.
    pub attitude_source: Option<String>,
    /// Positions with an attitude.
    pub attitudes: usize,
    /// The source of the gimbal's attitudes, where requested.
    pub gimbal_source: Option<String>,
    /// Positions with an attitude of the gimbal.
    pub gimbal_attitudes: usize,
    /// Datum of the log's heights; none for positions in the robot's local axes.
    pub height_datum: Option<HeightDatum>,
    /// The autopilot's clock on GPS time, where it was needed.
    pub clock: Option<ClockSummary>,
    /// Positions by the kind of their solution.
    pub statuses: StatusCounts,
    /// Remarks that a user needs before trusting the trajectory.
    pub warnings: Vec<LogWarning>,
}

impl LogReport {
    /// Whether the positions are in the robot's local axes.
    #[must_use]
    pub const fn is_local(&self) -> bool {
        self.height_datum.is_none()
    }

    /// The sources in one line: `positions of GPS[0], attitude of ATT`.
    #[must_use]
    pub fn sources_used(&self) -> String {
        format!(
            "positions of {}, {}",
            self.source.name,
            self.attitudes_used()
        )
    }

    /// Remarks that a user needs before trusting the attitudes at times of other positions.
    #[must_use]
    pub fn attitude_warnings(&self) -> Vec<LogWarning> {
        let own = self.warnings.iter().filter(|w| w.concerns_attitudes());
        let of_attitudes = |warning: &LogWarning| match warning {
            LogWarning::UnknownLatency { spread_s, .. } => LogWarning::UnknownLatency {
                what: "attitudes",
                spread_s: *spread_s,
            },
            other => other.clone(),
        };
        own.map(of_attitudes).collect()
    }

    /// Sources of the attitudes alone: `attitude of ATT, gimbal of MNT[0]`.
    #[must_use]
    pub fn attitudes_used(&self) -> String {
        let attitude = match &self.attitude_source {
            Some(attitude) => format!("attitude of {attitude}"),
            None => "no attitude".to_owned(),
        };
        let gimbal = self.gimbal_source.as_ref();
        let gimbal = gimbal.map_or_else(String::new, |gimbal| format!(", gimbal of {gimbal}"));
        format!("{attitude}{gimbal}")
    }
}

/// Something a user should know before trusting the trajectory.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LogWarning {
    /// The first of several sources was taken.
    FirstOfSeveral {
        /// Of positions or attitudes.
        what: &'static str,
        /// The key that names one.
        key: &'static str,
        /// The available sources.
        names: Vec<String>,
    },
    /// Heights count from the sea and stay so.
    SeaLevelHeights {
        /// The source of the positions.
        source: String,
    },
    /// Heights counted from the sea and were raised by the grid of the geoid.
    RaisedByGeoid {
        /// Height of the geoid at the first position (m).
        geoid_m: f64,
    },
    /// Positions whose height counts from something else than the others'.
    OtherDatumLeftOut {
        /// Count.
        count: usize,
    },
    /// Records of a receiver that had no position.
    WithoutPosition {
        /// The source.
        source: String,
        /// Count.
        count: usize,
    },
    /// Positions whose time does not go with the log's other readings of the clocks.
    OtherTimeLeftOut {
        /// Count.
        count: usize,
    },
    /// Positions whose time does not advance.
    TimesRepeated {
        /// Count.
        count: usize,
    },
    /// Positions that are no carrier-phase solutions with fixed ambiguities.
    NotFixed {
        /// Positions.
        total: usize,
        /// Number of each status.
        statuses: StatusCounts,
    },
    /// Times of the autopilot's clock, put on GPS time by messages of unknown latency.
    UnknownLatency {
        /// What has such times.
        what: &'static str,
        /// Nine tenths of the readings lie within this (s) of the line of least delay.
        spread_s: f64,
    },
    /// Positions of a receiver that are stamped when they arrived.
    StampedOnArrival {
        /// The source.
        source: String,
    },
    /// Clock readings of another time.
    ClockReadingsLeftOut {
        /// Count.
        count: usize,
        /// Total.
        total: usize,
    },
    /// Times of a clock of the log without relation to GPS time.
    OwnClock,
    /// No attitude in the log.
    NoAttitude,
    /// Positions without an attitude near enough in time.
    AttitudeGaps {
        /// Count.
        count: usize,
        /// Total.
        total: usize,
    },
    /// Positions without an attitude of the gimbal near enough in time.
    GimbalGaps {
        /// Count.
        count: usize,
        /// Total.
        total: usize,
    },
    /// Records of a gimbal without an attitude.
    GimbalWithoutAttitude {
        /// The source.
        source: String,
        /// Count.
        count: usize,
    },
    /// Attitudes of a gimbal that count from the vehicle's nose, whose heading is unknown at their time.
    GimbalWithoutHeading {
        /// The source.
        source: String,
        /// Count.
        count: usize,
        /// Total.
        total: usize,
    },
    /// Attitudes at which the gimbal reports a failure of its sensing.
    GimbalFailing {
        /// The source.
        source: String,
        /// Count.
        count: usize,
        /// Total.
        total: usize,
    },
    /// Attitudes of a gimbal that the autopilot gives, measured or not.
    GimbalByAutopilot {
        /// The source.
        source: String,
    },
    /// Attitudes of a gimbal that are the autopilot's commands, not measurements.
    GimbalCommanded {
        /// The source.
        source: String,
    },
    /// Bytes that belong to no record.
    Damaged(Damage),
    /// Remark of the format's reader.
    Remark(String),
}

impl LogWarning {
    /// Whether the remark concerns the attitudes at their own times, and not the positions alone.
    const fn concerns_attitudes(&self) -> bool {
        match self {
            Self::FirstOfSeveral { .. }
            | Self::UnknownLatency { .. }
            | Self::ClockReadingsLeftOut { .. }
            | Self::GimbalWithoutAttitude { .. }
            | Self::GimbalWithoutHeading { .. }
            | Self::GimbalFailing { .. }
            | Self::GimbalByAutopilot { .. }
            | Self::GimbalCommanded { .. }
            | Self::Damaged(_)
            | Self::Remark(_) => true,
            Self::SeaLevelHeights { .. }
            | Self::RaisedByGeoid { .. }
            | Self::OtherDatumLeftOut { .. }
            | Self::WithoutPosition { .. }
            | Self::OtherTimeLeftOut { .. }
            | Self::TimesRepeated { .. }
            | Self::NotFixed { .. }
            | Self::StampedOnArrival { .. }
            | Self::OwnClock
            | Self::NoAttitude
            | Self::AttitudeGaps { .. }
            | Self::GimbalGaps { .. } => false,
        }
    }
}

impl std::fmt::Display for LogWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::FirstOfSeveral { what, key, names } => write!(
                f,
                "several sources of {what}, of which the first was taken; {key} names one: {}",
                names.join(", ")
            ),
            Self::SeaLevelHeights { source } => write!(
                f,
                "heights of {source} are above the sea and were used as heights above the ellipsoid: \
                 origin, terrain and maps are off by the geoid's height, tens of metres ([image] geoid \
                 names a grid of it)"
            ),
            Self::RaisedByGeoid { geoid_m } => write!(
                f,
                "heights above the sea were raised by the geoid's, {geoid_m:.2} m at the first position"
            ),
            Self::OtherDatumLeftOut { count } => write!(
                f,
                "{count} positions with a height above the sea alone were left out in favour of those with \
                 one above the ellipsoid"
            ),
            Self::WithoutPosition { source, count } => {
                write!(f, "{count} records of {source} without a fix were left out")
            }
            Self::OtherTimeLeftOut { count } => write!(
                f,
                "{count} positions have another time than the others (leap seconds or a date that the \
                 receiver did not have yet) and were left out"
            ),
            Self::TimesRepeated { count } => write!(
                f,
                "{count} positions with a time repeated or out of order were left out"
            ),
            Self::NotFixed { total, statuses } => write!(
                f,
                "of {total} positions only {} are fixed by carrier phase ({statuses}): the others are good \
                 to decimetres or metres, while focusing needs millimetres to centimetres",
                statuses.fixed()
            ),
            Self::UnknownLatency { what, spread_s } => write!(
                f,
                "times of the {what} are the autopilot's, converted to GPS time by the least delayed \
                 messages of the receiver (nine tenths within {:.0} ms): the receiver's own latency, \
                 usually 0.05 to 0.25 s, is not in the log and remains in the times",
                1e3 * spread_s
            ),
            Self::StampedOnArrival { source } => write!(
                f,
                "positions of {source} are stamped when they arrived at the autopilot, later than they were \
                 measured by the receiver's latency, usually 0.05 to 0.25 s"
            ),
            Self::ClockReadingsLeftOut { count, total } => write!(
                f,
                "{count} of {total} readings of GPS time differ from the others (leap seconds or a date \
                 that the receiver did not have yet) and were left out"
            ),
            Self::OwnClock => f.write_str(
                "times are by a clock of the log without relation to GPS time: state time_offset_s or let \
                 it be found",
            ),
            Self::NoAttitude => f.write_str(
                "no attitude in the log: a lever arm is turned by the course of the track",
            ),
            Self::AttitudeGaps { count, total } => write!(
                f,
                "{count} of {total} positions have no attitude within half a second: there the last one is held"
            ),
            Self::GimbalGaps { count, total } => write!(
                f,
                "{count} of {total} positions have no attitude of the gimbal within half a second: there its last \
                 one is held"
            ),
            Self::GimbalWithoutAttitude { source, count } => write!(
                f,
                "{count} records of {source} without a usable attitude were left out"
            ),
            Self::GimbalWithoutHeading {
                source,
                count,
                total,
            } => write!(
                f,
                "{count} of {total} attitudes of {source} count from the vehicle's nose, and no attitude of \
                 the vehicle gives its heading then: they were left out"
            ),
            Self::GimbalFailing {
                source,
                count,
                total,
            } => write!(
                f,
                "at {count} of {total} attitudes {source} reports a failure of its encoders, software or \
                 communication, or that it calibrates: they are used nevertheless"
            ),
            Self::GimbalByAutopilot { source } => write!(
                f,
                "attitudes of {source} are the autopilot's report on the gimbal: where servos move it they \
                 are commands, not measurements, and ArduPilot may count the angles from the vehicle \
                 instead of the horizon (parameter MNT1_TYPE = 1; antenna_axis = \"vertical\" where it \
                 keeps level)"
            ),
            Self::GimbalCommanded { source } => write!(
                f,
                "attitudes of {source} are the autopilot's commands to the gimbal's servos, not \
                 measurements"
            ),
            Self::Damaged(damage) => write!(
                f,
                "{} bytes in {} places belong to no record and were passed over, the first at byte {}",
                damage.bytes, damage.places, damage.first_offset
            ),
            Self::Remark(text) => f.write_str(text),
        }
    }
}
