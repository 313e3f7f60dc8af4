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
    let n = radargram.samples_per_trace;
    if radargram.samples.is_complex() {
        return (0..radargram.samples.len())
            .map(|i| radargram.samples.at(i).norm())
            .collect();
    }
    let size = (n + n / 4).next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(size),
        planner.plan_fft_inverse(size),
    );
    let weight: Vec<f64> = (0..size)
        .map(|k| match k {
            0 => 1.0,
            _ if k == size / 2 => 1.0,
            _ if k < size / 2 => 2.0,
            _ => 0.0,
        })
        .enumerate()
        .map(|(k, w)| {
            let frequency_hz = k as f64 / (size as f64 * radargram.fast_time_step_s);
            w * band_hz.map_or(1.0, |band| in_band(frequency_hz, band))
        })
        .collect();
    let mut out = vec![0.0; radargram.samples.len()];
    out.par_chunks_exact_mut(n)
        .enumerate()
        .for_each(|(trace, row)| {
            let mut work = radargram.trace(trace);
            work.resize(size, Complex64::default());
            forward.process(&mut work);
            work.iter_mut().zip(&weight).for_each(|(z, w)| *z *= w);
            inverse.process(&mut work);
            for (e, z) in row.iter_mut().zip(&work) {
                *e = z.norm() / size as f64;
            }
        });
    out
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
