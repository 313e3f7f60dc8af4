//! Attitudes of an autopilot's log on positions from another source.

use std::io::Read;

use acerra_autopilot::{
    GimbalChoice, LogAttitudes, LogError, LogFormat, LogOptions, LogReport, read_attitudes,
};
use acerra_geo::geodesy::EnuFrame;
use acerra_geo::matrix::{multiply, transpose};
use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::{Fix, Trajectory, TrajectoryError};

use crate::position::clock_shift::{ClockShift, clock_shift};

/// Largest deviation of a shift that is reported (s).
const MOST_SIGMA_S: f64 = 1.0;

/// Reason for which the attitudes of a log cannot be combined with positions.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AttitudeFileError {
    /// A log that cannot be used.
    #[error(transparent)]
    Log(#[from] LogError),
    /// A log without attitudes.
    #[error("[trajectory] attitude_file: expected attitudes, found none in this {format}")]
    NoAttitude {
        /// The kind of log.
        format: LogFormat,
    },
    /// The log's clock is not GPS time.
    #[error(
        "[trajectory] attitude_file: expected times that a GNSS receiver ties to GPS time, found a clock of the \
         log's own"
    )]
    OwnClock,
    /// The positions' times are not on GPS time.
    #[error(
        "[trajectory] attitude_file: expected positions on GPS time, by which attitudes find them, found times that \
         name no day"
    )]
    NotOnGpsTime,
    /// The positions are in axes of unknown direction.
    #[error(
        "[trajectory] attitude_file: expected positions east, north, up of a place on the Earth, as attitudes count \
         from north and down, found axes of the file's own"
    )]
    LocalAxes,
    /// The log's attitudes count from axes with no relation to north.
    #[error(
        "[trajectory] attitude_file: expected attitudes from north and down, found a robot's own axes (positions of \
         {source_name})"
    )]
    RobotAxes {
        /// The source of the log's positions.
        source_name: String,
    },
    /// No position has an attitude near enough in time.
    #[error(
        "[trajectory] attitude_file: expected attitudes at the times of the positions, {} to {}, found them from {} \
         to {}",
        positions[0], positions[1], log[0], log[1]
    )]
    NoOverlap {
        /// First and last time of the positions.
        positions: [GpsTime; 2],
        /// Times of the log's own positions.
        log: [GpsTime; 2],
    },
    /// The positions do not make a trajectory.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
}

/// Positions with the attitudes of a log.
#[derive(Clone, Debug)]
pub struct WithAttitudes {
    /// The positions.
    pub trajectory: Trajectory,
    /// Remarks on the log.
    pub report: LogReport,
    /// Displacement of the log's positions from the positions used; `None` where the displacement cannot be
    /// determined.
    pub shift: Option<ClockShift>,
    /// Positions without an attitude of the vehicle.
    pub without_attitude: usize,
    /// Positions without an attitude of the gimbal, where the campaign uses one.
    pub without_gimbal: usize,
}

/// Replaces the attitudes of `trajectory` by the attitudes of the log `reader`, interpolated in GPS time at
/// the positions.
///
/// # Errors
/// A log that cannot be used or holds no attitude, positions without GPS time or place, and logs of other times than
/// the positions; the caller adds the path.
pub fn with_log_attitudes(
    trajectory: &Trajectory,
    reader: impl Read,
    options: &LogOptions,
) -> Result<WithAttitudes, AttitudeFileError> {
    let origin = trajectory.time_origin().gps_time();
    let origin = origin.ok_or(AttitudeFileError::NotOnGpsTime)?;
    let frame = *trajectory
        .frame()
        .enu()
        .ok_or(AttitudeFileError::LocalAxes)?;
    let options = options.clone().with_origin(*frame.origin());
    let (attitudes, log, report) = read_attitudes(reader, &options)?;
    let log_origin = log.time_origin().gps_time();
    let log_origin = log_origin.ok_or(AttitudeFileError::OwnClock)?;
    if report.attitude_source.is_none() {
        return Err(AttitudeFileError::NoAttitude {
            format: report.format,
        });
    }
    if report.is_local() {
        return Err(AttitudeFileError::RobotAxes {
            source_name: report.source.name,
        });
    }
    let turn = |fix: &Fix| turned(fix, origin + fix.time_s, &attitudes, &frame);
    let fixes: Vec<Fix> = trajectory.fixes().iter().map(turn).collect();
    let without = |is_there: fn(&Fix) -> bool| fixes.iter().filter(|fix| !is_there(fix)).count();
    let without_attitude = without(|fix| fix.attitude.is_some());
    let without_gimbal = without(|fix| fix.gimbal.is_some());
    let asks_for_gimbal = options.gimbal != GimbalChoice::None;
    if without_attitude == fixes.len() || asks_for_gimbal && without_gimbal == fixes.len() {
        return Err(AttitudeFileError::NoOverlap {
            positions: [trajectory.start_s(), trajectory.end_s()].map(|s| origin + s),
            log: [log.start_s(), log.end_s()].map(|s| log_origin + s),
        });
    }
    Ok(WithAttitudes {
        shift: clock_shift(&log, trajectory),
        trajectory: Trajectory::new(*trajectory.frame(), trajectory.time_origin(), fixes)?,
        report,
        without_attitude,
        without_gimbal: if asks_for_gimbal { without_gimbal } else { 0 },
    })
}

impl WithAttitudes {
    /// Remarks that a user needs before trusting the attitudes, as sentences.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let total = self.trajectory.fixes().len();
        let gaps = |whose: &str, count: usize| {
            (count > 0).then(|| {
                format!(
                    "{count} of {total} positions have no attitude{whose} within half a second: there the last one \
                     is held"
                )
            })
        };
        let unchecked = self.well_known_shift().is_none().then(|| {
            "the log's own positions cannot show whether its clock agrees with the positions': they move \
             too little, or have too few times in common"
                .to_owned()
        });
        let own = self.report.attitude_warnings();
        let own = own.iter().map(ToString::to_string);
        own.chain(gaps("", self.without_attitude))
            .chain(gaps(" of the gimbal", self.without_gimbal))
            .chain(unchecked)
            .collect()
    }

    /// Comparison of the log's clock and positions with the positions used; `None` where the log's positions
    /// move too little.
    #[must_use]
    pub fn seen(&self) -> Option<AttitudesSeen> {
        self.shift.map(|shift| AttitudesSeen {
            clock: self.well_known_shift().map(|s| [s.shift_s, s.sigma_s]),
            apart_m: shift.distance_m,
        })
    }

    fn well_known_shift(&self) -> Option<ClockShift> {
        self.shift.filter(|shift| shift.sigma_s <= MOST_SIGMA_S)
    }
}

/// Comparison of the clock and positions of a log of attitudes with the positions that use the attitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttitudesSeen {
    /// The log's stamp of an event minus the positions' stamp, and the standard deviation of this difference
    /// (s), where the motion determines the difference.
    pub clock: Option<[f64; 2]>,
    /// Mean horizontal distance of the log's positions from the positions used (m).
    pub apart_m: f64,
}

/// A position with the attitudes at `time`, which come in the axes of the place itself.
fn turned(fix: &Fix, time: GpsTime, attitudes: &LogAttitudes, frame: &EnuFrame) -> Fix {
    let here = EnuFrame::new(frame.geodetic_from_enu(fix.position_m));
    let frame_from_here = multiply(
        frame.rotation_enu_from_ecef(),
        &transpose(here.rotation_enu_from_ecef()),
    );
    Fix {
        attitude: attitudes
            .vehicle_at(time)
            .map(|attitude| attitude.turned_by(&frame_from_here)),
        gimbal: attitudes
            .gimbal_at(time)
            .map(|attitude| attitude.turned_by(&frame_from_here)),
        ..*fix
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use acerra_geo::geodesy::Geodetic;
    use acerra_geo::trajectory::{Frame, TimeOrigin};

    /// A robot's log: a receiver's positions as `/fix`, odometry as `/odom`.
    const LOG: &[u8] = include_bytes!("../../../../fuzz/seeds/log_ros/records.mcap");

    fn refused(source: &str) -> AttitudeFileError {
        let frame = Frame::Enu(EnuFrame::new(Geodetic::from_degrees(41.0, 14.0, 80.0)));
        let origin = TimeOrigin::Gps(GpsTime::from_week_tow(2390, 0.0));
        let fixes = [0.0, 1.0].map(|time_s| Fix::new(time_s, [time_s, 0.0, 8.0]));
        let positions = Trajectory::new(frame, origin, fixes.to_vec()).unwrap();
        let options = LogOptions::default().with_source(source);
        with_log_attitudes(&positions, LOG, &options).unwrap_err()
    }

    #[test]
    fn attitudes_that_count_from_a_robots_own_axes_are_refused() {
        let error = refused("/odom");
        assert!(
            matches!(&error, AttitudeFileError::RobotAxes { source_name } if source_name == "/odom"),
            "{error}"
        );
        // Attitudes to be used with the receiver's positions count from north: only their times are replaced.
        let error = refused("/fix");
        assert!(
            matches!(error, AttitudeFileError::NoOverlap { .. }),
            "{error}"
        );
    }
}
