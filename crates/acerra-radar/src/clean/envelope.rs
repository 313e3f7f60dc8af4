//! Envelopes of traces, by the analytic signal.

use std::sync::Arc;

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::{Fft, FftPlanner};

use crate::radargram::Radargram;

/// Envelope of every trace, row-major `[traces, samples_per_trace]`.
///
/// For real samples: the modulus of the analytic signal (negative frequencies removed), with the record
/// padded so that its ends do not wrap into each other; for complex samples: the modulus.
#[must_use]
pub fn envelope(radargram: &Radargram) -> Vec<f64> {
    envelope_in_band(radargram, None)
}

/// The envelope of the signal within a band `[from, to]`, Hz, with raised-cosine edges of a fifth of its
/// width outside the band. Complex samples are not filtered.
pub(super) fn envelope_in_band(radargram: &Radargram, band_hz: Option<[f64; 2]>) -> Vec<f64> {
    if radargram.samples.is_complex() {
        return (0..radargram.samples.len())
            .map(|i| modulus(radargram.samples.at(i)))
            .collect();
    }
    let gain = |frequency_hz| band_hz.map_or(1.0, |band| in_band(frequency_hz, band));
    let mut out = vec![0.0; radargram.samples.len()];
    for_analytic_rows(radargram, gain, &mut out, |work, row| {
        for (e, z) in row.iter_mut().zip(work) {
            *e = modulus(*z);
        }
    });
    out
}

/// Envelopes of every trace as [`envelope`] gives them: of the traces less their mean, and of the traces.
#[must_use]
pub(crate) fn envelopes_about_mean(radargram: &Radargram) -> Vec<[f64; 2]> {
    let n = radargram.samples_per_trace;
    let mean = mean_trace(radargram);
    let mut out = vec![[0.0; 2]; radargram.samples.len()];
    let both = |z: &Complex64, mean: &Complex64| [modulus(z - mean), modulus(*z)];
    let take = |mean: &[Complex64], work: &[Complex64], row: &mut [[f64; 2]]| {
        for (e, (z, mean)) in row.iter_mut().zip(work.iter().zip(mean)) {
            *e = both(z, mean);
        }
    };
    if radargram.samples.is_complex() {
        out.par_chunks_exact_mut(n)
            .enumerate()
            .for_each(|(trace, row)| take(&mean, &radargram.trace(trace), row));
        return out;
    }
    // The analytic signal of a difference is the difference of the analytic signals.
    let transform = Analytic::new(n, radargram.fast_time_step_s, |_| 1.0);
    let mean = transform.of(mean);
    out.par_chunks_exact_mut(n)
        .enumerate()
        .for_each(|(trace, row)| take(&mean, &transform.of(radargram.trace(trace)), row));
    out
}

/// Modulus of a sample; samples are far from the ends of the numbers' range.
fn modulus(z: Complex64) -> f64 {
    z.norm_sqr().sqrt()
}

/// The mean of all traces.
pub(crate) fn mean_trace(radargram: &Radargram) -> Vec<Complex64> {
    let (traces, n) = (radargram.traces, radargram.samples_per_trace);
    let add = |mut sums: Vec<Complex64>, trace: usize| {
        for (j, sum) in sums.iter_mut().enumerate() {
            *sum += radargram.samples.at(trace * n + j);
        }
        sums
    };
    let mut mean = (0..traces)
        .into_par_iter()
        .fold(|| vec![Complex64::default(); n], add)
        .reduce_with(|mut a, b| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            a
        })
        .unwrap_or_default();
    mean.iter_mut().for_each(|sum| *sum /= traces as f64);
    mean
}

/// Calls `take` with the analytic signal of every trace of real samples (negative frequencies removed, every
/// frequency in Hz multiplied by its `gain`), and the trace's part of `out` `[traces, samples_per_trace]`.
///
/// The record is padded, so that its ends do not wrap into each other; the signal includes the padding.
pub fn for_analytic_rows<T: Send>(
    radargram: &Radargram,
    gain: impl Fn(f64) -> f64,
    out: &mut [T],
    take: impl Fn(&[Complex64], &mut [T]) + Sync,
) {
    let n = radargram.samples_per_trace;
    let transform = Analytic::new(n, radargram.fast_time_step_s, gain);
    out.par_chunks_exact_mut(n)
        .enumerate()
        .for_each(|(trace, row)| take(&transform.of(radargram.trace(trace)), row));
}

/// The transform of real traces of one length to their analytic signals.
struct Analytic {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Gain of every frequency of the transform, 0 for negative ones.
    weight: Vec<f64>,
}

impl Analytic {
    /// For traces of `samples` samples `step_s` apart, with a gain at each frequency (Hz).
    fn new(samples: usize, step_s: f64, gain: impl Fn(f64) -> f64) -> Self {
        let size = (samples + samples / 4).next_power_of_two();
        let mut planner = FftPlanner::new();
        let bin_hz = 1.0 / (size as f64 * step_s);
        let sides = |k: usize| match k {
            _ if k == 0 || k == size / 2 => 1.0,
            _ if k < size / 2 => 2.0,
            _ => 0.0,
        };
        Self {
            forward: planner.plan_fft_forward(size),
            inverse: planner.plan_fft_inverse(size),
            weight: (0..size)
                .map(|k| sides(k) / size as f64 * gain(k as f64 * bin_hz))
                .collect(),
        }
    }

    /// The analytic signal of a trace, with its padding.
    fn of(&self, mut trace: Vec<Complex64>) -> Vec<Complex64> {
        trace.resize(self.weight.len(), Complex64::default());
        self.forward.process(&mut trace);
        trace
            .iter_mut()
            .zip(&self.weight)
            .for_each(|(z, w)| *z *= w);
        self.inverse.process(&mut trace);
        trace
    }
}

/// Weight of a frequency by a band: 1 within it, 0 further than a fifth of its width outside.
pub(super) fn in_band(frequency_hz: f64, [from, to]: [f64; 2]) -> f64 {
    let edge = 0.2 * (to - from);
    let outside = (from - frequency_hz).max(frequency_hz - to);
    match outside / edge {
        x if x <= 0.0 => 1.0,
        x if x >= 1.0 => 0.0,
        x => 0.5 * (1.0 + (std::f64::consts::PI * x).cos()),
    }
}
