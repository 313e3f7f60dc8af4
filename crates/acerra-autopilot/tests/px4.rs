//! PX4 logs of a flight of known truth.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // each test file uses a part of the writers

#[path = "write/flight.rs"]
mod flight;
#[path = "write/px4.rs"]
mod px4;

use acerra_autopilot::{
    HeightDatum, LogError, LogFormat, LogOptions, LogReport, LogWarning, read_log, sniff,
};
use acerra_geo::matrix::distance;
use acerra_geo::trajectory::{SolutionStatus, Trajectory};
use flight::{
    GEOID_M, attitude_at, boot_s, euler_rad, geodetic, origin, position_m, start, velocity_m_s,
};
use px4::{Gps, attitude, format, global, head, message, new_gps, old_gps, subscribe};

const LATENCY_S: f64 = 0.12;

fn boot_us(time_s: f64) -> u64 {
    (boot_s(time_s) * 1e6).round() as u64
}

/// UTC (µs since 1970) of the flight: week 2390 is of 2025, 18 s behind GPS time.
fn utc_us(time_s: f64) -> u64 {
    let gps_s = 2390 * 604_800 + 302_400 + 315_964_800 - 18;
    (gps_s as f64 * 1e6 + time_s * 1e6).round() as u64
}

fn receiver(fix_type: u8, time_s: f64) -> Gps {
    Gps {
        boot_us: boot_us(time_s + LATENCY_S),
        utc_us: utc_us(time_s),
        fix_type,
        place: geodetic(time_s),
        geoid_m: GEOID_M,
        velocity_m_s: velocity_m_s(time_s),
    }
}

fn definitions() -> Vec<u8> {
    let mut out = head(0);
    out.extend(message(b'I', b"\x0dchar[3] sys_nPX4"));
    for text in [px4::OLD_GPS, px4::NEW_GPS, px4::ATTITUDE, px4::GLOBAL] {
        out.extend(format(text));
    }
    out
}

/// A minute: the receiver at 5 Hz, attitude at 50 Hz, the filter at 10 Hz.
fn log(is_old: bool) -> Vec<u8> {
    let mut out = definitions();
    let topic = if is_old {
        "vehicle_gps_position"
    } else {
        "sensor_gps"
    };
    out.extend(subscribe(3, 0, topic));
    out.extend(subscribe(4, 0, "vehicle_attitude"));
    out.extend(subscribe(5, 0, "vehicle_global_position"));
    for k in 0..3000_u32 {
        let time_s = 0.02 * f64::from(k);
        out.extend(attitude(4, boot_us(time_s), euler_rad(time_s)));
        if k % 5 == 0 {
            out.extend(global(5, boot_us(time_s), geodetic(time_s), GEOID_M));
        }
        if k % 10 == 0 {
            let gps = receiver(6, time_s);
            out.extend(if is_old {
                old_gps(3, &gps)
            } else {
                new_gps(3, &gps)
            });
        }
        if k % 50 == 0 {
            out.extend([8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]);
        }
    }
    out
}

fn at_origin() -> LogOptions {
    LogOptions::default().with_origin(origin())
}

fn read(bytes: &[u8], options: &LogOptions) -> (Trajectory, LogReport) {
    read_log(bytes, options).unwrap()
}

#[test]
fn positions_times_and_attitudes_are_those_flown() {
    // Whole 1e-7 degrees and millimetres before version 1.14, double precision since.
    for (is_old, across_m, up_m) in [(true, 6e-3, 6e-4), (false, 1e-6, 1e-6)] {
        let bytes = log(is_old);
        assert_eq!(sniff(&bytes), Some(LogFormat::Px4));
        let (track, report) = read(&bytes, &at_origin());
        assert_eq!(track.fixes().len(), 300);
        assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
        assert_eq!(
            report.attitude_source.as_deref(),
            Some("vehicle_attitude[0]")
        );
        for (k, fix) in track.fixes().iter().enumerate() {
            let time_s = 0.2 * k as f64;
            assert!((track.gps_time_at(fix.time_s).unwrap() - start() - time_s).abs() < 1e-6);
            let truth = position_m(time_s);
            assert!((fix.position_m[0] - truth[0]).abs() < across_m);
            assert!((fix.position_m[1] - truth[1]).abs() < across_m);
            assert!((fix.position_m[2] - truth[2]).abs() < up_m);
            assert!(distance(fix.velocity_m_s.unwrap(), velocity_m_s(time_s)) < 1e-3);
            assert_eq!(fix.status, SolutionStatus::Fixed);
            let sigma = fix.standard_deviation_m().unwrap();
            assert!(distance(sigma, [0.012, 0.012, 0.02]) < 1e-6);
        }
        for (k, fix) in track.fixes().iter().enumerate().take(295) {
            let expected = attitude_at(0.2 * k as f64 + LATENCY_S);
            assert!(fix.attitude.unwrap().angle_to(&expected).to_degrees() < 0.01);
        }
    }
}

#[test]
fn the_filter_has_ellipsoidal_heights_and_sampling_times() {
    let (track, report) = read(&log(false), &at_origin().with_source("ekf"));
    assert_eq!(report.source.name, "vehicle_global_position[0]");
    assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
    for (k, fix) in track.fixes().iter().enumerate() {
        let time_s = 0.1 * k as f64;
        let off_s = track.gps_time_at(fix.time_s).unwrap() - start() - time_s;
        assert!((off_s + LATENCY_S).abs() < 1e-4, "{off_s}");
        assert!(distance(fix.position_m, position_m(time_s)) < 1e-4);
        assert_eq!(fix.status, SolutionStatus::Float);
        assert!(
            fix.attitude
                .unwrap()
                .angle_to(&attitude_at(time_s))
                .to_degrees()
                < 0.01
        );
    }
}

#[test]
fn what_the_autopilot_uses_goes_before_its_receivers_and_those_are_for_choice() {
    let mut bytes = definitions();
    bytes.extend(subscribe(1, 0, "sensor_gps"));
    bytes.extend(subscribe(2, 1, "sensor_gps"));
    for k in 0..20 {
        bytes.extend(new_gps(1, &receiver(3, 0.2 * f64::from(k))));
        bytes.extend(new_gps(2, &receiver(6, 0.2 * f64::from(k))));
    }
    let error = read_log(&bytes[..], &at_origin()).unwrap_err().to_string();
    assert!(error.ends_with("sensor_gps[0], sensor_gps[1]"), "{error}");
    let (track, _) = read(&bytes, &at_origin().with_source("sensor_gps[1]"));
    assert_eq!(track.status_counts().fixed(), 20);
    bytes.extend(subscribe(9, 0, "vehicle_gps_position"));
    for k in 0..20 {
        bytes.extend(old_gps(9, &receiver(5, 4.0 + 0.2 * f64::from(k))));
    }
    let (track, report) = read(&bytes, &at_origin());
    assert_eq!(report.source.name, "vehicle_gps_position[0]");
    assert_eq!(track.status_counts().of(SolutionStatus::Float), 20);
}

#[test]
fn a_wrong_date_before_the_leap_seconds_are_known_is_left_out_of_the_clock() {
    let mut bytes = definitions();
    bytes.extend(subscribe(1, 0, "sensor_gps"));
    bytes.extend(subscribe(5, 0, "vehicle_global_position"));
    for k in 0..100 {
        let time_s = 0.2 * f64::from(k);
        let mut gps = receiver(3, time_s);
        if k < 10 {
            gps.utc_us -= 2_000_000;
        }
        bytes.extend(new_gps(1, &gps));
        bytes.extend(global(5, boot_us(time_s), geodetic(time_s), GEOID_M));
    }
    let (track, report) = read(&bytes, &at_origin().with_source("ekf"));
    assert_eq!(report.clock.unwrap().left_out, 10);
    let off_s = track.gps_time_at(track.start_s()).unwrap() - start();
    assert!((off_s + LATENCY_S).abs() < 1e-3, "{off_s}");
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("leap seconds"))
    );
    // The receiver's own positions of those two seconds are left out as well.
    let (track, report) = read(&bytes, &at_origin());
    assert_eq!(track.fixes().len(), 90);
    assert!((track.gps_time_at(track.start_s()).unwrap() - start() - 2.0).abs() < 1e-6);
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("10 positions have another time"))
    );
    let mut bytes = definitions();
    bytes.extend(subscribe(5, 0, "vehicle_global_position"));
    bytes.extend(global(5, boot_us(0.0), geodetic(0.0), GEOID_M));
    assert!(matches!(
        read_log(&bytes[..], &at_origin()),
        Err(LogError::NoGpsTime { .. })
    ));
}

#[test]
fn what_was_appended_after_a_crash_is_read_and_cut_off_damaged_and_unknown_logs_are_told() {
    let whole = log(false);
    // A log that is cut off is read up to the message it ends within, and the rest of it is counted.
    let told = |cut: usize| {
        let (track, report) = read(&whole[..whole.len() - cut], &at_origin());
        let told: Vec<String> = report.warnings.iter().map(ToString::to_string).collect();
        (track.fixes().len(), told.join("\n"))
    };
    let (fixes, said) = told(0);
    assert!(
        fixes == 300 && !said.contains("belong to no record"),
        "{fixes}: {said}"
    );
    for cut in [1, 4, 100, 5000] {
        let (fixes, said) = told(cut);
        assert!((290..=300).contains(&fixes), "{cut}: {fixes}");
        assert!(said.contains("belong to no record"), "{cut}: {said}");
    }

    // The crash cut the last message; what was appended goes on.
    let cut = &whole[..whole.len() - 4];
    let mut appended = cut.to_vec();
    appended[16 + 3 + 8] = 1;
    appended[16 + 3 + 16..16 + 3 + 24].copy_from_slice(&(cut.len() as u64).to_le_bytes());
    appended.extend(message(b'L', b"6\0\0\0\0\0\0\0\0crash dump"));
    let (track, _) = read(&appended, &at_origin());
    assert_eq!(track.fixes().len(), 300);

    let mut unknown = whole.clone();
    unknown[16 + 3 + 8] = 2;
    let error = read_log(&unknown[..], &at_origin()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("byte 16: expected a log without flags"),
        "{error}"
    );
    let mut damaged = whole.clone();
    damaged[50_000..50_900].fill(0);
    let (track, report) = read(&damaged, &at_origin());
    // 730 bytes hold a position.
    assert!((297..300).contains(&track.fixes().len()));
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("belong to no record"))
    );
    let mut mixed = whole[..5000].to_vec();
    mixed.extend([0; 5000]);
    mixed.extend(b"x");
    assert!(matches!(
        read_log(&mixed[..], &at_origin()),
        Err(LogError::Damaged { .. })
    ));
}

/// The bytes passed over, and the positions that are left, each checked against the truth.
fn recovered(damaged: &[u8]) -> (u64, usize) {
    let (track, report) = read(damaged, &at_origin());
    for fix in track.fixes() {
        let time_s = track.gps_time_at(fix.time_s).unwrap() - start();
        assert!(distance(fix.position_m, position_m(time_s)) < 1e-6);
    }
    let lost = report.warnings.iter().find_map(|w| match w {
        LogWarning::Damaged(damage) => Some(damage.bytes),
        _ => None,
    });
    (lost.unwrap_or(0), track.fixes().len())
}

#[test]
fn damage_costs_the_messages_it_lies_in_without_marks_of_synchronisation() {
    let mut whole = log(false);
    let mark = [8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
    let places: Vec<usize> = (0..whole.len() - 10)
        .filter(|k| whole[*k..].starts_with(&mark))
        .collect();
    for at in places.into_iter().rev() {
        whole.drain(at..at + mark.len());
    }
    assert_eq!(recovered(&whole), (0, 300));
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    // Zeros, random bytes, bytes lost and bytes too many, at ten places each: a message or two on either side of 60
    // bytes are lost, at most one position in a place.
    for kind in 0..4 {
        let mut damaged = whole.clone();
        for place in (1..=10).rev() {
            let at = place * whole.len() / 11 + 17 * place;
            match kind {
                0 => damaged[at..at + 60].fill(0),
                1 => damaged[at..at + 60].fill_with(&mut random),
                2 => drop(damaged.drain(at..at + 60)),
                _ => drop(damaged.splice(at..at, (0..60).map(|_| random()))),
            }
        }
        let (lost, fixes) = recovered(&damaged);
        assert!((200..4000).contains(&lost), "kind {kind}: {lost} bytes");
        assert!(fixes >= 290, "kind {kind}: {fixes} positions");
    }
}
