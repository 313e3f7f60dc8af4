//! Positions and attitude out of autopilots' logs, through files and the command.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(dead_code)] // a part of the writers is used here

#[path = "../../acerra-autopilot/tests/write/ardupilot.rs"]
mod ardupilot;
#[path = "../../acerra-autopilot/tests/write/mavlink.rs"]
mod mavlink;
#[path = "../../acerra-autopilot/tests/write/px4.rs"]
mod px4;

use std::f64::consts::TAU;
use std::fs;
use std::fs::File;
use std::path::Path;

use acerra_geo::geodesy::{EnuFrame, Geodetic};
use acerra_imaging::reference::{self, Scatterer};
use acerra_imaging::{Complex64, SPEED_OF_LIGHT_M_S, Spreading};
use acerra_npz::NpzReader;
use acerra_radar::{NeutralContent, Spectrum};
use assert_cmd::Command;
use serde_json::Value;

use ardupilot::{Gps, att, gpa, gps, head, mnt};

/// The drone flies north with its nose far off the course.
const LEVER_ARM_M: [f64; 3] = [0.4, 0.1, -0.2];
const REFLECTOR_M: [f64; 3] = [4.0, 0.5, 0.0];
/// The first trace comes so long after the flight's second zero (s).
const FIRST_TRACE_S: f64 = 2.0;
const TOW_S: f64 = 302_400.0;
const GEOID_M: f64 = 47.25;

fn origin() -> Geodetic {
    Geodetic::from_degrees(41.1, 14.25, 80.0)
}

/// The GNSS antenna (east, north, up, m).
fn antenna_m(time_s: f64) -> [f64; 3] {
    [0.05 * (0.9 * time_s).sin(), 0.8 * (time_s - 6.0), 5.0]
}

/// Roll, pitch and yaw (rad).
fn euler_rad(time_s: f64) -> [f64; 3] {
    [
        0.05 * (0.6 * time_s).sin(),
        0.03,
        TAU / 5.0 + 0.15 * (0.5 * time_s).sin(),
    ]
}

/// The radar's phase centre: the lever arm turned by yaw, pitch and roll.
fn phase_centre_m(time_s: f64) -> [f64; 3] {
    let [roll, pitch, yaw] = euler_rad(time_s);
    let [forward, left, up] = LEVER_ARM_M;
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    let (f, r, d) = (forward, -left, -up);
    let north = cp * cy * f + (sr * sp * cy - cr * sy) * r + (cr * sp * cy + sr * sy) * d;
    let east = cp * sy * f + (sr * sp * sy + cr * cy) * r + (cr * sp * sy - sr * cy) * d;
    let down = -sp * f + sr * cp * r + cr * cp * d;
    let [x, y, z] = antenna_m(time_s);
    [x + east, y + north, z - down]
}

/// Echoes of the reflector, 8 s at 20 Hz.
fn write_radar(folder: &Path) {
    let times_s: Vec<f64> = (0..160).map(|m| 0.05 * f64::from(m)).collect();
    let position_m: Vec<[f64; 3]> = times_s
        .iter()
        .map(|t| phase_centre_m(FIRST_TRACE_S + t))
        .collect();
    let frequency_hz: Vec<f64> = (0..86).map(|n| 3.1e9 + 2e7 * f64::from(n)).collect();
    let values = reference::forward(
        &position_m,
        &frequency_hz,
        &[Scatterer {
            position_m: REFLECTOR_M,
            reflectivity: Complex64::ONE,
        }],
        SPEED_OF_LIGHT_M_S,
        Spreading::InverseSquare,
    )
    .unwrap();
    let content = NeutralContent::Spectrum(Spectrum {
        frequency_hz,
        values,
        time_s: times_s,
    });
    let file = File::create(folder.join("radar.npz")).unwrap();
    acerra_radar::npz::write_npz(file, &content, None).unwrap();
}

/// The log of the whole flight, 12 s: RTK at 10 Hz, attitude at 50 Hz.
fn bin(status: u8, with_attitude: bool) -> Vec<u8> {
    let frame = EnuFrame::new(origin());
    let mut log = head();
    for k in 0..600_u32 {
        let time_s = 0.02 * f64::from(k);
        if with_attitude {
            log.extend(att(40.0 + time_s, euler_rad(time_s)));
        }
        if k % 5 == 0 {
            let place = frame.geodetic_from_enu(antenna_m(time_s));
            let fix = Gps {
                instance: 0,
                status,
                week: 2390,
                week_ms: ((TOW_S + time_s) * 1e3).round() as u32,
                place: [
                    place.latitude_deg(),
                    place.longitude_deg(),
                    place.height_m - GEOID_M,
                ],
                velocity_m_s: [0.0, 0.8, 0.0],
            };
            let arrival_s = 40.0 + time_s + 0.06;
            log.extend(gps(arrival_s, &fix));
            log.extend(gpa(arrival_s, 0, [0.01, 0.02], -GEOID_M));
        }
    }
    log
}

/// UTC of the flight (µs since 1970): 18 s behind GPS time.
fn utc_us(time_s: f64) -> u64 {
    let start_s = 2390.0 * 604_800.0 + TOW_S + 315_964_800.0 - 18.0;
    ((start_s + time_s) * 1e6).round() as u64
}

fn antenna_deg_m(time_s: f64) -> [f64; 3] {
    let place = EnuFrame::new(origin()).geodetic_from_enu(antenna_m(time_s));
    [place.latitude_deg(), place.longitude_deg(), place.height_m]
}

/// The same flight as PX4 logs it.
fn ulg() -> Vec<u8> {
    let mut log = px4::head(0);
    for text in [px4::NEW_GPS, px4::ATTITUDE] {
        log.extend(px4::format(text));
    }
    log.extend(px4::subscribe(1, 0, "sensor_gps"));
    log.extend(px4::subscribe(2, 0, "vehicle_attitude"));
    for k in 0..600_u32 {
        let time_s = 0.02 * f64::from(k);
        let boot_us = |s: f64| ((40.0 + s) * 1e6).round() as u64;
        log.extend(px4::attitude(2, boot_us(time_s), euler_rad(time_s)));
        if k % 5 == 0 {
            let gps = px4::Gps {
                boot_us: boot_us(time_s + 0.06),
                utc_us: utc_us(time_s),
                fix_type: 6,
                place: antenna_deg_m(time_s),
                geoid_m: GEOID_M,
                velocity_m_s: [0.0, 0.8, 0.0],
            };
            log.extend(px4::new_gps(1, &gps));
        }
    }
    log
}

/// The same flight as a ground station records it.
fn tlog() -> Vec<u8> {
    let mut log = Vec::new();
    for k in 0..600_u32 {
        let time_s = 0.02 * f64::from(k);
        let boot_ms = 40_000 + 20 * k;
        let mut send = |(kind, payload): ((u32, u8), Vec<u8>)| {
            let packet = mavlink::packet(utc_us(time_s), mavlink::AUTOPILOT, kind, &payload);
            log.extend(packet);
        };
        send(mavlink::attitude(boot_ms, euler_rad(time_s)));
        if k % 5 == 0 {
            let [latitude, longitude, height_m] = antenna_deg_m(time_s);
            send(mavlink::system_time(utc_us(time_s), boot_ms));
            send(mavlink::gps_raw(&mavlink::Gps {
                time_us: u64::from(boot_ms) * 1000,
                fix_type: 6,
                place: [latitude, longitude, height_m - GEOID_M],
                above_ellipsoid_m: height_m,
            }));
        }
    }
    log
}

/// A run of `focus`.
#[derive(Clone, Copy)]
struct Run<'a> {
    log: &'a str,
    lever_arm_m: [f64; 3],
    /// Further keys of `[trajectory]`.
    trajectory: &'a str,
    /// Further keys of `[image]`.
    image: &'a str,
}

impl<'a> Run<'a> {
    fn of(log: &'a str) -> Self {
        Self {
            log,
            lever_arm_m: LEVER_ARM_M,
            trajectory: "",
            image: "",
        }
    }

    /// Targets and record of the run, or the message.
    fn focus(self, folder: &Path) -> Result<(Value, Value), String> {
        let Self {
            log,
            lever_arm_m,
            trajectory,
            image,
        } = self;
        let text = format!(
            "[radar]\nfile = 'radar.npz'\n[trajectory]\nfile = '{log}'\n\
             time_offset_s = {}\nlever_arm_m = {lever_arm_m:?}\norigin_deg_m = [41.1, 14.25, 80.0]\n\
             {trajectory}\n[image]\nx_m = [2, 6]\ny_m = [-2, 3]\nfrequencies = 86\n{image}\n\
             [checks]\ncontradictions = 'warn'\n",
            TOW_S + FIRST_TRACE_S
        );
        run_campaign(folder, &text)
    }
}

/// Runs `focus` on a log with further keys of `[trajectory]`; targets and record of the run, or the message.
fn focus(folder: &Path, log: &str, keys: &str) -> Result<(Value, Value), String> {
    let run = Run {
        trajectory: keys,
        ..Run::of(log)
    };
    run.focus(folder)
}

fn run_campaign(folder: &Path, text: &str) -> Result<(Value, Value), String> {
    let campaign = folder.join("campaign.toml");
    fs::write(&campaign, text).unwrap();
    let products = folder.join("run");
    let output = Command::cargo_bin("acerra")
        .unwrap()
        .args(["focus", campaign.to_str().unwrap(), "-o"])
        .arg(&products)
        .output()
        .unwrap();
    if !output.status.success() {
        assert_eq!(output.status.code(), Some(1));
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let json = |file: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(products.join(file)).unwrap()).unwrap()
    };
    Ok((json("targets.json"), json("run.json")))
}

/// How far the strongest target is from the reflector (m).
fn off_m(targets: &Value) -> f64 {
    let target = &targets["targets"][0];
    let of = |key: &str| target[key].as_f64().unwrap();
    (of("x_m") - REFLECTOR_M[0]).hypot(of("y_m") - REFLECTOR_M[1])
}

fn finding<'a>(run: &'a Value, name: &str) -> &'a Value {
    let all = run["evidence"].as_array().unwrap();
    all.iter().find(|f| f["name"] == name).unwrap()
}

#[test]
fn an_ardupilot_log_puts_the_reflector_where_it_stands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    // The name says nothing: the content does.
    fs::write(folder.join("flight.log"), bin(6, true)).unwrap();
    let (targets, run) = focus(folder, "flight.log", "").unwrap();
    assert!(off_m(&targets) < 0.05, "{targets:#}");
    let inputs = run["inputs"].as_array().unwrap();
    let sources: Vec<&Value> = inputs.iter().map(|i| &i["sources"]).collect();
    assert!(sources.contains(&&Value::from("positions of GPS[0], attitude of ATT")));
    assert_eq!(finding(&run, "autopilot_fixed")["verdict"], "agrees");

    // Without the attitude the lever arm is turned by the course: the nose is not where it flies.
    fs::write(folder.join("course.bin"), bin(6, false)).unwrap();
    let (targets, run) = focus(folder, "course.bin", "").unwrap();
    assert!(off_m(&targets) > 0.2, "{targets:#}");
    let warnings = run["warnings"].to_string();
    assert!(warnings.contains("no attitude in the log"), "{warnings}");

    // Positions that are good to metres are said to be.
    fs::write(folder.join("single.bin"), bin(3, true)).unwrap();
    let (_, run) = focus(folder, "single.bin", "").unwrap();
    assert_eq!(finding(&run, "autopilot_fixed")["verdict"], "doubtful");
}

#[test]
fn px4_and_mavlink_logs_put_it_there_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    for (name, log, sources) in [
        (
            "flight.ulg",
            ulg(),
            "positions of sensor_gps[0], attitude of vehicle_attitude[0]",
        ),
        (
            "flight.tlog",
            tlog(),
            "positions of GPS_RAW_INT, attitude of ATTITUDE",
        ),
    ] {
        fs::write(folder.join(name), log).unwrap();
        let (targets, run) = focus(folder, name, "").unwrap();
        assert!(off_m(&targets) < 0.05, "{name}: {targets:#}");
        assert!(run["inputs"].to_string().contains(sources), "{name}");
    }
}

/// The flight of [`bin`], its drone turned as `euler_rad` says, with a gimbal in `MNT` (rad).
fn bin_with_gimbal(euler_rad: impl Fn(f64) -> [f64; 3], [roll, pitch, yaw]: [f64; 3]) -> Vec<u8> {
    let mut log = bin(6, false);
    for k in 0..600_u32 {
        let time_s = 0.02 * f64::from(k);
        log.extend(att(40.0 + time_s, euler_rad(time_s)));
        log.extend(mnt(40.0 + time_s, 0, [roll, pitch, f64::NAN, yaw]));
    }
    log
}

/// The image of an antenna of a steep pattern on the phase centre that was logged.
fn image_by(folder: &Path, log: &str, axis: &str) -> Vec<f64> {
    let run = Run {
        lever_arm_m: [0.0; 3],
        image: &format!("pixel_m = 0.05\nantenna_cosine_power = 8\nantenna_axis = '{axis}'"),
        ..Run::of(log)
    };
    run.focus(folder).unwrap();
    let file = File::open(folder.join("run/image.npz")).unwrap();
    let values = NpzReader::new(file).unwrap().values("image", 1 << 20);
    let (_, image) = values.unwrap();
    image.into_iter().flat_map(|(re, im)| [re, im]).collect()
}

/// Relative difference of two images.
fn difference(one: &[f64], other: &[f64]) -> f64 {
    assert_eq!(one.len(), other.len());
    let power = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let off = power(&mut one.iter().zip(other).map(|(a, b)| a - b));
    (off / power(&mut other.iter().copied())).sqrt()
}

#[test]
fn an_antenna_on_a_gimbal_is_weighed_where_the_log_says_it_points() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    // The drone rolls, the gimbal keeps level: as if the antenna always looked straight down.
    let rolling = |t: f64| [0.3 * (1.9 * t).sin(), 0.03, 1.2];
    fs::write(
        folder.join("level.bin"),
        bin_with_gimbal(rolling, [0.0, 0.0, 1.2]),
    )
    .unwrap();
    let vertical = image_by(folder, "level.bin", "vertical");
    assert!(difference(&image_by(folder, "level.bin", "gimbal"), &vertical) < 2e-3);
    assert!(difference(&image_by(folder, "level.bin", "attitude"), &vertical) > 0.02);
    // A gimbal tilted to the side weighs as a drone that is so tilted.
    let tilted = [0.5, -0.1, 3.0];
    fs::write(folder.join("tilted.bin"), bin_with_gimbal(rolling, tilted)).unwrap();
    fs::write(
        folder.join("drone.bin"),
        bin_with_gimbal(|_| tilted, [0.0; 3]),
    )
    .unwrap();
    let by_gimbal = image_by(folder, "tilted.bin", "gimbal");
    assert!(difference(&by_gimbal, &image_by(folder, "drone.bin", "attitude")) < 1e-5);
    assert!(difference(&by_gimbal, &vertical) > 0.05);

    // The lever arm stays the drone's.
    fs::write(folder.join("arm.bin"), bin_with_gimbal(euler_rad, tilted)).unwrap();
    let run = Run {
        image: "antenna_cosine_power = 1\nantenna_axis = 'gimbal'",
        trajectory: "gimbal_source = 'MNT[0]'",
        ..Run::of("arm.bin")
    };
    let (targets, run) = run.focus(folder).unwrap();
    assert!(off_m(&targets) < 0.05, "{targets:#}");
    let sources = "positions of GPS[0], attitude of ATT, gimbal of MNT[0]";
    assert!(run["inputs"].to_string().contains(sources));
    let tilt = finding(&run, "antenna_tilt");
    let expected_deg = (0.5_f64.cos() * 0.1_f64.cos()).acos().to_degrees();
    assert!(
        (tilt["value"].as_f64().unwrap() - expected_deg).abs() < 0.01,
        "{tilt:#}"
    );
}

#[test]
fn a_gimbal_that_no_log_holds_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    let on_gimbal = |log| Run {
        image: "antenna_axis = 'gimbal'",
        ..Run::of(log)
    };
    fs::write(folder.join("flight.bin"), bin(6, true)).unwrap();
    let message = on_gimbal("flight.bin").focus(folder).unwrap_err();
    assert!(
        message.contains("flight.bin: no attitude of a gimbal"),
        "{message}"
    );
    let table = "time_s,x_m,y_m,z_m\n0,0,0,4\n1,1,0,4\n";
    fs::write(folder.join("table.csv"), table).unwrap();
    let message = on_gimbal("table.csv").focus(folder).unwrap_err();
    assert!(message.contains("[image] antenna_axis"), "{message}");
}

#[test]
fn logs_that_cannot_be_used_are_refused_with_file_and_place() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    let whole = bin(6, true);
    fs::write(folder.join("cut.bin"), &whole[..whole.len() - 10]).unwrap();
    let message = focus(folder, "cut.bin", "").unwrap_err();
    assert!(
        message.contains("cut.bin: byte ") && message.contains("cut off"),
        "{message}"
    );
    fs::write(folder.join("flight.bin"), whole).unwrap();
    let message = focus(folder, "flight.bin", "source = 'GPS[1]'").unwrap_err();
    assert!(message.contains("GPS[0] (120 positions)"), "{message}");
    fs::write(
        folder.join("table.csv"),
        "time_s,x_m,y_m,z_m\n0,0,0,4\n1,1,0,4\n",
    )
    .unwrap();
    let message = focus(folder, "table.csv", "source = 'ekf'").unwrap_err();
    assert!(message.contains("[trajectory] source"), "{message}");
}

/// The flight's positions at 5 Hz as a carrier-phase solution of RTKLIB's format, from `late_s` after its start.
fn pos(late_s: f64) -> String {
    let mut text = "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix)\n%  GPST  latitude(deg) longitude(deg)  height(m)   \
                    Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio\n"
        .to_owned();
    for k in 0..60_u32 {
        let time_s = 0.2 * f64::from(k);
        let [latitude, longitude, height_m] = antenna_deg_m(time_s);
        let tow_s = TOW_S + late_s + time_s;
        text += &format!(
            "2390 {tow_s:.3} {latitude:.10} {longitude:.10} {height_m:.4} 1 12 0.003 0.003 0.006 0 0 0 0.2 30.0\n"
        );
    }
    text
}

#[test]
fn attitudes_of_a_log_turn_the_lever_arm_at_positions_of_another_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    fs::write(folder.join("ppk.pos"), pos(0.0)).unwrap();
    // The log's own positions are good to metres, and do not count.
    fs::write(folder.join("flight.bin"), bin(3, true)).unwrap();
    let (targets, _) = focus(folder, "ppk.pos", "").unwrap();
    assert!(off_m(&targets) > 0.2, "{targets:#}");
    let (targets, run) = focus(folder, "ppk.pos", "attitude_file = 'flight.bin'").unwrap();
    assert!(off_m(&targets) < 0.05, "{targets:#}");
    let inputs = run["inputs"].as_array().unwrap();
    let log = inputs
        .iter()
        .find(|i| i["path"].to_string().contains("flight.bin"));
    assert_eq!(log.unwrap()["sources"], "attitude of ATT");
    for name in ["attitude_clock", "attitude_place"] {
        assert_eq!(finding(&run, name)["verdict"], "agrees", "{name}");
    }
    assert!(!run["evidence"].to_string().contains("autopilot_fixed"));

    // Positions that are another second's.
    fs::write(folder.join("late.pos"), pos(2.0)).unwrap();
    let (_, run) = focus(folder, "late.pos", "attitude_file = 'flight.bin'").unwrap();
    let clock = finding(&run, "attitude_clock");
    assert_eq!(clock["verdict"], "contradicts", "{clock:#}");
    assert!(
        (clock["value"].as_f64().unwrap() + 2.0).abs() < 0.1,
        "{clock:#}"
    );
}

#[test]
fn a_gimbal_of_the_log_of_the_attitudes_weighs_as_one_of_the_log_of_the_positions() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    fs::write(
        folder.join("flight.bin"),
        bin_with_gimbal(euler_rad, [0.5, -0.1, 3.0]),
    )
    .unwrap();
    fs::write(folder.join("ppk.pos"), pos(0.0)).unwrap();
    let image = "antenna_cosine_power = 1\nantenna_axis = 'gimbal'";
    let run = Run {
        image,
        trajectory: "attitude_file = 'flight.bin'\ngimbal_source = 'MNT[0]'",
        ..Run::of("ppk.pos")
    };
    let (targets, run) = run.focus(folder).unwrap();
    assert!(off_m(&targets) < 0.05, "{targets:#}");
    assert!(
        run["inputs"]
            .to_string()
            .contains("attitude of ATT, gimbal of MNT[0]")
    );
    let expected_deg = (0.5_f64.cos() * 0.1_f64.cos()).acos().to_degrees();
    let tilt_deg = finding(&run, "antenna_tilt")["value"].as_f64().unwrap();
    assert!((tilt_deg - expected_deg).abs() < 0.01, "{tilt_deg}");
    // A log without a gimbal is refused by its name, not by that of the positions.
    fs::write(folder.join("none.bin"), bin(6, true)).unwrap();
    let run = Run {
        image,
        trajectory: "attitude_file = 'none.bin'",
        ..Run::of("ppk.pos")
    };
    let message = run.focus(folder).unwrap_err();
    assert!(
        message.contains("none.bin: no attitude of a gimbal"),
        "{message}"
    );
}

#[test]
fn attitudes_that_cannot_be_put_on_the_positions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    fs::write(folder.join("flight.bin"), bin(6, true)).unwrap();
    fs::write(folder.join("level.bin"), bin(6, false)).unwrap();
    fs::write(folder.join("ppk.pos"), pos(0.0)).unwrap();
    fs::write(folder.join("day.pos"), pos(86_400.0)).unwrap();
    fs::write(
        folder.join("table.csv"),
        "time_s,x_m,y_m,z_m\n0,0,0,4\n1,1,0,4\n",
    )
    .unwrap();
    for (positions, log, expected) in [
        (
            "day.pos",
            "flight.bin",
            "flight.bin: [trajectory] attitude_file: expected attitudes at the times of",
        ),
        (
            "ppk.pos",
            "level.bin",
            "level.bin: [trajectory] attitude_file: expected attitudes, found none",
        ),
        (
            "ppk.pos",
            "radar.npz",
            "radar.npz: not the log of an autopilot",
        ),
        ("ppk.pos", "gone.bin", "gone.bin: "),
        ("table.csv", "flight.bin", "expected positions on GPS time"),
        (
            "flight.bin",
            "flight.bin",
            "expected another file than that of the positions",
        ),
    ] {
        let message = focus(folder, positions, &format!("attitude_file = '{log}'")).unwrap_err();
        assert!(message.contains(expected), "{positions}, {log}: {message}");
    }
}

#[test]
fn init_and_info_know_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_radar(folder);
    fs::write(folder.join("flight.bin"), bin(5, true)).unwrap();
    let run = |arguments: &[&str]| {
        let output = Command::cargo_bin("acerra")
            .unwrap()
            .current_dir(folder)
            .args(arguments)
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        text
    };
    let told: Value = serde_json::from_str(&run(&["info", "--json", "flight.bin"])).unwrap();
    let told = told.to_string();
    for what in [
        "ArduPilot log",
        "GPS[0] (GNSS receiver, 120 positions)",
        "above the ellipsoid",
    ] {
        assert!(told.contains(what), "{told}");
    }
    run(&["init", "radar.npz", "flight.bin", "-o", "campaign.toml"]);
    let campaign = fs::read_to_string(folder.join("campaign.toml")).unwrap();
    assert!(campaign.contains("file = \"flight.bin\""), "{campaign}");
    assert!(
        campaign.contains("positions of GPS[0], attitude of ATT"),
        "{campaign}"
    );
    // Beside better positions the log is there for its attitudes.
    fs::write(folder.join("ppk.pos"), pos(0.0)).unwrap();
    run(&[
        "init",
        "radar.npz",
        "flight.bin",
        "ppk.pos",
        "-o",
        "ppk.toml",
    ]);
    let campaign = fs::read_to_string(folder.join("ppk.toml")).unwrap();
    for line in [
        "\nfile = \"ppk.pos\"\n",
        "\nattitude_file = \"flight.bin\"\n",
    ] {
        assert!(campaign.contains(line), "{campaign}");
    }
}
