//! Cleaning: every stage against what it must do to known signals.

use std::f64::consts::{PI, TAU};

use acerra_radar::clean::{
    Background, CleanError, Gate, SurfaceOptions, ZeroTiming, apply_gate, envelope,
    remove_background, spectrum_at, spectrum_by_direct_sum, track_surface, zero_timing,
};
use acerra_radar::{Radargram, Samples, two_way_delay_s};
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;

const STEP_S: f64 = 1e-9 / 16.384;

/// A 3.95 GHz pulse of about 1.7 GHz bandwidth.
fn pulse(t: f64) -> f64 {
    let width = 0.22e-9;
    (-(t / width).powi(2) / 2.0).exp() * (TAU * 3.95e9 * t).cos()
}

/// Deterministic noise, standard deviation about 1.
fn noise(i: u64) -> f64 {
    let mut x = i.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mut sum = 0.0;
    for _ in 0..6 {
        x ^= x >> 31;
        x = x.wrapping_mul(0xBF58_476D_1CE4_E5B9);
        sum += (x >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
    }
    sum * 2f64.sqrt()
}

/// A raw flight: coupling 40 dB above the surface, a point target, noise, a delay of the radio.
struct Flight {
    delay_s: f64,
    coupling: f64,
    noise: f64,
    height_m: Vec<f64>,
}

impl Flight {
    fn new(traces: usize, ripple_m: f64) -> Self {
        let height_m = (0..traces)
            .map(|m| {
                4.0 + ripple_m * (m as f64 * 0.11).sin() + 0.3 * ripple_m * (m as f64 * 0.31).cos()
            })
            .collect();
        Self {
            delay_s: 9.7e-9,
            coupling: 1e5,
            noise: 20.0,
            height_m,
        }
    }

    fn radargram(&self) -> Radargram {
        let n = 1152;
        let samples = (0..self.height_m.len())
            .flat_map(|m| (0..n).map(move |k| (m, k)))
            .map(|(m, k)| {
                let t = k as f64 * STEP_S - self.delay_s;
                let h = self.height_m[m];
                let x = 0.12 * m as f64 - 10.0;
                let target_s = two_way_delay_s((h * h + x * x).sqrt() - 0.4);
                let value = self.coupling * pulse(t - 0.5e-9)
                    + 1e3 * pulse(t - two_way_delay_s(h))
                    + 400.0 * pulse(t - target_s)
                    + self.noise * noise((m * n + k) as u64);
                value.round() as f32
            })
            .collect();
        let time_s = (0..self.height_m.len()).map(|m| m as f64 * 0.07).collect();
        Radargram::new(time_s, 0.0, STEP_S, Samples::Real(samples)).unwrap()
    }
}

#[test]
fn the_paper_zero_timing_puts_the_first_surface_echo_at_2h_over_c() {
    let flight = Flight::new(200, 0.25);
    let method = ZeroTiming::FirstTrace(SurfaceOptions::default());
    let done = zero_timing(flight.radargram(), &flight.height_m, &method).unwrap();
    // A tenth of a sample.
    assert!(
        (done.shift_s + flight.delay_s).abs() < 6e-12,
        "{:e}",
        done.shift_s
    );
    assert_eq!(done.radargram.fast_time_start_s, done.shift_s);
    let surface = done.surface.unwrap();
    assert!(
        (surface.delay_s - flight.delay_s).abs() < 30e-12,
        "{:e}",
        surface.delay_s
    );
    assert_eq!(surface.picks.iter().flatten().count(), 200);
    for (pick, h) in surface.picks.iter().zip(&flight.height_m) {
        let off = pick.unwrap().fast_time_s - flight.delay_s - two_way_delay_s(*h);
        assert!(
            off.abs() < 0.1e-9,
            "the target pulls some picks, but no pick is lost: {off:e}"
        );
    }
    assert!(done.median_residual_s.unwrap().abs() < 15e-12);
    assert!(done.spread_s.unwrap() < 10e-12);
}

#[test]
fn a_flight_of_constant_height_is_zero_timed_with_a_known_delay() {
    // Nothing moves apart, so the raw section is searched about the approximate delay.
    let flight = Flight::new(100, 0.0);
    let options = SurfaceOptions::default()
        .with_approximate_delay_s(10.5e-9)
        .with_band_hz([3.1e9, 4.8e9]);
    for method in [
        ZeroTiming::FirstTrace(options),
        ZeroTiming::AllTraces(options),
    ] {
        let done = zero_timing(flight.radargram(), &flight.height_m, &method).unwrap();
        assert!(
            (done.shift_s + flight.delay_s).abs() < 12e-12,
            "{:e}",
            done.shift_s
        );
    }
}

#[test]
fn a_tail_of_the_coupling_above_the_surface_does_no_harm() {
    // A steady flight, ± 3 cm, under a tail that decays past the surface and hides it.
    let flight = Flight::new(250, 0.03);
    let mut radargram = flight.radargram();
    let n = radargram.samples_per_trace;
    if let Samples::Real(values) = &mut radargram.samples {
        for (i, v) in values.iter_mut().enumerate() {
            let t = (i % n) as f64 * STEP_S - flight.delay_s;
            if t > 0.0 {
                *v += (3e5 * (-t / 7e-9).exp() * (TAU * 3.95e9 * t).cos()).round() as f32;
            }
        }
    }
    let options = SurfaceOptions::default().with_band_hz([3.1e9, 4.8e9]);
    let method = ZeroTiming::AllTraces(options);
    let done = zero_timing(radargram, &flight.height_m, &method).unwrap();
    // Taking the mean away also takes some of a surface this steady: half a centimetre of bias.
    assert!(
        (done.shift_s + flight.delay_s).abs() < 35e-12,
        "{:e}",
        done.shift_s
    );
}

#[test]
fn one_wrong_first_height_shows_in_the_residuals_of_all() {
    let mut flight = Flight::new(200, 0.25);
    let radargram = flight.radargram();
    flight.height_m[0] += 0.06;
    let method = ZeroTiming::FirstTrace(SurfaceOptions::default());
    let done = zero_timing(radargram.clone(), &flight.height_m, &method).unwrap();
    let error_s = two_way_delay_s(0.06);
    assert!(
        (done.median_residual_s.unwrap() - error_s).abs() < 15e-12,
        "{done:?}"
    );
    let method = ZeroTiming::AllTraces(SurfaceOptions::default());
    let done = zero_timing(radargram, &flight.height_m, &method).unwrap();
    assert!(
        (done.shift_s + flight.delay_s).abs() < 10e-12,
        "the median does not care"
    );
}

#[test]
fn given_shifts_and_delays() {
    let flight = Flight::new(3, 0.1);
    let start = |method: ZeroTiming| {
        zero_timing(flight.radargram(), &flight.height_m, &method)
            .unwrap()
            .radargram
            .fast_time_start_s
    };
    assert_eq!(start(ZeroTiming::None), 0.0);
    assert_eq!(start(ZeroTiming::Shift(-3e-9)), -3e-9);
    assert_eq!(start(ZeroTiming::Delay(10e-9)), -10e-9);
}

#[test]
fn no_surface_is_said_not_guessed() {
    let mut flight = Flight::new(150, 0.25);
    flight.coupling = 0.0;
    flight.noise = 50.0;
    let mut noise_only = flight.radargram();
    noise_only.samples = Samples::Real(
        (0..150 * 1152)
            .map(|i| (50.0 * noise(i + 77)).round() as f32)
            .collect(),
    );
    let options = SurfaceOptions::default();
    match track_surface(&noise_only, &flight.height_m, &options) {
        Err(CleanError::NoSurface { contrast_db, .. }) => assert!(contrast_db < 3.0),
        other => panic!("{other:?}"),
    }
    let too_high = vec![40.0; 150];
    assert!(matches!(
        track_surface(&noise_only, &too_high, &options),
        Err(CleanError::SurfaceOutside { .. })
    ));
    assert!(matches!(
        track_surface(&noise_only, &[4.0], &options),
        Err(CleanError::Heights {
            traces: 150,
            heights: 1
        })
    ));
    let mut unknown = flight.height_m.clone();
    unknown[0] = f64::NAN;
    assert!(matches!(
        zero_timing(
            flight.radargram(),
            &unknown,
            &ZeroTiming::FirstTrace(options)
        ),
        Err(CleanError::Height { trace: 0, .. })
    ));
    // A height missing elsewhere costs that pick only.
    let mut unknown = flight.height_m.clone();
    unknown[7] = f64::NAN;
    let done = zero_timing(
        flight.radargram(),
        &unknown,
        &ZeroTiming::FirstTrace(options),
    )
    .unwrap();
    let picks = done.surface.unwrap().picks;
    assert!(picks[7].is_none() && picks.iter().flatten().count() == 149);
}

fn energy(r: &Radargram, from_s: f64, to_s: f64) -> f64 {
    (0..r.traces)
        .flat_map(|m| (0..r.samples_per_trace).map(move |k| (m, k)))
        .filter(|(_, k)| (from_s..to_s).contains(&r.fast_time_s(*k)))
        .map(|(m, k)| r.at(m, k).norm_sqr())
        .sum()
}

#[test]
fn every_background_method_takes_the_coupling_and_leaves_the_surface() {
    let mut flight = Flight::new(200, 0.25);
    flight.noise = 0.5;
    let raw = flight.radargram();
    let coupling = [flight.delay_s - 1e-9, flight.delay_s + 2e-9];
    let surface = [flight.delay_s + 23e-9, flight.delay_s + 31e-9];
    for background in [
        Background::Mean,
        Background::Median,
        Background::Sliding { window: 61 },
        Background::Components { components: 1 },
    ] {
        let clean = remove_background(raw.clone(), background).unwrap();
        let left =
            energy(&clean, coupling[0], coupling[1]) / energy(&raw, coupling[0], coupling[1]);
        let kept = energy(&clean, surface[0], surface[1]) / energy(&raw, surface[0], surface[1]);
        // Coupling of 1e5 against noise and rounding of about 0.6: 90 dB and more.
        assert!(
            10.0 * left.log10() < -80.0,
            "{background:?} leaves {left:e}"
        );
        assert!(kept > 0.75, "{background:?} keeps {kept}");
    }
    assert_eq!(
        remove_background(raw.clone(), Background::None).unwrap(),
        raw
    );
}

#[test]
fn a_drifting_background_needs_the_window_or_two_components() {
    let (traces, n) = (120, 200);
    let value = |m: usize, k: usize| {
        let drift = 1.0 + 0.5 * (m as f64 / traces as f64);
        1000.0 * drift * (k as f64 * 0.3).sin()
            + 300.0 * (m as f64 * 0.05).cos() * (k as f64 * 0.11).cos()
    };
    let samples = (0..traces * n)
        .map(|i| value(i / n, i % n) as f32)
        .collect();
    let time_s = (0..traces).map(|m| m as f64).collect();
    let raw = Radargram::new(time_s, 0.0, 1e-9, Samples::Real(samples)).unwrap();
    let left = |b| {
        let clean = remove_background(raw.clone(), b).unwrap();
        10.0 * (energy(&clean, -1.0, 1.0) / energy(&raw, -1.0, 1.0)).log10()
    };
    assert!(left(Background::Mean) > -25.0);
    assert!(left(Background::Sliding { window: 5 }) < -40.0);
    assert!(left(Background::Components { components: 1 }) > -25.0);
    assert!(
        left(Background::Components { components: 2 }) < -110.0,
        "rank two is all there is"
    );
}

#[test]
fn components_are_the_best_low_rank_approximation() {
    // Against singular values of the whole matrix (Eckart–Young).
    let (traces, n) = (24, 31);
    let values: Vec<Complex32> = (0..traces * n)
        .map(|i| Complex32::new(noise(i as u64) as f32, noise(i as u64 + 5000) as f32))
        .collect();
    let time_s = (0..traces).map(|m| m as f64).collect();
    let raw = Radargram::new(time_s, 0.0, 1e-9, Samples::Complex(values)).unwrap();
    let matrix = nalgebra::DMatrix::from_fn(traces, n, |i, j| raw.at(i, j));
    let singular = matrix.singular_values();
    for components in 1..5 {
        let clean = remove_background(raw.clone(), Background::Components { components }).unwrap();
        let expected: f64 = singular.iter().skip(components).map(|s| s * s).sum();
        let found = energy(&clean, -1.0, 1.0);
        assert!(
            (found / expected - 1.0).abs() < 2e-3,
            "{components}: {found} {expected}"
        );
    }
}

#[test]
fn nonsense_backgrounds_and_gates_are_refused() {
    let raw = Flight::new(2, 0.1).radargram();
    let refused = |b| remove_background(raw.clone(), b).unwrap_err();
    assert!(matches!(
        refused(Background::Median),
        CleanError::TooFewTraces { needed: 3, .. }
    ));
    assert!(matches!(
        refused(Background::Components { components: 2 }),
        CleanError::Components { most: 1, .. }
    ));
    let three = Flight::new(3, 0.1).radargram();
    assert!(matches!(
        remove_background(three.clone(), Background::Sliding { window: 1 }),
        Err(CleanError::Window { window: 1 })
    ));
    let gate = |start_s, end_s, edge_s| Gate {
        start_s,
        end_s,
        edge_s,
    };
    for bad in [
        gate(1.0, 0.0, 0.0),
        gate(0.0, 1e-9, 2e-9),
        gate(f64::NAN, 1.0, 0.0),
    ] {
        assert!(matches!(
            apply_gate(three.clone(), &[4.0; 3], &bad),
            Err(CleanError::Gate { .. })
        ));
    }
    assert!(matches!(
        apply_gate(three, &[4.0, f64::INFINITY, 4.0], &Gate::default()),
        Err(CleanError::Height { trace: 1, .. })
    ));
}

#[test]
fn the_gate_follows_the_height() {
    let traces = 5;
    let height_m: Vec<f64> = (0..traces).map(|m| 3.0 + 0.5 * m as f64).collect();
    let ones = Samples::Real(vec![1.0; traces * 1152]);
    let time_s = (0..traces).map(|m| m as f64).collect();
    let flat = Radargram::new(time_s, 0.0, STEP_S, ones).unwrap();
    let gated = apply_gate(flat, &height_m, &Gate::default()).unwrap();
    for (m, &h) in height_m.iter().enumerate() {
        let surface_s = two_way_delay_s(h);
        let mut sum = 0.0;
        for k in 0..1152 {
            let weight = gated.at(m, k).re;
            let offset = gated.fast_time_s(k) - surface_s;
            sum += weight * STEP_S;
            match offset {
                o if (-5.4e-9..23.4e-9).contains(&o) => assert_eq!(weight, 1.0),
                o if !(-6.6e-9..24.6e-9).contains(&o) => assert_eq!(weight, 0.0),
                o => {
                    let inside = (o + 6e-9).min(24e-9 - o) / 1e-9;
                    let expected = 0.5 * (1.0 + (PI * inside.clamp(-0.5, 0.5)).sin());
                    assert!((weight - expected).abs() < 1e-6);
                }
            }
        }
        assert!(
            (sum - 30e-9).abs() < 0.02e-9,
            "the interval keeps its length: {sum:e}"
        );
    }
}

#[test]
fn an_envelope_peaks_where_the_pulse_does() {
    let centre = 20.013e-9;
    let trace = (0..1152)
        .map(|k| pulse(k as f64 * STEP_S - centre) as f32)
        .collect();
    let r = Radargram::new(vec![0.0], 0.0, STEP_S, Samples::Real(trace)).unwrap();
    let envelope = envelope(&r);
    for (k, e) in envelope.iter().enumerate() {
        let t = k as f64 * STEP_S - centre;
        let expected = (-(t / 0.22e-9).powi(2) / 2.0).exp();
        assert!((e - expected).abs() < 2e-3, "{k}: {e} {expected}");
    }
}

#[test]
fn a_zero_timed_echo_has_the_phase_of_the_contract() {
    let range_m = 5.4321;
    let n = 1152;
    let delay_s = two_way_delay_s(range_m);
    let trace = (0..n)
        .map(|k| pulse(5e-9 + k as f64 * STEP_S - delay_s) as f32)
        .collect();
    let r = Radargram::new(vec![0.0], 5e-9, STEP_S, Samples::Real(trace)).unwrap();
    let frequency_hz: Vec<f64> = (0..341).map(|i| 3.1e9 + 5e6 * f64::from(i)).collect();
    let spectrum = spectrum_at(&r, &frequency_hz).unwrap();
    for (f, s) in frequency_hz.iter().zip(&spectrum.values) {
        let k0 = TAU * f / acerra_radar::SPEED_OF_LIGHT_M_S;
        let back = s * Complex64::cis(2.0 * k0 * range_m);
        // Gaussian spectrum of the pulse, real and positive once the delay is taken out.
        let width = 0.22e-9;
        let expected =
            0.5 * width * TAU.sqrt() / STEP_S * (-(TAU * (f - 3.95e9) * width).powi(2) / 2.0).exp();
        assert!(
            (back - expected).norm() < 1e-5 * expected + 1e-5,
            "{f}: {back} {expected}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// The fast transform is the direct sum, to rounding.
    #[test]
    fn chirp_z_equals_the_sum(
        traces in 1usize..4,
        n in 2usize..300,
        m in 8usize..120,
        start in -50e-9..100e-9f64,
        first in 0.5e9..4e9f64,
        span in 1e6..3e9f64,
        complex in any::<bool>(),
        seed in any::<u32>(),
    ) {
        let at = |i: usize| noise(i as u64 + u64::from(seed)) as f32;
        let samples = if complex {
            Samples::Complex((0..traces * n).map(|i| Complex32::new(at(i), at(i + 9999))).collect())
        } else {
            Samples::Real((0..traces * n).map(at).collect())
        };
        let r = Radargram::new(vec![0.0; traces], start, STEP_S, samples).unwrap();
        let frequency_hz: Vec<f64> =
            (0..m).map(|i| first + span * i as f64 / (m - 1) as f64).collect();
        let fast = spectrum_at(&r, &frequency_hz).unwrap();
        let slow = spectrum_by_direct_sum(&r, &frequency_hz).unwrap();
        let scale: f64 = (n as f64).sqrt() * 2.0;
        for (a, b) in fast.values.iter().zip(&slow.values) {
            prop_assert!((a - b).norm() < 1e-9 * scale, "{a} {b}");
        }
    }

    /// Subtracting the mean twice is subtracting it once, and the mean is then nothing.
    #[test]
    fn mean_removal_is_a_projection(traces in 2usize..20, n in 2usize..20, seed in any::<u32>()) {
        let samples = (0..traces * n)
            .map(|i| (1000.0 * noise(i as u64 + u64::from(seed))) as f32)
            .collect();
        let r = Radargram::new(vec![0.0; traces], 0.0, 1.0, Samples::Real(samples)).unwrap();
        let once = remove_background(r, Background::Mean).unwrap();
        for j in 0..n {
            let mean: f64 = (0..traces).map(|i| once.at(i, j).re).sum::<f64>() / traces as f64;
            prop_assert!(mean.abs() < 1e-3);
        }
        let twice = remove_background(once.clone(), Background::Mean).unwrap();
        for i in 0..once.samples.len() {
            prop_assert!((once.samples.at(i) - twice.samples.at(i)).norm() < 1e-3);
        }
    }
}

#[test]
fn frequencies_the_samples_cannot_hold_are_refused() {
    let r = Flight::new(2, 0.1).radargram();
    for wrong in [0.0, -1e9, 8.2e9, f64::NAN] {
        assert!(matches!(
            spectrum_at(&r, &[4e9, wrong]),
            Err(CleanError::Frequency { .. })
        ));
    }
    assert!(spectrum_at(&r, &[]).is_err());
}
