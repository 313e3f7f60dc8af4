//! Matched range profiles of all pulses, tabulated.

use num_complex::{Complex32, Complex64};
use rayon::prelude::*;
use rustfft::FftPlanner;

use acerra_imaging::{Control, ImagingError, Pulses};

use crate::template::{Template, hermite};

/// Bins per frequency: the table is at least this much finer than the range resolution.
const OVERSAMPLING: usize = 8;

/// b(R) = Σ_n S*(n) E(m, n) e^{j(κ − κ_c)R} and its first moment Σ (κ − κ_c) …, for every pulse at
/// evenly spaced ranges.
#[derive(Clone, Debug)]
pub(crate) struct Profiles {
    origin_m: f64,
    step_m: f64,
    bins: usize,
    /// `[M, bins]` of value and first moment.
    values: Vec<[Complex32; 2]>,
    /// Σ_n |E(m, n)|² of each pulse.
    pub energy: Vec<f64>,
}

impl Profiles {
    /// Profiles over ranges from `range_m[0]` to `range_m[1]`; frequencies are `step_rad_m` apart in κ.
    pub fn new(
        pulses: &Pulses,
        template: &Template,
        range_m: [f64; 2],
        control: Control,
    ) -> Result<Self, ImagingError> {
        let n = template.wavenumber.len();
        let kappa_step = template.wavenumber[1] - template.wavenumber[0];
        let size = (OVERSAMPLING * n).next_power_of_two();
        let step_m = std::f64::consts::TAU / (kappa_step * size as f64);
        let bins = ((range_m[1] - range_m[0]) / step_m).ceil() as usize + 2;
        let first = template.wavenumber[0];
        let fft = FftPlanner::<f64>::new().plan_fft_inverse(size);
        let turn: Vec<Complex64> = (0..bins)
            .map(|i| Complex64::cis(first * i as f64 * step_m))
            .collect();
        let start: Vec<Complex64> = template
            .wavenumber
            .iter()
            .zip(&template.spectrum)
            .map(|(k, s)| s.conj() * Complex64::cis((k - first) * range_m[0]))
            .collect();
        let shift = Complex64::cis(first * range_m[0]);
        let mut values = vec![[Complex32::ZERO; 2]; pulses.len() * bins];
        values
            .par_chunks_mut(bins)
            .enumerate()
            .for_each(|(m, row)| {
                if control.is_cancelled() {
                    return;
                }
                for p in 0..2 {
                    let mut buffer = vec![Complex64::ZERO; size];
                    for (i, (e, s)) in pulses.spectrum_of(m).iter().zip(&start).enumerate() {
                        let moment = if p == 0 { 1.0 } else { template.wavenumber[i] };
                        buffer[i] = e * s * moment;
                    }
                    fft.process(&mut buffer);
                    for (i, v) in row.iter_mut().enumerate() {
                        let value = buffer[i % size] * turn[i] * shift;
                        v[p] = Complex32::new(value.re as f32, value.im as f32);
                    }
                }
            });
        control.check()?;
        let energy = (0..pulses.len())
            .map(|m| pulses.spectrum_of(m).iter().map(Complex64::norm_sqr).sum())
            .collect();
        Ok(Self {
            origin_m: range_m[0],
            step_m,
            bins,
            values,
            energy,
        })
    }

    /// Value and first moment of a pulse at a range; zero beyond the table.
    #[inline]
    pub fn at(&self, pulse: usize, range_m: f64) -> [Complex64; 2] {
        let at = (range_m - self.origin_m) / self.step_m;
        let i = at as usize;
        if !(at >= 0.0 && i + 1 < self.bins) {
            return [Complex64::ZERO; 2];
        }
        let (a, b) = self.nodes(pulse, i);
        let j_step = Complex64::I * self.step_m;
        let t = at - i as f64;
        let slope = [j_step * a[1], j_step * b[1]];
        let value = hermite(t, [a[0], b[0]], slope);
        // The moment is −j times the derivative of the value.
        let derivative = (a[0] - b[0]) * (6.0 * t * (t - 1.0))
            + slope[0] * ((1.0 - t) * (1.0 - 3.0 * t))
            + slope[1] * (t * (3.0 * t - 2.0));
        [value, derivative * (-Complex64::I / self.step_m)]
    }

    /// Value of a pulse at a range, without the first moment; zero beyond the table.
    #[inline]
    pub fn value(&self, pulse: usize, range_m: f64) -> Complex64 {
        let at = (range_m - self.origin_m) / self.step_m;
        let i = at as usize;
        if !(at >= 0.0 && i + 1 < self.bins) {
            return Complex64::ZERO;
        }
        let (a, b) = self.nodes(pulse, i);
        let j_step = Complex64::I * self.step_m;
        hermite(at - i as f64, [a[0], b[0]], [j_step * a[1], j_step * b[1]])
    }

    #[inline]
    fn nodes(&self, pulse: usize, i: usize) -> ([Complex64; 2], [Complex64; 2]) {
        let row = &self.values[pulse * self.bins + i..];
        let wide = |v: [Complex32; 2]| v.map(|c| Complex64::new(c.re.into(), c.im.into()));
        (wide(row[0]), wide(row[1]))
    }

    /// Powers of one pulse in `every` at the table's ranges after removing echoes of known range and
    /// amplitude, given per pulse.
    pub fn powers_without(
        &self,
        echoes: &[Vec<(f64, Complex64)>],
        every: usize,
        template: &Template,
    ) -> Powers {
        let mut power = vec![0_f32; self.values.len()];
        power
            .par_chunks_mut(self.bins)
            .zip(self.values.par_chunks(self.bins))
            .zip(echoes)
            .step_by(every)
            .for_each(|((power, row), echoes)| {
                for (i, (p, v)) in power.iter_mut().zip(row).enumerate() {
                    let range = self.origin_m + i as f64 * self.step_m;
                    let mut left = Complex64::new(v[0].re.into(), v[0].im.into());
                    for (at, amplitude) in echoes {
                        left -= template.correlation_value(range - at) * amplitude;
                    }
                    *p = left.norm_sqr() as f32;
                }
            });
        Powers {
            origin_m: self.origin_m,
            step_m: self.step_m,
            bins: self.bins,
            power,
        }
    }
}

/// Powers of range profiles, tabulated.
pub(crate) struct Powers {
    origin_m: f64,
    step_m: f64,
    bins: usize,
    power: Vec<f32>,
}

impl Powers {
    /// Adds to each sum the power of a pulse at its range plus `longer_m`; zero beyond the table.
    pub fn add(&self, pulse: usize, longer_m: f64, range_m: &[f32], sum: &mut [f32]) {
        let row = &self.power[pulse * self.bins..(pulse + 1) * self.bins];
        let per_m = (1.0 / self.step_m) as f32;
        let first = ((longer_m - self.origin_m) / self.step_m) as f32;
        for (sum, range) in sum.iter_mut().zip(range_m) {
            let at = range * per_m + first;
            let i = at as u32;
            if let (true, Some([a, b])) = (at >= 0.0, row.get(i as usize..i as usize + 2)) {
                *sum += a + (b - a) * (at - i as f32);
            }
        }
    }
}
