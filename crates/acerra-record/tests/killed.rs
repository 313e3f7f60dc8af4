//! A recorder that is killed at any moment leaves a log that opens and holds all but the last second.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::emulate::{EmulatedRadio, EmulatorOptions, Pattern};
use acerra_record::log::{LogReader, RecordKind};
use acerra_record::session::{CAMPAIGN_NAME, CAPTURE_NAME, LOG_NAME, Recorder, Session, finish};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);
const SETTINGS: &str = "KILLED_RECORDER_SETTINGS";
const DIRECTORY: &str = "KILLED_RECORDER_DIRECTORY";
/// What a killed recorder may lose, and what scheduling adds on a busy computer.
const MAY_LOSE: Duration = Duration::from_millis(1_300);

/// The recorder that is killed: this test run by itself in a process of its own.
#[test]
#[ignore = "run by the other tests of this file"]
fn recorder_to_be_killed() {
    let (Ok(text), Ok(directory)) = (std::env::var(SETTINGS), std::env::var(DIRECTORY)) else {
        return;
    };
    let session = Session::parse(&text).unwrap();
    let stop = AtomicBool::new(false);
    let recorder = Recorder {
        session: &session,
        text: &text,
        directory: Path::new(&directory),
        stop: &stop,
        requests: RequestOptions::default(),
        watch: WatchOptions::default(),
        tap: None,
    };
    recorder.run(&mut |_| {}).unwrap();
}

/// An emulated radio, and the settings of a session with it.
fn emulated() -> (EmulatedRadio, String) {
    let source = Box::new(Pattern::new(1_000_000));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, EmulatorOptions::default()).unwrap();
    let text = format!(
        "[radio]\naddress = \"{}\"\nwindow_ps = [0, 17000]\nscan_interval_ms = 5.0\n",
        radio.address()
    );
    (radio, text)
}

/// Kills a recorder after `after`, and checks what it left.
fn kill_after(after: Duration) {
    let (radio, text) = emulated();
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "recorder_to_be_killed", "--ignored"])
        .env(SETTINGS, &text)
        .env(DIRECTORY, folder.path())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let began = Instant::now();
    let mut sent = Vec::new();
    while began.elapsed() < after {
        sent.push((Instant::now(), radio.counts().scans));
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    let killed = Instant::now();
    child.wait().unwrap();
    let path = folder.path().join(LOG_NAME);
    let Ok(file) = std::fs::File::open(&path) else {
        assert!(
            sent.iter().all(|(_, scans)| *scans == 0),
            "no log, but scans"
        );
        return;
    };
    let mut reader = LogReader::new(file).unwrap();
    let mut scans = 0;
    while let Some(record) = reader.next_record().unwrap() {
        scans += u64::from(record.kind == RecordKind::Radio && record.payload.len() == 1452);
    }
    assert_eq!(reader.damage().damaged_places, 0);
    let a_second_before = sent
        .iter()
        .rev()
        .find(|(at, _)| killed.duration_since(*at) >= MAY_LOSE)
        .map_or(0, |(_, scans)| *scans);
    assert!(
        scans + 2 >= a_second_before,
        "{scans} scans in the log, {a_second_before} sent a second before the end"
    );
    // The settings may not have reached the disk yet.
    if scans > 0 {
        let finished = finish(folder.path()).unwrap();
        assert!(!finished.ended_in_order);
        assert_eq!(finished.scans, scans);
    }
}

fn kill_many(times: u64, workers: u64) {
    std::thread::scope(|scope| {
        for worker in 0..workers {
            scope.spawn(move || {
                let mut random = ChaCha8Rng::seed_from_u64(worker);
                for _ in 0..times / workers {
                    kill_after(Duration::from_millis(random.random_range(10..3_000)));
                }
            });
        }
    });
}

#[test]
fn a_recorder_killed_at_random_loses_a_second_at_most() {
    kill_many(24, 8);
}

#[test]
#[ignore = "200 runs"]
fn validation_two_hundred_kills() {
    kill_many(200, 8);
}

/// What is killed while it finishes: this test run by itself in a process of its own.
#[test]
#[ignore = "run by the other tests of this file"]
fn finisher_to_be_killed() {
    let Ok(directory) = std::env::var(DIRECTORY) else {
        return;
    };
    finish(Path::new(&directory)).unwrap();
}

/// Kills the making of a recording's files at moments all over it, and looks at what is there.
fn kill_finishing(times: u32) {
    let (_radio, text) = emulated();
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let began = Instant::now();
    let recorder = Recorder {
        session: &Session::parse(&text).unwrap(),
        text: &text,
        directory: folder.path(),
        stop: &stop,
        requests: RequestOptions::default(),
        watch: WatchOptions::default(),
        tap: None,
    };
    let stopping = &mut |_| {
        stop.store(began.elapsed() > Duration::from_secs(2), Ordering::SeqCst);
    };
    recorder.run(stopping).unwrap();
    let finishing = || {
        Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "finisher_to_be_killed", "--ignored"])
            .env(DIRECTORY, folder.path())
            .stdout(Stdio::null())
            .spawn()
            .unwrap()
    };
    let began = Instant::now();
    assert!(finishing().wait().unwrap().success());
    let whole_run = began.elapsed();
    let read = |name: &str| std::fs::read(folder.path().join(name)).ok();
    let whole = [CAPTURE_NAME, CAMPAIGN_NAME].map(|name| read(name).unwrap());
    assert!(whole[0].len() > 100_000, "{}", whole[0].len());
    for k in 0..times {
        for name in [CAPTURE_NAME, CAMPAIGN_NAME] {
            let _ = std::fs::remove_file(folder.path().join(name));
        }
        let mut child = finishing();
        std::thread::sleep(whole_run * k / times);
        child.kill().unwrap();
        child.wait().unwrap();
        for (name, whole) in [CAPTURE_NAME, CAMPAIGN_NAME].iter().zip(&whole) {
            // Nothing cut stands under the name.
            assert!(
                read(name).is_none_or(|found| found == *whole),
                "{k}: {name}"
            );
        }
    }
    finish(folder.path()).unwrap();
    assert!([CAPTURE_NAME, CAMPAIGN_NAME].map(read) == whole.map(Some));
}

#[test]
fn files_of_a_recording_are_whole_or_absent_whenever_their_making_is_killed() {
    kill_finishing(24);
}

#[test]
#[ignore = "200 runs"]
fn validation_two_hundred_kills_of_finishing() {
    kill_finishing(200);
}
