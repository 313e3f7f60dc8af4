//! Two tracks whose instruments and positions have errors of their own: what an autofocus finds of them, and
//! that images and settled campaigns have it.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;

use acerra_chain::autofocus::{AutofocusOptions, Quantity};
use acerra_chain::choices::Sum;
use acerra_chain::clean::CleanOptions;
use acerra_chain::{
    Control, ImageRequest, Journal, MemorySink, Prepared, Recording, Scene, prepare,
};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::{PlaneGrid, SPEED_OF_LIGHT_M_S};
use acerra_radar::{Radargram, Samples};

/// What the second track has for its own: delay (ns), phase (degrees), and what its positions are off (m).
const DELAY_NS: f64 = 0.15;
const PHASE_DEG: f64 = 70.0;
const SHIFT_M: [f64; 3] = [0.0, 0.03, -0.02];
const TARGETS_M: [[f64; 2]; 6] = [
    [-1.8, 2.4],
    [-1.0, 3.5],
    [-0.2, 1.7],
    [0.5, 2.9],
    [1.2, 2.0],
    [1.9, 3.2],
];

/// Where the antenna is: the first track flies east, the second back, lower and to the south.
fn flown_m(track: usize, t_s: f64) -> [f64; 3] {
    let wave = |amplitude_m: f64, period_s: f64| amplitude_m * (TAU * t_s / period_s).sin();
    match track {
        0 => [0.5 * t_s - 3.0, wave(0.2, 5.1), 4.0 + wave(0.1, 3.7)],
        _ => [3.0 - 0.5 * t_s, wave(0.2, 4.3) - 0.8, 3.2 + wave(0.1, 4.9)],
    }
}

fn recording(track: usize, instrument: [f64; 2], shift_m: [f64; 3]) -> Recording {
    let t_s: Vec<f64> = (0..161).map(|k| 0.075 * f64::from(k)).collect();
    let [delay_ns, phase_deg] = instrument;
    let echo = |t: f64, n: i32| -> f32 {
        let [x, y, z] = flown_m(track, t);
        let of = |q: &[f64; 2]| {
            let range_m = (x - q[0]).hypot(y - q[1]).hypot(z);
            let s = 61e-12 * f64::from(n) - 2.0 * range_m / SPEED_OF_LIGHT_M_S - 1e-9 * delay_ns;
            (-(s / 0.3e-9).powi(2)).exp() * (TAU * 4e9 * s + phase_deg.to_radians()).cos()
        };
        TARGETS_M.iter().map(of).sum::<f64>() as f32
    };
    let samples = t_s.iter().flat_map(|t| (0..800).map(move |n| echo(*t, n)));
    let samples = Samples::Real(samples.collect());
    let fixes = t_s.iter().map(|t| {
        let place = flown_m(track, *t);
        Fix::new(*t, [0, 1, 2].map(|a| place[a] - shift_m[a]))
    });
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap();
    let radargram = Radargram::new(t_s.clone(), 0.0, 61e-12, samples).unwrap();
    let name = format!("track {}", track + 1);
    Recording::new(&name, radargram, trajectory).clean_by(CleanOptions::none())
}

fn prepared(instrument: [f64; 2], shift_m: [f64; 3]) -> Prepared {
    let recordings = vec![
        recording(0, [0.0; 2], [0.0; 3]),
        recording(1, instrument, shift_m),
    ];
    let grid = PlaneGrid::from_ranges([-2.6, 2.6], [1.0, 4.4], 0.0, 0.02).unwrap();
    let (calibration, control) = (Default::default(), Control::default());
    let journal = &mut Journal::default();
    prepare(
        recordings,
        Scene::plane(grid),
        &calibration,
        journal,
        &control,
    )
    .unwrap()
}

fn peak(prepared: &Prepared, sum: Sum) -> f32 {
    let mut request = ImageRequest::on(prepared.scene.pixels.clone());
    request.options.sum = sum;
    let control = Control::default();
    let focused = prepared
        .image(&request, &mut MemorySink::default(), &control)
        .unwrap();
    focused.image.iter().map(|v| v.norm()).fold(0.0, f32::max)
}

fn options(sum: Sum) -> AutofocusOptions {
    AutofocusOptions {
        sigma_m: Some([0.001; 3]),
        correlation_s: Some(0.7),
        track_delay_sigma_ns: Some(0.2),
        track_phase_sigma_deg: 104.0,
        track_shift_sigma_m: Some([0.0, 0.03, 0.03]),
        sum,
        ..AutofocusOptions::default()
    }
}

#[test]
fn what_a_track_has_for_its_own_is_found_and_carried_through() {
    let mut flight = prepared([DELAY_NS, PHASE_DEG], SHIFT_M);
    let before = peak(&flight, Sum::Coherent);
    let correction = flight.autofocus(&options(Sum::Coherent), &Control::default());
    let correction = correction.unwrap().clone();
    assert!(correction.is_applied(), "{:?}", correction.found.decision);
    let difference = |quantity| correction.of_track(quantity, 1) - correction.of_track(quantity, 0);
    for (quantity, truth, most) in [
        (Quantity::TrackDelay, DELAY_NS, 0.03),
        (Quantity::TrackPhase, PHASE_DEG, 20.0),
        (Quantity::TrackNorth, SHIFT_M[1], 0.01),
        (Quantity::TrackUp, SHIFT_M[2], 0.01),
    ] {
        let off = (difference(quantity) - truth).abs();
        assert!(
            off < most,
            "{quantity:?}: {} of {truth}",
            difference(quantity)
        );
    }
    let right = peak(&prepared([0.0; 2], [0.0; 3]), Sum::Coherent);
    let after = peak(&flight, Sum::Coherent);
    assert!(before < 0.9 * right, "{before} of {right}");
    assert!(after > 0.98 * right, "{after} of {right}");
    let restored = flight.as_stated();
    assert!((peak(&restored, Sum::Coherent) / before - 1.0).abs() < 1e-4);
}

/// Tracks summed by power have no phase against each other.
#[test]
fn tracks_summed_by_power_have_no_relative_phase() {
    let mut flight = prepared([DELAY_NS, PHASE_DEG], SHIFT_M);
    let before = peak(&flight, Sum::Incoherent);
    let correction = flight.autofocus(&options(Sum::Incoherent), &Control::default());
    let correction = correction.unwrap();
    assert!(correction.is_applied(), "{:?}", correction.found.decision);
    let has_phase =
        |g: &acerra_chain::autofocus::GlobalCorrection| g.quantity == Quantity::TrackPhase;
    assert!(!correction.globals.iter().any(has_phase));
    let right = peak(&prepared([0.0; 2], [0.0; 3]), Sum::Incoherent);
    let after = peak(&flight, Sum::Incoherent);
    assert!(before < 0.98 * right, "{before} of {right}");
    assert!(after > 0.995 * right, "{after} of {right}");
}
