//! Envelopes of traces, by the analytic signal.

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

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
            .map(|i| radargram.samples.at(i).norm())
            .collect();
    }
    let gain = |frequency_hz| band_hz.map_or(1.0, |band| in_band(frequency_hz, band));
    let mut out = vec![0.0; radargram.samples.len()];
    for_analytic_rows(radargram, gain, &mut out, |work, row| {
        for (e, z) in row.iter_mut().zip(work) {
            *e = z.norm();
        }
    });
    out
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
    let size = (n + n / 4).next_power_of_two();
    let mut planner = FftPlanner::new();
    let forward = planner.plan_fft_forward(size);
    let inverse = planner.plan_fft_inverse(size);
    let bin_hz = 1.0 / (size as f64 * radargram.fast_time_step_s);
    let weight: Vec<f64> = (0..size)
        .map(|k| match k {
            _ if k == 0 || k == size / 2 => 1.0,
            _ if k < size / 2 => 2.0,
            _ => 0.0,
        })
        .enumerate()
        .map(|(k, sides)| sides / size as f64 * gain(k as f64 * bin_hz))
        .collect();
    out.par_chunks_exact_mut(n)
        .enumerate()
        .for_each(|(trace, row)| {
            let mut work = radargram.trace(trace);
            work.resize(size, Complex64::default());
            forward.process(&mut work);
            work.iter_mut().zip(&weight).for_each(|(z, w)| *z *= w);
            inverse.process(&mut work);
            take(&work, row);
        });
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
