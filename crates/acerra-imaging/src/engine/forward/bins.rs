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

/// Scratch memory of a thread that converts bins.
#[derive(Default)]
pub(crate) struct Workspace {
    profile: Vec<Complex64>,
    transform: Vec<Complex64>,
}

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
    /// The conversion for `bins`, which encloses the absolute bin numbers of all pulses.
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
    pub fn add(
        &self,
        echoes: &WeightedPulses,
        filled: &FilledBins,
        room: &mut Workspace,
        out: &mut [Complex64],
    ) {
        match self.spec.degree {
            1 => self.add_terms::<2>(echoes, filled, room, out),
            2 => self.add_terms::<3>(echoes, filled, room, out),
            _ => self.add_terms::<4>(echoes, filled, room, out),
        }
    }

    fn add_terms<const TERMS: usize>(
        &self,
        echoes: &WeightedPulses,
        filled: &FilledBins,
        room: &mut Workspace,
        out: &mut [Complex64],
    ) {
        let profile = &mut room.profile;
        let (Some(fft), Some(length)) = (&self.fft, self.spec.period) else {
            self.fill_profile::<TERMS>(echoes, filled, profile);
            return self.uneven(echoes, filled.first_bin, profile, out);
        };
        self.fill_profile::<TERMS>(echoes, filled, profile);
        room.transform
            .resize(fft.get_inplace_scratch_len(), Complex64::ZERO);
        fft.process_with_scratch(profile, &mut room.transform);
        for (n, (e, fit)) in out.iter_mut().zip(&self.phases.ramp_fit).enumerate() {
            let slot = (n + length - self.spec.carrier) % length;
            for p in 0..TERMS {
                *e += profile[p * length + slot] * fit[p].conj();
            }
        }
    }

    /// Coefficients of a bin, weights and carrier included.
    fn coefficients<const TERMS: usize>(
        &self,
        echoes: &WeightedPulses,
        pulse: usize,
        bin: i64,
        entry: &[f64],
    ) -> [Complex64; TERMS] {
        let weights = &echoes.weights;
        if bin < 2 && weights.spreading == Spreading::InverseSquare {
            return [Complex64::ZERO; TERMS];
        }
        let mut c: [Complex64; TERMS] =
            std::array::from_fn(|p| Complex64::new(entry[2 * p], entry[2 * p + 1]));
        if let Some(weight) = self.phases.weight_at(&self.spec, weights, pulse, bin) {
            c = weight.transposed_times(c);
        }
        let weight = echoes.pulses.weight()[pulse];
        let factor = match self.spec.period {
            Some(_) => self.phases.carrier_at(bin).conj() * weight,
            None => Complex64::new(weight, 0.0),
        };
        c.map(|c| c * factor)
    }

    /// Fills `profile` `[TERMS, period or entries]` with the coefficients of the bins, weights and carrier included.
    fn fill_profile<const TERMS: usize>(
        &self,
        echoes: &WeightedPulses,
        filled: &FilledBins,
        profile: &mut Vec<Complex64>,
    ) {
        let (start, bins, step) = (filled.first_bin, filled.values, filled.step);
        let length = self.spec.period.unwrap_or(bins.len() / step);
        profile.clear();
        profile.resize(length * TERMS, Complex64::ZERO);
        let mut slot = match self.spec.period {
            Some(period) => start.rem_euclid(period as i64) as usize,
            None => 0,
        };
        for (i, entry) in bins.chunks_exact(step).enumerate() {
            let c = self.coefficients::<TERMS>(echoes, filled.pulse, start + i as i64, entry);
            for p in 0..TERMS {
                profile[p * length + slot] += c[p];
            }
            slot += 1;
            if slot == length {
                slot = 0;
            }
        }
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
