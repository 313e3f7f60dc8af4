//! RINEX and UBX: the same seed, the same bytes; read back as written, by us and by RTKLIB.

use super::*;
use acerra_gnss::input::Limits;
use acerra_gnss::{read_navigation, read_observations};
use std::process::Command;

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
