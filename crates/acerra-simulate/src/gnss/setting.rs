//! Where and when two receivers log, and the satellites above them.

use acerra_geo::geodesy::EnuFrame;
use acerra_geo::time::GpsTime;
use acerra_gnss::Navigation;

/// Where, when and along which path the receivers log.
pub struct Setting<'a> {
    /// The frame of the positions below.
    pub frame: EnuFrame,
    /// GPS time at which the rover's time is 0.
    pub start: GpsTime,
    /// Duration of both receivers' logs (s).
    pub duration_s: f64,
    /// Position of the rover's antenna (east, north, up, m) at a time (s) from the start.
    pub rover_m: &'a dyn Fn(f64) -> [f64; 3],
    /// Position of the base's antenna (east, north, up, m).
    pub base_m: [f64; 3],
    /// The satellites: from [`constellation`](fn@super::constellation), or read from a navigation
    /// file. GPS is used.
    pub navigation: &'a Navigation,
    /// Seed of everything random.
    pub seed: u64,
}
