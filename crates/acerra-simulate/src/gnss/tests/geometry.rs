//! Ranges, phases and orbits against geometry of their own.

use super::*;
use crate::gnss::receiver::WAVELENGTH_M;
use acerra_gnss::SPEED_OF_LIGHT_M_S;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// The place of a satellite in inertial axes (aligned with the Earth at the week's start), and
/// its clock: Kepler's equation by bisection, the orbit by its basis vectors.
fn inertial(e: &KeplerEphemeris, t: GpsTime) -> ([f64; 3], f64) {
    const MU: f64 = 3.986_005e14;
    let a = e.sqrt_semi_major_axis.powi(2);
    let tk = t.seconds_since(e.toe);
    let mean = e.mean_anomaly_rad + ((MU / a.powi(3)).sqrt() + e.mean_motion_correction_rad_s) * tk;
    let (mut low, mut high) = (mean - 1.0, mean + 1.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle - e.eccentricity * middle.sin() < mean {
            low = middle
        } else {
            high = middle
        }
    }
    let anomaly = 0.5 * (low + high);
    let half = ((1.0 + e.eccentricity) / (1.0 - e.eccentricity)).sqrt() * (anomaly / 2.0).tan();
    let latitude = 2.0 * half.atan() + e.perigee_rad;
    let wave = |[c, s]: [f64; 2]| c * (2.0 * latitude).cos() + s * (2.0 * latitude).sin();
    let u = latitude + wave(e.latitude_correction_rad);
    let r = a * (1.0 - e.eccentricity * anomaly.cos()) + wave(e.radius_correction_m);
    let i = e.inclination_rad + e.inclination_rate_rad_s * tk + wave(e.inclination_correction_rad);
    // In inertial axes the node moves by its own rate only; the message gives the node at toe in rotated axes.
    let node = e.ascending_node_rad + e.ascending_node_rate_rad_s * tk;
    let to_node = [node.cos(), node.sin(), 0.0];
    let across = [-node.sin() * i.cos(), node.cos() * i.cos(), i.sin()];
    let place = [0, 1, 2].map(|k| r * (u.cos() * to_node[k] + u.sin() * across[k]));
    let dt = t.seconds_since(e.toc);
    let [a0, a1, a2] = e.clock;
    let relativity =
        -2.0 * (MU * a).sqrt() * e.eccentricity * anomaly.sin() / SPEED_OF_LIGHT_M_S.powi(2);
    (place, a0 + a1 * dt + a2 * dt * dt + relativity)
}

/// A point of the Earth in the same axes.
fn antenna_inertial(ecef: [f64; 3], t: GpsTime) -> [f64; 3] {
    let turn = 7.292_115_146_7e-5 * t.tow_s();
    let [x, y, z] = ecef;
    [
        x * turn.cos() - y * turn.sin(),
        x * turn.sin() + y * turn.cos(),
        z,
    ]
}

#[test]
fn ranges_are_those_of_inertial_geometry() {
    let navigation = constellation(start(), 120.0, 3);
    let setting = setting(&navigation, 120.0, 3);
    let logs = simulate(&bare(), &setting).unwrap();
    let mut checked = 0;
    for (log, rover) in [(&logs.rover, true), (&logs.base, false)] {
        for epoch in log.epochs.iter().step_by(37) {
            let t = epoch.true_time;
            let enu = if rover {
                flight(t.seconds_since(start()))
            } else {
                BASE_M
            };
            let antenna = antenna_inertial(frame().ecef_from_enu(enu), t);
            for seen in &epoch.observed {
                let e = kepler_of(&navigation, seen.satellite, start() + 60.0);
                // The light cone by fixed-point iteration, in axes that do not turn.
                let mut delay = 0.07;
                let mut clock = 0.0;
                for _ in 0..6 {
                    let (place, satellite_clock) = inertial(&e, t - delay);
                    clock = satellite_clock;
                    let d = [0, 1, 2].map(|k| place[k] - antenna[k]);
                    delay = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt() / SPEED_OF_LIGHT_M_S;
                }
                let want = SPEED_OF_LIGHT_M_S * (delay - clock + e.group_delay_s[0]);
                let miss = seen.pseudorange_m - want;
                assert!(miss.abs() < 1e-4, "{} misses by {miss} m", seen.satellite);
                checked += 1;
            }
        }
    }
    assert!(checked > 200, "{checked}");
}

#[test]
fn without_noise_the_phase_is_the_range_plus_whole_cycles() {
    let navigation = constellation(start(), 60.0, 3);
    let logs = simulate(&bare(), &setting(&navigation, 60.0, 4)).unwrap();
    let mut first: BTreeMap<SatelliteId, f64> = BTreeMap::new();
    for epoch in &logs.rover.epochs {
        for seen in &epoch.observed {
            let cycles = seen.phase_cycles - seen.pseudorange_m / WAVELENGTH_M;
            assert!((cycles - cycles.round()).abs() < 1e-5, "{cycles}");
            let known = *first.entry(seen.satellite).or_insert(cycles);
            assert!((cycles - known).abs() < 1e-5);
        }
    }
    assert!(first.len() >= 6);
}

#[test]
fn the_atmosphere_delays_the_code_and_divides_the_phase() {
    let navigation = constellation(start(), 10.0, 3);
    let model = GnssModel {
        ionosphere_scale: 1.5,
        humidity: 0.5,
        ..bare()
    };
    let dry = simulate(&bare(), &setting(&navigation, 10.0, 4)).unwrap();
    let wet = simulate(&model, &setting(&navigation, 10.0, 4)).unwrap();
    let (a, b) = (&dry.base.epochs[3].observed, &wet.base.epochs[3].observed);
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(b) {
        let code = b.pseudorange_m - a.pseudorange_m;
        let phase = (b.phase_cycles - a.phase_cycles) * WAVELENGTH_M;
        let (troposphere, ionosphere) = ((code + phase) / 2.0, (code - phase) / 2.0);
        assert!((2.2..15.0).contains(&troposphere), "{troposphere}");
        assert!((2.0..40.0).contains(&ionosphere), "{ionosphere}");
    }
}

#[test]
fn doppler_is_the_rate_of_the_phase() {
    let navigation = constellation(start(), 60.0, 3);
    let mut model = GnssModel::default();
    model.rover = ReceiverModel {
        clock_drift_walk: 0.0,
        ..model.rover.noiseless()
    };
    let logs = simulate(&model, &setting(&navigation, 60.0, 4)).unwrap();
    for trio in logs.rover.epochs.windows(3) {
        for seen in &trio[1].observed {
            let of = |epoch: &ObservedEpoch| {
                epoch
                    .observed
                    .iter()
                    .find(|o| o.satellite == seen.satellite)
                    .copied()
            };
            let (Some(before), Some(after)) = (of(&trio[0]), of(&trio[2])) else {
                continue;
            };
            if trio
                .iter()
                .any(|e| of(e).is_some_and(|o| o.loss_of_lock.slipped()))
            {
                continue;
            }
            let jump = trio[2].true_time.seconds_since(trio[0].true_time) - 0.4;
            if jump.abs() > 1e-4 {
                continue; // the clock jumped by a millisecond
            }
            let rate = (after.phase_cycles - before.phase_cycles) / 0.4;
            // The climb's jerk bends the difference by two hundredths of a cycle.
            assert!(
                (rate + seen.doppler_hz).abs() < 0.05,
                "{rate} against {}",
                seen.doppler_hz
            );
        }
    }
}

#[test]
fn issues_of_one_satellite_describe_one_orbit() {
    // Across the end of a week, where the reference of the node changes.
    let end_of_week = GpsTime::from_week_tow(2010, 604_800.0 - 3600.0);
    let navigation = constellation(end_of_week, 4.0 * 3600.0, 10);
    let mut by_satellite: BTreeMap<SatelliteId, Vec<Ephemeris>> = BTreeMap::new();
    for e in &navigation.ephemerides {
        by_satellite.entry(e.satellite()).or_default().push(*e);
    }
    assert_eq!(by_satellite.len(), 31);
    for list in by_satellite.values() {
        assert!(list.len() >= 3);
        for pair in list.windows(2) {
            let t = pair[0].toe() + 3600.0;
            let (a, b) = (pair[0].orbit_at(t), pair[1].orbit_at(t));
            let miss = [0, 1, 2].map(|k| a.position_ecef_m[k] - b.position_ecef_m[k]);
            let miss = miss.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!(miss < 0.5, "issues differ by {miss} m");
            assert!((a.clock_s - b.clock_s).abs() < 2e-9);
        }
    }
}

#[test]
fn the_sky_is_that_of_gps() {
    let mut fewest = usize::MAX;
    for seed in 0..8 {
        let navigation = constellation(start(), 10.0, seed);
        let logs = simulate(&bare(), &setting(&navigation, 10.0, seed)).unwrap();
        fewest = fewest.min(logs.base.epochs[0].observed.len());
        for e in &navigation.ephemerides {
            let p = e.orbit_at(start()).position_ecef_m;
            let r = p.iter().map(|v| v * v).sum::<f64>().sqrt();
            assert!((26.0e6..27.1e6).contains(&r), "{r}");
            let latitude = (p[2] / r).asin();
            assert!(latitude.abs() < 57.0 * PI / 180.0);
        }
    }
    assert!(fewest >= 6, "{fewest} satellites above 10°");
}
