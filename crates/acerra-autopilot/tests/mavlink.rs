//! MAVLink telemetry logs of a flight of known truth.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // each test file uses a part of the writers

#[path = "write/flight.rs"]
mod flight;
#[path = "write/mavlink.rs"]
mod mavlink;

use acerra_autopilot::{HeightDatum, LogError, LogFormat, LogOptions, LogReport, read_log, sniff};
use acerra_geo::matrix::distance;
use acerra_geo::trajectory::{SolutionStatus, Trajectory};
use flight::{GEOID_M, attitude_at, euler_rad, geodetic, origin, position_m, start, velocity_m_s};
use mavlink::{
    AUTOPILOT, Gps, Sender, attitude, global, gps_raw, gps2_raw, heartbeat, packet, system_time,
};

/// UTC (µs since 1970) of the flight: 18 s behind GPS time.
fn utc_us(time_s: f64) -> u64 {
    let start_s: i64 = 2390 * 604_800 + 302_400 + 315_964_800 - 18;
    (start_s as f64 * 1e6 + time_s * 1e6).round() as u64
}

/// The autopilot's clock, which tells whole milliseconds here.
fn boot_ms(time_s: f64) -> u32 {
    ((200.0 + time_s) * 1e3).round() as u32
}

/// The ground station's clock is off by an hour.
fn stamp_us(time_s: f64) -> u64 {
    utc_us(time_s + 3600.0)
}

fn above_sea(time_s: f64) -> [f64; 3] {
    let [latitude, longitude, height_m] = geodetic(time_s);
    [latitude, longitude, height_m - GEOID_M]
}

fn receiver(fix_type: u8, time_s: f64) -> Gps {
    Gps {
        time_us: u64::from(boot_ms(time_s)) * 1000,
        fix_type,
        place: above_sea(time_s),
        above_ellipsoid_m: geodetic(time_s)[2],
    }
}

/// A minute: the receiver at 5 Hz, the filter at 10 Hz, attitude at 50 Hz, time at 1 Hz.
fn log(version: u8) -> Vec<u8> {
    let sender = Sender {
        version,
        ..AUTOPILOT
    };
    let gimbal = Sender {
        component: 154,
        ..sender
    };
    let mut out = Vec::new();
    for k in 0..3000_u32 {
        let time_s = 0.02 * f64::from(k);
        let mut send = |sender, (kind, payload): ((u32, u8), Vec<u8>)| {
            out.extend(packet(stamp_us(time_s), sender, kind, &payload));
        };
        if k % 50 == 0 {
            send(sender, heartbeat());
            send(sender, system_time(utc_us(time_s), boot_ms(time_s)));
            send(gimbal, attitude(boot_ms(time_s), [1.0, 1.0, 1.0]));
        }
        send(sender, attitude(boot_ms(time_s), euler_rad(time_s)));
        if k % 5 == 0 {
            send(
                sender,
                global(boot_ms(time_s), above_sea(time_s), velocity_m_s(time_s)),
            );
        }
        if k % 10 == 0 {
            send(sender, gps_raw(&receiver(6, time_s)));
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

fn check(track: &Trajectory, step_s: f64, height_off_m: f64) {
    for (k, fix) in track.fixes().iter().enumerate() {
        let time_s = step_s * k as f64;
        assert!((track.gps_time_at(fix.time_s).unwrap() - start() - time_s).abs() < 1e-4);
        let [e, n, u] = position_m(time_s);
        // Whole 1e-7 degrees and millimetres; heights that are 47 m off move places 125 m away by 1 mm.
        let off = [fix.position_m[0] - e, fix.position_m[1] - n];
        assert!(off[0].abs() < 5.5e-3 && off[1].abs() < 7e-3, "{k}: {off:?}");
        assert!((fix.position_m[2] - u - height_off_m).abs() < 6e-4);
        let off = fix.attitude.unwrap().angle_to(&attitude_at(time_s));
        assert!(off.to_degrees() < 0.01, "{k}: {off}");
    }
}

#[test]
fn positions_times_and_attitudes_are_those_flown() {
    for version in [1, 2] {
        let bytes = log(version);
        assert_eq!(sniff(&bytes), Some(LogFormat::Mavlink));
        let (track, report) = read(&bytes, &at_origin());
        assert_eq!(report.source.name, "GPS_RAW_INT");
        assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
        assert_eq!(track.fixes().len(), 300);
        check(&track, 0.2, 0.0);
        assert_eq!(track.status_counts().fixed(), 300);
        let sigma = track.fixes()[0].standard_deviation_m().unwrap();
        assert!(distance(sigma, [0.014, 0.014, 0.025]) < 1e-6);
        assert!(
            report
                .warnings
                .iter()
                .any(|w| w.to_string().contains("when they arrived"))
        );

        let (track, report) = read(&bytes, &at_origin().with_source("GLOBAL_POSITION_INT"));
        assert_eq!(report.height_datum, Some(HeightDatum::SeaLevel));
        assert_eq!(track.fixes().len(), 600);
        check(&track, 0.1, -GEOID_M);
        for (k, fix) in track.fixes().iter().enumerate() {
            let truth = velocity_m_s(0.1 * k as f64);
            assert!(distance(fix.velocity_m_s.unwrap(), truth) < 0.01);
            assert_eq!(fix.status, SolutionStatus::Float);
        }
    }
}

#[test]
fn receivers_that_tell_utc_need_no_clock_and_two_are_for_choice() {
    let mut bytes = Vec::new();
    for k in 0..30 {
        let time_s = 0.2 * f64::from(k);
        let first = Gps {
            time_us: utc_us(time_s),
            above_ellipsoid_m: 0.0,
            ..receiver(3, time_s)
        };
        let (kind, payload) = gps_raw(&first);
        bytes.extend(packet(stamp_us(time_s), AUTOPILOT, kind, &payload));
        let (kind, payload) = gps2_raw(&receiver(5, time_s));
        bytes.extend(packet(stamp_us(time_s), AUTOPILOT, kind, &payload));
    }
    let error = read_log(&bytes[..], &at_origin()).unwrap_err().to_string();
    assert!(error.ends_with("GPS_RAW_INT, GPS2_RAW"), "{error}");
    let (track, report) = read(&bytes, &at_origin().with_source("GPS_RAW_INT"));
    assert!((track.gps_time_at(track.end_s()).unwrap() - start() - 5.8).abs() < 1e-6);
    assert_eq!(report.height_datum, Some(HeightDatum::SeaLevel));
    assert_eq!(track.status_counts().of(SolutionStatus::Single), 30);
    // The second one counts from the autopilot's start, and nothing ties that to GPS time.
    let error = read_log(&bytes[..], &at_origin().with_source("GPS2_RAW")).unwrap_err();
    assert!(matches!(error, LogError::NoGpsTime { .. }), "{error}");
}

#[test]
fn other_vehicles_are_left_out_and_said() {
    let mut bytes = log(2);
    let other = Sender {
        system: 7,
        ..AUTOPILOT
    };
    let (kind, payload) = gps_raw(&receiver(3, 70.0));
    bytes.extend(packet(stamp_us(60.0), other, kind, &payload));
    let (track, report) = read(&bytes, &at_origin());
    assert_eq!(track.fixes().len(), 300);
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("vehicles 7 were left out"))
    );
}

#[test]
fn cut_off_damaged_and_mixed_logs_are_told() {
    let whole = log(2);
    for cut in [1, 5, 30] {
        let error = read_log(&whole[..whole.len() - cut], &at_origin()).unwrap_err();
        let LogError::CutOff { offset, .. } = error else {
            panic!("{error}");
        };
        assert!(read_log(&whole[..usize::try_from(offset).unwrap()], &at_origin()).is_ok());
    }
    // A flipped bit in a latitude: the packet is passed over.
    let mut flipped = whole.clone();
    let (kind, payload) = gps_raw(&receiver(6, 30.0));
    let target = packet(stamp_us(30.0), AUTOPILOT, kind, &payload);
    let at = whole
        .windows(target.len())
        .position(|w| w == target)
        .unwrap();
    flipped[at + 8 + 10 + 9] ^= 0x40;
    let (track, report) = read(&flipped, &at_origin());
    assert_eq!(track.fixes().len(), 299);
    let says = format!("1 places belong to no record and were passed over, the first at byte {at}");
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains(&says)),
        "{:?}",
        report.warnings
    );
    let mut mixed = whole.clone();
    mixed.extend([0x17; 20_000]);
    let error = read_log(&mixed[..], &at_origin()).unwrap_err();
    assert!(matches!(error, LogError::Damaged { .. }), "{error}");
}

#[test]
fn stray_bytes_do_not_hide_what_the_log_is_and_are_counted() {
    let whole = log(2);
    let mut stray = b"boot\r\n".to_vec();
    stray.extend(&whole);
    let places = [0, 400, 1500, 30_000, 61_000];
    for at in places.into_iter().rev() {
        stray.splice(6 + at..6 + at, *b"\xfe\xfd~");
    }
    assert_eq!(sniff(&stray), Some(LogFormat::Mavlink));
    let (track, report) = read(&stray, &at_origin());
    assert!(track.fixes().len() >= 300 - places.len());
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("belong to no record"))
    );
    // Text that holds one packet is no log of them.
    let mut text = b"a line of text\n".repeat(40);
    text.extend(&whole[..300]);
    assert_eq!(sniff(&text), None);
}
