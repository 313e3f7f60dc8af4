//! A flight that wanders, climbs and turns, with errors of its positions and of what is the same for the
//! whole flight: clock, lever arm, height of the scene, propagation speed, delay.
#![allow(dead_code)] // each test uses a part

#[path = "../draws/mod.rs"]
mod draws;

use std::f64::consts::{PI, TAU};

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

pub const PULSES: usize = 161;
const INTERVAL_S: f64 = 0.15;
const FREQUENCIES: usize = 171;
/// Noise of a range profile over a target's peak.
const NOISE: f64 = 0.01;
const CORRELATION_S: f64 = 1.0;

/// Names of the globals, in the order of [`Truth::values`].
pub const NAMES: [&str; 8] = [
    "delay", "clock", "drift", "forward", "left", "up", "height", "speed",
];
pub const DELAY: usize = 0;
pub const CLOCK: usize = 1;
pub const DRIFT: usize = 2;
pub const FORWARD: usize = 3;
pub const LEFT: usize = 4;
pub const UP: usize = 5;
pub const HEIGHT: usize = 6;
pub const SPEED: usize = 7;

/// How the flight moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Sways, climbs, turns and changes its speed.
    Wandering,
    /// Straight, level, at one speed.
    Straight,
}

impl Motion {
    fn at(self, t_s: f64) -> [f64; 3] {
        let wave = |amplitude: f64, period_s: f64| amplitude * (TAU * t_s / period_s).sin();
        match self {
            Self::Wandering => [
                wave(0.8, 13.0),
                0.5 * t_s + wave(0.4, 7.0),
                6.0 + wave(0.4, 11.0),
            ],
            Self::Straight => [0.0, 0.5 * t_s, 6.0],
        }
    }

    /// Forward, left and up: the nose along the track, rolled and pitched.
    fn axes(self, t_s: f64) -> [[f64; 3]; 3] {
        let rate = |a: usize| (self.at(t_s + 1e-4)[a] - self.at(t_s - 1e-4)[a]) / 2e-4;
        let heading = rate(1).atan2(rate(0));
        let (s, c) = heading.sin_cos();
        let tilt = match self {
            Self::Wandering => 0.15 * (TAU * t_s / 5.0).sin(),
            Self::Straight => 0.0,
        };
        let (ts, tc) = tilt.sin_cos();
        let (forward, left) = ([c, s, 0.0], [-s, c, 0.0]);
        let rolled = [0, 1, 2].map(|i| tc * left[i] + [0.0, 0.0, ts][i]);
        let up = [0, 1, 2].map(|i| [0.0, 0.0, tc][i] - ts * left[i]);
        [forward, rolled, up]
    }
}

/// A flight's errors: values of the globals, and deviations of the positions (m).
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    pub values: [f64; 8],
    pub path_sigma_m: f64,
}

pub struct Flight {
    pub motion: Motion,
    pub nominal_m: Vec<[f64; 3]>,
    pub true_m: Vec<[f64; 3]>,
    pub targets_m: Vec<[f64; 3]>,
    pub truth: Truth,
    frequency_hz: Vec<f64>,
    spectrum: Vec<Complex64>,
}

fn time_s(m: usize) -> f64 {
    m as f64 * INTERVAL_S
}

fn middle_s() -> f64 {
    0.5 * time_s(PULSES - 1)
}

/// Errors of unit variance that last for [`CORRELATION_S`].
fn lasting(rng: &mut ChaCha8Rng) -> Vec<f64> {
    let correlation = Correlation::Matern32 {
        length: CORRELATION_S,
    };
    correlated(rng, correlation, (PULSES, INTERVAL_S))
}

/// Deviations of the globals that the tests draw from.
pub const SIGMA: [f64; 8] = [0.05, 0.02, 500.0, 0.05, 0.05, 0.05, 0.2, 0.003];

/// Values drawn for the globals named, 0 for the others.
pub fn drawn(rng: &mut ChaCha8Rng, which: &[usize]) -> [f64; 8] {
    let mut values = [0.0; 8];
    for j in which {
        values[*j] = SIGMA[*j] * gaussian(rng);
    }
    values
}

impl Flight {
    /// Ten targets beside the flight.
    pub fn new(seed: u64, motion: Motion, which: &[usize], path_sigma_m: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let targets: Vec<[f64; 2]> = (0..10)
            .map(|_| [rng.random_range(1.5..6.5), rng.random_range(1.0..11.0)])
            .collect();
        let values = drawn(&mut rng, which);
        Self::over(&mut rng, motion, values, path_sigma_m, &targets)
    }

    pub fn over(
        rng: &mut ChaCha8Rng,
        motion: Motion,
        values: [f64; 8],
        path_sigma_m: f64,
        targets: &[[f64; 2]],
    ) -> Self {
        let error = [(); 3].map(|()| lasting(rng));
        let nominal_m: Vec<[f64; 3]> = (0..PULSES).map(|m| motion.at(time_s(m))).collect();
        let true_m: Vec<[f64; 3]> = (0..PULSES)
            .map(|m| {
                let late_s = values[CLOCK] + 1e-6 * values[DRIFT] * (time_s(m) - middle_s());
                let at = motion.at(time_s(m) + late_s);
                let axes = motion.axes(time_s(m));
                [0, 1, 2].map(|a| {
                    let lever: f64 = (0..3).map(|i| values[FORWARD + i] * axes[i][a]).sum();
                    at[a] + lever + path_sigma_m * error[a][m]
                })
            })
            .collect();
        let targets_m: Vec<[f64; 3]> = targets
            .iter()
            .map(|[x, y]| [*x, *y, values[HEIGHT]])
            .collect();
        let frequency_hz: Vec<f64> = (0..FREQUENCIES)
            .map(|n| 3.1e9 + 1.7e9 * n as f64 / (FREQUENCIES - 1) as f64)
            .collect();
        let window: Vec<f64> = (0..FREQUENCIES)
            .map(|n| 0.54 - 0.46 * (TAU * n as f64 / (FREQUENCIES - 1) as f64).cos())
            .collect();
        let peak: f64 = window.iter().sum();
        let noise = NOISE * peak / (FREQUENCIES as f64).sqrt() / 2.0_f64.sqrt();
        let mut spectrum = Vec::with_capacity(PULSES * FREQUENCIES);
        let phase: Vec<f64> = targets.iter().map(|_| rng.random_range(-PI..PI)).collect();
        for p in &true_m {
            for (f, w) in frequency_hz.iter().zip(&window) {
                let mut sum = Complex64::ZERO;
                for (q, own) in targets_m.iter().zip(&phase) {
                    let apart: f64 = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum();
                    let range = apart.sqrt() / (1.0 + values[SPEED]) + values[DELAY];
                    sum += Complex64::cis(own - 4.0 * PI * f * range / SPEED_OF_LIGHT_M_S);
                }
                let n = Complex64::new(gaussian(rng), gaussian(rng)) * noise;
                spectrum.push(sum * w + n);
            }
        }
        Self {
            motion,
            nominal_m,
            true_m,
            targets_m,
            truth: Truth {
                values,
                path_sigma_m,
            },
            frequency_hz,
            spectrum,
        }
    }

    /// Errors of the corrected positions above the scene, whether applied or not, over their deviations, mean
    /// square.
    pub fn path_square(&self, found: &Autofocused) -> f64 {
        let count = (3 * PULSES) as f64;
        let of = |m: usize| {
            let level = [0.0, 0.0, self.truth.values[HEIGHT]];
            let square = |a: usize| {
                let error = self.nominal_m[m][a] + found.correction_m[m][a] + level[a];
                ((error - self.true_m[m][a]) / found.sigma_m[m][a]).powi(2)
            };
            (0..3).map(square).sum::<f64>()
        };
        (0..PULSES).map(of).sum::<f64>() / count
    }

    /// The prior with these globals free, deviations as drawn from times `factor`.
    pub fn prior(&self, which: &[usize], factor: f64) -> PositionPrior {
        let times: Vec<f64> = (0..PULSES).map(time_s).collect();
        let correlation = Correlation::Matern32 {
            length: CORRELATION_S,
        };
        let sigma = [[self.truth.path_sigma_m; 3]; PULSES];
        let mut prior = PositionPrior::of_deviations(&sigma, &times, correlation);
        prior.globals = which.iter().map(|j| self.global(*j, factor)).collect();
        prior
    }

    fn global(&self, j: usize, factor: f64) -> Global {
        let sigma = factor * SIGMA[j];
        let shifted = |scale: &dyn Fn(f64) -> f64| {
            let at = |m: usize, s: f64| self.motion.at(time_s(m) + s * scale(time_s(m)));
            let of = |value: &dyn Fn([f64; 3], [f64; 3], [f64; 3], usize) -> f64| {
                let each = |m| {
                    let [low, own, high] = [-1.0, 0.0, 1.0].map(|s| at(m, s * sigma));
                    [0, 1, 2].map(|a| value(low, own, high, a))
                };
                (0..PULSES).map(each).collect::<Vec<_>>()
            };
            Effect::Position {
                first: of(&|low, _, high, a| (high[a] - low[a]) / (2.0 * sigma)),
                second: of(&|low, own, high, a| {
                    (high[a] + low[a] - 2.0 * own[a]) / (sigma * sigma)
                }),
            }
        };
        let effect = match j {
            DELAY => Effect::Delay(0..PULSES),
            CLOCK => shifted(&|_| 1.0),
            DRIFT => shifted(&|t| 1e-6 * (t - middle_s())),
            // The flight is lower above the scene where the scene is higher.
            HEIGHT => Effect::Position {
                first: vec![[0.0, 0.0, -1.0]; PULSES],
                second: vec![[0.0; 3]; PULSES],
            },
            SPEED => Effect::Speed,
            axis => Effect::Position {
                first: (0..PULSES)
                    .map(|m| self.motion.axes(time_s(m))[axis - FORWARD])
                    .collect(),
                second: vec![[0.0; 3]; PULSES],
            },
        };
        Global {
            name: NAMES[j].into(),
            sigma,
            effect,
        }
    }

    pub fn focus(&self, prior: &PositionPrior) -> Autofocused {
        let grid = PlaneGrid::from_ranges([0.5, 7.5], [0.0, 12.0], 0.0, 0.03).unwrap();
        let options = AutofocusOptions::default();
        autofocus(
            self.pulses(&self.nominal_m, &self.spectrum, SPEED_OF_LIGHT_M_S),
            grid,
            prior,
            &options,
            Control::default(),
        )
        .unwrap()
    }

    /// The data with this range taken off all echoes.
    fn spectrum_less(&self, delay_m: f64) -> Vec<Complex64> {
        let mut spectrum = self.spectrum.clone();
        for row in spectrum.chunks_exact_mut(FREQUENCIES) {
            for (v, f) in row.iter_mut().zip(&self.frequency_hz) {
                *v *= Complex64::cis(4.0 * PI * f * delay_m / SPEED_OF_LIGHT_M_S);
            }
        }
        spectrum
    }

    fn pulses<'a>(
        &'a self,
        position_m: &'a [[f64; 3]],
        spectrum: &'a [Complex64],
        light_speed_m_s: f64,
    ) -> Pulses<'a> {
        Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &self.frequency_hz,
            spectrum,
            weight: &[1.0; PULSES],
            light_speed_m_s,
        })
        .unwrap()
    }

    /// Where a target shows itself on the plane of an image with these positions and globals: the place whose
    /// ranges are most like its own.
    fn shown_at(
        &self,
        position_m: &[[f64; 3]],
        values: &[f64; 8],
        target_m: &[f64; 3],
    ) -> [f64; 2] {
        let apart = |p: &[f64; 3], q: [f64; 3]| {
            let square: f64 = (0..3).map(|a| (p[a] - q[a]).powi(2)).sum();
            square.sqrt()
        };
        let truth = &self.truth.values;
        let mut at = [target_m[0], target_m[1]];
        for _ in 0..20 {
            let (mut n, mut r) = ([[1e-9, 0.0], [0.0, 1e-9]], [0.0; 2]);
            for (p, q) in position_m.iter().zip(&self.true_m) {
                let wanted = apart(q, *target_m) / (1.0 + truth[SPEED]) + truth[DELAY];
                let distance = apart(p, [at[0], at[1], values[HEIGHT]]);
                let off = wanted - distance / (1.0 + values[SPEED]) - values[DELAY];
                let slope = [0, 1].map(|a| (at[a] - p[a]) / distance);
                for i in 0..2 {
                    r[i] += slope[i] * off;
                    (0..2).for_each(|j| n[i][j] += slope[i] * slope[j]);
                }
            }
            let determinant = n[0][0] * n[1][1] - n[0][1] * n[1][0];
            at[0] += (n[1][1] * r[0] - n[0][1] * r[1]) / determinant;
            at[1] += (n[0][0] * r[1] - n[1][0] * r[0]) / determinant;
        }
        at
    }

    /// Greatest power within 0.3 m of where each target shows itself in an image with these positions and
    /// globals.
    pub fn peaks(&self, position_m: &[[f64; 3]], values: &[f64; 8]) -> Vec<f64> {
        let spectrum = self.spectrum_less(values[DELAY]);
        let light_speed_m_s = SPEED_OF_LIGHT_M_S * (1.0 + values[SPEED]);
        let of = |target_m: &[f64; 3]| {
            let [x, y] = self.shown_at(position_m, values, target_m);
            let about = |v: f64| [v - 0.3, v + 0.3];
            let grid = PlaneGrid::from_ranges(about(x), about(y), values[HEIGHT], 0.01).unwrap();
            let options = PlanOptions::default()
                .with_spreading(Spreading::None)
                .with_check_pixels(1);
            let pulses = self.pulses(position_m, &spectrum, light_speed_m_s);
            let image = image(pulses, grid, &options, Control::default()).unwrap();
            let power = image.iter().map(|v| f64::from(v.norm_sqr()));
            power.fold(0.0, f64::max)
        };
        self.targets_m.iter().map(of).collect()
    }

    /// Mean loss of the targets' peaks against those of true positions and globals, dB: as stated, and as
    /// found.
    pub fn loss_db(&self, found: &Autofocused) -> [f64; 2] {
        let right = self.peaks(&self.true_m, &self.truth.values);
        let mut values = [0.0; 8];
        if found.decision == Decision::Applied {
            for global in &found.globals {
                let j = NAMES.iter().position(|name| *name == global.name).unwrap();
                values[j] = global.value;
            }
        }
        values[HEIGHT] = 0.0; // the positions have it
        let stated = self.peaks(&self.nominal_m, &[0.0; 8]);
        let corrected = self.peaks(&found.position_m, &values);
        [stated, corrected].map(|powers| {
            let each = right.iter().zip(&powers);
            each.map(|(r, p)| 10.0 * (r / p).log10()).sum::<f64>() / right.len() as f64
        })
    }
}
