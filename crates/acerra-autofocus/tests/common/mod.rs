//! The scene of the comparison with published autofocus: a straight nominal track 10 m up, smooth
//! errors of its positions, point targets on the ground, and how a result is measured.
#![allow(dead_code)] // each test uses a part

use std::f64::consts::PI;

use acerra_autofocus::{AutofocusOptions, Autofocused, Correlation, PositionPrior, autofocus};
use acerra_imaging::{
    Complex64, Control, PlanOptions, PlaneGrid, PulseArrays, Pulses, SPEED_OF_LIGHT_M_S, Spreading,
    image, reference,
};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub const PULSES: usize = 331;
const HALF_TRACK_M: f64 = 8.0;
const HEIGHT_M: f64 = 10.0;
const FREQUENCIES: usize = 341;
const NOISE: f64 = 0.01;

/// A target, which may move at a constant velocity over the flight.
#[derive(Clone, Copy)]
pub struct Target {
    pub position_m: [f64; 3],
    pub amplitude: Complex64,
    /// Displacement from the first pulse to the last, m, and amplitude of a sway, m.
    pub drift_m: [f64; 3],
    pub sway_m: f64,
}

impl Target {
    pub fn at(x_m: f64, y_m: f64) -> Self {
        Self {
            position_m: [x_m, y_m, 0.0],
            amplitude: Complex64::ONE,
            drift_m: [0.0; 3],
            sway_m: 0.0,
        }
    }
}

/// Errors of the positions.
#[derive(Clone, Copy)]
pub struct Errors {
    /// Rms in x and y, m; double in z.
    pub sigma_m: f64,
    /// Deviation of the Gaussian that smooths white noise, m; 0 for white errors.
    pub smoothed_m: f64,
}

pub struct Scene {
    pub nominal_m: Vec<[f64; 3]>,
    pub true_m: Vec<[f64; 3]>,
    pub targets: Vec<Target>,
    pub frequency_hz: Vec<f64>,
    pub spectrum: Vec<Complex64>,
}

pub fn gaussian(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random::<f64>().max(1e-300), rng.random());
    (-2.0 * u.ln()).sqrt() * (2.0 * PI * v).cos()
}

pub fn spacing_m() -> f64 {
    2.0 * HALF_TRACK_M / (PULSES - 1) as f64
}

fn without_trend(values: &mut [f64]) {
    let n = values.len() as f64;
    let centre = 0.5 * (n - 1.0);
    let mean = values.iter().sum::<f64>() / n;
    let square: f64 = (0..values.len()).map(|i| (i as f64 - centre).powi(2)).sum();
    let cross: f64 = values
        .iter()
        .enumerate()
        .map(|(i, v)| (i as f64 - centre) * v)
        .sum();
    for (i, v) in values.iter_mut().enumerate() {
        *v -= mean + cross / square * (i as f64 - centre);
    }
}

fn error_of_axis(rng: &mut ChaCha8Rng, sigma_m: f64, smoothed_m: f64) -> Vec<f64> {
    let s = smoothed_m / spacing_m();
    let pad = (5.0 * s).ceil() as usize;
    let white: Vec<f64> = (0..PULSES + 2 * pad).map(|_| gaussian(rng)).collect();
    let mut error: Vec<f64> = (0..PULSES)
        .map(|m| {
            (0..=2 * pad)
                .map(|j| {
                    let lag = j as f64 - pad as f64;
                    let weight = if s > 0.0 {
                        (-0.5 * (lag / s).powi(2)).exp()
                    } else {
                        1.0
                    };
                    white[m + j] * weight
                })
                .sum()
        })
        .collect();
    without_trend(&mut error);
    let rms = (error.iter().map(|v| v * v).sum::<f64>() / PULSES as f64).sqrt();
    error.iter_mut().for_each(|v| *v *= sigma_m / rms);
    error
}

/// Lower Cholesky factor of a correlation matrix over the pulses.
fn factor_of(correlation: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let mut factor = vec![vec![0.0; PULSES]; PULSES];
    for i in 0..PULSES {
        for j in 0..=i {
            let done: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let left = correlation(i, j) - done;
            factor[i][j] = if i == j {
                left.max(1e-12).sqrt()
            } else {
                left / factor[j][j]
            };
        }
    }
    factor
}

/// Targets of the published scene.
pub fn twelve(rng: &mut ChaCha8Rng) -> Vec<Target> {
    (0..12)
        .map(|_| {
            let (x, y) = (rng.random_range(2.0..8.0), rng.random_range(-5.0..5.0));
            let phase = rng.random_range(-PI..PI);
            Target {
                amplitude: Complex64::cis(phase),
                ..Target::at(x, y)
            }
        })
        .collect()
}

/// Weak scatterers of random place and amplitude: ground clutter.
pub fn clutter(rng: &mut ChaCha8Rng, count: usize, amplitude: f64) -> Vec<Target> {
    (0..count)
        .map(|_| {
            let (x, y) = (rng.random_range(1.5..8.5), rng.random_range(-5.5..5.5));
            let a = Complex64::new(gaussian(rng), gaussian(rng)) * amplitude;
            Target {
                amplitude: a,
                ..Target::at(x, y)
            }
        })
        .collect()
}

impl Scene {
    pub fn new(
        seed: u64,
        errors: Errors,
        targets: impl Fn(&mut ChaCha8Rng) -> Vec<Target>,
    ) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let targets = targets(&mut rng);
        let error_m =
            [1.0, 1.0, 2.0].map(|f| error_of_axis(&mut rng, f * errors.sigma_m, errors.smoothed_m));
        Self::with_errors(&mut rng, &error_m, targets)
    }

    /// The scene with errors drawn from the prior itself, common shifts and trends included.
    pub fn drawn_from_prior(seed: u64, sigma_m: f64, smoothed_m: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let targets = twelve(&mut rng);
        let correlation = Self::prior(sigma_m, smoothed_m).correlation;
        let factor = factor_of(|i, j| correlation.at((i as f64 - j as f64) * spacing_m()));
        let error_m = [1.0, 1.0, 2.0].map(|f| {
            let white: Vec<f64> = (0..PULSES).map(|_| gaussian(&mut rng)).collect();
            let row = |m: usize| (0..=m).map(|j| factor[m][j] * white[j]).sum::<f64>();
            (0..PULSES).map(|m| f * sigma_m * row(m)).collect()
        });
        Self::with_errors(&mut rng, &error_m, targets)
    }

    /// The scene with errors in x and z that are correlated by `rho`, as
    /// [`Scene::correlated_prior`] has them.
    pub fn correlated(seed: u64, errors: Errors, rho: f64, targets: Vec<Target>) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [x, y, own] =
            [1.0; 3].map(|_| error_of_axis(&mut rng, errors.sigma_m, errors.smoothed_m));
        let share = (1.0 - rho * rho).sqrt();
        let both = x.iter().zip(&own);
        let z = both.map(|(x, z)| 2.0 * (rho * x + share * z)).collect();
        Self::with_errors(&mut rng, &[x, y, z], targets)
    }

    fn with_errors(rng: &mut ChaCha8Rng, error_m: &[Vec<f64>; 3], targets: Vec<Target>) -> Self {
        let nominal_m: Vec<[f64; 3]> = (0..PULSES)
            .map(|m| [0.0, m as f64 * spacing_m() - HALF_TRACK_M, HEIGHT_M])
            .collect();
        let true_m: Vec<[f64; 3]> = (0..PULSES)
            .map(|m| [0, 1, 2].map(|a| nominal_m[m][a] + error_m[a][m]))
            .collect();
        let frequency_hz: Vec<f64> = (0..FREQUENCIES)
            .map(|n| 3.1e9 + 1.7e9 * n as f64 / (FREQUENCIES - 1) as f64)
            .collect();
        let window: Vec<f64> = (0..FREQUENCIES)
            .map(|n| 0.54 - 0.46 * (2.0 * PI * n as f64 / (FREQUENCIES - 1) as f64).cos())
            .collect();
        let peak: f64 = window.iter().sum();
        let noise = NOISE * peak / (FREQUENCIES as f64).sqrt() / 2.0_f64.sqrt();
        let mut spectrum = Vec::with_capacity(PULSES * FREQUENCIES);
        for (m, p) in true_m.iter().enumerate() {
            let share = m as f64 / (PULSES - 1) as f64;
            let mut row = vec![Complex64::ZERO; FREQUENCIES];
            for t in &targets {
                let sway = t.sway_m * (2.0 * PI * 3.0 * share).sin();
                let q = [0, 1, 2].map(|a| t.position_m[a] + t.drift_m[a] * (share - 0.5));
                let r = reference::range_m(*p, [q[0] + sway, q[1], q[2]]);
                let step = 4.0 * PI * (frequency_hz[1] - frequency_hz[0]) / SPEED_OF_LIGHT_M_S;
                let mut turn = Complex64::cis(-4.0 * PI * frequency_hz[0] / SPEED_OF_LIGHT_M_S * r);
                let turn_step = Complex64::cis(-step * r);
                for v in &mut row {
                    *v += t.amplitude * turn;
                    turn *= turn_step;
                }
            }
            for (v, w) in row.iter().zip(&window) {
                let n = Complex64::new(gaussian(rng), gaussian(rng)) * noise;
                spectrum.push(v * w + n);
            }
        }
        Self {
            nominal_m,
            true_m,
            targets,
            frequency_hz,
            spectrum,
        }
    }

    pub fn pulses<'a>(&'a self, position_m: &'a [[f64; 3]]) -> Pulses<'a> {
        Pulses::new(PulseArrays {
            position_m,
            frequency_hz: &self.frequency_hz,
            spectrum: &self.spectrum,
            weight: &[1.0; PULSES],
            light_speed_m_s: SPEED_OF_LIGHT_M_S,
        })
        .unwrap()
    }

    pub fn grid() -> PlaneGrid {
        PlaneGrid::from_ranges([1.5, 8.5], [-5.5, 5.5], 0.0, 0.02).unwrap()
    }

    /// The ground on both sides of the track, where every target has a ghost.
    pub fn both_sides() -> PlaneGrid {
        PlaneGrid::from_ranges([-8.5, 8.5], [-5.5, 5.5], 0.0, 0.02).unwrap()
    }

    pub fn prior(sigma_m: f64, smoothed_m: f64) -> PositionPrior {
        let correlation = if smoothed_m == 0.0 {
            Correlation::White
        } else {
            // The curvature at 0 of white noise smoothed by a Gaussian, e^{−d²/(4s²)}.
            Correlation::Matern52 {
                length: smoothed_m * (10.0_f64 / 3.0).sqrt(),
            }
        };
        let abscissa: Vec<f64> = (0..PULSES).map(|m| m as f64 * spacing_m()).collect();
        let sigma = [sigma_m, sigma_m, 2.0 * sigma_m];
        PositionPrior::of_deviations(&[sigma; PULSES], &abscissa, correlation)
    }

    /// The prior of errors without mean and trend that are correlated by `rho` in x and z.
    pub fn correlated_prior(sigma_m: f64, smoothed_m: f64, rho: f64) -> PositionPrior {
        let plain = Self::prior(sigma_m, smoothed_m);
        let v = sigma_m * sigma_m;
        let covariance = [
            [v, 0.0, 2.0 * rho * v],
            [0.0, v, 0.0],
            [2.0 * rho * v, 0.0, 4.0 * v],
        ];
        PositionPrior {
            without_trend: true,
            ..PositionPrior::of_covariances(
                &[covariance; PULSES],
                &plain.abscissa,
                plain.correlation,
            )
        }
    }

    /// The prior of errors without mean and trend.
    pub fn trendless_prior(sigma_m: f64, smoothed_m: f64) -> PositionPrior {
        PositionPrior {
            without_trend: true,
            ..Self::prior(sigma_m, smoothed_m)
        }
    }

    pub fn focus(&self, prior: &PositionPrior) -> Autofocused {
        self.focus_on(Self::grid(), prior)
    }

    pub fn focus_on(&self, grid: PlaneGrid, prior: &PositionPrior) -> Autofocused {
        let options = AutofocusOptions::default();
        let pulses = self.pulses(&self.nominal_m);
        autofocus(pulses, grid, prior, &options, Control::default()).unwrap()
    }

    /// Peak power within ±0.24 m of a target and where it stands.
    pub fn peak(&self, position_m: &[[f64; 3]], target: &Target) -> (f64, [f64; 2]) {
        let [x, y, _] = target.position_m;
        let about = |v: f64| [v - 0.24, v + 0.24];
        let grid = PlaneGrid::from_ranges(about(x), about(y), 0.0, 0.01).unwrap();
        let options = PlanOptions::default()
            .with_spreading(Spreading::None)
            .with_check_pixels(1);
        let image = image(self.pulses(position_m), grid, &options, Control::default()).unwrap();
        let power = image.iter().map(|v| f64::from(v.norm_sqr())).enumerate();
        let (k, power) = power.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
        let [x, y, _] = grid.point_m(k);
        (power, [x, y])
    }

    /// Targets without another within 0.5 m, whose peaks cannot be taken for one another.
    pub fn lone_targets(&self) -> impl Iterator<Item = &Target> {
        let off = |a: &Target, b: &Target| {
            (a.position_m[0] - b.position_m[0]).hypot(a.position_m[1] - b.position_m[1])
        };
        self.targets
            .iter()
            .filter(move |t| self.targets.iter().filter(|o| off(o, t) < 0.5).count() == 1)
    }

    /// Distance along the track of a target's peaks with true and with other positions, m.
    pub fn shift_along_m(&self, position_m: &[[f64; 3]], target: &Target) -> f64 {
        let [(_, [_, right_m]), (_, [_, found_m])] =
            [&self.true_m[..], position_m].map(|p| self.peak(p, target));
        (found_m - right_m).abs()
    }

    /// Mean loss of the targets' peaks against the true positions, dB.
    pub fn loss_db(&self, position_m: &[[f64; 3]]) -> f64 {
        let of =
            |t: &Target| 10.0 * (self.peak(&self.true_m, t).0 / self.peak(position_m, t).0).log10();
        self.targets.iter().map(of).sum::<f64>() / self.targets.len() as f64
    }

    /// Rms range error over targets and pulses after removing each target's mean and trend, m.
    pub fn slant_error_m(&self, position_m: &[[f64; 3]]) -> f64 {
        let mut sum = 0.0;
        for t in &self.targets {
            let mut error: Vec<f64> = (0..PULSES)
                .map(|m| {
                    reference::range_m(position_m[m], t.position_m)
                        - reference::range_m(self.true_m[m], t.position_m)
                })
                .collect();
            without_trend(&mut error);
            sum += error.iter().map(|v| v * v).sum::<f64>();
        }
        (sum / (PULSES * self.targets.len()) as f64).sqrt()
    }
}
