//! A moving base: the position of its antenna from its codes.
//!
//! A receiver's place enters a baseline only through the directions to the satellites: errors of metres turn
//! the directions by less than a microradian. The base's motion between its epoch and the rover's, which must
//! be accurate to a millimetre, comes from the base's Doppler shifts.

use crate::measurements::measurement::Epoch;
use crate::single::{SingleContext, SinglePoint};
use acerra_geo::time::GpsTime;

/// Largest time between the epochs of two receivers on one vehicle (s), as in RTKLIB: one second, and the
/// tolerance of the tags.
pub(crate) const LARGEST_SEPARATION_S: f64 = 1.05;
/// Standard deviation of an unmeasured speed (m/s), typical of a drone.
const UNKNOWN_SPEED_SIGMA_M_S: f64 = 10.0;
/// Standard deviation of the acceleration between two epochs (m/s²), typical of a drone.
const ACCELERATION_SIGMA_M_S2: f64 = 3.0;
/// Distance to the satellites (m): a base's position error divided by this distance is the error of the
/// directions.
const SATELLITE_DISTANCE_M: f64 = 2.2e7;

/// Position of the base at each of its epochs; `None` where the codes give no position.
#[derive(Debug)]
pub(crate) struct BaseTrack(Vec<Option<SinglePoint>>);

/// The base at the time of a rover's epoch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MovedBase {
    pub position_ecef_m: [f64; 3],
    /// Covariance of the base's position (m²).
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// Covariance (m²) of the base's motion between the epochs of base and rover.
    pub motion_ecef_m2: [[f64; 3]; 3],
}

impl BaseTrack {
    /// The track of a base by its single-point positions.
    pub(crate) fn of(context: &SingleContext<'_>, epochs: &[Epoch]) -> Self {
        // Every epoch starts from the first position found, so that no epoch depends on its neighbours.
        let mut start = None;
        let points = epochs.iter().map(|epoch| {
            let states = context.states(epoch, epoch.tag, true);
            let from = start.unwrap_or([0.0; 3]);
            let point = context.solve(epoch, &states, from).ok()?;
            start.get_or_insert(point.position_ecef_m);
            Some(point)
        });
        Self(points.collect())
    }

    /// The base at one of its epochs.
    pub(crate) fn at(&self, index: usize) -> Option<&SinglePoint> {
        self.0.get(index)?.as_ref()
    }

    /// The base's first position (ECEF, m).
    pub(crate) fn first_ecef_m(&self) -> Option<[f64; 3]> {
        self.0.iter().flatten().next().map(|p| p.position_ecef_m)
    }
}

/// The place of the base of `point` at `time`, a second at most from the base's epoch.
pub(crate) fn moved(point: &SinglePoint, time: GpsTime) -> MovedBase {
    let elapsed_s = time.seconds_since(point.time);
    let unknown = UNKNOWN_SPEED_SIGMA_M_S.powi(2);
    let (velocity, covariance) = point.velocity.unwrap_or((
        [0.0; 3],
        [
            [unknown, 0.0, 0.0],
            [0.0, unknown, 0.0],
            [0.0, 0.0, unknown],
        ],
    ));
    let by_acceleration = (ACCELERATION_SIGMA_M_S2 * elapsed_s * elapsed_s / 2.0).powi(2);
    MovedBase {
        position_ecef_m: std::array::from_fn(|k| {
            point.position_ecef_m[k] + velocity[k] * elapsed_s
        }),
        covariance_ecef_m2: point.covariance_ecef_m2,
        motion_ecef_m2: std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let own = if i == j { by_acceleration } else { 0.0 };
                covariance[i][j] * elapsed_s * elapsed_s + own
            })
        }),
    }
}

impl MovedBase {
    /// Covariance (m²) of a baseline of `length_m` with the filter's `covariance`, plus the contributions of
    /// the base's motion between the epochs and of the base's position.
    pub(crate) fn of_baseline(
        &self,
        covariance_ecef_m2: &[[f64; 3]; 3],
        length_m: f64,
    ) -> [[f64; 3]; 3] {
        let turn = (length_m / SATELLITE_DISTANCE_M).powi(2);
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                covariance_ecef_m2[i][j]
                    + self.motion_ecef_m2[i][j]
                    + turn * self.covariance_ecef_m2[i][j]
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_base_is_carried_to_the_rovers_time() {
        let time = GpsTime::from_week_tow(2_445, 1_000.0);
        let mut point = SinglePoint {
            position_ecef_m: [4e6, 1e6, 4e6],
            covariance_ecef_m2: [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 9.0]],
            satellites: 9,
            velocity: Some(([8.0, 0.0, -2.0], [[0.01; 3]; 3])),
            time,
        };
        let there = moved(&point, time + 0.012);
        assert!((there.position_ecef_m[0] - 4e6 - 0.096).abs() < 1e-6);
        assert!((there.position_ecef_m[2] - 4e6 + 0.024).abs() < 1e-6);
        // 0.1 m/s over 12 ms are 1.2 mm, 3 m/s² are 0.2 mm.
        let sigma_m = there.motion_ecef_m2[0][0].sqrt();
        assert!((sigma_m - 1.219e-3).abs() < 1e-5, "{sigma_m}");
        let whole = there.of_baseline(&[[0.0; 3]; 3], 11.0);
        let by_place_m2 = whole[2][2] - there.motion_ecef_m2[2][2];
        // Three metres turn a baseline of eleven by a micrometre and a half.
        assert!((by_place_m2.sqrt() - 1.5e-6).abs() < 1e-8, "{by_place_m2}");
        point.velocity = None;
        let sigma_m = moved(&point, time + 0.012).motion_ecef_m2[1][1].sqrt();
        assert!((sigma_m - 0.12).abs() < 1e-3, "{sigma_m}");
    }
}
