//! The fuzzers' seeds, replayed without a fuzzer; `-- --ignored` writes them anew.
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

use std::fs;
use std::path::PathBuf;

use acerra_autopilot::{GimbalChoice, LogOptions, read_log};
use flight::{
    euler_rad, geodetic, gimbal_from_nose_rad, gimbal_rad, quaternion_frd_ned, velocity_m_s,
};

fn folder(target: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../fuzz/seeds")
        .join(target)
}

const TARGETS: [&str; 4] = ["log_ardupilot", "log_px4", "log_mavlink", "log_ros"];

#[test]
fn every_seed_is_read_and_its_cuts_and_flips_are_read_or_refused() {
    for target in TARGETS {
        let mut seeds = 0;
        for entry in fs::read_dir(folder(target)).unwrap() {
            let bytes = fs::read(entry.unwrap().path()).unwrap();
            let options = LogOptions::default().taking_first();
            let (track, report) = read_log(&bytes[..], &options).unwrap();
            assert!(!track.fixes().is_empty());
            seeds += 1;
            let options = match report.gimbal_sources.first() {
                Some(gimbal) => options.with_gimbal(GimbalChoice::Named(gimbal.name.clone())),
                None => options,
            };
            let (_, named) = read_log(&bytes[..], &options).unwrap();
            assert_eq!(named.gimbal_attitudes > 0, named.gimbal_source.is_some());
            for end in 0..bytes.len() {
                let _ = read_log(&bytes[..end], &options);
            }
            let mut flipped = bytes.clone();
            for at in 0..bytes.len() {
                flipped[at] ^= 1 << (at % 8);
                let _ = read_log(&flipped[..], &options);
                flipped[at] = !bytes[at];
                let _ = read_log(&flipped[..], &options);
                flipped[at] = bytes[at];
            }
        }
        assert!(seeds > 0, "{target}");
    }
}

const START_US: u64 = 1_761_177_582_000_000;

fn ardupilot_seed() -> Vec<u8> {
    let mut out = ardupilot::head();
    for k in 0..4_u32 {
        let time_s = 0.2 * f64::from(k);
        let fix = ardupilot::Gps {
            instance: 0,
            status: 6,
            week: 2390,
            week_ms: 302_400_000 + 200 * k,
            place: geodetic(time_s),
            velocity_m_s: velocity_m_s(time_s),
        };
        out.extend(ardupilot::att(40.0 + time_s, euler_rad(time_s)));
        out.extend(ardupilot::pos(40.0 + time_s, geodetic(time_s)));
        out.extend(ardupilot::gps(40.1 + time_s, &fix));
        out.extend(ardupilot::gpa(40.1 + time_s, 0, [0.02, 0.03], -47.0));
    }
    out
}

fn px4_seed() -> Vec<u8> {
    let mut out = px4::head(0);
    for text in [px4::OLD_GPS, px4::NEW_GPS, px4::ATTITUDE, px4::GLOBAL] {
        out.extend(px4::format(text));
    }
    out.extend(px4::subscribe(1, 0, "vehicle_gps_position"));
    out.extend(px4::subscribe(2, 0, "sensor_gps"));
    out.extend(px4::subscribe(3, 0, "vehicle_attitude"));
    out.extend(px4::subscribe(4, 0, "vehicle_global_position"));
    for k in 0..4 {
        let time_s = 0.2 * f64::from(k);
        let us = (time_s * 1e6) as u64;
        let gps = px4::Gps {
            boot_us: 40_100_000 + us,
            utc_us: START_US + us,
            fix_type: 6,
            place: geodetic(time_s),
            geoid_m: 47.0,
            velocity_m_s: velocity_m_s(time_s),
        };
        out.extend(px4::old_gps(1, &gps));
        out.extend(px4::new_gps(2, &gps));
        out.extend(px4::attitude(3, 40_000_000 + us, euler_rad(time_s)));
        out.extend(px4::global(4, 40_000_000 + us, geodetic(time_s), 47.0));
    }
    out.extend([8, 0, b'S', 0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]);
    out
}

fn mavlink_seed(version: u8) -> Vec<u8> {
    let sender = mavlink::Sender {
        version,
        ..mavlink::AUTOPILOT
    };
    let mut out = Vec::new();
    for k in 0..4_u32 {
        let time_s = 0.2 * f64::from(k);
        let us = u64::from(200_000 * k);
        let boot_ms = 40_000 + 200 * k;
        let gps = mavlink::Gps {
            time_us: u64::from(boot_ms) * 1000,
            fix_type: 6,
            place: geodetic(time_s),
            above_ellipsoid_m: geodetic(time_s)[2],
        };
        for (kind, payload) in [
            mavlink::heartbeat(),
            mavlink::system_time(START_US + us, boot_ms),
            mavlink::attitude(boot_ms, euler_rad(time_s)),
            mavlink::global(boot_ms, geodetic(time_s), velocity_m_s(time_s)),
            mavlink::gps_raw(&gps),
            mavlink::gps2_raw(&gps),
        ] {
            out.extend(mavlink::packet(START_US + us, sender, kind, &payload));
        }
    }
    out
}

/// Gimbals that speak through the autopilot, and one with a clock of its own.
fn mavlink_gimbals_seed() -> Vec<u8> {
    let gimbal = mavlink::Sender {
        component: 154,
        ..mavlink::AUTOPILOT
    };
    let mut out = mavlink_seed(2);
    for k in 0..4_u32 {
        let time_s = 0.2 * f64::from(k);
        let mut status = mavlink::GimbalStatus {
            boot_ms: 40_000 + 200 * k,
            flags: 32,
            failures: 8 * (k % 2),
            quaternion: quaternion_frd_ned(gimbal_from_nose_rad(time_s)),
            extension: Some((euler_rad(time_s)[2], 1)),
        };
        let mut send = |sender, (kind, payload): ((u32, u8), Vec<u8>)| {
            let stamp_us = START_US + u64::from(200_000 * k);
            out.extend(mavlink::packet(stamp_us, sender, kind, &payload));
        };
        send(mavlink::AUTOPILOT, mavlink::gimbal_status(&status));
        status.boot_ms = 7_000 + 200 * k;
        status.extension = None;
        send(gimbal, mavlink::gimbal_status(&status));
        let angles = mavlink::mount_orientation(status.boot_ms, &gimbal_from_nose_rad(time_s));
        send(gimbal, angles);
    }
    out
}

fn ardupilot_gimbal_seed() -> Vec<u8> {
    let mut out = ardupilot_seed();
    for k in 0..4_u32 {
        let time_s = 0.2 * f64::from(k);
        let ([roll, pitch, yaw], [_, _, from_nose]) =
            (gimbal_rad(time_s), gimbal_from_nose_rad(time_s));
        let yaw = if k == 2 { f64::NAN } else { yaw };
        out.extend(ardupilot::mnt(
            40.0 + time_s,
            0,
            [roll, pitch, from_nose, yaw],
        ));
    }
    out
}

fn px4_gimbal_seed() -> Vec<u8> {
    let mut out = px4_seed();
    out.extend(px4::format(px4::GIMBAL));
    out.extend(px4::subscribe(5, 0, "gimbal_device_attitude_status"));
    for k in 0..4_u32 {
        let time_s = 0.2 * f64::from(k);
        let us = 40_000_000 + u64::from(200_000 * k);
        let quaternion = quaternion_frd_ned(gimbal_rad(time_s));
        out.extend(px4::gimbal(5, us, quaternion, 16 << (k % 3), 0.0));
    }
    out
}

fn ros_gimbal_seed() -> Vec<u8> {
    let mut records = ros::topic(1, "/fix", "sensor_msgs/msg/NavSatFix", "cdr");
    let schema = "geometry_msgs/msg/QuaternionStamped";
    records.extend(ros::topic(2, "/gimbal", schema, "cdr"));
    for k in 0..3_u32 {
        let time_s = 0.2 * f64::from(k);
        let stamp = ((START_US / 1_000_000) as i32, 200_000_000 * k);
        let place = geodetic(time_s);
        records.extend(ros::message(1, &ros::fix(stamp, 0, place, [1.0; 3])));
        let quaternion = [0.0, 0.1, 0.0, 1.0];
        records.extend(ros::message(2, &ros::quaternion(stamp, quaternion)));
    }
    [ros::head(), records, ros::end()].concat()
}

fn ros_seed(compression: Option<&str>) -> Vec<u8> {
    let mut records = ros::topic(1, "/fix", "sensor_msgs/msg/NavSatFix", "cdr");
    records.extend(ros::topic(2, "/imu", "sensor_msgs/msg/Imu", "cdr"));
    records.extend(ros::topic(3, "/odom", "nav_msgs/msg/Odometry", "cdr"));
    for k in 0..3_u32 {
        let time_s = 0.2 * f64::from(k);
        let stamp = ((START_US / 1_000_000) as i32, 200_000_000 * k);
        let level = [0.0, 0.0, 0.0, 1.0];
        records.extend(ros::message(
            1,
            &ros::fix(stamp, 0, geodetic(time_s), [1.0; 3]),
        ));
        records.extend(ros::message(2, &ros::imu(stamp, level, 0.1)));
        records.extend(ros::message(
            3,
            &ros::odometry(stamp, flight::position_m(time_s), level),
        ));
    }
    let body = match compression {
        None => records,
        Some(compression) => ros::chunk(&records, compression),
    };
    [ros::head(), body, ros::end()].concat()
}

#[test]
#[ignore = "writes fuzz/seeds anew"]
fn write_seeds() {
    let save = |target: &str, name: &str, bytes: &[u8]| {
        fs::create_dir_all(folder(target)).unwrap();
        fs::write(folder(target).join(name), bytes).unwrap();
    };
    save("log_ardupilot", "flight.bin", &ardupilot_seed());
    save("log_ardupilot", "gimbal.bin", &ardupilot_gimbal_seed());
    save("log_px4", "flight.ulg", &px4_seed());
    save("log_px4", "gimbal.ulg", &px4_gimbal_seed());
    save("log_mavlink", "version-1.tlog", &mavlink_seed(1));
    save("log_mavlink", "version-2.tlog", &mavlink_seed(2));
    save("log_mavlink", "gimbals.tlog", &mavlink_gimbals_seed());
    save("log_ros", "gimbal.mcap", &ros_gimbal_seed());
    save("log_ros", "records.mcap", &ros_seed(None));
    save("log_ros", "lz4.mcap", &ros_seed(Some("lz4")));
    save("log_ros", "zstd.mcap", &ros_seed(Some("zstd")));
}
