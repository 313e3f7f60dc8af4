//! MCAP files of a flight of known truth.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // each test file uses a part of the writers

#[path = "write/flight.rs"]
mod flight;
#[path = "write/ros.rs"]
mod ros;

use acerra_autopilot::{HeightDatum, LogError, LogFormat, LogOptions, LogReport, read_log, sniff};
use acerra_geo::matrix::distance;
use acerra_geo::trajectory::{Frame, SolutionStatus, TimeOrigin, Trajectory};
use flight::{attitude_at, geodetic, origin, position_m, start};
use ros::{Stamp, chunk, end, fix, head, imu, message, odometry, record, topic};

const FIX: &str = "sensor_msgs/msg/NavSatFix";
const IMU: &str = "sensor_msgs/msg/Imu";
const ODOMETRY: &str = "nav_msgs/msg/Odometry";

/// UTC of the flight since 1970: 18 s behind GPS time.
fn stamp(time_s: f64) -> Stamp {
    let start_s = 2390 * 604_800 + 302_400 + 315_964_800 - 18;
    let whole = time_s.floor();
    (
        start_s + whole as i32,
        ((time_s - whole) * 1e9).round() as u32,
    )
}

fn xyzw(time_s: f64) -> [f64; 4] {
    let [w, x, y, z] = attitude_at(time_s).quaternion();
    [x, y, z, w]
}

/// A minute: fixes at 5 Hz, odometry at 10 Hz, attitude at 50 Hz.
fn records() -> Vec<u8> {
    let mut out = topic(1, "/fix", FIX, "cdr");
    out.extend(topic(2, "/imu/data", IMU, "cdr"));
    out.extend(topic(3, "/odom", ODOMETRY, "cdr"));
    out.extend(topic(4, "/rosout", "rcl_interfaces/msg/Log", "cdr"));
    for k in 0..3000_u32 {
        let time_s = 0.02 * f64::from(k);
        out.extend(message(2, &imu(stamp(time_s), xyzw(time_s), 0.1)));
        out.extend(message(4, b"anything"));
        if k % 5 == 0 {
            let at = odometry(stamp(time_s), position_m(time_s), xyzw(time_s));
            out.extend(message(3, &at));
        }
        if k % 10 == 0 {
            let at = fix(stamp(time_s), 2, geodetic(time_s), [0.02, 0.03, 0.04]);
            out.extend(message(1, &at));
        }
    }
    out
}

fn file(records: &[u8], compression: Option<&str>) -> Vec<u8> {
    let mut out = head();
    match compression {
        None => out.extend(records),
        Some(compression) => out.extend(chunk(records, compression)),
    }
    out.extend(end());
    out
}

fn at_origin() -> LogOptions {
    LogOptions::default().with_origin(origin())
}

fn read(bytes: &[u8], options: &LogOptions) -> (Trajectory, LogReport) {
    read_log(bytes, options).unwrap()
}

#[test]
fn positions_times_and_attitudes_are_those_flown_however_they_are_packed() {
    let records = records();
    for compression in [None, Some(""), Some("lz4"), Some("zstd")] {
        let bytes = file(&records, compression);
        assert_eq!(sniff(&bytes), Some(LogFormat::Mcap));
        let (track, report) = read(&bytes, &at_origin());
        assert_eq!(
            report.sources_used(),
            "positions of /fix, attitude of /imu/data"
        );
        assert_eq!(report.height_datum, Some(HeightDatum::Ellipsoid));
        assert_eq!(track.fixes().len(), 300);
        for (k, fix) in track.fixes().iter().enumerate() {
            let time_s = 0.2 * k as f64;
            assert!((track.gps_time_at(fix.time_s).unwrap() - start() - time_s).abs() < 1e-6);
            assert!(distance(fix.position_m, position_m(time_s)) < 1e-6);
            assert_eq!(fix.status, SolutionStatus::Dgps);
            let sigma = fix.standard_deviation_m().unwrap();
            assert!(distance(sigma, [0.02, 0.03, 0.04]) < 1e-4);
            let off = fix.attitude.unwrap().angle_to(&attitude_at(time_s));
            assert!(off.to_degrees() < 0.01);
        }
        assert!(
            report
                .warnings
                .iter()
                .any(|w| w.to_string().contains("stamps of the messages"))
        );
    }
}

#[test]
fn odometry_stands_in_axes_of_its_own_with_its_own_attitude() {
    let bytes = file(&records(), Some("zstd"));
    let (track, report) = read(&bytes, &LogOptions::default().with_source("/odom"));
    assert_eq!(
        report.sources_used(),
        "positions of /odom, attitude of /odom"
    );
    assert!(report.is_local() && *track.frame() == Frame::Local);
    assert_eq!(track.fixes().len(), 600);
    for (k, fix) in track.fixes().iter().enumerate() {
        let time_s = 0.1 * k as f64;
        assert!(distance(fix.position_m, position_m(time_s)) < 1e-12);
        assert!(
            fix.attitude
                .unwrap()
                .angle_to(&attitude_at(time_s))
                .to_degrees()
                < 0.01
        );
        assert!(distance(fix.standard_deviation_m().unwrap(), [0.1; 3]) < 1e-9);
    }
    let (track, _) = read(
        &bytes,
        &at_origin()
            .with_source("ekf")
            .with_attitude_source("/imu/data"),
    );
    assert!(track.frame().enu().is_some());

    // Simulated time counts from zero.
    let mut simulated = topic(3, "/odom", ODOMETRY, "cdr");
    for k in 0..20 {
        let at = odometry(
            (k, 500_000_000),
            position_m(f64::from(k)),
            [0.0, 0.0, 0.0, 1.0],
        );
        simulated.extend(message(3, &at));
    }
    let (track, report) = read(&file(&simulated, None), &LogOptions::default());
    assert_eq!(
        (track.time_origin(), track.start_s()),
        (TimeOrigin::Relative, 0.5)
    );
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("clock of the log without"))
    );
}

#[test]
fn several_topics_are_listed_and_an_imu_without_orientation_has_no_attitude() {
    let mut records = topic(1, "/a/fix", FIX, "cdr");
    records.extend(topic(2, "/b/fix", FIX, "cdr"));
    records.extend(topic(3, "/imu/raw", IMU, "cdr"));
    for k in 0..20 {
        let time_s = 0.2 * f64::from(k);
        records.extend(message(
            1,
            &fix(stamp(time_s), 0, geodetic(time_s), [2.0; 3]),
        ));
        records.extend(message(
            2,
            &fix(stamp(time_s), -1, geodetic(time_s), [2.0; 3]),
        ));
        records.extend(message(3, &imu(stamp(time_s), [0.0, 0.0, 0.0, 1.0], -1.0)));
    }
    // One of them never has a fix.
    let (track, report) = read(&file(&records, None), &at_origin());
    assert_eq!(report.sources_used(), "positions of /a/fix, no attitude");
    assert_eq!(track.status_counts().of(SolutionStatus::Single), 20);
    records.extend(message(2, &fix(stamp(9.0), 1, geodetic(9.0), [2.0; 3])));
    let error = read_log(&file(&records, None)[..], &at_origin())
        .unwrap_err()
        .to_string();
    assert!(error.ends_with("/a/fix, /b/fix"), "{error}");
}

#[test]
fn cut_off_hostile_and_foreign_files_are_refused_with_the_place() {
    let whole = file(&records(), None);
    let error = read_log(&whole[..whole.len() / 2], &at_origin()).unwrap_err();
    let LogError::CutOff { offset, .. } = error else {
        panic!("{error}");
    };
    let (_, report) = read(&whole[..usize::try_from(offset).unwrap()], &at_origin());
    assert!(
        report
            .warnings
            .iter()
            .any(|w| w.to_string().contains("was not closed"))
    );

    // A chunk that says less than it holds, and one that says more than anybody has.
    let records = records();
    let packed = chunk(&records, "zstd");
    for size in [10_u64, u64::MAX] {
        let mut hostile = packed.clone();
        hostile[9 + 16..9 + 24].copy_from_slice(&size.to_le_bytes());
        let bytes = [head(), hostile, end()].concat();
        let error = read_log(&bytes[..], &at_origin()).unwrap_err().to_string();
        let at = head().len();
        assert!(
            error.starts_with(&format!("byte {at}: expected a chunk of records")),
            "{error}"
        );
    }
    let mut wrong = packed.clone();
    wrong[9 + 24] ^= 1;
    let error = read_log(&[head(), wrong, end()].concat()[..], &at_origin()).unwrap_err();
    assert!(error.to_string().contains("wrong checksum"), "{error}");
    let bytes = [head(), record(6, &[0; 12]), end()].concat();
    assert!(read_log(&bytes[..], &at_origin()).is_err());
    let mut giant = head();
    giant.push(5);
    giant.extend((1_u64 << 40).to_le_bytes());
    assert!(matches!(
        read_log(&giant[..], &at_origin()),
        Err(LogError::Limit { .. })
    ));
    // ROS 1 serialises otherwise.
    let bytes = file(&topic(1, "/fix", FIX, "ros1"), None);
    let error = read_log(&bytes[..], &at_origin()).unwrap_err().to_string();
    assert!(
        error.contains("encoding cdr of ROS 2, found 'ros1'"),
        "{error}"
    );
    let mut short = topic(1, "/fix", FIX, "cdr");
    short.extend(message(
        1,
        &fix(stamp(0.0), 0, geodetic(0.0), [1.0; 3])[..40],
    ));
    let error = read_log(&file(&short, None)[..], &at_origin())
        .unwrap_err()
        .to_string();
    assert!(error.contains("a whole message of /fix"), "{error}");
    let error = read_log(&file(&[], None)[..], &at_origin()).unwrap_err();
    assert!(matches!(error, LogError::NoPositions { .. }));
}
