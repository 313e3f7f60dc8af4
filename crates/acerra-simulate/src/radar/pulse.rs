//! The pulse on the air and the record that its echoes make.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

use super::model::RadarModel;
use super::scatter::Echo;

/// Turns echoes into the samples of one record, exactly band-limited.
pub struct PulseShaper {
    /// First frequency bin of the band and the amplitude of each, adding up to 1.
    first_bin: usize,
    amplitude: Vec<f64>,
    /// Bins are the multiples of this (Hz).
    bin_hz: f64,
    samples: usize,
    start_s: f64,
    inverse: Arc<dyn Fft<f64>>,
    /// Scratch, so that traces allocate nothing: phasors, their turns, the record.
    phasor: Vec<[f64; 4]>,
    record: Vec<Complex64>,
    fft_scratch: Vec<Complex64>,
}

impl std::fmt::Debug for PulseShaper {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PulseShaper")
            .field("bin_hz", &self.bin_hz)
            .field("bins", &self.amplitude.len())
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl PulseShaper {
    /// A shaper for the window and band of `radar`, samples `step_s` apart.
    #[must_use]
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "bin numbers are small and positive"
    )]
    pub fn new(radar: &RadarModel, step_s: f64) -> Self {
        // Twice the window, so that echoes from behind it do not come round to its start.
        let length = 2 * radar.samples;
        let bin_hz = 1.0 / (length as f64 * step_s);
        let [low_hz, high_hz] = radar.band_ghz.map(|f| f * 1e9);
        let first_bin = (low_hz / bin_hz).ceil() as usize;
        let last_bin = ((high_hz / bin_hz).floor() as usize).max(first_bin);
        let edge_hz = 0.5 * radar.band_taper * (high_hz - low_hz);
        let mut amplitude: Vec<f64> = (first_bin..=last_bin)
            .map(|k| {
                let f = k as f64 * bin_hz;
                let inside = (f - low_hz).min(high_hz - f).max(0.0);
                if inside >= edge_hz {
                    1.0
                } else {
                    0.5 - 0.5 * (TAU * 0.5 * inside / edge_hz).cos()
                }
            })
            .collect();
        let sum: f64 = amplitude.iter().sum();
        if sum > 0.0 {
            amplitude.iter_mut().for_each(|a| *a /= sum);
        }
        let inverse = FftPlanner::new().plan_fft_inverse(length);
        let fft_scratch = vec![Complex64::default(); inverse.get_inplace_scratch_len()];
        Self {
            first_bin,
            amplitude,
            bin_hz,
            samples: radar.samples,
            start_s: radar.window_start_ns * 1e-9,
            inverse,
            phasor: Vec::new(),
            record: vec![Complex64::default(); length],
            fft_scratch,
        }
    }

    /// The record of `echoes`, each late by `delay_s`: an echo of strength 1 has an envelope that
    /// peaks at 1. `record` is overwritten.
    pub fn shape(&mut self, echoes: &[Echo], delay_s: f64, record: &mut Vec<f64>) {
        let window_s = 0.5 / self.bin_hz;
        self.phasor.clear();
        for echo in echoes {
            let late_s = echo.delay_s + delay_s - self.start_s;
            if late_s <= -window_s || late_s >= 2.0 * window_s {
                continue;
            }
            #[expect(clippy::cast_precision_loss, reason = "bin numbers are small")]
            let (s0, c0) =
                (echo.phase_rad - TAU * self.first_bin as f64 * self.bin_hz * late_s).sin_cos();
            let (s1, c1) = (-TAU * self.bin_hz * late_s).sin_cos();
            self.phasor
                .push([echo.strength * c0, echo.strength * s0, c1, s1]);
        }
        self.record.fill(Complex64::default());
        for (bin, amplitude) in (self.first_bin..).zip(&self.amplitude) {
            let (mut re, mut im) = (0.0, 0.0);
            for [pr, pi, tr, ti] in &mut self.phasor {
                re += *pr;
                im += *pi;
                (*pr, *pi) = (*pr * *tr - *pi * *ti, *pr * *ti + *pi * *tr);
            }
            self.record[bin] = Complex64::new(amplitude * re, amplitude * im);
        }
        self.inverse
            .process_with_scratch(&mut self.record, &mut self.fft_scratch);
        record.clear();
        record.extend(self.record[..self.samples].iter().map(|v| v.re));
    }
}
