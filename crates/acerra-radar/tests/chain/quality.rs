//! Evidence: outliers, coupling, spectrum, spacing, the surface echo.

use std::f64::consts::TAU;

use crate::common::shared;
use acerra_radar::mrm::read_mrm;
use acerra_radar::quality::{
    OutlierKind, OutlierOptions, coupling, scan_outliers, spectrum_occupancy,
};
use acerra_radar::{Limits, Radargram, RadargramOptions, Samples, two_way_delay_s};

/// A surface that sways about 4 m under coupling at 9.5 ns, in noise; delay 9 ns.
fn flight(drift: f64) -> (Radargram, Vec<f64>) {
    let (n, start, step) = (700, 5e-9, 61e-12);
    let time_s: Vec<f64> = (0..200).map(|m| 0.07 * f64::from(m)).collect();
    let height_m: Vec<f64> = time_s.iter().map(|t| 4.0 + 0.2 * (0.7 * t).sin()).collect();
    let mut state = 7u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let pulse = |u: f64| (-u * u / 0.2).exp() * (TAU * 3.95 * u).cos();
    let mut samples = Vec::new();
    for (t, h) in time_s.iter().zip(&height_m) {
        let surface_ns = 9.0 + 1e9 * (two_way_delay_s(*h) + drift * t);
        for k in 0..n {
            let at = 1e9 * (start + f64::from(k) * step);
            let sum = 900.0 * pulse(at - 9.5) + 40.0 * pulse(at - surface_ns);
            samples.push((sum + noise()) as f32);
        }
    }
    let radargram = Radargram::new(time_s, start, step, Samples::Real(samples)).unwrap();
    (radargram, height_m)
}

#[test]
fn coupling_and_spectrum() {
    let (radargram, _) = flight(0.0);
    let c = coupling(&radargram).unwrap();
    assert!((c.fast_time_s - 9.5e-9).abs() < 0.02e-9, "{c:?}");
    assert!(c.spread_s < 0.01e-9 && c.drift.abs() < 1e-12 && c.level_spread_db < 0.1);
    let s = spectrum_occupancy(&radargram).unwrap();
    // The power spectrum of e^{−t²/0.2 ns²} is e^{−0.4π²f²}: 10 dB down √(ln 10/0.4π²) = 0.764 GHz
    // off the carrier.
    assert!((s.band_hz[0] - 3.186e9).abs() < 0.03e9, "{:?}", s.band_hz);
    assert!((s.band_hz[1] - 4.714e9).abs() < 0.03e9, "{:?}", s.band_hz);
    assert!(s.share_within([3.1e9, 4.8e9]) > 0.95);
    assert!(s.share_within([1e9, 2e9]) < 0.01);
    assert_eq!(s.occupied_share_of([1e9, 2e9]), 0.0);
}

#[test]
fn outliers_are_told_and_sound_flights_have_none() {
    let (sound, _) = flight(0.0);
    let options = OutlierOptions::default();
    assert_eq!(scan_outliers(&sound, &options), []);
    let n = sound.samples_per_trace;
    let Samples::Real(clean) = &sound.samples else {
        panic!("real")
    };
    let mut samples = clean.clone();
    samples[30 * n..31 * n].iter_mut().for_each(|s| *s *= 50.0);
    samples[77 * n + 500] = 2e6;
    samples[90 * n..100 * n].fill(0.0);
    samples[150 * n + 3] = f32::NAN;
    let damaged = Radargram {
        samples: Samples::Real(samples),
        ..sound
    };
    let found = scan_outliers(&damaged, &options);
    let traces: Vec<usize> = found.iter().map(|o| o.trace).collect();
    let want: Vec<usize> = [30, 77].into_iter().chain(90..100).chain([150]).collect();
    assert_eq!(traces, want);
    assert!(matches!(found[0].kind, OutlierKind::Energy { ratio_db } if ratio_db > 30.0));
    assert_eq!(found[2].kind, OutlierKind::Dead);
    assert_eq!(found[12].kind, OutlierKind::NotFinite { sample: 3 });
    assert!(found[12].to_string().starts_with("trace 150: sample 3"));
}

#[test]
fn real_captures_are_sound() {
    for name in [
        "uav-flight-2019/flight.mrm",
        "corner-reflector-captures/July19-CornerReflector-scan01.out",
        "corner-reflector-captures/July19-CornerReflector-scan07.out",
    ] {
        let Some(bytes) = shared(name) else { continue };
        let log = read_mrm(&bytes[..], &Limits::default()).unwrap();
        let radargram = log
            .radargram(&RadargramOptions::default())
            .unwrap()
            .radargram;
        assert_eq!(
            scan_outliers(&radargram, &OutlierOptions::default()),
            [],
            "{name}"
        );
        let spectrum = spectrum_occupancy(&radargram).unwrap();
        let share = spectrum.share_within([3.1e9, 4.8e9]);
        println!(
            "{name}: {:?}; {:.2} of the energy in 3.1–4.8 GHz, band {:?}",
            coupling(&radargram),
            share,
            spectrum.band_hz
        );
        assert!(share > 0.8, "{name}: {share}");
        assert!(radargram.time_s.is_sorted_by(|a, b| a < b));
    }
}
