//! Real UBX logs against what RTKLIB's convbin made of them, field by field.

use crate::common;

use acerra_geo::time::GpsTime;
use acerra_gnss::input::{DropReason, FileKind, Limits};
use acerra_gnss::{Ephemeris, KeplerEphemeris, ObservationData, read_gnss, read_navigation};

/// Walks two logs of the same receiver in step. Counts values compared, slips that the second
/// has, slips that only the first has, and unresolved half cycles.
fn compare(ubx: &ObservationData, rinex: &ObservationData) -> [usize; 4] {
    let mut seen = std::collections::HashSet::new();
    let (mut values, mut slips, mut extra_slips, mut halves) = (0, 0, 0, 0);
    let mut before = GpsTime::EPOCH;
    for r in &rinex.epochs {
        let u = ubx.epochs.iter().find(|u| (u.time - r.time).abs() < 6e-8);
        let u = u.unwrap_or_else(|| panic!("no epoch at {}", r.time));
        let names = |e: &acerra_gnss::ObservationEpoch| -> Vec<_> {
            e.satellites.iter().map(|s| s.satellite).collect()
        };
        assert_eq!(names(u), names(r), "{}", u.time);
        for (us, rs) in u.satellites.iter().zip(&r.satellites) {
            let (a, b) = (us.signals[0].unwrap(), rs.signals[0].unwrap());
            assert_eq!(a.code, b.code);
            for (x, y) in [
                (a.pseudorange_m, b.pseudorange_m),
                (a.phase_cycles, b.phase_cycles),
                (a.doppler_hz, b.doppler_hz),
                (a.cn0_db_hz, b.cn0_db_hz),
            ] {
                let at = || format!("{} {}: {a:?} {b:?}", u.time, us.satellite);
                match (x, y) {
                    (Some(x), Some(y)) => assert!((x - y).abs() < 6e-4, "{}", at()),
                    // A Doppler below half a millihertz prints as zero.
                    (Some(x), None) => assert!(x.abs() < 6e-4, "{}", at()),
                    (x, y) => assert_eq!(x, y, "{}", at()),
                }
                values += usize::from(x.is_some());
            }
            if a.phase_cycles.is_some() {
                let (x, y) = (a.loss_of_lock, b.loss_of_lock);
                assert_eq!(x.half_cycle_unknown(), y.half_cycle_unknown());
                halves += usize::from(x.half_cycle_unknown());
                slips += usize::from(y.slipped());
                // Every slip RTKLIB sees is seen, but for a signal's first epoch, which has none;
                // more may be.
                // RTKLIB loses whole frames behind a damaged one: a slip may have shown in
                // an epoch it did not see.
                let slipped = ubx
                    .epochs
                    .iter()
                    .filter(|e| e.time > before && e.time <= u.time)
                    .flat_map(|e| &e.satellites)
                    .filter(|s| s.satellite == us.satellite)
                    .any(|s| s.signals[0].is_some_and(|s| s.loss_of_lock.slipped()));
                let first = seen.insert(us.satellite);
                assert!(
                    first || slipped || !y.slipped(),
                    "{} {} {a:?} {b:?}",
                    u.time,
                    us.satellite
                );
                extra_slips += usize::from(x.slipped() && !y.slipped());
            }
        }
        before = u.time;
    }
    [values, slips, extra_slips, halves]
}

#[test]
fn measurements_are_those_of_the_converted_file() {
    for (name, epochs, expected) in [
        ("rover", 2072, [164_007, 1343, 92, 2546]),
        // RTKLIB drops the frames behind a damaged one: it has 452 of these epochs.
        ("base", 529, [40_209, 223, 19, 103]),
    ] {
        let Some(file) = common::open(&format!("gnss-walk-m8p/{name}.ubx.gz")) else {
            return;
        };
        let Some(rinex) = common::open(&format!("gnss-walk-m8p/{name}.obs")) else {
            return;
        };
        let ubx = read_gnss(file, Limits::default()).unwrap();
        assert_eq!(ubx.kind, FileKind::Ubx);
        let ubx = ubx.observations.unwrap();
        let rinex = read_gnss(rinex, Limits::default())
            .unwrap()
            .observations
            .unwrap();
        assert_eq!(ubx.epochs.len(), epochs, "{name}");
        assert_eq!(compare(&ubx, &rinex), expected, "{name}");
        assert_eq!(ubx.glonass_channels, rinex.glonass_channels);
    }
}

/// Equal to the twelve digits that RINEX prints.
fn close(what: &str, pairs: &[(f64, f64)]) {
    for (i, (x, y)) in pairs.iter().enumerate() {
        assert!(
            (x - y).abs() <= 6e-12 * y.abs(),
            "{what} [{i}]: {x:e} {y:e}"
        );
    }
}

#[test]
fn ephemerides_are_those_of_the_converted_file() {
    for (name, count) in [("rover", 33), ("base", 42)] {
        let Some(file) = common::open(&format!("gnss-walk-m8p/{name}.ubx.gz")) else {
            return;
        };
        let Some(nav) = common::open(&format!("gnss-walk-m8p/{name}.nav")) else {
            return;
        };
        let (ubx, report) = read_navigation(file, Limits::default()).unwrap();
        let (nav, _) = read_navigation(nav, Limits::default()).unwrap();
        assert_eq!(
            report.count(&DropReason::InvalidNavigationFrame),
            0,
            "{report}"
        );
        assert_eq!(
            (ubx.ephemerides.len(), nav.ephemerides.len()),
            (count, count),
            "{name}"
        );
        let (a, b) = (ubx.klobuchar.unwrap(), nav.klobuchar.unwrap());
        for (x, y) in a.alpha.iter().zip(b.alpha).chain(a.beta.iter().zip(b.beta)) {
            assert!((x - y).abs() <= 5e-4 * y.abs(), "{a:?} {b:?}");
        }
        for expected in &nav.ephemerides {
            let what = format!("{} {}", expected.satellite(), expected.toe());
            let found = ubx
                .ephemerides
                .iter()
                .find(|u| u.satellite() == expected.satellite() && u.toe() == expected.toe());
            match (found, expected) {
                (Some(Ephemeris::Kepler(u)), Ephemeris::Kepler(e)) => {
                    same_orbit(&what, u, e);
                    close(
                        &what,
                        &[
                            (u.clock[0], e.clock[0]),
                            (u.clock[1], e.clock[1]),
                            (u.clock[2], e.clock[2]),
                            (u.group_delay_s[0], e.group_delay_s[0]),
                            (u.accuracy_m, e.accuracy_m),
                        ],
                    );
                    assert_eq!((u.iode, u.iodc, u.health), (e.iode, e.iodc, e.health));
                    assert_eq!((u.toc, u.data_source), (e.toc, e.data_source));
                    // RTKLIB notes the start of the subframe after, of some repetition.
                    let later_s = e.transmission_time - u.transmission_time;
                    assert!(
                        later_s.abs() < 3600.0 && (later_s - 6.0) % 30.0 == 0.0,
                        "{what} {later_s}"
                    );
                }
                (Some(Ephemeris::Glonass(u)), Ephemeris::Glonass(e)) => {
                    let pairs = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| (a[i], b[i]));
                    close(&what, &pairs(u.position_ecef_m, e.position_ecef_m));
                    close(&what, &pairs(u.velocity_ecef_m_s, e.velocity_ecef_m_s));
                    close(
                        &what,
                        &pairs(u.acceleration_ecef_m_s2, e.acceleration_ecef_m_s2),
                    );
                    close(
                        &what,
                        &[
                            (u.clock_offset_s, e.clock_offset_s),
                            (u.clock_rate, e.clock_rate),
                        ],
                    );
                    // Another frame of the same half hour, where frames were lost.
                    let later_s = e.transmission_time - u.transmission_time;
                    assert!(
                        later_s.abs() < 1800.0 && later_s % 30.0 == 0.0,
                        "{what} {later_s}"
                    );
                    assert_eq!(
                        (u.channel, u.health, u.age_days),
                        (e.channel, e.health, e.age_days)
                    );
                }
                other => panic!("{what}: {other:?}"),
            }
        }
    }
}

fn same_orbit(what: &str, u: &KeplerEphemeris, e: &KeplerEphemeris) {
    close(
        what,
        &[
            (u.sqrt_semi_major_axis, e.sqrt_semi_major_axis),
            (u.eccentricity, e.eccentricity),
            (u.inclination_rad, e.inclination_rad),
            (u.ascending_node_rad, e.ascending_node_rad),
            (u.perigee_rad, e.perigee_rad),
            (u.mean_anomaly_rad, e.mean_anomaly_rad),
            (
                u.mean_motion_correction_rad_s,
                e.mean_motion_correction_rad_s,
            ),
            (u.ascending_node_rate_rad_s, e.ascending_node_rate_rad_s),
            (u.inclination_rate_rad_s, e.inclination_rate_rad_s),
            (u.latitude_correction_rad[0], e.latitude_correction_rad[0]),
            (u.latitude_correction_rad[1], e.latitude_correction_rad[1]),
            (u.radius_correction_m[0], e.radius_correction_m[0]),
            (u.radius_correction_m[1], e.radius_correction_m[1]),
            (
                u.inclination_correction_rad[0],
                e.inclination_correction_rad[0],
            ),
            (
                u.inclination_correction_rad[1],
                e.inclination_correction_rad[1],
            ),
            (u.toe_seconds_of_week, e.toe_seconds_of_week),
        ],
    );
}
