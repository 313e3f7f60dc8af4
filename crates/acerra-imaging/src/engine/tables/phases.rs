//! Phases of range bins and the conversion of spectra into bin coefficients.

use super::spec::{MAX_DEGREE, TableSpec};
use crate::engine::travel_time::TravelTime;
use crate::engine::weights::Weights;
use crate::pulses::{Pulses, Spreading};
use num_complex::Complex64;
use std::f64::consts::PI;

/// Bins after which a recurrent phasor is computed afresh.
pub(crate) const RENEW: usize = 64;

/// Number of bins whose weight is kept for all pulses (8 MB): on tracks far longer than the image's width
/// most bins are used by few pulses.
const MOST_SHARED_BINS: usize = 1 << 16;

/// The rows of one pulse in a table.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub pulse: usize,
    /// Absolute number of the first bin.
    pub first_bin: i64,
    /// Factor of all coefficients.
    pub factor: f64,
}

/// Phases and polynomials that all pulses of a table share.
pub(crate) struct BinPhases {
    /// Monomial fit of every frequency's phase ramp across a bin.
    pub ramp_fit: Vec<[Complex64; MAX_DEGREE + 1]>,
    /// e^{jαi} from bin `first` on (even frequencies).
    carrier: Vec<Complex64>,
    /// The weight of the bins from `first` on, of [`MOST_SHARED_BINS`] at most, where the weight is equal for
    /// every pulse and not 1.
    weight: Vec<WeightMatrix>,
    first: i64,
}

impl BinPhases {
    /// Phases and weights of the absolute bins `first..last`.
    pub fn new(
        pulses: &Pulses,
        weights: &Weights,
        spec: &TableSpec,
        [first, last]: [i64; 2],
    ) -> Self {
        let carrier_rad = spec.carrier_rad(pulses);
        let weight = |bin: i64| {
            let expansion = weights.shared_expansion(bin as f64, spec.bin_m)?;
            Some(WeightMatrix::new(expansion, spec.degree))
        };
        Self {
            ramp_fit: spec.ramp_fits(pulses),
            carrier: match spec.period {
                Some(_) => (first..last)
                    .map(|i| Complex64::cis((carrier_rad * i as f64) % (2.0 * PI)))
                    .collect(),
                None => Vec::new(),
            },
            weight: (first..last)
                .take(MOST_SHARED_BINS)
                .map_while(weight)
                .collect(),
            first,
        }
    }

    /// Phases of the absolute bins `first..last`, without weights.
    pub fn unweighted(pulses: &Pulses, spec: &TableSpec, bins: [i64; 2]) -> Self {
        Self::new(pulses, &Weights::unit(), spec, bins)
    }

    /// e^{jαi} at an absolute bin (even frequencies).
    pub fn carrier_at(&self, bin: i64) -> Complex64 {
        self.carrier[(bin - self.first) as usize]
    }

    /// Spectra of the coefficients, `[degree + 1, period]`, ready for the inverse FFT: sets the slots of the
    /// frequencies, which are equal for every pulse, and leaves the others unchanged.
    pub fn even(&self, pulses: &Pulses, m: usize, spec: &TableSpec, out: &mut [Complex64]) {
        let length = out.len() / (spec.degree + 1);
        for (n, (e, fit)) in pulses.spectrum_of(m).iter().zip(&self.ramp_fit).enumerate() {
            let slot = (n + length - spec.carrier) % length;
            for p in 0..=spec.degree {
                out[p * length + slot] = e * fit[p];
            }
        }
    }

    /// The coefficients from bin `start` on by direct summation, carrier included.
    pub fn uneven(
        &self,
        pulses: &Pulses,
        m: usize,
        spec: &TableSpec,
        start: i64,
        out: &mut [Complex64],
    ) {
        let length = out.len() / (spec.degree + 1);
        let law = TravelTime::of(pulses);
        out.fill(Complex64::ZERO);
        for ((e, fit), f) in pulses
            .spectrum_of(m)
            .iter()
            .zip(&self.ramp_fit)
            .zip(pulses.frequency_hz())
        {
            let advance = law.wavenumber_rad_m(*f) * spec.bin_m;
            let step = Complex64::cis(advance % (2.0 * PI));
            let mut phasor = Complex64::ZERO;
            for k in 0..length {
                if k % RENEW == 0 {
                    let range_m = (start + k as i64) as f64 * spec.bin_m;
                    phasor = e * Complex64::cis(law.phase_rad(*f, range_m) % (2.0 * PI));
                }
                for p in 0..=spec.degree {
                    out[p * length + k] += phasor * fit[p];
                }
                phasor *= step;
            }
        }
    }

    /// Multiplies a profile by carrier and weights and stores it in single precision, `out` being
    /// the rows of one pulse.
    pub fn store(
        &self,
        spec: &TableSpec,
        row: Row,
        weights: &Weights,
        profile: &[Complex64],
        out: &mut [f32],
    ) {
        match spec.degree {
            1 => self.store_terms::<2>(spec, row, weights, profile, out),
            2 => self.store_terms::<3>(spec, row, weights, profile, out),
            _ => self.store_terms::<4>(spec, row, weights, profile, out),
        }
    }

    /// As [`Self::store`], for polynomials of a fixed number of terms.
    fn store_terms<const TERMS: usize>(
        &self,
        spec: &TableSpec,
        row: Row,
        weights: &Weights,
        profile: &[Complex64],
        out: &mut [f32],
    ) {
        let length = profile.len() / TERMS;
        let stride = out.len() / (2 * TERMS);
        let mut slot = match spec.period {
            Some(period) => row.first_bin.rem_euclid(period as i64) as usize,
            None => 0,
        };
        for i in 0..stride {
            let bin = row.first_bin + i as i64;
            let factor = match spec.period {
                Some(_) => self.carrier_at(bin) * row.factor,
                None => Complex64::new(row.factor, 0.0),
            };
            let mut c: [Complex64; TERMS] =
                std::array::from_fn(|p| profile[p * length + slot] * factor);
            if bin < 2 && weights.spreading == Spreading::InverseSquare {
                // Bins this close to the antenna are never read: see `folding_range_m`.
                c = [Complex64::ZERO; TERMS];
            } else if let Some(weight) = self.weight_at(spec, weights, row.pulse, bin) {
                c = weight.times(c);
            }
            for (p, c) in c.iter().enumerate() {
                let (re, im) = if spec.interleaved {
                    let at = TERMS * 2 * i + 2 * p;
                    (at, at + 1)
                } else {
                    (2 * p * stride + i, (2 * p + 1) * stride + i)
                };
                out[re] = c.re as f32;
                out[im] = c.im as f32;
            }
            slot += 1;
            if slot == length {
                slot = 0;
            }
        }
    }

    /// The weight at an absolute bin; `None` where it is 1 everywhere.
    #[inline]
    pub fn weight_at(
        &self,
        spec: &TableSpec,
        weights: &Weights,
        pulse: usize,
        bin: i64,
    ) -> Option<WeightMatrix> {
        let shared = self.weight.get((bin - self.first) as usize).copied();
        shared.or_else(|| {
            let expansion = weights.expansion(pulse, bin as f64, spec.bin_m)?;
            Some(WeightMatrix::new(expansion, spec.degree))
        })
    }
}

/// Multiplication of a bin's polynomial c(δ) by the weight's g(δ), as a matrix on coefficients: column p
/// holds the least-squares polynomial of δᵖ·g(δ).
#[derive(Debug, Clone, Copy)]
pub(crate) struct WeightMatrix([[f64; MAX_DEGREE + 1]; MAX_DEGREE + 1]);

impl WeightMatrix {
    /// The matrix for polynomials of degree `degree`.
    fn new(g: [f64; MAX_DEGREE + 1], degree: usize) -> Self {
        let mut columns = [[0.0; MAX_DEGREE + 1]; MAX_DEGREE + 1];
        for (p, column) in columns.iter_mut().enumerate().take(degree + 1) {
            let mut product = [0.0; 2 * MAX_DEGREE + 1];
            product[p..=p + MAX_DEGREE].copy_from_slice(&g);
            // Powers above the degree become their least-squares polynomials on [−½, ½].
            for power in (degree + 1..=p + MAX_DEGREE).rev() {
                let v = product[power];
                match degree {
                    1 => product[power - 2] += v / 12.0,
                    2 => product[power - 2] += v * 0.15,
                    _ => {
                        product[power - 2] += v * (3.0 / 14.0);
                        product[power - 4] -= v * (3.0 / 560.0);
                    }
                }
            }
            column[..=degree].copy_from_slice(&product[..=degree]);
        }
        Self(columns)
    }

    /// The polynomial of c(δ)·g(δ).
    #[inline]
    fn times<const TERMS: usize>(&self, c: [Complex64; TERMS]) -> [Complex64; TERMS] {
        std::array::from_fn(|q| {
            let terms = c.iter().zip(&self.0).map(|(c, column)| c * column[q]);
            terms.sum()
        })
    }

    /// The transpose of [`Self::times`].
    #[inline]
    pub fn transposed_times<const TERMS: usize>(
        &self,
        c: [Complex64; TERMS],
    ) -> [Complex64; TERMS] {
        std::array::from_fn(|p| c.iter().zip(&self.0[p]).map(|(c, v)| c * *v).sum())
    }
}
