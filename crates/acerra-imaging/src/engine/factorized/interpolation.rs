//! Least-squares interpolation of band-limited samples.

use crate::kernel::merge::MOST_TAPS;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Number of the `taps` samples that precede the interval of the interpolated value.
pub(crate) fn before(taps: usize) -> usize {
    taps / 2 - 1
}

/// Least-squares interpolation over all signals whose frequencies lie within ±`nu` cycles a sample.
pub(crate) struct Interpolator {
    taps: usize,
    /// Angular frequency of the band's edge, rad a sample.
    edge_rad: f64,
    /// Normal equations after elimination: factors of the rows below the diagonal, the rest above.
    factored: [[f64; MOST_TAPS]; MOST_TAPS],
}

impl Interpolator {
    /// The interpolation from `taps` samples, at most [`MOST_TAPS`], for `nu` cycles a sample.
    pub fn new(taps: usize, nu: f64) -> Self {
        let edge_rad = 2.0 * PI * nu.clamp(1e-6, 0.5);
        // The matrix is a Toeplitz matrix; a small diagonal term regularises the system where samples are
        // plentiful.
        let sincs: [f64; MOST_TAPS] = std::array::from_fn(|k| sinc(edge_rad * k as f64));
        let mut a: [[f64; MOST_TAPS]; MOST_TAPS] =
            std::array::from_fn(|i| std::array::from_fn(|j| sincs[i.abs_diff(j)]));
        for (i, row) in a.iter_mut().enumerate() {
            row[i] += 1e-11;
        }
        for k in 0..taps {
            let pivot = a[k];
            for row in &mut a[k + 1..taps] {
                let factor = row[k] / pivot[k];
                row[k] = factor;
                for (v, p) in row[..taps].iter_mut().zip(pivot).skip(k + 1) {
                    *v -= factor * p;
                }
            }
        }
        Self {
            taps,
            edge_rad,
            factored: a,
        }
    }

    /// Weights of the samples at 0, 1, … for a value at `x`, zeros after the taps.
    pub fn weights(&self, x: f64) -> [f64; MOST_TAPS] {
        let (a, taps) = (&self.factored, self.taps);
        let mut w = [0.0; MOST_TAPS];
        for (i, w) in w.iter_mut().enumerate().take(taps) {
            *w = sinc(self.edge_rad * (x - i as f64));
        }
        for k in 0..taps {
            for i in k + 1..taps {
                w[i] -= a[i][k] * w[k];
            }
        }
        for i in (0..taps).rev() {
            let known: f64 = (i + 1..taps).map(|j| a[i][j] * w[j]).sum();
            w[i] = (w[i] - known) / a[i][i];
        }
        w
    }

    /// Mean square of the relative error of `weights` for a value at `x` over the band's frequencies.
    fn mean_square_error(&self, x: f64, weights: &[f64; MOST_TAPS]) -> f64 {
        let squares = (0..=FREQUENCIES).map(|k| {
            let omega = self.edge_rad * f64::from(k) / f64::from(FREQUENCIES);
            let step = Complex64::cis(omega);
            let mut phasor = Complex64::cis(-omega * x);
            let mut sum = Complex64::ZERO;
            for w in &weights[..self.taps] {
                sum += phasor * w;
                phasor *= step;
            }
            (sum - 1.0).norm_sqr()
        });
        squares.sum::<f64>() / f64::from(FREQUENCIES + 1)
    }
}

/// Frequencies around 0 over which errors are averaged.
const FREQUENCIES: u32 = 16;

/// sin a/a.
fn sinc(a: f64) -> f64 {
    if a.abs() < 1e-9 { 1.0 } else { a.sin() / a }
}

/// Number of phases within an interval that give the mean over all: the squared error has one maximum and one
/// minimum over the interval, so that more phases have no effect.
const MOST_PHASES: usize = 16;

/// Frequencies of samples that no interpolation reproduces, cycles a sample.
pub(crate) const TOO_FAST: f64 = 0.48;

/// RMS error over all phases of an interval of `d` pixels, of `taps` samples at `nu` cycles a sample.
pub(crate) fn worst_error(taps: usize, nu: f64, d: usize) -> f64 {
    if nu >= TOO_FAST {
        return f64::INFINITY;
    }
    let interpolator = Interpolator::new(taps, nu);
    let phases = d.min(MOST_PHASES);
    // The interval is in the middle of the samples: errors are equal at phases to either side of its centre.
    let sum: f64 = (0..=phases / 2)
        .map(|p| {
            let x = before(taps) as f64 + p as f64 / phases as f64;
            let alike = if p == 0 || 2 * p == phases { 1.0 } else { 2.0 };
            alike * interpolator.mean_square_error(x, &interpolator.weights(x))
        })
        .sum();
    (sum / phases as f64).sqrt()
}

/// The widest band, in cycles a sample, of signals that `taps` samples reproduce with an RMS error of at most
/// `error` over all phases.
pub(crate) fn widest_band(taps: usize, error: f64) -> f64 {
    const HALVINGS: usize = 9;
    const PHASES: usize = 8;
    let (mut narrow, mut wide) = (0.0, TOO_FAST);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (narrow + wide);
        if worst_error(taps, middle, PHASES) <= error {
            narrow = middle;
        } else {
            wide = middle;
        }
    }
    narrow
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::merge::TAPS;

    #[test]
    fn weights_reproduce_what_the_band_holds() {
        for (taps, nu, bound) in [
            (TAPS, 0.1, 1e-5),
            (TAPS, 0.25, 4e-4),
            (TAPS, 0.35, 1e-2),
            (MOST_TAPS, 0.25, 1e-5),
            (MOST_TAPS, 0.35, 2e-3),
        ] {
            for phase in 0..5 {
                let x = before(taps) as f64 + f64::from(phase) / 5.0;
                let interpolator = Interpolator::new(taps, nu);
                let w = interpolator.weights(x);
                assert!(w[taps..].iter().all(|w| *w == 0.0));
                let error = interpolator.mean_square_error(x, &w).sqrt();
                assert!(error < bound, "{taps} {nu} {error:e}");
                for k in -10..=10 {
                    let omega = 2.0 * PI * nu * f64::from(k) / 10.0;
                    let sum: Complex64 = (0..taps)
                        .map(|i| Complex64::cis(omega * (i as f64 - x)) * w[i])
                        .sum();
                    assert!((sum - 1.0).norm() < 6.0 * bound);
                }
            }
        }
        assert!(worst_error(TAPS, 0.49, 3).is_infinite());
    }

    #[test]
    fn few_phases_tell_the_mean_error_of_all() {
        for nu in [0.05, 0.15, 0.3, 0.42] {
            for d in [1, 2, 3, 7, 16, 17, 33, 64] {
                let interpolator = Interpolator::new(TAPS, nu);
                let all: f64 = (0..d)
                    .map(|p| {
                        let x = before(TAPS) as f64 + p as f64 / d as f64;
                        interpolator.mean_square_error(x, &interpolator.weights(x))
                    })
                    .sum();
                let expected = (all / d as f64).sqrt();
                let found = worst_error(TAPS, nu, d);
                assert!(
                    (found - expected).abs() <= 0.01 * expected + 1e-12,
                    "{nu} {d}: {found:e} for {expected:e}"
                );
            }
        }
    }

    #[test]
    fn the_widest_band_meets_its_error() {
        for taps in [TAPS, MOST_TAPS] {
            for error in [1e-5, 4e-4, 1e-3] {
                let nu = widest_band(taps, error);
                assert!(worst_error(taps, nu, 64) <= 1.02 * error);
                assert!(worst_error(taps, 1.02 * nu, 64) > error, "{nu}");
            }
        }
        assert!(widest_band(TAPS, 4e-4) < widest_band(MOST_TAPS, 4e-4));
    }
}
