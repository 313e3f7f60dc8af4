//! The attitudes of a log at any instant.

use acerra_geo::time::GpsTime;
use acerra_geo::trajectory::Attitude;

use crate::timeline::AttitudeTrack;

/// Attitudes of the vehicle, and of the requested gimbal, on GPS time.
///
/// They turn body axes (forward, left, up) to east, north, up at the vehicle.
#[derive(Debug, Clone, Default)]
pub struct LogAttitudes {
    pub(crate) vehicle: Option<AttitudeTrack>,
    pub(crate) gimbal: Option<AttitudeTrack>,
}

impl LogAttitudes {
    /// Attitude of the vehicle at `time`, between its neighbours; none where they are more than half a second
    /// apart.
    #[must_use]
    pub fn vehicle_at(&self, time: GpsTime) -> Option<Attitude> {
        self.vehicle.as_ref()?.at(time)
    }

    /// Attitude of the gimbal, likewise.
    #[must_use]
    pub fn gimbal_at(&self, time: GpsTime) -> Option<Attitude> {
        self.gimbal.as_ref()?.at(time)
    }
}
