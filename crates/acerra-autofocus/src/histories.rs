//! Histories of the points' echoes along the flight, and the amplitudes that a model gives them.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::echoes::{Separated, misfit, separate};
use crate::profiles::Profiles;
use crate::template::Template;

/// Amplitudes are means over this share of the flight: points show themselves from some sides more
/// than from others.
const SMOOTHED_SHARE: f64 = 1.0 / 12.0;
/// Least number of pulses of such a mean.
const LEAST_SMOOTHED: usize = 9;

/// Echoes of all points in all pulses.
pub(crate) struct Histories {
    /// Pulse by pulse.
    pub pulses: Vec<Separated>,
    /// Variance of the noise per frequency: the pulses' median.
    pub noise: f64,
}

impl Histories {
    /// Separates the echoes of points at `range_m`, `[M][K]`.
    pub fn new(profiles: &Profiles, template: &Template, range_m: &[Vec<f64>]) -> Self {
        let pulses: Vec<Separated> = range_m
            .par_iter()
            .enumerate()
            .map(|(m, ranges)| separate(profiles, template, m, ranges))
            .collect();
        let points = range_m.first().map_or(0, Vec::len);
        let free = template.wavenumber.len().saturating_sub(points).max(1) as f64;
        let mut power: Vec<f64> = pulses
            .iter()
            .zip(&profiles.energy)
            .map(|(p, e)| (e - p.captured).max(0.0) / free)
            .collect();
        power.sort_by(f64::total_cmp);
        let greatest = profiles.energy.iter().copied().fold(0.0, f64::max);
        // Not below what tables in single precision resolve.
        let noise = power[power.len() / 2].max(1e-9 * greatest / free);
        Self { pulses, noise }
    }

    /// Energy that free amplitudes of every pulse explain.
    pub fn captured(&self) -> f64 {
        self.pulses.iter().map(|p| p.captured).sum()
    }

    /// The amplitudes of points that keep their phase along the flight.
    pub fn coherent(&self) -> CoherentAmplitudes {
        let points = self.pulses.first().map_or(0, |p| p.echoes.len());
        let histories: Vec<(Vec<f64>, Complex64)> =
            (0..points).map(|k| self.coherent_of(k)).collect();
        let modulus = (0..self.pulses.len())
            .map(|m| histories.iter().map(|(rho, _)| rho[m]).collect())
            .collect();
        CoherentAmplitudes {
            modulus,
            phase: histories.iter().map(|(_, phase)| *phase).collect(),
        }
    }

    /// Coherent amplitude of each point, and its coherence: the share of its echoes' amplitude that
    /// has one phase along the flight.
    pub fn coherence(&self) -> Vec<[f64; 2]> {
        let points = self.pulses.first().map_or(0, |p| p.echoes.len());
        (0..points)
            .map(|k| {
                let (modulus, phase) = self.coherent_of(k);
                let (mut sum, mut own, mut power) = (0.0, 0.0, 0.0);
                for (pulse, rho) in self.pulses.iter().zip(&modulus) {
                    let amplitude = pulse.echoes[k].amplitude;
                    sum += rho * (amplitude * phase.conj()).re;
                    own += rho * rho;
                    power += amplitude.norm_sqr();
                }
                let scale = (own * power).sqrt();
                [
                    sum / own.sqrt().max(f64::MIN_POSITIVE),
                    if scale > 0.0 { sum / scale } else { 0.0 },
                ]
            })
            .collect()
    }

    fn coherent_of(&self, k: usize) -> (Vec<f64>, Complex64) {
        let count = self.pulses.len();
        let half = ((SMOOTHED_SHARE * count as f64) as usize).max(LEAST_SMOOTHED) / 2;
        let mut before = Vec::with_capacity(count + 1);
        before.push(0.0);
        for pulse in &self.pulses {
            let echo = &pulse.echoes[k];
            let power = echo.amplitude.norm_sqr() - self.noise * echo.amplitude_variance;
            before.push(before[before.len() - 1] + power);
        }
        let modulus: Vec<f64> = (0..count)
            .map(|m| {
                let (from, to) = (m.saturating_sub(half), (m + half + 1).min(count));
                ((before[to] - before[from]) / (to - from) as f64)
                    .max(0.0)
                    .sqrt()
            })
            .collect();
        let sum: Complex64 = self
            .pulses
            .iter()
            .zip(&modulus)
            .map(|(p, rho)| p.echoes[k].amplitude * *rho)
            .sum();
        let phase = if sum == Complex64::ZERO {
            Complex64::ONE
        } else {
            sum / sum.norm()
        };
        (modulus, phase)
    }
}

/// Amplitudes of points that keep their phase along the flight.
pub(crate) struct CoherentAmplitudes {
    /// Modulus, `[M][K]`.
    pub modulus: Vec<Vec<f64>>,
    /// Phase factor of each point.
    pub phase: Vec<Complex64>,
}

impl CoherentAmplitudes {
    /// Σ|E − model|² − Σ|E|² over all pulses.
    pub fn misfit(&self, profiles: &Profiles, template: &Template, range_m: &[Vec<f64>]) -> f64 {
        let of_pulse: Vec<f64> = range_m
            .par_iter()
            .enumerate()
            .map(|(m, ranges)| {
                let model: Vec<(f64, Complex64)> = ranges
                    .iter()
                    .enumerate()
                    .map(|(k, r)| (*r, self.phase[k] * self.modulus[m][k]))
                    .collect();
                misfit(profiles, template, m, &model)
            })
            .collect();
        of_pulse.iter().sum()
    }
}
