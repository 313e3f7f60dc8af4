//! A simulated flight through the radar readers and cleaning, which know nothing of the truth.

#![allow(clippy::unwrap_used)] // helpers of tests panic like tests

use std::io::Cursor;

use acerra_radar::clean::{
    Background, Gate, SurfaceOptions, ZeroTiming, apply_gate, envelope, remove_background,
    zero_timing,
};
use acerra_radar::mrm::{Framing, RadarConfig, write_mrm};
use acerra_radar::{
    BlemishKind, Limits, RadarFile, RadarLog, Radargram, RadargramOptions, Scan, read,
    two_way_delay_s,
};
use acerra_simulate::flight::Flight;
use acerra_simulate::radar::{RadarModel, lost_packets, simulate_scans};
use acerra_simulate::scene::Scene;

const SCENE: &str = "
seed = 11
[flight]
track_start_m = [0, 0]
track_end_m = [31.4, 0]
height_m = 4
track_duration_s = 17.5
[[corner]]
position_m = [4, 0, 0]
[[corner]]
position_m = [14, 0, 0]
[ground]
[[clutter]]
from_m = [-12, 2, 0]
to_m = [-10, 6, 3]
scatterers = 60
rcs_m2 = 40
";

struct Campaign {
    radar: RadarModel,
    flight: Flight,
    scans: Vec<Scan>,
}

fn fly() -> Campaign {
    let scene = Scene::parse(SCENE).unwrap();
    let flight = scene.fly().unwrap();
    let scans = simulate_scans(
        &scene.radar,
        &scene.radar_scene(),
        &flight,
        flight.on_track_s,
        scene.seed,
    )
    .unwrap();
    Campaign {
        radar: scene.radar,
        flight,
        scans,
    }
}

fn log(bytes: Vec<u8>) -> RadarLog {
    match read(Cursor::new(bytes), &Limits::default()).unwrap() {
        RadarFile::Log(log) => log,
        RadarFile::Neutral(_) => panic!("a log"),
    }
}

impl Campaign {
    fn heights_m(&self, radargram: &Radargram) -> Vec<f64> {
        let start_s = self.flight.on_track_s[0];
        radargram
            .time_s
            .iter()
            .map(|t| self.flight.pose_at(start_s + t).position_m[2])
            .collect()
    }
}

/// Largest envelope within an interval of fast time, over all traces.
fn peak(radargram: &Radargram, from_s: f64, to_s: f64) -> f64 {
    let n = radargram.samples_per_trace;
    envelope(radargram)
        .iter()
        .enumerate()
        .filter(|(i, _)| (from_s..to_s).contains(&radargram.fast_time_s(i % n)))
        .fold(0.0, |m, (_, e)| m.max(*e))
}

#[test]
fn cleaning_takes_the_radio_out_of_a_simulated_flight() {
    let campaign = fly();
    let config = RadarConfig::default();
    let bytes = write_mrm(Vec::new(), Framing::Bare, Some(&config), &campaign.scans).unwrap();
    let log = log(bytes);
    assert_eq!(log.scans, campaign.scans);
    assert!(log.report.is_clean(), "{:?}", log.report);

    let made = log.radargram(&RadargramOptions::default()).unwrap();
    let truth_s = campaign.radar.scan_interval_s;
    for (m, t) in made.radargram.time_s.iter().enumerate() {
        assert!((t - m as f64 * truth_s).abs() < 1e-3, "trace {m} at {t} s");
    }
    let heights_m = campaign.heights_m(&made.radargram);

    // The radio's own delay comes out, to a centimetre or two: speckle lies about the surface.
    let options = SurfaceOptions::default().with_band_hz([3.1e9, 4.8e9]);
    let method = ZeroTiming::FirstTrace(options);
    let timed = zero_timing(made.radargram, &heights_m, &method).unwrap();
    let off_s = timed.shift_s + campaign.radar.delay_ns * 1e-9;
    assert!(off_s.abs() < 0.15e-9, "{off_s:e}");
    assert!(timed.median_residual_s.unwrap().abs() < 0.15e-9);

    // Coupling stands above everything in the raw traces, and is gone without the mean.
    let raw = timed.radargram;
    let surface_s = two_way_delay_s(3.0);
    let before = peak(&raw, 0.0, 4e-9);
    let echoes = peak(&raw, surface_s, 40e-9);
    assert!(before > 2.0 * echoes, "{before} and {echoes}");
    let clean = remove_background(raw, Background::Mean).unwrap();
    let after = peak(&clean, 0.0, 4e-9);
    assert!(after < before / 30.0, "{before} to {after}");

    // The awnings are there before the gate and not behind it.
    assert!(peak(&clean, 70e-9, 90e-9) > 3.0 * 20.0);
    let gated = apply_gate(clean, &heights_m, &Gate::default()).unwrap();
    // What is left there is the analytic signal's own tail, far below the noise of 20 counts.
    assert!(peak(&gated, 70e-9, 90e-9) < 4.0);
    assert!(peak(&gated, surface_s, 40e-9) > 20.0 * 20.0);
}

#[test]
fn scans_with_lost_packets_are_reported_and_the_others_keep_their_times() {
    let campaign = fly();
    let radar = RadarModel {
        lost_packets: 0.02,
        ..campaign.radar.clone()
    };
    let bytes = write_mrm(Vec::new(), Framing::Serial, None, &campaign.scans).unwrap();
    let messages: Vec<&[u8]> = bytes.chunks(1456).collect();
    let lost = lost_packets(&radar, messages.len(), 5);
    let per_scan = messages.len() / campaign.scans.len();
    let whole: Vec<bool> = lost.chunks(per_scan).map(|s| !s.contains(&true)).collect();
    let gone = lost
        .chunks(per_scan)
        .filter(|s| !s.contains(&false))
        .count();
    let arrived: Vec<u8> = messages
        .iter()
        .zip(&lost)
        .filter(|(_, lost)| !**lost)
        .flat_map(|(message, _)| message.iter().copied())
        .collect();
    assert!(whole.contains(&false), "some packets are lost");

    let log = log(arrived);
    let wanted: Vec<&Scan> = campaign
        .scans
        .iter()
        .zip(&whole)
        .filter_map(|(scan, whole)| whole.then_some(scan))
        .collect();
    assert_eq!(log.scans.iter().collect::<Vec<_>>(), wanted);
    let incomplete = whole.iter().filter(|w| !**w).count() - gone;
    assert_eq!(log.report.incomplete_scans, incomplete as u64);
    assert!(
        log.report
            .blemishes
            .iter()
            .all(|b| matches!(b.kind, BlemishKind::IncompleteScan { .. }))
    );

    let made = log.radargram(&RadargramOptions::default()).unwrap();
    let first = whole.iter().position(|w| *w).unwrap();
    let numbers = (0..whole.len()).filter(|&m| whole[m]);
    for (m, t) in numbers.zip(&made.radargram.time_s) {
        let truth_s = (m - first) as f64 * radar.scan_interval_s;
        assert!((t - truth_s).abs() < 1e-3, "scan {m} at {t} s");
    }
}
