//! Least-squares interpolation of band-limited samples.

use crate::kernel::merge::TAPS;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Coarse samples before the interval that a value lies in.
pub(crate) const BEFORE: usize = TAPS / 2 - 1;

/// Least-squares interpolation over all signals whose frequencies lie within ±`nu` cycles a sample.
pub(crate) struct Interpolator {
    /// Angular frequency of the band's edge, rad a sample.
    edge_rad: f64,
    /// Normal equations after elimination: factors of the rows below the diagonal, the rest above.
    factored: [[f64; TAPS]; TAPS],
}

impl Interpolator {
    /// For `nu` cycles a sample.
    pub fn new(nu: f64) -> Self {
        let edge_rad = 2.0 * PI * nu.clamp(1e-6, 0.5);
        // The matrix is that of a convolution; a small diagonal term regularises it where samples are
        // plentiful.
        let sincs: [f64; TAPS] = std::array::from_fn(|k| sinc(edge_rad * k as f64));
        let mut a: [[f64; TAPS]; TAPS] =
            std::array::from_fn(|i| std::array::from_fn(|j| sincs[i.abs_diff(j)]));
        for (i, row) in a.iter_mut().enumerate() {
            row[i] += 1e-11;
        }
        for k in 0..TAPS {
            let pivot = a[k];
            for row in a.iter_mut().skip(k + 1) {
                let factor = row[k] / pivot[k];
                row[k] = factor;
                for (v, p) in row.iter_mut().zip(pivot).skip(k + 1) {
                    *v -= factor * p;
                }
            }
        }
        Self {
            edge_rad,
            factored: a,
        }
    }

    /// Weights of [`TAPS`] samples at 0, 1, … for a value at `x`.
    pub fn weights(&self, x: f64) -> [f64; TAPS] {
        let a = &self.factored;
        let mut w: [f64; TAPS] = std::array::from_fn(|i| sinc(self.edge_rad * (x - i as f64)));
        for k in 0..TAPS {
            for i in k + 1..TAPS {
                w[i] -= a[i][k] * w[k];
            }
        }
        for i in (0..TAPS).rev() {
            let known: f64 = (i + 1..TAPS).map(|j| a[i][j] * w[j]).sum();
            w[i] = (w[i] - known) / a[i][i];
        }
        w
    }

    /// Mean square of the relative error of `weights` for a value at `x` over the band's frequencies.
    fn mean_square_error(&self, x: f64, weights: &[f64; TAPS]) -> f64 {
        let squares = (0..=FREQUENCIES).map(|k| {
            let omega = self.edge_rad * f64::from(k) / f64::from(FREQUENCIES);
            let step = Complex64::cis(omega);
            let mut phasor = Complex64::cis(-omega * x);
            let mut sum = Complex64::ZERO;
            for w in weights {
                sum += phasor * w;
                phasor *= step;
            }
            (sum - 1.0).norm_sqr()
        });
        squares.sum::<f64>() / f64::from(FREQUENCIES + 1)
    }
}

/// Frequencies beside 0 over which errors are averaged.
const FREQUENCIES: u32 = 16;

/// sin a/a.
fn sinc(a: f64) -> f64 {
    if a.abs() < 1e-9 { 1.0 } else { a.sin() / a }
}

/// Phases of an interval by which the mean over all of them is judged: the error's square rises and falls
/// once over the interval, so that more change nothing.
const MOST_PHASES: usize = 16;

/// RMS error over all phases of an interval of `d` pixels at `nu` cycles a sample.
pub(crate) fn worst_error(nu: f64, d: usize) -> f64 {
    if nu >= 0.48 {
        return f64::INFINITY;
    }
    let interpolator = Interpolator::new(nu);
    let phases = d.min(MOST_PHASES);
    // The interval stands in the middle of the samples: phases at either side of its centre err alike.
    let sum: f64 = (0..=phases / 2)
        .map(|p| {
            let x = BEFORE as f64 + p as f64 / phases as f64;
            let alike = if p == 0 || 2 * p == phases { 1.0 } else { 2.0 };
            alike * interpolator.mean_square_error(x, &interpolator.weights(x))
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
                let interpolator = Interpolator::new(nu);
                let w = interpolator.weights(x);
                let error = interpolator.mean_square_error(x, &w).sqrt();
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
                let interpolator = Interpolator::new(nu);
                let all: f64 = (0..d)
                    .map(|p| {
                        let x = BEFORE as f64 + p as f64 / d as f64;
                        interpolator.mean_square_error(x, &interpolator.weights(x))
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
