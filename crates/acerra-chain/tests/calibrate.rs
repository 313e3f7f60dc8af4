//! Calibration of flights simulated in memory: point reflectors' range profiles with noise, and
//! positions with slow errors.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::f64::consts::TAU;

use acerra_chain::align::AlignOptions;
use acerra_chain::calibrate::{
    AtRest, CalibrateError, CalibrateOptions, Calibrated, Parameter, calibrate, delay_at_rest,
};
use acerra_chain::choices::{Select, TimeOffset};
use acerra_chain::clean::CleanOptions;
use acerra_chain::{Control, Recording, Scene, Warnings};
use acerra_geo::interpolate::{InterpolationOptions, Interpolator};
use acerra_geo::lever_arm::{HeadingOptions, apply_lever_arm};
use acerra_geo::trajectory::{Fix, Frame, TimeOrigin, Trajectory};
use acerra_imaging::PlaneGrid;
use acerra_radar::{Radargram, Samples};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

const C: f64 = 299_792_458.0;
const STEP_S: f64 = 61.035e-12;
const DELAY_S: f64 = 11.3e-9;
const OFFSET_S: f64 = 1000.37;
const ARM_M: [f64; 3] = [0.12, -0.05, -0.25];
const REFLECTORS: [[f64; 3]; 3] = [[3.0, 1.0, 0.0], [-4.0, -2.5, 0.3], [0.5, 5.0, 0.1]];
/// Standard deviations and correlation time of the positions' errors.
const POSITION_SIGMA_M: [f64; 3] = [0.005, 0.005, 0.01];
const CORRELATION_S: f64 = 10.0;

/// A path over time, sampled at `interval_s`.
fn track(path: impl Fn(f64) -> [f64; 3], interval_s: f64) -> Trajectory {
    let count = (48.0 / interval_s) as usize;
    let fix = |k: usize| {
        let t = k as f64 * interval_s;
        Fix::new(OFFSET_S + t - 4.0, path(t))
    };
    Trajectory::new(
        Frame::Local,
        TimeOrigin::Relative,
        (0..count).map(fix).collect(),
    )
    .unwrap()
}

/// A figure of eight that climbs and sinks: headings and look angles of all kinds.
fn eight(t: f64) -> [f64; 3] {
    let a = TAU * t / 40.0;
    [
        8.0 * a.sin(),
        5.0 * (2.0 * a).sin(),
        6.0 + 0.8 * (0.5 * t).sin(),
    ]
}

/// A straight, level track at constant speed.
fn straight(t: f64) -> [f64; 3] {
    [-12.0 + 0.5 * t, -2.0, 6.0]
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}

/// The positions as a receiver gives them: with errors that last, and their deviations.
fn measured(truth: &Trajectory, rng: &mut ChaCha8Rng) -> Trajectory {
    let every = 4; // 5 Hz of 20 Hz
    let keep = (-0.05 * f64::from(every) / CORRELATION_S).exp();
    let mut error = POSITION_SIGMA_M.map(|s| s * normal(rng));
    let fixes = truth.fixes().iter().step_by(every as usize).map(|fix| {
        for (e, s) in error.iter_mut().zip(POSITION_SIGMA_M) {
            *e = keep * *e + s * (1.0 - keep * keep).sqrt() * normal(rng);
        }
        let mut fix = *fix;
        fix.position_m = [0, 1, 2].map(|i| fix.position_m[i] + error[i]);
        let mut covariance = [[0.0; 3]; 3];
        (0..3).for_each(|i| covariance[i][i] = POSITION_SIGMA_M[i].powi(2));
        fix.covariance_m2 = Some(covariance);
        fix
    });
    Trajectory::new(Frame::Local, TimeOrigin::Relative, fixes.collect()).unwrap()
}

/// The pulse of the P440, nearly: 2.2 GHz wide (−10 dB) about 3.95 GHz.
fn pulse(t: f64) -> f64 {
    (-0.5 * (t / 0.28e-9).powi(2)).exp() * (TAU * 3.95e9 * t).cos()
}

/// Traces of a flight of the phase centre over the reflectors.
fn radargram(truth: &Trajectory, reflectors: &[[f64; 3]], rng: &mut ChaCha8Rng) -> Radargram {
    let (moved, _) = apply_lever_arm(truth, ARM_M, &HeadingOptions::default()).unwrap();
    let at = Interpolator::new(&moved, &InterpolationOptions::default());
    let (traces, samples) = (200, 1400);
    let time_s: Vec<f64> = (0..traces).map(|k| 0.2 * f64::from(k)).collect();
    let mut values = Vec::new();
    for t in &time_s {
        let mut row: Vec<f64> = (0..samples).map(|_| 0.02 * normal(rng)).collect();
        let p = at.at(t + OFFSET_S).position_m;
        for r in reflectors {
            let range_m = (0..3).map(|i| (p[i] - r[i]).powi(2)).sum::<f64>().sqrt();
            let delay_s = 2.0 * range_m / C + DELAY_S;
            let strength = 25.0 / range_m.powi(2);
            let first = ((delay_s - 1.5e-9) / STEP_S) as usize;
            let near = row.iter_mut().enumerate().skip(first).take(50);
            near.for_each(|(k, v)| *v += strength * pulse(k as f64 * STEP_S - delay_s));
        }
        values.extend(row.iter().map(|v| *v as f32));
    }
    Radargram::new(time_s, 0.0, STEP_S, Samples::Real(values)).unwrap()
}

fn scene() -> Scene {
    Scene::plane(PlaneGrid::new([-5.0, -5.0, 0.0], 0.1, [100, 100]).unwrap())
}

/// A flight whose campaign has the offset wrong by 0.4 s.
fn flight(path: fn(f64) -> [f64; 3], reflectors: &[[f64; 3]], seed: u64) -> Recording {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth = track(path, 0.05);
    let radar = radargram(&truth, reflectors, &mut rng);
    Recording::new("1", radar, measured(&truth, &mut rng))
        .clean_by(CleanOptions::none())
        .align_by(AlignOptions {
            time_offset: Some(TimeOffset::Seconds(OFFSET_S - 0.4)),
            select: Select::All,
            ..AlignOptions::default()
        })
}

fn calibrated(
    recording: Recording,
    lever_arm_m: [f64; 3],
) -> (Result<Calibrated, CalibrateError>, Warnings) {
    let mut warnings = Warnings::default();
    let options = CalibrateOptions {
        lever_arm_m,
        survey_sigma_m: 0.0,
        position_correlation_s: CORRELATION_S,
        ..CalibrateOptions::on(REFLECTORS.to_vec())
    };
    let found = calibrate(
        &[recording],
        &scene(),
        &options,
        &mut warnings,
        &Control::default(),
    );
    (found, warnings)
}

fn truth(parameter: Parameter) -> f64 {
    match parameter {
        Parameter::Delay => DELAY_S,
        Parameter::RangeScale => 0.0,
        Parameter::Forward => ARM_M[0],
        Parameter::Left => ARM_M[1],
        Parameter::Up => ARM_M[2],
        Parameter::ClockOffset(_) => OFFSET_S,
    }
}

/// χ² of the estimates, by their covariance.
fn chi_square(found: &Calibrated) -> f64 {
    let n = found.free.len();
    let error = nalgebra::DVector::from_fn(n, |i, _| {
        found.values.get(found.free[i]) - truth(found.free[i])
    });
    let covariance = nalgebra::DMatrix::from_fn(n, n, |i, j| found.covariance[i][j]);
    let scale: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    let relative = error.map_with_location(|i, _, e| e / scale[i]);
    let correlation = covariance.map_with_location(|i, j, c| c / (scale[i] * scale[j]));
    (relative.transpose() * correlation.try_inverse().unwrap() * relative)[(0, 0)]
}

#[test]
fn a_figure_of_eight_tells_the_lever_arm() {
    // Too few for root mean squares: errors against their own covariance.
    let (_, chi) = draw(4);
    check_deviations(chi, 4);
}

/// The stated covariance against the errors of a hundred flights.
#[test]
#[ignore = "minutes; run by cargo xtask validate"]
fn validation_deviations_of_a_calibration_are_true() {
    let (rms, chi) = draw(100);
    assert!(rms[0] < 0.05e-9, "{rms:?}");
    assert!(rms[1..4].iter().all(|m| *m < 0.02), "{rms:?}");
    assert!(rms[4] < 0.003, "{rms:?}");
    check_deviations(chi, 100);
}

/// So many flights, in which all but the range scale is observed (errors of height stand in for it):
/// root mean squares of the errors, and the sum of their χ².
fn draw(draws: u64) -> ([f64; 5], f64) {
    let all: Vec<Calibrated> = (0..draws)
        .into_par_iter()
        .map(|seed| {
            calibrated(flight(eight, &REFLECTORS, seed), [0.0; 3])
                .0
                .unwrap()
        })
        .collect();
    let mut squares = [0.0; 5];
    for (seed, found) in all.iter().enumerate() {
        assert_eq!(
            found.free.len(),
            5,
            "held in draw {seed}: {:?}",
            found.singular
        );
        for (sum, p) in squares.iter_mut().zip(&found.free) {
            *sum += (found.values.get(*p) - truth(*p)).powi(2);
        }
    }
    let chi: f64 = all.iter().map(chi_square).sum();
    (squares.map(|s| (s / draws as f64).sqrt()), chi)
}

/// χ² of so many flights with five unknowns each, within bounds of 99.9 %.
fn check_deviations(chi: f64, draws: u32) {
    let freedom = 5.0 * f64::from(draws);
    let bound = 3.3 * (2.0 * freedom).sqrt();
    assert!((chi - freedom).abs() < bound, "χ² {chi:.1} of {freedom}");
}

#[test]
fn a_straight_level_track_declares_what_it_cannot_tell() {
    let (found, warnings) = calibrated(flight(straight, &REFLECTORS, 7), ARM_M);
    let found = found.unwrap();
    println!("{:?} {:?}", found.estimates, warnings.said());
    let held = |p| found.estimate(p).unwrap().sigma.is_none();
    // At constant speed an arm ahead is an offset of the clock.
    assert!(held(Parameter::Forward));
    let forward = found
        .singular
        .iter()
        .flat_map(|direction| &direction.component)
        .any(|(p, c)| *p == Parameter::Forward && c.abs() > 0.3);
    assert!(forward, "{:?}", found.singular);
    let offset = found.estimate(Parameter::ClockOffset(0)).unwrap();
    assert!((offset.value - OFFSET_S).abs() < 4.0 * offset.sigma.unwrap());
    let slope = found
        .sensitivity
        .iter()
        .find(|s| s.of == Parameter::ClockOffset(0) && s.to == Parameter::Forward)
        .unwrap();
    // A centimetre ahead at 0.5 m/s is 20 ms.
    assert!((slope.slope + 2.0).abs() < 0.1, "{slope:?}");
}

#[test]
fn noise_alone_and_misplaced_reflectors_are_refused() {
    let (none, _) = calibrated(flight(eight, &[], 1), ARM_M);
    assert!(
        matches!(none, Err(CalibrateError::NoEcho { .. })),
        "{none:?}"
    );
    let elsewhere = REFLECTORS.map(|[x, y, z]| [x + 4.0, y - 3.0, z]);
    let (moved, warnings) = calibrated(flight(eight, &elsewhere, 1), ARM_M);
    let doubted = warnings.said().iter().any(|w| w.contains("outliers"));
    assert!(moved.is_err() || doubted, "{moved:?}");
}

#[test]
fn a_radar_at_rest_tells_its_delay() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let rest = AtRest {
        range_m: 6.2,
        range_sigma_m: 0.003,
        light_speed_m_s: C,
        band_hz: [3.1e9, 4.8e9],
    };
    let echo_s = 2.0 * rest.range_m / C + DELAY_S;
    let mut log = |coupling: f64, strength: f64| {
        let mut values = Vec::new();
        for _ in 0..60 {
            for k in 0..1200 {
                let t = f64::from(k) * STEP_S;
                let v = coupling * pulse(t - DELAY_S - 0.8e-9) + strength * pulse(t - echo_s);
                values.push((v + 0.02 * normal(&mut rng)) as f32);
            }
        }
        let time_s = (0..60).map(|k| 0.1 * f64::from(k)).collect();
        Radargram::new(time_s, 0.0, STEP_S, Samples::Real(values)).unwrap()
    };
    // The coupling is twenty times as strong as the echo.
    let found = delay_at_rest(&log(20.0, 1.0), &rest).unwrap();
    assert!(
        (found.delay_s - DELAY_S).abs() < 4.0 * found.sigma_s + 1e-12,
        "{found:?}"
    );
    assert!(
        (found.sigma_s - 2.0 * 0.003 / C).abs() < 2e-12 && found.coupling_seen,
        "{found:?}"
    );
    let alone = delay_at_rest(&log(0.0, 1.0), &rest).unwrap();
    assert!((alone.delay_s - DELAY_S).abs() < 4.0 * alone.sigma_s && !alone.coupling_seen);
    assert!(matches!(
        delay_at_rest(&log(0.0, 0.0), &rest),
        Err(CalibrateError::NothingAtRange { .. })
    ));
}

/// A rail that looks sideways at its reflectors over static coupling and a floor of weaker scatterers: no
/// surface echo, no climb, and echoes that single traces do not show.
fn rail(seed: u64) -> (Recording, Vec<[f64; 3]>) {
    let mut rng = ChaCha8Rng::seed_from_u64(1000 + seed);
    let path = |t: f64| [-4.0 + 0.2 * t, 0.01 * (0.9 * t).sin(), 1.2];
    let truth = track(path, 0.05);
    let at = Interpolator::new(&truth, &InterpolationOptions::default());
    let mut within = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    let reflectors = vec![
        [within(-1.0, 0.0), within(3.0, 4.5), 0.4],
        [within(0.5, 1.5), within(3.5, 5.5), 0.7],
    ];
    let scatterers: Vec<([f64; 3], f64)> = (0..250)
        .map(|_| {
            let place = [within(-6.0, 6.0), within(1.5, 8.0), within(0.0, 1.5)];
            (place, within(0.0, 0.35))
        })
        .collect();
    let time_s: Vec<f64> = (0..400).map(|k| 0.1 * f64::from(k)).collect();
    let mut values = Vec::new();
    for t in &time_s {
        let mut row: Vec<f64> = (0..1100).map(|_| 0.02 * normal(&mut rng)).collect();
        let p = at.at(t + OFFSET_S).position_m;
        let mut add = |delay_s: f64, strength: f64| {
            let first = ((delay_s - 1.5e-9) / STEP_S).max(0.0) as usize;
            let near = row.iter_mut().enumerate().skip(first).take(50);
            near.for_each(|(k, v)| *v += strength * pulse(k as f64 * STEP_S - delay_s));
        };
        let echo_s = |place: &[f64; 3]| {
            let range_m = (0..3)
                .map(|i| (p[i] - place[i]).powi(2))
                .sum::<f64>()
                .sqrt();
            (2.0 * range_m / C + DELAY_S, 16.0 / range_m.powi(2))
        };
        add(DELAY_S + 1e-9, 30.0);
        let points = reflectors.iter().map(|r| (r, 1.0));
        for (place, strength) in points.chain(scatterers.iter().map(|(p, s)| (p, *s))) {
            let (delay_s, spreading) = echo_s(place);
            add(delay_s, strength * spreading);
        }
        values.extend(row.iter().map(|v| *v as f32));
    }
    let radar = Radargram::new(time_s, 0.0, STEP_S, Samples::Real(values)).unwrap();
    let recording = Recording::new("1", radar, measured(&truth, &mut rng)).align_by(AlignOptions {
        time_offset: Some(TimeOffset::Seconds(OFFSET_S + 0.15)),
        select: Select::All,
        ..AlignOptions::default()
    });
    (recording, reflectors)
}

/// Of ten rails: how many tell a delay within 3 σ or hold the one found, and that none is certain and wrong.
#[test]
fn a_rail_that_looks_sideways_is_never_certain_and_wrong() {
    let mut right = 0;
    for seed in 0..10 {
        let (recording, reflectors) = rail(seed);
        let mut warnings = Warnings::default();
        let options = CalibrateOptions::on(reflectors);
        let scene = &scene();
        let control = &Control::default();
        let outcome = calibrate(&[recording], scene, &options, &mut warnings, control);
        let Ok(calibrated) = outcome else {
            println!("seed {seed}: {}", outcome.unwrap_err());
            continue;
        };
        let delay = calibrated.estimate(Parameter::Delay).unwrap();
        println!("seed {seed}: {delay:?} {:?}", warnings.said());
        let off_s = (delay.value - DELAY_S).abs();
        match delay.sigma {
            Some(sigma_s) => {
                assert!(off_s < 3.0 * sigma_s + 0.02e-9, "seed {seed}: {delay:?}");
                right += 1;
            }
            // Held at what focuses the reflectors, on a grid of 0.45 ns.
            None => right += i32::from(off_s < 0.5e-9),
        }
    }
    assert!(right >= 5, "{right} of 10");
}

/// The reflector of a real flight in a motion-capture hall.
#[test]
fn the_reflector_of_a_real_flight_tells_the_delay() {
    let folder = std::path::Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/data/uav-flight-2019"
    ));
    if !folder.exists() {
        eprintln!("skipped: {} is absent", folder.display());
        return;
    }
    let text = "[radar]\nfile = 'flight.mrm'\n[trajectory]\nfile = 'platform-mocap.csv'\n\
                time_offset_s = 6.52\n[preprocess]\ngate_ns = 'none'\n\
                [image]\nx_m = [0, 4]\ny_m = [0, 4]\nz_m = 0.0\npixel_m = 0.02\n";
    let campaign = acerra_chain::campaign::Campaign::parse(text).unwrap();
    let survey = campaign.resolved_in(folder).survey();
    let mut journal = acerra_chain::Journal::default();
    let control = Control::default();
    let (recordings, scene) = survey.recordings(&mut journal, &control).unwrap();
    let options = CalibrateOptions::on(vec![[1.793, 1.810, -0.017]]);
    let mut warnings = Warnings::default();
    let found = calibrate(&recordings, &scene, &options, &mut warnings, &control).unwrap();
    println!(
        "{:?}\n{:?}\n{:?}",
        found.estimates,
        found.reflectors,
        warnings.said()
    );
    // The image of the flight focuses the reflector nearest to its surveyed place at 12.0 to 12.4 ns.
    let delay = found.estimate(Parameter::Delay).unwrap();
    assert!((delay.value - 12.2e-9).abs() < 0.5e-9, "{delay:?}");
}
