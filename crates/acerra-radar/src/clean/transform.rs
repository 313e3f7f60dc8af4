//! Spectra at exactly the given frequencies, for any record length.
//!
//! S(f) = Σₖ x(tₖ) e^{−j2πf tₖ} with tₖ the radargram's fast time, so that an echo at fast time t has phase
//! e^{−j2πft}, which is e^{−j4πfR/c} once fast time is zero-timed. No scale factor.

use std::f64::consts::TAU;

use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;

use super::CleanError;
use crate::radargram::Radargram;
use crate::spectrum::Spectrum;
use acerra_control::{Cancelled, Control};

/// Departure from even spacing, in steps, up to which frequencies count as evenly spaced. Over
/// 100 ns a departure of 1e−9 of a 5 MHz step is 3e−9 rad.
const EVEN: f64 = 1e-9;

/// Spectra at `frequency_hz`: by chirp-z transform (Bluestein) where the frequencies are evenly
/// spaced, else by the direct sum. Both agree to rounding.
///
/// # Errors
/// If a frequency is not positive, or not below half the sampling rate (the whole rate for complex
/// samples), or there is none.
///
/// ```
/// use acerra_radar::{Radargram, Samples, clean::spectrum_at};
/// let mut trace = vec![0.0; 64];
/// trace[10] = 1.0; // an echo at 20 ns + 10 × 61 ps
/// let radargram = Radargram::new(vec![0.0], 20e-9, 61e-12, Samples::Real(trace))?;
/// let spectrum = spectrum_at(&radargram, &[3.1e9, 4.8e9])?;
/// let phase = -std::f64::consts::TAU * 3.1e9 * (20e-9 + 610e-12);
/// assert!((spectrum.values[0] - num_complex::Complex64::from_polar(1.0, phase)).norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn spectrum_at(radargram: &Radargram, frequency_hz: &[f64]) -> Result<Spectrum, CleanError> {
    spectrum_at_with(radargram, frequency_hz, Control::default())
}

/// As [`spectrum_at`]; can be cancelled.
///
/// # Errors
/// As [`spectrum_at`], and [`CleanError::Cancelled`].
pub fn spectrum_at_with(
    radargram: &Radargram,
    frequency_hz: &[f64],
    control: Control<'_>,
) -> Result<Spectrum, CleanError> {
    check(radargram, frequency_hz)?;
    let values = match even_step(frequency_hz) {
        Some(step_hz) => chirp_z(radargram, frequency_hz, step_hz, control)?,
        None => direct(radargram, frequency_hz, control)?,
    };
    Ok(finish(radargram, frequency_hz, values))
}

/// As [`spectrum_at`], by the plain sum in double precision: the reference.
///
/// # Errors
/// As [`spectrum_at`].
pub fn spectrum_by_direct_sum(
    radargram: &Radargram,
    frequency_hz: &[f64],
) -> Result<Spectrum, CleanError> {
    check(radargram, frequency_hz)?;
    let values = direct(radargram, frequency_hz, Control::default())?;
    Ok(finish(radargram, frequency_hz, values))
}

fn check(radargram: &Radargram, frequency_hz: &[f64]) -> Result<(), CleanError> {
    let step_s = radargram.fast_time_step_s;
    let limit_hz = if radargram.samples.is_complex() {
        1.0
    } else {
        0.5
    } / step_s;
    let wrong = |f: &f64| !(*f > 0.0 && *f < limit_hz);
    match frequency_hz.iter().copied().find(wrong) {
        Some(frequency_hz) => Err(CleanError::Frequency {
            frequency_hz,
            step_s,
            limit_hz,
        }),
        None if frequency_hz.is_empty() => Err(CleanError::Frequency {
            frequency_hz: f64::NAN,
            step_s,
            limit_hz,
        }),
        None => Ok(()),
    }
}

fn even_step(frequency_hz: &[f64]) -> Option<f64> {
    let (&first, &last) = (frequency_hz.first()?, frequency_hz.last()?);
    if frequency_hz.len() < 8 {
        return None;
    }
    let step = (last - first) / (frequency_hz.len() - 1) as f64;
    frequency_hz
        .iter()
        .enumerate()
        .all(|(i, f)| (f - (first + i as f64 * step)).abs() <= EVEN * step.abs())
        .then_some(step)
}

fn finish(radargram: &Radargram, frequency_hz: &[f64], values: Vec<Complex64>) -> Spectrum {
    let time_s = radargram.time_s.clone();
    Spectrum {
        frequency_hz: frequency_hz.to_vec(),
        values,
        time_s,
    }
}

fn direct(
    radargram: &Radargram,
    frequency_hz: &[f64],
    control: Control<'_>,
) -> Result<Vec<Complex64>, Cancelled> {
    /// Samples whose phasors are held at once: 64 × 341 phasors fit the second-level cache.
    const BLOCK: usize = 64;
    let (n, m) = (radargram.samples_per_trace, frequency_hz.len());
    let mut values = vec![Complex64::default(); radargram.traces * m];
    for first in (0..n).step_by(BLOCK) {
        let block = first..(first + BLOCK).min(n);
        let phasors: Vec<Complex64> = block
            .clone()
            .flat_map(|k| {
                let t = radargram.fast_time_s(k);
                frequency_hz
                    .iter()
                    .map(move |f| Complex64::cis(-TAU * (f * t)))
            })
            .collect();
        values
            .par_chunks_exact_mut(m)
            .enumerate()
            .try_for_each(|(trace, row)| {
                control.check()?;
                for (k, phasors) in block.clone().zip(phasors.chunks_exact(m)) {
                    let x = radargram.at(trace, k);
                    if x != Complex64::default() {
                        row.iter_mut().zip(phasors).for_each(|(s, p)| *s += x * p);
                    }
                }
                Ok(())
            })?;
    }
    Ok(values)
}

/// Bluestein's identity nk = (n² + k² − (k−n)²)/2 turns the sum into a convolution.
fn chirp_z(
    radargram: &Radargram,
    frequency_hz: &[f64],
    step_hz: f64,
    control: Control<'_>,
) -> Result<Vec<Complex64>, Cancelled> {
    let (n, m) = (radargram.samples_per_trace, frequency_hz.len());
    let size = (n + m - 1).next_power_of_two();
    let mut planner = FftPlanner::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(size),
        planner.plan_fft_inverse(size),
    );
    let (t0, dt) = (radargram.fast_time_start_s, radargram.fast_time_step_s);
    let turn = step_hz * dt; // chirp rate, cycles per sample squared
    let chirp = |k: usize| {
        let k = k as f64;
        Complex64::cis(-TAU * (0.5 * turn * k * k).fract())
    };
    let f0 = frequency_hz[0];
    let before: Vec<Complex64> = (0..n)
        .map(|k| chirp(k) * Complex64::cis(-TAU * (f0 * (k as f64 * dt)).fract()))
        .collect();
    let after: Vec<Complex64> = (0..m)
        .map(|i| {
            let turns = (f0 + i as f64 * step_hz) * t0;
            chirp(i) * Complex64::cis(-TAU * turns.fract()) / size as f64
        })
        .collect();
    let mut kernel = vec![Complex64::default(); size];
    for (k, slot) in kernel.iter_mut().enumerate().take(m) {
        *slot = chirp(k).conj();
    }
    for k in 1..n {
        kernel[size - k] = chirp(k).conj();
    }
    forward.process(&mut kernel);
    let mut values = vec![Complex64::default(); radargram.traces * m];
    values
        .par_chunks_exact_mut(m)
        .enumerate()
        .try_for_each_init(
            || (vec![Complex64::default(); size], Vec::new()),
            |(work, scratch): &mut (_, Vec<Complex64>), (trace, row)| {
                control.check()?;
                let needed = forward
                    .get_inplace_scratch_len()
                    .max(inverse.get_inplace_scratch_len());
                scratch.resize(needed, Complex64::default());
                for (k, slot) in work.iter_mut().enumerate() {
                    *slot = match before.get(k) {
                        Some(b) => radargram.at(trace, k) * b,
                        None => Complex64::default(),
                    };
                }
                forward.process_with_scratch(work, scratch);
                work.iter_mut().zip(&kernel).for_each(|(w, k)| *w *= k);
                inverse.process_with_scratch(work, scratch);
                for ((s, w), a) in row.iter_mut().zip(work.iter()).zip(&after) {
                    *s = w * a;
                }
                Ok(())
            },
        )?;
    Ok(values)
}
