//! One position at one time.

use super::{Attitude, SolutionStatus};
use crate::matrix::{Matrix3, Vector3};

/// One position at one time, with data on its quality.
///
/// Build it with [`Fix::new`] and set the fields that are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Time (s) after the trajectory's origin.
    pub time_s: f64,
    /// East, north, up (m) in the trajectory's frame.
    pub position_m: Vector3,
    /// Covariance of the position (m²) in the axes of the position, if known.
    pub covariance_m2: Option<Matrix3>,
    /// Velocity (m/s) in these axes, if the source gives one.
    pub velocity_m_s: Option<Vector3>,
    /// The rotation from the body's forward, left, up to these axes, if known.
    pub attitude: Option<Attitude>,
    /// The rotation of the gimbal that carries the antenna, if there is one and its attitude is known.
    pub gimbal: Option<Attitude>,
    /// Kind of solution.
    pub status: SolutionStatus,
    /// Satellites used, when the source says.
    pub satellites: Option<u16>,
    /// Age of the base's observation (s), when the source says.
    pub age_s: Option<f64>,
    /// Ratio of the ambiguity test, when the source says.
    pub ratio: Option<f64>,
}

impl Fix {
    /// A position of [`SolutionStatus::External`] without further data.
    #[must_use]
    pub const fn new(time_s: f64, position_m: Vector3) -> Self {
        Self {
            time_s,
            position_m,
            covariance_m2: None,
            velocity_m_s: None,
            attitude: None,
            gimbal: None,
            status: SolutionStatus::External,
            satellites: None,
            age_s: None,
            ratio: None,
        }
    }

    /// Standard deviations east, north, up (m), when the covariance is known.
    #[must_use]
    pub fn standard_deviation_m(&self) -> Option<Vector3> {
        self.covariance_m2
            .map(|c| [0, 1, 2].map(|i| c[i][i].max(0.0).sqrt()))
    }
}
