//! Bin width, degree and error of range tables.

use crate::engine::travel_time::TravelTime;
use crate::pulses::Pulses;
use num_complex::Complex64;
use std::f64::consts::PI;

/// Highest polynomial degree.
pub(crate) const MAX_DEGREE: usize = 3;

/// Bins and polynomials of a range table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TableSpec {
    /// Width of a bin, m.
    pub bin_m: f64,
    /// Polynomial degree, 1 to [`MAX_DEGREE`].
    pub degree: usize,
    /// Bins in one period c/(2Δf); `None` where frequencies are uneven.
    pub period: Option<usize>,
    /// Index of the frequency taken as carrier.
    pub carrier: usize,
    /// Coefficients of a bin side by side, for gathers, instead of bins side by side, for windows.
    pub interleaved: bool,
}

impl TableSpec {
    /// Two-way carrier phase advance per range bin, α = 2πf_c·b·dτ/dR, rad.
    pub fn carrier_rad(&self, pulses: &Pulses) -> f64 {
        let law = TravelTime::of(pulses);
        law.wavenumber_rad_m(pulses.frequency_hz()[self.carrier]) * self.bin_m
    }

    /// Phase advance per range bin of each frequency relative to the carrier, rad.
    pub fn ramps_rad(&self, pulses: &Pulses) -> Vec<f64> {
        let f = pulses.frequency_hz();
        let law = TravelTime::of(pulses);
        f.iter()
            .map(|v| law.wavenumber_rad_m(v - f[self.carrier]) * self.bin_m)
            .collect()
    }

    /// Relative RMS error of the polynomials for a spectrum of the given power a frequency.
    pub fn fit_error(&self, pulses: &Pulses, power: &[f64]) -> f64 {
        let mut error = 0.0;
        for (ramp, p) in self.ramps_rad(pulses).iter().zip(power) {
            error += p * fit_phase_ramp(*ramp, self.degree).1;
        }
        (error / power.iter().sum::<f64>().max(f64::MIN_POSITIVE)).sqrt()
    }

    /// Range from which 1/R² is folded into the bins with relative RMS error below `accuracy`, m.
    pub fn folding_range_m(&self, accuracy: f64) -> f64 {
        // The first power of bin/R that the polynomial drops, times the RMS of its remainder.
        let dropped = [0.0, 3.0 * 0.0745, 4.0 * 0.0189, 5.0 * 0.0048][self.degree];
        self.bin_m
            * (dropped / accuracy)
                .powf(1.0 / (self.degree + 1) as f64)
                .max(4.0)
    }
}

/// Least-squares monomial coefficients of the phase ramp e^{jθδ} on [−½, ½], and the mean square of
/// the residual.
pub(crate) fn fit_phase_ramp(ramp_rad: f64, degree: usize) -> ([Complex64; MAX_DEGREE + 1], f64) {
    let mut legendre = [Complex64::ZERO; MAX_DEGREE + 1];
    for &(x, w) in gauss_legendre() {
        let e = Complex64::cis(0.5 * ramp_rad * x) * (0.5 * w);
        let p = [1.0, x, 1.5 * x * x - 0.5, 2.5 * x * x * x - 1.5 * x];
        for (l, a) in legendre.iter_mut().enumerate().take(degree + 1) {
            *a += e * (p[l] * (2 * l + 1) as f64);
        }
    }
    // |e^{jθδ}|² = 1, shared among orthogonal polynomials of mean square 1/(2l+1).
    let kept: f64 = legendre
        .iter()
        .enumerate()
        .map(|(l, a)| a.norm_sqr() / (2 * l + 1) as f64)
        .sum();
    let [a0, a1, a2, a3] = legendre;
    let monomial = [a0 - a2 * 0.5, a1 * 2.0 - a3 * 3.0, a2 * 6.0, a3 * 20.0];
    (monomial, (1.0 - kept).max(0.0))
}

/// Nodes and weights of 16-point Gauss–Legendre quadrature on [−1, 1].
fn gauss_legendre() -> &'static [(f64, f64); 16] {
    static NODES: std::sync::OnceLock<[(f64, f64); 16]> = std::sync::OnceLock::new();
    NODES.get_or_init(|| {
        std::array::from_fn(|k| {
            let n = 16.0;
            let mut x = (PI * (k as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut p0, mut p1) = (1.0, x);
                for j in 2..=16 {
                    let j = f64::from(j);
                    (p0, p1) = (p1, ((2.0 * j - 1.0) * x * p1 - (j - 1.0) * p0) / j);
                }
                slope = n * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
    })
}
