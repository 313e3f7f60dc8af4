//! The simulated logs against independent geometry, against their own promises, and against
//! programs that know nothing of them.

mod files;
mod geometry;
mod positions;
mod receivers;

use super::*;
use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_geo::time::{Calendar, GpsTime};
use acerra_gnss::{Ephemeris, KeplerEphemeris, Navigation, SatelliteId};
use std::f64::consts::TAU;

fn start() -> GpsTime {
    GpsTime::from_calendar(&Calendar::new(2018, 7, 9, 9, 30, 0.0).unwrap())
}

fn frame() -> EnuFrame {
    EnuFrame::new(Geodetic::from_degrees(40.95, 14.35, 60.0))
}

const BASE_M: [f64; 3] = [-35.0, 12.0, 1.6];

/// Thirty seconds on the ground, a climb, and loops at up to 2.5 m/s.
fn flight(time_s: f64) -> [f64; 3] {
    let t = (time_s - 30.0).max(0.0);
    let begin = (t / 10.0).min(1.0);
    let smooth = begin.powi(3) * (10.0 - 15.0 * begin + 6.0 * begin * begin);
    [
        15.0 * (TAU * t / 60.0).sin() * smooth,
        6.0 * (TAU * t / 45.0).sin() * smooth,
        0.3 + 9.7 * smooth + 0.4 * (TAU * t / 9.0).sin() * smooth,
    ]
}

fn setting(navigation: &Navigation, duration_s: f64, seed: u64) -> Setting<'_> {
    Setting {
        frame: frame(),
        start: start(),
        duration_s,
        rover_m: &flight,
        base_m: BASE_M,
        navigation,
        seed,
    }
}

/// Geometry alone: no atmosphere, no clocks, no noise.
fn bare() -> GnssModel {
    let model = GnssModel::default();
    GnssModel {
        ionosphere_scale: 0.0,
        humidity: -1.0,
        rover: model.rover.perfect(),
        base: model.base.perfect(),
        ..model
    }
}

fn kepler_of(navigation: &Navigation, satellite: SatelliteId, t: GpsTime) -> KeplerEphemeris {
    navigation
        .ephemerides
        .iter()
        .filter_map(|e| match e {
            Ephemeris::Kepler(e) if e.satellite == satellite => Some(*e),
            _ => None,
        })
        .min_by(|a, b| {
            let away = |e: &KeplerEphemeris| e.toe.seconds_since(t).abs();
            away(a).total_cmp(&away(b))
        })
        .unwrap()
}
