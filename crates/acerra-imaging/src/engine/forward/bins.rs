//! Conversion of range bins into spectra: the transpose of building a range table.

use crate::engine::tables::phases::{BinPhases, RENEW};
use crate::engine::tables::spec::{MAX_DEGREE, TableSpec};
use crate::engine::travel_time::TravelTime;
use crate::engine::weights::WeightedPulses;
use crate::pulses::Spreading;
use num_complex::Complex64;
use rustfft::{Fft, FftPlanner};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Converts the filled bins of a pulse into its spectrum.
pub(crate) struct BinsToSpectrum {
    spec: TableSpec,
    phases: BinPhases,
    fft: Option<Arc<dyn Fft<f64>>>,
}

/// Filled bins of one pulse, `[entries, step]`.
pub(crate) struct FilledBins<'a> {
    pub pulse: usize,
    /// Absolute number of the first bin.
    pub first_bin: i64,
    pub values: &'a [f64],
    /// Numbers per bin.
    pub step: usize,
}

impl BinsToSpectrum {
    /// `bins` encloses the absolute bin numbers of all pulses.
    pub fn new(echoes: &WeightedPulses, spec: TableSpec, bins: Range<i64>) -> Self {
        Self {
            spec,
            phases: BinPhases::new(
                &echoes.pulses,
                &echoes.weights,
                &spec,
                [bins.start, bins.end],
            ),
            fft: spec
                .period
                .map(|length| FftPlanner::new().plan_fft_forward(length)),
        }
    }

    /// Adds the spectrum of filled bins to `out` `[N]`.
    pub fn add(&self, echoes: &WeightedPulses, filled: &FilledBins, out: &mut [Complex64]) {
        let degree = self.spec.degree;
        let mut profile = match degree {
            1 => self.profile::<2>(echoes, filled),
            2 => self.profile::<3>(echoes, filled),
            _ => self.profile::<4>(echoes, filled),
        };
        let length = profile.len() / (degree + 1);
        match &self.fft {
            Some(fft) => {
                fft.process(&mut profile);
                for (n, (e, fit)) in out.iter_mut().zip(&self.phases.ramp_fit).enumerate() {
                    let slot = (n + length - self.spec.carrier) % length;
                    for p in 0..=degree {
                        *e += profile[p * length + slot] * fit[p].conj();
                    }
                }
            }
            None => self.uneven(echoes, filled.first_bin, &profile, out),
        }
    }

    /// Coefficients of the bins, weights and carrier included, `[TERMS, period or entries]`.
    fn profile<const TERMS: usize>(
        &self,
        echoes: &WeightedPulses,
        filled: &FilledBins,
    ) -> Vec<Complex64> {
        let (m, start, bins, step) = (filled.pulse, filled.first_bin, filled.values, filled.step);
        let weights = &echoes.weights;
        let length = self.spec.period.unwrap_or(bins.len() / step);
        let mut profile = vec![Complex64::ZERO; length * TERMS];
        let weight = echoes.pulses.weight()[m];
        let mut slot = match self.spec.period {
            Some(period) => start.rem_euclid(period as i64) as usize,
            None => 0,
        };
        for (i, entry) in bins.chunks_exact(step).enumerate() {
            let bin = start + i as i64;
            let mut c: [Complex64; TERMS] =
                std::array::from_fn(|p| Complex64::new(entry[2 * p], entry[2 * p + 1]));
            if bin < 2 && weights.spreading == Spreading::InverseSquare {
                c = [Complex64::ZERO; TERMS];
            } else if let Some(weight) = self.phases.weight_at(&self.spec, weights, m, bin) {
                c = weight.transposed_times(c);
            }
            let factor = match self.spec.period {
                Some(_) => self.phases.carrier_at(bin).conj() * weight,
                None => Complex64::new(weight, 0.0),
            };
            for p in 0..TERMS {
                profile[p * length + slot] += c[p] * factor;
            }
            slot += 1;
            if slot == length {
                slot = 0;
            }
        }
        profile
    }

    fn uneven(
        &self,
        echoes: &WeightedPulses,
        start: i64,
        profile: &[Complex64],
        out: &mut [Complex64],
    ) {
        let length = profile.len() / (self.spec.degree + 1);
        let law = TravelTime::of(&echoes.pulses);
        for ((e, fit), f) in out
            .iter_mut()
            .zip(&self.phases.ramp_fit)
            .zip(echoes.pulses.frequency_hz())
        {
            let advance = law.wavenumber_rad_m(*f) * self.spec.bin_m;
            let step = Complex64::cis(-advance % (2.0 * PI));
            let mut sums = [Complex64::ZERO; MAX_DEGREE + 1];
            let mut phasor = Complex64::ZERO;
            for k in 0..length {
                if k % RENEW == 0 {
                    let range_m = (start + k as i64) as f64 * self.spec.bin_m;
                    phasor = Complex64::cis(-law.phase_rad(*f, range_m) % (2.0 * PI));
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
