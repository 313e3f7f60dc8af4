//! ArduPilot logs of a flight of known truth.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // each test file uses a part of the writers

#[path = "write/ardupilot.rs"]
mod ardupilot;
#[path = "write/flight.rs"]
mod flight;

use std::sync::Arc;

use acerra_autopilot::{
    HeightDatum, LogError, LogFormat, LogOptions, LogReport, LogWarning, read_log, sniff,
};
use acerra_geo::geoid::GeoidGrid;
use acerra_geo::matrix::distance;
use acerra_geo::trajectory::{SolutionStatus, Trajectory};
use ardupilot::{Gps, att, gpa, gps, head, msg, pos};
use flight::{
    GEOID_M, attitude_at, boot_s, euler_rad, geodetic, origin, position_m, start, velocity_m_s,
};

/// Messages of the receiver arrive so long after the instant they are about (s), at least.
const LATENCY_S: f64 = 0.11;

fn receiver(instance: u8, status: u8, time_s: f64) -> Gps {
    let [latitude, longitude, height_m] = geodetic(time_s);
    Gps {
        instance,
        status,
        week: 2390,
        week_ms: 302_400_000 + (time_s * 1e3).round() as u32,
        place: [latitude, longitude, height_m - GEOID_M],
        velocity_m_s: velocity_m_s(time_s),
    }
}

/// A minute: the receiver at 5 Hz with RTK, attitude at 50 Hz, the filter at 10 Hz.
fn log() -> Vec<u8> {
    let mut out = head();
    out.extend(msg(1.0, "ArduCopter V4.5.1"));
    out.extend(gps(
        3.0,
        &Gps {
            status: 1,
            week: 0,
            week_ms: 0,
            place: [0.0; 3],
            ..receiver(0, 1, 0.0)
        },
    ));
    for k in 0..3000_u32 {
        let time_s = 0.02 * f64::from(k);
        out.extend(att(boot_s(time_s), euler_rad(time_s)));
        if k % 5 == 0 {
            let [latitude, longitude, height_m] = geodetic(time_s);
            out.extend(pos(
                boot_s(time_s),
                [latitude, longitude, height_m - GEOID_M],
            ));
        }
        if k % 10 == 0 {
            let arrival_s = boot_s(time_s + LATENCY_S) + 0.02 * f64::from(k % 7);
            out.extend(gps(arrival_s, &receiver(0, 6, time_s)));
            out.extend(gpa(arrival_s, 0, [0.02, 0.03], -GEOID_M));
        }
    }
    out
}

fn read(bytes: &[u8], options: &LogOptions) -> (Trajectory, LogReport) {
    read_log(bytes, options).unwrap()
}

fn at_origin() -> LogOptions {
    LogOptions::default().with_origin(origin())
}

#[test]
fn positions_times_and_attitudes_are_those_flown() {
    let bytes = log();
    assert_eq!(sniff(&bytes), Some(LogFormat::ArduPilot));
    let (track, report) = read(&bytes, &at_origin());
    assert_eq!(report.source.name, "GPS[0]");
    assert_eq!(
        report.sources_used(),
        "positions of GPS[0], attitude of ATT"
    );
    assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
    assert_eq!(track.fixes().len(), 300);
    for (k, fix) in track.fixes().iter().enumerate() {
        let time_s = 0.2 * k as f64;
        assert!((track.gps_time_at(fix.time_s).unwrap() - start() - time_s).abs() < 1e-4);
        // 1e-7 degrees are 11 mm, a centimetre of height: half of each at most is lost.
        let truth = position_m(time_s);
        assert!((fix.position_m[0] - truth[0]).abs() < 0.0046, "{fix:?}");
        assert!((fix.position_m[1] - truth[1]).abs() < 0.0060, "{fix:?}");
        assert!((fix.position_m[2] - truth[2]).abs() < 0.0055, "{fix:?}");
        assert!(distance(fix.velocity_m_s.unwrap(), velocity_m_s(time_s)) < 1e-3);
        assert_eq!(fix.status, SolutionStatus::Fixed);
        assert_eq!(fix.satellites, Some(21));
        let sigma = fix.standard_deviation_m().unwrap();
        assert!(distance(sigma, [0.02, 0.02, 0.03]) < 1e-6);
    }
    // Attitudes are late by the receiver's latency, which the log does not tell.
    for (k, fix) in track.fixes().iter().enumerate().take(295) {
        let expected = attitude_at(0.2 * k as f64 + LATENCY_S);
        let off_deg = fix.attitude.unwrap().angle_to(&expected).to_degrees();
        assert!(off_deg < 0.02, "{k}: {off_deg}");
    }
    let says = |text: &str| report.warnings.iter().any(|w| w.to_string().contains(text));
    assert!(
        says("latency") && says("1 records of GPS[0] without a fix"),
        "{:?}",
        report.warnings
    );
    assert!(!says("above the sea") && !says("fixed by carrier phase"));
}

#[test]
fn the_filter_is_taken_when_asked_for_and_its_heights_and_times_are_warned_of() {
    let (track, report) = read(&log(), &at_origin().with_source("ekf"));
    assert_eq!(
        (report.source.name.as_str(), track.fixes().len()),
        ("POS", 600)
    );
    assert_eq!(report.height_datum, Some(HeightDatum::SeaLevel));
    let clock = report.clock.unwrap();
    assert_eq!((clock.readings, clock.left_out), (300, 0));
    for (k, fix) in track.fixes().iter().enumerate() {
        let time_s = 0.1 * k as f64;
        // Behind by the least latency, but for a few µs of rounding and rate.
        let off_s = track.gps_time_at(fix.time_s).unwrap() - start() - time_s;
        assert!((off_s + LATENCY_S).abs() < 1e-3, "{off_s}");
        assert!((fix.position_m[2] + GEOID_M - position_m(time_s)[2]).abs() < 1e-3);
        assert_eq!(fix.status, SolutionStatus::Float);
        // Attitudes have the same clock.
        assert!(
            fix.attitude
                .unwrap()
                .angle_to(&attitude_at(time_s))
                .to_degrees()
                < 0.01
        );
    }
    let says = |text: &str| report.warnings.iter().any(|w| w.to_string().contains(text));
    assert!(says("above the sea") && says("of the positions are the autopilot's"));
}

/// A grid of the geoid (VDatum, `.gtx`): so high everywhere between these latitudes and longitudes.
fn geoid([south, west, north, east]: [f64; 4], height_m: f64) -> GeoidGrid {
    let mut out = Vec::new();
    for value in [south, west, 1.0, 1.0] {
        out.extend(value.to_be_bytes());
    }
    let (rows, columns) = ((north - south) as i32 + 1, (east - west) as i32 + 1);
    out.extend(rows.to_be_bytes());
    out.extend(columns.to_be_bytes());
    for _ in 0..rows * columns {
        out.extend((height_m as f32).to_be_bytes());
    }
    GeoidGrid::from_reader(&out[..]).unwrap()
}

#[test]
fn a_grid_of_the_geoid_raises_heights_above_the_sea_and_must_cover_them() {
    let here = Arc::new(geoid([39.0, 12.0, 43.0, 16.0], GEOID_M));
    let options = at_origin().with_source("ekf").with_geoid(here);
    let (track, report) = read(&log(), &options);
    assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
    for (k, fix) in track.fixes().iter().enumerate() {
        assert!((fix.position_m[2] - position_m(0.1 * k as f64)[2]).abs() < 1e-3);
    }
    let says = |text: &str| report.warnings.iter().any(|w| w.to_string().contains(text));
    assert!(says("47.25 m at the first position") && !says("used as heights above the ellipsoid"));
    // Heights that the log itself has above the ellipsoid stay.
    let elsewhere = Arc::new(geoid([0.0, 0.0, 3.0, 3.0], 20.0));
    let (track, _) = read(&log(), &at_origin().with_geoid(elsewhere.clone()));
    assert!((track.fixes()[0].position_m[2] - position_m(0.0)[2]).abs() < 0.0055);
    let error = read_log(&log()[..], &options.with_geoid(elsewhere)).unwrap_err();
    assert!(error.to_string().contains("does not cover 41.1"), "{error}");
}

#[test]
fn two_receivers_are_listed_and_one_is_named() {
    let mut bytes = head();
    for k in 0..20_u32 {
        let time_s = 0.2 * f64::from(k);
        bytes.extend(gps(boot_s(time_s), &receiver(0, 3, time_s)));
        bytes.extend(gps(boot_s(time_s) + 0.001, &receiver(1, 6, time_s + 0.1)));
    }
    let error = read_log(&bytes[..], &at_origin()).unwrap_err().to_string();
    assert_eq!(
        error,
        "several sources of positions, choose one by source: GPS[0], GPS[1]"
    );
    let (track, _) = read(&bytes, &at_origin().with_source("GPS[1]"));
    assert_eq!(track.status_counts().fixed(), 20);
    assert!((track.gps_time_at(track.start_s()).unwrap() - start() - 0.1).abs() < 1e-9);
    let (track, report) = read(&bytes, &at_origin().with_source("GPS[0]"));
    assert_eq!(track.status_counts().fixed(), 0);
    let says = |text: &str| report.warnings.iter().any(|w| w.to_string().contains(text));
    assert!(says("of 20 positions only 0 are fixed") && says("no attitude"));
    let error = read_log(&bytes[..], &at_origin().with_source("GPS[2]")).unwrap_err();
    assert!(matches!(error, LogError::NoSuchSource { names, .. } if names.len() == 2));
}

#[test]
fn without_gps_time_the_filter_has_no_time_and_nothing_has_a_position() {
    let mut bytes = head();
    for k in 0..20_u32 {
        let time_s = 0.2 * f64::from(k);
        bytes.extend(pos(boot_s(time_s), geodetic(time_s)));
        bytes.extend(gps(
            boot_s(time_s),
            &Gps {
                status: 1,
                ..receiver(0, 1, time_s)
            },
        ));
    }
    let error = read_log(&bytes[..], &at_origin()).unwrap_err();
    assert!(matches!(error, LogError::NoGpsTime { .. }), "{error}");
    let error = read_log(&bytes[..], &at_origin().with_source("gnss")).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("GPS[0] (20 records without a fix)"),
        "{error}"
    );
}

#[test]
fn a_log_that_ends_within_a_record_is_refused_with_the_place() {
    let whole = log();
    for cut in [1, 2, 20] {
        let bytes = &whole[..whole.len() - cut];
        let error = read_log(bytes, &at_origin()).unwrap_err();
        let LogError::CutOff { offset, .. } = error else {
            panic!("{error}");
        };
        // What comes before is whole.
        let kept = &whole[..usize::try_from(offset).unwrap()];
        assert!(read_log(kept, &at_origin()).is_ok());
    }
    let mut begun = whole.clone();
    begun.extend([0xa3, 0x95]);
    let error = read_log(&begun[..], &at_origin()).unwrap_err();
    assert!(matches!(error, LogError::CutOff { offset, .. } if offset == whole.len() as u64));
    // Memory that was never written is no record.
    let mut padded = whole.clone();
    padded.extend([0xff; 4096]);
    let (_, report) = read(&padded, &at_origin());
    assert!(
        !report
            .warnings
            .iter()
            .any(|w| matches!(w, LogWarning::Damaged(_)))
    );
}

#[test]
fn damage_is_counted_and_other_files_are_refused() {
    let whole = log();
    let mut damaged = whole.clone();
    let at = head().len() + 5000;
    damaged[at..at + 1000].fill(0x5a);
    let (track, report) = read(&damaged, &at_origin());
    assert!(
        (296..300).contains(&track.fixes().len()),
        "{}",
        track.fixes().len()
    );
    let found = report.warnings.iter().find_map(|w| match w {
        LogWarning::Damaged(damage) => Some(*damage),
        _ => None,
    });
    let found = found.unwrap();
    assert!(
        (at as u64).abs_diff(found.first_offset) < 100 && found.bytes >= 900,
        "{found:?}"
    );

    let mut mixed = whole.clone();
    mixed.extend(
        std::iter::repeat_n(
            &b"$GNGGA,123519.00,4807.038,N,01131.000,E,4*72\r\n"[..],
            4000,
        )
        .flatten(),
    );
    let error = read_log(&mixed[..], &at_origin()).unwrap_err();
    assert!(
        matches!(error, LogError::Damaged { offset, .. } if offset == whole.len() as u64),
        "{error}"
    );
    assert!(matches!(
        read_log(&b""[..], &at_origin()),
        Err(LogError::Empty)
    ));
    let text = read_log(&b"time_s,x_m\n"[..], &at_origin())
        .unwrap_err()
        .to_string();
    assert!(text.contains("74 69 6d 65"), "{text}");
    // A definition shorter than its own mark.
    let mut hostile = head();
    hostile.extend(ardupilot::fmt(200, "BAD", "Q", "TimeUS"));
    let length = hostile.len() - 89 + 4;
    hostile[length] = 2;
    let error = read_log(&hostile[..], &at_origin()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("fields of 11 bytes and a length of 2"),
        "{error}"
    );
}
