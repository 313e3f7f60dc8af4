//! `acerra emulate`, `record` and `focus` as a user runs them.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::fs;
use std::io::{BufRead, BufReader};
use std::net::{TcpListener, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

use acerra_npz::NpzReader;
use serde_json::Value;

/// A short flight with receivers, recorded from take-off to landing. Antennas on ground planes let half a minute
/// of log fix its ambiguities.
const SCENE: &str = "seed = 3\nrecord = \"flight\"\n\
    [flight]\ntrack_start_m = [0, 0]\ntrack_end_m = [8, 0]\nheight_m = 4\ntrack_duration_s = 6\n\
    [radar]\nsamples = 960\n[ground]\nfacets_per_m2 = 1\nextent_m = 5\n[gnss]\n\
    [gnss.rover]\ncode_multipath_m = 0.3\n[gnss.base]\ncode_multipath_m = 0.3\n\
    [[corner]]\nposition_m = [3, 1.5, 0]\n\
    [image]\nx_m = [2, 4]\ny_m = [0.5, 2.5]\npixel_m = 0.02\n";

/// GPS week of simulated scenes.
const SCENE_WEEK: i64 = 2075;

fn acerra() -> Command {
    Command::new(env!("CARGO_BIN_EXE_acerra"))
}

fn run(arguments: &[&str]) -> Output {
    acerra().args(arguments).output().unwrap()
}

fn succeeds(arguments: &[&str]) -> String {
    let output = run(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {told}");
    String::from_utf8_lossy(&output.stdout).into_owned() + &told
}

/// A child that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn path(folder: &Path, name: &str) -> String {
    folder.join(name).display().to_string()
}

/// Place of the strongest target (m).
fn target_m(products: &Path) -> [f64; 2] {
    let text = fs::read_to_string(products.join("targets.json")).unwrap();
    let targets: Value = serde_json::from_str(&text).unwrap();
    ["x_m", "y_m"].map(|key| targets["targets"][0][key].as_f64().unwrap())
}

/// Largest modulus of an image (dB).
fn peak_db(products: &Path) -> f64 {
    let file = fs::File::open(products.join("image.npz")).unwrap();
    let (_, image) = NpzReader::new(file)
        .unwrap()
        .values("image", 1 << 20)
        .unwrap();
    let largest = image
        .iter()
        .map(|(re, im)| re.hypot(*im))
        .fold(0.0, f64::max);
    20.0 * largest.log10()
}

/// Ports that were free a moment ago: the radio's and the receiver's.
fn free_ports() -> [String; 2] {
    let radio = UdpSocket::bind("127.0.0.1:0").unwrap();
    let receiver = TcpListener::bind("127.0.0.1:0").unwrap();
    [radio.local_addr().unwrap(), receiver.local_addr().unwrap()].map(|a| a.to_string())
}

/// An emulator of `scene`, and the session file that it writes.
fn emulated(folder: &Path, scene: &str) -> (Running, String) {
    let [radio, receiver] = free_ports();
    let mut emulator = Running(
        acerra()
            .args(["emulate", scene, "-o", &path(folder, "ground")])
            .args(["--radio", &radio, "--receiver", &receiver])
            .args(["--speed", "4", "--drift-ppm", "20", "--jitter-ms", "5"])
            .args(["--loss", "0.002", "--reordering", "0.01", "--seed", "2"])
            .args(["--marks", "--mark-loss", "0.1"])
            .args([
                "--receiver-latency-ms",
                "60",
                "--pps",
                &path(folder, "pulses"),
            ])
            .args(["--pps-loss", "0.05"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let output = emulator.0.stdout.take().unwrap();
    let mut session = String::new();
    for line in BufReader::new(output).lines() {
        session += &(line.unwrap() + "\n");
        // The last key of the last table.
        if session.contains("origin_deg_m") {
            break;
        }
    }
    (emulator, session)
}

/// The recording as one file: `info` tells the scans and bytes that the other files hold.
fn check_mcap(flight: &Path) {
    let info = |name: &str| -> Value {
        let told = succeeds(&["info", "--json", &flight.join(name).display().to_string()]);
        serde_json::from_str(&told).unwrap()
    };
    let (mcap, capture) = (info("session.mcap"), info("radar.mrm"));
    println!("{mcap}\n{capture}");
    let text = mcap.to_string();
    assert!(text.contains("recorded session (MCAP)"), "{text}");
    let fact = |name: &str| mcap_fact(&mcap, name);
    let scans = fact("/radar/scan");
    let count: u64 = scans.split(' ').next().unwrap().parse().unwrap();
    assert!(
        count > 300 && scans.ends_with("acerra_msgs/msg/Scan"),
        "{scans}"
    );
    assert!(fact("/clock/fit").starts_with("1 messages"));
    assert!(fact("/clock/pulse").ends_with("acerra_msgs/msg/Pulse"));
    assert!(!text.contains("cut off"), "{text}");
}

/// A fact of the only file that is told about.
fn mcap_fact(told: &Value, name: &str) -> String {
    let told = told.as_array().map_or(told, |files| &files[0]);
    let fact = &told["facts"][name];
    fact.as_str()
        .unwrap_or_else(|| panic!("{name}: {told}"))
        .to_owned()
}

#[test]
fn an_emulated_flight_is_recorded_and_focused_as_with_perfect_times() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let scene = path(folder, "scene.toml");
    let (emulator, session) = emulated(folder, &scene);
    let session = session.replace("[flight]\n", "[flight]\nstop_after_s = 11.0\n");
    fs::write(folder.join("session.toml"), &session).unwrap();
    let session_text = session;
    let flight = path(folder, "flight");
    let session = path(folder, "session.toml");
    let told = succeeds(&["record", &session, "-o", &flight, "--mcap"]);
    println!("{told}");
    drop(emulator);
    check_mcap(Path::new(&flight));
    let clock = fs::read_to_string(Path::new(&flight).join("radar.clock.json")).unwrap();
    println!("{clock}");
    let clock: Value = serde_json::from_str(&clock).unwrap();
    // Without the pulses the latency, which no session states, is too unsure for marks.
    assert!(session_text.contains("pps = ") && !session_text.contains("latency_sigma_ms = 2"));
    assert!(clock["marks"].as_u64().unwrap() >= 16);
    assert!(clock["pulses"].as_u64().unwrap() >= 16);
    let latency_s = clock["gnss_latency_s"].as_f64().unwrap();
    assert!((latency_s - 0.060).abs() < 3e-3, "{latency_s}");
    assert!(told.contains("GPS time rests on "), "{told}");
    // The flight begins at 207 000 s of the week, the radio is 20 ppm fast.
    let offset_s = clock["time_offset_s"].as_f64().unwrap();
    assert!((offset_s - 207_000.0).abs() < 2e-3, "{offset_s}");

    let [recorded, perfect] = ["recorded", "perfect"].map(|name| folder.join(name));
    succeeds(&[
        "focus",
        &path(Path::new(&flight), "campaign.toml"),
        "-o",
        &recorded.display().to_string(),
    ]);
    succeeds(&["simulate", &scene, "-o", &path(folder, "truth")]);
    succeeds(&[
        "focus",
        &path(&folder.join("truth"), "campaign.toml"),
        "-o",
        &perfect.display().to_string(),
    ]);
    let [found_m, expected_m] = [&recorded, &perfect].map(|products| target_m(products));
    let [found_db, expected_db] = [&recorded, &perfect].map(|products| peak_db(products));
    println!("{found_m:?} {expected_m:?} m; {found_db:.3} {expected_db:.3} dB");
    assert!((found_db - expected_db).abs() < 0.2);
    for (found, expected) in found_m.into_iter().zip(expected_m) {
        assert!((found - expected).abs() < 0.01);
    }

    // The same time of another week is another time.
    let file = Path::new(&flight).join("radar.clock.json");
    let week = clock["gps_week"].as_i64().unwrap();
    let text = fs::read_to_string(&file).unwrap();
    let [right, wrong] = [week, week + 1].map(|week| format!("\"gps_week\": {week}"));
    assert!(text.contains(&right));
    fs::write(&file, text.replace(&right, &wrong)).unwrap();
    let output = run(&["focus", &path(Path::new(&flight), "campaign.toml")]);
    println!("{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(1));
}

/// A clock that is asked for and is not there, or is another log's.
#[test]
fn a_clock_that_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    succeeds(&[
        "simulate",
        &path(folder, "scene.toml"),
        "-o",
        &path(folder, "logs"),
    ]);
    let logs = folder.join("logs");
    let text = fs::read_to_string(logs.join("campaign.toml")).unwrap();
    let text = text.replace("time_offset_s = 207000", "time_offset_s = \"logged\"");
    fs::write(logs.join("campaign.toml"), text).unwrap();
    let refused = || {
        let output = run(&["focus", &path(&logs, "campaign.toml")]);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let told = refused();
    assert!(
        told.contains(
            "radar.clock.json: [trajectory] time_offset_s = \"logged\": expected the clock"
        ),
        "{told}"
    );
    let other = "{\"version\": 1, \"first_message_id\": 9, \"first_timestamp_ms\": 7, \"gps_week\": 2075, \
                 \"time_offset_s\": 7.0, \"rate\": 1.0, \"sigma_stamps_s\": 0.0, \"sigma_s\": 0.0, \
                 \"radio_jitter_s\": 0.0, \"gnss_jitter_s\": 0.0, \"radio_latency_s\": 0.0, \
                 \"gnss_latency_s\": 0.0}";
    fs::write(logs.join("radar.clock.json"), other).unwrap();
    let told = refused();
    assert!(told.contains("begins with scan (9, 7)"), "{told}");
}

/// Number and stamp of the first scan of a capture.
fn first_scan(capture: &Path) -> (u16, u32) {
    let file = BufReader::new(fs::File::open(capture).unwrap());
    let log = acerra_radar::mrm::read_mrm(file, &acerra_radar::Limits::default()).unwrap();
    (log.scans[0].message_id, log.scans[0].timestamp_ms)
}

fn finding(run: &Value, name: &str) -> Value {
    let findings = run["evidence"].as_array().unwrap();
    let found = findings.iter().find(|finding| finding["name"] == name);
    found.cloned().unwrap_or(Value::Null)
}

/// Where nothing is stated the clock beside the radar log is taken; a stated offset wins; a clock of another
/// time is refused.
#[test]
fn a_recorded_clock_is_taken_where_no_offset_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let logs = folder.join("logs");
    let scene = path(folder, "scene.toml");
    succeeds(&["simulate", &scene, "-o", &logs.display().to_string()]);
    let (first_message_id, first_timestamp_ms) = first_scan(&logs.join("radar.mrm"));
    let mut clock = acerra_radar::LoggedClock {
        version: acerra_radar::LoggedClock::VERSION,
        first_message_id,
        first_timestamp_ms,
        gps_week: SCENE_WEEK,
        time_offset_s: 207_000.0,
        rate: 1.0,
        sigma_stamps_s: 1e-4,
        sigma_s: 0.01,
        radio_jitter_s: 0.0,
        gnss_jitter_s: 0.0,
        radio_latency_s: 0.0,
        gnss_latency_s: 0.0,
        marks: 0,
        pulses: 0,
    };
    let campaign = fs::read_to_string(logs.join("campaign.toml")).unwrap();
    let focus = |offset: &str, clock: &acerra_radar::LoggedClock| {
        fs::write(logs.join("radar.clock.json"), clock.to_json()).unwrap();
        let text = campaign.replace("time_offset_s = 207000\n", offset);
        assert_ne!(text, campaign);
        fs::write(logs.join("campaign.toml"), text).unwrap();
        let products = folder.join("products");
        let output = run(&[
            "focus",
            &path(&logs, "campaign.toml"),
            "-o",
            &products.display().to_string(),
        ]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        let told = told + &String::from_utf8_lossy(&output.stdout);
        let record = fs::read_to_string(products.join("run.json")).unwrap_or_default();
        let record: Value = serde_json::from_str(&record).unwrap_or_default();
        (output.status.code(), told, record)
    };

    let (code, told, record) = focus("", &clock);
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("(recorded clock, ± 10.00 ms)"), "{told}");
    assert_eq!(record["time_offset_s"], 207_000.0);
    assert_eq!(record["recorded_clock"]["sigma_s"], 0.01);
    assert_eq!(
        record["configuration"]["trajectory"]["time_offset_s"],
        "logged"
    );
    // 8 m in 6 s, ± 10 ms: 13 mm along the track.
    let along = finding(&record, "clock_offset_sigma");
    let along_m = along["value"].as_f64().unwrap();
    assert!((along_m - 0.0133).abs() < 1e-3, "{along}");
    let loss = finding(&record, "position_sigma");
    assert!(
        loss["explanation"]
            .as_str()
            .unwrap()
            .contains("by the recorded clock"),
        "{loss}"
    );

    let (code, told, record) = focus("time_offset_s = 207000.01\n", &clock);
    assert_eq!(code, Some(0), "{told}");
    assert_eq!(record["time_offset_s"], 207_000.01);
    assert_eq!(record["recorded_clock"], Value::Null);
    assert_eq!(finding(&record, "clock_offset_sigma"), Value::Null);

    clock.gps_week += 1;
    let (code, told, _) = focus("", &clock);
    assert_eq!(code, Some(1), "{told}");
    assert!(told.contains("do not overlap"), "{told}");
}

#[test]
fn a_window_that_cannot_hold_the_ground_is_refused_before_the_radio_is_asked() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let session =
        "[radio]\naddress = \"127.0.0.1:1\"\nwindow_ps = [0, 20000]\n[flight]\nheight_m = 50.0\n";
    fs::write(folder.join("session.toml"), session).unwrap();
    let output = run(&[
        "record",
        &path(folder, "session.toml"),
        "-o",
        &path(folder, "flight"),
    ]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("session.toml: [radio] window_ps: the ground 50 m below answers at"),
        "{told}"
    );
    assert!(!folder.join("flight").exists());
}

/// A session of an emulator that records until it is ended, in a file.
fn session_file(folder: &Path) -> (Running, String) {
    let scene = path(folder, "scene.toml");
    fs::write(&scene, SCENE).unwrap();
    let (emulator, session) = emulated(folder, &scene);
    let file = path(folder, "session.toml");
    fs::write(&file, session).unwrap();
    (emulator, file)
}

/// Waits until the file is longer than `bytes`.
fn wait_for(file: &str, bytes: u64) {
    for _ in 0..600 {
        if fs::metadata(file).is_ok_and(|found| found.len() > bytes) {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    panic!("{file} has not grown beyond {bytes} bytes within 30 s");
}

#[test]
fn two_recordings_into_one_directory_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let (_emulator, session) = session_file(folder.path());
    let flight = path(folder.path(), "flight");
    let log = path(folder.path(), "flight/session.log");
    let record = || {
        let mut command = acerra();
        command.args(["record", &session, "-o", &flight]);
        command.stderr(Stdio::null()).stdout(Stdio::null());
        command
    };
    let mut first = Running(record().spawn().unwrap());
    wait_for(&log, 100_000);
    let second = run(&["record", &session, "-o", &flight]);
    let told = String::from_utf8_lossy(&second.stderr).into_owned();
    assert_eq!(second.status.code(), Some(1), "{told}");
    assert!(told.contains("another recording writes this log"), "{told}");
    // A kill lets go of the lock, and what was recorded is gone on with.
    first.0.kill().unwrap();
    first.0.wait().unwrap();
    let length = fs::metadata(&log).unwrap().len();
    let third = Running(record().spawn().unwrap());
    wait_for(&log, length + 100_000);
    drop(third);
    let told = succeeds(&["record", "--finish", &flight]);
    assert!(
        told.contains("0 damaged bytes") || !told.contains("damaged"),
        "{told}"
    );
    assert!(!Path::new(&path(folder.path(), "flight/.radar.mrm.part")).exists());
}

/// The system stops the writing of a file beyond a limit of its size by a signal, which would end the program
/// without a word.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (_emulator, session) = session_file(folder.path());
    let flight = path(folder.path(), "flight");
    let limited = format!(
        "ulimit -f 200; exec {} record {session} -o {flight}",
        env!("CARGO_BIN_EXE_acerra")
    );
    let ended = Command::new("sh").args(["-c", &limited]).output().unwrap();
    let told = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(1), "{told}");
    assert!(
        told.contains("session.log: the file system accepts no longer file"),
        "{told}"
    );
}
