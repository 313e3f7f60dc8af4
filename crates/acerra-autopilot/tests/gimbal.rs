//! Attitudes of gimbals in logs of a flight of known truth.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // a part of the writers is used here

#[path = "write/ardupilot.rs"]
mod ardupilot;
#[path = "write/flight.rs"]
mod flight;
#[path = "write/mavlink.rs"]
mod mavlink;
#[path = "write/px4.rs"]
mod px4;
#[path = "write/ros.rs"]
mod ros;

use acerra_autopilot::{GimbalChoice, LogError, LogOptions, LogReport, read_log};
use acerra_geo::trajectory::Trajectory;
use flight::{
    GEOID_M, attitude_at, attitude_of, boot_s, euler_rad, geodetic, gimbal_from_nose_rad,
    gimbal_rad, origin, quaternion_frd_ned, start, velocity_m_s,
};
use mavlink::GimbalStatus;

/// Seconds of the flight logged, and steps of them.
const FLIGHT_S: f64 = 20.0;
const STEPS: u32 = 1000;

/// A MAVLink message: number and checksum's byte, payload.
type Message = ((u32, u8), Vec<u8>);

fn wanting(gimbal: GimbalChoice) -> LogOptions {
    LogOptions::default()
        .with_origin(origin())
        .with_gimbal(gimbal)
}

fn named(name: &str) -> LogOptions {
    wanting(GimbalChoice::Named(name.to_owned()))
}

fn read(bytes: &[u8], options: &LogOptions) -> (Trajectory, LogReport) {
    read_log(bytes, options).unwrap()
}

fn refused(bytes: &[u8], options: &LogOptions) -> LogError {
    read_log(bytes, options).unwrap_err()
}

fn warned(report: &LogReport, text: &str) -> bool {
    report.warnings.iter().any(|w| w.to_string().contains(text))
}

/// The gimbal's attitudes are those flown within `most_deg`, and the vehicle's stay its own.
fn check(track: &Trajectory, most_deg: f64) {
    assert_eq!(track.fixes().len(), 100);
    for fix in track.fixes() {
        let time_s = track.gps_time_at(fix.time_s).unwrap() - start();
        let off = fix
            .gimbal
            .unwrap()
            .angle_to(&attitude_of(gimbal_rad(time_s)));
        assert!(
            off.to_degrees() < most_deg,
            "{time_s}: {}°",
            off.to_degrees()
        );
        let off = fix.attitude.unwrap().angle_to(&attitude_at(time_s));
        assert!(off.to_degrees() < 0.06, "{time_s}: {}°", off.to_degrees());
    }
}

fn step_s(k: u32) -> f64 {
    FLIGHT_S / f64::from(STEPS) * f64::from(k)
}

/// An ArduPilot log of which `instances` gimbals say in `MNT` what `angles_rad` makes of the time.
fn bin(angles_rad: impl Fn(f64) -> [f64; 4], instances: u8) -> Vec<u8> {
    let mut out = ardupilot::head();
    for k in 0..STEPS {
        let time_s = step_s(k);
        out.extend(ardupilot::att(boot_s(time_s), euler_rad(time_s)));
        for instance in 0..instances {
            if k % 2 == 0 {
                out.extend(ardupilot::mnt(boot_s(time_s), instance, angles_rad(time_s)));
            }
        }
        if k % 10 == 0 {
            let [latitude, longitude, height_m] = geodetic(time_s);
            let fix = ardupilot::Gps {
                instance: 0,
                status: 6,
                week: 2390,
                week_ms: (302_400_000.0 + 1e3 * time_s).round() as u32,
                place: [latitude, longitude, height_m - GEOID_M],
                velocity_m_s: velocity_m_s(time_s),
            };
            out.extend(ardupilot::gps(boot_s(time_s), &fix));
            out.extend(ardupilot::gpa(boot_s(time_s), 0, [0.02, 0.03], -GEOID_M));
        }
    }
    out
}

/// Roll and pitch, yaw from the nose and from north (rad).
fn mount_rad(time_s: f64) -> [f64; 4] {
    let ([roll, pitch, yaw], [_, _, from_nose]) =
        (gimbal_rad(time_s), gimbal_from_nose_rad(time_s));
    [roll, pitch, from_nose, yaw]
}

#[test]
fn ardupilot_tells_the_gimbal_from_north_or_from_the_nose() {
    let (track, report) = read(&bin(mount_rad, 1), &wanting(GimbalChoice::Only));
    assert_eq!(
        report.sources_used(),
        "positions of GPS[0], attitude of ATT, gimbal of MNT[0]"
    );
    assert_eq!(report.gimbal_sources[0].attitudes, 500);
    assert_eq!(report.gimbal_attitudes, 100);
    check(&track, 0.06);

    // Without yaw from north that from the nose is turned by the vehicle's heading.
    let from_nose = |t| {
        let [roll, pitch, from_nose, _] = mount_rad(t);
        [roll, pitch, from_nose, f64::NAN]
    };
    let (track, _) = read(&bin(from_nose, 1), &named("MNT[0]"));
    check(&track, 0.06);

    // Nobody asks: nothing is read, and two gimbals are no trouble.
    let two = bin(mount_rad, 2);
    let (track, report) = read(&two, &wanting(GimbalChoice::None));
    assert!(track.fixes().iter().all(|fix| fix.gimbal.is_none()));
    assert_eq!(
        (report.gimbal_source, report.gimbal_sources.len()),
        (None, 2)
    );
    let error = refused(&two, &wanting(GimbalChoice::Only)).to_string();
    assert!(error.contains("gimbal_source: MNT[0], MNT[1]"), "{error}");
    check(&read(&two, &named("MNT[1]")).0, 0.06);
    let error = refused(&two, &named("MNT[2]")).to_string();
    assert!(error.contains("gimbal_source = \"MNT[2]\"") && error.contains("MNT[0], MNT[1]"));
}

#[test]
fn a_gimbal_that_says_nothing_or_is_not_there_is_refused() {
    for bytes in [bin(|_| [f64::NAN; 4], 1), bin(|_| [0.0; 4], 0)] {
        let error = refused(&bytes, &wanting(GimbalChoice::Only));
        assert!(matches!(error, LogError::NoGimbal { .. }), "{error}");
        let error = error.to_string();
        assert!(error.contains("no attitude of a gimbal") && error.contains("records MNT"));
    }
    let (_, report) = read(&bin(|_| [f64::NAN; 4], 1), &wanting(GimbalChoice::None));
    assert!(!warned(&report, "MNT"));
    // Half of the records say nothing.
    let half = |t| if t < 10.0 { [f64::NAN; 4] } else { [0.0; 4] };
    let (track, report) = read(&bin(half, 1), &wanting(GimbalChoice::Only));
    assert!(warned(
        &report,
        "250 records of MNT[0] without a usable attitude"
    ));
    // The first at 10 s is held for a quarter of a second before it: one position at 5 Hz.
    assert!(warned(
        &report,
        "49 of 100 positions have no attitude of the gimbal"
    ));
    assert!(track.fixes()[10].gimbal.is_none() && track.fixes()[90].gimbal.is_some());
}

#[test]
fn servos_without_feedback_are_told_from_gimbals_by_the_parameters() {
    let with_kind = |name, kind| {
        let mut bytes = bin(mount_rad, 1);
        bytes.extend(ardupilot::parm(boot_s(FLIGHT_S), "ATC_RAT_RLL_P", 0.135));
        bytes.extend(ardupilot::parm(boot_s(FLIGHT_S), name, kind));
        bytes
    };
    let only = wanting(GimbalChoice::Only);
    // A gimbal on a serial line, one behind servo signals that stabilises itself, and nobody knows.
    for (name, kind, asked, unknown) in [
        ("MNT1_TYPE", 8.0, false, false),
        ("MNT1_TYPE", 7.0, true, false),
        ("MNT2_TYPE", 1.0, false, true),
        ("MNT1_TYPE", 0.0, false, true),
    ] {
        let (track, report) = read(&with_kind(name, kind), &only);
        check(&track, 0.06);
        assert_eq!(
            warned(&report, "commands to the gimbal's servos"),
            asked,
            "{name} {kind}"
        );
        assert_eq!(
            warned(&report, "the autopilot's report on"),
            unknown,
            "{name} {kind}"
        );
    }
    let servos = with_kind("MNT1_TYPE", 1.0);
    let error = refused(&servos, &only).to_string();
    assert!(
        error.contains("MNT1_TYPE = 1") && error.contains("\"vertical\""),
        "{error}"
    );
    assert_eq!(
        read(&servos, &wanting(GimbalChoice::None)).1.gimbal_source,
        None
    );
}

/// UTC (µs since 1970): 18 s behind GPS time.
fn utc_us(time_s: f64) -> u64 {
    let start_s: i64 = 2390 * 604_800 + 302_400 + 315_964_800 - 18;
    (start_s as f64 * 1e6 + time_s * 1e6).round() as u64
}

fn boot_ms(time_s: f64) -> u32 {
    ((200.0 + time_s) * 1e3).round() as u32
}

/// Delay of the telemetry (s): 80 ms and up to 40 ms more.
fn delay_s(k: u32) -> f64 {
    0.08 + 0.04 * f64::from(k.wrapping_mul(2_654_435_761) >> 8) / 16_777_216.0
}

/// A telemetry log; `gimbals` are sent 25 times a second, each by its component.
fn tlog(gimbals: impl Fn(f64) -> Vec<(u8, Message)>, with_attitude: bool) -> Vec<u8> {
    let mut out = Vec::new();
    for k in 0..STEPS {
        let time_s = step_s(k);
        // The ground station's clock is off by an hour.
        let stamp_us = utc_us(time_s + 3600.0 + delay_s(k));
        let mut send = |component, (kind, payload): Message| {
            let sender = mavlink::Sender {
                component,
                ..mavlink::AUTOPILOT
            };
            out.extend(mavlink::packet(stamp_us, sender, kind, &payload));
        };
        if k % 50 == 0 {
            send(1, mavlink::system_time(utc_us(time_s), boot_ms(time_s)));
        }
        if with_attitude {
            send(1, mavlink::attitude(boot_ms(time_s), euler_rad(time_s)));
        }
        if k % 10 == 0 {
            let [latitude, longitude, height_m] = geodetic(time_s);
            let gps = mavlink::Gps {
                time_us: u64::from(boot_ms(time_s)) * 1000,
                fix_type: 6,
                place: [latitude, longitude, height_m - GEOID_M],
                above_ellipsoid_m: height_m,
            };
            send(1, mavlink::gps_raw(&gps));
        }
        if k % 2 == 0 {
            for (component, message) in gimbals(time_s) {
                send(component, message);
            }
        }
    }
    out
}

/// A telemetry log whose autopilot says that of its gimbal.
fn tlog_of(status: impl Fn(f64) -> GimbalStatus) -> Vec<u8> {
    tlog(|t| vec![(1, mavlink::gimbal_status(&status(t)))], true)
}

fn status(time_s: f64) -> GimbalStatus {
    GimbalStatus {
        boot_ms: boot_ms(time_s),
        flags: 4 | 8 | 64,
        failures: 0,
        quaternion: quaternion_frd_ned(gimbal_rad(time_s)),
        extension: Some((f64::NAN, 0)),
    }
}

fn status_from_nose(time_s: f64) -> GimbalStatus {
    GimbalStatus {
        flags: 4 | 8 | 32,
        quaternion: quaternion_frd_ned(gimbal_from_nose_rad(time_s)),
        ..status(time_s)
    }
}

#[test]
fn the_flags_of_mavlink_say_what_the_yaw_counts_from() {
    let ways: [&dyn Fn(f64) -> GimbalStatus; 6] = [
        &status,
        &status_from_nose,
        // The sender knows the heading.
        &|t| GimbalStatus {
            extension: Some((euler_rad(t)[2], 0)),
            ..status_from_nose(t)
        },
        // Senders of the older definition: yaw locked, or not.
        &|t| GimbalStatus {
            flags: 4 | 8 | 16,
            extension: None,
            ..status(t)
        },
        &|t| GimbalStatus {
            flags: 4 | 8,
            extension: None,
            ..status_from_nose(t)
        },
        // The heading has no meaning without the flags.
        &|t| GimbalStatus {
            flags: 0,
            extension: Some((2.5, 0)),
            ..status_from_nose(t)
        },
    ];
    for (k, way) in ways.into_iter().enumerate() {
        let (track, report) = read(&tlog_of(way), &wanting(GimbalChoice::Only));
        let source = report.gimbal_source.as_deref();
        assert_eq!(source, Some("GIMBAL_DEVICE_ATTITUDE_STATUS[1]"), "{k}");
        assert!(warned(&report, "the autopilot's report on"));
        check(&track, 0.06);
    }
    let contradicting = |t| GimbalStatus {
        flags: 32 | 64,
        ..status(t)
    };
    let error = refused(&tlog_of(contradicting), &wanting(GimbalChoice::Only));
    assert!(matches!(error, LogError::NoGimbal { .. }), "{error}");
}

#[test]
fn a_yaw_from_a_nose_that_nothing_tells_is_refused() {
    let bytes = tlog(
        |t| vec![(1, mavlink::gimbal_status(&status_from_nose(t)))],
        false,
    );
    let error = refused(&bytes, &wanting(GimbalChoice::Only)).to_string();
    assert!(error.contains("none of its 500 attitudes"), "{error}");
    assert!(error.contains("no attitude of the vehicle"), "{error}");
    // From north the gimbal needs no vehicle.
    let bytes = tlog(|t| vec![(1, mavlink::gimbal_status(&status(t)))], false);
    let (track, report) = read(&bytes, &wanting(GimbalChoice::Only));
    assert_eq!(
        (report.attitude_source, report.gimbal_attitudes),
        (None, 100)
    );
    let expected = attitude_of(gimbal_rad(10.0));
    let off = track.fixes()[50].gimbal.unwrap().angle_to(&expected);
    assert!(off.to_degrees() < 0.06, "{off}");
}

#[test]
fn mount_orientation_is_in_degrees_and_gives_way_to_the_status_of_the_device() {
    let from_nose = |t| mavlink::mount_orientation(boot_ms(t), &gimbal_from_nose_rad(t));
    let from_north = |t| mavlink::mount_orientation(boot_ms(t), &mount_rad(t));
    let ways: [&dyn Fn(f64) -> Message; 2] = [&from_nose, &from_north];
    for message in ways {
        let bytes = tlog(|t| vec![(1, message(t))], true);
        let (track, report) = read(&bytes, &wanting(GimbalChoice::Only));
        assert_eq!(
            report.gimbal_source.as_deref(),
            Some("MOUNT_ORIENTATION[1]")
        );
        check(&track, 0.06);
    }
    let both = |t| {
        let off = mavlink::mount_orientation(boot_ms(t), &[0.0; 3]);
        vec![(1, off), (1, mavlink::gimbal_status(&status(t)))]
    };
    let (track, report) = read(&tlog(both, true), &wanting(GimbalChoice::Only));
    assert_eq!(
        report.gimbal_source.as_deref(),
        Some("GIMBAL_DEVICE_ATTITUDE_STATUS[1]")
    );
    check(&track, 0.06);
}

#[test]
fn the_own_clock_of_a_gimbal_is_put_on_that_of_the_autopilot() {
    let sent = |status: &dyn Fn(f64) -> GimbalStatus| {
        tlog(|t| vec![(154, mavlink::gimbal_status(&status(t)))], true)
    };
    // It started 37 s later, and is 100 ppm fast.
    let own = |t: f64| GimbalStatus {
        boot_ms: ((163.0 + t) * 1e3 * (1.0 + 1e-4)).round() as u32,
        ..status(t)
    };
    let (track, report) = read(&sent(&own), &wanting(GimbalChoice::Only));
    let source = report.gimbal_source.as_deref();
    assert_eq!(source, Some("GIMBAL_DEVICE_ATTITUDE_STATUS[154]"));
    assert!(!warned(&report, "that of their arrival"));
    // It turns by 4.5° a second at most: 20 ms are 0.09°.
    check(&track, 0.09);
    assert!(!warned(&report, "the autopilot's report on"));

    // Without a clock its messages are taken as they arrive, 20 ms early or late of the mean delay.
    let none = |t| GimbalStatus {
        boot_ms: 0,
        ..status(t)
    };
    let (track, report) = read(&sent(&none), &wanting(GimbalChoice::Only));
    assert!(warned(&report, "that of their arrival"));
    check(&track, 0.18);
}

#[test]
fn several_devices_are_for_choice_and_those_of_other_vehicles_are_not_ours() {
    let devices = |t| {
        let numbered = |device| {
            let extension = Some((f64::NAN, device));
            mavlink::gimbal_status(&GimbalStatus {
                extension,
                ..status(t)
            })
        };
        vec![(1, numbered(1)), (1, numbered(2))]
    };
    let bytes = tlog(devices, true);
    let error = refused(&bytes, &wanting(GimbalChoice::Only)).to_string();
    let names = "GIMBAL_DEVICE_ATTITUDE_STATUS[1], GIMBAL_DEVICE_ATTITUDE_STATUS[2]";
    assert!(error.contains(names), "{error}");
    check(
        &read(&bytes, &named("GIMBAL_DEVICE_ATTITUDE_STATUS[2]")).0,
        0.06,
    );

    let mut bytes = tlog(|_| Vec::new(), true);
    for k in 0..50 {
        let other = mavlink::Sender {
            system: 7,
            ..mavlink::AUTOPILOT
        };
        let (kind, payload) = mavlink::gimbal_status(&status(step_s(k)));
        bytes.extend(mavlink::packet(utc_us(step_s(k)), other, kind, &payload));
    }
    let error = refused(&bytes, &wanting(GimbalChoice::Only));
    assert!(matches!(error, LogError::NoGimbal { .. }), "{error}");
}

#[test]
fn failures_that_a_gimbal_reports_are_told() {
    let failing = |t| GimbalStatus {
        failures: if t < 4.99 { 8 } else { 2 },
        ..status(t)
    };
    let (track, report) = read(&tlog_of(failing), &wanting(GimbalChoice::Only));
    let told = "at 125 of 500 attitudes GIMBAL_DEVICE_ATTITUDE_STATUS[1] reports";
    assert!(warned(&report, told), "{:?}", report.warnings);
    check(&track, 0.06);
}

/// A PX4 log whose gimbal says what `gimbal` makes of the message's number, the clock (µs) and the time.
fn ulg(gimbal: impl Fn(u16, u64, f64) -> Vec<u8>) -> Vec<u8> {
    let mut out = px4::head(0);
    for text in [px4::NEW_GPS, px4::ATTITUDE, px4::GIMBAL] {
        out.extend(px4::format(text));
    }
    out.extend(px4::subscribe(1, 0, "sensor_gps"));
    out.extend(px4::subscribe(2, 0, "vehicle_attitude"));
    out.extend(px4::subscribe(3, 0, "gimbal_device_attitude_status"));
    for k in 0..STEPS {
        let time_s = step_s(k);
        let us = (boot_s(time_s) * 1e6).round() as u64;
        out.extend(px4::attitude(2, us, euler_rad(time_s)));
        if k % 2 == 0 {
            out.extend(gimbal(3, us, time_s));
        }
        if k % 10 == 0 {
            let gps = px4::Gps {
                boot_us: us,
                utc_us: utc_us(time_s),
                fix_type: 6,
                place: geodetic(time_s),
                geoid_m: GEOID_M,
                velocity_m_s: velocity_m_s(time_s),
            };
            out.extend(px4::new_gps(1, &gps));
        }
    }
    out
}

#[test]
fn the_gimbal_of_px4_is_read_by_its_flags_and_what_servos_were_asked_is_told() {
    let absolute = |t| quaternion_frd_ned(gimbal_rad(t));
    let relative = |t| quaternion_frd_ned(gimbal_from_nose_rad(t));
    let ways: [&dyn Fn(u16, u64, f64) -> Vec<u8>; 4] = [
        &|id, us, t| px4::gimbal(id, us, absolute(t), 4 | 8 | 16, 0.0),
        &|id, us, t| px4::gimbal(id, us, absolute(t), 4 | 8 | 64, f64::NAN),
        &|id, us, t| px4::gimbal(id, us, relative(t), 4 | 8 | 32, euler_rad(t)[2]),
        &|id, us, t| px4::gimbal(id, us, relative(t), 4 | 8, 0.0),
    ];
    for way in ways {
        let (track, report) = read(&ulg(way), &wanting(GimbalChoice::Only));
        let source = report.gimbal_source.as_deref();
        assert_eq!(source, Some("gimbal_device_attitude_status[0]"));
        check(&track, 0.06);
        assert!(!warned(&report, "servos"));
    }
    let asked = |id, us, t| {
        let mut message = px4::gimbal(id, us, absolute(t), 16, 0.0);
        *message.last_mut().unwrap() = 0;
        message
    };
    let (_, report) = read(&ulg(asked), &wanting(GimbalChoice::Only));
    assert!(warned(&report, "servos"));
}

/// A file of ROS 2: positions, the vehicle's Imu, and the gimbal's as Imu and as quaternion.
fn mcap() -> Vec<u8> {
    let mut records = ros::topic(1, "/fix", "sensor_msgs/msg/NavSatFix", "cdr");
    records.extend(ros::topic(2, "/imu/data", "sensor_msgs/msg/Imu", "cdr"));
    records.extend(ros::topic(3, "/gimbal/imu", "sensor_msgs/msg/Imu", "cdr"));
    let quaternion = "geometry_msgs/msg/QuaternionStamped";
    records.extend(ros::topic(4, "/gimbal/attitude", quaternion, "cdr"));
    for k in 0..STEPS {
        let time_s = step_s(k);
        let us = utc_us(time_s);
        let stamp = ((us / 1_000_000) as i32, 1000 * (us % 1_000_000) as u32);
        let xyzw = |angles| {
            let [w, x, y, z] = attitude_of(angles).quaternion();
            [x, y, z, w]
        };
        let vehicle = xyzw(euler_rad(time_s));
        let gimbal = xyzw(gimbal_rad(time_s));
        if k % 10 == 0 {
            let fix = ros::fix(stamp, 2, geodetic(time_s), [0.02, 0.02, 0.03]);
            records.extend(ros::message(1, &fix));
        }
        records.extend(ros::message(2, &ros::imu(stamp, vehicle, 0.1)));
        records.extend(ros::message(3, &ros::imu(stamp, gimbal, 0.1)));
        records.extend(ros::message(4, &ros::quaternion(stamp, gimbal)));
    }
    [ros::head(), records, ros::end()].concat()
}

#[test]
fn of_a_ros_file_the_topic_of_the_gimbal_is_named_and_is_then_not_that_of_the_vehicle() {
    let bytes = mcap();
    for name in ["/gimbal/imu", "/gimbal/attitude"] {
        let options = named(name).with_attitude_source("/imu/data");
        let (track, report) = read(&bytes, &options);
        assert_eq!(report.gimbal_source.as_deref(), Some(name));
        check(&track, 0.06);
    }
    // The vehicle's is the only one left.
    check(&read(&bytes, &named("/gimbal/imu")).0, 0.06);
    let options = wanting(GimbalChoice::Only).with_attitude_source("/imu/data");
    let error = refused(&bytes, &options).to_string();
    assert!(error.contains("gimbal_source to name a topic"), "{error}");
    let topics = "/gimbal/attitude, /imu/data, /gimbal/imu";
    assert!(error.contains(topics), "{error}");
    let options = named("/camera").with_attitude_source("/imu/data");
    assert!(matches!(
        refused(&bytes, &options),
        LogError::NoSuchSource { wanted, .. } if wanted == "/camera"
    ));
}

#[test]
fn cut_off_and_hostile_gimbals_are_read_or_refused() {
    let relative = |t| quaternion_frd_ned(gimbal_from_nose_rad(t));
    let whole = [
        bin(mount_rad, 1),
        tlog(|t| vec![(154, mavlink::gimbal_status(&status(t)))], true),
        ulg(|id, us, t| px4::gimbal(id, us, relative(t), 32, 0.3)),
    ];
    let options = wanting(GimbalChoice::Only);
    for bytes in whole {
        let bytes = &bytes[..6000];
        for end in (0..bytes.len()).step_by(7) {
            let _ = read_log(&bytes[..end], &options);
        }
        let mut flipped = bytes.to_vec();
        for at in 0..bytes.len() {
            flipped[at] = !bytes[at];
            let _ = read_log(&flipped[..], &options);
            flipped[at] = bytes[at];
        }
    }
    let mut few = options;
    few.max_samples = 100;
    let thrice = |t| vec![(154, mavlink::gimbal_status(&status(t))); 3];
    let error = refused(&tlog(thrice, false), &few).to_string();
    assert!(error.contains("100 attitudes of a gimbal"), "{error}");
}
