//! The one trajectory type that every reader produces and every later stage takes.

mod attitude;
mod fix;
mod status;

pub use attitude::Attitude;
pub use fix::Fix;
pub use status::{SolutionStatus, StatusCounts};

use crate::geodesy::{EnuFrame, Geodetic};
use crate::matrix::{
    Vector3, distance, is_finite, multiply, multiply_vector, rotate_covariance, transpose,
};
use crate::time::GpsTime;

/// Meaning of second zero of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum TimeOrigin {
    /// An instant of GPS time.
    Gps(GpsTime),
    /// Midnight UTC of a day that the file does not name (NMEA without a date).
    UtcMidnight,
    /// A clock without relation to GPS time: a motion-capture system's, or a computation's.
    Relative,
    /// No clock: a table gives the numbers of a radar's traces in place of times.
    TraceNumbers,
}

impl TimeOrigin {
    /// The instant of second zero, when it is known.
    #[must_use]
    pub const fn gps_time(self) -> Option<GpsTime> {
        match self {
            Self::Gps(t) => Some(t),
            _ => None,
        }
    }
}

/// Axes of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Frame {
    /// East, north, up about a known place on the Earth.
    Enu(EnuFrame),
    /// Right-handed x, y and z up about an unknown place (motion capture, plain tables).
    Local,
}

impl Frame {
    /// The frame on the Earth, when it is known.
    #[must_use]
    pub const fn enu(&self) -> Option<&EnuFrame> {
        match self {
            Self::Enu(frame) => Some(frame),
            Self::Local => None,
        }
    }
}

/// Reason why fixes do not make a trajectory.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// Not a single position.
    #[error("the trajectory holds no position")]
    Empty,
    /// A time or coordinate is NaN or infinite.
    #[error("fix {index}: time or position is not a finite number")]
    NotFinite {
        /// Number of the fix, from 0.
        index: usize,
    },
    /// Time does not advance.
    #[error("fix {index}: time {time_s} s does not come after the one before it, {previous_s} s")]
    TimeNotIncreasing {
        /// Number of the fix, from 0.
        index: usize,
        /// Time (s).
        time_s: f64,
        /// The time before it (s).
        previous_s: f64,
    },
    /// Two frames on the Earth are needed, one is not.
    #[error("the trajectory is in a local frame of unknown place and cannot be moved to another")]
    NoPlace,
}

/// Time-tagged positions in one local frame, strictly increasing in time, all finite.
///
/// ```
/// use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
///
/// let fixes = (0..5).map(|i| Fix::new(f64::from(i), [2.0 * f64::from(i), 0.0, 10.0])).collect();
/// let flight = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes)?;
/// assert_eq!(flight.path_length_m(), 8.0);
/// assert_eq!(flight.sample_interval_s(), Some(1.0));
/// # Ok::<(), acerra_geo::trajectory::TrajectoryError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    frame: Frame,
    time_origin: TimeOrigin,
    fixes: Vec<Fix>,
}

impl Trajectory {
    /// A trajectory from fixes in order of time.
    ///
    /// # Errors
    /// [`TrajectoryError`] when there is no fix, one is not finite, or time does not strictly
    /// increase.
    pub fn new(
        frame: Frame,
        time_origin: TimeOrigin,
        fixes: Vec<Fix>,
    ) -> Result<Self, TrajectoryError> {
        if fixes.is_empty() {
            return Err(TrajectoryError::Empty);
        }
        for (index, fix) in fixes.iter().enumerate() {
            if !fix.time_s.is_finite() || !is_finite(fix.position_m) {
                return Err(TrajectoryError::NotFinite { index });
            }
            if index > 0 && fix.time_s <= fixes[index - 1].time_s {
                return Err(TrajectoryError::TimeNotIncreasing {
                    index,
                    time_s: fix.time_s,
                    previous_s: fixes[index - 1].time_s,
                });
            }
        }
        Ok(Self {
            frame,
            time_origin,
            fixes,
        })
    }

    /// What the axes are.
    #[must_use]
    pub const fn frame(&self) -> &Frame {
        &self.frame
    }

    /// What second zero is.
    #[must_use]
    pub const fn time_origin(&self) -> TimeOrigin {
        self.time_origin
    }

    /// The fixes, in order of time; never empty.
    #[must_use]
    pub fn fixes(&self) -> &[Fix] {
        &self.fixes
    }

    /// The fixes by value.
    #[must_use]
    pub fn into_fixes(self) -> Vec<Fix> {
        self.fixes
    }

    /// Time of the first fix (s after the origin).
    #[must_use]
    pub fn start_s(&self) -> f64 {
        self.fixes[0].time_s
    }

    /// Time of the last fix (s after the origin).
    #[must_use]
    pub fn end_s(&self) -> f64 {
        self.fixes[self.fixes.len() - 1].time_s
    }

    /// Median time between neighbouring fixes (s); none for a single fix.
    #[must_use]
    pub fn sample_interval_s(&self) -> Option<f64> {
        let mut steps: Vec<f64> = self
            .fixes
            .windows(2)
            .map(|w| w[1].time_s - w[0].time_s)
            .collect();
        let middle = steps.len().checked_sub(1)? / 2;
        Some(*steps.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Pairs of neighbouring fixes further apart than `longest_s`: (time before, time after), s.
    pub fn gaps(&self, longest_s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.fixes.windows(2).filter_map(move |w| {
            (w[1].time_s - w[0].time_s > longest_s).then_some((w[0].time_s, w[1].time_s))
        })
    }

    /// Length of the line through all fixes (m).
    #[must_use]
    pub fn path_length_m(&self) -> f64 {
        self.fixes
            .windows(2)
            .map(|w| distance(w[0].position_m, w[1].position_m))
            .sum()
    }

    /// Smallest and largest coordinate on each axis (m).
    #[must_use]
    pub fn bounds_m(&self) -> (Vector3, Vector3) {
        let first = self.fixes[0].position_m;
        self.fixes
            .iter()
            .fold((first, first), |(mut low, mut high), fix| {
                for axis in 0..3 {
                    low[axis] = low[axis].min(fix.position_m[axis]);
                    high[axis] = high[axis].max(fix.position_m[axis]);
                }
                (low, high)
            })
    }

    /// Number of fixes of each status.
    #[must_use]
    pub fn status_counts(&self) -> StatusCounts {
        self.fixes.iter().map(|fix| fix.status).collect()
    }

    /// The instant of a trajectory time, when the origin is an instant.
    #[must_use]
    pub fn gps_time_at(&self, time_s: f64) -> Option<GpsTime> {
        self.time_origin.gps_time().map(|origin| origin + time_s)
    }

    /// Trajectory time (s after the origin) of an instant, when the origin is an instant.
    #[must_use]
    pub fn time_s_at(&self, time: GpsTime) -> Option<f64> {
        self.time_origin.gps_time().map(|origin| time - origin)
    }

    /// Latitude, longitude and height of each fix, when the frame is on the Earth.
    #[must_use]
    pub fn geodetic(&self) -> Option<Vec<Geodetic>> {
        let frame = self.frame.enu()?;
        Some(
            self.fixes
                .iter()
                .map(|fix| frame.geodetic_from_enu(fix.position_m))
                .collect(),
        )
    }

    /// The trajectory in another frame on the Earth: positions, velocities, covariances and attitudes
    /// rotated.
    ///
    /// # Errors
    /// [`TrajectoryError::NoPlace`] when this trajectory's frame has no place on the Earth.
    pub fn in_frame(&self, target: EnuFrame) -> Result<Self, TrajectoryError> {
        let source = self.frame.enu().ok_or(TrajectoryError::NoPlace)?;
        let target_from_source = multiply(
            target.rotation_enu_from_ecef(),
            &transpose(source.rotation_enu_from_ecef()),
        );
        let fixes = self
            .fixes
            .iter()
            .map(|fix| Fix {
                position_m: target.enu_from_ecef(source.ecef_from_enu(fix.position_m)),
                velocity_m_s: fix
                    .velocity_m_s
                    .map(|v| multiply_vector(&target_from_source, v)),
                covariance_m2: fix
                    .covariance_m2
                    .map(|c| rotate_covariance(&target_from_source, &c)),
                attitude: fix.attitude.map(|a| a.turned_by(&target_from_source)),
                gimbal: fix.gimbal.map(|a| a.turned_by(&target_from_source)),
                ..*fix
            })
            .collect();
        Ok(Self {
            frame: Frame::Enu(target),
            time_origin: self.time_origin,
            fixes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line() -> Vec<Fix> {
        (0..4)
            .map(|i| Fix::new(f64::from(i) * 0.5, [f64::from(i), 1.0, 2.0]))
            .collect()
    }

    #[test]
    fn what_is_not_a_trajectory_is_refused() {
        let make = |fixes| Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes);
        assert_eq!(make(vec![]), Err(TrajectoryError::Empty));
        let mut fixes = line();
        fixes[2].time_s = 0.5;
        assert!(matches!(
            make(fixes),
            Err(TrajectoryError::TimeNotIncreasing { index: 2, .. })
        ));
        let mut fixes = line();
        fixes[3].position_m[1] = f64::NAN;
        assert_eq!(make(fixes), Err(TrajectoryError::NotFinite { index: 3 }));
    }

    #[test]
    fn moved_to_another_place_it_is_the_same_on_the_earth() {
        let here = EnuFrame::new(Geodetic::from_degrees(40.0, 14.0, 50.0));
        let there = EnuFrame::new(Geodetic::from_degrees(40.01, 14.02, 80.0));
        let mut fixes = line();
        fixes[0].attitude = Some(Attitude::IDENTITY);
        fixes[0].gimbal = Some(Attitude::from_heading(0.0));
        fixes[0].velocity_m_s = Some([1.0, 0.0, 0.0]);
        let track = Trajectory::new(Frame::Enu(here), TimeOrigin::Relative, fixes).expect("track");
        let moved = track.in_frame(there).expect("on the Earth");
        let (a, b) = (
            track.geodetic().expect("place"),
            moved.geodetic().expect("place"),
        );
        for (a, b) in a.iter().zip(&b) {
            assert!((a.latitude_rad - b.latitude_rad).abs() < 1e-14);
            assert!((a.height_m - b.height_m).abs() < 1e-8);
        }
        // Forward was east; it still points along the velocity.
        let fix = moved.fixes()[0];
        let forward = fix.attitude.expect("attitude").rotate([1.0, 0.0, 0.0]);
        assert!(distance(forward, fix.velocity_m_s.expect("velocity")) < 1e-12);
        // A gimbal that pointed a quarter turn to the left of forward still does.
        let gimbal = fix.gimbal.expect("gimbal");
        assert!(
            (gimbal.angle_to(&fix.attitude.expect("attitude")) - 0.5 * std::f64::consts::PI).abs()
                < 1e-7
        );
        assert_eq!(
            track.in_frame(here).expect("same").status_counts().fixed(),
            4
        );
    }

    #[test]
    fn gaps_and_interval() {
        let mut fixes = line();
        fixes.push(Fix::new(9.5, [9.0, 9.0, 9.0]));
        let track = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes).expect("track");
        assert_eq!(track.sample_interval_s(), Some(0.5));
        assert_eq!(track.gaps(0.75).collect::<Vec<_>>(), [(1.5, 9.5)]);
        assert_eq!(track.bounds_m(), ([0.0, 1.0, 2.0], [9.0, 9.0, 9.0]));
    }
}
