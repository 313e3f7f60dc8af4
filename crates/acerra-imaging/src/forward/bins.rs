//! From range bins back to spectra: the transpose of building a range table.

use crate::Pulses;
use crate::Spreading;
use crate::table::{MAX_DEGREE, Shared, TableSpec, times};
use crate::weights::Weights;
use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::sync::Arc;

/// What turns filled bins of any pulse into its spectrum.
pub(crate) struct BinsToSpectrum {
    spec: TableSpec,
    weights: Weights,
    shared: Shared,
    fft: Option<Arc<dyn Fft<f64>>>,
}

impl BinsToSpectrum {
    /// `first` and `last` enclose the absolute bin numbers of all pulses.
    pub fn new(pulses: &Pulses, spec: TableSpec, weights: &Weights, first: i64, last: i64) -> Self {
        Self {
            spec,
            weights: weights.clone(),
            shared: Shared::new(pulses, &spec, first, last),
            fft: spec
                .period
                .map(|length| FftPlanner::new().plan_fft_forward(length)),
        }
    }

    /// Adds to `out` `[N]` what the `bins` `[entries, step]` of pulse `m` hold, the first of which
    /// has the absolute number `start`.
    pub fn add(
        &self,
        pulses: &Pulses,
        m: usize,
        start: i64,
        bins: &[f64],
        step: usize,
        out: &mut [Complex64],
    ) {
        let degree = self.spec.degree;
        let entries = bins.len() / step;
        let length = self.spec.period.unwrap_or(entries);
        let mut profile = vec![Complex64::ZERO; length * (degree + 1)];
        let weight = pulses.weight()[m];
        let mut slot = match self.spec.period {
            Some(period) => start.rem_euclid(period as i64) as usize,
            None => 0,
        };
        for (i, entry) in bins.chunks_exact(step).enumerate() {
            let bin = start + i as i64;
            let mut c = [Complex64::ZERO; MAX_DEGREE + 1];
            for (p, c) in c.iter_mut().enumerate().take(degree + 1) {
                *c = Complex64::new(entry[2 * p], entry[2 * p + 1]);
            }
            if bin < 2 && self.weights.spreading == Spreading::InverseSquare {
                c = [Complex64::ZERO; MAX_DEGREE + 1];
            } else if let Some(g) = self.weights.expansion(m, bin as f64, self.spec.bin_m) {
                c = transposed_times(c, g, degree);
            }
            let turn = match self.spec.period {
                Some(_) => self.shared.carrier_at(bin).conj() * weight,
                None => Complex64::new(weight, 0.0),
            };
            for p in 0..=degree {
                profile[p * length + slot] += c[p] * turn;
            }
            slot += 1;
            if slot == length {
                slot = 0;
            }
        }
        match &self.fft {
            Some(fft) => {
                fft.process(&mut profile);
                for (n, (e, fit)) in out.iter_mut().zip(&self.shared.turns_fit).enumerate() {
                    let slot = (n + length - self.spec.carrier) % length;
                    for p in 0..=degree {
                        *e += profile[p * length + slot] * fit[p].conj();
                    }
                }
            }
            None => self.uneven(pulses, start, &profile, length, out),
        }
    }

    fn uneven(
        &self,
        pulses: &Pulses,
        start: i64,
        profile: &[Complex64],
        length: usize,
        out: &mut [Complex64],
    ) {
        /// Bins after which the turning phasor is computed afresh.
        const RENEW: usize = 64;
        let scale = 4.0 * PI * self.spec.bin_m / pulses.light_speed_m_s();
        for ((e, fit), f) in out
            .iter_mut()
            .zip(&self.shared.turns_fit)
            .zip(pulses.frequency_hz())
        {
            let turn = f * scale;
            let step = Complex64::cis(-turn % (2.0 * PI));
            let mut sums = [Complex64::ZERO; MAX_DEGREE + 1];
            let mut phasor = Complex64::ZERO;
            for k in 0..length {
                if k % RENEW == 0 {
                    phasor = Complex64::cis((-turn * (start + k as i64) as f64) % (2.0 * PI));
                }
                for (p, sum) in sums.iter_mut().enumerate().take(self.spec.degree + 1) {
                    *sum += profile[p * length + k] * phasor;
                }
                phasor *= step;
            }
            for (sum, fit) in sums.iter().zip(fit).take(self.spec.degree + 1) {
                *e += sum * fit.conj();
            }
        }
    }
}

/// The transpose of [`times`], a real map of coefficients.
fn transposed_times(
    c: [Complex64; MAX_DEGREE + 1],
    g: [f64; MAX_DEGREE + 1],
    degree: usize,
) -> [Complex64; MAX_DEGREE + 1] {
    let mut out = [Complex64::ZERO; MAX_DEGREE + 1];
    for (p, out) in out.iter_mut().enumerate().take(degree + 1) {
        let mut unit = [Complex64::ZERO; MAX_DEGREE + 1];
        unit[p] = Complex64::ONE;
        let column = times(unit, g, degree);
        *out = (0..=degree).map(|q| c[q] * column[q].re).sum();
    }
    out
}
