//! The simulated logs against independent geometry, against their own promises, and against
//! programs that know nothing of them.

use super::receiver::WAVELENGTH_M;
use super::*;
use acerra_geo::geodesy::Geodetic;
use acerra_geo::time::Calendar;
use acerra_gnss::input::Limits;
use acerra_gnss::{
    BasePosition, Ephemeris, KeplerEphemeris, LossOfLock, PpkOptions, Quality, SPEED_OF_LIGHT_M_S,
    SatelliteId, read_navigation, read_observations,
};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::process::Command;

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

/// The place of a satellite in axes that do not turn (those of the Earth at the week's start), and
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
    // In these axes the node moves by its own rate only; told at toe in turned axes.
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
fn noise_is_as_large_as_asked_and_grows_towards_the_horizon() {
    let navigation = constellation(start(), 3600.0, 5);
    let mut quiet = GnssModel::default();
    quiet.base = ReceiverModel {
        interval_s: 1.0,
        ..quiet.base.noiseless()
    };
    let mut noisy = quiet.clone();
    noisy.base.code_noise_m = 0.5;
    noisy.base.phase_noise_m = 0.002;
    let still = |_: f64| [0.0, 0.0, 5.0];
    let setting = Setting {
        rover_m: &still,
        ..setting(&navigation, 1800.0, 5)
    };
    let a = simulate(&quiet, &setting).unwrap().base;
    let b = simulate(&noisy, &setting).unwrap().base;
    let place = EnuFrame::from_ecef(a.position_ecef_m);
    // Bins of elevation: 10–20°, 60–90°.
    let mut code = [(0.0, 0.0); 2];
    let mut phase = [(0.0, 0.0); 2];
    for (a, b) in a.epochs.iter().zip(&b.epochs) {
        for (quiet, noisy) in a.observed.iter().zip(&b.observed) {
            let e = kepler_of(&navigation, quiet.satellite, a.tag);
            let ecef = Ephemeris::Kepler(e).orbit_at(a.tag).position_ecef_m;
            let [x, y, up] = place.enu_from_ecef(ecef);
            let elevation = up.atan2(x.hypot(y)).to_degrees();
            let bin = match elevation {
                e if e < 20.0 => 0,
                e if e > 60.0 => 1,
                _ => continue,
            };
            let d = noisy.pseudorange_m - quiet.pseudorange_m;
            code[bin] = (code[bin].0 + d * d, code[bin].1 + 1.0);
            let d = (noisy.phase_cycles - quiet.phase_cycles) * WAVELENGTH_M;
            phase[bin] = (phase[bin].0 + d * d, phase[bin].1 + 1.0);
        }
    }
    let rms = |(sum, n): (f64, f64)| (sum / n).sqrt();
    // √((1 + 1/sin²)/2) is 1.00 to 1.08 above 60° and 2.2 to 4.1 between 10° and 20°.
    assert!(
        code[1].1 > 500.0 && (0.49..0.56).contains(&rms(code[1])),
        "{}",
        rms(code[1])
    );
    assert!(
        code[0].1 > 500.0 && (1.0..2.1).contains(&rms(code[0])),
        "{}",
        rms(code[0])
    );
    assert!(
        (0.0019..0.0023).contains(&rms(phase[1])),
        "{}",
        rms(phase[1])
    );
    assert!(
        (0.004..0.0085).contains(&rms(phase[0])),
        "{}",
        rms(phase[0])
    );
}

#[test]
fn cycles_change_only_where_the_log_says_so() {
    let navigation = constellation(start(), 600.0, 6);
    let mut model = bare();
    model.rover.slips_per_hour = 60.0;
    model.rover.blockages_per_hour = 40.0;
    model.rover.blockage_time_s = 4.0;
    model.rover.outages_s = vec![[200.0, 203.0]];
    let logs = simulate(&model, &setting(&navigation, 600.0, 6)).unwrap();
    let mut cycles: BTreeMap<SatelliteId, f64> = BTreeMap::new();
    let (mut slips, mut halves, mut unresolved) = (0, 0, 0);
    for epoch in &logs.rover.epochs {
        let time_s = epoch.true_time.seconds_since(start());
        assert!(
            !(200.0..203.0).contains(&time_s),
            "nothing is logged in the outage"
        );
        for seen in &epoch.observed {
            let now = seen.phase_cycles - seen.pseudorange_m / WAVELENGTH_M;
            let LossOfLock(bits) = seen.loss_of_lock;
            let before = cycles.insert(seen.satellite, now);
            if bits & LossOfLock::HALF_CYCLE != 0 {
                unresolved += 1;
            } else {
                assert!(
                    (now - now.round()).abs() < 1e-5,
                    "whole cycles when resolved: {now}"
                );
            }
            if (now * 2.0).round() as i64 % 2 != 0 {
                halves += 1;
            }
            if let Some(before) = before {
                if bits & LossOfLock::SLIP != 0 {
                    slips += 1;
                } else {
                    assert!(
                        (now - before).abs() < 1e-5,
                        "silent change of {}",
                        now - before
                    );
                }
            }
        }
    }
    assert!(slips > 30, "{slips} slips");
    assert!(
        unresolved > 100 && halves > 20,
        "{unresolved} unresolved, {halves} with a half"
    );
}

#[test]
fn the_clock_wanders_and_jumps_by_whole_milliseconds() {
    let navigation = constellation(start(), 300.0, 7);
    let mut model = GnssModel::default();
    model.rover = ReceiverModel {
        clock_offset_s: 4.9e-4,
        clock_drift: 5e-7,
        tag_offset_s: 0.013,
        ..model.rover.noiseless()
    };
    let logs = simulate(&model, &setting(&navigation, 300.0, 7)).unwrap();
    let offsets: Vec<f64> = logs
        .rover
        .epochs
        .iter()
        .map(|e| e.tag.seconds_since(e.true_time))
        .collect();
    assert!(offsets.iter().all(|o| o.abs() <= 5.0e-4 + 1e-9));
    let jumps = offsets
        .windows(2)
        .filter(|w| (w[1] - w[0] + 1e-3).abs() < 1e-5)
        .count();
    assert_eq!(jumps, 1);
    for epoch in &logs.rover.epochs {
        let ms = epoch.tag.tow_s() * 1e3;
        assert!(
            (ms - ms.round()).abs() < 1e-4,
            "tags are whole milliseconds"
        );
        assert_eq!(ms.round() as i64 % 200, 13);
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_receivers_are_independent() {
    let navigation = constellation(start(), 30.0, 8);
    let model = GnssModel::default();
    let run = |model: &GnssModel, seed| simulate(model, &setting(&navigation, 30.0, seed)).unwrap();
    let (a, b, c) = (run(&model, 8), run(&model, 8), run(&model, 9));
    assert_eq!(a.rover.to_rinex("R"), b.rover.to_rinex("R"));
    assert_eq!(a.rover.to_ubx(&navigation), b.rover.to_ubx(&navigation));
    assert_ne!(a.rover.to_rinex("R"), c.rover.to_rinex("R"));
    let mut other = model.clone();
    other.rover.code_noise_m = 3.0;
    other.rover.slips_per_hour = 500.0;
    let d = run(&other, 8);
    assert_eq!(a.base.to_rinex("B"), d.base.to_rinex("B"));
    assert_ne!(a.rover.to_rinex("R"), d.rover.to_rinex("R"));
    assert_eq!(navigation, constellation(start(), 30.0, 8));
    assert_ne!(navigation, constellation(start(), 30.0, 9));
}

#[test]
fn rinex_is_read_back_as_written() {
    let navigation = constellation(start(), 20.0, 9);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 20.0, 9)).unwrap();
    let text = logs.rover.to_rinex("ROVER");
    assert!(text.lines().all(|line| line.len() <= 80));
    let (data, report) = read_observations(text.as_bytes(), Limits::default()).unwrap();
    assert!(report.dropped.is_empty(), "{report:?}");
    assert_eq!(data.epochs.len(), logs.rover.epochs.len());
    for (read, written) in data.epochs.iter().zip(&logs.rover.epochs) {
        assert!(read.time.seconds_since(written.tag).abs() < 1e-7);
        assert_eq!(read.satellites.len(), written.observed.len());
        for (read, written) in read.satellites.iter().zip(&written.observed) {
            assert_eq!(read.satellite, written.satellite);
            let signal = read.signals[0].unwrap();
            assert!((signal.pseudorange_m.unwrap() - written.pseudorange_m).abs() <= 5.01e-4);
            assert!((signal.phase_cycles.unwrap() - written.phase_cycles).abs() <= 5.01e-4);
            assert_eq!(signal.loss_of_lock, written.loss_of_lock);
        }
    }
    let text = navigation_to_rinex(&navigation);
    assert!(text.lines().all(|line| line.len() <= 80));
    let (read, _) = read_navigation(text.as_bytes(), Limits::default()).unwrap();
    assert_eq!(read.ephemerides.len(), 31);
    let t = start() + 1234.0;
    for (read, written) in read.ephemerides.iter().zip(&navigation.ephemerides) {
        assert_eq!(read.satellite(), written.satellite());
        let (a, b) = (read.orbit_at(t), written.orbit_at(t));
        for k in 0..3 {
            assert!((a.position_ecef_m[k] - b.position_ecef_m[k]).abs() < 1e-3);
        }
        assert!((a.clock_s - b.clock_s).abs() < 1e-15);
    }
}

#[test]
fn issues_of_one_satellite_describe_one_orbit() {
    // Over the end of a week, where the node is told anew.
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

#[test]
fn nonsense_is_refused_with_the_reason() {
    let navigation = constellation(start(), 10.0, 1);
    let good = GnssModel::default();
    let refused = |model: &GnssModel| {
        simulate(model, &setting(&navigation, 10.0, 1))
            .unwrap_err()
            .to_string()
    };
    let mut model = good.clone();
    model.rover.interval_s = 0.0;
    assert!(refused(&model).contains("interval_s: expected 0.05 to 60 s"));
    let mut model = good.clone();
    model.base.code_noise_m = f64::NAN;
    assert!(refused(&model).contains("code_noise_m"));
    let mut model = good.clone();
    model.rover.outages_s = vec![[5.0, 2.0]];
    assert!(refused(&model).contains("outages_s"));
    let mut model = good.clone();
    model.elevation_mask_deg = 91.0;
    assert!(refused(&model).contains("elevation_mask_deg"));
    let empty = Navigation::default();
    let error = simulate(&good, &setting(&empty, 10.0, 1)).unwrap_err();
    assert_eq!(error, GnssError::EmptySky { most: 0 });
    let error = simulate(&good, &setting(&navigation, f64::INFINITY, 1)).unwrap_err();
    assert!(error.to_string().contains("duration_s"));
    assert!(
        toml::from_str::<GnssModel>("elevation_mask = 3").is_err(),
        "unknown keys"
    );
    let model: GnssModel = toml::from_str("[rover]\ninterval_s = 1.0").unwrap();
    assert_eq!(model.rover.interval_s, 1.0);
}

/// Horizontal and vertical misses of fixed positions against the flight (m), and their share.
struct Misses {
    horizontal: Vec<f64>,
    vertical: Vec<f64>,
    epochs: usize,
}

impl Misses {
    fn of(list: impl Iterator<Item = (GpsTime, [f64; 3], bool)>) -> Self {
        let mut out = Self {
            horizontal: Vec::new(),
            vertical: Vec::new(),
            epochs: 0,
        };
        for (time, ecef, fixed) in list {
            out.epochs += 1;
            if fixed {
                let truth = flight(time.seconds_since(start()));
                let enu = frame().enu_from_ecef(ecef);
                out.horizontal
                    .push((enu[0] - truth[0]).hypot(enu[1] - truth[1]));
                out.vertical.push((enu[2] - truth[2]).abs());
            }
        }
        out.horizontal.sort_by(f64::total_cmp);
        out.vertical.sort_by(f64::total_cmp);
        out
    }

    fn share(&self) -> f64 {
        self.horizontal.len() as f64 / self.epochs.max(1) as f64
    }

    fn quantile(list: &[f64], share: f64) -> f64 {
        list[((list.len() - 1) as f64 * share).round() as usize]
    }
}

#[test]
fn our_own_ppk_fixes_the_flight_within_two_centimetres() {
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let read = |text: String| {
        read_observations(text.as_bytes(), Limits::default())
            .unwrap()
            .0
    };
    let (rover, base) = (
        read(logs.rover.to_rinex("R")),
        read(logs.base.to_rinex("B")),
    );
    let misses = own_ppk(&rover, &base, &navigation, logs.base.position_ecef_m);
    println!(
        "fixed {:.1} %, 95 % within {:.4} m horizontally, {:.4} m vertically",
        100.0 * misses.share(),
        Misses::quantile(&misses.horizontal, 0.95),
        Misses::quantile(&misses.vertical, 0.95)
    );
    assert!(
        misses.epochs > 1000 && misses.share() > 0.9,
        "{}",
        misses.share()
    );
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
    assert!(Misses::quantile(&misses.vertical, 0.95) < 0.04);
}

#[test]
fn rtklib_accepts_the_rinex_and_fixes_the_flight_within_two_centimetres() {
    let Ok(found) = Command::new("rnx2rtkp").arg("-?").output() else {
        println!("skipped: rnx2rtkp (Debian package rtklib) is not installed");
        return;
    };
    drop(found);
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let rover = write("rover.18o", logs.rover.to_rinex("ROVER"));
    let base = write("base.18o", logs.base.to_rinex("BASE"));
    let nav = write("brdc.18n", navigation_to_rinex(&navigation));
    let out = folder.path().join("out.pos");
    let [x, y, z] = logs.base.position_ecef_m.map(|v| format!("{v:.5}"));
    let status = Command::new("rnx2rtkp")
        .args([
            "-p", "2", "-m", "15", "-f", "1", "-h", "-v", "3", "-e", "-d", "6", "-sys", "G",
        ])
        .args(["-r", &x, &y, &z, "-o"])
        .arg(&out)
        .args([&rover, &base, &nav])
        .output()
        .unwrap()
        .status;
    assert!(status.success());
    let text = std::fs::read_to_string(&out).unwrap();
    let misses = Misses::of(
        text.lines()
            .filter(|l| !l.starts_with('%'))
            .filter_map(|l| {
                let v: Vec<f64> = l
                    .split_whitespace()
                    .filter_map(|f| f.parse().ok())
                    .collect();
                let time = GpsTime::from_week_tow(*v.first()? as i64, *v.get(1)?);
                Some((time, [v[2], v[3], v[4]], v[5] == 1.0))
            }),
    );
    println!(
        "RTKLIB: {} epochs, fixed {:.1} %, 95 % within {:.4} m horizontally, {:.4} m vertically",
        misses.epochs,
        100.0 * misses.share(),
        Misses::quantile(&misses.horizontal, 0.95),
        Misses::quantile(&misses.vertical, 0.95)
    );
    assert!(
        misses.epochs > 1000 && misses.share() > 0.9,
        "{}",
        misses.share()
    );
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
    assert!(Misses::quantile(&misses.vertical, 0.95) < 0.04);
}

#[test]
fn rtklib_converts_the_ubx_log_to_the_same_rinex() {
    if Command::new("convbin").arg("-?").output().is_err() {
        println!("skipped: convbin (Debian package rtklib) is not installed");
        return;
    }
    let navigation = constellation(start(), 120.0, 12);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 120.0, 12)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("rover.ubx"), logs.rover.to_ubx(&navigation)).unwrap();
    let output = Command::new("convbin")
        .args([
            "-r",
            "ubx",
            "-v",
            "2.11",
            "-od",
            "-os",
            "-tr",
            "2018/07/09",
            "09:30:00",
        ])
        .arg("-o")
        .arg(path("rover.obs"))
        .arg("-n")
        .arg(path("rover.nav"))
        .arg(path("rover.ubx"))
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = std::fs::read(path("rover.obs")).unwrap();
    let (data, _) = read_observations(text.as_slice(), Limits::default()).unwrap();
    assert_eq!(data.epochs.len(), logs.rover.epochs.len());
    for (read, written) in data.epochs.iter().zip(&logs.rover.epochs) {
        assert!(read.time.seconds_since(written.tag).abs() < 1e-6);
        assert_eq!(read.satellites.len(), written.observed.len());
        for (read, written) in read.satellites.iter().zip(&written.observed) {
            let signal = read.signals[0].unwrap();
            assert!((signal.pseudorange_m.unwrap() - written.pseudorange_m).abs() <= 5.01e-4);
            assert!((signal.phase_cycles.unwrap() - written.phase_cycles).abs() <= 5.01e-4);
            assert!((signal.doppler_hz.unwrap() - written.doppler_hz).abs() <= 2e-3);
        }
    }
    // Every satellite tracked through subframes 1 to 3, each parameter as it was sent.
    let text = std::fs::read(path("rover.nav")).unwrap();
    let (read, _) = read_navigation(text.as_slice(), Limits::default()).unwrap();
    assert!(read.ephemerides.len() >= 6, "{}", read.ephemerides.len());
    for ephemeris in &read.ephemerides {
        let Ephemeris::Kepler(read) = ephemeris else {
            panic!("GPS only")
        };
        let sent = kepler_of(&navigation, read.satellite, start());
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-11 * b.abs().max(1e-30);
        assert_eq!((read.toe, read.toc), (sent.toe, sent.toc));
        assert_eq!(
            (read.iode, read.iodc, read.health),
            (sent.iode, sent.iodc, sent.health)
        );
        let pairs = [
            (read.sqrt_semi_major_axis, sent.sqrt_semi_major_axis),
            (read.eccentricity, sent.eccentricity),
            (read.inclination_rad, sent.inclination_rad),
            (read.ascending_node_rad, sent.ascending_node_rad),
            (read.perigee_rad, sent.perigee_rad),
            (read.mean_anomaly_rad, sent.mean_anomaly_rad),
            (
                read.mean_motion_correction_rad_s,
                sent.mean_motion_correction_rad_s,
            ),
            (
                read.ascending_node_rate_rad_s,
                sent.ascending_node_rate_rad_s,
            ),
            (read.inclination_rate_rad_s, sent.inclination_rate_rad_s),
            (
                read.latitude_correction_rad[0],
                sent.latitude_correction_rad[0],
            ),
            (
                read.latitude_correction_rad[1],
                sent.latitude_correction_rad[1],
            ),
            (read.radius_correction_m[0], sent.radius_correction_m[0]),
            (read.radius_correction_m[1], sent.radius_correction_m[1]),
            (
                read.inclination_correction_rad[0],
                sent.inclination_correction_rad[0],
            ),
            (
                read.inclination_correction_rad[1],
                sent.inclination_correction_rad[1],
            ),
            (read.clock[0], sent.clock[0]),
            (read.clock[1], sent.clock[1]),
            (read.group_delay_s[0], sent.group_delay_s[0]),
        ];
        for (i, (read, sent)) in pairs.into_iter().enumerate() {
            assert!(near(read, sent), "parameter {i}: {read} against {sent}");
        }
    }
}

#[test]
fn the_ubx_logs_alone_are_enough_for_our_own_ppk() {
    let navigation = constellation(start(), 240.0, 11);
    let logs = simulate(&GnssModel::default(), &setting(&navigation, 240.0, 11)).unwrap();
    let read = |bytes: Vec<u8>| {
        let file = acerra_gnss::read_gnss(bytes.as_slice(), Limits::default()).unwrap();
        assert!(file.report.dropped.is_empty(), "{:?}", file.report);
        (file.observations.unwrap(), file.navigation.unwrap())
    };
    let (rover, mut heard) = read(logs.rover.to_ubx(&navigation));
    let (base, from_base) = read(logs.base.to_ubx(&navigation));
    assert_eq!(rover.epochs.len(), logs.rover.epochs.len());
    for (read, written) in rover.epochs.iter().zip(&logs.rover.epochs) {
        for (read, written) in read.satellites.iter().zip(&written.observed) {
            let signal = read.signals[0].unwrap();
            assert_eq!(signal.pseudorange_m, Some(written.pseudorange_m));
            assert_eq!(signal.phase_cycles, Some(written.phase_cycles));
            assert_eq!(signal.loss_of_lock, written.loss_of_lock);
        }
    }
    heard.merge(from_base);
    for ephemeris in &heard.ephemerides {
        let sent = Ephemeris::Kepler(kepler_of(&navigation, ephemeris.satellite(), start()));
        let t = start() + 100.0;
        let (a, b) = (ephemeris.orbit_at(t), sent.orbit_at(t));
        for k in 0..3 {
            assert!((a.position_ecef_m[k] - b.position_ecef_m[k]).abs() < 1e-4);
        }
    }
    let misses = own_ppk(&rover, &base, &heard, logs.base.position_ecef_m);
    assert!(misses.share() > 0.9, "{}", misses.share());
    assert!(Misses::quantile(&misses.horizontal, 0.95) < 0.02);
}

fn own_ppk(
    rover: &acerra_gnss::ObservationData,
    base: &acerra_gnss::ObservationData,
    navigation: &Navigation,
    base_ecef_m: [f64; 3],
) -> Misses {
    let options = PpkOptions {
        base_position: BasePosition::Ecef(base_ecef_m),
        ..PpkOptions::default()
    };
    let solution = acerra_gnss::process(rover, base, navigation, &options).unwrap();
    Misses::of(
        solution
            .epochs
            .iter()
            .map(|s| (s.time, s.position_ecef_m, s.quality == Quality::Fixed)),
    )
}

#[test]
fn a_real_constellation_serves_as_well() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/gnss-geonet/nav.05n"
    );
    let Ok(file) = std::fs::File::open(path) else {
        println!("skipped: {path} is not here");
        return;
    };
    let (navigation, _) = read_navigation(file, Limits::default()).unwrap();
    let start = GpsTime::from_calendar(&Calendar::new(2005, 4, 2, 0, 10, 0.0).unwrap());
    let frame = EnuFrame::from_ecef([-3_978_241.958, 3_382_840.234, 3_649_900.853]);
    let logs = simulate(
        &GnssModel::default(),
        &Setting {
            frame,
            start,
            duration_s: 300.0,
            rover_m: &flight,
            base_m: [0.0; 3],
            navigation: &navigation,
            seed: 4,
        },
    )
    .unwrap();
    let read = |text: String| {
        read_observations(text.as_bytes(), Limits::default())
            .unwrap()
            .0
    };
    let (rover, base) = (
        read(logs.rover.to_rinex("R")),
        read(logs.base.to_rinex("B")),
    );
    let options = PpkOptions {
        base_position: BasePosition::Header,
        ..PpkOptions::default()
    };
    let solution = acerra_gnss::process(&rover, &base, &navigation, &options).unwrap();
    let mut misses: Vec<f64> = solution
        .epochs
        .iter()
        .filter(|s| s.quality == Quality::Fixed)
        .map(|s| {
            let truth = flight(s.time.seconds_since(start));
            let enu = frame.enu_from_ecef(s.position_ecef_m);
            (enu[0] - truth[0]).hypot(enu[1] - truth[1])
        })
        .collect();
    misses.sort_by(f64::total_cmp);
    println!("{} of {} fixed", misses.len(), solution.epochs.len());
    assert!(2 * misses.len() > solution.epochs.len());
    assert!(
        Misses::quantile(&misses, 0.95) < 0.03,
        "{}",
        Misses::quantile(&misses, 0.95)
    );
}
