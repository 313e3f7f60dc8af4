//! Two passes over the same targets, each with a delay, a phase and a place of its own.

#[path = "../draws/mod.rs"]
mod draws;

use std::f64::consts::{PI, TAU};
use std::ops::Range;

use acerra_autofocus::{
    AutofocusOptions, Autofocused, Correlation, Decision, Effect, Global, PositionPrior, autofocus,
};
use acerra_imaging::{
    Complex64, Control, PlanOptions, PlaneGrid, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading,
    image,
};
use draws::{correlated, gaussian};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Pulses of each pass, and of both.
const OF_PASS: usize = 101;
pub const PULSES: usize = 2 * OF_PASS;
/// The second pass.
pub const SECOND: Range<usize> = OF_PASS..PULSES;
const FREQUENCIES: usize = 171;
/// Noise of a range profile over a target's peak.
const NOISE: f64 = 0.01;
/// Errors of the positions (m), and over which time they last (s).
const PATH_SIGMA_M: f64 = 0.003;
const CORRELATION_S: f64 = 1.0;
const INTERVAL_S: f64 = 0.12;
/// Deviations of what the second pass has for its own: range (m), phase (rad), place (m).
pub const DELAY_SIGMA_M: f64 = 0.03;
pub const PHASE_SIGMA_RAD: f64 = 1.8;
pub const SHIFT_SIGMA_M: f64 = 0.03;

/// What the second pass has for its own, and whether targets turn between the passes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Truth {
    pub delay_m: f64,
    pub phase_rad: f64,
    pub shift_m: [f64; 3],
    pub targets_turn: bool,
}

impl Truth {
    pub fn drawn(rng: &mut ChaCha8Rng) -> Self {
        Self {
            delay_m: DELAY_SIGMA_M * gaussian(rng),
            phase_rad: rng.random_range(-PI..PI),
            shift_m: [(); 3].map(|()| SHIFT_SIGMA_M * gaussian(rng)),
            targets_turn: false,
        }
    }
}

pub struct Passes {
    pub truth: Truth,
    pub nominal_m: Vec<[f64; 3]>,
    pub true_m: Vec<[f64; 3]>,
    targets_m: Vec<[f64; 3]>,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
}

/// The first pass flies north, the second back, lower and beside it; both sway.
fn flown_m(m: usize) -> [f64; 3] {
    let along = 0.1 * (m % OF_PASS) as f64;
    let wave = |amplitude: f64, length_m: f64| amplitude * (TAU * along / length_m).sin();
    match m < OF_PASS {
        true => [wave(0.2, 9.0), along - 5.0, 8.0 + wave(0.1, 5.0)],
        false => [-1.0 + wave(0.15, 7.0), 5.0 - along, 6.5 + wave(0.1, 4.0)],
    }
}

/// Errors of unit variance that last for [`CORRELATION_S`].
fn lasting(rng: &mut ChaCha8Rng) -> Vec<f64> {
    let correlation = Correlation::Matern32 {
        length: CORRELATION_S,
    };
    correlated(rng, correlation, (OF_PASS, INTERVAL_S))
}

impl Passes {
    /// Ten targets beside both passes.
    pub fn new(seed: u64, truth: impl Fn(&mut ChaCha8Rng) -> Truth) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let targets_m: Vec<[f64; 3]> = (0..10)
            .map(|_| [rng.random_range(1.5..6.0), rng.random_range(-4.5..4.5), 0.0])
            .collect();
        let truth = truth(&mut rng);
        let nominal_m: Vec<[f64; 3]> = (0..PULSES).map(flown_m).collect();
        let error: Vec<[f64; 3]> = (0..2)
            .flat_map(|_| {
                let axes = [(); 3].map(|()| lasting(&mut rng));
                (0..OF_PASS).map(move |m| [0, 1, 2].map(|a| PATH_SIGMA_M * axes[a][m]))
            })
            .collect();
        let shift = |m: usize| {
            if SECOND.contains(&m) {
                truth.shift_m
            } else {
                [0.0; 3]
            }
        };
        let true_m: Vec<[f64; 3]> = (0..PULSES)
            .map(|m| [0, 1, 2].map(|a| nominal_m[m][a] + error[m][a] + shift(m)[a]))
            .collect();
        let mut passes = Self {
            truth,
            nominal_m,
            true_m,
            targets_m,
            frequency_hz: (0..FREQUENCIES)
                .map(|n| 3.1e9 + 1.7e9 * n as f64 / (FREQUENCIES - 1) as f64)
                .collect(),
            spectrum: Vec::new(),
        };
        passes.spectrum = passes.echoes(&mut rng);
        passes
    }

    fn echoes(&self, rng: &mut ChaCha8Rng) -> Vec<Complex64> {
        let window = |n: usize| 0.54 - 0.46 * (TAU * n as f64 / (FREQUENCIES - 1) as f64).cos();
        let peak: f64 = (0..FREQUENCIES).map(window).sum();
        let noise = NOISE * peak / (2.0 * FREQUENCIES as f64).sqrt();
        let mut own_phases = || -> Vec<f64> {
            self.targets_m
                .iter()
                .map(|_| rng.random_range(-PI..PI))
                .collect()
        };
        let phases = [own_phases(), own_phases()];
        let mut spectrum = Vec::with_capacity(PULSES * FREQUENCIES);
        for (m, p) in self.true_m.iter().enumerate() {
            let is_second = SECOND.contains(&m);
            let of_target = &phases[usize::from(is_second && self.truth.targets_turn)];
            let (delay_m, turn) = match is_second {
                true => (self.truth.delay_m, self.truth.phase_rad),
                false => (0.0, 0.0),
            };
            for (n, f) in self.frequency_hz.iter().enumerate() {
                let echo = |(q, own): (&[f64; 3], &f64)| {
                    let apart: f64 = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum();
                    let range_m = apart.sqrt() + delay_m;
                    Complex64::cis(own + turn - 4.0 * PI * f * range_m / SPEED_OF_LIGHT_M_S)
                };
                let sum: Complex64 = self.targets_m.iter().zip(of_target).map(echo).sum();
                let white = Complex64::new(gaussian(rng), gaussian(rng));
                spectrum.push(sum * window(n) + white * noise);
            }
        }
        spectrum
    }

    /// What the positions are known to be off, with what the second pass has for its own.
    pub fn prior(&self) -> PositionPrior {
        let time_s: Vec<f64> = (0..PULSES)
            .map(|m| INTERVAL_S * m as f64 + if SECOND.contains(&m) { 1e6 } else { 0.0 })
            .collect();
        let correlation = Correlation::Matern32 {
            length: CORRELATION_S,
        };
        let sigma = [[PATH_SIGMA_M; 3]; PULSES];
        let mut prior = PositionPrior::of_deviations(&sigma, &time_s, correlation);
        let of = |name: &str, sigma, effect| Global {
            name: name.to_owned(),
            sigma,
            effect,
        };
        prior.globals = vec![
            of("delay", DELAY_SIGMA_M, Effect::Delay(SECOND)),
            of("phase", PHASE_SIGMA_RAD, Effect::Phase(SECOND)),
        ];
        for (axis, name) in ["east", "north", "up"].into_iter().enumerate() {
            let mut first = vec![[0.0; 3]; PULSES];
            first[SECOND].iter_mut().for_each(|d| d[axis] = 1.0);
            let second = vec![[0.0; 3]; PULSES];
            prior
                .globals
                .push(of(name, SHIFT_SIGMA_M, Effect::Position { first, second }));
        }
        prior
    }

    /// True values of the prior's globals, in its order.
    pub fn values(&self) -> [f64; 5] {
        let [east, north, up] = self.truth.shift_m;
        [self.truth.delay_m, self.truth.phase_rad, east, north, up]
    }

    pub fn focus(&self, prior: &PositionPrior, parts: &[Range<usize>]) -> Autofocused {
        let mut options = AutofocusOptions::default();
        options.coherent_parts = parts.to_vec();
        let pulses = self.pulses(&self.nominal_m, &self.spectrum);
        let grid = PlaneGrid::from_ranges([0.5, 7.0], [-5.5, 5.5], 0.0, 0.02).unwrap();
        autofocus(pulses, grid, prior, &options, Control::default()).unwrap()
    }

    fn pulses<'a>(&'a self, position_m: &'a [[f64; 3]], spectrum: &'a [Complex64]) -> Pulses<'a> {
        Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &self.frequency_hz,
            spectrum,
            weight: &[1.0; PULSES],
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
        })
        .unwrap()
    }

    /// Greatest power about each target of the image by these positions, delay and phase of the second pass:
    /// of all pulses, or the passes' powers summed.
    fn peaks(
        &self,
        position_m: &[[f64; 3]],
        delay_m: f64,
        phase_rad: f64,
        together: bool,
    ) -> Vec<f64> {
        let mut spectrum = self.spectrum.clone();
        for pulse in spectrum[SECOND.start * FREQUENCIES..].chunks_exact_mut(FREQUENCIES) {
            for (v, f) in pulse.iter_mut().zip(&self.frequency_hz) {
                let back = 4.0 * PI * f * delay_m / SPEED_OF_LIGHT_M_S - phase_rad;
                *v *= Complex64::cis(back);
            }
        }
        let of = |target: &[f64; 3], part: &Range<usize>| {
            let about = |v: f64| [v - 0.25, v + 0.25];
            let grid =
                PlaneGrid::from_ranges(about(target[0]), about(target[1]), 0.0, 0.01).unwrap();
            let options = PlanOptions::default()
                .with_spreading(Spreading::None)
                .with_check_pixels(1);
            let own = &spectrum[part.start * FREQUENCIES..part.end * FREQUENCIES];
            let pulses = Pulses::new(PulseArrays {
                position_m: &position_m[part.clone()],
                frequency_hz: &self.frequency_hz,
                spectrum: own,
                weight: &[1.0; PULSES][..part.len()],
                light_speed_m_s: SPEED_OF_LIGHT_M_S,
            });
            let image = image(pulses.unwrap(), grid, &options, Control::default()).unwrap();
            image
                .iter()
                .map(|v| f64::from(v.norm_sqr()))
                .collect::<Vec<f64>>()
        };
        let whole = [Range {
            start: 0,
            end: PULSES,
        }];
        let passes = [0..SECOND.start, SECOND];
        let parts: &[Range<usize>] = if together { &whole } else { &passes };
        let peak = |target: &[f64; 3]| {
            let images: Vec<Vec<f64>> = parts.iter().map(|part| of(target, part)).collect();
            let sum = |i: usize| images.iter().map(|image| image[i]).sum::<f64>();
            (0..images[0].len()).map(sum).fold(0.0, f64::max)
        };
        self.targets_m.iter().map(peak).collect()
    }

    /// Mean loss of the targets' peaks against those of the truth, dB: as stated, and as found.
    pub fn loss_db(&self, found: &Autofocused, together: bool) -> [f64; 2] {
        let values = self.values();
        let right = self.peaks(&self.true_m, values[0], values[1], together);
        let stated = self.peaks(&self.nominal_m, 0.0, 0.0, together);
        let value = |name: &str| {
            let own = found.globals.iter().find(|g| g.name == name);
            own.filter(|_| found.decision == Decision::Applied)
                .map_or(0.0, |g| g.value)
        };
        let corrected = self.peaks(&found.position_m, value("delay"), value("phase"), together);
        [stated, corrected].map(|powers| {
            let each = right.iter().zip(&powers);
            each.map(|(r, p)| 10.0 * (r / p).log10()).sum::<f64>() / right.len() as f64
        })
    }
}
