//! Histories of the points' echoes along the flight, and coherent amplitudes of these echoes.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::echoes::{Separated, misfit, separate};
use crate::parts::Parts;
use crate::profiles::Profiles;
use crate::template::Template;

/// Amplitudes are means over this share of the flight, since points scatter more strongly towards some
/// directions than towards others.
const SMOOTHED_SHARE: f64 = 1.0 / 12.0;
/// Least number of pulses of a mean amplitude.
const LEAST_SMOOTHED: usize = 9;

/// Echoes of all points in all pulses.
pub(crate) struct Histories {
    /// Separated echoes, pulse by pulse.
    pub pulses: Vec<Separated>,
    /// Variance of the noise per frequency, the median over the pulses.
    pub noise: f64,
    /// Unit phasor that the flight applies to the echoes of each pulse.
    turn: Vec<Complex64>,
    parts: Parts,
}

impl Histories {
    /// Separates the echoes of points at `range_m`, `[M][K]`; `turn`, `[M]`, are the phasors that the flight
    /// applies to the echoes.
    pub fn new(
        (profiles, template): (&Profiles, &Template),
        range_m: &[Vec<f64>],
        turn: Vec<Complex64>,
        parts: &Parts,
    ) -> Self {
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
        // Not below the resolution of tables in single precision.
        let noise = power[power.len() / 2].max(1e-9 * greatest / free);
        Self {
            pulses,
            noise,
            turn,
            parts: parts.clone(),
        }
    }

    /// Energy that free amplitudes of every pulse explain.
    pub fn captured(&self) -> f64 {
        self.pulses.iter().map(|p| p.captured).sum()
    }

    /// The amplitudes of points that keep their phase along each part of the flight.
    pub fn coherent(&self) -> CoherentAmplitudes {
        let points = self.pulses.first().map_or(0, |p| p.echoes.len());
        let histories: Vec<Vec<Complex64>> = (0..points).map(|k| self.coherent_of(k)).collect();
        let amplitude = (0..self.pulses.len())
            .map(|m| histories.iter().map(|own| own[m]).collect())
            .collect();
        CoherentAmplitudes { amplitude }
    }

    /// Coherent amplitude of each point, and its coherence: the share of its echoes' amplitude that
    /// has one phase along each part of the flight.
    pub fn coherence(&self) -> Vec<[f64; 2]> {
        let points = self.pulses.first().map_or(0, |p| p.echoes.len());
        (0..points)
            .map(|k| {
                let coherent = self.coherent_of(k);
                let (mut sum, mut own, mut power) = (0.0, 0.0, 0.0);
                for (pulse, coherent) in self.pulses.iter().zip(&coherent) {
                    let amplitude = pulse.echoes[k].amplitude;
                    sum += (amplitude * coherent.conj()).re;
                    own += coherent.norm_sqr();
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

    /// A point's amplitudes with one phase along each part.
    fn coherent_of(&self, k: usize) -> Vec<Complex64> {
        let modulus = self.modulus_of(k);
        let phase: Vec<Complex64> = self.sums_of(k, &modulus).into_iter().map(unit).collect();
        let of = |(m, rho): (usize, &f64)| phase[self.parts.of(m)] * self.turn[m] * *rho;
        modulus.iter().enumerate().map(of).collect()
    }

    /// Sum of a point's amplitudes over each part, weighted by their moduli, with the flight's phasors
    /// removed.
    fn sums_of(&self, k: usize, modulus: &[f64]) -> Vec<Complex64> {
        let mut sums = vec![Complex64::ZERO; self.parts.len()];
        for (m, (pulse, rho)) in self.pulses.iter().zip(modulus).enumerate() {
            sums[self.parts.of(m)] += pulse.echoes[k].amplitude * self.turn[m].conj() * *rho;
        }
        sums
    }

    /// Moduli of a point's echoes, means over neighbouring pulses of a part.
    fn modulus_of(&self, k: usize) -> Vec<f64> {
        let count = self.pulses.len();
        let half = ((SMOOTHED_SHARE * count as f64) as usize).max(LEAST_SMOOTHED) / 2;
        let mut before = Vec::with_capacity(count + 1);
        before.push(0.0);
        for pulse in &self.pulses {
            let echo = &pulse.echoes[k];
            let power = echo.amplitude.norm_sqr() - self.noise * echo.amplitude_variance;
            before.push(before[before.len() - 1] + power);
        }
        (0..count)
            .map(|m| {
                let part = self.parts.about(m);
                let from = m.saturating_sub(half).max(part.start);
                let to = (m + half + 1).min(part.end);
                ((before[to] - before[from]) / (to - from) as f64)
                    .max(0.0)
                    .sqrt()
            })
            .collect()
    }

    /// Phase of the echoes of the `own` pulses relative to the echoes of the `others`, rad, averaged over the
    /// points of `guides`; `None` where either set has no echo.
    pub fn turn_between(&self, own: &[bool], others: &[bool], guides: &[bool]) -> Option<f64> {
        let mut cross = Complex64::ZERO;
        for k in (0..guides.len()).filter(|k| guides[*k]) {
            let modulus = self.modulus_of(k);
            let sum_of = |which: &[bool]| -> Complex64 {
                let pulses = (0..which.len()).filter(|m| which[*m]);
                let of = |m: usize| self.pulses[m].echoes[k].amplitude * self.turn[m].conj();
                pulses.map(|m| of(m) * modulus[m]).sum()
            };
            cross += sum_of(own) * sum_of(others).conj();
        }
        (cross != Complex64::ZERO).then(|| cross.arg())
    }
}

/// The phase factor of a sum.
fn unit(sum: Complex64) -> Complex64 {
    if sum == Complex64::ZERO {
        Complex64::ONE
    } else {
        sum / sum.norm()
    }
}

/// Amplitudes of points that keep their phase along each part of the flight.
pub(crate) struct CoherentAmplitudes {
    /// `[M][K]`.
    pub amplitude: Vec<Vec<Complex64>>,
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
                    .map(|(k, r)| (*r, self.amplitude[m][k]))
                    .collect();
                misfit(profiles, template, m, &model)
            })
            .collect();
        of_pulse.iter().sum()
    }
}
