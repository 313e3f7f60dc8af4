//! From beat signals to spectra.
//!
//! A chirp transmits f(t) = f₀ + S t. Mixed with the transmitted signal, an echo of delay τ beats as
//! e^{j2π(f₀τ + Sτt − Sτ²/2)} for t from τ on. The term in τ² (the *residual video phase*) and the late
//! beginning both go when every beat frequency f is turned by e^{+jπf²/S}, which moves it f/S = τ earlier:
//! the result is e^{j2πf(t)τ}, and its conjugate the spectrum at f(t) in the convention of the neutral file.
//! Beats are real or complex; only positive frequencies of real ones are kept. Source: Carrara, Goodman and
//! Majewski, *Spotlight Synthetic Aperture Radar* (1995), section 10.

use num_complex::{Complex32, Complex64};
use rustfft::FftPlanner;

/// A chirp and its sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chirp {
    /// Frequency at the first sample, Hz.
    pub start_frequency_hz: f64,
    /// Slope, Hz/s; negative downwards.
    pub slope_hz_per_s: f64,
    /// Samples a second.
    pub sample_rate_hz: f64,
    /// Whether the echo's phase lags in the beat, as where the mixer conjugates the transmitted signal.
    pub is_conjugate: bool,
}

impl Chirp {
    /// Frequencies sent at the samples, Hz.
    #[must_use]
    pub fn frequency_hz(&self, samples: usize) -> Vec<f64> {
        let step_hz = self.slope_hz_per_s / self.sample_rate_hz;
        (0..samples)
            .map(|i| self.start_frequency_hz + step_hz * i as f64)
            .collect()
    }
}

/// Spectra of beats, both row-major `[traces, samples]`, at [`Chirp::frequency_hz`].
///
/// ```
/// use acerra_formats::fmcw::{Chirp, deramp};
/// use num_complex::Complex64;
/// let chirp = Chirp {
///     start_frequency_hz: 6e9,
///     slope_hz_per_s: 500e6 / 1e-3,
///     sample_rate_hz: 1e6,
///     is_conjugate: false,
/// };
/// let delay_s = 200e-9;
/// let beat: Vec<Complex64> = (0..1000)
///     .map(|i| {
///         let cycles = 6e9 * delay_s + 5e11 * delay_s * (i as f64 * 1e-6 - delay_s / 2.0);
///         Complex64::from_polar(1.0, std::f64::consts::TAU * cycles)
///     })
///     .collect();
/// let spectrum = deramp(&beat, 1000, &chirp);
/// let f = chirp.frequency_hz(1000)[500];
/// let expected = Complex64::from_polar(1.0, -std::f64::consts::TAU * f * delay_s);
/// let found = Complex64::new(f64::from(spectrum[500].re), f64::from(spectrum[500].im));
/// assert!((found - expected).norm() < 2e-2);
/// ```
#[must_use]
pub fn deramp(beat: &[Complex64], samples: usize, chirp: &Chirp) -> Vec<Complex32> {
    if samples == 0 {
        return Vec::new();
    }
    // Twice the length, so that moved beats do not wrap round.
    let n = (2 * samples).next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let is_real = beat.iter().all(|z| z.im == 0.0);
    let turns: Vec<Complex64> = (0..n)
        .map(|k| {
            let bin = if k <= n / 2 {
                k as f64
            } else {
                k as f64 - n as f64
            };
            let f = bin * chirp.sample_rate_hz / n as f64;
            // Beats of echoes have the slope's sign.
            let is_echo = f * chirp.slope_hz_per_s >= 0.0;
            let gain = match (is_real, is_echo) {
                (true, false) => 0.0,
                (true, true) if f != 0.0 => 2.0,
                _ => 1.0,
            };
            let phase = std::f64::consts::PI * f * f / chirp.slope_hz_per_s;
            Complex64::from_polar(gain / n as f64, phase)
        })
        .collect();
    let mut buffer = vec![Complex64::ZERO; n];
    let mut out = Vec::with_capacity(beat.len());
    for row in beat.chunks(samples) {
        buffer.fill(Complex64::ZERO);
        for (to, z) in buffer.iter_mut().zip(row) {
            *to = if chirp.is_conjugate { z.conj() } else { *z };
        }
        forward.process(&mut buffer);
        for (z, turn) in buffer.iter_mut().zip(&turns) {
            *z *= turn;
        }
        inverse.process(&mut buffer);
        out.extend(buffer[..row.len()].iter().map(|z| {
            // Beats lead by 2πfτ; spectra lag.
            Complex32::new(z.re as f32, -z.im as f32)
        }));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A chirp of 1 µs a MHz, on which the residual video phase of a far echo is many radians.
    fn chirp(slope_hz_per_s: f64) -> Chirp {
        Chirp {
            start_frequency_hz: 6e9,
            slope_hz_per_s,
            sample_rate_hz: 100e6,
            is_conjugate: false,
        }
    }

    fn beat(chirp: &Chirp, samples: usize, delay_s: f64) -> Vec<Complex64> {
        (0..samples)
            .map(|i| {
                let t = i as f64 / chirp.sample_rate_hz;
                let cycles = chirp.start_frequency_hz * delay_s
                    + chirp.slope_hz_per_s * delay_s * (t - delay_s / 2.0);
                if t < delay_s {
                    Complex64::ZERO
                } else {
                    Complex64::from_polar(1.0, TAU * cycles)
                }
            })
            .collect()
    }

    /// Largest error over the middle of the sweep.
    fn error(spectrum: &[Complex32], chirp: &Chirp, delay_s: f64) -> f64 {
        let n = spectrum.len();
        let hz = chirp.frequency_hz(n);
        (n / 5..4 * n / 5)
            .map(|i| {
                let expected = Complex64::from_polar(1.0, -TAU * hz[i] * delay_s);
                let found = Complex64::new(f64::from(spectrum[i].re), f64::from(spectrum[i].im));
                (found - expected).norm()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_residual_video_phase_is_gone() {
        for slope in [5e13, -5e13] {
            let chirp = chirp(slope);
            let delay_s = 430e-9;
            // π S τ² = 29 rad, far from a multiple of 2π.
            let beat = beat(&chirp, 1000, delay_s);
            let spectrum = deramp(&beat, 1000, &chirp);
            let found = error(&spectrum, &chirp, delay_s);
            assert!(found < 0.05, "slope {slope:e}: {found}");
            let untouched: Vec<Complex32> = beat
                .iter()
                .map(|z| Complex32::new(z.re as f32, -z.im as f32))
                .collect();
            assert!(error(&untouched, &chirp, delay_s) > 1.0);
        }
    }

    #[test]
    fn real_beats_and_conjugate_ones_are_the_same_spectra() {
        let upward = chirp(5e13);
        let delay_s = 400e-9;
        let complex = beat(&upward, 1000, delay_s);
        let real: Vec<Complex64> = complex.iter().map(|z| Complex64::new(z.re, 0.0)).collect();
        let found = error(&deramp(&real, 1000, &upward), &upward, delay_s);
        assert!(found < 0.08, "{found}");
        let turned: Vec<Complex64> = complex.iter().map(Complex64::conj).collect();
        let lagging = Chirp {
            is_conjugate: true,
            ..upward
        };
        let found = error(&deramp(&turned, 1000, &lagging), &upward, delay_s);
        assert!(found < 0.05, "{found}");
    }
}
