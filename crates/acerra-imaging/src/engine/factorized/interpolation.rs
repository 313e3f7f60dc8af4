//! Least-squares interpolation of band-limited samples.

use crate::kernel::merge::TAPS;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Coarse samples before the interval that a value lies in.
pub(crate) const BEFORE: usize = TAPS / 2 - 1;

/// Weights of [`TAPS`] samples at 0, 1, … for a value at `x`, least squares over all signals whose
/// frequencies lie within ±`nu` cycles a sample, and the relative RMS error of the worst frequency.
pub(crate) fn interpolation_weights(x: f64, nu: f64) -> ([f64; TAPS], f64) {
    let nu = nu.clamp(1e-6, 0.5);
    let sinc = |t: f64| {
        let a = 2.0 * PI * nu * t;
        if a.abs() < 1e-9 { 1.0 } else { a.sin() / a }
    };
    // Normal equations; a small diagonal term regularises them where samples are plentiful.
    let mut a = [[0.0; TAPS + 1]; TAPS];
    for (i, row) in a.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().take(TAPS).enumerate() {
            *v = sinc(i as f64 - j as f64);
        }
        row[i] += 1e-11;
        row[TAPS] = sinc(x - i as f64);
    }
    for k in 0..TAPS {
        let pivot = a[k];
        for row in a.iter_mut().skip(k + 1) {
            let factor = row[k] / pivot[k];
            for (v, p) in row.iter_mut().zip(pivot).skip(k) {
                *v -= factor * p;
            }
        }
    }
    let mut w = [0.0; TAPS];
    for i in (0..TAPS).rev() {
        let known: f64 = (i + 1..TAPS).map(|j| a[i][j] * w[j]).sum();
        w[i] = (a[i][TAPS] - known) / a[i][i];
    }
    let worst = (0..=16)
        .map(|k| {
            let omega = 2.0 * PI * nu * f64::from(k) / 16.0;
            let step = Complex64::cis(omega);
            let mut phasor = Complex64::cis(-omega * x);
            let mut sum = Complex64::ZERO;
            for w in w {
                sum += phasor * w;
                phasor *= step;
            }
            (sum - 1.0).norm_sqr()
        })
        .sum::<f64>()
        / 17.0;
    (w, worst.sqrt())
}

/// Phases of an interval by which the mean over all of them is judged: the error's square rises and falls
/// once over the interval, so that more change nothing.
const MOST_PHASES: usize = 16;

/// RMS error over all phases of an interval of `d` pixels at `nu` cycles a sample.
pub(crate) fn worst_error(nu: f64, d: usize) -> f64 {
    if nu >= 0.48 {
        return f64::INFINITY;
    }
    let phases = d.min(MOST_PHASES);
    // The interval stands in the middle of the samples: phases at either side of its centre err alike.
    let sum: f64 = (0..=phases / 2)
        .map(|p| {
            let x = BEFORE as f64 + p as f64 / phases as f64;
            let alike = if p == 0 || 2 * p == phases { 1.0 } else { 2.0 };
            alike * interpolation_weights(x, nu).1.powi(2)
        })
        .sum();
    (sum / phases as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_reproduce_what_the_band_holds() {
        for (nu, bound) in [(0.1, 1e-5), (0.25, 4e-4), (0.35, 1e-2)] {
            for phase in 0..5 {
                let x = BEFORE as f64 + f64::from(phase) / 5.0;
                let (w, error) = interpolation_weights(x, nu);
                assert!(error < bound, "{nu} {error:e}");
                for k in -10..=10 {
                    let omega = 2.0 * PI * nu * f64::from(k) / 10.0;
                    let sum: Complex64 = (0..TAPS)
                        .map(|i| Complex64::cis(omega * (i as f64 - x)) * w[i])
                        .sum();
                    assert!((sum - 1.0).norm() < 6.0 * bound);
                }
            }
        }
        assert!(worst_error(0.49, 3).is_infinite());
    }

    #[test]
    fn few_phases_tell_the_mean_error_of_all() {
        for nu in [0.05, 0.15, 0.3, 0.42] {
            for d in [1, 2, 3, 7, 16, 17, 33, 64] {
                let all: f64 = (0..d)
                    .map(|p| {
                        interpolation_weights(BEFORE as f64 + p as f64 / d as f64, nu)
                            .1
                            .powi(2)
                    })
                    .sum();
                let expected = (all / d as f64).sqrt();
                let found = worst_error(nu, d);
                assert!(
                    (found - expected).abs() <= 0.01 * expected + 1e-12,
                    "{nu} {d}: {found:e} for {expected:e}"
                );
            }
        }
    }
}
