//! Range with Earth rotation, line of sight, azimuth and elevation.

use super::state::EARTH_ROTATION_RAD_S;
use crate::observations::signal::SPEED_OF_LIGHT_M_S;
use acerra_geo::geodesy::{EnuFrame, WGS84_SEMI_MAJOR_AXIS_M};

/// Range and direction from a receiver to a satellite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineOfSight {
    /// Geometric range with the Sagnac term (m).
    pub range_m: f64,
    /// Unit vector from receiver to satellite (ECEF, not corrected for Earth rotation).
    pub unit_ecef: [f64; 3],
}

/// Line of sight from `receiver_ecef_m` to `satellite_ecef_m`; `None` when the "satellite" is
/// inside the Earth.
///
/// ```
/// let los = acerra_gnss::line_of_sight([26_560_000.0, 0.0, 0.0], [4e6, -3e6, 4e6]).unwrap();
/// assert!((los.range_m - 23_107_416.651_319).abs() < 1e-6);
/// ```
#[must_use]
pub fn line_of_sight(satellite_ecef_m: [f64; 3], receiver_ecef_m: [f64; 3]) -> Option<LineOfSight> {
    let norm = |v: &[f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    let (s, r) = (satellite_ecef_m, receiver_ecef_m);
    let outside = norm(&s) >= WGS84_SEMI_MAJOR_AXIS_M; // false for NaN too
    let d = [s[0] - r[0], s[1] - r[1], s[2] - r[2]];
    let distance = norm(&d);
    if !outside || distance.is_nan() || distance <= 0.0 {
        return None;
    }
    Some(LineOfSight {
        range_m: distance + EARTH_ROTATION_RAD_S * (s[0] * r[1] - s[1] * r[0]) / SPEED_OF_LIGHT_M_S,
        unit_ecef: d.map(|v| v / distance),
    })
}

/// Azimuth from north in \[0, 2π) and elevation (rad) of a unit vector, in the local frame.
#[must_use]
pub fn azimuth_elevation_rad(frame: &EnuFrame, unit_ecef: [f64; 3]) -> (f64, f64) {
    let [east, north, up] = frame.enu_vector_from_ecef(unit_ecef);
    (azimuth_rad(east, north), elevation_rad(up))
}

/// Azimuth from north in \[0, 2π) of a direction (rad); 0 in the zenith.
pub(crate) fn azimuth_rad(east: f64, north: f64) -> f64 {
    let azimuth = if east * east + north * north < 1e-12 {
        0.0
    } else {
        east.atan2(north)
    };
    if azimuth < 0.0 {
        azimuth + std::f64::consts::TAU
    } else {
        azimuth
    }
}

/// Elevation (rad) of a unit vector, by its component upwards.
pub(crate) fn elevation_rad(up: f64) -> f64 {
    up.clamp(-1.0, 1.0).asin()
}
