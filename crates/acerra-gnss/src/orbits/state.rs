//! Position and clock of a satellite with their rates, in the frame that rotates with the Earth.

/// Earth's rotation rate of WGS84 and GTRF (rad/s).
pub(crate) const EARTH_ROTATION_RAD_S: f64 = 7.292_115_146_7e-5;

/// Earth's rotation rate of CGCS2000 and PZ-90 (rad/s).
pub(crate) const EARTH_ROTATION_CGCS_RAD_S: f64 = 7.292_115e-5;

/// Position and clock of a satellite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitState {
    /// Antenna position (ECEF at the same instant, m).
    pub position_ecef_m: [f64; 3],
    /// Satellite clock minus GPS time, relativity included, group delay not (s).
    pub clock_s: f64,
}

/// A state with its rates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitRates {
    /// Velocity in the rotating frame (m/s).
    pub velocity_ecef_m_s: [f64; 3],
    /// Clock drift (s/s).
    pub clock_rate: f64,
}
