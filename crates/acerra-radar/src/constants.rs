//! Constants of the instrument and of propagation.

/// Speed of light in vacuum, m/s (exact, SI definition of the metre).
pub const SPEED_OF_LIGHT_M_S: f64 = 299_792_458.0;

/// One fast-time bin of a PulsON 400-series radio, s: 1 / (512 × 1.024 GHz) = 1.907 348 6 ps.
pub const FAST_TIME_BIN_S: f64 = 1e-9 / (512.0 * 1.024);

/// Bins between two samples of a scan as the P440 delivers them (16.384 GHz, 61.035 156 25 ps).
pub const DEFAULT_STEP_BINS: u16 = 32;

/// Two-way delay, s, of an echo from `range_m` metres.
///
/// ```
/// let delay_s = acerra_radar::two_way_delay_s(1.5);
/// assert!((delay_s - 10.007e-9).abs() < 1e-12);
/// ```
#[must_use]
pub fn two_way_delay_s(range_m: f64) -> f64 {
    2.0 * range_m / SPEED_OF_LIGHT_M_S
}
