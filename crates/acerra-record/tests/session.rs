//! Whole sessions: emulated instruments, recorder, log, and the files that `focus` takes.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures, and why a test is skipped

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::frame::encode;
use acerra_radar::LoggedClock;
use acerra_record::driver::{RequestOptions, WatchOptions};
use acerra_record::emulate::{
    EmulatedPps, EmulatedRadio, EmulatedReceiver, EmulatorOptions, Impairments, Pattern,
    PpsOptions, PulseLine, ReceiverOptions, Recorded, World,
};
use acerra_record::log::{LogReader, LogWriter, RecordKind};
use acerra_record::session::{
    CAPTURE_NAME, Finished, Health, LOG_NAME, Progress, ROVER_NAME, Recorder, Session, finish,
};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);

fn shared(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(file);
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
        return None;
    }
    Some(path)
}

/// Records until `is_over`, and finishes.
fn record(text: &str, directory: &Path, is_over: impl Fn() -> bool) -> (Health, Finished) {
    let session = Session::parse(text).unwrap();
    let stop = AtomicBool::new(false);
    let recorder = Recorder {
        session: &session,
        text,
        directory,
        stop: &stop,
        requests: RequestOptions {
            timeout: Duration::from_millis(200),
            attempts: 5,
        },
        watch: WatchOptions {
            silence: Duration::from_millis(500),
            retry: Duration::from_millis(50),
            status_every: Duration::ZERO,
        },
        tap: None,
    };
    let began = Instant::now();
    let health = recorder
        .run(&mut |progress| {
            assert!(began.elapsed() < Duration::from_secs(100), "stalled");
            if let Progress::Warning(text) | Progress::Note(text) = &progress {
                println!("{text}");
            }
            if is_over() {
                stop.store(true, Ordering::SeqCst);
            }
        })
        .unwrap();
    (health, finish(directory).unwrap())
}

fn radio_table(radio: &EmulatedRadio, recorded_window_ps: [i32; 2]) -> String {
    format!(
        "[radio]\naddress = \"{}\"\nwindow_ps = {recorded_window_ps:?}\nlatency_ms = 0.0\n",
        radio.address()
    )
}

/// A capture's bytes after emulator, driver and log, what was made of the log, and how many datagrams the
/// system dropped on the way.
fn replayed(file: &str, bytes: &[u8], speed: f64) -> (Vec<u8>, Finished, u64) {
    let recorded = Recorded::from_capture(bytes)
        .expect("a bare capture")
        .unwrap();
    let config = recorded.config();
    let options = EmulatorOptions {
        speed,
        impairments: Impairments {
            repetition: 0.02,
            reordering: 0.05,
            held_back_s: 0.03,
            seed: 3,
            ..Impairments::default()
        },
        ..EmulatorOptions::default()
    };
    let radio = EmulatedRadio::start(LOOPBACK.into(), Box::new(recorded), options).unwrap();
    let window_ps = [config.scan_start_ps, config.scan_stop_ps];
    let text = radio_table(&radio, window_ps)
        + &format!(
            "antenna_mode = {}\ntransmit_gain = {}\ncode_channel = {}\n",
            config.antenna_mode, config.transmit_gain, config.code_channel
        );
    let folder = tempfile::tempdir().unwrap();
    let (health, finished) = record(&text, folder.path(), || radio.counts().exhausted);
    println!("{file}, {speed} times as fast: {}", health.radio);
    let found = fs::read(folder.path().join(CAPTURE_NAME)).unwrap();
    let dropped = radio.counts().datagrams - health.radio.packets;
    (found, finished, dropped)
}

/// The radio's and the receiver's bytes come through emulator, driver and log as they were.
#[test]
fn real_captures_come_back_identical() {
    for file in [
        "uav-flight-2019/flight.mrm",
        "corner-reflector-captures/July19-CornerReflector-scan01.out",
        "corner-reflector-captures/July19-CornerReflector-scan07.out",
    ] {
        let Some(path) = shared(file) else { return };
        let bytes = fs::read(&path).unwrap();
        // A busy machine drops datagrams before any program sees them: slower, fewer wait at once.
        let (found, finished) = [8.0, 4.0, 1.0]
            .into_iter()
            .map(|speed| replayed(file, &bytes, speed))
            .find(|(_, _, dropped)| *dropped == 0)
            .map(|(found, finished, _)| (found, finished))
            .expect("a replay of which the system dropped nothing");
        // Node, segments and persistence are not settings of a session; messages follow.
        assert_eq!(found[4..16], bytes[4..16]);
        let whole = 32 + (bytes.len() - 32) / 1452 * 1452;
        assert!(found[32..] == bytes[32..whole], "{file}");
        assert_eq!(
            finished.damage.torn_bytes + finished.damage.damaged_bytes,
            0
        );
        assert!(finished.ended_in_order);
    }
}

#[test]
fn a_receivers_bytes_come_back_identical() {
    let Some(path) = shared("gnss-walk-m8p/rover.ubx.gz") else {
        return;
    };
    let mut log = Vec::new();
    let file = fs::File::open(path).unwrap();
    flate2::read::GzDecoder::new(file)
        .read_to_end(&mut log)
        .unwrap();
    let world = World::new(1000.0);
    world.begin();
    let receiver = EmulatedReceiver::start(
        LOOPBACK.into(),
        log.clone(),
        ReceiverOptions::new(world.clone()),
    )
    .unwrap();
    let source = Pattern::new(1_000_000);
    let options = EmulatorOptions::default();
    let radio = EmulatedRadio::start(LOOPBACK.into(), Box::new(source), options).unwrap();
    let text = radio_table(&radio, [0, 11_000])
        + &format!(
            "scan_interval_ms = 50.0\n[gnss]\naddress = \"{}\"\nreceiver = \"m8t\"\n",
            receiver.address()
        );
    let folder = tempfile::tempdir().unwrap();
    let (health, _) = record(&text, folder.path(), || receiver.is_finished());
    let found = fs::read(folder.path().join(ROVER_NAME)).unwrap();
    println!(
        "{} bytes of the log, {} in the session",
        log.len(),
        found.len()
    );
    assert_eq!(health.gnss_bytes, found.len() as u64);
    // Acknowledgements of the configuration come before, between bursts of the log.
    let mut at = 0;
    let acknowledged = encode(5, 1, &[6, 1]).unwrap().len() * 5;
    let longest = found.iter().filter(|byte| {
        let is_next = log.get(at) == Some(byte);
        at += usize::from(is_next);
        is_next
    });
    assert_eq!(
        longest.count(),
        log.len(),
        "each byte of the log in its order"
    );
    assert_eq!(found.len(), log.len() + acknowledged);
}

/// A receiver's log: RXM-RAWX with nine satellites, five times a second from second 1000 of week 2345.
fn receiver_log(seconds: u32) -> Vec<u8> {
    let mut log = Vec::new();
    for epoch in 0..5 * seconds {
        let mut payload = vec![0; 16 + 9 * 32];
        payload[..8].copy_from_slice(&(1000.0 + 0.2 * f64::from(epoch)).to_le_bytes());
        payload[8..10].copy_from_slice(&2345_u16.to_le_bytes());
        payload[11] = 9;
        payload[13] = 1;
        for (k, signal) in payload[16..].chunks_mut(32).enumerate() {
            (signal[21], signal[30]) = (k as u8 + 1, 1);
        }
        log.extend(encode(0x02, 0x15, &payload).unwrap());
    }
    log
}

/// Instruments of one world, and the session that records them.
fn instruments(
    receiver: ReceiverOptions,
    seconds: u32,
    radio: EmulatorOptions,
) -> (EmulatedRadio, EmulatedReceiver, String) {
    let log = receiver_log(seconds);
    let receiver = EmulatedReceiver::start(LOOPBACK.into(), log, receiver).unwrap();
    let source = Box::new(Pattern::new(20 * u64::from(seconds)));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, radio).unwrap();
    let text = radio_table(&radio, [0, 11_000])
        + &format!(
            "scan_interval_ms = 50.0\nlatency_sigma_ms = 0.0\nmark_delay_ms = 0.0\n[gnss]\naddress = \"{}\"\n\
             latency_sigma_ms = 2.0\n",
            receiver.address()
        );
    (radio, receiver, text)
}

/// What was told, as the log has it.
fn events(directory: &Path) -> Vec<String> {
    let mut reader = LogReader::new(fs::File::open(directory.join(LOG_NAME)).unwrap()).unwrap();
    let mut events = Vec::new();
    while let Some(record) = reader.next_record().unwrap() {
        if record.kind == RecordKind::Note {
            events.push(String::from_utf8(record.payload).unwrap());
        }
    }
    events
}

/// A receiver that loses its fix for four seconds: told, an event of the log, and told when it is over.
#[test]
fn a_lost_fix_is_told_and_logged() {
    let world = World::new(1.0);
    let receiver = ReceiverOptions {
        no_fix_s: vec![[1.0, 5.0]],
        ..ReceiverOptions::new(world.clone())
    };
    let options = EmulatorOptions {
        world: Some((world, 0.0)),
        ..EmulatorOptions::default()
    };
    let (_radio, receiver, text) = instruments(receiver, 7, options);
    let folder = tempfile::tempdir().unwrap();
    let (health, _) = record(&text, folder.path(), || receiver.is_finished());
    let fix = health.fix.unwrap();
    assert_eq!((fix.has_fix, fix.satellites), (true, 9));
    let events = events(folder.path());
    let about = |what: &str| {
        let found = events.iter().position(|event| event.contains(what));
        found.unwrap_or_else(|| panic!("{what}: {events:?}"))
    };
    let stamped = about("its messages are stamped by");
    let first = about("the GNSS receiver has a fix: 9 satellites");
    let lost = about("no GNSS fix for 2 s, 0 satellites");
    let back = about("the GNSS receiver has a fix after 4 s without: 9 satellites");
    assert!(stamped < lost && first < lost && lost < back, "{events:?}");
    if cfg!(target_os = "linux") {
        assert!(health.kernel_stamped > 0, "{health:?}");
        assert!(health.kernel_stamped <= health.radio.packets);
    }
}

/// The radio's pulses on the receiver's time-mark input, a fifth of them lost, put the traces on GPS time
/// far better than times of arrival do.
#[test]
fn time_marks_are_used_where_the_radio_is_wired() {
    let pulses = PulseLine::new(0.2, 5);
    let world = World::new(4.0);
    let receiver = ReceiverOptions {
        pulses: Some(pulses.clone()),
        ..ReceiverOptions::new(world.clone())
    };
    let options = EmulatorOptions {
        world: Some((world, 1.5)),
        drift_ppm: 200.0,
        pulses: Some(pulses),
        impairments: Impairments {
            loss: 0.02,
            jitter_s: 0.004,
            ..Impairments::default()
        },
        ..EmulatorOptions::default()
    };
    let (_radio, receiver, text) = instruments(receiver, 24, options);
    let folder = tempfile::tempdir().unwrap();
    let (_, finished) = record(&text, folder.path(), || receiver.is_finished());
    println!("{:?}", finished.remarks);
    let clock = finished.clock.unwrap();
    println!("{clock:?}");
    assert!(clock.marks >= 60, "{}", clock.marks);
    // The scans are even and the marks exact.
    assert!(clock.sigma_s < 1e-4, "{}", clock.sigma_s);
    let first_id = f64::from(clock.first_message_id);
    let expected_s = 1001.5 + 0.05 * first_id;
    let error_s = clock.time_offset_s - expected_s;
    assert!(error_s.abs() < 5e-4, "{error_s}");
    // Five of those milliseconds in 24 s.
    assert!((clock.rate - (1.0 - 200e-6)).abs() < 4e-5, "{}", clock.rate);
}

/// A flight of 44 s, four times as fast, whose receiver needs 60 ms from an epoch to its first byte, which the
/// session does not state, and has no fix at first. Returns the remarks, and clocks with and without
/// `[gnss] pps`, with their errors (s).
fn with_and_without_pulses(edge_s: f64) -> (Vec<String>, [(LoggedClock, f64); 2]) {
    let world = World::new(4.0);
    let receiver = ReceiverOptions {
        latency_s: 0.060,
        no_fix_s: vec![[-1.0, 9.5]],
        ..ReceiverOptions::new(world.clone())
    };
    let options = EmulatorOptions {
        world: Some((world.clone(), 1.5)),
        drift_ppm: 20.0,
        impairments: Impairments {
            loss: 0.02,
            jitter_s: 0.004,
            ..Impairments::default()
        },
        ..EmulatorOptions::default()
    };
    let (_radio, receiver, text) = instruments(receiver, 44, options);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("assert");
    let pulses = PpsOptions {
        edge_s,
        loss: 0.05,
        no_fix_s: vec![[-1.0, 9.5]],
        ..PpsOptions::new(world, GpsTime::from_week_tow(2345, 1000.0))
    };
    let _pps = EmulatedPps::start(&file, pulses).unwrap();
    let text = text.replace("latency_sigma_ms = 2.0\n", "");
    let text = format!("{text}pps = {:?}\n", file.display().to_string());
    let directory = folder.path().join("flight");
    let (health, with) = record(&text, &directory, || receiver.is_finished());
    assert!(health.pulses >= 30, "{health:?}");
    // The same log without its pulses.
    let bytes = fs::read(directory.join(LOG_NAME)).unwrap();
    let mut reader = LogReader::new(&bytes[..]).unwrap();
    let without = folder.path().join("without");
    fs::create_dir(&without).unwrap();
    let mut log = LogWriter::create(&without.join(LOG_NAME)).unwrap();
    while let Some(record) = reader.next_record().unwrap() {
        if record.kind != RecordKind::Pulse {
            log.write(&record).unwrap();
        }
    }
    log.sync().unwrap();
    let finished = finish(&without).unwrap();
    let told = finished.remarks.join("; ");
    assert!(
        told.contains("pulses per second are not used: expected 16 pulses"),
        "{told}"
    );
    let clocks = [&with, &finished].map(|finished| {
        let clock = finished.clock.clone().unwrap();
        // In the middle of the scans, whose numbers count 50 ms each.
        let middle_s = 20.0;
        let expected_s =
            1001.5 + 0.05 * f64::from(clock.first_message_id) + middle_s / (1.0 + 20e-6);
        let error_s = clock.time_offset_s + clock.rate * middle_s - expected_s;
        (clock, error_s)
    });
    (with.remarks, clocks)
}

/// The receiver's latency, which nobody stated, is measured by its pulses and makes no error.
#[test]
fn pulses_per_second_take_the_receivers_latency_out() {
    let (remarks, [(with, error_s), (without, error_without_s)]) = with_and_without_pulses(0.0);
    println!("{remarks:?}\n{with:?}\n{error_s} {error_without_s}");
    assert!(with.pulses >= 16 && without.pulses == 0, "{with:?}");
    assert!(with.sigma_s < 0.2e-3, "{with:?}");
    assert!(error_s.abs() < 0.5e-3 + 2.0 * with.sigma_s, "{error_s}");
    assert!((with.gnss_latency_s - 0.060).abs() < 2e-3);
    assert!((error_without_s - -0.060).abs() < 3e-3, "{error_without_s}");
    assert!(without.sigma_s >= 0.02);
    assert!(
        remarks.iter().any(|r| r.starts_with("GPS time rests on")),
        "{remarks:?}"
    );
}

/// An inverted wire: the kernel stamps the end of a pulse 100 ms long. The pulses are not used, and why is said.
#[test]
fn the_other_edge_of_the_pulse_is_not_used() {
    let (remarks, [(with, error_s), (_, error_without_s)]) = with_and_without_pulses(0.1);
    println!("{remarks:?}");
    assert_eq!((with.pulses, error_s), (0, error_without_s));
    assert!(
        remarks.iter().any(|r| r.contains("pulse's other edge")),
        "{remarks:?}"
    );
}

/// A device that is not there is told before anything is recorded.
#[test]
fn a_missing_pps_device_is_refused_at_the_start() {
    let world = World::new(1.0);
    let options = EmulatorOptions {
        world: Some((world.clone(), 0.0)),
        ..EmulatorOptions::default()
    };
    let (_radio, _receiver, text) = instruments(ReceiverOptions::new(world), 1, options);
    let text = text + "pps = \"/dev/pps4711\"\n";
    let folder = tempfile::tempdir().unwrap();
    let session = Session::parse(&text).unwrap();
    let recorder = Recorder {
        session: &session,
        text: &text,
        directory: folder.path(),
        stop: &AtomicBool::new(false),
        requests: RequestOptions::default(),
        watch: WatchOptions::default(),
        tap: None,
    };
    let error = recorder.run(&mut |_| {}).unwrap_err().to_string();
    assert!(
        error.starts_with("PPS at /sys/class/pps/pps4711/assert: "),
        "{error}"
    );
}
