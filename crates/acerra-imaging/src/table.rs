//! The range table: every pulse's range profile as short polynomials, one a range bin.
//!
//! A bin of width b about R_i = i·b holds the least-squares polynomial, of degree 1 to 3 in
//! δ = (R − R_i)/b ∈ [−½, ½], of what the pulse contributes at range R once the carrier's turn
//! within the bin is taken out: w_m Σ_n E(m, n) e^{j4πf_n R/c} e^{−jαδ} / R², α = 4πf_c b/c. A
//! least-squares line has 2.4 times less error than one drawn through the bin's ends, so bins may
//! be wider, and the carrier at bin centres is part of the coefficients. For even frequencies the
//! profile before the carrier is periodic in c/(2Δf); the bin divides the period, the coefficients
//! come from one inverse FFT a degree, and ranges beyond the period wrap exactly.

use crate::weights::Weights;
use crate::{Pulses, Spreading};
use num_complex::Complex64;
use rayon::prelude::*;
use rustfft::FftPlanner;
use std::f64::consts::PI;

/// Highest polynomial degree.
pub(crate) const MAX_DEGREE: usize = 3;
/// Entries at either end that vectors may read without meaning them.
pub(crate) const PADDING: usize = 20;

/// How a table is cut into bins.
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
    /// Turn of the carrier across a bin, α = 4πf_c b/c, rad.
    pub fn carrier_rad(&self, pulses: &Pulses) -> f64 {
        4.0 * PI * pulses.frequency_hz()[self.carrier] * self.bin_m / pulses.light_speed_m_s()
    }

    /// Turn across a bin of each frequency about the carrier, rad.
    fn turns_rad(&self, pulses: &Pulses) -> Vec<f64> {
        let f = pulses.frequency_hz();
        let scale = 4.0 * PI * self.bin_m / pulses.light_speed_m_s();
        f.iter().map(|v| (v - f[self.carrier]) * scale).collect()
    }

    /// Relative RMS error of the polynomials for a spectrum of the given power a frequency.
    pub fn fit_error(&self, pulses: &Pulses, power: &[f64]) -> f64 {
        let mut error = 0.0;
        for (turn, p) in self.turns_rad(pulses).iter().zip(power) {
            error += p * fit_turn(*turn, self.degree).1;
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

/// Least-squares monomial coefficients of e^{jθδ} on [−½, ½], and the mean square of what is left.
fn fit_turn(turn: f64, degree: usize) -> ([Complex64; MAX_DEGREE + 1], f64) {
    let mut legendre = [Complex64::ZERO; MAX_DEGREE + 1];
    for &(x, w) in gauss_legendre() {
        let e = Complex64::cis(0.5 * turn * x) * (0.5 * w);
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

/// The table of all pulses over the ranges that an image needs.
#[derive(Debug, Clone)]
pub(crate) struct RangeTable {
    pub spec: TableSpec,
    /// α, rad.
    pub carrier_rad: f64,
    /// Absolute bin number of each pulse's entry 0.
    pub first_bin: Vec<i64>,
    /// Numbers from one coefficient row to the next.
    pub stride: usize,
    /// `[pulse, degree + 1, re/im, stride]`, or `[pulse, stride, degree + 1, re/im]` interleaved.
    pub coefficients: Vec<f32>,
    /// What the coefficients were multiplied by, a power of two that keeps them near 1.
    pub scale: f64,
}

impl RangeTable {
    /// Entries that a table over `ranges_m` (least and greatest a pulse) holds a row.
    pub fn stride_for(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> usize {
        let widest = ranges_m
            .iter()
            .map(|[a, b]| (b / spec.bin_m).ceil() - (a / spec.bin_m).floor())
            .fold(0.0, f64::max);
        (widest as usize + 2 + 2 * PADDING).next_multiple_of(16)
    }

    /// Bytes of such a table.
    pub fn bytes_for(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> u128 {
        ranges_m.len() as u128
            * (spec.degree as u128 + 1)
            * 2
            * Self::stride_for(spec, ranges_m) as u128
            * size_of::<f32>() as u128
    }

    /// Absolute bin number of each pulse's entry 0.
    pub fn first_bins(spec: &TableSpec, ranges_m: &[[f64; 2]]) -> Vec<i64> {
        ranges_m
            .iter()
            .map(|r| (r[0] / spec.bin_m).floor() as i64 - PADDING as i64)
            .collect()
    }

    /// Numbers from one pulse to the next.
    pub fn pulse_stride(&self) -> usize {
        (self.spec.degree + 1) * 2 * self.stride
    }

    /// The table over `ranges_m`, least and greatest range of every pulse.
    pub fn build(
        pulses: &Pulses,
        spec: TableSpec,
        ranges_m: &[[f64; 2]],
        weights: &Weights,
    ) -> Self {
        let stride = Self::stride_for(&spec, ranges_m);
        let carrier_rad = spec.carrier_rad(pulses);
        let first_bin = Self::first_bins(&spec, ranges_m);
        let scale = power_of_two_scale(pulses, ranges_m, weights.spreading);
        let mut coefficients = vec![0f32; ranges_m.len() * (spec.degree + 1) * 2 * stride];
        let first = first_bin.iter().copied().min().unwrap_or(0);
        let last = first_bin.iter().copied().max().unwrap_or(0) + stride as i64;
        let shared = Shared::new(pulses, &spec, first, last);
        let fft = spec
            .period
            .map(|length| FftPlanner::new().plan_fft_inverse(length));
        coefficients
            .par_chunks_mut((spec.degree + 1) * 2 * stride)
            .enumerate()
            .for_each_init(
                || {
                    let length = spec.period.unwrap_or(stride);
                    let scratch = fft.as_ref().map_or(0, |f| f.get_inplace_scratch_len());
                    (
                        vec![Complex64::ZERO; length * (spec.degree + 1)],
                        vec![Complex64::ZERO; scratch],
                    )
                },
                |(profile, scratch), (m, out)| {
                    let start = first_bin[m];
                    match &fft {
                        Some(fft) => {
                            shared.even(pulses, m, &spec, profile);
                            fft.process_with_scratch(profile, scratch);
                        }
                        None => shared.uneven(pulses, m, &spec, start, profile),
                    }
                    shared.fold(
                        &spec,
                        start,
                        m,
                        (pulses.weight()[m] * scale, weights),
                        profile,
                        out,
                        stride,
                    );
                },
            );
        Self {
            spec,
            carrier_rad,
            first_bin,
            stride,
            coefficients,
            scale,
        }
    }

    /// The contribution of a pulse at a range within the table, evaluated in double precision.
    #[cfg(test)]
    pub fn evaluate(&self, pulse: usize, range_m: f64) -> Complex64 {
        let t = range_m / self.spec.bin_m - self.first_bin[pulse] as f64;
        let i = t.round();
        let delta = t - i;
        let row = &self.coefficients[pulse * self.pulse_stride()..][..self.pulse_stride()];
        let at = |k: usize| f64::from(row[k * self.stride + i as usize]);
        let mut value = Complex64::ZERO;
        for p in (0..=self.spec.degree).rev() {
            value = value * delta + Complex64::new(at(2 * p), at(2 * p + 1));
        }
        value * Complex64::cis(self.carrier_rad * delta) / self.scale
    }
}

/// A power of two that brings the largest contributions near 1.
fn power_of_two_scale(pulses: &Pulses, ranges_m: &[[f64; 2]], spreading: Spreading) -> f64 {
    let peak = pulses
        .spectrum()
        .iter()
        .map(|e| e.re.abs().max(e.im.abs()))
        .fold(0.0, f64::max);
    let weight = pulses.weight().iter().map(|w| w.abs()).fold(0.0, f64::max);
    let range = ranges_m
        .iter()
        .map(|r| 0.5 * (r[0] + r[1]))
        .fold(f64::INFINITY, f64::min)
        .max(1e-3);
    let size = peak * weight * spreading.weight(range) * pulses.frequency_hz().len() as f64;
    if size > 0.0 && size.is_finite() {
        2f64.powi(-(size.log2().round().clamp(-900.0, 900.0) as i32))
    } else {
        1.0
    }
}

/// What all pulses of a table have in common.
pub(crate) struct Shared {
    /// Monomial fit of every frequency's turn.
    pub turns_fit: Vec<[Complex64; MAX_DEGREE + 1]>,
    /// e^{jαi} from bin `first` on (even frequencies).
    carrier: Vec<Complex64>,
    first: i64,
}

impl Shared {
    /// For the absolute bins `first..last`.
    pub fn new(pulses: &Pulses, spec: &TableSpec, first: i64, last: i64) -> Self {
        let carrier_rad = spec.carrier_rad(pulses);
        Self {
            turns_fit: spec
                .turns_rad(pulses)
                .iter()
                .map(|t| fit_turn(*t, spec.degree).0)
                .collect(),
            carrier: match spec.period {
                Some(_) => (first..last)
                    .map(|i| Complex64::cis((carrier_rad * i as f64) % (2.0 * PI)))
                    .collect(),
                None => Vec::new(),
            },
            first,
        }
    }

    /// e^{jαi} at an absolute bin (even frequencies).
    pub fn carrier_at(&self, bin: i64) -> Complex64 {
        self.carrier[(bin - self.first) as usize]
    }

    /// Spectra of the coefficients, `[degree + 1, period]`, ready for the inverse FFT.
    fn even(&self, pulses: &Pulses, m: usize, spec: &TableSpec, out: &mut [Complex64]) {
        let length = out.len() / (spec.degree + 1);
        out.fill(Complex64::ZERO);
        for (n, (e, fit)) in pulses
            .spectrum_of(m)
            .iter()
            .zip(&self.turns_fit)
            .enumerate()
        {
            let slot = (n + length - spec.carrier) % length;
            for p in 0..=spec.degree {
                out[p * length + slot] += e * fit[p];
            }
        }
    }

    /// The coefficients from bin `start` on by plain summation, carrier included.
    fn uneven(
        &self,
        pulses: &Pulses,
        m: usize,
        spec: &TableSpec,
        start: i64,
        out: &mut [Complex64],
    ) {
        /// Bins after which the turning phasor is computed afresh.
        const RENEW: usize = 64;
        let length = out.len() / (spec.degree + 1);
        let scale = 4.0 * PI * spec.bin_m / pulses.light_speed_m_s();
        out.fill(Complex64::ZERO);
        for ((e, fit), f) in pulses
            .spectrum_of(m)
            .iter()
            .zip(&self.turns_fit)
            .zip(pulses.frequency_hz())
        {
            let turn = f * scale;
            let step = Complex64::cis(turn % (2.0 * PI));
            let mut phasor = Complex64::ZERO;
            for k in 0..length {
                if k % RENEW == 0 {
                    phasor = e * Complex64::cis((turn * (start + k as i64) as f64) % (2.0 * PI));
                }
                for p in 0..=spec.degree {
                    out[p * length + k] += phasor * fit[p];
                }
                phasor *= step;
            }
        }
    }

    /// Multiplies carrier, weight and spreading in and stores single precision.
    #[allow(clippy::too_many_arguments)]
    fn fold(
        &self,
        spec: &TableSpec,
        start: i64,
        pulse: usize,
        (weight, weights): (f64, &Weights),
        profile: &[Complex64],
        out: &mut [f32],
        stride: usize,
    ) {
        let length = profile.len() / (spec.degree + 1);
        let mut slot = match spec.period {
            Some(period) => start.rem_euclid(period as i64) as usize,
            None => 0,
        };
        for i in 0..stride {
            let bin = start + i as i64;
            let mut c = [Complex64::ZERO; MAX_DEGREE + 1];
            let turn = match spec.period {
                Some(_) => self.carrier_at(bin) * weight,
                None => Complex64::new(weight, 0.0),
            };
            for p in 0..=spec.degree {
                c[p] = profile[p * length + slot] * turn;
            }
            if bin < 2 && weights.spreading == Spreading::InverseSquare {
                // Bins this close to the antenna are never read: see `folding_range_m`.
                c = [Complex64::ZERO; MAX_DEGREE + 1];
            } else if let Some(g) = weights.expansion(pulse, bin as f64, spec.bin_m) {
                c = times(c, g, spec.degree);
            }
            for (p, c) in c.iter().enumerate().take(spec.degree + 1) {
                let (re, im) = if spec.interleaved {
                    let at = (spec.degree + 1) * 2 * i + 2 * p;
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
}

/// The least-squares polynomial of c(δ)·g(δ).
pub(crate) fn times(
    c: [Complex64; MAX_DEGREE + 1],
    g: [f64; MAX_DEGREE + 1],
    degree: usize,
) -> [Complex64; MAX_DEGREE + 1] {
    let mut product = [Complex64::ZERO; 2 * MAX_DEGREE + 1];
    for (p, cp) in c.iter().enumerate().take(degree + 1) {
        for (q, gq) in g.iter().enumerate() {
            product[p + q] += cp * *gq;
        }
    }
    // Powers above the degree become their least-squares polynomials on [−½, ½].
    for power in (degree + 1..product.len()).rev() {
        let v = std::mem::take(&mut product[power]);
        match degree {
            1 => product[power - 2] += v / 12.0,
            2 => product[power - 2] += v * 0.15,
            _ => {
                product[power - 2] += v * (3.0 / 14.0);
                product[power - 4] -= v * (3.0 / 560.0);
            }
        }
    }
    std::array::from_fn(|p| product[p])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::pulse_at_range;

    fn error(f: &[f64], spec: TableSpec, ranges: [f64; 2], spreading: Spreading) -> f64 {
        let n = f.len();
        let spectrum: Vec<_> = (0..n)
            .map(|k| Complex64::cis((k * k) as f64 * 0.7) * (1.0 + (k as f64).sin()))
            .collect();
        let position = [[0.0; 3]];
        let pulses = Pulses::new(&position, f, &spectrum, &[0.7], 3e8).unwrap();
        let table = RangeTable::build(
            &pulses,
            spec,
            &[ranges],
            &Weights::spreading_alone(spreading),
        );
        let (mut difference, mut power) = (0.0, 0.0);
        for k in 0..2000 {
            let r = ranges[0] + (ranges[1] - ranges[0]) * (k as f64 * 0.618_034).fract();
            let expected = pulse_at_range(&pulses, 0, r) * (0.7 * spreading.weight(r));
            difference += (table.evaluate(0, r) - expected).norm_sqr();
            power += expected.norm_sqr();
        }
        (difference / power).sqrt()
    }

    #[test]
    fn the_fit_error_is_as_predicted_at_any_range_and_degree() {
        let f: Vec<f64> = (0..213).map(|n| 3.102e9 + 8e6 * f64::from(n)).collect();
        for degree in 1..=3 {
            let spec = TableSpec {
                bin_m: 3e8 / 16e6 / 1536.0,
                degree,
                period: Some(1536),
                carrier: 106,
                interleaved: false,
            };
            let spectrum = vec![Complex64::ONE; 213];
            let pulses = Pulses::new(&[[0.0; 3]], &f, &spectrum, &[1.0], 3e8)
                .map(|p| spec.fit_error(&p, &vec![1.0; 213]))
                .unwrap();
            // 100 and 3000 m lie many periods (18.75 m) away: wrapping is exact.
            for ranges in [[3.0, 9.0], [97.0, 105.0], [2999.0, 3010.0]] {
                let found = error(&f, spec, ranges, Spreading::None);
                assert!(
                    (0.7..1.3).contains(&(found / pulses)) || found < 3e-7,
                    "{degree}: {found:e} for {pulses:e}"
                );
                let weighted = error(&f, spec, ranges, Spreading::InverseSquare);
                assert!(weighted < 1.5 * pulses + 3e-7, "{weighted:e} {pulses:e}");
            }
        }
    }

    #[test]
    fn uneven_frequencies_are_summed_plainly() {
        let f: Vec<f64> = (0..60)
            .map(|n| 3.1e9 + 8e6 * f64::from(n) + 1.3e6 * f64::from(n * n % 7))
            .collect();
        let spec = TableSpec {
            bin_m: 0.02,
            degree: 3,
            period: None,
            carrier: 30,
            interleaved: false,
        };
        assert!(error(&f, spec, [40.0, 60.0], Spreading::InverseSquare) < 2e-5);
    }
}
