//! The delay found from flights simulated in memory, and refused where the flight does not tell it.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;

use acerra_chain::choices::{Background, Delay, Gate};
use acerra_chain::clean::CleanOptions;
use acerra_chain::{ChainError, Control, Journal, Prepared, Recording, Scene, prepare};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::PlaneGrid;
use acerra_radar::{Radargram, Samples};

const C: f64 = 299_792_458.0;
const DELAY_S: f64 = 9.3e-9;
const STEP_S: f64 = 61.035e-12;
const TARGETS: [[f64; 3]; 3] = [[1.5, 1.2, 0.0], [3.0, -1.5, 0.0], [4.6, 2.0, 0.0]];

/// Numbers between -1 and 1 that repeat after 2^64 draws.
fn noise(state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / 2f64.powi(52) - 1.0
}

/// A level pass over the targets, `length_m` long about their middle.
fn flight(length_m: f64, clean: CleanOptions) -> Recording {
    let time_s: Vec<f64> = (0..150).map(|k| 0.05 * f64::from(k)).collect();
    let along = |t: f64| 3.0 + length_m * (t / 7.45 - 0.5);
    let mut state = 11;
    let mut samples = Vec::new();
    for t in &time_s {
        let echoes_s = TARGETS.map(|[x, y, z]| {
            let range_m = ((along(*t) - x).powi(2) + y * y + (3.0 - z).powi(2)).sqrt();
            2.0 * range_m / C + DELAY_S
        });
        for n in 0..900 {
            let fast_time_s = STEP_S * f64::from(n);
            let pulse = |echo_s: f64| {
                let s = fast_time_s - echo_s;
                (-(s / 0.35e-9).powi(2)).exp() * (TAU * 3.95e9 * s).cos()
            };
            let sum: f64 = echoes_s.iter().map(|echo_s| pulse(*echo_s)).sum();
            samples.push((sum + 0.3 * noise(&mut state)) as f32);
        }
    }
    let fixes = (-10..160).map(|k| {
        let t = 0.05 * f64::from(k);
        Fix::new(t, [along(t), 0.0, 3.0])
    });
    let trajectory = Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap();
    let radargram = Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap();
    Recording::new("flight", radargram, trajectory).clean_by(clean)
}

fn prepared(length_m: f64) -> Result<Prepared, ChainError> {
    let grid = PlaneGrid::from_ranges([0.0, 6.0], [-3.0, 3.0], 0.0, 0.05).unwrap();
    prepared_on(grid, length_m)
}

fn prepared_on(grid: PlaneGrid, length_m: f64) -> Result<Prepared, ChainError> {
    let clean = CleanOptions {
        delay_ns: Some(Delay::Auto),
        background: Background::None,
        ..CleanOptions::default()
    };
    prepare(
        vec![flight(length_m, clean)],
        Scene::plane(grid),
        &acerra_chain::calibration::CalibrationOptions::default(),
        &mut Journal::default(),
        &Control::default(),
    )
}

#[test]
fn a_pass_over_targets_tells_the_delay() {
    let prepared = prepared(6.0).unwrap();
    let track = prepared.first();
    let found = track.delay.as_ref().unwrap();
    let error_s = found.delay_s - DELAY_S;
    println!("{:+.3} ± {:.3} ns", 1e9 * error_s, 1e9 * found.sigma_s);
    assert!(error_s.abs() < 0.1e-9, "{found:?}");
    assert!(error_s.abs() < 3.0 * found.sigma_s, "{found:?}");
    assert!(found.second.is_none_or(|(_, below)| below > 6.0));
    // It is in force, behind the gate of a view from above.
    let shift_s = track.cleaned.as_ref().unwrap().shift_s;
    assert!((shift_s + found.delay_s).abs() < 1e-15);
    assert_eq!(track.gate_ns, Gate::About(Gate::BELOW_NS));
}

#[test]
fn a_scene_ten_times_as_wide_tells_the_same_delay() {
    let grid = PlaneGrid::from_ranges([-27.0, 33.0], [-30.0, 30.0], 0.0, 0.1).unwrap();
    let prepared = prepared_on(grid, 6.0).unwrap();
    let found = prepared.first().delay.as_ref().unwrap();
    let error_s = found.delay_s - DELAY_S;
    println!("{:+.3} ± {:.3} ns", 1e9 * error_s, 1e9 * found.sigma_s);
    assert!(error_s.abs() < 0.1e-9, "{found:?}");
    // Errors of the positions would bend the phases as much: a deviation below a centimetre claims too much.
    assert!(
        found.sigma_s > 0.07e-9 && found.sigma_s < 0.5e-9,
        "{found:?}"
    );
}

#[test]
fn a_short_aperture_is_refused() {
    let Err(error) = prepared(0.25) else {
        panic!("a delay was found");
    };
    let message = error.to_string();
    assert!(
        message.starts_with("[radar] delay_ns = \"auto\": "),
        "{message}"
    );
    assert!(message.ends_with("; state the delay"), "{message}");
}
