//! Results of single epochs and events.

use super::baseline::Baseline;
use super::not_fixed::NotFixedReason;
use super::quality::Quality;
use crate::observations::observation::EventRecord;
use crate::observations::satellite::SatelliteId;
use acerra_geo::time::GpsTime;

/// The solution of one epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// GPS time of the position: receiver tag minus receiver clock offset.
    pub time: GpsTime,
    /// Rover antenna position (ECEF, m).
    pub position_ecef_m: [f64; 3],
    /// Covariance of the position (ECEF, m²), for a known base position; with a moving base the covariance of
    /// the base's position is included.
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// The vector from a moving base ([`PositioningMode::MovingBase`]); `None` with a fixed base.
    ///
    /// [`PositioningMode::MovingBase`]: crate::PositioningMode::MovingBase
    pub baseline: Option<Baseline>,
    /// Velocity (ECEF, m/s), from Doppler or from the motion model.
    pub velocity_ecef_m_s: Option<[f64; 3]>,
    /// Quality.
    pub quality: Quality,
    /// Satellites used.
    pub satellites: usize,
    /// Age of the base's data (s); negative when the base epoch is later.
    pub age_s: f64,
    /// Ratio of the ambiguity test, capped at 999.9; 0 when none was made.
    pub ratio: f64,
    /// Reason for which the epoch is not fixed; `None` for a fixed epoch.
    pub not_fixed: Option<NotFixedReason>,
    /// Residuals and state of each satellite used.
    pub residuals: Vec<SatelliteResidual>,
}

/// Residuals of one satellite and frequency after the update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SatelliteResidual {
    /// The satellite.
    pub satellite: SatelliteId,
    /// Frequency slot.
    pub slot: usize,
    /// Azimuth from north (rad).
    pub azimuth_rad: f64,
    /// Elevation (rad).
    pub elevation_rad: f64,
    /// Double-difference phase residual (m), where the phase was used.
    pub phase_m: Option<f64>,
    /// Double-difference code residual (m), where the code was used.
    pub code_m: Option<f64>,
    /// Whether a cycle slip was flagged at this epoch.
    pub slipped: bool,
    /// Whether the ambiguity is part of a fix.
    pub fixed: bool,
}

/// An epoch that yields no position at all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostEpoch {
    /// Receiver tag.
    pub time: GpsTime,
    /// Reason for which there is no position.
    pub reason: NotFixedReason,
}

/// The rover's position at an event.
#[derive(Debug, Clone, PartialEq)]
pub struct EventPosition {
    /// The event.
    pub event: EventRecord,
    /// Time of the event in GPS time.
    pub time: GpsTime,
    /// Position (ECEF, m) interpolated between its neighbours; `None` outside the solution or
    /// inside a gap.
    pub position_ecef_m: Option<[f64; 3]>,
    /// The worse covariance of the two neighbours (ECEF, m²).
    pub covariance_ecef_m2: [[f64; 3]; 3],
    /// The worse quality of the two neighbours.
    pub quality: Option<Quality>,
}

impl Solution {
    /// The covariance (ECEF, m²) relative to the base: the baseline's covariance for a moving base.
    #[must_use]
    pub fn relative_covariance_ecef_m2(&self) -> [[f64; 3]; 3] {
        self.baseline
            .map_or(self.covariance_ecef_m2, |b| b.covariance_ecef_m2)
    }
}
