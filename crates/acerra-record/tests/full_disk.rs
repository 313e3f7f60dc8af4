//! A disk that is full, or takes no longer file, in the middle of a recording.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::emulate::{EmulatedRadio, EmulatorOptions, Pattern};
use acerra_record::log::{LogReader, LogWriteError, RecordKind};
use acerra_record::session::{
    CAPTURE_NAME, LOG_NAME, Progress, RecordError, Recorder, Session, finish,
};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);
const SETTINGS: &str = "FULL_DISK_SETTINGS";
const DIRECTORY: &str = "FULL_DISK_DIRECTORY";
/// What fills the disk until it is removed.
const BALLAST: &str = "ballast";

/// Records into `directory`, for `seconds` at most.
fn record(text: &str, directory: &Path, seconds: f64) -> Result<u64, RecordError> {
    let session = Session::parse(text).unwrap();
    let stop = AtomicBool::new(false);
    let recorder = Recorder {
        session: &session,
        text,
        directory,
        stop: &stop,
        requests: RequestOptions::default(),
        watch: WatchOptions::default(),
        tap: None,
    };
    let began = Instant::now();
    let health = recorder.run(&mut |progress| {
        if let Progress::Warning(text) = &progress {
            println!("{text}");
        }
        stop.store(began.elapsed().as_secs_f64() > seconds, Ordering::SeqCst);
    })?;
    Ok(health.radio.whole_scans)
}

/// Scans of the log, all of whose records are sound but for a torn end.
fn scans_in_log(directory: &Path) -> u64 {
    let mut reader = LogReader::new(fs::File::open(directory.join(LOG_NAME)).unwrap()).unwrap();
    let mut scans = 0;
    while let Some(record) = reader.next_record().unwrap() {
        scans += u64::from(record.kind == RecordKind::Radio && record.payload.len() == 1452);
    }
    assert_eq!(reader.damage().damaged_places, 0);
    scans
}

/// The recorder on a file system of its own: full, then with space again.
#[test]
#[ignore = "run by another test of this file"]
fn recorder_on_a_full_disk() {
    let (Ok(text), Ok(directory)) = (std::env::var(SETTINGS), std::env::var(DIRECTORY)) else {
        return;
    };
    let disk = Path::new(&directory);
    let flight = disk.join("flight");
    let error = record(&text, &flight, 60.0).unwrap_err();
    assert!(
        matches!(error, RecordError::Log(LogWriteError::DiskFull { .. })),
        "{error}"
    );
    assert!(error.to_string().contains("session.log: the disk is full"));
    let kept = scans_in_log(&flight);
    assert!(kept > 300, "{kept}");
    // The capture has no room either: said, and nothing of the log is touched.
    let error = finish(&flight).unwrap_err().to_string();
    assert!(error.contains(&flight.display().to_string()), "{error}");
    assert_eq!(scans_in_log(&flight), kept);
    fs::remove_file(disk.join(BALLAST)).unwrap();
    // The same command goes on.
    let more = record(&text, &flight, 1.5).unwrap();
    let finished = finish(&flight).unwrap();
    assert!(finished.ended_in_order && more > 20);
    assert_eq!(finished.scans, scans_in_log(&flight));
    assert!(finished.scans >= kept + more);
    assert!(flight.join(CAPTURE_NAME).exists());
    println!("{kept} scans on the full disk, {more} later");
}

/// The recorder where files may not grow beyond a limit.
#[test]
#[ignore = "run by another test of this file"]
fn recorder_under_a_limit() {
    let (Ok(text), Ok(directory)) = (std::env::var(SETTINGS), std::env::var(DIRECTORY)) else {
        return;
    };
    let flight = Path::new(&directory).join("flight");
    let error = record(&text, &flight, 60.0).unwrap_err();
    assert!(
        matches!(error, RecordError::Log(LogWriteError::FileTooLong { .. })),
        "{error}"
    );
    let kept = scans_in_log(&flight);
    assert!(kept > 300, "{kept}");
}

/// A radio, and the settings that record it: scans of one message, 800 a second.
fn radio() -> (EmulatedRadio, String) {
    let options = EmulatorOptions {
        speed: 4.0,
        ..EmulatorOptions::default()
    };
    let source = Box::new(Pattern::new(1_000_000));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, options).unwrap();
    let text = format!(
        "[radio]\naddress = \"{}\"\nwindow_ps = [0, 17000]\nscan_interval_ms = 5.0\n",
        radio.address()
    );
    (radio, text)
}

/// Runs a test of this file in a process of its own, started by a shell's `script` as `"$@"`.
fn run_by(shell: &mut Command, script: &str, test: &str, directory: &Path, text: &str) -> Output {
    shell
        .args(["-c", script, "sh"])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", test, "--ignored", "--nocapture"])
        .env(SETTINGS, text)
        .env(DIRECTORY, directory)
        .output()
        .unwrap()
}

fn passed(output: &Output) {
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = told + &String::from_utf8_lossy(&output.stderr);
    println!("{told}");
    assert!(output.status.success() && told.contains("1 passed"));
}

/// In a name space of its own for mounts, as whoever runs the tests.
fn with_own_mounts() -> Command {
    let mut unshare = Command::new("unshare");
    unshare.args(["--user", "--map-root-user", "--mount", "sh"]);
    unshare
}

#[test]
fn a_full_disk_ends_the_recording_and_space_lets_it_go_on() {
    let folder = tempfile::tempdir().unwrap();
    let mount = format!(
        "mount -t tmpfs -o size=10m none {0} && head -c 8000000 /dev/zero > {0}/{BALLAST}",
        folder.path().display()
    );
    let can_mount = with_own_mounts().args(["-c", &mount]).output();
    if !can_mount.is_ok_and(|output| output.status.success()) {
        println!("skipped: no file system can be mounted here (unshare, tmpfs)");
        return;
    }
    let (_radio, text) = radio();
    let script = format!("{mount} && exec \"$@\"");
    let mut shell = with_own_mounts();
    let output = run_by(
        &mut shell,
        &script,
        "recorder_on_a_full_disk",
        folder.path(),
        &text,
    );
    passed(&output);
}

#[test]
fn a_limit_of_files_ends_the_recording_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let (_radio, text) = radio();
    // Blocks of 512 bytes (POSIX) or 1024 (bash).
    let script = "trap '' XFSZ; ulimit -f 2000; exec \"$@\"";
    let mut shell = Command::new("sh");
    let output = run_by(
        &mut shell,
        script,
        "recorder_under_a_limit",
        folder.path(),
        &text,
    );
    passed(&output);
    assert!(scans_in_log(&folder.path().join("flight")) > 300);
}
