//! The running clock over the emulated instruments: pulses per second take out a latency that nobody stated, at one
//! switch, and nothing jumps after it.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed
#![allow(clippy::print_stdout)] // figures

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use acerra_geo::time::GpsTime;
use acerra_gnss::ubx::epoch_time;
use acerra_gnss::ubx::frame::encode;
use acerra_live::clock::RunningClock;
use acerra_live::hardware_clock::{ClockKind, Wiring};
use acerra_record::driver::{Intake, RequestOptions, WatchOptions};
use acerra_record::emulate::{
    EmulatedPps, EmulatedRadio, EmulatedReceiver, EmulatorOptions, Impairments, Pattern,
    PpsOptions, ReceiverOptions, World,
};
use acerra_record::gnss::FrameFinder;
use acerra_record::log::RecordKind;
use acerra_record::pps::PulseStamp;
use acerra_record::session::{Recorder, Session, Tap, Tapped};

const LOOPBACK: ([u8; 4], u16) = ([127, 0, 0, 1], 0);
const WEEK: i64 = 2345;
const STARTS_S: f64 = 1000.0;
const RADIO_STARTS_S: f64 = 1.5;
const INTERVAL_S: f64 = 0.05;
const DRIFT: f64 = 20e-6;
const SECONDS: u32 = 44;
/// Until then the receiver has no fix, and its pulses are those of its own clock (s).
const FIX_S: f64 = 9.5;

/// RXM-RAWX with nine satellites, five times a second.
fn receiver_log() -> Vec<u8> {
    let mut log = Vec::new();
    for epoch in 0..5 * SECONDS {
        let mut payload = vec![0; 16 + 9 * 32];
        payload[..8].copy_from_slice(&(STARTS_S + 0.2 * f64::from(epoch)).to_le_bytes());
        payload[8..10].copy_from_slice(&(WEEK as u16).to_le_bytes());
        payload[11] = 9;
        payload[13] = 1;
        for (k, signal) in payload[16..].chunks_mut(32).enumerate() {
            (signal[21], signal[30]) = (k as u8 + 1, 1);
        }
        log.extend(encode(0x02, 0x15, &payload).unwrap());
    }
    log
}

/// What a recording of emulated instruments hands to the live image, in order. The receiver needs 60 ms from an epoch to
/// its first byte; the session says nothing of it.
fn tapped() -> (Session, Vec<Tapped>) {
    let world = World::new(4.0);
    let no_fix_s = vec![[-1.0, FIX_S]];
    let receiver = ReceiverOptions {
        latency_s: 0.060,
        no_fix_s: no_fix_s.clone(),
        ..ReceiverOptions::new(world.clone())
    };
    let receiver = EmulatedReceiver::start(LOOPBACK.into(), receiver_log(), receiver).unwrap();
    let options = EmulatorOptions {
        world: Some((world.clone(), RADIO_STARTS_S)),
        drift_ppm: 1e6 * DRIFT,
        impairments: Impairments {
            loss: 0.02,
            jitter_s: 0.004,
            ..Impairments::default()
        },
        ..EmulatorOptions::default()
    };
    let source = Box::new(Pattern::new(20 * u64::from(SECONDS)));
    let radio = EmulatedRadio::start(LOOPBACK.into(), source, options).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("assert");
    let pulses = PpsOptions {
        loss: 0.05,
        no_fix_s,
        ..PpsOptions::new(world, GpsTime::from_week_tow(WEEK, STARTS_S))
    };
    let _pps = EmulatedPps::start(&file, pulses).unwrap();
    let text = format!(
        "[radio]\naddress = \"{}\"\nwindow_ps = [0, 11_000]\nlatency_ms = 0.0\nscan_interval_ms = 50.0\n\
         [gnss]\naddress = \"{}\"\npps = {:?}\n",
        radio.address(),
        receiver.address(),
        file.display().to_string()
    );
    let session = Session::parse(&text).unwrap();
    let (tap, receive) = Tap::new(100_000);
    let stop = AtomicBool::new(false);
    let directory = folder.path().join("flight");
    let recorder = Recorder {
        session: &session,
        text: &text,
        directory: &directory,
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
        tap: Some(tap),
    };
    let began = Instant::now();
    recorder
        .run(&mut |_| {
            assert!(began.elapsed() < Duration::from_secs(100), "stalled");
            if receiver.is_finished() {
                stop.store(true, Ordering::SeqCst);
            }
        })
        .unwrap();
    drop(recorder);
    (session, receive.try_iter().collect())
}

/// GPS seconds of the week at which the radio made a scan.
fn made_s(message_id: u16) -> f64 {
    STARTS_S + RADIO_STARTS_S + INTERVAL_S * f64::from(message_id) / (1.0 + DRIFT)
}

#[test]
fn pulses_take_an_untold_latency_out_at_one_switch() {
    let (session, records) = tapped();
    let mut clock = RunningClock::new(session.latencies(), Wiring::of(&session));
    let (mut intake, mut frames) = (Intake::default(), FrameFinder::default());
    let mut number = 0;
    let mut changes_s = Vec::new();
    // Errors of scans' first times, by what they rested on.
    let mut errors_s: [Vec<f64>; 2] = Default::default();
    for Tapped { record, .. } in &records {
        let host_s = 1e-9 * record.at_ns as f64;
        match record.kind {
            RecordKind::Gnss => frames.take(&record.payload, host_s, |frame, host_s| {
                clock.frame(frame, host_s);
                if let Some(time) = epoch_time(frame) {
                    clock.epoch(time, host_s);
                }
            }),
            RecordKind::Pulse => {
                let stamp = PulseStamp::parse(&record.payload).unwrap();
                clock.pulse(stamp.sequence, host_s);
            }
            RecordKind::Radio => {
                intake.take(&record.payload);
                while let Some(scan) = intake.next_scan() {
                    clock.scan(number, scan.message_id, scan.timestamp_ms, host_s);
                    if let Ok(settled) = clock.settle() {
                        changes_s.extend(settled.change_s);
                        let week = GpsTime::from_week_tow(WEEK, 0.0);
                        let found_s = settled.time(number).unwrap().seconds_since(week);
                        let kind = usize::from(settled.kind == ClockKind::Pulses);
                        errors_s[kind].push(found_s - made_s(scan.message_id));
                    }
                    number += 1;
                }
            }
            _ => {}
        }
    }
    let [arrivals, pulses] = errors_s;
    let most = |errors_s: &[f64]| errors_s.iter().fold(0.0_f64, |most, e| most.max(e.abs()));
    println!(
        "{number} scans; by arrivals {} off by up to {:.1} ms, by pulses {} by up to {:.2} ms; {changes_s:?}",
        arrivals.len(),
        1e3 * most(&arrivals),
        pulses.len(),
        1e3 * most(&pulses)
    );
    assert_eq!(clock.hardware_trouble(), None);
    let [change_s] = changes_s[..] else {
        panic!("one switch, found {changes_s:?}");
    };
    assert!((change_s.abs() - 0.060).abs() < 8e-3, "{change_s}");
    // Sixteen pulses of a fix that has settled, some lost: less than half a minute of 44 s is without.
    assert!(pulses.len() > 200, "{}", pulses.len());
    let late = arrivals.last().unwrap();
    assert!((late.abs() - 0.060).abs() < 8e-3, "{late}");
    assert!(most(&pulses) < 3e-3, "{:.2} ms", 1e3 * most(&pulses));
}
